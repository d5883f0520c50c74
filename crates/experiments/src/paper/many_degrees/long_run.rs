//! The effect of the roundings of very many steps on K.

use super::chain;
use crate::claim::{Readings, Said, list, sci, verdict};
use crate::findings::long_run::{CAPTION, HEADER, cells, chart, growth, readings};
use crate::findings::{KEPT, kept};
use crate::manifest::RunOutcome;
use crate::paper::{Extent, Paper};
use crate::sheet::{ReportError, Sheet};
use afterbay_analysis::Model;
use afterbay_analysis::study::Problem;
use afterbay_analysis::study::long_run::{self, LongRun, Setup};
use afterbay_analysis::study::outcome::COMPLETED;
use afterbay_systems::FPUT_CHAIN;
use std::f64::consts::PI;

/// The method, the step, and whether roundings are compensated.
const RUNS: [(&str, f64, bool); 7] = [
    ("increment-4", 0.1, false),
    ("gonzalez", 0.05, false),
    ("increment-2", 0.2, false),
    ("increment-2", 0.2, true),
    ("increment-2", 0.05, false),
    ("increment-4", 0.1, true),
    ("rk4", 0.05, false),
];

/// A chain of 8 without friction that starts from rest as a sine of amplitude 1 or slightly more,
/// so that the roundings of all starts differ.
pub(super) fn starts(extent: Extent) -> Vec<Problem> {
    let n = 8;
    let start = |i: u32| {
        let amplitude = 1.0 + f64::from(i) / 1024.0;
        let sine = |j: usize| amplitude * (PI * j as f64 / (n + 1) as f64).sin();
        let model = Model::of(&FPUT_CHAIN, &[n as f64, 1.0, 0.0]);
        Problem { model, q: (1..=n).map(sine).collect(), ..chain(n, 0.0) }
    };
    (0..extent.pick(4, 2)).map(start).collect()
}

pub(in crate::paper) fn add(paper: &Paper<'_>, sheet: &mut Sheet) -> Result<(), ReportError> {
    let Paper { extent, progress, .. } = *paper;
    let (starts, steps) = (starts(extent), extent.pick(1_000_000, 100_000));
    let setup = |&(name, h, compensated)| Ok(Setup { row: paper.method(name)?, h, compensated });
    let setups = RUNS.iter().map(setup).collect::<Result<Vec<_>, ReportError>>()?;
    progress.begin("K in a long run", setups.len() * starts.len());
    let found = long_run::run(&starts, &setups, steps, progress)?;
    let rows: Vec<_> = found.iter().flat_map(|run| &run.rows).collect();
    sheet.data("fput-chain/long_run", &rows)?;
    let outcome = |run| RunOutcome::of_long_run(run, "fput-chain");
    sheet.runs.extend(found.iter().map(outcome));
    sheet.text(format!(
        "A method that keeps K changes it only by the roundings of each step, which add up. Each \
         run takes {steps} steps on a chain of 8 without friction (β = 1, from rest as a sine), \
         from each of {} starts with the amplitudes 1, 1 + 1/1024, …. K is computed in 106 bits at \
         about a hundred samples in each of four windows per decade, relative to the largest |H| \
         + Σ |w_j| or T of the samples so far, T = ½ Σ |p_j ∂H/∂p_j|. The deviation grows like √t \
         if roundings are independent, and like t if they are biased. The exponent is the slope of \
         log rms against log t over the last two decades, with its 95 % confidence interval. The \
         windows of a run are not independent, so that the interval is too narrow. A \
         compensated run solves each equation to extended precision and carries the roundings of \
         q, p and w on to the next step: what remains of K - K₀ is the rounding of the state at \
         which it is sampled.",
        starts.len()
    ));
    judge(sheet, &found, steps);
    sheet.table(&HEADER, found.iter().map(cells).collect());
    let chart = chart("The chain without friction: K in a long run", "time t", &found);
    sheet.show("fput-chain-long-run", &chart, CAPTION, "fput-chain/long_run");
    Ok(())
}

fn judge(sheet: &mut Sheet, found: &[LongRun], steps: u64) {
    sheet.find("K in a long run", readings(found, steps), in_a_long_run);
}

/// Holds if every run of a discrete gradient reaches its end and keeps K.
fn in_a_long_run(r: &Readings) -> Said {
    let of = r.numbers("rms");
    let (contrast, claimed): (Vec<_>, Vec<_>) =
        of.into_iter().partition(|(label, _)| label.starts_with("rk4"));
    let lost =
        claimed.iter().filter(|(label, rms)| !(*rms <= KEPT && r.word(label, "run") == COMPLETED));
    let lost: Vec<_> = lost.map(|(label, _)| label.to_string()).collect();
    let say = |(label, rms): (&str, f64)| {
        format!(
            "{label}: {} ({}), {}, {}",
            sci(rms),
            kept(rms),
            r.word(label, "run"),
            growth(r, label)
        )
    };
    let says = if lost.is_empty() {
        "the discrete gradients keep K".to_owned()
    } else {
        format!("K is lost by {}", list(lost.iter().cloned()))
    };
    let all: Vec<_> = claimed.into_iter().chain(contrast).map(say).collect();
    let statement = format!(
        "after {} steps {says}. rms of K - K₀ relative to the largest energy: {}.",
        r.number("run", "steps"),
        all.join("; ")
    );
    (verdict(lost.is_empty()), statement)
}
