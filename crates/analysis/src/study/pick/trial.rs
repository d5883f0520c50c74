//! One run, compared with the reference along the way.

use super::Wanted;
use super::dense::Dense;
use super::setting::Choice;
use crate::measured::{Doubt, Measured};
use crate::progress::Progress;
use crate::solution::apart;
use crate::study::Problem;
use crate::study::outcome::Ending;
use crate::study::watch::Watch;
use crate::study::work_precision::{Ended, ended, setting_in_words};
use afterbay_core::{Abilities, IntegrateError, Motors, State, StateRef, larger_or_nan};
use serde::Serialize;
use std::ops::ControlFlow;
use std::sync::Arc;

/// The most states of a run that are compared with the reference. A run with fewer steps is
/// compared after each.
pub const SAMPLES: u64 = 2048;

/// The errors of a run: for (q, p) max(|Δq_j|, |Δp_j|), and for w max |Δw_j|, over the degrees of
/// freedom.
#[derive(Clone, Debug, Serialize)]
pub struct Trial {
    /// Name of the method.
    pub method: &'static str,
    /// The step; the mean one where it follows from a tolerance.
    pub h: f64,
    /// The relative and absolute tolerance of q, p and w, where the steps follow from it.
    pub tolerance: Option<f64>,
    /// The outcome of the run.
    pub outcome: &'static str,
    /// The largest error of (q, p) on the way and at the end; none if the run did not reach it.
    pub error_qp: Option<f64>,
    /// The largest error of w on the way and at the end.
    pub error_w: Option<f64>,
    /// The time of the largest of both errors.
    pub worst_t: f64,
    /// The error of (q, p) at the end.
    pub end_qp: Option<f64>,
    /// The error of w at the end.
    pub end_w: Option<f64>,
    /// The largest doubt of q and p in the reference, over the states compared.
    pub doubt_qp: f64,
    /// The largest doubt of w.
    pub doubt_w: f64,
    /// The doubt of q and p in the reference at the end.
    pub end_doubt_qp: f64,
    /// The doubt of w at the end.
    pub end_doubt_w: f64,
    /// The number of states compared.
    pub samples: u64,
    /// max |K - K0| over all steps done.
    pub k_drift: f64,
    /// Steps that violate passivity; none where the system is not known to be passive.
    pub passivity_violations: Option<u64>,
    /// Wall-clock time of an unobserved run.
    pub seconds: Option<f64>,
    /// Steps done.
    pub steps: u64,
    /// Evaluations of the force.
    pub evaluations: Option<u64>,
    /// Iterations of a nonlinear solver.
    pub iterations: Option<u64>,
    /// The failure in words.
    pub failure: Option<String>,
    /// The error that decides: the larger of both with its doubt, on the way or at the end, and
    /// infinite if the run did not reach its end.
    #[serde(skip)]
    pub decisive: f64,
}

impl Trial {
    /// The largest error of (q, p) on the way, with its doubt.
    pub fn qp(&self) -> Option<Measured> {
        self.error_qp.map(|error| Measured { error, doubt: self.doubt_qp })
    }

    /// The largest error of w on the way, with its doubt.
    pub fn w(&self) -> Option<Measured> {
        self.error_w.map(|error| Measured { error, doubt: self.doubt_w })
    }

    /// The errors of (q, p) and of w at the end, with their doubts.
    pub fn at_end(&self) -> Option<[Measured; 2]> {
        let [qp, w] = [self.end_qp?, self.end_w?];
        Some([
            Measured { error: qp, doubt: self.end_doubt_qp },
            Measured { error: w, doubt: self.end_doubt_w },
        ])
    }

    /// The time of the largest error on the way; none if there is no error.
    pub fn worst(&self) -> Option<f64> {
        let most = larger_or_nan(self.error_qp?, self.error_w?);
        (most != 0.0).then_some(self.worst_t)
    }

    /// The step or the tolerance, in words.
    pub fn setting(&self) -> String {
        setting_in_words(self.h, self.tolerance)
    }
}

/// The reference and the requirements, common to all runs.
pub(super) struct Bench<'a> {
    pub(super) problem: &'a Problem,
    pub(super) wanted: Wanted,
    pub(super) dense: &'a Dense,
    pub(super) progress: &'a dyn Progress,
    system: Arc<dyn Abilities<f64>>,
}

/// Compares a run with the reference.
struct Comparison<'a> {
    bench: &'a Bench<'a>,
    watch: Watch<Arc<dyn Abilities<f64>>>,
    /// The time of the next comparison.
    next: f64,
    samples: u64,
    qp: Measured,
    w: Measured,
    worst: (f64, f64),
    z: Vec<f64>,
}

/// The errors of (q, p) and of w, the energy dissipated.
fn off(found: StateRef<'_, f64>, z: &[f64], motors: &Motors) -> [f64; 2] {
    let (q, rest) = z.split_at(found.q.len());
    let (p, w) = rest.split_at(found.p.len());
    let [q, p, w] = apart(found, StateRef { q, p, w, t: found.t }, motors);
    [larger_or_nan(q, p), w]
}

impl Comparison<'_> {
    fn see(&mut self, step: u64, state: StateRef<'_, f64>) -> ControlFlow<()> {
        let Bench { problem, wanted, dense, progress, .. } = self.bench;
        self.watch.see(step, state);
        if state.t >= self.next && state.t < problem.end {
            self.next = state.t + problem.end / SAMPLES as f64;
            let [known, between] = dense.at(state.t, &mut self.z);
            // Beside a kink the reference is known only at its own times.
            if between.most() <= BETWEEN * wanted.error {
                let errors = off(state, &self.z, &problem.model.motors());
                self.take(state.t, errors, known + between);
            }
        }
        progress.flow()
    }

    fn take(&mut self, t: f64, [qp, w]: [f64; 2], doubt: Doubt) {
        self.samples += 1;
        self.qp = self.qp.larger(Measured { error: qp, doubt: doubt.qp() });
        self.w = self.w.larger(Measured { error: w, doubt: doubt.w });
        let most = larger_or_nan(qp, w);
        if most > self.worst.0 || (most.is_nan() && !self.worst.0.is_nan()) {
            self.worst = (most, t);
        }
    }
}

/// The largest interpolation error, as a share of the wanted error, at which states are compared.
pub(super) const BETWEEN: f64 = 0.1;

impl<'a> Bench<'a> {
    pub(super) fn new(
        problem: &'a Problem,
        wanted: Wanted,
        dense: &'a Dense,
        progress: &'a dyn Progress,
    ) -> Result<Self, IntegrateError> {
        let system = problem.model.system::<f64>()?;
        Ok(Self { problem, wanted, dense, progress, system })
    }

    /// Runs once. A failure of the run is recorded in the trial.
    ///
    /// # Errors
    /// Invalid input.
    pub(super) fn run(&self, choice: Choice) -> Result<Trial, IntegrateError> {
        let (problem, mut state) = (self.problem, self.problem.start::<f64>()?);
        let start = state.state_ref();
        let mut run = Comparison {
            bench: self,
            watch: Watch::new(self.system.clone(), &problem.model, start)?,
            next: 0.0,
            samples: 0,
            qp: Measured::default(),
            w: Measured::default(),
            worst: (0.0, 0.0),
            z: vec![0.0; 3 * state.dof()],
        };
        let (row, setting) = (choice.row(), choice.setting(problem.end)?);
        let look = &mut |step: u64, state: StateRef<'_, f64>| run.see(step, state);
        let result = problem.model.bind(row)?.run(setting, &mut state, 1, look);
        let ended = ended(&result, setting, run.watch.steps, &state, problem.end)?;
        Ok(self.judged(run, row.name, ended, &state))
    }

    fn judged(
        &self,
        mut run: Comparison<'_>,
        method: &'static str,
        Ended { ending, h, tolerance, effort }: Ended,
        state: &State<Vec<f64>>,
    ) -> Trial {
        let at_end = effort.map(|_| {
            let exact = self.dense.end();
            let exact = [exact.q, exact.p, exact.w].concat();
            let errors = off(state.state_ref(), &exact, &self.problem.model.motors());
            run.take(self.problem.end, errors, self.dense.doubt_at_end());
            errors
        });
        let Ending { outcome, failure } = ending;
        let Comparison { qp, w, worst, samples, watch, .. } = run;
        let end_doubt = self.dense.doubt_at_end();
        let decisive = match at_end {
            Some([end_qp, end_w]) if self.wanted.at_end => {
                larger_or_nan(end_qp + end_doubt.qp(), end_w + end_doubt.w)
            }
            Some(_) => larger_or_nan(qp.bound(), w.bound()),
            None => f64::INFINITY,
        };
        Trial {
            method,
            h,
            tolerance,
            outcome,
            error_qp: at_end.map(|_| qp.error),
            error_w: at_end.map(|_| w.error),
            worst_t: worst.1,
            end_qp: at_end.map(|end| end[0]),
            end_w: at_end.map(|end| end[1]),
            doubt_qp: qp.doubt,
            doubt_w: w.doubt,
            end_doubt_qp: end_doubt.qp(),
            end_doubt_w: end_doubt.w,
            samples,
            k_drift: watch.drift,
            passivity_violations: watch.violations(),
            seconds: None,
            steps: watch.steps,
            evaluations: effort.map(|effort| effort.evaluations),
            iterations: effort.map(|effort| effort.iterations),
            failure,
            decisive: if decisive.is_nan() { f64::INFINITY } else { decisive },
        }
    }
}
