//! Newton's iteration with the exact derivative, used where the Jacobian at one point of the step
//! does not lead to the solution.
//!
//! Products with the derivative of the residual are approximated by differences, each of which
//! costs one evaluation of the nodes and no memory. The equations of the simplified iteration
//! precondition GMRES (D. A. Knoll, D. E. Keyes, J. Comput. Phys. 193 (2004) 357-397). A correction
//! is halved until it reduces the residual. If the iteration does not converge from a constant, the
//! solution is continued from h = 0.

use super::iteration::Workspace;
use super::krylov::Krylov;
use super::newton::Step;
use super::nodes::extent;
use super::progress::Progress;
use super::rule::Modes;
use crate::iteration::{CONTINUATION, Correction, Iteration, Verdict};
use crate::kernels::reductions::largest_if_finite;
use afterbay_core::solver::{Updates, follow};
use afterbay_core::{Curvature, Scalar, StepFailure, Vector};

/// The share of the residual at which the products stop; between 0 and 1. A choice.
const REMAINING_SHARE: f64 = 1e-3;
/// A correction is accepted if it reduces the residual by this part of its share at least (C. T.
/// Kelley, Iterative Methods for Linear and Nonlinear Equations, 8.2). Otherwise it is halved.
const LEAST_DECREASE: f64 = 1e-4;
/// The largest number of halvings of a correction.
const MOST_HALVINGS: u32 = 6;
/// Corrections below this share of z are accepted without a test of the residual. A choice.
const UNTESTED_SHARE: f64 = 1e-6;
/// The number of corrections without a new smallest one after which the iteration stops. A choice.
const STALLED_CORRECTIONS: u32 = 6;

/// Scales the two parts of x to shares of q and p.
fn scaled(x: &mut [f64], weights: [f64; 2]) {
    let (q, p) = x.split_at_mut(x.len() / 2);
    for (part, weight) in [q, p].into_iter().zip(weights) {
        part.iter_mut().for_each(|x| *x *= weight);
    }
}

/// The norm of a vector whose two parts have these weights.
fn length(x: &[f64], weights: [f64; 2]) -> f64 {
    let (q, p) = x.split_at(x.len() / 2);
    let square = |part: &[f64], weight: f64| part.iter().map(|x| (weight * x).powi(2)).sum::<f64>();
    (square(q, weights[0]) + square(p, weights[1])).sqrt()
}

/// The iteration for a step, and the state of its correction.
pub(super) struct Exact<'s, 'a, V: Vector, S: ?Sized> {
    step: &'s mut Step<'a, V, S>,
    krylov: &'s mut Krylov<V::Scalar>,
    weights: [f64; 2],
    /// The norm of the residual.
    size: f64,
    /// The share of the correction that was added, and the size of the whole correction relative to
    /// z.
    share: f64,
    change: f64,
    /// The degree of freedom that it changes most.
    dof: usize,
}

impl<'s, 'a, V: Vector, S: Curvature<V::Scalar> + ?Sized> Exact<'s, 'a, V, S> {
    /// The iteration from the current γ.
    pub(super) fn new(step: &'s mut Step<'a, V, S>, krylov: &'s mut Krylov<V::Scalar>) -> Self {
        let (weights, size, change) = ([1.0; 2], f64::NAN, f64::NAN);
        Self { step, krylov, weights, size, share: 1.0, change, dof: 0 }
    }

    /// Continues the solution from h = 0 to h.
    pub(super) fn solve_by_continuation(&mut self) -> Result<(), StepFailure> {
        self.step.workspace.rest(self.step.problem.state.dof());
        let h = self.step.problem.h;
        let outcome = follow(CONTINUATION, |s| {
            self.krylov.keep(self.step.workspace.modes());
            self.step.problem.h = h * V::Scalar::from_f64(s);
            let outcome = self.converge();
            if outcome.is_err() {
                self.krylov.recall(self.step.workspace.modes());
            }
            (self.step.spent, outcome)
        });
        self.step.problem.h = h;
        outcome
    }

    /// γ = base + share · missing
    fn shift(&mut self, share: f64) {
        let Self { step, krylov, .. } = self;
        shift(step, &krylov.base, share);
    }

    fn stalled(&self) -> StepFailure {
        self.step.stalled(self.dof, self.change)
    }
}

/// γ = base + share · missing
fn shift<V: Vector, S: ?Sized>(
    step: &mut Step<'_, V, S>,
    base: &[Vec<Modes<V::Scalar>>; 2],
    share: f64,
) {
    let [q, p] = step.workspace.modes();
    q.copy_from_slice(&base[0]);
    p.copy_from_slice(&base[1]);
    step.equations.add(share, [q, p]);
}

impl<V: Vector, S: Curvature<V::Scalar> + ?Sized> Iteration for Exact<'_, '_, V, S> {
    const MOST_CORRECTIONS: u32 = 30;

    fn residual(&mut self) -> Result<(), StepFailure> {
        self.weights = self.step.weights();
        self.step.evaluate();
        self.size = length(&self.step.equations.missing, self.weights);
        if self.size.is_finite() { Ok(()) } else { Err(self.step.not_finite()) }
    }

    fn factorise(&mut self) -> Result<(), StepFailure> {
        self.step.factorise()
    }

    /// Solves the equations with the exact derivative to a share of the residual, by GMRES.
    fn solve(&mut self) {
        let Self { step, krylov, weights, .. } = self;
        let (weights, inverse) = (*weights, weights.map(f64::recip));
        let Krylov { gmres, base, missed, correction, .. } = &mut **krylov;
        missed.copy_from_slice(&step.equations.missing);
        for (base, modes) in base.iter_mut().zip(step.workspace.modes()) {
            base.copy_from_slice(modes);
        }
        correction.copy_from_slice(missed);
        scaled(correction, weights);
        let mut multiply = |v: &[f64], to: &mut [f64]| {
            step.equations.missing.copy_from_slice(v);
            scaled(&mut step.equations.missing, inverse);
            step.equations.solve();
            let size = length(&step.equations.missing, weights);
            let share = if size > 0.0 { V::Scalar::EPSILON.sqrt() / size } else { 0.0 };
            shift(step, base, share);
            step.evaluate();
            for ((to, missing), missed) in to.iter_mut().zip(&step.equations.missing).zip(&*missed)
            {
                *to = if share == 0.0 { 0.0 } else { (missed - missing) / share };
            }
            scaled(to, weights);
        };
        let products = gmres.solve(REMAINING_SHARE, correction, &mut multiply);
        step.spent += products as u32 + 1;
        step.equations.missing.copy_from_slice(correction);
        scaled(&mut step.equations.missing, inverse);
        step.equations.solve();
        correction.copy_from_slice(&step.equations.missing);
    }

    /// Adds the correction, or half of it repeatedly until that reduces the residual.
    fn update(&mut self) -> Result<f64, StepFailure> {
        let [q, p] = self.step.equations.largest();
        let changes = [q.0 * self.weights[0], p.0 * self.weights[1]];
        self.change = largest_if_finite(changes);
        self.dof = if changes[0] > changes[1] { q.1 } else { p.1 };
        if !self.change.is_finite() {
            return Err(self.stalled());
        }
        self.share = 1.0;
        self.shift(self.share);
        for halvings in 0.. {
            if self.change <= UNTESTED_SHARE {
                break;
            }
            self.step.evaluate();
            self.step.spent += 1;
            let enough = (1.0 - LEAST_DECREASE * self.share) * self.size;
            if length(&self.step.equations.missing, self.weights) < enough {
                break;
            }
            if halvings == MOST_HALVINGS {
                return Err(self.stalled());
            }
            self.share *= 0.5;
            self.step.equations.missing.copy_from_slice(&self.krylov.correction);
            self.shift(self.share);
        }
        Ok(self.share * self.change)
    }

    fn judge(
        &mut self,
        updates: &Updates<f64>,
        Correction { is_last, .. }: Correction,
    ) -> Result<Verdict, StepFailure> {
        let progress = Progress::of(updates, V::Scalar::EPSILON);
        if self.share == 1.0 && progress.has_arrived(updates.ratio(), self.change) {
            return Ok(Verdict::Converged);
        }
        let diverges = progress.diverges(STALLED_CORRECTIONS) && self.change <= UNTESTED_SHARE;
        let may_be_noise = diverges || is_last;
        if may_be_noise && self.step.workspace.is_noise(&self.step.problem, self.change) {
            return Ok(Verdict::Converged);
        }
        if diverges || is_last { Err(self.stalled()) } else { Ok(Verdict::Renew) }
    }
}

impl<V: Vector, S: ?Sized> Step<'_, V, S> {
    /// The factors that convert changes of γ to shares of q and p.
    fn weights(&self) -> [f64; 2] {
        let (Workspace { q_modes, p_modes, .. }, problem) = (&*self.workspace, &self.problem);
        let (length, state) = (problem.h.to_f64().abs(), problem.state);
        [(&state.q, q_modes), (&state.p, p_modes)].map(|(start, modes)| {
            let size = extent(start, modes, length);
            if size > 0.0 { length / size } else { 1.0 }
        })
    }
}
