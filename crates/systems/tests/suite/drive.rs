//! Drives given as text, and systems under them.

use afterbay_core::{
    Abilities, Drive, Driven, Harmonic, Harmonics, InputError, Quad, Scalar, f64x8, validate,
};
use afterbay_systems::{
    Custom, CustomDrive, CustomError, CustomGeneral, Description, DissipationText,
    DriveDescription, GeneralDescription, Place, Problem,
};
use std::sync::Arc;

fn drive(forces: &[&str]) -> Result<(CustomDrive<f64>, Vec<String>), CustomError> {
    let parameters = [("f", 0.7), ("omega", 1.3)].map(|(name, x)| (name.to_owned(), x)).to_vec();
    let forces: Vec<String> = forces.iter().map(ToString::to_string).collect();
    let dof = forces.len();
    CustomDrive::new(&DriveDescription { forces, parameters, ..Default::default() }, dof)
}

fn pair() -> Arc<dyn Abilities<f64>> {
    let texts = |x: [&str; 2]| x.map(str::to_owned).to_vec();
    let description = Description {
        potential: "q1^2/2 + q2^4/4 + cos(q1 - q2)".into(),
        dissipation: DissipationText::Forces(texts(["0.3*v1*(1 + q2^2)", "0.1*v2^3"])),
        masses: texts(["1", "2"]),
        ..Default::default()
    };
    Arc::new(Custom::new(&description).unwrap())
}

const FORCES: [[&str; 2]; 4] = [
    ["f*cos(omega*t)", "0"],
    ["0", "f*sin(omega*t)*(1 + q1*q2^2)"],
    ["f*cos(omega*t) + 0.1*q2", "exp(-t)*q1"],
    ["f", "omega*t^2"],
];

#[test]
fn a_driven_system_is_a_system() {
    for forces in FORCES {
        let (drive, _) = drive(&forces).unwrap();
        let motors = Drive::<f64>::driven(&drive).len();
        assert_eq!(motors, forces.iter().filter(|force| **force != "0").count());
        let driven = Driven::<_, dyn Drive<f64>>::new(pair(), Arc::new(drive) as _).unwrap();
        let with = |part: [f64; 2], of: f64| {
            part.into_iter().chain(std::iter::repeat_n(of, motors)).collect::<Vec<_>>()
        };
        let (q, p) = (with([0.6, -0.8], 0.4), with([0.5, 1.1], 0.2));
        assert_eq!(validate::drive(&**driven.drive(), &q[..2], 0.4), Ok(()), "{forces:?}");
        assert_eq!(validate::system(&driven, &q, &p), Ok(()), "{forces:?}");
        let driven = Arc::new(driven);
        let separable = driven.clone().separable().unwrap();
        assert_eq!(validate::separable(&*separable, &q, &p), Ok(()), "{forces:?}");
        let curved = driven.second_derivatives().unwrap();
        assert_eq!(validate::curvature(&*curved, &q, &p), Ok(()), "{forces:?}");
    }
}

#[test]
fn a_driven_system_of_any_h_without_friction_is_a_system() {
    let hamiltonian = "p1^2/2 + p2^2/(2 + q1^2) + q2^2/2".into();
    let system = CustomGeneral::new(&GeneralDescription { hamiltonian, ..Default::default() });
    let (drive, _) = drive(&FORCES[2]).unwrap();
    let driven =
        Driven::<_, dyn Drive<f64>>::new(Arc::new(system.unwrap()), Arc::new(drive) as _).unwrap();
    let (q, p) = ([0.6, -0.8, 0.4, 0.4], [0.5, 1.1, 0.2, 0.2]);
    assert_eq!(validate::system(&driven, &q, &p), Ok(()));
}

fn with_period(force: &str, period: Option<&str>) -> Result<CustomDrive<f64>, CustomError> {
    let parameters = vec![("omega".to_owned(), 1.3)];
    let (forces, period) = (vec![force.to_owned()], period.map(str::to_owned));
    let description = DriveDescription { forces, parameters, period, ..Default::default() };
    CustomDrive::new(&description, 1).map(|found| found.0)
}

#[test]
fn the_period_is_found_or_given() {
    let one = std::f64::consts::TAU / 1.3;
    for (force, period) in [
        ("cos(omega*t)", Some(one)),
        ("q1^2*sin(omega*t + q1) + cos(3*omega*t)", Some(one)),
        ("sqrt(abs(cos(omega*t/2)))", Some(one)),
        ("exp(-cos(t*omega)^2)", Some(one / 2.0)),
        ("2*cos(omega*t/2)^2 - 1", Some(one)),
        ("sin(omega*t)*cos(omega*t)", Some(one / 2.0)),
        ("sin(omega*t)*cos(2*omega*t)", Some(one)),
        ("sin(omega*t)*cos(3*omega*t)", Some(one / 2.0)),
        ("1/cos(omega*t)^3", Some(one)),
        ("tanh(sin(omega*t))*sin(3*omega*t)", Some(one / 2.0)),
        ("(1 + cos(omega*t))^2", Some(one)),
        ("exp(cos(omega*t))*sin(omega*t)", Some(one)),
        ("(cos(omega*t) + cos(3*omega*t))^2", Some(one / 2.0)),
        ("(cos(omega*t) + cos(2*omega*t))^2", Some(one)),
        ("sign(cos(omega*t))*q1", Some(one)),
        ("mod(t, 0.7) - 0.35", Some(0.7)),
        ("mod(t, 0.7)*mod(t, 2.1)", Some(2.1)),
        ("mod(t, 0.7) + cos(omega*t)", None),
        ("floor(t)", None),
        ("omega*t*cos(omega*t)", None),
        ("cos(omega*t^2)", None),
        ("cos(omega*t) + cos(sqrt(2)*t)", None),
        ("cos(2*omega*t) + sin(3*omega*t)", Some(one)),
        ("cos(2*omega*t)*sin(3*omega*t)", Some(one)),
        ("cos(3*omega*t)*sin(5*omega*t)", Some(one / 2.0)),
        ("omega", None),
        ("q1*exp(-t*omega)", None),
    ] {
        let found = with_period(force, None).unwrap().period();
        let same = match (found, period) {
            (Some(found), Some(period)) => (found / period - 1.0).abs() < 1e-14,
            (found, period) => found == period,
        };
        assert!(same, "{force}: {found:?} instead of {period:?}");
    }
    let given = with_period("cos(2*omega*t) + sin(3*omega*t)", Some("2*pi/omega")).unwrap();
    assert_eq!(given.period(), Some(one));
    let other = given.with("omega", 2.6, 1).unwrap();
    assert!((other.period().unwrap() / one - 0.5).abs() < 1e-14);
    assert_eq!(with_period("omega", Some("3")).unwrap().period(), Some(3.0));
}

#[test]
fn a_number_that_is_no_period_is_refused() {
    for period in ["1", "pi/omega", "4*pi/omega + 1e-6"] {
        let refused = with_period("cos(omega*t)", Some(period)).unwrap_err();
        assert!(matches!(refused, CustomError::NoPeriod { dof: 0, .. }), "{period}: {refused}");
    }
    for period in ["0", "-2*pi/omega"] {
        let refused = with_period("cos(omega*t)", Some(period)).unwrap_err();
        assert!(matches!(refused, CustomError::PeriodRange { .. }), "{period}: {refused}");
    }
    let refused = with_period("cos(omega*t)", Some("2*pi/t")).unwrap_err();
    assert!(matches!(refused, CustomError::Expression { place: Place::Period, .. }), "{refused}");
    // 2π/1.3 is no period with another omega.
    let fixed = with_period("cos(omega*t)", Some("2*pi/1.3")).unwrap();
    assert!(matches!(fixed.with("omega", 1.4, 1), Err(CustomError::NoPeriod { .. })));
}

#[test]
fn a_drive_beyond_the_last_degree_of_freedom_is_refused() {
    let (drive, _) = drive(&["0", "0", "f*t"]).unwrap();
    assert!(Driven::<_, dyn Drive<f64>>::new(pair(), Arc::new(drive) as _).is_err());
}

/// The instants in (0, end) at which steps end.
fn breaks(force: &str, end: f64) -> Vec<f64> {
    let (drive, _) = drive(&[&format!("{force} + 0*f*omega")]).unwrap();
    let (mut t, mut found) = (0.0, Vec::new());
    while t < end {
        let h = Drive::<f64>::step_between_breaks(&drive, t, (0.3_f64).min(end - t));
        assert!(h > 0.0, "{force}: a step of {h:e} at {t}");
        if h < 1e-12 {
            // The force on both sides is that of the pieces.
            found.push(t + h / 2.0);
        }
        t += h;
    }
    found
}

/// At t = 0 steps of any length have an end, also where the roundings of t vanish.
#[test]
fn the_shortest_steps_at_a_kink_have_an_end() {
    let (drive, _) = drive(&["sqrt(abs(sin(t))) + 0*f*omega"]).unwrap();
    for h in [1e-300, 1e-310, f64::from_bits(1)] {
        let step = Drive::<f64>::step_between_breaks(&drive, 0.0, h);
        assert!(0.0 < step && step <= h, "{h:e}: {step:e}");
    }
}

#[test]
fn kinks_of_the_time_are_not_those_of_the_state() {
    for (force, expected) in
        [("sign(t - 1.25)", [1, 0]), ("abs(q1 - t)", [1, 1]), ("cos(t)", [0; 2])]
    {
        let (drive, _) = drive(&[&format!("{force} + 0*f*omega")]).unwrap();
        let (mut all, mut of_state) = (0, 0);
        Drive::<f64>::kinks(&drive, &[0.3], 0.2, &mut |_| all += 1);
        Drive::<f64>::kinks_of_state(&drive, &[0.3], 0.2, &mut |_| of_state += 1);
        assert_eq!([all, of_state], expected, "{force}");
    }
}

#[test]
fn steps_end_where_a_force_jumps_or_has_a_kink_in_time() {
    use std::f64::consts::{FRAC_PI_2, PI};
    for (force, expected) in [
        ("sign(t - 1.25)", vec![1.25]),
        ("sign(cos(2*t))", vec![PI / 4.0, 0.75 * PI, 1.25 * PI]),
        ("abs(sin(t))*q1", vec![0.0, PI]),
        ("floor(2*t)", (0..9).map(|k| f64::from(k) / 2.0).collect()),
        ("mod(t - 0.1, 1.5)", vec![0.1, 1.6, 3.1]),
        ("max(0, cos(t))", vec![FRAC_PI_2]),
        ("mod(floor(t), 2)", (0..5).map(f64::from).collect()),
        ("abs(sign(t - 1.25) + 1)", vec![1.25]),
        ("cos(t)", vec![]),
        ("abs(q1 - t)", vec![]),
        // It touches 0 and does not change its sign.
        ("sign((t - 1.25)^2)", vec![1.25]),
    ] {
        let found = breaks(force, 4.3);
        assert_eq!(found.len(), expected.len(), "{force}: {found:?}");
        for (found, expected) in found.iter().zip(expected) {
            let width = if force.contains(")^2)") { 1e-7 } else { 1e-13 };
            assert!((found - expected).abs() < width, "{force}: {found}, not {expected}");
        }
    }
    // A sign whose argument is lost in rounding does not stop a run.
    assert!(breaks("sign(sin(1e300*t))", 4.3).len() < 100);
    let (drive, _) = drive(&["sign(t - 2)*f*omega"]).unwrap();
    let lanes = drive.lift(|_, x| f64x8::splat(x));
    let times = f64x8::new([0.0, 1.0, 1.5, 1.7, 1.9, 1.95, 2.5, 3.0]);
    let step = lanes.step_between_breaks(times, f64x8::splat(0.2));
    let expected = [0.2, 0.2, 0.2, 0.2, 0.1, 0.05, 0.2, 0.2];
    for (step, expected) in step.to_array().into_iter().zip(expected) {
        assert!((step - expected).abs() < 1e-14, "{step}, not {expected}");
    }
}

#[test]
fn no_step_crosses_a_singular_force() {
    let singular = |force: &str, from: f64, to: f64| {
        let (drive, _) = drive(&[&format!("{force} + 0*f*omega")]).unwrap();
        drive.is_singular_between(from, to)
    };
    assert!(singular("1/(t - 5)", 4.9, 5.1) && singular("q1/(t - 5)^2", 5.1, 4.9));
    assert!(singular("tan(t)", 1.5, 1.6) && singular("log(t - 2)", 1.9, 2.1));
    assert!(!singular("1/(t - 5)", 5.1, 5.2) && !singular("1/(1 + sin(t)^2)", 0.0, 9.0));
    assert!(!singular("1/(q1 - t)", 0.0, 9.0) && !singular("cos(t)/f", 0.0, 9.0));
}

#[test]
fn only_a_force_may_jump_and_only_in_time() {
    for text in ["sign(q1)", "floor(q1 + t)", "mod(t, q1)", "sign()", "mod(t)", "sign(t, 1)"] {
        let refused = drive(&[&format!("{text} + f*omega")]).unwrap_err();
        assert!(matches!(refused, CustomError::Expression { .. }), "{text}: {refused}");
    }
    let description = |potential: &str, friction: &str| Description {
        potential: potential.into(),
        dissipation: DissipationText::Forces(vec![friction.into()]),
        ..Default::default()
    };
    let jumps = |found: Result<Custom<f64>, CustomError>| match found.unwrap_err() {
        CustomError::Expression { problem, .. } => matches!(problem, Problem::Jumps { .. }),
        _ => false,
    };
    assert!(jumps(Custom::new(&description("q1^2*sign(t)", "0"))));
    assert!(jumps(Custom::new(&description("q1^2", "sign(p1)"))));
    assert!(jumps(Custom::new(&description("q1^2", "mod(t, 1)*p1"))));
    // Of numbers alone they are numbers.
    assert!(Custom::new(&description("floor(2.5)*q1^2/2", "mod(7, 3)*p1")).is_ok());
}

#[test]
fn a_second_drive_is_refused() {
    let [first, second] = [0, 1].map(|_| drive(&["f*cos(omega*t)", "0"]).unwrap().0);
    let driven =
        Driven::<dyn Abilities<f64>, dyn Drive<f64>>::new(pair(), Arc::new(first)).unwrap();
    let twice = Driven::<_, dyn Drive<f64>>::new(Arc::new(driven), Arc::new(second) as _);
    assert!(matches!(twice.err(), Some(InputError::Unsupported { .. })));
}

#[test]
fn what_is_no_force_is_refused() {
    let (_, unused) = drive(&["cos(omega*t)"]).unwrap();
    assert_eq!(unused, ["f"]);
    for text in ["p1", "v1", "x", "t(", "q2", ""] {
        match drive(&[text]) {
            Err(CustomError::Expression { place: Place::Force(0), .. }) => {}
            other => panic!("{text}: {other:?}"),
        }
    }
    assert!(matches!(drive(&["1/(f - 0.7)"]), Err(CustomError::NotFinite { .. })));
    let (drive, _) = drive(&["f/(t - 2)"]).unwrap();
    assert!(drive.check_at(&[0.0], 1.0).is_ok() && drive.check_at(&[0.0], 2.0).is_err());
    // The cube overflows, and the force is 0.
    let (drive, _) = self::drive(&["f*(q1 + t)^-3"]).unwrap();
    assert!(drive.check_at(&[0.0], 1e90).is_ok() && drive.check_at(&[0.0], 1e110).is_err());
}

/// The sums of sines and cosines that these forces are, [c, [ω, a, b], ..], with f = 0.7 and ω =
/// 1.3.
#[test]
fn sums_of_sines_and_cosines_are_found() {
    let (f, omega) = (0.7, 1.3);
    let wave = |frequency, cosine, sine| Harmonic { frequency, cosine, sine };
    let of = |constant, terms: &[Harmonic<f64>]| Harmonics { constant, terms: terms.to_vec() };
    let (sin, cos) = 0.4_f64.sin_cos();
    for (force, exact) in [
        ("f", of(f, &[])),
        ("f*cos(omega*t)", of(0.0, &[wave(omega, f, 0.0)])),
        ("2 - f*sin(t)/omega", of(2.0, &[wave(1.0, 0.0, -f / omega)])),
        ("f*cos(omega*t - 0.4)", of(0.0, &[wave(omega, f * cos, f * sin)])),
        ("-sin((0.4*omega - t*omega^2)/omega)", of(0.0, &[wave(omega, -sin, cos)])),
        ("cos(t) + f*sin(t) + sin(omega*t)", of(0.0, &[wave(1.0, 1.0, f), wave(omega, 0.0, 1.0)])),
        ("cos((f - 0.7)*t)", of(1.0, &[])),
        ("cos(t)^2", of(0.5, &[wave(2.0, 0.5, 0.0)])),
        ("sin(t)*sin(3*t)", of(0.0, &[wave(2.0, 0.5, 0.0), wave(4.0, -0.5, 0.0)])),
        ("cos(3*t)*sin(2*t)", of(0.0, &[wave(1.0, 0.0, -0.5), wave(5.0, 0.0, 0.5)])),
        (
            "(1 + f*cos(t/8))*sin(t)",
            of(0.0, &[wave(1.0, 0.0, 1.0), wave(0.875, 0.0, f / 2.0), wave(1.125, 0.0, f / 2.0)]),
        ),
    ] {
        let (drive, _) = drive(&[force]).unwrap();
        let found = Drive::<f64>::harmonics(&drive, 0).expect(force);
        let mut rest = found.clone();
        assert!((found.constant - exact.constant).abs() < 1e-15, "{force}: {found:?}");
        for term in exact.terms {
            let near = |other: &Harmonic<f64>| {
                let pairs = [
                    (other.frequency, term.frequency),
                    (other.cosine, term.cosine),
                    (other.sine, term.sine),
                ];
                pairs.iter().all(|(a, b)| (a - b).abs() < 1e-15)
            };
            let place = rest.terms.iter().position(near);
            rest.terms.remove(place.unwrap_or_else(|| panic!("{force}: {found:?}")));
        }
        assert!(rest.terms.is_empty(), "{force}: {found:?}");
        let in_quad = drive.lift(|_, x| Quad::from_f64(x));
        let found = Drive::<Quad>::harmonics(&in_quad, 0).unwrap();
        for t in [-1.1, 0.0, 0.6, 9.0].map(Quad::from_f64) {
            let off = (found.at(t) - in_quad.force(0, &[Quad::ZERO], t)).to_f64().abs();
            assert!(off < 1e-29, "{force} at {t:?}: {off:e}");
        }
    }
}

/// Waves have a form of their own, which the same force inside a larger one has not.
#[test]
fn waves_have_the_value_of_their_program() {
    for wave in [
        "cos(t)",
        "-f*cos(omega*t)",
        "sin(omega*t)*f/2",
        "f*cos(omega*t + 0.4)",
        "f*sin(0.4 - t*omega)",
        "-(f + 1)*cos(t*omega^2 - 0.4)",
        "f*sin(t + 0.4)",
    ] {
        let (alone, _) = drive(&[wave]).unwrap();
        let (within, _) = drive(&[&format!("q1 + {wave}")]).unwrap();
        let [alone, within] = [alone, within].map(|drive| drive.lift(|_, x| Quad::from_f64(x)));
        for t in [-7.3, 0.0, 0.6, 1e3].map(Quad::from_f64) {
            let [a, b] = [&alone, &within].map(|drive| drive.force(0, &[Quad::ZERO], t));
            assert!((a - b).to_f64().abs() < 1e-27, "{wave} at {t:?}: {a:?} {b:?}");
        }
    }
}

#[test]
fn other_forces_are_no_sums_of_sines_and_cosines() {
    for force in [
        "t",
        "t*cos(t)",
        "cos(t) + q1",
        "q1*cos(t)",
        "cos(q1)",
        "cos(t + q1)",
        "cos(t^2)",
        "cos(cos(t))",
        "cos(1/t)",
        "1/(2 + cos(t))",
        "exp(-t)*cos(t)",
        "abs(cos(t))",
        "tan(t)",
        "cos(t)^300",
    ] {
        let (drive, _) = drive(&[force]).unwrap();
        assert_eq!(Drive::<f64>::harmonics(&drive, 0), None, "{force}");
    }
}

#[test]
fn a_driven_system_gives_its_parts() {
    let (drive, _) = drive(&["f*cos(omega*t)", "0"]).unwrap();
    let driven: Driven<_, dyn Drive<f64>> = Driven::new(pair(), Arc::new(drive) as _).unwrap();
    let system: Arc<dyn Abilities<f64>> = Arc::new(driven);
    let driven = system.driven().unwrap();
    assert_eq!((driven.undriven().dof(), driven.drive().driven()), (2, &[0][..]));
    assert!(driven.undriven().driven().is_none());
}

#[test]
fn only_a_pole_in_time_makes_a_force_singular() {
    for (force, singular) in
        [("f*cos(omega*t)", false), ("sin(t)/omega", false), ("f/(t - 2)", true)]
    {
        let (drive, _) = drive(&[force]).unwrap();
        assert_eq!(Drive::<f64>::may_be_singular(&drive), singular, "{force}");
    }
}
