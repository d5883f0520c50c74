//! How far roundings alone may move K over a step.

use super::iteration::{Workspace, largest};
use afterbay_core::{Curvature, Scalar, State, Vector};

impl<V: Vector> Workspace<V> {
    /// What K is made of at both ends of the step, each rounding of z as large as the second derivatives make it over h:
    /// `Σ |H| + Σ |w_j| + (1 + h |H''|) |z| (Σ |∂H| + Σ |D_j|)`. A rounding of the forces moves K by no more than one of these terms
    /// does; what moves it further is a quadrature that does not resolve H.
    #[cold]
    pub(super) fn terms<S>(&mut self, system: &S, h: V::Scalar, state: &State<V>) -> f64
    where
        S: Curvature<V::Scalar> + ?Sized,
    {
        let Self { slopes, q, p, w, .. } = self;
        let ([hq, d, ..], [hp, ..]) = (&mut slopes.hq, &mut slopes.hp);
        let (hq, hp, d) = (hq.as_mut_slice(), hp.as_mut_slice(), d.as_mut_slice());
        let total = |x: &[V::Scalar]| x.iter().map(|x| x.to_f64().abs()).sum::<f64>();
        let mut terms = 0.0;
        for (q, p, w) in [(&state.q, &state.p, &state.w), (&*q, &*p, &*w)] {
            let (q, p) = (q.as_slice(), p.as_slice());
            system.gradient(q, p, hq, hp);
            system.dissipation(q, p, hp, d);
            let mut bend = 0.0_f64;
            system.curvature(q, p, |_, _, _, entry| bend = bend.max(entry.to_f64().abs()));
            let slopes = total(hq) + total(hp) + total(d);
            let reach = (1.0 + h.to_f64().abs() * bend) * largest(q).max(largest(p));
            terms += system.energy(q, p).to_f64().abs() + total(w.as_slice()) + reach * slopes;
        }
        terms
    }
}
