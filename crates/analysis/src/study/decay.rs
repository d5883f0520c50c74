//! Decay faster than the step: the ratio R = H₂/H₁ of the energies after and before the second
//! step, beside the exact ratio, and whether the drift of K reveals an error.

use super::energy::EnergyRun;
use super::kept::KEPT;
use crate::progress::Progress;
use afterbay_core::IntegrateError;
use serde::{Serialize, Serializer};

/// The verdict on a run, from its numbers alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decay {
    /// The loss of energy is right, and K is kept.
    Right,
    /// The loss is right, and K is not kept.
    RightWithoutK,
    /// K is kept, but the loss is wrong.
    WrongWithK,
    /// The loss is wrong, and K is not kept.
    Wrong,
    /// The energy exceeded that at the start.
    Diverged,
    /// A step failed. The word names the failure.
    Failed(&'static str),
}

/// The largest relative error of a loss 1 - R that counts as right.
pub const TOLERANCE: f64 = 0.1;

impl Decay {
    /// Judges a run of at least two steps with every step recorded. `exact` is the exact ratio R of
    /// the second step.
    pub fn judge(run: &EnergyRun, exact: f64) -> Self {
        let start = run.rows.first().map_or(0.0, |row| row.energy);
        let grown = |energy: f64| energy.is_nan() || energy > start * (1.0 + KEPT);
        if run.rows.iter().any(|row| grown(row.energy)) {
            return Self::Diverged;
        }
        if !run.ending.is_completed() {
            return Self::Failed(run.ending.outcome);
        }
        let kept = run.drift <= KEPT * start;
        let right = second_ratio(run)
            .is_some_and(|found| (found - exact).abs() <= TOLERANCE * (1.0 - exact));
        match (right, kept) {
            (true, true) => Self::Right,
            (true, false) => Self::RightWithoutK,
            (false, true) => Self::WrongWithK,
            (false, false) => Self::Wrong,
        }
    }
}

impl std::fmt::Display for Decay {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Right => "right decay, K exact",
            Self::RightWithoutK => "right decay, K lost",
            Self::WrongWithK => "K exact, wrong decay",
            Self::Wrong => "wrong decay, K lost",
            Self::Diverged => "diverged",
            Self::Failed(word) => return write!(f, "failed: {word}"),
        })
    }
}

impl Serialize for Decay {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// A row of `overdamped.csv`.
#[derive(Clone, Debug, Serialize)]
pub struct DecayRow {
    /// Name of the method.
    pub method: &'static str,
    /// b
    pub b: f64,
    /// The step.
    pub h: f64,
    /// R, the energy after the second step divided by that after the first; none if a step failed.
    #[serde(rename = "R")]
    pub ratio: Option<f64>,
    /// The exact R.
    #[serde(rename = "R_exact")]
    pub exact: f64,
    /// max |K - K0| over all steps done; none if no step was done.
    pub k_drift: Option<f64>,
    /// The verdict.
    pub decay: Decay,
}

/// Judges the runs of every method. They must have the step h and record every step.
///
/// # Errors
/// Errors of the exact solution.
pub fn rows(
    problem: &super::Problem,
    b: f64,
    h: f64,
    runs: &[EnergyRun],
    progress: &dyn Progress,
) -> Result<Vec<DecayRow>, IntegrateError> {
    let system = problem.model.system::<f64>()?;
    let solution = problem.solution(h, 2, progress)?;
    let exact = solution.at(2).energy(&*system) / solution.at(1).energy(&*system);
    let row = |run: &EnergyRun| DecayRow {
        method: run.method,
        b,
        h,
        ratio: second_ratio(run),
        exact,
        k_drift: Some(run.drift).filter(|drift| drift.is_finite() && run.rows.len() > 1),
        decay: Decay::judge(run, exact),
    };
    Ok(runs.iter().map(row).collect())
}

/// R of the second step.
fn second_ratio(run: &EnergyRun) -> Option<f64> {
    run.rows.get(2)?.ratio
}
