//! Bifurcation diagrams: the points of each method beside those of the reference.

use super::declared::{Boxed, section};
use super::reference::{REFERENCE_LABEL, States, label, of_reference, show_states};
use crate::chart::{Axis, LineChart};
use crate::claim::{Readings, Said, counted, in_full, list, note, significant};
use crate::findings::all_zero;
use crate::manifest::RunOutcome;
use crate::scene::Scene;
use crate::sheet::{ReportError, Sheet, spaced};
use afterbay_analysis::Model;
use afterbay_analysis::Variable;
use afterbay_analysis::study::attractor::{Attractor, Kind, OF_ONE_POINT, REST};
use afterbay_analysis::study::bifurcation::{self, Bifurcation, Column, Diagram, Way};
use afterbay_analysis::study::dynamics::DynamicsPlan;
use afterbay_analysis::study::growing::GROWING;
use afterbay_analysis::study::outcome::Ending;

/// The table from which the charts are made.
const DATA: &str = "bifurcation";
/// The word for a value at which the run fails.
const FAILED: &str = "failed";
/// The words for a diagram none of whose runs was begun.
const NOT_REACHED: &str = "nothing computed";
/// The number of values at which a method is compared with the reference, or of runs, of which
/// there are two at each value if each run begins where the one before ended.
const VALUES: &str = "compared";
const RUNS: &str = "compared runs";
/// The words that are not the period of a cycle.
const WITHOUT_PERIOD: [&str; 4] = [GROWING, REST, FAILED, NOT_REACHED];
/// The most changes of the period that a sentence names.
const MOST_NAMED: usize = 6;

pub(super) fn declared<'a>(scene: &'a Scene, plan: &'a DynamicsPlan<Bifurcation>) -> Boxed<'a> {
    let made = |plan: &DynamicsPlan<Bifurcation>, parts| sheet(scene, plan, plan.gather(parts));
    section(["bifurcation", "bifurcation diagram"], plan.clone(), made)
}

fn sheet(
    scene: &Scene,
    plan: &DynamicsPlan<Bifurcation>,
    found: Vec<Diagram>,
) -> Result<Sheet, ReportError> {
    let (mut sheet, study) = (Sheet::new("Bifurcation diagram"), &plan.study);
    let model = &scene.problem.model;
    let rows: Vec<_> =
        found.iter().flat_map(|diagram| diagram.rows(&study.parameter, model.degrees())).collect();
    sheet.wide_data(DATA, &bifurcation::columns(model), &rows)?;
    sheet.runs.extend(found.iter().map(|diagram| {
        let worst = diagram.columns.iter().find(|column| !column.ending.is_completed());
        let ending = worst.or(diagram.columns.first()).map(|column| column.ending.clone());
        let ending = ending.unwrap_or_else(Ending::interrupted);
        let point = worst.map(|column| format!("{} = {}", study.parameter, in_full(column.value)));
        let (row, h) = (diagram.row, diagram.h);
        RunOutcome { point, ..RunOutcome::of(&ending, "bifurcation", model.name(), row.name, h) }
    }));
    sheet.text(prose(plan, model));
    sheet.find("Bifurcation diagram", readings(study, &found), what_is_seen);
    let states = |diagram: &Diagram| States {
        row: diagram.row,
        label: label(diagram.row, diagram.h),
        points: points(diagram),
    };
    let states: Vec<_> = found.iter().map(states).collect();
    show_states(&mut sheet, DATA, &states, |label, curves| {
        let title = format!("States against {}: {label}", study.parameter);
        let x = spaced(&study.parameter, study.spacing);
        let y = Axis::linear(scene.units.variable(Variable::Q, "q1"));
        LineChart::new(title, x, y, curves)
    });
    Ok(sheet)
}

fn prose(plan: &DynamicsPlan<Bifurcation>, model: &Model) -> String {
    let study = &plan.study;
    let begin = if study.follow {
        "Each run begins where that of the value before ended, once upwards and once downwards; \
         after one that fails, grows or comes to rest, at the initial state."
    } else {
        "Each run begins at the initial state."
    };
    format!(
        "States {}, {} of each run after {} that are not shown, for {} values of {}. {begin} Two \
         attractors count as the same if both have one period and lie within 5 % of the extents \
         of their motions, or if neither has a period and their extents agree. A run whose \
         size rises all along, to three times or more, grows, and shows no attractor.{}",
        study.section.describe(model),
        study.points,
        study.transient,
        study.values.len(),
        study.parameter,
        of_reference(plan.reference),
    )
}

fn readings(study: &Bifurcation, found: &[Diagram]) -> Readings {
    let exact = found.iter().find(|diagram| diagram.row.name == REFERENCE_LABEL);
    let exact = exact.map(|exact| (exact, kinds(exact)));
    // A motion that still settles has no attractor yet.
    let settled = |kinds: &[Option<Attractor>]| -> Vec<_> {
        let settled = |kind: &Option<Attractor>| kind.clone().filter(|x| !x.is_settling());
        kinds.iter().map(settled).collect()
    };
    let exact = exact.map(|(exact, kinds)| (exact, settled(&kinds)));
    let mut readings = Readings::default();
    for diagram in found {
        let (label, own) = (label(diagram.row, diagram.h), kinds(diagram));
        let count =
            |which: fn(&Column) -> bool| diagram.columns.iter().filter(|x| which(x)).count();
        readings.add(&label, "values", diagram.columns.len());
        readings.add(&label, "failed runs", count(Column::failed));
        readings.add(&label, "growing runs", count(Column::grows));
        readings.add(&label, "interrupted runs", count(|column| column.ending.is_interrupted()));
        readings.add(&label, "changes", changes(diagram, &own, &study.parameter));
        if let Some(exact) = exact.as_ref().filter(|_| diagram.row.name != REFERENCE_LABEL) {
            let own = settled(&own);
            // A diagram that was interrupted may lack any of its columns.
            let reached = |column: &Column| !column.ending.is_interrupted();
            let beside = |own: &Column| {
                let same = |(column, _): &(&Column, _)| {
                    reached(column) && column.way == own.way && column.value == own.value
                };
                exact.0.columns.iter().zip(&exact.1).find(same).map(|(_, kind)| kind)
            };
            let pairs: Vec<_> = own
                .iter()
                .zip(&diagram.columns)
                .filter(|(_, column)| reached(column))
                .filter_map(|(own, column)| Some(((own, beside(column)?), column.value)))
                .collect();
            let values = || pairs.iter().copied();
            let pairs = || values().map(|(pair, _)| pair);
            let same = |(own, exact): (&Option<Attractor>, &Option<Attractor>)| {
                own.as_ref().zip(exact.as_ref()).is_some_and(|(own, exact)| exact.is_like(own))
            };
            let known = pairs().filter(|(_, exact)| exact.is_some()).count();
            if known > 0 {
                let alike = pairs().filter(|&pair| same(pair)).count();
                readings.add(&label, if study.follow { RUNS } else { VALUES }, known);
                readings.add(&label, "as the reference", alike);
            }
            let others = pairs().filter(|(own, exact)| own.is_some() && exact.is_none()).count();
            readings.add(&label, "others", others);
            let first = values().find(|&(pair, _)| pair.1.is_some() && !same(pair));
            readings.add(&label, "first other value", first.map(|(_, value)| value));
        }
    }
    readings
}

fn points(diagram: &Diagram) -> Vec<(f64, f64)> {
    let of = |column: &Column| {
        let value = column.value;
        column.points.iter().map(move |[q, _]| (value, q[0])).collect::<Vec<_>>()
    };
    diagram.columns.iter().flat_map(of).collect()
}

/// The attractor of each value.
fn kinds(diagram: &Diagram) -> Vec<Option<Attractor>> {
    diagram.columns.iter().map(Column::attractor).collect()
}

/// The values at which the period changes, in words.
fn changes(diagram: &Diagram, kinds: &[Option<Attractor>], parameter: &str) -> String {
    let word = |i: usize| match &kinds[i] {
        Some(found) if found.rests() => REST.into(),
        Some(found) if found.is_settling() => "none yet".into(),
        Some(found) => match found.kind {
            Kind::Period(period) => period.to_string(),
            Kind::Aperiodic => match found.of_few_points() {
                Some(points) => format!("none {points}"),
                None => "none".into(),
            },
        },
        None if diagram.columns[i].grows() => GROWING.into(),
        None if diagram.columns[i].ending.is_completed() => format!("none {OF_ONE_POINT}"),
        None => FAILED.into(),
    };
    let way = |i: usize| diagram.columns[i].way;
    let reached = (0..kinds.len()).filter(|&i| !diagram.columns[i].ending.is_interrupted());
    // The columns downwards are in the order of the values, too.
    let (mut downwards, mut reached): (Vec<_>, Vec<_>) =
        reached.partition(|&i| way(i) == Way::Down);
    downwards.reverse();
    reached.append(&mut downwards);
    let change = |pair: &[usize]| {
        let [before, after] = [pair[0], pair[1]];
        let [from, to] = [before, after].map(word);
        let value = significant(diagram.columns[after].value, 5);
        let direction = match way(after) {
            Way::Afresh => "",
            Way::Up => " upwards",
            Way::Down => " downwards",
        };
        let is_one = from != to && way(before) == way(after);
        is_one.then(|| format!("{from} to {to} at {parameter} = {value}{direction}"))
    };
    let all: Vec<String> = reached.windows(2).filter_map(change).collect();
    match all.len() {
        0 => reached.first().map_or(NOT_REACHED.into(), |&i| format!("{} throughout", word(i))),
        count if count > MOST_NAMED => {
            let more = counted(count - MOST_NAMED, "more change");
            format!("{}, and {more}", all[..MOST_NAMED].join(", "))
        }
        _ => all.join(", "),
    }
}

fn what_is_seen(r: &Readings) -> Said {
    let one = |label: &str| {
        let number = |what: &str| r.number(label, what);
        let alike = r.number(label, "as the reference");
        let beside = if alike.is_nan() {
            match r.word(label, "changes") {
                changes if changes == format!("{FAILED} throughout") => {
                    "no run completes".to_owned()
                }
                changes if WITHOUT_PERIOD.iter().any(|word| changes.starts_with(word)) => {
                    changes.to_owned()
                }
                changes => format!("period {changes}"),
            }
        } else {
            let (all, at, thing) = match r.known(label, RUNS) {
                Some(runs) => (runs, "in", "run"),
                None => (number(VALUES), "at", "value"),
            };
            // The reference may have none at the other values.
            let known = if all < number("values") { " where it has one" } else { "" };
            let at = match (alike == all, all) {
                (true, 1.0) => format!("{at} the {thing}"),
                (true, 2.0) => format!("{at} both {thing}s"),
                (true, _) => format!("{at} all {}", counted(all, thing)),
                (false, _) => format!("{at} {alike} of {}", counted(all, thing)),
            };
            let first = significant(number("first other value"), 5);
            let other = if alike == all {
                String::new()
            } else {
                format!(", another, or none, first at {first}")
            };
            format!("the attractor of the reference {at}{known}{other}")
        };
        let mut end = Vec::new();
        if number("others") > 0.0 {
            end.push(format!("one at {} where the reference has none", number("others")));
        }
        if number("growing runs") > 0.0 {
            end.push(match number("growing runs") {
                1.0 => "1 run grows and has no attractor".into(),
                count => format!("{count} runs grow and have no attractor"),
            });
        }
        for (what, word) in [("failed runs", "failed"), ("interrupted runs", "interrupted")] {
            if number(what) > 0.0 {
                end.push(format!("{} {word}", counted(number(what), "run")));
            }
        }
        let end = if end.is_empty() { String::new() } else { format!(" ({})", list(end)) };
        format!("{label}: {beside}{end}")
    };
    let all_done = all_zero(r, "failed runs") && all_zero(r, "interrupted runs");
    (note(all_done), r.each("values", one))
}
