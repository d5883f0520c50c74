//! Local errors and their orders.

use super::declared::{Boxed, section};
use super::names;
use crate::chart::{Axis, LineChart};
use crate::claim::{Readings, Said, fixed, list};
use crate::report::Verdict;
use crate::scene::{LocalOrderPlan, Scene};
use crate::sheet::{ReportError, Sheet, decimal, marked, scientific, table};
use afterbay_analysis::study::VARIABLES;
use afterbay_analysis::study::local_order::{LocalErrors, LocalOrders, OrderRow, Statistic, rows};
use afterbay_methods::registry::{Order, Row};

/// The table from which the charts are made.
const DATA: &str = "local_orders";

/// The reading of the number of steps that failed.
const FAILED: &str = "steps that failed";
/// The readings of the orders of q, p and w that a method claims.
const CLAIMED: [&str; 3] = ["claimed for q", "claimed for p", "claimed for w"];
/// An order found this far below the claimed one is not that of the method. A choice.
const FAR_BELOW: f64 = 0.7;
/// Nor is one of more than this many times the claimed order. A choice: errors may happen to fall
/// at twice the order.
const FAR_ABOVE: f64 = 2.5;

pub(super) fn declared<'a>(scene: &'a Scene, plan: &'a LocalOrderPlan) -> Boxed<'a> {
    let study = plan.study.of::<f64>(&scene.problem, &plan.methods);
    let made = |_: &LocalOrders<'_, f64>, errors: Vec<LocalErrors>| sheet(scene, plan, &errors);
    section(["local-order", "local errors"], study, made)
}

fn sheet(
    scene: &Scene,
    plan: &LocalOrderPlan,
    errors: &[LocalErrors],
) -> Result<Sheet, ReportError> {
    let mut sheet = Sheet::new("Local errors and orders");
    let (study, orders) = (&plan.study, rows(errors, |_, _, _| None));
    sheet.data(DATA, &orders)?;
    sheet.text(format!(
        "One step of each size is taken from every point of the reference at a multiple of {}. The \
         local error T is the increment of the reference minus that of the method, divided by h. \
         The order is the slope of log |T| against log h, with its 95 % confidence interval. A \
         single point determines the maximum, while all points determine the median. {}",
        study.base_step,
        left_out(&orders, study.steps.len())
    ));
    sheet.find("Local orders of q / p / w (median)", readings(plan, &orders), local);
    let cells = orders.iter().map(|row| cells(row, study.steps.len()));
    sheet.fold("every order", vec![table(&HEADER, cells.collect())]);
    let figures = [0, 1, 2].map(|i| {
        let name = VARIABLES[i];
        let caption = format!("Median of the local errors of {name} over the base grid.");
        let chart = chart(scene, plan, errors, i);
        sheet.figure(&format!("local-error-{name}"), chart.draw(), caption, DATA)
    });
    sheet.show_pairs(figures);
    Ok(sheet)
}

fn readings(plan: &LocalOrderPlan, orders: &[OrderRow]) -> Readings {
    let median = |method: &str, variable: &str| {
        OrderRow::find(orders, method, variable, Statistic::Median)?.order
    };
    plan.methods.iter().fold(Readings::default(), |r, row| {
        let r = VARIABLES.iter().fold(r, |r, of| r.and(row.name, of, median(row.name, of)));
        let failed = orders.iter().find(|order| order.method == row.name).map(|order| order.failed);
        let r = match failed.filter(|count| *count > 0) {
            Some(count) => r.and(row.name, FAILED, count as f64),
            None => r,
        };
        claims(r, row, row.local_order)
    })
}

const HEADER: [&str; 9] = [
    "method",
    "variable",
    "statistic",
    "order",
    "95 % interval",
    "steps used",
    "t of the worst point",
    "its distance to a pole",
    "steps that failed",
];

fn cells(row: &OrderRow, steps: usize) -> Vec<String> {
    let interval = row.ci_low.zip(row.ci_high);
    vec![
        row.method.into(),
        row.variable.into(),
        row.statistic.into(),
        order_of(row),
        interval.map_or(String::new(), |(low, high)| format!("{low:.3} to {high:.3}")),
        format!("{} of {steps}", row.points),
        row.worst_t.to_string(),
        scientific(row.pole_distance),
        row.failed.to_string(),
    ]
}

/// The median of the local errors of variable number i against the step.
fn chart(scene: &Scene, plan: &LocalOrderPlan, errors: &[LocalErrors], i: usize) -> LineChart {
    let curve = |method: &&str| {
        let points = errors.iter().filter(|errors| errors.method.name == *method);
        let point = |errors: &LocalErrors| (errors.h, errors.variables[i].get(Statistic::Median));
        marked(method, points.map(point).collect())
    };
    LineChart {
        title: format!("Local error of {}, median", VARIABLES[i]),
        x: Axis::log(scene.units.time("step h")),
        y: Axis::log(format!("median of |T| of {}", VARIABLES[i])),
        curves: names(&plan.methods).iter().map(curve).collect(),
        guides: slopes(plan.methods.iter().map(|row| row.local_order[i])),
    }
}

/// An order, or the reason why there is none.
fn order_of(row: &OrderRow) -> String {
    if row.order.is_some() { decimal(row.order) } else { no_order(row.failed > 0).into() }
}

/// The reason why there is no order.
fn no_order(has_failed: bool) -> &'static str {
    if has_failed { "none: failed or below rounding" } else { "none: below rounding" }
}

/// States which statistics use fewer than all steps, and why.
fn left_out(orders: &[OrderRow], steps: usize) -> String {
    let fewer = orders.iter().filter(|row| row.points < steps);
    let of = |row: &OrderRow| {
        format!("{} {} {} ({} of {steps})", row.method, row.variable, row.statistic, row.points)
    };
    let all: Vec<_> = fewer.map(of).collect();
    if all.is_empty() {
        return "All steps are used: their errors are at least ten times their rounding.".into();
    }
    format!(
        "Steps that failed and those with |T| less than ten times its rounding are left out. The \
         rounding is the difference between the step in f64 and the same step in 106 bits, plus \
         the rounding of the states compared, divided by h. Steps used where some are left out: \
         {}.",
        all.join(", ")
    )
}

/// The slopes of guides for methods of these orders.
pub(super) fn slopes(orders: impl Iterator<Item = Order>) -> Vec<f64> {
    let mut orders: Vec<u32> = orders.filter_map(Order::number).collect();
    orders.sort_unstable();
    orders.dedup();
    orders.into_iter().map(f64::from).collect()
}

fn local(r: &Readings) -> Said {
    let none = |name: &str| no_order(r.known(name, FAILED).is_some());
    let mut statement = orders_of_three(r, 3, none);
    let failed = r.numbers(FAILED).into_iter();
    let failed: Vec<String> = failed.map(|(name, count)| format!("{name} {count}")).collect();
    if !failed.is_empty() {
        statement += &format!(" Steps that failed: {}.", failed.join(", "));
    }
    if let Some((off, poles)) = off_their_order(r) {
        statement += &format!(
            " The local errors of {off} do not fall at their order: these steps are too long for \
             it, errors are near their roundings, or the motion has kinks{poles}."
        );
    }
    (Verdict::Note, statement)
}

/// The orders of q, p and w of every method. What `none` says of a method stands for a missing one.
pub(super) fn orders_of_three<'a>(
    r: &Readings,
    decimals: usize,
    none: impl Fn(&str) -> &'a str,
) -> String {
    let one = |name: &str| {
        let order = |variable: &str| match r.number(name, variable) {
            order if order.is_nan() => none(name).into(),
            order => fixed(order, decimals),
        };
        format!("{name} {}", VARIABLES.map(order).join(" / "))
    };
    r.each(VARIABLES[0], one)
}

/// Adds the orders of q, p and w that a method claims, and whether its δ have poles.
pub(super) fn claims(r: Readings, row: &Row, orders: [Order; 3]) -> Readings {
    let claimed = CLAIMED.iter().zip(orders);
    let claimed = claimed.filter_map(|(of, order)| Some((of, f64::from(order.number()?))));
    let r = claimed.fold(r, |r, (of, order)| r.and(row.name, of, order));
    if row.poles().is_empty() { r } else { r.and(row.name, "poles", "δ") }
}

/// The methods whose errors do not fall at the order they claim, and the end of a sentence about
/// the causes if there are poles of δ among them.
pub(super) fn off_their_order(r: &Readings) -> Option<(String, &'static str)> {
    let is_off = |name: &&str| {
        VARIABLES.iter().zip(CLAIMED).any(|(variable, claimed)| {
            let (order, claimed) = (r.number(name, variable), r.number(name, claimed));
            order < claimed - FAR_BELOW || order > FAR_ABOVE * claimed
        })
    };
    let off: Vec<&str> = r.of_all(VARIABLES[0]).into_iter().filter(is_off).collect();
    let has_poles = off.iter().any(|name| !r.word(name, "poles").is_empty());
    let poles = if has_poles { ", or δ has poles" } else { "" };
    (!off.is_empty()).then(|| (list(off.into_iter().map(str::to_owned)), poles))
}
