//! Global orders on chain, ring and double pendulum.

use super::{chain, pendulum, ring};
use crate::chart::{Axis, LineChart};
use crate::claim::{Readings, Said, fixed, list, verdict};
use crate::paper::{Extent, Paper};
use crate::sheet::{ReportError, Sheet, decimal, marked, table};
use afterbay_analysis::study::VARIABLES;
use afterbay_analysis::study::global_order::{self, GlobalRow, ROUNDING};
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
/// ... and for any system.
pub(super) const ANY: [&str; 7] =
    ["increment-1", "increment-2", "increment-4", "increment-6", "increment-8", "gonzalez", "rk4"];

/// The end of time.
pub(super) fn end(extent: Extent) -> f64 {
    extent.pick(4.0, 2.0)
}

/// The number of masses of the chain.
pub(super) fn masses(extent: Extent) -> usize {
    extent.pick(8, 3)
}

/// The largest difference of an order from the one claimed.
const AGREEMENT: f64 = 0.25;

pub(in crate::paper) fn add(paper: &Paper<'_>, sheet: &mut Sheet) -> Result<(), ReportError> {
    let Paper { extent, progress, .. } = *paper;
    let (coarsest, count) = extent.pick((0.4, 6), (0.2, 4));
    let steps: Vec<f64> = (0..count).map(|k| coarsest / f64::from(1 << k)).collect();
    let (end, mut figures) = (end(extent), Vec::new());
    for (name, problem, names) in [
        ("fput-chain", chain(masses(extent), end), &SEPARABLE[..]),
        ("van-der-pol-ring", ring(end), &SEPARABLE),
        ("damped-double-pendulum", pendulum(end), &ANY),
    ] {
        let rows = paper.methods(names)?;
        progress.begin(&format!("global orders of {name}"), rows.len() * steps.len());
        let found = global_order::run(&problem, &rows, &steps, progress)?;
        let data = format!("{name}/global_orders");
        sheet.data(&data, &found)?;
        judge(sheet, name, &found);
        let cells = |name: &&str| {
            let claimed = registry::find(name).map(|row| row.order().to_string());
            let mut cells = vec![name.to_string(), claimed.unwrap_or_default()];
            cells.extend(VARIABLES.map(|variable| decimal(order(&found, name, variable))));
            cells
        };
        let header = ["method", "order", "found in q", "p", "w"];
        sheet.fold(
            &format!("{name}: orders"),
            vec![table(&header, names.iter().map(cells).collect())],
        );
        let chart = |variable: &str| LineChart {
            title: format!("{name}: global error of {variable}"),
            x: Axis::log("step h"),
            y: Axis::log(format!("largest error of {variable} on [0, {end}]")),
            curves: names.iter().map(|name| marked(name, points(&found, name, variable))).collect(),
            guides: Vec::new(),
        };
        for variable in ["q", "w"] {
            let caption =
                format!("Global error of {variable}, the largest over the degrees of freedom.");
            let file = format!("{name}-global-error-{variable}");
            figures.push(sheet.figure(&file, chart(variable).draw(), caption, &data));
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

fn points(rows: &[GlobalRow], method: &str, variable: &str) -> Vec<(f64, f64)> {
    GlobalRow::of(rows, method, variable).filter_map(|row| Some((row.h, row.error?))).collect()
}

/// The orders between successive steps whose errors are above rounding, from coarse to fine.
fn orders(rows: &[GlobalRow], method: &str, variable: &str) -> Vec<f64> {
    GlobalRow::of(rows, method, variable).filter_map(|row| row.order).collect()
}

/// The order between the two finest of these steps.
fn order(rows: &[GlobalRow], method: &str, variable: &str) -> Option<f64> {
    orders(rows, method, variable).last().copied()
}

/// The difference of the last two orders, the largest over the variables. A high order may reach
/// rounding before it shows.
fn unsettled(rows: &[GlobalRow], method: &str) -> Option<f64> {
    let apart = VARIABLES.iter().map(|variable| match orders(rows, method, variable)[..] {
        [.., a, b] => Some((a - b).abs()),
        _ => None,
    });
    apart.reduce(|a, b| Some(a?.max(b?))).flatten()
}

fn judge(sheet: &mut Sheet, name: &str, rows: &[GlobalRow]) {
    let mut names: Vec<_> = rows.iter().map(|row| row.method).collect();
    names.dedup();
    let readings = names.into_iter().fold(Readings::default(), |r, method| {
        let found = VARIABLES.map(|variable| order(rows, method, variable));
        let of = |better: fn(f64, f64) -> f64| {
            found.into_iter().reduce(|a, b| Some(better(a?, b?))).flatten()
        };
        r.and(
            method,
            "claimed",
            registry::find(method).and_then(|row| row.order().number()).map(f64::from),
        )
        .and(method, "least", of(f64::min))
        .and(method, "largest", of(f64::max))
        .and(method, "last two apart", unsettled(rows, method))
    });
    sheet.find(&format!("orders on {name}"), readings, as_claimed);
}

/// Holds if every settled order of q, p and w is the one claimed.
fn as_claimed(r: &Readings) -> Said {
    let near = |a: f64, b: f64| (a - b).abs() < AGREEMENT;
    let settled = |name: &str| r.number(name, "last two apart") < AGREEMENT;
    let right = |name: &str| {
        let claimed = r.number(name, "claimed");
        near(r.number(name, "least"), claimed) && near(r.number(name, "largest"), claimed)
    };
    let say = |name: &str| {
        let [claimed, least, largest] =
            ["claimed", "least", "largest"].map(|what| r.number(name, what));
        format!("{name} {} to {} for {claimed}", fixed(least, 2), fixed(largest, 2))
    };
    let names = r.of_all("claimed");
    let (judged, rest): (Vec<&str>, Vec<&str>) = names.into_iter().partition(|name| settled(name));
    let (good, bad): (Vec<&str>, Vec<&str>) = judged.iter().copied().partition(|name| right(name));
    let holds = bad.is_empty() && !good.is_empty();
    let says = match (good.is_empty(), bad.is_empty()) {
        (true, true) => "no order is settled".to_owned(),
        (false, true) => {
            format!("each has its order in q, p and w: {}", list(good.into_iter().map(say)))
        }
        (_, false) => format!(
            "{} has another order than its own; as they should be: {}",
            list(bad.into_iter().map(say)),
            list(good.into_iter().map(say))
        ),
    };
    let unsettled = rest.iter().map(|name| match r.number(name, "last two apart") {
        _ if r.number(name, "least").is_nan() => {
            format!("{name} (no order for {})", r.number(name, "claimed"))
        }
        apart if apart.is_nan() => format!("{} (one order alone)", say(name)),
        apart => format!("{} (the last two apart by {apart:.2})", say(name)),
    });
    let statement = format!(
        "{says}; between the two smallest steps whose error stands above {ROUNDING:.0e} of the \
         largest value, within {AGREEMENT}. Not settled before rounding, and not judged: {}.",
        list(unsettled)
    );
    (verdict(holds), statement)
}
