//! Solvers of the scalar equation an implicit step comes down to.
//!
//! The equation is written `x = start - F(s, x)` with `F = O(s)`: at s = 0 its solution is `start`, at s = 1 it is the
//! step wanted, and the solution meant is the one that leads from there to here.

mod fixed_point;
mod newton;
mod several;

pub use fixed_point::FixedPoint;
pub use newton::Newton;

use crate::error::StepFailure;
use crate::numbers::Scalar;

/// A way to solve `x = start - F(1, x)` to rounding.
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

/// F of an equation `x = start - F(s, x)`; a closure `FnMut(T, T) -> Sample<T>` is one. Solvers evaluate it in several places:
/// types of their own can ask to be inlined in each, closures cannot.
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

/// F at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample<T> {
    /// F
    pub value: T,
    /// ∂F/∂x
    pub slope: T,
    /// What F changes by where its argument is rounded: this times the unit roundoff.
    pub argument_rounding: T,
    /// The same of all F is made of, of which much may cancel. Corrections that no longer shrink are noise up to 64 roundings
    /// of it, which is what a large bound costs at most.
    pub value_rounding: T,
}

/// A solution and what it took.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Root<T> {
    /// The solution.
    pub x: T,
    /// Evaluations of F.
    pub evaluations: u32,
}
