//! A system as the studies see it: with a solution to compare to and methods to run.

use crate::Solution;
use crate::progress::Progress;
use afterbay_core::{
    Curvature, ExactFlow, InputError, IntegrateError, Scalar, Series, State, System, Vector, taylor,
};
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
            let mut state = start.clone();
            self.flow(T::from_f64(i as f64) * h, &mut state);
            state.check(1).map_err(|_| InputError::SolutionEnds { t: state.t.to_f64() })?;
            solution.push(state.view());
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

/// Terms of the Taylor series that stand in for an exact solution.
const TERMS: usize = 24;

/// The solution by series, its states stored in `V` on the way.
fn by_series<V, S>(
    system: &S,
    start: &State<Vec<V::Scalar>>,
    h: V::Scalar,
    count: usize,
    progress: &dyn Progress,
) -> Result<Solution<V::Scalar>, IntegrateError>
where
    V: Vector,
    S: System<Series<V::Scalar, TERMS>>,
{
    let start = stored::<V>(start, system.dof())?;
    if progress.stopped() {
        return Err(IntegrateError::Interrupted);
    }
    let states = taylor::trajectory(system, &start, h, count)?;
    let mut solution = Solution::with_room(system.dof(), states.len());
    states.iter().for_each(|state| solution.push(state.view()));
    Ok(solution)
}

/// The same state in another storage.
fn stored<V: Vector>(state: &State<Vec<V::Scalar>>, dof: usize) -> Result<State<V>, InputError> {
    state.check(dof)?;
    let copy = |part: &Vec<V::Scalar>| V::filled(part, |x| x);
    Ok(State { q: copy(&state.q), p: copy(&state.p), w: copy(&state.w), t: state.t })
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
                by_series::<[T; 1], _>(&self.map(Series::constant), start, h, count, progress)
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
                by_series::<Vec<T>, _>(&self.map(Series::constant), start, h, count, progress)
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
        by_series::<Vec<T>, _>(&self.map(Series::constant), start, h, count, progress)
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
