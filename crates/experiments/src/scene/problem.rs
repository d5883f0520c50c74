//! Errors of a scene.

mod advice;

use crate::claim::in_full;
pub(crate) use advice::suggestion;
use afterbay_analysis::ModelError;
use afterbay_core::InputError;
use afterbay_systems::CustomError;
use std::ops::Range;
use thiserror::Error;

/// A problem of a scene and its place.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{problem}")]
pub struct SceneError {
    /// The problem.
    #[source]
    pub problem: SceneProblem,
    /// The place, in bytes of the text.
    pub span: Range<usize>,
}

/// A problem of a scene.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum SceneProblem {
    /// The text is too large.
    #[error("the scene has {bytes} bytes, more than {limit}")]
    TooLarge {
        /// Its size.
        bytes: usize,
        /// The largest size.
        limit: usize,
    },
    /// Tables or arrays are nested too deep.
    #[error("this is nested more than {limit} deep")]
    TooDeep {
        /// The largest depth.
        limit: usize,
    },
    /// The text is not UTF-8.
    #[error("this is no text (UTF-8)")]
    NoText,
    /// The text is not TOML.
    #[error("{0}")]
    Syntax(String),
    /// A key that is unknown in its table.
    #[error("there is no key {key} here")]
    UnknownKey {
        /// The key.
        key: String,
        /// The known keys.
        known: Vec<String>,
        /// The other tables that have this key.
        tables: Vec<String>,
    },
    /// A required key is missing.
    #[error("the key {key} is missing")]
    Missing {
        /// The key.
        key: String,
    },
    /// A value of the wrong kind.
    #[error("this is {found}, where {expected} is expected")]
    Kind {
        /// The kind found.
        found: &'static str,
        /// The kind expected.
        expected: String,
    },
    /// A number between quotation marks.
    #[error("{text:?} is text, where a number is expected")]
    Quoted {
        /// The text.
        text: String,
    },
    /// A number that is not finite in `f64`, or rounds to 0.
    #[error("{text} {}", no_number(text))]
    Number {
        /// The number as written.
        text: String,
    },
    /// A whole number that is too large.
    #[error("{text} is too large for a whole number")]
    LargeWhole {
        /// The number as written.
        text: String,
    },
    /// An unknown name.
    #[error("there is no {what} {name}")]
    Unknown {
        /// The kind of thing that was named, such as "method".
        what: &'static str,
        /// The name.
        name: String,
        /// The known names.
        known: Vec<String>,
    },
    /// Several names of no method.
    #[error("there are no methods {}", names.join(", "))]
    UnknownMethods {
        /// The names.
        names: Vec<String>,
        /// The known names.
        known: Vec<String>,
    },
    /// A method that chooses its steps, used where steps are given.
    #[error("{name} takes a tolerance instead of a step")]
    Adaptive {
        /// The method.
        name: &'static str,
    },
    /// A method that chooses its steps, in a study of methods at given steps.
    #[error("{name} chooses its steps, and this study needs methods that take one")]
    ChoosesSteps {
        /// The method.
        name: &'static str,
    },
    /// A figure whose name is none of a file.
    #[error("{name:?} cannot be the name of a figure, which is that of its files")]
    FileName {
        /// The name.
        name: String,
    },
    /// A title or a unit with a control character.
    #[error("a title or a unit has no control characters")]
    ControlCharacter,
    /// A list without entries.
    #[error("the list is empty: give one {what} at least")]
    Empty {
        /// The kind of its entries.
        what: &'static str,
    },
    /// A study without methods.
    #[error("no methods are named for this study")]
    NoMethods,
    /// An entry occurs twice.
    #[error("{name} is in the list already")]
    Twice {
        /// The entry.
        name: String,
    },
    /// A key that does not belong in its place.
    #[error("{key} does not belong here: {why}")]
    Misplaced {
        /// The key.
        key: &'static str,
        /// The reason, in words.
        why: &'static str,
    },
    /// A number outside its range.
    #[error("{name} = {} must be {range}", in_full(*value))]
    Range {
        /// The name of the number.
        name: &'static str,
        /// The value given.
        value: f64,
        /// The range.
        range: &'static str,
    },
    /// A step of a study that does not consist of steps of its base grid.
    #[error("the step {step:?} is no multiple of base_step = {base:?}")]
    OffGrid {
        /// The step.
        step: f64,
        /// The step of the base grid.
        base: f64,
    },
    /// A list that is no row of a matrix.
    #[error("friction is a matrix, a list of rows")]
    NoMatrix,
    /// A study of orders with one step only.
    #[error("an order needs two steps at least, since it is a slope between errors")]
    OneStep,
    /// An end that is no whole number of steps away.
    #[error("the end {end:?} is no multiple of {name} = {h:?}")]
    Indivisible {
        /// The name of the step.
        name: &'static str,
        /// The end asked for.
        end: f64,
        /// The step asked for.
        h: f64,
        /// The nearest step that divides the end.
        nearest: f64,
    },
    /// A vector of the initial state of the wrong length.
    #[error("{error}")]
    Length {
        /// The lengths expected and found.
        error: InputError,
        /// A sentence that names the source of the expected length.
        set_by: String,
    },
    /// A method that does not apply to this system.
    #[error("{error}")]
    Unsupported {
        /// The reason.
        error: InputError,
        /// The methods that apply.
        others: Vec<&'static str>,
    },
    /// A size beyond the budget.
    #[error("{what} would be {size:.3e}, more than the budget of {limit:e}")]
    Budget {
        /// The quantity that is too large.
        what: &'static str,
        /// Its size.
        size: f64,
        /// The limit.
        limit: f64,
        /// The advice: what to change in the scene.
        change: &'static str,
    },
    /// The scene declares nothing to do.
    #[error("there is nothing to do: the scene has no {table}")]
    Nothing {
        /// The table that is missing.
        table: &'static str,
    },
    /// Input that the library refuses.
    #[error(transparent)]
    Input(InputError),
    /// A system that cannot be made.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A number given by an invalid expression.
    #[error("{0}")]
    Expression(afterbay_expression::Problem),
    /// A number given by an expression that is not finite.
    #[error("this is {value:?}")]
    NotFinite {
        /// Its value.
        value: f64,
    },
    /// A parameter that is defined by itself.
    #[error("{name} is defined by itself, or by parameters that are defined by it")]
    Circle {
        /// Its name.
        name: String,
    },
    /// A varied parameter that others are computed from, in a built-in system.
    #[error("{name} cannot be varied: {other} is computed from it")]
    Computed {
        /// The varied parameter.
        name: String,
        /// The parameter given by an expression.
        other: String,
    },
    /// A file of numbers that cannot be read.
    #[error("{file} cannot be read: {why}")]
    File {
        /// The file.
        file: String,
        /// The reason, in words.
        why: String,
    },
    /// Something that a sweep or a study cannot vary.
    #[error("{name} cannot be varied: {why}")]
    NotVaried {
        /// Its name.
        name: String,
        /// The reason, in words.
        why: &'static str,
    },
    /// Values of a sweep in no form or in several.
    #[error("this is no list, range or distribution")]
    OneForm,
    /// A problem at a point of a sweep.
    #[error("at {at}: {problem}")]
    AtPoint {
        /// The values there.
        at: String,
        /// The problem.
        problem: Box<SceneProblem>,
    },
    /// A grid of basins that does not have two axes.
    #[error("a map of basins has two axes")]
    TwoAxes,
    /// A stroboscopic section of a drive, or of V(q, t), without a period.
    #[error("the dependence on t shows no period")]
    NoPeriod,
    /// An interval after which the drive, or V(q, t), does not repeat.
    #[error("the interval {interval:?} is no multiple of the period in t, {period:?}")]
    OffPeriod {
        /// The interval.
        interval: f64,
        /// The period.
        period: f64,
    },
    /// An event that changes the state, where the motion is followed without events.
    #[error("the event {event} changes the state: neither a study nor `pick` follows it")]
    Changes {
        /// Its name.
        event: String,
    },
    /// Rules for all degrees of freedom, without their number.
    #[error("the number of degrees of freedom is not given")]
    NoCount,
    /// Expressions that are not valid.
    #[error("{}", in_words(.0))]
    Custom(CustomError),
}

/// The reason why a text is not a number.
fn no_number(text: &str) -> &'static str {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => "is too small to be told from 0",
        _ => "is not a finite number",
    }
}

impl From<InputError> for SceneProblem {
    fn from(error: InputError) -> Self {
        match error {
            InputError::NotAMultiple { end, h, nearest } => {
                Self::Indivisible { name: "the step h", end, h, nearest }
            }
            error => Self::Input(error),
        }
    }
}

/// The message about an expression without the place, which the span shows.
fn in_words(error: &CustomError) -> String {
    match error {
        CustomError::Expression { problem, .. } => problem.to_string(),
        CustomError::NotFinite { place, value, .. } => format!("this is {value:?} in {place}"),
        _ => error.to_string(),
    }
}
