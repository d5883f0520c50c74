//! A correction taken: how large it is, and what there is to say if it leads nowhere.

use super::equation::{Correction, Workspace};
use afterbay_core::{Mask, Quantity, Scalar, State, StepFailure, Vector};

/// The size of a correction beside what it corrects, and beside what rounding of q makes of p and of p makes of q too.
pub(super) struct Update {
    pub(super) size: f64,
    pub(super) reach: f64,
}

/// The largest entries of a correction, of z and of Δz.
#[derive(Clone, Copy)]
struct Largest {
    correction: f64,
    z: f64,
    increment: f64,
}

impl<V: Vector> Workspace<V> {
    /// Adds the correction to Δz. Its size is NaN where an entry is not finite.
    pub(super) fn take(
        &mut self,
        h: V::Scalar,
        state: &State<V>,
        correction: &Correction<V::Scalar>,
    ) -> Update {
        let [a, b] = &self.missing;
        let q = add(&mut self.dq, a, state.q.as_slice());
        let p = add(&mut self.dp, b, state.p.as_slice());
        // The rounding of λ, through h λ Δp in q and h λ Δq in p, is as lost as that of q and p.
        let rough = h.to_f64().abs() * correction.rough;
        let q_scale = rough.mul_add(p.increment, q.z);
        let p_scale = rough.mul_add(q.increment, p.z);
        let gain = self.gain;
        let beside = |q_scale, p_scale| share(q.correction, q_scale).max(share(p.correction, p_scale));
        let size = beside(q_scale, p_scale);
        let finite = (q.correction + p.correction).is_finite();
        let reach = beside(gain.mul_add(p_scale, q_scale), gain.mul_add(q_scale, p_scale));
        Update { size: if finite { size } else { f64::NAN }, reach }
    }

    /// The degree of freedom with the largest correction, and that correction.
    #[cold]
    pub(super) fn largest(&self) -> (usize, f64) {
        let [a, b] = &self.missing;
        let all = a.iter().enumerate().chain(b.iter().enumerate());
        all.fold((0, 0.0), |most, (j, x)| if x.abs() > most.1 { (j, x.abs()) } else { most })
    }

    /// Why a correction is not finite: the system is not at z̄, or the Jacobian is singular.
    #[cold]
    pub(super) fn not_finite(&self) -> StepFailure {
        let singular = |_| {
            let all = self.missing.iter().flat_map(|part| part.iter().enumerate());
            let dof = all.clone().find(|(_, x)| !x.is_finite()).map_or(0, |(j, _)| j);
            StepFailure::Singular { dof, slope: 0.0 }
        };
        self.check_force().map_or_else(|failure| failure, singular)
    }

    /// Are ∇H and D finite where they were evaluated?
    #[cold]
    pub(super) fn check_force(&self) -> Result<(), StepFailure> {
        let parts = [&self.hq, &self.hp, &self.d].map(|part| (Quantity::Force, part.as_slice()));
        let finite = parts.iter().all(|(_, part)| part.iter().all(|x| x.is_finite().all()));
        if finite { Ok(()) } else { Err(StepFailure::non_finite(&parts)) }
    }

    /// Keeps this Δz.
    pub(super) fn remember(&mut self) {
        self.kept[0].as_mut_slice().copy_from_slice(self.dq.as_slice());
        self.kept[1].as_mut_slice().copy_from_slice(self.dp.as_slice());
    }

    /// Comes back to it.
    pub(super) fn recall(&mut self) {
        self.dq.as_mut_slice().copy_from_slice(self.kept[0].as_slice());
        self.dp.as_mut_slice().copy_from_slice(self.kept[1].as_slice());
    }
}

/// Adds `correction` to `increment`.
fn add<V: Vector>(increment: &mut V, correction: &[f64], start: &[V::Scalar]) -> Largest {
    let mut most = Largest { correction: 0.0, z: 0.0, increment: 0.0 };
    let mut lost = 0.0;
    let n = correction.len();
    let (increment, start) = (&mut increment.as_mut_slice()[..n], &start[..n]);
    for j in 0..n {
        increment[j] += V::Scalar::from_f64(correction[j]);
        let width = increment[j].to_f64().abs();
        most.correction = larger(most.correction, correction[j].abs());
        most.z = larger(most.z, start[j].to_f64().abs() + width);
        most.increment = larger(most.increment, width);
        // NaN once an entry is not finite, 0 before.
        lost += correction[j] * 0.0;
    }
    most.correction += lost;
    most
}

/// The larger of two numbers; NaN is passed over.
fn larger(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}

/// a / b, where 0 / 0 = 0.
fn share(a: f64, b: f64) -> f64 {
    if a == 0.0 { 0.0 } else { a / b }
}
