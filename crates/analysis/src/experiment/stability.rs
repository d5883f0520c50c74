//! Stability: a map of verdicts for each method, and an atlas of first failures.

use super::declared::{Boxed, section};
use super::names;
use crate::chart::{Axis, Cells, HeatMap};
use crate::claim::{Readings, Said};
use crate::record::RunOutcome;
use crate::report::{Block, Verdict as Holds};
use crate::scene::{Scene, Spacing, StabilityPlan, UnitsTable};
use crate::sheet::{ReportError, Sheet};
use crate::study::outcome::INTERRUPTED;
use crate::study::stability::{AtlasRow, Map, StabilityRow, Tiles, Verdict, atlas, rules};

/// The table from which the maps are made.
const DATA: &str = "stability";
/// The least number of steps of a run. Shorter runs show nothing.
const LEAST_STEPS: u64 = 50;

pub(super) fn declared<'a>(
    scene: &'a Scene,
    plan: &'a StabilityPlan,
) -> Result<Boxed<'a>, ReportError> {
    let map = Map {
        problem: scene.problem.clone(),
        parameter: &plan.parameter,
        values: &plan.values,
        steps: &plan.steps,
        end: plan.end,
        least_steps: LEAST_STEPS,
    };
    let study = Tiles::new(map, &plan.methods)?;
    let made = |study: &Tiles<'_>, parts| sheet(scene, plan, &study.rows(parts));
    Ok(section(["stability", "stability"], study, made))
}

fn sheet(
    scene: &Scene,
    plan: &StabilityPlan,
    found: &[StabilityRow],
) -> Result<Sheet, ReportError> {
    let mut sheet = Sheet::new("Stability where methods fail");
    sheet.text(format!(
        "Each cell is a run over [0, {}] of at least {LEAST_STEPS} steps. Its motion is measured \
         by A = T/T_max + |q - c|²/Q² with T = ½ p·∂H/∂p. T_max and Q are the largest T and |q| of \
         the reference, and c is its mean of q over the second half of the run. {} Where the step \
         is linear, the spectral radius of its matrix is shown beside the verdict.",
        plan.end,
        rules()
    ));
    sheet.data(DATA, found)?;
    let whole = plan.methods.len() * plan.steps.len() * plan.values.len();
    let model = scene.problem.model.name();
    if found.len() < whole {
        let missing = format!("{} of {whole} cells were not begun", whole - found.len());
        let outcome = INTERRUPTED.into();
        let (study, method, h) = ("stability", "all", scene.step);
        sheet.runs.push(RunOutcome {
            study,
            system: model,
            method,
            h,
            outcome,
            failure: Some(missing.clone()),
        });
        sheet.text(format!("Interrupted: {missing}, and the maps are left out."));
        return Ok(sheet);
    }
    let rows = atlas(found);
    let readings = rows.iter().fold(Readings::default(), |r, row| {
        let first = row.verdict.map_or("", Verdict::describe);
        r.and(row.method, "first failure", first).and(row.method, "h", row.h)
    });
    sheet.find("First failure as h grows", readings, what_breaks_first);
    let mut figures = Vec::new();
    for method in names(&plan.methods) {
        let cells: Vec<_> = found.iter().filter(|row| row.method == method).collect();
        let verdicts = verdict_map(&format!("{method}: verdict"), plan, &cells, &scene.units);
        let name = format!("stability-{method}");
        figures.push(sheet.figure(&name, verdicts.draw(), "What the run did.", DATA));
        let radii: Option<Vec<f64>> = cells.iter().map(|row| row.spectral_radius).collect();
        if let Some(radii) = radii {
            let cells = Cells::Values {
                label: "log₁₀ of the spectral radius (0: neither growing nor decaying)".into(),
                span: 1.0,
                values: radii.into_iter().map(f64::log10).collect(),
            };
            let radius = HeatMap { title: format!("{method}: spectral radius"), cells, ..verdicts };
            let caption = "The exact spectral radius of the step matrix.";
            figures.push(sheet.figure(
                &format!("spectral-radius-{method}"),
                radius.draw(),
                caption,
                DATA,
            ));
        }
    }
    let mut figures = figures.into_iter();
    while let Some(left) = figures.next() {
        match figures.next() {
            Some(right) => sheet.show_pair(left, right),
            None => sheet.section.blocks.push(Block::Figure(left)),
        }
    }
    sheet.text(
        "Map of failures: the first verdict of each method that is not right as h grows, over all \
         values and at the middle one.",
    );
    let header = [
        "method",
        "first failure",
        "from h",
        "at values",
        "at the middle value",
        "from h",
        "value",
    ];
    sheet.table(&header, rows.iter().map(cells_of).collect());
    Ok(sheet)
}

fn what_breaks_first(r: &Readings) -> Said {
    let one = |method: &str| match r.word(method, "first failure") {
        "" => format!("{method}: nothing fails"),
        verdict => format!("{method}: {verdict} from h = {:.3}", r.number(method, "h")),
    };
    let all: Vec<_> = r.of_all("first failure").into_iter().map(one).collect();
    (Holds::Note, format!("{}.", all.join("; ")))
}

fn cells_of(row: &AtlasRow) -> Vec<String> {
    let verdict =
        |verdict: Option<Verdict>| verdict.map_or("nothing fails", Verdict::describe).to_owned();
    let step = |h: Option<f64>| h.map_or(String::new(), |h| format!("{h:.4}"));
    let values = row.from.zip(row.to).map_or(String::new(), |(from, to)| {
        if from == to { format!("{from:.3}") } else { format!("{from:.3} to {to:.3}") }
    });
    vec![
        row.method.into(),
        verdict(row.verdict),
        step(row.h),
        values,
        verdict(row.middle_verdict),
        step(row.middle_h),
        format!("{} = {:.3}", row.parameter, row.middle),
    ]
}

/// The verdicts of one method over steps and values, as a map.
fn verdict_map(
    title: &str,
    plan: &StabilityPlan,
    cells: &[&StabilityRow],
    units: &UnitsTable,
) -> HeatMap {
    let index = |row: &&StabilityRow| {
        Verdict::ALL.iter().position(|&verdict| verdict == row.verdict).unwrap_or(0)
    };
    let axis = |label: &str, spacing| match spacing {
        Spacing::Linear => Axis::linear(label),
        Spacing::Log => Axis::log(label),
    };
    HeatMap {
        title: title.into(),
        x: axis(&units.time("step h"), plan.step_spacing),
        y: axis(&plan.parameter, plan.spacing),
        xs: plan.steps.clone(),
        ys: plan.values.clone(),
        cells: Cells::Verdicts {
            names: Verdict::ALL.map(|verdict| verdict.describe().into()).into(),
            verdicts: cells.iter().map(index).collect(),
        },
    }
}
