//! Tables and sentences that the report of the paper and those of scenes share.

pub(crate) mod long_run;
pub(crate) mod work;

pub(crate) use crate::study::decay::KEPT;

/// Whether K is kept. `drift` is its largest deviation relative to the energy at the start; K is
/// not kept if it is NaN.
pub(crate) fn keeps(drift: f64) -> bool {
    drift <= KEPT
}

/// [`keeps`] in words.
pub(crate) fn kept(drift: f64) -> &'static str {
    if keeps(drift) { "keeps K" } else { "does not keep K" }
}
