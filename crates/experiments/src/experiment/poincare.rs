//! Poincaré sections: the points of each method beside those of the reference.

use super::declared::{Boxed, section};
use super::reference::{REFERENCE_LABEL, States, label, of_reference, show_states};
use crate::chart::{Axis, LineChart};
use crate::claim::{Readings, Said, list, note, significant};
use crate::findings::{all_completed, all_zero, ended};
use crate::manifest::RunOutcome;
use crate::scene::Scene;
use crate::sheet::{ReportError, Sheet, scientific};
use afterbay_analysis::Model;
use afterbay_analysis::Variable;
use afterbay_analysis::study::attractor::{Attractor, OF_ONE_POINT, POINTS_A_RETURN, SETTLING};
use afterbay_analysis::study::dynamics::DynamicsPlan;
use afterbay_analysis::study::growing::GROWING;
use afterbay_analysis::study::outcome::{COMPLETED, Ending};
use afterbay_analysis::study::poincare::{self, Poincare, Portrait};

/// The table from which the charts are made.
const DATA: &str = "poincare";

/// The number of motions with too few points to tell whether they settle.
const FEW: &str = "of few points";

pub(super) fn declared<'a>(scene: &'a Scene, plan: &'a DynamicsPlan<Poincare>) -> Boxed<'a> {
    let made = |plan: &DynamicsPlan<Poincare>, parts| sheet(scene, plan, plan.gather(parts));
    section(["poincare", "Poincaré section"], plan.clone(), made)
}

fn sheet(
    scene: &Scene,
    plan: &DynamicsPlan<Poincare>,
    found: Vec<Portrait>,
) -> Result<Sheet, ReportError> {
    let (mut sheet, model) = (Sheet::new("Poincaré section"), &scene.problem.model);
    let rows: Vec<_> = found.iter().flat_map(|portrait| &portrait.rows).collect();
    sheet.wide_data(DATA, &poincare::columns(model), &rows)?;
    for Portrait { row, h, endings, .. } in &found {
        let record = |(start, ending): (usize, &Ending)| {
            let point = (endings.len() > 1).then(|| format!("start {}", start + 1));
            RunOutcome { point, ..RunOutcome::of(ending, "poincare", model.name(), row.name, *h) }
        };
        sheet.runs.extend(endings.iter().enumerate().map(record));
    }
    sheet.text(prose(plan, model));
    let readings = readings(&found);
    sheet.table(&HEADER, found.iter().map(|portrait| cells(portrait, &readings)).collect());
    sheet.find("Poincaré section", readings, what_is_seen);
    let states = |portrait: &Portrait| States {
        row: portrait.row,
        label: label(portrait.row, portrait.h),
        points: portrait.rows.iter().map(|row| (row.q[0], row.p[0])).collect(),
    };
    let states: Vec<_> = found.iter().map(states).collect();
    show_states(&mut sheet, DATA, &states, |label, curves| {
        let title = format!("{}: {label}", title(&plan.study, model));
        let x = Axis::linear(scene.units.variable(Variable::Q, "q1"));
        let y = Axis::linear(scene.units.variable(Variable::P, "p1"));
        LineChart::new(title, x, y, curves)
    });
    Ok(sheet)
}

fn prose(plan: &DynamicsPlan<Poincare>, model: &Model) -> String {
    let study = &plan.study;
    let starts = match study.starts.len() {
        1 => "from the initial state".to_owned(),
        count => format!("from each of {count} initial states"),
    };
    format!(
        "The states of runs {starts}, {}: {} of each run after {} that are not shown. A run whose \
         size rises all along, to three times or more, grows, and shows no attractor. Steps \
         divide the interval between two states of a stroboscopic section.{}",
        study.section.describe(model),
        study.points,
        study.transient,
        of_reference(plan.reference),
    )
}

fn readings(found: &[Portrait]) -> Readings {
    let attractors: Vec<_> = found.iter().map(Portrait::attractors).collect();
    let exact = found.iter().position(|portrait| portrait.row.name == REFERENCE_LABEL);
    let mut readings = Readings::default();
    for (portrait, own) in found.iter().zip(&attractors) {
        let label = label(portrait.row, portrait.h);
        let broken = portrait.endings.iter().find(|ending| !ending.is_completed());
        readings.add(&label, "run", broken.map_or(COMPLETED, |ending| ending.outcome));
        readings.add(&label, "attractors", kinds(own, &portrait.endings));
        let few = own.iter().flatten().filter(|own| own.of_few_points().is_some()).count();
        if few > 0 {
            readings.add(&label, FEW, few);
        }
        if let Some(exact) = exact.filter(|_| portrait.row.name != REFERENCE_LABEL) {
            let reached = own.iter().zip(&attractors[exact]).zip(&portrait.endings);
            let reached = reached.filter(|(_, ending)| !ending.is_interrupted());
            compare(&mut readings, &label, &reached.map(|(pair, _)| pair).collect::<Vec<_>>());
        }
    }
    readings
}

/// Compares attractors with those of the reference, start by start. Starts whose reference has no
/// attractor are left out, and those from which only one of the two motions is still settling, or
/// only one of two in the same place counts as rest.
fn compare(
    readings: &mut Readings,
    label: &str,
    pairs: &[(&Option<Attractor>, &Option<Attractor>)],
) {
    let comparable = |pair: &&(&Option<Attractor>, &Option<Attractor>)| {
        let (Some(own), Some(exact)) = pair else { return true };
        let alike = own.rests() == exact.rests() || !exact.is_like(own);
        alike && own.is_settling() == exact.is_settling()
    };
    let pairs: Vec<_> = pairs.iter().filter(comparable).collect();
    let pairs = || pairs.iter().filter_map(|(own, exact)| Some((*own, exact.as_ref()?)));
    let starts = pairs().count();
    if starts > 0 {
        let both = || pairs().filter_map(|(own, exact)| Some((own.as_ref()?, exact)));
        let alike = both().filter(|(own, exact)| exact.is_like(own)).count();
        let off = both().map(|(own, exact)| exact.distance(own)).reduce(f64::max);
        readings.add(label, "other attractors", starts - alike);
        readings.add(label, "starts", starts);
        readings.add(label, "distance", off);
    }
}

const HEADER: [&str; 5] =
    ["method and step", "run", "points", "attractor", "distance from the reference"];

fn cells(portrait: &Portrait, readings: &Readings) -> Vec<String> {
    let label = label(portrait.row, portrait.h);
    vec![
        label.clone(),
        readings.word(&label, "run").to_owned(),
        portrait.rows.len().to_string(),
        readings.word(&label, "attractors").to_owned(),
        scientific(readings.known(&label, "distance")),
    ]
}

fn title(study: &Poincare, model: &Model) -> String {
    match study.section.interval(model) {
        Some(interval) => format!("States once every {}", significant(interval, 5)),
        None => format!("States {}", study.section.describe(model)),
    }
}

/// The kinds of all attractors, each once. A run that grows has none, and is told from one that
/// fails.
fn kinds(attractors: &[Option<Attractor>], endings: &[Ending]) -> String {
    let mut found: Vec<String> = Vec::new();
    for (attractor, ending) in attractors.iter().zip(endings) {
        let none = match ending.outcome {
            GROWING => "no attractor".into(),
            COMPLETED => format!("no period {OF_ONE_POINT}"),
            _ => "none".into(),
        };
        let kind = attractor.as_ref().map_or(none, Attractor::describe);
        if !found.contains(&kind) {
            found.push(kind);
        }
    }
    list(found)
}

fn what_is_seen(r: &Readings) -> Said {
    let one = |label: &str| {
        let (kinds, end) = (r.word(label, "attractors"), ended(r, label));
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
    let right = all_zero(r, "other attractors") && all_completed(r, "attractors");
    let mut said = r.each("attractors", one);
    if r.of_all("attractors").iter().any(|of| r.word(of, "attractors").contains(SETTLING)) {
        said += " A longer transient shows what a motion that is still settling comes to.";
    }
    if !r.of_all(FEW).is_empty() {
        said += &format!(
            " Fewer than {POINTS_A_RETURN} points do not tell whether a motion is still settling."
        );
    }
    (note(right), said)
}
