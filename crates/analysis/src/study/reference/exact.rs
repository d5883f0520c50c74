//! References of linear systems: their exact flow in 106 bits.

use super::super::{Problem, method};
use super::runs::checked;
use crate::Solution;
use crate::progress::Progress;
use afterbay_core::{Grid, IntegrateError, Quad};

/// The steps in which the time from one state to the next is taken. Both runs are exact but for
/// the roundings of 106 bits, which differ.
const PARTS: [u64; 2] = [1, 2];

/// The reference at the times `i h`, i = 0..=count; none if the system is not linear, or its flow
/// is not finite.
///
/// # Errors
/// An interruption.
pub(super) fn by_exact_flow(
    problem: &Problem,
    h: f64,
    count: usize,
    progress: &dyn Progress,
) -> Result<Option<Solution<Quad>>, IntegrateError> {
    let found = follow(problem, h, count, PARTS[0], progress)
        .and_then(|whole| Ok((whole, follow(problem, h, count, PARTS[1], progress)?)));
    match found {
        Ok((whole, halves)) => Ok(Some(checked(&whole, &halves, 2.0))),
        Err(IntegrateError::Interrupted) => Err(IntegrateError::Interrupted),
        // A system to which the method does not apply may have another reference.
        Err(_) => Ok(None),
    }
}

fn follow(
    problem: &Problem,
    h: f64,
    count: usize,
    parts: u64,
    progress: &dyn Progress,
) -> Result<Solution<Quad>, IntegrateError> {
    let run = problem.model.bind_in::<Quad>(method("linear-exact")?)?;
    let mut solution = Solution::with_room(&problem.model, count + 1);
    let grid = Grid::<Quad>::of(h / parts as f64, count as u64 * parts)?;
    run.run(grid, &mut problem.start()?, 1, &mut |step, state| {
        if step % parts == 0 {
            solution.push(state);
        }
        progress.flow()
    })?;
    if progress.stopped() { Err(IntegrateError::Interrupted) } else { Ok(solution) }
}
