//! The coefficients of a step by simple iteration, q and p in turn.
//!
//! A sweep takes ĝ_p from the p there is, makes q of it at once, and then the forces at the new q: its error shrinks by
//! (hω)² where all at a time would leave hω. It begins with the polynomial of the step before, continued, where this step
//! starts where that one ended, bit by bit; otherwise from rest.

use super::newton::Equations;
use super::nodes::{Nodes, dissipations, gradients, place, project, values};
use super::rule::{Modes, NODES, Panel, continuation, rules};
use afterbay_core::{Curvature, Effort, Mask, Quantity, Scalar, State, StepFailure, Vector};
use std::hint::cold_path;

/// Sweeps before the iteration is given up.
const LIMIT: u32 = 60;
/// Sweeps without a smaller change among them that end it.
const PATIENCE: u32 = 3;
/// A change of so many roundings may be noise.
const CLEAR: f64 = 64.0;
/// The next change that is not made, in roundings. Left out at every step, it is what K would drift by.
const UNSEEN: f64 = 0.015625;
/// A correction that leaves more than this of the one before asks for a new Jacobian.
const SLOW: f64 = 0.0625;
/// The most that changes may be, in roundings, where they no longer shrink.
const NOISE: f64 = 1024.0;
/// Roundings of what K is made of that are not yet an error of the quadrature.
const ROUNDINGS: f64 = 16.0;

/// A step while it is made.
#[derive(Clone, Debug)]
pub struct Workspace<V: Vector> {
    /// The quadrature rules, each with twice the nodes of the one before.
    rules: Vec<Vec<Panel<V::Scalar>>>,
    ahead: [Modes<V::Scalar>; 8],
    dissipative: bool,
    nodes: Vec<Nodes<V>>,
    /// The system at a panel.
    hq: [V; NODES],
    hp: [V; NODES],
    v: [V; NODES],
    d: [V; NODES],
    /// γ by degree of freedom, and the next ones.
    q_modes: Vec<Modes<V::Scalar>>,
    p_modes: Vec<Modes<V::Scalar>>,
    next: Vec<Modes<V::Scalar>>,
    next_q: Vec<Modes<V::Scalar>>,
    /// Newton's equations, where there are not too many of them, and whether the last step needed them.
    equations: Option<Equations>,
    stiff: bool,
    /// The new state.
    q: V,
    p: V,
    w: V,
    /// The step that made it, if there was one.
    made_by: Option<V::Scalar>,
    defect: f64,
}

fn none<T: Scalar>() -> Modes<T> {
    [[T::zero(); 4]; 2]
}

impl<V: Vector> Workspace<V> {
    pub(super) fn new<S: Curvature<V::Scalar> + ?Sized>(system: &S, stages: usize, nodes: usize) -> Self {
        let n = system.dof();
        let zeros = || V::zeros(n);
        let many = || std::array::from_fn(|_| V::zeros(n));
        let modes = || vec![none(); n];
        let rules = rules(stages, nodes);
        let panels = rules.last().map_or(0, Vec::len);
        Self {
            rules,
            ahead: continuation(),
            dissipative: !system.damping().zero,
            nodes: (0..panels).map(|_| Nodes { q: many(), p: many() }).collect(),
            hq: many(),
            hp: many(),
            v: many(),
            d: many(),
            q_modes: modes(),
            p_modes: modes(),
            next: modes(),
            next_q: modes(),
            equations: Equations::new(system, stages),
            stiff: false,
            q: zeros(),
            p: zeros(),
            w: zeros(),
            made_by: None,
            defect: 0.0,
        }
    }

    /// |ΔK| of the last step, in units of K's own rounding: beyond about 16 the quadrature did not resolve H, and a shorter step
    /// would.
    pub fn defect(&self) -> f64 {
        self.defect
    }

    /// Finds the new state.
    #[inline]
    pub(super) fn find<S>(
        &mut self,
        system: &S,
        h: V::Scalar,
        state: &State<V>,
    ) -> Result<Effort, StepFailure>
    where
        S: Curvature<V::Scalar> + ?Sized,
    {
        self.begin(h, state);
        let start = state.energy(system);
        let mut effort = Effort::default();
        for level in 0..self.rules.len() {
            effort += self.solve(system, h, state, level)?;
            let before = self.defect;
            self.end(system, h, state, level, start)?;
            if self.defect <= ROUNDINGS || (level > 0 && self.defect > 0.5 * before) {
                break;
            }
        }
        self.made_by = Some(h);
        Ok(effort)
    }

    /// The step is taken.
    #[inline]
    pub(super) fn hand_over<S>(&mut self, _system: &S, state: &mut State<V>)
    where
        S: Curvature<V::Scalar> + ?Sized,
    {
        state.q.as_mut_slice().copy_from_slice(self.q.as_slice());
        state.p.as_mut_slice().copy_from_slice(self.p.as_slice());
        if self.dissipative {
            state.w.as_mut_slice().copy_from_slice(self.w.as_slice());
        }
    }

    /// The first guess.
    #[inline]
    fn begin(&mut self, h: V::Scalar, state: &State<V>) {
        let continued = self.made_by.take() == Some(h)
            && self.q.as_slice() == state.q.as_slice()
            && self.p.as_slice() == state.p.as_slice();
        if !continued {
            return self.rest(state.dof());
        }
        for modes in [&mut self.q_modes, &mut self.p_modes] {
            for modes in &mut modes[..state.dof()] {
                *modes = carry(&self.ahead, modes);
            }
        }
    }

    /// z = z0
    #[inline]
    fn rest(&mut self, n: usize) {
        self.q_modes[..n].fill(none());
        self.p_modes[..n].fill(none());
    }

    /// Iterates to rounding: simply where that contracts fast, else by Newton's method.
    #[inline]
    fn solve<S>(
        &mut self,
        system: &S,
        h: V::Scalar,
        state: &State<V>,
        level: usize,
    ) -> Result<Effort, StepFailure>
    where
        S: Curvature<V::Scalar> + ?Sized,
    {
        let nodes = NODES * self.rules[level].len();
        let spent = |iterations: u32| Effort {
            evaluations: u64::from(iterations) * nodes as u64,
            iterations: u64::from(iterations),
        };
        let (failure, before) = if self.stiff {
            (None, 0)
        } else {
            match self.sweeps(system, h, state, level) {
                Ok(sweeps) => return Ok(spent(sweeps)),
                Err((failure, sweeps)) => (Some(failure), sweeps),
            }
        };
        cold_path();
        let after = self.correct(system, h, state, level, failure)?;
        Ok(spent(before + after))
    }

    /// Sweeps to rounding. How many, also where they lead nowhere.
    #[inline]
    fn sweeps<S>(
        &mut self,
        system: &S,
        h: V::Scalar,
        state: &State<V>,
        level: usize,
    ) -> Result<u32, (StepFailure, u32)>
    where
        S: Curvature<V::Scalar> + ?Sized,
    {
        let epsilon = V::Scalar::EPSILON;
        let sizes = [largest(state.q.as_slice()), largest(state.p.as_slice())];
        let (mut before, mut rate, mut least, mut left, mut waited) =
            (f64::NAN, 1.0_f64, f64::INFINITY, f64::INFINITY, 0);
        self.place_q(h, state, level);
        for sweeps in 1..=LIMIT {
            let change = self.sweep(system, h, state, level, sizes);
            if !change.is_finite() {
                return Err((
                    StepFailure::NonFinite { quantity: Quantity::Force, dof: 0, value: change },
                    sweeps,
                ));
            }
            if before > CLEAR * epsilon {
                rate = change / before;
            }
            waited = if change < least { 0 } else { waited + 1 };
            least = least.min(change);
            left = left.min(change) * rate;
            let lost = rate < 0.5 && left <= UNSEEN * epsilon;
            if lost || change == 0.0 || (waited >= PATIENCE && change <= NOISE * epsilon) {
                return Ok(sweeps);
            }
            let ratio = change / before;
            before = change;
            if waited >= PATIENCE || sweeps == LIMIT {
                return Err((StepFailure::NotContracting { dof: 0, iterations: sweeps, ratio }, sweeps));
            }
        }
        Err((StepFailure::NotContracting { dof: 0, iterations: LIMIT, ratio: rate }, LIMIT))
    }

    /// Newton's iteration, where there is one: from the continued polynomial if that leads on, else from rest.
    fn correct<S>(
        &mut self,
        system: &S,
        h: V::Scalar,
        state: &State<V>,
        level: usize,
        failure: Option<StepFailure>,
    ) -> Result<u32, StepFailure>
    where
        S: Curvature<V::Scalar> + ?Sized,
    {
        let Some(mut equations) = self.equations.take() else {
            let nothing = StepFailure::NotContracting { dof: 0, iterations: 0, ratio: f64::NAN };
            return Err(failure.unwrap_or(nothing));
        };
        let mut spent = 0;
        let mut outcome = Err(StepFailure::NewtonStalled { dof: 0, iterations: 0, update: f64::NAN });
        for guess in [failure.is_none(), false] {
            if !guess {
                self.rest(state.dof());
            }
            outcome = self.corrections(system, h, state, level, &mut equations, &mut spent);
            if outcome.is_ok() {
                break;
            }
        }
        // Sweeps contract again where h J is small.
        self.stiff = outcome.is_ok() && equations.gain > 0.5;
        self.equations = Some(equations);
        outcome.map(|()| spent)
    }

    fn corrections<S>(
        &mut self,
        system: &S,
        h: V::Scalar,
        state: &State<V>,
        level: usize,
        equations: &mut Equations,
        spent: &mut u32,
    ) -> Result<(), StepFailure>
    where
        S: Curvature<V::Scalar> + ?Sized,
    {
        let (n, epsilon, length) = (state.dof(), V::Scalar::EPSILON, h.to_f64());
        let (mut stale, mut before, mut least, mut waited) = (true, f64::NAN, f64::INFINITY, 0);
        for iterations in 1..=LIMIT {
            *spent += 1;
            if stale {
                let half = h.half();
                for j in 0..n {
                    self.q.as_mut_slice()[j] = half.mul_add(self.q_modes[j][0][0], state.q.as_slice()[j]);
                    self.p.as_mut_slice()[j] = half.mul_add(self.p_modes[j][0][0], state.p.as_slice()[j]);
                }
                let factorised = equations.factorise(system, length, self.q.as_slice(), self.p.as_slice());
                factorised.map_err(|dof| StepFailure::Singular { dof, slope: 0.0 })?;
            }
            self.place_q(h, state, level);
            self.velocities(system, h, state, level);
            self.next_q.copy_from_slice(&self.next);
            self.forces(system, state, level, true);
            let modes = [&mut self.q_modes[..], &mut self.p_modes[..]];
            let [dq, dp] = equations.correct([&self.next_q, &self.next], modes);
            let size = |start: &V, modes: &[Modes<V::Scalar>]| {
                let most = modes.iter().fold(0.0, |most: f64, modes| most.max(modes[0][0].to_f64().abs()));
                largest(start.as_slice()) + length.abs() * most
            };
            let share =
                |change: f64, size: f64| if change == 0.0 { 0.0 } else { length.abs() * change / size };
            let changes =
                [share(dq, size(&state.q, &self.q_modes)), share(dp, size(&state.p, &self.p_modes))];
            let change = changes[0].max(changes[1]) + 0.0 * (changes[0] + changes[1]);
            let stalled = StepFailure::NewtonStalled { dof: 0, iterations, update: change };
            if !change.is_finite() {
                return Err(stalled);
            }
            let ratio = change / before;
            waited = if change < least { 0 } else { waited + 1 };
            least = least.min(change);
            let lost = change == 0.0 || (ratio < 0.5 && ratio * change <= UNSEEN * epsilon);
            if lost || (waited >= PATIENCE && change <= NOISE * epsilon) {
                return Ok(());
            }
            if waited > 2 * PATIENCE {
                return Err(stalled);
            }
            stale = ratio > SLOW && change > CLEAR * epsilon;
            before = change;
        }
        Err(StepFailure::NewtonStalled { dof: 0, iterations: LIMIT, update: before })
    }

    #[inline]
    fn place_q(&mut self, h: V::Scalar, state: &State<V>, level: usize) {
        for (panel, nodes) in self.rules[level].iter().zip(&mut self.nodes) {
            place(panel, state.q.as_slice(), h, &self.q_modes, &mut nodes.q, state.dof());
        }
    }

    /// One sweep over q and p. By how much they moved, relative to their size.
    #[inline(always)]
    fn sweep<S>(&mut self, system: &S, h: V::Scalar, state: &State<V>, level: usize, sizes: [f64; 2]) -> f64
    where
        S: Curvature<V::Scalar> + ?Sized,
    {
        let n = state.dof();
        let length = h.to_f64().abs();
        self.velocities(system, h, state, level);
        let change_q = exchange(&self.next[..n], &mut self.q_modes[..n], sizes[0], length);
        self.place_q(h, state, level);
        self.forces(system, state, level, false);
        let change_p = exchange(&self.next[..n], &mut self.p_modes[..n], sizes[1], length);
        change_q.max(change_p) + 0.0 * (change_q + change_p)
    }

    /// ĝ_p from the q at the nodes and the p of its coefficients.
    #[inline(always)]
    fn velocities<S>(&mut self, system: &S, h: V::Scalar, state: &State<V>, level: usize)
    where
        S: Curvature<V::Scalar> + ?Sized,
    {
        let n = state.dof();
        let Self { rules, nodes, hq, hp, p_modes, next, .. } = self;
        let (p_modes, next) = (&p_modes[..n], &mut next[..n]);
        next.fill(none());
        for (panel, nodes) in rules[level].iter().zip(nodes) {
            place(panel, state.p.as_slice(), h, p_modes, &mut nodes.p, n);
            gradients(system, nodes, hq, hp);
            project(panel, hp, next, n);
        }
    }

    /// The force on p, from the state at the nodes and the velocity of the coefficients of q: those there are, or (`all_at_once`)
    /// those to come.
    #[inline(always)]
    fn forces<S>(&mut self, system: &S, state: &State<V>, level: usize, all_at_once: bool)
    where
        S: Curvature<V::Scalar> + ?Sized,
    {
        let n = state.dof();
        let Self { rules, nodes, hq, hp, v, d, q_modes, next_q, next, dissipative, .. } = self;
        let velocity = if all_at_once { &next_q[..n] } else { &q_modes[..n] };
        let next = &mut next[..n];
        next.fill(none());
        for (panel, nodes) in rules[level].iter().zip(nodes) {
            gradients(system, nodes, hq, hp);
            if *dissipative {
                values(panel, velocity, v, n);
                dissipations(system, nodes, v, d);
                for (hq, d) in hq.iter_mut().zip(&*d) {
                    hq.as_mut_slice().iter_mut().zip(d.as_slice()).for_each(|(hq, &d)| *hq += d);
                }
            }
            project(panel, hq, next, n);
        }
        for modes in next {
            *modes = modes.map(|half| half.map(|x| -x));
        }
    }

    /// z1, w1 and what K has moved by.
    #[inline]
    fn end<S>(
        &mut self,
        system: &S,
        h: V::Scalar,
        state: &State<V>,
        level: usize,
        start: V::Scalar,
    ) -> Result<(), StepFailure>
    where
        S: Curvature<V::Scalar> + ?Sized,
    {
        let n = state.dof();
        let zero = V::Scalar::zero();
        let Self { rules, nodes, hq, hp, v, d, q_modes, p_modes, q, p, w, .. } = self;
        let (q, p, w) = (q.as_mut_slice(), p.as_mut_slice(), w.as_mut_slice());
        let (q0, p0, w0) = (state.q.as_slice(), state.p.as_slice(), state.w.as_slice());
        let mut finite = zero.is_finite();
        for j in 0..n {
            q[j] = h.mul_add(q_modes[j][0][0], q0[j]);
            p[j] = h.mul_add(p_modes[j][0][0], p0[j]);
            w[j] = zero;
            finite = finite.and(q[j].is_finite()).and(p[j].is_finite());
        }
        let mut gained = zero;
        if self.dissipative {
            for (panel, nodes) in rules[level].iter().zip(&*nodes) {
                values(panel, q_modes, v, n);
                dissipations(system, nodes, v, d);
                for j in 0..n {
                    let power = std::array::from_fn(|i| d[i].as_slice()[j] * v[i].as_slice()[j]);
                    w[j] += panel.integrate(power);
                }
            }
            for j in 0..n {
                gained = h.mul_add(w[j], gained);
                w[j] = h.mul_add(w[j], w0[j]);
                finite = finite.and(w[j].is_finite());
            }
        }
        if !finite.all() {
            let parts = [(Quantity::Coordinate, &*q), (Quantity::Momentum, &*p), (Quantity::Reservoir, &*w)];
            return Err(StepFailure::non_finite(&parts));
        }
        // What a rounding of z makes of H.
        let (hq, hp) = (hq[0].as_mut_slice(), hp[0].as_mut_slice());
        system.gradient(q, p, hq, hp);
        let terms = (0..n).fold(zero, |sum, j| sum + (hq[j] * q[j]).abs() + (hp[j] * p[j]).abs());
        let end = system.energy(q, p);
        let scale = start.abs() + end.abs() + gained.abs() + terms;
        let defect = (end - start + gained).abs().to_f64();
        self.defect = if defect == 0.0 { 0.0 } else { defect / (V::Scalar::EPSILON * scale.to_f64()) };
        Ok(())
    }
}

/// The coefficients one interval later.
#[inline(always)]
fn carry<T: Scalar>(ahead: &[Modes<T>; 8], modes: &Modes<T>) -> Modes<T> {
    let mut carried = none();
    for (l, row) in ahead.iter().enumerate() {
        let mode = modes[l % 2][l / 2];
        for parity in 0..2 {
            for m in 0..4 {
                carried[parity][m] = row[parity][m].mul_add(mode, carried[parity][m]);
            }
        }
    }
    carried
}

/// `to` becomes `from`. The largest change over the size of z, or no number where there is none.
#[inline(always)]
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
    // The sum shows what comparisons skip.
    let sum = (sum[0] + sum[1]) + (sum[2] + sum[3]);
    let relative = if most == 0.0 { 0.0 } else { h * most / h.mul_add(reach, size) };
    relative + 0.0 * sum
}

#[inline]
fn largest<T: Scalar>(x: &[T]) -> f64 {
    x.iter().fold(0.0, |most: f64, x| most.max(x.to_f64().abs()))
}
