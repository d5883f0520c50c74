//! The vectorised coloured sweeps give to the bit the results of coloured sweeps one member at a
//! time.

use crate::bind::AnyMembers;
use crate::catalog::{chain, ring};
use afterbay_core::{
    Coupling, Dissipation, DissipationForm, Effort, Every, Grid, InputError, IntegrateError,
    Method, RunError, Scalar, Separable, State, StepFailure, System, Uniform, f64x8, integrate,
};
use afterbay_methods::{Composition, Increment, Tiled};
use proptest::prelude::*;
use std::ops::ControlFlow;

fn start(n: usize, seed: f64) -> State<Vec<f64>> {
    let at = |phase: f64| {
        (0..n).map(|j| (phase + 1.7 * j as f64).sin() * (1.0 + 0.1 * (j % 7) as f64)).collect()
    };
    State::new(at(seed), at(seed + 2.1)).unwrap()
}

/// q, p and w after some steps, one member at a time in coloured order.
pub(crate) fn one_at_a_time(
    system: &dyn Separable<f64>,
    composition: &Composition,
    grid: Grid<f64>,
    mut state: State<Vec<f64>>,
) -> State<Vec<f64>> {
    let method =
        Increment::new(composition.clone()).in_order(system.coupling().coloured(system.dof()));
    integrate(&method, system, grid, &mut state, &mut ()).unwrap();
    state
}

pub(crate) fn side_by_side(
    system: &AnyMembers,
    composition: &Composition,
    threads: usize,
    grid: Grid<f64>,
    mut state: State<Vec<f64>>,
) -> State<Vec<f64>> {
    let method = Tiled::new(composition.clone()).on_threads(threads);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| integrate(&method, system, grid, &mut state, &mut ())).unwrap();
    state
}

fn compositions() -> [Composition; 5] {
    [
        Composition::sweep(),
        Composition::pair(),
        Composition::suzuki4(),
        Composition::blanes_moan4(),
        Composition::kahan_li8(),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn a_chain_is_moved_as_it_is_one_at_a_time(
        n in 1usize..70, beta in 0.0..2.0, c in -0.2..0.5, h in 0.01..1.0,
        seed in 0.0..6.0, which in 0usize..5,
    ) {
        let (system, grid) = (chain(n, beta, c).members(), Grid::of(h, 3).unwrap());
        let composition = &compositions()[which];
        let found = side_by_side(&*system, composition, 1, grid, start(n, seed));
        prop_assert_eq!(found, one_at_a_time(&*system, composition, grid, start(n, seed)));
    }

    #[test]
    fn a_ring_is_moved_as_it_is_one_at_a_time(
        half in 1usize..35, mu in -1.0..2.0, coupling in 0.0..2.0, h in 0.01..0.5,
        seed in 0.0..6.0, which in 0usize..5,
    ) {
        let system = ring(2 * half, mu, coupling).members();
        let grid = Grid::of(h, 3).unwrap();
        let composition = &compositions()[which];
        let found = side_by_side(&*system, composition, 1, grid, start(2 * half, seed));
        prop_assert_eq!(found, one_at_a_time(&*system, composition, grid, start(2 * half, seed)));
    }
}

/// Several tiles, the last of them not full, divided among the threads in different ways.
#[test]
fn the_number_of_threads_changes_nothing() {
    let grid = Grid::of(0.1, 3).unwrap();
    for composition in &compositions() {
        for n in [1024, 2049, 5000] {
            let chain = chain(n, 1.0, 0.1).members();
            let expected = one_at_a_time(&*chain, composition, grid, start(n, 0.3));
            for threads in [1, 2, 5] {
                assert_eq!(
                    side_by_side(&*chain, composition, threads, grid, start(n, 0.3)),
                    expected,
                    "{n}"
                );
            }
        }
        let ring = ring(4098, 0.5, 0.3).members();
        let expected = one_at_a_time(&*ring, composition, grid, start(4098, 0.3));
        for threads in [1, 3] {
            assert_eq!(
                side_by_side(&*ring, composition, threads, grid, start(4098, 0.3)),
                expected
            );
        }
    }
}

#[test]
fn a_step_that_fails_has_a_name_and_changes_nothing() {
    // Softening springs: at large extension the force decreases, and a long step has no solution.
    let chain = &*chain(3000, -1.0, 0.1).members();
    let before = start(3000, 0.3);
    let failures = [1, 2, 5].map(|threads| {
        let mut state = before.clone();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let method = Tiled::new(Composition::pair()).on_threads(threads);
        let error = pool
            .install(|| integrate(&method, chain, Grid::of(3.0, 1).unwrap(), &mut state, &mut ()));
        assert_eq!(state, before);
        error.unwrap_err().to_string()
    });
    assert!(failures[0].contains("degree of freedom 3 has several solutions"), "{}", failures[0]);
    assert!(failures.iter().all(|failure| *failure == failures[0]), "{failures:?}");
}

/// Takes one step after the other, and returns the failure of the first step that fails, if any.
fn step_by_step(
    system: &AnyMembers,
    composition: &Composition,
    grid: Grid<f64>,
    start: State<Vec<f64>>,
) -> (Vec<State<Vec<f64>>>, Option<StepFailure>) {
    let method = Tiled::new(composition.clone());
    let mut workspace = method.workspace(system).unwrap();
    let mut states = vec![start];
    for n in 1..=grid.steps {
        let mut state = states[states.len() - 1].clone();
        if let Err(failure) = method.step(system, grid.h, &mut state, &mut workspace) {
            return (states, Some(failure));
        }
        state.t = (n as f64).mul_add(grid.h, states[0].t);
        states.push(state);
    }
    (states, None)
}

/// The states seen in a run, its outcome, and its final state.
type Seen = (Vec<State<Vec<f64>>>, Result<Effort, IntegrateError>, State<Vec<f64>>);

/// A run on some threads, shown every `stride` steps.
fn seen(
    system: &AnyMembers,
    composition: &Composition,
    (threads, stride): (usize, u64),
    grid: Grid<f64>,
    mut state: State<Vec<f64>>,
) -> Seen {
    let method = Tiled::new(composition.clone()).on_threads(threads);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let mut states = vec![];
    let mut look = Every::new(stride, |_: u64, state: &State<Vec<f64>>| {
        states.push(state.clone());
        ControlFlow::Continue(())
    });
    let outcome = pool.install(|| integrate(&method, system, grid, &mut state, &mut look));
    (states, outcome, state)
}

fn steps_at_once_are_steps_one_by_one(system: &AnyMembers, steps: u64) {
    let (n, grid) = (system.dof(), Grid::of(0.1, steps).unwrap());
    for composition in &compositions() {
        let (all, failure) = step_by_step(system, composition, grid, start(n, 0.3));
        assert_eq!(failure, None);
        assert_eq!(
            all[all.len() - 1],
            one_at_a_time(system, composition, grid, start(n, 0.3)),
            "{n}"
        );
        for (threads, stride) in [(1, 1), (1, 3), (2, 5), (1, 8), (1, 11), (2, u64::MAX)] {
            let (some, outcome, last) =
                seen(system, composition, (threads, stride), grid, start(n, 0.3));
            assert!(outcome.is_ok() && last == all[all.len() - 1], "{n} {threads} {stride}");
            assert!(
                all.iter()
                    .enumerate()
                    .filter(|(n, _)| (*n as u64).is_multiple_of(stride))
                    .map(|(_, s)| s)
                    .eq(&some)
            );
        }
    }
}

/// One tile and several, with and without friction; strides that divide the number of steps a tile
/// takes at once, and others.
#[test]
fn several_steps_at_once_are_the_same_one_by_one() {
    for n in [1, 2, 3, 17, 112, 1023] {
        steps_at_once_are_steps_one_by_one(&*chain(n, 1.0, 0.1).members(), 19);
    }
    for n in [2, 4, 18, 112, 1022] {
        steps_at_once_are_steps_one_by_one(&*ring(n, 0.5, 0.3).members(), 19);
    }
    steps_at_once_are_steps_one_by_one(&*chain(1025, 1.0, 0.0).members(), 19);
    steps_at_once_are_steps_one_by_one(&*chain(3071, 1.0, -0.1).members(), 19);
    steps_at_once_are_steps_one_by_one(&*ring(2050, 0.5, 0.3).members(), 19);
}

#[test]
fn a_failure_among_several_steps_is_of_the_right_one() {
    // Softening springs break where they are stretched most, in one tile or in two, earlier for
    // larger stretch.
    let chain = chain(2500, -1.0, -0.2).members();
    let grid = Grid::of(0.4, 100).unwrap();
    let mut places = vec![];
    for pulled in [[700, 700], [1500, 2200], [1023, 1024]] {
        for by in [0.9, 1.1, 1.4] {
            let mut before = start(2500, 0.3);
            before.q.iter_mut().chain(&mut before.p).for_each(|x| *x *= 0.1);
            pulled.iter().for_each(|&j| before.q[j] += by);
            let (all, failure) = step_by_step(&*chain, &Composition::pair(), grid, before.clone());
            let last = &all[all.len() - 1];
            let run = RunError { step: all.len() as u64, t: last.t, failure: failure.unwrap() };
            places.push((all.len() - 1) % 8);
            for (threads, stride) in [(1, u64::MAX), (2, u64::MAX), (1, 5), (1, 1)] {
                let (_, outcome, state) =
                    seen(&*chain, &Composition::pair(), (threads, stride), grid, before.clone());
                assert_eq!(outcome, Err(IntegrateError::Run(run)), "{threads} {stride}");
                assert_eq!(&state, last, "{threads} {stride}");
            }
        }
    }
    // In the middle of the steps that a tile takes at once.
    assert!(places.iter().any(|place| (2..7).contains(place)), "{places:?}");
}

#[test]
fn two_colours_are_for_chains_and_even_rings() {
    let (method, grid) = (Tiled::new(Composition::pair()), Grid::of(0.1, 1).unwrap());
    let ring = &*ring(7, 0.5, 0.3).members();
    let refused = integrate(&method, ring, grid, &mut start(7, 0.3), &mut ());
    assert!(
        matches!(refused, Err(IntegrateError::Input(InputError::Unsupported { .. }))),
        "{refused:?}"
    );
}

/// Masses, equal or not, on springs to the walls: H = Σ p_j²/(2 m_j) + q_j²/2, no friction.
#[derive(Clone)]
struct Masses<T>(Vec<T>);

impl<T: Scalar> System<T> for Masses<T> {
    fn dof(&self) -> usize {
        self.0.len()
    }
    fn energy(&self, q: &[T], p: &[T]) -> T {
        let each = |(j, (&q, &p)): (usize, (&T, &T))| (p * p / self.0[j] + q * q).half();
        q.iter().zip(p).enumerate().map(each).fold(T::zero(), |sum, h| sum + h)
    }
    fn gradient(&self, q: &[T], p: &[T], hq: &mut [T], hp: &mut [T]) {
        (0..q.len()).for_each(|j| (hq[j], hp[j]) = (q[j], p[j] / self.0[j]));
    }
    fn dissipation(&self, _q: &[T], _p: &[T], _v: &[T], d: &mut [T]) {
        d.fill(T::zero());
    }
    fn dissipation_form(&self) -> DissipationForm {
        DissipationForm::NONE
    }
    fn coupling(&self) -> Coupling {
        Coupling::Chain
    }
}

impl<T: Scalar> Separable<T> for Masses<T> {
    fn mass(&self, j: usize) -> T {
        self.0[j.min(self.0.len() - 1)]
    }
    fn partial(&self, _q: &[T], _j: usize, at: T) -> T {
        at
    }
    fn dissipation_of(&self, _q: &[T], _p: &[T], _j: usize) -> Dissipation<T> {
        Dissipation { value: T::zero(), by_q: T::zero(), by_p: T::zero() }
    }
}

impl Uniform for Masses<f64> {
    type Lanes = Masses<f64x8>;
    fn lanes(&self) -> Result<Masses<f64x8>, InputError> {
        Ok(Masses(self.0.iter().map(|&m| f64x8::from_f64(m)).collect()))
    }
}

#[test]
fn members_of_other_masses_are_refused() {
    let method = Tiled::new(Composition::pair());
    let (alike, other) = (Masses(vec![2.0; 5]), Masses(vec![2.0, 2.0, 3.0, 2.0, 2.0]));
    let workspace = |system: &AnyMembers| method.workspace(system).map(drop);
    assert_eq!(workspace(&alike), Ok(()));
    let refused = workspace(&other).unwrap_err();
    assert!(matches!(refused, InputError::Unsupported { method: "increment", .. }), "{refused}");
    assert!(refused.to_string().contains("mass"), "{refused}");
}

#[test]
fn no_members_are_nothing_to_do() {
    let mut state = State::new(vec![], vec![]).unwrap();
    let grid = Grid::of(0.1, 3).unwrap();
    let nobody: &AnyMembers = &Masses(vec![]);
    integrate(&Tiled::new(Composition::pair()), nobody, grid, &mut state, &mut ()).unwrap();
    assert_eq!(state.dof(), 0);
}

/// A node of a standing wave is at rest except for rounding, between forces that cancel.
#[test]
fn nodes_of_a_wave_are_no_obstacle() {
    for n in [64, 256, 1024] {
        for h in [0.1, 0.05, 0.025] {
            let chain = chain(n, 1.0, 0.01).members();
            let q = (1..=n).map(|j| (std::f64::consts::PI * j as f64 / 4.0).sin()).collect();
            let start = State::new(q, vec![0.0; n]).unwrap();
            let grid = Grid::of(h, 200).unwrap();
            let found = side_by_side(&*chain, &Composition::suzuki4(), 1, grid, start.clone());
            assert_eq!(found, one_at_a_time(&*chain, &Composition::suzuki4(), grid, start));
        }
    }
}
