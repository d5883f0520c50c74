//! Maps of stability: the verdicts of a method, and the spectral radius of its step.

use crate::chart::{Axis, Cells, HeatMap};
use afterbay_analysis::study::stability::{StabilityRow, Verdict};

/// The axes of a map, and the steps and values of its cells.
pub(crate) struct Grid<'a> {
    pub(crate) x: Axis,
    pub(crate) y: Axis,
    pub(crate) steps: &'a [f64],
    pub(crate) values: &'a [f64],
}

/// The verdicts of one method over steps and values.
pub(crate) fn verdicts(title: String, grid: &Grid<'_>, rows: &[&StabilityRow]) -> HeatMap {
    let index = |row: &&StabilityRow| row.verdict.badness();
    HeatMap {
        title,
        x: grid.x.clone(),
        y: grid.y.clone(),
        xs: grid.steps.to_vec(),
        ys: grid.values.to_vec(),
        cells: Cells::Verdicts {
            names: Verdict::ALL.map(|verdict| verdict.describe().into()).into(),
            verdicts: rows.iter().map(index).collect(),
        },
    }
}

/// The spectral radii of the step matrix, if all steps of the method are linear.
pub(crate) fn spectral_radii(
    method: &str,
    grid: &Grid<'_>,
    rows: &[&StabilityRow],
) -> Option<HeatMap> {
    let radii = rows.iter().map(|row| row.spectral_radius).collect::<Option<Vec<f64>>>()?;
    let label = "log₁₀ of the spectral radius (0: neither growing nor decaying)".into();
    let values = radii.into_iter().map(f64::log10).collect();
    let cells = Cells::Values { label, span: 1.0, values };
    let title = format!("{method}: spectral radius");
    Some(HeatMap { cells, ..verdicts(title, grid, rows) })
}
