//! Why a description is no system.

use afterbay_core::InputError;
use afterbay_expression::Problem;
use std::fmt;
use std::ops::Range;
use thiserror::Error;

/// Which expression of a [`super::Description`]. Counted from 0 here and from 1 in messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// V
    Potential,
    /// D_j
    Dissipation(usize),
    /// R_ij
    Friction(usize, usize),
    /// m_j
    Mass(usize),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Potential => f.write_str("the potential"),
            Self::Dissipation(j) => write!(f, "entry {} of the dissipation", j + 1),
            Self::Friction(i, j) => write!(f, "entry {}, {} of the friction matrix", i + 1, j + 1),
            Self::Mass(j) => write!(f, "mass {}", j + 1),
        }
    }
}

/// Why a description is no system, or a system cannot be evaluated. Spans are in bytes of the expression.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum CustomError {
    /// An expression that cannot be read, or says what it may not.
    #[error("{place}, bytes {}..{}: {problem}", span.start, span.end)]
    Expression {
        /// Which.
        place: Place,
        /// Where in it.
        span: Range<usize>,
        /// What is wrong.
        problem: Problem,
    },
    /// A name no parameter can have.
    #[error("a parameter cannot be called {name:?}: {why}")]
    Name {
        /// The name.
        name: String,
        /// Why not.
        why: &'static str,
    },
    /// A parameter that is infinite or no number.
    #[error("parameter {name} = {value:?} must be finite")]
    Value {
        /// Its name.
        name: String,
        /// The value given.
        value: f64,
    },
    /// A parameter no expression mentions.
    #[error("parameter {name} is not used")]
    Unused {
        /// Its name.
        name: String,
    },
    /// A parameter the system does not have.
    #[error("there is no parameter {name}")]
    NoParameter {
        /// The name asked for.
        name: String,
    },
    /// A list that is not as long as there are degrees of freedom.
    #[error("the {list} has {found} entries where there are {expected} degrees of freedom")]
    Count {
        /// Which list.
        list: &'static str,
        /// N
        expected: usize,
        /// Its length.
        found: usize,
    },
    /// No degree of freedom.
    #[error(
        "there is no degree of freedom: neither masses nor dissipation are given, and the potential mentions no coordinate"
    )]
    Empty,
    /// An expression that has no finite value.
    #[error("{place}, bytes {}..{}, is {value:?} there", span.start, span.end)]
    NotFinite {
        /// Which expression.
        place: Place,
        /// The first operation in it without one.
        span: Range<usize>,
        /// Its value.
        value: f64,
    },
    /// More than there is room for.
    #[error("{count} {what} are more than {limit}: take fewer degrees of freedom, or couple fewer of them")]
    TooLarge {
        /// What there is too much of.
        what: &'static str,
        /// How many.
        count: usize,
        /// The most there may be.
        limit: usize,
    },
    /// A mass, a state or a derivative that is none.
    #[error(transparent)]
    Input(#[from] InputError),
}
