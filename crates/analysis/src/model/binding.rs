//! The system of a model in the scalars that studies need, and methods bound to it.

use super::{DEGREES, Model, is_number_of_degrees};
use afterbay_core::{Abilities, Corrected, InputError, Series, System, f64x8};
use afterbay_methods::registry::{self, Row, Run};
use afterbay_systems::catalog::{self, Compensable, Expandable, Number, Ranges, SystemRow, TERMS};
use std::sync::Arc;

/// Eight runs of one method side by side.
pub struct Lanes {
    /// The method, bound to the systems.
    pub run: Run<f64x8>,
    /// The systems.
    pub system: Arc<dyn Abilities<f64x8>>,
}

impl Model {
    /// Binds a method to the system in `f64`, in the fastest form available.
    ///
    /// # Errors
    /// [`InputError::Parameter`], and [`InputError::Unsupported`] where the method does not apply.
    pub fn bind(&self, row: &Row) -> Result<Run<f64>, InputError> {
        let system = self.system()?;
        if !self.motors().is_empty() {
            return registry::bind(row, system);
        }
        afterbay_inlined::bind(row, &system).unwrap_or_else(|| registry::bind(row, system))
    }

    /// Binds a method to the system in a scalar.
    ///
    /// # Errors
    /// Those of [`Model::bind`].
    pub(crate) fn bind_in<T: Number + registry::Number>(
        &self,
        row: &Row,
    ) -> Result<Run<T>, InputError> {
        registry::bind(row, self.system::<T>()?)
    }

    /// Binds modDG or coordinate increments to the system in `f64` or lanes of it, with compensated
    /// roundings ([`registry::compensated`]).
    ///
    /// # Errors
    /// [`InputError::Parameter`], and [`InputError::Unsupported`] where the method does not apply.
    pub fn bind_compensated<T>(&self, row: &Row) -> Result<Run<T>, InputError>
    where
        T: Compensable + registry::Compensable,
    {
        let exact = match self {
            Self::Listed(row, values) => {
                let (n, values) = split(row, values)?;
                let values: Vec<_> =
                    values.iter().map(|&x| Corrected::exact(T::from_f64(x))).collect();
                T::corrected(row, n, &values)?
            }
            Self::Custom(custom) => T::custom_corrected(custom),
            Self::Driven(..) => None,
        };
        let why = "H is not separable or depends on the time, or the system has a drive";
        let exact = exact.ok_or(InputError::Unsupported { method: row.name, why })?;
        registry::compensated(row, self.system()?, exact)
    }

    /// Binds a method to eight systems side by side, which differ in the parameter `name`. Returns
    /// `None` where the system or the method does not run in lanes, or where these systems require
    /// different steps.
    ///
    /// # Errors
    /// [`InputError::Parameter`].
    pub fn bind_lanes(
        &self,
        row: &Row,
        name: &str,
        values: [f64; 8],
    ) -> Result<Option<Lanes>, InputError> {
        let lift = |parameter: &str, x| {
            if parameter == name { f64x8::from(values) } else { f64x8::splat(x) }
        };
        let system = self.lifted(&lift)?;
        if !row.has_lanes() || system.clone().separable().is_none() {
            return Ok(None);
        }
        let run = afterbay_inlined::bind_lanes(row, &system)
            .unwrap_or_else(|| registry::bind(row, system.clone()));
        match run {
            Ok(run) => Ok(Some(Lanes { run, system })),
            Err(InputError::Unsupported { .. }) => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// The system in a scalar, with its abilities.
    ///
    /// # Errors
    /// [`InputError::Parameter`] for a parameter out of range.
    pub fn system<T: Number>(&self) -> Result<Arc<dyn Abilities<T>>, InputError> {
        self.lifted(&|_, x| T::from_f64(x))
    }

    fn lifted<T: Number>(
        &self,
        lift: &dyn Fn(&str, f64) -> T,
    ) -> Result<Arc<dyn Abilities<T>>, InputError> {
        match self {
            Self::Listed(row, values) => {
                let (n, values) = split(row, values)?;
                let names =
                    row.parameters[row.parameters.len().saturating_sub(values.len())..].iter();
                let lifted: Vec<T> =
                    names.zip(values).map(|(name, &x)| lift(name.name, x)).collect();
                T::system(row, n, &lifted)
            }
            Self::Custom(custom) => Ok(T::custom(custom, lift)),
            Self::Driven(model, drive) => T::driven(model.lifted(lift)?, drive, lift),
        }
    }

    /// The system in Taylor series of a scalar, and in series of intervals.
    ///
    /// # Errors
    /// [`InputError::Parameter`] for a parameter out of range.
    pub(crate) fn expanded<T: Expandable>(&self) -> Result<Expanded<T>, InputError> {
        match self {
            Self::Listed(row, values) => {
                let (n, values) = split(row, values)?;
                let series: Vec<_> =
                    values.iter().map(|&x| Series::constant(T::from_f64(x))).collect();
                Ok((T::series(row, n, &series)?, catalog::ranges(row, n, values)?))
            }
            Self::Custom(custom) => Ok((T::custom_series(custom), catalog::custom_ranges(custom))),
            Self::Driven(model, drive) => {
                let (system, ranges) = model.expanded::<T>()?;
                Ok((T::driven_series(system, drive)?, catalog::driven_ranges(ranges, drive)?))
            }
        }
    }
}

/// A system in Taylor series of a scalar, and in series of intervals.
type Expanded<T> = (Arc<dyn System<Series<T, TERMS>>>, Arc<dyn System<Ranges>>);

/// The number of degrees of freedom and the other parameters.
///
/// # Errors
/// [`InputError::Parameter`] if the number is a parameter and not one of [`DEGREES`].
pub(super) fn split<'a>(
    row: &SystemRow,
    values: &'a [f64],
) -> Result<(usize, &'a [f64]), InputError> {
    if let Some(n) = row.dof {
        return Ok((n, values));
    }
    let (&n, rest) = values.split_first().unwrap_or((&0.0, values));
    if is_number_of_degrees(n) {
        Ok((n as usize, rest))
    } else {
        Err(InputError::Parameter { name: "n", value: n, range: DEGREES })
    }
}

/// Whether the equations of a system are linear, so that a step of a linear method is a matrix.
pub fn is_linear(system: &Arc<dyn Abilities<f64>>) -> bool {
    system.clone().second_derivatives().is_some_and(|system| system.is_constant())
}
