//! The energy balance: the loss of H, the content of the reservoir, and the deviation of K.

use super::declared::{Boxed, section};
use crate::chart::{Axis, Curve, LineChart, Style};
use crate::claim::{Readings, Said, deviation, note};
use crate::findings::{all_completed, ended};
use crate::manifest::RunOutcome;
use crate::scene::{EnergyPlan, Scene};
use crate::sheet::{ReportError, Sheet, line, measured, of_errors, scientific};
use afterbay_analysis::Measured;
use afterbay_analysis::study::energy::{self, Energy, EnergyRow, EnergyRun};

/// The table from which the charts are made.
const DATA: &str = "energy";

pub(super) fn declared<'a>(scene: &'a Scene, plan: &'a EnergyPlan) -> Boxed<'a> {
    let (problem, methods, every) = (&scene.problem, &plan.methods[..], plan.every.max(1));
    let study = Energy { problem, methods, h: plan.step, every };
    let made = |_: &Energy<'_>, found: Vec<EnergyRun>| sheet(scene, plan, &found);
    section(["energy", "energy balance"], study, made)
}

fn sheet(scene: &Scene, plan: &EnergyPlan, found: &[EnergyRun]) -> Result<Sheet, ReportError> {
    let (mut sheet, model) = (Sheet::new("Energy balance"), &scene.problem.model);
    let rows: Vec<_> = found.iter().flat_map(|run| &run.rows).collect();
    sheet.wide_data(DATA, &energy::columns(model), &rows)?;
    let record = |run: &EnergyRun| {
        RunOutcome::of(&run.ending, "energy", model.name(), run.method, plan.step)
    };
    sheet.runs.extend(found.iter().map(record));
    sheet.text(format!(
        "Each run has h = {}. The table shows separate figures: the drift of K and the error of \
         w against the reference, both over all steps, the error of R at the states kept, and the \
         number of steps that violate passivity.",
        plan.step
    ));
    sheet.doubt("Energy balance", rows.iter().map(|row| row.measured_w()));
    sheet.find("Energy balance", readings(found), k_and_w);
    sheet.table(&HEADER, found.iter().map(cells).collect());
    let figure = |(name, caption, chart): Shown| sheet.figure(name, chart.draw(), caption, DATA);
    let figures: Vec<_> = charts(scene, found).into_iter().map(figure).collect();
    sheet.show_pairs(figures);
    Ok(sheet)
}

fn readings(found: &[EnergyRun]) -> Readings {
    // Without a step nothing deviates.
    let of_steps = |run: &EnergyRun, number: f64| (run.steps > 0).then_some(number);
    found.iter().fold(Readings::default(), |r, run| {
        r.and(run.method, "drift", of_steps(run, run.drift))
            .and(run.method, "error of w", of_steps(run, run.w.error))
            .and(run.method, "doubt of w", of_steps(run, run.w.doubt))
            .and(run.method, "steps", run.steps as f64)
            .and(run.method, "run", run.ending.outcome)
    })
}

const HEADER: [&str; 6] =
    ["method", "outcome", "max |K - K₀|", "max |w_j - w_j(t)|", "max |d_R|", "times Δw < 0"];

fn cells(run: &EnergyRun) -> Vec<String> {
    let has_steps = run.steps > 0;
    let ratios = run.rows.iter().filter_map(EnergyRow::measured_ratio);
    let violations = run.violations.filter(|_| has_steps);
    vec![
        run.method.into(),
        run.ending.describe(),
        scientific(has_steps.then_some(run.drift)),
        measured(has_steps.then_some(run.w)),
        measured(ratios.reduce(Measured::larger)),
        violations.map_or("not counted".into(), |count| count.to_string()),
    ]
}

/// A chart over time with the name of its files and its caption.
type Shown = (&'static str, &'static str, LineChart);

fn charts(scene: &Scene, found: &[EnergyRun]) -> Vec<Shown> {
    let energy = |quantity: &str| scene.units.energy(quantity);
    let chart = |title: &str, y: Axis, curves: Vec<Curve>| over(scene, title, y, curves);
    let each = |value: fn(&EnergyRow) -> f64| -> Vec<Curve> {
        found.iter().map(|run| curve(run, run.method, value)).collect()
    };
    let errors = found.iter().map(|run| {
        let errors = run.rows.iter().map(|row| (row.t, row.measured_w()));
        of_errors(run.method, Style::Line, errors)
    });
    let mut charts = vec![
        (
            "balance-energy",
            "H over time.",
            chart("Energy", Axis::linear(energy("H")), each(|row| row.energy)),
        ),
        (
            "balance-reservoir",
            "The sum of all reservoirs.",
            chart("Reservoir", Axis::linear(energy("Σ w")), each(dissipated)),
        ),
    ];
    let is_supplied = !scene.problem.model.motors().is_empty();
    if let Some(first) = found.first().filter(|_| is_supplied) {
        let supply = chart("Supplied energy", Axis::linear(energy("Σ s")), each(supplied));
        let caption = "The energy that the drive, or H itself in time, has supplied.";
        charts.extend([("balance-supplied", caption, supply), balance(scene, first)]);
    }
    charts.extend([
        (
            "balance-deviation-of-k",
            "Deviation of K. Exact zeros cannot be shown on a logarithmic axis.",
            chart("Deviation of K", Axis::log(energy("|K − K₀|")), each(|row| row.drift.abs())),
        ),
        (
            "balance-error-of-w",
            "Error of w against the reference, the largest over the degrees of freedom.",
            chart("Error of w", Axis::log(energy("|w − w(t)|")), errors.collect()),
        ),
    ]);
    charts
}

/// The chart of the energy stored, dissipated and supplied in a run.
fn balance(scene: &Scene, run: &EnergyRun) -> Shown {
    let parts = vec![
        curve(run, "stored, H", |row| row.energy),
        curve(run, "dissipated, Σ w", dissipated),
        curve(run, "supplied, Σ s", supplied),
        curve(run, "H + Σ w − Σ s", |row| row.energy + dissipated(row) - supplied(row)),
    ];
    let (title, y) = (format!("Balance of {}", run.method), scene.units.energy("energy"));
    let caption = "Energy stored, dissipated and supplied, and the sum that stays constant.";
    ("balance-of-energy", caption, over(scene, &title, Axis::linear(y), parts))
}

fn over(scene: &Scene, title: &str, y: Axis, curves: Vec<Curve>) -> LineChart {
    LineChart::new(title, Axis::linear(scene.units.time("time t")), y, curves)
}

/// A quantity of a run over time.
fn curve(run: &EnergyRun, label: &str, value: fn(&EnergyRow) -> f64) -> Curve {
    line(label, run.rows.iter().map(|row| (row.t, value(row))).collect())
}

fn dissipated(row: &EnergyRow) -> f64 {
    row.w.iter().sum()
}

fn supplied(row: &EnergyRow) -> f64 {
    row.s.iter().chain(&row.pumped).sum()
}

/// States the errors of K and of w side by side.
fn k_and_w(r: &Readings) -> Said {
    let one = |name: &str| {
        let [error, doubt] = ["error of w", "doubt of w"].map(|what| r.number(name, what));
        let (drift, w) = (r.number(name, "drift"), Measured { error, doubt });
        if r.number(name, "steps") == 0.0 {
            return format!("{name}: no step{}", ended(r, name));
        }
        format!("{name}: K off by {}, w by {w}{}", deviation(drift), ended(r, name))
    };
    (note(all_completed(r, "drift")), r.each("drift", one))
}
