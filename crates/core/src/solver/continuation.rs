//! Continuation of the solution of an equation from s = 0, where it is known, to s = 1.
//!
//! Each step in s starts an iteration from the last solution. If the iteration converges the next
//! step is twice as long, else a quarter as long. Where steps become too short, the branch of
//! solutions ends in a fold or a fork.

use crate::numbers::{Mask, Scalar};

/// The first step in s, and the factors after a failure and after a success. A choice: a quarter
/// and a doubling keep failures to one in three attempts where the length of a step is limited.
const FIRST_STEP: f64 = 0.25;
const SHORTER: f64 = 0.25;
const LONGER: f64 = 2.0;

/// The limits at which a continuation gives up.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// The shortest step in s, between 0 and 1.
    pub shortest: f64,
    /// The largest number of evaluations, tested after a failure.
    pub evaluations: u32,
}

impl Limits {
    /// The limits for one or two equations. A choice: steps in s are shorter only at a fold or a
    /// fork.
    pub(super) const OF_FOLDS: Self = Self { shortest: 1e-6, evaluations: 10_000 };
}

/// The position of a continuation, lane by lane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Position<T> {
    s: T,
    stride: T,
    limits: Limits,
}

impl<T: Scalar> Position<T> {
    /// Begins at `s`, which is 1 in lanes that need no continuation.
    pub(super) fn at(s: T, limits: Limits) -> Self {
        Self { s, stride: T::from_f64(FIRST_STEP), limits }
    }

    /// The s of the last solution.
    pub(super) fn s(&self) -> T {
        self.s
    }

    /// Lanes in which s = 1.
    pub(super) fn arrived(&self) -> T::Mask {
        T::one().le(self.s)
    }

    /// The s at which to solve next.
    pub(super) fn next(&self) -> T {
        let next = self.s + self.stride;
        T::select(next.lt(T::one()), next, T::one())
    }

    /// Moves to [`Position::next`] in lanes that were solved there, and shortens the step in those
    /// that stalled. Returns whether the continuation goes on.
    pub(super) fn advance(&mut self, stalled: T::Mask, evaluations: u32) -> bool {
        let next = self.next();
        self.stride *= T::select(stalled, T::from_f64(SHORTER), T::from_f64(LONGER));
        self.s = T::select(stalled, self.s, next);
        let shortest = T::from_f64(self.limits.shortest);
        !stalled.any()
            || !(stalled.and(self.stride.lt(shortest)).any()
                || evaluations > self.limits.evaluations)
    }
}

/// Continues a solution from s = 0 to s = 1. `solve(s)` starts from the last solution and returns
/// the number of evaluations of all calls so far. If it fails, it also returns its failure and must
/// leave the last solution unchanged.
///
/// # Errors
/// The last failure of `solve`, where steps become too short or evaluations too many.
pub fn follow<E>(
    limits: Limits,
    mut solve: impl FnMut(f64) -> (u32, Result<(), E>),
) -> Result<(), E> {
    let mut position = Position::at(0.0, limits);
    while !position.arrived() {
        let (evaluations, outcome) = solve(position.next());
        if !position.advance(outcome.is_err(), evaluations) {
            return outcome;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The points at which `follow` solves an equation with solutions wherever `solvable`.
    fn visited(limits: Limits, solvable: impl Fn(f64) -> bool) -> (Vec<f64>, Result<(), ()>) {
        let mut visited = Vec::new();
        let outcome = follow(limits, |s| {
            visited.push(s);
            (visited.len() as u32, if solvable(s) { Ok(()) } else { Err(()) })
        });
        (visited, outcome)
    }

    #[test]
    fn steps_double_until_one() {
        let limits = Limits { shortest: 1e-3, evaluations: 100 };
        assert_eq!(visited(limits, |_| true), (vec![0.25, 0.75, 1.0], Ok(())));
    }

    #[test]
    fn a_branch_that_ends_is_followed_to_its_end() {
        let limits = Limits { shortest: 1e-3, evaluations: 1000 };
        let (visited, outcome) = visited(limits, |s| s < 0.6);
        let last = visited.iter().copied().filter(|&s| s < 0.6).fold(0.0, f64::max);
        assert!(outcome.is_err() && 0.6 - last < 4e-3, "{last}");
    }

    #[test]
    fn evaluations_are_limited() {
        let limits = Limits { shortest: 1e-9, evaluations: 5 };
        let (visited, outcome) = visited(limits, |_| false);
        assert!(outcome.is_err() && visited.len() == 6);
    }
}
