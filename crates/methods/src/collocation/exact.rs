//! K made exact: by a small change of (q, p), or by the collocation that keeps K of itself.

use super::engine::Engine;
use super::iteration::Workspace;
use super::rule::MOST;
use afterbay_core::{Curvature, Effort, Scalar, State, StepFailure, Vector};

/// Roundings of K that are not corrected, and those that are left where corrections change nothing.
const ROUNDINGS: [f64; 2] = [2.0, 16.0];
/// Roundings K may be off by where H is no better known: it cancels.
const LOST: f64 = 64.0;

impl<V: Vector, const K: usize> Engine<V, K> {
    /// Makes K exact by the smallest change of (q, p) that does, in units of what is allowed. Where it would be more than allowed, how much more.
    #[inline]
    pub(super) fn correct<S: Curvature<V::Scalar> + ?Sized>(
        &mut self,
        system: &S,
        before: V::Scalar,
        scales: [f64; 3],
        allowed: f64,
    ) -> Result<(), f64> {
        let Self { end, .. } = self;
        let n = end.q.as_slice().len();
        let zero = V::Scalar::zero();
        let (mut gained, mut steep, mut terms) = (zero, zero, zero);
        let squares = [scales[0], scales[1]].map(|s| V::Scalar::from_f64(s * s));
        for j in 0..n {
            let (hq, hp) = (end.hq.as_slice()[j], end.v.as_slice()[j]);
            gained += end.gain.as_slice()[j];
            steep += squares[0] * (hq * hq) + squares[1] * (hp * hp);
            terms += (hq * end.q.as_slice()[j]).abs() + (hp * end.p.as_slice()[j]).abs();
        }
        let scale = before.abs() + end.energy.abs() + gained.abs() + terms;
        let rounding = V::Scalar::EPSILON * scale.to_f64();
        let (mut way, mut before_that) = (0.0, f64::INFINITY);
        loop {
            let missing = end.energy - before + gained;
            let size = missing.abs().to_f64();
            // What no longer shrinks is as good as q and p can be told.
            if size <= ROUNDINGS[0] * rounding
                || (size <= ROUNDINGS[1] * rounding && size > 0.5 * before_that)
            {
                break;
            }
            way += size / steep.to_f64().sqrt();
            // Not a number is too large as well.
            if !(way <= allowed && size <= 0.5 * before_that) {
                return Err(way / allowed);
            }
            before_that = size;
            let lambda = missing / steep;
            for j in 0..n {
                let (hq, hp) = (end.hq.as_slice()[j], end.v.as_slice()[j]);
                end.q.as_mut_slice()[j] -= lambda * squares[0] * hq;
                end.p.as_mut_slice()[j] -= lambda * squares[1] * hp;
            }
            end.energy = system.energy(end.q.as_slice(), end.p.as_slice());
        }
        if way > 0.0 {
            end.look(system);
        }
        Ok(())
    }

    /// The step by the collocation that keeps K of itself.
    #[cold]
    pub(super) fn rounded<S: Curvature<V::Scalar> + ?Sized>(
        &mut self,
        system: &S,
        h: V::Scalar,
        state: &State<V>,
    ) -> Result<Effort, StepFailure> {
        let Self { gauss, trial, end, spare, .. } = self;
        let spare = spare.get_or_insert_with(|| Box::new(Workspace::new(system, K, 2 * K)));
        let effort = spare.find(system, h, state)?;
        let roundings = spare.defect();
        if roundings > LOST {
            return Err(StepFailure::Unresolved { nodes: MOST, roundings });
        }
        for d in 0..state.dof() {
            let [v, f] = spare.slopes_at(d, &gauss.nodes);
            for i in 0..K {
                trial.v[i].as_mut_slice()[d] = v[i];
                trial.f[i].as_mut_slice()[d] = f[i];
            }
        }
        trial.settle(system, gauss, h, state);
        let [q, p, w] = spare.ends();
        end.q.as_mut_slice().copy_from_slice(q.as_slice());
        end.p.as_mut_slice().copy_from_slice(p.as_slice());
        for d in 0..state.dof() {
            end.gain.as_mut_slice()[d] = w.as_slice()[d] - state.w.as_slice()[d];
        }
        end.look(system);
        end.energy = system.energy(end.q.as_slice(), end.p.as_slice());
        Ok(effort)
    }
}
