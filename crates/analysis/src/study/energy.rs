//! The energy balance: H, K - K0, the ratio R = H_{i+1}/H_i, and the error of the reservoir.

use super::cell::{Cell, Study, compute_all, reference_bytes};
use super::outcome::Ending;
use super::watch::Watch;
use super::{PUMPED, Problem, numbered};
use crate::finite_or_none;
use crate::progress::{Piece, Progress};
use crate::solution::accounts;
use crate::words::{Word, word};
use crate::{Doubt, Measured, Model, Solution};
use afterbay_core::{Accounts, Grid, IntegrateError, Motors, StateRef, System};
use afterbay_methods::registry::Row;
use serde::{Deserialize, Serialize};

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
    /// H(q, p); not finite, and an empty cell, where its terms overflow.
    #[serde(with = "finite_or_none")]
    pub energy: f64,
    /// K - K0, as H.
    #[serde(with = "finite_or_none")]
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
    pub fn measured_w(&self) -> Measured {
        Measured { error: self.w_error.abs(), doubt: self.doubt_w }
    }

    /// |d_R| with its doubt.
    pub fn measured_ratio(&self) -> Option<Measured> {
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
    /// Every `every`-th state, and the last.
    pub rows: Vec<EnergyRow>,
    /// The number of steps done.
    pub steps: u64,
    /// max |K - K0| over all steps.
    pub drift: f64,
    /// The largest error of w over all steps.
    pub w: Measured,
    /// Steps that violate passivity; none where the system is not known to be passive.
    pub violations: Option<u64>,
    /// The outcome of the run.
    pub ending: Ending,
}

/// Computes the energy balance of each method with steps of size h, and records every `every`-th
/// state and the last.
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
    compute_all(&Energy { problem, methods, h, every }, progress)
}

/// A study of the energy balance: a run of each method.
pub struct Energy<'a> {
    /// The system, the initial state and the end of time.
    pub problem: &'a Problem,
    /// The methods.
    pub methods: &'a [&'static Row],
    /// The step.
    pub h: f64,
    /// The steps between two states that are recorded. 0 counts as 1.
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
        let run = follow(self, self.methods[index], solution, progress);
        progress.advance();
        run
    }
}

/// A run of a method, compared with the reference.
fn follow(
    Energy { problem, h, every, .. }: &Energy<'_>,
    row: &'static Row,
    solution: &Solution<f64>,
    progress: &dyn Progress,
) -> Result<EnergyRun, IntegrateError> {
    let (system, method) = (problem.model.system::<f64>()?, problem.model.bind(row)?);
    let mut state = problem.start()?;
    let (n, motors) = (problem.model.degrees(), problem.model.motors());
    let reference = Reference { system: &*system, solution, n, motors: &motors };
    let (grid, every) = (Grid::<f64>::new(*h, problem.end)?, (*every).max(1));
    let mut watch = Watch::new(&*system, &problem.model, state.state_ref())?;
    let (mut rows, mut largest, mut energy_before) = (Vec::new(), Measured::default(), None);
    let mut piece = Piece::new(progress);
    let result = method.run(grid, &mut state, 1, &mut |step, state| {
        piece.report(step, grid.steps);
        let energy = energy_of(&*system, state, n);
        let drift = watch.see(step, state);
        let found = accounts(state, &motors);
        let w_error = reference.error_of_w(&found.w, step as usize);
        let doubt = solution.doubt_at(step as usize).w;
        largest = largest.larger(Measured { error: w_error.abs(), doubt });
        if step % every == 0 || step == grid.steps {
            let ratio = energy_before.and_then(|before| finite(energy / before));
            let own = Own { method: row.name, h: *h, t: state.t, energy, drift, ratio };
            rows.push(reference.compare(own, found, w_error, step as usize));
        }
        energy_before = Some(energy);
        progress.flow()
    });
    let ending = Ending::of(&result, grid.steps, watch.steps);
    let (drift, violations) = (watch.drift, watch.violations());
    let steps = watch.steps;
    Ok(EnergyRun { method: row.name, rows, steps, drift, w: largest, violations, ending })
}

fn finite(x: f64) -> Option<f64> {
    x.is_finite().then_some(x)
}

/// The values of a state of a run that need no reference.
struct Own {
    method: Word,
    h: f64,
    t: f64,
    energy: f64,
    drift: f64,
    ratio: Option<f64>,
}

/// The solution that runs are compared with.
struct Reference<'a> {
    system: &'a dyn System<f64>,
    solution: &'a Solution<f64>,
    /// The number of degrees of freedom that are not motors.
    n: usize,
    motors: &'a Motors,
}

impl Reference<'_> {
    /// The error of w after i steps, of largest magnitude.
    fn error_of_w(&self, w: &[f64], i: usize) -> f64 {
        largest_difference(w, &accounts(self.solution.at(i), self.motors).w)
    }

    /// The row of a state after i steps, from its energies, its accounts and the error of w.
    fn compare(&self, own: Own, found: Accounts<f64>, w_error: f64, i: usize) -> EnergyRow {
        let Own { method, h, t, energy, drift, ratio } = own;
        let Accounts { w, s, pumped } = found;
        let (exact, doubt_ratio) = self.ratio(i);
        EnergyRow {
            method,
            h,
            t,
            energy,
            drift,
            ratio,
            ratio_error: ratio.zip(exact).map(|(ratio, exact)| ratio - exact),
            w_error,
            doubt_w: self.solution.doubt_at(i).w,
            doubt_ratio,
            supplied: if s.is_empty() { Vec::new() } else { vec![s.iter().sum()] },
            pumped: pumped.into_iter().collect(),
            w,
            s,
        }
    }

    /// The ratio R after i steps, and its doubt.
    fn ratio(&self, i: usize) -> (Option<f64>, Option<f64>) {
        let Some(before) = i.checked_sub(1) else { return (None, None) };
        let energies = [self.energy(before), self.energy(i)];
        let exact = finite(energies[1].error / energies[0].error);
        // The relative doubts of the two energies add up.
        let relative = energies.map(|energy| energy.doubt / energy.error.abs());
        let doubt = exact.and_then(|exact| finite((exact * (relative[0] + relative[1])).abs()));
        (exact, doubt)
    }

    /// H without motors. Its doubt is the sum over j of |∂H/∂q_j| and |∂H/∂p_j| times the doubts of
    /// q and p.
    fn energy(&self, i: usize) -> Measured {
        let state = self.solution.at(i);
        let [mut hq, mut hp] = [(); 2].map(|()| vec![0.0; state.q.len()]);
        self.system.gradient(state.q, state.p, &mut hq, &mut hp);
        let steepness = |slopes: &[f64]| slopes[..self.n].iter().map(|x| x.abs()).sum::<f64>();
        let Doubt { q, p, .. } = self.solution.doubt_at(i);
        let doubt = steepness(&hq) * q + steepness(&hp) * p;
        Measured { error: energy_of(self.system, state, self.n), doubt }
    }
}

/// H, without the momenta of the motors behind n degrees of freedom.
fn energy_of(system: &dyn System<f64>, state: StateRef<'_, f64>, n: usize) -> f64 {
    state.energy(system) - state.p[n..].iter().sum::<f64>()
}

/// The difference of largest magnitude, with its sign.
fn largest_difference(found: &[f64], exact: &[f64]) -> f64 {
    let differences = found.iter().zip(exact).map(|(found, exact)| found - exact);
    differences.reduce(|most, x| if x.abs() > most.abs() { x } else { most }).unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Silent;
    use afterbay_methods::registry::find;
    use afterbay_systems::catalog::DAMPED_OSCILLATOR;

    #[test]
    fn every_state_is_recorded_where_there_are_no_steps_between_two() {
        let model = Model::of(&DAMPED_OSCILLATOR, &[1.0, 0.1]);
        let problem = Problem { model, q: vec![1.0], p: vec![0.0], end: 0.5 };
        let methods = [find("rk4").expect("a method")];
        let study = Energy { problem: &problem, methods: &methods, h: 0.125, every: 0 };
        let shared = study.share(&Silent).expect("a reference");
        let run = study.compute(&shared, 0, &Silent).expect("a run");
        let times: Vec<f64> = run.rows.iter().map(|row| row.t).collect();
        assert_eq!(times, [0.0, 0.125, 0.25, 0.375, 0.5]);
    }
}
