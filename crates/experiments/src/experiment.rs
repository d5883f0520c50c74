//! The experiments of a scene: trajectories and studies, as tables, figures and a report with a
//! finding on each.
//!
//! A module makes the section of one study, in its function `sheet`. Its `prose` says what was
//! computed and how, its `readings` are the numbers on which its finding rests, `cells` makes a row
//! of its table, and `charts` draws its figures.

mod about;
mod basins;
mod bifurcation;
mod coarse;
mod declared;
mod energy;
mod figures;
mod global_orders;
mod limit_cycle;
mod local_orders;
mod long_run;
mod lyapunov;
mod pick;
mod poincare;
mod reference;
mod resonance;
mod stability;
mod sweep;
mod trajectories;
mod work;

pub use about::{stops, unswept};
pub use pick::{coarse_error, longer_step};

use crate::claim::{Finding, counted};
use crate::journal::{Afresh, Ledger};
use crate::manifest::{Manifest, RunOutcome, processor};
use crate::record::Output;
use crate::report::Report;
use crate::scene::{Scene, Studies, Task};
use crate::sheet::{Gathered, ReportError, Sheet};
use afterbay_analysis::progress::Progress;
use afterbay_analysis::study::cell::Cell;
use afterbay_analysis::study::outcome::Ending;
use afterbay_analysis::study::pick::Pick;
use afterbay_core::{InputError, IntegrateError};
use afterbay_methods::registry::Row;
use declared::Boxed;

/// All results of an experiment, and its findings.
pub type Results = (Output, Vec<Finding>);

/// Computes the trajectories of a scene.
///
/// # Errors
/// [`ReportError`] if nothing can be run. The table of a run that fails ends with its last good
/// state.
pub fn run(scene: &Scene, progress: &dyn Progress) -> Result<Results, ReportError> {
    finish(Task::Run, scene, sheets(Task::Run, scene, &Afresh, progress)?.0)
}

/// Runs the studies that a scene declares.
///
/// # Errors
/// [`ReportError`] if nothing can be run. A run that fails is recorded in its table, and a study
/// without a reference in the report.
pub fn study(scene: &Scene, progress: &dyn Progress) -> Result<Results, ReportError> {
    finish(Task::Study, scene, sheets(Task::Study, scene, &Afresh, progress)?.0)
}

/// The cells of a task: the trajectories of all methods, the cells of all studies, or the points of
/// a sweep. Nothing is run.
///
/// # Errors
/// [`ReportError`] for a method that does not apply.
pub fn plan(task: Task, scene: &Scene) -> Result<Vec<Cell>, ReportError> {
    Ok(Cells::new(task, scene)?.plan)
}

/// The cells of a task, to be computed one by one.
pub struct Cells<'a> {
    studies: Vec<Boxed<'a>>,
    /// The cells of all studies, one study after another.
    plan: Vec<Cell>,
    /// The study of each cell, and its index there.
    places: Vec<[usize; 2]>,
}

impl<'a> Cells<'a> {
    /// The cells of a task.
    ///
    /// # Errors
    /// As for [`plan`].
    pub fn new(task: Task, scene: &'a Scene) -> Result<Self, ReportError> {
        let studies = declared(task, scene)?;
        let (mut plan, mut places) = (Vec::new(), Vec::new());
        for (at, study) in studies.iter().enumerate() {
            let cells = study.cells();
            places.extend((0..cells.len()).map(|index| [at, index]));
            plan.extend(cells);
        }
        Ok(Self { studies, plan, places })
    }

    /// The bytes of the largest reference, estimated.
    pub fn reference_bytes(&self) -> f64 {
        self.studies.iter().map(|study| study.shared_bytes()).fold(0.0, f64::max)
    }

    /// All cells.
    pub fn plan(&self) -> &[Cell] {
        &self.plan
    }

    /// The result of a cell, as a ledger keeps it. What the cells of a study have in common is
    /// computed with the first of them. A long cell keeps its checkpoints in the ledger.
    ///
    /// # Errors
    /// As for [`perform`].
    ///
    /// # Panics
    /// If the plan has no such cell.
    pub fn compute(
        &self,
        cell: usize,
        ledger: &dyn Ledger,
        progress: &dyn Progress,
    ) -> Result<Vec<u8>, ReportError> {
        let [at, index] = self.places[cell];
        self.studies[at].prepare(progress)?;
        self.studies[at].compute(index, (&self.plan[cell].key, ledger), progress)
    }
}

/// Computes the cells that `ledger` takes and does not have. Returns the results if it then has
/// all.
///
/// # Errors
/// As for [`study`], and a ledger that cannot be written.
pub fn perform(
    task: Task,
    scene: &Scene,
    ledger: &dyn Ledger,
    progress: &dyn Progress,
) -> Result<Option<Results>, ReportError> {
    let (sheets, whole) = sheets(task, scene, ledger, progress)?;
    whole.then(|| finish(task, scene, sheets)).transpose()
}

/// The sections of the report, and whether all cells have results.
fn sheets(
    task: Task,
    scene: &Scene,
    ledger: &dyn Ledger,
    progress: &dyn Progress,
) -> Result<(Vec<Sheet>, bool), ReportError> {
    let (mut sheets, mut whole) = (Vec::new(), true);
    for study in declared(task, scene)? {
        if progress.stopped() {
            break;
        }
        let parts = declared::results(&*study, ledger, progress);
        match parts
            .and_then(|parts| parts.map(|parts| study.sheet(&parts, ledger.shelf())).transpose())
        {
            Ok(Some(sheet)) => sheets.push(sheet),
            Ok(None) => whole = false,
            // A study without a reference has nothing to compare with. Other studies may need none,
            // or a shorter one.
            Err(ReportError::NoReference(why)) => {
                sheets.push(without_reference(scene, study.name(), why));
            }
            Err(ReportError::Study(error)) if is_of_reference(&error) => {
                sheets.push(without_reference(scene, study.name(), error.to_string()));
            }
            // The results so far are kept, and the interrupted study is marked.
            Err(error) if error.is_interrupted() => {
                sheets.push(interrupted(scene, study.name()));
            }
            Err(error) => return Err(error),
        }
    }
    let about = about::sheet(scene)?;
    sheets.push(match task {
        Task::Study => about::beyond_stops(about, scene),
        Task::Run => about,
    });
    Ok((sheets, whole))
}

/// The studies of a task, in the order of the report.
fn declared(task: Task, scene: &Scene) -> Result<Vec<Boxed<'_>>, ReportError> {
    if let Some(sweep) = &scene.sweep {
        return Ok(vec![sweep::declared(task, scene, sweep)?]);
    }
    if task == Task::Run {
        let runs = scene.run.iter().map(|plan| trajectories::declared(scene, plan));
        return Ok(runs.collect());
    }
    let Studies {
        local_order,
        global_order,
        energy,
        work_precision,
        long_run,
        stability,
        poincare,
        bifurcation,
        resonance,
        basins,
        lyapunov,
        limit_cycle,
    } = &scene.studies;
    let all: [Option<Result<Boxed<'_>, ReportError>>; 12] = [
        local_order.as_ref().map(|plan| Ok(local_orders::declared(scene, plan))),
        global_order.as_ref().map(|plan| Ok(global_orders::declared(scene, plan))),
        energy.as_ref().map(|plan| Ok(energy::declared(scene, plan))),
        work_precision.as_ref().map(|plan| work::declared(scene, plan)),
        long_run.as_ref().map(|plan| long_run::declared(scene, plan)),
        stability.as_ref().map(|plan| stability::declared(scene, plan)),
        poincare.as_ref().map(|plan| Ok(poincare::declared(scene, plan))),
        bifurcation.as_ref().map(|plan| Ok(bifurcation::declared(scene, plan))),
        resonance.as_ref().map(|plan| Ok(resonance::declared(scene, plan))),
        basins.as_ref().map(|plan| Ok(basins::declared(scene, plan))),
        lyapunov.as_ref().map(|plan| Ok(lyapunov::declared(scene, plan))),
        limit_cycle.as_ref().map(|plan| Ok(limit_cycle::declared(scene, plan))),
    ];
    all.into_iter().flatten().collect()
}

/// The report on a search, with charts of the runs that were tried.
///
/// # Errors
/// [`ReportError`] if a table cannot be made.
pub fn pick(scene: &Scene, found: &Pick) -> Result<Results, ReportError> {
    let about = about::beyond_stops(about::sheet(scene)?, scene);
    let about = about::beside_sweep(about, scene);
    let sheets = vec![pick::sheet(scene, found)?, about];
    finish_as("pick", scene, sheets)
}

fn is_of_reference(error: &IntegrateError) -> bool {
    matches!(error, IntegrateError::Run(_) | IntegrateError::Input(InputError::SolutionEnds { .. }))
}

fn interrupted(scene: &Scene, study: &'static str) -> Sheet {
    let text = "It was interrupted before its reference was known.";
    not_done(scene, study, "interrupted", text.into(), Ending::interrupted())
}

fn without_reference(scene: &Scene, study: &'static str, why: String) -> Sheet {
    let text = format!("There is no reference to compare to: {why}.");
    let ending = Ending { outcome: "no-reference", failure: Some(why) };
    not_done(scene, study, "not done", text, ending)
}

/// The section of a study that compares to a reference and has none.
fn not_done(scene: &Scene, study: &'static str, how: &str, text: String, ending: Ending) -> Sheet {
    let mut sheet = Sheet::new(&format!("{study}: {how}"));
    sheet.text(text);
    let system = scene.problem.model.name();
    sheet.runs.push(RunOutcome::of(&ending, study, system, "reference", scene.step));
    sheet
}

/// The names of methods, for a title or a sentence.
fn names(methods: &[&Row]) -> Vec<&'static str> {
    methods.iter().map(|row| row.name).collect()
}

fn finish(task: Task, scene: &Scene, sheets: Vec<Sheet>) -> Result<Results, ReportError> {
    finish_as(task.name(), scene, sheets)
}

fn finish_as(
    command: &'static str,
    scene: &Scene,
    sheets: Vec<Sheet>,
) -> Result<Results, ReportError> {
    let Gathered { sections, artifacts, findings, runs } =
        sheets.into_iter().collect::<Gathered>().in_order();
    let manifest = Manifest::new(command, scene.json(), runs);
    let report = Report {
        title: scene.title.clone().unwrap_or_else(|| scene.problem.model.name().into()),
        subtitle: format!(
            "{} by afterbay {} on {} ({}). {}",
            match command {
                "run" => "Trajectories",
                "pick" => "The cheapest method and step",
                _ => "Studies",
            },
            manifest.version,
            processor(),
            counted(manifest.threads, "thread"),
            match &scene.document.units {
                Some(_) => "Units are those that the scene names.",
                None => "All quantities are in the units of the scene.",
            }
        ),
        sections,
    };
    Ok((Output { report, artifacts, manifest }, findings))
}
