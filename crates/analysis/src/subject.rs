//! A system as the studies see it: with a solution to compare to and methods to run.

use afterbay_core::{ExactFlow, InputError, Scalar, Series, State, System, taylor};
use afterbay_methods::moddg::steps::Equation;
use afterbay_methods::registry::{self, Row, Run};
use afterbay_systems::{DampedOscillator, Duffing, ModifiedVanDerPol, VanDerPol};

/// The states of the systems studied: one degree of freedom.
pub type OneState<T> = State<[T; 1]>;

/// A system with one degree of freedom, its type forgotten.
pub trait Subject<T: Scalar>: System<T> {
    /// The exact solution from `start` at the times `i h`, i = 0..=count.
    ///
    /// # Errors
    /// [`InputError::SolutionEnds`] where it leaves the numbers.
    fn solution(&self, start: &OneState<T>, h: T, count: usize) -> Result<Vec<OneState<T>>, InputError>;

    /// The method of a row, bound to this system.
    ///
    /// # Errors
    /// [`InputError::Unsupported`] where it does not apply.
    fn bind(&self, row: &Row) -> Result<Box<dyn Run<[T; 1]>>, InputError>;

    /// What the δ of an equation divides by at (q, p): the distance to its pole.
    fn denominator(&self, equation: Equation, q: T, p: T) -> T;

    /// Are the equations linear, so that a step of a linear method is a matrix?
    fn is_linear(&self) -> bool {
        false
    }
}

impl<T: Scalar> Subject<T> for DampedOscillator<T> {
    fn solution(&self, start: &OneState<T>, h: T, count: usize) -> Result<Vec<OneState<T>>, InputError> {
        (0..=count)
            .map(|i| {
                let mut state = start.clone();
                self.flow(T::from_f64(i as f64) * h, &mut state);
                state.check(1).map_err(|_| InputError::SolutionEnds { t: state.t.to_f64() })?;
                Ok(state)
            })
            .collect()
    }

    fn bind(&self, row: &Row) -> Result<Box<dyn Run<[T; 1]>>, InputError> {
        registry::linear(row, *self)
    }

    fn denominator(&self, equation: Equation, q: T, p: T) -> T {
        equation.denominator(self, q, p)
    }

    fn is_linear(&self) -> bool {
        true
    }
}

/// Terms of the Taylor series that stand in for an exact solution.
const TERMS: usize = 24;

macro_rules! solved_by_series {
    ($($system:ident),*) => {$(
        impl<T: Scalar> Subject<T> for $system<T> {
            fn solution(
                &self,
                start: &OneState<T>,
                h: T,
                count: usize,
            ) -> Result<Vec<OneState<T>>, InputError> {
                taylor::trajectory::<_, T, 1, TERMS>(&self.map(Series::constant), start, h, count)
            }

            fn bind(&self, row: &Row) -> Result<Box<dyn Run<[T; 1]>>, InputError> {
                registry::nonlinear(row, *self)
            }

            fn denominator(&self, equation: Equation, q: T, p: T) -> T {
                equation.denominator(self, q, p)
            }
        }
    )*};
}

solved_by_series!(Duffing, VanDerPol, ModifiedVanDerPol);
