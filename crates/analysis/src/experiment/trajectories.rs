//! Trajectories by each method.

use super::declared::{Boxed, section};
use super::figures;
use crate::claim::{Readings, Said};
use crate::progress::Progress;
use crate::report::{Block, Figure, Verdict};
use crate::scene::{RunPlan, Scene};
use crate::sheet::{ReportError, Sheet, scientific};
use crate::study::Problem;
use crate::study::cell::{Cell, Leg, Study};
use crate::study::events::{self, EventPlan, EventRow, Steps};
use crate::study::outcome::COMPLETED;
use crate::study::trajectory::{self, Legs, Trajectory};
use afterbay_core::Passive;
use afterbay_methods::registry::Row;
use serde::{Deserialize, Serialize};

/// The most coordinates, and momenta, whose ends are numbers of a sweep.
const MOST_ENTRIES: usize = 4;
/// The rise of H, as a share of its size, up to which it counts as rounding.
const ROUNDING: f64 = 1e-8;
/// The table from which the charts are made.
const DATA: &str = "trajectory";

/// The run of each method.
struct Runs<'a> {
    scene: &'a Scene,
    plan: &'a RunPlan,
}

/// A run, or the first legs of one, and its events.
#[derive(Serialize, Deserialize)]
struct Found {
    legs: Legs,
    events: Vec<EventRow>,
}

pub(super) fn declared<'a>(scene: &'a Scene, plan: &'a RunPlan) -> Boxed<'a> {
    let made = |_: &Runs<'_>, found| sheet(scene, plan, found);
    section(["run", "trajectories"], Runs { scene, plan }, made)
}

impl Runs<'_> {
    fn row(&self, index: usize) -> &'static Row {
        let RunPlan { methods, adaptive, .. } = self.plan;
        methods.get(index).copied().unwrap_or_else(|| adaptive[index - methods.len()])
    }

    fn steps(&self) -> Steps {
        let tolerance = self.plan.tolerance.unwrap_or(f64::NAN);
        Steps { h: self.scene.step, every: self.plan.every, tolerance }
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
        let mut so_far = None;
        loop {
            match self.advance(&(), index, so_far, progress)? {
                Leg::Last(found) => return Ok(found),
                Leg::Further(found) => so_far = Some(found),
            }
        }
    }

    fn advance(
        &self,
        (): &(),
        index: usize,
        so_far: Option<Found>,
        progress: &dyn Progress,
    ) -> Result<Leg<Found>, ReportError> {
        let (problem, row, steps) = (&self.scene.problem, self.row(index), self.steps());
        if !self.plan.events.is_empty() {
            let (run, events) = events::run(problem, row, steps, &self.plan.events, progress)?;
            return Ok(Leg::Last(Found { legs: Legs::whole(run), events }));
        }
        if let Some(spacing) = self.plan.sample {
            let run = trajectory::dense(problem, row, steps, spacing, progress)?;
            return Ok(Leg::Last(Found { legs: Legs::whole(run), events: Vec::new() }));
        }
        let begin = || Legs::new(problem, row).map(|legs| Found { legs, events: Vec::new() });
        let mut found = so_far.map_or_else(begin, Ok)?;
        found.legs.advance(problem, row, steps, progress)?;
        Ok(if found.legs.has_ended() { Leg::Last(found) } else { Leg::Further(found) })
    }
}

fn sheet(scene: &Scene, plan: &RunPlan, found: Vec<Found>) -> Result<Sheet, ReportError> {
    let mut sheet = Sheet::new("Trajectories");
    let problem = &scene.problem;
    let (found, events): (Vec<_>, Vec<_>) =
        found.into_iter().map(|run| (run.legs.trajectory, run.events)).unzip();
    let events = events.concat();
    let rows: Vec<_> = found.iter().flat_map(|run| &run.rows).collect();
    sheet.wide_data(DATA, &trajectory::columns(&problem.model), &rows)?;
    if !plan.events.is_empty() {
        sheet.wide_data("events", &events::columns(&problem.model), &events)?;
        tell(&mut sheet, plan, &events);
    }
    let record =
        |run: &Trajectory| run.ending.record("run", problem.model.name(), run.method, scene.step);
    sheet.runs.extend(found.iter().map(record));
    let form = problem.model.system::<f64>()?.dissipation_form();
    // What is pumped by V(q, t) may raise H.
    let only_falls = !form.zero && form.passive != Passive::No && !problem.model.has_clock();
    say(&mut sheet, &found, only_falls);
    for run in &found {
        let Some(end) = run.rows.last() else { continue };
        let of_method = |what: &str, value| (run.method.to_owned(), what.to_owned(), value);
        let lost = end.w.iter().sum();
        sheet.numbers.push(of_method("H at the end", end.energy));
        sheet.numbers.push(of_method("Σ w at the end", lost));
        if !end.s.is_empty() {
            sheet.numbers.push(of_method("Σ s at the end", end.s.iter().sum()));
        }
        for (name, part) in [("q", &end.q), ("p", &end.p)] {
            let entries = (1..).zip(part).take(MOST_ENTRIES);
            let named = entries.map(|(j, &x)| of_method(&format!("{name}{j} at the end"), x));
            sheet.numbers.extend(named);
        }
    }
    let mut narrow: Option<Figure> = None;
    for figure in figures::plans(scene, plan) {
        let drawn = figures::draw(&figure, &found, &scene.units);
        let wide = drawn.wide;
        let figure = sheet.figure(&figure.name, drawn.drawing, drawn.caption, DATA);
        match (wide, narrow.take()) {
            (false, None) => narrow = Some(figure),
            (false, Some(left)) => sheet.show_pair(left, figure),
            (true, left) => {
                sheet.section.blocks.extend(left.map(Block::Figure));
                sheet.section.blocks.push(Block::Figure(figure));
            }
        }
    }
    sheet.section.blocks.extend(narrow.map(Block::Figure));
    let is_driven = !problem.model.driven().is_empty();
    let last = |run: &Trajectory| {
        let mut cells = vec![run.method.into(), run.ending.describe()];
        if let Some(row) = run.rows.last() {
            cells.extend([row.step.to_string(), row.t.to_string(), format!("{:.6}", row.energy)]);
            cells.push(format!("{:.6}", row.w.iter().sum::<f64>()));
            if is_driven {
                cells.push(format!("{:.6}", row.s.iter().sum::<f64>()));
            }
            cells.extend(row.pumped.iter().map(|pumped| format!("{pumped:.6}")));
            cells.push(scientific(Some(drift(run))));
        }
        cells
    };
    let mut header = vec!["method", "outcome", "steps", "t", "H", "Σ w"];
    header.extend(is_driven.then_some("Σ s"));
    header.extend(problem.model.has_clock().then_some("s_t"));
    header.push("max |K - K₀| of the states kept");
    sheet.table(&header, found.iter().map(last).collect());
    let kept = match plan.every {
        1 => "every state".to_owned(),
        every => format!("one of every {every} states, and the last"),
    };
    sheet.text(format!("Methods: {}. The table contains {kept}.", plan.names().join(", ")));
    Ok(sheet)
}

/// The largest deviation of K in the states that were kept.
fn drift(run: &Trajectory) -> f64 {
    let start = run.rows.first().map_or(0.0, |row| row.total);
    run.rows.iter().fold(0.0, |most: f64, row| most.max((row.total - start).abs()))
}

/// The largest rise of H between two states that were kept, the first before the second, and none
/// if it is a rounding of the start.
fn rise(run: &Trajectory) -> Option<f64> {
    let (mut least, mut rise, mut size) = (f64::INFINITY, 0.0_f64, 0.0_f64);
    for row in &run.rows {
        least = least.min(row.energy);
        rise = rise.max(row.energy - least);
        size = size.max(row.energy.abs().min(row.total.abs()));
    }
    (rise > ROUNDING * size).then_some(rise)
}

fn say(sheet: &mut Sheet, found: &[Trajectory], only_falls: bool) {
    let readings = found.iter().fold(Readings::default(), |r, run| {
        let r = r.and(run.method, "run", run.ending.outcome).and(run.method, "drift", drift(run));
        match rise(run).filter(|_| only_falls) {
            Some(rise) => r.and(run.method, "rise", rise),
            None => r,
        }
    });
    sheet.find("Trajectories", readings, where_they_went);
}

fn where_they_went(r: &Readings) -> Said {
    let all = r.of_all("run");
    let done = all.iter().filter(|name| r.word(name, "run") == COMPLETED).count();
    let off = r.numbers("drift").into_iter().map(|(name, drift)| format!("{name} {drift:.0e}"));
    let mut statement = format!(
        "{done} of {} runs reached the end. K is off by {}; that says nothing of the error of (q, \
         p) and of w, which `afterbay study` measures.",
        all.len(),
        off.collect::<Vec<_>>().join(", "),
    );
    let rises = r.numbers("rise").into_iter().map(|(name, rise)| format!("{name} {rise:.0e}"));
    let rises: Vec<String> = rises.collect();
    if !rises.is_empty() {
        statement = format!(
            "H can only fall, since the dissipation only takes energy, but it rises with {}. \
             {statement}",
            rises.join(", ")
        );
    }
    (if done == all.len() { Verdict::Note } else { Verdict::Fails }, statement)
}

/// The most events of a method and a name that are listed one by one.
const MOST_LISTED: usize = 3;

/// Lists the events of each method.
fn tell(sheet: &mut Sheet, plan: &RunPlan, events: &[EventRow]) {
    let cells = |method: &'static str, event: &EventPlan| {
        let of = events.iter().filter(|row| row.method == method && row.event == event.name);
        let times: Vec<f64> = of.map(|row| row.t).collect();
        let first: Vec<String> =
            times.iter().take(MOST_LISTED).map(|t| format!("{t:.6}")).collect();
        let more = if times.len() > MOST_LISTED { ", …" } else { "" };
        let count = times.len().to_string();
        vec![method.into(), event.name.clone(), count, format!("{}{more}", first.join(", "))]
    };
    let names = plan.names();
    let rows = names.iter().flat_map(|name| plan.events.iter().map(|event| cells(name, event)));
    sheet.table(&["method", "event", "times", "at t ="], rows.collect());
}
