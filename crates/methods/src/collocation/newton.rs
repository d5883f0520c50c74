//! Newton's simplified iteration for the coefficients of a step, with the Jacobian at its middle.

use super::equations::Equations;
use super::iteration::{Problem, Workspace};
use super::nodes::{extent, forces, place_q, velocities};
use super::progress::{MOST_ITERATIONS, Progress};
use super::rule::Modes;
use crate::iteration::{Correction, Iteration, Verdict};
use crate::kernels::reductions::largest_if_finite;
use afterbay_core::solver::Updates;
use afterbay_core::{Curvature, Quantity, Scalar, StepFailure, Vector};

/// The number of corrections without a new smallest one after which the iteration stops. A choice.
const STALLED_CORRECTIONS: u32 = 7;
/// The Jacobian is renewed if the ratio of successive corrections exceeds this, between 0 and 1. A
/// choice.
const SLOWEST_RATIO: f64 = 0.0625;
/// The exact derivative is used if corrections still shrink by less than this factor, between 0 and
/// 1, after this many of them. Choices: products with it cost less than so slow an iteration.
const CRAWLING_RATIO: f64 = 0.5;
const CRAWLING_CORRECTIONS: u32 = 12;

/// The Newton equations of a step, and the state of their iteration.
pub(super) struct Step<'a, V: Vector, S: ?Sized> {
    pub(super) workspace: &'a mut Workspace<V>,
    pub(super) equations: &'a mut Equations,
    pub(super) problem: Problem<'a, V, S>,
    /// The number of evaluations of all nodes.
    pub(super) spent: u32,
    /// The degree of freedom with the largest change of the last correction.
    dof: usize,
}

impl<'a, V: Vector, S: Curvature<V::Scalar> + ?Sized> Step<'a, V, S> {
    /// The iteration from the current γ.
    pub(super) fn new(
        workspace: &'a mut Workspace<V>,
        equations: &'a mut Equations,
        problem: Problem<'a, V, S>,
    ) -> Self {
        Self { workspace, equations, problem, spent: 0, dof: 0 }
    }

    /// Computes the residual of γ.
    pub(super) fn evaluate(&mut self) {
        let Self { workspace, equations, problem, .. } = self;
        let Problem { system, level, .. } = *problem;
        let Workspace { rules, nodes, slopes, q_modes, p_modes, next, next_q, .. } =
            &mut **workspace;
        let (panels, [q, p]) = (&rules[level], problem.starts());
        place_q(panels, nodes, q, q_modes);
        velocities(system, panels, nodes, slopes, p, p_modes, next_q);
        forces(system, panels, nodes, slopes, q, [q_modes, next_q], next);
        equations.set_residual([next_q, next], [q_modes, p_modes]);
    }

    /// The failure of an iteration with this last correction.
    pub(super) fn stalled(&self, dof: usize, update: f64) -> StepFailure {
        StepFailure::NewtonStalled { dof, iterations: self.spent, update }
    }

    /// The force that is not finite, if the residual is not.
    #[cold]
    pub(super) fn not_finite(&self) -> StepFailure {
        let not_finite = |&(most, _): &(f64, usize)| !most.is_finite();
        let (value, dof) =
            self.equations.largest().into_iter().find(not_finite).unwrap_or((f64::NAN, 0));
        StepFailure::NonFinite { quantity: Quantity::Force, dof, value }
    }
}

impl<V: Vector, S: Curvature<V::Scalar> + ?Sized> Iteration for Step<'_, V, S> {
    const MOST_CORRECTIONS: u32 = MOST_ITERATIONS;

    fn residual(&mut self) -> Result<(), StepFailure> {
        self.spent += 1;
        self.evaluate();
        Ok(())
    }

    /// Evaluates and factorises the Jacobian at the middle of the step.
    fn factorise(&mut self) -> Result<(), StepFailure> {
        let Self { workspace, equations, problem, .. } = self;
        let Problem { system, h, state, .. } = *problem;
        let Workspace { q, p, q_modes, p_modes, .. } = &mut **workspace;
        let (q, p, half) = (q.as_mut_slice(), p.as_mut_slice(), h.half());
        for j in 0..state.dof() {
            q[j] = half.mul_add(q_modes[j][0][0], state.q.as_slice()[j]);
            p[j] = (-half).mul_add(p_modes[j][0][0], state.p.as_slice()[j]);
        }
        let singular = |dof| StepFailure::Singular { dof, slope: None };
        equations.factorise(system, h.to_f64(), q, p).map_err(singular)
    }

    fn solve(&mut self) {
        self.equations.solve();
    }

    fn update(&mut self) -> Result<f64, StepFailure> {
        let Self { workspace, equations, problem: Problem { h, state, .. }, .. } = self;
        let Workspace { q_modes, p_modes, .. } = &mut **workspace;
        equations.add(1.0, [&mut *q_modes, &mut *p_modes]);
        let [(dq, q), (dp, p)] = equations.largest();
        let h = h.to_f64();
        let changes = [share(dq, h, &state.q, q_modes), share(dp, h, &state.p, p_modes)];
        let change = largest_if_finite(changes);
        self.dof = if changes[0] >= changes[1] { q } else { p };
        if change.is_finite() { Ok(change) } else { Err(self.stalled(self.dof, change)) }
    }

    fn judge(
        &mut self,
        updates: &Updates<f64>,
        Correction { count, is_last, .. }: Correction,
    ) -> Result<Verdict, StepFailure> {
        let (progress, ratio) = (Progress::of(updates, V::Scalar::EPSILON), updates.ratio());
        if progress.has_arrived(ratio, updates.last()) {
            return Ok(Verdict::Converged);
        }
        let crawls = self.workspace.thorough
            && count >= CRAWLING_CORRECTIONS
            && ratio > CRAWLING_RATIO
            && progress.is_clear();
        let diverges = progress.diverges(STALLED_CORRECTIONS);
        if crawls || diverges || is_last {
            let noise = (is_last && progress.is_rounding())
                || self.workspace.is_noise(&self.problem, updates.last());
            let failure = self.stalled(self.dof, updates.last());
            return if noise { Ok(Verdict::Converged) } else { Err(failure) };
        }
        let renew = ratio > SLOWEST_RATIO && progress.is_clear();
        Ok(if renew { Verdict::Renew } else { Verdict::Keep })
    }
}

/// The change of z due to the largest change of γ, relative to the size of z.
fn share<V: Vector>(change: f64, h: f64, start: &V, modes: &[Modes<V::Scalar>]) -> f64 {
    let size = extent(start, modes, h.abs());
    if change == 0.0 { 0.0 } else { h.abs() * change / size }
}
