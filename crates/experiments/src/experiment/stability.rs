//! Stability: a map of verdicts for each method, and an atlas of first failures.

use super::declared::{Boxed, section};
use super::names;
use crate::claim::{Readings, Said, fixed, in_short, sci, significant};
use crate::findings::stability::{Grid, spectral_radii, verdicts};
use crate::manifest::RunOutcome;
use crate::report::Verdict as Holds;
use crate::scene::{Scene, StabilityPlan};
use crate::sheet::{ReportError, Sheet, spaced};
use afterbay_analysis::study::outcome::{Ending, INTERRUPTED};
use afterbay_analysis::study::stability::{
    AtlasRow, Map, StabilityRow, Tiles, Verdict, atlas, rules,
};
use std::collections::HashSet;

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
        "Each cell is a run over [0, {}], or over {LEAST_STEPS} steps where these take longer. Its \
         motion is measured by A = T/T_max + |q - c|²/Q² with T = ½ p·∂H/∂p. T_max and Q are the \
         largest T and |q| of the reference, and c is its mean of q over the second half of the \
         run. {} Where the step is linear, the spectral radius of its matrix is shown beside the \
         verdict.",
        plan.end,
        rules()
    ));
    sheet.data(DATA, found)?;
    let whole = plan.methods.len() * plan.steps.len() * plan.values.len();
    if found.len() < whole {
        let missing = format!("{} of {whole} cells were not begun", whole - found.len());
        sheet.text(format!("Interrupted: {missing}, and the maps are left out."));
        let ending = Ending { outcome: INTERRUPTED, failure: Some(missing) };
        let model = scene.problem.model.name();
        sheet.runs.push(RunOutcome::of(&ending, "stability", model, "all", scene.step));
        return Ok(sheet);
    }
    let rows = atlas(found);
    let digits = digits(&plan.steps);
    sheet.find("First failure as h grows", readings(&rows, digits), what_breaks_first);
    charts(&mut sheet, scene, plan, found);
    sheet.text(
        "Map of failures: the first step of each method, as h grows, at which a verdict is not \
         right, with the worst verdict there and the values that have it; and the same at the \
         middle value.",
    );
    sheet.table(&HEADER, rows.iter().map(|row| cells(row, digits)).collect());
    Ok(sheet)
}

fn readings(rows: &[AtlasRow], digits: Option<usize>) -> Readings {
    let mut steps = Readings::default();
    if let Some(digits) = digits {
        steps.add("steps", "digits", digits as f64);
    }
    rows.iter().fold(steps, |r, row| {
        let first = row.verdict.map_or("", Verdict::describe);
        let ([failed, values], [unjudged, cells]) = (row.count, row.unjudged);
        r.and(row.method, "unjudged", unjudged)
            .and(row.method, "cells", cells)
            .and(row.method, "first failure", first)
            .and(row.method, "h", row.h)
            .and(row.method, "failed", failed)
            .and(row.method, "values", values)
            .and(row.method, "parameter", row.parameter.as_str())
    })
}

/// Shows the verdicts of each method, and beside them the spectral radii where its steps are
/// linear.
fn charts(sheet: &mut Sheet, scene: &Scene, plan: &StabilityPlan, found: &[StabilityRow]) {
    let grid = Grid {
        x: spaced(&scene.units.time("step h"), plan.step_spacing),
        y: spaced(&plan.parameter, plan.spacing),
        steps: &plan.steps,
        values: &plan.values,
    };
    let mut figures = Vec::new();
    for method in names(&plan.methods) {
        let rows: Vec<_> = found.iter().filter(|row| row.method == method).collect();
        let map = verdicts(format!("{method}: verdict"), &grid, &rows);
        let name = format!("stability-{method}");
        figures.push(sheet.figure(&name, map.draw(), "What the run did.", DATA));
        if let Some(map) = spectral_radii(method, &grid, &rows) {
            let (name, caption) = (
                format!("spectral-radius-{method}"),
                "The exact spectral radius of the step matrix.",
            );
            figures.push(sheet.figure(&name, map.draw(), caption, DATA));
        }
    }
    sheet.show_pairs(figures);
}

const HEADER: [&str; 7] =
    ["method", "first failure", "from h", "at values", "at the middle value", "from h", "value"];

/// The number of significant digits that tells the steps of a map apart; none if the short form of
/// [`step`] does.
fn digits(steps: &[f64]) -> Option<usize> {
    let distinct = steps.iter().map(|h| h.to_bits()).collect::<HashSet<_>>().len();
    let is_told = |digits: &Option<usize>| {
        steps.iter().map(|&h| step(h, *digits)).collect::<HashSet<_>>().len() == distinct
    };
    std::iter::once(None).chain((3..=MOST_DIGITS).map(Some)).find(is_told).flatten()
}

/// The digits that tell any two numbers apart.
const MOST_DIGITS: usize = 17;

/// A step for a sentence, with these significant digits; without them with three decimals, or two
/// digits if it is small.
fn step(h: f64, digits: Option<usize>) -> String {
    match digits {
        Some(digits) => significant(h, digits),
        None if h < 0.01 => sci(h),
        None => fixed(h, 3),
    }
}

fn what_breaks_first(r: &Readings) -> Said {
    let digits = r.known("steps", "digits").map(|digits| digits as usize);
    let one = |method: &str| {
        let number = |what: &str| r.number(method, what);
        let [unjudged, cells] = ["unjudged", "cells"].map(number);
        if unjudged == cells {
            return format!("{method}: no cell is judged");
        }
        let judged = match r.word(method, "first failure") {
            "" => format!("{method}: nothing fails"),
            verdict => {
                let [h, failed, values] = ["h", "failed", "values"].map(number);
                let (h, of) = (step(h, digits), r.word(method, "parameter"));
                format!("{method}: {verdict} at h = {h} ({failed} of {values} values of {of})")
            }
        };
        match unjudged {
            0.0 => judged,
            _ => format!("{judged}, in the {} of {cells} cells that are judged", cells - unjudged),
        }
    };
    (Holds::Note, r.each("first failure", one))
}

fn cells(row: &AtlasRow, digits: Option<usize>) -> Vec<String> {
    let [unjudged, cells] = row.unjudged;
    let without = if unjudged == cells { "not judged" } else { "nothing fails" };
    let verdict = |verdict: Option<Verdict>| verdict.map_or(without, Verdict::describe).to_owned();
    let step = |h: Option<f64>| h.map_or(String::new(), |h| step(h, digits));
    let values = row.from.zip(row.to).map_or(String::new(), |(from, to)| {
        let [from, to] = [from, to].map(in_short);
        if from == to { from } else { format!("{from} to {to}") }
    });
    vec![
        row.method.into(),
        verdict(row.verdict),
        step(row.h),
        values,
        verdict(row.middle_verdict),
        step(row.middle_h),
        format!("{} = {}", row.parameter, in_short(row.middle)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn different_steps_are_told_apart() {
        let said = |steps: &[f64]| {
            let digits = digits(steps);
            steps.iter().map(|&h| step(h, digits)).collect::<Vec<_>>()
        };
        assert_eq!(said(&[0.004, 0.148, 1.5]), ["4.0e-3", "0.148", "1.500"]);
        assert_eq!(said(&[0.0401, 0.0402]), ["0.0401", "0.0402"]);
        assert_eq!(said(&[4.001e-3, 4.002e-3, 4.002e-3]), ["0.004001", "0.004002", "0.004002"]);
        let close = [0.1, 0.1_f64.next_up()];
        assert_ne!(said(&close)[0], said(&close)[1]);
    }

    #[test]
    fn cells_that_are_not_judged_are_counted() {
        let row = AtlasRow {
            method: "rk4",
            parameter: "c".into(),
            h: None,
            verdict: None,
            count: [0, 4],
            unjudged: [0, 12],
            from: None,
            to: None,
            middle: 1.0,
            middle_h: None,
            middle_verdict: None,
        };
        let says = |unjudged: usize, verdict: Option<Verdict>| {
            let (h, count) = (verdict.map(|_| 0.5), [usize::from(verdict.is_some()), 4]);
            let row = AtlasRow { unjudged: [unjudged, 12], verdict, h, count, ..row.clone() };
            what_breaks_first(&readings(&[row], None)).1
        };
        assert_eq!(says(0, None), "rk4: nothing fails.");
        assert_eq!(says(12, None), "rk4: no cell is judged.");
        assert_eq!(says(3, None), "rk4: nothing fails, in the 9 of 12 cells that are judged.");
        let short = AtlasRow { middle: 0.00125, from: Some(0.0012), to: Some(2.0), ..row.clone() };
        assert_eq!([3, 6].map(|i| cells(&short, None)[i].clone()), ["0.0012 to 2", "c = 0.00125"]);
        let wrong = says(3, Some(Verdict::Wrong));
        assert!(wrong.contains("(1 of 4 values of c), in the 9 of 12 cells"), "{wrong}");
    }
}
