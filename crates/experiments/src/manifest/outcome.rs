//! The outcome of a run, and the groups of runs that ended alike.

use afterbay_analysis::study::long_run::LongRun;
use afterbay_analysis::study::outcome::{COMPLETED, Ending};
use afterbay_analysis::study::work_precision::WorkRow;
use afterbay_analysis::words::{Word, word};
use serde::{Deserialize, Serialize};

/// The outcome of one run.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct RunOutcome {
    /// The study it belongs to.
    #[serde(deserialize_with = "word")]
    pub study: Word,
    /// The system.
    #[serde(deserialize_with = "word")]
    pub system: Word,
    /// The method.
    #[serde(deserialize_with = "word")]
    pub method: Word,
    /// The step.
    pub h: f64,
    /// The values at the point of a sweep, a diagram or a map, as `a = 1.5, q1 = 0`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub point: Option<String>,
    /// The ending in one word.
    pub outcome: String,
    /// The failure in words.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub failure: Option<String>,
}

impl RunOutcome {
    /// The outcome of a run that ended in this way.
    pub(crate) fn of(ending: &Ending, study: Word, system: Word, method: Word, h: f64) -> Self {
        let Ending { outcome, failure } = ending.clone();
        Self { study, system, method, h, point: None, outcome: outcome.into(), failure }
    }

    /// The outcome of a long run.
    pub(crate) fn of_long_run(run: &LongRun, system: Word) -> Self {
        let study = if run.setup.compensated { "long-run, compensated" } else { "long-run" };
        Self::of(&run.ending, study, system, run.setup.row.name, run.setup.h)
    }

    /// The outcome of a run whose work was measured.
    pub(crate) fn of_work(row: &WorkRow, system: Word) -> Self {
        Self::of(&row.ending(), "work-precision", system, row.method, row.h)
    }
}

/// Runs of a study and a method with one step that ended alike without completing, such as those at
/// the points of a sweep.
#[derive(Clone, Copy, Debug)]
pub struct Alike<'a> {
    /// The first of the runs.
    pub first: &'a RunOutcome,
    /// The number of the runs.
    pub count: usize,
}

impl<'a> Alike<'a> {
    /// The groups of the runs that did not complete, in the order of their first runs.
    pub fn groups(runs: &'a [RunOutcome]) -> Vec<Self> {
        let key = |run: &'a RunOutcome| (run.study, run.method, run.h.to_bits(), &*run.outcome);
        let mut groups: Vec<Self> = Vec::new();
        for run in runs.iter().filter(|run| run.outcome != COMPLETED) {
            match groups.iter_mut().find(|group| key(group.first) == key(run)) {
                Some(group) => group.count += 1,
                None => groups.push(Self { first: run, count: 1 }),
            }
        }
        groups
    }
}
