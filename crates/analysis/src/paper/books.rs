//! Figures 4.1 to 4.4: local errors over time, the drift of K, the energy ratio; and the global orders behind them.

use super::{BASE_STEP, FIGURE_STEP, methods, oscillator};
use crate::chart::{Axis, LineChart};
use crate::progress::Progress;
use crate::report::Verdict;
use crate::sheet::{ReportError, Sheet, decimal, line, marked, over_time, scientific};
use crate::statistics::median;
use crate::study::energy::{self, Books, EnergyRow};
use crate::study::global_order;
use crate::study::local_order::{LocalOrder, Trace};
use afterbay_core::Quad;
use serde::Serialize;

/// The methods whose books are kept.
const KEPT: [&str; 7] =
    ["moddg", "rk4", "leapfrog", "moddg-q3-shared", "moddg-q4-shared", "moddg-p3-shared", "moddg-p4-shared"];

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

pub(super) fn sheet(progress: &dyn Progress) -> Result<Sheet, ReportError> {
    let mut sheet = Sheet::new("Errors and books over time: figures 4.1 to 4.4");
    sheet.text(format!(
        "The paper does not say at which step its figures over time were made; h = {FIGURE_STEP} is taken here, from \
         q₀ = 2.3, p₀ = -3.1 with b = 0.1, on [0, 20].",
    ));
    let traces = local_errors(&mut sheet, progress)?;
    let books = energy_books(&mut sheet, progress)?;
    order_raised(&mut sheet, &traces);
    drift_of_k(&mut sheet, &books);
    compared(&mut sheet, &traces);
    energy_ratio(&mut sheet, &books);
    sheet.text(
        "The books of each run: three figures that are not to be mixed, and the steps that took energy back.",
    );
    sheet.table(
        &["method", "max |K - K₀|", "max |w - w(t)|", "max |d_R|", "steps with Δw < 0"],
        books.iter().map(summary).collect(),
    );
    global_orders(&mut sheet, progress)?;
    Ok(sheet)
}

/// Local errors along the solution, by method.
struct Traces(Vec<(&'static str, Trace)>);

impl Traces {
    /// (t, |T|) of one variable.
    fn points(&self, name: &str, column: usize) -> Vec<(f64, f64)> {
        let trace = self.0.iter().find(|(method, _)| *method == name).map_or(&[][..], |(_, trace)| trace);
        let point =
            |(i, errors): (usize, &Option<[f64; 3]>)| Some((i as f64 * BASE_STEP, (*errors)?[column]));
        trace.iter().enumerate().filter_map(point).collect()
    }

    fn median(&self, name: &str, column: usize) -> f64 {
        median(&mut self.points(name, column).into_iter().map(|(_, error)| error).collect::<Vec<_>>())
    }
}

fn local_errors(sheet: &mut Sheet, progress: &dyn Progress) -> Result<Traces, ReportError> {
    let study = LocalOrder { base_step: BASE_STEP, steps: vec![FIGURE_STEP] };
    let shown = methods(&["moddg-q3-shared", "moddg-q4-shared", "moddg", "leapfrog", "rk4"]);
    progress.begin("local errors over time", shown.len());
    let mut traces = Vec::new();
    for row in shown {
        traces.push((row.name, study.trace::<Quad>(&oscillator(), row, FIGURE_STEP)?));
        progress.advance();
    }
    let mut rows = Vec::new();
    for (method, trace) in &traces {
        for (i, errors) in trace.iter().enumerate().step_by(10) {
            let Some([error_q, error_p, error_w]) = *errors else { continue };
            rows.push(LocalErrorRow {
                method,
                h: FIGURE_STEP,
                t: i as f64 * BASE_STEP,
                error_q,
                error_p,
                error_w,
            });
        }
    }
    sheet.data("local_errors", &rows)?;
    Ok(Traces(traces))
}

fn order_raised(sheet: &mut Sheet, traces: &Traces) {
    let ratio = traces.median("moddg-q4-shared", 0) / traces.median("moddg-q3-shared", 0);
    // Of one magnitude: nearer to 1 than to 10 or a tenth.
    let verdict = if ratio.log10().abs() < 0.5 { Verdict::Holds } else { Verdict::Fails };
    sheet.find("figure 4.1", verdict, format!(
        "\"errors remain of constant magnitude\" from δ₃ to δ₄: the median local error of q with δ₄(q) is {ratio:.2} times \
         that with δ₃(q). With one δ in all equations the error of p, of order 2, is what is left in q at order 3.",
    ));
    let chart = over_time(
        "Figure 4.1: local error of q, δ₃(q) and δ₄(q)",
        Axis::log("local error |T| of q"),
        ["moddg-q3-shared", "moddg-q4-shared"].map(|name| line(name, traces.points(name, 0))).into(),
    );
    sheet.show(
        "figure-4-1",
        &chart,
        "Local error of q along the solution with three and with four terms of δ(q), shared by all three equations. The \
         peaks are the poles p = 0.",
        "local_errors",
    );
}

fn compared(sheet: &mut Sheet, traces: &Traces) {
    let shown = ["moddg", "leapfrog", "rk4"];
    let medians = shown.map(|name| FIGURE_STEP * traces.median(name, 0));
    let comparable = medians[0] / medians[1];
    let magnitude = |x: f64| (1e-8..1e-6).contains(&x);
    let holds = (0.1..10.0).contains(&comparable) && magnitude(medians[0]) && magnitude(medians[1]);
    sheet.find("figure 4.3", if holds { Verdict::Holds } else { Verdict::Fails }, format!(
        "\"for q our scheme and SV are both committing errors of order 1e-7\": the error of one step, h |T|, has the median \
         {:.1e} with moddg, {:.1e} with leapfrog and {:.1e} with rk4. (The local error of section 2 is 1/h = {} times that.)",
        medians[0], medians[1], medians[2], 1.0 / FIGURE_STEP
    ));
    let chart = over_time(
        "Figure 4.3: local error of p",
        Axis::log("local error |T| of p"),
        shown.map(|name| line(name, traces.points(name, 1))).into(),
    );
    sheet.show("figure-4-3", &chart, "Local error of p along the solution.", "local_errors");
}

fn energy_books(sheet: &mut Sheet, progress: &dyn Progress) -> Result<Vec<Books>, ReportError> {
    progress.begin("energy books", KEPT.len());
    let all = energy::run(&oscillator(), &methods(&KEPT), FIGURE_STEP, 1, progress)?;
    sheet
        .runs
        .extend(all.iter().map(|books| {
            books.ending.record("energy", oscillator().model.name(), books.method, FIGURE_STEP)
        }));
    let rows: Vec<&EnergyRow> = all.iter().flat_map(|books| &books.rows).collect();
    sheet.wide_data("energy", &energy::columns(1), &rows)?;
    Ok(all)
}

fn largest(books: &Books, value: impl Fn(&EnergyRow) -> Option<f64>) -> f64 {
    books.rows.iter().filter_map(value).map(f64::abs).fold(0.0, f64::max)
}

fn summary(books: &Books) -> Vec<String> {
    vec![
        books.method.into(),
        scientific(Some(books.drift)),
        scientific(Some(largest(books, |row| Some(row.w_error)))),
        scientific(Some(largest(books, |row| row.ratio_error))),
        books.violations.map_or("none owed".into(), |count| count.to_string()),
    ]
}

fn of<'a>(books: &'a [Books], name: &str) -> Option<&'a Books> {
    books.iter().find(|books| books.method == name)
}

fn drift_of_k(sheet: &mut Sheet, books: &[Books]) {
    let drift = |name: &str| of(books, name).map_or(f64::NAN, |books| books.drift);
    let (moddg, rk4, leapfrog) = (drift("moddg"), drift("rk4"), drift("leapfrog"));
    let holds = leapfrog > 1e3 * moddg && leapfrog > 1e3 * rk4;
    sheet.find(
        "figure 4.2, \"SV underperforms\"",
        if holds { Verdict::Holds } else { Verdict::Fails },
        format!(
            "max |K - K₀| is {moddg:.1e} with moddg, {rk4:.1e} with rk4 and {leapfrog:.1e} with leapfrog."
        ),
    );
    let level = rk4 <= 10.0 * moddg;
    sheet.find("figure 4.2, \"modDG goes head to head with eRK4\"", if level { Verdict::Holds } else { Verdict::Fails }, format!(
        "on the scale of the leap-frog's drift the two look alike, but rk4 drifts {:.0} times as far as moddg at \
         h = {FIGURE_STEP}: moddg is at rounding at every step, rk4 only as its order 4 allows.",
        rk4 / moddg
    ));
    let shared: Vec<_> = books.iter().filter(|books| books.method.ends_with("-shared")).collect();
    let simple = shared.iter().map(|books| books.drift).fold(0.0, f64::max);
    let all = shared.iter().all(|books| books.ending.is_completed());
    sheet.find(
        "figure 4.2, \"even with a simpler δ\"",
        if all && simple < 1e-12 { Verdict::Holds } else { Verdict::Fails },
        format!("with a shared δ, whichever, K stays at rounding: {simple:.1e} at most."),
    );
    let curve = |name: &str| {
        let rows = of(books, name).map_or(&[][..], |books| &books.rows);
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
        "Deviation of K. Steps at which K is exact to the last bit have no place on a logarithmic axis.",
        "energy",
    );
}

fn energy_ratio(sheet: &mut Sheet, books: &[Books]) {
    let curve = |name: &str| {
        let rows = of(books, name).map_or(&[][..], |books| &books.rows);
        line(name, rows.iter().filter_map(|row| Some((row.t, row.ratio_error?.abs()))).collect())
    };
    let worst = |name: &str| of(books, name).map_or(f64::NAN, |books| largest(books, |row| row.ratio_error));
    let (rk4, fourth, plain, leapfrog) =
        (worst("rk4"), worst("moddg-p4-shared"), worst("moddg"), worst("leapfrog"));
    sheet.find("figure 4.4", Verdict::Note, format!(
        "max |d_R| is {rk4:.1e} with rk4, {fourth:.1e} with moddg-p4-shared, {leapfrog:.1e} with leapfrog and {plain:.1e} \
         with plain moddg: keeping K exactly does not by itself make the energy ratio accurate.",
    ));
    let chart = over_time(
        "Figure 4.4: error of the energy ratio R",
        Axis::log("|d_R| = |R - R(exact)|"),
        ["rk4", "moddg-p4-shared", "leapfrog", "moddg"].map(curve).into(),
    );
    sheet.show(
        "figure-4-4",
        &chart,
        "Error of R = E(i+1)/E(i) of the fourth-order schemes and of pqpLF, with plain modDG beside them.",
        "energy",
    );
}

fn global_orders(sheet: &mut Sheet, progress: &dyn Progress) -> Result<(), ReportError> {
    let rows = methods(&["moddg", "leapfrog", "rk4", "moddg-q3-shared", "moddg-qp4"]);
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
        "Global errors on [0, 20]: the largest over the run, and the order between the last two steps.",
    );
    sheet.table(&["method", "order of q", "order of p", "order of w"], names.iter().map(cells).collect());
    let chart = |variable: &str| LineChart {
        title: format!("Global error of {variable}"),
        x: Axis::log("step h"),
        y: Axis::log(format!("largest error of {variable} on [0, 20]")),
        curves: names.iter().map(|name| marked(name, points(name, variable))).collect(),
        guides: vec![2.0, 4.0],
    };
    let left = sheet.figure("global-error-q", chart("q").svg(), "Global error of q.", "global_orders");
    let right = sheet.figure("global-error-w", chart("w").svg(), "Global error of w.", "global_orders");
    sheet.show_pair(left, right);
    Ok(())
}
