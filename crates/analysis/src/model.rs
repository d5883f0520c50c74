//! A system by name, with its parameters.

mod binding;
mod periods;
mod serialize;

use afterbay_core::{Drive, InputError, Motors, Passive};
use afterbay_systems::Parameter;
use afterbay_systems::catalog::SystemRow;
use afterbay_systems::{CustomDrive, CustomError, Described, whole_multiples};
use thiserror::Error;

pub use binding::Lanes;
pub use binding::is_linear;
use binding::split;

/// The most degrees of freedom of a built-in system. A choice: its equations take some 2 kilobytes
/// each.
const MOST_DEGREES: f64 = 1e6;
/// The range of their number, in words.
const DEGREES: &str = "a whole number from 1 to 1e6";

/// A system and its parameters.
#[derive(Clone, Debug)]
pub enum Model {
    /// A row of the catalogue, with a value for each parameter in its order.
    Listed(&'static SystemRow, Vec<f64>),
    /// A system given by expressions.
    Custom(Described),
    /// A system with a drive. Its motors ([`afterbay_core::Driven`]) are the last degrees of
    /// freedom, after the clock of a custom system that has one.
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
    /// A number of degrees of freedom that is not whole, is 0, or is too large.
    #[error("parameter {name} = {value:?} must be {DEGREES}")]
    Whole {
        /// Its name.
        name: String,
        /// The value given.
        value: f64,
    },
    /// A parameter that has no value.
    #[error("parameter {name} has no value")]
    Missing {
        /// Its name.
        name: String,
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

impl Model {
    /// A system of the catalogue, with its parameters in their order. [`Model::system`] checks
    /// their number and ranges.
    pub fn of(row: &'static SystemRow, parameters: &[f64]) -> Self {
        Self::Listed(row, parameters.to_vec())
    }

    /// A system of the catalogue with a value for each parameter, by name.
    ///
    /// # Errors
    /// [`ModelError`]. [`Model::system`] checks the ranges.
    pub fn named<'a>(
        row: &'static SystemRow,
        values: impl IntoIterator<Item = (&'a str, f64)>,
    ) -> Result<Self, ModelError> {
        let mut found = vec![None; row.parameters.len()];
        for (name, value) in values {
            found[place(row, name, value)?] = Some(value);
        }
        let value = |(parameter, value): (&Parameter, Option<f64>)| {
            value.ok_or_else(|| ModelError::Missing { name: parameter.name.into() })
        };
        let values = row.parameters.iter().zip(found).map(value).collect::<Result<_, _>>()?;
        Ok(Self::Listed(row, values))
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

    /// The number of degrees of freedom without clock and motors; 0 where the parameter that sets
    /// it is out of range, with which there is no system.
    pub fn degrees(&self) -> usize {
        self.checked_degrees().unwrap_or(0)
    }

    /// The number of degrees of freedom without clock and motors.
    ///
    /// # Errors
    /// [`InputError::Parameter`] where the parameter that sets it is out of range.
    pub(crate) fn checked_degrees(&self) -> Result<usize, InputError> {
        match self {
            Self::Listed(row, values) => Ok(split(row, values)?.0),
            Self::Custom(custom) => Ok(custom.dof()),
            Self::Driven(model, _) => model.checked_degrees(),
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

    /// Whether the equations do not depend on the time.
    pub fn is_autonomous(&self) -> bool {
        self.motors().count() == 0
    }

    /// The clock and the motors, which are the last degrees of freedom.
    pub fn motors(&self) -> Motors {
        Motors { has_clock: self.has_clock(), driven: self.driven().to_vec() }
    }

    /// The letters of the variables: q, p and w, and s where there is a drive.
    pub fn variables(&self) -> &'static [&'static str] {
        if self.driven().is_empty() { &["q", "p", "w"] } else { &["q", "p", "w", "s"] }
    }

    /// The passivity of D: whether the reservoirs can only gain energy, apart from the work of a
    /// drive.
    ///
    /// # Errors
    /// Those of [`Model::system`].
    pub fn passive(&self) -> Result<Passive, InputError> {
        match self {
            Self::Driven(model, _) => model.passive(),
            _ => Ok(self.system::<f64>()?.dissipation_form().passive),
        }
    }

    /// The period P_j of each coordinate for which V, D and the forces of a drive are periodic;
    /// `None` for the other coordinates. See [`afterbay_systems::Custom::periods`].
    pub fn periods(&self) -> Vec<Option<f64>> {
        match self {
            Self::Listed(row, _) => vec![row.period; self.degrees()],
            Self::Custom(custom) => custom.periods(),
            Self::Driven(model, drive) => periods::under(drive, &model.periods()),
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

    /// This model with another value of a parameter.
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
        let (index, mut values) = (place(row, name, value)?, values.clone());
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
}

/// The place of a parameter that is to have a value.
fn place(row: &SystemRow, name: &str, value: f64) -> Result<usize, ModelError> {
    let index = row.parameters.iter().position(|parameter| parameter.name == name);
    let index = index.ok_or_else(|| ModelError::NoParameter { name: name.into() })?;
    if row.is_count(index) && !is_number_of_degrees(value) {
        return Err(ModelError::Whole { name: name.into(), value });
    }
    Ok(index)
}

/// Whether a system can have so many degrees of freedom.
fn is_number_of_degrees(value: f64) -> bool {
    value.fract() == 0.0 && (1.0..=MOST_DEGREES).contains(&value)
}

/// The shortest multiple of the longer of two periods that is one of the other too.
fn common_period(a: f64, b: f64) -> Option<f64> {
    /// The largest deviation of the ratio from one of whole numbers. It covers periods given with
    /// ten digits.
    const RATIO_TOLERANCE: f64 = 1e-9;
    let [times, _] = whole_multiples(a.max(b) / a.min(b), RATIO_TOLERANCE)?;
    Some(times * a.max(b))
}

#[cfg(test)]
mod tests {
    use super::{Model, ModelError, common_period};
    use afterbay_core::InputError;
    use afterbay_systems::catalog::{FPUT_CHAIN, VAN_DER_POL};

    #[test]
    fn a_number_of_degrees_that_is_not_whole_is_named_as_it_was_given() {
        for n in [0.0, -1.0, 2.7, 1e30, f64::NAN] {
            let model = Model::of(&FPUT_CHAIN, &[n, 1.0, 0.1]);
            let error = model.system::<f64>().map(drop).expect_err("no system");
            assert!(
                matches!(error, InputError::Parameter { name: "n", value, .. }
                    if value.to_bits() == n.to_bits()),
                "{error}"
            );
            assert!(model.periods().is_empty());
        }
        let chain = Model::of(&FPUT_CHAIN, &[2.0, 1.0, 0.1]);
        let error = chain.with("n", 0.0).expect_err("no system").to_string();
        assert_eq!(error, "parameter n = 0.0 must be a whole number from 1 to 1e6");
    }

    #[test]
    fn a_parameter_that_is_not_named_is_missing() {
        let missing = |name: &str| ModelError::Missing { name: name.into() };
        assert_eq!(Model::named(&VAN_DER_POL, []).unwrap_err(), missing("mu"));
        let chain = Model::named(&FPUT_CHAIN, [("n", 2.0), ("c", 0.1)]);
        assert_eq!(chain.unwrap_err(), missing("beta"));
    }

    #[test]
    fn a_common_period_is_a_multiple_of_both() {
        assert_eq!(common_period(3.0, 1.0), Some(3.0));
        assert_eq!(common_period(1.0, 1.5), Some(3.0));
        assert_eq!(common_period(2.0 / 3.0, 1.0), Some(2.0));
        assert_eq!(common_period(1.0, 2.0_f64.sqrt()), None);
        assert_eq!(common_period(1.0, 1.0 + 1.0 / 29.0), None);
    }
}
