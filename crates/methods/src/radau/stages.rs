//! The stages of a Radau IIA step.

use super::tables::Tables;
use crate::points::{dissipation, gradient};
use afterbay_core::{Quantity, Scalar, State, StepFailure, System, Vector};
use std::array::from_fn;

/// A matrix that maps S stages to S stages, by columns.
pub(super) type Columns<T, const S: usize> = [[T; S]; S];

/// The increments of q and p at the stages, and the slopes there.
#[derive(Clone, Debug)]
pub(super) struct Stages<V: Vector, const S: usize> {
    /// Z_i = z_i - z0
    pub(super) q: [V; S],
    pub(super) p: [V; S],
    /// ∂H/∂p, -∂H/∂q - D, and D_j ∂H/∂p_j.
    pub(super) v: [V; S],
    pub(super) f: [V; S],
    pub(super) loss: [V; S],
}

/// The slopes at a point.
#[derive(Clone, Debug)]
pub(super) struct Point<V: Vector> {
    pub(super) hq: V,
    pub(super) v: V,
    pub(super) f: V,
    pub(super) d: V,
    pub(super) loss: V,
}

impl<V: Vector> Point<V> {
    pub(super) fn new(n: usize) -> Self {
        let zeros = || V::zeros(n);
        Self { hq: zeros(), v: zeros(), f: zeros(), d: zeros(), loss: zeros() }
    }

    /// Computes the slopes at (q, p).
    #[inline(always)]
    pub(super) fn evaluate_slopes<S>(&mut self, system: &S, dissipative: bool, q: &V, p: &V)
    where
        S: System<V::Scalar> + ?Sized,
    {
        let Self { hq, v, f, d, loss } = self;
        let (q, p) = (q.as_slice(), p.as_slice());
        system.gradient(q, p, hq.as_mut_slice(), v.as_mut_slice());
        if dissipative {
            system.dissipation(q, p, v.as_slice(), d.as_mut_slice());
        }
        forces(dissipative, [hq, d, v], [f, loss]);
    }
}

/// Writes -∂H/∂q - D and D_j ∂H/∂p_j for the given ∂H/∂q, D and ∂H/∂p.
#[inline(always)]
fn forces<V: Vector>(dissipative: bool, [hq, d, v]: [&V; 3], [f, loss]: [&mut V; 2]) {
    let n = V::LEN.unwrap_or(hq.as_slice().len());
    let [hq, d, v] = [hq, d, v].map(|x| &x.as_slice()[..n]);
    let [f, loss] = [f, loss].map(|x| &mut x.as_mut_slice()[..n]);
    if dissipative {
        for j in 0..n {
            f[j] = -(hq[j] + d[j]);
            loss[j] = d[j] * v[j];
        }
    } else {
        for j in 0..n {
            f[j] = -hq[j];
        }
    }
}

/// The points of the stages, and ∂H/∂q and D there.
#[derive(Clone, Debug)]
pub(super) struct Points<V: Vector, const S: usize> {
    q: [V; S],
    p: [V; S],
    hq: [V; S],
    d: [V; S],
}

impl<V: Vector, const S: usize> Points<V, S> {
    pub(super) fn new(n: usize) -> Self {
        let zeros = || from_fn(|_| V::zeros(n));
        Self { q: zeros(), p: zeros(), hq: zeros(), d: zeros() }
    }
}

impl<V: Vector, const S: usize> Stages<V, S> {
    pub(super) fn new(n: usize) -> Self {
        let zeros = || from_fn(|_| V::zeros(n));
        Self { q: zeros(), p: zeros(), v: zeros(), f: zeros(), loss: zeros() }
    }

    /// Computes the slopes at the stages of a step from `state`. ∂H/∂q and D of the last stage,
    /// which is the end of the step, are copied to `last`.
    #[inline(always)]
    pub(super) fn evaluate_slopes<F: System<V::Scalar> + ?Sized>(
        &mut self,
        system: &F,
        dissipative: bool,
        state: &State<V>,
        points: &mut Points<V, S>,
        last: &mut Point<V>,
    ) {
        let n = V::LEN.unwrap_or(state.dof());
        let Self { q: by_q, p: by_p, v, f, loss } = self;
        let Points { q, p, hq, d } = points;
        for (to, from, by) in [(&mut *q, &state.q, by_q), (&mut *p, &state.p, by_p)] {
            let from = &from.as_slice()[..n];
            for (to, by) in to.iter_mut().zip(by) {
                let (to, by) = (&mut to.as_mut_slice()[..n], &by.as_slice()[..n]);
                for j in 0..n {
                    to[j] = from[j] + by[j];
                }
            }
        }
        gradient(system, q, p, hq, v);
        if dissipative {
            dissipation(system, q, p, v, d);
        }
        for i in 0..S {
            forces(dissipative, [&hq[i], &d[i], &v[i]], [&mut f[i], &mut loss[i]]);
        }
        for (to, from) in [(&mut last.hq, &hq[S - 1]), (&mut last.d, &d[S - 1])] {
            to.as_mut_slice().copy_from_slice(from.as_slice());
        }
    }

    /// The residual `h Σ_j a_ij y'_j - Z_i` of one degree of freedom, with the stages of q or p and
    /// their slopes.
    #[inline(always)]
    pub(super) fn residual(
        tables: &Tables<V::Scalar, S>,
        h: V::Scalar,
        increments: &[V; S],
        slopes: &[V; S],
        d: usize,
    ) -> [f64; S] {
        let mut sums = [V::Scalar::zero(); S];
        for (column, slope) in tables.columns.iter().zip(slopes) {
            let slope = slope.as_slice()[d];
            for i in 0..S {
                sums[i] = column[i].mul_add(slope, sums[i]);
            }
        }
        from_fn(|i| h.mul_add(sums[i], -increments[i].as_slice()[d]).to_f64())
    }

    /// Initialises the stages by a polynomial, given by its values at the stages of `from`,
    /// relative to its value at the end of that step if the new step begins there.
    #[inline(always)]
    pub(super) fn extrapolate(
        &mut self,
        extrapolation: &Columns<V::Scalar, S>,
        from: &Self,
        from_its_end: bool,
    ) {
        for (to, from) in [(&mut self.q, &from.q), (&mut self.p, &from.p)] {
            let n = V::LEN.unwrap_or(to[0].as_slice().len());
            for d in 0..n {
                let mut sums = [V::Scalar::zero(); S];
                for (column, from) in extrapolation.iter().zip(from) {
                    let value = from.as_slice()[d];
                    for i in 0..S {
                        sums[i] = column[i].mul_add(value, sums[i]);
                    }
                }
                let start =
                    if from_its_end { from[S - 1].as_slice()[d] } else { V::Scalar::zero() };
                for i in 0..S {
                    to[i].as_mut_slice()[d] = sums[i] - start;
                }
            }
        }
    }

    /// Initialises the stages by the state at the start of the step, except for the coordinates
    /// from `free` on. These belong to motors and are times, which are known.
    pub(super) fn rest(&mut self, free: usize, times: [V::Scalar; S]) {
        for part in self.q.iter_mut().chain(&mut self.p) {
            part.as_mut_slice().fill(V::Scalar::zero());
        }
        for (q, time) in self.q.iter_mut().zip(times) {
            q.as_mut_slice()[free..].fill(time);
        }
    }

    /// The failure of a step whose stages are not finite.
    #[cold]
    pub(super) fn not_finite(&self) -> StepFailure {
        for i in 0..S {
            let parts = [
                (Quantity::Coordinate, self.q[i].as_slice()),
                (Quantity::Momentum, self.p[i].as_slice()),
                (Quantity::Velocity, self.v[i].as_slice()),
                (Quantity::Force, self.f[i].as_slice()),
                (Quantity::ReservoirRate, self.loss[i].as_slice()),
            ];
            if parts.iter().any(|(_, part)| part.iter().any(|x| !x.to_f64().is_finite())) {
                return StepFailure::non_finite(&parts);
            }
        }
        StepFailure::NonFinite { quantity: Quantity::Momentum, dof: 0, value: f64::NAN }
    }
}
