//! What accuracy costs, a chart per system.

use super::other_systems::problems;
use super::{Extent, methods, oscillator};
use crate::chart::{Axis, LineChart};
use crate::progress::Progress;
use crate::report::{Block, Verdict};
use crate::sheet::{ReportError, Sheet, marked, measured, scientific};
use crate::study::work_precision::{self, WorkRow};
use afterbay_methods::registry::ADAPTIVE;

const COMPARED: [&str; 7] =
    ["moddg", "leapfrog", "rk4", "moddg-q3-shared", "moddg-qp4", "increment-4", "increment-8"];

/// The columns of a table of runs, see [`cells`].
pub(crate) const HEADER: [&str; 9] = [
    "method",
    "h or tolerance",
    "outcome",
    "error of (q, p)",
    "error of w",
    "max |K - K₀|",
    "steps with Δw < 0",
    "seconds",
    "evaluations",
];

/// What a run costs: a name and the figure.
type Cost = (&'static str, fn(&WorkRow) -> Option<f64>);

pub(super) fn sheet(extent: Extent, progress: &dyn Progress) -> Result<Sheet, ReportError> {
    let mut sheet = Sheet::new("Accuracy against cost");
    sheet.text(
        "Errors at t = 20 against the time of the whole run. Every time is the fastest of several runs, taken one after \
         the other on an otherwise idle program. The error of (q, p) and the error of w are charted apart; the drift of \
         K stands in the table and says nothing of either. Beside the paper's methods stand compositions of coordinate \
         increments, what raises the order without a δ, and methods that choose their steps at tolerances from 1e-3: all of \
         these keep K.",
    );
    let count = extent.pick(9, 4);
    let steps: Vec<f64> = (0..count).map(|k| 0.2 / f64::from(1 << k)).collect();
    let tolerances: Vec<f64> = (0..count).map(|k| 10_f64.powi(-3 - k)).collect();
    let rows = methods(&COMPARED);
    for (name, problem) in std::iter::once(("damped-oscillator", oscillator())).chain(problems()) {
        let runs = rows.len() * steps.len() + ADAPTIVE.len() * tolerances.len();
        progress.begin(&format!("cost of accuracy: {name}"), 2 * runs);
        let found = work_precision::run(&problem, &rows, &steps, &tolerances, progress)?;
        let folder = if name == oscillator().model.name() { String::new() } else { format!("{name}/") };
        let data = format!("{folder}work_precision");
        sheet.data(&data, &found)?;
        sheet.runs.extend(found.iter().map(|row| row.record(problem.model.name())));
        cheapest(&mut sheet, name, &found);
        let seconds: Cost = ("seconds", |row| row.seconds);
        let evaluations: Cost = ("evaluations of the force", |row| row.evaluations.map(|count| count as f64));
        let chart = |title: &str, cost: Cost, error: fn(&WorkRow) -> Option<f64>| LineChart {
            title: format!("{name}: {title}"),
            x: Axis::log(cost.0),
            y: Axis::log(format!("{title} at t = 20")),
            curves: COMPARED
                .into_iter()
                .chain(ADAPTIVE.map(|row| row.name))
                .map(|method| {
                    let of = found.iter().filter(|row| row.method == method);
                    marked(method, of.filter_map(|row| Some(((cost.1)(row)?, error(row)?))).collect())
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
            sheet.figure(&format!("{name}-{file}"), chart.svg(), caption, &data)
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

/// The answer in one sentence: the cheapest way to an error of 1e-4, with and without K.
pub(crate) fn cheapest(sheet: &mut Sheet, name: &str, rows: &[WorkRow]) {
    const WANTED: f64 = 1e-4;
    let best = |keeps: bool| {
        let good = rows.iter().filter(|row| {
            let accurate = row.qp().zip(row.w()).is_some_and(|(qp, w)| qp.bound().max(w.bound()) <= WANTED);
            let exact = row.tolerance.is_some() || methods(&[row.method]).iter().any(|method| method.keeps_k);
            accurate && (exact || !keeps)
        });
        good.min_by(|a, b| a.seconds.unwrap_or(f64::MAX).total_cmp(&b.seconds.unwrap_or(f64::MAX)))
    };
    let say = |row: Option<&WorkRow>| match row {
        Some(row) => format!("{} at {} ({} s)", row.method, row.setting(), scientific(row.seconds)),
        None => "none of these".into(),
    };
    sheet.find(
        &format!("{name}, cost of an error of 1e-4"),
        Verdict::Note,
        format!(
            "in (q, p) and in w the cheapest is {}; with K exact it is {}.",
            say(best(false)),
            say(best(true)),
        ),
    );
}

/// The cells of a run.
pub(crate) fn cells(row: &WorkRow) -> Vec<String> {
    vec![
        row.method.into(),
        row.tolerance.map_or(row.h.to_string(), |tolerance| format!("tolerance {tolerance:e}")),
        row.failure.clone().unwrap_or_else(|| row.outcome.into()),
        measured(row.qp()),
        measured(row.w()),
        scientific(Some(row.k_drift)),
        row.passivity_violations.map_or("none owed".into(), |count| count.to_string()),
        scientific(row.seconds),
        row.evaluations.map_or(String::new(), |count| count.to_string()),
    ]
}
