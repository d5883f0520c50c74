//! The cheapest method and step that meets an error bound, measured on the problem itself.
//!
//! For each method of the registry the number of steps is raised until the errors of (q, p) and of
//! w, at up to [`SAMPLES`] times along the run, are within the bound. Bisection then finds the
//! least such number to 5 %. A step is recommended only if all steps tried within 5 % of it and
//! half of it are within the bound too. This excludes steps that meet the bound by chance or lie
//! near a change of basin. Methods that choose their steps are searched by tolerance in the same
//! way. The settings that qualify are timed one after another, those near the fastest several
//! times. The winner is compared with a run of twice as many steps: their difference is an error
//! estimate that needs no reference.

mod dense;
mod search;
mod sensitivity;
mod setting;
mod times;
mod trial;

use super::Problem;
use crate::Solution;
use crate::digits::in_full;
use crate::measured::Doubt;
use crate::progress::Progress;
use afterbay_core::{IntegrateError, Passive, StateRef, larger_or_nan};
use afterbay_methods::registry::{ADAPTIVE, FIXED, Row};
use dense::Dense;
use rayon::prelude::*;
pub use search::Checked;
use search::{Found, Search};
pub use sensitivity::TooSensitive;
use serde::Serialize;
use setting::Choice;
use std::sync::atomic::AtomicU64;
pub use times::Times;
use trial::Bench;
pub use trial::{SAMPLES, Trial};

/// The requirements.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Wanted {
    /// The largest error allowed for every q_j, p_j and w_j, in the unit of each.
    pub error: f64,
    /// Whether errors count at the end only.
    pub at_end: bool,
    /// Whether K must be kept to rounding.
    pub keep_k: bool,
    /// Whether no step may violate passivity.
    pub passive: bool,
}

impl Wanted {
    /// The times at which errors count, in words.
    pub fn place(&self, end: f64) -> String {
        let end = in_full(end);
        if self.at_end { format!("at t = {end}") } else { format!("all along to t = {end}") }
    }
}

/// A method at the setting it needs, or at the nearest one that was found.
#[derive(Clone, Debug, Serialize)]
pub struct Candidate {
    /// The run at this setting.
    #[serde(flatten)]
    pub run: Trial,
    /// The requirement that the method does not meet, in words; none if it qualifies.
    pub why_not: Option<String>,
    /// The check of neighbouring settings; none if the search did not get that far.
    pub checked: Option<Checked>,
    /// Its times; none if it was not timed.
    pub times: Option<Times>,
}

/// The result of a search.
#[derive(Clone, Debug, Serialize)]
pub struct Pick {
    /// The requirements.
    pub wanted: Wanted,
    /// The methods that qualify, the cheapest first.
    pub qualified: Vec<Candidate>,
    /// The methods that do not qualify, the nearest first.
    pub others: Vec<Candidate>,
    /// The number of methods after the cheapest whose times differ from its time by no more than
    /// noise.
    pub ties: usize,
    /// Every run that was tried, method after method.
    pub tried: Vec<Trial>,
    /// The largest differences of (q, p) and of w between the winner and a run of twice as many
    /// steps, over common times (at the end only, where errors count there only or steps follow
    /// from a tolerance).
    pub check: Option<[f64; 2]>,
    /// The largest doubt of the reference.
    pub doubt: Doubt,
    /// The reason why nothing was searched, if the scene is too sensitive for the wanted error.
    pub too_sensitive: Option<TooSensitive>,
    /// Whether the search was interrupted. The result then contains what was found until then.
    pub interrupted: bool,
    /// Whether the system is known to be passive, so that violations can be counted.
    pub is_passive: bool,
    /// The largest |q_j|, |p_j| and |w_j| of the reference; 0 if it was not found.
    pub sizes: [f64; 3],
}

/// Measures every method that applies.
///
/// # Errors
/// Invalid input, and errors of the reference. A method whose run fails does not qualify.
pub fn run(
    problem: &Problem,
    wanted: Wanted,
    progress: &dyn Progress,
) -> Result<Pick, IntegrateError> {
    let is_passive = problem.model.passive()? != Passive::No;
    let mut pick = Pick {
        wanted,
        qualified: Vec::new(),
        others: Vec::new(),
        ties: 0,
        tried: Vec::new(),
        check: None,
        doubt: Doubt::default(),
        too_sensitive: None,
        interrupted: false,
        is_passive,
        sizes: [0.0; 3],
    };
    match fill(&mut pick, problem, progress) {
        Ok(()) | Err(IntegrateError::Interrupted) => {
            pick.interrupted = progress.stopped();
            Ok(pick)
        }
        Err(error) => Err(error),
    }
}

fn fill(pick: &mut Pick, problem: &Problem, progress: &dyn Progress) -> Result<(), IntegrateError> {
    let wanted = pick.wanted;
    progress.begin("reference", 1);
    let dense = Dense::new(problem, wanted.error, progress)?;
    pick.doubt = if wanted.at_end { dense.doubt_at_end() } else { dense.doubt() };
    pick.sizes = dense.sizes();
    pick.too_sensitive = sensitivity::judge(problem, wanted, &dense, progress)?;
    if pick.too_sensitive.is_some() {
        return Ok(());
    }
    let bench = Bench::new(problem, wanted, &dense, progress)?;
    let rows: Vec<&'static Row> =
        FIXED.iter().filter(|row| problem.model.bind(row).is_ok()).collect();
    let shortest = AtomicU64::new(u64::MAX);
    progress.begin("search for steps", rows.len() + ADAPTIVE.len());
    let searched = |search: Result<Found, IntegrateError>| {
        progress.advance();
        search
    };
    // Methods that choose their steps come first: where fixed steps are hopeless, as under a drive
    // that jumps, their time bounds the search of all others.
    let by_tolerance = ADAPTIVE
        .par_iter()
        .with_max_len(1)
        .map(|row| searched(Search::new(&bench, &shortest).tolerance(row)))
        .collect::<Result<Vec<_>, _>>()?;
    let mut found = rows
        .par_iter()
        .with_max_len(1)
        .map(|row| searched(Search::new(&bench, &shortest).steps(row)))
        .collect::<Result<Vec<_>, _>>()?;
    found.extend(by_tolerance);
    let mut qualified: Vec<(Candidate, Choice)> = Vec::new();
    for Found { candidate, tried } in found {
        pick.tried.extend(tried);
        match candidate {
            Some(one) if one.0.why_not.is_none() => qualified.push(one),
            one => pick.others.extend(one.map(|one| one.0)),
        }
    }
    times::measure(&mut qualified, problem, progress)?;
    let seconds = |one: &(Candidate, Choice)| one.0.run.seconds.unwrap_or(f64::INFINITY);
    qualified.sort_by(|a, b| seconds(a).total_cmp(&seconds(b)));
    // A winner contradicted by twice as many steps is not recommended, whatever the reference says.
    while let Some((winner, setting)) = qualified.first() {
        pick.check = finer(problem, *setting, wanted.at_end, progress)?;
        let apart = pick.check.map_or(0.0, |[qp, w]| larger_or_nan(qp, w));
        if apart <= 2.0 * wanted.error || progress.stopped() {
            break;
        }
        let why = format!("a finer run differs from it by {apart:.1e}");
        pick.others.push(Candidate { why_not: Some(why), ..winner.clone() });
        qualified.remove(0);
    }
    pick.qualified = qualified.into_iter().map(|one| one.0).collect();
    pick.ties = times::ties(&pick.qualified);
    pick.others.sort_by(|a, b| a.run.decisive.total_cmp(&b.run.decisive));
    Ok(())
}

/// The difference of (q, p) and of w of a run from one of twice as many steps, over common times
/// unless errors count `at_end` only, or from one of a quarter of the tolerance, at the end. None
/// if either fails.
fn finer(
    problem: &Problem,
    setting: Choice,
    at_end: bool,
    progress: &dyn Progress,
) -> Result<Option<[f64; 2]>, IntegrateError> {
    let Some(finer) = setting.finer() else { return Ok(None) };
    let follow = |setting: Choice, parts: u64| -> Result<Option<Solution<f64>>, IntegrateError> {
        let (mut state, mut seen) =
            (problem.start::<f64>()?, Solution::with_room(&problem.model, 1));
        let look = &mut |_: u64, state: StateRef<'_, f64>| {
            if matches!(setting, Choice::Steps(..)) && !at_end {
                seen.push(state);
            }
            progress.flow()
        };
        let every = match setting {
            Choice::Tolerance(..) => 1,
            Choice::Steps(_, steps) => parts * (steps / parts).div_ceil(SAMPLES),
        };
        let method = problem.model.bind(setting.row())?;
        let done = method.run(setting.setting(problem.end)?, &mut state, every, look).is_ok();
        seen.push(state.state_ref());
        Ok((done && !progress.stopped()).then_some(seen))
    };
    let (Some(coarse), Some(fine)) = (follow(setting, 1)?, follow(finer, 2)?) else {
        return Ok(None);
    };
    let apart = coarse.distance(&fine);
    Ok(Some([apart.qp(), apart.w]))
}
