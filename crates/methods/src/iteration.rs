//! The iteration of implicit methods with several unknowns: Newton's method with a Jacobian that is
//! kept while it serves, or fixed-point iteration, which has none.
//!
//! ```text
//! residual        evaluates the equations at the current iterate
//! factorise       evaluates and factorises the Jacobian there, at the first iterate and on request
//! solve           computes the correction
//! update          adds it, and returns its size
//! judge           tests convergence by the sizes so far (`Updates`)
//! ```

use afterbay_core::StepFailure;
use afterbay_core::solver::{Limits, Updates};

/// The limits of the continuation of a step from h = 0. Choices: with many unknowns each of its
/// steps is expensive.
pub(crate) const CONTINUATION: Limits = Limits { shortest: 1e-3, evaluations: 20_000 };

/// The outcome of [`Iteration::judge`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// The equations are solved.
    Converged,
    /// Another correction with the same Jacobian.
    Keep,
    /// Another correction with the Jacobian at the current iterate.
    Renew,
}

/// The correction that is judged.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Correction {
    /// Its number, from 1.
    pub(crate) count: u32,
    /// Whether its Jacobian was evaluated at the iterate that it corrects.
    pub(crate) is_fresh: bool,
    /// Whether it is the last one allowed.
    pub(crate) is_last: bool,
}

/// An iteration for the equations of a step.
pub(crate) trait Iteration {
    /// The largest number of corrections.
    const MOST_CORRECTIONS: u32;

    /// Evaluates the equations at the current iterate.
    fn residual(&mut self) -> Result<(), StepFailure>;

    /// Evaluates and factorises the Jacobian at the current iterate.
    fn factorise(&mut self) -> Result<(), StepFailure> {
        Ok(())
    }

    /// Computes the correction from the residual.
    fn solve(&mut self) {}

    /// Adds the correction. Returns its size, usually relative to that of the solution.
    fn update(&mut self) -> Result<f64, StepFailure>;

    /// Whether to go on. Must not ask for more after the last correction.
    fn judge(
        &mut self,
        updates: &Updates<f64>,
        correction: Correction,
    ) -> Result<Verdict, StepFailure>;

    /// Iterates from the current iterate to the solution.
    ///
    /// # Errors
    /// A failure of one of the parts.
    fn converge(&mut self) -> Result<(), StepFailure> {
        let (mut updates, mut is_fresh) = (Updates::none(), true);
        for count in 1..=Self::MOST_CORRECTIONS {
            self.residual()?;
            if is_fresh {
                self.factorise()?;
            }
            self.solve();
            updates.see(self.update()?);
            let is_last = count == Self::MOST_CORRECTIONS;
            match self.judge(&updates, Correction { count, is_fresh, is_last })? {
                Verdict::Converged => return Ok(()),
                verdict => is_fresh = verdict == Verdict::Renew,
            }
        }
        let (iterations, update) = (Self::MOST_CORRECTIONS, updates.last());
        Err(StepFailure::NewtonStalled { dof: 0, iterations, update })
    }
}
