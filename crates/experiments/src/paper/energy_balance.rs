//! Figures 4.1 to 4.4: local errors over time, the drift of K and the energy ratio, and the global
//! orders behind them.

mod claims;

use super::{BASE_STEP, FIGURE_STEP, Paper, Part, oscillator};
use crate::chart::{Axis, LineChart};
use crate::claim::{Readings, Said};
use crate::manifest::RunOutcome;
use crate::sheet::{ReportError, Sheet, decimal, line, marked, over_time, scientific};
use afterbay_analysis::statistics::median;
use afterbay_analysis::study::energy::{self, EnergyRow, EnergyRun};
use afterbay_analysis::study::global_order;
use afterbay_analysis::study::local_order::{LocalOrder, Trace};
use afterbay_core::{Quad, larger_or_nan};
use serde::Serialize;

pub(super) const PART: Part = Part {
    heading: "Errors and energies over time: figures 4.1 to 4.4",
    methods: &[&FOLLOWED, &COMPARED, &RAISED, &OF_GLOBAL_ERRORS],
    sheet,
};

/// The methods whose energies are recorded.
const FOLLOWED: [&str; 7] = [
    "moddg",
    "rk4",
    "leapfrog",
    "moddg-q3-shared",
    "moddg-q4-shared",
    "moddg-p3-shared",
    "moddg-p4-shared",
];
/// The three methods that the paper compares.
const COMPARED: [&str; 3] = ["moddg", "leapfrog", "rk4"];
/// The methods with three and with four terms of δ.
const RAISED: [&str; 2] = ["moddg-q3-shared", "moddg-q4-shared"];
const OF_GLOBAL_ERRORS: [&str; 5] = ["moddg", "leapfrog", "rk4", "moddg-q3-shared", "moddg-qp4"];

/// A row of `local_errors.csv`.
#[derive(Serialize)]
struct LocalErrorRow {
    method: &'static str,
    h: f64,
    t: f64,
    error_q: f64,
    error_p: f64,
    error_w: f64,
}

fn sheet(paper: &Paper<'_>, mut sheet: Sheet) -> Result<Sheet, ReportError> {
    sheet.text(format!(
        "The paper does not give the step of its figures over time. Here h = {FIGURE_STEP} is \
         used, from q₀ = 2.3, p₀ = -3.1 with b = 0.1, on [0, 20], and the base step h = \
         {BASE_STEP} for comparison.",
    ));
    let traces = local_errors(paper, &mut sheet)?;
    let runs = energy_balance(paper, &mut sheet)?;
    let fine = energy::run(
        &oscillator(),
        &paper.methods(&COMPARED)?,
        BASE_STEP,
        u64::MAX,
        paper.progress,
    )?;
    order_raised(&mut sheet, &traces, &runs);
    drift_of_k(&mut sheet, &runs, &fine);
    compared(&mut sheet, &traces);
    energy_ratio(&mut sheet, &runs);
    sheet.text(
        "The energies of each run: the drift of K, the errors of w and of R, and the number of \
         steps that took energy back.",
    );
    sheet.table(
        &["method", "max |K - K₀|", "max |w - w(t)|", "max |d_R|", "steps with Δw < 0"],
        runs.iter().map(summary).collect(),
    );
    global_orders(paper, &mut sheet)?;
    Ok(sheet)
}

/// Local errors along the solution, by method and step.
struct Traces(Vec<(&'static str, f64, Trace)>);

impl Traces {
    /// (t, |T|) of one variable.
    fn points(&self, name: &str, h: f64, column: usize) -> Vec<(f64, f64)> {
        let mut of = self.0.iter().filter(|(method, step, _)| *method == name && *step == h);
        let trace = of.next().map_or(&[][..], |(_, _, trace)| trace);
        let point = |(i, errors): (usize, &Option<[f64; 3]>)| {
            Some((i as f64 * BASE_STEP, (*errors)?[column]))
        };
        trace.iter().enumerate().filter_map(point).collect()
    }

    /// Median and maximum of |T| of q.
    fn of_q(&self, name: &str, h: f64) -> [Option<f64>; 2] {
        let mut sizes: Vec<f64> =
            self.points(name, h, 0).into_iter().map(|(_, error)| error).collect();
        let maximum = sizes.iter().copied().reduce(larger_or_nan);
        [maximum.is_some().then(|| median(&mut sizes)), maximum]
    }
}

fn local_errors(paper: &Paper<'_>, sheet: &mut Sheet) -> Result<Traces, ReportError> {
    let raised = paper.methods(&RAISED)?.into_iter().map(|row| (row, FIGURE_STEP));
    let compared = paper.methods(&COMPARED)?;
    let compared = compared.into_iter().flat_map(|row| [(row, FIGURE_STEP), (row, BASE_STEP)]);
    let shown: Vec<_> = raised.chain(compared).collect();
    paper.progress.begin("local errors over time", shown.len());
    let mut traces = Vec::new();
    for (row, h) in shown {
        let study = LocalOrder { base_step: BASE_STEP, steps: vec![h] };
        traces.push((row.name, h, study.trace::<Quad>(&oscillator(), row, h)?));
        paper.progress.advance();
    }
    let mut rows = Vec::new();
    for (method, h, trace) in &traces {
        for (i, errors) in trace.iter().enumerate().step_by(10) {
            let Some([error_q, error_p, error_w]) = *errors else { continue };
            let t = i as f64 * BASE_STEP;
            rows.push(LocalErrorRow { method, h: *h, t, error_q, error_p, error_w });
        }
    }
    sheet.data("local_errors", &rows)?;
    Ok(Traces(traces))
}

fn order_raised(sheet: &mut Sheet, traces: &Traces, runs: &[EnergyRun]) {
    let readings = RAISED.into_iter().fold(Readings::default(), |r, name| {
        let [median, maximum] = traces.of_q(name, FIGURE_STEP);
        r.and(name, "median", median).and(name, "maximum", maximum).and(
            name,
            "drift",
            drift(runs, name),
        )
    });
    sheet.find(
        "figure 4.1, \"errors remain of constant magnitude\"",
        readings,
        claims::order_raised,
    );
    let chart = over_time(
        "Figure 4.1: local error of q, δ₃(q) and δ₄(q)",
        Axis::log("local error |T| of q"),
        RAISED.map(|name| line(name, traces.points(name, FIGURE_STEP, 0))).into(),
    );
    sheet.show(
        "figure-4-1",
        &chart,
        "Local error of q along the solution with three and with four terms of δ(q), shared by all \
         three equations. δ(q) has its poles where p = 0.",
        "local_errors",
    );
}

fn compared(sheet: &mut Sheet, traces: &Traces) {
    let at = |h: f64| {
        COMPARED.into_iter().fold(Readings::default().and("step", "h", h), |r, name| {
            let [median, maximum] = traces.of_q(name, h);
            r.and(name, "median", median).and(name, "maximum", maximum)
        })
    };
    let topic = "figure 4.3, \"committing errors of order magnitude 10⁻⁷\"";
    sheet.find(topic, at(FIGURE_STEP), claims::errors_of_one_magnitude);
    sheet.find(
        &format!("{topic}, at the base step"),
        at(BASE_STEP),
        claims::errors_of_one_magnitude,
    );
    let chart = over_time(
        "Figure 4.3: local error of p",
        Axis::log("local error |T| of p"),
        COMPARED.map(|name| line(name, traces.points(name, FIGURE_STEP, 1))).into(),
    );
    sheet.show("figure-4-3", &chart, "Local error of p along the solution.", "local_errors");
}

fn energy_balance(paper: &Paper<'_>, sheet: &mut Sheet) -> Result<Vec<EnergyRun>, ReportError> {
    paper.progress.begin("energies", FOLLOWED.len() + COMPARED.len());
    let all =
        energy::run(&oscillator(), &paper.methods(&FOLLOWED)?, FIGURE_STEP, 1, paper.progress)?;
    sheet.runs.extend(all.iter().map(|run| {
        RunOutcome::of(&run.ending, "energy", oscillator().model.name(), run.method, FIGURE_STEP)
    }));
    let rows: Vec<&EnergyRow> = all.iter().flat_map(|run| &run.rows).collect();
    sheet.wide_data("energy", &energy::columns(&oscillator().model), &rows)?;
    Ok(all)
}

fn largest(run: &EnergyRun, value: impl Fn(&EnergyRow) -> Option<f64>) -> f64 {
    run.rows.iter().filter_map(value).map(f64::abs).fold(0.0, larger_or_nan)
}

fn summary(run: &EnergyRun) -> Vec<String> {
    vec![
        run.method.into(),
        scientific(Some(run.drift)),
        scientific(Some(largest(run, |row| Some(row.w_error)))),
        scientific(Some(largest(run, |row| row.ratio_error))),
        run.violations.map_or("not counted".into(), |count| count.to_string()),
    ]
}

fn of<'a>(runs: &'a [EnergyRun], name: &str) -> Option<&'a EnergyRun> {
    runs.iter().find(|run| run.method == name)
}

/// max |K - K₀| of a run that reached its end, relative to the energy at the start.
fn drift(runs: &[EnergyRun], name: &str) -> Option<f64> {
    let run = of(runs, name).filter(|run| run.ending.is_completed())?;
    Some(run.drift / run.rows.first()?.energy)
}

fn drift_of_k(sheet: &mut Sheet, runs: &[EnergyRun], fine: &[EnergyRun]) {
    let at = |h: f64, runs: &[EnergyRun]| {
        COMPARED.into_iter().fold(Readings::default().and("step", "h", h), |r, name| {
            r.and(name, "drift", drift(runs, name))
        })
    };
    let (as_shown, base) = (at(FIGURE_STEP, runs), at(BASE_STEP, fine));
    for (quotation, say) in [
        ("SV scheme underperforms", claims::underperforms as fn(&Readings) -> Said),
        ("modDG goes head to head with eRK4", claims::head_to_head),
    ] {
        let topic = format!("figure 4.2, \"{quotation}\"");
        sheet.find(&topic, as_shown.clone(), say);
        sheet.find(&format!("{topic}, at the base step"), base.clone(), say);
    }
    let simpler = runs.iter().filter(|run| run.method.ends_with("-shared"));
    let simpler = simpler
        .fold(Readings::default(), |r, one| r.and(one.method, "drift", drift(runs, one.method)));
    sheet.find(
        "figure 4.2, \"even when we substitute simpler expression for the δ function\"",
        simpler,
        claims::simpler_delta,
    );
    let curve = |name: &str| {
        let rows = of(runs, name).map_or(&[][..], |run| &run.rows);
        line(name, rows.iter().map(|row| (row.t, row.drift.abs())).collect())
    };
    let chart = over_time(
        "Figure 4.2: deviation of K from its initial value",
        Axis::log("|K - K₀|"),
        ["moddg", "rk4", "leapfrog", "moddg-q4-shared"].map(curve).into(),
    );
    sheet.show(
        "figure-4-2",
        &chart,
        "Deviation of K. Exact zeros cannot be shown on a logarithmic axis.",
        "energy",
    );
}

fn energy_ratio(sheet: &mut Sheet, runs: &[EnergyRun]) {
    let curve = |name: &str| {
        let rows = of(runs, name).map_or(&[][..], |run| &run.rows);
        line(name, rows.iter().filter_map(|row| Some((row.t, row.ratio_error?.abs()))).collect())
    };
    let readings = ["rk4", "moddg-p4-shared", "leapfrog", "moddg"].into_iter().fold(
        Readings::default(),
        |r, name| {
            let worst = of(runs, name).map(|run| largest(run, |row| row.ratio_error));
            r.and(name, "d_R", worst).and(name, "drift", drift(runs, name))
        },
    );
    sheet.find("figure 4.4", readings, claims::energy_ratio);
    let chart = over_time(
        "Figure 4.4: error of the energy ratio R",
        Axis::log("|d_R| = |R - R(exact)|"),
        ["rk4", "moddg-p4-shared", "leapfrog", "moddg"].map(curve).into(),
    );
    sheet.show(
        "figure-4-4",
        &chart,
        "Error of R = E(i+1)/E(i) of the fourth-order schemes, of pqpLF and of plain modDG.",
        "energy",
    );
}

fn global_orders(paper: &Paper<'_>, sheet: &mut Sheet) -> Result<(), ReportError> {
    let (rows, progress) = (paper.methods(&OF_GLOBAL_ERRORS)?, paper.progress);
    let steps = [0.2, 0.1, 0.05, 0.025, 0.0125, 0.00625];
    progress.begin("global errors", rows.len() * steps.len());
    let found = global_order::run(&oscillator(), &rows, &steps, progress)?;
    sheet.data("global_orders", &found)?;
    let points = |name: &str, variable: &str| {
        let of = found.iter().filter(|row| row.method == name && row.variable == variable);
        of.filter_map(|row| Some((row.h, row.error?))).collect::<Vec<_>>()
    };
    let last = |name: &str, variable: &str| {
        let mut of = found.iter().filter(|row| row.method == name && row.variable == variable);
        of.next_back().and_then(|row| row.order)
    };
    let cells = |name: &&'static str| {
        let mut cells = vec![(*name).to_string()];
        cells.extend(["q", "p", "w"].map(|variable| decimal(last(name, variable))));
        cells
    };
    let names: Vec<_> = rows.iter().map(|row| row.name).collect();
    sheet.text(
        "Global errors on [0, 20]: the largest over the run, and the order between the last two \
         steps.",
    );
    sheet.table(
        &["method", "order of q", "order of p", "order of w"],
        names.iter().map(cells).collect(),
    );
    let chart = |variable: &str| LineChart {
        title: format!("Global error of {variable}"),
        x: Axis::log("step h"),
        y: Axis::log(format!("largest error of {variable} on [0, 20]")),
        curves: names.iter().map(|name| marked(name, points(name, variable))).collect(),
        guides: vec![2.0, 4.0],
    };
    let left =
        sheet.figure("global-error-q", chart("q").draw(), "Global error of q.", "global_orders");
    let right =
        sheet.figure("global-error-w", chart("w").draw(), "Global error of w.", "global_orders");
    sheet.show_pair(left, right);
    Ok(())
}
