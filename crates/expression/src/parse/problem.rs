//! The mistakes in a text that make it no expression.

use super::{DEEPEST, LONGEST, MOST_DEGREES, MOST_INDEX, MOST_WRITTEN_OUT};
use std::ops::Range;
use thiserror::Error;

/// A mistake in an expression.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum Problem {
    /// A symbol or word that the grammar does not allow here.
    #[error("{found} where {expected} should be")]
    Unexpected {
        /// The symbol or word.
        found: String,
        /// The tokens that the grammar allows.
        expected: &'static str,
    },
    /// A text that ends too early.
    #[error("the expression ends where {expected} should be")]
    Ends {
        /// The tokens that the grammar allows.
        expected: &'static str,
    },
    /// A product without its sign, such as `2 q1` or `g(1 - q1)`.
    #[error("a sign such as * is missing between {left} and {right}")]
    NoSign {
        /// The word before, or a parenthesis.
        left: String,
        /// The word behind, or a parenthesis.
        right: String,
    },
    /// A name that is not defined.
    #[error(
        "{name} is not known{}",
        nearest.as_ref().map(|x| format!(": do you mean {x}?")).unwrap_or_default()
    )]
    Unknown {
        /// The name.
        name: String,
        /// The most similar known name, if one is similar.
        nearest: Option<Box<str>>,
        /// The names that are known, as a list in words.
        known: Box<str>,
    },
    /// A parameter with the name of a velocity, where velocities are allowed.
    #[error("{name} is a velocity here, and the name of a parameter: rename the parameter")]
    Ambiguous {
        /// The name.
        name: String,
    },
    /// A number outside the range of `f64`.
    #[error("{text} is too large or too small for a number")]
    Number {
        /// The text as written.
        text: String,
    },
    /// A coordinate, momentum or velocity with an invalid index.
    #[error(
        "{name} is no coordinate, momentum or velocity: they are counted from 1, without leading \
         zeros, up to {}",
        MOST_DEGREES
    )]
    Index {
        /// The text as written.
        name: String,
    },
    /// A degree of freedom beyond the last.
    #[error(
        "{name} is beyond the last of {dof} degree{} of freedom",
        if *dof == 1 { "" } else { "s" }
    )]
    BeyondLast {
        /// The text as written.
        name: String,
        /// N
        dof: usize,
    },
    /// A coordinate, a momentum, a velocity or the time where [`Names`](super::Names) does not
    /// allow it.
    #[error("{name} has no place here: {rule}")]
    NoPlace {
        /// The text as written.
        name: String,
        /// The rule.
        rule: &'static str,
    },
    /// A function with jumps where none is allowed, or of something that is not the time.
    #[error("{name} has no place here: {rule}")]
    Jumps {
        /// The name of the function.
        name: &'static str,
        /// The rule.
        rule: &'static str,
    },
    /// An entry q\[j\], p\[j\] or v\[j\] outside 1..=N.
    #[error("{name}[{index}] does not exist: entries are counted from 1{}", last(*dof))]
    NoEntry {
        /// q, p or v.
        name: char,
        /// j
        index: i64,
        /// N, if it is known.
        dof: Option<usize>,
    },
    /// An index of a sum with the name of something else.
    #[error("{name} cannot be the index of a sum: it has a meaning of its own")]
    NoIndex {
        /// The name.
        name: String,
    },
    /// An index that is too large to compute.
    #[error("an index is at most {} in size", MOST_INDEX)]
    LargeIndex,
    /// The number of degrees of freedom is needed but not known.
    #[error("the number of degrees of freedom is not known here")]
    NoCount,
    /// Sums with too many terms.
    #[error("its sums are too long: written out they have more than {MOST_WRITTEN_OUT} bytes")]
    TooManyTerms,
    /// A text that is too long.
    #[error("the expression has {bytes} bytes, and {LONGEST} is the most")]
    TooLong {
        /// Its length.
        bytes: usize,
    },
    /// Parentheses, signs or powers that are nested too deeply.
    #[error("the expression is nested deeper than {DEEPEST}")]
    TooDeep,
}

impl Problem {
    /// The text to write instead, where the mistake is a common one.
    pub fn advice(&self) -> Option<String> {
        match self {
            Self::TooLong { .. } => {
                Some("write terms that repeat as a sum, such as sum(i, 1, n, q[i]^2)".into())
            }
            Self::TooDeep => Some("leave out parentheses and signs that change nothing".into()),
            Self::Ends { expected } => {
                expected.contains("closing").then(|| "what was opened is not closed".into())
            }
            Self::NoSign { left, right } => {
                let [left, right] = [left, right].map(|word| match word.as_str() {
                    "(" | ")" => "(..)",
                    word => word,
                });
                Some(format!("write {left}*{right}"))
            }
            Self::Unexpected { found, .. } => {
                let advice = match found.chars().next()? {
                    '*' => "powers are written ^, as in q1^2, and products *, as in 2*q1",
                    '[' => "entries are written q[1], p[1], ..",
                    ',' => {
                        "numbers are written with a point, as in 9.81, and min, max and mod take \
                         two arguments"
                    }
                    _ => return None,
                };
                Some(advice.into())
            }
            Self::Unknown { name, .. } if jumps_elsewhere(name) => Some(
                "the functions with jumps are sign, floor and mod, for forces of a drive; \
                 tanh(x/eps) is a smooth sign"
                    .into(),
            ),
            Self::Jumps { .. } => Some("tanh(x/eps) is a smooth sign".into()),
            Self::Unknown { name, nearest: None, known } => match name.as_str() {
                "time" => Some("the time is called t".into()),
                "i" | "n" => None,
                _ => Some(format!(
                    "known here are {known}; `parameters` defines other names, and `afterbay list \
                     functions` has the functions"
                )),
            },
            Self::BeyondLast { .. } => {
                Some("there are as many as dissipation, mass, q and p have entries".into())
            }
            Self::NoIndex { .. } => Some("take another name, as in sum(k, 1, n, q[k]^2)".into()),
            Self::NoCount => Some("write q = { count = 8, value = .. } in [initial]".into()),
            _ => None,
        }
    }
}

/// Whether it is the name of a function with jumps in other languages.
pub(super) fn jumps_elsewhere(name: &str) -> bool {
    matches!(name, "sgn" | "step" | "heaviside" | "ceil" | "round" | "frac" | "square")
}

fn last(dof: Option<usize>) -> String {
    dof.map_or(String::new(), |dof| format!(" to {dof}"))
}

/// A text is no expression.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("bytes {}..{}: {problem}", span.start, span.end)]
pub struct ParseError {
    /// The bytes of the text that are wrong.
    pub span: Range<usize>,
    /// The mistake.
    pub problem: Problem,
}
