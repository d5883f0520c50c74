//! A described system of either form.

use super::failure::CustomError;
use super::{Custom, CustomGeneral};
use afterbay_core::System;

/// A system described by expressions.
#[derive(Clone, Debug)]
pub enum Described {
    /// H = Σ p_j²/(2 m_j) + V(q)
    Separable(Custom<f64>),
    /// Any H(q, p)
    General(CustomGeneral<f64>),
}

impl Described {
    /// N
    pub fn dof(&self) -> usize {
        match self {
            Self::Separable(system) => System::<f64>::dof(system),
            Self::General(system) => System::<f64>::dof(system),
        }
    }

    /// The names and values of the parameters.
    pub fn parameters(&self) -> Vec<(&str, f64)> {
        match self {
            Self::Separable(system) => system.parameters().collect(),
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
            Self::General(system) => Self::General(system.with(name, value)?),
        })
    }

    /// The period of each coordinate; see [`Custom::periods`].
    pub fn periods(&self) -> Vec<Option<f64>> {
        match self {
            Self::Separable(system) => system.periods(),
            Self::General(system) => system.periods(),
        }
    }

    /// Checks that all expressions, and H, its gradient and D, are finite at (q, p).
    ///
    /// # Errors
    /// Those of [`Custom::check_at`].
    pub fn check_at(&self, q: &[f64], p: &[f64]) -> Result<(), CustomError> {
        match self {
            Self::Separable(system) => system.check_at(q, p),
            Self::General(system) => system.check_at(q, p),
        }
    }
}
