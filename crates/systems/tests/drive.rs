//! Drives given as text, and systems under them.

#![cfg(test)]

use afterbay_core::{Abilities, Drive, Driven, validate};
use afterbay_systems::{
    Custom, CustomDrive, CustomError, Description, DissipationText, DriveDescription, Place,
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
        assert_eq!(validate::system(&driven, &q, &p), Ok(()), "{forces:?}");
        let curved = Arc::new(driven).second_derivatives().unwrap();
        assert_eq!(validate::curvature(&*curved, &q, &p), Ok(()), "{forces:?}");
    }
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
        ("sqrt(abs(cos(omega*t/2)))", Some(2.0 * one)),
        ("exp(-cos(t*omega)^2)", Some(one)),
        ("omega*t*cos(omega*t)", None),
        ("cos(omega*t^2)", None),
        ("cos(omega*t) + cos(sqrt(2)*t)", None),
        ("cos(2*omega*t) + sin(3*omega*t)", None),
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
}
