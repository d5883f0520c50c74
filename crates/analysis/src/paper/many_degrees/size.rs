//! What N does to errors, books and cost.

use super::{chain, wave};
use crate::chart::{Axis, Curve, LineChart};
use crate::paper::{Extent, methods};
use crate::progress::Progress;
use crate::report::Verdict;
use crate::sheet::{ReportError, Sheet, marked};
use crate::study::size::SizeRow;
use crate::study::{cost, size};

const COMPARED: [&str; 5] = ["increment-2", "increment-4", "gonzalez", "leapfrog", "rk4"];
const TIMED: [&str; 4] = ["increment-2", "gonzalez", "leapfrog", "rk4"];
const STEP: f64 = 0.05;
const END: f64 = 2.0;

/// K is kept if it moves by no more than this beside H.
const ROUNDING: f64 = 1e-12;

/// Degree-of-freedom steps of a timed run, and the least number of steps.
const TIMED_STEPS: (usize, usize) = (20_000, 4);

pub(in crate::paper) fn add(
    sheet: &mut Sheet,
    extent: Extent,
    progress: &dyn Progress,
) -> Result<(), ReportError> {
    let sizes = (1..=extent.pick(10, 5)).map(|k| 1_usize << k);
    let problems: Vec<_> = sizes.map(|n| wave(n, END)).collect();
    progress.begin("errors against N", problems.len() * COMPARED.len());
    let found = size::run(&problems, &methods(&COMPARED), STEP, progress)?;
    sheet.data("fput-chain/size", &found)?;
    errors(sheet, &found);

    let counts = extent.pick(&[100, 300, 1000, 3000, 10_000, 30_000, 100_000][..], &[100, 1000]);
    let timed: Vec<_> =
        counts.iter().map(|&n| (chain(n, END), (TIMED_STEPS.0 / n).max(TIMED_STEPS.1) as u64)).collect();
    progress.begin("cost against N", timed.len() * TIMED.len());
    let found = cost::run(&timed, &methods(&TIMED), STEP, progress)?;
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
            "Time of a step of h = {STEP} on the chain, divided by N, all on one thread. Coordinate increments are taken red and \
             black, eight masses at a time. Every time is the fastest of several runs, taken one after the other. A level curve \
             is a step whose cost grows like N."
        ),
        "fput-chain/cost",
    );
    Ok(())
}

fn errors(sheet: &mut Sheet, found: &[SizeRow]) {
    let keeps = |row: &&SizeRow| methods(&[row.method]).iter().any(|method| method.keeps_k);
    let relative = |row: &SizeRow| row.k_drift / row.initial_energy;
    let worst = found.iter().filter(keeps).map(relative).fold(0.0, f64::max);
    let doubt = found.iter().map(|row| row.doubt_qp.max(row.doubt_w)).fold(0.0, f64::max);
    let largest = found.iter().map(|row| row.n).max().unwrap_or(0);
    let failed = found.iter().filter(|row| row.error_qp.is_none());
    let failed: Vec<_> =
        failed.map(|row| format!("{} at N = {} ({})", row.method, row.n, row.outcome)).collect();
    let all = found.iter().filter(keeps).all(|row| row.error_qp.is_some());
    let rest = if failed.is_empty() {
        String::new()
    } else {
        format!(" Runs that did not reach their end: {}.", failed.join(", "))
    };
    sheet.find(
        "K against N",
        if all && worst < ROUNDING { Verdict::Holds } else { Verdict::Fails },
        format!(
            "from N = 2 to {largest} the discrete gradients keep K to {worst:.0e} of H on [0, {END}] at h = {STEP}, the same wave \
             on every chain.{rest}"
        ),
    );
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
    let drift = chart("The chain: K against N", "max |K - K₀| / H₀", curves(&|row| Some(relative(row))));
    let error = chart(
        "The chain: error against N",
        &format!("largest error of q and p at t = {END}"),
        curves(&|row| row.error_qp),
    );
    let left = sheet.figure(
        "fput-chain-size-drift",
        drift.svg(),
        format!("The largest deviation of K on [0, {END}] at h = {STEP}, beside the energy at the start."),
        "fput-chain/size",
    );
    let right = sheet.figure(
        "fput-chain-size-error",
        error.svg(),
        format!(
            "Error of (q, p) at t = {END}, for a wave of eight masses on every chain. Where the reference is increment-8 its \
             last two runs agree to {doubt:.0e}."
        ),
        "fput-chain/size",
    );
    sheet.show_pair(left, right);
}
