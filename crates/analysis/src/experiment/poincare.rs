//! Poincaré sections: the points of each method beside those of the reference.

use super::declared::{Boxed, section};
use crate::Model;
use crate::chart::{Axis, LineChart};
use crate::claim::{Readings, Said, list};
use crate::report::Verdict;
use crate::scene::{DynamicsPlan, Scene, Variable};
use crate::sheet::{ReportError, Sheet, dotted, scientific};
use crate::study::attractor::Attractor;
use crate::study::outcome::{COMPLETED, Ending};
use crate::study::poincare::{self, Poincare, Portrait};
use afterbay_methods::registry::REFERENCE;

/// The table from which the charts are made.
const DATA: &str = "poincare";
/// The label of the reference.
const EXACT: &str = REFERENCE.name;

pub(super) fn declared<'a>(scene: &'a Scene, plan: &'a DynamicsPlan<Poincare>) -> Boxed<'a> {
    let made = |plan: &DynamicsPlan<Poincare>, parts| sheet(scene, plan, plan.gather(parts));
    section(["poincare", "Poincaré section"], plan.clone(), made)
}

fn sheet(
    scene: &Scene,
    plan: &DynamicsPlan<Poincare>,
    found: Vec<Portrait>,
) -> Result<Sheet, ReportError> {
    let mut sheet = Sheet::new("Poincaré section");
    let DynamicsPlan { study, .. } = plan;
    let model = &scene.problem.model;
    let rows: Vec<_> = found.iter().flat_map(|portrait| &portrait.rows).collect();
    sheet.wide_data(DATA, &poincare::columns(model), &rows)?;
    let records = found.iter().flat_map(|portrait| {
        let record = |ending: &Ending| {
            ending.record("poincare", model.name(), portrait.row.name, portrait.h)
        };
        portrait.endings.iter().map(record)
    });
    sheet.runs.extend(records.collect::<Vec<_>>());
    let starts = match study.starts.len() {
        1 => "from the initial state".to_owned(),
        count => format!("from each of {count} initial states"),
    };
    sheet.text(format!(
        "The states of runs {starts}, {}: {} of each run after {} that are not shown. Steps divide \
         the interval between two states of a stroboscopic section.{}",
        study.section.describe(model),
        study.points,
        study.transient,
        of_reference(plan.reference),
    ));
    let attractors: Vec<_> = found.iter().map(attractors).collect();
    let exact = found.iter().position(|portrait| portrait.row.name == EXACT);
    let mut readings = Readings::default();
    for (portrait, own) in found.iter().zip(&attractors) {
        let label = label(portrait);
        let broken = portrait.endings.iter().find(|ending| !ending.is_completed());
        let outcome = broken.map_or(COMPLETED, |ending| ending.outcome);
        readings.add(&label, "run", outcome);
        readings.add(&label, "attractors", kinds(own));
        if let Some(exact) = exact.filter(|_| portrait.row.name != EXACT) {
            // Only starts whose reference has an attractor are compared.
            let pairs =
                || own.iter().zip(&attractors[exact]).filter_map(|(a, b)| Some((a, b.as_ref()?)));
            let starts = pairs().count();
            if starts > 0 {
                let like = |(a, b): (&Option<Attractor>, &Attractor)| {
                    a.as_ref().is_some_and(|a| b.is_like(a))
                };
                readings.add(
                    &label,
                    "other attractors",
                    starts - pairs().filter(|&x| like(x)).count(),
                );
                readings.add(&label, "starts", starts);
                let both = pairs().filter_map(|(a, b)| Some((a.as_ref()?, b)));
                let off = both.map(|(a, b)| b.distance(a)).reduce(f64::max);
                readings.add(&label, "distance", off);
            }
        }
    }
    let table = found.iter().map(|portrait| {
        let label = label(portrait);
        let number = |what: &str| Some(readings.number(&label, what)).filter(|x| !x.is_nan());
        vec![
            label.clone(),
            readings.word(&label, "run").to_owned(),
            portrait.rows.len().to_string(),
            readings.word(&label, "attractors").to_owned(),
            scientific(number("distance")),
        ]
    });
    let header = ["method and step", "run", "points", "attractor", "distance from the reference"];
    sheet.table(&header, table.collect());
    sheet.find("Poincaré section", readings, what_is_seen);
    let exact = exact.map(|exact| points(&found[exact]));
    for (nth, portrait) in found.iter().enumerate() {
        if portrait.row.name == EXACT && found.len() > 1 {
            continue;
        }
        let own = (portrait.row.name != EXACT).then(|| dotted(&label(portrait), points(portrait)));
        let reference = exact.clone().map(|points| dotted(EXACT, points));
        let chart = LineChart {
            title: format!("{}: {}", title(study, model), label(portrait)),
            x: Axis::linear(scene.units.variable(Variable::Q, "q1")),
            y: Axis::linear(scene.units.variable(Variable::P, "p1")),
            curves: reference.into_iter().chain(own).collect(),
            guides: Vec::new(),
        };
        let name = format!("poincare-{}-{nth}", portrait.row.name);
        sheet.show(&name, &chart, "Grey: the reference. It lies below the method.", DATA);
    }
    Ok(sheet)
}

/// How the reference is computed, in words.
pub(super) fn of_reference(h: Option<f64>) -> String {
    h.map_or(String::new(), |h| {
        format!(" The reference takes steps of nearly {h:.2e} with DOP853.")
    })
}

/// A method and its step.
fn label(portrait: &Portrait) -> String {
    match portrait.row.name {
        EXACT => EXACT.into(),
        name => format!("{name}, h = {:.4}", portrait.h),
    }
}

fn title(study: &Poincare, model: &Model) -> String {
    match study.section.interval(model) {
        Some(interval) => format!("States once every {interval:.4}"),
        None => format!("States {}", study.section.describe(model)),
    }
}

fn points(portrait: &Portrait) -> Vec<(f64, f64)> {
    portrait.rows.iter().map(|row| (row.q[0], row.p[0])).collect()
}

/// The attractor of each start, if its run got far enough.
fn attractors(portrait: &Portrait) -> Vec<Option<Attractor>> {
    let of_start = |start: usize| {
        let rows = portrait.rows.iter().filter(|row| row.start == start + 1);
        let points: Vec<_> = rows.map(|row| [row.q.clone(), row.p.clone()]).collect();
        let done = portrait.endings[start].is_completed();
        Attractor::of(&points).filter(|_| done)
    };
    (0..portrait.endings.len()).map(of_start).collect()
}

/// The kinds of all attractors, each once.
fn kinds(attractors: &[Option<Attractor>]) -> String {
    let mut found: Vec<String> = Vec::new();
    for attractor in attractors {
        let kind = attractor.as_ref().map_or("none".into(), |found| found.kind.describe());
        if !found.contains(&kind) {
            found.push(kind);
        }
    }
    list(found)
}

fn what_is_seen(r: &Readings) -> Said {
    let one = |label: &str| {
        let (run, kinds) = (r.word(label, "run"), r.word(label, "attractors"));
        let end = if run == COMPLETED { String::new() } else { format!(" ({run})") };
        let (other, starts) = (r.number(label, "other attractors"), r.number(label, "starts"));
        let beside = match (other, starts) {
            (other, _) if other.is_nan() => String::new(),
            (0.0, 1.0) => ", as the reference".into(),
            (0.0, _) => ", each start as the reference".into(),
            (_, 1.0) => ", not the attractor of the reference".into(),
            (other, starts) => {
                format!(", another attractor than the reference from {other} of {starts} starts")
            }
        };
        format!("{label}: {kinds}{beside}{end}")
    };
    let all = r.of_all("attractors");
    let right = r.numbers("other attractors").iter().all(|(_, other)| *other == 0.0);
    let done = all.iter().all(|label| r.word(label, "run") == COMPLETED);
    let verdict = if right && done { Verdict::Note } else { Verdict::Fails };
    (verdict, format!("{}.", all.into_iter().map(one).collect::<Vec<_>>().join("; ")))
}
