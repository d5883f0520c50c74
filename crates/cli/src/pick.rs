//! `afterbay pick`

use crate::arguments::Format;
use crate::bars::Bars;
use crate::experiment::FAILED;
use crate::failure::Failure;
use crate::{interrupt, scene, table};
use afterbay_analysis::study::pick::{self, Candidate, Pick, Wanted};
use std::path::Path;
use std::process::ExitCode;

/// Those that qualify and those that do not, shown.
const SHOWN: usize = 8;
const NEAREST: usize = 3;

pub(crate) fn run(path: &Path, wanted: Wanted, format: Format) -> Result<ExitCode, Failure> {
    let scene = scene::read(path)?;
    let bars = Bars::new();
    let found = pick::run(&scene.problem, wanted, &bars).map_err(Failure::study)?;
    bars.finish();
    match format {
        Format::Json => table::json(&found)?,
        Format::Table => print(&found, scene.problem.end)?,
    }
    let failed = found.qualified.is_empty();
    let completed = if failed { ExitCode::from(FAILED) } else { ExitCode::SUCCESS };
    Ok(interrupt::exit_code().unwrap_or(completed))
}

fn print(found: &Pick, end: f64) -> Result<(), Failure> {
    let bound = found.wanted.error;
    match &found.qualified[..] {
        [] => {
            table::line(&format!(
                "No method was found with errors within {bound:e} at t = {end}{}.",
                structure(found)
            ))?;
            if let Some(nearest) = found.others.first() {
                let why = nearest.why_not.as_deref().unwrap_or_default();
                table::line(&format!("Nearest is {}: {why}.", nearest.run.method))?;
            }
        }
        [winner, rest @ ..] => {
            let run = &winner.run;
            table::line(&format!(
                "{} with {} is the cheapest within {bound:e} at t = {end}{}: {}.",
                run.method,
                run.setting(),
                structure(found),
                cost(winner)
            ))?;
            if let Some([qp, w]) = found.check {
                table::line(&format!(
                    "Checked: a finer run differs by {qp:.1e} in (q, p) and {w:.1e} in w."
                ))?;
            }
            match rest.first() {
                Some(second) => table::line(&format!(
                    "The runner-up is {} with {}: {}.",
                    second.run.method,
                    second.run.setting(),
                    cost(second)
                ))?,
                None => table::line("Nothing else qualifies.")?,
            }
        }
    }
    if found.reference_doubt > bound / 10.0 {
        table::line(&format!("! The reference itself is known to {:.0e} only.", found.reference_doubt))?;
    }
    if found.wanted.passive && !found.owed {
        table::line("The system is not known to be passive: nothing is owed, whatever the method.")?;
    }
    let shown = found.qualified.iter().take(SHOWN).chain(found.others.iter().take(NEAREST));
    let header = [
        "method",
        "step or tolerance",
        "error of (q, p)",
        "error of w",
        "max |K - K₀|",
        "Δw < 0",
        "seconds",
        "evaluations",
        "why not",
    ];
    table::print(&header, shown.map(cells))?;
    match found.qualified.len().saturating_sub(SHOWN) {
        0 => Ok(()),
        more => table::line(&format!("{more} more qualify; --format json shows all.")),
    }
}

/// What else was wanted, in words.
fn structure(found: &Pick) -> &'static str {
    match (found.wanted.keep_k, found.wanted.passive) {
        (true, true) => ", with K kept and passive",
        (true, false) => ", with K kept",
        (false, true) => ", passive",
        (false, false) => "",
    }
}

fn cost(candidate: &Candidate) -> String {
    let run = &candidate.run;
    format!(
        "{:.1e} s, error {:.1e} in (q, p) and {:.1e} in w",
        run.seconds.unwrap_or(f64::NAN),
        run.error_qp.unwrap_or(f64::NAN),
        run.error_w.unwrap_or(f64::NAN)
    )
}

fn cells(candidate: &Candidate) -> Vec<String> {
    let run = &candidate.run;
    let scientific = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value:.1e}"));
    let why = match (&candidate.why_not, &run.failure) {
        (Some(why), Some(failure)) => format!("{why}: {failure}"),
        (Some(why), None) => why.clone(),
        _ => String::new(),
    };
    vec![
        run.method.into(),
        run.setting(),
        scientific(run.error_qp),
        scientific(run.error_w),
        scientific(Some(run.k_drift)),
        run.passivity_violations.map_or("none owed".into(), |count| count.to_string()),
        scientific(run.seconds),
        run.evaluations.map_or(String::new(), |count| count.to_string()),
        why,
    ]
}
