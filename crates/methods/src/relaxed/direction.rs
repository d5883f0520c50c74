//! The direction of a step: the increments of q, p and w for γ = 1.

use crate::kernels::reductions::{max_norm, sum};
use crate::runge_kutta::{P, Q, Stages, Tableau, W};
use afterbay_core::{Effort, Scalar, State, System, Vector};

/// The stages of a step and the increments d = (q, p) and e = w.
#[derive(Clone, Debug)]
pub(super) struct Direction<V: Vector> {
    stages: Stages<V>,
    pub(super) q: V,
    pub(super) p: V,
    pub(super) w: V,
}

impl<V: Vector> Direction<V> {
    pub(super) fn new<S: System<V::Scalar> + ?Sized>(system: &S, stages: usize) -> Self {
        let zeros = || V::zeros(system.dof());
        Self { stages: Stages::new(system, stages), q: zeros(), p: zeros(), w: zeros() }
    }

    /// Computes the first stage of a step from `state`.
    #[inline]
    pub(super) fn begin<S: System<V::Scalar> + ?Sized>(
        &mut self,
        system: &S,
        state: &State<V>,
    ) -> Effort {
        self.stages.begin(system, state);
        Effort { evaluations: 1, iterations: 0 }
    }

    /// Computes the other stages, and d and e, for the step size η.
    #[inline]
    pub(super) fn take<B, S>(&mut self, system: &S, eta: V::Scalar, state: &State<V>) -> Effort
    where
        B: Tableau,
        S: System<V::Scalar> + ?Sized,
    {
        let Self { stages, q, p, w } = self;
        stages.advance::<B, S>(system, eta, state);
        stages.sum::<Q>(B::WEIGHTS, eta, q);
        stages.sum::<P>(B::WEIGHTS, eta, p);
        stages.sum::<W>(B::WEIGHTS, eta, w);
        Effort { evaluations: B::ROWS.len() as u64 - 1, iterations: 0 }
    }

    /// The derivative of K with respect to γ at γ = 0, ∇H·d + Σ e_j.
    pub(super) fn slope(&self) -> V::Scalar {
        let along = |slope: &V, d: &V| sum([slope.as_slice(), d.as_slice()], |[x, y]| x * y);
        let gained = sum([self.w.as_slice()], |[e]| e);
        along(&self.stages.start, &self.q) + along(self.stages.velocity(0), &self.p) + gained
    }

    /// Σ (|z_j| + |d_j|) |∂H/∂z_j| + Σ (|w_j| + |e_j|) with the slopes at the start: the scale of
    /// the rounding of K along the step. The increments count because a step may begin at z = 0.
    pub(super) fn size(&self, state: &State<V>) -> f64 {
        let terms = |z: &V, d: &V, slope: &V| {
            let parts = [z.as_slice(), d.as_slice(), slope.as_slice()];
            sum(parts, |[z, d, slope]| (z.abs() + d.abs()) * slope.abs())
        };
        let held = sum([state.w.as_slice(), self.w.as_slice()], |[w, e]| w.abs() + e.abs());
        let [q, p] = [&self.stages.start, self.stages.velocity(0)];
        (terms(&state.q, &self.q, q) + terms(&state.p, &self.p, p) + held).to_f64()
    }

    /// Whether `change` times d moves the state by more than a rounding.
    pub(super) fn feel(&self, state: &State<V>, change: V::Scalar) -> bool {
        let largest = |part: &V| max_norm(part.as_slice());
        let moved =
            |d: &V, z: &V| change.to_f64().abs() * largest(d) > V::Scalar::EPSILON * largest(z);
        moved(&self.q, &state.q) || moved(&self.p, &state.p)
    }
}
