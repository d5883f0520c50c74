//! Scenes: a system, its initial state, the end of time and what to do with it, read from a text.
//!
//! [`Document`] is the content of the file. [`Scene`] is the checked form with names resolved. An
//! error carries its place in the text.

mod depth;
mod document;
mod drive;
mod file;
mod literal;
mod numbers;
mod plan;
mod planner;
mod problem;
mod source;
mod sweep;
mod system;
mod task;
mod texts;

pub use document::Document;
pub use plan::{
    EnergyPlan, FigurePlan, LocalOrderPlan, LongRunPlan, RunPlan, Shown, StabilityPlan, StepsPlan,
    Studies, WorkPrecisionPlan,
};
pub(crate) use problem::suggestion;
pub use problem::{SceneError, SceneProblem};

pub use sweep::Sweep;
pub use task::Task;

use crate::UnitsTable;
use crate::manifest::hash_of;
use afterbay_analysis::study::Problem;
use afterbay_core::{Grid, Quantity, Scalar, State};
use afterbay_methods::registry::Row;
use planner::{Planner, Plans};
use source::Source;
use std::path::Path;
use std::sync::Arc;

/// The number of states shown of a run without a step.
const STATES_SHOWN: f64 = 1000.0;
/// The most bytes a scene may have.
pub const MOST_BYTES: usize = 1 << 20;

/// A scene that can be run.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The title of reports. Commands take the name of the file where the scene has none.
    pub title: Option<String>,
    /// The document it was read from.
    pub document: Document,
    /// The system, the initial state and the end of time.
    pub problem: Problem,
    /// The step h, a divisor of the end. Where the scene gives none, it is the spacing of the
    /// states shown.
    pub step: f64,
    /// Trajectories.
    pub run: Option<RunPlan>,
    /// Figures of the trajectories.
    pub figures: Vec<FigurePlan>,
    /// Units, for the axes of charts.
    pub units: UnitsTable,
    /// Studies.
    pub studies: Studies,
    /// The points at which everything is repeated.
    pub sweep: Option<Arc<Sweep>>,
    /// The error of a study that does not follow an event that changes the state.
    changing: Option<SceneError>,
}

/// The JSON schema of scenes.
pub fn schema() -> serde_json::Value {
    schemars::schema_for!(Document).to_value()
}

/// The text of a scene file, without a byte order mark.
///
/// # Errors
/// [`SceneProblem::TooLarge`] and [`SceneProblem::NoText`].
pub fn text(bytes: &[u8]) -> Result<&str, SceneError> {
    if bytes.len() > MOST_BYTES {
        let problem = SceneProblem::TooLarge { bytes: bytes.len(), limit: MOST_BYTES };
        return Err(SceneError { problem, span: 0..0 });
    }
    let text = std::str::from_utf8(bytes).map_err(|error| {
        let at = error.valid_up_to();
        SceneError { problem: SceneProblem::NoText, span: at..at }
    })?;
    Ok(text.strip_prefix('\u{feff}').unwrap_or(text))
}

impl Scene {
    /// Reads and checks a scene. Nothing is run. Files it names are relative to the working
    /// directory.
    ///
    /// # Errors
    /// [`SceneError`] with the problem and its place.
    pub fn read(text: &str) -> Result<Self, SceneError> {
        Self::read_in(Path::new(""), text)
    }

    /// Reads and checks a scene whose files are relative to a folder.
    ///
    /// # Errors
    /// Those of [`Scene::read`].
    pub fn read_in(folder: &Path, text: &str) -> Result<Self, SceneError> {
        let source = Source::parse(text)?;
        source.check(&schema()).map_err(|error| system::in_friction(&source, error))?;
        let mut document: Document = source.read()?;
        texts::check(&source, &document)?;
        file::resolve(&source, &mut document, folder)?;
        let time = &document.time;
        let problem = problem_of(&source, &document)?;
        check_start(&source, &problem)?;
        let at =
            |path: &str, problem: SceneProblem| SceneError { problem, span: source.span(path) };
        let step = time.step.unwrap_or(time.end / STATES_SHOWN);
        let grid = Grid::<f64>::new(step, time.end).map_err(|error| {
            at(if time.end > 0.0 { "time.step" } else { "time.end" }, error.into())
        })?;
        let (source, steps) = (&source, grid.steps);
        let mut planner =
            Planner { source, document: &document, problem: &problem, steps, points: 1 };
        let sweep = planner.sweep()?.map(Arc::new);
        planner.points = sweep.as_ref().map_or(1, |sweep| sweep.count());
        let Plans { run, studies, changing } = planner.plans()?;
        let figures = planner.figures(run.as_ref())?;
        if let Some(sweep) = &sweep {
            planner.check_points(sweep)?;
        }
        let (title, units) = (document.title.clone(), document.units.clone().unwrap_or_default());
        let step = grid.h.to_f64();
        Ok(Self { title, step, problem, run, figures, units, studies, sweep, document, changing })
    }

    /// Calls a scene without a title by the name of its file.
    pub fn call_by(&mut self, path: &Path) {
        let name = path.file_stem().map(|name| texts::as_title(&name.to_string_lossy()));
        self.title = self.title.take().or(name);
    }

    /// Refuses a scene with an event that changes the state: studies and `pick` follow the motion
    /// without events. A scene that declares studies has no such event.
    ///
    /// # Errors
    /// [`SceneProblem::Changes`] with the place of the event.
    pub fn refuse_changes(&self) -> Result<(), SceneError> {
        self.changing.clone().map_or(Ok(()), Err)
    }

    /// SHA-256 of the document.
    pub fn hash(&self) -> String {
        hash_of(&self.json())
    }

    /// The document as TOML, with the contents of the files that it names. Reading it gives the
    /// same scene.
    ///
    /// # Errors
    /// Values that TOML does not have.
    pub fn text(&self) -> Result<String, toml::ser::Error> {
        toml::to_string(&without_nulls(self.json()))
    }

    /// The document as JSON. A document has strings as keys, so that it can be written.
    pub(crate) fn json(&self) -> serde_json::Value {
        serde_json::to_value(&self.document).expect("the keys of a document are strings")
    }

    /// The methods of `[run]` and of all studies, each once, in the order of their first mention.
    pub fn methods(&self) -> Vec<&'static Row> {
        let run = self.run.iter().flat_map(|plan| plan.methods.iter().chain(&plan.adaptive));
        let mut found: Vec<&'static Row> = Vec::new();
        for row in run.chain(self.studies.methods()) {
            if found.iter().all(|other| other.name != row.name) {
                found.push(row);
            }
        }
        found
    }
}

/// A document without the values that are not given.
fn without_nulls(value: serde_json::Value) -> serde_json::Value {
    use serde_json::Value;
    match value {
        Value::Object(entries) => entries
            .into_iter()
            .filter(|entry| !entry.1.is_null())
            .map(|(key, value)| (key, without_nulls(value)))
            .collect(),
        Value::Array(entries) => entries.into_iter().map(without_nulls).collect(),
        value => value,
    }
}

/// The problem of a document.
fn problem_of(source: &Source<'_>, document: &Document) -> Result<Problem, SceneError> {
    let initial = &document.initial;
    let count = initial.q.count().or(initial.p.count());
    let known = numbers::parameters(source, &document.system.parameters, count)?;
    let model = system::model(source, &document.system, &known, count)?;
    let model = match &document.drive {
        Some(table) => drive::driven(source, &document.system, table, model)?,
        None => model,
    };
    let (with, by) =
        ((&known, model.degrees()), &system::sets_dof(&document.system, count, &model));
    let q = numbers::entries(source, "initial.q", Quantity::Coordinate, &initial.q, with, by)?;
    let p = numbers::entries(source, "initial.p", Quantity::Momentum, &initial.p, with, by)?;
    Ok(Problem { model, q, p, end: document.time.end })
}

/// Checks that H and the forces are finite at the start.
fn check_start(source: &Source<'_>, problem: &Problem) -> Result<(), SceneError> {
    let start: State<Vec<f64>> = problem
        .start()
        .map_err(|error| SceneError { problem: error.into(), span: source.span("initial") })?;
    system::finite_at(source, problem, &start)
}
