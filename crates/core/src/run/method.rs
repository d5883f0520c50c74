//! What a one-step method is.

use crate::error::{InputError, StepFailure};
use crate::numbers::Vector;
use crate::system::{State, System};
use std::ops::AddAssign;

/// A one-step method for systems `S` with states stored in `V`.
pub trait Method<V: Vector, S: System<V::Scalar> + ?Sized> {
    /// Scratch space a step writes to; the caller owns it, so that a step does not allocate.
    type Workspace;

    /// The workspace for a system.
    ///
    /// # Errors
    /// [`InputError::Unsupported`] where the method does not apply to this system.
    fn workspace(&self, system: &S) -> Result<Self::Workspace, InputError>;

    /// Takes (q, p, w) one step `h` further. The time in `state` is the caller's to set.
    ///
    /// # Errors
    /// A [`StepFailure`]; the state is then as it was.
    fn step(
        &self,
        system: &S,
        h: V::Scalar,
        state: &mut State<V>,
        workspace: &mut Self::Workspace,
    ) -> Result<Effort, StepFailure>;

    /// Does a step depend on nothing but the state, whatever others have left in the workspace: is that scratch space, or a table? One that
    /// changes nothing is then followed by none that does, and runs do not take them; and a workspace is as good as new for another run.
    #[inline(always)]
    fn is_memoryless(&self) -> bool {
        false
    }

    /// Takes `count` steps at which no one looks, the same to the bit as one after the other. A method that gains by it may
    /// take several at a time.
    ///
    /// # Errors
    /// The number of steps done and why the next one failed; the state is then that after the last good one.
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

/// What steps cost, counted for all degrees of freedom at once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effort {
    /// Evaluations of the force (∂H/∂q or its mean along an edge, together with D).
    pub evaluations: u64,
    /// Iterations of a nonlinear solver.
    pub iterations: u64,
}

impl Effort {
    /// That of as many steps.
    pub(crate) fn times(self, steps: u64) -> Self {
        Self { evaluations: self.evaluations * steps, iterations: self.iterations * steps }
    }

    /// What `n` degrees of freedom took one at a time, as what each of them took, rounded up.
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
