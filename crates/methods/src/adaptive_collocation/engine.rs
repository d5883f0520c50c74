//! One step of Gauss collocation, solved to the accuracy the tolerance requires, with K exact.
//!
//! The sweeps end when the remaining error is a tenth of the error allowed for the step. Then
//! (q, p) is projected onto `H(q, p) = H(q0, p0) - Σ Δw_j` along the gradient of H, scaled by the
//! tolerances of q and p. If the projection would exceed the allowed error, the step is rejected,
//! or, near an equilibrium, repeated by [`crate::Collocation`], which conserves K without
//! projection.

use super::gauss::{Columns, Gauss, weighted};
use super::slopes::Slopes;
use super::stages::{SWEEP_ROUNDINGS, Stages};
use super::stiffness::Stiffness;
use crate::adaptive::{Budget, End, Kinks, REFUSED_ERROR, ROUNDING_SUSPECTED_BELOW, Rates};
use crate::collocation;
use crate::kernels::reductions::largest_if_finite;
use afterbay_core::{
    Attempt, Curvature, Effort, Quad, Scalar, State, StepFailure, Tolerance, Vector,
};
use std::array::from_fn;

/// The largest number of sweeps of a step. A choice: with the best contraction they gain ten
/// digits.
const MOST_SWEEPS: u32 = 12;
/// The contraction factor per sweep that maximises progress. The factor is κ h² for a step of
/// length h, and `-h ln (κ h²)`, the digits gained per sweep times h, is largest for
/// κ h² = e⁻².
const BEST_CONTRACTION: f64 = 0.135;
/// The largest h ω. Sweeps amplify rounding errors of the fastest oscillation by up to e^(h ω)
/// before they contract: 4 loses up to two digits. A choice.
const LARGEST_PHASE: f64 = 4.0;
/// The least factor by which a step is multiplied to improve the contraction of sweeps. A choice:
/// the contraction of one step predicts that of steps of about its length.
const SHORTEST_STRETCH: f64 = 0.5;
/// The largest factor by which a step is multiplied where the contraction of sweeps permits it. A
/// choice, for the same reason.
const LONGEST_STRETCH: f64 = 2.0;
/// The ratio of the changes of two sweeps above which they do not contract. A choice.
const STALLED: f64 = 0.7;
/// The error of the solver relative to the error allowed for the step; between 0 and 1. A choice.
const SOLVER_SHARE: f64 = 0.1;
/// The error of a step, relative to the allowed one, below which sweeps and not the error limit the
/// step size. A choice, between 0 and 1: at order 8 the error alone would allow steps 1.5 times as
/// long.
const UNLIMITED_SHARE: f64 = 0.05;

/// The memory of a step with K nodes.
#[derive(Clone, Debug)]
pub(super) struct Engine<V: Vector, const K: usize> {
    pub(super) gauss: Gauss<V::Scalar, K>,
    /// The stages of the current trial step, and of the last accepted one.
    pub(super) trial: Stages<V, K>,
    pub(super) kept: Stages<V, K>,
    /// The slopes at the start, and H there.
    pub(super) start: Slopes<V>,
    pub(super) energy: V::Scalar,
    pub(super) end: End<V>,
    /// The slopes at the end.
    pub(super) last: Slopes<V>,
    pub(super) zero: V,
    /// The number of degrees of freedom without motors.
    pub(super) free: usize,
    pub(super) unit_mass: bool,
    /// The lengths of the trial step and of the last accepted one, if any.
    pub(super) h: V::Scalar,
    pub(super) kept_h: Option<V::Scalar>,
    /// The matrix that extrapolates the accepted step, and the offset, ratio and count it belongs
    /// to.
    pub(super) extrapolation: Columns<V::Scalar, K>,
    pub(super) extrapolation_for: Option<(V::Scalar, V::Scalar, usize)>,
    pub(super) stiff: Stiffness,
    /// An estimate of the largest frequency, and the memory for computing it.
    pub(super) fastest: f64,
    /// |∂²H/∂p∂p| at the end of the step.
    pub(super) inverse_mass: f64,
    pub(super) rates: Rates<V>,
    /// The geometric mean of the contraction factors of the last step's sweeps.
    pub(super) contraction: f64,
    /// The changes of q and p at the nodes in the last sweep, without motors.
    pub(super) moved: [f64; 2],
    pub(super) kinks: Kinks,
    pub(super) budget: Budget,
    /// The solver that iterates to rounding, allocated when it is first needed.
    pub(super) spare: Option<Box<collocation::Workspace<V>>>,
}

impl<V: Vector, const K: usize> Engine<V, K> {
    pub(super) fn new<S: Curvature<V::Scalar> + ?Sized>(
        system: &S,
        gauss: &Gauss<Quad, K>,
        tolerance: &Tolerance,
        span: f64,
    ) -> Self {
        let n = system.dof();
        Self {
            gauss: gauss.narrow(),
            trial: Stages::new(n),
            kept: Stages::new(n),
            start: Slopes::new(n),
            energy: V::Scalar::zero(),
            end: End::new(n),
            last: Slopes::new(n),
            zero: V::zeros(n),
            free: n - system.motors(),
            unit_mass: system.unit_mass(),
            h: V::Scalar::zero(),
            kept_h: None,
            extrapolation: [[V::Scalar::zero(); K]; K],
            extrapolation_for: None,
            stiff: Stiffness::new(n),
            fastest: 0.0,
            inverse_mass: 0.0,
            rates: Rates::new(n),
            contraction: 0.0,
            moved: [0.0; 2],
            kinks: Kinks::default(),
            budget: Budget::new(tolerance, span, n - system.motors()),
            spare: None,
        }
    }

    /// Tries the step h from `state`, where the accepted step ended.
    #[inline]
    pub(super) fn attempt<S: Curvature<V::Scalar> + ?Sized>(
        &mut self,
        system: &S,
        h: V::Scalar,
        state: &State<V>,
    ) -> Result<Attempt, StepFailure> {
        if self.kept_h.is_none() {
            self.start.evaluate(system, [&state.q, &state.p]);
            self.energy = state.energy(system);
        }
        let share = self.budget.share_of(h.to_f64().abs());
        let scales = self.budget.scales(state, self.energy, share);
        self.h = h;
        self.initial_guess(h, state, false);
        if self.stiff.uses_newton {
            self.attempt_by_newton(system, state, scales, share)
        } else {
            self.attempt_by_sweeps(system, state, scales, share)
        }
    }

    /// Solves the equations to rounding.
    #[cold]
    fn attempt_by_newton<S: Curvature<V::Scalar> + ?Sized>(
        &mut self,
        system: &S,
        state: &State<V>,
        scales: [f64; 3],
        share: f64,
    ) -> Result<Attempt, StepFailure> {
        let effort = self.rounded(system, self.h, state)?;
        self.see_fastest(system);
        let limits = self.limits(system, state, scales, share);
        let newton = self.spare.as_ref().is_some_and(|spare| spare.solved_by_newton());
        let error =
            if newton { self.error_after_newton(state, &limits)? } else { self.error(&limits)? };
        self.stiff.record_newton(self.h.to_f64().abs());
        Ok(Attempt { error, order: limits.order, largest_growth: f64::INFINITY, effort })
    }

    /// Solves the equations by sweeps, to the accuracy that the tolerance requires.
    #[inline(always)]
    fn attempt_by_sweeps<S: Curvature<V::Scalar> + ?Sized>(
        &mut self,
        system: &S,
        state: &State<V>,
        scales: [f64; 3],
        share: f64,
    ) -> Result<Attempt, StepFailure> {
        let (before, length) = (self.energy, self.h.to_f64().abs());
        let sweeps = self.sweeps(system, self.h, state, scales, share);
        if let Err(StepFailure::NotContracting { .. }) = sweeps {
            self.stiff.record_refused(length);
        }
        let sweeps = sweeps?;
        let mut effort = Self::spent(sweeps);
        self.finish(system, state);
        self.see_fastest(system);
        let limits = self.limits(system, state, scales, share);
        let mut error = self.error(&limits)?;
        if error <= 1.0 {
            match self.restore(system, before, limits.scales, limits.share) {
                Ok(()) => {}
                // K is off either because the step is long, or because near an equilibrium no
                // change of (q, p) changes it.
                Err(ratio) if error > ROUNDING_SUSPECTED_BELOW => error = ratio.max(REFUSED_ERROR),
                Err(_) => match self.rounded(system, self.h, state) {
                    Ok(more) => effort += more,
                    Err(failure) => self.keep_rounding(system, state, failure)?,
                },
            }
        }
        if error > 1.0 {
            self.end.balance(system, before);
        }
        let reach = (BEST_CONTRACTION / self.contraction)
            .sqrt()
            .min(LARGEST_PHASE / (length * self.fastest));
        let reach = reach.clamp(SHORTEST_STRETCH, LONGEST_STRETCH);
        self.stiff.record_swept(length, reach <= 1.0, error < UNLIMITED_SHARE);
        Ok(Attempt { error, order: limits.order, largest_growth: reach, effort })
    }

    /// Computes the state the time h after `before`, with which the accepted step began.
    pub(super) fn between<S: Curvature<V::Scalar> + ?Sized>(
        &mut self,
        system: &S,
        h: V::Scalar,
        before: &State<V>,
        to: &mut State<V>,
    ) -> Result<Effort, StepFailure> {
        let share = self.budget.share_of(h.to_f64().abs());
        let scales = self.budget.scales(before, before.energy(system), share);
        self.h = h;
        self.initial_guess(h, before, true);
        let mut effort = Effort::default();
        let mut found = false;
        if !self.stiff.uses_newton
            && let Ok(sweeps) = self.sweeps(system, h, before, scales, share)
        {
            effort += Self::spent(sweeps);
            self.finish(system, before);
            found = self.restore(system, before.energy(system), scales, share).is_ok();
        }
        if !found {
            effort += self.rounded(system, h, before)?;
        }
        to.w.as_mut_slice().copy_from_slice(before.w.as_slice());
        self.end.write(to);
        Ok(effort)
    }

    fn spent(sweeps: u32) -> Effort {
        Effort { evaluations: u64::from(sweeps) * K as u64, iterations: u64::from(sweeps) }
    }

    /// Sweeps until the remaining error is small relative to the allowed one.
    #[inline]
    fn sweeps<S: Curvature<V::Scalar> + ?Sized>(
        &mut self,
        system: &S,
        h: V::Scalar,
        state: &State<V>,
        scales: [f64; 3],
        share: f64,
    ) -> Result<u32, StepFailure> {
        // Changes up to this size may be rounding.
        let noise = SWEEP_ROUNDINGS * V::Scalar::EPSILON;
        let noise = noise / self.budget.relative().max(noise);
        let inverse = scales.map(f64::recip);
        let phase = h.to_f64() * self.fastest;
        let (mut before, mut first, mut sweeps) = (f64::NAN, f64::NAN, 0);
        loop {
            sweeps += 1;
            let moved = self.trial.sweep(system, &self.gauss, h, state);
            self.moved = [moved[0], moved[1]];
            let [q, p, w] = [moved[0] * inverse[0], moved[1] * inverse[1], moved[2] * inverse[2]];
            let change = largest_if_finite([q, p, w]);
            if !change.is_finite() {
                return Err(self.trial.not_finite(&self.last));
            }
            let ratio = change / before;
            if sweeps == 1 {
                first = change;
            }
            // After n sweeps the fastest oscillation has the error (h ω)²ⁿ/(2n)!, which slower ones
            // may hide. The first change does not predict the next.
            let n = f64::from(2 * sweeps);
            let rate = ratio.min(1.0).max((phase * phase / ((n + 1.0) * (n + 2.0))).min(1.0));
            let stalls = sweeps > 3 && ratio > STALLED;
            let is_noise = || stalls || self.trial.are_roundings(moved, h, state, self.free);
            if change * rate <= SOLVER_SHARE * share || (change <= noise && is_noise()) {
                self.contraction = match sweeps - 1 {
                    0 => 0.0,
                    ratios => geometric_mean(change / first, ratios),
                };
                return Ok(sweeps);
            }
            if sweeps == MOST_SWEEPS || stalls {
                let dof = self.trial.restless(system);
                return Err(StepFailure::NotContracting { dof, iterations: sweeps, ratio });
            }
            before = change;
        }
    }

    /// Computes z1 and the increments of the reservoirs.
    #[inline]
    pub(super) fn finish<S: Curvature<V::Scalar> + ?Sized>(
        &mut self,
        system: &S,
        state: &State<V>,
    ) {
        let Self { gauss, trial, end, last, h, unit_mass, .. } = self;
        let n = state.dof();
        for d in 0..n {
            let at = |x: &[V; K]| -> [V::Scalar; K] { from_fn(|i| x[i].as_slice()[d]) };
            let (f, p) = (at(&trial.f), state.p.as_slice()[d]);
            let velocity = if *unit_mass {
                (-*h).mul_add(weighted(&gauss.moments, f), p)
            } else {
                weighted(&gauss.weights, at(&trial.v))
            };
            end.q.as_mut_slice()[d] = h.mul_add(velocity, state.q.as_slice()[d]);
            end.p.as_mut_slice()[d] = (-*h).mul_add(weighted(&gauss.weights, f), p);
            end.gain.as_mut_slice()[d] = *h * weighted(&gauss.weights, at(&trial.loss));
        }
        last.evaluate(system, [&end.q, &end.p]);
        end.measure(system);
    }

    /// Accepts the trial step.
    #[inline]
    pub(super) fn accept(&mut self, state: &mut State<V>) {
        self.end.write(state);
        std::mem::swap(&mut self.trial, &mut self.kept);
        std::mem::swap(&mut self.start, &mut self.last);
        self.energy = self.end.energy;
        self.kept_h = Some(self.h);
        self.budget.spend(self.h.to_f64().abs());
    }

    /// The coordinates at the end of the trial step.
    #[inline]
    pub(super) fn end_of_attempt(&self) -> &[V::Scalar] {
        self.end.q.as_slice()
    }
}

/// The geometric mean of this number of positive numbers, given their product.
#[inline(always)]
fn geometric_mean(product: f64, count: u32) -> f64 {
    match count {
        1 => product,
        2 => product.sqrt(),
        4 => product.sqrt().sqrt(),
        _ => product.powf(f64::from(count).recip()),
    }
}
