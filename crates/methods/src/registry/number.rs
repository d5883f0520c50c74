//! The scalars methods are bound in. What is bound is compiled here, once a scalar, and not in the
//! crates that ask for it.

use super::{Row, Run, forms};
use afterbay_core::{
    Abilities, Corrected, InputError, Lanewise, Quad, Scalar, Separable, f64x4, f64x8,
};
use std::sync::Arc;

/// A scalar methods are bound in: `f64`, [`Quad`], and [`f64x8`] for those that run side by side.
pub trait Number: Scalar {
    /// [`bind`](super::bind)
    ///
    /// # Errors
    /// Those of [`bind`](super::bind).
    fn bind(row: &Row, system: &Arc<dyn Abilities<Self>>) -> Result<Run<Self>, InputError>;
}

impl Number for f64 {
    fn bind(row: &Row, system: &Arc<dyn Abilities<Self>>) -> Result<Run<Self>, InputError> {
        forms::in_f64(row, system)
    }
}

impl Number for Quad {
    fn bind(row: &Row, system: &Arc<dyn Abilities<Self>>) -> Result<Run<Self>, InputError> {
        if system.dof() == 1 {
            forms::of_any::<[Self; 1]>(row, system)
        } else {
            forms::of_any::<Vec<Self>>(row, system)
        }
    }
}

impl Number for f64x8 {
    fn bind(row: &Row, system: &Arc<dyn Abilities<Self>>) -> Result<Run<Self>, InputError> {
        forms::in_lanes(row, system)
    }
}

/// A scalar increments are compensated in: `f64` and lanes of it.
pub trait Compensable: Lanewise {
    /// [`compensated`]
    ///
    /// # Errors
    /// Those of [`compensated`].
    fn bind(
        row: &Row,
        system: &Arc<dyn Abilities<Self>>,
        exact: Arc<dyn Separable<Corrected<Self>>>,
    ) -> Result<Run<Self>, InputError>;
}

impl Compensable for f64 {
    fn bind(
        row: &Row,
        system: &Arc<dyn Abilities<Self>>,
        exact: Arc<dyn Separable<Corrected<Self>>>,
    ) -> Result<Run<Self>, InputError> {
        forms::compensated(row, system, exact)
    }
}

impl Compensable for f64x4 {
    fn bind(
        row: &Row,
        system: &Arc<dyn Abilities<Self>>,
        exact: Arc<dyn Separable<Corrected<Self>>>,
    ) -> Result<Run<Self>, InputError> {
        forms::compensated(row, system, exact)
    }
}

impl Compensable for f64x8 {
    fn bind(
        row: &Row,
        system: &Arc<dyn Abilities<Self>>,
        exact: Arc<dyn Separable<Corrected<Self>>>,
    ) -> Result<Run<Self>, InputError> {
        forms::compensated(row, system, exact)
    }
}

/// Binds coordinate increments whose roundings do not add up
/// ([`Increment::compensated`](crate::Increment::compensated)), colour by colour, to a system and
/// the same in [`Corrected`] numbers. A row knows no scalar, so these are no rows of their own.
///
/// # Errors
/// [`InputError::Unsupported`] where it is another method or the system is not separable,
/// [`InputError::Length`] where `exact` is another system.
pub fn compensated<T: Compensable>(
    row: &Row,
    system: Arc<dyn Abilities<T>>,
    exact: Arc<dyn Separable<Corrected<T>>>,
) -> Result<Run<T>, InputError> {
    T::bind(row, &system, exact)
}
