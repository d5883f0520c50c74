//! Newton's iterations in turn, used where sweeps do not contract, and where they did not in the
//! step before.
//!
//! The simplified iteration starts from the extrapolated polynomial of the last step, then from a
//! constant. If it does not converge, or converges slowly, the exact derivative is used.

use super::equations::Equations;
use super::exact_newton::Exact;
use super::iteration::{Problem, Workspace};
use super::krylov::Krylov;
use super::newton::Step;
use crate::iteration::Iteration;
use afterbay_core::{Curvature, StepFailure, Vector};

/// The largest h times an entry of the Jacobian for which the next step tries sweeps again. A
/// choice: sweeps contract where it is below 1.
const LARGEST_SWEPT_GAIN: f64 = 0.5;

impl<V: Vector> Workspace<V> {
    /// Runs Newton's iterations in turn. Returns the number of evaluations of all nodes.
    pub(super) fn newton<S: Curvature<V::Scalar> + ?Sized>(
        &mut self,
        problem: &Problem<'_, V, S>,
    ) -> Result<u32, StepFailure> {
        let mut equations = match self.equations.take() {
            Some(equations) => equations,
            None => Box::new(Equations::new(problem.system, self.stages)?),
        };
        let mut krylov = self.krylov.take();
        let (workspace, problem) = (&mut *self, Problem { ..*problem });
        let mut step = Step::new(workspace, &mut equations, problem);
        let outcome = step.try_in_turn(&mut krylov).map(|()| step.spent);
        self.krylov = krylov;
        // Sweeps contract again where h J is small.
        self.stiff = outcome.is_ok() && equations.gain > LARGEST_SWEPT_GAIN;
        self.equations = Some(equations);
        outcome
    }
}

impl<V: Vector, S: Curvature<V::Scalar> + ?Sized> Step<'_, V, S> {
    /// Tries the simplified iteration and then the exact one, from the polynomial of the last step,
    /// from a constant, and by continuation. What the last step needed comes first.
    fn try_in_turn(
        &mut self,
        krylov: &mut Option<Box<Krylov<V::Scalar>>>,
    ) -> Result<(), StepFailure> {
        let (n, hard) = (self.problem.state.dof(), self.workspace.hard);
        let mut outcome =
            Err(StepFailure::NewtonStalled { dof: 0, iterations: 0, update: f64::NAN });
        if !hard {
            if self.workspace.stiff {
                outcome = self.converge();
            }
            if outcome.is_err() {
                self.workspace.rest(n);
                outcome = self.converge();
            }
        }
        if outcome.is_ok() || !self.workspace.thorough {
            return outcome;
        }
        let (unknowns, modes) = (self.equations.missing.len(), &self.workspace.q_modes);
        let krylov = krylov.get_or_insert_with(|| Box::new(Krylov::new(modes, unknowns)));
        if hard {
            outcome = Exact::new(self, krylov).converge();
        }
        if outcome.is_err() {
            self.workspace.rest(n);
            outcome = Exact::new(self, krylov).converge();
        }
        if outcome.is_err() {
            outcome = Exact::new(self, krylov).solve_by_continuation();
        }
        self.workspace.hard = outcome.is_ok();
        outcome
    }
}
