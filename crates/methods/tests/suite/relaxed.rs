//! Runge-Kutta methods with relaxation: orders at the grid points, K, passivity, time, failures,
//! memory.

use crate::catalog::{As, Both, Built, chain, duffing, oscillator, pendulum, ring, written};
use crate::many;
use crate::many::orders::check_orders;
use afterbay_core::{
    DissipationForm, Grid, Method, Passive, Quad, State, StepFailure, System, integrate,
};
use afterbay_methods::registry::find;
use afterbay_methods::{Relaxed, Rk4};
use afterbay_systems::catalog::Expandable;
use afterbay_systems::{DampedDoublePendulum, Description, DissipationText};
use allocation_counter::measure;
use proptest::prelude::*;

const CHAIN: [&[f64]; 2] = [&[0.5, -0.3, 0.8], &[0.2, 0.7, -0.4]];
const PENDULUM: [&[f64]; 2] = [&[0.6, -0.4], &[0.3, 0.5]];

/// Every relaxed method, in the order of the registry.
const METHODS: [Relaxed; 3] = [Relaxed::rk4(), Relaxed::dop853(), Relaxed::verner98()];

/// Checks the order on a system for these numbers of steps.
fn orders<T: Both + Expandable>(
    system: &Built,
    name: &str,
    counts: [u64; 4],
    (order, tolerance): (f64, f64),
) {
    let run = system.bind::<T>(find(name).unwrap(), As::Curved).unwrap();
    check_orders(name, (&run, &*system.series()), CHAIN, (2.0, counts), (order, tolerance));
}

/// order_table.rs measures it on the chain and the double pendulum in 31 digits.
#[test]
fn order_four_at_the_grid_points() {
    let (counts, ring) = ([200, 250, 320, 400], ring(3, 0.75, 0.5));
    orders::<f64>(&chain(3, 0.5, 0.25), "relaxed-rk4", counts, (4.0, 0.1));
    orders::<f64>(&ring, "relaxed-rk4", counts, (4.0, 0.1));
    orders::<Quad>(&ring, "relaxed-rk4", [3000, 4000, 5000, 6000], (4.0, 0.05));
}

#[test]
fn order_eight_at_the_grid_points() {
    let ring = ring(3, 0.75, 0.5);
    orders::<f64>(&chain(3, 0.5, 0.25), "relaxed-dop853", [20, 24, 28, 34], (8.0, 0.1));
    orders::<f64>(&ring, "relaxed-dop853", [16, 20, 24, 28], (8.0, 0.1));
    orders::<Quad>(&ring, "relaxed-dop853", [1000, 1200, 1400, 1500], (8.0, 0.05));
}

/// In `f64` the error meets rounding before order 9 shows.
#[test]
fn order_nine_at_the_grid_points() {
    let counts = [240, 280, 320, 360];
    orders::<Quad>(&ring(3, 0.75, 0.5), "relaxed-verner98", counts, (9.0, 0.05));
}

fn swing(c: f64) -> Built {
    pendulum([1.0, 0.75], [1.0, 0.5], 3.0, [c, 0.25])
}

/// Takes steps with one workspace, each from the end of the last one.
fn steps(
    method: Relaxed,
    system: &dyn System<f64>,
    h: f64,
    state: &mut State<Vec<f64>>,
    count: u32,
) -> Result<(), StepFailure> {
    let mut workspace = method.workspace(system).unwrap();
    (0..count).try_for_each(|_| method.step(system, h, state, &mut workspace).map(drop))
}

/// |ΔK| in roundings of its terms at both ends.
fn drift(system: &dyn System<f64>, before: &State<Vec<f64>>, after: &State<Vec<f64>>) -> f64 {
    let scale = |state: &State<Vec<f64>>| {
        let n = state.dof();
        let (mut hq, mut hp) = (vec![0.0; n], vec![0.0; n]);
        system.gradient(&state.q, &state.p, &mut hq, &mut hp);
        let terms =
            |z: &[f64], slope: &[f64]| z.iter().zip(slope).map(|(a, b)| (a * b).abs()).sum::<f64>();
        state.energy(system).abs()
            + terms(&state.q, &hq)
            + terms(&state.p, &hp)
            + state.w.iter().map(|w| w.abs()).sum::<f64>()
    };
    let size = scale(before) + scale(after);
    (after.total(system) - before.total(system)).abs()
        / (f64::EPSILON / 2.0 * size + f64::MIN_POSITIVE)
}

/// Whether h is beyond the time scale of the system: one step of RK4 and two of half the size
/// differ by a hundredth, or K after the step is off by 1e-5 of the kinetic energy. In this case a
/// root near 1 need not exist.
fn beyond(system: &dyn System<f64>, h: f64, before: &State<Vec<f64>>) -> bool {
    let step = |h: f64, count: u32| {
        let mut state = before.clone();
        let mut workspace = Method::<Vec<f64>, dyn System<f64>>::workspace(&Rk4, system).unwrap();
        (0..count)
            .try_for_each(|_| Rk4.step(system, h, &mut state, &mut workspace).map(drop))
            .map(|()| state)
    };
    let (Ok(one), Ok(two)) = (step(h, 1), step(h / 2.0, 2)) else { return true };
    let (n, lost) = (before.dof(), (one.total(system) - before.total(system)).abs());
    let (mut hq, mut hp) = (vec![0.0; n], vec![0.0; n]);
    system.gradient(&before.q, &before.p, &mut hq, &mut hp);
    let kinetic: f64 = before.p.iter().zip(&hp).map(|(p, v)| (p * v).abs()).sum();
    if lost > 1e-5 * kinetic {
        return true;
    }
    let pairs = one.q.iter().zip(&two.q).chain(one.p.iter().zip(&two.p));
    let size = two.q.iter().chain(&two.p).fold(0.0, |most: f64, x| most.max(x.abs()));
    pairs.fold(0.0, |most: f64, (a, b)| most.max((a - b).abs())) > 1e-2 * size
}

/// Whether the advice of the failure holds: a step with h/2, h/4, .. or h/256 succeeds.
fn cured(method: &Relaxed, system: &dyn System<f64>, h: f64, before: &State<Vec<f64>>) -> bool {
    (1..=8).any(|k| {
        let mut state = before.clone();
        let mut workspace = Method::<Vec<f64>, dyn System<f64>>::workspace(method, system).unwrap();
        method.step(system, h * 0.5_f64.powi(k), &mut state, &mut workspace).is_ok()
    })
}

/// Whether no γ within ½ of 1 conserves K, however short the step. K is evaluated along the
/// direction of RK4 and shifted by the error of K of the failed step.
fn no_root(system: &dyn System<f64>, h: f64, before: &State<Vec<f64>>, excess: f64) -> bool {
    let mut after = before.clone();
    let mut workspace = Method::<Vec<f64>, dyn System<f64>>::workspace(&Rk4, system).unwrap();
    if Rk4.step(system, h, &mut after, &mut workspace).is_err() {
        return true;
    }
    let off = |gamma: f64| {
        let along =
            |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| gamma.mul_add(b - a, *a)).collect();
        let [q, p, w] = [(&before.q, &after.q), (&before.p, &after.p), (&before.w, &after.w)]
            .map(|(a, b): (&Vec<f64>, &Vec<f64>)| -> Vec<f64> { along(a, b) });
        State { q, p, w, t: 0.0 }.total(system) - after.total(system) + excess
    };
    // The direction is that of RK4, not of the method. If K is nearly tangent to its target, or γ
    // changes it by little more than its error, one of the two may have a root and the other none.
    let [below, above] = [off(0.99), off(1.01)].map(|x| x - excess);
    let (slope, bend) = ((above - below) / 0.02, (above + below) / 2e-4);
    let moved = [0.5, 1.5].map(|gamma| (off(gamma) - excess).abs());
    if slope * slope < 100.0 * (bend * excess).abs()
        || moved[0].max(moved[1]) < 100.0 * excess.abs()
    {
        return true;
    }
    let side = off(0.5);
    (1..=400).all(|i| off(0.5 + f64::from(i) / 400.0) * side > 0.0)
}

/// Checks that a few steps conserve K, that rk4 is passive, and that a failed step leaves the state
/// unchanged.
fn checked(system: &dyn System<f64>, h: f64, q: &[f64], p: &[f64]) -> Result<(), TestCaseError> {
    for (method, passive) in METHODS.into_iter().zip([true, false, false]) {
        let mut state = State::new(q.to_vec(), p.to_vec()).unwrap();
        let first = state.clone();
        let mut workspace = method.workspace(system).unwrap();
        for n in 1..=20 {
            let before = state.clone();
            match method.step(system, h, &mut state, &mut workspace) {
                Ok(_) => {
                    prop_assert!(state.check(q.len()).is_ok());
                    // The target is K of the first step, so twenty steps conserve K as well as one.
                    let off = drift(system, &first, &state);
                    prop_assert!(
                        off <= 16.0,
                        "{:?}: K is off by {} roundings after {}",
                        method,
                        off,
                        n
                    );
                    let violated = system.dissipation_form().passive.violated(&before.w, &state.w);
                    prop_assert!(!(passive && violated), "{:?} {:?}", before.w, state.w);
                }
                Err(failure) => {
                    let owed = match failure {
                        StepFailure::NoRelaxationRoot { excess } => {
                            // K may be nearly tangent to its target, and then a shorter step
                            // succeeds.
                            let shorter = h > 1e-2 && cured(&method, system, h, &before);
                            // The error of K may be a rounding of its terms, which no γ reduces.
                            let w: f64 = before.w.iter().map(|w| w.abs()).sum();
                            let size = before.energy(system).abs() + w;
                            excess.abs() <= 2e-14 * size
                                || no_root(system, h, &before, excess)
                                || shorter
                        }
                        StepFailure::NonFinite { .. } => beyond(system, h, &before),
                        _ => false,
                    };
                    prop_assert!(owed, "{:?}: {}", method, failure);
                    prop_assert_eq!(&before, &state);
                    break;
                }
            }
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    #[test]
    fn books_of_a_chain(
        h in (-6.0..0.5_f64).prop_map(|x| 10f64.powf(x)), beta in 0.0..2.0, c in -0.5..2.0,
        z in prop::array::uniform6(-2.0..2.0),
    ) {
        checked(&*chain(3, beta, c).curved(), h, &z[..3], &z[3..])?;
    }

    #[test]
    fn books_of_a_double_pendulum(
        h in (-6.0..0.5_f64).prop_map(|x| 10f64.powf(x)), c in 0.0..2.0,
        z in prop::array::uniform4(-2.0..2.0),
    ) {
        checked(&*swing(c).curved(), h, &z[..2], &z[2..])?;
    }
}

/// In the ninth step f·H''f passes through 0; in the seventeenth step of the other run K along the
/// step has its minimum at γ = 1.
#[test]
fn a_short_step_without_a_root() {
    let system = swing(0.855_653_685_212_379_1).curved();
    let z = [
        1.274_137_907_960_212_9,
        0.128_012_654_228_454_12,
        1.720_979_757_704_655,
        1.728_457_055_200_074_6,
    ];
    checked(&*system, 0.007_609_133_956_834_795, &z[..2], &z[2..]).unwrap();
    let system = swing(1.301_537_323_429_073_7).curved();
    let z = [
        0.713_529_853_804_126_1,
        -1.248_118_471_407_786,
        -1.262_484_081_435_130_8,
        -1.224_529_197_962_097,
    ];
    checked(&*system, 0.008_356_270_392_745_141, &z[..2], &z[2..]).unwrap();
}

/// K after 20,000 steps is that of the first.
#[test]
fn roundings_of_k_do_not_add_up() {
    let system: &dyn System<f64> = &*chain(3, 0.5, 0.25).curved();
    for method in METHODS {
        let mut state = many::start::<f64>(CHAIN);
        let first = state.clone();
        integrate(&method, system, Grid::of(0.1, 20_000).unwrap(), &mut state, &mut ()).unwrap();
        let off = drift(system, &first, &state);
        assert!(off < 8.0, "{off}");
    }
}

/// After the state is changed from outside, a step discards the lag and the target K, as with a new
/// workspace.
#[test]
fn a_state_changed_from_outside_is_a_new_beginning() {
    let system: &dyn System<f64> = &*chain(3, 0.5, 0.25).curved();
    let method = Relaxed::rk4();
    let mut state = many::start::<f64>(CHAIN);
    let mut workspace = method.workspace(system).unwrap();
    method.step(system, 0.1, &mut state, &mut workspace).unwrap();
    state.w[1] += 1.0;
    let mut fresh = state.clone();
    method.step(system, 0.1, &mut state, &mut workspace).unwrap();
    method.step(system, 0.1, &mut fresh, &mut method.workspace(system).unwrap()).unwrap();
    assert_eq!(state, fresh);
}

/// A fall from rest at q = 0, where all terms of K are 0 at the start of the step.
#[test]
fn a_step_may_begin_where_all_terms_are_zero() {
    let system = written(&Description {
        potential: "9.81*q1".to_owned(),
        dissipation: DissipationText::Forces(vec!["0.05*p1".to_owned()]),
        ..Description::default()
    });
    for method in METHODS {
        for h in [1.0, 0.1, 0.01] {
            let mut state = State::new(vec![0.0], vec![0.0]).unwrap();
            let before = state.clone();
            steps(method, &*system.curved(), h, &mut state, 3).unwrap();
            let off = drift(&*system.curved(), &before, &state);
            assert!(off < 8.0, "{method:?}, h = {h}: {off} roundings");
        }
    }
}

#[test]
fn beyond_stability_there_is_no_root() {
    let system = oscillator(1.0, 0.0).curved();
    for (method, h) in METHODS.into_iter().zip([4.0, 8.0, 8.0]) {
        let mut state = State::new(vec![1.0], vec![0.5]).unwrap();
        let before = state.clone();
        let failure = steps(method, &*system, h, &mut state, 1).unwrap_err();
        let StepFailure::NoRelaxationRoot { excess } = failure else { panic!("{failure}") };
        assert!(
            excess.abs() > 0.1 && failure.to_string().contains("another step size"),
            "{failure}"
        );
        assert_eq!(state, before);
    }
}

/// f·H''f passes through 0 twice per oscillation on the double well.
#[test]
fn flanks_of_a_double_well() {
    let system = duffing(-1.0, 1.0, 0.1).curved();
    for (method, h) in METHODS.into_iter().zip([0.05, 0.25, 0.25]) {
        let (mut failed, runs) = (0, 200);
        for i in 0..runs {
            let mut state = State::new(vec![1.5 + 0.002 * f64::from(i)], vec![0.5]).unwrap();
            failed += u32::from(steps(method, &*system, h, &mut state, (50.0 / h) as u32).is_err());
        }
        println!("{method:?} {h}: {failed} of {runs} runs meet no root");
        assert!(failed <= 1, "{failed}");
    }
}

/// A force that is NaN beyond q1 = 1.
struct Cliff;

impl System<f64> for Cliff {
    fn dof(&self) -> usize {
        2
    }
    fn energy(&self, _q: &[f64], p: &[f64]) -> f64 {
        (p[0] * p[0] + p[1] * p[1]) / 2.0
    }
    fn gradient(&self, q: &[f64], p: &[f64], hq: &mut [f64], hp: &mut [f64]) {
        hq[0] = if q[0] > 1.0 { f64::NAN } else { 0.0 };
        hq[1] = 0.0;
        hp.copy_from_slice(p);
    }
    fn dissipation(&self, _q: &[f64], _p: &[f64], v: &[f64], d: &mut [f64]) {
        (d[0], d[1]) = (0.1 * v[0], 0.1 * v[1]);
    }
    fn dissipation_form(&self) -> DissipationForm {
        DissipationForm { passive: Passive::Each, ..DissipationForm::LINEAR }
    }
}

#[test]
fn what_is_no_number_is_named() {
    for method in METHODS {
        let mut state = State::new(vec![0.5, 0.0], vec![1.0, 1.0]).unwrap();
        let before = state.clone();
        let failure = steps(method, &Cliff, 2.0, &mut state, 1).unwrap_err();
        assert!(matches!(failure, StepFailure::NonFinite { dof: 0, .. }), "{failure}");
        assert_eq!(state, before);
    }
}

/// Nor does the erasure of the type of the system.
#[test]
fn storage_does_not_matter_and_steps_allocate_nothing() {
    let system = DampedDoublePendulum::new([1.0, 0.75], [1.0, 0.5], 3.0, [0.125, 0.25]).unwrap();
    let erased: &dyn System<f64> = &system;
    for method in METHODS {
        let mut stack = State::new([0.6, -0.4], [0.3, 0.5]).unwrap();
        let mut heap = many::start::<f64>(PENDULUM);
        let (mut on_stack, mut on_heap) =
            (method.workspace(&system).unwrap(), method.workspace(erased).unwrap());
        let allocated = measure(|| {
            for _ in 0..50 {
                method.step(&system, 0.05, &mut stack, &mut on_stack).unwrap();
                method.step(erased, 0.05, &mut heap, &mut on_heap).unwrap();
            }
        });
        assert_eq!(allocated.count_total, 0);
        assert_eq!(
            (stack.q.to_vec(), stack.p.to_vec(), stack.w.to_vec()),
            (heap.q, heap.p, heap.w)
        );
    }
}
