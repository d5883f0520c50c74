//! The reference divides its steps at kinks of the force, and where they do not resolve the motion.

use crate::catalog::{Both, Built, written};
use afterbay_core::{IntegrateError, Quad, Scalar, State, StepFailure, f64x8};
use afterbay_methods::registry::{REFERENCE, bind};
use afterbay_systems::{Description, DissipationText};

fn in_potential(potential: &str) -> Built {
    written(&Description {
        potential: potential.into(),
        dissipation: DissipationText::Forces(vec!["0".into()]),
        ..Description::default()
    })
}

/// The end of some steps h from (q, p).
fn end<T: Both>(
    system: &Built,
    [q, p]: [f64; 2],
    h: f64,
    steps: u32,
) -> Result<[T; 2], IntegrateError> {
    let run = bind(&REFERENCE, system.abilities::<T>())?;
    let [q, p] = [q, p].map(|x| vec![T::from_f64(x)]);
    let mut state = State::new(q, p)?;
    for _ in 0..steps {
        run.step(T::from_f64(h), &mut state)?;
    }
    Ok([state.q[0], state.p[0]])
}

/// The end of one step from (0.3, -1) under the force -sign q, which takes q through 0.
fn exact<T: Scalar>(h: f64) -> [T; 2] {
    let number = T::from_f64;
    // p at q = 0, where p² = 1 + 2 q.
    let p = -(number(1.0) + number(2.0) * number(0.3)).sqrt();
    let left = number(h) + p + number(1.0);
    [p * left + (left * left).half(), p + left]
}

fn check_jump<T: Both>(most: f64) {
    let [q, p] = end::<T>(&in_potential("abs(q1)"), [0.3, -1.0], 1.0, 1).unwrap();
    let [q_exact, p_exact] = exact::<T>(1.0);
    let off = (q - q_exact).to_f64().abs().max((p - p_exact).to_f64().abs());
    assert!(off < most, "{off:e}");
}

#[test]
fn a_step_ends_where_the_force_jumps() {
    check_jump::<f64>(3e-13);
    check_jump::<Quad>(1e-28);
}

/// H is that of the start, to within its change by the truncation errors.
#[test]
fn h_is_kept_across_kinks_of_many_kinds() {
    for (potential, h, most) in [
        ("q1^2/2 + 10*max(q1 - 1, 0)^2", 0.02, 1e-12),
        ("q1^2/2 + 100*max(q1 - 1, 0)^2.5", 0.02, 1e-8),
        ("q1^2/2 + 10*max(q1 - 1, 0)^1.5", 0.02, 1e-7),
        ("q1^2/2 + 0.5*abs(q1)", 0.02, 1e-12),
        // Three kinks in a step.
        ("abs(q1 - 0.01) + abs(q1) + max(q1 + 0.01, 0)", 0.1, 1e-12),
        // It touches the kink of a hard spring.
        ("q1^2/2 + 50*max(q1 - 1.25, 0)^2", 0.02, 1e-12),
    ] {
        let system = in_potential(potential);
        let start = [0.75, 1.0];
        let [q, p] = end::<f64>(&system, start, h, 300).unwrap();
        let [before, after] = [start, [q, p]].map(|[q, p]| system.energy(&[q], &[p]));
        let off = (after - before).abs();
        assert!(off < most, "{potential}: {off:e}");
    }
}

#[test]
fn a_motion_that_comes_to_rest_on_a_kink_is_refused_by_name() {
    let system = in_potential("abs(q1)");
    assert_eq!(end::<f64>(&system, [0.0, 0.0], 0.1, 3).unwrap(), [0.0, 0.0]);
    let error = end::<f64>(&system, [0.0, 1e-9], 0.1, 1).unwrap_err();
    let IntegrateError::Run(error) = error else { panic!("{error}") };
    assert!(matches!(error.failure, StepFailure::PartsAccumulate { .. }), "{error}");
}

/// Motions that a step of 0.1 does not resolve, with their H at the end of 300 steps.
#[test]
fn fast_motions_divide_the_step() {
    for (potential, most) in [
        // The force turns around within 1e-5 of q = 0, which is passed 15 times.
        ("sqrt(q1^2 + 1e-10)", 1e-7),
        // The frequency is 300, and the motion takes 20,000 parts, each with an error below 1e-10.
        ("4.5e4*q1^2", 2e-6),
        // The force changes by 1 within 1e-3 of q = 0: each passage errs by less than 1e-7.
        ("q1^2/2 + 1e-3*ln(1 + exp(1e3*q1))", 1e-6),
    ] {
        let system = in_potential(potential);
        let start = [0.01, 0.5];
        let [q, p] = end::<f64>(&system, start, 0.1, 300).unwrap();
        let [before, after] = [start, [q, p]].map(|[q, p]| system.energy(&[q], &[p]));
        let off = (after - before).abs() / before;
        assert!(off < most, "{potential}: {off:e}");
    }
}

/// With D = 1e4 v, v decays at the rate 1e4, and then q at the rate 1e-4.
#[test]
fn stiff_friction_divides_the_step() {
    let system = written(&Description {
        potential: "(q1 - 2)^2/2".into(),
        dissipation: DissipationText::Forces(vec!["1e4*v1".into()]),
        ..Description::default()
    });
    let [q, p] = end::<f64>(&system, [1.0, 3.0], 0.1, 100).unwrap();
    let (fast, slow) = (-9999.9999, -1.00000001000000e-4);
    // q - 2 = a exp(slow t) + b exp(fast t)
    let (x, v) = (-1.0, 3.0);
    let a = (v - fast * x) / (slow - fast);
    let exact = a * (slow * 10.0_f64).exp();
    assert!((q - 2.0 - exact).abs() < 1e-9 && (p - slow * exact).abs() < 1e-9, "{q} {p}");
}

#[test]
fn a_motion_that_is_much_too_fast_is_refused_by_name() {
    let error = end::<f64>(&in_potential("1e14*q1^2"), [1.0, 0.0], 0.1, 1).unwrap_err();
    let IntegrateError::Run(error) = error else { panic!("{error}") };
    assert!(matches!(error.failure, StepFailure::PartsAccumulate { .. }), "{error}");
    // q reaches infinity before t = 3.
    let error = end::<f64>(&in_potential("-q1^4"), [1.0, 1.0], 1.0, 3).unwrap_err();
    let IntegrateError::Run(error) = error else { panic!("{error}") };
    assert!(matches!(error.failure, StepFailure::NonFinite { .. }), "{error}");
}

/// Each of eight motions divides its steps at its own kinks.
#[test]
fn eight_motions_side_by_side_end_where_each_does_alone() {
    for potential in ["q1^2/2", "abs(q1)", "q1^2/2 + 10*max(q1 - 1, 0)^2.5", "q1^4/4 + 1e5*q1^2"] {
        let system = in_potential(potential);
        let starts: [f64; 8] = std::array::from_fn(|lane| 0.2 + 0.11 * lane as f64);
        let run = bind(&REFERENCE, system.abilities::<f64x8>()).unwrap();
        let [q, p] = [f64x8::from_lanes(|lane| starts[lane]), f64x8::from_f64(-1.0)];
        let mut state = State::new(vec![q], vec![p]).unwrap();
        for _ in 0..5 {
            run.step(f64x8::from_f64(0.3), &mut state).unwrap();
        }
        for (lane, start) in starts.into_iter().enumerate() {
            let alone = end::<f64>(&system, [start, -1.0], 0.3, 5).unwrap();
            let together = [state.q[0].lane(lane), state.p[0].lane(lane)];
            assert_eq!(together, alone, "{potential}, lane {lane}");
        }
    }
}
