//! `afterbay pick`

use crate::arguments::{Format, PickArguments};
use crate::bars::Bars;
use crate::experiment::folder;
use crate::failure::{Failure, code_of_results};
use crate::table::Column;
use crate::{interrupt, recommended, scene, table};
use afterbay_analysis::Measured;
use afterbay_analysis::study::pick::{self, Candidate, Pick, TooSensitive, Trial, Wanted};
use afterbay_experiments::journal::take_over;
use afterbay_experiments::record::writable;
use afterbay_experiments::scene::Scene;
use afterbay_experiments::{experiment, in_short};
use serde::Serialize;
use std::path::Path;
use std::process::ExitCode;

/// The most candidates shown, of those that qualify and of those that do not.
const SHOWN: usize = 8;
const NEAREST: usize = 3;

pub(crate) fn run(arguments: &PickArguments, format: Format) -> Result<ExitCode, Failure> {
    let &PickArguments { error, at_end, keep_k, passive, .. } = arguments;
    let (text, scene) = scene::with_text(&arguments.scene)?;
    scene.refuse_changes().map_err(|error| Failure::scene(&arguments.scene, &text, error))?;
    prepare(arguments, &scene)?;
    interrupt::listen();
    let bars = Bars::new();
    let wanted = Wanted { error, at_end, keep_k, passive };
    let found = pick::run(&scene.problem, wanted, &bars).map_err(Failure::study)?;
    bars.finish();
    let winner = found.qualified.first().map(|winner| &winner.run);
    let (written, failure) = match write(arguments, &text, (&scene, &found)) {
        Ok(written) => (written, None),
        Err(failure) => (None, Some(failure)),
    };
    let lines = winner.map(|winner| recommended::lines(&scene, winner));
    match format {
        Format::Json => {
            let events = [experiment::stops(&scene), experiment::longer_step(&scene, &found)];
            let events = events.into_iter().flatten().map(|said| said.statement);
            let events = events.reduce(|all, one| format!("{all} {one}"));
            let sweep = experiment::unswept(&scene).map(|unswept| unswept.statement);
            table::json(&Answer { found: &found, events, sweep, lines, written })?;
        }
        Format::Table => {
            print(&found, scene.problem.end)?;
            let of_answer =
                [experiment::coarse_error(&found), experiment::longer_step(&scene, &found)];
            let of_scene = [experiment::stops(&scene), experiment::unswept(&scene)];
            for said in of_answer.into_iter().chain(of_scene).flatten() {
                table::text(&format!("{}: {}", said.topic, said.statement))?;
            }
            if let Some(lines) = lines {
                table::line(&format!("To run it, put these tables into the scene:\n\n{lines}"))?;
            }
            match (written, &arguments.write) {
                (Some(file), _) => table::text(&format!("Scene: {}", file.display()))?,
                (None, Some(file)) => {
                    table::text(&format!("{} was not written.", file.display()))?;
                }
                (None, None) => {}
            }
            if let Some(out) = arguments.out.as_ref().filter(|_| failure.is_none()) {
                table::text(&format!("Report: {}", out.join("report.html").display()))?;
            }
        }
    }
    // The answer has been printed, as the only JSON where JSON is asked for.
    let done = || code_of_results(found.qualified.is_empty());
    Ok(failure.map_or_else(done, |failure| failure.tell()))
}

/// Checks before the search that its results can be written.
fn prepare(arguments: &PickArguments, scene: &Scene) -> Result<(), Failure> {
    if let Some(file) = &arguments.write {
        if file.is_file() && !arguments.force {
            return Err(Failure::exists(file));
        }
        writable(file).map_err(|error| Failure::unwritable(file, error))?;
    }
    if let Some(out) = &arguments.out {
        folder(out, scene, arguments.force)?;
        if arguments.force {
            take_over(out, &scene.hash())?;
        }
    }
    Ok(())
}

/// Writes the report and the scene that are asked for. Returns the file of the scene.
fn write<'a>(
    arguments: &'a PickArguments,
    text: &str,
    (scene, found): (&Scene, &Pick),
) -> Result<Option<&'a Path>, Failure> {
    if let Some(out) = &arguments.out {
        let (output, _) = experiment::pick(scene, found)?;
        output.write(out, arguments.files.into()).map_err(Failure::storage)?;
    }
    let winner = found.qualified.first().map(|winner| &winner.run);
    let Some((file, winner)) = arguments.write.as_deref().zip(winner) else { return Ok(None) };
    std::fs::write(file, recommended::scene(text, scene, winner))
        .map_err(|error| Failure::unwritable(file, error))?;
    Ok(Some(file))
}

/// The answer as JSON.
#[derive(Serialize)]
struct Answer<'a> {
    #[serde(flatten)]
    found: &'a Pick,
    /// The events that would end a run, and those that the step found may miss, as a sentence.
    events: Option<String>,
    /// The statement that the sweep is not followed; none without a sweep.
    sweep: Option<String>,
    /// The tables of a scene that run the recommendation.
    lines: Option<String>,
    /// The scene that was written.
    written: Option<&'a Path>,
}

fn print(found: &Pick, end: f64) -> Result<(), Failure> {
    said(found, end).iter().try_for_each(|line| table::text(line))?;
    let shown = found.qualified.iter().take(SHOWN).chain(found.others.iter().take(NEAREST));
    let rows: Vec<Vec<String>> = shown.map(cells).collect();
    if rows.is_empty() {
        return Ok(());
    }
    let columns = [
        Column::of("method", 0),
        Column::of("step or tolerance", 0),
        Column::words("error of (q, p)", 0, 8),
        Column::words("error of w", 1, 8),
        Column::words("at the end", 5, 10),
        Column::words("w at the end", 6, 8),
        Column::words("max |K - K₀|", 4, 8),
        Column::words("not passive", 7, 7),
        Column::of("seconds", 2),
        Column::of("evaluations", 3),
    ];
    table::print(&columns, rows)?;
    // The nearest has been named above where nothing qualifies.
    let named = usize::from(found.qualified.is_empty());
    for other in found.others.iter().take(NEAREST).skip(named) {
        table::text(&format!("{} does not qualify: {}.", other.run.method, why_not(other)))?;
    }
    let more = found.qualified.len().saturating_sub(SHOWN);
    if more > 0 {
        table::text(&format!("{more} more qualify; --format json shows all."))?;
    }
    Ok(())
}

/// The result of the search in sentences, with the accuracy to which it is known.
fn said(found: &Pick, end: f64) -> Vec<String> {
    let bound = found.wanted.error;
    let asked = format!("within {bound:e} {}{}", found.wanted.place(end), structure(found));
    let mut lines = Vec::new();
    if found.interrupted {
        let tried = found.tried.len();
        lines.push(format!("The search was interrupted after {tried} runs; so far:"));
    }
    match (&found.qualified[..], found.too_sensitive) {
        ([], Some(why @ TooSensitive::Between { .. })) => {
            lines.push(format!("No method can be compared all along: {why}."));
        }
        ([], Some(why)) => {
            lines.push(format!("The scene is too sensitive for an error of {bound:e}: {why}."));
        }
        ([], None) if found.interrupted => {
            lines.push(format!("No method was found and checked yet {asked}."));
        }
        ([], None) => lines.push(format!("No method was found {asked}.")),
        ([winner, rest @ ..], _) => lines.extend(cheapest(found, winner, rest, &asked)),
    }
    if let ([], Some(nearest)) = (&found.qualified[..], found.others.first()) {
        lines.push(format!("Nearest is {}: {}.", nearest.run.method, why_not(nearest)));
    }
    let doubt = found.doubt.most();
    if doubt > bound / 10.0 {
        lines.push(format!("! The reference itself is known to {doubt:.0e} only."));
    }
    if found.wanted.passive && !found.is_passive {
        lines.push("The system is not known to be passive: no step can violate passivity.".into());
    }
    lines
}

/// The cheapest method, its check, and those that come next.
fn cheapest(found: &Pick, winner: &Candidate, rest: &[Candidate], asked: &str) -> Vec<String> {
    let (method, by) = (winner.run.method, setting(&winner.run));
    let next = rest.first().map_or("Nothing else qualifies.".into(), |second| {
        let (other, by) = (second.run.method, setting(&second.run));
        format!("The runner-up is {other} with {by}: {}.", cost(second))
    });
    let mut lines = vec![
        format!("{method} with {by} is the cheapest {asked}: {}.", cost(winner)),
        format!("{}.", checked(winner, found.check)),
        next,
    ];
    if let Some(tied) = rest.get(..found.ties).filter(|tied| !tied.is_empty()) {
        let names: Vec<_> = tied.iter().map(|other| other.run.method).collect();
        lines.push(format!(
            "Not told from {method} by the noise of the times: {}. Another search may prefer one \
             of them.",
            names.join(", ")
        ));
    }
    lines
}

/// The other requirements, in words.
fn structure(found: &Pick) -> &'static str {
    match (found.wanted.keep_k, found.wanted.passive) {
        (true, true) => ", with K kept and passive",
        (true, false) => ", with K kept",
        (false, true) => ", passive",
        (false, false) => "",
    }
}

/// The reason for which a candidate does not qualify.
fn why_not(candidate: &Candidate) -> String {
    let parts = [&candidate.why_not, &candidate.run.failure];
    parts.into_iter().flatten().map(String::as_str).collect::<Vec<_>>().join(": ")
}

/// The step in four digits, or the tolerance.
fn setting(run: &Trial) -> String {
    match run.tolerance {
        Some(_) => run.setting(),
        None => format!("step = {}", in_short(run.h)),
    }
}

fn cost(candidate: &Candidate) -> String {
    let run = &candidate.run;
    let said = |error: Option<Measured>| error.map_or(String::new(), |error| error.to_string());
    let [end_qp, end_w] = run.at_end().map_or([None; 2], |end| end.map(Some));
    let worst = run.worst().map_or(String::new(), |t| format!(" (largest at t = {})", in_short(t)));
    let seconds = run.seconds.map_or("not timed".into(), |seconds| format!("{seconds:.1e} s"));
    format!(
        "{seconds}, error {} in (q, p) and {} in w on the way{worst}, {} and {} at the end",
        said(run.qp()),
        said(run.w()),
        said(end_qp),
        said(end_w),
    )
}

/// The checks of the recommendation.
fn checked(winner: &Candidate, finer: Option<[f64; 2]>) -> String {
    let run = &winner.run;
    let beside = winner.checked.map_or(String::new(), |checked| {
        format!("{} settings beside it err by {:.1e} at most", checked.settings, checked.most)
    });
    let finer = finer.map_or(String::new(), |[qp, w]| {
        format!(", and a finer run differs by {qp:.1e} in (q, p) and {w:.1e} in w")
    });
    format!("Checked at {} times: {beside}{finer}", run.samples)
}

fn cells(candidate: &Candidate) -> Vec<String> {
    let run = &candidate.run;
    let said = |error: Option<Measured>| error.map_or(String::new(), |error| error.to_string());
    let [end_qp, end_w] = run.at_end().map_or([None; 2], |end| end.map(Some));
    let scientific =
        |value: Option<f64>| value.map_or(String::new(), |value| format!("{value:.1e}"));
    vec![
        run.method.into(),
        setting(run),
        said(run.qp()),
        said(run.w()),
        said(end_qp),
        said(end_w),
        scientific(Some(run.k_drift)),
        run.passivity_violations.map_or("not counted".into(), |count| count.to_string()),
        scientific(run.seconds),
        run.evaluations.map_or(String::new(), |count| count.to_string()),
    ]
}
