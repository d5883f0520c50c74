//! The reference across kinks of the force: it ends its steps there.

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
    assert!(matches!(error.failure, StepFailure::KinksAccumulate { .. }), "{error}");
}

#[test]
fn systems_with_kinks_are_not_taken_side_by_side() {
    for (potential, together) in [("q1^2/2", true), ("abs(q1)", false)] {
        let system = in_potential(potential).abilities::<f64x8>();
        assert_eq!(bind(&REFERENCE, system).is_ok(), together, "{potential}");
    }
}
