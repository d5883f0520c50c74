//! The result of `pick` with the charts of its runs.

use super::coarse;
use crate::chart::{Axis, Curve, LineChart, Style};
use crate::claim::{Finding, Readings, Said, in_short, sci};
use crate::manifest::RunOutcome;
use crate::report::Verdict as Holds;
use crate::scene::Scene;
use crate::sheet::{ReportError, Sheet, line, measured, of_errors, scientific};
use afterbay_analysis::Measured;
use afterbay_analysis::study::outcome::Ending;
use afterbay_analysis::study::pick::{Candidate, Pick, SAMPLES, Trial};
use serde::Serialize;

/// The tables from which the charts are made.
const TRIED: &str = "pick_tried";
const FOUND: &str = "pick";
/// The topic of the finding on a coarse error, and the words for it.
const COARSE: &str = "Wanted error";
const ERROR: [&str; 2] = ["wanted error", "an absolute error"];
/// The topic of the finding on a step in which events may be missed, and the subject of its values.
const EVENTS: &str = "Events between steps";
const STEPS: &str = "the step";
/// The label of the ring around the run that is chosen.
const CHOSEN: &str = "chosen";

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
    end_doubt_qp: f64,
    end_doubt_w: f64,
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
        end_doubt_qp: run.end_doubt_qp,
        end_doubt_w: run.end_doubt_w,
        k_drift: run.k_drift,
        passivity_violations: run.passivity_violations,
        seconds: run.seconds,
        steps: run.steps,
        evaluations: run.evaluations,
        why_not: candidate.why_not.as_deref(),
    }
}

/// The error by which a trial is judged: the larger of both, with the larger doubt.
fn judged(found: &Pick, run: &Trial) -> Option<Measured> {
    let [qp, w] = if found.wanted.at_end { run.at_end()? } else { [run.qp()?, run.w()?] };
    Some(qp.larger(w))
}

pub(super) fn sheet(scene: &Scene, found: &Pick) -> Result<Sheet, ReportError> {
    let mut sheet = Sheet::new("The cheapest method and step");
    let all = || found.qualified.iter().chain(&found.others);
    sheet.data(FOUND, &all().map(row).collect::<Vec<_>>())?;
    sheet.data(TRIED, &found.tried)?;
    let place = found.wanted.place(scene.problem.end);
    let asked = format!("within {:e} {place}", found.wanted.error);
    sheet.text(format!(
        "The error of a run is the largest error of any q_j, p_j and w_j after every step, or at \
         {SAMPLES} times if there are more steps. A step qualifies if it, every step tried within \
         5 % of it and half of it are {asked}. A tolerance qualifies if it, those from half to \
         twice as large and a quarter of it are. {} runs were compared with a reference known to \
         {:.0e}.",
        found.tried.len(),
        found.doubt.most()
    ));
    sheet.find("Pick", readings(found, &asked), the_cheapest);
    if let Some(readings) = coarse_for(found) {
        sheet.find(COARSE, readings, too_coarse);
    }
    if let Some(readings) = longer_for(scene, found) {
        sheet.find(EVENTS, readings, may_miss);
    }
    if found.interrupted {
        let model = scene.problem.model.name();
        sheet.runs.push(RunOutcome::of(&Ending::interrupted(), "pick", model, "all", scene.step));
    }
    charts(&mut sheet, found, &place);
    sheet.table(&HEADER, all().map(cells).collect());
    Ok(sheet)
}

fn readings(found: &Pick, asked: &str) -> Readings {
    let why = found.too_sensitive.map_or(String::new(), |why| why.to_string());
    let readings = Readings::default()
        .and("the search", "asked", asked)
        .and("the search", "interrupted", if found.interrupted { "yes" } else { "no" })
        .and("the scene", "too sensitive", why);
    found.qualified.iter().map(|one| &one.run).fold(readings, |r, run| {
        r.and(&format!("{} with {}", run.method, run.setting()), "seconds", run.seconds)
    })
}

/// The finding that the wanted error is coarse beside q or p; none if it is not.
pub fn coarse_error(found: &Pick) -> Option<Finding> {
    coarse_for(found).map(|readings| Finding::new(COARSE, readings, too_coarse))
}

fn coarse_for(found: &Pick) -> Option<Readings> {
    let ([q, p, _], mut readings) = (found.sizes, Readings::default());
    coarse::read(found.wanted.error, [q, p], &mut readings);
    coarse::say(ERROR, &readings).is_some().then_some(readings)
}

/// The finding that the step chosen is longer than that of the scene, so that a run may miss
/// events; none without events.
pub fn longer_step(scene: &Scene, found: &Pick) -> Option<Finding> {
    longer_for(scene, found).map(|readings| Finding::new(EVENTS, readings, may_miss))
}

fn longer_for(scene: &Scene, found: &Pick) -> Option<Readings> {
    let (run, winner) = (scene.run.as_ref()?, &found.qualified.first()?.run);
    let is_longer = winner.tolerance.is_none() && winner.h > scene.step;
    let steps = Readings::default().and(STEPS, "scene", scene.step).and(STEPS, "chosen", winner.h);
    (is_longer && !run.events.is_empty()).then_some(steps)
}

fn may_miss(r: &Readings) -> Said {
    let [scene, chosen] = ["scene", "chosen"].map(|of| in_short(r.number(STEPS, of)));
    let statement = format!(
        "Events are looked for in each step. The step found, {chosen}, is longer than that of the \
         scene, {scene}: with it `run` misses a function that crosses zero twice within a step."
    );
    (Holds::Note, statement)
}

fn too_coarse(r: &Readings) -> Said {
    (Holds::Note, coarse::say(ERROR, r).unwrap_or_default())
}

const HEADER: [&str; 8] = [
    "method",
    "step or tolerance",
    "error of (q, p)",
    "error of w",
    "at the end",
    "w at the end",
    "seconds",
    "why not",
];

fn cells(candidate: &Candidate) -> Vec<String> {
    let run = &candidate.run;
    let [end_qp, end_w] = run.at_end().map_or([None; 2], |end| end.map(Some));
    vec![
        run.method.into(),
        run.setting(),
        measured(run.qp()),
        measured(run.w()),
        measured(end_qp),
        measured(end_w),
        scientific(run.seconds),
        candidate.why_not.clone().unwrap_or_default(),
    ]
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
fn charts(sheet: &mut Sheet, found: &Pick, place: &str) {
    let chosen = found.qualified.first().map(|winner| &winner.run);
    let at = |run: &Trial| Some((run.evaluations? as f64, judged(found, run)?));
    let mut curves = tried(found, at);
    curves.extend(chosen.and_then(at).map(ring));
    if curves.is_empty() {
        return;
    }
    let bound = found.wanted.error;
    let chart = |title: &str, cost: &str, curves: Vec<Curve>| {
        let y = Axis::log(format!("largest error {place}"));
        LineChart::new(title, Axis::log(cost), y, with_bound(bound, curves))
    };
    let caption = "Every run that was tried. A method whose curve jumps or does not fall is \
                   accurate only by chance.";
    let all = chart("Runs that were tried", "evaluations of the force", curves);
    sheet.show("pick-tried", &all, caption, TRIED);
    let timed = |run: &Trial| Some((run.seconds?, judged(found, run)?));
    if let Some(point) = chosen.and_then(timed) {
        let curve = |run: &Trial| Some(of_runs(run.method, vec![timed(run)?]));
        let qualified = found.qualified.iter().filter_map(|one| curve(&one.run));
        let curves = qualified.chain([ring(point)]).collect();
        let caption = "The methods that qualify, by the time of a run. The leftmost is chosen.";
        let qualified = chart("What qualifies", "seconds", curves);
        sheet.show("pick-qualified", &qualified, caption, FOUND);
    }
}

/// The runs of one method: their costs and errors.
fn of_runs(method: &str, runs: Vec<(f64, Measured)>) -> Curve {
    of_errors(method, Style::LineMarkers, runs.into_iter())
}

/// The ring around the run that is chosen, at its error or at the bound of it.
fn ring((cost, error): (f64, Measured)) -> Curve {
    let shown = if error.is_resolved() { error.error } else { error.bound() };
    Curve { label: CHOSEN.into(), points: vec![(cost, shown)], bounds: vec![], style: Style::Ring }
}

/// A curve of the runs that were tried with each method.
fn tried(found: &Pick, at: impl Fn(&Trial) -> Option<(f64, Measured)>) -> Vec<Curve> {
    let mut methods: Vec<&str> = found.tried.iter().map(|run| run.method).collect();
    methods.dedup();
    let curve = |method: &str| {
        let runs = found.tried.iter().filter(|run| run.method == method);
        let mut points: Vec<_> = runs.filter_map(&at).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        of_runs(method, points)
    };
    let is_seen = |curve: &Curve| !curve.points.is_empty() || !curve.bounds.is_empty();
    methods.into_iter().map(curve).filter(is_seen).collect()
}

/// The curves, and a line at the bound over the range of their points.
fn with_bound(bound: f64, mut curves: Vec<Curve>) -> Vec<Curve> {
    let points = curves.iter().flat_map(|curve| curve.points.iter().chain(&curve.bounds));
    let xs = points.map(|point| point.0);
    let (low, high) = xs.fold((f64::INFINITY, 0.0_f64), |(l, h), x| (l.min(x), h.max(x)));
    if low <= high {
        curves.push(line(&format!("the bound {bound:e}"), vec![(low, bound), (high, bound)]));
    }
    curves
}

#[cfg(test)]
mod tests {
    use super::*;
    use afterbay_analysis::study::pick::Wanted;

    const SCENE: &str = r#"
[system]
name = "damped-oscillator"
parameters = { k = 1.0, b = 0.1 }
[initial]
q = [1.0]
p = [0.0]
[time]
end = 2.0
step = 0.5
"#;

    fn candidate(method: &'static str, error: f64, seconds: f64) -> Candidate {
        let run = Trial {
            method,
            h: 0.5,
            tolerance: None,
            outcome: "completed",
            error_qp: Some(error),
            error_w: Some(error),
            worst_t: 1.0,
            end_qp: Some(error),
            end_w: Some(error),
            doubt_qp: 1e-15,
            doubt_w: 1e-15,
            end_doubt_qp: 1e-15,
            end_doubt_w: 1e-15,
            samples: 4,
            k_drift: 0.0,
            passivity_violations: Some(0),
            seconds: Some(seconds),
            steps: 4,
            evaluations: Some(4),
            iterations: Some(0),
            failure: None,
            decisive: error + 1e-15,
        };
        Candidate { run, why_not: None, checked: None, times: None }
    }

    #[test]
    fn a_chosen_run_without_an_error_is_in_the_charts() {
        let wanted = Wanted { error: 1e-6, at_end: false, keep_k: false, passive: false };
        let qualified = vec![candidate("linear-exact", 0.0, 1e-7), candidate("rk4", 1e-8, 1e-6)];
        let found = Pick {
            wanted,
            tried: qualified.iter().map(|one| one.run.clone()).collect(),
            qualified,
            others: Vec::new(),
            ties: 0,
            check: None,
            doubt: afterbay_analysis::Doubt { q: 1e-15, p: 1e-15, w: 1e-15 },
            too_sensitive: None,
            interrupted: false,
            is_passive: true,
            sizes: [1.0; 3],
        };
        let sheet = sheet(&Scene::read(SCENE).expect("a scene"), &found).expect("a sheet");
        for name in ["pick-tried", "pick-qualified"] {
            let name = format!("figures/{name}.svg");
            let svg = &sheet.artifacts.iter().find(|x| x.name == name).expect("a chart").text;
            assert!(svg.contains("hollow with an arrow"), "{name}: a bound");
            assert!(!svg.contains("are not shown"), "{name}: all points are shown");
            assert_eq!(svg.matches(r#"stroke-width="2""#).count(), 2, "{name}: rings");
        }
    }
}
