//! References from runs: increment-8 with steps halved repeatedly, and methods of two other
//! families at tight tolerances. Of the two runs that agree best, one is the reference and the
//! other its check.

use super::super::{Problem, method};
use crate::Solution;
use crate::measured::Doubt;
use crate::progress::Progress;
use afterbay_core::{Grid, InputError, IntegrateError, Scalar, State, StateRef, Tolerance};
use afterbay_methods::registry::Setting;
use std::ops::ControlFlow;

/// The largest difference of two runs that agree, relative to the largest |q_j|, |p_j| or |w_j|.
const AGREEMENT: f64 = 1e-12;
/// Differences below this share of the largest of them that no longer fall are roundings. Above it
/// the errors may not have reached their order yet, and the search goes on.
const LARGEST_ROUNDING: f64 = 1e-9;
/// The number of successive differences without a decrease after which the search ends.
const IDLE: u32 = 2;
/// The longest step tried, as far as the work allows.
const COARSEST: f64 = 0.1;
/// The most steps of a run, times the number of degrees of freedom.
const MOST_WORK: u64 = 4_000_000;
/// Tolerances for the methods that choose their steps.
const TOLERANCES: [f64; 2] = [1e-10, 1e-12];
/// Methods of other families: explicit, and for stiff systems.
const FAMILIES: [&str; 2] = ["adaptive-dop853", "adaptive-collocation"];
/// The most degrees of freedom of an implicit run, which solves dense equations.
const LARGEST_DENSE: usize = 64;

/// The reference at the times `i h`, i = 0..=count.
pub(super) fn by_runs(
    problem: &Problem,
    h: f64,
    count: usize,
    progress: &dyn Progress,
) -> Result<Solution<f64>, IntegrateError> {
    let halved = halved(problem, h, count, progress);
    match halved {
        Err(IntegrateError::Interrupted) => return Err(IntegrateError::Interrupted),
        Ok((found, true)) => return Ok(found),
        _ => {}
    }
    let (mut others, mut failure): (Vec<Solution<f64>>, _) = (Vec::new(), None);
    for name in FAMILIES {
        if name == FAMILIES[1] && problem.model.dof() > LARGEST_DENSE {
            continue;
        }
        for tolerance in TOLERANCES {
            match by_tolerance(problem, name, tolerance, h, count, progress) {
                Ok(found) => others.push(found),
                Err(IntegrateError::Interrupted) => return Err(IntegrateError::Interrupted),
                // A run that fails is no reference, but the others may be.
                Err(error) => failure = Some(error),
            }
        }
    }
    let mut best = halved.as_ref().ok().map(|(found, _)| found.clone());
    let all: Vec<&Solution<f64>> = halved.iter().map(|(found, _)| found).chain(&others).collect();
    for (i, first) in all.iter().enumerate().rev() {
        for second in &all[..i] {
            let found = checked(first, second, 2.0);
            if best.as_ref().is_none_or(|best| found.doubt().most() < best.doubt().most()) {
                best = Some(found);
            }
        }
    }
    match (best, halved) {
        (Some(found), _) => Ok(found),
        // The user did not ask for increment-8, whose conditions a system may not fulfil.
        (None, Err(IntegrateError::Input(input))) => {
            Err(failure.unwrap_or(IntegrateError::Input(input)))
        }
        (None, Err(error)) => Err(error),
        (None, Ok((found, _))) => Ok(found),
    }
}

/// The solution `found`, with a doubt at each time of `factor` times its largest distance from
/// `other` up to then.
pub(super) fn checked<T: Scalar>(
    found: &Solution<T>,
    other: &Solution<T>,
    factor: f64,
) -> Solution<T> {
    let (mut checked, mut most) = (found.without_doubt(), Doubt::default());
    for i in 0..found.len() {
        let [q, p, w] = other.errors(i, found.at(i)).map(|off| factor * off.error);
        most = most.larger(Doubt { q, p, w });
        checked.raise_doubt(i, most);
    }
    checked
}

/// The number of progress reports of one run.
const REPORTS: u64 = 200;

/// A run of increment-8 with the step halved until the result no longer changes, and whether this
/// was reached. The doubt is the difference of the last two runs, since halving the step of a
/// method of order 8 divides the error by 256. If a kink prevents this, errors do not fall evenly,
/// and the larger of the last two differences counts.
fn halved(
    problem: &Problem,
    h: f64,
    count: usize,
    progress: &dyn Progress,
) -> Result<(Solution<f64>, bool), IntegrateError> {
    let (run, dof) = (problem.model.bind(method("increment-8")?)?, problem.model.dof());
    // The number of parts is odd at first, so that no run whose step is h halved repeatedly is
    // compared with itself.
    let affordable = MOST_WORK as f64 / (4.0 * (count * dof) as f64);
    let first = (h / COARSEST).ceil().min(affordable).max(3.0) as u64 | 1;
    let follow = |parts: u64| -> Result<Solution<f64>, IntegrateError> {
        let mut solution = Solution::with_room(&problem.model, count + 1);
        let grid = Grid::<f64>::of(h / parts as f64, count as u64 * parts)?;
        // Of all runs, were this the last; there are two at least.
        let (before, all) = (parts - first, (2 * parts).max(4 * first) - first);
        let between_reports = (count as u64).div_ceil(REPORTS) * parts;
        run.run(grid, &mut problem.start()?, 1, &mut |step, state| {
            if step % between_reports == 0 {
                let share = before as f64 + step as f64 / count as f64;
                progress.reference(share / all as f64);
            }
            if step % parts == 0 {
                solution.push(state);
            }
            progress.flow()
        })?;
        if progress.stopped() { Err(IntegrateError::Interrupted) } else { Ok(solution) }
    };
    let mut parts = first;
    let mut before = follow(parts);
    let (mut last, mut idle) = (f64::INFINITY, 0);
    let mut best: Option<Solution<f64>> = None;
    loop {
        if matches!(before, Err(IntegrateError::Interrupted | IntegrateError::Input(_))) {
            return before.map(|found| (found, false));
        }
        parts *= 2;
        if (parts * count as u64).saturating_mul(dof as u64) > MOST_WORK {
            return best.map_or_else(|| before, Ok).map(|found| (found, false));
        }
        let found = follow(parts);
        if let (Ok(before), Ok(found)) = (&before, &found) {
            let (doubt, size) = (found.distance(before).most(), found.size());
            idle = if doubt > last / 2.0 && doubt < LARGEST_ROUNDING * size { idle + 1 } else { 0 };
            let uneven = if doubt > last / 2.0 { (last / doubt).max(1.0) } else { 1.0 };
            let candidate = checked(found, before, if uneven.is_finite() { uneven } else { 1.0 });
            let settled = doubt <= AGREEMENT * size || idle == IDLE;
            let better = |best: &Solution<f64>| candidate.doubt().most() < best.doubt().most();
            if settled || best.as_ref().is_none_or(better) {
                best = Some(candidate);
            }
            if let Some(best) = best.take_if(|_| settled) {
                return Ok((best, true));
            }
            last = doubt;
        }
        before = found;
    }
}

/// A run of a method that takes a tolerance, from each of the times `i h`, i = 0..=count, to the
/// next.
fn by_tolerance(
    problem: &Problem,
    name: &'static str,
    tolerance: f64,
    h: f64,
    count: usize,
    progress: &dyn Progress,
) -> Result<Solution<f64>, IntegrateError> {
    let (run, dof) = (problem.model.bind(method(name)?)?, problem.model.dof());
    let most = MOST_WORK / dof as u64;
    let mut state: State<Vec<f64>> = problem.start()?;
    let mut solution = Solution::with_room(&problem.model, count + 1);
    solution.push(state.state_ref());
    let mut steps = 0;
    for i in 1..=count {
        let end = h * i as f64;
        let mut see = |_: u64, _: StateRef<'_, f64>| {
            steps += 1;
            if steps > most { ControlFlow::Break(()) } else { progress.flow() }
        };
        run.run(Setting::Tolerance(Tolerance::all(tolerance), end), &mut state, 1, &mut see)?;
        if progress.stopped() {
            return Err(IntegrateError::Interrupted);
        }
        if steps > most {
            return Err(InputError::Budget { steps: steps as f64, limit: most as f64 }.into());
        }
        solution.push(state.state_ref());
    }
    Ok(solution)
}
