//! The scalars in which systems are made. Each form is compiled here, once per scalar, and not in
//! the crates that use it.

use super::{Family, SystemRow};
use crate::{CustomDrive, Described};
use afterbay_core::taylor::{self, Enclosed, Pace, Route};
use afterbay_core::{
    Abilities, Corrected, Drive, Driven, Grid, InputError, Interval, Lanewise, Quad, Scalar,
    Separable, Series, State, StateRef, System, Vector, f64x8,
};
use std::sync::Arc;

/// The number of terms of the series of a solution.
pub const TERMS: usize = 24;

/// Series of intervals that enclose the defect of a solution.
pub type Ranges = Series<Interval, TERMS>;

/// Makes a system of `n` degrees of freedom from its other parameters.
type Make<T, S> = fn(usize, &[T]) -> Result<Arc<S>, InputError>;
/// Makes a separable system; `None` where the system is not separable.
type MakeSeparable<T> = fn(usize, &[T]) -> Result<Option<Arc<dyn Separable<T>>>, InputError>;

/// A system in every scalar.
#[derive(Clone, Copy, Debug)]
pub(super) struct Forms {
    f64: Make<f64, dyn Abilities<f64>>,
    quad: Make<Quad, dyn Abilities<Quad>>,
    eight: Make<f64x8, dyn Abilities<f64x8>>,
    corrected: MakeSeparable<Corrected<f64>>,
    corrected_eight: MakeSeparable<Corrected<f64x8>>,
    series: Make<Series<f64, TERMS>, dyn System<Series<f64, TERMS>>>,
    series_quad: Make<Series<Quad, TERMS>, dyn System<Series<Quad, TERMS>>>,
    ranges: Make<Ranges, dyn System<Ranges>>,
}

fn asked<F: Family, T: Scalar>(
    n: usize,
    parameters: &[T],
) -> Result<Arc<dyn Abilities<T>>, InputError> {
    Ok(Arc::new(F::make(n, parameters)?))
}

fn separable<F: Family, T: Scalar>(
    n: usize,
    parameters: &[T],
) -> Result<Option<Arc<dyn Separable<T>>>, InputError> {
    Ok(Arc::new(F::make(n, parameters)?).separable())
}

fn field<F: Family, T: Scalar>(
    n: usize,
    parameters: &[T],
) -> Result<Arc<dyn System<T>>, InputError> {
    Ok(Arc::new(F::make(n, parameters)?))
}

impl Forms {
    pub(super) const fn of<F: Family>() -> Self {
        Self {
            f64: asked::<F, _>,
            quad: asked::<F, _>,
            eight: asked::<F, _>,
            corrected: separable::<F, _>,
            corrected_eight: separable::<F, _>,
            series: field::<F, _>,
            series_quad: field::<F, _>,
            ranges: field::<F, _>,
        }
    }
}

/// Lifts a parameter, by its name and value, into a scalar.
type Lift<'a, T> = &'a dyn Fn(&str, f64) -> T;

/// A scalar in which methods run. Systems are made in it with their abilities.
pub trait Number: Scalar {
    /// The system of a row.
    ///
    /// # Errors
    /// Those of [`Family::make`].
    fn system(
        row: &SystemRow,
        n: usize,
        parameters: &[Self],
    ) -> Result<Arc<dyn Abilities<Self>>, InputError>;

    /// A system given by expressions.
    fn custom(system: &Described, lift: Lift<'_, Self>) -> Arc<dyn Abilities<Self>>;

    /// A system with a drive.
    ///
    /// # Errors
    /// Those of [`Driven::new`].
    fn driven(
        system: Arc<dyn Abilities<Self>>,
        drive: &CustomDrive<f64>,
        lift: Lift<'_, Self>,
    ) -> Result<Arc<dyn Abilities<Self>>, InputError>;
}

fn lifted<T: Scalar>(system: &Described, lift: Lift<'_, T>) -> Arc<dyn Abilities<T>> {
    match system {
        Described::Separable(system) => Arc::new(system.lift(lift)),
        Described::Clocked(system) => Arc::new(system.map(|system| system.lift(lift))),
        Described::General(system) => Arc::new(system.lift(lift)),
    }
}

macro_rules! numbers {
    ($($scalar:ty, $form:ident;)+) => {$(
        impl Number for $scalar {
            fn system(
                row: &SystemRow,
                n: usize,
                x: &[Self],
            ) -> Result<Arc<dyn Abilities<Self>>, InputError> {
                (row.forms.$form)(n, x)
            }
            fn custom(system: &Described, lift: Lift<'_, Self>) -> Arc<dyn Abilities<Self>> {
                lifted(system, lift)
            }
            fn driven(
                system: Arc<dyn Abilities<Self>>,
                drive: &CustomDrive<f64>,
                lift: Lift<'_, Self>,
            ) -> Result<Arc<dyn Abilities<Self>>, InputError> {
                let drive: Arc<dyn Drive<Self>> = Arc::new(drive.lift(lift));
                Ok(Arc::new(Driven::new(system, drive)?))
            }
        }
    )+};
}
numbers! {
    f64, f64;
    Quad, quad;
    f64x8, eight;
}

/// A scalar for compensated increments. Separable systems are made in [`Corrected`] numbers of it.
pub trait Compensable: Number + Lanewise {
    /// The system of a row; `None` where it is not separable.
    ///
    /// # Errors
    /// Those of [`Family::make`].
    fn corrected(row: &SystemRow, n: usize, x: &[Corrected<Self>]) -> Made<Corrected<Self>>;

    /// A system given by expressions; `None` where it is not separable.
    fn custom_corrected(system: &Described) -> Option<Arc<dyn Separable<Corrected<Self>>>>;
}

/// The system if it is separable.
type Made<T> = Result<Option<Arc<dyn Separable<T>>>, InputError>;

fn exact<T: Lanewise>(system: &Described) -> Option<Arc<dyn Separable<Corrected<T>>>> {
    match system {
        Described::Separable(system) => {
            Some(Arc::new(system.map(|x| Corrected::exact(T::from_f64(x)))))
        }
        Described::Clocked(_) | Described::General(_) => None,
    }
}

macro_rules! compensable {
    ($($scalar:ty, $form:ident;)+) => {$(
        impl Compensable for $scalar {
            fn corrected(
                row: &SystemRow,
                n: usize,
                x: &[Corrected<Self>],
            ) -> Made<Corrected<Self>> {
                (row.forms.$form)(n, x)
            }
            fn custom_corrected(system: &Described) -> Option<Arc<dyn Separable<Corrected<Self>>>> {
                exact(system)
            }
        }
    )+};
}
compensable! {
    f64, corrected;
    f64x8, corrected_eight;
}

/// A system in series of a scalar.
type Field<T> = Arc<dyn System<Series<T, TERMS>>>;

/// A scalar in which solutions are expanded. Systems are made in series of it.
pub trait Expandable: Number {
    /// The system of a row.
    ///
    /// # Errors
    /// Those of [`Family::make`].
    fn series(
        row: &SystemRow,
        n: usize,
        parameters: &[Series<Self, TERMS>],
    ) -> Result<Field<Self>, InputError>;

    /// A system given by expressions.
    fn custom_series(system: &Described) -> Field<Self>;

    /// A system with a drive, in power series.
    ///
    /// # Errors
    /// Those of [`Driven::new`].
    fn driven_series(
        system: Field<Self>,
        drive: &CustomDrive<f64>,
    ) -> Result<Field<Self>, InputError>;

    /// The flow of a system from `start` at the times `i h`, i = 0..=count, with its defect
    /// enclosed. See [`taylor::follow`].
    ///
    /// # Errors
    /// Those of [`taylor::follow`].
    fn follow(
        system: (&dyn System<Series<Self, TERMS>>, &Enclosure),
        start: &State<Vec<Self>>,
        times: (Self, usize),
        pace: Pace,
        stop: &dyn Fn() -> bool,
        see: &mut dyn FnMut(StateRef<'_, Self>),
    ) -> Result<Route, InputError>;
}

/// The defect of a solution, enclosed by its system in series of intervals.
pub type Enclosure = Enclosed<Arc<dyn System<Ranges>>>;

/// [`Expandable::follow`] with states stored in `V`.
fn follow<V: Vector>(
    (system, defect): (&dyn System<Series<V::Scalar, TERMS>>, &Enclosure),
    start: &State<Vec<V::Scalar>>,
    times: (V::Scalar, usize),
    pace: Pace,
    stop: &dyn Fn() -> bool,
    see: &mut dyn FnMut(StateRef<'_, V::Scalar>),
) -> Result<Route, InputError> {
    start.check_with(system.dof(), || system.motors())?;
    let copy = |part: &[V::Scalar]| V::filled(part, |x| x);
    let start = State { q: copy(&start.q), p: copy(&start.p), w: copy(&start.w), t: start.t };
    let see = &mut |_, state: State<V>| see(state.state_ref());
    let grid = Grid { h: times.0, steps: times.1 as u64 };
    taylor::follow(system, defect, &start, grid, pace, stop, see)
}

/// A system given by expressions, in the scalar of its constants.
fn with_constants<T: Scalar>(
    system: &Described,
    constant: impl Fn(f64) -> T + Copy,
) -> Arc<dyn System<T>> {
    match system {
        Described::Separable(system) => Arc::new(system.map(constant)),
        Described::Clocked(system) => Arc::new(system.map(|system| system.map(constant))),
        Described::General(system) => Arc::new(system.map(constant)),
    }
}

fn driven<T: Scalar>(
    system: Arc<dyn System<T>>,
    drive: &CustomDrive<f64>,
    constant: impl Fn(f64) -> T,
) -> Result<Arc<dyn System<T>>, InputError> {
    let drive: Arc<dyn Drive<T>> = Arc::new(drive.lift(|_, x| constant(x)));
    Ok(Arc::new(Driven::new(system, drive)?))
}

macro_rules! expandable {
    ($($scalar:ty, $form:ident;)+) => {$(
        impl Expandable for $scalar {
            fn series(
                row: &SystemRow,
                n: usize,
                x: &[Series<Self, TERMS>],
            ) -> Result<Field<Self>, InputError> {
                (row.forms.$form)(n, x)
            }
            fn custom_series(system: &Described) -> Field<Self> {
                with_constants(system, |x| Series::constant(Self::from_f64(x)))
            }
            fn driven_series(
                system: Field<Self>,
                drive: &CustomDrive<f64>,
            ) -> Result<Field<Self>, InputError> {
                driven(system, drive, |x| Series::constant(Self::from_f64(x)))
            }
            fn follow(
                system: (&dyn System<Series<Self, TERMS>>, &Enclosure),
                start: &State<Vec<Self>>,
                times: (Self, usize),
                pace: Pace,
                stop: &dyn Fn() -> bool,
                see: &mut dyn FnMut(StateRef<'_, Self>),
            ) -> Result<Route, InputError> {
                match system.0.dof() {
                    1 => follow::<[Self; 1]>(system, start, times, pace, stop, see),
                    _ => follow::<Vec<Self>>(system, start, times, pace, stop, see),
                }
            }
        }
    )+};
}
expandable! {
    f64, series;
    Quad, series_quad;
}

/// The system of a row in series of intervals.
///
/// # Errors
/// Those of [`Family::make`].
pub fn ranges(
    row: &SystemRow,
    n: usize,
    parameters: &[f64],
) -> Result<Arc<dyn System<Ranges>>, InputError> {
    let parameters: Vec<_> =
        parameters.iter().map(|&x| Series::constant(Interval::from_f64(x))).collect();
    (row.forms.ranges)(n, &parameters)
}

/// A system given by expressions, in series of intervals.
pub fn custom_ranges(system: &Described) -> Arc<dyn System<Ranges>> {
    with_constants(system, |x| Series::constant(Interval::from_f64(x)))
}

/// A system with a drive, in series of intervals.
///
/// # Errors
/// Those of [`Driven::new`].
pub fn driven_ranges(
    system: Arc<dyn System<Ranges>>,
    drive: &CustomDrive<f64>,
) -> Result<Arc<dyn System<Ranges>>, InputError> {
    driven(system, drive, |x| Series::constant(Interval::from_f64(x)))
}
