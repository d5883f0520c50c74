//! A system by name, with its parameters.

use afterbay_core::{
    Abilities, Corrected, Drive, Driven, InputError, Interval, Motors, Passive, Scalar, Series,
    System, f64x8,
};
use afterbay_methods::registry::{self, Row, Run};
use afterbay_systems::catalog::{self, Compensable, Expandable, Number, Ranges, SystemRow, TERMS};
use afterbay_systems::{CustomDrive, CustomError, Described};
use serde::ser::{SerializeMap, SerializeStruct};
use serde::{Serialize, Serializer};
use std::sync::Arc;
use thiserror::Error;

/// A system and its parameters.
#[derive(Clone, Debug)]
pub enum Model {
    /// A row of the catalogue, with a value for each parameter in its order.
    Listed(&'static SystemRow, Vec<f64>),
    /// A system given by expressions.
    Custom(Described),
    /// A system with a drive. Its motors ([`Driven`]) are the last degrees of freedom, behind the
    /// clock of a custom system that has one.
    Driven(Box<Model>, CustomDrive<f64>),
}

/// An error in making a system.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ModelError {
    /// A parameter that the system does not have.
    #[error("there is no parameter {name}")]
    NoParameter {
        /// The name asked for.
        name: String,
    },
    /// A number of degrees of freedom that is not whole.
    #[error("parameter {name} = {value:?} must be a whole number")]
    Whole {
        /// Its name.
        name: String,
        /// The value given.
        value: f64,
    },
    /// A number of degrees of freedom that the forces of a drive do not have.
    #[error("{name} changes the number of degrees of freedom, for which the drive has its forces")]
    Drive {
        /// The name of the parameter.
        name: String,
    },
    /// A custom system that is not valid with this value.
    #[error(transparent)]
    Custom(#[from] CustomError),
}

/// Eight runs of one method side by side.
pub struct Lanes {
    /// The method, bound to the systems.
    pub run: Run<f64x8>,
    /// The systems.
    pub system: Arc<dyn Abilities<f64x8>>,
}

impl Model {
    /// A system of the catalogue, with its parameters in their order. [`Model::system`] checks
    /// their number and ranges.
    pub fn of(row: &'static SystemRow, parameters: &[f64]) -> Self {
        Self::Listed(row, parameters.to_vec())
    }

    /// A system of the catalogue with parameters by name. Parameters that are not named are 0.
    ///
    /// # Errors
    /// [`ModelError`]. [`Model::system`] checks the ranges.
    pub fn named<'a>(
        row: &'static SystemRow,
        values: impl IntoIterator<Item = (&'a str, f64)>,
    ) -> Result<Self, ModelError> {
        let empty = Self::Listed(row, vec![0.0; row.parameters.len()]);
        values.into_iter().try_fold(empty, |model, (name, value)| model.with(name, value))
    }

    /// The name in scenes and tables.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Listed(row, _) => row.name,
            Self::Custom(_) => "custom",
            Self::Driven(model, _) => model.name(),
        }
    }

    /// The number of degrees of freedom, the clock and motors included.
    pub fn dof(&self) -> usize {
        self.degrees() + self.motors().count()
    }

    /// The number of degrees of freedom without clock and motors.
    pub fn degrees(&self) -> usize {
        match self {
            Self::Listed(row, values) => row.dof.unwrap_or(first(values).0),
            Self::Custom(custom) => custom.dof(),
            Self::Driven(model, _) => model.degrees(),
        }
    }

    /// The driven degrees of freedom, in the order of their motors.
    pub fn driven(&self) -> &[usize] {
        match self {
            Self::Listed(..) | Self::Custom(_) => &[],
            Self::Driven(_, drive) => Drive::<f64>::driven(drive),
        }
    }

    /// Whether V or D depends on the time.
    pub fn has_clock(&self) -> bool {
        match self {
            Self::Listed(..) => false,
            Self::Custom(custom) => custom.has_clock(),
            Self::Driven(model, _) => model.has_clock(),
        }
    }

    /// The clock and the motors, which are the last degrees of freedom.
    pub fn motors(&self) -> Motors {
        Motors { has_clock: self.has_clock(), driven: self.driven().to_vec() }
    }

    /// The letters of the variables: q, p and w, and s where there is a drive.
    pub fn variables(&self) -> &'static [&'static str] {
        if self.driven().is_empty() { &["q", "p", "w"] } else { &["q", "p", "w", "s"] }
    }

    /// Whether the reservoir can only fill, apart from the work of a drive.
    ///
    /// # Errors
    /// As for [`Model::system`].
    pub(crate) fn passive(&self) -> Result<Passive, InputError> {
        match self {
            Self::Driven(model, _) => model.passive(),
            _ => Ok(self.system::<f64>()?.dissipation_form().passive),
        }
    }

    /// The period P_j of each coordinate for which V and D are periodic; `None` for the other
    /// coordinates. See [`afterbay_systems::Custom::periods`].
    pub fn periods(&self) -> Vec<Option<f64>> {
        match self {
            Self::Listed(row, _) => vec![row.period; self.degrees()],
            Self::Custom(custom) => custom.periods(),
            Self::Driven(model, _) => model.periods(),
        }
    }

    /// A period in t of everything that depends on it: of the forces ([`CustomDrive::period`])
    /// of a drive, and of V and D ([`Described::period_in_time`]) where they depend on t.
    pub fn drive_period(&self) -> Option<f64> {
        match self {
            Self::Listed(..) => None,
            Self::Custom(custom) => custom.period_in_time(),
            Self::Driven(model, drive) if model.has_clock() => {
                common_period(model.drive_period()?, drive.period()?)
            }
            Self::Driven(_, drive) => drive.period(),
        }
    }

    /// The names of the parameters.
    pub fn parameters(&self) -> Vec<&str> {
        match self {
            Self::Listed(row, _) => row.parameters.iter().map(|parameter| parameter.name).collect(),
            Self::Custom(custom) => custom.parameters().into_iter().map(|x| x.0).collect(),
            Self::Driven(model, drive) => {
                let mut names = model.parameters();
                let own: Vec<_> =
                    drive.parameters().map(|x| x.0).filter(|name| !names.contains(name)).collect();
                names.extend(own);
                names
            }
        }
    }

    /// The names and values of the parameters.
    pub fn values(&self) -> Vec<(String, f64)> {
        match self {
            Self::Listed(row, values) => {
                let names = row.parameters.iter().map(|parameter| parameter.name.to_owned());
                names.zip(values.iter().copied()).collect()
            }
            Self::Custom(custom) => {
                custom.parameters().into_iter().map(|(name, x)| (name.to_owned(), x)).collect()
            }
            Self::Driven(model, drive) => {
                let mut values = model.values();
                let known: Vec<String> = values.iter().map(|x| x.0.clone()).collect();
                let own = drive.parameters().map(|(name, x)| (name.to_owned(), x));
                values.extend(own.filter(|(name, _)| !known.contains(name)));
                values
            }
        }
    }

    /// The same model with another value of a parameter.
    ///
    /// # Errors
    /// [`ModelError::NoParameter`], [`ModelError::Whole`] for n, and [`ModelError::Custom`] where a
    /// custom system is not valid with the value.
    pub fn with(&self, name: &str, value: f64) -> Result<Self, ModelError> {
        let (row, values) = match self {
            Self::Custom(custom) => return Ok(Self::Custom(custom.with(name, value)?)),
            Self::Driven(model, drive) => return model.driven_with(drive, name, value),
            Self::Listed(row, values) => (row, values),
        };
        let index = row.parameters.iter().position(|parameter| parameter.name == name);
        let index = index.ok_or_else(|| ModelError::NoParameter { name: name.into() })?;
        if row.is_count(index) && !(value.fract() == 0.0 && (0.0..=1e9).contains(&value)) {
            return Err(ModelError::Whole { name: name.into(), value });
        }
        let mut values = values.clone();
        if let Some(old) = values.get_mut(index) {
            *old = value;
        }
        Ok(Self::Listed(row, values))
    }

    /// This model under a drive, with another value of a parameter of either.
    fn driven_with(
        &self,
        drive: &CustomDrive<f64>,
        name: &str,
        value: f64,
    ) -> Result<Self, ModelError> {
        let of_system = self.parameters().contains(&name);
        let model = if of_system { self.with(name, value)? } else { self.clone() };
        if model.degrees() != self.degrees() {
            return Err(ModelError::Drive { name: name.into() });
        }
        let of_drive = drive.parameters().any(|x| x.0 == name);
        let drive = if of_drive || !of_system {
            drive.with(name, value, self.degrees())?
        } else {
            drive.clone()
        };
        Ok(Self::Driven(Box::new(model), drive))
    }

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
    /// As for [`Model::bind`].
    pub fn bind_in<T: Number + registry::Number>(&self, row: &Row) -> Result<Run<T>, InputError> {
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
                let (n, values) = split(row, values);
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
    /// `None` where the system or the method does not run in lanes.
    ///
    /// # Errors
    /// [`InputError::Parameter`], and [`InputError::Unsupported`] where the method does not apply.
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
        let run = registry::bind(row, system.clone())?;
        Ok(Some(Lanes { run, system }))
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
                let (n, values) = split(row, values);
                let names =
                    row.parameters[row.parameters.len().saturating_sub(values.len())..].iter();
                let lifted: Vec<T> =
                    names.zip(values).map(|(name, &x)| lift(name.name, x)).collect();
                T::system(row, n, &lifted)
            }
            Self::Custom(custom) => Ok(T::custom(custom, lift)),
            Self::Driven(model, drive) => {
                let drive: Arc<dyn Drive<T>> = Arc::new(drive.lift(lift));
                Ok(Arc::new(Driven::new(model.lifted(lift)?, drive)?))
            }
        }
    }

    /// The system in Taylor series of a scalar, and in series of intervals.
    ///
    /// # Errors
    /// [`InputError::Parameter`] for a parameter out of range.
    pub(crate) fn expanded<T: Expandable>(&self) -> Result<Expanded<T>, InputError> {
        match self {
            Self::Listed(row, values) => {
                let (n, values) = split(row, values);
                let series: Vec<_> =
                    values.iter().map(|&x| Series::constant(T::from_f64(x))).collect();
                Ok((T::series(row, n, &series)?, catalog::ranges(row, n, values)?))
            }
            Self::Custom(custom) => Ok((T::custom_series(custom), catalog::custom_ranges(custom))),
            Self::Driven(model, drive) => {
                let (system, ranges) = model.expanded::<T>()?;
                let of_series: Arc<dyn Drive<Series<T, TERMS>>> =
                    Arc::new(drive.lift(|_, x| Series::constant(T::from_f64(x))));
                let of_ranges: Arc<dyn Drive<Ranges>> =
                    Arc::new(drive.lift(|_, x| Series::constant(Interval::from_f64(x))));
                Ok((
                    Arc::new(Driven::new(system, of_series)?),
                    Arc::new(Driven::new(ranges, of_ranges)?),
                ))
            }
        }
    }
}

/// A system in Taylor series of a scalar, and in series of intervals.
type Expanded<T> = (Arc<dyn System<Series<T, TERMS>>>, Arc<dyn System<Ranges>>);

/// The longer of two periods, if it is a multiple of the other.
fn common_period(a: f64, b: f64) -> Option<f64> {
    /// The largest deviation of the ratio from a whole number. It covers periods given with ten
    /// digits.
    const WHOLE_RATIO_TOLERANCE: f64 = 1e-9;
    let (long, ratio) = (a.max(b), a.max(b) / a.min(b));
    ((ratio - ratio.round()).abs() <= WHOLE_RATIO_TOLERANCE * ratio).then_some(long)
}

/// The number of degrees of freedom, which is the first parameter, and the other parameters.
fn first(values: &[f64]) -> (usize, &[f64]) {
    values.split_first().map_or((0, values), |(&n, rest)| (n as usize, rest))
}

/// The number of degrees of freedom and the other parameters.
fn split<'a>(row: &SystemRow, values: &'a [f64]) -> (usize, &'a [f64]) {
    row.dof.map_or_else(|| first(values), |n| (n, values))
}

/// Whether the equations of a system are linear, so that a step of a linear method is a matrix.
pub(crate) fn is_linear(system: &Arc<dyn Abilities<f64>>) -> bool {
    system.clone().second_derivatives().is_some_and(|system| system.is_constant())
}

/// Serializes the name and the parameters. The expressions of a custom system are part of the
/// scene.
impl Serialize for Model {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut model = serializer.serialize_struct("Model", 2)?;
        model.serialize_field("name", self.name())?;
        model.serialize_field("parameters", &Parameters(self))?;
        model.end()
    }
}

struct Parameters<'a>(&'a Model);

impl Serialize for Parameters<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.0 {
            Model::Listed(row, values) => {
                let mut map = serializer.serialize_map(Some(values.len()))?;
                for (i, (parameter, &value)) in row.parameters.iter().zip(values).enumerate() {
                    if row.is_count(i) {
                        map.serialize_entry(parameter.name, &(value as u64))?;
                    } else {
                        map.serialize_entry(parameter.name, &value)?;
                    }
                }
                map.end()
            }
            Model::Custom(custom) => serializer.collect_map(custom.parameters()),
            Model::Driven(model, _) => Parameters(model).serialize(serializer),
        }
    }
}
