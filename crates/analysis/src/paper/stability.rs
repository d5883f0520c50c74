//! Stability maps over (h, b) of the damped oscillator and over (h, μ) of Van der Pol.

use super::{Paper, Part, oscillator};
use crate::Model;
use crate::chart::{Axis, Cells, HeatMap};
use crate::claim::{Readings, Said};
use crate::report::Verdict as Holds;
use crate::sheet::{ReportError, Sheet};
use crate::study::Problem;
use crate::study::stability::{Map, StabilityRow, Verdict, rules};
use afterbay_systems::VAN_DER_POL;

const MAPPED: [&str; 5] = ["leapfrog", "rk4", "moddg", "moddg-fixed-point", "moddg-q3-shared"];

pub(super) const PART: Part =
    Part { heading: "Stability where methods fail", methods: &[&MAPPED], sheet };

fn sheet(paper: &Paper<'_>, mut sheet: Sheet) -> Result<Sheet, ReportError> {
    let Paper { extent, progress, .. } = *paper;
    sheet.text(format!(
        "Each cell is a run over [0, 20] of at least 50 steps. Its motion is measured by A = \
         T/T_max + |q - c|²/Q² with T = ½ p·∂H/∂p, which is nonnegative for every V. T_max and Q \
         are the largest T and |q| of the reference, and c is its mean of q over the second half \
         of the run. {} \"Several solutions\" means that the equation of a step has more than one \
         solution and the one continued from h = 0 ends. For the damped oscillator the spectral \
         radius of the matrix of one step is shown beside the verdict, where the step is linear.",
        rules()
    ));
    let count = extent.pick(60, 16);
    let steps = spread(count, 0.01, 10.0, true);
    let values = spread(count, 0.0, 10.0, false);
    let rows = paper.methods(&MAPPED)?;

    let map = Map {
        problem: oscillator(),
        parameter: "b",
        values: &values,
        steps: &steps,
        end: 20.0,
        least_steps: 50,
    };
    progress.begin("stability of the damped oscillator", map.pieces(rows.len()));
    let cells = map.run(&rows, progress)?;
    sheet.data("stability", &cells)?;
    compare_with_spectrum(&mut sheet, &cells);
    for method in MAPPED {
        let cells: Vec<_> = cells.iter().filter(|row| row.method == method).collect();
        let verdicts = verdict_map(&format!("{method}: verdict"), "damping b", &map, &cells);
        let right = sheet.figure(
            &format!("stability-{method}"),
            verdicts.draw(),
            "What the run did.",
            "stability",
        );
        let radii: Option<Vec<f64>> = cells.iter().map(|row| row.spectral_radius).collect();
        if let Some(radii) = radii {
            let cells = Cells::Values {
                label: "log₁₀ of the spectral radius (0: neither growing nor decaying)".into(),
                span: 1.0,
                values: radii.into_iter().map(f64::log10).collect(),
            };
            let radius = HeatMap { title: format!("{method}: spectral radius"), cells, ..verdicts };
            let left = sheet.figure(
                &format!("spectral-radius-{method}"),
                radius.draw(),
                "The exact spectral radius of the step matrix.",
                "stability",
            );
            sheet.show_pair(left, right);
        } else {
            sheet.section.blocks.push(crate::report::Block::Figure(right));
        }
    }

    let problem =
        Problem { model: Model::of(&VAN_DER_POL, &[1.0]), q: vec![2.0], p: vec![0.5], end: 20.0 };
    let map = Map { problem, parameter: "mu", ..map };
    let rows = paper.methods(&MAPPED[..4])?;
    progress.begin("stability of Van der Pol", map.pieces(rows.len()));
    let cells = map.run(&rows, progress)?;
    sheet.data("van-der-pol/stability", &cells)?;
    first_failures(&mut sheet, &cells);
    let figures: Vec<_> = MAPPED[..4]
        .iter()
        .map(|method| {
            let cells: Vec<_> = cells.iter().filter(|row| row.method == *method).collect();
            let chart = verdict_map(&format!("Van der Pol, {method}"), "activity μ", &map, &cells);
            sheet.figure(
                &format!("stability-van-der-pol-{method}"),
                chart.draw(),
                "What the run did.",
                "van-der-pol/stability",
            )
        })
        .collect();
    for pair in figures.chunks_exact(2) {
        sheet.show_pair(pair[0].clone(), pair[1].clone());
    }
    Ok(sheet)
}

/// `count` values from `low` to `high`.
fn spread(count: usize, low: f64, high: f64, logarithmic: bool) -> Vec<f64> {
    let share = |i: usize| i as f64 / (count - 1) as f64;
    (0..count)
        .map(|i| {
            if logarithmic {
                low * (high / low).powf(share(i))
            } else {
                low + (high - low) * share(i)
            }
        })
        .collect()
}

fn verdict_map(title: &str, y: &str, map: &Map, cells: &[&StabilityRow]) -> HeatMap {
    let index = |row: &&StabilityRow| {
        Verdict::ALL.iter().position(|&verdict| verdict == row.verdict).unwrap_or(0)
    };
    HeatMap {
        title: title.into(),
        x: Axis::log("step h"),
        y: Axis::linear(y),
        xs: map.steps.to_vec(),
        ys: map.values.to_vec(),
        cells: Cells::Verdicts {
            names: Verdict::ALL.map(|verdict| verdict.describe().into()).into(),
            verdicts: cells.iter().map(index).collect(),
        },
    }
}

fn bounded(row: &StabilityRow) -> bool {
    matches!(row.verdict, Verdict::Right | Verdict::Late | Verdict::Wrong)
}

/// Compares the spectral radius with the verdicts.
fn compare_with_spectrum(sheet: &mut Sheet, cells: &[StabilityRow]) {
    for method in ["leapfrog", "rk4", "moddg"] {
        let mut counts = [0_usize; 5];
        for row in cells.iter().filter(|row| row.method == method) {
            let Some(radius) = row.spectral_radius else { continue };
            let unstable = radius > 1.0 + ROUNDING;
            counts[0] += 1;
            counts[1] += usize::from(unstable);
            counts[2] += usize::from(unstable && bounded(row));
            counts[3] += usize::from(!unstable && !bounded(row));
            counts[4] += usize::from(!unstable && bounded(row) && row.verdict != Verdict::Right);
        }
        let readings = COUNTED
            .iter()
            .zip(counts)
            .fold(Readings::default(), |r, (what, count)| r.and("cells", what, count));
        sheet.find(&format!("stability of {method}"), readings, beside_the_spectrum);
    }
}

/// The largest excess of a spectral radius over 1 that counts as rounding.
const ROUNDING: f64 = 1e-9;

const COUNTED: [&str; 5] =
    ["linear", "unstable", "unstable and bounded", "stable and unbounded", "stable, not right"];

fn beside_the_spectrum(r: &Readings) -> Said {
    let [linear, unstable, quiet, loud, wrong] = COUNTED.map(|what| r.number("cells", what));
    let beside = if quiet == 0.0 && loud == 0.0 {
        "no verdict disagrees with it".to_owned()
    } else {
        format!("{quiet} of these stay bounded within the run, and {loud} of the others do not")
    };
    let statement = format!(
        "the spectral radius exceeds 1 in {unstable} of {linear} cells, and {beside}; {wrong} \
         cells are stable and bounded and not right."
    );
    (Holds::Note, statement)
}

fn first_failures(sheet: &mut Sheet, cells: &[StabilityRow]) {
    let readings = MAPPED[..4].iter().fold(Readings::default(), |r, method| {
        let failed =
            cells.iter().filter(|row| row.method == *method && row.verdict != Verdict::Right);
        let first = failed.min_by(|a, b| a.h.total_cmp(&b.h));
        r.and(method, "first failure", first.map_or("", |row| row.verdict.describe()))
            .and(method, "h", first.map(|row| row.h))
            .and(method, "μ", first.map(|row| row.value))
    });
    sheet.find("Van der Pol, the first failure as h grows", readings, what_breaks_first);
}

fn what_breaks_first(r: &Readings) -> Said {
    let one = |method: &str| match r.word(method, "first failure") {
        "" => format!("{method}: nothing fails"),
        verdict => {
            let (h, mu) = (r.number(method, "h"), r.number(method, "μ"));
            format!("{method}: {verdict} from h = {h:.3} (μ = {mu:.1})")
        }
    };
    let all: Vec<_> = r.of_all("first failure").into_iter().map(one).collect();
    (Holds::Note, format!("{}.", all.join("; ")))
}
