//! Explicit Runge-Kutta methods with step size control, and K exact after every step.
//!
//! ```text
//! z = (q, p)        f = (∂H/∂p, -∂H/∂q - D)        v = ∂H/∂p        Z_i = z0 + h Σ_j a_ij f(Z_j)
//! z1 = z0 + h Σ_i b_i f(Z_i)        w1_j = w0_j + h Σ_i b_i D_j(Z_i) v_j(Z_i)
//! ```
//!
//! The error is estimated by embedded weights of lower order (E. Hairer, S. P. Nørsett, G. Wanner,
//! Solving Ordinary Differential Equations I, II.4 and II.10). Then (q1, p1) is projected onto
//! `H = H(q0, p0) - Σ Δw_j` along ∇H of the last stage, scaled by the tolerances (E. Hairer, C.
//! Lubich, G. Wanner, Geometric Numerical Integration, IV.4). The projection is of the size of the
//! error of the step. K is exact; w is the quadrature, unchanged.
//!
//! A sample between steps is a step of its own from the beginning of the current step, with K
//! exact. Steps are limited to a half disc |hλ| ≤ r, Re λ ≤ 0 of the stability region by a bound of
//! |λ|, which is renewed from time to time. Steps do not allocate, except where K differs only by
//! rounding, near rest.

mod doubt;
mod estimate;
mod methods;
mod passage;

pub(crate) use methods::adaptive_explicit;

use crate::adaptive::{
    Budget, End, KINK_ORDER, Kinks, REFUSED_ERROR, ROUNDING_SUSPECTED_BELOW, Rates, Sizes,
    SlopeRoundings, is_noise, size_of_first_or_nan,
};
use crate::runge_kutta::{Embedded, P, Q, Stages, W};
use afterbay_core::{
    Attempt, Curvature, Effort, Scalar, State, StepFailure, System, Tolerance, Vector,
};

/// The rounding error of a slope, in roundings of ∂H/∂q, with that of the point of its stage.
/// A choice: the estimate then does not reject steps whose error is rounding.
const STAGES_ROUNDINGS: f64 = 8.0;
/// A step is near the limit of stability if a step longer by this factor would reach it. A choice.
const NEAR_LIMIT: f64 = 1.25;
/// A bound of |λ| is steady if it differs from the one before by at most this share. A choice.
const STEADY_CHANGE: f64 = 0.01;
/// The largest number of steps with one bound of |λ| near the limit while it is steady. A choice.
const MOST_STEPS_NEAR_LIMIT: u32 = 8;
/// The largest number of steps with one bound of |λ| far from the limit. A choice.
const MOST_STEPS_ELSEWHERE: u32 = 32;

/// The memory of a step.
#[derive(Clone, Debug)]
pub struct Workspace<V: Vector> {
    stages: Stages<V>,
    /// Whether the first stage belongs to the current state, and whether `energy` does.
    begun: bool,
    measured: bool,
    energy: V::Scalar,
    end: End<V>,
    /// Whether K is exact at the end, and H there is known.
    ended: bool,
    /// Whether the step passes no kink, and whether it passes one or begins shortly after one.
    smooth: bool,
    near_kink: bool,
    kinks: Kinks,
    /// The number of degrees of freedom without motors.
    free: usize,
    /// Memory for a point between the start and the end.
    between: [V; 2],
    /// The length of the step.
    length: f64,
    /// The error of K at the end of a longer step from this state, near an equilibrium.
    last_defect: f64,
    /// An upper bound of |λ| ([`Rates::bounds`]); 0 if none is known.
    fastest: f64,
    /// The steps since it was computed, and the number of them after which it is computed anew near
    /// the limit of stability.
    since: u32,
    until: u32,
    rates: Rates<V>,
    budget: Budget,
    roundings: SlopeRoundings,
    /// The largest factor by which the next step may be longer, where an estimate is rounding.
    growth: f64,
    /// Whether the step is the beginning of one that was accepted.
    inside: bool,
}

impl<V: Vector> Workspace<V> {
    pub(crate) fn new<B, S>(system: &S, tolerance: &Tolerance, span: f64) -> Self
    where
        B: Embedded,
        S: System<V::Scalar> + ?Sized,
    {
        let (n, zero) = (system.dof(), V::Scalar::zero());
        let zeros = || V::zeros(n);
        Self {
            stages: Stages::new(system, B::ROWS.len()),
            begun: false,
            measured: false,
            energy: zero,
            end: End::new(n),
            ended: false,
            smooth: true,
            near_kink: false,
            kinks: Kinks::default(),
            free: n - system.motors(),
            between: [zeros(), zeros()],
            length: 0.0,
            last_defect: f64::INFINITY,
            fastest: 0.0,
            since: 0,
            until: 1,
            rates: Rates::new(n),
            budget: Budget::new(tolerance, span, n - system.motors()),
            roundings: SlopeRoundings::default(),
            growth: f64::INFINITY,
            inside: false,
        }
    }

    /// Computes the quantities that do not depend on h. Returns the number of evaluations.
    #[inline]
    fn begin<S: System<V::Scalar> + ?Sized>(&mut self, system: &S, state: &State<V>) -> u64 {
        if !self.measured {
            self.energy = state.energy(system);
            self.measured = true;
        }
        if self.begun {
            return 0;
        }
        self.stages.begin(system, state);
        self.begun = true;
        1
    }

    /// Computes the end of the step h from the stages.
    #[inline]
    fn finish<B: Embedded>(&mut self, h: V::Scalar, state: &State<V>) {
        let Self { stages, end: End { q, p, gain, .. }, .. } = self;
        stages.add::<Q>(B::WEIGHTS, h, &state.q, q);
        stages.add::<P>(B::WEIGHTS, h, &state.p, p);
        if stages.is_dissipative() {
            stages.sum::<W>(B::WEIGHTS, h, gain);
        }
    }

    /// Projects the end onto K. If the change exceeds the allowed one, returns the ratio of the two
    /// as the error.
    #[inline(always)]
    fn project<B, S>(&mut self, system: &S, errors_allowed: [f64; 3]) -> Result<(), f64>
    where
        B: Embedded,
        S: System<V::Scalar> + ?Sized,
    {
        let Self { stages, end, energy, .. } = self;
        end.measure(system);
        let slope = [&stages.hq, stages.velocity(B::ROWS.len() - 1)];
        end.project(system, slope, *energy, errors_allowed, 1.0).map(|_moved| ())
    }

    /// Ends a step with this error, within the tolerance, whose end no allowed change of (q, p)
    /// brings onto K. `ratio` is that change over the allowed one. If the error of K is rounding,
    /// it stays. If it is within the allowed error of energies, the account of a drive takes it.
    /// Otherwise the step is rejected. Returns the error of the step.
    #[cold]
    #[inline(never)]
    fn without_projection<S>(
        &mut self,
        system: &S,
        state: &State<V>,
        error: f64,
        energy_allowed: f64,
        ratio: f64,
    ) -> Result<f64, StepFailure>
    where
        S: Curvature<V::Scalar> + ?Sized,
    {
        let Self { end, energy, last_defect, ended, .. } = self;
        end.measure(system);
        let energies = [*energy, end.energy, end.target(*energy)];
        let missing = (energies[2] - energies[1]).abs().to_f64();
        if error <= ROUNDING_SUSPECTED_BELOW
            && is_noise(system, [&end.q, &end.p], energies, &state.w, last_defect)?
        {
            *ended = true;
            return Ok(error);
        }
        *ended = end.balance(system, *energy);
        let is_small = *ended && missing <= energy_allowed;
        Ok(if is_small { error } else { ratio.max(REFUSED_ERROR) })
    }

    /// The largest factor by which the step may be lengthened while staying stable.
    #[inline]
    fn stable_growth<B: Embedded>(&self, length: f64) -> f64 {
        B::STABLE_RADIUS / (length * self.fastest)
    }

    /// Computes the bound of |λ|.
    #[cold]
    fn see_fastest<S: Curvature<V::Scalar> + ?Sized>(&mut self, system: &S, state: &State<V>) {
        let fastest = self.rates.bounds(system, &state.q, &state.p).eigenvalue;
        let steady = (fastest - self.fastest).abs() <= STEADY_CHANGE * self.fastest;
        self.until = if steady { MOST_STEPS_NEAR_LIMIT.min(2 * self.until) } else { 1 };
        self.since = 0;
        // A bound that is not finite is discarded.
        self.fastest = if fastest.is_finite() { fastest } else { 0.0 };
    }

    /// Takes the step h from the state of `begin`, and returns its error relative to the allowed
    /// one.
    #[inline]
    fn step<B, S>(&mut self, system: &S, h: V::Scalar, state: &State<V>) -> Result<f64, StepFailure>
    where
        B: Embedded,
        S: Curvature<V::Scalar> + ?Sized,
    {
        (self.length, self.ended, self.growth) = (h.to_f64().abs(), false, f64::INFINITY);
        let errors_allowed = self.errors_allowed::<B>(state);
        self.stages.advance::<B, S>(system, h, state);
        self.finish::<B>(h, state);
        let passage = self.passage::<B, S>(system, h, state);
        if self.smooth && !self.roundings.is_active() {
            let error = self.relative_error(self.estimates::<B>(), errors_allowed);
            if error <= 1.0 && (self.inside || !self.roundings.suspects(self.length, error)) {
                return self.end_step::<B, S>(system, h, state, error, errors_allowed);
            }
        }
        self.end_in_doubt::<B, S>(system, h, state, passage)
    }

    /// The errors of q, p and energies allowed for the step.
    #[inline(always)]
    fn errors_allowed<B: Embedded>(&self, state: &State<V>) -> [f64; 3] {
        let sizes = Sizes::of(state, self.energy, self.free);
        let [q, p, w] = self.budget.allowed_of_equal_steps::<V::Scalar>(sizes, self.length);
        // If forces cancel, as in a long chain, roundings of q change the slopes of p by much more
        // than the roundings of these slopes.
        let force = self.rates.force([sizes.q, sizes.p]);
        let start = size_of_first_or_nan(&self.stages.start, self.free);
        let slope = V::Scalar::EPSILON * force.max(start);
        let rounding = STAGES_ROUNDINGS * B::ESTIMATE_ROUNDINGS * slope * self.length;
        [q, p.max(rounding), w]
    }

    /// Ends a step with this error relative to the allowed ones: with K exact, or rejected. Returns
    /// the error.
    #[inline(always)]
    fn end_step<B, S>(
        &mut self,
        system: &S,
        h: V::Scalar,
        state: &State<V>,
        error: f64,
        errors_allowed: [f64; 3],
    ) -> Result<f64, StepFailure>
    where
        B: Embedded,
        S: Curvature<V::Scalar> + ?Sized,
    {
        if error > 1.0 {
            self.ended = self.end.balance(system, self.energy);
            return Ok(error);
        }
        if let Err(ratio) = self.project::<B, S>(system, errors_allowed) {
            self.finish::<B>(h, state);
            return self.without_projection(system, state, error, errors_allowed[2], ratio);
        }
        self.ended = true;
        Ok(error)
    }

    /// Computes the step h from `state`, and estimates its error.
    #[inline]
    pub(crate) fn attempt<B, S>(
        &mut self,
        system: &S,
        h: V::Scalar,
        state: &State<V>,
    ) -> Result<Attempt, StepFailure>
    where
        B: Embedded,
        S: Curvature<V::Scalar> + ?Sized,
    {
        let first = self.begin(system, state);
        let (length, order) = (h.to_f64().abs(), B::ERROR_ORDER);
        if self.fastest == 0.0 {
            self.see_fastest(system, state);
            let growth = self.stable_growth::<B>(length);
            if growth < 1.0 {
                let effort = Effort { evaluations: 1, iterations: 0 };
                return Ok(Attempt { error: f64::INFINITY, order, largest_growth: growth, effort });
            }
        }
        let error = self.step::<B, S>(system, h, state)?;
        self.since += 1;
        let near = self.since >= self.until && self.stable_growth::<B>(length) < NEAR_LIMIT;
        let due = near || self.since >= MOST_STEPS_ELSEWHERE;
        if error > 1.0 || due {
            self.see_fastest(system, state);
        }
        let order = if self.near_kink { KINK_ORDER } else { order };
        let evaluations = B::ROWS.len() as u64 - 1 + first;
        let effort = Effort { evaluations, iterations: 0 };
        let largest_growth = self.stable_growth::<B>(length).min(self.growth);
        Ok(Attempt { error, order, largest_growth, effort })
    }

    /// The coordinates at the end of the step.
    pub(crate) fn end(&self) -> &[V::Scalar] {
        self.end.q.as_slice()
    }

    /// Moves `state` to the end of the step attempted last.
    #[inline]
    pub(crate) fn accept(&mut self, state: &mut State<V>) {
        self.end.write(state);
        self.budget.spend(self.length);
        self.energy = self.end.energy;
        self.last_defect = f64::INFINITY;
        if self.roundings.is_active() {
            self.roundings.moved();
        }
        // A step across a break is taken whatever its error is. H is then evaluated anew.
        (self.begun, self.measured) = (false, self.ended);
    }

    /// Computes the state at the time h after `before`, which begins a step longer than h.
    pub(crate) fn between<B, S>(
        &mut self,
        system: &S,
        h: V::Scalar,
        before: &State<V>,
        to: &mut State<V>,
    ) -> Result<Effort, StepFailure>
    where
        B: Embedded,
        S: Curvature<V::Scalar> + ?Sized,
    {
        (self.begun, self.measured) = (false, false);
        self.begin(system, before);
        // There is no longer step to compare with.
        (self.last_defect, self.inside) = (0.0, true);
        let error = self.step::<B, S>(system, h, before);
        (self.begun, self.measured, self.last_defect) = (false, false, f64::INFINITY);
        self.inside = false;
        if error? > 1.0 {
            self.end.measure(system);
            let excess = (self.end.energy - self.end.target(self.energy)).to_f64();
            return Err(StepFailure::ProjectionFailed { excess });
        }
        to.w.as_mut_slice().copy_from_slice(before.w.as_slice());
        self.end.write(to);
        Ok(Effort { evaluations: B::ROWS.len() as u64, iterations: 0 })
    }
}
