//! The restoration of K after a step.
//!
//! The stages give the end of the step and `Δw_j = h Σ b_i D_j v_j`. The defect `H0 - H1 - Σ Δw_j`
//! is of the size of the error of the step. It belongs to (q, p) or to w. For quadratic H it is
//!
//! ```text
//! h²/2 Σ_ik (b_i a_ik + b_k a_ki - b_i b_k) z'_i · H'' z'_k  ≥ 0
//! ```
//!
//! since Radau IIA is algebraically stable (Hairer, Wanner II, IV.12). Where a fast decay is not
//! resolved, (q, p) is right and the defect is dissipated energy that the weights missed. Where the
//! system oscillates it is numerical damping. The defect is divided in the ratio of the squares of
//! the estimated errors, as in least squares: the share of w is added to it, and (q, p) is
//! projected by the rest. Under a drive all of the defect is projected, since the estimated errors
//! of w are also those of the energy supplied.

use super::engine::Engine;
use super::share::Allowed;
use crate::adaptive::{End, ROUNDING_SUSPECTED_BELOW, is_noise};
use afterbay_core::{Curvature, Passive, Scalar, State, StepFailure, Vector};

/// The reservoirs take all of the defect if their share exceeds this number, between 0 and 1. A
/// choice.
const WHOLE_SHARE: f64 = 0.999;

impl<V: Vector, const S: usize> Engine<V, S> {
    /// Computes the end of the step with K exact. If no allowed change makes it so, returns the
    /// ratio of the necessary to the allowed change.
    ///
    /// # Errors
    /// [`StepFailure::NotGradient`]
    #[inline(always)]
    pub(super) fn balance<F: Curvature<V::Scalar> + ?Sized>(
        &mut self,
        system: &F,
        state: &State<V>,
        allowed: Allowed,
        error: f64,
    ) -> Result<Option<f64>, StepFailure> {
        self.place_end(system, state);
        self.sum_gains();
        if self.dissipative && self.undriven {
            self.share_defect(system);
        }
        let Err(excess) = self.project(system, allowed) else { return Ok(None) };
        Ok((!self.is_noise(system, state, error)?).then_some(excess))
    }

    /// Whether the error of K at the end of the step, which no projection reduces, is rounding.
    #[cold]
    #[inline(never)]
    fn is_noise<F: Curvature<V::Scalar> + ?Sized>(
        &mut self,
        system: &F,
        state: &State<V>,
        error: f64,
    ) -> Result<bool, StepFailure> {
        self.place_end(system, state);
        let Self { end, energy, last_defect, .. } = self;
        let energies = [*energy, end.energy, end.target(*energy)];
        Ok(error <= ROUNDING_SUSPECTED_BELOW
            && is_noise(system, [&end.q, &end.p], energies, &state.w, last_defect)?)
    }

    /// The end of the step as the stages give it. The momenta of motors, which are energies, are
    /// summed by the weights, as w is. Energy that is supplied and not dissipated then leaves w
    /// unchanged.
    #[inline(always)]
    pub(super) fn place_end<F: Curvature<V::Scalar> + ?Sized>(
        &mut self,
        system: &F,
        state: &State<V>,
    ) {
        let Self { end, trial, tables, h, .. } = self;
        let End { q, p, .. } = end;
        for (to, from, by) in [(&mut *q, &state.q, &trial.q), (&mut *p, &state.p, &trial.p)] {
            let steps = from.as_slice().iter().zip(by[S - 1].as_slice());
            for (to, (&from, &by)) in to.as_mut_slice().iter_mut().zip(steps) {
                *to = from + by;
            }
        }
        let n = p.as_slice().len();
        for d in n - system.motors()..n {
            let terms = tables.weights.iter().zip(&trial.f);
            let sum = terms.fold(V::Scalar::zero(), |sum, (&b, f)| b.mul_add(f.as_slice()[d], sum));
            p.as_mut_slice()[d] = h.mul_add(sum, state.p.as_slice()[d]);
        }
        end.measure(system);
        self.unmoved = true;
    }

    /// Δw_j = h Σ b_i D_j v_j
    #[inline(always)]
    pub(super) fn sum_gains(&mut self) {
        let Self { tables, trial, end, .. } = self;
        let (h, gain) = (self.h, end.gain.as_mut_slice());
        let n = V::LEN.unwrap_or(gain.len());
        for (d, gain) in gain[..n].iter_mut().enumerate() {
            let terms = tables.weights.iter().zip(&trial.loss);
            let sum =
                terms.fold(V::Scalar::zero(), |sum, (&b, loss)| b.mul_add(loss.as_slice()[d], sum));
            *gain = h * sum;
        }
    }

    /// Adds to the reservoirs their share of the defect, in proportion to their estimated errors,
    /// unless this would drain a passive one.
    #[inline(always)]
    fn share_defect<F: Curvature<V::Scalar> + ?Sized>(&mut self, system: &F) {
        let Self { errors: [of_q, of_p, of_w], trial, last, end, energy, .. } = self;
        let defect = end.target(*energy) - end.energy;
        let n = V::LEN.unwrap_or(end.gain.as_slice().len()) - system.motors();
        let zero = V::Scalar::zero();
        let [of_q, of_p, of_w] = [of_q, of_p, of_w].map(|x| &x.as_slice()[..n]);
        let (hq, v) = (&last.hq.as_slice()[..n], &trial.v[S - 1].as_slice()[..n]);
        let (mut of_energy, mut of_reservoirs) = (zero, zero);
        for d in 0..n {
            of_energy += (hq[d] * of_q[d]).abs() + (v[d] * of_p[d]).abs();
            of_reservoirs += of_w[d].abs();
        }
        let ratio = of_energy.to_f64() / of_reservoirs.to_f64();
        let share = 1.0 / ratio.mul_add(ratio, 1.0);
        // There is nothing to share if no error of w is estimated.
        if share.is_nan() || share == 0.0 {
            return;
        }
        let share = if share > WHOLE_SHARE { 1.0 } else { share };
        let defect = V::Scalar::from_f64(share) * defect;
        let each = defect / of_reservoirs;
        let gain = &mut end.gain.as_mut_slice()[..n];
        let drained = match system.dissipation_form().passive {
            Passive::No => false,
            Passive::InSum => gain.iter().fold(defect, |sum, &gain| sum + gain).to_f64() < 0.0,
            Passive::Each => (0..n).any(|d| (gain[d] + each * of_w[d].abs()).to_f64() < 0.0),
        };
        if !drained {
            for d in 0..n {
                gain[d] += each * of_w[d].abs();
            }
        }
    }

    /// Projects (q, p) onto K along ∇H, scaled by the tolerances.
    #[inline(always)]
    fn project<F: Curvature<V::Scalar> + ?Sized>(
        &mut self,
        system: &F,
        allowed: Allowed,
    ) -> Result<(), f64> {
        let Self { trial, last, end, energy, .. } = self;
        let slope = [&last.hq, &trial.v[S - 1]];
        let moved = end.project(system, slope, *energy, allowed.scales, allowed.share)?;
        self.unmoved = !moved;
        Ok(())
    }

    /// The coordinates at the end of the trial step.
    #[inline]
    pub(crate) fn end_of_attempt(&self) -> &[V::Scalar] {
        self.end.q.as_slice()
    }
}
