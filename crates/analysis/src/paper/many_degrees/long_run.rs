//! What the roundings of very many steps do to K.

use super::chain;
use crate::Model;
use crate::chart::{Axis, Curve, LineChart};
use crate::paper::{Extent, methods};
use crate::progress::Progress;
use crate::report::Verdict;
use crate::sheet::{ReportError, Sheet, marked, scientific};
use crate::statistics::Fit;
use crate::study::Problem;
use crate::study::long_run::{self, LongRun, Setup};
use std::f64::consts::PI;

/// Name, step, and whether roundings are kept from adding up.
const RUNS: [(&str, f64, bool); 7] = [
    ("increment-4", 0.1, false),
    ("gonzalez", 0.05, false),
    ("increment-2", 0.2, false),
    ("increment-2", 0.2, true),
    ("increment-2", 0.05, false),
    ("increment-4", 0.1, true),
    ("rk4", 0.05, false),
];

/// K is kept if it moves by no more than this beside itself.
const ROUNDING: f64 = 1e-12;

/// An exponent agrees with another within this, however narrow its interval.
const AGREEMENT: f64 = 0.05;

/// A chain of 8 without friction, from rest as a sine of the amplitude 1 or a little more: the roundings of no two starts
/// are the same.
pub(super) fn starts(extent: Extent) -> Vec<Problem> {
    let n = 8;
    let start = |i: u32| {
        let amplitude = 1.0 + f64::from(i) / 1024.0;
        let sine = |j: usize| amplitude * (PI * j as f64 / (n + 1) as f64).sin();
        let model = Model::FputChain { n, beta: 1.0, c: 0.0 };
        Problem { model, q: (1..=n).map(sine).collect(), ..chain(n, 0.0) }
    };
    (0..extent.pick(4, 2)).map(start).collect()
}

pub(in crate::paper) fn add(
    sheet: &mut Sheet,
    extent: Extent,
    progress: &dyn Progress,
) -> Result<(), ReportError> {
    let (starts, steps) = (starts(extent), extent.pick(1_000_000, 100_000));
    let setup =
        |&(name, h, compensated)| methods(&[name]).into_iter().map(move |row| Setup { row, h, compensated });
    let setups: Vec<_> = RUNS.iter().flat_map(setup).collect();
    progress.begin("K in a long run", setups.len() * starts.len());
    let found = long_run::run(&starts, &setups, steps, progress)?;
    let rows: Vec<_> = found.iter().flat_map(|run| &run.rows).collect();
    sheet.data("fput-chain/long_run", &rows)?;
    sheet.runs.extend(found.iter().map(|run| {
        let study = if run.setup.compensated { "long-run, compensated" } else { "long-run" };
        run.ending.record(study, "fput-chain", run.setup.row.name, run.setup.h)
    }));
    sheet.text(format!(
        "A method that keeps K moves it by the roundings of each step. How do they add up? On a chain of 8 without friction \
         (β = 1, at rest as a sine), {steps} steps from each of {} starts with the amplitudes 1, 1 + 1/1024, …; K in 106 bits \
         at some hundred samples in each of four windows a decade. Roundings that are independent grow like √t, those that lean to one \
         side like t. The exponent is the slope of log rms against log t over the last two decades, with the 95 % \
         interval of that line; the windows of a run are not independent, so the interval is on the narrow side. A run that is compensated \
         solves each equation to extended precision and carries what q, p and w lose to rounding on to the next step: what is left of \
         K - K₀ is the rounding of the state it is seen at.",
        starts.len()
    ));
    judge(sheet, &found, steps);
    sheet.table(
        &[
            "method and step",
            "exponent of t",
            "interval",
            "grows",
            "rms at the end",
            "mean at the end",
            "run",
        ],
        found.iter().map(cells).collect(),
    );
    let chart = LineChart {
        title: "The chain without friction: K in a long run".into(),
        x: Axis::log("time t"),
        y: Axis::log("|K - K₀| / |K₀|, rms of a window"),
        curves: found.iter().map(chart_of).collect(),
        guides: vec![0.5, 1.0],
    };
    sheet.show(
        "fput-chain-long-run",
        &chart,
        "Deviation of K beside K, root mean square over the samples of a window and the starts. Dashed: growth like √t and \
         like t.",
        "fput-chain/long_run",
    );
    Ok(())
}

/// The deviation of K over time.
pub(crate) fn chart_of(run: &LongRun) -> Curve {
    marked(&run.setup.label(), run.rows.iter().map(|row| (row.t, row.rms)).collect())
}

/// What an exponent says, as far as its interval lets it.
pub(crate) fn grows(fit: &Fit) -> &'static str {
    let margin = fit.margin.map_or(f64::INFINITY, |margin| margin.max(AGREEMENT));
    let may_be = |exponent: f64| (fit.slope - exponent).abs() <= margin;
    if may_be(0.0) && !may_be(0.5) {
        return "not at all";
    }
    match (may_be(0.5), may_be(1.0)) {
        (true, true) => "like √t or like t: not told apart",
        (true, false) => "like √t",
        (false, true) => "like t",
        (false, false) if fit.slope < 0.5 => "slower than √t",
        (false, false) if fit.slope < 1.0 => "faster than √t, slower than t",
        (false, false) => "faster than t",
    }
}

pub(crate) fn cells(run: &LongRun) -> Vec<String> {
    let (growth, last) = (run.growth(), run.rows.last());
    vec![
        run.setup.label(),
        growth.map_or(String::new(), |fit| format!("{:.2}", fit.slope)),
        growth.and_then(|fit| fit.margin).map_or(String::new(), |margin| format!("± {margin:.2}")),
        growth.as_ref().map_or("", grows).into(),
        scientific(last.map(|row| row.rms)),
        scientific(last.map(|row| row.mean)),
        run.ending.describe(),
    ]
}

fn judge(sheet: &mut Sheet, found: &[LongRun], steps: u64) {
    let keeps = |run: &&LongRun| run.setup.row.keeps_k;
    let end = |run: &LongRun| run.rows.last().map_or(f64::NAN, |row| row.rms);
    let kept: Vec<_> = found.iter().filter(keeps).collect();
    let worst = kept.iter().map(|run| end(run)).fold(0.0, f64::max);
    let holds = kept.iter().all(|run| run.ending.is_completed() && end(run) < ROUNDING);
    let say = |run: &&LongRun| {
        let growth =
            run.growth().map_or("not known".into(), |fit| format!("{} ({:.2})", grows(&fit), fit.slope));
        format!("{}: {growth}", run.setup.label())
    };
    let contrast = found.iter().filter(|run| !keeps(run));
    let contrast: Vec<_> = contrast.map(|run| format!("{} by {:.0e}", run.setup.label(), end(run))).collect();
    sheet.find(
        "K in a long run",
        if holds { Verdict::Holds } else { Verdict::Fails },
        format!(
            "after {steps} steps the discrete gradients are off K by {worst:.0e} of it at most, {}. The deviation grows: {}.",
            contrast.join(", "),
            kept.iter().map(say).collect::<Vec<_>>().join("; "),
        ),
    );
}
