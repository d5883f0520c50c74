//! What a run costs and what comes out of it.

use super::Scene;
use afterbay_core::Passive;
use serde::Serialize;
use std::time::{Duration, Instant};

/// Sees y = (q, p, w) after each accepted step.
pub type Watch<'a> = &'a mut dyn FnMut(&[f64]);

/// Follows a scene to its end and writes y = (q, p, w) there; the second run is shown to a watcher,
/// others keep nothing.
pub type Run = Box<dyn Fn(&mut [f64], Option<Watch<'_>>) -> Result<Spent, String>>;

/// What a run took.
#[derive(Clone, Copy, Debug, Default)]
pub struct Spent {
    /// Steps accepted.
    pub steps: u64,
    /// Evaluations of the right-hand side, those for finite differences included.
    pub evaluations: u64,
    /// Iterations of a nonlinear solver, where it counts them.
    pub iterations: Option<u64>,
}

/// What a method is told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Setting {
    /// h
    Step(f64),
    /// Relative and absolute.
    Tolerance(f64),
}

/// A method on a scene, at all of its settings from coarse to fine.
#[derive(Clone)]
pub struct Line {
    /// Its name, unique in the table.
    pub method: &'static str,
    /// Does it claim to keep K?
    pub keeps_k: bool,
    /// Ours, not a peer's.
    pub ours: bool,
    /// What it is run at.
    pub settings: Vec<Setting>,
    /// The run at one of them.
    pub bind: std::rc::Rc<dyn Fn(Setting) -> Result<Run, String>>,
}

/// A row of `work_precision.csv`.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// The method.
    pub method: &'static str,
    /// The step, where that is what it is told.
    pub h: Option<f64>,
    /// `completed`, `failed`, or `too-long` where a coarser run already took too long.
    pub outcome: &'static str,
    /// max(|Δq|, |Δp|) at the end.
    pub error_qp: Option<f64>,
    /// max |Δw| at the end.
    pub error_w: Option<f64>,
    /// max |K - K0| over all accepted steps.
    pub k_drift: f64,
    /// Times Δw_j < 0 where Δw_j ≥ 0 is owed.
    pub passivity_violations: Option<u64>,
    /// The least of all times taken.
    pub seconds: Option<f64>,
    /// Steps accepted.
    pub steps: Option<u64>,
    /// Evaluations of the right-hand side; of ours the force or its mean, as the method counts
    /// them.
    pub evaluations: Option<u64>,
    /// Iterations of a nonlinear solver.
    pub iterations: Option<u64>,
    /// The scene.
    pub problem: &'static str,
    /// The tolerance, where that is what it is told.
    pub tolerance: Option<f64>,
    /// Largest of |H| and Σ|w| on the way: what K is rounded to.
    pub k_scale: f64,
    /// The method claims to keep K.
    pub keeps_k: bool,
    /// It is one of ours.
    pub ours: bool,
    /// What went wrong, in words.
    pub failure: Option<String>,
}

/// How long to measure.
#[derive(Clone, Copy, Debug)]
pub struct Patience {
    /// Settings tried of each line.
    pub settings: usize,
    /// Turns, in each of which every run of the scene is timed.
    pub turns: u32,
    /// A run is repeated for at least so long in all.
    pub least: Duration,
    /// One that takes longer is timed once, and finer ones of its line are not run.
    pub most: Duration,
}

struct Timed {
    row: usize,
    run: Run,
    first: Duration,
    best: Duration,
}

/// The rows of a scene: errors and drift from a first run of each, watched, which also warms it up,
/// then times in turns.
///
/// # Errors
/// Where the scene has no reference or no system.
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
                        timed.push(Timed { row: rows.len(), run, first, best: Duration::MAX });
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
                (timed.run)(&mut end, None)?;
                let elapsed = clock.elapsed();
                timed.best = timed.best.min(elapsed);
                all += elapsed;
                if all >= patience.least / patience.turns {
                    break;
                }
            }
        }
    }
    for timed in timed {
        rows[timed.row].seconds = Some(timed.best.as_secs_f64());
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

/// Runs once, looks at every step, and fills in what there is to see; the time is that of an
/// unwatched run.
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
    run(&mut end, None)?;
    let first = clock.elapsed();
    let books = |y: &[f64]| (subject.energy(&y[..n], &y[n..2 * n]), y[2 * n..].iter().sum::<f64>());
    let start = books(&scene.start()).0;
    let mut before = vec![0.0; n];
    let mut violations = 0;
    let spent = run(
        &mut end,
        Some(&mut |y| {
            let (energy, spent) = books(y);
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
    /// A peer's method at the tolerances.
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
