//! The cycle of one turn in a solution of several.
//!
//! With coarse steps the run of the first guess may return close to its start only after several
//! turns. The solution then crosses the plane through its start, in the direction in which it
//! began, once in each of them.

use super::shooting::{SINGULAR, Shooting, Solved};
use super::{Cycle, CycleFailure, at_rest, metric, phase, steps};
use crate::study::zero::at_zero;
use afterbay_core::{IntegrateError, State, StateRef};

/// The largest distance of a crossing from the start from which a cycle of fewer turns is looked
/// for, and of the states of both cycles, in the scales. A choice: the error of coarse steps.
const NEAR: f64 = 0.1;
/// The latest crossing that may end a first turn of several, as a share of the period.
const LATEST: f64 = 0.75;

/// The cycle with the fewest turns that a solution repeats, if it is not the solution itself. Both
/// are stable, or neither is: near a period doubling the cycle of one turn is another one.
///
/// # Errors
/// An interruption.
pub(super) fn fewer<'a>(
    shooting: &Shooting<'a>,
    solved: &Solved,
    h: f64,
) -> Result<Option<(Shooting<'a>, Solved)>, CycleFailure> {
    let stable = |shooting: &Shooting<'_>, Solved { x, image, .. }: &Solved| {
        Cycle::of(shooting, x, image).is_ok_and(|cycle| cycle.is_stable())
    };
    let metric = metric(shooting);
    for period in returns(shooting, solved)? {
        let mut part = Shooting {
            steps: steps(shooting.row, shooting.model, h, None, period)?,
            scales: shooting.scales.clone(),
            ..*shooting
        };
        let (size, mut x) = (shooting.size(), solved.x.clone());
        (x[size], part.scales[size]) = (period, period);
        let condition = phase(&part, &solved.image.path, &x);
        let once = match part.solve(x, &[condition]) {
            Err(CycleFailure::Run(IntegrateError::Interrupted)) => {
                return Err(IntegrateError::Interrupted.into());
            }
            Err(_) => continue,
            Ok(once) => once,
        };
        let turns = (solved.x[size] / once.x[size]).round();
        let repeats = (turns * once.x[size] / solved.x[size] - 1.0).abs() <= NEAR / turns
            && turns > 1.0
            && metric.distance(&solved.x[..size], &once.x[..size]) <= NEAR;
        let is_cycle = once.ratio > SINGULAR && at_rest(&part, &once).is_ok();
        if repeats && is_cycle && stable(&part, &once) == stable(shooting, solved) {
            return Ok(Some((part, once)));
        }
    }
    Ok(None)
}

/// The times at which a solution comes back near its start before its period ends, in order.
fn returns(shooting: &Shooting<'_>, solved: &Solved) -> Result<Vec<f64>, CycleFailure> {
    let Solved { x, image, .. } = solved;
    let (model, size, path) = (shooting.model, shooting.size(), &image.path);
    let (run, h) = (model.bind(shooting.row)?, image.period / shooting.steps as f64);
    let (metric, normal) = (metric(shooting), phase(shooting, path, x).normal);
    let off = |state: StateRef<'_, f64>| {
        metric.difference(&path[0], &[state.q, state.p].concat()).collect::<Vec<_>>()
    };
    let height = |state: StateRef<'_, f64>| {
        let parts = off(state).into_iter().zip(&normal).zip(&shooting.scales);
        parts.map(|((off, normal), scale)| normal * off / scale).sum::<f64>()
    };
    let node = |k: usize| {
        let (q, p) = path[k].split_at(size / 2);
        let w = vec![0.0; size / 2];
        let state = State { q: q.to_vec(), p: p.to_vec(), w, t: h * k as f64 };
        let height = height(state.state_ref());
        (state, height)
    };
    let (mut found, mut before) = (Vec::new(), node(1));
    for k in 2..(LATEST * shooting.steps as f64).ceil() as usize {
        let after = node(k);
        if before.1 < 0.0 && after.1 >= 0.0 {
            let there = at_zero(&run, h, height, &before.0, after.0.state_ref());
            if metric.largest(&off(there.state_ref())) <= NEAR {
                found.push(there.t);
            }
        }
        before = after;
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::super::LimitCycle;
    use super::*;
    use crate::Model;
    use crate::progress::Silent;
    use crate::study::Problem;
    use afterbay_methods::registry::find;
    use afterbay_systems::catalog::VAN_DER_POL;

    #[test]
    fn three_turns_of_a_cycle_are_one() {
        let model = Model::named(&VAN_DER_POL, [("mu", 1.0)]).expect("a system");
        let problem = Problem { model, q: vec![2.0], p: vec![0.0], end: 1.0 };
        let study =
            LimitCycle { problem: problem.clone(), transient: 30.0, multiple: None, branch: None };
        let (row, h) = (find("collocation-4").expect("a method"), 0.2);
        let (shooting, solved) = study.find(&problem, row, h, &Silent).expect("a cycle");
        assert!(fewer(&shooting, &solved, h).expect("no failure").is_none());
        let (mut x, mut scales) = (solved.x.clone(), shooting.scales.clone());
        (x[2], scales[2]) = (3.0 * x[2], 3.0 * scales[2]);
        let thrice = Shooting { steps: 3 * shooting.steps, scales, ..shooting };
        let condition = phase(&thrice, &solved.image.path, &x);
        let all = thrice.solve(x, &[condition]).expect("three turns");
        let (once, found) = fewer(&thrice, &all, h).expect("no failure").expect("one turn");
        assert_eq!(3 * once.steps, thrice.steps);
        assert!((found.x[2] - solved.x[2]).abs() < 1e-12, "{:?} {:?}", found.x, solved.x);
    }
}
