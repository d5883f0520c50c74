//! The coefficients of a step by fixed-point iteration, with q and p updated in turn.
//!
//! A sweep computes ĝ_p from the current p, updates q with it, and evaluates the forces at the new
//! q. Its error contracts by (hω)², whereas updating q and p together would contract by hω. The
//! iteration starts from the extrapolated polynomial of the last step if the state is exactly the
//! end of that step, otherwise from a constant.

use super::equations::{Equations, Response};
use super::krylov::Krylov;
use super::nodes::{Nodes, Slopes, Start, forces, place_q, velocities};
use super::progress::{MOST_ITERATIONS, Progress};
use super::rule::{Modes, NODES, Panel, extrapolate, extrapolation, rules, value};
use crate::commit::store;
use crate::gradient_check::check_gradient;
use crate::kernels::reductions::{largest_if_finite, max_norm};
use crate::legendre::MODES;
use crate::measured_rounding::EnergyRounding;
use afterbay_core::solver::Updates;
use afterbay_core::{Curvature, Effort, Scalar, State, StepFailure, Vector};
use std::hint::cold_path;

/// The number of changes without a new smallest one after which the sweeps stop. A choice.
const STALLED_SWEEPS: u32 = 3;
/// The error of K, in roundings of its terms, that is not attributed to the quadrature.
const RESOLVED_ROUNDINGS: f64 = 16.0;

/// The error of K, in roundings of its terms, that each of the N terms of a sum may contribute.
pub(super) const ROUNDINGS_A_TERM: f64 = 0.5;
/// The number of unknowns up to which the equations are allocated with the workspace, so that no
/// step allocates. A choice.
const MOST_PREALLOCATED: usize = 2048;

/// A step of size h from `state`, where H is `start`, with the quadrature rule of a level.
pub(super) struct Problem<'a, V: Vector, S: ?Sized> {
    pub(super) system: &'a S,
    pub(super) h: V::Scalar,
    pub(super) state: &'a State<V>,
    pub(super) start: V::Scalar,
    pub(super) level: usize,
}

impl<V: Vector, S: ?Sized> Problem<'_, V, S> {
    /// The initial values of q and p; the sign of h is reversed for p.
    #[inline(always)]
    pub(super) fn starts(&self) -> [Start<'_, V::Scalar>; 2] {
        let Self { h, state, .. } = *self;
        [Start { at: state.q.as_slice(), h }, Start { at: state.p.as_slice(), h: -h }]
    }
}

/// The memory of a step.
#[derive(Clone, Debug)]
pub struct Workspace<V: Vector> {
    /// The quadrature rules, each with twice the nodes of the one before.
    pub(super) rules: Vec<Vec<Panel<V::Scalar>>>,
    extrapolation: [Modes<V::Scalar>; MODES],
    pub(super) dissipative: bool,
    pub(super) nodes: Vec<Nodes<V>>,
    pub(super) slopes: Slopes<V>,
    /// The coefficients of q' and of -p' for each degree of freedom, and their next iterates.
    pub(super) q_modes: Vec<Modes<V::Scalar>>,
    pub(super) p_modes: Vec<Modes<V::Scalar>>,
    pub(super) next: Vec<Modes<V::Scalar>>,
    pub(super) next_q: Vec<Modes<V::Scalar>>,
    pub(super) stages: usize,
    /// Newton's equations, allocated beforehand if they are few, and whether the last step needed
    /// them.
    pub(super) equations: Option<Box<Equations>>,
    pub(super) stiff: bool,
    /// The memory of the iteration with the exact derivative, and whether this step needed it.
    pub(super) krylov: Option<Box<Krylov<V::Scalar>>>,
    pub(super) hard: bool,
    /// Whether that iteration is allowed. It is not if a shorter step is an alternative.
    pub(crate) thorough: bool,
    /// The new state.
    pub(super) q: V,
    pub(super) p: V,
    pub(super) w: V,
    /// The size of the step that produced it, if any.
    made_by: Option<V::Scalar>,
    /// Whether the rounding of H was measured at the start and at the end of the step.
    pub(super) measured_at: [bool; 2],
    pub(crate) energy_rounding: EnergyRounding<V::Scalar>,
    /// Σ Δw_j
    pub(super) gained: V::Scalar,
    pub(super) defect: f64,
    /// The sum of the terms of K at the end of the last step.
    pub(super) scale: f64,
}

impl<V: Vector> Workspace<V> {
    pub(crate) fn new<S: Curvature<V::Scalar> + ?Sized>(
        system: &S,
        stages: usize,
        nodes: usize,
    ) -> Self {
        let n = system.dof();
        let zeros = || V::zeros(n);
        let modes = || vec![Modes::zero(); n];
        let rules = rules(stages, nodes);
        let panels = rules.last().map_or(0, Vec::len);
        Self {
            rules,
            extrapolation: extrapolation(),
            dissipative: !system.dissipation_form().zero,
            nodes: (0..panels).map(|_| Nodes::new(n)).collect(),
            slopes: Slopes::new(n),
            q_modes: modes(),
            p_modes: modes(),
            next: modes(),
            next_q: modes(),
            stages,
            equations: (2 * stages * n <= MOST_PREALLOCATED)
                .then(|| Equations::new(system, stages).ok().map(Box::new))
                .flatten(),
            stiff: false,
            krylov: None,
            hard: false,
            thorough: true,
            q: zeros(),
            p: zeros(),
            w: zeros(),
            made_by: None,
            measured_at: [false; 2],
            energy_rounding: EnergyRounding::new(n),
            gained: V::Scalar::zero(),
            defect: 0.0,
            scale: 0.0,
        }
    }

    /// The change of K in the last step, in roundings of H, w and the terms of `∇H·z` at both ends.
    /// It exceeds 16 only if the second derivatives amplify roundings of z by that much.
    pub fn defect(&self) -> f64 {
        self.defect
    }

    /// The sum of the terms of K, whose rounding is the unit of the defect.
    pub(crate) fn scale(&self) -> f64 {
        self.scale
    }

    /// Whether Newton's method solved the last step, which was stiff.
    pub(crate) fn solved_by_newton(&self) -> bool {
        self.stiff
    }

    /// Passes to `see` the responses to a defect of the slopes of a step that Newton's method
    /// solved, and to `see_sum` the errors of q' and -p' that add up over the run. The part of the
    /// defect that these roundings of q and p may cause is left out.
    pub(crate) fn respond(
        &mut self,
        roundings: impl Fn(usize) -> [f64; 2],
        defect: impl Fn(usize) -> [f64; 2],
        see: impl FnMut(usize, Response),
        see_sum: impl FnMut(usize, [f64; 2]),
    ) {
        if let Some(equations) = &mut self.equations {
            equations.respond(roundings, defect, see);
            equations.respond_again(see_sum);
        }
    }

    /// The new q, p and w.
    pub(crate) fn ends(&self) -> [&V; 3] {
        [&self.q, &self.p, &self.w]
    }

    /// q' and -p' of one degree of freedom at the times τ of the step.
    pub(crate) fn slopes_at<const K: usize>(
        &self,
        dof: usize,
        times: &[V::Scalar; K],
    ) -> [[V::Scalar; K]; 2] {
        [&self.q_modes, &self.p_modes].map(|modes| times.map(|time| value(&modes[dof], time)))
    }

    /// Computes the new state.
    #[inline]
    pub(crate) fn find<S: Curvature<V::Scalar> + ?Sized>(
        &mut self,
        system: &S,
        h: V::Scalar,
        state: &State<V>,
    ) -> Result<Effort, StepFailure> {
        self.initial_guess(h, state);
        self.hard = false;
        let mut problem = Problem { system, h, state, start: state.energy(system), level: 0 };
        let mut effort = Effort::default();
        for level in 0..self.rules.len() {
            problem.level = level;
            effort += self.solve(&problem)?;
            let before = self.defect;
            self.finish(&problem)?;
            self.measured_at[1] = false;
            // If more nodes do not reduce the error, it may be due to the rounding of H. The error
            // with the most nodes may be due to it as well.
            let is_last = level + 1 == self.rules.len();
            let settled = level > 0 && (is_last || self.defect > 0.5 * before);
            let resolved = self.defect <= RESOLVED_ROUNDINGS;
            if resolved
                || (settled && self.defect <= ROUNDINGS_A_TERM * state.dof() as f64)
                || (settled && self.is_rounding(&problem))
            {
                let kept = resolved || self.is_energy_rounding(&problem);
                if !kept {
                    self.restore(&problem)?;
                }
                if kept || self.keeps_k(&problem) {
                    self.made_by = Some(h);
                    return Ok(effort);
                }
            }
        }
        check_gradient(system, state.q.as_slice(), state.p.as_slice())?;
        let nodes = self.rules.last().map_or(0, |panels| NODES * panels.len());
        Err(StepFailure::Unresolved { nodes, roundings: self.defect })
    }

    /// Writes the new state.
    #[inline]
    pub(super) fn commit(&self, state: &mut State<V>) {
        store(state, self.ends().map(V::as_slice), self.dissipative);
    }

    /// Sets the initial guess.
    #[inline]
    fn initial_guess(&mut self, h: V::Scalar, state: &State<V>) {
        let continued = self.made_by.take() == Some(h)
            && self.q.as_slice() == state.q.as_slice()
            && self.p.as_slice() == state.p.as_slice();
        self.measured_at = [continued && self.measured_at[1], false];
        if !continued {
            return self.rest(state.dof());
        }
        for modes in [&mut self.q_modes, &mut self.p_modes] {
            for modes in &mut modes[..state.dof()] {
                *modes = extrapolate(&self.extrapolation, modes);
            }
        }
    }

    /// The coefficients of q' and of -p'.
    pub(super) fn modes(&mut self) -> [&mut [Modes<V::Scalar>]; 2] {
        [&mut self.q_modes, &mut self.p_modes]
    }

    /// Sets z(τ) = z0.
    #[inline]
    pub(super) fn rest(&mut self, n: usize) {
        self.q_modes[..n].fill(Modes::zero());
        self.p_modes[..n].fill(Modes::zero());
    }

    /// Iterates to rounding: by sweeps if they contract fast, else by Newton's method.
    #[inline]
    fn solve<S: Curvature<V::Scalar> + ?Sized>(
        &mut self,
        problem: &Problem<'_, V, S>,
    ) -> Result<Effort, StepFailure> {
        let nodes = NODES * self.rules[problem.level].len();
        let spent = |iterations: u32| Effort {
            evaluations: u64::from(iterations) * nodes as u64,
            iterations: u64::from(iterations),
        };
        let before = if self.stiff {
            0
        } else {
            match self.sweeps(problem) {
                Ok(sweeps) => return Ok(spent(sweeps)),
                Err(sweeps) => sweeps,
            }
        };
        cold_path();
        match self.newton(problem) {
            Ok(after) => Ok(spent(before + after)),
            Err(StepFailure::NewtonStalled { dof, iterations, update }) => {
                let iterations = before + iterations;
                Err(StepFailure::NewtonStalled { dof, iterations, update })
            }
            Err(failure) => Err(failure),
        }
    }

    /// Sweeps until the coefficients converge to rounding. Returns the number of sweeps, as the
    /// error if they do not converge.
    #[inline]
    fn sweeps<S: Curvature<V::Scalar> + ?Sized>(
        &mut self,
        problem: &Problem<'_, V, S>,
    ) -> Result<u32, u32> {
        let epsilon = V::Scalar::EPSILON;
        let Problem { state, level, .. } = *problem;
        let sizes = [max_norm(state.q.as_slice()), max_norm(state.p.as_slice())];
        let (mut updates, mut rate, mut left) = (Updates::none(), 1.0_f64, f64::INFINITY);
        place_q(&self.rules[level], &mut self.nodes, problem.starts()[0], &self.q_modes);
        for sweeps in 1..=MOST_ITERATIONS {
            let change = self.sweep(problem, sizes);
            if !change.is_finite() {
                return Err(sweeps);
            }
            let clear = Progress::of(&updates, epsilon).is_clear();
            updates.see(change);
            if clear {
                rate = updates.ratio();
            }
            let progress = Progress::of(&updates, epsilon);
            left = left.min(change);
            if progress.has_arrived(rate, left) {
                return Ok(sweeps);
            }
            left *= rate;
            if progress.diverges(STALLED_SWEEPS) {
                let noise = self.is_noise(problem, change);
                return if noise { Ok(sweeps) } else { Err(sweeps) };
            }
        }
        if Progress::of(&updates, epsilon).is_rounding() {
            Ok(MOST_ITERATIONS)
        } else {
            Err(MOST_ITERATIONS)
        }
    }

    /// Takes one sweep over q and p. Returns their change relative to their size.
    #[inline(always)]
    fn sweep<S: Curvature<V::Scalar> + ?Sized>(
        &mut self,
        problem: &Problem<'_, V, S>,
        sizes: [f64; 2],
    ) -> f64 {
        let Problem { system, h, state, level, .. } = *problem;
        let (n, length) = (state.dof(), h.to_f64().abs());
        let Self { rules, nodes, slopes, q_modes, p_modes, next, .. } = self;
        let (q_modes, p_modes, next) = (&mut q_modes[..n], &mut p_modes[..n], &mut next[..n]);
        let (panels, [q, p]) = (&rules[level], problem.starts());
        velocities(system, panels, nodes, slopes, p, p_modes, next);
        let change_q = exchange(next, q_modes, sizes[0], length);
        forces(system, panels, nodes, slopes, q, [q_modes, q_modes], next);
        let change_p = exchange(next, p_modes, sizes[1], length);
        largest_if_finite([change_q, change_p])
    }
}

/// Copies `from` to `to`. Returns the largest change relative to the size of z, or NaN if an entry
/// is not finite.
#[inline(never)]
fn exchange<T: Scalar>(from: &[Modes<T>], to: &mut [Modes<T>], size: f64, h: f64) -> f64 {
    let larger = |a: f64, b: f64| if a > b { a } else { b };
    let (mut most, mut sum, mut reach) = ([0.0; 4], [0.0; 4], 0.0);
    for (from, to) in from.iter().zip(to) {
        let change = |parity: usize, m: usize| (from[parity][m] - to[parity][m]).abs().to_f64();
        for m in 0..4 {
            let (even, odd) = (change(0, m), change(1, m));
            most[m] = larger(most[m], larger(even, odd));
            sum[m] += even + odd;
        }
        reach = larger(reach, from[0][0].abs().to_f64());
        *to = *from;
    }
    let most = larger(larger(most[0], most[1]), larger(most[2], most[3]));
    // Comparisons ignore NaN; the sum does not.
    let sum = (sum[0] + sum[1]) + (sum[2] + sum[3]);
    let relative = if most == 0.0 { 0.0 } else { h * most / h.mul_add(reach, size) };
    relative + 0.0 * sum
}
