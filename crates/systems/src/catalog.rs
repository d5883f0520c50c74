//! The catalogue of systems, with one row for each.
//!
//! A system enters it by [`Family`], in its own file, and by its row in [`SYSTEMS`].

mod forms;

pub use forms::{
    Compensable, Enclosure, Expandable, Number, Ranges, TERMS, custom_ranges, driven_ranges, ranges,
};

use crate::family::{Family, Parameter};
use crate::{
    DampedDoublePendulum, DampedOscillator, Duffing, FputChain, ModifiedVanDerPol, MorseChain,
    VanDerPol, VanDerPolRing,
};
use forms::Forms;

/// A system in the list of systems.
#[derive(Clone, Copy, Debug)]
pub struct SystemRow {
    /// Its name in scenes and tables.
    pub name: &'static str,
    /// Its equations.
    pub equations: &'static str,
    /// The parameters. The first is `n`, the number of degrees of freedom, if `dof` is `None`.
    pub parameters: &'static [Parameter],
    /// The ranges of the parameters, in words.
    pub ranges: &'static str,
    /// Whether an exact solution or a reference is known, in words.
    pub solution: &'static str,
    /// The number of degrees of freedom, if it is not a parameter.
    pub dof: Option<usize>,
    /// The period of the coordinates, if they are angles.
    pub period: Option<f64>,
    forms: Forms,
}

/// Two rows are equal if their names are.
impl PartialEq for SystemRow {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl SystemRow {
    /// The row of a system.
    pub const fn of<F: Family>() -> Self {
        Self {
            name: F::NAME,
            equations: F::EQUATIONS,
            parameters: F::PARAMETERS,
            ranges: F::RANGES,
            solution: F::SOLUTION,
            dof: F::DOF,
            period: F::PERIOD,
            forms: Forms::of::<F>(),
        }
    }

    /// Whether the parameter is the number of degrees of freedom, a whole number.
    pub fn is_count(&self, index: usize) -> bool {
        self.dof.is_none() && index == 0
    }
}

/// Every system except [`Custom`](crate::Custom).
pub static SYSTEMS: &[&SystemRow] = &[
    &DAMPED_OSCILLATOR,
    &DUFFING,
    &VAN_DER_POL,
    &MODIFIED_VAN_DER_POL,
    &FPUT_CHAIN,
    &MORSE_CHAIN,
    &VAN_DER_POL_RING,
    &DAMPED_DOUBLE_PENDULUM,
];

/// The damped oscillator.
pub static DAMPED_OSCILLATOR: SystemRow = SystemRow::of::<DampedOscillator<f64>>();
/// The Duffing oscillator.
pub static DUFFING: SystemRow = SystemRow::of::<Duffing<f64>>();
/// The Van der Pol oscillator.
pub static VAN_DER_POL: SystemRow = SystemRow::of::<VanDerPol<f64>>();
/// The Van der Pol oscillator in a Duffing potential.
pub static MODIFIED_VAN_DER_POL: SystemRow = SystemRow::of::<ModifiedVanDerPol<f64>>();
/// The damped FPUT-β chain.
pub static FPUT_CHAIN: SystemRow = SystemRow::of::<FputChain<f64>>();
/// The damped Morse chain.
pub static MORSE_CHAIN: SystemRow = SystemRow::of::<MorseChain<f64>>();
/// The ring of Van der Pol oscillators.
pub static VAN_DER_POL_RING: SystemRow = SystemRow::of::<VanDerPolRing<f64>>();
/// The damped double pendulum.
pub static DAMPED_DOUBLE_PENDULUM: SystemRow = SystemRow::of::<DampedDoublePendulum<f64>>();
