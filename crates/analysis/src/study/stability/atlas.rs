//! The least step at which each method fails.

use super::piece::StabilityRow;
use super::verdict::Verdict;
use serde::Serialize;

/// The first step of a method, as h grows, at which a verdict is not [`Verdict::Right`], over all
/// values of the parameter and at the middle one. Cells without a reference
/// ([`Verdict::Unjudged`]) are counted apart.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AtlasRow {
    /// Name of the method.
    pub method: &'static str,
    /// Name of the parameter.
    pub parameter: String,
    /// The least h at which a cell is not right; none if all that are judged are right.
    pub h: Option<f64>,
    /// The worst verdict at this h.
    pub verdict: Option<Verdict>,
    /// The number of values with this verdict at this h, and the number of values judged at it.
    pub count: [usize; 2],
    /// The number of cells without a reference, and the number of all cells.
    pub unjudged: [usize; 2],
    /// The least value with this verdict at this h.
    pub from: Option<f64>,
    /// The largest value with this verdict at this h.
    pub to: Option<f64>,
    /// The middle value of the parameter.
    pub middle: f64,
    /// The least h at which the middle value is not right.
    pub middle_h: Option<f64>,
    /// The verdict there.
    pub middle_verdict: Option<Verdict>,
}

/// A row for each method and parameter, in the order of the map.
pub fn atlas(rows: &[StabilityRow]) -> Vec<AtlasRow> {
    let same =
        |a: &StabilityRow, b: &StabilityRow| a.method == b.method && a.parameter == b.parameter;
    rows.chunk_by(same)
        .map(|cells| {
            let first = &cells[0];
            let mut values: Vec<f64> = cells.iter().map(|cell| cell.value).collect();
            values.sort_by(f64::total_cmp);
            values.dedup();
            let middle = values[values.len() / 2];
            let failed = first_failure(cells.iter());
            let at_middle = first_failure(cells.iter().filter(|cell| cell.value == middle));
            let mut alike: Vec<f64> = failed.map_or(Vec::new(), |failed| {
                let alike =
                    |cell: &&StabilityRow| cell.h == failed.h && cell.verdict == failed.verdict;
                cells.iter().filter(alike).map(|cell| cell.value).collect()
            });
            alike.sort_by(f64::total_cmp);
            let unjudged = cells.iter().filter(|cell| cell.verdict == Verdict::Unjudged).count();
            AtlasRow {
                method: first.method,
                parameter: first.parameter.clone(),
                h: failed.map(|cell| cell.h),
                verdict: failed.map(|cell| cell.verdict),
                count: [alike.len(), values.len()],
                unjudged: [unjudged, cells.len()],
                from: alike.first().copied(),
                to: alike.last().copied(),
                middle,
                middle_h: at_middle.map(|cell| cell.h),
                middle_verdict: at_middle.map(|cell| cell.verdict),
            }
        })
        .collect()
}

/// The failed cell with the least h, and among these with the worst verdict.
fn first_failure<'a>(cells: impl Iterator<Item = &'a StabilityRow>) -> Option<&'a StabilityRow> {
    cells
        .filter(|cell| !matches!(cell.verdict, Verdict::Right | Verdict::Unjudged))
        .min_by(|a, b| a.h.total_cmp(&b.h).then(b.verdict.badness().cmp(&a.verdict.badness())))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_step_and_its_values_are_found() {
        let cell = |value: f64, h: f64, verdict: Verdict| StabilityRow {
            method: "rk4",
            h,
            parameter: "c".into(),
            value,
            verdict,
            spectral_radius: None,
            steps_done: 1,
            outcome: "completed",
        };
        use Verdict::{Growing, Right, Unjudged, Wrong};
        let rows = [
            (1.0, [Right, Wrong, Growing]),
            (2.0, [Right, Right, Wrong]),
            (3.0, [Unjudged, Wrong, Growing]),
            (4.0, [Right, Growing, Growing]),
        ]
        .map(|(value, verdicts)| [0, 1, 2].map(|i| cell(value, 0.5 * (i + 1) as f64, verdicts[i])))
        .concat();
        let found = atlas(&rows);
        assert_eq!(found.len(), 1);
        let row = &found[0];
        assert_eq!(
            (row.h, row.verdict, row.from, row.to),
            (Some(1.0), Some(Growing), Some(4.0), Some(4.0))
        );
        assert_eq!((row.count, row.unjudged), ([1, 4], [1, 12]));
        assert_eq!((row.middle, row.middle_h, row.middle_verdict), (3.0, Some(1.0), Some(Wrong)));
        let good = atlas(&[cell(1.0, 0.5, Right)]);
        assert_eq!((good[0].h, good[0].middle_h), (None, None));
        assert_eq!(atlas(&[]), []);
    }
}
