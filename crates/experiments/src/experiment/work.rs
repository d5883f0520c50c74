//! Work against precision.

use super::declared::{Boxed, section};
use super::names;
use crate::findings::work::{HEADER, cells, cheapest};
use crate::findings::work_charts::{EVALUATIONS, Runs, TIME, with_bounds};
use crate::manifest::RunOutcome;
use crate::report::Block;
use crate::scene::{Scene, WorkPrecisionPlan};
use crate::sheet::{ReportError, Sheet};
use afterbay_analysis::study::work_precision::{self, WorkPrecision, WorkRow};

/// The table from which the charts are made.
const DATA: &str = "work_precision";

pub(super) fn declared<'a>(
    scene: &'a Scene,
    plan: &'a WorkPrecisionPlan,
) -> Result<Boxed<'a>, ReportError> {
    let WorkPrecisionPlan { methods, steps, adaptive, tolerances, .. } = plan;
    let runs = work_precision::Runs { methods, steps, adaptive, tolerances };
    let study = WorkPrecision::new(&scene.problem, runs)?;
    let made = |_: &WorkPrecision<'_>, parts| sheet(scene, plan, &WorkPrecision::rows(parts));
    Ok(section(["work-precision", "cost of accuracy"], study, made))
}

fn sheet(scene: &Scene, plan: &WorkPrecisionPlan, found: &[WorkRow]) -> Result<Sheet, ReportError> {
    let (mut sheet, problem) = (Sheet::new("Accuracy against cost"), &scene.problem);
    sheet.data(DATA, found)?;
    sheet.runs.extend(found.iter().map(|row| RunOutcome::of_work(row, problem.model.name())));
    sheet.text(format!(
        "Errors at t = {} against the time of the whole run, the fastest of several runs measured \
         one after another. The errors of (q, p) and of w have separate charts. The table also \
         shows the drift of K, which is no measure of either error.",
        problem.end
    ));
    sheet.doubt("Accuracy", found.iter().flat_map(|row| [row.qp(), row.w()]).flatten());
    cheapest(&mut sheet, "The scene", found);
    let mut methods = names(&plan.methods);
    methods.extend(names(&plan.adaptive));
    let runs = Runs { name: None, end: problem.end, methods: &methods, found, curve: with_bounds };
    let [[qp, w], [by_qp, by_w]] = [TIME, EVALUATIONS].map(|cost| {
        runs.against(&cost)
            .map(|(name, caption, chart)| sheet.figure(&name, chart.draw(), caption, DATA))
    });
    sheet.show_pair(qp, w);
    sheet.table(&HEADER, found.iter().map(cells).collect());
    sheet.fold("errors against evaluations", vec![Block::Pair(by_qp, by_w)]);
    Ok(sheet)
}
