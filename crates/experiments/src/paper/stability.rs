//! Stability maps over (h, b) of the damped oscillator and over (h, μ) of Van der Pol.

use super::{Paper, Part, oscillator};
use crate::chart::Axis;
use crate::claim::{Readings, Said};
use crate::findings::stability::{Grid, spectral_radii, verdicts};
use crate::report::Verdict as Holds;
use crate::sheet::{ReportError, Sheet};
use afterbay_analysis::Model;
use afterbay_analysis::study::Problem;
use afterbay_analysis::study::stability::{Map, StabilityRow, Verdict, rules};
use afterbay_systems::VAN_DER_POL;

const MAPPED: [&str; 5] = ["leapfrog", "rk4", "moddg", "moddg-fixed-point", "moddg-q3-shared"];

pub(super) const PART: Part =
    Part { heading: "Stability where methods fail", methods: &[&MAPPED], sheet };

fn sheet(paper: &Paper<'_>, mut sheet: Sheet) -> Result<Sheet, ReportError> {
    sheet.text(format!(
        "Each cell is a run over [0, 20] of at least 50 steps. Its motion is measured by A = \
         T/T_max + |q - c|²/Q² with T = ½ p·∂H/∂p, which is nonnegative for every V. T_max and Q \
         are the largest T and |q| of the reference, and c is its mean of q over the second half \
         of the run. {} \"Several solutions\" means that the equation of a step has more than one \
         solution and the one continued from h = 0 ends. For the damped oscillator the spectral \
         radius of the matrix of one step is shown beside the verdict, where the step is linear.",
        rules()
    ));
    let count = paper.extent.pick(60, 16);
    let steps = spread(count, 0.01, 10.0, true);
    let values = spread(count, 0.0, 10.0, false);
    let map = Map {
        problem: oscillator(),
        parameter: "b",
        values: &values,
        steps: &steps,
        end: 20.0,
        least_steps: 50,
    };
    of_oscillator(paper, &mut sheet, &map)?;
    let problem =
        Problem { model: Model::of(&VAN_DER_POL, &[1.0]), q: vec![2.0], p: vec![0.5], end: 20.0 };
    of_van_der_pol(paper, &mut sheet, &Map { problem, parameter: "mu", ..map })?;
    Ok(sheet)
}

/// The map of the damped oscillator, whose verdicts are compared with the spectral radius.
fn of_oscillator(paper: &Paper<'_>, sheet: &mut Sheet, map: &Map<'_>) -> Result<(), ReportError> {
    let methods = paper.methods(&MAPPED)?;
    paper.progress.begin("stability of the damped oscillator", map.pieces(methods.len()));
    let cells = map.run(&methods, paper.progress)?;
    sheet.data("stability", &cells)?;
    compare_with_spectrum(sheet, &cells);
    let grid = grid("damping b", map);
    for method in MAPPED {
        let rows: Vec<_> = cells.iter().filter(|row| row.method == method).collect();
        let right = verdicts(format!("{method}: verdict"), &grid, &rows).draw();
        let name = format!("stability-{method}");
        let right = sheet.figure(&name, right, "What the run did.", "stability");
        let left = spectral_radii(method, &grid, &rows).map(|map| {
            let name = format!("spectral-radius-{method}");
            let caption = "The exact spectral radius of the step matrix.";
            sheet.figure(&name, map.draw(), caption, "stability")
        });
        sheet.show_pairs(left.into_iter().chain([right]));
    }
    Ok(())
}

fn of_van_der_pol(paper: &Paper<'_>, sheet: &mut Sheet, map: &Map<'_>) -> Result<(), ReportError> {
    let methods = paper.methods(&MAPPED[..4])?;
    paper.progress.begin("stability of Van der Pol", map.pieces(methods.len()));
    let cells = map.run(&methods, paper.progress)?;
    let data = "van-der-pol/stability";
    sheet.data(data, &cells)?;
    first_failures(sheet, &cells);
    let grid = grid("activity μ", map);
    let figure = |method: &&str| {
        let rows: Vec<_> = cells.iter().filter(|row| row.method == *method).collect();
        let chart = verdicts(format!("Van der Pol, {method}"), &grid, &rows);
        let name = format!("stability-van-der-pol-{method}");
        sheet.figure(&name, chart.draw(), "What the run did.", data)
    };
    let figures: Vec<_> = MAPPED[..4].iter().map(figure).collect();
    sheet.show_pairs(figures);
    Ok(())
}

fn grid<'a>(y: &str, map: &Map<'a>) -> Grid<'a> {
    Grid { x: Axis::log("step h"), y: Axis::linear(y), steps: map.steps, values: map.values }
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
    let [linear, unstable, bounded, unbounded, wrong] = COUNTED.map(|what| r.number("cells", what));
    let beside = if bounded == 0.0 && unbounded == 0.0 {
        "no verdict disagrees with it".to_owned()
    } else {
        format!(
            "{bounded} of these stay bounded within the run, and {unbounded} of the others do not"
        )
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
    (Holds::Note, r.each("first failure", one))
}
