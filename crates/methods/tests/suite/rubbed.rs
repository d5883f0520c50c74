//! Three masses whose friction couples their momenta.

use afterbay_core::{Dissipation, DissipationForm, Passive, Scalar, Separable, System};

/// H = Σ [p_j²/(2 m_j) + q_j²/2] + (q_{j+1} - q_j)⁴/4, m = 1, 1.7, 0.6; D = c R ∂H/∂p, R symmetric
/// and positive definite.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rubbed {
    pub(crate) c: f64,
}

const MASSES: [f64; 3] = [1.0, 1.7, 0.6];
const R: [[f64; 3]; 3] = [[1.0, -0.5, 0.25], [-0.5, 1.5, 0.125], [0.25, 0.125, 0.75]];

impl<T: Scalar> System<T> for Rubbed {
    fn dof(&self) -> usize {
        3
    }
    fn energy(&self, q: &[T], p: &[T]) -> T {
        let own = |j: usize| (p[j] * p[j] / self.mass(j) + q[j] * q[j]).half();
        let bond = |r: T| (r * r * (r * r)).half().half();
        own(0) + own(1) + own(2) + bond(q[1] - q[0]) + bond(q[2] - q[1])
    }
    fn gradient(&self, q: &[T], p: &[T], hq: &mut [T], hp: &mut [T]) {
        (0..3).for_each(|j| (hq[j], hp[j]) = (self.partial(q, j, q[j]), p[j] / self.mass(j)));
    }
    fn dissipation(&self, _q: &[T], _p: &[T], v: &[T], d: &mut [T]) {
        for (d, row) in d.iter_mut().zip(R) {
            *d = row
                .iter()
                .zip(v)
                .fold(T::zero(), |sum, (&r, &v)| sum + T::from_f64(self.c) * T::from_f64(r) * v);
        }
    }
    fn dissipation_form(&self) -> DissipationForm {
        DissipationForm { zero: false, passive: Passive::InSum, linear: true, coupled: true }
    }
}

impl<T: Scalar> Separable<T> for Rubbed {
    fn mass(&self, j: usize) -> T {
        T::from_f64(MASSES[j])
    }
    fn partial(&self, q: &[T], j: usize, at: T) -> T {
        let pull = |i: Option<usize>| {
            i.and_then(|i| q.get(i)).map_or(T::zero(), |&q| (at - q) * (at - q) * (at - q))
        };
        at + pull(j.checked_sub(1)) + pull(Some(j + 1))
    }
    fn dissipation_of(&self, _q: &[T], p: &[T], j: usize) -> Dissipation<T> {
        let of = |k: usize| T::from_f64(self.c) * T::from_f64(R[j][k]) / self.mass(k);
        let value = (0..3).fold(T::zero(), |sum, k| of(k).mul_add(p[k], sum));
        Dissipation { value, by_q: T::zero(), by_p: of(j) }
    }
}
