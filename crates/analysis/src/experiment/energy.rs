//! The energy balance: the loss of H, the content of the reservoir, and the deviation of K.

use super::declared::{Boxed, section};
use crate::Measured;
use crate::chart::{Axis, Curve, LineChart, Style};
use crate::claim::{Readings, Said};
use crate::report::Verdict;
use crate::scene::{EnergyPlan, Scene};
use crate::sheet::{ReportError, Sheet, line, measured, of_errors, over_time, scientific};
use crate::study::energy::{self, Energy, EnergyRow, EnergyRun};
use crate::study::outcome::COMPLETED;

/// The table from which the charts are made.
const DATA: &str = "energy";

pub(super) fn declared<'a>(scene: &'a Scene, plan: &'a EnergyPlan) -> Boxed<'a> {
    let (problem, methods, every) = (&scene.problem, &plan.methods[..], plan.every.max(1));
    let study = Energy { problem, methods, h: plan.step, every };
    let made = |_: &Energy<'_>, found: Vec<EnergyRun>| sheet(scene, plan, &found);
    section(["energy", "energy balance"], study, made)
}

fn sheet(scene: &Scene, plan: &EnergyPlan, found: &[EnergyRun]) -> Result<Sheet, ReportError> {
    let mut sheet = Sheet::new("Energy balance");
    let problem = &scene.problem;
    let rows: Vec<_> = found.iter().flat_map(|run| &run.rows).collect();
    sheet.wide_data(DATA, &energy::columns(&problem.model), &rows)?;
    let record =
        |run: &EnergyRun| run.ending.record("energy", problem.model.name(), run.method, plan.step);
    sheet.runs.extend(found.iter().map(record));
    sheet.text(format!(
        "Each run has h = {}. The table shows three separate figures: the drift of K over all \
         steps, the error of w against the reference at the states kept, and the number of steps \
         that violate passivity.",
        plan.step
    ));
    sheet
        .doubt("Energy balance", found.iter().flat_map(|run| &run.rows).map(EnergyRow::measured_w));
    let worst = |run: &EnergyRun, value: fn(&EnergyRow) -> Option<Measured>| {
        run.rows.iter().filter_map(value).fold(Measured::default(), Measured::larger)
    };
    let readings = found.iter().fold(Readings::default(), |r, run| {
        let w = worst(run, |row| Some(row.measured_w()));
        r.and(run.method, "drift", run.drift)
            .and(run.method, "error of w", w.error)
            .and(run.method, "doubt of w", w.doubt)
            .and(run.method, "run", run.ending.outcome)
    });
    sheet.find("Energy balance", readings, k_and_w);
    let cells = |run: &EnergyRun| {
        vec![
            run.method.into(),
            run.ending.describe(),
            scientific(Some(run.drift)),
            measured(Some(worst(run, |row| Some(row.measured_w())))),
            measured(Some(worst(run, EnergyRow::measured_ratio))),
            run.violations.map_or("not counted".into(), |count| count.to_string()),
        ]
    };
    sheet.table(
        &["method", "outcome", "max |K - K₀|", "max |w_j - w_j(t)|", "max |d_R|", "times Δw < 0"],
        found.iter().map(cells).collect(),
    );
    let curves = |value: &dyn Fn(&EnergyRow) -> f64| -> Vec<Curve> {
        let of = |run: &EnergyRun| run.rows.iter().map(|row| (row.t, value(row))).collect();
        found.iter().map(|run| line(run.method, of(run))).collect()
    };
    let w_errors = found.iter().map(|run| {
        let errors = run.rows.iter().map(|row| (row.t, row.measured_w()));
        of_errors(run.method, Style::Line, errors)
    });
    let w_errors = w_errors.collect();
    let energy = |quantity: &str| scene.units.energy(quantity);
    let over_time = |title: &str, y: Axis, curves: Vec<Curve>| LineChart {
        x: Axis::linear(scene.units.time("time t")),
        ..over_time(title, y, curves)
    };
    let charts = [
        (
            "balance-energy",
            "H over time.",
            over_time("Energy", Axis::linear(energy("H")), curves(&|row| row.energy)),
        ),
        (
            "balance-reservoir",
            "The sum of all reservoirs.",
            over_time("Reservoir", Axis::linear(energy("Σ w")), curves(&|row| row.w.iter().sum())),
        ),
        (
            "balance-deviation-of-k",
            "Deviation of K. Exact zeros cannot be shown on a logarithmic axis.",
            over_time(
                "Deviation of K",
                Axis::log(energy("|K − K₀|")),
                curves(&|row| row.drift.abs()),
            ),
        ),
        (
            "balance-error-of-w",
            "Error of w against the reference, the largest over the degrees of freedom.",
            over_time("Error of w", Axis::log(energy("|w − w(t)|")), w_errors),
        ),
    ];
    let [a, b, c, d] =
        charts.map(|(name, caption, chart)| sheet.figure(name, chart.draw(), caption, DATA));
    sheet.show_pair(a, b);
    let given = |row: &EnergyRow| row.s.iter().chain(&row.pumped).sum::<f64>();
    if let Some(first) = found.first().filter(|_| !problem.model.motors().is_empty()) {
        let supplied =
            over_time("Supplied energy", Axis::linear(energy("Σ s")), curves(&|row| given(row)));
        let of_first = |label: &str, value: &dyn Fn(&EnergyRow) -> f64| {
            line(label, first.rows.iter().map(|row| (row.t, value(row))).collect())
        };
        let lost = |row: &EnergyRow| row.w.iter().sum::<f64>();
        let parts = vec![
            of_first("stored, H", &|row| row.energy),
            of_first("dissipated, Σ w", &lost),
            of_first("supplied, Σ s", &given),
            of_first("H + Σ w − Σ s", &|row| row.energy + lost(row) - given(row)),
        ];
        let title = format!("Balance of {}", first.method);
        let balance = over_time(&title, Axis::linear(energy("energy")), parts);
        let caption = "The energy that the drive, or H itself in time, has supplied.";
        let left = sheet.figure("balance-supplied", supplied.draw(), caption, DATA);
        let caption = "Energy stored, dissipated and supplied, and the sum that stays constant.";
        let right = sheet.figure("balance-of-energy", balance.draw(), caption, DATA);
        sheet.show_pair(left, right);
    }
    sheet.show_pair(c, d);
    Ok(sheet)
}

/// States the errors of K and of w side by side.
fn k_and_w(r: &Readings) -> Said {
    let one = |(name, drift): (&str, f64)| {
        let [error, doubt] = ["error of w", "doubt of w"].map(|what| r.number(name, what));
        let (w, run) = (Measured { error, doubt }, r.word(name, "run"));
        let end = if run == COMPLETED { String::new() } else { format!(" ({run})") };
        format!("{name}: K off by {drift:.0e}, w by {w}{end}")
    };
    let all = r.numbers("drift");
    let done = all.iter().all(|(name, _)| r.word(name, "run") == COMPLETED);
    let all: Vec<_> = all.into_iter().map(one).collect();
    (if done { Verdict::Note } else { Verdict::Fails }, format!("{}.", all.join("; ")))
}
