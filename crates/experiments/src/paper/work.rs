//! Work against precision, with a chart for each system.

use super::other_systems::problems;
use super::{Paper, Part, oscillator};
use crate::findings::work::{HEADER, cells, cheapest};
use crate::findings::work_charts::{EVALUATIONS, Runs, TIME, as_measured};
use crate::manifest::RunOutcome;
use crate::report::Block;
use crate::sheet::{ReportError, Sheet, table};
use afterbay_analysis::study::Problem;
use afterbay_analysis::study::work_precision::{self, WorkRow};
use afterbay_methods::registry::ADAPTIVE;

pub(super) const PART: Part =
    Part { heading: "Accuracy against cost", methods: &[&COMPARED], sheet };

const COMPARED: [&str; 7] =
    ["moddg", "leapfrog", "rk4", "moddg-q3-shared", "moddg-qp4", "increment-4", "increment-8"];

fn sheet(paper: &Paper<'_>, mut sheet: Sheet) -> Result<Sheet, ReportError> {
    let Paper { extent, progress, .. } = *paper;
    sheet.text(
        "Errors at t = 20 against the time of the whole run, the fastest of several runs measured \
         one after another while nothing else is computed. The errors of (q, p) and of w have \
         separate charts. The table also shows the drift of K, which is no measure of either \
         error. The paper's methods are compared with compositions of coordinate increments, other \
         methods of higher order without a δ, and methods that choose their steps, at tolerances \
         from 1e-3.",
    );
    let count = extent.pick(9, 4);
    let steps: Vec<f64> = (0..count).map(|k| 0.2 / f64::from(1 << k)).collect();
    let tolerances: Vec<f64> = (0..count).map(|k| 10_f64.powi(-3 - k)).collect();
    let rows = paper.methods(&COMPARED)?;
    let cases = std::iter::once(("damped-oscillator", oscillator())).chain(problems());
    for (name, problem) in cases {
        let runs = rows.len() * steps.len() + ADAPTIVE.len() * tolerances.len();
        progress.begin(&format!("cost of accuracy: {name}"), 2 * runs);
        let adaptive: Vec<_> = ADAPTIVE.iter().collect();
        let all = work_precision::Runs {
            methods: &rows,
            steps: &steps,
            adaptive: &adaptive,
            tolerances: &tolerances,
        };
        let found = work_precision::run(&problem, all, progress)?;
        of_system(&mut sheet, name, &problem, &found)?;
    }
    Ok(sheet)
}

/// The table, the findings and the charts of the runs of a system.
fn of_system(
    sheet: &mut Sheet,
    name: &str,
    problem: &Problem,
    found: &[WorkRow],
) -> Result<(), ReportError> {
    let is_first = name == oscillator().model.name();
    let folder = if is_first { String::new() } else { format!("{name}/") };
    let data = format!("{folder}work_precision");
    sheet.data(&data, found)?;
    sheet.runs.extend(found.iter().map(|row| RunOutcome::of_work(row, problem.model.name())));
    cheapest(sheet, name, found);
    let methods: Vec<_> = COMPARED.into_iter().chain(ADAPTIVE.iter().map(|row| row.name)).collect();
    let (end, methods, curve) = (problem.end, &methods[..], as_measured);
    let runs = Runs { name: Some(name), end, methods, found, curve };
    let [[qp, w], [by_qp, by_w]] = [TIME, EVALUATIONS].map(|cost| {
        runs.against(&cost).map(|(file, caption, chart)| {
            sheet.figure(&format!("{name}-{file}"), chart.draw(), caption, &data)
        })
    });
    sheet.show_pair(qp, w);
    sheet.fold(
        &format!("{name}: every run, and errors against evaluations"),
        vec![table(&HEADER, found.iter().map(cells).collect()), Block::Pair(by_qp, by_w)],
    );
    Ok(())
}
