//! The cheapest method and step that meets an error, measured on the problem itself.
//!
//! For each method of the registry the number of steps is raised until the errors of (q, p) and of w at the end are within the bound, then taken back by
//! bisection to the least that does. The times of what qualifies are taken one after the other. The winner is checked against a run
//! of twice as many steps: by how much the two differ is an error estimate that needs no reference.

use super::work_precision::{self, WorkRow};
use super::{Problem, distance};
use crate::Solution;
use crate::progress::Progress;
use afterbay_core::{Grid, IntegrateError, Passive, Scalar, Tolerance, View};
use afterbay_methods::registry::{self, ADAPTIVE, AdaptiveRow, EXACT, METHODS, Row};
use rayon::prelude::*;
use serde::Serialize;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// What is wanted.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Wanted {
    /// The largest error of (q, p) and of w at the end.
    pub error: f64,
    /// K is to be kept to rounding.
    pub keep_k: bool,
    /// No energy is to be taken back from a reservoir that only fills.
    pub passive: bool,
}

/// A method at the step it was found to need, or how near it came.
#[derive(Clone, Debug, Serialize)]
pub struct Candidate {
    /// Its run.
    #[serde(flatten)]
    pub run: WorkRow,
    /// Why it does not qualify.
    pub why_not: Option<String>,
}

/// What was found.
#[derive(Clone, Debug, Serialize)]
pub struct Pick {
    /// What was wanted.
    pub wanted: Wanted,
    /// What qualifies, the cheapest first.
    pub qualified: Vec<Candidate>,
    /// What does not, the nearest first.
    pub others: Vec<Candidate>,
    /// The largest difference of (q, p) and of w between the winner and a run of twice as many steps.
    pub check: Option<[f64; 2]>,
    /// How far two computations of the reference are apart; 0 where it is known to rounding.
    pub reference_doubt: f64,
    /// Is it owed that a reservoir only fills?
    pub owed: bool,
}

/// A run that takes so many times as long as one that qualifies is not worth looking at, if it takes this long at least.
const SLOWER: u32 = 30;
const SHORT: Duration = Duration::from_millis(20);
/// No method is given more than this for its search.
const PATIENCE: Duration = Duration::from_secs(8);
/// The most steps of a run.
const MOST: u64 = 1 << 31;
/// Methods that choose their steps are tried with tolerances this far apart, so often, and with none looser than this.
const NEXT: f64 = 2.0;
const TRIES: u32 = 24;
const LOOSEST: f64 = 0.1;
/// An error that is not halved as often as this, one search after the other, stays where it is: where the field has kinks errors do not
/// fall evenly.
const IDLE: u32 = 3;
/// The number of steps is found to this share.
const CLOSE: f64 = 1.05;
/// K moves by no more than this beside the largest of its terms where it is kept to rounding.
const ROUNDING: f64 = 1e-11;

/// Measures every method that applies.
///
/// # Errors
/// Those of the input, and of the reference. What goes wrong in a run is why its method does not qualify.
pub fn run(problem: &Problem, wanted: Wanted, progress: &dyn Progress) -> Result<Pick, IntegrateError> {
    let exact = problem.solution(problem.end, 1, progress)?;
    let rows: Vec<&'static Row> = METHODS.iter().filter(|row| problem.model.bind(row).is_ok()).collect();
    let shortest = AtomicU64::new(u64::MAX);
    progress.begin("search for steps", rows.len());
    let found = rows
        .par_iter()
        .with_max_len(1)
        .map(|row| {
            let (exact, shortest) = (&exact, &shortest);
            let candidate =
                Search { problem, row, wanted, exact, progress, shortest, started: Instant::now() }.find();
            progress.advance();
            candidate
        })
        .collect::<Result<Vec<_>, _>>()?;
    let (mut qualified, mut others): (Vec<_>, Vec<_>) =
        found.into_iter().flatten().partition(|candidate: &Candidate| candidate.why_not.is_none());
    for row in &ADAPTIVE {
        match loosest(problem, row, wanted, &exact, progress)? {
            Some(candidate) if candidate.why_not.is_none() => qualified.push(candidate),
            adaptive => others.extend(adaptive),
        }
    }
    progress.begin("times", qualified.len());
    for Candidate { run, .. } in &mut qualified {
        let time = match Chosen::of(run) {
            Some(Chosen::Step(row)) => work_precision::time(problem, row, run.h)?,
            Some(Chosen::Tolerance(row, tolerance)) => work_precision::time_within(problem, row, tolerance)?,
            None => continue,
        };
        run.seconds = Some(time.as_secs_f64());
        progress.advance();
    }
    let seconds = |candidate: &Candidate| candidate.run.seconds.unwrap_or(f64::INFINITY);
    qualified.sort_by(|a, b| seconds(a).total_cmp(&seconds(b)));
    others.sort_by(|a, b| error(&a.run).total_cmp(&error(&b.run)));
    let check = qualified.first().map(|winner| finer(problem, &winner.run)).transpose()?.flatten();
    let owed = problem.model.subject::<f64>()?.damping().passive != Passive::No;
    Ok(Pick { wanted, qualified, others, check, reference_doubt: exact.doubt_at(1).most(), owed })
}

/// What a run was made by.
enum Chosen {
    Step(&'static Row),
    Tolerance(&'static AdaptiveRow, f64),
}

impl Chosen {
    fn of(run: &WorkRow) -> Option<Self> {
        match run.tolerance {
            Some(tolerance) => Some(Self::Tolerance(registry::find_adaptive(run.method)?, tolerance)),
            None => registry::find(run.method).map(Self::Step),
        }
    }
}

/// The larger of the two errors of a run, infinite where it did not reach its end.
fn error(run: &WorkRow) -> f64 {
    run.error_qp.zip(run.error_w).map_or(f64::INFINITY, |(qp, w)| if qp > w { qp } else { w })
}

/// The search for the steps of one method.
struct Search<'a> {
    problem: &'a Problem,
    row: &'static Row,
    wanted: Wanted,
    exact: &'a Solution<f64>,
    progress: &'a dyn Progress,
    /// The shortest time of a run that qualifies, of any method, in nanoseconds.
    shortest: &'a AtomicU64,
    started: Instant,
}

impl Search<'_> {
    /// A run, and why no longer one is worth it.
    fn run(&self, steps: u64) -> Result<(WorkRow, Option<&'static str>), IntegrateError> {
        let clock = Instant::now();
        let h = self.problem.end / steps as f64;
        let found = work_precision::errors(self.problem, self.row, h, self.exact, self.progress)?;
        let took = clock.elapsed();
        let nanoseconds = u64::try_from(took.as_nanos()).unwrap_or(u64::MAX);
        if error(&found) <= self.wanted.error && lack(self.row, self.wanted).is_none() {
            self.shortest.fetch_min(nanoseconds, Ordering::Relaxed);
        }
        let shortest = self.shortest.load(Ordering::Relaxed);
        let enough = if took > SHORT && nanoseconds / u64::from(SLOWER) > shortest {
            Some("it takes far longer than others that qualify")
        } else if self.started.elapsed() > PATIENCE || steps > MOST / 2 {
            Some("more steps were not tried")
        } else {
            None
        };
        Ok((found, enough))
    }

    /// The fewest steps within the bound, where twice as many are within it too: an error may be small by chance. None where
    /// somebody had enough.
    fn find(&self) -> Result<Option<Candidate>, IntegrateError> {
        let bound = self.wanted.error;
        let order = if self.row.order() == EXACT { 1.0 } else { f64::from(self.row.order()) };
        let (mut steps, mut too_few, mut nearest, mut idle) = (1_u64, 0, None::<WorkRow>, 0);
        let mut good = loop {
            let (found, enough) = self.run(steps)?;
            let now = error(&found);
            if now <= bound && error(&self.run(2 * steps)?.0) <= bound {
                break found;
            }
            if self.progress.stopped() {
                return Ok(None);
            }
            too_few = steps;
            let before = nearest.as_ref().map_or(f64::INFINITY, error);
            let best = now.min(before);
            idle = if now > bound && now > 0.5 * before && now < 1e-3 { idle + 1 } else { 0 };
            let why = match enough {
                _ if idle == IDLE => Some(format!("its error stays at {best:.1e} however small the step")),
                Some(enough) => Some(format!("at {steps} steps its error is still {best:.1e}: {enough}")),
                None => None,
            };
            if nearest.is_none() || now < before {
                nearest = Some(found.clone());
            }
            if why.is_some() {
                return Ok(Some(Candidate { run: nearest.unwrap_or(found), why_not: why }));
            }
            // Once errors fall as they should, the order tells where to look.
            let share = now / bound;
            let leap =
                if now < 0.1 && idle == 0 { (1.05 * share.powf(1.0 / order)).clamp(1.1, 64.0) } else { 2.0 };
            steps = (steps as f64 * leap).ceil() as u64;
        };
        while too_few > 0 && good.steps as f64 > CLOSE * too_few as f64 {
            let middle = (too_few as f64 * good.steps as f64).sqrt().round() as u64;
            if middle <= too_few || middle >= good.steps {
                break;
            }
            let (found, enough) = self.run(middle)?;
            if error(&found) <= bound {
                good = found;
            } else {
                too_few = middle;
            }
            if enough.is_some() {
                break;
            }
        }
        let why_not = match lack(self.row, self.wanted) {
            Some(lacks) => Some(lacks.into()),
            None => flaw(self.problem, self.wanted, self.exact, &good)?,
        };
        Ok(Some(Candidate { run: good, why_not }))
    }
}

/// A method that chooses its steps with the loosest tolerance within the bound. None where somebody had enough.
fn loosest(
    problem: &Problem,
    row: &AdaptiveRow,
    wanted: Wanted,
    exact: &Solution<f64>,
    progress: &dyn Progress,
) -> Result<Option<Candidate>, IntegrateError> {
    let least = 64.0 * <f64 as Scalar>::EPSILON;
    let run = |tolerance: f64| work_precision::errors_within(problem, row, tolerance, exact, progress);
    let (mut tolerance, mut good, mut nearest) = (wanted.error.clamp(least, LOOSEST), None, None::<WorkRow>);
    // Errors may be smaller than what is asked for, or larger.
    for _ in 0..TRIES {
        let found = run(tolerance)?;
        if progress.stopped() {
            return Ok(None);
        }
        if error(&found) <= wanted.error {
            good = Some(found);
            if tolerance >= LOOSEST || nearest.is_some() {
                break;
            }
            tolerance = (tolerance * NEXT).min(LOOSEST);
        } else if good.is_some() {
            break;
        } else {
            if nearest.as_ref().is_none_or(|nearest| error(&found) < error(nearest)) {
                nearest = Some(found);
            }
            if tolerance <= least {
                break;
            }
            tolerance = (tolerance / NEXT).max(least);
        }
    }
    match (good, nearest) {
        (Some(run), _) => {
            let lacks = (wanted.passive && !row.passive).then(|| TAKES_BACK.to_owned());
            let why_not = if lacks.is_some() { lacks } else { flaw(problem, wanted, exact, &run)? };
            Ok(Some(Candidate { run, why_not }))
        }
        (None, Some(run)) => {
            let why = format!("with tolerances down to {tolerance:.1e} its error is {:.1e}", error(&run));
            Ok(Some(Candidate { run, why_not: Some(why) }))
        }
        (None, None) => Ok(None),
    }
}

/// What a run within the bound lacks.
fn flaw(
    problem: &Problem,
    wanted: Wanted,
    exact: &Solution<f64>,
    run: &WorkRow,
) -> Result<Option<String>, IntegrateError> {
    if wanted.keep_k && run.k_drift > ROUNDING * scale(problem, exact)? {
        return Ok(Some(format!("K drifts by {:.1e}", run.k_drift)));
    }
    let taken = run.passivity_violations.filter(|&count| wanted.passive && count > 0);
    Ok(taken.map(|count| format!("it took energy back {count} times")))
}

const TAKES_BACK: &str = "it may take energy back from the reservoir";

/// What is wanted of a method that it does not promise.
fn lack(row: &Row, wanted: Wanted) -> Option<&'static str> {
    match (wanted.keep_k && !row.keeps_k, wanted.passive && !row.passive) {
        (true, _) => Some("it does not keep K"),
        (_, true) => Some(TAKES_BACK),
        _ => None,
    }
}

/// The largest of what K is made of, at the start and at the end.
fn scale(problem: &Problem, exact: &Solution<f64>) -> Result<f64, IntegrateError> {
    let subject = problem.model.subject::<f64>()?;
    let of = |i: usize| {
        let state = exact.at(i);
        let kinetic: f64 = state.p.iter().map(|p| p * p).sum();
        state.energy(&*subject).abs() + state.w.iter().map(|w| w.abs()).sum::<f64>() + kinetic
    };
    Ok(of(0).max(of(1)).max(f64::MIN_POSITIVE))
}

/// How far a run is from one of twice as many steps, or of a quarter of the tolerance.
fn finer(problem: &Problem, run: &WorkRow) -> Result<Option<[f64; 2]>, IntegrateError> {
    let end = |part: f64| -> Result<_, IntegrateError> {
        let mut state = problem.start::<f64>()?;
        let look = &mut |_: u64, _: View<'_, f64>| ControlFlow::Continue(());
        let done = match Chosen::of(run) {
            Some(Chosen::Tolerance(row, tolerance)) => {
                let tolerance =
                    Tolerance::all((tolerance * part * part).max(64.0 * <f64 as Scalar>::EPSILON));
                problem.model.bind_adaptive(row)?.run(&tolerance, problem.end, &mut state, look).is_ok()
            }
            Some(Chosen::Step(row)) => {
                let grid = Grid::new(run.h * part, problem.end)?;
                problem.model.bind(row)?.run(grid, &mut state, u64::MAX, look).is_ok()
            }
            None => false,
        };
        Ok(done.then_some(state))
    };
    let (Some(coarse), Some(fine)) = (end(1.0)?, end(0.5)?) else { return Ok(None) };
    let [q, p, w] = distance(coarse.view(), fine.view());
    Ok(Some([q.max(p), w]))
}
