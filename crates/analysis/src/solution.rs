//! A solution at equally spaced times.

use afterbay_core::{Scalar, View};

/// The states of a solution one after the other: the exact one, or what stands in for it.
#[derive(Clone, Debug)]
pub struct Solution<T> {
    dof: usize,
    /// q, p, w and t of each state.
    numbers: Vec<T>,
    /// How far two independent computations of it are apart; 0 where it is known to rounding.
    pub doubt: f64,
}

impl<T: Scalar> Solution<T> {
    /// Room for `count` states of `dof` degrees of freedom, none of them there yet.
    pub fn with_room(dof: usize, count: usize) -> Self {
        Self { dof, numbers: Vec::with_capacity(count * (3 * dof + 1)), doubt: 0.0 }
    }

    /// Adds a state.
    pub fn push(&mut self, state: View<'_, T>) {
        for part in [state.q, state.p, state.w] {
            self.numbers.extend_from_slice(part);
        }
        self.numbers.push(state.t);
    }

    /// The states.
    pub fn states(&self) -> impl ExactSizeIterator<Item = View<'_, T>> {
        (0..self.numbers.len() / (3 * self.dof + 1)).map(|i| self.at(i))
    }

    /// The state i, one of those that were added.
    pub fn at(&self, i: usize) -> View<'_, T> {
        let size = 3 * self.dof + 1;
        let numbers = &self.numbers[i * size..(i + 1) * size];
        let [q, p, w] = [0, 1, 2].map(|part| &numbers[part * self.dof..(part + 1) * self.dof]);
        View { q, p, w, t: numbers[size - 1] }
    }

    /// The same in `f64`.
    pub fn rounded(&self) -> Solution<f64> {
        let numbers = self.numbers.iter().map(|x| x.to_f64()).collect();
        Solution { dof: self.dof, numbers, doubt: self.doubt }
    }

    /// The largest difference to another solution at the same times, and the largest number in this one.
    pub fn distance(&self, other: &Self) -> (f64, f64) {
        let differences = self.numbers.iter().zip(&other.numbers).map(|(&a, &b)| (a - b).abs().to_f64());
        let largest = self.numbers.iter().map(|x| x.abs().to_f64()).fold(0.0, f64::max);
        (differences.fold(0.0, f64::max), largest)
    }
}
