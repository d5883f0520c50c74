//! Newton's iteration for Δz from Δz = 0, and by continuation from h = 0 if it fails.
//!
//! The Jacobian at z0 is kept for the whole step as long as each correction is less than a
//! sixteenth of the one before. Otherwise it is evaluated again at z̄, including the derivative of
//! λ. The first correction is the linearly implicit midpoint rule, whose error is O(h³). (A
//! Jacobian at the explicit z0 + h/2 f(z0) saves few corrections on short steps. On long steps that
//! point may be so far out that corrections are small only because the Jacobian is large.)

use super::equation::Workspace;
use super::lambda::Lambda;
use crate::iteration::{CONTINUATION, Correction, Iteration, Verdict};
use crate::kernels::reductions::terms;
use crate::second_derivatives::SecondDerivatives;
use afterbay_core::solver::{Updates, follow};
use afterbay_core::{Curvature, Effort, Mask, Quantity, Scalar, State, StepFailure, Vector};

/// At noise level, the iteration ends after this number of corrections without a new smallest one.
/// A choice.
const STALLED_IN_NOISE: u32 = 2;
/// Above noise level, the iteration ends after this number of corrections without a new smallest
/// one: far from the solution, Newton's method may pause for a few corrections. A choice.
const STALLED_ABOVE_NOISE: u32 = 8;
/// The Jacobian is renewed if the ratio of successive corrections exceeds this, between 0 and 1,
/// unless the last correction may be noise. A choice.
const SLOWEST_RATIO: f64 = 0.0625;
/// The Jacobian is renewed if a correction other than the first exceeds this share of z. A choice.
const LARGEST_CORRECTION: f64 = 0.01;
/// A correction below this number of roundings may be noise. A choice.
const CLEAR_ROUNDINGS: f64 = 1e3;
/// The largest correction, in roundings of the terms of the equation, that is accepted where
/// corrections no longer shrink.
const STALLED_CORRECTION_ROUNDINGS: f64 = 64.0;
/// The size of the next correction, in roundings, below which it is omitted. Omitted at every step,
/// it makes K drift by this amount.
const OMITTED_ROUNDINGS: f64 = 1.0 / 1024.0;

impl<V: Vector> Workspace<V> {
    /// Computes Δz, z̄ and z1. `finish` computes w1 and returns whether it accepts the solution.
    pub(crate) fn find<S>(
        &mut self,
        system: &S,
        h: V::Scalar,
        state: &State<V>,
        finish: impl Fn(&mut Self) -> bool,
    ) -> Result<Effort, StepFailure>
    where
        S: Curvature<V::Scalar> + ?Sized,
    {
        self.lambda_rounding = self.measured.largest();
        (self.energy_rounding, self.force_rounding) = (0.0, 0.0);
        if self.has_lambda {
            self.start = state.energy(system);
        }
        let (workspace, lambda) = (self, Lambda::zero());
        let mut step = Step {
            workspace,
            system,
            h,
            state,
            lambda,
            resolved: None,
            renewed: false,
            in_noise: 0,
            noise_share: f64::NAN,
            spent: 0,
        };
        if step.solve_from_rest().is_ok() && finish(step.workspace) {
            return Ok(step.effort());
        }
        // If the terms of H or of the forces cancel, their roundings exceed those of |H| and p. The
        // equations are solved up to these roundings: the largest that were measured in earlier
        // steps, then those measured here.
        if step.workspace.measured_roundings() != [0.0; 2] {
            step.workspace.allow_roundings(system, state);
            if step.solve_from_rest().is_ok() && finish(step.workspace) {
                return Ok(step.effort());
            }
        }
        step.workspace.measure_roundings(system, state)?;
        step.workspace.allow_roundings(system, state);
        if step.solve_from_rest().is_ok() && finish(step.workspace) {
            return Ok(step.effort());
        }
        step.solve_by_continuation()?;
        if finish(step.workspace) {
            return Ok(step.effort());
        }
        if step.workspace.energy.is_finite().all() {
            return Err(step.stalled());
        }
        Err(StepFailure::non_finite(&[(Quantity::Energy, &[step.workspace.energy])]))
    }

    /// The largest roundings of H and of the forces that were measured.
    fn measured_roundings(&self) -> [f64; 2] {
        [self.measured.largest(), self.measured_force.largest()]
    }

    /// Measures the roundings of H and of the forces at the start.
    #[cold]
    fn measure_roundings<S>(&mut self, system: &S, state: &State<V>) -> Result<(), StepFailure>
    where
        S: Curvature<V::Scalar> + ?Sized,
    {
        let (q, p) = (state.q.as_slice(), state.p.as_slice());
        self.measured.measure(system, q, p)?;
        self.measured_force.measure(system, [q, p]);
        Ok(())
    }

    /// Sets the roundings of H, of λ and of the forces at the start from the largest ones that were
    /// measured.
    #[cold]
    fn allow_roundings<S>(&mut self, system: &S, state: &State<V>)
    where
        S: Curvature<V::Scalar> + ?Sized,
    {
        let (q, p) = (state.q.as_slice(), state.p.as_slice());
        let second = SecondDerivatives::at(system, q, p).of_potential();
        let estimated = self.measured.of_forces(state.energy(system).to_f64(), second);
        self.force_rounding = estimated.max(self.measured_force.largest());
        if self.has_lambda {
            let [hq, hp] = &mut self.end_slopes;
            system.gradient(q, p, hq.as_mut_slice(), hp.as_mut_slice());
            // A rounding of z changes H by a rounding of these terms.
            let terms = (terms(hq.as_slice(), q) + terms(hp.as_slice(), p)).to_f64();
            let measured = self.measured.largest();
            (self.energy_rounding, self.lambda_rounding) = (measured, measured + terms);
        }
    }
}

/// A step of size h from `state`, and the state of its iteration.
struct Step<'a, V: Vector, S: ?Sized> {
    workspace: &'a mut Workspace<V>,
    system: &'a S,
    h: V::Scalar,
    state: &'a State<V>,
    /// λ at the current iterate
    lambda: Lambda<V::Scalar>,
    /// Whether λ exceeds its rounding error; decided once, so that the equation does not change
    /// while it is solved.
    resolved: Option<bool>,
    /// Whether the Jacobian was renewed.
    renewed: bool,
    /// The number of corrections in a row that may be noise, the first with a fresh Jacobian.
    in_noise: u32,
    /// The last correction relative to z, and to the terms of the equation.
    noise_share: f64,
    /// The number of corrections in this step.
    spent: u32,
}

impl<V: Vector, S: Curvature<V::Scalar> + ?Sized> Iteration for Step<'_, V, S> {
    const MOST_CORRECTIONS: u32 = 40;

    fn residual(&mut self) -> Result<(), StepFailure> {
        let Self { workspace, system, h, lambda, resolved, spent, .. } = self;
        *spent += 1;
        workspace.evaluate(*system);
        *lambda = workspace.lambda(*system).if_resolved(*h, resolved);
        workspace.residual(*system, *h, lambda);
        Ok(())
    }

    fn factorise(&mut self) -> Result<(), StepFailure> {
        let singular = |dof| StepFailure::Singular { dof, slope: None };
        self.workspace.factorise(self.system, self.h, &self.lambda).map_err(singular)?;
        // Only at the first iterate; later ones may be far out.
        if !self.renewed {
            self.workspace.gain = self.workspace.jacobian.gain();
        }
        Ok(())
    }

    fn solve(&mut self) {
        self.workspace.solve();
    }

    fn update(&mut self) -> Result<f64, StepFailure> {
        let update = self.workspace.update(self.h, self.state, &self.lambda);
        self.noise_share = update.noise_share;
        if update.size.is_finite() { Ok(update.size) } else { Err(self.workspace.not_finite()) }
    }

    fn judge(
        &mut self,
        updates: &Updates<f64>,
        correction: Correction,
    ) -> Result<Verdict, StepFailure> {
        let (epsilon, size, ratio) = (V::Scalar::EPSILON, updates.last(), updates.ratio());
        let Correction { count, is_fresh, is_last } = correction;
        let next_is_rounding = size <= epsilon
            || (ratio < 0.5 && updates.next_is_at_most(OMITTED_ROUNDINGS * epsilon));
        let small = self.noise_share <= STALLED_CORRECTION_ROUNDINGS * epsilon;
        let done = next_is_rounding || (small && updates.stalled(STALLED_IN_NOISE));
        // If the Jacobian had to be renewed, convergence must be confirmed by a correction with a
        // Jacobian evaluated at the current iterate.
        if done && (!self.renewed || (is_fresh && small)) {
            return Ok(Verdict::Converged);
        }
        // Near an equilibrium the noise of λ stays large relative to p, but is negligible relative
        // to the forces. A correction with a Jacobian evaluated here must confirm this first.
        self.in_noise =
            if small && (is_fresh || self.in_noise > 0) { self.in_noise + 1 } else { 0 };
        if self.in_noise > STALLED_ABOVE_NOISE {
            return Ok(Verdict::Converged);
        }
        if updates.stalled(STALLED_ABOVE_NOISE) || is_last {
            return Err(self.stalled());
        }
        // A Jacobian evaluated far out is large and makes the next correction small.
        let far = count > 1 && size > LARGEST_CORRECTION;
        let slow = ratio > SLOWEST_RATIO && size > CLEAR_ROUNDINGS * epsilon;
        let renew = slow || far || done;
        self.renewed |= renew;
        Ok(if renew { Verdict::Renew } else { Verdict::Keep })
    }
}

impl<V: Vector, S: Curvature<V::Scalar> + ?Sized> Step<'_, V, S> {
    /// Solves the step of size h from the current Δz.
    fn solve_from_here(&mut self) -> Result<(), StepFailure> {
        (self.resolved, self.renewed, self.in_noise) = (None, false, 0);
        self.converge()
    }

    /// Solves the step from Δz = 0.
    fn solve_from_rest(&mut self) -> Result<(), StepFailure> {
        self.workspace.initial_guess();
        self.workspace.place(self.state);
        self.solve_from_here()
    }

    /// Continues the solution from s = 0 to s = 1 for the step size s h.
    #[cold]
    fn solve_by_continuation(&mut self) -> Result<(), StepFailure> {
        let workspace = &mut *self.workspace;
        workspace.initial_guess();
        workspace.place(self.state);
        workspace.evaluate(self.system);
        workspace.v.as_mut_slice().copy_from_slice(workspace.hp.as_slice());
        if workspace.dissipative {
            workspace.dissipate(self.system);
        }
        workspace.check_force()?;
        let h = self.h;
        follow(CONTINUATION, |s| {
            self.workspace.remember();
            self.h = h * V::Scalar::from_f64(s);
            let outcome = self.solve_from_here();
            if outcome.is_err() {
                self.workspace.recall();
                self.workspace.place(self.state);
            }
            (self.spent, outcome)
        })
    }

    #[cold]
    fn stalled(&self) -> StepFailure {
        let (dof, update) = self.workspace.largest();
        StepFailure::NewtonStalled { dof, iterations: self.spent, update }
    }

    fn effort(&self) -> Effort {
        Effort { evaluations: u64::from(self.spent), iterations: u64::from(self.spent) }
    }
}
