//! The search for the setting of one method, and its check at neighbouring settings.

use super::setting::{Choice, TIGHTEST, two_digits};
use super::trial::{Bench, Trial};
use super::{Candidate, Wanted};
use crate::progress::Piece;
use crate::study::kept::KEPT;
use afterbay_core::IntegrateError;
use afterbay_methods::registry::Row;
use cpu_time::ThreadTime;
use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// More steps are not tried after a run that takes this many times as long as one that qualifies,
/// unless it is short.
const SLOWER: u32 = 10;
/// The time of a run that is short.
const SHORT_RUN: Duration = Duration::from_millis(10);
/// The most time for the search of one method, without its check.
const MOST_SEARCH_TIME: Duration = Duration::from_secs(8);
/// The most steps of a run.
const MOST_STEPS: u64 = 1 << 31;
/// The ratio of successive tolerances.
const TOLERANCE_RATIO: f64 = 2.0;
/// The most tolerances tried.
const MOST_TOLERANCES: u32 = 24;
/// The loosest tolerance.
const LOOSEST: f64 = 0.1;
/// The number of successive searches without halving the error after which the method is given up.
/// It exceeds one because errors do not fall evenly where the field has kinks.
const MOST_IDLE_SEARCHES: u32 = 3;
/// The error, relative to the size of the motion, below which a method that no longer gains counts
/// as idle. A choice.
const IDLE_ERROR: f64 = 1e-3;
/// The error, relative to the size of the motion, from which on errors may fall at their order. A
/// choice.
const SMALL_ERROR: f64 = 0.1;
/// The relative accuracy of the number of steps.
const STEPS_ACCURACY: f64 = 1.05;
/// The most settings tried for one that holds with its neighbours: 1.06⁴⁸ = 16 times the steps.
const MOST_CHECKED: u32 = 48;
/// The time after which no other setting is tried for it.
const MOST_CHECK_TIME: Duration = Duration::from_secs(60);

/// The search for the setting of one method.
pub(super) struct Search<'a> {
    bench: &'a Bench<'a>,
    /// The shortest time of a run that qualifies, of any method, in nanoseconds.
    shortest: &'a AtomicU64,
    started: Instant,
    /// The runs tried, by key.
    tried: HashMap<u64, Trial>,
    order: Vec<u64>,
    piece: Piece<'a>,
}

/// The result of the search of one method.
pub(super) struct Found {
    pub(super) candidate: Option<(Candidate, Choice)>,
    /// Every run, in the order of the search.
    pub(super) tried: Vec<Trial>,
}

impl<'a> Search<'a> {
    pub(super) fn new(bench: &'a Bench<'a>, shortest: &'a AtomicU64) -> Self {
        let (started, piece) = (Instant::now(), Piece::new(bench.progress));
        Self { bench, shortest, started, tried: HashMap::new(), order: Vec::new(), piece }
    }

    fn wanted(&self) -> Wanted {
        self.bench.wanted
    }

    fn holds(&self, trial: &Trial) -> bool {
        trial.decisive <= self.wanted().error
    }

    fn run(&mut self, setting: Choice) -> Result<Trial, IntegrateError> {
        if let Some(trial) = self.tried.get(&setting.key()) {
            return Ok(trial.clone());
        }
        let trial = self.bench.run(setting)?;
        // The number of trials to come is unknown, so progress is measured by the time spent.
        let time = self.started.elapsed().min(MOST_SEARCH_TIME.mul_f64(0.9)).as_millis() as u64;
        self.piece.report(time, MOST_SEARCH_TIME.as_millis() as u64);
        if !self.bench.progress.stopped() {
            self.order.push(setting.key());
            self.tried.insert(setting.key(), trial.clone());
        }
        Ok(trial)
    }

    /// Runs with a fixed number of steps. Also returns the factor by which the number of steps may
    /// grow, so that the next run is not far longer than is worth it, or the reason to try no more.
    fn at(
        &mut self,
        row: &'static Row,
        steps: u64,
    ) -> Result<(Trial, Result<f64, &'static str>), IntegrateError> {
        // The time of this thread: on a busy machine the clock counts waiting, too.
        let clock = ThreadTime::now();
        let trial = self.run(Choice::Steps(row, steps))?;
        let took = clock.elapsed();
        let shortest = Duration::from_nanos(self.shortest.load(Ordering::Relaxed));
        let worth = SHORT_RUN.max(shortest.saturating_mul(SLOWER));
        let growth = if took > worth {
            Err("it takes far longer than others that qualify")
        } else if self.started.elapsed() > MOST_SEARCH_TIME || steps > MOST_STEPS / 4 {
            Err("more steps were not tried")
        } else {
            Ok((2.0 * worth.as_secs_f64() / took.as_secs_f64()).max(2.0))
        };
        Ok((trial, growth))
    }

    /// The fewest steps within the bound together with their neighbours.
    pub(super) fn steps(mut self, row: &'static Row) -> Result<Found, IntegrateError> {
        let candidate = match self.fewest(row)? {
            Reached::Within(steps) => {
                let lacks = lack(row.keeps_k, row.passive, self.wanted());
                self.confirmed(Choice::Steps(row, steps), lacks)?
            }
            Reached::Not(trial, why) => trial.map(|trial| {
                let setting = Choice::Steps(row, trial.steps.max(1));
                (Candidate { run: *trial, why_not: Some(why), checked: None, times: None }, setting)
            }),
        };
        Ok(self.leave(candidate))
    }

    /// The loosest tolerance within the bound together with its neighbours.
    pub(super) fn tolerance(mut self, row: &'static Row) -> Result<Found, IntegrateError> {
        let bound = self.wanted().error;
        let (mut tolerance, mut good, mut nearest) =
            (bound.clamp(TIGHTEST, LOOSEST), None, None::<Trial>);
        let mut tightest = tolerance;
        for _ in 0..MOST_TOLERANCES {
            let trial = self.run(Choice::Tolerance(row, tolerance))?;
            tightest = tightest.min(tolerance);
            if self.bench.progress.stopped() {
                break;
            }
            if self.holds(&trial) {
                good = Some(tolerance);
                if tolerance >= LOOSEST || nearest.is_some() {
                    break;
                }
                tolerance = (tolerance * TOLERANCE_RATIO).min(LOOSEST);
            } else if good.is_some() {
                break;
            } else {
                if nearest.as_ref().is_none_or(|nearest| trial.decisive < nearest.decisive) {
                    nearest = Some(trial);
                }
                if tolerance <= TIGHTEST || self.started.elapsed() > MOST_SEARCH_TIME {
                    break;
                }
                tolerance = (tolerance / TOLERANCE_RATIO).max(TIGHTEST);
            }
        }
        let candidate = match (good, nearest) {
            (Some(tolerance), _) => {
                // Tighter by little, and checked like any other.
                let tolerance = two_digits(tolerance).max(TIGHTEST);
                let lacks = lack(true, row.passive, self.wanted());
                self.confirmed(Choice::Tolerance(row, tolerance), lacks)?
            }
            (None, Some(run)) => {
                let why = format!(
                    "with tolerances down to {tightest:.1e} its error is {:.1e}",
                    run.decisive
                );
                let choice = Choice::Tolerance(row, run.tolerance.unwrap_or(tightest));
                Some((Candidate { run, why_not: Some(why), checked: None, times: None }, choice))
            }
            (None, None) => None,
        };
        Ok(self.leave(candidate))
    }

    fn leave(self, candidate: Option<(Candidate, Choice)>) -> Found {
        let Self { tried, order, .. } = self;
        Found { candidate, tried: order.iter().filter_map(|key| tried.get(key).cloned()).collect() }
    }

    /// The fewest steps within the bound for which twice as many are within it too, since an error
    /// may be small by chance.
    fn fewest(&mut self, row: &'static Row) -> Result<Reached, IntegrateError> {
        let Bracket { mut too_few, mut good, nearest } = match self.bracket(row)? {
            Ok(bracket) => bracket,
            Err(reached) => return Ok(reached),
        };
        while too_few > 0 && good as f64 > STEPS_ACCURACY * too_few as f64 {
            let middle = (too_few as f64 * good as f64).sqrt().round() as u64;
            if middle <= too_few || middle >= good {
                break;
            }
            let (found, growth) = self.at(row, middle)?;
            if self.bench.progress.stopped() {
                return Ok(Reached::Not(nearest.map(Box::new), INTERRUPTED.into()));
            }
            if self.holds(&found) {
                good = middle;
            } else {
                too_few = middle;
            }
            if growth.is_err() {
                break;
            }
        }
        Ok(Reached::Within(good))
    }

    /// Takes more and more steps until they and twice as many are within the bound. The error is
    /// the reason why no number of steps was found.
    fn bracket(&mut self, row: &'static Row) -> Result<Result<Bracket, Reached>, IntegrateError> {
        let bound = self.wanted().error;
        let order = row.order().number().map_or(1.0, f64::from);
        let size = self.bench.dense.size();
        let (mut steps, mut too_few, mut nearest, mut idle) = (1_u64, 0, None::<Trial>, 0);
        loop {
            let (found, growth) = self.at(row, steps)?;
            if self.holds(&found) {
                let twice = self.at(row, 2 * steps)?.0;
                if self.holds(&twice) {
                    return Ok(Ok(Bracket { too_few, good: steps, nearest }));
                }
            }
            if self.bench.progress.stopped() {
                return Ok(Err(Reached::Not(nearest.map(Box::new), INTERRUPTED.into())));
            }
            too_few = steps;
            let now = found.decisive;
            let before = nearest.as_ref().map_or(f64::INFINITY, |trial| trial.decisive);
            let stays = now > bound && now > 0.5 * before && now < IDLE_ERROR * size;
            idle = if stays { idle + 1 } else { 0 };
            if nearest.is_none() || now < before {
                nearest = Some(found);
            }
            if let Some(why) = given_up(idle, growth.err(), now.min(before), steps) {
                return Ok(Err(Reached::Not(nearest.map(Box::new), why)));
            }
            // Once errors fall at their order, it predicts the number of steps.
            let share = now / bound;
            let falls = now < SMALL_ERROR * size && idle == 0;
            let leap = if falls { (1.05 * share.powf(1.0 / order)).clamp(1.1, 64.0) } else { 2.0 };
            steps = (steps as f64 * leap.min(growth.unwrap_or(leap))).ceil() as u64;
        }
    }

    /// The setting, or the next safer one, that is within the bound together with all its
    /// neighbours and the finer run.
    fn confirmed(
        &mut self,
        from: Choice,
        lacks: Option<&'static str>,
    ) -> Result<Option<(Candidate, Choice)>, IntegrateError> {
        let first = self.run(from)?;
        let refused = |run: Trial, why: String| {
            Ok(Some((Candidate { run, why_not: Some(why), checked: None, times: None }, from)))
        };
        if let Some(lacks) = lacks {
            return refused(first, lacks.into());
        }
        let (mut setting, mut worst) = (from, None::<Trial>);
        for _ in 0..MOST_CHECKED {
            let trial = self.run(setting)?;
            let finer = setting.finer();
            let mut beside = setting.neighbours();
            beside.extend(finer);
            let mut failed = (!self.holds(&trial)).then(|| trial.clone());
            let mut most: f64 = trial.decisive;
            for &neighbour in &beside {
                if failed.is_some() || self.bench.progress.stopped() {
                    break;
                }
                let other = self.run(neighbour)?;
                most = most.max(other.decisive);
                failed = (!self.holds(&other)).then_some(other);
            }
            if self.bench.progress.stopped() {
                return refused(first, INTERRUPTED.into());
            }
            let Some(other) = failed else {
                let why_not = self.flaw(&trial)?;
                if why_not.is_none() {
                    self.qualifies(setting)?;
                }
                let checked = Some(Checked { settings: beside.len() as u64, most });
                return Ok(Some((
                    Candidate { run: trial, why_not, checked, times: None },
                    setting,
                )));
            };
            worst = Some(other);
            match setting.safer().filter(|_| self.started.elapsed() < MOST_CHECK_TIME) {
                Some(safer) => setting = safer,
                None => break,
            }
        }
        let said = worst.map_or(String::new(), |trial| {
            format!(", as with {}, where the error is {:.1e}", trial.setting(), trial.decisive)
        });
        refused(first, format!("no setting beside it holds with all its neighbours{said}"))
    }

    /// Records the time of a run that qualifies.
    fn qualifies(&self, setting: Choice) -> Result<(), IntegrateError> {
        let clock = ThreadTime::now();
        self.bench.run(setting)?;
        let nanoseconds = u64::try_from(clock.elapsed().as_nanos()).unwrap_or(u64::MAX);
        self.shortest.fetch_min(nanoseconds, Ordering::Relaxed);
        Ok(())
    }

    /// The requirement that a run within the bound does not meet, in words, if any.
    fn flaw(&self, trial: &Trial) -> Result<Option<String>, IntegrateError> {
        let Bench { wanted, dense, problem, .. } = self.bench;
        let drift = dense.largest_energy(problem)?.share(trial.k_drift);
        if wanted.keep_k && (drift > KEPT || drift.is_nan()) {
            return Ok(Some(format!("K drifts by {:.1e}", trial.k_drift)));
        }
        let taken = trial.passivity_violations.filter(|&count| wanted.passive && count > 0);
        Ok(taken.map(|count| format!("{count} of its steps violate passivity")))
    }
}

/// Numbers of steps between which the fewest within the bound lie.
struct Bracket {
    /// Too few steps, or 0.
    too_few: u64,
    good: u64,
    /// The nearest of the runs with fewer steps.
    nearest: Option<Trial>,
}

/// The reason for which no more steps are tried, if the search is given up. `best` is the least
/// error so far.
fn given_up(idle: u32, enough: Option<&str>, best: f64, steps: u64) -> Option<String> {
    match enough {
        _ if idle == MOST_IDLE_SEARCHES => {
            Some(format!("its error stays at {best:.1e} however small the step"))
        }
        Some(enough) if best.is_infinite() => {
            Some(format!("no run reached the end, up to {steps} steps: {enough}"))
        }
        Some(enough) => Some(format!("at {steps} steps its error is still {best:.1e}: {enough}")),
        None => None,
    }
}

/// The result of the search for the number of steps.
enum Reached {
    /// This many steps are within the bound.
    Within(u64),
    /// The nearest run, and the reason for which none is nearer.
    Not(Option<Box<Trial>>, String),
}

/// The check of a setting.
#[derive(Clone, Copy, Debug, serde::Serialize)]
pub struct Checked {
    /// The number of settings tried: the neighbours and the finer one.
    pub settings: u64,
    /// The largest error of the setting and its neighbours.
    pub most: f64,
}

pub(super) const INTERRUPTED: &str = "interrupted before it was found or checked";

/// The requirement that a method does not promise to meet, if any.
fn lack(keeps_k: bool, passive: bool, wanted: Wanted) -> Option<&'static str> {
    match (wanted.keep_k && !keeps_k, wanted.passive && !passive) {
        (true, _) => Some("it does not keep K"),
        (_, true) => Some("it may take energy back from the reservoir"),
        _ => None,
    }
}
