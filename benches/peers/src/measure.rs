//! The measurement of the cost and the error of runs.

use super::Scene;
use afterbay_core::{Passive, StateRef};
use serde::Serialize;
use std::time::{Duration, Instant};

/// Receives y = (q, p, w) after each accepted step.
pub type Watch<'a> = &'a mut dyn FnMut(&[f64]);

/// Integrates a scene to its end and writes y = (q, p, w) there. Accepted steps are shown to the
/// watcher, if there is one; otherwise no output is stored.
pub type Run = Box<dyn Fn(&mut [f64], Option<Watch<'_>>) -> Result<Spent, String>>;

/// Writes y = (q, p, w).
pub(crate) fn write(StateRef { q, p, w, .. }: StateRef<'_, f64>, y: &mut [f64]) {
    for (to, from) in y.chunks_exact_mut(q.len()).zip([q, p, w]) {
        to.copy_from_slice(from);
    }
}

/// The work of a run.
#[derive(Clone, Copy, Debug, Default)]
pub struct Spent {
    /// The number of accepted steps.
    pub steps: u64,
    /// The number of evaluations of the right-hand side, including those for finite differences.
    pub evaluations: u64,
    /// The number of iterations of a nonlinear solver, if it counts them.
    pub iterations: Option<u64>,
    /// The time of the run in seconds, where a process of its own has measured it.
    pub seconds: Option<f64>,
}

impl Spent {
    /// The time of the run, which began at `clock`.
    fn time(&self, clock: Instant) -> Duration {
        self.seconds.map_or_else(|| clock.elapsed(), Duration::from_secs_f64)
    }
}

/// The parameter that determines the accuracy of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Setting {
    /// The step size h.
    Step(f64),
    /// The tolerance, relative and absolute.
    Tolerance(f64),
}

/// A method on a scene, with all its settings from coarse to fine.
#[derive(Clone)]
pub struct Line {
    /// The name of the method, unique in the table.
    pub method: &'static str,
    /// Whether the method claims to conserve K.
    pub keeps_k: bool,
    /// Whether the method belongs to this project.
    pub ours: bool,
    /// The settings.
    pub settings: Vec<Setting>,
    /// Creates the run for one setting.
    pub bind: std::rc::Rc<dyn Fn(Setting) -> Result<Run, String>>,
}

/// A row of `work_precision.csv`.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// The name of the method.
    pub method: &'static str,
    /// The step size, for methods with a fixed step.
    pub h: Option<f64>,
    /// `completed`, `failed`, or `too-long` where a coarser run already took too long.
    pub outcome: &'static str,
    /// max(|Δq|, |Δp|) at the end.
    pub error_qp: Option<f64>,
    /// max |Δw| at the end.
    pub error_w: Option<f64>,
    /// max |K - K0| over all accepted steps.
    pub k_drift: f64,
    /// The number of times that Δw_j < 0 on a passive system.
    pub passivity_violations: Option<u64>,
    /// The minimum of all times in seconds.
    pub seconds: Option<f64>,
    /// The number of accepted steps.
    pub steps: Option<u64>,
    /// The number of evaluations of the right-hand side; for the project's methods those of the
    /// force or its mean, as the method counts them.
    pub evaluations: Option<u64>,
    /// The number of iterations of a nonlinear solver.
    pub iterations: Option<u64>,
    /// The name of the scene.
    pub problem: &'static str,
    /// The tolerance, for methods with a tolerance.
    pub tolerance: Option<f64>,
    /// The largest of |H| and Σ|w| along the run, the scale of the rounding of K.
    pub k_scale: f64,
    /// Whether the method claims to conserve K.
    pub keeps_k: bool,
    /// Whether the method belongs to this project.
    pub ours: bool,
    /// The description of the failure, if any.
    pub failure: Option<String>,
}

/// The limits of the measurement.
#[derive(Clone, Copy, Debug)]
pub struct Patience {
    /// The number of settings of each line that are run.
    pub settings: usize,
    /// The number of turns; each turn times every run of the scene.
    pub turns: u32,
    /// The minimum total time for which a run is repeated.
    pub least: Duration,
    /// A run that takes longer than this is timed once, and finer settings of its line are not run.
    pub most: Duration,
}

struct Timed {
    row: usize,
    run: Run,
    first: Duration,
    best: Duration,
    failure: Option<String>,
}

/// Computes the rows of a scene. The errors and the drift come from a first, watched run of each
/// setting, which also warms up the caches; then all runs are timed in turns.
///
/// # Errors
/// An error if the scene has no reference or no system.
pub fn all(scene: &Scene, lines: &[Line], patience: Patience) -> Result<Vec<Row>, String> {
    let exact = scene.reference().ok_or_else(|| format!("{}: no reference", scene.name))?;
    let (mut rows, mut timed) = (Vec::new(), Vec::new());
    for line in lines {
        let mut long = false;
        for &setting in line.settings.iter().take(patience.settings) {
            let mut row = blank(scene, line, setting);
            if long {
                row.outcome = "too-long";
            } else {
                match watched(scene, &exact, line, setting, &mut row) {
                    Ok((run, first)) => {
                        long = first > patience.most;
                        timed.push(Timed {
                            row: rows.len(),
                            run,
                            first,
                            best: Duration::MAX,
                            failure: None,
                        });
                    }
                    Err(why) => (row.outcome, row.failure) = ("failed", Some(why)),
                }
            }
            rows.push(row);
        }
    }
    let mut end = scene.start();
    for turn in 0..patience.turns {
        for timed in timed.iter_mut().filter(|timed| turn == 0 || timed.first < patience.most) {
            let mut all = Duration::ZERO;
            loop {
                let clock = Instant::now();
                match (timed.run)(&mut end, None) {
                    Ok(spent) => timed.best = timed.best.min(spent.time(clock)),
                    Err(why) => timed.failure = Some(why),
                }
                all += clock.elapsed();
                if timed.failure.is_some() || all >= patience.least / patience.turns {
                    break;
                }
            }
        }
    }
    for timed in timed {
        let row = &mut rows[timed.row];
        match timed.failure {
            None => row.seconds = Some(timed.best.as_secs_f64()),
            Some(_) => (row.outcome, row.failure) = ("failed", timed.failure),
        }
    }
    Ok(rows)
}

fn blank(scene: &Scene, line: &Line, setting: Setting) -> Row {
    let (h, tolerance) = match setting {
        Setting::Step(h) => (Some(h), None),
        Setting::Tolerance(tolerance) => (None, Some(tolerance)),
    };
    Row {
        method: line.method,
        h,
        outcome: "completed",
        error_qp: None,
        error_w: None,
        k_drift: 0.0,
        passivity_violations: None,
        seconds: None,
        steps: None,
        evaluations: None,
        iterations: None,
        problem: scene.name,
        tolerance,
        k_scale: 0.0,
        keeps_k: line.keeps_k,
        ours: line.ours,
        failure: None,
    }
}

/// Runs once, observes every step, and fills in the row; the time is that of an unwatched run.
fn watched(
    scene: &Scene,
    exact: &[f64],
    line: &Line,
    setting: Setting,
    row: &mut Row,
) -> Result<(Run, Duration), String> {
    let n = scene.dof();
    let subject = scene.problem.model.system::<f64>().map_err(|error| error.to_string())?;
    let passive = subject.dissipation_form().passive;
    let run = (line.bind)(setting)?;
    let mut end = scene.start();
    let clock = Instant::now();
    let first = run(&mut end, None)?.time(clock);
    let energies =
        |y: &[f64]| (subject.energy(&y[..n], &y[n..2 * n]), y[2 * n..].iter().sum::<f64>());
    let start = energies(&scene.start()).0;
    let mut before = vec![0.0; n];
    let mut violations = 0;
    let spent = run(
        &mut end,
        Some(&mut |y| {
            let (energy, spent) = energies(y);
            row.k_drift = row.k_drift.max((energy + spent - start).abs());
            row.k_scale =
                row.k_scale.max(energy.abs()).max(y[2 * n..].iter().map(|w| w.abs()).sum());
            violations += u64::from(passive.violated(&before, &y[2 * n..]));
            before.copy_from_slice(&y[2 * n..]);
        }),
    )?;
    if let Some(bad) = end.iter().position(|x| !x.is_finite()) {
        return Err(format!("entry {bad} of the end state is not finite"));
    }
    let off = |range: std::ops::Range<usize>| {
        end[range.clone()].iter().zip(&exact[range]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    (row.error_qp, row.error_w) = (Some(off(0..2 * n)), Some(off(2 * n..3 * n)));
    row.passivity_violations = (passive != Passive::No).then_some(violations);
    (row.steps, row.evaluations, row.iterations) =
        (Some(spent.steps), Some(spent.evaluations), spent.iterations);
    Ok((run, first))
}

impl Line {
    /// The line of another library's method at the tolerances.
    pub fn peer(
        method: &'static str,
        tolerances: Vec<f64>,
        bind: impl Fn(f64) -> Result<Run, String> + 'static,
    ) -> Self {
        Self {
            method,
            keeps_k: false,
            ours: false,
            settings: tolerances.into_iter().map(Setting::Tolerance).collect(),
            bind: std::rc::Rc::new(move |setting| match setting {
                Setting::Tolerance(tolerance) => bind(tolerance),
                Setting::Step(_) => Err("takes a tolerance".into()),
            }),
        }
    }
}
