//! The energy books: H, K - K0, the ratio R = H_{i+1}/H_i, and what the reservoir is off by.

use super::{Problem, values};
use crate::progress::Progress;
use afterbay_core::{Grid, IntegrateError, Passive};
use afterbay_methods::registry::Row;
use rayon::prelude::*;
use serde::Serialize;
use std::ops::ControlFlow;

/// A row of `energy.csv`.
#[derive(Clone, Debug, Serialize)]
pub struct EnergyRow {
    /// Name of the method.
    pub method: &'static str,
    /// The step.
    pub h: f64,
    /// Time.
    pub t: f64,
    /// H(q, p)
    #[serde(rename = "H")]
    pub energy: f64,
    /// K - K0
    #[serde(rename = "K_minus_K0")]
    pub drift: f64,
    /// R = H/H one step before.
    #[serde(rename = "R")]
    pub ratio: Option<f64>,
    /// R less that of the exact solution.
    #[serde(rename = "d_R")]
    pub ratio_error: Option<f64>,
    /// w less the exact one.
    pub w_error: f64,
}

/// The books of one run.
#[derive(Clone, Debug)]
pub struct Books {
    /// Name of the method.
    pub method: &'static str,
    /// Every `every`-th state.
    pub rows: Vec<EnergyRow>,
    /// max |K - K0| over all steps.
    pub drift: f64,
    /// Steps with Δw < 0 where Δw ≥ 0 is owed; none where the system is active and owes nothing.
    pub violations: Option<u64>,
    /// How the run ended.
    pub result: Result<(), IntegrateError>,
}

/// Follows the books of each method with steps of size h, every `every`-th state recorded.
///
/// # Errors
/// Those of the input. A run that fails is in its books.
pub fn run(
    problem: &Problem,
    methods: &[&'static Row],
    h: f64,
    every: u64,
    progress: &dyn Progress,
) -> Result<Vec<Books>, IntegrateError> {
    let solution = problem.solution(h, Grid::<f64>::new(h, problem.end)?.steps as usize)?;
    methods
        .par_iter()
        .map(|row| {
            let books = follow(problem, row, h, every.max(1), &solution);
            progress.advance();
            books
        })
        .collect()
}

fn follow(
    problem: &Problem,
    row: &'static Row,
    h: f64,
    every: u64,
    solution: &[[f64; 3]],
) -> Result<Books, IntegrateError> {
    let subject = problem.model.subject::<f64>()?;
    let method = subject.bind(row)?;
    let mut state = problem.start()?;
    let total = state.total(&*subject);
    let exact_energy = |step: usize| subject.energy(&solution[step][..1], &solution[step][1..2]);
    let finite = |x: f64| x.is_finite().then_some(x);

    let mut rows = Vec::new();
    let (mut drift, mut violations) = (0.0_f64, 0);
    let (mut energy_before, mut w_before) = (None, state.w[0]);
    let result = method.run(Grid::new(h, problem.end)?, &mut state, 1, &mut |step, state| {
        let energy = state.energy(&*subject);
        let off = state.total(&*subject) - total;
        drift = drift.max(off.abs());
        violations += u64::from(state.w[0] < w_before);
        if step % every == 0 {
            let i = step as usize;
            let ratio = energy_before.and_then(|before| finite(energy / before));
            let exact = i.checked_sub(1).and_then(|before| finite(exact_energy(i) / exact_energy(before)));
            rows.push(EnergyRow {
                method: row.name,
                h,
                t: state.t,
                energy,
                drift: off,
                ratio,
                ratio_error: ratio.zip(exact).map(|(ratio, exact)| ratio - exact),
                w_error: values(state)[2] - solution[i][2],
            });
        }
        (energy_before, w_before) = (Some(energy), state.w[0]);
        ControlFlow::Continue(())
    });
    let violations = (subject.damping().passive != Passive::No).then_some(violations);
    Ok(Books { method: row.name, rows, drift, violations, result: result.map(|_| ()) })
}
