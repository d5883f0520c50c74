//! The errors allowed for a step, and what a kink on its way changes in them.

use super::engine::Engine;
use crate::adaptive::{KINK_ORDER, Passage, REFUSED_ERROR, roundings_of_time};
use afterbay_core::{Curvature, Scalar, State, Vector};

/// The errors allowed for a step and the order of its error.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// The errors of q, p and energies allowed at the end of the run.
    pub(super) scales: [f64; 3],
    /// The share of them allowed for this step.
    pub(super) share: f64,
    /// Whether the step passes no kink.
    pub(super) smooth: bool,
    pub(super) order: u32,
    /// The error of the step, relative to the allowed one, is at least this.
    pub(super) least_error: f64,
}

impl<V: Vector, const K: usize> Engine<V, K> {
    /// The limits of a step that would be allowed this share of these errors if it were smooth.
    ///
    /// A step across a kink is short because of the kink, so that its share is that of a step of
    /// mean length. A step that may pass a kink and return is refused.
    #[inline(always)]
    pub(super) fn limits<S: Curvature<V::Scalar> + ?Sized>(
        &mut self,
        system: &S,
        state: &State<V>,
        scales: [f64; 3],
        share: f64,
    ) -> Limits {
        let smooth = Limits { scales, share, smooth: true, order: 2 * K as u32, least_error: 0.0 };
        if !self.kinks.begin(system, state.q.as_slice(), state.p.as_slice()) {
            return smooth;
        }
        match self.passage(system, state) {
            Passage::Smooth => smooth,
            passage => self.limits_across(passage, state, share),
        }
    }

    /// The limits of a step across a kink.
    #[cold]
    fn limits_across(&self, passage: Passage, state: &State<V>, share: f64) -> Limits {
        let share = share.max(self.budget.equal_share(self.h.to_f64().abs()));
        let mut scales = self.budget.scales(state, self.energy, share);
        let Self { start, last, free, .. } = self;
        let slopes = [[&start.v, &start.f], [&last.v, &last.f]];
        let least = roundings_of_time(state.t, slopes, *free);
        for (scale, least) in scales.iter_mut().zip(least) {
            *scale = scale.max(least / share);
        }
        let least_error = if passage == Passage::Returned { REFUSED_ERROR } else { 0.0 };
        Limits { scales, share, smooth: false, order: KINK_ORDER, least_error }
    }

    /// Looks for kinks between the start, the nodes and the end of the step.
    #[cold]
    fn passage<S: Curvature<V::Scalar> + ?Sized>(
        &mut self,
        system: &S,
        state: &State<V>,
    ) -> Passage {
        let Self { kinks, gauss, trial, end, .. } = self;
        for ((&node, q), p) in gauss.nodes.iter().zip(&trial.q).zip(&trial.p) {
            kinks.add(system, node, [q.as_slice(), p.as_slice()]);
        }
        kinks.add(system, V::Scalar::one(), [end.q.as_slice(), end.p.as_slice()]);
        kinks.passage(self.h, state.t)
    }
}
