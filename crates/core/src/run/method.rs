//! One-step methods, with a fixed step and with steps chosen by an error estimate.

use super::tolerance::Tolerance;
use crate::error::{InputError, StepFailure};
use crate::numbers::Vector;
use crate::system::{State, System};
use std::ops::{AddAssign, Sub};

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
    /// For other methods w holds only the sum of the increments since the start of a block, so that
    /// small increments are not lost in the rounding of w.
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

/// A method that estimates its own error.
pub trait Adaptive<V: Vector, S: System<V::Scalar> + ?Sized> {
    /// Scratch space and the last attempted step.
    type Workspace;

    /// The least factor by which a step grows; at least 1. A step that could grow by less keeps its
    /// length. Above 1 it pays for methods that reuse work as long as the step does not change.
    const LEAST_GROWTH: f64 = 1.0;

    /// The workspace for a run over the time `span`.
    ///
    /// # Errors
    /// [`InputError::Unsupported`] if the method does not apply to this system,
    /// [`InputError::Tolerance`] if it cannot meet the tolerance.
    fn workspace(
        &self,
        system: &S,
        tolerance: &Tolerance,
        span: f64,
    ) -> Result<Self::Workspace, InputError>;

    /// Computes the step h from `state`, which does not change, and estimates its error.
    ///
    /// # Errors
    /// A [`StepFailure`]. A shorter step may succeed.
    fn attempt(
        &self,
        system: &S,
        h: V::Scalar,
        state: &State<V>,
        workspace: &mut Self::Workspace,
    ) -> Result<Attempt, StepFailure>;

    /// The coordinates at the end of the step attempted last.
    fn end<'a>(&self, workspace: &'a Self::Workspace) -> &'a [V::Scalar];

    /// Moves `state` to the end of the step attempted last. The caller sets its time.
    fn accept(&self, state: &mut State<V>, workspace: &mut Self::Workspace);

    /// Computes the state at the time h after `before`, the initial state of the step accepted
    /// last, which is longer than h.
    ///
    /// # Errors
    /// A [`StepFailure`].
    fn between(
        &self,
        system: &S,
        h: V::Scalar,
        before: &State<V>,
        workspace: &mut Self::Workspace,
        to: &mut State<V>,
    ) -> Result<Effort, StepFailure>;
}

/// The estimates for an attempted step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Attempt {
    /// The error as a share of the error allowed for the step; accepted up to 1. Infinite if the
    /// end of the step was not computed.
    pub error: f64,
    /// The power of h by which this share grows.
    pub order: u32,
    /// The largest factor from this step to the next for reasons other than the error, such as
    /// stability.
    pub largest_growth: f64,
    /// The work done.
    pub effort: Effort,
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

impl Sub for Effort {
    type Output = Self;

    fn sub(self, before: Self) -> Self {
        Self {
            evaluations: self.evaluations - before.evaluations,
            iterations: self.iterations - before.iterations,
        }
    }
}

impl AddAssign for Effort {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        self.evaluations += other.evaluations;
        self.iterations += other.iterations;
    }
}
