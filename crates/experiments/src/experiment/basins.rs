//! Basins of attraction: a map for each method and step, beside that of the reference.

use super::declared::{Boxed, section};
use super::reference::{REFERENCE_LABEL, label, of_reference};
use crate::chart::{Axis, Cells, HeatMap};
use crate::claim::{Readings, Said, counted, fixed, in_full, list, note};
use crate::findings::all_zero;
use crate::manifest::RunOutcome;
use crate::scene::Scene;
use crate::sheet::{ReportError, Sheet, decimal};
use afterbay_analysis::Model;
use afterbay_analysis::study::basins::{
    self, BasinMap, Basins, MOST_ATTRACTORS, TOO_MANY, UNSETTLED, UNSTABLE,
};
use afterbay_analysis::study::dynamics::DynamicsPlan;
use afterbay_analysis::study::outcome::{COMPLETED, Ending, INTERRUPTED};

/// The table from which the maps are made.
const DATA: &str = "basins";
/// The most attractors with a colour of their own.
const MOST_COLOURS: usize = 8;

pub(super) fn declared<'a>(scene: &'a Scene, plan: &'a DynamicsPlan<Basins>) -> Boxed<'a> {
    let made = |plan: &DynamicsPlan<Basins>, parts| sheet(scene, plan, plan.gather(parts));
    section(["basins", "basins of attraction"], plan.clone(), made)
}

fn sheet(
    scene: &Scene,
    plan: &DynamicsPlan<Basins>,
    mut found: Vec<BasinMap>,
) -> Result<Sheet, ReportError> {
    let (mut sheet, study) = (Sheet::new("Basins of attraction"), &plan.study);
    let model = &scene.problem.model;
    if let Some((exact, others)) =
        found.split_first_mut().filter(|(x, _)| x.row.name == REFERENCE_LABEL)
    {
        others.iter_mut().for_each(|map| map.renumber(exact));
    }
    let rows: Vec<_> = found.iter().flat_map(|map| study.rows(map)).collect();
    sheet.wide_data(DATA, &basins::columns(model), &rows)?;
    sheet.runs.extend(found.iter().map(|map| {
        let failed =
            map.cells.iter().position(|cell| ![COMPLETED, UNSTABLE].contains(&cell.ending.outcome));
        let ending = failed.map_or(Ending::completed(), |i| map.cells[i].ending.clone());
        let (point, row, h) = (failed.map(|i| place(study, i)), map.row, map.h);
        RunOutcome { point, ..RunOutcome::of(&ending, "basins", model.name(), row.name, h) }
    }));
    sheet.text(prose(plan, model));
    sheet.table(&HEADER, found.iter().flat_map(cells).collect());
    sheet.find("Basins of attraction", readings(study, &found), what_is_seen);
    let figure = |(nth, map): (usize, &BasinMap)| {
        let caption = "The attractor that each initial state reaches.";
        let name = format!("basins-{}-{nth}", map.row.name);
        sheet.figure(&name, chart(scene, study, map).draw(), caption, DATA)
    };
    let figures: Vec<_> = found.iter().enumerate().map(figure).collect();
    sheet.show_pairs(figures);
    Ok(sheet)
}

/// The values of cell i of the grid, in words.
fn place(study: &Basins, i: usize) -> String {
    let width = study.axes[0].values.len();
    let of = |axis: &basins::Axis, at: usize| {
        let letter = axis.variable.letter();
        format!("{letter}{} = {}", axis.dof + 1, in_full(axis.values[at]))
    };
    let [x, y] = &study.axes;
    format!("{}, {}", of(x, i % width), of(y, i / width))
}

fn prose(plan: &DynamicsPlan<Basins>, model: &Model) -> String {
    let [width, height] = plan.study.axes.each_ref().map(|axis| axis.values.len());
    format!(
        "Runs from {width} × {height} initial states, observed {}. A run has reached an attractor \
         when its states repeat, when they stay near an attractor that another run has shown, or \
         when they fill a region of the same extent all along{}. One that still moves towards \
         something, or away, is unsettled. One that comes to an equilibrium or a cycle from which \
         small displacements grow lies on a boundary, and reaches no attractor. No more than \
         {MOST_ATTRACTORS} attractors are told apart: a run to another reaches none. The boundary \
         between basins has the dimension 2 - α, where the share of cells with a cell of another \
         attractor at a distance ε grows like ε^α; runs that fail count as one basin there, and \
         other cells without an attractor are left out.{}",
        plan.study.section.describe(model),
        if plan.study.is_autonomous() { ", with the whole of their path" } else { "" },
        of_reference(plan.reference),
    )
}

fn readings(study: &Basins, found: &[BasinMap]) -> Readings {
    let width = study.axes[0].values.len();
    let exact = found.first().filter(|first| first.row.name == REFERENCE_LABEL);
    let mut readings = Readings::default();
    for map in found {
        let label = label(map.row, map.h);
        let count =
            |which: fn(&basins::Cell) -> bool| map.cells.iter().filter(|cell| which(cell)).count();
        readings.add(&label, "cells", map.cells.len());
        readings.add(&label, "unsettled", count(|cell| cell.ending.outcome == UNSETTLED));
        readings.add(&label, TOO_MANY, count(|cell| cell.ending.outcome == TOO_MANY));
        readings.add(&label, UNSTABLE, count(|cell| cell.ending.outcome == UNSTABLE));
        let failed = count(|cell| {
            ![COMPLETED, UNSETTLED, TOO_MANY, UNSTABLE, INTERRUPTED].contains(&cell.ending.outcome)
        });
        readings.add(&label, "failed", failed);
        readings.add(&label, INTERRUPTED, count(|cell| cell.ending.is_interrupted()));
        let reached = map.shares().iter().filter(|share| **share > 0.0).count();
        readings.add(&label, "attractors", reached);
        if map.has_boundary(width) {
            readings.add(&label, "α", map.uncertainty(width));
        }
        if let Some(exact) = exact.filter(|_| map.row.name != REFERENCE_LABEL) {
            compare(&mut readings, &label, map, exact);
        }
    }
    readings
}

/// Compares a map with that of the reference, cell by cell.
fn compare(readings: &mut Readings, label: &str, map: &BasinMap, exact: &BasinMap) {
    let reached = |(own, exact): &(&basins::Cell, &basins::Cell)| {
        !own.ending.is_interrupted() && !exact.ending.is_interrupted()
    };
    let pairs = || map.cells.iter().zip(&exact.cells).filter(reached);
    let of_exact = || pairs().filter(|(_, exact)| exact.attractor.is_some());
    let same = of_exact().filter(|(own, exact)| own.attractor == exact.attractor);
    let others =
        pairs().filter(|(own, exact)| own.attractor.is_some() && exact.attractor.is_none());
    readings.add(label, "cells of the reference", of_exact().count());
    readings.add(label, "as the reference", same.count());
    readings.add(label, "others", others.count());
}

const HEADER: [&str; 4] = ["method and step", "attractor", "kind", "share of the cells"];

/// A row for each attractor that some run has reached.
fn cells(map: &BasinMap) -> impl Iterator<Item = Vec<String>> {
    let shares = map.shares().into_iter().enumerate().filter(|(_, share)| *share > 0.0);
    shares.map(|(k, share)| {
        let attractor = map.attractors[k].describe();
        vec![label(map.row, map.h), (k + 1).to_string(), attractor, decimal(Some(share))]
    })
}

fn chart(scene: &Scene, study: &Basins, map: &BasinMap) -> HeatMap {
    let axis = |k: usize| {
        let axis = &study.axes[k];
        let letter = axis.variable.letter();
        Axis::linear(
            scene.units.variable(axis.variable, &format!("{letter}{} at t = 0", axis.dof + 1)),
        )
    };
    let shown = map.attractors.len().min(MOST_COLOURS);
    let mut names: Vec<String> =
        (0..shown).map(|k| format!("{}: {}", k + 1, map.attractors[k].describe())).collect();
    names.push(if map.attractors.len() > shown { "others, or none" } else { "none" }.into());
    let verdicts = map.cells.iter();
    let verdicts = verdicts.map(|cell| cell.attractor.map_or(shown, |k| k.min(shown))).collect();
    HeatMap {
        title: format!("Attractor: {}", label(map.row, map.h)),
        x: axis(0),
        y: axis(1),
        xs: study.axes[0].values.clone(),
        ys: study.axes[1].values.clone(),
        cells: Cells::Verdicts { names, verdicts },
    }
}

fn what_is_seen(r: &Readings) -> Said {
    let one = |label: &str| {
        let number = |what: &str| r.number(label, what);
        let mut said = vec![match number("attractors") {
            1.0 => "1 attractor".to_owned(),
            count => format!("{count} attractors"),
        }];
        let (alike, of) = (number("as the reference"), number("cells of the reference"));
        if of > 0.0 {
            let share = fixed(100.0 * alike / of, 1);
            let cells = counted(of, "cell");
            said.push(format!(
                "that of the reference in {share} % of the {cells} where it has one"
            ));
        }
        if number("others") > 0.0 {
            let cells = counted(number("others"), "cell");
            said.push(format!("one in {cells} where the reference has none"));
        }
        if r.of_all("α").contains(&label) {
            said.push(match number("α") {
                alpha if alpha.is_nan() => "α not known".to_owned(),
                alpha => format!("α = {}", fixed(alpha, 2)),
            });
        }
        let lasting = "on an unstable equilibrium or cycle";
        let beyond = format!("at none of the {MOST_ATTRACTORS} attractors that are told apart");
        for (what, word) in [
            ("unsettled", "unsettled"),
            (TOO_MANY, &beyond),
            (UNSTABLE, lasting),
            ("failed", "failed"),
            (INTERRUPTED, INTERRUPTED),
        ] {
            if number(what) > 0.0 {
                said.push(format!(
                    "{} of {} {word}",
                    number(what),
                    counted(number("cells"), "cell")
                ));
            }
        }
        format!("{label}: {}", list(said))
    };
    let all_done = all_zero(r, "failed") && all_zero(r, INTERRUPTED);
    (note(all_done), r.each("cells", one))
}
