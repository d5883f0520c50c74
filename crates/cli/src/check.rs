//! `afterbay check`

use crate::arguments::Format;
use crate::failure::Failure;
use crate::table::Column;
use crate::{scene, table};
use afterbay_analysis::Model;
use afterbay_analysis::study::dynamics::DynamicsPlan;
use afterbay_analysis::study::trajectory;
use afterbay_experiments::scene::{Scene, Studies, WorkPrecisionPlan};
use afterbay_experiments::{counted, experiment, in_full};
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
            table::text(&format!("{} is valid: {}.", path.display(), described(&scene)))?;
            if scene.run.is_none() && scene.studies.is_empty() {
                table::text("It has no [run] and no [study.*]: there is nothing to do.")?;
                return Ok(ExitCode::SUCCESS);
            }
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

/// The system of a scene, its degrees of freedom and its drive, in words.
fn described(scene: &Scene) -> String {
    let model = &scene.problem.model;
    let (name, dof, timed) = (model.name(), model.degrees(), timed(model));
    let drive = match model.drive_period() {
        Some(period) => format!(", {timed} with period {}", in_full(period)),
        None if timed.is_empty() => String::new(),
        None => format!(", {timed} without a known period"),
    };
    format!("{name}, {} of freedom{drive}", counted(dof, "degree"))
}

/// The dependence of a system on the time, in words; empty if there is none.
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

fn steps<T>(steps: &[T]) -> String {
    counted(steps.len(), "step")
}

fn plan(what: &'static str, methods: &[&'static Row], detail: String) -> Plan {
    Plan { what, methods: methods.iter().map(|row| row.name).collect(), detail }
}

fn plans(scene: &Scene) -> Vec<Plan> {
    let mut plans = runs(scene);
    plans.extend(accuracy(&scene.studies).into_iter().flatten());
    plans.extend(attractors(scene).into_iter().flatten());
    plans.extend(scene.sweep.as_ref().map(|sweep| {
        let detail = format!("{} over {}", counted(sweep.count(), "point"), sweep.names.join(", "));
        plan("sweep", &[], detail)
    }));
    plans
}

/// The trajectories, their events and their figures.
fn runs(scene: &Scene) -> Vec<Plan> {
    let Some(run) = &scene.run else { return Vec::new() };
    let (step, steps) = (scene.step, (scene.problem.end / scene.step).round());
    let methods: Vec<_> = run.methods.iter().chain(&run.adaptive).copied().collect();
    let tolerance = run.tolerance.map_or(String::new(), |x| format!(", tolerance {x:e}"));
    let kept = match run.sample {
        Some(spacing) => {
            let states = trajectory::samples(scene.problem.end, spacing).saturating_add(1);
            format!("{} at multiples of {}", counted(states, "state"), in_full(spacing))
        }
        None => kept(run.every),
    };
    let steps = counted(in_full(steps), "step");
    let detail = format!("{steps} of {}, {kept}{tolerance}", in_full(step));
    let mut plans = vec![plan("run", &methods, detail)];
    if let Err(error) = scene.refuse_changes() {
        plans.push(plan("events", &[], error.problem.to_string()));
    }
    plans.extend(experiment::stops(scene).map(|stops| plan("events", &[], stops.statement)));
    let figures: Vec<_> = scene.figures.iter().map(|plan| plan.name.as_str()).collect();
    if !figures.is_empty() {
        plans.push(plan("figures", &[], figures.join(", ")));
    }
    plans
}

/// The studies of errors, energies, cost and stability.
fn accuracy(studies: &Studies) -> [Option<Plan>; 6] {
    [
        studies.local_order.as_ref().map(|of| {
            let detail =
                format!("{} on a grid of {}", steps(&of.study.steps), in_full(of.study.base_step));
            plan("local-order", &of.methods, detail)
        }),
        studies.global_order.as_ref().map(|of| plan("global-order", &of.methods, steps(&of.steps))),
        studies.energy.as_ref().map(|of| {
            plan(
                "energy",
                &of.methods,
                format!("steps of {}, {}", in_full(of.step), kept(of.every)),
            )
        }),
        studies.work_precision.as_ref().map(cost),
        studies.stability.as_ref().map(|of| {
            let (steps, values) = (steps(&of.steps), counted(of.values.len(), "value"));
            let detail = format!("{steps} by {values} of {}", of.parameter);
            plan("stability", &of.methods, detail)
        }),
        studies.long_run.as_ref().map(|of| {
            plan(
                "long-run",
                &of.methods,
                format!("{} of {}", counted(of.count, "step"), in_full(of.step)),
            )
        }),
    ]
}

/// Work against precision.
fn cost(of: &WorkPrecisionPlan) -> Plan {
    let methods: Vec<_> = of.methods.iter().chain(&of.adaptive).copied().collect();
    let tolerances = counted(of.tolerances.len(), "tolerance");
    let details = [(steps(&of.steps), &of.methods), (tolerances, &of.adaptive)];
    let details: Vec<_> =
        details.into_iter().filter(|(_, rows)| !rows.is_empty()).map(|(text, _)| text).collect();
    plan("work-precision", &methods, details.join(", "))
}

/// The studies of attractors.
fn attractors(scene: &Scene) -> [Option<Plan>; 6] {
    let (studies, model) = (&scene.studies, &scene.problem.model);
    [
        studies.poincare.as_ref().map(|of| {
            of_each(of, "poincare", |study| {
                let (states, starts) = (study.points, counted(study.starts.len(), "run"));
                let section = study.section.describe(model);
                format!(", {} of {starts}, {section}", counted(states, "state"))
            })
        }),
        studies.bifurcation.as_ref().map(|of| {
            of_each(of, "bifurcation", |study| {
                let (values, parameter) = (counted(study.values.len(), "value"), &study.parameter);
                let section = study.section.describe(model);
                format!(", {values} of {parameter}, {section}")
            })
        }),
        studies.resonance.as_ref().map(|of| {
            of_each(of, "resonance", |study| {
                format!(", {} of {}", counted(study.values.len(), "value"), study.parameter)
            })
        }),
        studies.basins.as_ref().map(|of| {
            of_each(of, "basins", |study| {
                let [width, height] = study.axes.each_ref().map(|axis| axis.values.len());
                let section = study.section.describe(model);
                format!(", {width} by {height} initial states, {section}")
            })
        }),
        studies.lyapunov.as_ref().map(|of| {
            of_each(of, "lyapunov", |study| {
                format!(", {} over t = {}", counted(study.rows, "row"), in_full(study.time))
            })
        }),
        studies.limit_cycle.as_ref().map(|of| {
            of_each(of, "limit-cycle", |study| {
                let along = study.branch.as_ref();
                along.map_or(String::new(), |to| {
                    format!(", {} from {} to {}", to.parameter, to.from, to.to)
                })
            })
        }),
    ]
}

/// The plan of a study of methods at several steps.
fn of_each<S>(of: &DynamicsPlan<S>, what: &'static str, detail: impl Fn(&S) -> String) -> Plan {
    plan(what, &of.methods, steps(&of.steps) + &detail(&of.study))
}
