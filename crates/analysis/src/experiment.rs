//! The experiments of a scene: trajectories and studies, as tables, figures and a report with a
//! finding on each.

mod basins;
mod bifurcation;
mod energy;
mod figures;
mod global_orders;
mod limit_cycle;
mod local_orders;
mod long_run;
mod lyapunov;
mod pick;
mod poincare;
mod resonance;
mod stability;
mod sweep;
mod trajectories;
mod work;

use crate::Model;
use crate::claim::Finding;
use crate::model::is_linear;
use crate::progress::Progress;
use crate::record::{Manifest, Output, RunOutcome, processor};
use crate::report::{Block, Report};
use crate::scene::Scene;
use crate::sheet::{ReportError, Sheet};
use crate::study::outcome::INTERRUPTED;
use crate::study::pick::Pick;
use afterbay_core::{InputError, IntegrateError, Passive, State};
use afterbay_methods::registry::Row;
use afterbay_systems::Described;

/// All results of an experiment, and its findings.
pub type Results = (Output, Vec<Finding>);

/// Computes the trajectories of a scene.
///
/// # Errors
/// [`ReportError`] if nothing can be run. The table of a run that fails ends with its last good
/// state.
pub fn run(scene: &Scene, progress: &dyn Progress) -> Result<Results, ReportError> {
    let mut sheets = match &scene.sweep {
        Some(sweep) => vec![sweep::sheet(scene, sweep, runs, true, progress)?],
        None => runs(scene, progress)?,
    };
    sheets.push(about(scene)?);
    finish("run", scene, sheets)
}

/// Makes the sections of a scene.
type Sheets = fn(&Scene, &dyn Progress) -> Result<Vec<Sheet>, ReportError>;

fn runs(scene: &Scene, progress: &dyn Progress) -> Result<Vec<Sheet>, ReportError> {
    let plan = scene.run.iter();
    plan.map(|plan| trajectories::sheet(scene, plan, progress)).collect()
}

/// A study of a scene: its name, and a function that makes its section of the report.
type Part<'a> = (&'static str, Box<dyn FnOnce() -> Result<Sheet, ReportError> + 'a>);

/// Runs the studies that a scene declares.
///
/// # Errors
/// [`ReportError`] if nothing can be run. A run that fails is recorded in its table, and a study
/// without a reference in the report.
pub fn study(scene: &Scene, progress: &dyn Progress) -> Result<Results, ReportError> {
    let mut sheets = match &scene.sweep {
        // Each study is parallel in itself, and times are measured one run after another.
        Some(sweep) => vec![sweep::sheet(scene, sweep, studies, false, progress)?],
        None => studies(scene, progress)?,
    };
    sheets.push(about(scene)?);
    finish("study", scene, sheets)
}

fn studies(scene: &Scene, progress: &dyn Progress) -> Result<Vec<Sheet>, ReportError> {
    let studies = &scene.studies;
    let mut parts: Vec<Part<'_>> = Vec::new();
    if let Some(plan) = &studies.local_order {
        parts.push(("local-order", Box::new(|| local_orders::sheet(scene, plan, progress))));
    }
    if let Some(plan) = &studies.global_order {
        parts.push(("global-order", Box::new(|| global_orders::sheet(scene, plan, progress))));
    }
    if let Some(plan) = &studies.energy {
        parts.push(("energy", Box::new(|| energy::sheet(scene, plan, progress))));
    }
    if let Some(plan) = &studies.work_precision {
        parts.push(("work-precision", Box::new(|| work::sheet(scene, plan, progress))));
    }
    if let Some(plan) = &studies.long_run {
        parts.push(("long-run", Box::new(|| long_run::sheet(scene, plan, progress))));
    }
    if let Some(plan) = &studies.stability {
        parts.push(("stability", Box::new(|| stability::sheet(scene, plan, progress))));
    }
    if let Some(plan) = &studies.poincare {
        parts.push(("poincare", Box::new(|| poincare::sheet(scene, plan, progress))));
    }
    if let Some(plan) = &studies.bifurcation {
        parts.push(("bifurcation", Box::new(|| bifurcation::sheet(scene, plan, progress))));
    }
    if let Some(plan) = &studies.resonance {
        parts.push(("resonance", Box::new(|| resonance::sheet(scene, plan, progress))));
    }
    if let Some(plan) = &studies.basins {
        parts.push(("basins", Box::new(|| basins::sheet(scene, plan, progress))));
    }
    if let Some(plan) = &studies.lyapunov {
        parts.push(("lyapunov", Box::new(|| lyapunov::sheet(scene, plan, progress))));
    }
    if let Some(plan) = &studies.limit_cycle {
        parts.push(("limit-cycle", Box::new(|| limit_cycle::sheet(scene, plan, progress))));
    }
    let mut sheets = Vec::new();
    for (name, part) in parts {
        if progress.stopped() {
            break;
        }
        match part() {
            Ok(sheet) => sheets.push(sheet),
            // A study without a reference has nothing to compare with. Other studies may need none,
            // or a shorter one.
            Err(ReportError::Study(error)) if is_of_reference(&error) => {
                sheets.push(without_reference(scene, name, &error));
            }
            // The results so far are kept, and the interrupted study is marked.
            Err(ReportError::Study(IntegrateError::Interrupted)) => {
                sheets.push(interrupted(scene, name));
            }
            Err(error) => return Err(error),
        }
    }
    Ok(sheets)
}

/// The report on a search, with charts of the runs that were tried.
///
/// # Errors
/// [`ReportError`] if a table cannot be made.
pub fn pick(scene: &Scene, found: &Pick) -> Result<Results, ReportError> {
    let sheets = vec![pick::sheet(scene, found)?, about(scene)?];
    finish("pick", scene, sheets)
}

fn is_of_reference(error: &IntegrateError) -> bool {
    matches!(error, IntegrateError::Run(_) | IntegrateError::Input(InputError::SolutionEnds { .. }))
}

fn interrupted(scene: &Scene, study: &'static str) -> Sheet {
    let mut sheet = Sheet::new(&format!("{study}: interrupted"));
    sheet.text("It was interrupted before its reference was known.");
    sheet.runs.push(RunOutcome {
        study,
        system: scene.problem.model.name(),
        method: "reference",
        h: scene.step,
        outcome: INTERRUPTED.into(),
        failure: None,
    });
    sheet
}

fn without_reference(scene: &Scene, study: &'static str, error: &IntegrateError) -> Sheet {
    let mut sheet = Sheet::new(&format!("{study}: not done"));
    sheet.text(format!("There is no reference to compare to: {error}."));
    sheet.runs.push(RunOutcome {
        study,
        system: scene.problem.model.name(),
        method: "reference",
        h: scene.step,
        outcome: "no-reference".into(),
        failure: Some(error.to_string()),
    });
    sheet
}

/// Describes the scene.
fn about(scene: &Scene) -> Result<Sheet, ReportError> {
    let (mut sheet, problem) = (Sheet::new("The scene"), &scene.problem);
    let system = problem.model.system::<f64>()?;
    let start: State<Vec<f64>> = problem.start()?;
    let table = &scene.document.system;
    let mut rows = vec![vec!["system".into(), problem.model.name().into()]];
    let mut row = |name: &str, value: String| rows.push(vec![name.into(), value]);
    let model = match &problem.model {
        Model::Driven(model, _) => model,
        model => model,
    };
    match model {
        Model::Custom(custom) => {
            for (name, expression) in table.expressions() {
                row(&name, expression);
            }
            if let Described::Separable(custom) = custom {
                let degree = custom.structure().degree;
                let degree = degree.map_or("not a polynomial".into(), |degree| degree.to_string());
                row("degree of V", degree);
            }
            let coupling = model.system::<f64>()?.coupling();
            row("coupling", format!("{coupling:?}").to_lowercase());
        }
        Model::Listed(known, _) => row("equations", known.equations.into()),
        Model::Driven(..) => {}
    }
    let drive = scene.document.drive.as_ref();
    for (name, force) in drive.iter().flat_map(|drive| drive.force.named("F")) {
        row(&name, force);
    }
    let of_drive = drive.iter().flat_map(|drive| &drive.parameters);
    for (name, value) in table.parameters.iter().chain(of_drive) {
        row(name, value.text());
    }
    row("degrees of freedom", problem.model.degrees().to_string());
    let alone = model.system::<f64>()?;
    let linear = if is_linear(&alone) { "yes" } else { "no" };
    let apart = if drive.is_some() { ", apart from the drive" } else { "" };
    row("equations are linear", format!("{linear}{apart}"));
    let damping = alone.dissipation_form();
    row(
        "friction",
        match (damping.zero, problem.model.passive()?) {
            (true, _) if drive.is_some() => "none: w stays 0".into(),
            (true, _) => "none: H itself is constant".into(),
            (_, Passive::Each) => "passive: every w_j only fills".into(),
            (_, Passive::InSum) => "passive in sum: Σ w_j only fills".into(),
            (_, Passive::No) => "active, or not known to be passive: w may fall".into(),
        },
    );
    row("q at t = 0", list(&problem.q));
    row("p at t = 0", list(&problem.p));
    row("H at t = 0, which K keeps", start.energy(&*system).to_string());
    row("end of time", problem.end.to_string());
    row("step", scene.step.to_string());
    sheet.table(&["what", "value"], rows);
    Ok(sheet)
}

/// The first few numbers of a list.
fn list(numbers: &[f64]) -> String {
    const SHOWN: usize = 8;
    let shown: Vec<_> = numbers.iter().take(SHOWN).map(ToString::to_string).collect();
    let more = if numbers.len() > SHOWN {
        format!(", … ({} in all)", numbers.len())
    } else {
        String::new()
    };
    format!("{}{more}", shown.join(", "))
}

/// The names of methods, for a title or a sentence.
fn names(methods: &[&Row]) -> Vec<&'static str> {
    methods.iter().map(|row| row.name).collect()
}

fn finish(
    command: &'static str,
    scene: &Scene,
    sheets: Vec<Sheet>,
) -> Result<Results, ReportError> {
    let document = serde_json::to_value(&scene.document).unwrap_or_default();
    let findings: Vec<Finding> =
        sheets.iter().flat_map(|sheet| sheet.findings.iter().cloned()).collect();
    let runs = sheets.iter().flat_map(|sheet| sheet.runs.iter().cloned()).collect();
    let manifest = Manifest::new(command, document, runs);
    let mut report = Report {
        title: scene.title.clone().unwrap_or_else(|| scene.problem.model.name().into()),
        subtitle: format!(
            "{} by afterbay {} on {} ({} threads). {}",
            match command {
                "run" => "Trajectories",
                "pick" => "The cheapest method and step",
                _ => "Studies",
            },
            manifest.version,
            processor(),
            manifest.threads,
            match &scene.document.units {
                Some(_) => "Units are those that the scene names.",
                None => "All quantities are in the units of the scene.",
            }
        ),
        sections: Vec::new(),
    };
    let mut artifacts = Vec::new();
    for mut sheet in sheets {
        artifacts.extend(sheet.artifacts);
        sheet.section.blocks.sort_by_key(Block::place);
        report.sections.push(sheet.section);
    }
    Ok((Output { report, artifacts, manifest }, findings))
}
