//! The direction of a step: the increments of q, p and w for γ = 1.

use crate::kernels::reductions::{max_norm, sum};
use crate::runge_kutta::{P, Q, Stages, Tableau, W};
use afterbay_core::{Effort, Scalar, State, System, Vector};

/// The stages of a step, the number of the last one, and the increments d = (q, p) and e = w.
#[derive(Clone, Debug)]
pub(super) struct Direction<V: Vector> {
    stages: Stages<V>,
    last: usize,
    pub(super) q: V,
    pub(super) p: V,
    pub(super) w: V,
}

impl<V: Vector> Direction<V> {
    pub(super) fn new<S: System<V::Scalar> + ?Sized>(system: &S, stages: usize) -> Self {
        let zeros = || V::zeros(system.dof());
        let (last, stages) = (stages - 1, Stages::new(system, stages));
        Self { stages, last, q: zeros(), p: zeros(), w: zeros() }
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
        let Self { stages, q, p, w, .. } = self;
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
        let [q, p] = self.start_slopes();
        along(q, &self.q) + along(p, &self.p) + gained
    }

    /// Σ |d_j Δ∂H/∂z_j|, the absolute terms of d·H''d. Δ is the change from the first stage to the
    /// last one, which lies at the end of the step.
    #[inline]
    pub(super) fn curvature_terms(&self) -> V::Scalar {
        let terms = |d: &V, start: &V, end: &V| {
            let parts = [d.as_slice(), start.as_slice(), end.as_slice()];
            sum(parts, |[d, start, end]| (d * (end - start)).abs())
        };
        let ([q, p], [end_q, end_p]) = (self.start_slopes(), self.end_slopes());
        terms(&self.q, q, end_q) + terms(&self.p, p, end_p)
    }

    /// ∇H at the start of the step.
    fn start_slopes(&self) -> [&V; 2] {
        [&self.stages.start, self.stages.velocity(0)]
    }

    /// ∇H at the last stage.
    pub(super) fn end_slopes(&self) -> [&V; 2] {
        [&self.stages.hq, self.stages.velocity(self.last)]
    }

    /// Σ (|z_j| + |d_j|) |∂H/∂z_j| + Σ (|w_j| + |e_j|) with the slopes at the start: the scale of
    /// the rounding of K along the step. The increments count because a step may begin at z = 0.
    pub(super) fn size(&self, state: &State<V>) -> f64 {
        self.size_with(state, self.start_slopes())
    }

    /// The same with the slopes at the end of the step. A large angle is rounded where its force is
    /// large, even if that is 0 at the start.
    #[cold]
    pub(super) fn size_at_end(&self, state: &State<V>) -> f64 {
        self.size_with(state, self.end_slopes())
    }

    #[inline]
    fn size_with(&self, state: &State<V>, [q, p]: [&V; 2]) -> f64 {
        let terms = |z: &V, d: &V, slope: &V| {
            let parts = [z.as_slice(), d.as_slice(), slope.as_slice()];
            sum(parts, |[z, d, slope]| (z.abs() + d.abs()) * slope.abs())
        };
        let held = sum([state.w.as_slice(), self.w.as_slice()], |[w, e]| w.abs() + e.abs());
        (terms(&state.q, &self.q, q) + terms(&state.p, &self.p, p) + held).to_f64()
    }

    /// Whether ∇H of the first degrees of freedom, which are no motors, is zero at the start.
    pub(super) fn begins_at_rest(&self, free: usize) -> bool {
        let slopes = self.start_slopes().into_iter().flat_map(|slope| &slope.as_slice()[..free]);
        slopes.into_iter().all(|x| x.to_f64() == 0.0)
    }

    /// Whether `change` times d moves the state by more than a rounding.
    pub(super) fn feel(&self, state: &State<V>, change: V::Scalar) -> bool {
        let largest = |part: &V| max_norm(part.as_slice());
        let moved =
            |d: &V, z: &V| change.to_f64().abs() * largest(d) > V::Scalar::EPSILON * largest(z);
        moved(&self.q, &state.q) || moved(&self.p, &state.p)
    }
}
