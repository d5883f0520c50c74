//! The result of `pick` with the charts of its runs.

use crate::chart::{Axis, LineChart};
use crate::claim::{Readings, Said, sci};
use crate::record::RunOutcome;
use crate::report::Verdict as Holds;
use crate::scene::Scene;
use crate::sheet::{ReportError, Sheet, line, marked, scientific};
use crate::study::outcome::INTERRUPTED;
use crate::study::pick::{Candidate, Pick, SAMPLES, Trial};
use serde::Serialize;

/// The tables from which the charts are made.
const TRIED: &str = "pick_tried";
const FOUND: &str = "pick";

/// A row of `pick.csv`.
#[derive(Serialize)]
struct Row<'a> {
    method: &'a str,
    h: f64,
    tolerance: Option<f64>,
    error_qp: Option<f64>,
    error_w: Option<f64>,
    end_qp: Option<f64>,
    end_w: Option<f64>,
    doubt_qp: f64,
    doubt_w: f64,
    k_drift: f64,
    passivity_violations: Option<u64>,
    seconds: Option<f64>,
    steps: u64,
    evaluations: Option<u64>,
    why_not: Option<&'a str>,
}

fn row(candidate: &Candidate) -> Row<'_> {
    let run = &candidate.run;
    Row {
        method: run.method,
        h: run.h,
        tolerance: run.tolerance,
        error_qp: run.error_qp,
        error_w: run.error_w,
        end_qp: run.end_qp,
        end_w: run.end_w,
        doubt_qp: run.doubt_qp,
        doubt_w: run.doubt_w,
        k_drift: run.k_drift,
        passivity_violations: run.passivity_violations,
        seconds: run.seconds,
        steps: run.steps,
        evaluations: run.evaluations,
        why_not: candidate.why_not.as_deref(),
    }
}

/// The error by which a trial is judged.
fn judged(found: &Pick, run: &Trial) -> Option<f64> {
    let [qp, w] =
        if found.wanted.at_end { [run.end_qp, run.end_w] } else { [run.error_qp, run.error_w] };
    Some(qp?.max(w?))
}

pub(super) fn sheet(scene: &Scene, found: &Pick) -> Result<Sheet, ReportError> {
    let mut sheet = Sheet::new("The cheapest method and step");
    let (wanted, end) = (found.wanted, scene.problem.end);
    let all: Vec<Row<'_>> = found.qualified.iter().chain(&found.others).map(row).collect();
    sheet.data(FOUND, &all)?;
    sheet.data(TRIED, &found.tried)?;
    let asked = format!("within {:e} {}", wanted.error, wanted.place(end));
    sheet.text(format!(
        "The error of a run is the largest error of any q_j, p_j and w_j after every step, or at \
         {SAMPLES} times if there are more steps. A step qualifies if it, every step tried within \
         5 % of it and half of it are {asked}. A tolerance qualifies if it, those from half to \
         twice as large and a quarter of it are. {} runs were compared with a reference known to \
         {:.0e}.",
        found.tried.len(),
        found.doubt.most()
    ));
    let mut readings = Readings::default()
        .and("the search", "asked", asked.as_str())
        .and("the search", "interrupted", if found.interrupted { "yes" } else { "no" })
        .and(
            "the scene",
            "too sensitive",
            found.too_sensitive.map_or(String::new(), |why| why.to_string()),
        );
    for run in found.qualified.iter().map(|one| &one.run) {
        readings.add(&format!("{} with {}", run.method, run.setting()), "seconds", run.seconds);
    }
    sheet.find("Pick", readings, the_cheapest);
    if found.interrupted {
        sheet.runs.push(RunOutcome {
            study: "pick",
            system: scene.problem.model.name(),
            method: "all",
            h: scene.step,
            outcome: INTERRUPTED.into(),
            failure: None,
        });
    }
    charts(&mut sheet, found, end);
    let header = [
        "method",
        "step or tolerance",
        "error of (q, p)",
        "error of w",
        "at the end",
        "w at the end",
        "seconds",
        "why not",
    ];
    let cells = |candidate: &Candidate| {
        let run = &candidate.run;
        vec![
            run.method.into(),
            run.setting(),
            scientific(run.error_qp),
            scientific(run.error_w),
            scientific(run.end_qp),
            scientific(run.end_w),
            scientific(run.seconds),
            candidate.why_not.clone().unwrap_or_default(),
        ]
    };
    sheet.table(&header, found.qualified.iter().chain(&found.others).map(cells).collect());
    Ok(sheet)
}

/// States the cheapest method that qualifies, or the reason why there is none.
fn the_cheapest(r: &Readings) -> Said {
    let (asked, why) = (r.word("the search", "asked"), r.word("the scene", "too sensitive"));
    let all = r.numbers("seconds");
    let timed = all.iter().filter(|(_, seconds)| !seconds.is_nan());
    let says = match timed.min_by(|a, b| a.1.total_cmp(&b.1)) {
        _ if r.word("the search", "interrupted") != "no" => {
            "the search was interrupted; what follows was found until then".to_owned()
        }
        _ if !why.is_empty() => format!("the scene is too sensitive: {why}"),
        Some((run, seconds)) => format!("{run} is the cheapest {asked} ({} s)", sci(*seconds)),
        None => format!("no method was found {asked}"),
    };
    (Holds::Note, format!("{says}."))
}

/// Charts every run that was tried against its evaluations, and those that qualify against their
/// time, with the bound as a line.
fn charts(sheet: &mut Sheet, found: &Pick, end: f64) {
    let bound = found.wanted.error;
    let place = found.wanted.place(end);
    let mut chart =
        |name: &str, title: &str, cost: &str, data: &str, caption: &str, curves: Vec<_>| {
            let points = |curve: &crate::chart::Curve| {
                curve.points.iter().map(|at| at.0).collect::<Vec<_>>()
            };
            let xs: Vec<f64> = curves.iter().flat_map(points).collect();
            let (low, high) =
                xs.iter().fold((f64::INFINITY, 0.0_f64), |(l, h), &x| (l.min(x), h.max(x)));
            let mut curves = curves;
            if low <= high {
                curves
                    .push(line(&format!("the bound {bound:e}"), vec![(low, bound), (high, bound)]));
            }
            let chart = LineChart {
                title: title.into(),
                x: Axis::log(cost),
                y: Axis::log(format!("largest error {place}")),
                curves,
                guides: Vec::new(),
            };
            sheet.show(name, &chart, caption, data);
        };
    let at = |run: &Trial| Some((run.evaluations? as f64, judged(found, run)?));
    let mut methods: Vec<&str> = found.tried.iter().map(|run| run.method).collect();
    methods.dedup();
    let mut curves: Vec<_> = methods
        .iter()
        .map(|method| {
            let mut points: Vec<_> =
                found.tried.iter().filter(|run| run.method == *method).filter_map(at).collect();
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            marked(method, points)
        })
        .filter(|curve| !curve.points.is_empty())
        .collect();
    let chosen = found.qualified.first().map(|winner| &winner.run);
    if let Some(point) = chosen.and_then(at) {
        curves.push(marked("chosen", vec![point]));
    }
    if curves.is_empty() {
        return;
    }
    let evaluations = "evaluations of the force";
    let caption = "Every run that was tried. A method whose curve jumps or does not fall is \
                   accurate only by chance.";
    chart("pick-tried", "Runs that were tried", evaluations, TRIED, caption, curves);
    let timed = |run: &Trial| Some((run.seconds?, judged(found, run)?));
    let mut curves: Vec<_> = found
        .qualified
        .iter()
        .filter_map(|one| Some(marked(one.run.method, vec![timed(&one.run)?])))
        .collect();
    if let Some(point) = chosen.and_then(timed) {
        curves.push(marked("chosen", vec![point]));
        let caption = "The methods that qualify, by the time of a run. The leftmost is chosen.";
        chart("pick-qualified", "What qualifies", "seconds", FOUND, caption, curves);
    }
}
