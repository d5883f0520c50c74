//! Requests that cannot be met.

use crate::quantity::{Block, Quantity};
use thiserror::Error;

/// A request that cannot be met. Nothing was computed.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum InputError {
    /// A step size that is zero, negative or not finite.
    #[error(
        "the step h = {h:?} {}",
        if h.is_finite() { "must be positive" } else { "is not finite" }
    )]
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
    /// A time that is not finite, or before the one from which it is to be reached.
    #[error("the time {to:?} must be finite and not before {from:?}")]
    Backwards {
        /// The time before.
        from: f64,
        /// The time asked for.
        to: f64,
    },
    /// An end that is no whole number of steps away.
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
    #[error(
        "time stalls: t + h = t at t = {t:?} with h = {h:?}: take a larger step or an earlier end"
    )]
    TimeStalled {
        /// The time.
        t: f64,
        /// The step asked for.
        h: f64,
    },
    /// A tolerance that is not a positive finite number, or is below the rounding errors of the
    /// scalar.
    #[error("the tolerance {name} = {value:?} must be finite and at least {least:e}")]
    Tolerance {
        /// Its name.
        name: &'static str,
        /// The value given.
        value: f64,
        /// The least value allowed.
        least: f64,
    },
    /// A study that needs the solution beyond a time at which it becomes infinite or stays on a
    /// kink.
    #[error("the solution cannot be followed beyond t = {t:?}: end before")]
    SolutionEnds {
        /// The time it was followed to.
        t: f64,
    },
    /// More steps than the limit.
    #[error("{steps:e} steps are more than {limit:e}: take larger steps or an earlier end")]
    Budget {
        /// The steps asked for.
        steps: f64,
        /// The limit.
        limit: f64,
    },
    /// A vector of the wrong length.
    #[error(
        "{quantity} has {found} {} and the number of degrees of freedom is {expected}",
        if *found == 1 { "entry" } else { "entries" }
    )]
    Length {
        /// The vector.
        quantity: Quantity,
        /// The number of degrees of freedom.
        expected: usize,
        /// The length given.
        found: usize,
    },
    /// A state that lacks the motors of its system ([`crate::System::motors`]).
    #[error(
        "the state has {found} {} and lacks the {} of the system, of its time or its drive: \
         `with_motors(&state, {motors})` adds {}",
        if *found == 1 { "degree of freedom" } else { "degrees of freedom" },
        if *motors == 1 { "motor".to_owned() } else { format!("{motors} motors") },
        if *motors == 1 { "it" } else { "them" }
    )]
    NoMotors {
        /// The degrees of freedom of the state.
        found: usize,
        /// The motors of the system.
        motors: usize,
    },
    /// An initial state that is not finite, or a system that is not finite at a finite state.
    #[error("{} = {value:?} is not finite", quantity.of(*dof))]
    NotFinite {
        /// The vector.
        quantity: Quantity,
        /// The degree of freedom, from 0.
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
        /// The values that are allowed.
        range: &'static str,
    },
    /// A mass that is zero, negative or not finite.
    #[error("m{} = {value:?} must be positive and finite", dof + 1)]
    Mass {
        /// The degree of freedom, from 0.
        dof: usize,
        /// The mass given.
        value: f64,
    },
    /// A system whose functions contradict each other, see [`crate::validate`].
    #[error("{} is given as {given:?} and found to be {found:?}: {rule}", quantity.of(*dof))]
    Contradiction {
        /// The statement that is contradicted.
        quantity: Quantity,
        /// The degree of freedom, from 0; for a sum, the one that contributes most to the
        /// contradiction.
        dof: usize,
        /// The value given, or the bound claimed.
        given: f64,
        /// The value found.
        found: f64,
        /// The rule that is violated.
        rule: &'static str,
    },
    /// A system whose functions contradict a derivative of one degree of freedom by another.
    #[error("{} is given as {given:?} and found to be {found:?}: {rule}", block.of(*row, *column))]
    ContradictionBetween {
        /// The derivative.
        block: Block,
        /// The degree of freedom differentiated, from 0.
        row: usize,
        /// The degree of freedom it is differentiated by, from 0.
        column: usize,
        /// The value given.
        given: f64,
        /// The value found.
        found: f64,
        /// The rule that is violated.
        rule: &'static str,
    },
    /// A method that does not apply to this system.
    #[error("{method} does not apply: {why}")]
    Unsupported {
        /// The method.
        method: &'static str,
        /// The property it needs and the system lacks.
        why: &'static str,
    },
}
