//! Newton's iteration with the exact derivative, used where the Jacobian at one point of the step
//! does not lead to the solution.
//!
//! Products with the derivative of the residual are approximated by differences, each of which
//! costs one evaluation of the nodes and no memory. The equations of the simplified iteration
//! precondition GMRES (D. A. Knoll, D. E. Keyes, J. Comput. Phys. 193 (2004) 357-397). A correction
//! is halved until it reduces the residual. If the iteration does not converge from a constant, the
//! solution is continued from h = 0.

use super::equations::Equations;
use super::iteration::{Workspace, largest, starts};
use super::nodes::{forces, place_q, velocities};
use super::progress::Progress;
use super::rule::Modes;
use crate::linear::Gmres;
use afterbay_core::{Curvature, Scalar, State, StepFailure, Vector};

/// The largest number of corrections of an iteration, and of products for each.
const MOST_CORRECTIONS: u32 = 30;
const PRODUCTS: usize = 60;
/// The relative residual at which the products stop.
const LEFT: f64 = 1e-3;
/// A correction is accepted if it reduces the residual by this part of its share at least (C. T.
/// Kelley, Iterative Methods for Linear and Nonlinear Equations, 8.2). Otherwise it is halved,
const LEAST_DECREASE: f64 = 1e-4;
/// at most so many times.
const MOST_HALVINGS: u32 = 6;
/// Corrections below this share of z are accepted without a test of the residual.
const UNTESTED_SHARE: f64 = 1e-6;
/// The number of corrections without a new smallest one after which the iteration stops.
const STALLED_CORRECTIONS: u32 = 6;
/// The first and the smallest continuation step as a share of h, and the largest number of
/// evaluations in a step.
const FIRST_STEP: f64 = 0.25;
const SHORTEST_STEP: f64 = 1e-3;
const MOST_EVALUATIONS: u32 = 20_000;

/// The memory of the iteration.
#[derive(Clone, Debug)]
pub(super) struct Krylov<T> {
    gmres: Gmres,
    /// The γ to which a correction is added, and a copy to restore
    base: [Vec<Modes<T>>; 2],
    kept: [Vec<Modes<T>>; 2],
    /// The residual of γ, and the correction
    missed: Vec<f64>,
    correction: Vec<f64>,
}

impl<T: Scalar> Krylov<T> {
    pub(super) fn new(modes: &[Modes<T>], unknowns: usize) -> Self {
        let pair = || [modes.to_vec(), modes.to_vec()];
        Self {
            gmres: Gmres::new(unknowns, PRODUCTS.min(unknowns)),
            base: pair(),
            kept: pair(),
            missed: vec![0.0; unknowns],
            correction: vec![0.0; unknowns],
        }
    }

    /// Saves γ.
    pub(super) fn keep(&mut self, modes: [&[Modes<T>]; 2]) {
        self.kept.iter_mut().zip(modes).for_each(|(to, from)| to.copy_from_slice(from));
    }

    /// Restores the saved γ.
    pub(super) fn recall(&self, modes: [&mut [Modes<T>]; 2]) {
        self.kept.iter().zip(modes).for_each(|(from, to)| to.copy_from_slice(from));
    }
}

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

fn stalled((dof, update): (usize, f64), iterations: u32) -> StepFailure {
    StepFailure::NewtonStalled { dof, iterations, update }
}

impl<V: Vector> Workspace<V> {
    /// Runs Newton's iteration from the current γ.
    pub(super) fn search<S>(
        &mut self,
        system: &S,
        h: V::Scalar,
        state: &State<V>,
        level: usize,
        (equations, krylov): (&mut Equations, &mut Krylov<V::Scalar>),
        spent: &mut u32,
    ) -> Result<(), StepFailure>
    where
        S: Curvature<V::Scalar> + ?Sized,
    {
        let epsilon = V::Scalar::EPSILON;
        let mut progress = Progress::new(epsilon);
        let mut last = (0, f64::NAN);
        for _ in 1..=MOST_CORRECTIONS {
            let weights = self.weights(h, state);
            self.residual(system, h, state, level, equations);
            let size = length(&equations.missing, weights);
            if !size.is_finite() {
                return Err(self.not_finite(equations));
            }
            self.factorise(system, h, state, equations)?;
            krylov.missed.copy_from_slice(&equations.missing);
            krylov.base[0].copy_from_slice(&self.q_modes);
            krylov.base[1].copy_from_slice(&self.p_modes);
            let Krylov { gmres, base, missed, correction, .. } = &mut *krylov;
            correction.copy_from_slice(missed);
            scaled(correction, weights);
            let inverse = weights.map(f64::recip);
            let mut multiply = |v: &[f64], to: &mut [f64]| {
                equations.missing.copy_from_slice(v);
                scaled(&mut equations.missing, inverse);
                equations.solve();
                let size = length(&equations.missing, weights);
                let share = if size > 0.0 { epsilon.sqrt() / size } else { 0.0 };
                self.shift(base, share, equations);
                self.residual(system, h, state, level, equations);
                for ((to, missing), missed) in to.iter_mut().zip(&equations.missing).zip(&*missed) {
                    *to = if share == 0.0 { 0.0 } else { (missed - missing) / share };
                }
                scaled(to, weights);
            };
            let products = gmres.solve(LEFT, correction, &mut multiply);
            *spent += products as u32 + 1;
            equations.missing.copy_from_slice(correction);
            scaled(&mut equations.missing, inverse);
            equations.solve();
            correction.copy_from_slice(&equations.missing);
            let [q, p] = equations.largest();
            let changes = [q.0 * weights[0], p.0 * weights[1]];
            let change = changes[0].max(changes[1]) + 0.0 * (changes[0] + changes[1]);
            last = (if changes[0] > changes[1] { q.1 } else { p.1 }, change);
            if !change.is_finite() {
                return Err(stalled(last, *spent));
            }
            let mut share = 1.0;
            self.shift(base, share, equations);
            for halvings in 0.. {
                if change <= UNTESTED_SHARE {
                    break;
                }
                self.residual(system, h, state, level, equations);
                *spent += 1;
                if length(&equations.missing, weights) < (1.0 - LEAST_DECREASE * share) * size {
                    break;
                }
                if halvings == MOST_HALVINGS {
                    return Err(stalled(last, *spent));
                }
                share *= 0.5;
                equations.missing.copy_from_slice(correction);
                self.shift(base, share, equations);
            }
            progress.see(share * change);
            if share == 1.0 && progress.has_arrived(progress.ratio, change) {
                return Ok(());
            }
            if progress.diverges(STALLED_CORRECTIONS) && change <= UNTESTED_SHARE {
                return if self.is_noise(system, h, state, change) {
                    Ok(())
                } else {
                    Err(stalled(last, *spent))
                };
            }
        }
        Err(stalled(last, *spent))
    }

    /// Continues the solution from h = 0 to h.
    pub(super) fn follow<S>(
        &mut self,
        system: &S,
        h: V::Scalar,
        state: &State<V>,
        level: usize,
        (equations, krylov): (&mut Equations, &mut Krylov<V::Scalar>),
        spent: &mut u32,
    ) -> Result<(), StepFailure>
    where
        S: Curvature<V::Scalar> + ?Sized,
    {
        self.rest(state.dof());
        let (mut share, mut stride) = (0.0_f64, FIRST_STEP);
        while share < 1.0 {
            let next = (share + stride).min(1.0);
            krylov.keep([&self.q_modes, &self.p_modes]);
            let shorter = h * V::Scalar::from_f64(next);
            match self.search(system, shorter, state, level, (&mut *equations, &mut *krylov), spent)
            {
                Ok(()) => (share, stride) = (next, 2.0 * stride),
                Err(failure) => {
                    krylov.recall([&mut self.q_modes, &mut self.p_modes]);
                    stride *= 0.25;
                    if stride < SHORTEST_STEP || *spent > MOST_EVALUATIONS {
                        return Err(failure);
                    }
                }
            }
        }
        Ok(())
    }

    /// The factors that convert changes of γ to shares of q and p.
    fn weights(&self, h: V::Scalar, state: &State<V>) -> [f64; 2] {
        let length = h.to_f64().abs();
        [(&state.q, &self.q_modes), (&state.p, &self.p_modes)].map(|(start, modes)| {
            let most =
                modes.iter().fold(0.0, |most: f64, modes| most.max(modes[0][0].to_f64().abs()));
            let size = largest(start.as_slice()) + length * most;
            if size > 0.0 { length / size } else { 1.0 }
        })
    }

    /// γ = base + share · missing
    fn shift(&mut self, base: &[Vec<Modes<V::Scalar>>; 2], share: f64, equations: &Equations) {
        self.q_modes.copy_from_slice(&base[0]);
        self.p_modes.copy_from_slice(&base[1]);
        equations.add(share, [&mut self.q_modes, &mut self.p_modes]);
    }

    /// Computes the residual of γ.
    pub(super) fn residual<S>(
        &mut self,
        system: &S,
        h: V::Scalar,
        state: &State<V>,
        level: usize,
        equations: &mut Equations,
    ) where
        S: Curvature<V::Scalar> + ?Sized,
    {
        let Self { rules, nodes, slopes, q_modes, p_modes, next, next_q, .. } = self;
        let (panels, [q, p]) = (&rules[level], starts(h, state));
        place_q(panels, nodes, q, q_modes);
        velocities(system, panels, nodes, slopes, p, p_modes, next_q);
        forces(system, panels, nodes, slopes, q, [q_modes, next_q], next);
        equations.see([next_q, next], [q_modes, p_modes]);
    }
}
