//! The curves of two results in one chart.

use super::join::{Joined, entry, number};
use super::table::Table;
use super::trajectories::{Distance, VARIABLES};
use crate::chart::{Axis, Curve, Drawing, LineChart, Panels, Style};
use crate::sheet::{line, over_time};

/// The most runs whose curves with markers share a plot. More, and lines, have a panel each.
const SHARED: usize = 3;
/// The most panels.
const PANELS: usize = 12;
/// Columns that vary along a curve, and so do not tell curves apart.
const ALONG: [&str; 4] = ["t", "h", "tolerance", "steps"];

/// A kind of chart: a column against another one, of tables that have both.
struct Kind {
    x: &'static str,
    y: &'static str,
    /// Whether the horizontal and the vertical axis are logarithmic.
    log: [bool; 2],
    label: [&'static str; 2],
    style: Style,
}

const KINDS: [Kind; 9] = [
    over("q1", "q_1"),
    over("H", "H"),
    Kind { log: [false, true], ..over("K_minus_K0", "|K − K₀|") },
    Kind { log: [false, true], ..over("w_error", "error of w") },
    Kind { log: [true; 2], style: Style::LineMarkers, ..over("rms", "deviation of K, rms") },
    against("seconds", "error_qp", ["seconds", "error of (q, p)"]),
    against("seconds", "error_w", ["seconds", "error of w"]),
    against("evaluations", "error_qp", ["evaluations of the force", "error of (q, p)"]),
    against("h", "error", ["step h", "error"]),
];

const fn over(y: &'static str, label: &'static str) -> Kind {
    Kind { x: "t", y, log: [false; 2], label: ["time t", label], style: Style::Line }
}

const fn against(x: &'static str, y: &'static str, label: [&'static str; 2]) -> Kind {
    Kind { x, y, log: [true; 2], label, style: Style::LineMarkers }
}

/// A chart with the name of its file and its caption.
pub(super) struct Drawn {
    pub(super) name: String,
    pub(super) drawing: Drawing,
    pub(super) caption: String,
    /// Whether it takes the full width.
    pub(super) wide: bool,
}

/// A run: its name, and its points in A and in B.
type Pair = (String, [Vec<(f64, f64)>; 2]);

/// The charts of a table whose curves differ. A table of several variables has one for each.
pub(super) fn overlaid(joined: &Joined, tables: (&Table, &Table)) -> Vec<Drawn> {
    let file = joined.name.replace('/', "-");
    let differs = |name: &str| {
        joined.rows_in_one != [0, 0]
            || joined.columns.iter().any(|c| c.name == name && c.different > 0)
    };
    let has = |name: &str| [tables.0, tables.1].iter().all(|table| table.column(name).is_some());
    let mut drawn = Vec::new();
    for kind in KINDS.iter().filter(|kind| has(kind.x) && has(kind.y)) {
        if !differs(kind.x) && !differs(kind.y) {
            continue;
        }
        for variable in variables(tables) {
            let runs = runs(kind, joined, tables, variable);
            let of = variable.map_or(String::new(), |variable| format!(" of {variable}"));
            let title = format!("{}{of}, {}", kind.label[1], joined.name);
            let (drawing, left_out) = draw(kind, &title, &of, runs);
            let more = if left_out > 0 {
                format!(" {left_out} more runs are not shown.")
            } else {
                String::new()
            };
            let end = variable.map_or(String::new(), |variable| format!("-{variable}"));
            drawn.extend(drawing.map(|(drawing, wide)| Drawn {
                name: format!("{file}-{}-against-{}{end}", kind.y, kind.x),
                caption: format!(
                    "{}{of} against {} in A and B.{more}",
                    kind.label[1], kind.label[0]
                ),
                drawing,
                wide,
            }));
        }
    }
    drawn
}

/// The variables of a table; none for a table that is not of single variables.
fn variables<'a>((a, _): (&'a Table, &Table)) -> Vec<Option<&'a str>> {
    let Some(at) = a.column("variable") else { return vec![None] };
    let mut found: Vec<_> = a.rows.iter().map(|row| row.get(at).map(String::as_str)).collect();
    found.sort_unstable();
    found.dedup();
    found
}

/// The points of each run, in the order of their first row.
fn runs(
    kind: &Kind,
    joined: &Joined,
    (a, b): (&Table, &Table),
    variable: Option<&str>,
) -> Vec<Pair> {
    let mut runs: Vec<Pair> = Vec::new();
    for (side, table) in [a, b].into_iter().enumerate() {
        for row in 0..table.rows.len() {
            if variable.is_some_and(|variable| entry(table, row, "variable") != variable) {
                continue;
            }
            let point = |name| number(entry(table, row, name));
            let Some((x, y)) = point(kind.x).zip(point(kind.y)) else { continue };
            let point = (x, if kind.log[1] { y.abs() } else { y });
            let name = name(joined, table, row);
            match runs.iter_mut().rfind(|run| run.0 == name) {
                Some(run) => run.1[side].push(point),
                None => {
                    let mut points = [Vec::new(), Vec::new()];
                    points[side].push(point);
                    runs.push((name, points));
                }
            }
        }
    }
    runs
}

/// The name of the run of a row: the method, and the entries of other keys that do not vary along
/// a curve.
fn name(joined: &Joined, table: &Table, row: usize) -> String {
    let part = |key: &String| {
        let entry = entry(table, row, key);
        match key.strip_prefix("sweep_") {
            Some(name) => Some(format!("{name} = {entry}")),
            None if key == "compensated" => (entry == "true").then(|| key.clone()),
            None => Some(entry.to_owned()),
        }
    };
    let (method, others): (Vec<_>, Vec<_>) =
        joined.keys.iter().partition(|key| key.as_str() == "method");
    let keys = method.into_iter().chain(others);
    let keys = keys.filter(|key| key.as_str() != "variable" && !ALONG.contains(&key.as_str()));
    keys.filter_map(part).collect::<Vec<_>>().join(", ")
}

/// The chart, whether it is wide, and the number of runs that are not shown. Few runs share a plot.
fn draw(kind: &Kind, title: &str, of: &str, runs: Vec<Pair>) -> (Option<(Drawing, bool)>, usize) {
    let axis = |nth: usize, label: String| {
        if kind.log[nth] { Axis::log(label) } else { Axis::linear(label) }
    };
    let x = axis(0, kind.label[0].into());
    let y = axis(1, format!("{}{of}", kind.label[1]));
    let curve = |label: String, points: Vec<(f64, f64)>| Curve {
        label,
        points,
        bounds: Vec::new(),
        style: kind.style,
    };
    if runs.is_empty() {
        return (None, 0);
    }
    let shared = if kind.style == Style::Line { 1 } else { SHARED };
    if runs.len() <= shared {
        let curves = runs.into_iter().flat_map(|(name, points)| {
            ["A", "B"]
                .into_iter()
                .zip(points)
                .map(move |(side, points)| (format!("{name}, {side}"), points))
        });
        let curves = curves.filter(|(_, points)| !points.is_empty());
        let curves = curves.map(|(label, points)| curve(label, points)).collect();
        let chart = LineChart::new(title, x, y, curves);
        return (Some((chart.draw(), false)), 0);
    }
    let left_out = runs.len().saturating_sub(PANELS);
    let panels = runs
        .into_iter()
        .take(PANELS)
        .map(|(name, [a, b])| (name, vec![curve("A".into(), a), curve("B".into(), b)]));
    let panels = Panels { title: title.into(), x, own_x: false, y, panels: panels.collect() };
    (Some((panels.draw(), true)), left_out)
}

/// A chart over time for each variable of trajectories that differ: the distance of each run.
pub(super) fn distances(joined: &Joined, found: &[Distance]) -> Vec<Drawn> {
    let chart = |(nth, variable): (usize, &&str)| {
        let runs = found.chunk_by(|a, b| a.run == b.run).take(PANELS);
        let curves: Vec<_> = runs
            .map(|run| {
                let points = run.iter().filter_map(|one| Some((one.t, one.each()[nth]?)));
                line(&run[0].run, points.collect())
            })
            .collect();
        let differs = curves.iter().flat_map(|curve| &curve.points).any(|point| point.1 > 0.0);
        let title = format!("Difference of {variable}, {}", joined.name);
        let label = format!("largest |{variable}_j(B) − {variable}_j(A)|");
        differs.then(|| Drawn {
            name: format!("{}-difference-of-{variable}", joined.name.replace('/', "-")),
            drawing: over_time(&title, Axis::log(label), curves).draw(),
            caption: format!(
                "Difference of {variable} at common times, the largest over the degrees of \
                 freedom of both. Exact zeros cannot be shown on a logarithmic axis."
            ),
            wide: false,
        })
    };
    VARIABLES.iter().enumerate().filter_map(chart).collect()
}
