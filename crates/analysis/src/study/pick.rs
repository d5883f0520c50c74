//! The cheapest method and step that meets an error, measured on the problem itself.
//!
//! For each method of the registry the number of steps is raised until the errors of (q, p) and of
//! w, at up to [`SAMPLES`] times along the run, are within the bound, then taken back by bisection
//! to the least that does. A step is recommended where every step within 5 % of it and half of it
//! do as well: what meets the bound by chance, or lies near a change of basin, does not. Methods
//! that choose their steps are searched by tolerance in the same way. The times of what qualifies
//! are taken one after the other. The winner is compared with a run of twice as many steps: by how
//! much the two differ is an error estimate that needs no reference.

mod dense;
mod search;
mod sensitivity;
mod setting;
mod trial;

use super::Problem;
use crate::measured::Doubt;
use crate::progress::Progress;
use afterbay_core::{IntegrateError, Passive, StateRef};
use afterbay_methods::registry::{ADAPTIVE, FIXED, Row};
use dense::Dense;
use rayon::prelude::*;
pub use search::Checked;
use search::{Found, Search};
pub use sensitivity::TooSensitive;
use serde::Serialize;
use setting::Choice;
use std::ops::ControlFlow;
use std::sync::atomic::AtomicU64;
use trial::Bench;
pub use trial::{SAMPLES, Trial};

/// What is wanted.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Wanted {
    /// The largest error of any q_j and p_j, and of any w_j: each of them counts.
    pub error: f64,
    /// Errors count at the end alone, and not on the way.
    pub at_end: bool,
    /// K is to be kept to rounding.
    pub keep_k: bool,
    /// No step is to violate passivity.
    pub passive: bool,
}

impl Wanted {
    /// Where errors count, in words.
    pub fn place(&self, end: f64) -> String {
        if self.at_end { format!("at t = {end}") } else { format!("all along to t = {end}") }
    }
}

/// A method at the setting it was found to need, or how near it came.
#[derive(Clone, Debug, Serialize)]
pub struct Candidate {
    /// Its run.
    #[serde(flatten)]
    pub run: Trial,
    /// Why it does not qualify.
    pub why_not: Option<String>,
    /// What was tried beside it; none where that was not reached.
    pub checked: Option<Checked>,
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
    /// Every run that was tried, method after method.
    pub tried: Vec<Trial>,
    /// The largest difference of (q, p) and of w between the winner and a run of twice as many
    /// steps, over common times (at the end, where steps follow from a tolerance).
    pub check: Option<[f64; 2]>,
    /// The largest doubt of the reference.
    pub doubt: Doubt,
    /// Why nothing was searched: the scene is too sensitive for the wanted error.
    pub too_sensitive: Option<TooSensitive>,
    /// The search was interrupted; what was found until then is here.
    pub interrupted: bool,
    /// Is the system passive, so that violations can be counted?
    pub owed: bool,
}

/// Measures every method that applies.
///
/// # Errors
/// Those of the input, and of the reference. What goes wrong in a run is why its method does not
/// qualify.
pub fn run(
    problem: &Problem,
    wanted: Wanted,
    progress: &dyn Progress,
) -> Result<Pick, IntegrateError> {
    let owed = problem.model.system::<f64>()?.dissipation_form().passive != Passive::No;
    let mut pick = Pick {
        wanted,
        qualified: Vec::new(),
        others: Vec::new(),
        tried: Vec::new(),
        check: None,
        doubt: Doubt::default(),
        too_sensitive: None,
        interrupted: false,
        owed,
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
    let mut found = rows
        .par_iter()
        .with_max_len(1)
        .map(|row| searched(Search::new(&bench, &shortest).steps(row)))
        .collect::<Result<Vec<_>, _>>()?;
    for row in ADAPTIVE {
        if !progress.stopped() {
            found.push(searched(Search::new(&bench, &shortest).tolerance(row))?);
        }
    }
    let mut qualified: Vec<(Candidate, Choice)> = Vec::new();
    for Found { candidate, tried } in found {
        pick.tried.extend(tried);
        match candidate {
            Some(one) if one.0.why_not.is_none() => qualified.push(one),
            one => pick.others.extend(one.map(|one| one.0)),
        }
    }
    progress.begin("times", qualified.len());
    for (Candidate { run, .. }, setting) in &mut qualified {
        if progress.stopped() {
            break;
        }
        let time = setting.time(problem, progress)?;
        run.seconds = (!progress.stopped()).then_some(time.as_secs_f64());
        progress.advance();
    }
    let seconds = |one: &(Candidate, Choice)| one.0.run.seconds.unwrap_or(f64::INFINITY);
    qualified.sort_by(|a, b| seconds(a).total_cmp(&seconds(b)));
    // What twice as many steps contradict is not recommended, whatever the reference says.
    while let Some((winner, setting)) = qualified.first() {
        pick.check = finer(problem, *setting, progress)?;
        let apart = pick.check.map_or(0.0, |[qp, w]| qp.max(w));
        if apart <= 2.0 * wanted.error || progress.stopped() {
            break;
        }
        let why = format!("a finer run differs from it by {apart:.1e}");
        pick.others.push(Candidate { why_not: Some(why), ..winner.clone() });
        qualified.remove(0);
    }
    pick.qualified = qualified.into_iter().map(|one| one.0).collect();
    pick.others.sort_by(|a, b| a.run.decisive.total_cmp(&b.run.decisive));
    Ok(())
}

/// How far a run is from one of twice as many steps, after the same steps; or from one of a quarter
/// of the tolerance, at the end. None where one of them fails.
fn finer(
    problem: &Problem,
    setting: Choice,
    progress: &dyn Progress,
) -> Result<Option<[f64; 2]>, IntegrateError> {
    let Some(finer) = setting.finer() else { return Ok(None) };
    let follow = |setting: Choice, parts: u64| -> Result<Option<Vec<f64>>, IntegrateError> {
        let (mut state, mut seen) = (problem.start::<f64>()?, Vec::new());
        let look = &mut |_: u64, state: StateRef<'_, f64>| {
            if matches!(setting, Choice::Steps(..)) {
                seen.extend([state.q, state.p, state.w].concat());
            }
            if progress.stopped() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let every = match setting {
            Choice::Tolerance(..) => 1,
            Choice::Steps(_, steps) => parts * (steps / parts).div_ceil(SAMPLES),
        };
        let method = problem.model.bind(setting.row())?;
        let done = method.run(setting.setting(problem.end)?, &mut state, every, look).is_ok();
        seen.extend([&state.q[..], &state.p, &state.w].concat());
        Ok((done && !progress.stopped()).then_some(seen))
    };
    let (Some(coarse), Some(fine)) = (follow(setting, 1)?, follow(finer, 2)?) else {
        return Ok(None);
    };
    let n = problem.model.dof();
    let mut apart = [0.0_f64; 2];
    for (i, (a, b)) in coarse.iter().zip(&fine).enumerate() {
        let part = usize::from(i % (3 * n) >= 2 * n);
        apart[part] = apart[part].max((a - b).abs());
    }
    Ok(Some(apart))
}
