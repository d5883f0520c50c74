//! The growth of roundings along the solution, and whether an error bound can be met at all.

use super::Wanted;
use super::dense::Dense;
use crate::progress::Progress;
use crate::study::{MOST_DEGREES_IN_QUAD, Problem};
use afterbay_core::{IntegrateError, Quad, Scalar, State, StateRef};
use serde::Serialize;
use std::fmt;

/// The reason why no method can be shown to meet the wanted error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "cause")]
pub enum TooSensitive {
    /// A rounding in `f64` grows beyond the wanted error.
    Roundings {
        /// The factor by which a small change of the state grows along the solution.
        growth: f64,
        /// The size to which a rounding grows.
        error: f64,
        /// The time until which it stays below the wanted error.
        until: f64,
    },
    /// The doubt of the reference exceeds the wanted error.
    Reference {
        /// The doubt.
        doubt: f64,
    },
}

impl fmt::Display for TooSensitive {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Roundings { growth, error, until } => write!(
                f,
                "a change of the state grows by {growth:.0e} on the way, a rounding to \
                 {error:.0e}; up to t = {until:.3} it stays below the wanted error"
            ),
            Self::Reference { doubt } => {
                write!(f, "the reference itself is known to {doubt:.0e} only")
            }
        }
    }
}

/// The number of times at which the growth is measured.
const TIMES: usize = 512;
/// The initial change of the state. Its square is below the resolution of 106 bits.
const CHANGE: f64 = 1e-18;
/// The least growth factor. Below it, the rounding of the solution dominates.
const SHRUNK: f64 = 1e-6;

/// Whether the scene is too sensitive for the wanted error, and why.
///
/// # Errors
/// Errors of the reference.
pub(super) fn judge(
    problem: &Problem,
    wanted: Wanted,
    dense: &Dense,
    progress: &dyn Progress,
) -> Result<Option<TooSensitive>, IntegrateError> {
    let doubt = if wanted.at_end { dense.doubt_at_end() } else { dense.doubt() }.most();
    let unknown = doubt > wanted.error || doubt.is_nan();
    let by_doubt = unknown.then_some(TooSensitive::Reference { doubt });
    if problem.model.dof() > MOST_DEGREES_IN_QUAD {
        return Ok(by_doubt);
    }
    let (start, h) = (problem.start::<Quad>()?, Quad::from_f64(problem.end / TIMES as f64));
    // Each entry changes by another share, so that symmetry hides no direction.
    let mut changed = start.clone();
    let entries = changed.q.iter_mut().chain(&mut changed.p);
    for (i, x) in entries.enumerate() {
        *x += Quad::from_f64(CHANGE * (1.0 - 0.4 * (1.0 + i as f64).sin()));
    }
    let follow = |start: &State<Vec<Quad>>| problem.model.solution(start, h, TIMES, progress);
    let (one, other) = match (follow(&start), follow(&changed)) {
        (Ok(one), Ok(other)) => (one, other),
        (Err(IntegrateError::Interrupted), _) | (_, Err(IntegrateError::Interrupted)) => {
            return Err(IntegrateError::Interrupted);
        }
        // Series end at a kink. Only the doubt of the substitute reference is known then.
        _ => return Ok(by_doubt),
    };
    let (mut least, mut growth, mut size, mut error) = (1.0_f64, 1.0_f64, 0.0_f64, 0.0);
    let (mut until, mut beyond) = (0.0, false);
    for (one, other) in one.states().zip(other.states()) {
        let (apart, large) = compared(one, other);
        let grown = apart / CHANGE;
        least = least.min(grown).max(SHRUNK);
        size = size.max(large);
        growth = if wanted.at_end { grown / least } else { growth.max(grown / least) };
        error = growth * size * f64::EPSILON;
        beyond |= error > wanted.error || error.is_nan();
        if !beyond {
            until = one.t.to_f64();
        }
    }
    let lost = error > wanted.error || error.is_nan();
    let by_rounding = lost.then_some(TooSensitive::Roundings { growth, error, until });
    Ok(by_rounding.or(by_doubt))
}

/// The largest difference of an entry of two states, and the largest entry of q and p.
fn compared(one: StateRef<'_, Quad>, other: StateRef<'_, Quad>) -> (f64, f64) {
    let pairs = [(one.q, other.q), (one.p, other.p), (one.w, other.w)];
    let apart =
        pairs.into_iter().flat_map(|(a, b)| a.iter().zip(b)).map(|(&a, &b)| (a - b).abs().to_f64());
    let large = one.q.iter().chain(one.p).map(|x| x.abs().to_f64());
    (apart.fold(0.0, f64::max), large.fold(0.0, f64::max))
}
