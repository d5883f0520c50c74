//! DOP853 with step size control, and K exact after every step.
//!
//! ```text
//! z = (q, p)        f = (∂H/∂p, -∂H/∂q - D)        v = ∂H/∂p        Z_i = z0 + h Σ_j a_ij f(Z_j)
//! z1 = z0 + h Σ_i b_i f(Z_i)        w1_j = w0_j + h Σ_i b_i D_j(Z_i) v_j(Z_i)
//! ```
//!
//! The twelve stages of order 8, with error estimates from embedded weights of order 5 and 3: E.
//! Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, II.5 and II.10.
//! Then (q1, p1) is projected onto `H = H(q0, p0) - Σ Δw_j` along ∇H, scaled by the tolerances. The
//! projection is of the size of the error of the step. K is exact; w is the quadrature, unchanged.
//! (Projection: E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration, IV.4.)
//!
//! Order 8 in q, p and w, also between steps: a sample is a step of its own from the beginning of
//! the current step, with K exact. Two weights are negative, so the method is not passive. The
//! stability region contains the half disc |hλ| < 5.96, Re λ ≤ 0; steps stay within it. For stiff
//! systems use [`crate::AdaptiveCollocation`]. Steps do not allocate.
//!
//! A run **fails** with the last accepted state, and reports the [`StepFailure`] of the shortest
//! step tried, or `Vanishes`.

use crate::adaptive::{Budget, Projection, Rates, largest};
use crate::bend::bend;
use crate::grain::grain_at;
use crate::registry::binding::{AdaptiveBinding, Bound, Target};
use crate::runge_kutta::{Dop853, Embedded, P, Q, Stages, Tableau, W};
use afterbay_core::{
    Adaptive, Attempt, Curvature, Effort, InputError, Quantity, Scalar, State, StepFailure, System,
    Tolerance, Vector,
};

/// DOP853 for [`afterbay_core::integrate_within`] and [`afterbay_core::sample_within`], projected
/// onto the initial value of K.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AdaptiveDop853;

/// The stage at the end of the step: ∇H there approximates ∇H at z1.
const LAST: usize = 11;
/// The weight of the squared ratio of the two error estimates in their combination (Hairer,
/// Norsett, Wanner, II.10).
const SHARE: f64 = 0.01;
/// The smallest error assigned to a step whose projection fails.
const REFUSED: f64 = 2.0;
/// A failed projection is attributed to rounding if the error is below this share of the allowed
/// error,
const DOUBT: f64 = 0.01;
/// K is off by no more than this number of roundings of H, and a shorter step leaves as much.
const NOISE_ROUNDINGS: f64 = 64.0;
/// The bound imposed on h |λ|, since |R(hλ)| ≤ 1 for |hλ| < 5.96, Re λ ≤ 0. |λ| is evaluated anew
/// if the bound is less than the factor `RENEWAL_FACTOR` away.
const STABLE: f64 = 5.8;
const RENEWAL_FACTOR: f64 = 1.25;

/// The memory of a step.
#[derive(Clone, Debug)]
pub struct Workspace<V: Vector> {
    stages: Stages<V>,
    /// Whether the first stage and H belong to the current state.
    begun: bool,
    energy: V::Scalar,
    /// The end of the step.
    q: V,
    p: V,
    gain: V,
    /// The difference of two solutions.
    miss: V,
    /// The error of K at the end of a longer step from this state, near an equilibrium.
    off: f64,
    /// An upper bound of |λ| ([`Rates::see`]); 0 if none is known.
    fastest: f64,
    rates: Rates<V>,
    budget: Budget,
}

impl<V: Vector> Workspace<V> {
    /// Computes the quantities that do not depend on h.
    #[inline]
    fn begin<S: System<V::Scalar> + ?Sized>(&mut self, system: &S, state: &State<V>) {
        self.stages.begin(system, state);
        self.energy = state.energy(system);
        self.off = f64::INFINITY;
        self.begun = true;
    }

    /// Computes the end of the step h from the stages.
    #[inline]
    fn finish(&mut self, h: V::Scalar, state: &State<V>) {
        let Self { stages, q, p, gain, .. } = self;
        stages.add::<Q>(Dop853::WEIGHTS, h, &state.q, q);
        stages.add::<P>(Dop853::WEIGHTS, h, &state.p, p);
        stages.sum::<W>(Dop853::WEIGHTS, h, gain);
    }

    /// The error estimate of the step relative to the error allowed of the whole run.
    #[inline]
    fn error(&mut self, h: V::Scalar, scales: [f64; 3]) -> f64 {
        let Self { stages, miss, .. } = self;
        let shares = scales.map(f64::recip);
        let [fine, coarse] = Dop853::DIFFERENCES.map(|terms| {
            stages.sum::<Q>(terms, h, miss);
            let q = largest(miss) * shares[0];
            stages.sum::<P>(terms, h, miss);
            let p = largest(miss) * shares[1];
            stages.sum::<W>(terms, h, miss);
            let w = largest(miss) * shares[2];
            let larger = |a: f64, b: f64| if a > b { a } else { b };
            larger(larger(q, p), w) + 0.0 * (q + p + w)
        });
        let ratio = coarse / fine;
        if fine == 0.0 { 0.0 } else { fine / (1.0 + SHARE * ratio * ratio).sqrt() }
    }

    /// The target value of H at the end.
    #[inline]
    fn target(&self) -> V::Scalar {
        self.gain.as_slice().iter().fold(self.energy, |energy, &gain| energy - gain)
    }

    /// Projects the new state onto K. If the change exceeds the allowed one, returns the ratio of
    /// the two as the error.
    #[inline]
    fn project<S: System<V::Scalar> + ?Sized>(
        &mut self,
        system: &S,
        scales: [f64; 3],
        allowed: f64,
    ) -> Result<(), f64> {
        let target = self.target();
        let Self { stages, energy, q, p, .. } = self;
        let (q, p) = (q.as_mut_slice(), p.as_mut_slice());
        let mut found = system.energy(q, p);
        let projection = Projection {
            slope: [stages.hq.as_slice(), stages.velocity(LAST).as_slice()],
            target,
            size: (energy.abs() + target.abs()).to_f64(),
            scales: [scales[0], scales[1]],
            allowed,
        };
        projection.apply(system, [q, p], &mut found).map(|_| ())
    }

    /// Whether the error of K is within the rounding of z in H, and not reduced by a shorter step.
    /// Near an equilibrium away from the origin no small change of z can correct it.
    #[cold]
    fn is_noise<S: Curvature<V::Scalar> + ?Sized>(&mut self, system: &S) -> bool {
        let (q, p) = (self.q.as_slice(), self.p.as_slice());
        let (found, target) = (system.energy(q, p), self.target());
        let z = largest(&self.q).max(largest(&self.p));
        let terms = self.energy.abs().to_f64() + found.abs().to_f64() + bend(system, q, p) * z * z;
        let off = (found - target).abs().to_f64();
        let before = std::mem::replace(&mut self.off, off);
        let within = |terms: f64| off <= NOISE_ROUNDINGS * V::Scalar::EPSILON * terms;
        (off > 0.5 * before && within(terms)) || within(grain_at(system, q, p))
    }

    /// The largest factor by which the step may be lengthened while staying stable.
    #[inline]
    fn reach(&self, length: f64) -> f64 {
        STABLE / (length * self.fastest)
    }

    /// Computes the bound of |λ|.
    #[cold]
    fn see_fastest<S: Curvature<V::Scalar> + ?Sized>(&mut self, system: &S, state: &State<V>) {
        let [_, fastest] = self.rates.see(system, &state.q, &state.p);
        // A bound that is not finite is discarded.
        self.fastest = if fastest.is_finite() { fastest } else { 0.0 };
    }

    /// Takes the step h from the state of `begin`, and returns its error relative to the allowed
    /// one.
    #[inline]
    fn step<S: Curvature<V::Scalar> + ?Sized>(
        &mut self,
        system: &S,
        h: V::Scalar,
        state: &State<V>,
    ) -> Result<f64, StepFailure> {
        let allowed = self.budget.allowed(h.to_f64().abs());
        let scales = self.budget.scales(state, allowed);
        self.stages.advance::<Dop853, S>(system, h, state);
        self.finish(h, state);
        let error = self.error(h, scales) / allowed;
        if !error.is_finite() {
            let parts = [
                (Quantity::Coordinate, self.q.as_slice()),
                (Quantity::Momentum, self.p.as_slice()),
                (Quantity::Reservoir, self.gain.as_slice()),
            ];
            return Err(StepFailure::non_finite(&parts));
        }
        if error <= 1.0
            && let Err(way) = self.project(system, scales, allowed)
        {
            self.finish(h, state);
            if error > DOUBT || !self.is_noise(system) {
                return Ok(way.max(REFUSED));
            }
        }
        Ok(error)
    }

    /// Writes the end of the step; the gains of the reservoirs are added to the w of `to`.
    #[inline]
    fn write(&self, to: &mut State<V>) {
        to.q.as_mut_slice().copy_from_slice(self.q.as_slice());
        to.p.as_mut_slice().copy_from_slice(self.p.as_slice());
        for (w, &gain) in to.w.as_mut_slice().iter_mut().zip(self.gain.as_slice()) {
            *w += gain;
        }
    }
}

impl AdaptiveBinding for AdaptiveDop853 {
    fn bind(&self, target: &Target<'_, f64>) -> Bound<f64> {
        let system = target.curvature()?;
        match target.system.dof() {
            1 => target.chosen::<[f64; 1], _, _>(*self, system),
            2 => target.chosen::<[f64; 2], _, _>(*self, system),
            _ => target.chosen::<Vec<f64>, _, _>(*self, system),
        }
    }
}

impl<V, S> Adaptive<V, S> for AdaptiveDop853
where
    V: Vector,
    S: Curvature<V::Scalar> + ?Sized,
{
    type Workspace = Workspace<V>;

    fn workspace(
        &self,
        system: &S,
        tolerance: &Tolerance,
        span: f64,
    ) -> Result<Workspace<V>, InputError> {
        let zeros = || V::zeros(system.dof());
        Ok(Workspace {
            stages: Stages::new(system),
            begun: false,
            energy: V::Scalar::zero(),
            q: zeros(),
            p: zeros(),
            gain: zeros(),
            miss: zeros(),
            off: f64::INFINITY,
            fastest: 0.0,
            rates: Rates::new(system.dof()),
            budget: Budget::new(tolerance, span),
        })
    }

    #[inline]
    fn attempt(
        &self,
        system: &S,
        h: V::Scalar,
        state: &State<V>,
        workspace: &mut Workspace<V>,
    ) -> Result<Attempt, StepFailure> {
        let mut evaluations = Dop853::ROWS.len() as u64 - 1;
        if !workspace.begun {
            workspace.begin(system, state);
            evaluations += 1;
        }
        let (length, order) = (h.to_f64().abs(), 7);
        if workspace.fastest == 0.0 {
            workspace.see_fastest(system, state);
            let reach = workspace.reach(length);
            if reach < 1.0 {
                let effort = Effort { evaluations: 1, iterations: 0 };
                return Ok(Attempt { error: REFUSED, order, largest_growth: reach, effort });
            }
        }
        let error = workspace.step(system, h, state)?;
        if error > 1.0 || workspace.reach(length) < RENEWAL_FACTOR {
            workspace.see_fastest(system, state);
        }
        let reach = workspace.reach(length);
        Ok(Attempt {
            error,
            order,
            largest_growth: reach,
            effort: Effort { evaluations, iterations: 0 },
        })
    }

    #[inline]
    fn end<'a>(&self, workspace: &'a Workspace<V>) -> &'a [V::Scalar] {
        workspace.q.as_slice()
    }

    #[inline]
    fn accept(&self, state: &mut State<V>, workspace: &mut Workspace<V>) {
        workspace.write(state);
        workspace.begun = false;
    }

    fn between(
        &self,
        system: &S,
        h: V::Scalar,
        before: &State<V>,
        workspace: &mut Workspace<V>,
        to: &mut State<V>,
    ) -> Result<Effort, StepFailure> {
        workspace.begin(system, before);
        workspace.begun = false;
        // There is no longer step to compare with.
        workspace.off = 0.0;
        if workspace.step(system, h, before)? > 1.0 {
            let found = system.energy(workspace.q.as_slice(), workspace.p.as_slice());
            let excess = (found - workspace.target()).to_f64();
            return Err(StepFailure::ProjectionFailed { excess });
        }
        to.w.as_mut_slice().copy_from_slice(before.w.as_slice());
        workspace.write(to);
        Ok(Effort { evaluations: Dop853::ROWS.len() as u64, iterations: 0 })
    }
}
