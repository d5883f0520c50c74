//! Global orders on chain, ring and double pendulum.

use super::{chain, pendulum, ring};
use crate::chart::{Axis, LineChart};
use crate::paper::{Extent, methods};
use crate::progress::Progress;
use crate::report::Verdict;
use crate::sheet::{ReportError, Sheet, decimal, marked, table};
use crate::study::VARIABLES;
use crate::study::global_order::{self, GlobalRow};
use afterbay_methods::registry;

/// The methods for separable systems ...
pub(super) const SEPARABLE: [&str; 8] = [
    "increment-1",
    "increment-2",
    "increment-4",
    "increment-6",
    "increment-8",
    "gonzalez",
    "leapfrog",
    "rk4",
];
/// ... and for any.
pub(super) const ANY: [&str; 7] =
    ["increment-1", "increment-2", "increment-4", "increment-6", "increment-8", "gonzalez", "rk4"];

/// The end of the runs.
pub(super) fn end(extent: Extent) -> f64 {
    extent.pick(4.0, 2.0)
}

/// The masses of the chain.
pub(super) fn masses(extent: Extent) -> usize {
    extent.pick(8, 3)
}

/// An error above this is out of reach of rounding, and an order taken there is one.
const ABOVE_ROUNDING: f64 = 1e-11;

/// An order agrees with the one claimed within this.
const AGREEMENT: f64 = 0.25;

pub(in crate::paper) fn add(
    sheet: &mut Sheet,
    extent: Extent,
    progress: &dyn Progress,
) -> Result<(), ReportError> {
    let (coarsest, count) = extent.pick((0.4, 6), (0.2, 4));
    let steps: Vec<f64> = (0..count).map(|k| coarsest / f64::from(1 << k)).collect();
    let (end, mut figures) = (end(extent), Vec::new());
    for (name, problem, names) in [
        ("fput-chain", chain(masses(extent), end), &SEPARABLE[..]),
        ("van-der-pol-ring", ring(end), &SEPARABLE),
        ("damped-double-pendulum", pendulum(end), &ANY),
    ] {
        let rows = methods(names);
        progress.begin(&format!("global orders of {name}"), rows.len() * steps.len());
        let found = global_order::run(&problem, &rows, &steps, progress)?;
        let data = format!("{name}/global_orders");
        sheet.data(&data, &found)?;
        judge(sheet, name, &found);
        let cells = |name: &&str| {
            let claimed = registry::find(name).map_or(0, registry::Row::order);
            let mut cells = vec![name.to_string(), claimed.to_string()];
            cells.extend(VARIABLES.map(|variable| decimal(order(&found, name, variable))));
            cells
        };
        let header = ["method", "order", "found in q", "p", "w"];
        sheet.fold(&format!("{name}: orders"), vec![table(&header, names.iter().map(cells).collect())]);
        let chart = |variable: &str| LineChart {
            title: format!("{name}: global error of {variable}"),
            x: Axis::log("step h"),
            y: Axis::log(format!("largest error of {variable} on [0, {end}]")),
            curves: names.iter().map(|name| marked(name, points(&found, name, variable))).collect(),
            guides: Vec::new(),
        };
        for variable in ["q", "w"] {
            let caption = format!("Global error of {variable}, the largest over the degrees of freedom.");
            let file = format!("{name}-global-error-{variable}");
            figures.push(sheet.figure(&file, chart(variable).svg(), caption, &data));
        }
    }
    while figures.len() > 1 {
        let rest = figures.split_off(2);
        if let (Some(right), Some(left)) = (figures.pop(), figures.pop()) {
            sheet.show_pair(left, right);
        }
        figures = rest;
    }
    Ok(())
}

fn of<'a>(rows: &'a [GlobalRow], method: &str, variable: &str) -> impl Iterator<Item = &'a GlobalRow> {
    rows.iter().filter(move |row| row.method == method && row.variable == variable)
}

fn points(rows: &[GlobalRow], method: &str, variable: &str) -> Vec<(f64, f64)> {
    of(rows, method, variable).filter_map(|row| Some((row.h, row.error?))).collect()
}

/// The orders between the steps whose errors are above rounding, coarse to fine.
fn orders(rows: &[GlobalRow], method: &str, variable: &str) -> Vec<f64> {
    let above =
        of(rows, method, variable).filter(|row| row.error.is_some_and(|error| error > ABOVE_ROUNDING));
    above.filter_map(|row| row.order).collect()
}

/// The last of them.
fn order(rows: &[GlobalRow], method: &str, variable: &str) -> Option<f64> {
    orders(rows, method, variable).last().copied()
}

/// Do the last two agree? A high order can come down to rounding before it shows.
fn is_settled(rows: &[GlobalRow], method: &str) -> bool {
    VARIABLES.iter().all(|variable| match orders(rows, method, variable)[..] {
        [.., a, b] => (a - b).abs() < AGREEMENT,
        _ => false,
    })
}

fn judge(sheet: &mut Sheet, name: &str, rows: &[GlobalRow]) {
    let mut names: Vec<_> = rows.iter().map(|row| row.method).collect();
    names.dedup();
    let (settled, unsettled): (Vec<_>, Vec<_>) =
        names.into_iter().partition(|method| is_settled(rows, method));
    let found = |method: &str| VARIABLES.map(|variable| order(rows, method, variable).unwrap_or(f64::NAN));
    let right = |method: &&str| {
        let claimed = registry::find(method).map_or(f64::NAN, |row| f64::from(row.order()));
        found(method).into_iter().all(|order| (order - claimed).abs() < AGREEMENT)
    };
    let say = |methods: &[&str]| {
        let one = |method: &&str| {
            let orders = found(method);
            let (least, most) =
                (orders.into_iter().fold(f64::MAX, f64::min), orders.into_iter().fold(f64::MIN, f64::max));
            format!("{method} {least:.2} to {most:.2}")
        };
        methods.iter().map(one).collect::<Vec<_>>().join(", ")
    };
    let verdict =
        if !settled.is_empty() && settled.iter().all(right) { Verdict::Holds } else { Verdict::Fails };
    let rest = if unsettled.is_empty() {
        String::new()
    } else {
        format!(" Not settled within these steps before rounding, and not judged: {}.", say(&unsettled))
    };
    sheet.find(
        &format!("orders on {name}"),
        verdict,
        format!(
            "each method has its order in q, p and w: {}, between the two smallest steps whose error stands above \
             {ABOVE_ROUNDING:.0e}.{rest}",
            say(&settled)
        ),
    );
}
