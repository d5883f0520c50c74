//! The error estimate of adaptive collocation, compared with the error of the step.
//!
//! `cargo test -p afterbay-methods --test suite collocation_estimate -- --nocapture` prints it.

use crate::bind::Curved;
use crate::catalog::{Built, duffing, oscillator, pendulum, van_der_pol};
use crate::many::{InSeries, errors, start};
use afterbay_core::taylor::trajectory;
use afterbay_core::{
    Adaptive, Attempt, Effort, InputError, Quad, Scalar, State, StepFailure, Tolerance,
    integrate_within,
};
use afterbay_methods::AdaptiveCollocation;
use std::cell::RefCell;

/// Adaptive collocation that compares each accepted step with the flow computed by Taylor series.
struct Watched<'a> {
    series: &'a InSeries<Quad>,
    tolerance: f64,
    /// The error over the estimate, for estimates not far below the target.
    ratios: RefCell<Vec<f64>>,
}

type Inner = <AdaptiveCollocation as Adaptive<Vec<Quad>, Curved<Quad>>>::Workspace;

/// The last step attempted.
struct Step {
    inner: Inner,
    before: State<Vec<Quad>>,
    h: Quad,
    error: f64,
    /// The error allowed of a step of length 1, in q, p and w alike, in units of the size.
    allowed: f64,
}

/// The error allowed of a step relative to its share of the error of the run, as in the method.
const SHARES: f64 = 5.0;

impl Adaptive<Vec<Quad>, Curved<Quad>> for Watched<'_> {
    type Workspace = Step;

    fn workspace(
        &self,
        system: &Curved<Quad>,
        tolerance: &Tolerance,
        span: f64,
    ) -> Result<Step, InputError> {
        let inner = AdaptiveCollocation.workspace(system, tolerance, span)?;
        let zeros = || vec![Quad::ZERO; system.dof()];
        let before = State::new(zeros(), zeros())?;
        let allowed = SHARES * self.tolerance / span;
        Ok(Step { inner, before, h: Quad::ZERO, error: 0.0, allowed })
    }

    fn attempt(
        &self,
        system: &Curved<Quad>,
        h: Quad,
        state: &State<Vec<Quad>>,
        step: &mut Step,
    ) -> Result<Attempt, StepFailure> {
        let attempt = AdaptiveCollocation.attempt(system, h, state, &mut step.inner)?;
        step.before.clone_from(state);
        (step.h, step.error) = (h, attempt.error);
        Ok(attempt)
    }

    fn end<'a>(&self, step: &'a Step) -> &'a [Quad] {
        Adaptive::<Vec<Quad>, Curved<Quad>>::end(&AdaptiveCollocation, &step.inner)
    }

    fn accept(&self, state: &mut State<Vec<Quad>>, step: &mut Step) {
        Adaptive::<_, Curved<Quad>>::accept(&AdaptiveCollocation, state, &mut step.inner);
        let Step { before, h, error, allowed, .. } = step;
        if *error < 0.02 {
            return;
        }
        let exact = trajectory(self.series, before, *h, 1).unwrap().pop().unwrap();
        let sizes = [&before.q, &before.p, &before.w]
            .map(|part| 1.0 + part.iter().map(|x| x.abs().to_f64()).fold(0.0, f64::max));
        let shares = errors(state, &exact)
            .into_iter()
            .zip(sizes)
            .map(|(apart, size)| apart / (*allowed * h.to_f64() * size));
        self.ratios.borrow_mut().push(shares.fold(0.0, f64::max) / *error);
    }

    fn between(
        &self,
        system: &Curved<Quad>,
        h: Quad,
        before: &State<Vec<Quad>>,
        step: &mut Step,
        to: &mut State<Vec<Quad>>,
    ) -> Result<Effort, StepFailure> {
        AdaptiveCollocation.between(system, h, before, &mut step.inner, to)
    }
}

/// The allowed range of the median ratio.
const BAND: [f64; 2] = [0.03, 5.0];

fn compare(name: &str, system: &Built, from: [&[f64]; 2], end: f64) {
    let (series, system) = (&*system.series(), &*system.curved());
    for tolerance in [1e-4, 1e-6, 1e-9, 1e-12] {
        let mut state = start(from);
        let watched = Watched { series, tolerance, ratios: RefCell::default() };
        let all = Tolerance::all(tolerance);
        integrate_within(&watched, system, &all, Quad::from_f64(end), &mut state, &mut ()).unwrap();
        let mut ratios = watched.ratios.into_inner();
        ratios.sort_by(f64::total_cmp);
        let (median, most) = (ratios[ratios.len() / 2], ratios[ratios.len() - 1]);
        println!("{name:16} {tolerance:e}: {median:8.2} {most:8.2} of {} steps", ratios.len());
        assert!((BAND[0]..BAND[1]).contains(&median), "{name} {tolerance:e}: {ratios:?}");
    }
}

#[test]
fn the_estimate_is_that_of_a_step() {
    println!("error / estimate of a step: median, largest");
    compare("A oscillator", &oscillator(1.0, 0.1), [&[2.3], &[-3.1]], 100.0);
    compare("B Duffing", &duffing(-1.0, 1.0, 0.1), [&[1.5], &[0.5]], 50.0);
    compare("C1 Van der Pol", &van_der_pol(1.0), [&[2.0], &[0.0]], 50.0);
    let e = pendulum([1.0; 2], [1.0; 2], 1.0, [0.1; 2]);
    compare("E pendulum", &e, [&[1.5, -0.5], &[0.0; 2]], 40.0);
}
