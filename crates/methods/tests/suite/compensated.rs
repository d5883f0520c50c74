//! Compensated increments: K over long runs, agreement with the method in higher precision, lanes,
//! storage, memory and refusals.

use crate::bind::{AnySeparable, after};
use crate::catalog::{self, Built};
use crate::rubbed::Rubbed;
use afterbay_core::{
    Corrected, Grid, InputError, IntegrateError, Method, Quad, Quantity, Scalar, Separable, State,
    StepFailure, Vector, f64x8, integrate,
};
use afterbay_methods::registry::{compensated, find};
use afterbay_methods::{Composition, Increment};
use afterbay_systems::FputChain;
use nalgebra::{DVector, SVector};
use proptest::prelude::*;
use std::ops::ControlFlow;
use std::sync::Arc;

pub(crate) const N: usize = 8;

pub(crate) fn chain(c: f64) -> Built {
    catalog::chain(N, 1.0, c)
}

/// A chain at rest, displaced by a sine.
pub(crate) fn sine() -> State<Vec<f64>> {
    let sine = |j: usize| (std::f64::consts::PI * (j + 1) as f64 / (N + 1) as f64).sin();
    State::new((0..N).map(sine).collect(), vec![0.0; N]).unwrap()
}

/// A system in the numbers of compensation, with its type erased.
pub(crate) type Exact = Arc<dyn Separable<Corrected<f64>>>;

pub(crate) fn pair() -> Increment {
    Increment::new(Composition::pair())
}

fn lift(state: &State<Vec<f64>>) -> State<Vec<Quad>> {
    let lift = |part: &[f64]| part.iter().map(|&x| Quad::from_f64(x)).collect();
    State { q: lift(&state.q), p: lift(&state.p), w: lift(&state.w), t: Quad::from_f64(state.t) }
}

/// The change of K in `f64` due to the rounding of each entry of the state, plus a share of the
/// terms of K for the steps themselves, whose relative error is 1e-31.
fn roundings(exact: &dyn Separable<Quad>, state: &State<Vec<Quad>>) -> f64 {
    let n = state.q.len();
    let [mut hq, mut hp] = [0; 2].map(|_| vec![Quad::ZERO; n]);
    exact.gradient(&state.q, &state.p, &mut hq, &mut hp);
    let products = |x: &[Quad], y: &[Quad]| {
        x.iter().zip(y).map(|(&x, &y)| (x * y).to_f64().abs()).sum::<f64>()
    };
    let w = state.w.iter().map(|w| w.to_f64().abs()).sum::<f64>();
    let all = products(&state.q, &hq) + products(&state.p, &hp) + w;
    f64::EPSILON / 2.0 * all
        + 1e-24 * (all + exact.energy(&state.q, &state.p).to_f64().abs())
        + f64::MIN_POSITIVE
}

/// The largest deviation of K over a run, in roundings of the current state, and the relative
/// deviation at the end.
fn deviation<A: Method<Vec<f64>, AnySeparable<f64>>>(
    method: &A,
    system: &AnySeparable<f64>,
    exact: &dyn Separable<Quad>,
    start: &State<Vec<f64>>,
    h: f64,
) -> [f64; 2] {
    let before = lift(start).total(exact);
    let (grid, mut found) = (Grid::of(h, 100_000).unwrap(), [0.0_f64; 2]);
    let mut look = |step: u64, state: &State<Vec<f64>>| {
        if step.is_multiple_of(997) || step == grid.steps {
            let lifted = lift(state);
            let off = (lifted.total(exact) - before).to_f64();
            found = [found[0].max(off.abs() / roundings(exact, &lifted)), off / before.to_f64()];
        }
        ControlFlow::Continue(())
    };
    integrate(method, system, grid, &mut start.clone(), &mut look).unwrap();
    found
}

/// The deviations of a pair of sweeps without compensation, and with it.
fn deviations(
    system: &AnySeparable<f64>,
    exact: &dyn Separable<Quad>,
    corrected: Exact,
    start: &State<Vec<f64>>,
    h: f64,
) -> [[f64; 2]; 2] {
    let compensated = pair().compensated(corrected);
    [deviation(&pair(), system, exact, start, h), deviation(&compensated, system, exact, start, h)]
}

fn of_built(system: &Built, start: &State<Vec<f64>>, h: f64) -> [[f64; 2]; 2] {
    deviations(&*system.separable(), &*system.separable(), system.corrected(), start, h)
}

#[test]
fn k_does_not_drift_from_a_rounding() {
    // Friction so weak that the chain still moves at the end, at t = 2e4; and no friction.
    for c in [0.0, 1e-5] {
        let [[plain, _], [most, end]] = of_built(&chain(c), &sine(), 0.2);
        println!(
            "c = {c}: {most:.2} roundings, {end:.1e} of K at the end; without {plain:.0} roundings"
        );
        assert!(most <= 1.0, "{c}: {most} roundings");
        assert!(plain > 20.0, "{c}: {plain} roundings");
    }
}

#[test]
fn k_does_not_drift_on_a_limit_cycle() {
    let start = State::new(vec![2.0], vec![0.0]).unwrap();
    let [[plain, _], [most, _]] = of_built(&catalog::van_der_pol(1.0), &start, 0.1);
    println!("{most:.2} roundings, without {plain:.0}");
    assert!(most <= 1.0 && plain > 20.0, "{most} and {plain} roundings");
}

#[test]
fn friction_that_couples_momenta_is_compensated_too() {
    let start = State::new(vec![0.8, -0.3, 0.5], vec![0.2, 0.9, -0.7]).unwrap();
    let system = Rubbed { c: 1e-5 };
    let [[plain, _], [most, _]] = deviations(&system, &system, Arc::new(system), &start, 0.2);
    println!("{most:.2} roundings, without {plain:.0}");
    // Without compensation the rounding errors accumulate, but only like √t. When they contained
    // the rounding of the slope of friction, the drift was 2e5.
    assert!(most <= 1.0 && (20.0..5e3).contains(&plain), "{most} and {plain} roundings");
}

/// The difference between a run in `f64` and the same run in `Quad`, in roundings of the largest
/// entry of each part.
fn away(state: &State<Vec<f64>>, exact: &State<Vec<Quad>>) -> f64 {
    let parts = [(&state.q, &exact.q), (&state.p, &exact.p), (&state.w, &exact.w)];
    let of = |(found, exact): (&Vec<f64>, &Vec<Quad>)| {
        let pairs = || found.iter().zip(exact);
        let off =
            pairs().map(|(&a, &b)| (Quad::from_f64(a) - b).to_f64().abs()).fold(0.0, f64::max);
        let size = pairs().map(|(a, _)| a.abs()).fold(f64::MIN_POSITIVE, f64::max);
        off / (f64::EPSILON / 2.0 * size)
    };
    parts.map(of).into_iter().fold(0.0, f64::max)
}

/// Checks that the compensated run is the run in `Quad`, rounded. The run without compensation
/// agrees to 1e-13 and is less accurate.
fn check_against_quad(
    system: &dyn Separable<f64>,
    exact: &dyn Separable<Quad>,
    corrected: &Exact,
    start: &State<Vec<f64>>,
    label: &str,
) {
    let n = system.dof();
    for composition in [
        Composition::sweep(),
        Composition::pair(),
        Composition::suzuki4(),
        Composition::kahan_li8(),
    ] {
        for order in [(0..n).collect(), system.coupling().coloured(n)] {
            let method = Increment::new(composition.clone()).in_order(order);
            let (mut plain, mut found, mut reference) = (start.clone(), start.clone(), lift(start));
            for (h, steps) in [(0.1, 100), (0.07, 50)] {
                let exact_h = Quad::from_f64(h);
                integrate(&method, exact, Grid { h: exact_h, steps }, &mut reference, &mut ())
                    .unwrap();
                integrate(&method, system, Grid { h, steps }, &mut plain, &mut ()).unwrap();
            }
            let compensated = method.compensated(corrected.clone());
            let mut workspace = compensated.workspace(system).unwrap();
            // The carried remainders survive a change of the step size.
            for h in [0.1; 100].into_iter().chain([0.07; 50]) {
                compensated.step(system, h, &mut found, &mut workspace).unwrap();
            }
            let (off, without) = (away(&found, &reference), away(&plain, &reference));
            println!("{label} {:2} sweeps: {off:.3}, without {without:.0}", composition.sweeps());
            assert!(off <= 1.001, "{label} {composition:?}: {off} roundings from Quad");
            assert!(
                (4.0..1e4).contains(&without),
                "{label} {composition:?}: {without} roundings without"
            );
        }
    }
}

#[test]
fn a_run_is_that_in_quad_rounded() {
    let wave: Vec<f64> = (0..N).map(|j| (0.7 * j as f64).sin()).collect();
    let start = State::new(wave.clone(), wave.iter().rev().copied().collect()).unwrap();
    for (system, label) in
        [(chain(0.0), "chain"), (chain(0.3), "chain"), (catalog::ring(N, 0.8, 0.6), "ring")]
    {
        let (plain, exact) = (system.separable(), system.separable());
        check_against_quad(&*plain, &*exact, &system.corrected(), &start, label);
    }
    let three = State::new(vec![0.8, -0.3, 0.5], vec![0.2, 0.9, -0.7]).unwrap();
    let rubbed = Rubbed { c: 0.3 };
    let corrected: Exact = Arc::new(rubbed);
    check_against_quad(&rubbed, &rubbed, &corrected, &three, "rubbed");
}

pub(crate) fn bits<V: Vector<Scalar = f64>>(state: &State<V>) -> Vec<u64> {
    [&state.q, &state.p, &state.w]
        .iter()
        .flat_map(|part| part.as_slice())
        .map(|x| x.to_bits())
        .collect()
}

fn carried_by<V, S, P>(system: &S, exact: P, q: V, p: V) -> Vec<u64>
where
    V: Vector<Scalar = f64>,
    S: Separable<f64> + ?Sized,
    P: Separable<Corrected<f64>>,
{
    let mut state = State::new(q, p).unwrap();
    let method = Increment::new(Composition::suzuki4()).compensated(exact);
    integrate(&method, system, Grid::of(0.1, 200).unwrap(), &mut state, &mut ()).unwrap();
    bits(&state)
}

/// Eight chains side by side, each equal to the bit to a chain alone.
#[test]
fn lanes_change_no_bit() {
    let row = find("increment-2").unwrap();
    let start = |k: usize, j: usize| (1.0 + k as f64 / 16.0) * sine().q[j];
    let q = (0..N).map(|j| f64x8::new(std::array::from_fn(|k| start(k, j)))).collect();
    let together = State::new(q, vec![f64x8::splat(0.0); N]).unwrap();
    let run = compensated(row, chain(0.1).abilities(), chain(0.1).corrected()).unwrap();
    let together = after(&run, Grid { h: f64x8::splat(0.2), steps: 2000 }, &together);
    let run = compensated::<f64>(row, chain(0.1).abilities(), chain(0.1).corrected()).unwrap();
    for k in 0..8 {
        let alone = State::new((0..N).map(|j| start(k, j)).collect(), vec![0.0; N]).unwrap();
        let alone = after(&run, Grid::of(0.2, 2000).unwrap(), &alone);
        let parts = [&together.q, &together.p, &together.w];
        let found = parts.into_iter().flatten().map(|x| x.to_array()[k].to_bits());
        assert_eq!(found.collect::<Vec<_>>(), bits(&alone), "lane {k}");
    }
}

/// Nor does the erasure of the type of the system.
#[test]
fn storage_changes_no_bit() {
    let (q, p) = ([0.8, -0.3, 0.5], [0.2, 0.9, -0.7]);
    let check = |array: Vec<u64>, system: &dyn Separable<f64>, exact: Exact| {
        assert_eq!(array, carried_by(system, exact.clone(), q.to_vec(), p.to_vec()));
        let vector = |x: [f64; 3]| SVector::from(x);
        assert_eq!(array, carried_by(system, exact.clone(), vector(q), vector(p)));
        let vector = |x: [f64; 3]| DVector::from_row_slice(&x);
        assert_eq!(array, carried_by(system, exact, vector(q), vector(p)));
    };
    let (system, rubbed) = (FputChain::new(3, 1.0, 0.1).unwrap(), Rubbed { c: 0.3 });
    let corrected = system.map(Corrected::from);
    check(carried_by(&system, corrected, q, p), &system, Arc::new(corrected));
    check(carried_by(&rubbed, rubbed, q, p), &rubbed, Arc::new(rubbed));
}

#[test]
fn a_step_allocates_nothing() {
    fn check(system: &dyn Separable<f64>, exact: Exact) {
        let n = system.dof();
        let mut state = State::new(vec![0.3; n], vec![0.1; n]).unwrap();
        let method = Increment::new(Composition::kahan_li8()).compensated(exact);
        let mut workspace = method.workspace(system).unwrap();
        let steps = allocation_counter::measure(|| {
            for _ in 0..10 {
                method.step(system, 0.1, &mut state, &mut workspace).unwrap();
            }
        });
        assert_eq!(steps.count_total, 0);
    }
    let system = catalog::chain(40, 1.0, 0.1);
    check(&*system.separable(), system.corrected());
    check(&Rubbed { c: 0.3 }, Arc::new(Rubbed { c: 0.3 }));
}

#[test]
fn another_system_is_refused() {
    let system = &*chain(0.1).separable::<f64>();
    let try_with = |exact: Built| {
        let (method, mut state) = (pair().compensated(exact.corrected()), sine());
        let outcome = integrate(&method, system, Grid::of(0.1, 3).unwrap(), &mut state, &mut ());
        assert!(outcome.is_ok() || bits(&state) == bits(&sine()));
        outcome
    };
    assert!(try_with(chain(0.1)).is_ok());
    let longer = catalog::chain(N + 1, 1.0, 0.1);
    let length = InputError::Length { quantity: Quantity::Coordinate, expected: N, found: N + 1 };
    assert_eq!(try_with(longer), Err(length.into()));
    for damping in [0.0, -0.1] {
        let found = try_with(chain(damping));
        assert!(
            matches!(found, Err(IntegrateError::Input(InputError::Unsupported { .. }))),
            "{found:?}"
        );
    }
    // A difference that cannot be detected beforehand is detected in the first step.
    for other in [catalog::chain(N, 1.001, 0.1), chain(0.1001)] {
        let Err(IntegrateError::Run(error)) = try_with(other) else { panic!("it is not refused") };
        assert!(
            matches!(error.failure, StepFailure::NewtonStalled { .. }) && error.step <= 2,
            "{error}"
        );
    }
    let double = Increment::new(Composition::pair())
        .in_order(vec![0; N])
        .compensated(chain(0.1).corrected());
    assert!(Method::<Vec<f64>, _>::workspace(&double, system).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// After a few steps of any length, K is off only by the rounding of the state, and Δw ≥ 0
    /// where friction is passive.
    #[test]
    fn k_is_kept_to_a_rounding_of_the_state(
        q in prop::collection::vec(-3.0..3.0_f64, 1..10),
        seed in -2.0..2.0_f64,
        beta in -1.0..2.0_f64,
        c in -0.5..1.0_f64,
        log_h in -4.0..1.0_f64,
    ) {
        let p = q.iter().map(|q| seed * (7.0 * q).sin()).collect();
        let chain = catalog::chain(q.len(), beta, c);
        let (system, exact) = (&*chain.separable::<f64>(), &*chain.separable());
        let mut state = State::new(q, p).unwrap();
        let before = lift(&state).total(exact);
        let method = pair().compensated(chain.corrected());
        let mut workspace = method.workspace(system).unwrap();
        for _ in 0..5 {
            let last = state.clone();
            if method.step(system, 10f64.powf(log_h), &mut state, &mut workspace).is_err() {
                prop_assert_eq!(bits(&state), bits(&last));
                break;
            }
            let lifted = lift(&state);
            let off = (lifted.total(exact) - before).to_f64().abs() / roundings(exact, &lifted);
            prop_assert!(off <= 1.0 + 1e-6, "{} roundings", off);
            prop_assert!(c < 0.0 || state.w.iter().zip(&last.w).all(|(new, old)| new >= old));
        }
    }
}
