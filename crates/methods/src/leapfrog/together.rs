//! The step of many degrees of freedom with D_j = γ_j p_j and without a drive: loops over all of
//! them without a call, so that several numbers are computed at a time.

use super::{Step, Workspace};
use crate::kernels::reductions::all_finite;
use afterbay_core::{Scalar, Separable, Vector};

/// The least number of degrees of freedom. With fewer the loops cost more than the calls: on one
/// mass in a `Vec` twice as much.
const LEAST_DOF: usize = 4;

impl<V: Vector, S: Separable<V::Scalar> + ?Sized> Step<'_, V, S> {
    /// Whether the step is of this kind.
    #[inline(always)]
    pub(super) fn is_together(&self) -> bool {
        let n = self.state.dof();
        !Self::SINGLE && n >= LEAST_DOF && self.damping.linear && self.free() == n
    }

    /// γ at the q of the forces.
    #[inline(always)]
    pub(super) fn find_rates(&mut self) {
        let Workspace { at, rate, ones, inverse_mass, .. } = &mut *self.workspace;
        if !self.damping.zero {
            let (q, v) = (at.as_slice(), inverse_mass.as_slice());
            self.system.dissipation(q, ones.as_slice(), v, rate.as_mut_slice());
        }
    }

    /// p½ = (p0 - h/2 V'(q0)) / (1 + h/2 γ), q1 = q0 + h p½/m
    #[inline(always)]
    pub(super) fn kick_and_drift_together(&mut self) {
        let (n, h, half_h) = (self.state.dof(), self.h, self.h.half());
        let (q0, p0) = (&self.state.q.as_slice()[..n], &self.state.p.as_slice()[..n]);
        let Workspace { force, rate, inverse_mass, p_half, drag, q, .. } = &mut *self.workspace;
        let [force, rate, inverse_mass] =
            [force, rate, inverse_mass].map(|vector| &vector.as_slice()[..n]);
        let [p_half, drag, q1] = [p_half, drag, q].map(|vector| &mut vector.as_mut_slice()[..n]);
        for j in 0..n {
            let keep = half_h.mul_add(rate[j], V::Scalar::one()).recip();
            let kicked = (-half_h).mul_add(force[j], p0[j]);
            p_half[j] = kicked * keep;
            drag[j] = rate[j] * p_half[j];
            q1[j] = (h * inverse_mass[j] * keep).mul_add(kicked, q0[j]);
        }
    }

    /// p1 = (1 - h/2 γ) p½ - h/2 V'(q1), w1 = w0 + h/2 (D(q0, p½) + D(q1, p½)) p½/m. Returns
    /// whether the new state is finite.
    #[inline(always)]
    pub(super) fn kick_together(&mut self) -> bool {
        self.find_rates();
        let (n, half_h) = (self.state.dof(), self.h.half());
        let w0 = &self.state.w.as_slice()[..n];
        let Workspace { force, rate, inverse_mass, p_half, drag, q, p, w, .. } =
            &mut *self.workspace;
        let [force, rate, inverse_mass, p_half, drag] =
            [force, rate, inverse_mass, p_half, drag].map(|vector| &vector.as_slice()[..n]);
        let [p1, w1] = [p, w].map(|vector| &mut vector.as_mut_slice()[..n]);
        for j in 0..n {
            let dragged = p_half[j] * (-half_h).mul_add(rate[j], V::Scalar::one());
            p1[j] = (-half_h).mul_add(force[j], dragged);
            let drags = drag[j] + rate[j] * p_half[j];
            w1[j] = (half_h * inverse_mass[j] * drags).mul_add(p_half[j], w0[j]);
        }
        all_finite(q.as_slice()) & all_finite(p1) & all_finite(w1)
    }
}
