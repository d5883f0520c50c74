//! Errors of descriptions.

use afterbay_core::InputError;
use afterbay_expression::Problem;
use std::fmt;
use std::ops::Range;
use thiserror::Error;

/// An expression of a [`super::Description`] or [`super::GeneralDescription`]. Counted from 0 here
/// and from 1 in messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// V
    Potential,
    /// H
    Hamiltonian,
    /// D_j
    Dissipation(usize),
    /// R_ij
    Friction(usize, usize),
    /// m_j
    Mass(usize),
    /// A parameter that is an expression
    Definition(usize),
    /// F_j
    Force(usize),
    /// The period of a drive
    Period,
    /// A function of the state
    Function,
}

impl Place {
    /// The degree of freedom of the expression, if it is one of a list.
    pub(super) fn degree(self) -> Option<usize> {
        match self {
            Self::Dissipation(j) | Self::Friction(j, _) | Self::Mass(j) | Self::Force(j) => Some(j),
            Self::Potential
            | Self::Hamiltonian
            | Self::Definition(_)
            | Self::Period
            | Self::Function => None,
        }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Potential => f.write_str("the potential"),
            Self::Hamiltonian => f.write_str("the Hamiltonian"),
            Self::Dissipation(j) => write!(f, "entry {} of the dissipation", j + 1),
            Self::Friction(i, j) => write!(f, "entry {}, {} of the friction matrix", i + 1, j + 1),
            Self::Mass(j) => write!(f, "mass {}", j + 1),
            Self::Definition(k) => write!(f, "parameter {}", k + 1),
            Self::Force(j) => write!(f, "force {} of the drive", j + 1),
            Self::Period => f.write_str("the period of the drive"),
            Self::Function => f.write_str("the function"),
        }
    }
}

/// An invalid description, or a system that cannot be evaluated. Spans are in bytes of the
/// expression.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum CustomError {
    /// An expression that cannot be parsed or is not allowed here.
    #[error("{place}, bytes {}..{}: {problem}", span.start, span.end)]
    Expression {
        /// The expression.
        place: Place,
        /// The bytes of it.
        span: Range<usize>,
        /// The problem found there.
        problem: Problem,
    },
    /// A name that is not allowed for a parameter.
    #[error("a parameter cannot be called {name:?}: {why}")]
    Name {
        /// The name.
        name: String,
        /// The reason.
        why: &'static str,
    },
    /// A parameter that is not finite.
    #[error("parameter {name} = {value:?} must be finite")]
    Value {
        /// Its name.
        name: String,
        /// The value given.
        value: f64,
    },
    /// A parameter no expression mentions.
    #[error("parameter {name} is not used in the equations")]
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
    /// A list whose length is not the number of degrees of freedom.
    #[error(
        "the {list} has {found} {} where there {} of freedom",
        if *found == 1 { "entry" } else { "entries" },
        if *expected == 1 { "is 1 degree".to_owned() } else { format!("are {expected} degrees") }
    )]
    Count {
        /// The list.
        list: &'static str,
        /// N
        expected: usize,
        /// Its length.
        found: usize,
    },
    /// A description without degrees of freedom.
    #[error(
        "there is no degree of freedom: neither masses nor dissipation are given, and the energy \
         mentions no coordinate"
    )]
    Empty,
    /// An expression whose value is not finite.
    #[error("{place}, bytes {}..{}, is {value:?} there", span.start, span.end)]
    NotFinite {
        /// The expression.
        place: Place,
        /// The first operation in it whose value is not finite.
        span: Range<usize>,
        /// Its value.
        value: f64,
    },
    /// A number given as the period of a drive, after which its forces do not return.
    #[error(
        "{period:?} is no period of the drive: force {} is {before:?} at t = {t:?} and {after:?} \
         one period later",
        dof + 1
    )]
    NoPeriod {
        /// The number.
        period: f64,
        /// The degree of freedom, counted from 0.
        dof: usize,
        /// A time.
        t: f64,
        /// The force there.
        before: f64,
        /// The force later by the period.
        after: f64,
    },
    /// A function of an event that depends on neither the state nor the time.
    #[error("this is constant: an event is a zero of a function of the state or of t")]
    ConstantFunction,
    /// A period of a drive that is not positive and finite.
    #[error("the period of the drive is {period:?}: it must be positive and finite")]
    PeriodRange {
        /// The number.
        period: f64,
    },
    /// V or D depends on t, which [`super::Custom`] alone does not take.
    #[error("V or D depends on t: make the system with Described::separable")]
    NeedsClock,
    /// A size beyond its limit.
    #[error(
        "{count} {what} are more than {limit}: take fewer degrees of freedom, or couple fewer of \
         them"
    )]
    TooLarge {
        /// The things that are too many.
        what: &'static str,
        /// Their number.
        count: usize,
        /// The limit.
        limit: usize,
    },
    /// A mass, a state or a derivative that is not valid.
    #[error(transparent)]
    Input(#[from] InputError),
}
