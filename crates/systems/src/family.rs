//! The trait of the systems in the catalogue: name, equations, parameters and constructor.

use afterbay_core::{Abilities, InputError, Scalar};

/// A system in every scalar, with its description. It is implemented for the system in `f64`.
pub trait Family: 'static {
    /// The system in a scalar.
    type Of<T: Scalar>: Abilities<T>;

    /// Its name in scenes and tables.
    const NAME: &'static str;
    /// Its equations.
    const EQUATIONS: &'static str;
    /// The parameters. The first is `n`, the number of degrees of freedom, if [`Family::DOF`] is
    /// `None`.
    const PARAMETERS: &'static [Parameter];
    /// The ranges of the parameters, in words.
    const RANGES: &'static str;
    /// Whether an exact solution or a reference is known, in words.
    const SOLUTION: &'static str;
    /// The number of degrees of freedom, if it is not a parameter.
    const DOF: Option<usize>;
    /// The period of the coordinates, if they are angles.
    const PERIOD: Option<f64> = None;

    /// The system with `n` degrees of freedom and the other parameters in their order.
    ///
    /// # Errors
    /// [`InputError::Parameter`] for a parameter out of range, and [`InputError::Length`] for a
    /// wrong number of parameters.
    fn make<T: Scalar>(n: usize, parameters: &[T]) -> Result<Self::Of<T>, InputError>;
}

/// A parameter of a system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parameter {
    /// Its name in scenes.
    pub name: &'static str,
    /// Its unit, for a unit mass.
    pub unit: &'static str,
}

impl Parameter {
    /// A parameter in a unit.
    pub const fn new(name: &'static str, unit: &'static str) -> Self {
        Self { name, unit }
    }
}

/// The parameters, if their number is right.
pub(crate) fn exactly<T: Scalar, const K: usize>(parameters: &[T]) -> Result<[T; K], InputError> {
    let (name, value) = ("parameters", parameters.len() as f64);
    let wrong = InputError::Parameter { name, value, range: "as many as the system has" };
    parameters.try_into().map_err(|_| wrong)
}

/// The solution of a system with few degrees of freedom.
pub(crate) const BY_SERIES: &str = "Taylor series with a doubt, in 106 bits";
/// The solution of a system with any number of degrees of freedom.
pub(crate) const BY_SIZE: &str =
    "Taylor series with a doubt, in 106 bits; in 53 beyond 16 degrees of freedom";
