//! A system as the studies see it: with a solution to compare to and methods to run.

use crate::progress::Progress;
use crate::series::{self, by_series, stored};
use crate::{Solution, solution};
use afterbay_core::{Curvature, ExactFlow, InputError, IntegrateError, Scalar, Series, State, System};
use afterbay_methods::moddg::steps::Equation;
use afterbay_methods::registry::{self, Row, Run};
use afterbay_systems::{
    Custom, DampedDoublePendulum, DampedOscillator, Duffing, FputChain, ModifiedVanDerPol, VanDerPol,
    VanDerPolRing,
};

/// A system, its type forgotten.
pub trait Subject<T: Scalar>: System<T> {
    /// The solution from `start` at the times `i h`, i = 0..=count, with its doubt.
    ///
    /// # Errors
    /// [`InputError::Length`] where `start` is no state of this system, [`InputError::SolutionEnds`]
    /// where the solution leaves the numbers, [`IntegrateError::Interrupted`].
    fn solution(
        &self,
        start: &State<Vec<T>>,
        h: T,
        count: usize,
        progress: &dyn Progress,
    ) -> Result<Solution<T>, IntegrateError>;

    /// The method of a row, bound to this system.
    ///
    /// # Errors
    /// [`InputError::Unsupported`] where it does not apply.
    fn bind(&self, row: &Row) -> Result<Run<T>, InputError>;

    /// What the δ of an equation divides by at (q, p): the distance to its pole. Only one degree of freedom has a δ.
    fn denominator(&self, _equation: Equation, _q: &[T], _p: &[T]) -> Option<T> {
        None
    }

    /// Are the equations linear, so that a step of a linear method is a matrix?
    fn is_linear(&self) -> bool {
        false
    }
}

impl<T: Scalar> Subject<T> for DampedOscillator<T> {
    fn solution(
        &self,
        start: &State<Vec<T>>,
        h: T,
        count: usize,
        progress: &dyn Progress,
    ) -> Result<Solution<T>, IntegrateError> {
        let start = stored::<[T; 1]>(start, 1)?;
        let mut solution = Solution::with_room(1, count + 1);
        for i in 0..=count {
            if progress.stopped() {
                return Err(IntegrateError::Interrupted);
            }
            let t = T::from_f64(i as f64) * h;
            let (mut state, mut twice) = (start.clone(), start.clone());
            self.flow(t, &mut state);
            state.check(1).map_err(|_| InputError::SolutionEnds { t: state.t.to_f64() })?;
            // In two flows of a third and the rest: how far that is off is what roundings make of it.
            let third = t * T::from_f64(1.0 / 3.0);
            self.flow(third, &mut twice);
            self.flow(t - third, &mut twice);
            solution.push(state.state_ref());
            solution.doubt_last(solution::twice_apart(&state, &twice));
        }
        Ok(solution)
    }

    fn bind(&self, row: &Row) -> Result<Run<T>, InputError> {
        registry::linear(row, *self)
    }

    fn denominator(&self, equation: Equation, q: &[T], p: &[T]) -> Option<T> {
        Some(equation.denominator(self, *q.first()?, *p.first()?))
    }

    fn is_linear(&self) -> bool {
        true
    }
}

macro_rules! with_one_degree {
    ($($system:ident),*) => {$(
        impl<T: Scalar> Subject<T> for $system<T> {
            fn solution(
                &self,
                start: &State<Vec<T>>,
                h: T,
                count: usize,
                progress: &dyn Progress,
            ) -> Result<Solution<T>, IntegrateError> {
                let ranges = self.map(series::range);
                by_series::<[T; 1], _, _>((&self.map(Series::constant), ranges), start, h, count, progress)
            }

            fn bind(&self, row: &Row) -> Result<Run<T>, InputError> {
                registry::nonlinear(row, *self)
            }

            fn denominator(&self, equation: Equation, q: &[T], p: &[T]) -> Option<T> {
                Some(equation.denominator(self, *q.first()?, *p.first()?))
            }

            fn is_linear(&self) -> bool {
                Curvature::is_linear(self)
            }
        }
    )*};
}

macro_rules! with_many_degrees {
    ($($system:ident by $bind:ident),*) => {$(
        impl<T: Scalar> Subject<T> for $system<T> {
            fn solution(
                &self,
                start: &State<Vec<T>>,
                h: T,
                count: usize,
                progress: &dyn Progress,
            ) -> Result<Solution<T>, IntegrateError> {
                let ranges = self.map(series::range);
                by_series::<Vec<T>, _, _>((&self.map(Series::constant), ranges), start, h, count, progress)
            }

            fn bind(&self, row: &Row) -> Result<Run<T>, InputError> {
                registry::$bind(row, *self)
            }

            fn is_linear(&self) -> bool {
                Curvature::is_linear(self)
            }
        }
    )*};
}

with_one_degree!(Duffing, VanDerPol, ModifiedVanDerPol);
with_many_degrees!(FputChain by separable, VanDerPolRing by separable, DampedDoublePendulum by general);

impl<T: Scalar> Subject<T> for Custom<T> {
    fn solution(
        &self,
        start: &State<Vec<T>>,
        h: T,
        count: usize,
        progress: &dyn Progress,
    ) -> Result<Solution<T>, IntegrateError> {
        let ranges = self.map(series::range);
        by_series::<Vec<T>, _, _>((&self.map(Series::constant), ranges), start, h, count, progress)
    }

    fn bind(&self, row: &Row) -> Result<Run<T>, InputError> {
        if self.dof() == 1 {
            registry::single(row, self.clone())
        } else {
            registry::separable(row, self.clone())
        }
    }

    fn is_linear(&self) -> bool {
        Curvature::is_linear(self)
    }
}
