//! H along one coordinate or one momentum at a time.

use super::CustomGeneral;
use afterbay_core::{Mean, PhasePlane, PlaneDissipation, Scalar, Slopes};
use afterbay_expression::Point;

impl<T: Scalar> PhasePlane<T> for CustomGeneral<T> {
    fn slopes(&self, q: &[T], p: &[T], j: usize, at: [T; 2]) -> Slopes<T> {
        let point = Point { own: at, ..Point::new(q, p, &[]) };
        let [hq, hp, hqq, hqp, hpp] = self.run(&self.shape.planes[j].slopes, &point);
        Slopes { hq, hp, hqq, hqp, hpp }
    }

    fn along_q(&self, q: &[T], p: &[T], j: usize, [from, to]: [T; 2], p_j: T) -> Mean<T> {
        let point = Point { own: [from, p_j], end: to, ..Point::new(q, p, &[]) };
        let [value, by_end, by_other] = self.run(&self.shape.planes[j].along_q, &point);
        Mean { value, by_end, by_other }
    }

    fn along_p(&self, q: &[T], p: &[T], j: usize, q_j: T, [from, to]: [T; 2]) -> Mean<T> {
        let point = Point { own: [q_j, from], end: to, ..Point::new(q, p, &[]) };
        let [value, by_end, by_other] = self.run(&self.shape.planes[j].along_p, &point);
        Mean { value, by_end, by_other }
    }

    fn plane_dissipation(
        &self,
        q: &[T],
        p: &[T],
        j: usize,
        at: [T; 2],
        v: T,
    ) -> PlaneDissipation<T> {
        let Some(part) = &self.shape.planes[j].dissipation else {
            let zero = T::zero();
            return PlaneDissipation { value: zero, by_q: zero, by_p: zero, by_v: zero };
        };
        let point = Point { own: at, end: v, ..Point::new(q, p, &[]) };
        let [value, by_q, by_p, by_v] = self.run(part, &point);
        PlaneDissipation { value, by_q, by_p, by_v }
    }
}
