//! Figures of trajectories: those of the scene, and those shown without being asked for.

use crate::chart::{Axis, Cells, Curve, Drawing, HeatMap, LineChart, Maps, Panels, coincide};
use crate::observable::{Observable, entries, letter};
use crate::scene::{FigurePlan, RunPlan, Scene, Shown, UnitsTable, Variable};
use crate::sheet::line;
use crate::study::trajectory::{Trajectory, TrajectoryRow};

/// The most degrees of freedom in a default chart.
const SHOWN: usize = 6;
/// The least number of degrees of freedom of which a map is shown.
const CHAIN: usize = 8;
/// The most columns and rows of a map.
const CELLS: usize = 128;
/// The most panels of a chart. Beyond, the curves share one plot.
const PANELS: usize = 12;

/// The figures of the scene, and the default ones whose names it does not use.
pub(super) fn plans(scene: &Scene, run: &RunPlan) -> Vec<FigurePlan> {
    let mut plans = scene.figures.clone();
    for plan in defaults(scene.problem.model.dof(), run) {
        if plans.iter().all(|own| own.name != plan.name) {
            plans.push(plan);
        }
    }
    plans
}

fn defaults(dof: usize, run: &RunPlan) -> Vec<FigurePlan> {
    let all = run.names();
    let one: Vec<_> = all.iter().copied().take(1).collect();
    let plan = |name: &str, title: &str, methods: &[&'static str], shown| FigurePlan {
        name: name.into(),
        title: Some(title.into()),
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
            plans.push(plan("orbit", "Orbit", &one, orbit));
        }
        let portrait = curves(q1, vec![p1]);
        plans.push(plan("phase-plane", "Phase plane of degree 1", &one, portrait));
        plans.push(plan("reservoirs", "Reservoirs", &one, curves(time, first(Variable::W))));
    }
    let books = vec![Observable::Energy, Observable::Reservoirs, Observable::Total];
    plans.push(plan("energy", "Energy", &all, curves(time, books)));
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

pub(super) fn draw(plan: &FigurePlan, found: &[Trajectory], units: &UnitsTable) -> Drawn {
    let run = |name: &&str| found.iter().find(|run| run.method == *name);
    let runs: Vec<&Trajectory> = plan.methods.iter().filter_map(run).collect();
    match &plan.shown {
        Shown::Curves { x, y, log } => draw_curves(plan, &runs, (*x, y, *log), units),
        Shown::Map(variable) => draw_maps(plan, &runs, *variable, units),
    }
}

/// The title of a figure. It names the method if the figure shows one.
fn title(plan: &FigurePlan, runs: &[&Trajectory], quantities: &str) -> String {
    let what = plan.title.as_deref().unwrap_or(quantities);
    match (&plan.methods[..], runs) {
        ([one], _) => format!("{what} by {one}"),
        _ => what.to_owned(),
    }
}

fn draw_curves(
    plan: &FigurePlan,
    runs: &[&Trajectory],
    (x, y, log): (Observable, &[Observable], bool),
    units: &UnitsTable,
) -> Drawn {
    let curve = |run: &Trajectory, y: Observable, label: &str| {
        let Some(first) = run.rows.first() else { return line(label, Vec::new()) };
        let points = run.rows.iter().filter_map(|row| {
            let value = y.of(row, first)?;
            Some((x.of(row, first)?, if log { value.abs() } else { value }))
        });
        line(label, points.collect())
    };
    let symbol = |y: &Observable| if log { format!("|{}|", y.symbol()) } else { y.symbol() };
    let of =
        |run: &Trajectory| -> Vec<Curve> { y.iter().map(|y| curve(run, *y, &symbol(y))).collect() };
    let quantities = quantities(y, log);
    let over =
        if x == Observable::Time { "over time".into() } else { format!("against {}", x.symbol()) };
    let title = title(plan, runs, &format!("{quantities} {over}"));
    let x_label = if x == Observable::Time { "time t".into() } else { x.symbol() };
    let x_axis = Axis::linear(x.label(&x_label, units));
    let label = labels(y, log, units);
    let y_axis = if log { Axis::log(label) } else { Axis::linear(label) };
    let mut caption = format!("{quantities} {over}");
    if log {
        caption.push_str(". A logarithmic axis cannot show zeros");
    }
    let (single, several) = (y.len() == 1, runs.len() > 1);
    let overlaid: Vec<Curve> = if single {
        runs.iter().flat_map(|run| y.iter().map(|y| curve(run, *y, run.method))).collect()
    } else {
        runs.iter().take(1).flat_map(|run| of(run)).collect()
    };
    let hidden = several && (!single || (!log && coincide(&overlaid)));
    if hidden && runs.len() <= PANELS {
        let panel = |run: &&Trajectory| {
            let curves = if single {
                y.iter().map(|y| curve(run, *y, run.method)).collect()
            } else {
                of(run)
            };
            (run.method.to_owned(), curves)
        };
        if single {
            caption.push_str(". The curves of some methods coincide, so each has its own panel");
        }
        let panels =
            Panels { title, x: x_axis, y: y_axis, panels: runs.iter().map(panel).collect() };
        return Drawn { drawing: panels.draw(), caption: caption + ".", wide: true };
    }
    let curves = if single || !several {
        overlaid
    } else {
        let name = |run: &Trajectory, y: &Observable| format!("{}, {}", run.method, symbol(y));
        let of = |run: &&Trajectory| -> Vec<_> {
            y.iter().map(|y| curve(run, *y, &name(run, y))).collect()
        };
        runs.iter().flat_map(of).collect()
    };
    let chart = LineChart { title, x: x_axis, y: y_axis, curves, guides: Vec::new() };
    Drawn { drawing: chart.draw(), caption: caption + ".", wide: false }
}

/// The quantities of a chart in short: `q1, q2`, or `q1 to q6`.
fn quantities(y: &[Observable], log: bool) -> String {
    let symbols: Vec<String> = y.iter().map(|y| y.symbol()).collect();
    let text = match &symbols[..] {
        [first, .., last] if symbols.len() > 3 => format!("{first}, …, {last}"),
        _ => symbols.join(", "),
    };
    if log { format!("|{text}|") } else { text }
}

/// The label of the vertical axis. Quantities of one unit share it.
fn labels(y: &[Observable], log: bool, units: &UnitsTable) -> String {
    let same =
        |one: &Observable| y.iter().all(|other| other.label("", units) == one.label("", units));
    match y {
        [first, ..] if same(first) => {
            let text = match first {
                Observable::Of(variable, _) if y.len() > 3 => format!("{}_j", letter(*variable)),
                _ => quantities(y, false),
            };
            first.label(&if log { format!("|{text}|") } else { text }, units)
        }
        _ => {
            let each: Vec<String> = y.iter().map(|y| y.label(&y.symbol(), units)).collect();
            each.join(", ")
        }
    }
}

fn draw_maps(
    plan: &FigurePlan,
    runs: &[&Trajectory],
    variable: Variable,
    units: &UnitsTable,
) -> Drawn {
    let dof =
        runs.iter().flat_map(|run| run.rows.first()).map(|row| row.q.len()).max().unwrap_or(0);
    let columns = spaced(dof, CELLS);
    let letter = letter(variable);
    let cells = |run: &Trajectory| -> (Vec<f64>, Vec<f64>) {
        let rows: Vec<_> =
            spaced(run.rows.len(), CELLS).into_iter().filter_map(|i| run.rows.get(i)).collect();
        let value = |row: &&TrajectoryRow| -> Vec<f64> {
            let entries = entries(variable, row);
            columns.iter().filter_map(|&j| entries.get(j).copied()).collect()
        };
        (rows.iter().map(|row| row.t).collect(), rows.iter().flat_map(value).collect())
    };
    let found: Vec<_> = runs.iter().map(|run| (run.method, cells(run))).collect();
    let sizes = found.iter().flat_map(|(_, (_, values))| values).map(|value| value.abs());
    let span = sizes.filter(|size| size.is_finite()).fold(0.0, f64::max);
    let span = if span > 0.0 { span } else { 1.0 };
    let title = title(plan, runs, &format!("{letter}_i over the chain and time"));
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

/// At most `most` of the numbers below `count`, evenly spaced.
fn spaced(count: usize, most: usize) -> Vec<usize> {
    if count <= most {
        return (0..count).collect();
    }
    (0..most).map(|i| i * (count - 1) / (most - 1)).collect()
}
