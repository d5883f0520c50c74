//! Trajectories.

use super::events::Steps;
use super::outcome::Ending;
use super::{PUMPED, Problem, numbered};
use crate::Model;
use crate::progress::{Piece, Progress};
use crate::words::{Word, word as read_word};
use afterbay_core::{
    Abilities, Accounts, Grid, IntegrateError, RunError, STEPS_OF_BLOCK, State, StateRef,
    Tolerance, accounts,
};
use afterbay_methods::registry::{Part, Row};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;

/// A row of `trajectory.csv`, under the [`columns`].
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct TrajectoryRow {
    /// Name of the method.
    #[serde(deserialize_with = "read_word")]
    pub method: Word,
    /// Steps done.
    pub step: u64,
    /// Time.
    pub t: f64,
    /// Coordinates.
    pub q: Vec<f64>,
    /// Momenta.
    pub p: Vec<f64>,
    /// Reservoir.
    pub w: Vec<f64>,
    /// The energy supplied by a drive; empty without one.
    pub s: Vec<f64>,
    /// The energy s_t pumped by V(q, t); empty where V and D do not depend on t.
    pub pumped: Vec<f64>,
    /// H
    pub energy: f64,
    /// K = H + Σ w - Σ s - s_t
    pub total: f64,
}

impl TrajectoryRow {
    /// A state of a run, without motors.
    pub(super) fn of(
        method: &'static str,
        step: u64,
        state: StateRef<'_, f64>,
        system: &dyn Abilities<f64>,
        model: &Model,
    ) -> Self {
        let n = model.degrees();
        let Accounts { w, s, pumped } = accounts(state, &model.motors());
        let supplied: f64 = state.p[n..].iter().sum();
        Self {
            method,
            step,
            t: state.t,
            q: state.q[..n].to_vec(),
            p: state.p[..n].to_vec(),
            w,
            s,
            pumped: pumped.into_iter().collect(),
            energy: state.energy(system) - supplied,
            total: state.total(system),
        }
    }
}

/// The names of the columns: `method,step,t,q1..qN,p1..pN,w1..wN,H,K`, with s1..sN behind w where
/// there is a drive, and st behind them where V or D depends on t.
pub fn columns(model: &Model) -> Vec<String> {
    let names = |list: &[&str]| list.iter().map(ToString::to_string).collect::<Vec<_>>();
    let pumped = model.has_clock().then(|| PUMPED.to_owned());
    let parts = model.variables().iter().flat_map(|name| numbered(name, model.degrees()));
    names(&["method", "step", "t"])
        .into_iter()
        .chain(parts)
        .chain(pumped)
        .chain(names(&["H", "K"]))
        .collect()
}

/// One run.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Trajectory {
    /// Name of the method.
    #[serde(deserialize_with = "read_word")]
    pub method: Word,
    /// Every `every`-th state, and the last good one.
    pub rows: Vec<TrajectoryRow>,
    /// How the run ended; `interrupted` while legs of it are left.
    pub ending: Ending,
}

/// The steps of a leg, times degrees of freedom. A choice: a leg takes from a hundredth of a second
/// to some seconds, and what its start costs is small beside that.
const LEG: u64 = 1 << 20;
const _: () = assert!(LEG.is_multiple_of(STEPS_OF_BLOCK), "w then does not depend on the legs");
/// The most steps, times degrees of freedom, between two checks whether to stop.
const ASKED: u64 = 4096;

/// A run in legs: a stopped one goes on where a leg ended. Each leg begins with a fresh workspace,
/// so that its results are the same to the bit in one command and in several.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Legs {
    /// The run so far.
    pub trajectory: Trajectory,
    /// The steps of size h done.
    done: u64,
    /// The state there; none once the run has ended.
    state: Option<KeptState>,
}

/// A state of a run, with the motors of a drive.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct KeptState {
    q: Vec<f64>,
    p: Vec<f64>,
    w: Vec<f64>,
    /// The part of w below its rounding ([`Part::remainder`]).
    remainder: Vec<f64>,
}

impl Legs {
    /// A run before its first leg.
    ///
    /// # Errors
    /// A start that does not fit the system.
    pub fn new(problem: &Problem, row: &'static Row) -> Result<Self, IntegrateError> {
        let State { q, p, w, .. } = problem.start()?;
        let ending = Ending::interrupted();
        let trajectory = Trajectory { method: row.name, rows: Vec::new(), ending };
        let remainder = vec![0.0; w.len()];
        Ok(Self { trajectory, done: 0, state: Some(KeptState { q, p, w, remainder }) })
    }

    /// A run that is not computed in legs.
    pub fn whole(trajectory: Trajectory) -> Self {
        Self { trajectory, done: 0, state: None }
    }

    /// Whether the run has ended.
    pub fn has_ended(&self) -> bool {
        self.state.is_none()
    }

    /// Computes the next leg: with steps of size h, or within the tolerance of a method that
    /// chooses its steps. Every `every`-th state of the grid of h is kept.
    ///
    /// # Errors
    /// Invalid input. The trajectory of a run that fails ends with its last good state.
    pub fn advance(
        &mut self,
        problem: &Problem,
        row: &'static Row,
        Steps { h, every, tolerance }: Steps,
        progress: &dyn Progress,
    ) -> Result<(), IntegrateError> {
        let Some(KeptState { q, p, w, mut remainder }) = self.state.take() else { return Ok(()) };
        let (grid, every) = (Grid::<f64>::new(h, problem.end)?, every.max(1));
        let steps = LEG / q.len() as u64;
        let mut state = State { q, p, w, t: self.done as f64 * h };
        let until = |steps| grid.steps.min(self.done.saturating_add(steps));
        let (result, end) = if row.is_adaptive() {
            let end = until((steps / every).max(1).saturating_mul(every));
            let leg = Leg { grid, every, end };
            (self.within(problem, row, leg, tolerance, &mut state, progress)?, end)
        } else {
            // Whole blocks of steps, so that w does not depend on the legs.
            let end = until((steps / STEPS_OF_BLOCK).max(1) * STEPS_OF_BLOCK);
            let leg = Leg { grid, every, end };
            (self.by_steps(problem, row, leg, (&mut state, &mut remainder), progress)?, end)
        };
        self.trajectory.ending = Ending::of(&result, grid.steps, self.done);
        if result.is_ok() && self.done == end && end < grid.steps {
            let State { q, p, w, .. } = state;
            self.state = Some(KeptState { q, p, w, remainder });
        } else {
            progress.advance();
        }
        Ok(())
    }

    /// A leg of a method with a fixed step.
    fn by_steps(
        &mut self,
        problem: &Problem,
        row: &'static Row,
        Leg { grid, every, end }: Leg,
        (state, remainder): (&mut State<Vec<f64>>, &mut [f64]),
        progress: &dyn Progress,
    ) -> Result<Result<(), IntegrateError>, IntegrateError> {
        let system = problem.model.system::<f64>()?;
        let (rows, begin) = (&mut self.trajectory.rows, self.done);
        let mut record = |step: u64, state: StateRef<'_, f64>| {
            // The times are those of one grid, whatever the legs.
            let state = StateRef { t: step as f64 * grid.h, ..state };
            rows.push(TrajectoryRow::of(row.name, step, state, &*system, &problem.model));
        };
        let (mut done, mut recorded, mut piece) = (begin, begin, Piece::new(progress));
        let stride = if every <= ASKED / state.q.len() as u64 { every } else { 1 };
        let first = begin.next_multiple_of(stride) - begin;
        let part = Part { grid: Grid { steps: end - begin, ..grid }, first, stride, remainder };
        let result = problem.model.bind(row)?.run_part(part, state, &mut |step, state| {
            done = begin + step;
            piece.reach(done, grid.steps);
            if done % every == 0 && (done > begin || begin == 0) {
                record(done, state);
                recorded = done;
            }
            if progress.stopped() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        let result = result.map(drop).map_err(|error| match error {
            IntegrateError::Run(RunError { step, t, failure }) => {
                RunError { step: begin + step, t, failure }.into()
            }
            error => error,
        });
        self.done = match &result {
            Ok(()) if progress.stopped() => done,
            Ok(()) => end,
            Err(IntegrateError::Run(error)) => error.step - 1,
            Err(IntegrateError::Input(_) | IntegrateError::Interrupted) => begin,
        };
        let ends = result.is_err() || self.done < end || end == grid.steps;
        if ends && self.done != recorded {
            record(self.done, state.state_ref());
        }
        Ok(result)
    }

    /// A leg of a method that chooses its steps. It keeps the states at the times of every
    /// `every`-th step of size h, where K is exact too.
    fn within(
        &mut self,
        problem: &Problem,
        row: &'static Row,
        Leg { grid, every, end }: Leg,
        tolerance: f64,
        state: &mut State<Vec<f64>>,
        progress: &dyn Progress,
    ) -> Result<Result<(), IntegrateError>, IntegrateError> {
        let system = problem.model.system::<f64>()?;
        let (rows, begin) = (&mut self.trajectory.rows, self.done);
        let last = (!end.is_multiple_of(every)).then_some(end);
        let steps: Vec<u64> =
            (begin / every..=end / every).map(|n| n * every).chain(last).collect();
        let times: Vec<f64> = steps.iter().map(|&step| step as f64 * grid.h).collect();
        let (run, mut piece) = (problem.model.bind(row)?, Piece::new(progress));
        let mut done = begin;
        let result = run.sample(&Tolerance::all(tolerance), &times, state, &mut |n, state| {
            done = steps.get(n as usize).copied().unwrap_or(end);
            piece.reach(done, grid.steps);
            if done > begin || begin == 0 {
                rows.push(TrajectoryRow::of(row.name, done, state, &*system, &problem.model));
            }
            if progress.stopped() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        self.done = done;
        match result {
            Err(IntegrateError::Input(error)) => Err(error.into()),
            result => Ok(result.map(drop)),
        }
    }
}

/// The steps of a leg: up to `end` on the grid of the run.
#[derive(Clone, Copy)]
struct Leg {
    grid: Grid<f64>,
    every: u64,
    end: u64,
}

/// Runs each method with steps of size h and keeps every `every`-th state.
///
/// # Errors
/// Invalid input. The trajectory of a run that fails ends with its last good state.
pub fn run(
    problem: &Problem,
    methods: &[&'static Row],
    h: f64,
    every: u64,
    progress: &dyn Progress,
) -> Result<Vec<Trajectory>, IntegrateError> {
    let steps = Steps { h, every, tolerance: f64::NAN };
    let of_method = |row: &&'static Row| {
        let mut legs = Legs::new(problem, row)?;
        while !legs.has_ended() {
            legs.advance(problem, row, steps, progress)?;
        }
        Ok(legs.trajectory)
    };
    methods.par_iter().map(of_method).collect()
}

/// Runs a method with steps of size h and keeps the states at the times `0, spacing, 2 spacing,
/// ..`. A state between two steps is the end of a shorter step from the first of them, or of a run
/// within the tolerance: it has the accuracy of the method, and K is kept if the method keeps it.
///
/// # Errors
/// Invalid input. The trajectory of a run that fails ends with its last good state.
pub fn dense(
    problem: &Problem,
    row: &'static Row,
    steps: Steps,
    spacing: f64,
    progress: &dyn Progress,
) -> Result<Trajectory, IntegrateError> {
    let grid = Grid::<f64>::new(steps.h, problem.end)?;
    let (model, count) = (&problem.model, (problem.end / spacing).floor() as u64);
    let (system, bound) = (model.system::<f64>()?, problem.model.bind(row)?);
    let mut step = bound.stepper(Tolerance::all(steps.tolerance));
    let mut state = problem.start()?;
    let mut rows = vec![TrajectoryRow::of(row.name, 0, state.state_ref(), &*system, model)];
    let (mut piece, mut result, mut done) = (Piece::new(progress), Ok(()), 0);
    for n in 1..=grid.steps {
        let (before, time) = (state.clone(), n as f64 * grid.h);
        if let Err(error) = step(grid.h, &mut state) {
            result = Err(match error {
                IntegrateError::Run(error) => {
                    RunError { step: n, t: before.t, failure: error.failure }.into()
                }
                error => error,
            });
            break;
        }
        (state.t, done) = (time, n);
        piece.reach(n, grid.steps);
        while rows.len() as u64 <= count {
            let t = rows.len() as f64 * spacing;
            // The times of the steps are rounded.
            let (early, late) = (t - before.t, t - time);
            if late > ROUNDED * time {
                break;
            }
            let mut there =
                if late.abs() <= ROUNDED * time { state.clone() } else { before.clone() };
            if there.t < time && step(early, &mut there).is_err() {
                break;
            }
            there.t = t;
            rows.push(TrajectoryRow::of(row.name, n, there.state_ref(), &*system, model));
        }
        if progress.stopped() {
            break;
        }
    }
    drop(piece);
    progress.advance();
    if let Err(IntegrateError::Input(error)) = result {
        return Err(error.into());
    }
    if result.is_err() {
        rows.push(TrajectoryRow::of(row.name, done, state.state_ref(), &*system, model));
    }
    Ok(Trajectory { method: row.name, rows, ending: Ending::of(&result, grid.steps, done) })
}

/// The largest difference of equal times, relative to them: some roundings.
const ROUNDED: f64 = 1e-13;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Silent;
    use crate::scene::Scene;

    /// A driven oscillator whose runs take three legs, the last of them short.
    fn scene() -> Scene {
        let text = r#"
            [system]
            name = "duffing"
            parameters = { alpha = 1.0, beta = 0.5, c = 0.1 }
            [drive]
            force = "0.3*cos(1.2*t)"
            [initial]
            q = [1.0]
            p = [0.0]
            [time]
            end = 22000.0
            step = 0.01
            [run]
            methods = ["moddg", "adaptive-dop853"]
            tolerance = 1e-6
        "#;
        Scene::read(text).expect("a scene")
    }

    #[test]
    fn legs_go_on_from_what_was_kept_to_the_bit() {
        let scene = scene();
        let plan = scene.run.as_ref().expect("runs");
        let steps = Steps { h: scene.step, every: 7001, tolerance: 1e-6 };
        for row in plan.methods.iter().chain(&plan.adaptive) {
            let run = |kept: bool| {
                let (mut legs, mut count) = (Legs::new(&scene.problem, row).expect("a start"), 0);
                while !legs.has_ended() {
                    legs.advance(&scene.problem, row, steps, &Silent).expect("a leg");
                    count += 1;
                    if kept {
                        let mut bytes = Vec::new();
                        ciborium::into_writer(&legs, &mut bytes).expect("bytes");
                        legs = ciborium::from_reader(&bytes[..]).expect("the same legs");
                    }
                }
                assert_eq!(count, 5, "the motor of the drive is a second degree of freedom");
                legs.trajectory
            };
            let (alone, resumed) = (run(false), run(true));
            assert!(alone.ending.is_completed(), "{:?}", alone.ending);
            let bits = |run: &Trajectory| format!("{:?}", run.rows);
            assert_eq!(bits(&alone), bits(&resumed));
            let numbers: Vec<u64> = alone.rows.iter().map(|row| row.step).collect();
            let expected: Vec<u64> = (0..=314).map(|n| 7001 * n).chain([2_200_000]).collect();
            assert_eq!(numbers, expected, "{}", row.name);
            assert!(alone.rows.iter().all(|row| row.t == row.step as f64 * 0.01));
            let first = alone.rows[0].total;
            let off = alone.rows.iter().map(|row| (row.total - first).abs()).fold(0.0, f64::max);
            assert!(row.name != "moddg" || off < 1e-10, "K is off by {off:e}");
        }
    }

    #[test]
    fn w_does_not_depend_on_the_states_that_are_kept() {
        let scene = scene();
        let row = afterbay_methods::registry::find("moddg").expect("a method");
        let end = |every| {
            let runs = run(&scene.problem, &[row], scene.step, every, &Silent).expect("runs");
            format!("{:?}", runs[0].rows.last())
        };
        assert_eq!(end(7001), end(100_000));
    }

    #[test]
    fn a_run_that_fails_in_a_later_leg_names_its_step() {
        let text = r#"
            [system]
            name = "custom"
            potential = "-0.5*k*q1^2"
            dissipation = ["0"]
            parameters = { k = 1e-7 }
            [initial]
            q = [1.0]
            p = [0.0]
            [time]
            end = 2e7
            step = 1.0
            [run]
            methods = ["rk4"]
        "#;
        let scene = Scene::read(text).expect("a scene");
        let row = afterbay_methods::registry::find("rk4").expect("a method");
        let found = run(&scene.problem, &[row], 1.0, 1000, &Silent).expect("a run");
        let [run] = &found[..] else { panic!("one run") };
        assert_eq!(run.ending.outcome, "not-finite", "{:?}", run.ending);
        let last = run.rows.last().expect("rows").step;
        assert!(last > LEG, "{last}");
        let named = format!("step {}", last + 1);
        let said = run.ending.failure.as_deref().unwrap_or_default();
        assert!(said.contains(&named), "{said}: {named}");
    }
}
