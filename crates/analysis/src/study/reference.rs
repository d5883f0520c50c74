//! What stands in for the exact solution where series cost too much, or end at a kink: increment-8 at a step that is halved until
//! two runs agree.

use super::Problem;
use crate::Solution;
use crate::measured::Doubt;
use crate::progress::Progress;
use afterbay_core::{Grid, InputError, IntegrateError};
use afterbay_methods::registry;
use std::ops::ControlFlow;

/// With no more degrees of freedom than this a solution comes from Taylor series in 106 bits: exact to the last bit of what
/// it is compared to, at a cost that grows with N.
pub const LARGEST_BY_SERIES: usize = 16;

/// Two runs that differ by no more than this, beside the largest number in them, agree.
const AGREEMENT: f64 = 1e-12;
/// Runs that come no nearer, one after the other, come no nearer at all.
const IDLE: u32 = 2;
/// The first step tried, and the last.
const COARSEST: f64 = 0.1;
const FINEST: f64 = 1e-4;

/// The solution at the times `i h`, i = 0..=count, by self-convergence. Its doubt is the difference of the last two runs,
/// the second of which it is: halving the step of a method of order 8 makes the error 256 times smaller. Where rounding
/// or a kink comes first the runs stop to come nearer, and their difference is what it makes of them: the larger of the last two,
/// since at kinks errors do not fall evenly.
pub(super) fn self_converged(
    problem: &Problem,
    h: f64,
    count: usize,
    progress: &dyn Progress,
) -> Result<Solution<f64>, IntegrateError> {
    let row = registry::find("increment-8");
    let row = row.ok_or(InputError::Unsupported { method: "increment-8", why: "it is not registered" })?;
    let method = problem.model.bind(row)?;
    let follow = |parts: u64| -> Result<Solution<f64>, IntegrateError> {
        let mut solution = Solution::with_room(problem.model.dof(), count + 1);
        let grid = Grid::of(h / parts as f64, count as u64 * parts)?;
        method.run(grid, &mut problem.start()?, parts, &mut |_, state| {
            solution.push(state);
            if progress.stopped() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        })?;
        if progress.stopped() { Err(IntegrateError::Interrupted) } else { Ok(solution) }
    };
    // An odd number of parts to begin with: no run whose step is h halved is compared with itself.
    let mut parts = (h / COARSEST).ceil().max(3.0) as u64 | 1;
    let mut before = follow(parts);
    let (mut doubt_before, mut idle) = (f64::INFINITY, 0);
    loop {
        parts *= 2;
        let mut found = follow(parts);
        if matches!(found, Err(IntegrateError::Interrupted)) {
            return found;
        }
        let last = h / parts as f64 <= FINEST;
        if let (Ok(before), Ok(found)) = (&before, &mut found) {
            let (doubt, size) = found.distance(before);
            idle = if doubt > doubt_before / 2.0 { idle + 1 } else { 0 };
            let agreed = doubt <= AGREEMENT * size;
            let known = if idle > 0 && !agreed { doubt.max(doubt_before) } else { doubt };
            (0..found.len()).for_each(|i| found.raise_doubt(i, Doubt { qp: known, w: known }));
            if agreed || idle == IDLE || last {
                return Ok(found.clone());
            }
            doubt_before = doubt;
        } else if last {
            return found;
        }
        before = found;
    }
}
