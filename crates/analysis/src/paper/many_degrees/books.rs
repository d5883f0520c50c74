//! The energy books of a chain, reservoir by reservoir, and trajectories.

use super::orders::{ANY, end, masses};
use super::{chain, pendulum};
use crate::chart::{Axis, LineChart};
use crate::paper::{Extent, methods, oscillator};
use crate::progress::Progress;
use crate::report::Verdict;
use crate::sheet::{ReportError, Sheet, line, over_time, scientific};
use crate::study::{Problem, energy, trajectory};

const KEPT: [&str; 5] = ["increment-2", "increment-8", "gonzalez", "leapfrog", "rk4"];
const STEP: f64 = 0.02;

/// K is kept if it moves by no more than this beside H.
const ROUNDING: f64 = 1e-12;

pub(in crate::paper) fn add(
    sheet: &mut Sheet,
    extent: Extent,
    progress: &dyn Progress,
) -> Result<(), ReportError> {
    let n = masses(extent);
    let problem = chain(n, extent.pick(10.0, end(extent)));
    progress.begin("energy books of the chain", KEPT.len());
    let books = energy::run(&problem, &methods(&KEPT), STEP, 1, progress)?;
    let rows: Vec<_> = books.iter().flat_map(|books| &books.rows).collect();
    sheet.wide_data("fput-chain/energy", &energy::columns(n), &rows)?;
    sheet.runs.extend(
        books.iter().map(|books| books.ending.record("energy", problem.model.name(), books.method, STEP)),
    );
    let initial = books.first().and_then(|books| books.rows.first()).map_or(1.0, |row| row.energy);
    let kept = |books: &&energy::Books| methods(&[books.method]).iter().any(|row| row.keeps_k);
    let worst = books.iter().filter(kept).map(|books| books.drift / initial).fold(0.0, f64::max);
    let least =
        books.iter().filter(|books| !kept(books)).map(|books| books.drift / initial).fold(f64::MAX, f64::min);
    let holds = worst < ROUNDING && books.iter().filter(kept).all(|books| books.ending.is_completed());
    sheet.find(
        "K with a reservoir for each degree of freedom",
        if holds { Verdict::Holds } else { Verdict::Fails },
        format!(
            "on the chain of {n} at h = {STEP} the discrete gradients keep K = H + Σ w_j to {worst:.0e} of H, order 8 included; \
             leapfrog and rk4 are off by {least:.0e} at least."
        ),
    );
    let w_error = |books: &energy::Books| books.rows.iter().map(|row| row.w_error.abs()).fold(0.0, f64::max);
    let cells = |books: &energy::Books| {
        vec![
            books.method.into(),
            scientific(Some(books.drift)),
            scientific(Some(w_error(books))),
            books.violations.map_or("none owed".into(), |count| count.to_string()),
        ]
    };
    sheet.table(
        &["method", "max |K - K₀|", "max |w_j - w_j(t)|", "times Δw_j < 0"],
        books.iter().map(cells).collect(),
    );
    let reservoirs = over_time(
        &format!("The chain of {n}: what each reservoir holds"),
        Axis::linear("w_j"),
        (0..n.div_ceil(2))
            .map(|j| {
                let points = books[0].rows.iter().filter_map(|row| Some((row.t, *row.w.get(j)?)));
                line(&format!("w{}", j + 1), points.collect())
            })
            .collect(),
    );
    let drift = over_time(
        &format!("The chain of {n}: deviation of K"),
        Axis::log("|K - K₀|"),
        books
            .iter()
            .map(|books| line(books.method, books.rows.iter().map(|row| (row.t, row.drift.abs())).collect()))
            .collect(),
    );
    show(sheet, &reservoirs, &drift);
    trajectories(sheet, "", &oscillator(), &["moddg", "leapfrog", "rk4"], progress)?;
    trajectories(sheet, "fput-chain/", &problem, &KEPT, progress)?;
    trajectories(sheet, "damped-double-pendulum/", &pendulum(end(extent)), &ANY, progress)
}

fn show(sheet: &mut Sheet, reservoirs: &LineChart, drift: &LineChart) {
    let left = sheet.figure(
        "fput-chain-reservoirs",
        reservoirs.svg(),
        "The energy each mass up to the middle of the chain has given up, by increment-2. The other half mirrors it.",
        "fput-chain/energy",
    );
    let right = sheet.figure(
        "fput-chain-drift",
        drift.svg(),
        "Deviation of K from its initial value.",
        "fput-chain/energy",
    );
    sheet.show_pair(left, right);
}

/// Every tenth state of a run, to be read by other programs.
fn trajectories(
    sheet: &mut Sheet,
    folder: &str,
    problem: &Problem,
    names: &[&str],
    progress: &dyn Progress,
) -> Result<(), ReportError> {
    progress.begin(&format!("trajectories of {}", problem.model.name()), names.len());
    let runs = trajectory::run(problem, &methods(names), STEP, 10, progress)?;
    let rows: Vec<_> = runs.iter().flat_map(|run| &run.rows).collect();
    let header = trajectory::columns(problem.model.dof());
    Ok(sheet.wide_data(&format!("{folder}trajectory"), &header, &rows)?)
}
