//! K at the end of a step: the projection, and the errors that no projection reduces.

use super::Workspace;
use crate::adaptive::Projection;
use crate::commit::check;
use crate::kernels::reductions::{largest_difference, max_norm, sum, terms};
use crate::measured_rounding::EnergyRounding;
use crate::rounding::{RESTORED_ROUNDINGS, SMALL_ROUNDINGS, rounding, roundings};
use afterbay_core::{Quantity, Scalar, Separable, State, StepFailure, Vector};

/// The largest projection, as a share of the largest change of q and p over the step. A choice.
const LARGEST_SHARE: f64 = 0.125;
/// The error of K after a projection, in roundings of H, that is corrected once more. A projection
/// that goes well ends within 2 roundings of q ∂H/∂q and p ∂H/∂p, which are a few times H.
const LEFT_ROUNDINGS: f64 = 8.0;
/// The largest number of projections of a step. A choice.
const MOST_PROJECTIONS: u64 = 3;
/// Roundings of q and p that a projection may move them by, however short the step. A choice.
const ROUNDINGS: f64 = 64.0;

/// The norm in which the change of (q, p) by a projection is smallest.
#[derive(Clone, Copy)]
pub(super) enum Norm {
    /// The Euclidean norm of (q, p) in the units of the system.
    Euclidean,
    /// The norm in units of the changes of q and of p over the step. Where v is nearly 0, ∂H/∂p is
    /// far below ∂H/∂q. The Euclidean projection nevertheless moves p too far if p is small in its
    /// unit.
    OfChanges,
}

/// K at the end of a step.
pub(super) enum Balance {
    /// It is exact to rounding.
    Kept,
    /// The projection has made it exact.
    Restored { gradients: u64 },
    /// No projection makes it exact; it is off by this.
    Unrestored { excess: f64 },
}

impl<V: Vector> Workspace<V> {
    /// Projects (q, p) onto the target of H.
    #[inline]
    pub(super) fn project<S>(
        &mut self,
        system: &S,
        target: V::Scalar,
        state: &State<V>,
        norm: Norm,
    ) -> Result<Balance, StepFailure>
    where
        S: Separable<V::Scalar> + ?Sized,
    {
        let gained = sum([self.gain.as_slice()], |[gain]| gain.abs());
        let size = self.energy[0].abs() + gained;
        let (scales, share) = self.allowed(state, norm);
        let Self { q, p, hq, hp, .. } = self;
        let mut energy = system.energy(q.as_slice(), p.as_slice());
        // Near rest a rounding of K may take more than a small projection.
        let left = |energy: V::Scalar| {
            let off = (energy - target).to_f64().abs();
            roundings::<V::Scalar>(off, (size + energy.abs()).to_f64())
        };
        if left(energy) <= SMALL_ROUNDINGS {
            return Ok(Balance::Kept);
        }
        let (before, mut gradients) = (energy, 0);
        let mut correct = |energy: &mut V::Scalar| {
            let [hq, hp] = [hq.as_mut_slice(), hp.as_mut_slice()];
            system.gradient(q.as_slice(), p.as_slice(), hq, hp);
            let slope = [&*hq, &*hp];
            let size = size.to_f64();
            let projection = Projection { slope, target, size, scales, share };
            projection.apply(system, [q.as_mut_slice(), p.as_mut_slice()], energy).is_ok()
        };
        // A long projection ends where its slope is no longer that of H.
        while gradients < MOST_PROJECTIONS {
            let last = left(energy);
            let fits = correct(&mut energy);
            gradients += 1;
            if fits && (gradients > 1 || left(energy) <= LEFT_ROUNDINGS) {
                return Ok(Balance::Restored { gradients });
            }
            let falls = left(energy) < 0.5 * last;
            if !falls {
                break;
            }
        }
        let excess = (energy - target).to_f64();
        if !((before - target).to_f64().is_finite() && excess.is_finite()) {
            check([q.as_slice(), p.as_slice(), self.gain.as_slice()])?;
            return Err(StepFailure::non_finite(&[(Quantity::Energy, &[before, energy, target])]));
        }
        if self.is_noise(system, target, state)? {
            return Ok(Balance::Restored { gradients: gradients + 1 });
        }
        Ok(Balance::Unrestored { excess })
    }

    /// The scales of q and p in the norm, and the largest projection in it.
    #[inline]
    fn allowed(&self, state: &State<V>, norm: Norm) -> ([f64; 2], f64) {
        let ends = [(&self.q, &state.q), (&self.p, &state.p)];
        let sizes = ends.map(|(end, start)| {
            let [end, start] = [end, start].map(|z| &z.as_slice()[..self.first_motor]);
            [largest_difference(end, start).to_f64(), max_norm(end)]
        });
        let allowed = |[change, most]: [f64; 2]| {
            LARGEST_SHARE * change + ROUNDINGS * V::Scalar::EPSILON * most
        };
        match norm {
            Norm::Euclidean => {
                let [q, p] = sizes;
                ([1.0; 2], allowed([q[0].max(p[0]), q[1].max(p[1])]))
            }
            Norm::OfChanges => (sizes.map(allowed), 1.0),
        }
    }

    /// Whether K is off by a rounding of its terms, or of those that cancel inside H.
    #[cold]
    pub(super) fn is_noise<S>(
        &mut self,
        system: &S,
        target: V::Scalar,
        state: &State<V>,
    ) -> Result<bool, StepFailure>
    where
        S: Separable<V::Scalar> + ?Sized,
    {
        let Self { q, p, hq, hp, gain, energy_rounding, .. } = self;
        let (q, p) = (q.as_slice(), p.as_slice());
        system.gradient(q, p, hq.as_mut_slice(), hp.as_mut_slice());
        let energy = system.energy(q, p);
        let known =
            self.energy[0].abs() + energy.abs() + sum([gain.as_slice()], |[gain]| gain.abs());
        let first_order = (known + terms(hq.as_slice(), q) + terms(hp.as_slice(), p)).to_f64();
        let second_order = second_order(system, q, p) * V::Scalar::EPSILON;
        let off = (energy - target).to_f64().abs();
        let is_noise = |measured: &EnergyRounding<V::Scalar>| {
            let size = first_order + second_order + measured.largest();
            off <= RESTORED_ROUNDINGS * rounding::<V::Scalar>(size)
        };
        let start = [state.q.as_slice(), state.p.as_slice()];
        Ok(energy_rounding.allows(system, start, is_noise)?
            || energy_rounding.allows(system, [q, p], is_noise)?)
    }
}

/// Σ_i |q_i Σ_j q_j ∂²V/∂q_i∂q_j|, by a difference. Rounding q changes V by this times ε² at an
/// equilibrium away from the origin. 0 where it overflows: an infinite bound excuses every error.
#[cold]
fn second_order<T: Scalar, S: Separable<T> + ?Sized>(system: &S, q: &[T], p: &[T]) -> f64 {
    let share = 2.0_f64.powi(-20);
    let [mut hq, mut hp] = [(); 2].map(|()| vec![T::zero(); q.len()]);
    let mut at = |q: &[T]| {
        system.gradient(q, p, &mut hq, &mut hp);
        hq.clone()
    };
    let grown: Vec<T> = q.iter().map(|&q| T::from_f64(1.0 + share) * q).collect();
    let (here, beside) = (at(q), at(&grown));
    let changes = here.iter().zip(&beside).zip(q);
    let terms = changes.map(|((&here, &beside), &q)| ((beside - here) * q).to_f64().abs() / share);
    Some(terms.sum()).filter(|sum: &f64| sum.is_finite()).unwrap_or(0.0)
}
