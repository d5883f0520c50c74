//! Everything repeated at the points of a sweep: one table of each kind, with the values of a point
//! before its rows, and charts of what changes from point to point.

mod scale;
mod unfinished;
mod warnings;

use super::declared::{Boxed, section};
use crate::UnitsTable;
use crate::artifact::{Artifact, TableError};
use crate::chart::{Axis, LineChart};
use crate::claim::{Found, Readings, Said, in_short, note};
use crate::journal::Afresh;
use crate::manifest::RunOutcome;
use crate::record::StorageError;
use crate::report::Verdict;
use crate::scene::{Scene, Sweep, Task};
use crate::sheet::{Number, ReportError, Sheet, marked};
use afterbay_analysis::progress::Progress;
use afterbay_analysis::study::cell::{Cell, Study};
use afterbay_analysis::study::outcome::{COMPLETED, Ending};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use warnings::Warnings;

/// The table of all numbers that are charted, and the names of the charts but for their numbers. A
/// run and a study of one scene have one folder.
const fn names(task: Task) -> [&'static str; 2] {
    match task {
        Task::Study => ["sweep", "sweep"],
        Task::Run => ["sweep_of_run", "sweep-of-run"],
    }
}

/// The most charts. The table has the other numbers too.
const MOST_CHARTS: usize = 12;

/// A row of that table, behind the values of its point.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Row {
    topic: String,
    of: String,
    what: String,
    value: f64,
}

/// The results at a point.
#[derive(Default, Serialize, Deserialize)]
pub(super) struct Visit {
    /// The names and the contents of tables.
    tables: Vec<(String, String)>,
    rows: Vec<Row>,
    runs: Vec<RunOutcome>,
    /// The statements that do not hold although all runs completed, by their topics.
    #[serde(default)]
    failed: Vec<String>,
}

impl Visit {
    /// A point at which nothing could be run.
    fn refused(scene: &Scene, why: String) -> Self {
        let ending = Ending { outcome: "not-run", failure: Some(why) };
        let system = scene.problem.model.name();
        let outcome = RunOutcome::of(&ending, "sweep", system, "all", scene.step);
        Self { runs: vec![outcome], ..Self::default() }
    }
}

/// A task at each point of a sweep.
struct Points<'a> {
    task: Task,
    scene: &'a Scene,
    sweep: &'a Sweep,
    /// The cost of a point.
    cost: f64,
    /// Whether times are measured. Points are then computed one after another.
    timed: bool,
}

pub(super) fn declared<'a>(
    task: Task,
    scene: &'a Scene,
    sweep: &'a Sweep,
) -> Result<Boxed<'a>, ReportError> {
    let (mut cost, mut timed) = (0.0, false);
    if let Ok(first) = scene.at(0) {
        for cell in super::plan(task, &first)? {
            cost += cell.cost;
            timed |= cell.timed;
        }
    }
    let points = Points { task, scene, sweep, cost, timed };
    let made = move |_: &Points<'_>, visits| sheet((task, sweep, &scene.units), visits);
    Ok(section(["sweep", "points of the sweep"], points, made))
}

impl Study for Points<'_> {
    type Shared = ();
    /// The results at a point; none if the user stopped before it.
    type Part = Option<Visit>;
    type Error = ReportError;

    fn cells(&self) -> Vec<Cell> {
        let cell = |index| {
            let key = format!("point={index}");
            Cell { timed: self.timed, ..Cell::new(key, self.cost) }
        };
        (0..self.sweep.count()).map(cell).collect()
    }

    fn share(&self, _progress: &dyn Progress) -> Result<(), ReportError> {
        Ok(())
    }

    fn compute(
        &self,
        (): &(),
        index: usize,
        progress: &dyn Progress,
    ) -> Result<Option<Visit>, ReportError> {
        if progress.stopped() {
            return Ok(None);
        }
        let found = match self.scene.at(index) {
            Ok(scene) => visit(self.task, &scene, &Inner(progress))?,
            Err(error) => Visit::refused(self.scene, error.problem.to_string()),
        };
        progress.advance();
        Ok(Some(found))
    }
}

/// Joins the results of all points.
fn sheet(
    (task, sweep, units): (Task, &Sweep, &UnitsTable),
    visits: Vec<Option<Visit>>,
) -> Result<Sheet, ReportError> {
    let mut sheet = Sheet::new("Sweep");
    let (mut tables, mut lines) = (BTreeMap::<String, Joined>::new(), Vec::new());
    let mut warnings = Warnings::default();
    for (index, visit) in visits.into_iter().enumerate() {
        let Some(Visit { tables: found, rows, runs, failed }) = visit else { continue };
        let (values, point) = (sweep.values(index), sweep.place(index));
        for (name, text) in found {
            let joined: &mut Joined = tables.entry(name.clone()).or_default();
            joined.add(index, &sweep.names, &values, (&name, &text))?;
        }
        warnings.see(&point, &rows, failed);
        lines.push((index, values, rows));
        let within = |run: RunOutcome| {
            let further = run.point.iter().map(|inner| format!(", {inner}"));
            RunOutcome { point: Some(further.fold(point.clone(), |at, inner| at + &inner)), ..run }
        };
        sheet.runs.extend(runs.into_iter().map(within));
    }
    say(&mut sheet, [sweep.count(), lines.len()], &warnings);
    unfinished::list(&mut sheet);
    charts(&mut sheet, (task, sweep, units), &lines);
    let mut header = vec!["point".to_owned()];
    header.extend(sweep.names.iter().map(|name| format!("sweep_{name}")));
    header.extend(["topic", "of", "what", "value"].map(str::to_owned));
    let rows: Vec<_> = lines
        .iter()
        .flat_map(|(index, values, rows)| rows.iter().map(move |row| (*index, values, row)))
        .collect();
    sheet.wide_data(names(task)[0], &header, &rows)?;
    for (name, joined) in tables {
        sheet.artifacts.push(joined.artifact(name)?);
    }
    sheet.text(format!(
        "Varied: {}. In the tables, the number of the point and its values come before the columns \
         of a single scene.",
        sweep.names.join(", ")
    ));
    Ok(sheet)
}

/// Passes on whether to stop, and no more: the sweep counts points.
struct Inner<'a>(&'a dyn Progress);

impl Progress for Inner<'_> {
    fn begin(&self, _stage: &str, _total: usize) {}

    fn advance(&self) {}

    fn stopped(&self) -> bool {
        self.0.stopped()
    }
}

/// The results of a scene. A method that does not apply there is a run that did not complete.
fn visit(task: Task, scene: &Scene, progress: &dyn Progress) -> Result<Visit, ReportError> {
    let mut visit = Visit::default();
    let sheets = match super::sheets(task, scene, &Afresh, progress) {
        Ok((sheets, _)) => sheets,
        Err(ReportError::Study(error)) => {
            return Ok(Visit::refused(scene, error.to_string()));
        }
        Err(error) => return Err(error),
    };
    for sheet in sheets {
        let tables = sheet.artifacts.into_iter().filter(|x| x.name.ends_with(".csv"));
        visit.tables.extend(tables.map(|table| (table.name, table.text)));
        for finding in &sheet.findings {
            for reading in &finding.readings.0 {
                if let Found::Number(value) = reading.found {
                    let (topic, of) = (finding.topic.clone(), reading.of.clone());
                    visit.rows.push(Row { topic, of, what: reading.what.clone(), value });
                }
            }
        }
        visit.rows.extend(sheet.numbers.into_iter().map(|Number { of, what, value }| Row {
            topic: sheet.section.heading.clone(),
            of,
            what,
            value,
        }));
        if sheet.runs.iter().all(|run| run.outcome == COMPLETED) {
            let failed = sheet.findings.into_iter().filter(|x| x.verdict == Verdict::Fails);
            visit.failed.extend(failed.map(|finding| finding.topic));
        }
        visit.runs.extend(sheet.runs);
    }
    Ok(visit)
}

/// A table of all points.
#[derive(Default)]
struct Joined {
    writer: Option<csv::Writer<Vec<u8>>>,
}

impl Joined {
    /// Adds the rows of a table, behind the values of the point.
    fn add(
        &mut self,
        index: usize,
        names: &[String],
        values: &[f64],
        (name, text): (&str, &str),
    ) -> Result<(), StorageError> {
        let failed = |source| TableError { name: name.to_owned(), source };
        let mut reader = csv::ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .from_reader(text.as_bytes());
        let front: Vec<String> = std::iter::once(index.to_string())
            .chain(values.iter().map(|x| format!("{x:?}")))
            .collect();
        let mut records = reader.records();
        let header = records.next().transpose().map_err(failed)?.unwrap_or_default();
        if self.writer.is_none() {
            let mut writer = csv::WriterBuilder::new().flexible(true).from_writer(Vec::new());
            let first = names.iter().map(|name| format!("sweep_{name}"));
            let all = std::iter::once("point".to_owned()).chain(first);
            let all = all.chain(header.iter().map(str::to_owned));
            writer.write_record(all).map_err(failed)?;
            self.writer = Some(writer);
        }
        let Some(writer) = &mut self.writer else { return Ok(()) };
        for record in records {
            let record = record.map_err(failed)?;
            let row = front.iter().map(String::as_str).chain(&record);
            writer.write_record(row).map_err(failed)?;
        }
        Ok(())
    }

    fn artifact(self, name: String) -> Result<Artifact, StorageError> {
        let bytes = match self.writer.map(csv::Writer::into_inner).transpose() {
            Ok(bytes) => bytes.unwrap_or_default(),
            Err(error) => {
                let source = error.into_error().into();
                return Err(TableError { name, source }.into());
            }
        };
        let text = String::from_utf8_lossy(&bytes).into_owned();
        Ok(Artifact { name, text, ..Artifact::default() })
    }
}

/// The points of a curve for each subject.
type Curves<'a> = BTreeMap<&'a str, Vec<(f64, f64)>>;

/// Charts of each number over the points, one curve for each subject, and the range of each.
fn charts(
    sheet: &mut Sheet,
    (task, sweep, units): (Task, &Sweep, &UnitsTable),
    lines: &[(usize, Vec<f64>, Vec<Row>)],
) {
    // Over the value if one thing alone takes several, else over the number of the point.
    let differ = |k: usize| {
        let mut values = lines.iter().map(|(_, values, _)| values[k].to_bits());
        let first = values.next();
        values.any(|value| Some(value) != first)
    };
    let varied: Vec<usize> = (0..sweep.names.len()).filter(|&k| differ(k)).collect();
    let alone = if let [k] = varied[..] { Some(k) } else { None };
    let values = |k: usize| lines.iter().map(move |(_, values, _)| values[k]);
    let x = alone.map_or(Axis::linear("point"), |k| scale::of_varied(sweep, k, values(k)));
    let [data, prefix] = names(task);
    let mut numbers: BTreeMap<(&str, &str), Curves<'_>> = BTreeMap::new();
    for (index, values, rows) in lines {
        let place = alone.map_or(*index as f64, |k| values[k]);
        for row in rows {
            let curves = numbers.entry((&row.topic, &row.what)).or_default();
            curves.entry(&row.of).or_default().push((place, row.value));
        }
    }
    let mut ranges = Vec::new();
    let mut figures = Vec::new();
    for ((topic, what), curves) in numbers {
        for (of, points) in &curves {
            let values = || points.iter().map(|x| x.1);
            let [least, most] = [
                values().fold(f64::INFINITY, f64::min),
                values().fold(f64::NEG_INFINITY, f64::max),
            ];
            let cells = [topic, what, of].map(str::to_owned).into_iter();
            ranges.push(cells.chain([in_short(least), in_short(most)]).collect());
        }
        let same = |points: &Vec<(f64, f64)>| {
            points.iter().all(|x| x.1.to_bits() == points[0].1.to_bits())
        };
        if figures.len() == MOST_CHARTS || lines.len() < 2 || curves.values().all(same) {
            continue;
        }
        let is_order = topic.contains(" orders of ");
        let label = if is_order { format!("order of {what}") } else { units.result(what) };
        let y = scale::of_results(&label, curves.values().flatten().map(|x| x.1));
        let curves = curves
            .iter()
            .map(|(of, points)| {
                let mut points = points.clone();
                points.sort_by(|a, b| a.0.total_cmp(&b.0));
                marked(of, points)
            })
            .collect();
        let title = format!("{topic}: {what}");
        let name = format!("{prefix}-{}", figures.len() + 1);
        let chart = LineChart::new(&title, x.clone(), y, curves);
        let caption = format!("{title} over the sweep.");
        figures.push(sheet.figure(&name, chart.draw(), caption, data));
    }
    sheet.show_pairs(figures);
    sheet.table(&["topic", "number", "of", "least", "largest"], ranges);
}

fn say(sheet: &mut Sheet, [points, done]: [usize; 2], warnings: &Warnings) {
    let mut readings =
        Readings::default().and("sweep", "points", points).and("sweep", "done", done);
    let mut counts: BTreeMap<&str, [usize; 2]> = BTreeMap::new();
    for run in &sheet.runs {
        let [all, completed] = counts.entry(run.method).or_default();
        *all += 1;
        *completed += usize::from(run.outcome == COMPLETED);
    }
    for (method, [all, completed]) in counts {
        readings = readings.and(method, "runs", all).and(method, "completed", completed);
    }
    warnings.read(&mut readings);
    sheet.find("Sweep", readings, how_many_completed);
}

fn how_many_completed(r: &Readings) -> Said {
    let (points, done) = (r.number("sweep", "points"), r.number("sweep", "done"));
    // The sum of no numbers would be -0.
    let sum = |what: &str| r.numbers(what).into_iter().fold(0.0, |sum, x| sum + x.1);
    let (all, completed) = (sum("runs"), sum("completed"));
    let open = r.numbers("runs").into_iter().filter_map(|(of, runs)| {
        let open = runs - r.number(of, "completed");
        (open != 0.0).then(|| format!("{of} {open}"))
    });
    let open: Vec<String> = open.collect();
    let mut statement = format!("{done} of {points} points; {completed} of {all} runs completed");
    if !open.is_empty() {
        statement += &format!(", did not: {}", open.join(", "));
    }
    let (all_hold, warnings) = warnings::say(r);
    let whole = open.is_empty() && done == points && all_hold;
    (note(whole), format!("{statement}.{warnings}"))
}

#[cfg(test)]
mod tests {
    use super::{Readings, how_many_completed};

    #[test]
    fn no_runs_are_0_runs() {
        let readings = Readings::default().and("sweep", "points", 2.0).and("sweep", "done", 2.0);
        let said = how_many_completed(&readings).1;
        assert!(said.starts_with("2 of 2 points; 0 of 0 runs completed"), "{said}");
    }
}
