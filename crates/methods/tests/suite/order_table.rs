//! The order table: the global order of every row of the registry in q, p and w, in 31 digits, on
//! nonlinear damped problems.
//!
//! `cargo test -p afterbay-methods --test suite order_table -- --nocapture` prints the table.

use crate::catalog::{As, Built, chain, duffing, oscillator, pendulum, van_der_pol};
use crate::many::{exact_end, start};
use crate::slope::slope;
use afterbay_core::{Abilities, Grid, Quad, Scalar, State};
use afterbay_methods::registry::{FIXED, Needs, Order, Row, Run};
use rayon::prelude::*;
use std::ops::ControlFlow;
use std::sync::Arc;

/// The largest difference between a slope and the order.
const TOLERANCE: f64 = 0.05;
/// The 0.975 quantile of Student's t with three degrees of freedom: five points, two parameters.
const STUDENT: f64 = 3.182_446_305_284_263;
/// The largest |K - K0| / |K0| along a run of a method that conserves K, and the largest error of
/// an exact method: 1.2e-32 per step, in up to 2048 steps.
const KEPT: f64 = 5e-30;
/// Errors exceed the rounding of 31 digits, and from order 8 on they are below that of `f64`.
const SEEN: [f64; 2] = [1e-28, 1.1e-16];

/// Five numbers of steps, large enough for the next error term to be negligible.
fn counts(order: u32) -> [u64; 5] {
    match order {
        0..4 => [32, 40, 48, 64, 80],
        4..6 => [32, 48, 64, 96, 128],
        6..8 => [24, 32, 40, 48, 64],
        8 => [64, 68, 72, 80, 88],
        9 => [24, 26, 28, 30, 34],
        10..12 => [24, 28, 32, 40, 48],
        12..14 => [16, 20, 24, 28, 32],
        14..16 => [14, 16, 20, 24, 28],
        _ => [13, 14, 15, 16, 18],
    }
}

/// The factor by which the numbers of steps are multiplied. If a step is not its own adjoint, the
/// next error term is only one power of h smaller, instead of two, and shorter steps are needed to
/// see the order. This concerns explicit methods, δ at the start of a step, and single sweeps.
/// Relaxed methods from order 8 on take longer steps than other explicit ones: on shorter ones
/// roundings of K decide γ.
fn finer(row: &Row) -> u64 {
    match row.needs {
        Needs::Any if row.keeps_k && row.order() >= Order::Of(8) => 6,
        Needs::Any => 8,
        _ if !row.poles().is_empty() || row.order() == Order::Of(1) => 8,
        _ => 1,
    }
}

/// The global orders that follow from the local ones: the errors of q and p affect each other and
/// w, but the error of w affects neither.
fn orders(row: &Row) -> [Order; 3] {
    let [q, p, w] = row.local_order;
    [q.min(p), q.min(p), q.min(p).min(w)]
}

/// A system, its initial state, and its solution at the end.
struct Problem {
    name: &'static str,
    end: f64,
    /// The factor by which its numbers of steps are multiplied.
    finer: u64,
    start: State<Vec<Quad>>,
    exact: State<Vec<Quad>>,
    listed: Built,
    form: As,
    system: Arc<dyn Abilities<Quad>>,
}

impl Problem {
    fn new(
        name: &'static str,
        (listed, form): (Built, As),
        from: [&[f64]; 2],
        (end, finer): (f64, u64),
    ) -> Self {
        let start = start(from);
        let exact = exact_end(&*listed.series(), &start, end);
        let system = listed.abilities();
        Self { name, end, finer, start, exact, listed, form, system }
    }

    /// The errors of q, p and w at the end (Euclidean norms), and the largest drift of K along the
    /// run.
    fn run(&self, run: &Run<Quad>, steps: u64) -> ([f64; 3], f64) {
        let mut state = self.start.clone();
        let before = self.system.energy(&state.q, &state.p);
        let mut drift = 0.0_f64;
        let h = Quad::from_f64(self.end) / Quad::from_f64(steps as f64);
        run.run(Grid { h, steps }, &mut state, 1, &mut |_, now| {
            let total = now.w.iter().fold(self.system.energy(now.q, now.p), |sum, &w| sum + w);
            drift = drift.max(((total - before) / before).abs().to_f64());
            ControlFlow::Continue(())
        })
        .unwrap();
        let far = |a: &[Quad], b: &[Quad]| {
            a.iter().zip(b).map(|(&a, &b)| (a - b).to_f64().powi(2)).sum::<f64>().sqrt()
        };
        let Self { exact, .. } = self;
        ([far(&state.q, &exact.q), far(&state.p, &exact.p), far(&state.w, &exact.w)], drift)
    }

    /// A line of the table, and the errors found in it.
    fn line(&self, row: &Row) -> (String, Vec<String>) {
        let run = self.listed.bind(row, self.form).unwrap();
        let counts = counts(row.order().number().unwrap_or(u32::MAX))
            .map(|count| count * self.finer * finer(row));
        let runs = counts.map(|count| self.run(&run, count));
        let drift = runs.iter().fold(0.0, |most: f64, run| most.max(run.1));
        let (mut line, mut wrong) = (format!("{:24} {:10}", row.name, self.name), Vec::new());
        for (part, (variable, order)) in ["q", "p", "w"].into_iter().zip(orders(row)).enumerate() {
            let errors = runs.map(|(errors, _)| errors[part]);
            let (least, most) =
                errors.iter().fold((f64::MAX, 0.0_f64), |(a, b), &e| (a.min(e), b.max(e)));
            let Some(order) = order.number() else {
                line += &format!(" {:>14}", order.to_string());
                if most > KEPT {
                    wrong.push(format!("{} {variable}: off by {most:e}", row.name));
                }
                continue;
            };
            let (found, interval) = fit(&counts.map(|count| self.end / count as f64), &errors);
            line += &format!(" {found:6.3} ± {interval:.3}");
            let within = (found - f64::from(order)).abs() < TOLERANCE;
            if !within || least < SEEN[0] || (order >= 8 && most > SEEN[1]) {
                wrong.push(format!(
                    "{} {} {variable}: {found:.3} of {order}, {errors:?}",
                    row.name, self.name
                ));
            }
        }
        let [q, p, w] = runs[4].0;
        line += &format!("   {q:7.1e} {p:7.1e} {w:7.1e}   {drift:7.1e}");
        if row.keeps_k && drift > KEPT {
            wrong.push(format!("{} {}: K is off by {drift:e}", row.name, self.name));
        }
        (line, wrong)
    }
}

/// The slope of log(error) against log(h) by least squares, and the half-width of its 95 %
/// confidence interval.
fn fit(steps: &[f64; 5], errors: &[f64; 5]) -> (f64, f64) {
    let found = slope(steps, errors);
    let mean = |values: [f64; 5]| values.iter().sum::<f64>() / 5.0;
    let (x, y) = (steps.map(f64::ln), errors.map(f64::ln));
    let (middle, height) = (mean(x), mean(y));
    let left = |(x, y): (&f64, &f64)| (y - height - found * (x - middle)).powi(2);
    let spread = x.iter().map(|x| (x - middle).powi(2)).sum::<f64>();
    let rest = x.iter().zip(&y).map(left).sum::<f64>();
    (found, STUDENT * (rest / 3.0 / spread).sqrt())
}

/// The problems on which a row is measured: several degrees of freedom, one problem not separable,
/// if the method applies to these. Those with one degree of freedom end before p or V' + D
/// vanishes, where δ has its poles. On the chain the lag of `relaxed-verner98` is negligible only
/// on steps whose errors are below 31 digits; `relaxed.rs` measures its order on a ring.
fn problems(row: &Row) -> &'static [usize] {
    match row.needs {
        _ if row.order() == Order::Of(9) => &[1],
        Needs::Any | Needs::Curvature | Needs::SeparableOrPlanes => &[0, 1],
        Needs::Separable => &[0],
        Needs::OneDegree => &[2, 3],
        Needs::Printed => &[4],
        Needs::Linear => &[5],
    }
}

fn all() -> [Problem; 6] {
    let three: [&[f64]; 2] = [&[0.5, -0.3, 0.8], &[0.2, 0.7, -0.4]];
    let two: [&[f64]; 2] = [&[0.6, -0.4], &[0.3, 0.5]];
    let up: [&[f64]; 2] = [&[0.8], &[1.6]];
    let swing = pendulum([1.0, 0.75], [1.0, 0.5], 1.0, [0.125, 0.25]);
    [
        Problem::new("chain", (chain(3, 1.0, 0.25), As::Separable), three, (1.0, 1)),
        // The pendulum's sines vary faster than the forces of the chain.
        Problem::new("pendulum", (swing, As::General), two, (1.0, 2)),
        Problem::new("duffing", (duffing(1.0, 1.0, 0.3), As::Nonlinear), up, (0.375, 1)),
        Problem::new("vanderpol", (van_der_pol(0.5), As::Nonlinear), up, (0.375, 1)),
        Problem::new("oscillator", (oscillator(1.25, 0.375), As::Linear), up, (0.375, 1)),
        Problem::new("linear", (chain(3, 0.0, 0.25), As::Separable), three, (1.0, 1)),
    ]
}

#[test]
fn every_row_has_its_order_in_q_p_and_w() {
    let all = all();
    let cases: Vec<(&Row, &Problem)> = FIXED
        .iter()
        .flat_map(|row| problems(row).iter().map(|&i| (row, &all[i])).collect::<Vec<_>>())
        .collect();
    let lines: Vec<_> = cases.par_iter().map(|(row, problem)| problem.line(row)).collect();
    println!(
        "{:24} {:10} {:>14} {:>14} {:>14}   {:>23}   {:>7}",
        "method", "problem", "q ± 95 %", "p", "w", "least errors of q, p, w", "|ΔK|/K"
    );
    lines.iter().for_each(|(line, _)| println!("{line}"));
    let wrong: Vec<String> = lines.into_iter().flat_map(|(_, wrong)| wrong).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
