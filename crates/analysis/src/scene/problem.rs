//! Errors of a scene.

use crate::ModelError;
use afterbay_core::InputError;
use afterbay_systems::CustomError;
use std::fmt::Write;
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
    #[error("{text} is not a finite number, or too small to be told from 0")]
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
    /// A figure whose name is none of a file.
    #[error("{name:?} cannot be the name of a figure, which is that of its files")]
    FileName {
        /// The name.
        name: String,
    },
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
        /// Why.
        why: &'static str,
    },
    /// A number outside its range.
    #[error("{name} = {value:?} must be {range}")]
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
    /// A size beyond the budget.
    #[error("{what} would be {size:.3e}, more than the budget of {limit:e}")]
    Budget {
        /// The quantity that is too large.
        what: &'static str,
        /// Its size.
        size: f64,
        /// The limit.
        limit: f64,
        /// What to change.
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
    Input(#[from] InputError),
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
        /// Why.
        why: String,
    },
    /// Something that a sweep cannot vary.
    #[error("{name} cannot be varied: {why}")]
    NotVaried {
        /// Its name.
        name: String,
        /// Why.
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
    /// Rules for all degrees of freedom, without their number.
    #[error("the number of degrees of freedom is not given")]
    NoCount,
    /// Expressions that are not valid.
    #[error("{}", in_words(.0))]
    Custom(CustomError),
}

/// The message about an expression without the place, which the span shows.
fn in_words(error: &CustomError) -> String {
    match error {
        CustomError::Expression { problem, .. } => problem.to_string(),
        CustomError::NotFinite { place, value, .. } => format!("this is {value:?} in {place}"),
        _ => error.to_string(),
    }
}

impl SceneProblem {
    /// Advice on how to solve the problem.
    pub fn help(&self) -> Option<String> {
        match self {
            Self::UnknownKey { key, known } => Some(suggestion(key, known, "the keys are")),
            // The nearest name of q7 is q1, which helps no one.
            Self::Unknown { what: "quantity", known, .. } => {
                Some(format!("there are {}", known.join(", ")))
            }
            Self::Unknown { name, known, .. } => Some(suggestion(name, known, "there are")),
            Self::UnknownMethods { names, known } => Some(suggestions(names, known)),
            Self::OffGrid { step, base } => {
                let multiple = (step / base).round().max(1.0) * base;
                let digits = format!("{multiple:.12e}").parse().unwrap_or(multiple);
                Some(format!("write {digits:?}, or a base_step that divides {step:?}"))
            }
            Self::Adaptive { .. } => {
                Some("give `tolerance` in [run], or `tolerances` in [study.work-precision]".into())
            }
            Self::FileName { .. } => {
                Some("a name has letters, digits, `-` and `_`, at most 100 of them".into())
            }
            Self::Quoted { .. } => Some("write the number without quotation marks".into()),
            Self::LargeWhole { .. } => Some("write it as 1e20 where any number may stand".into()),
            Self::NoText => Some("save the file as UTF-8".into()),
            Self::TooLarge { .. } => Some("is this the right file?".into()),
            Self::Syntax(_) => {
                Some("scenes are TOML files: see https://toml.io, and `afterbay schema`".into())
            }
            Self::Budget { change, .. } => Some((*change).into()),
            Self::Nothing { .. } => {
                Some("`afterbay schema` describes all tables a scene may have".into())
            }
            Self::Input(InputError::NotAMultiple { end, h, nearest }) => {
                Some(match short_steps(*end, *h) {
                    [Some(below), Some(above)] => format!("{below} and {above} divide it"),
                    [Some(step), None] | [None, Some(step)] => format!("{step} divides it"),
                    [None, None] => format!("{nearest:?} divides it"),
                })
            }
            Self::Input(InputError::Unsupported { .. }) => {
                Some("`afterbay list methods` says what each method needs".into())
            }
            Self::AtPoint { problem, .. } => problem.help(),
            Self::OneForm => Some(
                "write [0.1, 0.2], { from = 0, to = 1, count = 5 }, { uniform = [0, 1] } or \
                 { normal = [0, 1] }"
                    .into(),
            ),
            Self::NoCount => {
                Some("write q = { count = 8, value = .. } in [initial], or a list".into())
            }
            Self::NoMethods => Some("name `methods` here, or in [run] for all studies".into()),
            Self::Expression(problem) | Self::Custom(CustomError::Expression { problem, .. }) => {
                problem.advice().map(str::to_owned)
            }
            Self::Missing { key } => match key.as_str() {
                "initial" => Some("for example:  [initial]  q = [1.0]  p = [0.0]".into()),
                "time" => Some("for example:  [time]  end = 10.0  step = 0.01".into()),
                "system" => Some("for example:  [system]  name = \"duffing\"".into()),
                "y" => Some("a quantity such as y = \"q1\", or a map such as map = \"q\"".into()),
                "step" => Some("the size of a step, such as step = 0.01".into()),
                _ => None,
            },
            Self::Custom(CustomError::NotFinite { .. })
            | Self::Input(InputError::NotFinite { .. }) => {
                Some("start where H and all forces are finite".into())
            }
            _ => None,
        }
    }
}

/// The nearest steps of at most two digits that divide the end, between h/2 and h and between h and
/// 2 h.
fn short_steps(end: f64, h: f64) -> [Option<String>; 2] {
    let exponent = h.log10().floor() - 1.0;
    let step = |digits: u32, shift: f64| format!("{digits}e{}", exponent + shift).parse::<f64>();
    let divides = |step: &f64| {
        let steps = end / step;
        steps >= 0.5 && (steps - steps.round()).abs() <= 1e-9 * steps
    };
    let all = || {
        let steps = (-1..2).flat_map(|shift| (10..100).map(move |digits| (digits, shift)));
        let steps = steps.filter_map(|(digits, shift)| step(digits, f64::from(shift)).ok());
        steps.filter(|step| (0.5 * h..=2.0 * h).contains(step)).filter(divides)
    };
    let below = all().filter(|step| *step < h).max_by(f64::total_cmp);
    let above = all().filter(|step| *step > h).min_by(f64::total_cmp);
    [below, above].map(|step| step.map(|step| step.to_string()))
}

/// The nearest of the known names for each name that has a similar one, and all known names if one
/// has none.
fn suggestions(names: &[String], known: &[String]) -> String {
    let (mut said, mut all) = (Vec::new(), String::new());
    for name in names {
        let advice = suggestion(name, known, "there are");
        match advice.strip_prefix("did you mean ") {
            Some(nearest) => said.push(format!("{name}: did you mean {nearest}")),
            None => all = advice,
        }
    }
    said.extend((!all.is_empty()).then_some(all));
    said.join(" ")
}

/// The nearest name if one is similar, else all names.
pub(crate) fn suggestion(name: &str, known: &[String], before: &str) -> String {
    let far = |other: &String| strsim::damerau_levenshtein(name, other);
    match known.iter().min_by_key(|other| far(other)) {
        Some(nearest)
            if far(nearest) < name.len()
                && far(nearest) <= 1 + nearest.len().min(name.len()) / 3 =>
        {
            format!("did you mean {nearest}?")
        }
        _ => {
            let mut all = String::from(before);
            for (i, name) in known.iter().enumerate() {
                let _ = write!(all, "{}{name}", if i == 0 { " " } else { ", " });
            }
            all
        }
    }
}
