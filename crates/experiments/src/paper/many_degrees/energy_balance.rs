//! The energies of a chain with each of its reservoirs, and trajectories.

use super::orders::{ANY, end, masses};
use super::{chain, pendulum};
use crate::chart::{Axis, LineChart};
use crate::claim::{Readings, Said, list, sci, verdict};
use crate::findings::{keeps, kept};
use crate::manifest::RunOutcome;
use crate::paper::{Paper, oscillator};
use crate::sheet::{ReportError, Sheet, line, over_time, scientific};
use afterbay_analysis::study::{Problem, energy, trajectory};
use afterbay_core::larger_or_nan;

pub(super) const FOLLOWED: [&str; 5] =
    ["increment-2", "increment-8", "gonzalez", "leapfrog", "rk4"];
/// The methods whose runs of one degree of freedom are written to files.
pub(super) const OF_ONE_DEGREE: [&str; 3] = ["moddg", "leapfrog", "rk4"];
const STEP: f64 = 0.02;

pub(in crate::paper) fn add(paper: &Paper<'_>, sheet: &mut Sheet) -> Result<(), ReportError> {
    let Paper { extent, progress, .. } = *paper;
    let n = masses(extent);
    let problem = chain(n, extent.pick(10.0, end(extent)));
    progress.begin("energies of the chain", FOLLOWED.len());
    let runs = energy::run(&problem, &paper.methods(&FOLLOWED)?, STEP, 1, progress)?;
    let rows: Vec<_> = runs.iter().flat_map(|run| &run.rows).collect();
    sheet.wide_data("fput-chain/energy", &energy::columns(&problem.model), &rows)?;
    sheet.runs.extend(
        runs.iter().map(|run| {
            RunOutcome::of(&run.ending, "energy", problem.model.name(), run.method, STEP)
        }),
    );
    let readings = Readings::default().and("chain", "N", n).and("chain", "h", STEP);
    let readings = runs.iter().fold(readings, |r, run| {
        let start = run.rows.first().map_or(f64::NAN, |row| row.energy);
        let done = run.ending.is_completed().then_some(run.drift / start);
        r.and(run.method, "drift", done)
    });
    sheet.find("K with a reservoir for each degree of freedom", readings, k_is_kept);
    let w_error = |run: &energy::EnergyRun| {
        run.rows.iter().map(|row| row.w_error.abs()).fold(0.0, larger_or_nan)
    };
    let cells = |run: &energy::EnergyRun| {
        vec![
            run.method.into(),
            scientific(Some(run.drift)),
            scientific(Some(w_error(run))),
            run.violations.map_or("not counted".into(), |count| count.to_string()),
        ]
    };
    sheet.table(
        &["method", "max |K - K₀|", "max |w_j - w_j(t)|", "times Δw_j < 0"],
        runs.iter().map(cells).collect(),
    );
    let reservoirs = over_time(
        &format!("The chain of {n}: what each reservoir holds"),
        Axis::linear("w_j"),
        (0..n.div_ceil(2))
            .map(|j| {
                let points = runs[0].rows.iter().filter_map(|row| Some((row.t, *row.w.get(j)?)));
                line(&format!("w{}", j + 1), points.collect())
            })
            .collect(),
    );
    let drift = over_time(
        &format!("The chain of {n}: deviation of K"),
        Axis::log("|K - K₀|"),
        runs.iter()
            .map(|run| {
                line(run.method, run.rows.iter().map(|row| (row.t, row.drift.abs())).collect())
            })
            .collect(),
    );
    show(sheet, &reservoirs, &drift);
    trajectories(paper, sheet, "", &oscillator(), &OF_ONE_DEGREE)?;
    trajectories(paper, sheet, "fput-chain/", &problem, &FOLLOWED)?;
    trajectories(paper, sheet, "damped-double-pendulum/", &pendulum(end(extent)), &ANY)
}

/// Holds if each discrete gradient keeps K, including one of order 8.
fn k_is_kept(r: &Readings) -> Said {
    const CLAIMED: [&str; 3] = ["increment-2", "increment-8", "gonzalez"];
    let lost: Vec<_> = CLAIMED.into_iter().filter(|name| !keeps(r.number(name, "drift"))).collect();
    let says = if lost.is_empty() {
        "the discrete gradients keep K = H + Σ w_j, order 8 included".to_owned()
    } else {
        format!("{} do not keep K = H + Σ w_j", list(lost.iter().map(ToString::to_string)))
    };
    let all = r.numbers("drift").into_iter();
    let all = all.map(|(name, drift)| format!("{name} {} ({})", kept(drift), sci(drift)));
    let (n, h) = (r.number("chain", "N"), r.number("chain", "h"));
    let statement =
        format!("on the chain of {n} at h = {h} {says}. max |K - K₀|/H₀: {}.", list(all));
    (verdict(lost.is_empty()), statement)
}

fn show(sheet: &mut Sheet, reservoirs: &LineChart, drift: &LineChart) {
    let left = sheet.figure(
        "fput-chain-reservoirs",
        reservoirs.draw(),
        "The energy each mass up to the middle of the chain has given up, by increment-2.",
        "fput-chain/energy",
    );
    let right = sheet.figure(
        "fput-chain-drift",
        drift.draw(),
        "Deviation of K from its initial value.",
        "fput-chain/energy",
    );
    sheet.show_pair(left, right);
}

/// Writes every tenth state of a run, for use by other programs.
fn trajectories(
    paper: &Paper<'_>,
    sheet: &mut Sheet,
    folder: &str,
    problem: &Problem,
    names: &[&str],
) -> Result<(), ReportError> {
    let progress = paper.progress;
    progress.begin(&format!("trajectories of {}", problem.model.name()), names.len());
    let runs = trajectory::run(problem, &paper.methods(names)?, STEP, 10, progress)?;
    let rows: Vec<_> = runs.iter().flat_map(|run| &run.rows).collect();
    let header = trajectory::columns(&problem.model);
    Ok(sheet.wide_data(&format!("{folder}trajectory"), &header, &rows)?)
}
