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

    /// Computes γ at the q of the workspace.
    #[inline(always)]
    pub(super) fn find_rates(&mut self) {
        let Workspace { rate, ones, inverse_mass, q, .. } = &mut *self.workspace;
        if !self.damping.zero {
            let (q, v) = (q.as_slice(), inverse_mass.as_slice());
            self.system.dissipation(q, ones.as_slice(), v, rate.as_mut_slice());
        }
    }

    /// Computes p½, D(q0, p½) and q1.
    #[inline(always)]
    pub(super) fn kick_and_drift_together(&mut self) {
        let Workspace { force, rate, inverse_mass, p_half, drag, q, .. } = &mut *self.workspace;
        let start = [&self.state.q, &self.state.p, &*force, &*rate, &*inverse_mass];
        let [p_half, drag, q] = [p_half, drag, q].map(V::as_mut_slice);
        first_kick_and_drift(self.h, start.map(V::as_slice), p_half, drag, q);
    }

    /// Computes p1 and w1. Returns whether the new state is finite.
    #[inline(always)]
    pub(super) fn kick_together(&mut self) -> bool {
        self.find_rates();
        let Workspace { force, rate, inverse_mass, p_half, drag, q, p, w, .. } =
            &mut *self.workspace;
        let middle = [&*p_half, &*drag, &self.state.w, &*force, &*rate, &*inverse_mass];
        let [p, w] = [p, w].map(V::as_mut_slice);
        second_kick(self.h, middle.map(V::as_slice), p, w);
        all_finite(q.as_slice()) & all_finite(p) & all_finite(w)
    }
}

/// p½ = (p0 - h/2 V'(q0)) / (1 + h/2 γ), q1 = q0 + h p½/m, and D(q0, p½) = γ p½
///
/// The results are separate arguments, so the compiler knows that they do not overlap. As entries
/// of one array they might, and each step tested this.
#[inline(always)]
fn first_kick_and_drift<T: Scalar>(
    h: T,
    [q0, p0, force, rate, inverse_mass]: [&[T]; 5],
    p_half: &mut [T],
    drag: &mut [T],
    q1: &mut [T],
) {
    let (n, half_h) = (q0.len(), h.half());
    let [p0, force, rate, inverse_mass] = [p0, force, rate, inverse_mass].map(|x| &x[..n]);
    let (p_half, drag, q1) = (&mut p_half[..n], &mut drag[..n], &mut q1[..n]);
    for j in 0..n {
        let keep = half_h.mul_add(rate[j], T::one()).recip();
        let kicked = (-half_h).mul_add(force[j], p0[j]);
        p_half[j] = kicked * keep;
        drag[j] = rate[j] * p_half[j];
        q1[j] = (h * inverse_mass[j] * keep).mul_add(kicked, q0[j]);
    }
}

/// With γ at q1: p1 = (1 - h/2 γ) p½ - h/2 V'(q1), w1 = w0 + h/2 (`drag` + γ p½) p½/m, where `drag`
/// is D(q0, p½)
#[inline(always)]
fn second_kick<T: Scalar>(
    h: T,
    [p_half, drag, w0, force, rate, inverse_mass]: [&[T]; 6],
    p1: &mut [T],
    w1: &mut [T],
) {
    let (n, half_h) = (p_half.len(), h.half());
    let [drag, w0, force] = [drag, w0, force].map(|x| &x[..n]);
    let [rate, inverse_mass] = [rate, inverse_mass].map(|x| &x[..n]);
    let (p1, w1) = (&mut p1[..n], &mut w1[..n]);
    for j in 0..n {
        let dragged = p_half[j] * (-half_h).mul_add(rate[j], T::one());
        p1[j] = (-half_h).mul_add(force[j], dragged);
        let drags = drag[j] + rate[j] * p_half[j];
        w1[j] = (half_h * inverse_mass[j] * drags).mul_add(p_half[j], w0[j]);
    }
}
