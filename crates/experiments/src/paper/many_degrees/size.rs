//! Errors, energy balance and cost as N grows.

use super::{chain, wave};
use crate::chart::{Axis, Curve, LineChart};
use crate::claim::{Readings, Said, list, sci, verdict};
use crate::findings::{KEPT, kept};
use crate::paper::Paper;
use crate::sheet::{ReportError, Sheet, marked};
use afterbay_analysis::study::size::SizeRow;
use afterbay_analysis::study::{cost, size};
use afterbay_core::larger_or_nan;

pub(super) const COMPARED: [&str; 5] =
    ["increment-2", "increment-4", "gonzalez", "leapfrog", "rk4"];
pub(super) const TIMED: [&str; 4] = ["increment-2", "gonzalez", "leapfrog", "rk4"];
const STEP: f64 = 0.05;
const END: f64 = 2.0;

/// Steps times degrees of freedom of a timed run, and the least number of steps.
const TIMED_STEPS: (usize, usize) = (20_000, 4);

pub(in crate::paper) fn add(paper: &Paper<'_>, sheet: &mut Sheet) -> Result<(), ReportError> {
    let Paper { extent, progress, .. } = *paper;
    let sizes = (1..=extent.pick(10, 5)).map(|k| 1_usize << k);
    let problems: Vec<_> = sizes.map(|n| wave(n, END)).collect();
    progress.begin("errors against N", problems.len() * COMPARED.len());
    let found = size::run(&problems, &paper.methods(&COMPARED)?, STEP, progress)?;
    sheet.data("fput-chain/size", &found)?;
    errors(sheet, &found);

    let counts = extent.pick(&[100, 300, 1000, 3000, 10_000, 30_000, 100_000][..], &[100, 1000]);
    let timed: Vec<_> = counts
        .iter()
        .map(|&n| (chain(n, END), (TIMED_STEPS.0 / n).max(TIMED_STEPS.1) as u64))
        .collect();
    progress.begin("cost against N", timed.len() * TIMED.len());
    let found = cost::run(&timed, &paper.methods(&TIMED)?, STEP, progress)?;
    sheet.data("fput-chain/cost", &found)?;
    let curve = |name: &&str| {
        let of = found.iter().filter(|row| row.method == *name);
        marked(name, of.map(|row| (row.n as f64, row.nanoseconds())).collect())
    };
    let chart = LineChart {
        title: "The chain: cost of a step on one thread".into(),
        x: Axis::log("degrees of freedom N"),
        y: Axis::log("ns a step and degree of freedom"),
        curves: TIMED.iter().map(curve).collect(),
        guides: Vec::new(),
    };
    sheet.show(
        "fput-chain-cost",
        &chart,
        format!(
            "Time of a step of h = {STEP} on the chain, divided by N, on one thread. Coordinate \
             increments are taken red and black, eight masses at a time. Every time is the fastest \
             of several runs, measured one after another. A level curve means that the cost grows \
             like N."
        ),
        "fput-chain/cost",
    );
    Ok(())
}

fn errors(sheet: &mut Sheet, found: &[SizeRow]) {
    let relative = |row: &SizeRow| row.k_drift / row.initial_energy;
    let doubt =
        found.iter().map(|row| larger_or_nan(row.doubt_qp, row.doubt_w)).fold(0.0, larger_or_nan);
    let mut readings = Readings::default()
        .and("N", "least", found.iter().map(|row| row.n as f64).reduce(f64::min))
        .and("N", "largest", found.iter().map(|row| row.n as f64).reduce(f64::max));
    for of in found.chunk_by(|a, b| a.method == b.method) {
        let done = of.iter().filter(|row| row.error_qp.is_some());
        readings.add(of[0].method, "drift", done.map(relative).reduce(larger_or_nan));
        let failed = of.iter().filter(|row| row.error_qp.is_none());
        let failed: Vec<_> =
            failed.map(|row| format!("at N = {} ({})", row.n, row.outcome)).collect();
        readings.add(of[0].method, "failed", failed.join(", "));
    }
    sheet.find("K against N", readings, k_against_n);
    let curves = |value: &dyn Fn(&SizeRow) -> Option<f64>| -> Vec<Curve> {
        let curve = |name: &&str| {
            let of = found.iter().filter(|row| row.method == *name);
            marked(name, of.filter_map(|row| Some((row.n as f64, value(row)?))).collect())
        };
        COMPARED.iter().map(curve).collect()
    };
    let chart = |title: &str, y: &str, curves| LineChart {
        title: title.into(),
        x: Axis::log("degrees of freedom N"),
        y: Axis::log(y),
        curves,
        guides: Vec::new(),
    };
    let drift =
        chart("The chain: K against N", "max |K - K₀| / H₀", curves(&|row| Some(relative(row))));
    let error = chart(
        "The chain: error against N",
        &format!("largest error of q and p at t = {END}"),
        curves(&|row| row.error_qp),
    );
    let left = sheet.figure(
        "fput-chain-size-drift",
        drift.draw(),
        format!(
            "The largest deviation of K on [0, {END}] at h = {STEP}, relative to the energy at the \
             start."
        ),
        "fput-chain/size",
    );
    let right = sheet.figure(
        "fput-chain-size-error",
        error.draw(),
        format!(
            "Error of (q, p) at t = {END}, for a wave of eight masses on every chain. References \
             by increment-8 have last two runs that agree to {doubt:.0e}."
        ),
        "fput-chain/size",
    );
    sheet.show_pair(left, right);
}

/// Holds if each of these discrete gradients keeps K and reaches the end for every N.
fn k_against_n(r: &Readings) -> Said {
    const CLAIMED: [&str; 3] = ["increment-2", "increment-4", "gonzalez"];
    let keeps = |name: &str| r.number(name, "drift") <= KEPT && r.word(name, "failed").is_empty();
    let not: Vec<_> = CLAIMED.into_iter().filter(|name| !keeps(name)).collect();
    let says = if not.is_empty() {
        "the discrete gradients keep K at every N".to_owned()
    } else {
        format!("{} do not keep K at every N", list(not.iter().map(ToString::to_string)))
    };
    let all = r.numbers("drift").into_iter().map(|(name, drift)| {
        let failed = match r.word(name, "failed") {
            "" => String::new(),
            where_ => format!(", not to the end {where_}"),
        };
        format!("{name} {} ({}{failed})", kept(drift), sci(drift))
    });
    let statement = format!(
        "{says}. From N = {} to {}, on [0, {END}] at h = {STEP}, the same wave on every chain, \
         with max |K - K₀|/H₀: {}.",
        r.number("N", "least"),
        r.number("N", "largest"),
        list(all),
    );
    (verdict(not.is_empty()), statement)
}
