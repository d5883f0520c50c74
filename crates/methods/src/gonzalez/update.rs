//! The application of a correction: its size, the check of K, and the failure if the iteration does
//! not converge.

use super::equation::Workspace;
use super::lambda::Lambda;
use crate::adaptive::{LARGEST_PROJECTION, Projection};
use crate::kernels::reductions::terms;
use crate::measured_rounding::EnergyRounding;
use crate::rounding::{KEPT_ROUNDINGS, RESTORED_ROUNDINGS, rounding};
use crate::second_derivatives::second_order;
use afterbay_core::{Curvature, Mask, Quantity, Scalar, State, StepFailure, Vector};

/// A solution is rejected if K changes by more than this share of H, of the terms of H and of Δw.
const LARGEST_DEFECT: f64 = 1e-3;

/// The size of a correction relative to z, including the error that a rounding of q causes in p and
/// the reverse.
pub(super) struct Update {
    pub(super) size: f64,
    pub(super) noise_share: f64,
}

/// The largest entries of a correction, of z and of Δz.
#[derive(Clone, Copy)]
struct Largest {
    correction: f64,
    z: f64,
    increment: f64,
}

impl<V: Vector> Workspace<V> {
    /// Adds the correction to Δz and updates z̄ and z1. The size is NaN if an entry is not finite.
    pub(super) fn update(
        &mut self,
        h: V::Scalar,
        state: &State<V>,
        lambda: &Lambda<V::Scalar>,
    ) -> Update {
        let [a, b] = &self.missing;
        let mut q = add(a, &state.q, [&mut self.dq, &mut self.q_mean, &mut self.q]);
        let mut p = add(b, &state.p, [&mut self.dp, &mut self.p_mean, &mut self.p]);
        let finite = (q.correction + p.correction).is_finite();
        if self.has_motors {
            [q, p] = self.largest_of_free(state);
        }
        // The rounding of λ enters q through h λ Δp and p through h λ (Δq + R Δp), and cannot be
        // resolved either.
        let rough = h.to_f64().abs() * lambda.rough;
        let q_scale = rough.mul_add(p.increment, q.z);
        let p_scale = rough.mul_add(q.increment + self.dragged, p.z);
        let gain = self.gain;
        let beside =
            |q_scale, p_scale| share(q.correction, q_scale).max(share(p.correction, p_scale));
        let mut size = beside(q_scale, p_scale);
        if self.has_motors {
            size = size.max(self.correction_of_supply(state));
        }
        let p_terms = h.to_f64().abs().mul_add(self.force_rounding, p_scale);
        let noise_share = beside(gain.mul_add(p_terms, q_scale), gain.mul_add(q_scale, p_terms));
        let size = if finite { size } else { f64::NAN };
        Update { size, noise_share }
    }

    /// The largest entries of q and p without motors, whose coordinates are the time.
    #[cold]
    fn largest_of_free(&self, state: &State<V>) -> [Largest; 2] {
        let ([a, b], own) = (&self.missing, ..self.free);
        let largest = |correction: &[f64], start: &V, increment: &V| {
            largest(&correction[own], &start.as_slice()[own], &increment.as_slice()[own])
        };
        [largest(a, &state.q, &self.dq), largest(b, &state.p, &self.dp)]
    }

    /// The correction of the energies supplied, which are the momenta of motors, relative to the
    /// energies.
    #[cold]
    fn correction_of_supply(&self, state: &State<V>) -> f64 {
        let (correction, start) = (&self.missing[1][self.free..], &state.p.as_slice()[self.free..]);
        let supplied = largest(correction, start, &self.dp.as_slice()[self.free..]);
        share(supplied.correction, supplied.z + self.start.abs().to_f64())
    }

    /// Computes w1, and returns whether K is near its old value. It is not if corrections were
    /// small because the Jacobian, evaluated far out, was large.
    pub(super) fn finish<S>(&mut self, system: &S, h: V::Scalar, state: &State<V>) -> bool
    where
        S: Curvature<V::Scalar> + ?Sized,
    {
        let zero = V::Scalar::zero();
        let mut spent = [zero; 2];
        if self.dissipative {
            // The velocity is exactly Δq/h, so that rounding cannot make Δw negative where friction
            // is positive.
            for (v, &dq) in self.v.as_mut_slice().iter_mut().zip(self.dq.as_slice()) {
                *v = dq / h;
            }
            self.dissipate(system);
            let (d, dq, w0) = (self.d.as_slice(), self.dq.as_slice(), state.w.as_slice());
            for (j, w) in self.w.as_mut_slice().iter_mut().enumerate() {
                let dw = d[j] * dq[j];
                spent = [spent[0] + dw, spent[1] + dw.abs()];
                *w = d[j].mul_add(dq[j], w0[j]);
            }
        }
        let (start, end) = (self.start, system.energy(self.q.as_slice(), self.p.as_slice()));
        let off = (end - start + spent[0]).abs();
        self.energy = end;
        // H may be a small sum of large terms.
        let of_slope = terms(self.hq.as_slice(), self.q_mean.as_slice())
            + terms(self.hp.as_slice(), self.p_mean.as_slice());
        let size = start.abs()
            + end.abs()
            + spent[1]
            + of_slope
            + V::Scalar::from_f64(self.energy_rounding);
        if off.to_f64() <= RESTORED_ROUNDINGS * rounding::<V::Scalar>(size.to_f64()) {
            return true;
        }
        self.restore(system, state, start, spent)
    }

    /// Moves z1 along ∇H until K equals its old value to rounding, unless the change of K is a
    /// rounding of H. If that is impossible, as close to an equilibrium, returns whether the change
    /// of K is a rounding of its terms.
    #[cold]
    fn restore<S>(
        &mut self,
        system: &S,
        state: &State<V>,
        start: V::Scalar,
        [gained, spent]: [V::Scalar; 2],
    ) -> bool
    where
        S: Curvature<V::Scalar> + ?Sized,
    {
        let [hq, hp] = &mut self.end_slopes;
        let slopes = |q: &V, p: &V, hq: &mut V, hp: &mut V| {
            let (q, p, hq, hp) = (q.as_slice(), p.as_slice(), hq.as_mut_slice(), hp.as_mut_slice());
            system.gradient(q, p, hq, hp);
            terms(hq, q) + terms(hp, p)
        };
        let before = slopes(&state.q, &state.p, hq, hp);
        let of_slopes = before + slopes(&self.q, &self.p, hq, hp);
        let size = start.abs() + self.energy.abs() + spent + of_slopes;
        let off = (self.energy - start + gained).abs();
        // At an equilibrium these terms vanish, and a rounding of z changes H in second order.
        let second_order = second_order(system, self.q_mean.as_slice(), self.p_mean.as_slice());
        let terms = size.to_f64() + V::Scalar::EPSILON * second_order;
        let kept = (KEPT_ROUNDINGS * rounding::<V::Scalar>(terms))
            .max(RESTORED_ROUNDINGS * rounding::<V::Scalar>(self.energy_rounding));
        let off = off.to_f64();
        // Far out H may be infinite at a finite z. A state that is not finite is reported by the
        // step.
        if !(off.is_finite() && off <= kept.max(LARGEST_DEFECT * size.to_f64())) {
            return false;
        }
        // Near rest ∇H is small. A move along ∇H that corrects a rounding of H is then longer than
        // the motion.
        let z = [self.q.as_slice(), self.p.as_slice()];
        let is_rounding = |measured: &EnergyRounding<V::Scalar>| {
            off <= rounding::<V::Scalar>(2.0 * measured.largest())
        };
        if off > kept && self.measured.allows(system, z, is_rounding).unwrap_or(false) {
            return true;
        }
        let (slope, target) = ([hq.as_slice(), hp.as_slice()], start - gained);
        let (size, energy, free) = ((start.abs() + spent).to_f64(), self.energy, self.free);
        let [q, p] = [self.q.as_mut_slice(), self.p.as_mut_slice()];
        let projection =
            Projection::short(slope, target, size, LARGEST_PROJECTION, [&q[..free], &p[..free]]);
        if projection.apply(system, [q, p], &mut self.energy).is_err() {
            self.energy = energy;
            self.place(state);
            return off <= kept;
        }
        true
    }

    /// The degree of freedom with the largest correction, and its value.
    #[cold]
    pub(super) fn largest(&self) -> (usize, f64) {
        let [a, b] = &self.missing;
        let all = a.iter().enumerate().chain(b.iter().enumerate());
        all.fold((0, 0.0), |most, (j, x)| if x.abs() > most.1 { (j, x.abs()) } else { most })
    }

    /// The reason for a correction that is not finite: the system is not finite at z̄, or the
    /// Jacobian is singular.
    #[cold]
    pub(super) fn not_finite(&self) -> StepFailure {
        let singular = |_| {
            let all = self.missing.iter().flat_map(|part| part.iter().enumerate());
            let dof = all.clone().find(|(_, x)| !x.is_finite()).map_or(0, |(j, _)| j);
            StepFailure::Singular { dof, slope: None }
        };
        self.check_force().map_or_else(|failure| failure, singular)
    }

    /// Checks that ∇H and D are finite where they were evaluated.
    #[cold]
    pub(super) fn check_force(&self) -> Result<(), StepFailure> {
        let parts = [&self.hq, &self.hp, &self.d].map(|part| (Quantity::Force, part.as_slice()));
        let finite = parts.iter().all(|(_, part)| part.iter().all(|x| x.is_finite().all()));
        if finite { Ok(()) } else { Err(StepFailure::non_finite(&parts)) }
    }

    /// Saves Δz.
    pub(super) fn remember(&mut self) {
        self.kept[0].as_mut_slice().copy_from_slice(self.dq.as_slice());
        self.kept[1].as_mut_slice().copy_from_slice(self.dp.as_slice());
    }

    /// Restores the saved Δz.
    pub(super) fn recall(&mut self) {
        self.dq.as_mut_slice().copy_from_slice(self.kept[0].as_slice());
        self.dp.as_mut_slice().copy_from_slice(self.kept[1].as_slice());
    }
}

/// Adds `correction` to the increment, then computes start + increment/2 and start + increment.
fn add<V: Vector>(correction: &[f64], start: &V, [increment, mean, end]: [&mut V; 3]) -> Largest {
    let n = correction.len();
    let (start, increment) = (&start.as_slice()[..n], &mut increment.as_mut_slice()[..n]);
    let (mean, end) = (&mut mean.as_mut_slice()[..n], &mut end.as_mut_slice()[..n]);
    for j in 0..n {
        increment[j] += V::Scalar::from_f64(correction[j]);
        mean[j] = start[j] + increment[j].half();
        end[j] = start[j] + increment[j];
    }
    largest(correction, start, increment)
}

/// The largest entries; full chunks of eight in lanes. The correction is NaN if an entry is not
/// finite.
fn largest<T: Scalar>(correction: &[f64], start: &[T], increment: &[T]) -> Largest {
    let (corrections, correction_rest) = correction.as_chunks::<8>();
    let (starts, start_rest) = start.as_chunks::<8>();
    let (increments, increment_rest) = increment.as_chunks::<8>();
    // `nan` is 0, or NaN where an entry is not finite.
    let (mut correction, mut z, mut increment, mut nan) = (0.0, 0.0, 0.0, 0.0);
    if !corrections.is_empty() {
        let mut lanes = [[0.0; 8]; 4];
        for ((corrections, starts), increments) in corrections.iter().zip(starts).zip(increments) {
            for k in 0..8 {
                let width = increments[k].to_f64().abs();
                lanes[0][k] = larger(lanes[0][k], corrections[k].abs());
                lanes[1][k] = larger(lanes[1][k], starts[k].to_f64().abs() + width);
                lanes[2][k] = larger(lanes[2][k], width);
                lanes[3][k] += corrections[k] * 0.0;
            }
        }
        let most = |lanes: [f64; 8]| lanes.into_iter().fold(0.0, larger);
        (correction, z, increment) = (most(lanes[0]), most(lanes[1]), most(lanes[2]));
        nan = lanes[3].iter().sum();
    }
    for ((a, start), step) in correction_rest.iter().zip(start_rest).zip(increment_rest) {
        let width = step.to_f64().abs();
        correction = larger(correction, a.abs());
        z = larger(z, start.to_f64().abs() + width);
        increment = larger(increment, width);
        nan += a * 0.0;
    }
    Largest { correction: correction + nan, z, increment }
}

/// The larger of two numbers; NaN is ignored.
fn larger(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}

/// a / b, with 0 / 0 = 0.
fn share(a: f64, b: f64) -> f64 {
    if a == 0.0 { 0.0 } else { a / b }
}
