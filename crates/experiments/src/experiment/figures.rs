//! Figures of trajectories: those of the scene, and those shown without being asked for.

use crate::UnitsTable;
use crate::chart::{
    Axis, Cells, Curve, Drawing, HeatMap, LineChart, Maps, Panels, coincide, dwarf,
};
use crate::scene::{FigurePlan, RunPlan, Scene, Shown};
use crate::sheet::line;
use afterbay_analysis::Model;
use afterbay_analysis::Observable;
use afterbay_analysis::Variable;
use afterbay_analysis::study::trajectory::{Trajectory, TrajectoryRow};

/// The most degrees of freedom in a default chart.
const SHOWN: usize = 6;
/// The least number of degrees of freedom of which a map is shown.
const CHAIN: usize = 8;
/// The most columns and rows of a map. Several maps of a figure share their square.
const CELLS: usize = 128;
/// The most panels of a chart. A choice: enough for one panel for each method.
const PANELS: usize = 32;

/// The figures of the scene, and the default ones whose names it does not use and which it does not
/// show under another name.
pub(super) fn plans(scene: &Scene, run: &RunPlan) -> Vec<FigurePlan> {
    let mut plans = scene.figures.clone();
    for plan in defaults(&scene.problem.model, run) {
        let is_shown = |own: &FigurePlan| own.shown == plan.shown && own.methods == plan.methods;
        if plans.iter().all(|own| own.name != plan.name && !is_shown(own)) {
            plans.push(plan);
        }
    }
    plans
}

fn defaults(model: &Model, run: &RunPlan) -> Vec<FigurePlan> {
    let (dof, is_driven) = (model.degrees(), !model.driven().is_empty());
    let all = run.names();
    let one: Vec<_> = all.iter().copied().take(1).collect();
    let plan = |name: &str, title: &str, methods: &[&'static str], shown| FigurePlan {
        name: name.into(),
        title: Some(match methods {
            [method] => format!("{title} by {method}"),
            _ => title.into(),
        }),
        methods: methods.to_vec(),
        shown,
    };
    let curves = |x, y: Vec<Observable>| Shown::Curves { x, y, log: false };
    let first =
        |variable| -> Vec<_> { (0..dof.min(SHOWN)).map(|j| Observable::Of(variable, j)).collect() };
    let (time, q1, p1) =
        (Observable::Time, Observable::Of(Variable::Q, 0), Observable::Of(Variable::P, 0));
    let mut plans = Vec::new();
    if dof == 1 {
        plans.push(plan("coordinate", "Coordinate", &all, curves(time, vec![q1])));
        plans.push(plan("phase-plane", "Phase plane", &all, curves(q1, vec![p1])));
    } else {
        if dof >= CHAIN {
            plans.push(plan("map-of-q", "Coordinates", &one, Shown::Map(Variable::Q)));
        }
        let coordinates = curves(time, first(Variable::Q));
        plans.push(plan("coordinates", "Coordinates", &one, coordinates));
        if dof == 2 {
            let orbit = curves(q1, vec![Observable::Of(Variable::Q, 1)]);
            plans.push(plan("orbit", "Configuration plane", &one, orbit));
        }
        let portrait = curves(q1, vec![p1]);
        plans.push(plan("phase-plane", "Phase plane of degree 1", &one, portrait));
        plans.push(plan("reservoirs", "Reservoirs", &one, curves(time, first(Variable::W))));
    }
    let mut balance = vec![Observable::Energy, Observable::Reservoirs, Observable::Total];
    if model.has_clock() {
        balance.insert(2, Observable::Pumped);
    }
    if is_driven {
        balance.insert(2, Observable::Supplied);
    }
    plans.push(plan("energy", "Energy", &all, curves(time, balance)));
    let drift = Shown::Curves { x: time, y: vec![Observable::Drift], log: true };
    plans.push(plan("deviation-of-k", "Deviation of K", &all, drift));
    plans
}

/// A figure: its drawing, its caption, and whether it takes the full width.
pub(super) struct Drawn {
    pub(super) drawing: Drawing,
    pub(super) caption: String,
    pub(super) wide: bool,
}

pub(super) fn draw(plan: &FigurePlan, found: &[&Trajectory], units: &UnitsTable) -> Drawn {
    let run = |name: &&str| found.iter().copied().find(|run| run.method == *name);
    let runs: Vec<&Trajectory> = plan.methods.iter().filter_map(run).collect();
    match &plan.shown {
        Shown::Curves { x, y, log } => draw_curves(plan, &runs, (*x, y, *log), units),
        Shown::Map(variable) => draw_maps(plan, &runs, *variable, units),
    }
}

/// The title of a figure: its own, or its quantities, and its method if it shows one.
fn title(plan: &FigurePlan, quantities: &str) -> String {
    match (&plan.title, &plan.methods[..]) {
        (Some(title), _) => title.clone(),
        (None, [method]) => format!("{quantities} by {method}"),
        (None, _) => quantities.to_owned(),
    }
}

fn draw_curves(
    plan: &FigurePlan,
    runs: &[&Trajectory],
    (x, y, log): (Observable, &[Observable], bool),
    units: &UnitsTable,
) -> Drawn {
    let points = |run: &Trajectory, y: Observable| -> Vec<(f64, f64)> {
        let Some(first) = run.rows.first() else { return Vec::new() };
        let value = |row| y.of(row, first).map(|value| if log { value.abs() } else { value });
        run.rows.iter().filter_map(|row| Some((x.of(row, first)?, value(row)?))).collect()
    };
    let (single, several) = (y.len() == 1, runs.len() > 1);
    // A curve is named by what tells it from the others of its plot.
    let curves = |run: &Trajectory, alone: bool| -> Vec<Curve> {
        let label = |y: Observable| match (single, alone) {
            (true, _) => run.method.to_owned(),
            (false, true) => symbol(y, log),
            (false, false) => format!("{}, {}", run.method, symbol(y, log)),
        };
        y.iter().map(|&y| line(&label(y), points(run, y))).collect()
    };
    let over_time = x == Observable::Time;
    let over = if over_time { "over time".into() } else { format!("against {}", x.symbol()) };
    let mut caption = format!("{} {over}", quantities(y, log));
    let title = title(plan, &caption);
    let x_symbol = if over_time { "time t".into() } else { x.symbol() };
    let x_axis = Axis::linear(units.observable(x, &x_symbol));
    let y_label = label(y, log, units);
    let y_axis = if log { Axis::log(y_label) } else { Axis::linear(y_label) };
    if log {
        caption.push_str(". Exact zeros cannot be shown on a logarithmic axis");
    }
    let overlaid: Vec<Curve> = runs.iter().flat_map(|run| curves(run, !several)).collect();
    let (coincide, dwarfed) = (!log && coincide(&overlaid), !log && dwarf(&overlaid));
    let panels: Vec<(String, Vec<Curve>)> = if several && !single {
        runs.iter().map(|run| (run.method.to_owned(), curves(run, true))).collect()
    } else if coincide || dwarfed {
        let why = if coincide { "coincide" } else { "would be flat beside others" };
        caption.push_str(&format!(". Some curves {why}, so each has its own panel"));
        overlaid.iter().map(|curve| (curve.label.clone(), vec![curve.clone()])).collect()
    } else {
        Vec::new()
    };
    if !panels.is_empty() {
        if panels.len() > PANELS {
            caption.push_str(&format!(". The first {PANELS} of {} are shown", panels.len()));
        }
        let panels = panels.into_iter().take(PANELS).collect();
        let panels = Panels { title, x: x_axis, own_x: !over_time, y: y_axis, panels };
        return Drawn { drawing: panels.draw(), caption: caption + ".", wide: true };
    }
    let chart = LineChart::new(title, x_axis, y_axis, overlaid);
    Drawn { drawing: chart.draw(), caption: caption + ".", wide: false }
}

/// The quantities of a chart in short: `q1, q2`, or `q1, …, q6`.
fn quantities(y: &[Observable], log: bool) -> String {
    let symbols: Vec<String> = y.iter().map(|y| symbol(*y, log)).collect();
    match &symbols[..] {
        [first, .., last] if symbols.len() > 4 => format!("{first}, …, {last}"),
        _ => symbols.join(", "),
    }
}

/// The symbol of a quantity, or of its absolute value.
fn symbol(y: Observable, absolute: bool) -> String {
    if absolute { format!("|{}|", y.symbol()) } else { y.symbol() }
}

/// The label of the vertical axis. Quantities of one unit share it.
fn label(y: &[Observable], log: bool, units: &UnitsTable) -> String {
    let shared =
        |one: &Observable| y.iter().all(|y| units.observable(*y, "") == units.observable(*one, ""));
    match y {
        [first @ Observable::Of(variable, _), ..] if y.len() > 3 && all_of(y, *variable) => {
            let entry = format!("{}_j", variable.letter());
            units.observable(*first, &if log { format!("|{entry}|") } else { entry })
        }
        [first, ..] if shared(first) => units.observable(*first, &quantities(y, log)),
        _ => {
            let each: Vec<String> =
                y.iter().map(|y| units.observable(*y, &symbol(*y, log))).collect();
            each.join(", ")
        }
    }
}

/// Whether all quantities are entries of one variable.
fn all_of(y: &[Observable], variable: Variable) -> bool {
    y.iter().all(|y| matches!(y, Observable::Of(other, _) if *other == variable))
}

fn draw_maps(
    plan: &FigurePlan,
    runs: &[&Trajectory],
    variable: Variable,
    units: &UnitsTable,
) -> Drawn {
    let dof =
        runs.iter().flat_map(|run| run.rows.first()).map(|row| row.q.len()).max().unwrap_or(0);
    let most = (CELLS as f64 / (runs.len().max(1) as f64).sqrt()) as usize;
    let columns = spaced(dof, most);
    let letter = variable.letter();
    let cells = |run: &Trajectory| -> (Vec<f64>, Vec<f64>) {
        let rows: Vec<_> =
            spaced(run.rows.len(), most).into_iter().filter_map(|i| run.rows.get(i)).collect();
        let value = |row: &&TrajectoryRow| -> Vec<f64> {
            let entries = row.entries(variable);
            columns.iter().filter_map(|&j| entries.get(j).copied()).collect()
        };
        (rows.iter().map(|row| row.t).collect(), rows.iter().flat_map(value).collect())
    };
    let found: Vec<_> = runs.iter().map(|run| (run.method, cells(run))).collect();
    let sizes = found.iter().flat_map(|(_, (_, values))| values).map(|value| value.abs());
    let span = sizes.filter(|size| size.is_finite()).fold(0.0, f64::max);
    let span = if span > 0.0 { span } else { 1.0 };
    let title = title(plan, &format!("{letter}_i over the chain and time"));
    let several = found.len() > 1;
    let map = |(method, (times, values)): (&str, (Vec<f64>, Vec<f64>))| HeatMap {
        title: if several { method.into() } else { title.clone() },
        x: Axis::linear("degree of freedom i"),
        y: Axis::linear(units.time("time t")),
        xs: columns.iter().map(|&j| (j + 1) as f64).collect(),
        ys: times,
        cells: Cells::Values {
            label: units.variable(variable, &format!("{letter}_i")),
            span,
            values,
        },
    };
    let mut maps: Vec<_> = found.into_iter().map(map).collect();
    let drawing = match (&mut maps[..], several) {
        ([one], false) => one.draw(),
        _ => Maps { title: title.clone(), maps }.draw(),
    };
    let mut caption = format!("{letter}_i over the number of the degree of freedom and time");
    if columns.len() < dof {
        caption.push_str(&format!(", {} of {dof} degrees of freedom", columns.len()));
    }
    Drawn { drawing, caption: caption + ".", wide: several }
}

/// At most `most` of the numbers below `count`, but two at least, evenly spaced.
fn spaced(count: usize, most: usize) -> Vec<usize> {
    let most = most.max(2);
    if count <= most {
        return (0..count).collect();
    }
    (0..most).map(|i| i * (count - 1) / (most - 1)).collect()
}
