//! The kinks that an explicit step passes.
//!
//! The stages are no points of the solution, so that kinks are looked for on the cubic polynomial
//! that has the states and slopes of both ends:
//!
//! ```text
//! z(s) = z0 + s Δz + s (1-s) [(1-s) (h z0' - Δz) + s (Δz - h z1')]      0 ≤ s ≤ 1
//! ```

use super::Workspace;
use super::estimate::KINK_CAUTION;
use crate::adaptive::{End, Passage, roundings_of_time, time_rounding};
use crate::runge_kutta::Embedded;
use afterbay_core::{Scalar, State, System, Vector};

/// The points between the start and the end, in units of the step. A choice.
const POINTS: [f64; 3] = [0.25, 0.5, 0.75];

impl<V: Vector> Workspace<V> {
    /// Looks for kinks on the way of the step, and shortly before it. The slope at the end is that
    /// of the last stage.
    #[inline]
    pub(super) fn passage<B, S>(&mut self, system: &S, h: V::Scalar, state: &State<V>) -> Passage
    where
        B: Embedded,
        S: System<V::Scalar> + ?Sized,
    {
        let mut passage = Passage::Smooth;
        self.near_kink = false;
        if self.kinks.begin(system, state.q.as_slice(), state.p.as_slice()) {
            passage = self.passage_of_kinks::<B, S>(system, h, state);
            self.near_kink = passage != Passage::Smooth || self.kinks.begins_near();
        }
        self.smooth = passage == Passage::Smooth;
        passage
    }

    #[cold]
    fn passage_of_kinks<B, S>(&mut self, system: &S, h: V::Scalar, state: &State<V>) -> Passage
    where
        B: Embedded,
        S: System<V::Scalar> + ?Sized,
    {
        let Self { stages, kinks, end: End { q, p, .. }, between, .. } = self;
        let [first, last] = [stages.slopes(0), stages.slopes(B::ROWS.len() - 1)];
        let parts = [(&state.q, &*q, first[0], last[0]), (&state.p, &*p, first[1], last[1])];
        for share in POINTS {
            let s = V::Scalar::from_f64(share);
            for (to, (start, end, before, after)) in between.iter_mut().zip(parts) {
                let ends = start.as_slice().iter().zip(end.as_slice());
                let slopes = before.as_slice().iter().zip(after.as_slice());
                for ((to, ends), slopes) in to.as_mut_slice().iter_mut().zip(ends).zip(slopes) {
                    let ((&z0, &z1), (&before, &after)) = (ends, slopes);
                    let (change, rest) = (z1 - z0, V::Scalar::one() - s);
                    let bend = rest * (h * before - change) + s * (change - h * after);
                    *to = z0 + s * (change + rest * bend);
                }
            }
            let [q, p] = &*between;
            kinks.add(system, s, [q.as_slice(), p.as_slice()]);
        }
        kinks.add(system, V::Scalar::one(), [q.as_slice(), p.as_slice()]);
        kinks.passage(h, state.t)
    }

    /// Allows for the changes of q and p in the roundings of t to which the time of a kink is
    /// known. An estimate of a much shorter step needs no caution.
    #[cold]
    pub(super) fn allow_roundings_of_time<B: Embedded>(
        &self,
        t: V::Scalar,
        errors_allowed: &mut [f64; 3],
    ) {
        let [first, last] = [0, B::ROWS.len() - 1].map(|stage| self.stages.velocity(stage));
        let short = KINK_CAUTION * self.length <= time_rounding(t);
        let caution = if short { KINK_CAUTION } else { 1.0 };
        let ends = [[first, &self.stages.start], [last, &self.stages.hq]];
        for (allowed, least) in errors_allowed.iter_mut().zip(roundings_of_time(t, ends, self.free))
        {
            *allowed = allowed.max(caution * least);
        }
    }
}
