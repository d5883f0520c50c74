//! The error estimate of adaptive collocation, compared with the error of the step.
//!
//! `cargo test -p afterbay-methods --test suite collocation_estimate -- --nocapture` prints it.

use afterbay_core::taylor::trajectory;
use afterbay_core::{
    Adaptive, Attempt, Curvature, Effort, InputError, Quad, Scalar, Series, State, StepFailure,
    System, Tolerance, Vector, integrate_within,
};
use afterbay_methods::AdaptiveCollocation;
use afterbay_systems::{DampedDoublePendulum, DampedOscillator, Duffing, VanDerPol};
use std::cell::RefCell;

/// Adaptive collocation that compares each accepted step with the flow computed by Taylor series.
struct Watched<'a, F> {
    series: &'a F,
    tolerance: f64,
    /// The error over the estimate, for estimates not far below the target.
    ratios: RefCell<Vec<f64>>,
}

type Inner<V, S> = <AdaptiveCollocation as Adaptive<V, S>>::Workspace;

/// The last step attempted.
struct Step<V: Vector, W> {
    inner: W,
    before: State<V>,
    h: V::Scalar,
    error: f64,
    /// The error allowed of a step of length 1, in q, p and w alike, in units of the size.
    allowed: f64,
}

/// The error allowed of a step relative to its share of the error of the run, as in the method.
const SHARES: f64 = 5.0;

impl<V, S, F> Adaptive<V, S> for Watched<'_, F>
where
    V: Vector,
    S: Curvature<V::Scalar>,
    F: System<Series<V::Scalar, 24>>,
{
    type Workspace = Step<V, Inner<V, S>>;

    fn workspace(
        &self,
        system: &S,
        tolerance: &Tolerance,
        span: f64,
    ) -> Result<Self::Workspace, InputError> {
        let inner = Adaptive::<V, S>::workspace(&AdaptiveCollocation, system, tolerance, span)?;
        let zeros = || V::zeros(system.dof());
        let before = State::new(zeros(), zeros())?;
        let allowed = SHARES * self.tolerance / span;
        Ok(Step { inner, before, h: V::Scalar::zero(), error: 0.0, allowed })
    }

    fn attempt(
        &self,
        system: &S,
        h: V::Scalar,
        state: &State<V>,
        step: &mut Self::Workspace,
    ) -> Result<Attempt, StepFailure> {
        let attempt = AdaptiveCollocation.attempt(system, h, state, &mut step.inner)?;
        step.before.clone_from(state);
        (step.h, step.error) = (h, attempt.error);
        Ok(attempt)
    }

    fn end<'a>(&self, step: &'a Self::Workspace) -> &'a [V::Scalar] {
        Adaptive::<V, S>::end(&AdaptiveCollocation, &step.inner)
    }

    fn accept(&self, state: &mut State<V>, step: &mut Self::Workspace) {
        Adaptive::<V, S>::accept(&AdaptiveCollocation, state, &mut step.inner);
        let Step { before, h, error, allowed, .. } = step;
        if *error < 0.02 {
            return;
        }
        let exact = trajectory::<_, _, 24>(self.series, before, *h, 1).unwrap().pop().unwrap();
        let share = |found: &V, exact: &V, before: &V| {
            let largest = |x: &mut dyn Iterator<Item = V::Scalar>| {
                x.map(|x| x.abs().to_f64()).fold(0.0, f64::max)
            };
            let apart =
                largest(&mut found.as_slice().iter().zip(exact.as_slice()).map(|(&a, &b)| a - b));
            let size = 1.0 + largest(&mut before.as_slice().iter().copied());
            apart / (*allowed * h.to_f64() * size)
        };
        let q = share(&state.q, &exact.q, &before.q);
        let p = share(&state.p, &exact.p, &before.p);
        let w = share(&state.w, &exact.w, &before.w);
        self.ratios.borrow_mut().push(q.max(p).max(w) / *error);
    }

    fn between(
        &self,
        system: &S,
        h: V::Scalar,
        before: &State<V>,
        step: &mut Self::Workspace,
        to: &mut State<V>,
    ) -> Result<Effort, StepFailure> {
        AdaptiveCollocation.between(system, h, before, &mut step.inner, to)
    }
}

/// The allowed range of the median ratio.
const BAND: [f64; 2] = [0.03, 5.0];

fn compare<S: Curvature<Quad>, const N: usize>(
    name: &str,
    system: &S,
    series: &impl System<Series<Quad, 24>>,
    start: [[f64; N]; 2],
    end: f64,
) {
    for tolerance in [1e-4, 1e-6, 1e-9, 1e-12] {
        let [q, p] = start.map(|x| x.map(Quad::from_f64));
        let mut state = State::new(q, p).unwrap();
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
    let quad = Quad::from_f64;
    let a = DampedOscillator::new(1.0, 0.1).unwrap().map(quad);
    compare("A oscillator", &a, &a.map(Series::constant), [[2.3], [-3.1]], 100.0);
    let b = Duffing::new(-1.0, 1.0, 0.1).unwrap().map(quad);
    compare("B Duffing", &b, &b.map(Series::constant), [[1.5], [0.5]], 50.0);
    let c1 = VanDerPol::new(1.0).unwrap().map(quad);
    compare("C1 Van der Pol", &c1, &c1.map(Series::constant), [[2.0], [0.0]], 50.0);
    let e = DampedDoublePendulum::new([1.0; 2], [1.0; 2], 1.0, [0.1; 2]).unwrap().map(quad);
    compare("E pendulum", &e, &e.map(Series::constant), [[1.5, -0.5], [0.0; 2]], 5.0);
}
