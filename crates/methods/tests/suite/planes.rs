//! Systems with their derivatives in the phase plane of one degree of freedom.

use super::systems::{Springs, Twisted};
use afterbay_core::{
    Dissipation, DissipationForm, Passive, PhasePlane, PlaneDissipation, Scalar, Separable, Slopes,
    System,
};
use std::sync::Arc;

/// A system given by its slopes alone, without its own edges.
pub(crate) struct BySlopes<T: Scalar>(pub(crate) Arc<dyn PhasePlane<T>>);

/// The H of [`Twisted`] with D_j = c_j (1 + q_j²) ∂H/∂p_j.
pub(crate) struct Curved(pub(crate) [f64; 2]);

pub(crate) const TWISTED: Twisted = Twisted { c: 0.0, offset: 0.0 };

impl<T: Scalar> System<T> for Curved {
    fn dof(&self) -> usize {
        2
    }
    fn energy(&self, q: &[T], p: &[T]) -> T {
        TWISTED.energy(q, p)
    }
    fn gradient(&self, q: &[T], p: &[T], hq: &mut [T], hp: &mut [T]) {
        TWISTED.gradient(q, p, hq, hp);
    }
    fn dissipation(&self, q: &[T], p: &[T], v: &[T], d: &mut [T]) {
        for j in 0..2 {
            d[j] = self.plane_dissipation(q, p, j, [q[j], p[j]], v[j]).value;
        }
    }
    fn dissipation_form(&self) -> DissipationForm {
        DissipationForm {
            passive: Passive::each_if(self.0.iter().all(|&c| c >= 0.0)),
            ..DissipationForm::GENERAL
        }
    }
}

/// The derivatives of the H of [`Twisted`] with respect to q_j and p_j.
fn twisted_slopes<T: Scalar>(q: &[T], p: &[T], j: usize, [q_j, p_j]: [T; 2]) -> Slopes<T> {
    let (one, quarter, twist) = (T::one(), T::from_f64(0.25), T::from_f64(0.3));
    let three = T::from_f64(3.0);
    if j == 0 {
        let (x, y) = (q_j, q[1]);
        let mass = quarter * x * x + one;
        Slopes {
            hq: quarter * x * p_j * p_j + twist * p[1] + (y + y + x * x + y * y + one) * x,
            hp: mass * p_j,
            hqq: quarter * p_j * p_j + y + y + three * x * x + y * y + one,
            hqp: (x * p_j).half(),
            hpp: mass,
        }
    } else {
        let (x, y) = (q[0], q_j);
        let r = x * x + y * y + one;
        Slopes {
            hq: x * x + r * y,
            hp: p_j + twist * x,
            hqq: r + (y + y) * y,
            hqp: T::zero(),
            hpp: one,
        }
    }
}

impl<T: Scalar> PhasePlane<T> for Curved {
    fn slopes(&self, q: &[T], p: &[T], j: usize, at: [T; 2]) -> Slopes<T> {
        twisted_slopes(q, p, j, at)
    }
    fn plane_dissipation(
        &self,
        _q: &[T],
        _p: &[T],
        j: usize,
        [q, _]: [T; 2],
        v: T,
    ) -> PlaneDissipation<T> {
        let c = T::from_f64(self.0[j]);
        let by_v = c * (q * q + T::one());
        PlaneDissipation { value: by_v * v, by_q: (c + c) * q * v, by_p: T::zero(), by_v }
    }
}

impl<T: Scalar> PhasePlane<T> for Twisted {
    fn slopes(&self, q: &[T], p: &[T], j: usize, at: [T; 2]) -> Slopes<T> {
        twisted_slopes(q, p, j, at)
    }
    fn plane_dissipation(
        &self,
        _q: &[T],
        _p: &[T],
        _j: usize,
        _at: [T; 2],
        _v: T,
    ) -> PlaneDissipation<T> {
        PlaneDissipation { value: T::zero(), by_q: T::zero(), by_p: T::zero(), by_v: T::zero() }
    }
}

impl<T: Scalar> System<T> for BySlopes<T> {
    fn dof(&self) -> usize {
        self.0.dof()
    }
    fn energy(&self, q: &[T], p: &[T]) -> T {
        self.0.energy(q, p)
    }
    fn gradient(&self, q: &[T], p: &[T], hq: &mut [T], hp: &mut [T]) {
        self.0.gradient(q, p, hq, hp);
    }
    fn dissipation(&self, q: &[T], p: &[T], v: &[T], d: &mut [T]) {
        self.0.dissipation(q, p, v, d);
    }
    fn dissipation_form(&self) -> DissipationForm {
        self.0.dissipation_form()
    }
}

impl<T: Scalar> PhasePlane<T> for BySlopes<T> {
    fn slopes(&self, q: &[T], p: &[T], j: usize, at: [T; 2]) -> Slopes<T> {
        self.0.slopes(q, p, j, at)
    }
    fn plane_dissipation(
        &self,
        q: &[T],
        p: &[T],
        j: usize,
        at: [T; 2],
        v: T,
    ) -> PlaneDissipation<T> {
        self.0.plane_dissipation(q, p, j, at, v)
    }
}

/// [`Springs`] have a separable H, and D_j = c p_j.
impl Separable<f64> for Springs {
    fn mass(&self, j: usize) -> f64 {
        self.masses[j]
    }
    fn partial(&self, q: &[f64], j: usize, at: f64) -> f64 {
        self.springs.iter().fold(at, |sum, &(a, b, k)| {
            let pull = |other: usize| (at - q[other]) * (k + (at - q[other]).powi(2));
            sum + if a == j { pull(b) } else { 0.0 } + if b == j { pull(a) } else { 0.0 }
        })
    }
    fn dissipation_of(&self, _q: &[f64], p: &[f64], j: usize) -> Dissipation<f64> {
        Dissipation { value: self.c * p[j], by_q: 0.0, by_p: self.c }
    }
}

impl PhasePlane<f64> for Springs {
    fn slopes(&self, q: &[f64], _p: &[f64], j: usize, [q_j, p_j]: [f64; 2]) -> Slopes<f64> {
        let stiffness = self.springs.iter().fold(1.0, |sum, &(a, b, k)| {
            let of = |other: usize| k + 3.0 * (q_j - q[other]).powi(2);
            sum + if a == j { of(b) } else { 0.0 } + if b == j { of(a) } else { 0.0 }
        });
        let mass = self.masses[j];
        Slopes {
            hq: self.partial(q, j, q_j),
            hp: p_j / mass,
            hqq: stiffness,
            hqp: 0.0,
            hpp: 1.0 / mass,
        }
    }
    fn plane_dissipation(
        &self,
        _q: &[f64],
        _p: &[f64],
        j: usize,
        _at: [f64; 2],
        v: f64,
    ) -> PlaneDissipation<f64> {
        let by_v = self.c * self.masses[j];
        PlaneDissipation { value: by_v * v, by_q: 0.0, by_p: 0.0, by_v }
    }
}

/// H = p1²/2 + p2²/2 + q1²/2 - a q2⁴/4 is unbounded below in q2; for a = NaN the force is NaN.
pub(crate) struct Endless(pub(crate) f64);

impl System<f64> for Endless {
    fn dof(&self) -> usize {
        2
    }
    fn energy(&self, q: &[f64], p: &[f64]) -> f64 {
        (p[0] * p[0] + p[1] * p[1] + q[0] * q[0]) / 2.0 - self.0 * q[1].powi(4) / 4.0
    }
    fn gradient(&self, q: &[f64], p: &[f64], hq: &mut [f64], hp: &mut [f64]) {
        (hq[0], hq[1]) = (q[0], -self.0 * q[1].powi(3));
        hp.copy_from_slice(p);
    }
    fn dissipation(&self, _q: &[f64], _p: &[f64], _v: &[f64], d: &mut [f64]) {
        d.fill(0.0);
    }
    fn dissipation_form(&self) -> DissipationForm {
        DissipationForm::NONE
    }
}

impl PhasePlane<f64> for Endless {
    fn slopes(&self, _q: &[f64], _p: &[f64], j: usize, [q, p]: [f64; 2]) -> Slopes<f64> {
        let (hq, hqq) =
            if j == 0 { (q, 1.0) } else { (-self.0 * q.powi(3), -3.0 * self.0 * q * q) };
        Slopes { hq, hp: p, hqq, hqp: 0.0, hpp: 1.0 }
    }
    fn plane_dissipation(
        &self,
        _q: &[f64],
        _p: &[f64],
        _j: usize,
        _at: [f64; 2],
        _v: f64,
    ) -> PlaneDissipation<f64> {
        PlaneDissipation { value: 0.0, by_q: 0.0, by_p: 0.0, by_v: 0.0 }
    }
}
