//! One-step methods.

use crate::error::{InputError, StepFailure};
use crate::numbers::Vector;
use crate::system::{State, System};
use std::ops::AddAssign;

/// A one-step method for systems `S` with states stored in `V`.
pub trait Method<V: Vector, S: System<V::Scalar> + ?Sized> {
    /// Scratch space for a step. The caller owns it, so that a step does not allocate.
    type Workspace;

    /// The workspace for a system.
    ///
    /// # Errors
    /// [`InputError::Unsupported`] if the method does not apply to this system.
    fn workspace(&self, system: &S) -> Result<Self::Workspace, InputError>;

    /// Advances (q, p, w) by one step `h`. The caller sets the time in `state`.
    ///
    /// # Errors
    /// A [`StepFailure`]; the state is then unchanged.
    fn step(
        &self,
        system: &S,
        h: V::Scalar,
        state: &mut State<V>,
        workspace: &mut Self::Workspace,
    ) -> Result<Effort, StepFailure>;

    /// Whether a step depends on the state alone and not on earlier steps through the workspace. A
    /// workspace can then be reused for another run, and a run of a system without singularities
    /// computes no more steps once the state has not changed over a block of steps.
    #[inline(always)]
    fn is_memoryless(&self) -> bool {
        false
    }

    /// Whether a step by itself keeps w to a rounding over a long run, and needs all of w for it.
    /// Other methods find in w what the steps since the start of a block have added, so that small
    /// increments are not lost in the rounding of w.
    #[inline(always)]
    fn sums_reservoir(&self) -> bool {
        false
    }

    /// Whether a step refuses by itself to cross a singularity of H. The time loop examines the
    /// steps of every other method ([`System::is_singular_between`]).
    #[inline(always)]
    fn refuses_singularities(&self) -> bool {
        false
    }

    /// Takes `count` steps without observation, with the same result to the bit as single steps.
    /// Methods that can take several steps at a time faster than one by one override it.
    ///
    /// # Errors
    /// The number of steps done and the failure of the next; the state is then that after the last
    /// successful step.
    #[inline(always)]
    fn steps(
        &self,
        system: &S,
        h: V::Scalar,
        count: u64,
        state: &mut State<V>,
        workspace: &mut Self::Workspace,
    ) -> Result<Effort, (u64, StepFailure)> {
        let mut effort = Effort::default();
        for done in 0..count {
            effort += self.step(system, h, state, workspace).map_err(|failure| (done, failure))?;
        }
        Ok(effort)
    }
}

/// The work of steps. An evaluation or iteration covers all degrees of freedom.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effort {
    /// Evaluations of the force: ∂H/∂q or its mean along an edge, together with D.
    pub evaluations: u64,
    /// Iterations of a nonlinear solver.
    pub iterations: u64,
}

impl Effort {
    /// The work of `steps` steps that cost as much as this one.
    pub(crate) fn times(self, steps: u64) -> Self {
        Self { evaluations: self.evaluations * steps, iterations: self.iterations * steps }
    }

    /// The average over `n` degrees of freedom that were treated one at a time, rounded up.
    #[inline(always)]
    pub fn shared_by(self, n: usize) -> Self {
        let share = |all: u64| if n > 1 { all.div_ceil(n as u64) } else { all };
        Self { evaluations: share(self.evaluations), iterations: share(self.iterations) }
    }
}

impl AddAssign for Effort {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        self.evaluations += other.evaluations;
        self.iterations += other.iterations;
    }
}
