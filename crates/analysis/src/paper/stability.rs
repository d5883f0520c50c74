//! Where methods fail: maps over (h, b) of the damped oscillator and over (h, μ) of Van der Pol.

use super::{Extent, methods, oscillator};
use crate::Model;
use crate::chart::{Axis, Cells, HeatMap};
use crate::progress::Progress;
use crate::report::Verdict as Holds;
use crate::sheet::{ReportError, Sheet};
use crate::study::Problem;
use crate::study::stability::{Map, StabilityRow, Verdict, rules};

const MAPPED: [&str; 5] = ["leapfrog", "rk4", "moddg", "moddg-fixed-point", "moddg-q3-shared"];

pub(super) fn sheet(extent: Extent, progress: &dyn Progress) -> Result<Sheet, ReportError> {
    let mut sheet = Sheet::new("Stability where methods fail");
    sheet.text(format!(
        "Each cell is a run over [0, 20] (50 steps at least). Its motion is measured by A = T/T_max + |q - c|²/Q², with \
         T = ½ p·∂H/∂p, the largest T and |q| of the exact solution and its mean c of q over the second half of the run: never \
         negative, whatever V is. {} \"Several solutions\" \
         is a step whose equation is seen to have more than one while the one that continues from h = 0 ends. For the damped oscillator \
         the spectral radius of the matrix of one step stands beside the verdict, where the step is linear.",
        rules()
    ));
    let count = extent.pick(60, 16);
    let steps = spread(count, 0.01, 10.0, true);
    let values = spread(count, 0.0, 10.0, false);
    let rows = methods(&MAPPED);

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
        let right =
            sheet.figure(&format!("stability-{method}"), verdicts.svg(), "What the run did.", "stability");
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
                radius.svg(),
                "The exact spectral radius of the step matrix.",
                "stability",
            );
            sheet.show_pair(left, right);
        } else {
            sheet.section.blocks.push(crate::report::Block::Figure(right));
        }
    }

    let problem = Problem { model: Model::VanDerPol { mu: 1.0 }, q: vec![2.0], p: vec![0.5], end: 20.0 };
    let map = Map { problem, parameter: "mu", ..map };
    let rows = methods(&MAPPED[..4]);
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
                chart.svg(),
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
        .map(|i| if logarithmic { low * (high / low).powf(share(i)) } else { low + (high - low) * share(i) })
        .collect()
}

fn verdict_map(title: &str, y: &str, map: &Map, cells: &[&StabilityRow]) -> HeatMap {
    let index =
        |row: &&StabilityRow| Verdict::ALL.iter().position(|&verdict| verdict == row.verdict).unwrap_or(0);
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

fn compare_with_spectrum(sheet: &mut Sheet, cells: &[StabilityRow]) {
    for method in ["leapfrog", "rk4", "moddg"] {
        let of = || cells.iter().filter(|row| row.method == method);
        let linear: Vec<_> = of().filter_map(|row| Some((row.spectral_radius?, row))).collect();
        let unstable = linear.iter().filter(|(radius, _)| *radius > 1.0 + 1e-9).count();
        let against = linear.iter().filter(|(radius, row)| (*radius > 1.0 + 1e-9) == bounded(row)).count();
        let wrong = of()
            .filter(|row| {
                row.verdict == Verdict::Wrong
                    && row.spectral_radius.is_some_and(|radius| radius <= 1.0 + 1e-9)
            })
            .count();
        let why = if against > 0 { " (growth that stays below the threshold within the run)" } else { "" };
        sheet.find(&format!("stability of {method}"), Holds::Note, format!(
            "the spectral radius exceeds 1 in {unstable} of {} cells, and {against} verdicts disagree with it{why}; {wrong} \
             cells are stable and have the wrong energy.",
            linear.len()
        ));
    }
}

fn first_failures(sheet: &mut Sheet, cells: &[StabilityRow]) {
    let said: Vec<_> = MAPPED[..4]
        .iter()
        .map(|method| {
            let first = cells
                .iter()
                .filter(|row| row.method == *method && row.verdict != Verdict::Right)
                .min_by(|a, b| a.h.total_cmp(&b.h));
            match first {
                Some(row) => format!(
                    "{method}: {} from h = {:.3} (μ = {:.1})",
                    row.verdict.describe(),
                    row.h,
                    row.value
                ),
                None => format!("{method}: nothing fails"),
            }
        })
        .collect();
    sheet.find("Van der Pol, what breaks first as h grows", Holds::Note, format!("{}.", said.join("; ")));
}
