//! Trajectories by each method.

mod kept;

use super::coarse;
use super::declared::{Boxed, section_of_rows};
use super::figures::{self, Drawn};
use crate::artifact::Artifact;
use crate::claim::{Readings, Said, deviation, in_full, note, significant};
use crate::journal::JournalError;
use crate::manifest::RunOutcome;
use crate::scene::{FigurePlan, RunPlan, Scene};
use crate::sheet::{Number, Placed, ReportError, Sheet, scientific};
use afterbay_analysis::progress::Progress;
use afterbay_analysis::rows::{RowWriter, Shelf};
use afterbay_analysis::study::Problem;
use afterbay_analysis::study::cell::{Cell, Leg, Study, all_legs};
use afterbay_analysis::study::events::{self, EventPlan, EventRow, EventRun};
use afterbay_analysis::study::outcome::COMPLETED;
use afterbay_analysis::study::section::is_multiple;
use afterbay_analysis::study::trajectory::{self, Legs, Steps, Trajectory, TrajectoryRow};
use afterbay_core::Passive;
use afterbay_methods::registry::{Row, find};
use kept::{Kept, stride, thinned};
use serde::{Deserialize, Serialize};

/// The most coordinates, and momenta, whose ends are numbers of a sweep.
const MOST_ENTRIES: usize = 4;
/// The topic of the summary.
pub(super) const TOPIC: &str = "Trajectories";
/// The reading of a rise of H where H can only fall.
pub(super) const RISE: &str = "rise";
/// The table from which the charts are made.
const DATA: &str = "trajectory";

/// The run of each method.
struct Runs<'a> {
    scene: &'a Scene,
    plan: &'a RunPlan,
}

/// A run, or the first legs of one, its states and its events.
#[derive(Serialize, Deserialize)]
struct Found {
    legs: Legs,
    kept: Kept,
    events: Vec<EventRow>,
}

pub(super) fn declared<'a>(scene: &'a Scene, plan: &'a RunPlan) -> Boxed<'a> {
    let made = |_: &Runs<'_>, found, shelf: Option<&Shelf>| sheet(scene, plan, found, shelf);
    section_of_rows(["run", "trajectories"], Runs { scene, plan }, made)
}

impl Runs<'_> {
    fn row(&self, index: usize) -> &'static Row {
        let RunPlan { methods, adaptive, .. } = self.plan;
        methods.get(index).copied().unwrap_or_else(|| adaptive[index - methods.len()])
    }

    fn steps(&self) -> Steps {
        let RunPlan { every, tolerance, .. } = *self.plan;
        Steps { h: self.scene.step, every, tolerance }
    }
}

impl Study for Runs<'_> {
    type Shared = ();
    type Part = Found;
    type Error = ReportError;

    fn cells(&self) -> Vec<Cell> {
        let Problem { model, end, .. } = &self.scene.problem;
        let cost = (end / self.scene.step).round() * model.degrees() as f64;
        self.plan.names().into_iter().map(|name| Cell::new(name.into(), cost)).collect()
    }

    fn share(&self, _progress: &dyn Progress) -> Result<(), ReportError> {
        Ok(())
    }

    fn compute(
        &self,
        (): &(),
        index: usize,
        progress: &dyn Progress,
    ) -> Result<Found, ReportError> {
        all_legs(self, &(), index, progress)
    }

    fn fraction_done(&self, found: &Found) -> f64 {
        found.legs.done() as f64 * self.scene.step / self.scene.problem.end
    }

    fn advance(
        &self,
        (): &(),
        index: usize,
        so_far: Option<Found>,
        progress: &dyn Progress,
        shelf: Option<&Shelf>,
    ) -> Result<Leg<Found>, ReportError> {
        let (problem, row, steps) = (&self.scene.problem, self.row(index), self.steps());
        // Rows that were lost are computed again.
        let whole = so_far.and_then(|found| {
            let writer = RowWriter::after(found.kept.rows.clone(), row.name, shelf).ok()?;
            Some((found, writer))
        });
        let (Found { mut legs, kept, mut events }, mut writer) = match whole {
            Some(found) => found,
            None => {
                let kept = Kept::default();
                let writer = RowWriter::after(kept.rows.clone(), row.name, shelf)
                    .map_err(JournalError::from)?;
                (Found { legs: Legs::new(problem, row)?, kept, events: Vec::new() }, writer)
            }
        };
        let mut last = kept.last;
        let keep = &mut |row| {
            let written = writer.push(&row);
            last = Some(row);
            written
        };
        if !self.plan.events.is_empty() {
            let run = EventRun { problem, row, steps, events: &self.plan.events };
            events::advance(&mut legs, run, keep, &mut events, progress)?;
        } else if let Some(spacing) = self.plan.sample {
            legs.sample(problem, row, steps, spacing, keep, progress)?;
        } else {
            legs.advance(problem, row, steps, keep, progress)?;
        }
        let kept = Kept { rows: writer.finish().map_err(JournalError::from)?, last };
        let found = Found { legs, kept, events };
        Ok(if found.legs.has_ended() { Leg::Last(found) } else { Leg::Further(found) })
    }
}

/// The data of a run that charts and sentences need, once its table is written.
struct Run {
    /// Some of its states.
    shown: Trajectory,
    last: Option<TrajectoryRow>,
}

/// Makes the table of the states of all runs.
fn tabled(
    scene: &Scene,
    (found, shelf): (Vec<(Legs, Kept)>, Option<&Shelf>),
    sheet: &mut Sheet,
) -> Result<(Vec<Run>, u64), ReportError> {
    let model = &scene.problem.model;
    let most = found.iter().map(|(_, kept)| kept.rows.count).max().unwrap_or(0);
    let (stride, mut runs) = (stride(most, model), Vec::new());
    let mut table =
        Artifact::wide_table(format!("data/{DATA}.csv"), &trajectory::columns(model), &[(); 0])?;
    for (Legs { method, balance, ending, .. }, Kept { rows, last }) in found {
        let (count, text) = (rows.count, rows.text().map(str::to_owned));
        let file = rows.located(shelf);
        let failed = |why: std::io::Error| JournalError::Unreadable {
            key: format!("run/{method}"),
            why: why.to_string(),
        };
        let shown = thinned(&file, (count, stride), (method, model)).map_err(failed)?;
        runs.push(Run { shown: Trajectory { method, rows: shown, balance, ending }, last });
        match text {
            Some(text) if table.rows.is_empty() => table.text += &text,
            _ => table.rows.push(file),
        }
    }
    sheet.artifacts.push(table);
    Ok((runs, stride))
}

fn sheet(
    scene: &Scene,
    plan: &RunPlan,
    found: Vec<Found>,
    shelf: Option<&Shelf>,
) -> Result<Sheet, ReportError> {
    let (mut sheet, model) = (Sheet::new(TOPIC), &scene.problem.model);
    let (found, events): (Vec<_>, Vec<_>) =
        found.into_iter().map(|run| ((run.legs, run.kept), run.events)).unzip();
    let events = events.concat();
    let (found, stride) = tabled(scene, (found, shelf), &mut sheet)?;
    if !plan.events.is_empty() {
        sheet.wide_data("events", &events::columns(model), &events)?;
        tell(&mut sheet, plan, &events);
    }
    let record = |Run { shown, .. }: &Run| {
        RunOutcome::of(&shown.ending, "run", model.name(), shown.method, scene.step)
    };
    sheet.runs.extend(found.iter().map(record));
    let form = model.system::<f64>()?.dissipation_form();
    // The energy that V(q, t) pumps may raise H.
    let only_falls = !form.zero && form.passive != Passive::No && !model.has_clock();
    let mut readings = readings(&found, only_falls);
    if plan.sample.is_some_and(|spacing| !is_multiple(spacing, scene.step)) {
        readings.add("states", "between steps", "kept");
    }
    if let Some((tolerance, run)) = plan.tolerance.zip(by_tolerance(plan, &found)) {
        coarse::read(tolerance, sizes(&run.shown.rows), &mut readings);
    }
    sheet.find(TOPIC, readings, where_they_went);
    sheet.numbers.extend(found.iter().flat_map(|run| numbers(run, (scene, plan))));
    let shown: Vec<&Trajectory> = found.iter().map(|run| &run.shown).collect();
    let place = |plan: FigurePlan| {
        let Drawn { drawing, caption, wide } = figures::draw(&plan, &shown, &scene.units);
        Placed { figure: sheet.figure(&plan.name, drawing, caption, DATA), wide }
    };
    let figures: Vec<_> = figures::plans(scene, plan).into_iter().map(place).collect();
    sheet.arrange(figures);
    let is_driven = !model.driven().is_empty();
    let mut header = vec!["method", "outcome", "steps", "t", "H", "Σ w"];
    header.extend(is_driven.then_some("Σ s"));
    header.extend(model.has_clock().then_some("s_t"));
    header.push("max |K - K₀|");
    sheet.table(&header, found.iter().map(|run| cells(run, is_driven)).collect());
    sheet.text(prose(plan, stride));
    Ok(sheet)
}

/// The numbers of a completed run that a sweep charts: its energies, and the first entries of its
/// last state.
fn numbers(Run { shown, last }: &Run, (scene, plan): (&Scene, &RunPlan)) -> Vec<Number> {
    let Some(end) = last.as_ref().filter(|_| shown.ending.is_completed()) else {
        return Vec::new();
    };
    // The last multiple of `sample` may be before the end.
    let last = scene.problem.end;
    let is_earlier = plan.sample.is_some_and(|spacing| !is_multiple(last, spacing));
    let time = format!("{:.9e}", end.t).parse().unwrap_or(end.t);
    let place = if is_earlier { format!("at t = {}", in_full(time)) } else { "at the end".into() };
    let at_end = |what: &str, value| {
        let (of, what) = (shown.method.to_owned(), format!("{what} {place}"));
        Number { of, what, value }
    };
    let mut numbers = vec![at_end("H", end.energy), at_end("Σ w", end.w.iter().sum())];
    if !end.s.is_empty() {
        numbers.push(at_end("Σ s", end.s.iter().sum()));
    }
    for (name, part) in [("q", &end.q), ("p", &end.p)] {
        let entries = (1..).zip(part).take(MOST_ENTRIES);
        numbers.extend(entries.map(|(j, &x)| at_end(&format!("{name}{j}"), x)));
    }
    numbers
}

/// An energy with six decimals, or with seven digits and an exponent if it is small or large; empty
/// if it overflows.
fn energy(x: f64) -> String {
    match x.abs() {
        size if !size.is_finite() => String::new(),
        size if size == 0.0 || (1e-3..1e9).contains(&size) => format!("{x:.6}"),
        _ => format!("{x:.6e}"),
    }
}

/// The end of a run.
fn cells(Run { shown, last }: &Run, is_driven: bool) -> Vec<String> {
    let mut cells = vec![shown.method.into(), shown.ending.describe()];
    if let Some(row) = last {
        cells.extend([row.step.to_string(), row.t.to_string(), energy(row.energy)]);
        cells.push(energy(row.w.iter().sum()));
        cells.extend(is_driven.then(|| energy(row.s.iter().sum())));
        cells.extend(row.pumped.iter().map(|&pumped| energy(pumped)));
        cells.push(scientific((row.step > 0).then_some(shown.balance.drift)));
    }
    cells
}

fn prose(plan: &RunPlan, stride: u64) -> String {
    let kept = match plan.every {
        1 => "every state".to_owned(),
        every => format!("one of every {every} states, and the last"),
    };
    let thinned = match stride {
        1 => String::new(),
        stride => format!(" Charts are made of one in {stride} of its rows."),
    };
    let methods = plan.names().join(", ");
    let seen = if plan.adaptive.is_empty() {
        ""
    } else {
        "; of the states kept where steps follow from a tolerance"
    };
    format!(
        "Methods: {methods}. The table contains {kept}.{thinned} The deviation of K and the rise \
         of H are those after every step{seen}."
    )
}

/// `only_falls` is whether H can only fall.
fn readings(found: &[Run], only_falls: bool) -> Readings {
    found.iter().fold(Readings::default(), |r, Run { shown, last }| {
        let Trajectory { method, balance, ending, .. } = shown;
        let mut r = r.and(method, "run", ending.outcome);
        // Without a step there is no deviation.
        if last.as_ref().is_some_and(|last| last.step > 0) {
            r = r.and(method, "drift", balance.drift);
        }
        match balance.rise().filter(|_| only_falls) {
            Some(rise) => r.and(method, RISE, rise),
            None => r,
        }
    })
}

/// The first run that followed the tolerance.
fn by_tolerance<'a>(plan: &RunPlan, found: &'a [Run]) -> Option<&'a Run> {
    found.iter().find(|run| plan.adaptive.iter().any(|row| row.name == run.shown.method))
}

/// The largest |q_j| and |p_j|.
fn sizes(rows: &[TrajectoryRow]) -> [f64; 2] {
    let largest = |x: f64, entries: &[f64]| entries.iter().fold(x, |x, entry| x.max(entry.abs()));
    rows.iter().fold([0.0; 2], |[q, p], row| [largest(q, &row.q), largest(p, &row.p)])
}

fn where_they_went(r: &Readings) -> Said {
    let all = r.of_all("run");
    let done = all.iter().filter(|name| r.word(name, "run") == COMPLETED).count();
    let off =
        r.numbers("drift").into_iter().map(|(name, drift)| format!("{name} {}", deviation(drift)));
    let off: Vec<String> = off.collect();
    let mut statement = format!("{done} of {} runs reached the end.", all.len());
    if !off.is_empty() {
        statement += &format!(
            " K is off by {}; that says nothing of the error of (q, p) and of w, which `afterbay \
             study` measures.",
            off.join(", ")
        );
    }
    let rises = r.numbers(RISE);
    if !rises.is_empty() {
        let by_tolerance = |name: &str| find(name).is_some_and(Row::is_adaptive);
        let between = if rises.iter().any(|(name, _)| by_tolerance(name)) {
            " Between two steps that follow from a tolerance, states have its accuracy alone."
        } else if !r.of_all("between steps").is_empty() {
            " Between two steps, states have the accuracy of the method alone."
        } else {
            ""
        };
        let rises: Vec<String> =
            rises.iter().map(|(name, rise)| format!("{name} {rise:.0e}")).collect();
        statement = format!(
            "H can only fall, since the dissipation only takes energy, but it rises with \
             {}.{between} {statement}",
            rises.join(", ")
        );
    }
    if let Some(warning) = coarse::say(["tolerance", "an absolute error below 1"], r) {
        statement += " ";
        statement += &warning;
    }
    (note(done == all.len()), statement)
}

/// The most events of a method and a name that are listed one by one.
const MOST_LISTED: usize = 3;

/// Lists the events of each method.
fn tell(sheet: &mut Sheet, plan: &RunPlan, events: &[EventRow]) {
    let cells = |method: &'static str, event: &EventPlan| {
        let of = events.iter().filter(|row| row.method == method && row.event == event.name);
        let times: Vec<f64> = of.map(|row| row.t).collect();
        let first: Vec<String> =
            times.iter().take(MOST_LISTED).map(|&t| significant(t, 7)).collect();
        let more = if times.len() > MOST_LISTED { ", …" } else { "" };
        let count = times.len().to_string();
        vec![method.into(), event.name.clone(), count, format!("{}{more}", first.join(", "))]
    };
    let names = plan.names();
    let rows = names.iter().flat_map(|name| plan.events.iter().map(|event| cells(name, event)));
    sheet.table(&["method", "event", "times", "at t ="], rows.collect());
}

#[cfg(test)]
mod tests;
