//! The methods that make K exact: projection of (q, p), or a step of energy-preserving collocation.

use super::engine::Engine;
use crate::adaptive::is_rounding_at_rest;
use crate::collocation::{MOST_NODES, Workspace};
use crate::rounding::rounding;
use afterbay_core::{Curvature, Effort, Scalar, State, StepFailure, Vector};

/// The error of K, in roundings, that is accepted where the terms of H cancel.
const ACCEPTED_ROUNDINGS: f64 = 64.0;

impl<V: Vector, const K: usize> Engine<V, K> {
    /// Makes K exact by the smallest change of (q, p) in the scaled norm. If it exceeds the allowed
    /// change, returns the ratio of the two as the error.
    #[inline]
    pub(super) fn restore<S: Curvature<V::Scalar> + ?Sized>(
        &mut self,
        system: &S,
        before: V::Scalar,
        scales: [f64; 3],
        share: f64,
    ) -> Result<(), f64> {
        let Self { end, last, .. } = self;
        if end.project(system, [&last.hq, &last.v], before, scales, share)? {
            last.evaluate(system, [&end.q, &end.p]);
        }
        Ok(())
    }

    /// Ends the step without a projection, where nothing makes K exact and the error of K is a
    /// rounding of w or of the terms of H. Otherwise the step fails.
    #[cold]
    pub(super) fn keep_rounding<S: Curvature<V::Scalar> + ?Sized>(
        &mut self,
        system: &S,
        state: &State<V>,
        failure: StepFailure,
    ) -> Result<(), StepFailure> {
        self.finish(system, state);
        self.end.measure(system);
        let missing = self.end.target(self.energy) - self.end.energy;
        let z = [self.end.q.as_slice(), self.end.p.as_slice()];
        let is_rounding = is_rounding_at_rest(system, z, &state.w, missing.abs().to_f64());
        if is_rounding { Ok(()) } else { Err(failure) }
    }

    /// Takes the step by energy-preserving collocation.
    #[cold]
    pub(super) fn rounded<S: Curvature<V::Scalar> + ?Sized>(
        &mut self,
        system: &S,
        h: V::Scalar,
        state: &State<V>,
    ) -> Result<Effort, StepFailure> {
        let Self { gauss, trial, end, last, spare, .. } = self;
        let spare = spare.get_or_insert_with(|| {
            let mut spare = Workspace::new(system, K, 2 * K);
            // If the equations are hard to solve, a shorter step is better.
            spare.thorough = false;
            Box::new(spare)
        });
        let effort = spare.find(system, h, state)?;
        let roundings = spare.defect();
        // Measured at each such step, even if a larger rounding is known: the check of the gradient
        // that belongs to it ends a run that no longer advances at a kink of V.
        if roundings > ACCEPTED_ROUNDINGS {
            let (q, p) = (state.q.as_slice(), state.p.as_slice());
            let measured = spare.energy_rounding.measure(system, q, p)?;
            let error = roundings * rounding::<V::Scalar>(spare.scale());
            if error > ACCEPTED_ROUNDINGS * rounding::<V::Scalar>(measured) {
                return Err(StepFailure::Unresolved { nodes: MOST_NODES, roundings });
            }
        }
        for d in 0..state.dof() {
            let [v, f] = spare.slopes_at(d, &gauss.nodes);
            for i in 0..K {
                trial.v[i].as_mut_slice()[d] = v[i];
                trial.f[i].as_mut_slice()[d] = f[i];
            }
        }
        trial.place_and_dissipate(system, gauss, h, state);
        let [q, p, w] = spare.ends();
        end.q.as_mut_slice().copy_from_slice(q.as_slice());
        end.p.as_mut_slice().copy_from_slice(p.as_slice());
        for d in 0..state.dof() {
            end.gain.as_mut_slice()[d] = w.as_slice()[d] - state.w.as_slice()[d];
        }
        last.evaluate(system, [&end.q, &end.p]);
        end.measure(system);
        Ok(effort)
    }
}
