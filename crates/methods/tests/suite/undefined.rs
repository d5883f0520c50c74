//! Systems without a value or a derivative where a run begins, or that contradict what they state.

use afterbay_core::{
    DissipationForm, Formulas, FromFormulas, Grid, InputError, IntegrateError, RunError, Scalar,
    State, StateRef, Statistics, StepFailure, System, Tolerance, f64x8, integrate,
    integrate_within,
};
use afterbay_methods::registry::{self, ADAPTIVE, METHODS, Setting, bind, find};
use afterbay_methods::{AdaptiveDop853, Composition, Increment, Relaxed};
use std::ops::ControlFlow;
use std::sync::Arc;

/// Two masses on springs of stiffness k, with drag on each velocity and between the two.
#[derive(Clone, Copy)]
struct Pair {
    k: f64,
    between: f64,
    form: DissipationForm,
}

const PAIR: Pair = Pair { k: 1.0, between: 0.0, form: DissipationForm::GENERAL };

impl Formulas for Pair {
    fn dof(&self) -> usize {
        2
    }

    fn potential<T: Scalar>(&self, q: &[T]) -> T {
        let d = q[1] - q[0];
        (T::from_f64(self.k) * (q[0] * q[0] + q[1] * q[1]) + d * d * d * d).half()
    }

    fn dissipation<T: Scalar>(&self, _q: &[T], v: &[T], j: usize) -> T {
        T::from_f64(0.1) * v[j] + T::from_f64(self.between) * (v[j] - v[1 - j])
    }

    fn dissipation_form(&self) -> DissipationForm {
        self.form
    }
}

/// Without a value of the stiffness, every method names the force.
#[test]
fn a_parameter_without_a_value_is_named_as_the_cause() {
    let mut ran = 0;
    for k in [f64::NAN, f64::INFINITY] {
        for row in METHODS {
            let system = Arc::new(FromFormulas(Pair { k, ..PAIR }));
            let Ok(run) = bind::<f64>(row, system) else { continue };
            let setting = match row.is_adaptive() {
                true => Setting::Tolerance(Tolerance::all(1e-6), 1.0),
                false => Setting::Step(Grid::of(0.1, 10).unwrap()),
            };
            let mut state = State::new(vec![1.0, 0.5], vec![0.0, 0.2]).unwrap();
            let mut show = |_: u64, _: StateRef<'_, f64>| ControlFlow::Continue(());
            let error = run.run(setting, &mut state, 1, &mut show).unwrap_err();
            let IntegrateError::Run(RunError { step: 1, failure, .. }) = error else {
                panic!("{} with k = {k}: {error}", row.name)
            };
            let is_named = matches!(failure, StepFailure::Undefined { .. });
            assert!(is_named, "{} with k = {k}: {failure}", row.name);
            let said = failure.to_string();
            assert!(said.contains("∂H/∂q1") && said.contains("check the parameters"), "{said}");
            ran += 1;
        }
    }
    assert!(ran > 30, "{ran}");
}

/// D_j depends on both velocities, and the system states that it does not: methods that rely on it
/// refuse the system. With the true statement they run, or refuse it by its name.
#[test]
fn friction_between_velocities_is_not_taken_for_friction_on_each() {
    let names =
        ["leapfrog", "splitting-2", "splitting-6", "increment-2", "increment-4", "locally-exact"];
    for name in names {
        let row = find(name).unwrap();
        let bound = |between, form| {
            bind::<f64>(row, Arc::new(FromFormulas(Pair { between, form, ..PAIR })))
        };
        let Err(error) = bound(0.3, DissipationForm::GENERAL) else { panic!("{name} applies") };
        assert!(error.to_string().contains("dissipation_form()"), "{name}: {error}");
        assert!(bound(0.0, DissipationForm::GENERAL).is_ok(), "{name}");
        let stated = DissipationForm { coupled: true, linear: true, ..DissipationForm::GENERAL };
        match bound(0.3, stated) {
            Ok(_) => {}
            Err(InputError::Unsupported { why, .. }) => {
                assert!(!why.contains("dissipation_form()"), "{name}: {why}");
            }
            Err(error) => panic!("{name}: {error}"),
        }
    }
}

/// From a late start, times are numbers far apart; steps end at such numbers.
#[test]
fn a_late_start_does_not_change_an_autonomous_run() {
    let system = FromFormulas(PAIR);
    let end = |from: f64| {
        let mut state = State { t: from, ..State::new([1.0, 0.5], [0.0, 0.2]).unwrap() };
        let tolerance = Tolerance::all(1e-9);
        integrate_within(&AdaptiveDop853, &system, &tolerance, from + 4.0, &mut state, &mut ())
            .expect("it runs");
        state
    };
    let early = end(0.0);
    for from in [1.7e9, 1e12] {
        let late = end(from);
        for (a, b) in early.q.iter().chain(&early.p).zip(late.q.iter().chain(&late.p)) {
            assert!((a - b).abs() < 2e-9, "from {from:e}: {a} and {b}");
        }
    }
}

#[test]
fn an_end_before_the_start_names_both() {
    let mut state = State { t: 5.0, ..State::new([1.0, 0.5], [0.0, 0.2]).unwrap() };
    let tolerance = Tolerance::all(1e-9);
    let system = FromFormulas(PAIR);
    let ended = integrate_within(&AdaptiveDop853, &system, &tolerance, 1.0, &mut state, &mut ());
    let said = ended.unwrap_err().to_string();
    assert_eq!(said, "the time 1.0 must be finite and not before 5.0");
}

/// An observer of every n-th step sees each run from its start.
#[test]
fn an_observer_of_some_steps_sees_a_second_run() {
    let (system, mut seen) = (FromFormulas(PAIR), Vec::new());
    let mut every = afterbay_core::Every::new(5, |step: u64, _: &State<[f64; 2]>| {
        seen.push(step);
        ControlFlow::Continue(())
    });
    for _ in 0..2 {
        let mut state = State::new([1.0, 0.5], [0.0, 0.2]).unwrap();
        let method = Increment::new(Composition::pair());
        integrate(&method, &system, Grid::of(0.1, 10).unwrap(), &mut state, &mut every).unwrap();
    }
    assert_eq!(seen, [0, 5, 10, 0, 5, 10]);
}

/// w begins at 0, where a tolerance relative to it allows nothing but roundings.
#[test]
fn a_reservoir_that_begins_empty_does_not_shorten_steps() {
    let steps = |absolute: f64| {
        let tolerance =
            Tolerance { w_relative: 1e-8, w_absolute: absolute, ..Tolerance::all(1e-8) };
        let mut state = State::new([1.0, 0.5], [0.0, 0.2]).unwrap();
        let system = FromFormulas(PAIR);
        integrate_within(&AdaptiveDop853, &system, &tolerance, 10.0, &mut state, &mut ())
            .expect("it runs")
            .accepted
    };
    let [usual, least] = [1e-8, 1e-300].map(steps);
    assert!(least <= 3 * usual, "{least} steps in place of {usual}");
}

/// H is NaN beyond q = 1, and its gradient is not.
struct Unmeasured;

impl System<f64> for Unmeasured {
    fn dof(&self) -> usize {
        1
    }
    fn energy(&self, q: &[f64], p: &[f64]) -> f64 {
        p[0] * p[0] / 2.0 + if q[0] > 1.0 { f64::NAN } else { 0.0 }
    }
    fn gradient(&self, _q: &[f64], p: &[f64], hq: &mut [f64], hp: &mut [f64]) {
        (hq[0], hp[0]) = (0.0, p[0]);
    }
    fn dissipation(&self, _q: &[f64], _p: &[f64], _v: &[f64], d: &mut [f64]) {
        d[0] = 0.0;
    }
}

#[test]
fn an_energy_without_a_value_is_named() {
    let mut state = State::new([2.0], [1.0]).unwrap();
    let grid = Grid::of(0.1, 10).unwrap();
    let ended = integrate(&Relaxed::rk4(), &Unmeasured, grid, &mut state, &mut ());
    let Err(IntegrateError::Run(RunError { step: 1, failure, .. })) = ended else {
        panic!("{ended:?}")
    };
    let said = failure.to_string();
    assert!(matches!(failure, StepFailure::Undefined { .. }) && said.contains("H = NaN"), "{said}");
}

/// Of several numbers side by side, the one that is not finite is said.
#[test]
fn a_lane_that_is_not_finite_is_said() {
    let mut lanes = [0.1; 8];
    lanes[3] = f64::NEG_INFINITY;
    let refused = State::new([f64x8::new(lanes)], [f64x8::splat(1.0)]).unwrap_err();
    assert!(refused.to_string().contains("q1 = -inf"), "{refused}");
}

/// Two oscillators, of which the friction on the first has no value beyond q1 = 1.2.
struct Ends;

impl Formulas for Ends {
    fn dof(&self) -> usize {
        2
    }

    fn potential<T: Scalar>(&self, q: &[T]) -> T {
        (q[0] * q[0] + q[1] * q[1]).half()
    }

    fn dissipation<T: Scalar>(&self, q: &[T], v: &[T], j: usize) -> T {
        let share = if j == 0 { (T::from_f64(1.2) - q[0]).sqrt() } else { T::one() };
        T::from_f64(0.1) * v[j] * share
    }
}

/// The end of a step may be beyond, though its nodes are not.
#[test]
fn no_step_ends_where_friction_has_no_value() {
    for row in ADAPTIVE {
        let run = bind(row, Arc::new(FromFormulas(Ends))).unwrap();
        for start in 0..20 {
            let p = 1.5 + 0.1 * f64::from(start);
            let mut state = State::new(vec![0.0, 0.5], vec![p, 0.0]).unwrap();
            let setting = Setting::Tolerance(Tolerance::all(1e-3), 10.0);
            let mut show = |_: u64, state: StateRef<'_, f64>| {
                assert!(state.q[0] <= 1.2, "{} p = {p}: {:?}", row.name, state.q);
                ControlFlow::Continue(())
            };
            let outcome = run.run(setting, &mut state, 1, &mut show);
            assert!(matches!(outcome, Err(IntegrateError::Run(_))), "{}: {outcome:?}", row.name);
            assert!(state.q[0] > 1.1, "{} p = {p}: {:?}", row.name, state.q);
        }
    }
}

/// Pendulums on a row of springs, with the drag v √|v|, whose derivative at rest is ∞·0 as it is
/// written.
#[derive(Clone, Copy)]
struct Row {
    n: usize,
}

impl Formulas for Row {
    fn dof(&self) -> usize {
        self.n
    }

    fn potential<T: Scalar>(&self, q: &[T]) -> T {
        let swings = q.iter().fold(T::zero(), |sum, q| sum - q.sin_cos().1);
        q.windows(2).fold(swings, |sum, q| sum + ((q[1] - q[0]) * (q[1] - q[0])).half())
    }

    fn dissipation<T: Scalar>(&self, _q: &[T], v: &[T], j: usize) -> T {
        T::from_f64(0.3) * v[j].abs().sqrt() * v[j]
    }

    fn kinks<T: Scalar>(&self, _q: &[T], v: &[T], put: &mut dyn FnMut(T)) {
        v.iter().for_each(|&v| put(v));
    }
}

/// An iteration may begin with any slope, so that methods that use derivatives of D run, too.
#[test]
fn a_friction_without_a_derivative_at_rest_is_taken_by_every_method() {
    for n in [1, 3] {
        let end = |row| {
            let run = bind::<f64>(row, Arc::new(FromFormulas(Row { n }))).ok()?;
            let setting = match row.is_adaptive() {
                true => Setting::Tolerance(Tolerance::all(1e-8), 2.0),
                false => Setting::Step(Grid::new(0.002, 2.0).unwrap()),
            };
            let q = [3.0, 1.0, -0.5][..n].to_vec();
            let mut state = State::new(q, vec![0.0; n]).unwrap();
            let mut show = |_: u64, _: StateRef<'_, f64>| ControlFlow::Continue(());
            let done = run.run(setting, &mut state, 1, &mut show);
            Some(done.map(|_| state).unwrap_or_else(|error| panic!("{}: {error}", row.name)))
        };
        let exact = end(find("adaptive-verner98").unwrap()).unwrap();
        let found = METHODS.iter().filter_map(|row| Some((row.name, end(row)?)));
        let found: Vec<_> = found.collect();
        assert!(found.len() > 20, "{}", found.len());
        for (name, state) in found {
            for (x, exact) in state.q.iter().chain(&state.p).zip(exact.q.iter().chain(&exact.p)) {
                assert!((x - exact).abs() < 0.005, "{name}: {x}, not {exact}");
            }
        }
    }
}

/// A mass without a derivative of D in q, or of V, where q = 0.
#[derive(Clone, Copy)]
enum Rooted {
    /// D = v √|q|
    Friction,
    /// V = q² √|q| - q
    Potential,
}

impl Formulas for Rooted {
    fn dof(&self) -> usize {
        1
    }

    fn potential<T: Scalar>(&self, q: &[T]) -> T {
        match self {
            Self::Friction => (q[0] * q[0]).half() - q[0],
            Self::Potential => q[0] * q[0] * q[0].abs().sqrt() - q[0],
        }
    }

    fn dissipation<T: Scalar>(&self, q: &[T], v: &[T], _j: usize) -> T {
        match self {
            Self::Friction => v[0] * q[0].abs().sqrt(),
            Self::Potential => v[0],
        }
    }

    fn kinks<T: Scalar>(&self, q: &[T], _v: &[T], put: &mut dyn FnMut(T)) {
        put(q[0]);
    }
}

/// Runs a method from rest at q = 0.
fn from_zero(row: &registry::Row, system: Rooted) -> Option<Result<Statistics, IntegrateError>> {
    let run = bind::<f64>(row, Arc::new(FromFormulas(system))).ok()?;
    let setting = match row.is_adaptive() {
        true => Setting::Tolerance(Tolerance::all(1e-8), 2.0),
        false => Setting::Step(Grid::new(0.002, 2.0).unwrap()),
    };
    let mut state = State::new(vec![0.0], vec![0.0]).unwrap();
    let mut show = |_: u64, _: StateRef<'_, f64>| ControlFlow::Continue(());
    Some(run.run(setting, &mut state, 1, &mut show))
}

/// A smaller step does not help: the step begins there.
#[test]
fn where_a_derivative_has_no_value_a_method_without_it_is_advised() {
    let outcomes =
        METHODS.iter().filter_map(|row| Some((row.name, from_zero(row, Rooted::Friction)?)));
    let mut failed = Vec::new();
    for (name, outcome) in outcomes {
        let Err(error) = outcome else { continue };
        let said = error.to_string();
        assert!(said.contains("so that its derivative exists, or take a method"), "{name}: {said}");
        failed.push(name);
    }
    assert_eq!(failed, ["leapfrog", "splitting-2", "splitting-4", "splitting-6"]);
    from_zero(find("adaptive-dop853").unwrap(), Rooted::Friction).unwrap().unwrap();
}

#[test]
fn an_energy_without_a_derivative_is_told_apart_from_one_without_a_value() {
    for row in METHODS {
        let Some(outcome) = from_zero(row, Rooted::Potential) else { continue };
        let said = outcome.unwrap_err().to_string();
        let end = "begin where H, its derivatives and D have values";
        assert!(said.contains("∂H/∂q1 = NaN") && said.ends_with(end), "{}: {said}", row.name);
    }
}
