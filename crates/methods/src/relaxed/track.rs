//! The data that a step leaves for the next: its lag behind the grid point, its γ, and the target
//! K.

use afterbay_core::{Scalar, State, System, Vector};

/// The data available at the beginning of a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Known<T> {
    /// The time of the state minus the time of its grid point.
    pub(super) lag: T,
    /// γ of the last step.
    pub(super) gamma: T,
    /// H at the state.
    pub(super) energy: T,
    /// The target value of K.
    pub(super) total: T,
}

/// The end of the last step, and the data known there.
#[derive(Clone, Debug)]
pub(super) struct Track<V: Vector> {
    q: V,
    p: V,
    w: V,
    last: Option<(V::Scalar, Known<V::Scalar>)>,
}

/// The largest distance from 1 of a γ that is used as a prediction.
const LARGEST_PREDICTED_DEVIATION: f64 = 0.1;

impl<V: Vector> Track<V> {
    pub(super) fn new(n: usize) -> Self {
        Self { q: V::zeros(n), p: V::zeros(n), w: V::zeros(n), last: None }
    }

    /// Returns the data for a step h from `state`.
    pub(super) fn known<S: System<V::Scalar> + ?Sized>(
        &self,
        system: &S,
        h: V::Scalar,
        state: &State<V>,
    ) -> Known<V::Scalar> {
        let (zero, one) = (V::Scalar::zero(), V::Scalar::one());
        let same = |ours: &V, theirs: &V| ours.as_slice() == theirs.as_slice();
        let here = same(&self.q, &state.q) && same(&self.p, &state.p) && same(&self.w, &state.w);
        let Some((step, known)) = self.last.filter(|_| here) else {
            let energy = state.energy(system);
            return Known { lag: zero, gamma: one, energy, total: energy + state.reservoir() };
        };
        let small = known.lag.to_f64().abs() <= h.to_f64().abs() / 2.0;
        let deviation = (known.gamma - one).to_f64().abs();
        let predicts = step == h && deviation <= LARGEST_PREDICTED_DEVIATION;
        let lag = if small { known.lag } else { zero };
        Known { lag, gamma: if predicts { known.gamma } else { one }, ..known }
    }

    /// Stores the data after a step h that ended in `state`.
    pub(super) fn keep(&mut self, h: V::Scalar, state: &State<V>, known: Known<V::Scalar>) {
        self.q.as_mut_slice().copy_from_slice(state.q.as_slice());
        self.p.as_mut_slice().copy_from_slice(state.p.as_slice());
        self.w.as_mut_slice().copy_from_slice(state.w.as_slice());
        self.last = Some((h, known));
    }
}
