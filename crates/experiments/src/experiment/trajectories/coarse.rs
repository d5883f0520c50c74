//! The warning that a tolerance is coarse: it is an absolute error where q or p stays small.

use super::Run;
use crate::claim::{Readings, sci};
use crate::scene::RunPlan;

/// The largest size of q or p that is judged. From 1 on, a tolerance is a relative error.
const SMALL: f64 = 0.1;
/// The share of the size of q or p from which on an error is coarse.
const COARSE: f64 = 0.01;

/// Reads the tolerance, and the sizes of q and p for which it is coarse, in the first run that
/// followed it.
pub(super) fn read(plan: &RunPlan, found: &[Run], readings: &mut Readings) {
    let Some(tolerance) = plan.tolerance else { return };
    let by_tolerance = |run: &&Run| plan.adaptive.iter().any(|row| row.name == run.shown.method);
    let Some(run) = found.iter().find(by_tolerance) else { return };
    let largest = |x: f64, entries: &[f64]| entries.iter().fold(x, |x, entry| x.max(entry.abs()));
    let [mut q, mut p] = [0.0; 2];
    for row in &run.shown.rows {
        (q, p) = (largest(q, &row.q), largest(p, &row.p));
    }
    for (name, size) in [("q", q), ("p", p)] {
        if size > 0.0 && size < SMALL && tolerance > COARSE * size {
            readings.add(name, "size", size);
            readings.add("tolerance", "coarse", tolerance);
        }
    }
}

/// The sentences on the readings.
pub(super) fn say(r: &Readings) -> String {
    let sizes = r.numbers("size").into_iter();
    let sizes: Vec<String> =
        sizes.map(|(name, size)| format!("|{name}| is {} at most", sci(size))).collect();
    if sizes.is_empty() {
        return String::new();
    }
    format!(
        " The tolerance {} is an absolute error below 1, but {}. Choose units in which q and p are \
         near 1, or a smaller tolerance.",
        sci(r.number("tolerance", "coarse")),
        sizes.join(" and ")
    )
}
