//! One step of a Radau IIA method, solved to the accuracy the tolerance requires, with K exact.
//!
//! ```text
//! attempt    solve       the stages by simplified Newton iteration (`solve.rs`, `equations.rs`)
//!            estimate    the error of the step (`estimate.rs`)
//!            balance     w, and the projection onto K (`balance.rs`)
//! accept     write       the new state
//! ```

use super::equations::Equations;
use super::share::Share;
use super::stages::{Columns, Point, Points, Stages};
use super::tables::Tables;
use crate::adaptive::{End, KINK_ORDER, Kinks, Passage, REFUSED_ERROR, roundings_of_time};
use afterbay_core::{
    Attempt, Curvature, Effort, InputError, Quad, Scalar, State, StepFailure, System, Tolerance,
    Vector,
};

/// The memory of a step with S stages.
#[derive(Clone, Debug)]
pub(crate) struct Engine<V: Vector, const S: usize> {
    pub(super) tables: Tables<V::Scalar, S>,
    pub(super) dissipative: bool,
    /// Whether w is dissipation alone. Under a drive its errors are also those of the supply.
    pub(super) undriven: bool,
    /// The stages of the current trial step, and of the last accepted one.
    pub(super) trial: Stages<V, S>,
    pub(super) kept: Stages<V, S>,
    pub(super) points: Points<V, S>,
    /// The lengths of the trial step and of the last accepted one, if any.
    pub(super) h: V::Scalar,
    pub(super) kept_h: Option<V::Scalar>,
    /// The matrix that evaluates the polynomial of the accepted step at `offset + ratio c_i`, and
    /// `[offset, ratio]`.
    pub(super) extrapolation: Columns<V::Scalar, S>,
    pub(super) extrapolation_for: Option<[V::Scalar; 2]>,
    /// Whether the slopes and H at the start belong to the current state.
    begun: bool,
    pub(super) start: Point<V>,
    pub(super) energy: V::Scalar,
    pub(super) end: End<V>,
    /// ∂H/∂q and D at the last stage, and whether it is the end of the step.
    pub(super) last: Point<V>,
    pub(super) unmoved: bool,
    /// The error of fast oscillations in the last estimate, relative to the allowed one.
    pub(super) oscillation: f64,
    /// The estimated errors of q, p and w, that of w before it is filtered.
    pub(super) errors: [V; 3],
    /// Memory for a point and the slopes there.
    pub(super) at: [V; 2],
    pub(super) moved: Point<V>,
    pub(super) equations: Equations<S>,
    /// The step to which the factorised matrices belong; 0 if there are none.
    pub(super) factorised: f64,
    /// Whether the Jacobian is one of the current step, and whether to renew it.
    pub(super) fresh: bool,
    pub(super) renew: bool,
    /// θ/(1-θ) of the last step, with θ the ratio of its last two corrections.
    pub(super) eta: f64,
    /// Whether the last attempt was not accepted, or there was none.
    rejected: bool,
    kinks: Kinks,
    pub(super) share: Share,
    /// The defect of K at the end of a longer step from this state, near an equilibrium.
    pub(super) last_defect: f64,
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
            undriven: !(0..n).any(|motor| system.driven_by(motor).is_some()),
            trial: Stages::new(n),
            kept: Stages::new(n),
            points: Points::new(n),
            h: zero,
            kept_h: None,
            extrapolation: [[zero; S]; S],
            extrapolation_for: None,
            begun: false,
            start: Point::new(n),
            energy: zero,
            end: End::new(n),
            last: Point::new(n),
            unmoved: false,
            oscillation: 0.0,
            errors: [(); 3].map(|()| zeros()),
            at: [zeros(), zeros()],
            moved: Point::new(n),
            equations: Equations::new::<V, F>(system)?,
            factorised: 0.0,
            fresh: false,
            renew: true,
            eta: 1.0,
            rejected: true,
            kinks: Kinks::default(),
            share: Share::new(tolerance, span, n - system.motors()),
            last_defect: f64::INFINITY,
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
        let mut allowed = self.share.allowed(state, self.energy);
        let shift = self.kept_h.map(|kept| [V::Scalar::one(), h / kept]);
        let rejected = std::mem::replace(&mut self.rejected, true);
        self.solve(system, h, state, allowed, shift, &mut effort)?;
        let passage = self.passage(system, h, state);
        let smooth = passage == Passage::Smooth;
        if !smooth {
            let Self { start, trial, .. } = self;
            let ends = [[&start.v, &start.f], [&trial.v[S - 1], &trial.f[S - 1]]];
            allowed.allow_at_least(roundings_of_time(state.t, ends, allowed.free));
        }
        let mut error = self.estimate(h, allowed, smooth);
        if rejected && error > 1.0 && error.is_finite() {
            error = self.estimate_again(system, h, state, allowed, smooth);
            effort.evaluations += 1;
        }
        if !error.is_finite() {
            return Err(self.trial.not_finite());
        }
        if passage == Passage::Returned {
            error = error.max(REFUSED_ERROR);
        }
        if error <= 1.0 {
            match self.balance(system, state, allowed, error)? {
                None => self.rejected = false,
                Some(excess) => error = excess.max(REFUSED_ERROR),
            }
        }
        if error > 1.0 {
            self.end_rejected_step(system, state);
        }
        let order = if smooth { 2 * S as u32 } else { KINK_ORDER };
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
        self.begun = false;
        let mut effort = self.begin(system, before);
        let allowed = self.share.allowed(before, self.energy);
        let shift = self.kept_h.map(|kept| [V::Scalar::zero(), h / kept]);
        // The run goes on as without the sample, with the Jacobian that it has.
        let (eta, renew) = (self.eta, self.renew);
        if V::LEN != Some(1) && self.kept_h.is_some() {
            (self.fresh, self.renew) = (true, false);
        }
        let outcome = self.solve(system, h, before, allowed, shift, &mut effort);
        (self.eta, self.renew) = (eta, renew);
        (self.begun, self.fresh, self.factorised) = (false, false, 0.0);
        outcome?;
        self.estimate(h, allowed, true);
        // No step longer than this one was tried.
        self.last_defect = 0.0;
        if self.balance(system, before, allowed, 0.0)?.is_some() {
            let excess = (self.end.energy - self.end.target(self.energy)).to_f64();
            return Err(StepFailure::ProjectionFailed { excess });
        }
        to.w.as_mut_slice().copy_from_slice(before.w.as_slice());
        self.end.write(to);
        Ok(effort)
    }

    /// Computes the quantities that do not depend on h.
    #[inline(always)]
    pub(super) fn begin<F: Curvature<V::Scalar> + ?Sized>(
        &mut self,
        system: &F,
        state: &State<V>,
    ) -> Effort {
        let mut effort = Effort::default();
        if !self.begun {
            self.start.evaluate_slopes(system, self.dissipative, &state.q, &state.p);
            self.energy = state.energy(system);
            self.last_defect = f64::INFINITY;
            (self.begun, self.fresh) = (true, false);
            effort.evaluations = 1;
        }
        // With one degree of freedom a new Jacobian costs less than a correction.
        self.renew |= V::LEN == Some(1) && !self.fresh;
        effort
    }

    /// Looks for kinks between the start and the stages.
    fn passage<F: System<V::Scalar> + ?Sized>(
        &mut self,
        system: &F,
        h: V::Scalar,
        state: &State<V>,
    ) -> Passage {
        if !self.kinks.begin(system, state.q.as_slice(), state.p.as_slice()) {
            return Passage::Smooth;
        }
        for stage in 0..S {
            self.place(stage, state);
            let Self { kinks, tables, at: [q, p], .. } = self;
            kinks.add(system, tables.nodes[stage], [q.as_slice(), p.as_slice()]);
        }
        self.kinks.passage(h, state.t)
    }

    /// Computes the end of a step with too large an error, with K exact if the system is driven.
    #[cold]
    fn end_rejected_step<F: Curvature<V::Scalar> + ?Sized>(
        &mut self,
        system: &F,
        state: &State<V>,
    ) {
        self.place_end(system, state);
        self.sum_gains();
        self.end.balance(system, self.energy);
    }

    /// Accepts the trial step.
    #[inline(always)]
    pub(crate) fn accept(&mut self, state: &mut State<V>) {
        self.end.write(state);
        self.share.spend(self.h.to_f64().abs());
        std::mem::swap(&mut self.trial, &mut self.kept);
        self.kept_h = Some(self.h);
        self.energy = self.end.energy;
        self.last_defect = f64::INFINITY;
        self.fresh = false;
        // The slopes at the end are known unless the projection moved it.
        self.begun = self.unmoved;
        if self.unmoved {
            let Self { start, last, kept, .. } = self;
            std::mem::swap(&mut start.hq, &mut last.hq);
            std::mem::swap(&mut start.d, &mut last.d);
            let pairs = [
                (&mut start.v, &kept.v[S - 1]),
                (&mut start.f, &kept.f[S - 1]),
                (&mut start.loss, &kept.loss[S - 1]),
            ];
            for (to, from) in pairs {
                to.as_mut_slice().copy_from_slice(from.as_slice());
            }
        }
    }
}
