//! Coordinate increments without a separable H, on random states and steps: K is kept to rounding,
//! reservoirs of a passive system only fill, and a separable system moves as under `Increment`.

use crate::increment_general::{pendulum, state, step};
use crate::planes::{BySlopes, Curved};
use crate::systems::Springs;
use afterbay_core::{Method, PhasePlane, Separable, State};
use afterbay_methods::{Composition, GeneralIncrement, Increment};
use proptest::prelude::*;

/// Bounds of the terms of ∂H/∂q, of ∂H/∂p and of H for |q| and |p| up to the given numbers.
type Sizes = fn([f64; 2], [f64; 2]) -> [f64; 3];

/// The change of K in a step, in roundings of its terms.
///
/// With residuals a in q and b in p, ΔK = a ∂H/∂q + b ∂H/∂p plus the roundings of H and w. Rounding
/// contributes to a that of q and of h ∂H/∂p, to b that of p and of h (∂H/∂q + D).
fn drift(
    system: &dyn PhasePlane<f64>,
    h: f64,
    [before, after]: [&State<Vec<f64>>; 2],
    sizes: Sizes,
) -> f64 {
    let most = |a: &[f64], b: &[f64]| [0, 1].map(|j| a[j].abs().max(b[j].abs()));
    let (q, p) = (most(&before.q, &after.q), most(&before.p, &after.p));
    let [hq, hp, held] = sizes(q, p);
    let scale = 2.0 * held
        + (q[0] + q[1]) * hq
        + (p[0] + p[1]) * hp
        + 2.0 * h.abs() * hq * hp
        + before.w.iter().chain(&after.w).map(|w| w.abs()).sum::<f64>();
    (after.total(system) - before.total(system)).abs()
        / (f64::EPSILON / 2.0 * scale + f64::MIN_POSITIVE)
}

/// The pendulum without its own edges.
fn by_slopes(c: [f64; 2]) -> BySlopes<f64> {
    BySlopes(pendulum(c).planes())
}

/// Bounds for the pendulum with friction up to 1: T ≤ |p1|² + |p2|², since M⁻¹ ≤ 2/(3 - √5) < 3 at
/// unit masses and lengths.
fn pendulum_sizes(_q: [f64; 2], [p1, p2]: [f64; 2]) -> [f64; 3] {
    let v = 3.0 * (p1 + p2);
    [2.0 * 9.81 + v * v + v, v, 6.0 * 9.81 + v * (p1 + p2)]
}

fn curved_sizes([q1, q2]: [f64; 2], [p1, p2]: [f64; 2]) -> [f64; 3] {
    let (r, mass) = (q1 + q2, 1.0 + q1 * q1 / 4.0);
    let hp = mass * p1 + p2 + 0.3 * q1;
    let hq = q1 * p1 * p1 + p2 + 2.0 * r * r + r + r.powi(3) + (1.0 + r * r) * hp;
    [hq, hp, hp * (p1 + p2) + r.powi(3) + r.powi(4) + r * r]
}

/// Takes steps of h and checks K after each sweep.
fn checked(
    system: &dyn PhasePlane<f64>,
    h: f64,
    start: &State<Vec<f64>>,
    sizes: Sizes,
) -> Result<(), TestCaseError> {
    // Even sweeps are forward, odd ones their adjoint; a sweep of length zero changes nothing.
    let sweeps =
        [(vec![1.0], 1.0), (vec![0.0, 1.0], 1.0), (vec![1.0], -0.6), (vec![0.0, 1.0], -0.6)];
    let mut state = start.clone();
    for (sweep, share) in sweeps {
        let before = state.clone();
        let method = GeneralIncrement::new(Composition::alternating(&sweep).unwrap());
        match step(&method, system, share * h, &mut state) {
            Ok(()) => {
                let drift = drift(system, share * h, [&before, &state], sizes);
                prop_assert!(drift < 4.0, "{sweep:?} {share}: K moves by {drift} roundings");
            }
            Err(failure) => {
                prop_assert_eq!(&before, &state, "{}", failure);
                // Short steps may not fail.
                prop_assert!(h > 0.02, "{}", failure);
            }
        }
    }
    Ok(())
}

/// Long edges on which a bisection happens to leave the tail of the quadrature unchanged once.
/// Taken for noise, this would change K by up to 12 roundings.
#[test]
fn a_tail_that_stays_once_is_not_taken_for_noise() {
    for (exponent, c, q, p) in [
        (
            0.9080899293176734,
            [0.6911849030115295, 0.8677431497391442],
            [-2.0439688873343536, 1.8646774175002339],
            [-1.0722538536017365, -0.2860306182443118],
        ),
        (
            0.6732832572789627,
            [0.0; 2],
            [-1.9280548849028833, 0.9011071125735185],
            [1.318445893379253, -2.1607340095748917],
        ),
        (
            0.8438695026767383,
            [-0.456301660097413, -0.298085766659344],
            [-0.5611051976183734, -0.09668491270681569],
            [-2.1543785206313384, 1.1857164733115009],
        ),
    ] {
        let h = 10.0_f64.powf(exponent);
        checked(&by_slopes(c), h, &state(q, p), pendulum_sizes).unwrap();
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::with_cases(1000)
    })]

    #[test]
    fn k_is_kept_by_the_pendulum(
        exponent in -6.0..1.0_f64, c in prop::array::uniform2(-0.5..1.0),
        q in prop::array::uniform2(-3.2..3.2), p in prop::array::uniform2(-4.0..4.0),
    ) {
        checked(&*pendulum(c).planes(), 10.0_f64.powf(exponent), &state(q, p), pendulum_sizes)?;
    }

    #[test]
    fn k_is_kept_by_quadrature_of_a_polynomial(
        exponent in -6.0..1.0_f64, c in prop::array::uniform2(-0.5..1.0),
        q in prop::array::uniform2(-2.0..2.0), p in prop::array::uniform2(-2.0..2.0),
    ) {
        checked(&Curved(c), 10.0_f64.powf(exponent), &state(q, p), curved_sizes)?;
    }

    #[test]
    fn every_reservoir_only_fills_where_the_system_is_passive(
        exponent in -6.0..1.0_f64, c in prop::array::uniform2(0.0..1.0),
        q in prop::array::uniform2(-2.0..2.0), p in prop::array::uniform2(-2.0..2.0),
    ) {
        let h = 10.0_f64.powf(exponent);
        for composition in [Composition::sweep(), Composition::pair()] {
            let method = GeneralIncrement::new(composition);
            let (mut swing, mut curve) = (state(q, p), state(q, p));
            let _ = step(&method, &*pendulum(c).planes(), h, &mut swing);
            let _ = step(&method, &Curved(c), h, &mut curve);
            let filled = swing.w.iter().chain(&curve.w).all(|&w| w >= 0.0);
            prop_assert!(filled, "{:?} {:?}", swing.w, curve.w);
        }
    }

    /// The same equations under another solver.
    #[test]
    fn a_separable_system_goes_where_increment_takes_it(
        exponent in -5.0..0.0_f64, c in -0.3..1.0, kind in 0..3,
        (q, p) in (1_usize..12).prop_flat_map(|n| {
            (prop::collection::vec(-1.5..1.5, n), prop::collection::vec(-1.5..1.5, n))
        }),
    ) {
        let (n, h) = (q.len(), 10.0_f64.powf(exponent));
        let system = match kind {
            0 => Springs::chain(n, c),
            1 if n > 2 => Springs::ring(n, c),
            _ => Springs::dense(n, c),
        };
        for composition in [Composition::sweep(), Composition::pair(), Composition::suzuki4()] {
            let start = State::new(q.clone(), p.clone()).unwrap();
            let (mut one, mut other) = (start.clone(), start);
            let separable = Increment::new(composition.clone());
            let by_force: &dyn Separable<f64> = &system;
            let mut workspace = separable.workspace(by_force).unwrap();
            separable.step(by_force, h, &mut one, &mut workspace).unwrap();
            step(&GeneralIncrement::new(composition), &system, h, &mut other).unwrap();
            let parts = [(&one.q, &other.q), (&one.p, &other.p), (&one.w, &other.w)];
            for (a, b) in parts.into_iter().flat_map(|(one, other)| one.iter().zip(other)) {
                prop_assert!((a - b).abs() < 1e-13, "{a} {b}");
            }
        }
    }
}

proptest! {
    // Long edges are split many times.
    #![proptest_config(ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::with_cases(250)
    })]

    #[test]
    fn k_is_kept_by_quadrature_of_the_pendulum(
        exponent in -6.0..1.0_f64, c in prop::array::uniform2(-0.5..1.0),
        q in prop::array::uniform2(-3.2..3.2), p in prop::array::uniform2(-4.0..4.0),
    ) {
        checked(&by_slopes(c), 10.0_f64.powf(exponent), &state(q, p), pendulum_sizes)?;
    }
}

/// Quadrature of a trigonometric H conserves K on long edges too, which are split.
#[test]
fn k_is_kept_on_long_edges_by_slopes_alone() {
    let drift = |h: f64| {
        let system = by_slopes([0.1, 0.2]);
        let method = GeneralIncrement::new(Composition::pair());
        let mut state = state([1.2, -0.7], [6.0, 5.0]);
        let before = state.total(&system);
        step(&method, &system, h, &mut state).map(|()| (state.total(&system) - before).abs())
    };
    for h in [0.02, 0.05, 0.3, 1.0] {
        let found = drift(h).unwrap();
        assert!(found < 1e-12, "h = {h}: {found:e}");
    }
}
