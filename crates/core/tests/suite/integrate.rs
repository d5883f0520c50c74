//! The time loop takes as many steps at once as no one looks at, and no bit of the run shows how
//! many.

use afterbay_core::{
    Effort, Every, Grid, InputError, IntegrateError, Method, Observer, Quantity, RunError,
    STEPS_OF_BLOCK, State, StepFailure, System, integrate, integrate_in,
};
use std::cell::RefCell;
use std::ops::ControlFlow;

/// H = p²/2, D = 0.
struct Free;

impl System<f64> for Free {
    fn dof(&self) -> usize {
        1
    }
    fn energy(&self, _q: &[f64], p: &[f64]) -> f64 {
        p[0] * p[0] / 2.0
    }
    fn gradient(&self, _q: &[f64], p: &[f64], hq: &mut [f64], hp: &mut [f64]) {
        (hq[0], hp[0]) = (0.0, p[0]);
    }
    fn dissipation(&self, _q: &[f64], _p: &[f64], _v: &[f64], d: &mut [f64]) {
        d[0] = 0.0;
    }
}

/// q + h p, up to a wall; w counts the steps taken in motion.
struct Drift {
    wall: f64,
}

impl Method<[f64; 1], Free> for Drift {
    type Workspace = ();

    fn workspace(&self, _system: &Free) -> Result<(), InputError> {
        Ok(())
    }

    fn is_memoryless(&self) -> bool {
        true
    }

    fn step(
        &self,
        _: &Free,
        h: f64,
        state: &mut State<[f64; 1]>,
        _: &mut (),
    ) -> Result<Effort, StepFailure> {
        let q = h.mul_add(state.p[0], state.q[0]);
        if q > self.wall {
            return Err(StepFailure::NonFinite {
                quantity: Quantity::Coordinate,
                dof: 0,
                value: q,
            });
        }
        state.q[0] = q;
        state.w[0] += f64::from(state.p[0] != 0.0);
        Ok(Effort { evaluations: 1, iterations: 0 })
    }
}

/// The same, with a list of how many steps it was asked for.
struct Asked {
    drift: Drift,
    counts: RefCell<Vec<u64>>,
}

impl Method<[f64; 1], Free> for Asked {
    type Workspace = ();

    fn workspace(&self, system: &Free) -> Result<(), InputError> {
        self.drift.workspace(system)
    }

    fn is_memoryless(&self) -> bool {
        true
    }

    fn step(
        &self,
        _: &Free,
        _: f64,
        _: &mut State<[f64; 1]>,
        _: &mut (),
    ) -> Result<Effort, StepFailure> {
        unreachable!("one step is asked for as one of several")
    }

    fn steps(
        &self,
        system: &Free,
        h: f64,
        count: u64,
        state: &mut State<[f64; 1]>,
        workspace: &mut (),
    ) -> Result<Effort, (u64, StepFailure)> {
        self.counts.borrow_mut().push(count);
        self.drift.steps(system, h, count, state, workspace)
    }
}

const H: f64 = 0.1;

fn start(p: f64) -> State<[f64; 1]> {
    State { t: 0.7, ..State::new([0.0], [p]).unwrap() }
}

/// How the run ended, where, and how many steps were asked for at a time.
fn run(
    p: f64,
    steps: u64,
    wall: f64,
    observer: &mut impl Observer<[f64; 1]>,
) -> (Result<Effort, IntegrateError>, State<[f64; 1]>, Vec<u64>) {
    let method = Asked { drift: Drift { wall }, counts: RefCell::default() };
    let mut state = start(p);
    let outcome = integrate(&method, &Free, Grid::of(H, steps).unwrap(), &mut state, observer);
    (outcome, state, method.counts.into_inner())
}

/// The steps and states seen.
type Seen = Vec<(u64, State<[f64; 1]>)>;

fn record(seen: &mut Seen) -> impl FnMut(u64, &State<[f64; 1]>) -> ControlFlow<()> {
    |step, state| {
        seen.push((step, state.clone()));
        ControlFlow::Continue(())
    }
}

#[test]
fn as_many_steps_are_asked_for_as_no_one_looks_at() {
    let (_, _, counts) = run(1.0, 2500, f64::MAX, &mut ());
    assert_eq!(counts, [1024, 1024, 452]);
    let (_, _, counts) = run(1.0, 2500, f64::MAX, &mut Every::new(700, record(&mut Seen::new())));
    assert_eq!(counts, [700, 324, 376, 648, 52, 400]);
    let (_, _, counts) = run(1.0, 2500, f64::MAX, &mut record(&mut Seen::new()));
    assert_eq!(counts, [1; 2500]);
}

#[test]
fn every_observer_sees_the_same_run() {
    let mut all = Seen::new();
    let expected = run(1.0, 2500, f64::MAX, &mut record(&mut all));
    assert_eq!(all.len(), 2501);
    for (n, (step, state)) in all.iter().enumerate() {
        assert_eq!((*step, state.t.to_bits()), (n as u64, (n as f64).mul_add(H, 0.7).to_bits()));
    }
    let found = run(1.0, 2500, f64::MAX, &mut ());
    assert_eq!((&found.0, &found.1), (&expected.0, &expected.1));
    for stride in [1, 2, 300, 512, 1024, 1025, 2500, 2501, u64::MAX] {
        let mut some = Seen::new();
        let found = run(1.0, 2500, f64::MAX, &mut Every::new(stride, record(&mut some)));
        assert_eq!((&found.0, &found.1), (&expected.0, &expected.1), "{stride}");
        assert!(all.iter().filter(|(step, _)| step % stride == 0).eq(&some), "{stride}");
    }
}

/// What is below 1e-290 is at rest from the 1024th step on, whoever looks.
#[test]
fn what_has_come_to_rest_does_so_at_the_same_step() {
    for stride in [1, 3, 1000, 1024, u64::MAX] {
        let (_, state, _) =
            run(1e-300, 1500, f64::MAX, &mut Every::new(stride, record(&mut Seen::new())));
        assert_eq!((state.p, state.w), ([0.0], [1024.0]), "{stride}");
    }
    let (_, state, _) = run(1e-300, 1500, f64::MAX, &mut ());
    assert_eq!((state.p, state.w), ([0.0], [1024.0]));
}

/// Steps that change nothing are not taken, and no one sees that but by the time it takes.
#[test]
fn what_does_not_move_is_left_alone() {
    let steps = 10_000;
    let (outcome, state, counts) = run(0.0, steps, f64::MAX, &mut ());
    assert_eq!(counts, [1024, 1]);
    assert_eq!(outcome, Ok(Effort { evaluations: steps, iterations: 0 }));
    assert_eq!(state, State { t: (steps as f64).mul_add(H, 0.7), ..start(0.0) });
    for stride in [1, 3, 1024, 3000] {
        let mut seen = Seen::new();
        let found = run(0.0, steps, f64::MAX, &mut Every::new(stride, record(&mut seen)));
        assert_eq!((found.0, found.1), (outcome.clone(), state.clone()), "{stride}");
        let expected = (0..=steps).filter(|step| step % stride == 0);
        assert!(
            expected.map(|n| (n, State { t: (n as f64).mul_add(H, 0.7), ..start(0.0) })).eq(seen),
            "{stride}"
        );
    }
    let stop = |step, _: &State<[f64; 1]>| {
        if step == 5000 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    assert_eq!(run(0.0, steps, f64::MAX, &mut { stop }).1.t, 5000_f64.mul_add(H, 0.7));
}

/// w grows once in 3000 steps, which are counted in the workspace.
struct Clock;

impl Method<[f64; 1], Free> for Clock {
    type Workspace = u64;

    fn workspace(&self, _system: &Free) -> Result<u64, InputError> {
        Ok(0)
    }

    fn step(
        &self,
        _: &Free,
        _: f64,
        state: &mut State<[f64; 1]>,
        n: &mut u64,
    ) -> Result<Effort, StepFailure> {
        *n += 1;
        state.w[0] += f64::from(n.is_multiple_of(3000));
        Ok(Effort::default())
    }
}

#[test]
fn a_method_with_memory_takes_every_step() {
    let mut state = start(0.0);
    integrate(&Clock, &Free, Grid::of(H, 10_000).unwrap(), &mut state, &mut ()).unwrap();
    assert_eq!(state.w, [3.0]);
}

#[test]
fn a_failure_is_of_the_right_step_and_leaves_the_last_good_state() {
    for failing in [1, 2, 1024, 1025, 1500] {
        let wall = H * (failing as f64 - 0.5);
        let mut all = Seen::new();
        let (outcome, state, _) = run(1.0, 2500, wall, &mut record(&mut all));
        let t = ((failing - 1) as f64).mul_add(H, 0.7);
        match &outcome {
            Err(IntegrateError::Run(RunError { step, t: found, .. })) => {
                assert_eq!((*step, *found), (failing, t));
            }
            other => panic!("{other:?}"),
        }
        assert_eq!(
            (&state, state.w, state.t),
            (&all[failing as usize - 1].1, [(failing - 1) as f64], t)
        );
        let found = run(1.0, 2500, wall, &mut ());
        assert_eq!((found.0, found.1), (outcome.clone(), state.clone()), "{failing}");
        for stride in [2, 7, 1024, 3000] {
            let found = run(1.0, 2500, wall, &mut Every::new(stride, record(&mut Seen::new())));
            assert_eq!((found.0, found.1), (outcome.clone(), state.clone()), "{failing} {stride}");
        }
    }
}

#[test]
fn a_run_may_be_ended_at_any_look() {
    for stride in [1, 5, 1024] {
        let mut looks = 0;
        let mut third = Every::new(stride, |_: u64, _: &State<[f64; 1]>| {
            looks += 1;
            if looks == 3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        let (outcome, state, _) = run(1.0, 5000, f64::MAX, &mut third);
        assert_eq!((outcome.unwrap().evaluations, state.w), (2 * stride, [(2 * stride) as f64]));
    }
}

/// A step that adds p to w, whole or in parts.
struct Leak {
    sums_reservoir: bool,
}

impl<S: System<f64>> Method<[f64; 1], S> for Leak {
    type Workspace = ();

    fn workspace(&self, _system: &S) -> Result<(), InputError> {
        Ok(())
    }

    fn sums_reservoir(&self) -> bool {
        self.sums_reservoir
    }

    fn step(
        &self,
        _: &S,
        _: f64,
        state: &mut State<[f64; 1]>,
        _: &mut (),
    ) -> Result<Effort, StepFailure> {
        state.w[0] += state.p[0];
        Ok(Effort::default())
    }
}

/// A fifth of the rounding of 1, and not a number of few bits.
const LEAKED: f64 = 0.2 * f64::EPSILON + 1e-19;

fn leak(steps: u64, observer: &mut impl Observer<[f64; 1]>) -> State<[f64; 1]> {
    let mut state = State { w: [1.0], ..start(LEAKED) };
    let (method, grid) = (Leak { sums_reservoir: false }, Grid::of(H, steps).unwrap());
    integrate(&method, &Free, grid, &mut state, observer).unwrap();
    state
}

#[test]
fn increments_below_the_rounding_of_w_are_not_lost() {
    let steps = 100_000;
    let expected = 1.0 + steps as f64 * LEAKED;
    assert_eq!(leak(steps, &mut ()).w, [expected]);
    let mut state = State { w: [1.0], ..start(LEAKED) };
    let (method, grid) = (Leak { sums_reservoir: true }, Grid::of(H, steps).unwrap());
    integrate(&method, &Free, grid, &mut state, &mut ()).unwrap();
    assert_eq!(state.w, [1.0], "a method that sums w by itself finds all of it in the state");
}

#[test]
fn w_does_not_depend_on_the_observer() {
    let (mut all, steps) = (Seen::new(), 5000);
    let end = leak(steps, &mut record(&mut all));
    for (n, (step, state)) in all.iter().enumerate() {
        let off = (state.w[0] - (1.0 + n as f64 * LEAKED)).abs();
        assert!(*step == n as u64 && off <= f64::EPSILON, "{n}: {off:e}");
    }
    assert!(all.is_sorted_by(|a, b| a.1.w <= b.1.w), "w never falls");
    for stride in [3, 1024, 1500, u64::MAX] {
        let mut some = Seen::new();
        assert_eq!(leak(steps, &mut Every::new(stride, record(&mut some))), end, "{stride}");
        assert!(all.iter().filter(|(step, _)| step % stride == 0).eq(&some), "{stride}");
    }
}

#[test]
fn a_run_in_parts_has_the_w_of_one_run() {
    let whole = leak(6 * STEPS_OF_BLOCK + 17, &mut ());
    let mut state = State { w: [1.0], ..start(LEAKED) };
    let mut remainder = [0.0];
    for steps in [STEPS_OF_BLOCK, 2 * STEPS_OF_BLOCK, 3 * STEPS_OF_BLOCK, 17] {
        let (method, grid) = (Leak { sums_reservoir: false }, Grid::of(H, steps).unwrap());
        integrate_in(&method, &Free, grid, &mut state, &mut remainder, &mut (), &mut ()).unwrap();
    }
    assert_eq!(state.w, whole.w);
    assert_ne!(remainder, [0.0]);
}

#[test]
fn a_reservoir_that_overflows_between_two_blocks_is_a_failure() {
    let mut state = State { w: [f64::MAX], ..start(f64::MAX / 1000.0) };
    let (method, grid) = (Leak { sums_reservoir: false }, Grid::of(H, 2000).unwrap());
    let outcome = integrate(&method, &Free, grid, &mut state, &mut ());
    let Err(IntegrateError::Run(RunError { failure, .. })) = outcome else { panic!("{outcome:?}") };
    let w = Quantity::Reservoir;
    assert_eq!(failure, StepFailure::NonFinite { quantity: w, dof: 0, value: f64::INFINITY });
    assert_eq!(state, State { w: [f64::MAX], ..start(f64::MAX / 1000.0) });
}

/// A system whose steps are examined.
struct Singular;

impl System<f64> for Singular {
    fn dof(&self) -> usize {
        1
    }
    fn energy(&self, q: &[f64], p: &[f64]) -> f64 {
        Free.energy(q, p)
    }
    fn gradient(&self, q: &[f64], p: &[f64], hq: &mut [f64], hp: &mut [f64]) {
        Free.gradient(q, p, hq, hp);
    }
    fn dissipation(&self, q: &[f64], p: &[f64], v: &[f64], d: &mut [f64]) {
        Free.dissipation(q, p, v, d);
    }
    fn may_be_singular(&self) -> bool {
        true
    }
}

#[test]
fn a_reservoir_that_overflows_leaves_an_earlier_state() {
    // w is p times the number of steps, and overflows at step 1501.
    let p = f64::MAX / 1500.5;
    fn check(system: &impl System<f64>, p: f64, observer: &mut impl Observer<[f64; 1]>) -> u64 {
        let (method, grid) = (Leak { sums_reservoir: false }, Grid::of(H, 2000).unwrap());
        let mut state = start(p);
        let error = integrate(&method, system, grid, &mut state, observer).unwrap_err();
        let IntegrateError::Run(RunError { step, t, .. }) = error else { panic!("{error}") };
        assert_eq!(t, ((step - 1) as f64).mul_add(H, start(p).t));
        let done = (state.w[0] / p).round();
        assert!((state.w[0] / p - done).abs() < 1e-9, "{:?}", state.w);
        assert_eq!(state, State { w: state.w, t: done.mul_add(H, start(p).t), ..start(p) });
        assert_eq!(done as u64, if system.may_be_singular() { 1500 } else { STEPS_OF_BLOCK });
        step
    }
    assert_eq!(check(&Free, p, &mut record(&mut Seen::new())), 1501);
    assert_eq!(check(&Free, p, &mut ()), 2000);
    assert_eq!(check(&Singular, p, &mut record(&mut Seen::new())), 1501);
}
