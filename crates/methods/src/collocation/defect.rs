//! The new state of a step and its defect, the change of K over the step.
//!
//! The defect is `H1 - H0 + Σ Δw_j` in units of the rounding of these terms. Where the iteration
//! ends in rounding noise, [`Workspace::restore`] projects the new state onto the old value of K.

use super::iteration::{Problem, Workspace};
use super::nodes::losses;
use crate::adaptive::{LARGEST_PROJECTION, Projection};
use crate::commit::not_finite;
use crate::rounding::roundings;
use afterbay_core::{Curvature, Mask, Scalar, StepFailure, Vector};

impl<V: Vector> Workspace<V> {
    /// Computes z1, w1 and the defect.
    #[inline(never)]
    pub(super) fn finish<S: Curvature<V::Scalar> + ?Sized>(
        &mut self,
        problem: &Problem<'_, V, S>,
    ) -> Result<(), StepFailure> {
        let Problem { system, h, state, start, level } = *problem;
        let (n, zero) = (state.dof(), V::Scalar::zero());
        let Self { rules, nodes, slopes, q_modes, p_modes, q, p, w, .. } = self;
        if self.dissipative {
            losses(system, &rules[level], nodes, slopes, q_modes, w);
        }
        let (q, p, w) = (q.as_mut_slice(), p.as_mut_slice(), w.as_mut_slice());
        let (q0, p0, w0) = (state.q.as_slice(), state.p.as_slice(), state.w.as_slice());
        let mut finite = zero.is_finite();
        for j in 0..n {
            q[j] = h.mul_add(q_modes[j][0][0], q0[j]);
            p[j] = (-h).mul_add(p_modes[j][0][0], p0[j]);
            finite = finite.and(q[j].is_finite()).and(p[j].is_finite());
        }
        let mut gained = zero;
        if self.dissipative {
            for j in 0..n {
                gained = h.mul_add(w[j], gained);
                w[j] = h.mul_add(w[j], w0[j]);
                finite = finite.and(w[j].is_finite());
            }
        }
        if !finite.all() {
            return Err(not_finite([q, p, w]));
        }
        self.gained = gained;
        self.weigh(system, start);
        Ok(())
    }

    /// Computes the defect of the new state, and the sum of the terms of K.
    #[inline]
    fn weigh<S: Curvature<V::Scalar> + ?Sized>(&mut self, system: &S, start: V::Scalar) {
        let Self { slopes, q, p, gained, .. } = self;
        let (q, p, zero) = (q.as_slice(), p.as_slice(), V::Scalar::zero());
        let (hq, hp) = (slopes.hq[0].as_mut_slice(), slopes.hp[0].as_mut_slice());
        system.gradient(q, p, hq, hp);
        let terms =
            (0..q.len()).fold(zero, |sum, j| sum + (hq[j] * q[j]).abs() + (hp[j] * p[j]).abs());
        let end = system.energy(q, p);
        let scale = (start.abs() + end.abs() + gained.abs() + terms).to_f64();
        let defect = (end - start + *gained).abs().to_f64();
        self.scale = scale;
        self.defect = roundings::<V::Scalar>(defect, scale);
    }

    /// Moves the new state along ∇H until K equals its old value to rounding at both ends. Without
    /// this move, a long step leaves an error that is a rounding of the work along the step, which
    /// may be much larger.
    #[cold]
    pub(super) fn restore<S: Curvature<V::Scalar> + ?Sized>(
        &mut self,
        problem: &Problem<'_, V, S>,
    ) -> Result<(), StepFailure> {
        let (&Problem { system, start, .. }, before) = (problem, self.defect);
        let Self { slopes, q, p, gained, .. } = self;
        let (q, p) = (q.as_mut_slice(), p.as_mut_slice());
        let mut end = system.energy(q, p);
        let slope = [slopes.hq[0].as_slice(), slopes.hp[0].as_slice()];
        let (target, size) = (start - *gained, start.abs().to_f64() + gained.abs().to_f64());
        let free = q.len() - system.motors();
        let end_of_free = [&q[..free], &p[..free]];
        let projection = Projection::short(slope, target, size, LARGEST_PROJECTION, end_of_free);
        let moved = projection.apply(system, [q, p], &mut end).is_ok();
        self.weigh(system, start);
        // NaN counts as worse.
        if !(moved || self.defect <= before) {
            self.finish(problem)?;
        }
        Ok(())
    }
}
