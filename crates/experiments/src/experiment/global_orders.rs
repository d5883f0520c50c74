//! Global errors and their orders.

use super::declared::{Boxed, section};
use super::local_orders::{claims, off_their_order, orders_of_three, slopes};
use super::names;
use crate::chart::{Axis, LineChart, Style};
use crate::claim::{Readings, Said};
use crate::manifest::RunOutcome;
use crate::report::Verdict;
use crate::scene::{Scene, StepsPlan};
use crate::sheet::{ReportError, Sheet, decimal, measured, of_errors};
use afterbay_analysis::study::VARIABLES;
use afterbay_analysis::study::global_order::{GlobalOrder, GlobalRow, ROUNDING};
use afterbay_analysis::study::outcome::Ending;
use afterbay_methods::registry::Row;

/// The table from which the charts are made.
const DATA: &str = "global_orders";

pub(super) fn declared<'a>(scene: &'a Scene, plan: &'a StepsPlan) -> Boxed<'a> {
    let mut steps = plan.steps.clone();
    steps.sort_by(|a, b| b.total_cmp(a));
    let study = GlobalOrder { problem: &scene.problem, methods: &plan.methods, steps };
    let made = |study: &GlobalOrder<'_>, found| sheet(scene, plan, &study.rows(found));
    section(["global-order", "global errors"], study, made)
}

fn sheet(scene: &Scene, plan: &StepsPlan, found: &[GlobalRow]) -> Result<Sheet, ReportError> {
    let (mut sheet, problem) = (Sheet::new("Global errors and orders"), &scene.problem);
    sheet.data(DATA, found)?;
    // Each run has three rows, one per variable.
    let runs = found.iter().filter(|row| row.variable == VARIABLES[0]);
    sheet.runs.extend(runs.map(|row| {
        let ending = Ending { outcome: row.outcome, failure: row.failure.clone() };
        RunOutcome::of(&ending, "global-order", problem.model.name(), row.method, row.h)
    }));
    sheet.text(format!(
        "The largest error of each variable over [0, {}] and over the degrees of freedom. The \
         order is computed from the two finest steps in a row whose errors exceed {ROUNDING:e} \
         of the largest value of the variable, so that they are no roundings, and are at least ten \
         times the doubt of the reference.",
        problem.end
    ));
    sheet.doubt("Global errors", found.iter().filter_map(GlobalRow::measured));
    let readings = plan.methods.iter().fold(Readings::default(), |r, row| {
        let orders = VARIABLES.map(|variable| order(found, row.name, variable));
        let r = VARIABLES.iter().zip(orders).fold(r, |r, (of, order)| r.and(row.name, of, order));
        if orders.iter().any(Option::is_some) { claims(r, row, [row.order(); 3]) } else { r }
    });
    sheet.find("Global orders of q / p / w", readings, global);
    sheet.table(&HEADER, plan.methods.iter().map(|row| cells(found, row)).collect());
    let figures = VARIABLES.map(|variable| {
        let caption = format!("Global error of {variable} against the step.");
        let chart = chart(scene, plan, found, variable);
        sheet.figure(&format!("global-error-{variable}"), chart.draw(), caption, DATA)
    });
    sheet.show_pairs(figures);
    Ok(sheet)
}

/// The order of a variable at the finest step that has one.
fn order(found: &[GlobalRow], method: &str, variable: &str) -> Option<f64> {
    GlobalRow::of(found, method, variable).filter_map(|row| row.order).next_back()
}

const HEADER: [&str; 8] =
    ["method", "order", "found in q", "p", "w", "error of q at the finest step", "of p", "of w"];

fn cells(found: &[GlobalRow], row: &Row) -> Vec<String> {
    let at_finest = |variable| match GlobalRow::of(found, row.name, variable).next_back() {
        Some(run) if run.error.is_none() => run.outcome.to_owned(),
        run => measured(run.and_then(GlobalRow::measured)),
    };
    let mut cells = vec![row.name.into(), row.order().to_string()];
    cells.extend(VARIABLES.map(|variable| decimal(order(found, row.name, variable))));
    cells.extend(VARIABLES.map(at_finest));
    cells
}

/// The global error of a variable against the step.
fn chart(scene: &Scene, plan: &StepsPlan, found: &[GlobalRow], variable: &str) -> LineChart {
    let curve = |method: &&str| {
        let rows = GlobalRow::of(found, method, variable);
        let errors = rows.filter_map(|row| Some((row.h, row.measured()?)));
        of_errors(method, Style::LineMarkers, errors)
    };
    LineChart {
        title: format!("Global error of {variable}"),
        x: Axis::log(scene.units.time("step h")),
        y: Axis::log(format!("largest error of {variable} on [0, {}]", scene.problem.end)),
        curves: names(&plan.methods).iter().map(curve).collect(),
        guides: slopes(plan.methods.iter().map(|row| row.order())),
    }
}

fn global(r: &Readings) -> Said {
    let mut statement = orders_of_three(r, 2, |_| "–");
    if let Some((off, poles)) = off_their_order(r) {
        statement += &format!(
            " The errors of {off} do not fall at their order: these steps are too long for it, the \
             motion is too sensitive, or it has kinks{poles}."
        );
    }
    (Verdict::Note, statement)
}

#[cfg(test)]
mod tests {
    use super::*;
    use afterbay_methods::registry::{Order, find};

    #[test]
    fn errors_that_do_not_fall_at_their_order_are_named() {
        let of = |r: Readings, name: &str, orders: [f64; 3]| {
            let found = VARIABLES.iter().zip(orders);
            let r = found.fold(r, |r, (of, order)| r.and(name, of, order));
            claims(r, find(name).unwrap(), [Order::Of(4); 3])
        };
        let right = of(Readings::default(), "rk4", [4.02, 3.97, 3.6]);
        assert_eq!(global(&right).1, "rk4 4.02 / 3.97 / 3.60.");
        let (_, said) = global(&of(right, "collocation-4", [4.0, -0.2, 4.0]));
        assert!(said.contains(" The errors of collocation-4 do not fall at their order"), "{said}");
        let (_, said) = global(&of(Readings::default(), "rk4", [75.09, 98.79, 148.46]));
        assert!(said.contains(" The errors of rk4 do not fall at their order"), "{said}");
    }

    #[test]
    fn a_method_that_fails_at_the_finest_step_has_no_error_there() {
        let method = find("rk4").unwrap();
        let row = |(i, h): (usize, f64)| GlobalRow {
            method: method.name,
            variable: VARIABLES[i % 3],
            h,
            error: (h > 0.1).then_some(1e-4),
            order: None,
            doubt: 0.0,
            outcome: if h > 0.1 { "completed" } else { "overflow" },
            failure: None,
        };
        let rows: Vec<_> =
            [0.2, 0.2, 0.2, 0.1, 0.1, 0.1].into_iter().enumerate().map(row).collect();
        assert_eq!(cells(&rows, method)[5..], ["overflow"; 3]);
        assert_eq!(cells(&rows[..3], method)[5], "1.0e-4");
    }
}
