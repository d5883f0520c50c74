//! The scalars in which methods can be bound. The methods are compiled here, once per scalar,
//! rather than in the crates that use them.

use super::binding::Form;
use super::{Row, Run};
use crate::Composition;
use crate::increment::Increments;
use crate::moddg::ModDg;
use afterbay_core::{Abilities, Corrected, InputError, Lanewise, Quad, Scalar, Separable, f64x8};
use std::sync::Arc;

/// A scalar in which methods can be bound: `f64`, [`Quad`], and [`f64x8`] for methods with lanes.
pub trait Number: Scalar {
    /// Binds a method to a system; see [`bind`](super::bind).
    ///
    /// # Errors
    /// Those of [`bind`](super::bind).
    fn bind(row: &Row, system: &Arc<dyn Abilities<Self>>) -> Result<Run<Self>, InputError>;
}

impl Number for f64 {
    fn bind(row: &Row, system: &Arc<dyn Abilities<Self>>) -> Result<Run<Self>, InputError> {
        match row.form {
            Form::Fixed(method) => method.in_f64(&row.target(system)),
            Form::Adaptive(method) => method.bind(&row.target(system)),
        }
    }
}

impl Number for Quad {
    fn bind(row: &Row, system: &Arc<dyn Abilities<Self>>) -> Result<Run<Self>, InputError> {
        let target = row.target(system);
        match row.form {
            Form::Fixed(method) => method.in_quad(&target),
            Form::Adaptive(_) => Err(target.refused("it runs in f64 only")),
        }
    }
}

impl Number for f64x8 {
    fn bind(row: &Row, system: &Arc<dyn Abilities<Self>>) -> Result<Run<Self>, InputError> {
        let target = row.target(system);
        match row.form {
            Form::Fixed(method) => method.in_lanes(&target),
            Form::Adaptive(_) => Err(target.no_lanes()),
        }
    }
}

/// A scalar in which increments can be compensated: `f64` and lanes of it.
pub trait Compensable: Lanewise {
    /// Binds compensated increments; see [`compensated`].
    ///
    /// # Errors
    /// Those of [`compensated`].
    fn bind(
        row: &Row,
        system: &Arc<dyn Abilities<Self>>,
        exact: Arc<dyn Separable<Corrected<Self>>>,
    ) -> Result<Run<Self>, InputError>;
}

macro_rules! compensable {
    ($($scalar:ty),+) => {$(
        impl Compensable for $scalar {
            fn bind(
                row: &Row,
                system: &Arc<dyn Abilities<Self>>,
                exact: Arc<dyn Separable<Corrected<Self>>>,
            ) -> Result<Run<Self>, InputError> {
                in_colours(row, system, exact)
            }
        }
    )+};
}
compensable!(f64, f64x8);

fn in_colours<T: Lanewise>(
    row: &Row,
    system: &Arc<dyn Abilities<T>>,
    exact: Arc<dyn Separable<Corrected<T>>>,
) -> Result<Run<T>, InputError> {
    let target = row.target(system);
    // The scheme for one degree of freedom is a sweep over one coordinate.
    let sweep = Increments(Composition::sweep);
    match (row.method::<Increments>(), row.method::<ModDg>()) {
        (Some(increments), _) => increments.compensated(&target, exact),
        (None, Some(_)) if system.dof() == 1 => sweep.compensated(&target, exact),
        (None, Some(_)) => Err(target.refused("the scheme applies to one degree of freedom only")),
        (None, None) => {
            Err(target.refused("only moddg and coordinate increments can be compensated"))
        }
    }
}

/// Binds compensated coordinate increments
/// ([`Increment::compensated`](crate::Increment::compensated)) with coloured sweeps, and modDG as
/// one sweep over one coordinate, which is the same scheme. `exact` is the same system in
/// [`Corrected`] numbers. The registry has no rows for them, because a row is independent of the
/// scalar.
///
/// # Errors
/// [`InputError::Unsupported`] if the row is another method or the system is not separable,
/// [`InputError::Length`] if `exact` has another number of degrees of freedom.
pub fn compensated<T: Compensable>(
    row: &Row,
    system: Arc<dyn Abilities<T>>,
    exact: Arc<dyn Separable<Corrected<T>>>,
) -> Result<Run<T>, InputError> {
    T::bind(row, &system, exact)
}
