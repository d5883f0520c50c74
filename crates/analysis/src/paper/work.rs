//! Work against precision, with a chart for each system.

use super::other_systems::problems;
use super::{Paper, Part, oscillator};
use crate::chart::{Axis, LineChart};
use crate::findings::work::{HEADER, cells, cheapest};
use crate::report::Block;
use crate::sheet::{ReportError, Sheet, marked};
use crate::study::work_precision::{self, WorkRow};
use afterbay_methods::registry::ADAPTIVE;

pub(super) const PART: Part =
    Part { heading: "Accuracy against cost", methods: &[&COMPARED], sheet };

const COMPARED: [&str; 7] =
    ["moddg", "leapfrog", "rk4", "moddg-q3-shared", "moddg-qp4", "increment-4", "increment-8"];

/// A measure of cost: its name and its value.
type Cost = (&'static str, fn(&WorkRow) -> Option<f64>);

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
    for (name, problem) in std::iter::once(("damped-oscillator", oscillator())).chain(problems()) {
        let runs = rows.len() * steps.len() + ADAPTIVE.len() * tolerances.len();
        progress.begin(&format!("cost of accuracy: {name}"), 2 * runs);
        let adaptive: Vec<_> = ADAPTIVE.iter().collect();
        let found =
            work_precision::run(&problem, (&rows, &steps), (&adaptive, &tolerances), progress)?;
        let folder =
            if name == oscillator().model.name() { String::new() } else { format!("{name}/") };
        let data = format!("{folder}work_precision");
        sheet.data(&data, &found)?;
        sheet.runs.extend(found.iter().map(|row| row.record(problem.model.name())));
        cheapest(&mut sheet, name, &problem, &found)?;
        let seconds: Cost = ("seconds", |row| row.seconds);
        let evaluations: Cost =
            ("evaluations of the force", |row| row.evaluations.map(|count| count as f64));
        let chart = |title: &str, cost: Cost, error: fn(&WorkRow) -> Option<f64>| LineChart {
            title: format!("{name}: {title}"),
            x: Axis::log(cost.0),
            y: Axis::log(format!("{title} at t = 20")),
            curves: COMPARED
                .into_iter()
                .chain(ADAPTIVE.iter().map(|row| row.name))
                .map(|method| {
                    let of = found.iter().filter(|row| row.method == method);
                    marked(
                        method,
                        of.filter_map(|row| Some(((cost.1)(row)?, error(row)?))).collect(),
                    )
                })
                .collect(),
            guides: Vec::new(),
        };
        let charts = [
            (
                "work-qp",
                "Error of (q, p) against time.",
                chart("error of (q, p)", seconds, |row| row.error_qp),
            ),
            ("work-w", "Error of w against time.", chart("error of w", seconds, |row| row.error_w)),
            (
                "evaluations-qp",
                "Error of (q, p) against evaluations.",
                chart("error of (q, p)", evaluations, |row| row.error_qp),
            ),
            (
                "evaluations-w",
                "Error of w against evaluations.",
                chart("error of w", evaluations, |row| row.error_w),
            ),
        ];
        let [qp, w, by_evaluations @ ..] = charts.map(|(file, caption, chart)| {
            sheet.figure(&format!("{name}-{file}"), chart.draw(), caption, &data)
        });
        sheet.show_pair(qp, w);
        let table = found.iter().map(cells).collect();
        let [qp, w] = by_evaluations;
        sheet.fold(
            &format!("{name}: every run, and errors against evaluations"),
            vec![crate::sheet::table(&HEADER, table), Block::Pair(qp, w)],
        );
    }
    Ok(sheet)
}
