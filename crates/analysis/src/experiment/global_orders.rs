//! Global errors and their orders.

use super::declared::{Boxed, section};
use super::local_orders::orders_of_three;
use super::names;
use crate::Measured;
use crate::chart::{Axis, LineChart, Style};
use crate::claim::{Readings, Said};
use crate::record::RunOutcome;
use crate::report::Verdict;
use crate::scene::{Scene, StepsPlan};
use crate::sheet::{ReportError, Sheet, decimal, measured, of_errors, table};
use crate::study::VARIABLES;
use crate::study::global_order::{GlobalOrder, GlobalRow};
use afterbay_methods::registry::EXACT;

/// The least error from which an order is taken, well above rounding.
const ABOVE_ROUNDING: f64 = 1e-11;

pub(super) fn declared<'a>(scene: &'a Scene, plan: &'a StepsPlan) -> Boxed<'a> {
    let mut steps = plan.steps.clone();
    steps.sort_by(|a, b| b.total_cmp(a));
    let study = GlobalOrder { problem: &scene.problem, methods: &plan.methods, steps };
    let made = |study: &GlobalOrder<'_>, found| sheet(scene, plan, &study.rows(found));
    section(["global-order", "global errors"], study, made)
}

fn sheet(scene: &Scene, plan: &StepsPlan, found: &[GlobalRow]) -> Result<Sheet, ReportError> {
    let mut sheet = Sheet::new("Global errors and orders");
    let (problem, all) = (&scene.problem, names(&plan.methods));
    sheet.data("global_orders", found)?;
    // Each run has three rows, one per variable.
    let runs = found.iter().filter(|row| row.variable == VARIABLES[0]);
    sheet.runs.extend(runs.map(|row| RunOutcome {
        study: "global-order",
        system: problem.model.name(),
        method: row.method,
        h: row.h,
        outcome: row.outcome.into(),
        failure: row.failure.clone(),
    }));
    sheet.text(format!(
        "The largest error of each variable over [0, {}] and over the degrees of freedom. The \
         order is computed from the two finest steps whose errors exceed {ABOVE_ROUNDING:e} and \
         are at least ten times the doubt of the reference.",
        problem.end
    ));
    sheet.doubt("Global errors", found.iter().filter_map(GlobalRow::measured));
    let of = |method: &str, variable: &str| -> Vec<&GlobalRow> {
        found.iter().filter(|row| row.method == method && row.variable == variable).collect()
    };
    let order = |method: &str, variable: &str| {
        let above = |row: &&&GlobalRow| row.error.is_some_and(|error| error > ABOVE_ROUNDING);
        of(method, variable).iter().filter(above).filter_map(|row| row.order).next_back()
    };
    let finest = |method: &str, variable: &str| -> Option<Measured> {
        of(method, variable).into_iter().filter_map(GlobalRow::measured).next_back()
    };
    let cells = |row: &&'static afterbay_methods::registry::Row| {
        let claimed = row.order();
        let claimed = if claimed == EXACT { "exact".into() } else { claimed.to_string() };
        let mut cells = vec![row.name.into(), claimed];
        cells.extend(VARIABLES.map(|variable| decimal(order(row.name, variable))));
        cells.extend(VARIABLES.map(|variable| measured(finest(row.name, variable))));
        cells
    };
    let readings = all.iter().fold(Readings::default(), |r, name| {
        VARIABLES.iter().fold(r, |r, variable| r.and(name, variable, order(name, variable)))
    });
    sheet.find("Global orders of q / p / w", readings, global);
    let header = [
        "method",
        "order",
        "found in q",
        "p",
        "w",
        "error of q at the finest step",
        "of p",
        "of w",
    ];
    sheet.section.blocks.push(table(&header, plan.methods.iter().map(cells).collect()));
    let chart = |variable: &str| LineChart {
        title: format!("Global error of {variable}"),
        x: Axis::log(scene.units.time("step h")),
        y: Axis::log(format!("largest error of {variable} on [0, {}]", problem.end)),
        curves: all
            .iter()
            .map(|method| {
                let of = of(method, variable).into_iter();
                let errors = of.filter_map(|row| Some((row.h, row.measured()?)));
                of_errors(method, Style::LineMarkers, errors)
            })
            .collect(),
        guides: slopes(plan.methods.iter().map(|row| row.order())),
    };
    let [q, p, w] = VARIABLES.map(|variable| {
        let caption = format!("Global error of {variable} against the step.");
        sheet.figure(
            &format!("global-error-{variable}"),
            chart(variable).draw(),
            caption,
            "global_orders",
        )
    });
    sheet.show_pair(q, p);
    sheet.section.blocks.push(crate::report::Block::Figure(w));
    Ok(sheet)
}

/// The slopes of guides for methods of these orders.
pub(super) fn slopes(orders: impl Iterator<Item = u32>) -> Vec<f64> {
    let mut orders: Vec<u32> = orders.filter(|&order| order != EXACT).collect();
    orders.sort_unstable();
    orders.dedup();
    orders.into_iter().map(f64::from).collect()
}

fn global(r: &Readings) -> Said {
    (Verdict::Note, orders_of_three(r, 2, "–"))
}
