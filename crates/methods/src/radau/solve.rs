//! The simplified Newton iteration.
//!
//! It ends when the remaining correction, η |ΔZ| with η = θ/(1-θ) and θ the ratio of the last two
//! corrections, is a tenth of the error allowed for the step (Hairer, Wanner II, IV.8). The
//! Jacobian is that at a predicted stage in the first half of the step. It is kept while
//! corrections contract fast, and the factorised matrices as long as h does not change.

use super::engine::Engine;
use super::share::{Allowed, power};
use super::stages::Stages;
use crate::kernels::reductions::see_size;
use afterbay_core::{Curvature, Effort, Scalar, State, StepFailure, System, Vector};

/// The largest number of corrections of a step.
const MOST_CORRECTIONS: u32 = 10;
/// The largest number of corrections of a step in scalars of more than 53 bits.
const MOST_CORRECTIONS_EXTENDED: u32 = 60;
/// The error of the iteration relative to the error allowed for the step; between 0.01 and 0.1 in
/// RADAU5 (Hairer, Wanner II, IV.8).
const SOLVED: f64 = 0.1;
/// Corrections below this number of roundings of z end the iteration. A choice.
const CONVERGED_ROUNDINGS: f64 = 2.0;
/// Corrections below this number of roundings of z end the iteration if they no longer shrink by
/// the factor [`SHRINKING`]. A choice.
const STAGNANT_ROUNDINGS: f64 = 64.0;
/// The ratio of successive corrections above which they stagnate. A choice.
const SHRINKING: f64 = 0.3;
/// The ratio of successive corrections above which the iteration is given up; below 1. A choice.
const DIVERGING: f64 = 0.9;
/// The ratio of successive corrections up to which the Jacobian is kept for the next step; above 0
/// and below 1. A choice.
const CONTRACTING: f64 = 0.02;
/// The least η from which a step starts.
const LEAST_ETA: f64 = 1e-16;
/// The polynomial of the last step is extrapolated to steps up to this many times as long. The last
/// step may have been cut short by a break. A choice, above the largest growth of a step.
const LARGEST_STRETCH: f64 = 16.0;
/// A step starts with the last η to this power. The result is larger than η, since the corrections
/// of the step may converge less fast (Hairer, Wanner II, IV.8).
const ETA_POWER: f64 = 0.8;

impl<V: Vector, const S: usize> Engine<V, S> {
    /// Solves the equations of the step h from `state`. The stages start from the polynomial of the
    /// accepted step, if there is one, at its times `offset + ratio c_i`;
    /// `shift` is `[offset, ratio]`.
    #[inline(always)]
    pub(super) fn solve<F: Curvature<V::Scalar> + ?Sized>(
        &mut self,
        system: &F,
        h: V::Scalar,
        state: &State<V>,
        allowed: Allowed,
        shift: Option<[V::Scalar; 2]>,
        effort: &mut Effort,
    ) -> Result<(), StepFailure> {
        self.h = h;
        let length = h.to_f64();
        loop {
            self.initial_guess(system, shift);
            if self.renew {
                self.place((S - 3) / 2, state);
                self.equations.evaluate(system, &self.at[0], &self.at[1]);
                (self.fresh, self.renew, self.factorised) = (true, false, 0.0);
            }
            if self.factorised != length {
                self.factorised = 0.0;
                self.equations.factorise(&self.tables, length)?;
                self.factorised = length;
            }
            match self.iterate(system, h, state, allowed, effort) {
                Ok(()) => return Ok(()),
                Err(failure) => {
                    self.renew = true;
                    if std::mem::replace(&mut self.fresh, false) {
                        return Err(failure);
                    }
                }
            }
        }
    }

    #[inline(always)]
    fn initial_guess<F>(&mut self, system: &F, shift: Option<[V::Scalar; 2]>)
    where
        F: System<V::Scalar> + ?Sized,
    {
        let known = shift.filter(|[_, ratio]| ratio.to_f64().abs() <= LARGEST_STRETCH);
        let Some([offset, ratio]) = known else {
            let free = system.dof() - system.motors();
            return self.trial.rest(free, self.tables.nodes.map(|node| self.h * node));
        };
        if self.extrapolation_for != shift {
            self.extrapolation = self.tables.extrapolation(offset, ratio);
            self.extrapolation_for = shift;
        }
        self.trial.extrapolate(&self.extrapolation, &self.kept, offset == V::Scalar::one());
    }

    /// Writes the point of a stage to `at`.
    #[inline(always)]
    pub(super) fn place(&mut self, stage: usize, state: &State<V>) {
        let Self { at, trial, .. } = self;
        let parts = [(&state.q, &trial.q[stage]), (&state.p, &trial.p[stage])];
        for (to, (from, by)) in at.iter_mut().zip(parts) {
            let steps = from.as_slice().iter().zip(by.as_slice());
            for (to, (&from, &by)) in to.as_mut_slice().iter_mut().zip(steps) {
                *to = from + by;
            }
        }
    }

    /// Corrects the stages until the remaining error is small relative to the allowed one.
    #[inline(always)]
    fn iterate<F: Curvature<V::Scalar> + ?Sized>(
        &mut self,
        system: &F,
        h: V::Scalar,
        state: &State<V>,
        allowed: Allowed,
        effort: &mut Effort,
    ) -> Result<(), StepFailure> {
        let shares = allowed.shares();
        let converged = CONVERGED_ROUNDINGS * allowed.rounding;
        let stagnant = STAGNANT_ROUNDINGS * allowed.rounding;
        let solved = (SOLVED * allowed.share).max(converged);
        let most =
            if V::Scalar::IS_EXTENDED { MOST_CORRECTIONS_EXTENDED } else { MOST_CORRECTIONS };
        let mut eta = power(self.eta.max(LEAST_ETA), ETA_POWER);
        let (mut before, mut theta) = (f64::NAN, 0.0);
        for count in 1..=most {
            self.evaluate_slopes(system, state);
            effort.evaluations += S as u64;
            effort.iterations += 1;
            let change = self.correct(h, &shares);
            if !change.is_finite() {
                self.eta = 1.0;
                return Err(self.trial.not_finite());
            }
            if count > 1 {
                theta = change / before;
                eta = if theta < 1.0 { theta / (1.0 - theta) } else { f64::INFINITY };
            }
            let stagnates = theta > SHRINKING && change <= stagnant;
            if change <= converged || stagnates || eta * change <= solved {
                // A larger η would make the next step take corrections that it may not need.
                self.eta = eta.min(1.0);
                self.renew |= theta > CONTRACTING;
                self.evaluate_slopes(system, state);
                effort.evaluations += S as u64;
                return Ok(());
            }
            before = change;
            let left = i32::try_from(most - count).unwrap_or(0);
            if count > 1 && (theta > DIVERGING || theta.powi(left) * eta * change > solved) {
                break;
            }
        }
        self.eta = 1.0;
        Err(self.stalled(effort.iterations, &shares))
    }

    /// Computes the slopes at the stages.
    #[inline(always)]
    fn evaluate_slopes<F: Curvature<V::Scalar> + ?Sized>(&mut self, system: &F, state: &State<V>) {
        let Self { trial, points, last, dissipative, .. } = self;
        trial.evaluate_slopes(system, *dissipative, state, points, last);
    }

    /// Corrects the stages once, and returns the size of the correction; NaN if it is not finite.
    #[inline(always)]
    fn correct(&mut self, h: V::Scalar, shares: &impl Fn(usize) -> [f64; 2]) -> f64 {
        let Self { tables, trial: Stages { q, p, v, f, .. }, equations, .. } = self;
        let n = V::LEN.unwrap_or(q[0].as_slice().len());
        equations.solve(tables, n, |d| {
            [
                Stages::<V, S>::residual(tables, h, q, v, d),
                Stages::<V, S>::residual(tables, h, p, f, d),
            ]
        });
        let mut found = [0.0; 2];
        for d in 0..n {
            let corrections = equations.solution(d);
            for ((to, by), share) in [&mut *q, &mut *p].into_iter().zip(corrections).zip(shares(d))
            {
                for (to, by) in to.iter_mut().zip(by) {
                    to.as_mut_slice()[d] += V::Scalar::from_f64(by);
                    found = see_size(found, by.abs() * share);
                }
            }
        }
        found[0] + found[1]
    }

    /// The failure of an iteration that does not converge.
    #[cold]
    fn stalled(&self, iterations: u64, shares: &impl Fn(usize) -> [f64; 2]) -> StepFailure {
        let n = self.end.q.as_slice().len();
        let size = |d: usize| {
            let parts = self.equations.solution(d).into_iter().zip(shares(d));
            let sizes = parts.flat_map(|(part, share)| part.map(|x| x.abs() * share));
            sizes.fold(0.0, f64::max)
        };
        let dof = (0..n).fold(0, |most, d| if size(d) > size(most) { d } else { most });
        let [q, p] = self.equations.solution(dof);
        let update = q.into_iter().chain(p).fold(0.0, |most: f64, x| most.max(x.abs()));
        let iterations = u32::try_from(iterations).unwrap_or(u32::MAX);
        StepFailure::NewtonStalled { dof, iterations, update }
    }
}
