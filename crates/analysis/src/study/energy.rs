//! The energy balance: H, K - K0, the ratio R = H_{i+1}/H_i, and the error of the reservoir.

use super::cell::{Cell, Study, compute_all, reference_bytes};
use super::outcome::Ending;
use super::passivity::Passivity;
use super::{PUMPED, Problem, numbered};
use crate::progress::{Piece, Progress};
use crate::words::{Word, word};
use crate::{Measured, Model, Solution};
use afterbay_core::{Accounts, Grid, IntegrateError, StateRef, System, accounts};
use afterbay_methods::registry::Row;
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;

/// A row of `energy.csv`, under the [`columns`].
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct EnergyRow {
    /// Name of the method.
    #[serde(deserialize_with = "word")]
    pub method: Word,
    /// The step.
    pub h: f64,
    /// Time.
    pub t: f64,
    /// H(q, p)
    pub energy: f64,
    /// K - K0
    pub drift: f64,
    /// R, the energy divided by that of the step before.
    pub ratio: Option<f64>,
    /// R minus that of the reference.
    pub ratio_error: Option<f64>,
    /// w minus that of the reference, in the degree of freedom where the difference is largest.
    pub w_error: f64,
    /// The doubt of w in the reference.
    pub doubt_w: f64,
    /// The doubt of R in the reference.
    pub doubt_ratio: Option<f64>,
    /// The reservoir.
    pub w: Vec<f64>,
    /// The energy supplied by a drive; empty without one.
    pub s: Vec<f64>,
    /// Σ s, where there is a drive.
    pub supplied: Vec<f64>,
    /// The energy s_t pumped by V(q, t); empty where V and D do not depend on t.
    pub pumped: Vec<f64>,
}

impl EnergyRow {
    /// |w_error| with its doubt.
    pub(crate) fn measured_w(&self) -> Measured {
        Measured { error: self.w_error.abs(), doubt: self.doubt_w }
    }

    /// |d_R| with its doubt.
    pub(crate) fn measured_ratio(&self) -> Option<Measured> {
        let (error, doubt) = self.ratio_error.zip(self.doubt_ratio)?;
        Some(Measured { error: error.abs(), doubt })
    }
}

/// The names of the columns: `method,h,t,H,K_minus_K0,R,d_R,w_error,doubt_w,doubt_d_R,w1..wN`, and
/// `s1..sN,supplied` where there is a drive, and `st` where V or D depends on t.
pub fn columns(model: &Model) -> Vec<String> {
    let names =
        ["method", "h", "t", "H", "K_minus_K0", "R", "d_R", "w_error", "doubt_w", "doubt_d_R"];
    let accounts = model.variables()[2..].iter().flat_map(|name| numbered(name, model.degrees()));
    let pumped = model.has_clock().then(|| PUMPED.to_owned());
    let supplied = (!model.driven().is_empty()).then(|| "supplied".to_owned());
    names.into_iter().map(String::from).chain(accounts).chain(supplied).chain(pumped).collect()
}

/// The energy balance of one run.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct EnergyRun {
    /// Name of the method.
    #[serde(deserialize_with = "word")]
    pub method: Word,
    /// Every `every`-th state.
    pub rows: Vec<EnergyRow>,
    /// max |K - K0| over all steps.
    pub drift: f64,
    /// Steps that violate passivity; none where the system is not known to be passive.
    pub violations: Option<u64>,
    /// The outcome of the run.
    pub ending: Ending,
}

/// Computes the energy balance of each method with steps of size h, and records every `every`-th
/// state.
///
/// # Errors
/// Invalid input. A run that fails contains its failure.
pub fn run(
    problem: &Problem,
    methods: &[&'static Row],
    h: f64,
    every: u64,
    progress: &dyn Progress,
) -> Result<Vec<EnergyRun>, IntegrateError> {
    compute_all(&Energy { problem, methods, h, every: every.max(1) }, progress)
}

/// A study of the energy balance: a run of each method.
pub struct Energy<'a> {
    /// The system, the initial state and the end of time.
    pub problem: &'a Problem,
    /// The methods.
    pub methods: &'a [&'static Row],
    /// The step.
    pub h: f64,
    /// The steps between two states that are recorded, at least 1.
    pub every: u64,
}

impl Study for Energy<'_> {
    type Shared = Solution<f64>;
    type Part = EnergyRun;
    type Error = IntegrateError;

    fn cells(&self) -> Vec<Cell> {
        let cost = self.problem.model.degrees() as f64 * self.problem.end / self.h;
        self.methods.iter().map(|row| Cell::new(row.name.to_owned(), cost)).collect()
    }

    fn shared_bytes(&self) -> f64 {
        reference_bytes(self.problem.model.degrees(), self.problem.end / self.h)
    }

    fn share(&self, progress: &dyn Progress) -> Result<Self::Shared, IntegrateError> {
        let steps = Grid::<f64>::new(self.h, self.problem.end)?.steps as usize;
        self.problem.solution(self.h, steps, progress)
    }

    fn compute(
        &self,
        solution: &Self::Shared,
        index: usize,
        progress: &dyn Progress,
    ) -> Result<EnergyRun, IntegrateError> {
        let Self { problem, methods, h, every } = *self;
        let run = follow(problem, methods[index], h, every, solution, progress);
        progress.advance();
        run
    }
}

fn follow(
    problem: &Problem,
    row: &'static Row,
    h: f64,
    every: u64,
    solution: &Solution<f64>,
    progress: &dyn Progress,
) -> Result<EnergyRun, IntegrateError> {
    let system = problem.model.system::<f64>()?;
    let method = problem.model.bind(row)?;
    let mut state = problem.start()?;
    let total = state.total(&*system);
    let (n, motors) = (problem.model.degrees(), problem.model.motors());
    let exact_energy = |step: usize| exact_energy(&*system, solution, step, n);
    let finite = |x: f64| x.is_finite().then_some(x);

    let mut rows = Vec::new();
    let grid = Grid::<f64>::new(h, problem.end)?;
    let (mut drift, mut energy_before, mut done) = (0.0_f64, None, 0);
    let mut piece = Piece::new(progress);
    let mut passivity = Passivity::new(&problem.model, state.state_ref())?;
    let result = method.run(grid, &mut state, 1, &mut |step, state| {
        done = step;
        piece.reach(step, grid.steps);
        let energy = energy_of(&*system, state, n);
        let off = state.total(&*system) - total;
        drift = drift.max(off.abs());
        let Accounts { w, s, pumped } = accounts(state, &motors);
        passivity.see(state);
        if step % every == 0 {
            let i = step as usize;
            let ratio = energy_before.and_then(|before| finite(energy / before));
            let of_reference =
                i.checked_sub(1).map(|before| [exact_energy(before), exact_energy(i)]);
            let exact = of_reference.and_then(|[before, now]| finite(now.error / before.error));
            // The relative doubts of the two energies add up.
            let doubt_ratio = of_reference.and_then(|energies| {
                let relative = energies.map(|energy| energy.doubt / energy.error.abs());
                finite((exact? * (relative[0] + relative[1])).abs())
            });
            rows.push(EnergyRow {
                method: row.name,
                h,
                t: state.t,
                energy,
                drift: off,
                ratio,
                ratio_error: ratio.zip(exact).map(|(ratio, exact)| ratio - exact),
                w_error: largest_difference(&w, &accounts(solution.at(i), &motors).w),
                doubt_w: solution.doubt_at(i).w,
                doubt_ratio,
                supplied: if s.is_empty() { Vec::new() } else { vec![s.iter().sum()] },
                pumped: pumped.into_iter().collect(),
                w,
                s,
            });
        }
        energy_before = Some(energy);
        if progress.stopped() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    let violations = passivity.violations();
    let ending = Ending::of(&result, grid.steps, done);
    Ok(EnergyRun { method: row.name, rows, drift, violations, ending })
}

/// H, without the momenta of the motors behind n degrees of freedom.
fn energy_of(system: &dyn System<f64>, state: StateRef<'_, f64>, n: usize) -> f64 {
    state.energy(system) - state.p[n..].iter().sum::<f64>()
}

/// H of the reference. Its doubt is |∇H| times the doubt of q and p.
fn exact_energy(
    system: &dyn System<f64>,
    solution: &Solution<f64>,
    i: usize,
    n: usize,
) -> Measured {
    let state = solution.at(i);
    let [mut hq, mut hp] = [(); 2].map(|()| vec![0.0; state.q.len()]);
    system.gradient(state.q, state.p, &mut hq, &mut hp);
    let slope: f64 = hq.iter().chain(&hp).map(|x: &f64| x.abs()).sum();
    Measured { error: energy_of(system, state, n), doubt: slope * solution.doubt_at(i).qp }
}

/// The difference of largest magnitude, with its sign.
fn largest_difference(found: &[f64], exact: &[f64]) -> f64 {
    let differences = found.iter().zip(exact).map(|(found, exact)| found - exact);
    differences.reduce(|most, x| if x.abs() > most.abs() { x } else { most }).unwrap_or(0.0)
}
