//! Requests that cannot be met.

use crate::quantity::{Block, Quantity};
use thiserror::Error;

/// Why nothing was computed: what was asked for cannot be done.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum InputError {
    /// A step size that is zero, negative or not finite.
    #[error("the step h = {h:?} must be positive and finite")]
    Step {
        /// The step asked for.
        h: f64,
    },
    /// An end of time that is zero, negative or not finite.
    #[error("the end of time {end:?} must be positive and finite")]
    End {
        /// The end asked for.
        end: f64,
    },
    /// The end is not reached by whole steps.
    #[error("the end {end:?} is no multiple of the step h = {h:?}: take h = {nearest:?}")]
    NotAMultiple {
        /// The end asked for.
        end: f64,
        /// The step asked for.
        h: f64,
        /// The nearest step that divides the end.
        nearest: f64,
    },
    /// A step that vanishes beside the time it is added to.
    #[error("time stalls: t + h = t at t = {t:?} with h = {h:?}: take a larger step or an earlier end")]
    TimeStalled {
        /// The time.
        t: f64,
        /// The step asked for.
        h: f64,
    },
    /// A tolerance that is not a positive number, or one that roundings alone exceed.
    #[error("the tolerance {name} = {value:?} must be finite and at least {least:e}")]
    Tolerance {
        /// Which of them.
        name: &'static str,
        /// The value given.
        value: f64,
        /// The least there may be.
        least: f64,
    },
    /// A study that needs the solution beyond its end: it leaves the numbers, or lies on a kink from there
    /// on.
    #[error("the solution cannot be followed beyond t = {t:?}: end before")]
    SolutionEnds {
        /// The time it was followed to.
        t: f64,
    },
    /// More steps than anyone can wait for.
    #[error("{steps:e} steps are more than {limit:e}: take larger steps or an earlier end")]
    Budget {
        /// The steps asked for.
        steps: f64,
        /// The most there may be.
        limit: f64,
    },
    /// A vector of the wrong length.
    #[error("{quantity} has {found} entries and the number of degrees of freedom is {expected}")]
    Length {
        /// Which vector.
        quantity: Quantity,
        /// The number of degrees of freedom.
        expected: usize,
        /// The length given.
        found: usize,
    },
    /// A state that is not finite to begin with, or a system that is not at a state that is.
    #[error("{} = {value:?} is not finite", quantity.of(*dof))]
    NotFinite {
        /// Which vector.
        quantity: Quantity,
        /// Which degree of freedom, from 0.
        dof: usize,
        /// The value given.
        value: f64,
    },
    /// A parameter outside its range.
    #[error("parameter {name} = {value:?} must be {range}")]
    Parameter {
        /// Its name.
        name: &'static str,
        /// The value given.
        value: f64,
        /// What is allowed.
        range: &'static str,
    },
    /// A mass that is zero, negative or not finite.
    #[error("m{} = {value:?} must be positive and finite", dof + 1)]
    Mass {
        /// Which degree of freedom, from 0.
        dof: usize,
        /// The mass given.
        value: f64,
    },
    /// A system that contradicts itself, see [`crate::validate`].
    #[error("{} is given as {given:?} and found to be {found:?}: {rule}", quantity.of(*dof))]
    Contradiction {
        /// What is contradicted.
        quantity: Quantity,
        /// Which degree of freedom, from 0; for a sum, the one that contributes most to what is wrong.
        dof: usize,
        /// The value given, or the bound claimed.
        given: f64,
        /// The value found.
        found: f64,
        /// What should hold and does not.
        rule: &'static str,
    },
    /// The same of a derivative of one degree of freedom by another.
    #[error("{} is given as {given:?} and found to be {found:?}: {rule}", block.of(*row, *column))]
    ContradictionBetween {
        /// Which derivative.
        block: Block,
        /// The degree of freedom differentiated, from 0.
        row: usize,
        /// The degree of freedom it is differentiated by, from 0.
        column: usize,
        /// The value given.
        given: f64,
        /// The value found.
        found: f64,
        /// What should hold and does not.
        rule: &'static str,
    },
    /// A method that does not apply to this system.
    #[error("{method} does not apply: {why}")]
    Unsupported {
        /// The method.
        method: &'static str,
        /// What it needs and the system does not have.
        why: &'static str,
    },
}
