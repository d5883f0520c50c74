//! A solution at equally spaced times, with a doubt.

use crate::Model;
use crate::measured::{Doubt, Measured};
use afterbay_core::{Accounts, Motors, Scalar, StateRef, larger_or_nan};

/// The states of a reference at equally spaced times, with a bound of the error of each.
#[derive(Clone, Debug)]
pub struct Solution<T> {
    /// The number of degrees of freedom, the clock and motors included.
    dof: usize,
    motors: Motors,
    /// q, p, w and t of each state.
    numbers: Vec<T>,
    doubts: Vec<Doubt>,
}

impl<T: Scalar> Solution<T> {
    /// An empty solution of a model with room for `count` states.
    pub(crate) fn with_room(model: &Model, count: usize) -> Self {
        let (dof, motors) = (model.dof(), model.motors());
        let (numbers, doubts) =
            (Vec::with_capacity(count * (3 * dof + 1)), Vec::with_capacity(count));
        Self { dof, motors, numbers, doubts }
    }

    /// The clock and the motors, which are the last degrees of freedom.
    pub(crate) fn motors(&self) -> &Motors {
        &self.motors
    }

    /// Appends a state with zero doubt.
    pub fn push(&mut self, state: StateRef<'_, T>) {
        for part in [state.q, state.p, state.w] {
            self.numbers.extend_from_slice(part);
        }
        self.numbers.push(state.t);
        self.doubts.push(Doubt::default());
    }

    /// The number of states.
    pub fn len(&self) -> usize {
        self.doubts.len()
    }

    /// Whether there are no states.
    pub fn is_empty(&self) -> bool {
        self.doubts.is_empty()
    }

    /// The states in order of time.
    pub fn states(&self) -> impl ExactSizeIterator<Item = StateRef<'_, T>> {
        (0..self.len()).map(|i| self.at(i))
    }

    /// State number i, counted from 0. Its slices have one entry for each degree of freedom, the
    /// clock and motors included.
    pub fn at(&self, i: usize) -> StateRef<'_, T> {
        let size = 3 * self.dof + 1;
        let numbers = &self.numbers[i * size..(i + 1) * size];
        let [q, p, w] = [0, 1, 2].map(|part| &numbers[part * self.dof..(part + 1) * self.dof]);
        StateRef { q, p, w, t: numbers[size - 1] }
    }

    /// A bound of the error of state i.
    pub fn doubt_at(&self, i: usize) -> Doubt {
        self.doubts[i]
    }

    /// The largest doubt of all states.
    pub fn doubt(&self) -> Doubt {
        self.doubts.iter().copied().fold(Doubt::default(), Doubt::larger)
    }

    /// The errors of q, p and w of a state computed for time i, each the largest over the degrees
    /// of freedom, with the doubt of the reference. With motors, w is the energy dissipated alone:
    /// what they supply follows from it and from (q, p), since K is constant.
    pub fn errors(&self, i: usize, found: StateRef<'_, T>) -> [Measured; 3] {
        let Doubt { q, p, w } = self.doubts[i];
        let [of_q, of_p, of_w] = apart(found, self.at(i), &self.motors);
        [(of_q, q), (of_p, p), (of_w, w)].map(|(error, doubt)| Measured { error, doubt })
    }

    /// The largest |q_j|, |p_j| and |w_j| of all states, without clock and motors.
    pub(crate) fn sizes(&self) -> [f64; 3] {
        let larger = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|k| a[k].max(b[k]));
        self.states().map(|state| sizes_of(state, &self.motors)).fold([0.0; 3], larger)
    }

    /// The states rounded to `f64`. The roundings are added to the doubt.
    pub fn rounded(&self) -> Solution<f64> {
        let numbers: Vec<f64> = self.numbers.iter().map(|x| x.to_f64()).collect();
        let rounding = |part: &[T]| {
            let lost = part.iter().map(|&x| (x - T::from_f64(x.to_f64())).abs().to_f64());
            lost.fold(0.0, f64::max)
        };
        let n = self.dof - self.motors.count();
        let doubt = |(state, &doubt): (StateRef<'_, T>, &Doubt)| {
            let [q, p] = [state.q, state.p].map(|part| rounding(&part[..n]));
            // An account is the sum of w_j and the momentum of a motor.
            doubt + Doubt { q, p, w: rounding(state.w) + rounding(&state.p[n..]) }
        };
        let doubts = self.states().zip(&self.doubts).map(doubt).collect();
        Solution { dof: self.dof, motors: self.motors.clone(), numbers, doubts }
    }

    /// A copy with zero doubt at every state.
    pub(crate) fn without_doubt(&self) -> Self {
        let doubts = vec![Doubt::default(); self.doubts.len()];
        Self { doubts, ..self.clone() }
    }

    /// Raises the doubt of state i to at least `doubt`.
    pub(crate) fn raise_doubt(&mut self, i: usize, doubt: Doubt) {
        self.doubts[i] = self.doubts[i].larger(doubt);
    }

    /// Raises the doubt of the last state to at least `doubt`.
    pub(crate) fn doubt_last(&mut self, doubt: Doubt) {
        if let Some(last) = self.doubts.last_mut() {
            *last = last.larger(doubt);
        }
    }
}

impl Solution<f64> {
    /// The largest |q_j|, |p_j| or |w_j| of all states. Each kind alone may be 0 at all of them, as
    /// p is where the motion turns.
    pub fn size(&self) -> f64 {
        self.sizes().into_iter().fold(0.0, f64::max)
    }

    /// The largest distances from another solution at the same times.
    pub fn distance(&self, other: &Self) -> Doubt {
        let apart = self.states().zip(other.states()).map(|(a, b)| apart(a, b, &self.motors));
        apart.map(|[q, p, w]| Doubt { q, p, w }).fold(Doubt::default(), Doubt::larger)
    }
}

/// The largest differences of q_j, of p_j and of the energies w_j dissipated. Coordinates of motors
/// are times and their momenta are energies, so that they count in w alone.
pub(crate) fn apart<T: Scalar>(
    a: StateRef<'_, T>,
    b: StateRef<'_, T>,
    motors: &Motors,
) -> [f64; 3] {
    if motors.is_empty() {
        return [distance(a.q, b.q), distance(a.p, b.p), distance(a.w, b.w)];
    }
    let n = a.q.len() - motors.count();
    let [of_a, of_b] = [a, b].map(|state| accounts(state, motors).w);
    [distance(&a.q[..n], &b.q[..n]), distance(&a.p[..n], &b.p[..n]), distance(&of_a, &of_b)]
}

/// The doubt of the first of two states computed for the same time: twice their distance, since
/// their errors may be correlated.
pub(crate) fn twice_apart<T: Scalar>(
    a: StateRef<'_, T>,
    b: StateRef<'_, T>,
    motors: &Motors,
) -> Doubt {
    let [q, p, w] = apart(a, b, motors).map(|off| 2.0 * off);
    Doubt { q, p, w }
}

/// The energies exchanged up to a state of a model with these motors, which fit each other.
pub(crate) fn accounts<T: Scalar>(state: StateRef<'_, T>, motors: &Motors) -> Accounts<T> {
    afterbay_core::accounts(state, motors).expect("the states of a model have its motors")
}

/// The largest |q_j|, |p_j| and |w_j| of a state, without clock and motors.
pub(crate) fn sizes_of<T: Scalar>(state: StateRef<'_, T>, motors: &Motors) -> [f64; 3] {
    let n = state.q.len() - motors.count();
    let w = accounts(state, motors).w;
    let largest = |part: &[T]| part.iter().map(|x| x.abs().to_f64()).fold(0.0, f64::max);
    [&state.q[..n], &state.p[..n], &w].map(largest)
}

/// The largest difference of two vectors; NaN if either contains NaN.
pub(crate) fn distance<T: Scalar>(a: &[T], b: &[T]) -> f64 {
    let differences = a.iter().zip(b).map(|(&a, &b)| (a - b).abs().to_f64());
    differences.fold(0.0, larger_or_nan)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_difference_that_is_no_number_stays_none() {
        assert!(distance(&[f64::NAN, 1.0], &[0.0, 0.9]).is_nan());
        assert!(distance(&[1.0, f64::INFINITY], &[0.9, f64::INFINITY]).is_nan());
        assert_eq!(distance(&[1.0, 2.0], &[1.5, 1.0]), 1.0);
    }
}
