//! A described system of any form.

use super::failure::CustomError;
use super::{Custom, CustomGeneral, Description};
use afterbay_core::{Clocked, System};
use std::sync::Arc;

/// A system described by expressions.
#[derive(Clone, Debug)]
pub enum Described {
    /// H = Σ p_j²/(2 m_j) + V(q)
    Separable(Custom<f64>),
    /// H = Σ p_j²/(2 m_j) + V(q, t), or D depends on the time.
    Clocked(Clocked<Custom<f64>>),
    /// Any H(q, p)
    General(CustomGeneral<f64>),
}

impl Described {
    /// Compiles the description of a separable system, which may depend on the time.
    ///
    /// # Errors
    /// [`CustomError`], with the expression and the place in it.
    pub fn separable(description: &Description) -> Result<Self, CustomError> {
        let system = Custom::compile(description)?;
        Ok(if system.shape.has_clock {
            Self::Clocked(Clocked::new::<f64>(Arc::new(system))?)
        } else {
            Self::Separable(system)
        })
    }

    /// N, without a clock.
    pub fn dof(&self) -> usize {
        match self {
            Self::Separable(system) => System::<f64>::dof(system),
            Self::Clocked(system) => System::<f64>::dof(system) - 1,
            Self::General(system) => System::<f64>::dof(system),
        }
    }

    /// Whether V or D depends on the time.
    pub fn has_clock(&self) -> bool {
        matches!(self, Self::Clocked(_))
    }

    /// The names and values of the parameters.
    pub fn parameters(&self) -> Vec<(&str, f64)> {
        match self {
            Self::Separable(system) => system.parameters().collect(),
            Self::Clocked(system) => system.unclocked().parameters().collect(),
            Self::General(system) => system.parameters().collect(),
        }
    }

    /// The system with another value of a parameter.
    ///
    /// # Errors
    /// Those of [`Custom::with`].
    pub fn with(&self, name: &str, value: f64) -> Result<Self, CustomError> {
        Ok(match self {
            Self::Separable(system) => Self::Separable(system.with(name, value)?),
            Self::Clocked(system) => {
                let changed = system.unclocked().with(name, value)?;
                Self::Clocked(system.map(|_| changed))
            }
            Self::General(system) => Self::General(system.with(name, value)?),
        })
    }

    /// The period of each coordinate; see [`Custom::periods`].
    pub fn periods(&self) -> Vec<Option<f64>> {
        match self {
            Self::Separable(system) => system.periods(),
            Self::Clocked(system) => {
                let mut periods = system.unclocked().periods();
                periods.truncate(self.dof());
                periods
            }
            Self::General(system) => system.periods(),
        }
    }

    /// The period of V and D in the time, if their form shows one: the time occurs only in sines
    /// and cosines whose frequencies are multiples of one.
    pub fn period_in_time(&self) -> Option<f64> {
        match self {
            Self::Clocked(system) => system.unclocked().periods().last().copied().flatten(),
            Self::Separable(_) | Self::General(_) => None,
        }
    }

    /// Checks that all expressions, and H, its gradient and D, are finite at (q, p, t).
    ///
    /// # Errors
    /// Those of [`Custom::check_at`].
    pub fn check_at(&self, q: &[f64], p: &[f64], t: f64) -> Result<(), CustomError> {
        match self {
            Self::Separable(system) => system.check_at(q, p),
            Self::Clocked(system) => {
                let [q, p] =
                    [(q, t), (p, 0.0)].map(|(part, of_clock)| [part, &[of_clock]].concat());
                system.unclocked().check_at(&q, &p)
            }
            Self::General(system) => system.check_at(q, p),
        }
    }
}
