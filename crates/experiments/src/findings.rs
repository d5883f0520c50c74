//! Tables and sentences that the report of the paper and those of scenes share.

pub(crate) mod long_run;
pub(crate) mod stability;
pub(crate) mod work;
pub(crate) mod work_charts;

pub(crate) use afterbay_analysis::study::kept::KEPT;

use crate::claim::Readings;
use afterbay_analysis::study::outcome::COMPLETED;

/// Whether the run of each subject that has the quantity `what` reached its end.
pub(crate) fn all_completed(r: &Readings, what: &str) -> bool {
    r.of_all(what).iter().all(|of| r.word(of, "run") == COMPLETED)
}

/// Whether the quantity `what` is 0 for each subject that has it.
pub(crate) fn all_zero(r: &Readings, what: &str) -> bool {
    r.numbers(what).iter().all(|(_, failed)| *failed == 0.0)
}

/// The end of a part of a sentence: how the run of a subject ended, unless it reached its end.
pub(crate) fn ended(r: &Readings, of: &str) -> String {
    match r.word(of, "run") {
        COMPLETED => String::new(),
        run => format!(" ({run})"),
    }
}

/// Whether K is kept. `drift` is its largest deviation relative to the energy at the start, or to
/// the largest energy; K is not kept if it is NaN.
pub(crate) fn keeps(drift: f64) -> bool {
    drift <= KEPT
}

/// [`keeps`] in words.
pub(crate) fn kept(drift: f64) -> &'static str {
    if keeps(drift) { "keeps K" } else { "does not keep K" }
}
