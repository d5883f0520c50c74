//! Solvers of the equations of an implicit step: one scalar equation ([`Newton`], [`FixedPoint`]),
//! or two equations ([`newton_2x2`]). The convergence test ([`Updates`]) and the continuation
//! ([`follow`]) serve methods with more equations too.
//!
//! A scalar equation is written `x = start - F(s, x)` with `F = O(s)`. Its solution is `start` at s
//! = 0 and the step at s = 1. If there are several at s = 1, the one wanted is on the branch that
//! starts at s = 0.

mod continuation;
mod convergence;
mod fixed_point;
mod illinois;
mod newton;
pub mod newton_2x2;
mod several_solutions;

pub use continuation::{Limits, follow};
pub use convergence::Updates;
pub use fixed_point::FixedPoint;
pub use illinois::zero_within;
pub use newton::Newton;

use crate::error::StepFailure;
use crate::numbers::Scalar;

/// A method that solves `x = start - F(1, x)` to rounding.
pub trait Solver {
    /// The solution, from `start`.
    ///
    /// # Errors
    /// A [`StepFailure`] of degree of freedom `dof`.
    fn solve<T: Scalar>(
        &self,
        dof: usize,
        start: T,
        equation: impl Equation<T>,
    ) -> Result<Root<T>, StepFailure>;
}

/// F of an equation `x = start - F(s, x)`. A closure `FnMut(T, T) -> Sample<T>` is one. Solvers
/// evaluate F in several places; a named type can request inlining in each, a closure cannot.
pub trait Equation<T> {
    /// F at (s, x)
    fn at(&mut self, s: T, x: T) -> Sample<T>;
}

impl<T, F: FnMut(T, T) -> Sample<T>> Equation<T> for F {
    #[inline(always)]
    fn at(&mut self, s: T, x: T) -> Sample<T> {
        self(s, x)
    }
}

/// F at a point, with its derivative and bounds of its rounding errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample<T> {
    /// F
    pub value: T,
    /// ∂F/∂x
    pub slope: T,
    /// The change of F by a rounding of its argument, in unit roundoffs: |∂F/∂x| times the size of
    /// the numbers that x is added to.
    pub argument_rounding: T,
    /// A bound of the rounding error of F, in unit roundoffs: the sum of the sizes of its terms,
    /// which may cancel. Corrections that no longer shrink are taken for noise up to 64 times this
    /// error, so that a bound that is too large costs no more accuracy than that.
    pub value_rounding: T,
}

/// A solution and the work to find it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Root<T> {
    /// The solution.
    pub x: T,
    /// Evaluations of F.
    pub evaluations: u32,
}
