//! The growth of roundings along the solution, and whether an error bound can be met at all.

use super::Wanted;
use super::dense::Dense;
use super::trial::BETWEEN;
use crate::Solution;
use crate::digits::in_short;
use crate::progress::Progress;
use crate::solution::sizes_of;
use crate::study::{MOST_DEGREES_IN_QUAD, Problem};
use afterbay_core::{IntegrateError, Motors, Quad, Scalar, State, larger_or_nan};
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
    /// The motion has too many oscillations for the states that can be kept of the reference, so
    /// that it is not known between them.
    Between {
        /// The beginning of the longest stretch without comparison.
        begin: f64,
        /// Its end.
        end: f64,
    },
}

impl fmt::Display for TooSensitive {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Roundings { growth, error, until } => write!(
                f,
                "a change of the state grows by {growth:.0e} on the way, a rounding to \
                 {error:.0e}; up to t = {} it stays below the wanted error",
                in_short(*until)
            ),
            Self::Reference { doubt } => {
                write!(f, "the reference itself is known to {doubt:.0e} only")
            }
            Self::Between { begin, end } => write!(
                f,
                "from t = {} to t = {} the motion has too many oscillations for a reference \
                 between its states; an earlier end, or errors at the end alone, can be compared",
                in_short(*begin),
                in_short(*end)
            ),
        }
    }
}

/// The number of times at which the growth is measured.
const TIMES: usize = 512;
/// The initial change of q and of p, as a share of the largest |q_j| and of the largest |p_j| along
/// the solution, so that units do not matter. Its square is below the resolution of 106 bits.
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
    if !wanted.at_end
        && let Some([begin, end]) = dense.unresolved(BETWEEN * wanted.error)
    {
        return Ok(Some(TooSensitive::Between { begin, end }));
    }
    if problem.model.dof() > MOST_DEGREES_IN_QUAD {
        return Ok(by_doubt);
    }
    let (start, h) = (problem.start::<Quad>()?, Quad::from_f64(problem.end / TIMES as f64));
    let sizes = dense.sizes();
    let changed = changed(&start, problem.model.degrees(), sizes);
    let follow = |start: &State<Vec<Quad>>| problem.model.solution(start, h, TIMES, progress);
    let (one, other) = match (follow(&start), follow(&changed)) {
        (Ok(one), Ok(other)) => (one, other),
        (Err(IntegrateError::Interrupted), _) | (_, Err(IntegrateError::Interrupted)) => {
            return Err(IntegrateError::Interrupted);
        }
        // Series end at a kink. Only the doubt of the substitute reference is known then.
        _ => return Ok(by_doubt),
    };
    let by_rounding = by_rounding(&one, &other, sizes, &problem.model.motors(), wanted);
    Ok(by_rounding.or(by_doubt))
}

/// The start with changes of q and p, but not of motors. Each entry changes by another share, so
/// that symmetry hides no direction.
fn changed(start: &State<Vec<Quad>>, n: usize, [q, p, _]: [f64; 3]) -> State<Vec<Quad>> {
    let mut changed = start.clone();
    let qs = changed.q[..n].iter_mut().map(|x| (x, q));
    for (i, (x, size)) in qs.chain(changed.p[..n].iter_mut().map(|x| (x, p))).enumerate() {
        *x += Quad::from_f64(CHANGE * size * (1.0 - 0.4 * (1.0 + i as f64).sin()));
    }
    changed
}

/// Whether roundings grow beyond the wanted error, as seen by the distance of two solutions. The
/// distances of q, of p and of w are shares of their sizes. A kind that is 0 all along does not
/// count.
fn by_rounding(
    one: &Solution<Quad>,
    other: &Solution<Quad>,
    sizes: [f64; 3],
    motors: &Motors,
    wanted: Wanted,
) -> Option<TooSensitive> {
    let (mut least, mut largest, mut found) = (1.0_f64, [0.0_f64; 3], [0.0; 2]);
    let (mut until, mut beyond) = (0.0, false);
    let most = |values: [f64; 3]| values.into_iter().fold(0.0, larger_or_nan);
    let is_beyond = |error: f64| error > wanted.error || error.is_nan();
    for (i, state) in one.states().enumerate() {
        let apart = one.errors(i, other.at(i));
        let share = |k: usize| if sizes[k] > 0.0 { apart[k].error / sizes[k] } else { 0.0 };
        let grown = [0, 1, 2].map(|k| share(k) / CHANGE);
        least = least.min(most(grown)).max(SHRUNK);
        let now = sizes_of(state, motors);
        largest = [0, 1, 2].map(|k| largest[k].max(now[k]));
        let errors = [0, 1, 2].map(|k| grown[k] / least * largest[k] * f64::EPSILON);
        let [growth, error] = [most(grown) / least, most(errors)];
        found = match wanted.at_end {
            true => [growth, error],
            false => [larger_or_nan(found[0], growth), larger_or_nan(found[1], error)],
        };
        beyond |= is_beyond(found[1]);
        if !beyond {
            until = state.t.to_f64();
        }
    }
    let [growth, error] = found;
    is_beyond(error).then_some(TooSensitive::Roundings { growth, error, until })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Model;
    use crate::progress::Silent;
    use afterbay_systems::{Custom, Described, Description, DissipationText};

    /// q'' = -a q - q³ - c q' in units of length, mass and time, with q = `start` and p = 0, and
    /// what is said of an error of 1e-6 lengths.
    fn judged([a, c, start, end]: [f64; 4], [l, m, t]: [f64; 3]) -> Option<TooSensitive> {
        let description = Description {
            potential: "k*q1^2/2 + b*q1^4/4".into(),
            dissipation: DissipationText::Forces(vec!["c*p1".into()]),
            masses: vec![format!("{m:e}")],
            parameters: [("k", a * m / t / t), ("b", m / t / t / l / l), ("c", c / t)]
                .map(|(name, value)| (name.to_owned(), value))
                .into(),
            ..Default::default()
        };
        let system = Custom::new(&description).expect("a system");
        let model = Model::Custom(Described::Separable(system));
        let problem = Problem { model, q: vec![start * l], p: vec![0.0], end: end * t };
        // The larger of the sizes 1 of q and p.
        let unit = l.max(m * l / t);
        let wanted = Wanted { error: 1e-6 * unit, at_end: false, keep_k: false, passive: false };
        let dense = Dense::new(&problem, wanted.error, &Silent).expect("a reference");
        judge(&problem, wanted, &dense, &Silent).expect("an answer")
    }

    /// Natural units, those of an atom and those of a planet.
    const UNITS: [[f64; 3]; 3] = [[1.0; 3], [1e-10, 1e-26, 1e-13], [1.5e11, 6e24, 5e6]];

    #[test]
    fn the_growth_of_roundings_does_not_depend_on_units() {
        let said = UNITS.map(|units| judged([1.0, 0.1, 1.0, 10.0], units));
        assert_eq!(said, [None; 3]);
        // A start on a ridge.
        let growths = UNITS.map(|units| match judged([-1.0, 0.0, 1e-12, 40.0], units) {
            Some(TooSensitive::Roundings { growth, .. }) => growth,
            other => panic!("{units:?}: {other:?}"),
        });
        for growth in growths {
            assert!((growth / growths[0] - 1.0).abs() < 0.01, "{growths:?}");
        }
    }

    #[test]
    fn a_time_has_its_digits_in_any_unit() {
        let says = TooSensitive::Roundings { growth: 1e12, error: 1e-4, until: 1.2345678e-12 };
        assert!(says.to_string().contains("up to t = 1.235e-12"), "{says}");
    }
}
