//! One step of a Radau IIA method, solved to the accuracy the tolerance requires, with K exact.

use super::equations::Equations;
use super::share::{Allowed, Share, power};
use super::stages::{Columns, Point, Stages};
use super::tables::Tables;
use afterbay_core::{
    Attempt, Curvature, Effort, InputError, Quad, Scalar, State, StepFailure, Tolerance, Vector,
};

/// The largest number of corrections of a step.
const CORRECTIONS: u32 = 10;
/// The error of Newton's method relative to the error allowed of the step.
const SOLVED: f64 = 0.1;
/// Corrections below this number of roundings of z end the iteration, and below the second one if
/// they no longer shrink.
const ROUNDINGS: [f64; 2] = [2.0, 64.0];
/// A ratio of successive corrections above which the iteration is given up.
const DIVERGING: f64 = 0.9;
/// A ratio of successive corrections below which the Jacobian is kept for the next step.
const CONTRACTING: f64 = 0.02;
/// The factor by which the estimate of lower order is multiplied before it is raised to the order of
/// the method (Hairer and Wanner's RADAU: 0.1 times the tolerance to the power (s+1)/(2s)).
const CAUTION: f64 = 10.0;
/// The smallest error assigned to a step that is rejected because of K.
const REFUSED: f64 = 2.0;

/// The memory of a step with S stages.
#[derive(Clone, Debug)]
pub(crate) struct Engine<V: Vector, const S: usize> {
    pub(super) tables: Tables<V::Scalar, S>,
    dissipative: bool,
    /// The stages of the current trial step, and of the last accepted one.
    pub(super) trial: Stages<V, S>,
    kept: Stages<V, S>,
    /// The lengths of the trial step and of the last accepted one, if any.
    pub(super) h: V::Scalar,
    kept_h: Option<V::Scalar>,
    /// The matrix that continues the accepted step, and the offset and the ratio it belongs to.
    ahead: Columns<V::Scalar, S>,
    ahead_for: Option<[V::Scalar; 2]>,
    /// The slopes and H at the start of the step, if they are known.
    pub(super) start: Point<V>,
    pub(super) energy: V::Scalar,
    begun: bool,
    /// The end of the step, with H there and the increments of the reservoirs.
    pub(crate) q: V,
    pub(super) p: V,
    pub(super) gain: V,
    pub(super) end: Point<V>,
    pub(super) end_energy: V::Scalar,
    /// Whether the slopes at the end are those of the last stage.
    pub(super) unmoved: bool,
    /// The error estimates of q, p and w, that of w before it is filtered, and a point.
    pub(super) errors: [V; 4],
    scratch: [V; 2],
    equations: Equations<S>,
    /// The step the matrices belong to; 0 if there is none.
    factorised: f64,
    /// Whether the Jacobian is that at the start of the step, and whether to renew it.
    fresh: bool,
    renew: bool,
    /// θ/(1-θ) of the last step, with θ the ratio of successive corrections.
    eta: f64,
    rejected: bool,
    share: Share,
    /// The defect of K at the end of a longer step from this state.
    pub(super) off: f64,
}

impl<V: Vector, const S: usize> Engine<V, S> {
    pub(crate) fn new<F: Curvature<V::Scalar> + ?Sized>(
        system: &F,
        tables: &Tables<Quad, S>,
        tolerance: &Tolerance,
        span: f64,
    ) -> Result<Self, InputError> {
        let n = system.dof();
        let zeros = || V::zeros(n);
        let zero = V::Scalar::zero();
        Ok(Self {
            tables: tables.narrow(),
            dissipative: !system.dissipation_form().zero,
            trial: Stages::new(n),
            kept: Stages::new(n),
            h: zero,
            kept_h: None,
            ahead: [[zero; S]; S],
            ahead_for: None,
            start: Point::new(n),
            energy: zero,
            begun: false,
            q: zeros(),
            p: zeros(),
            gain: zeros(),
            end: Point::new(n),
            end_energy: zero,
            unmoved: false,
            errors: [(); 4].map(|()| zeros()),
            scratch: [zeros(), zeros()],
            equations: Equations::new::<V, F>(system)?,
            factorised: 0.0,
            fresh: false,
            renew: true,
            eta: 1.0,
            rejected: true,
            share: Share::new(tolerance, span),
            off: f64::INFINITY,
        })
    }

    /// Tries the step h from `state`.
    #[inline]
    pub(crate) fn attempt<F: Curvature<V::Scalar> + ?Sized>(
        &mut self,
        system: &F,
        h: V::Scalar,
        state: &State<V>,
    ) -> Result<Attempt, StepFailure> {
        let mut effort = self.begin(system, state);
        let allowed = self.share.allowed(state);
        let outcome = self.advance(system, h, state, allowed, [V::Scalar::one(); 2], &mut effort);
        let rejected = std::mem::replace(&mut self.rejected, true);
        outcome?;
        let mut error = self.estimate(h, allowed);
        if error > 1.0 && rejected && error.is_finite() {
            error = self.estimate_again(system, h, state, allowed);
            effort.evaluations += 1;
        }
        if !error.is_finite() {
            return Err(self.trial.not_finite());
        }
        if error <= 1.0 {
            match self.balance(system, state, allowed, error) {
                Ok(()) => self.rejected = false,
                Err(excess) => error = excess.max(REFUSED),
            }
        }
        let order = 2 * S as u32;
        Ok(Attempt { error, order, largest_growth: f64::INFINITY, effort })
    }

    /// Computes the state the time h after `before`, with which the accepted step began.
    pub(crate) fn between<F: Curvature<V::Scalar> + ?Sized>(
        &mut self,
        system: &F,
        h: V::Scalar,
        before: &State<V>,
        to: &mut State<V>,
    ) -> Result<Effort, StepFailure> {
        let mut effort = Effort::default();
        self.begun = false;
        effort += self.begin(system, before);
        (self.begun, self.renew) = (false, true);
        let allowed = self.share.allowed(before);
        let outcome = match self.kept_h {
            Some(kept) => {
                let way = [V::Scalar::zero(), h / kept];
                self.advance(system, h, before, allowed, way, &mut effort)
            }
            None => self.advance(system, h, before, allowed, [V::Scalar::one(); 2], &mut effort),
        };
        self.renew = true;
        outcome?;
        self.estimate(h, allowed);
        // There is no longer step to compare with.
        self.off = 0.0;
        if self.balance(system, before, allowed, 0.0).is_err() {
            let excess = (self.end_energy - self.target()).to_f64();
            return Err(StepFailure::ProjectionFailed { excess });
        }
        to.w.as_mut_slice().copy_from_slice(before.w.as_slice());
        self.write(to);
        Ok(effort)
    }

    /// Computes the quantities that do not depend on h.
    #[inline(always)]
    fn begin<F: Curvature<V::Scalar> + ?Sized>(&mut self, system: &F, state: &State<V>) -> Effort {
        let mut effort = Effort::default();
        if !self.begun {
            self.start.look(system, self.dissipative, &state.q, &state.p);
            self.energy = state.energy(system);
            (self.begun, self.fresh) = (true, false);
            self.off = f64::INFINITY;
            effort.evaluations = 1;
        }
        if V::LEN == Some(1) {
            self.renew |= !self.fresh;
        }
        effort
    }

    /// Solves the equations of the step h from `state`. The stages start from the polynomial of the
    /// accepted step, if there is one.
    #[inline(always)]
    fn advance<F: Curvature<V::Scalar> + ?Sized>(
        &mut self,
        system: &F,
        h: V::Scalar,
        state: &State<V>,
        allowed: Allowed,
        [offset, ratio]: [V::Scalar; 2],
        effort: &mut Effort,
    ) -> Result<(), StepFailure> {
        self.h = h;
        loop {
            if self.renew {
                self.equations.evaluate(system, &state.q, &state.p);
                (self.fresh, self.renew, self.factorised) = (true, false, 0.0);
            }
            let length = h.to_f64();
            if self.factorised != length {
                self.factorised = 0.0;
                self.equations.factorise(&self.tables, length)?;
                self.factorised = length;
            }
            let from_its_end = offset == V::Scalar::one();
            self.initial_guess(h, [offset, ratio], from_its_end);
            match self.iterate(system, h, state, allowed, effort) {
                Ok(()) => return Ok(()),
                Err(failure) if self.fresh => return Err(failure),
                Err(_) => self.renew = true,
            }
        }
    }

    #[inline(always)]
    fn initial_guess(&mut self, h: V::Scalar, [offset, ratio]: [V::Scalar; 2], ends: bool) {
        let Some(kept) = self.kept_h else { return self.trial.rest() };
        let ratio = if ends { h / kept } else { ratio };
        if self.ahead_for != Some([offset, ratio]) {
            self.ahead = self.tables.continuation(offset, ratio);
            self.ahead_for = Some([offset, ratio]);
        }
        self.trial.follow(&self.ahead, &self.kept, ends);
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
        let n = V::LEN.unwrap_or(state.dof());
        let shares = [allowed.scales[0].recip(), allowed.scales[1].recip()];
        // In units of the scales, which are at least some roundings divided by the share.
        let rounding = V::Scalar::EPSILON / allowed.relative[0].max(V::Scalar::EPSILON);
        let solved = (SOLVED * allowed.share).max(ROUNDINGS[0] * rounding);
        let mut eta = power(self.eta.max(1e-16), 0.8);
        let mut before = f64::NAN;
        let mut theta = 0.0;
        for count in 1..=CORRECTIONS {
            self.look(system, state);
            effort.evaluations += S as u64;
            effort.iterations += 1;
            let change = self.correct(h, n, shares);
            if !change.is_finite() {
                self.eta = 1.0;
                return Err(self.trial.not_finite());
            }
            if count > 1 {
                theta = change / before;
                eta = if theta < 1.0 { theta / (1.0 - theta) } else { f64::INFINITY };
            }
            let resolved = change <= ROUNDINGS[0] * rounding
                || (theta > 0.3 && change <= ROUNDINGS[1] * rounding);
            if resolved || eta * change <= solved {
                self.eta = eta.min(1.0);
                self.renew = theta > CONTRACTING || V::LEN == Some(1);
                self.look(system, state);
                effort.evaluations += S as u64;
                return Ok(());
            }
            // The remaining corrections are too few.
            let left = (CORRECTIONS - count) as i32;
            if count > 1 && (theta > DIVERGING || theta.powi(left) * eta * change > solved) {
                break;
            }
            before = change;
        }
        self.eta = 1.0;
        let dof = 0;
        Err(StepFailure::NewtonStalled { dof, iterations: effort.iterations as u32, update: before })
    }

    /// Computes the slopes at the stages.
    #[inline(always)]
    fn look<F: Curvature<V::Scalar> + ?Sized>(&mut self, system: &F, state: &State<V>) {
        let Self { trial, scratch: [q, p], end, dissipative, .. } = self;
        trial.look(system, *dissipative, state, [q, p], end);
    }

    /// Corrects the stages once, and returns the size of the correction.
    #[inline(always)]
    fn correct(&mut self, h: V::Scalar, n: usize, shares: [f64; 2]) -> f64 {
        let Self { tables, trial, equations, .. } = self;
        let Stages { q, p, v, f, .. } = trial;
        let (mut most, mut poison) = (0.0_f64, 0.0);
        let residual = |q: &[V; S], p: &[V; S], d: usize| {
            [
                Stages::<V, S>::residual(tables, h, q, v, d),
                Stages::<V, S>::residual(tables, h, p, f, d),
            ]
        };
        let mut see = |to: &mut [V; S], by: [f64; S], share: f64, d: usize| {
            for (to, by) in to.iter_mut().zip(by) {
                to.as_mut_slice()[d] += V::Scalar::from_f64(by);
                let size = by.abs() * share;
                most = if size > most { size } else { most };
                poison += 0.0 * size;
            }
        };
        equations.solve(tables, n, |d| residual(q, p, d));
        for d in 0..n {
            let [by_q, by_p] = equations.solution(d);
            see(q, by_q, shares[0], d);
            see(p, by_p, shares[1], d);
        }
        most + poison
    }

    /// Estimates the errors of q, p and w by the embedded method of order S, filtered by the matrix
    /// of the real eigenvalue, and returns the largest relative to the allowed one.
    #[inline(always)]
    fn estimate(&mut self, h: V::Scalar, allowed: Allowed) -> f64 {
        let Self { tables, trial, equations, start, errors, dissipative, .. } = self;
        let [of_q, of_p, of_w, raw_w] = errors;
        let n = V::LEN.unwrap_or(of_q.as_slice().len());
        let value = tables.value;
        let scale = h * V::Scalar::from_f64(value);
        let raw = |at: &V, slopes: &[V; S], d: usize| {
            let sum = tables.start.iter().zip(slopes).fold(at.as_slice()[d], |sum, (&l, slope)| {
                (-l).mul_add(slope.as_slice()[d], sum)
            });
            (scale * sum).to_f64()
        };
        let step = scale.to_f64();
        let sizes = [allowed.scales[0].recip(), allowed.scales[1].recip(), allowed.scales[2].recip()];
        let mut most = [0.0_f64; 3];
        let mut poison = 0.0;
        equations.filter(
            tables,
            n,
            |d| [raw(&start.v, &trial.v, d), raw(&start.f, &trial.f, d)],
            |d, [a, b, friction]| {
                let mut c = 0.0;
                if *dissipative {
                    // The power D v changes with v and with D.
                    let by_v = (a - raw(&start.v, &trial.v, d)) * start.d.as_slice()[d].to_f64();
                    let by_d = step * friction * start.v.as_slice()[d].to_f64();
                    let raw = raw(&start.loss, &trial.loss, d);
                    c = raw + by_v + by_d;
                    raw_w.as_mut_slice()[d] = V::Scalar::from_f64(raw);
                }
                for (most, (x, size)) in most.iter_mut().zip([a, b, c].into_iter().zip(sizes)) {
                    let x = x.abs() * size;
                    *most = if x > *most { x } else { *most };
                    poison += 0.0 * x;
                }
                of_q.as_mut_slice()[d] = V::Scalar::from_f64(a);
                of_p.as_mut_slice()[d] = V::Scalar::from_f64(b);
                of_w.as_mut_slice()[d] = V::Scalar::from_f64(c);
            },
        );
        Self::relative(most, allowed) + poison
    }

    /// The error relative to the allowed one, from estimates of order S in units of the scales.
    #[inline(always)]
    fn relative(estimates: [f64; 3], allowed: Allowed) -> f64 {
        let order = (S + 1) as f64 / (2 * S) as f64;
        let mut most = 0.0_f64;
        for (estimate, relative) in estimates.into_iter().zip(allowed.relative) {
            // The estimate relative to the size, over the power of the tolerance.
            let goal = power(relative * allowed.share, order);
            most = most.max(CAUTION * estimate * relative / goal);
        }
        power(most, order.recip())
    }

    /// Estimates the errors again, with slopes at the start moved by the first estimate: the estimate
    /// then vanishes for fast components that are not resolved and decay (Hairer, Wanner II,
    /// (8.20)).
    #[cold]
    fn estimate_again<F: Curvature<V::Scalar> + ?Sized>(
        &mut self,
        system: &F,
        h: V::Scalar,
        state: &State<V>,
        allowed: Allowed,
    ) -> f64 {
        let Self { scratch, errors, .. } = self;
        for ((to, from), by) in scratch.iter_mut().zip([&state.q, &state.p]).zip(&*errors) {
            for ((to, &from), &by) in
                to.as_mut_slice().iter_mut().zip(from.as_slice()).zip(by.as_slice())
            {
                *to = from + by;
            }
        }
        let kept = self.start.clone();
        self.start.look(system, self.dissipative, &self.scratch[0], &self.scratch[1]);
        let error = self.estimate(h, allowed);
        self.start = kept;
        error
    }

    /// Accepts the trial step.
    #[inline(always)]
    pub(crate) fn accept(&mut self, state: &mut State<V>) {
        self.write(state);
        self.share.see(self.h.to_f64().abs());
        std::mem::swap(&mut self.trial, &mut self.kept);
        self.kept_h = Some(self.h);
        self.energy = self.end_energy;
        self.begun = self.unmoved;
        if self.unmoved {
            std::mem::swap(&mut self.start.hq, &mut self.end.hq);
            std::mem::swap(&mut self.start.d, &mut self.end.d);
            let last = S - 1;
            for (to, from) in [
                (&mut self.start.v, &mut self.kept.v[last]),
                (&mut self.start.f, &mut self.kept.f[last]),
                (&mut self.start.loss, &mut self.kept.loss[last]),
            ] {
                std::mem::swap(to, from);
            }
            self.off = f64::INFINITY;
        }
        self.fresh = false;
    }

    /// Writes the end of the step; the gains of the reservoirs are added to the w of `to`.
    #[inline(always)]
    fn write(&self, to: &mut State<V>) {
        to.q.as_mut_slice().copy_from_slice(self.q.as_slice());
        to.p.as_mut_slice().copy_from_slice(self.p.as_slice());
        if self.dissipative {
            for (w, &gain) in to.w.as_mut_slice().iter_mut().zip(self.gain.as_slice()) {
                *w += gain;
            }
        }
    }

    /// The target value of H at the end.
    pub(crate) fn target(&self) -> V::Scalar {
        self.gain.as_slice().iter().fold(self.energy, |energy, &gain| energy - gain)
    }

    pub(crate) fn is_dissipative(&self) -> bool {
        self.dissipative
    }
}
