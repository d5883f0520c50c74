//! Work against precision.

use super::declared::{Boxed, section};
use super::names;
use crate::Measured;
use crate::chart::{Axis, LineChart, Style};
use crate::findings::work::{HEADER, cells, cheapest};
use crate::report::Block;
use crate::scene::{Scene, WorkPrecisionPlan};
use crate::sheet::{ReportError, Sheet, of_errors, table};
use crate::study::work_precision::{WorkPrecision, WorkRow};

/// The table from which the charts are made.
const DATA: &str = "work_precision";

pub(super) fn declared<'a>(
    scene: &'a Scene,
    plan: &'a WorkPrecisionPlan,
) -> Result<Boxed<'a>, ReportError> {
    let by_step = (&plan.methods[..], &plan.steps[..]);
    let by_tolerance = (&plan.adaptive[..], &plan.tolerances[..]);
    let study = WorkPrecision::new(&scene.problem, by_step, by_tolerance)?;
    let made = |_: &WorkPrecision<'_>, parts| sheet(scene, plan, &WorkPrecision::rows(parts));
    Ok(section(["work-precision", "cost of accuracy"], study, made))
}

fn sheet(scene: &Scene, plan: &WorkPrecisionPlan, found: &[WorkRow]) -> Result<Sheet, ReportError> {
    let mut sheet = Sheet::new("Accuracy against cost");
    let (problem, mut all) = (&scene.problem, names(&plan.methods));
    if !plan.tolerances.is_empty() {
        all.extend(names(&plan.adaptive));
    }
    sheet.data(DATA, found)?;
    sheet.runs.extend(found.iter().map(|row| row.record(problem.model.name())));
    sheet.text(format!(
        "Errors at t = {} against the time of the whole run, the fastest of several runs measured \
         one after another. The errors of (q, p) and of w have separate charts. The table also \
         shows the drift of K, which is no measure of either error.",
        problem.end
    ));
    sheet.doubt("Accuracy", found.iter().flat_map(|row| [row.qp(), row.w()]).flatten());
    cheapest(&mut sheet, "The scene", problem, found)?;
    let chart = |title: &str,
                 cost: &str,
                 x: fn(&WorkRow) -> Option<f64>,
                 y: fn(&WorkRow) -> Option<Measured>| LineChart {
        title: title.into(),
        x: Axis::log(cost),
        y: Axis::log(format!("{title} at t = {}", problem.end)),
        curves: all
            .iter()
            .map(|method| {
                let of = found.iter().filter(|row| row.method == *method);
                of_errors(method, Style::LineMarkers, of.filter_map(|row| Some((x(row)?, y(row)?))))
            })
            .collect(),
        guides: Vec::new(),
    };
    let (seconds, evaluations) = ("seconds", "evaluations of the force");
    let count = |row: &WorkRow| row.evaluations.map(|count| count as f64);
    let charts = [
        (
            "work-qp",
            "Error of (q, p) against time.",
            chart("Error of (q, p)", seconds, |row| row.seconds, WorkRow::qp),
        ),
        (
            "work-w",
            "Error of w against time.",
            chart("Error of w", seconds, |row| row.seconds, WorkRow::w),
        ),
        (
            "evaluations-qp",
            "Error of (q, p) against evaluations.",
            chart("Error of (q, p)", evaluations, count, WorkRow::qp),
        ),
        (
            "evaluations-w",
            "Error of w against evaluations.",
            chart("Error of w", evaluations, count, WorkRow::w),
        ),
    ];
    let [qp, w, by_qp, by_w] =
        charts.map(|(name, caption, chart)| sheet.figure(name, chart.draw(), caption, DATA));
    sheet.show_pair(qp, w);
    sheet.section.blocks.push(table(&HEADER, found.iter().map(cells).collect()));
    sheet.fold("errors against evaluations", vec![Block::Pair(by_qp, by_w)]);
    Ok(sheet)
}
