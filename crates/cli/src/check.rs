//! `afterbay check`

use crate::arguments::Format;
use crate::failure::Failure;
use crate::table::Column;
use crate::{scene, table};
use afterbay_analysis::scene::Scene;
use afterbay_analysis::{Model, experiment};
use afterbay_methods::registry::Row;
use serde::Serialize;
use std::path::Path;
use std::process::ExitCode;

/// The plan of a scene.
#[derive(Serialize)]
struct Plan {
    what: &'static str,
    methods: Vec<&'static str>,
    detail: String,
}

pub(crate) fn run(path: &Path, format: Format) -> Result<ExitCode, Failure> {
    let scene = scene::read(path)?;
    let plans = plans(&scene);
    match format {
        Format::Json => table::json(&plans)?,
        Format::Table => {
            let (model, dof) = (scene.problem.model.name(), scene.problem.model.degrees());
            let freedom = if dof == 1 { "degree" } else { "degrees" };
            let timed = timed(&scene.problem.model);
            let period = scene.problem.model.drive_period();
            let drive = match period {
                Some(period) => format!(", {timed} with period {period}"),
                None if timed.is_empty() => String::new(),
                None => format!(", {timed} without a known period"),
            };
            table::text(&format!(
                "{} is valid: {model}, {dof} {freedom} of freedom{drive}.",
                path.display()
            ))?;
            let rows = plans
                .iter()
                .map(|plan| vec![plan.what.into(), plan.methods.join(", "), plan.detail.clone()]);
            let columns = [
                Column::of("what", 0),
                Column::words("methods", 0, 20),
                Column::words("detail", 0, 20),
            ];
            table::print(&columns, rows)?;
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// How a system depends on the time; empty if it does not.
fn timed(model: &Model) -> &'static str {
    match (model.has_clock(), model.driven().is_empty()) {
        (false, true) => "",
        (false, false) => "driven",
        (true, true) => "depending on t",
        (true, false) => "driven and depending on t",
    }
}

fn kept(every: u64) -> String {
    if every == 1 { "every state kept".into() } else { format!("every {every} steps a state kept") }
}

fn steps(count: usize) -> String {
    if count == 1 { "1 step".into() } else { format!("{count} steps") }
}

fn plans(scene: &Scene) -> Vec<Plan> {
    let studies = &scene.studies;
    let mut plans = Vec::new();
    let mut add = |what, methods: &[&'static Row], detail| {
        plans.push(Plan { what, methods: methods.iter().map(|row| row.name).collect(), detail });
    };
    if let Some(plan) = &scene.run {
        let count = (scene.problem.end / scene.step).round() as usize;
        let all: Vec<_> = plan.methods.iter().chain(&plan.adaptive).copied().collect();
        let tolerance = plan.tolerance.map_or(String::new(), |x| format!(", tolerance {x:e}"));
        let steps = steps(count);
        let detail = format!("{steps} of {}, {}{tolerance}", scene.step, kept(plan.every));
        add("run", &all, detail);
        if let Err(error) = scene.refuse_changes() {
            add("events", &[], error.problem.to_string());
        }
        if let Some(stops) = experiment::stops(scene) {
            add("events", &[], stops.statement);
        }
        let figures: Vec<_> = scene.figures.iter().map(|plan| plan.name.as_str()).collect();
        if !figures.is_empty() {
            add("figures", &[], figures.join(", "));
        }
    }
    if let Some(plan) = &studies.local_order {
        let detail =
            format!("{} on a grid of {}", steps(plan.study.steps.len()), plan.study.base_step);
        add("local-order", &plan.methods, detail);
    }
    if let Some(plan) = &studies.global_order {
        add("global-order", &plan.methods, steps(plan.steps.len()));
    }
    if let Some(plan) = &studies.energy {
        add("energy", &plan.methods, format!("steps of {}, {}", plan.step, kept(plan.every)));
    }
    if let Some(plan) = &studies.work_precision {
        add("work-precision", &plan.methods, steps(plan.steps.len()));
    }
    if let Some(plan) = &studies.stability {
        let detail = format!(
            "{} by {} values of {}",
            steps(plan.steps.len()),
            plan.values.len(),
            plan.parameter
        );
        add("stability", &plan.methods, detail);
    }
    if let Some(plan) = &studies.long_run {
        add("long-run", &plan.methods, format!("{} steps of {}", plan.count, plan.step));
    }
    let model = &scene.problem.model;
    if let Some(plan) = &studies.poincare {
        let (study, steps) = (&plan.study, steps(plan.steps.len()));
        let starts = study.starts.len();
        let detail = format!(
            "{steps}, {} states of {starts} {}, {}",
            study.points,
            if starts == 1 { "run" } else { "runs" },
            study.section.describe(model)
        );
        add("poincare", &plan.methods, detail);
    }
    if let Some(plan) = &studies.bifurcation {
        let (study, steps) = (&plan.study, steps(plan.steps.len()));
        let detail = format!(
            "{steps}, {} values of {}, {}",
            study.values.len(),
            study.parameter,
            study.section.describe(model)
        );
        add("bifurcation", &plan.methods, detail);
    }
    if let Some(plan) = &studies.resonance {
        let steps = steps(plan.steps.len());
        let (count, parameter) = (plan.study.values.len(), &plan.study.parameter);
        add("resonance", &plan.methods, format!("{steps}, {count} values of {parameter}"));
    }
    if let Some(plan) = &studies.basins {
        let steps = steps(plan.steps.len());
        let [width, height] = plan.study.axes.each_ref().map(|axis| axis.values.len());
        let section = plan.study.section.describe(model);
        let detail = format!("{steps}, {width} by {height} initial states, {section}");
        add("basins", &plan.methods, detail);
    }
    if let Some(plan) = &studies.lyapunov {
        let (study, steps) = (&plan.study, steps(plan.steps.len()));
        let detail = format!("{steps}, {} rows over t = {}", study.rows, study.time);
        add("lyapunov", &plan.methods, detail);
    }
    if let Some(plan) = &studies.limit_cycle {
        let branch = plan.study.branch.as_ref();
        let along = branch.map(|to| format!(", {} from {} to {}", to.parameter, to.from, to.to));
        let detail = format!("{}{}", steps(plan.steps.len()), along.unwrap_or_default());
        add("limit-cycle", &plan.methods, detail);
    }
    if let Some(sweep) = &scene.sweep {
        let detail = format!("{} points over {}", sweep.count(), sweep.names.join(", "));
        add("sweep", &[], detail);
    }
    plans
}
