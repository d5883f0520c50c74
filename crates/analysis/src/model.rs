//! A system by name, with its parameters.

use crate::Subject;
use afterbay_core::{InputError, Scalar};
use afterbay_systems::{DampedOscillator, Duffing, ModifiedVanDerPol, VanDerPol};
use serde::Serialize;

/// A system and its parameters.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(tag = "name", content = "parameters", rename_all = "kebab-case")]
pub enum Model {
    /// `V = k q²/2, D = b p`
    DampedOscillator {
        /// Stiffness.
        k: f64,
        /// Damping.
        b: f64,
    },
    /// `V = α q²/2 + β q⁴/4, D = c p`
    Duffing {
        /// Linear stiffness; negative for a double well.
        alpha: f64,
        /// Cubic stiffness.
        beta: f64,
        /// Damping.
        c: f64,
    },
    /// `V = q²/2, D = -μ (1 - q²) p`
    VanDerPol {
        /// Activity.
        mu: f64,
    },
    /// `V = α q²/2 + β q⁴/4, D = -μ (1 - q²) p`
    ModifiedVanDerPol {
        /// Activity.
        mu: f64,
        /// Linear stiffness.
        alpha: f64,
        /// Cubic stiffness.
        beta: f64,
    },
}

impl Model {
    /// The name in scenes and tables.
    pub fn name(&self) -> &'static str {
        match self {
            Self::DampedOscillator { .. } => "damped-oscillator",
            Self::Duffing { .. } => "duffing",
            Self::VanDerPol { .. } => "van-der-pol",
            Self::ModifiedVanDerPol { .. } => "modified-van-der-pol",
        }
    }

    /// The system itself, in the scalar asked for.
    ///
    /// # Errors
    /// [`InputError::Parameter`] for a parameter out of range.
    pub fn subject<T: Scalar>(&self) -> Result<Box<dyn Subject<T>>, InputError> {
        let t = T::from_f64;
        Ok(match *self {
            Self::DampedOscillator { k, b } => Box::new(DampedOscillator::new(t(k), t(b))?),
            Self::Duffing { alpha, beta, c } => Box::new(Duffing::new(t(alpha), t(beta), t(c))?),
            Self::VanDerPol { mu } => Box::new(VanDerPol::new(t(mu))?),
            Self::ModifiedVanDerPol { mu, alpha, beta } => {
                Box::new(ModifiedVanDerPol::new(t(mu), t(alpha), t(beta))?)
            }
        })
    }
}

/// A system in the list of systems.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct SystemRow {
    /// Its name in scenes and tables.
    pub name: &'static str,
    /// Its equations.
    pub equations: &'static str,
    /// Its parameters and their ranges.
    pub parameters: &'static str,
    /// What is known of its solution.
    pub solution: &'static str,
}

/// Every system there is.
pub const SYSTEMS: &[SystemRow] = &[
    SystemRow {
        name: "damped-oscillator",
        equations: "V = k q²/2, D = b p",
        parameters: "k > 0, b (b < 0 feeds energy in)",
        solution: "exact: q, p and w",
    },
    SystemRow {
        name: "duffing",
        equations: "V = α q²/2 + β q⁴/4, D = c p",
        parameters: "alpha, beta, c (alpha < 0 < beta: double well)",
        solution: "Taylor series, to rounding",
    },
    SystemRow {
        name: "van-der-pol",
        equations: "V = q²/2, D = -μ (1 - q²) p",
        parameters: "mu (mu > 0: limit cycle)",
        solution: "Taylor series, to rounding",
    },
    SystemRow {
        name: "modified-van-der-pol",
        equations: "V = α q²/2 + β q⁴/4, D = -μ (1 - q²) p",
        parameters: "mu, alpha, beta",
        solution: "Taylor series, to rounding",
    },
];
