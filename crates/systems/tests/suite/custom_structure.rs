//! The properties of a custom system that follow from the form of its expressions.

use afterbay_core::{Coupling, DissipationForm, Passive, System, f64x8};
use afterbay_systems::{Custom, Description, DissipationText};

fn texts(x: &[&str]) -> Vec<String> {
    x.iter().map(|&x| x.to_owned()).collect()
}

fn system(potential: &str, friction: DissipationText, parameters: &[(&str, f64)]) -> Custom<f64> {
    let parameters = parameters.iter().map(|&(name, value)| (name.to_owned(), value)).collect();
    let description = Description {
        potential: potential.to_owned(),
        dissipation: friction,
        masses: Vec::new(),
        parameters,
        ..Description::default()
    };
    Custom::new(&description).unwrap_or_else(|error| panic!("{potential}: {error}"))
}

#[test]
fn degrees_and_linearity() {
    for (potential, degree, degrees, linear) in [
        ("q1^2/2", Some(2), vec![Some(2)], true),
        ("q1^2/2 + 3", Some(2), vec![Some(2)], true),
        ("(q1 - 2*q2)^2", Some(2), vec![Some(2), Some(2)], true),
        ("q1*q2", Some(2), vec![Some(1), Some(1)], true),
        ("sin(2)*q1^2*exp(pi)", Some(2), vec![Some(2)], true),
        ("q1^2/2 + q1", Some(2), vec![Some(2)], true),
        ("q1", Some(1), vec![Some(1)], true),
        ("abs(q1)", None, vec![None], false),
        ("q1^2 + sqrt(q1^2)", None, vec![None], false),
        ("q1^4/4 - q1*q1", Some(4), vec![Some(4)], false),
        ("q1^2/2 + q2^2/2 + q1^2*q2 - q2^3/3", Some(3), vec![Some(2), Some(3)], false),
        ("(q1^2 + q2)^3", Some(6), vec![Some(6), Some(3)], false),
        ("q1^2*cos(q2)", None, vec![Some(2), None], false),
        ("cos(q1)", None, vec![None], false),
        ("1/q1", None, vec![None], false),
        ("q1^2/(q2 + 3)", None, vec![Some(2), None], false),
        ("q1^2.5", None, vec![None], false),
        ("0*q2 + q1^2 + q2 - q2", Some(2), vec![Some(2), Some(0)], true),
    ] {
        let n = degrees.len();
        let friction = DissipationText::Forces((1..=n).map(|j| format!("0.5*p{j}")).collect());
        let structure = system(potential, friction, &[]).structure().clone();
        assert_eq!(
            (structure.degree, structure.degrees, structure.linear),
            (degree, degrees, linear),
            "{potential}"
        );
    }
}

#[test]
fn who_acts_on_whom() {
    let bonds = |pairs: &[(usize, usize)]| {
        let bond = |(i, j): &(usize, usize)| format!("(q{i} - q{j})^4");
        pairs.iter().map(bond).collect::<Vec<_>>().join(" + ")
    };
    for (potential, expected) in [
        (bonds(&[(1, 2), (2, 3), (3, 4)]), Coupling::Chain),
        (bonds(&[(1, 2), (2, 3), (3, 4), (4, 1)]), Coupling::Ring),
        (bonds(&[(1, 2), (2, 3), (3, 1)]), Coupling::Ring),
        (bonds(&[(1, 2), (2, 3), (3, 4), (4, 2)]), Coupling::Dense),
        ("q1^2 + q2^2 + q3^2".to_owned(), Coupling::Chain),
        ("sin(q1)*cos(q2) + 0*q1*q3 + q1*q3 - q3*q1 + q3".to_owned(), Coupling::Chain),
        ("q1*q2".to_owned(), Coupling::Chain),
    ] {
        assert_eq!(
            system(&potential, DissipationText::None, &[]).coupling(),
            expected,
            "{potential}"
        );
    }
    // D counts too.
    for (forces, expected) in [
        (["p1", "p2*q1^2", "p3"], Coupling::Chain),
        (["p1*q3^2", "p2", "p3"], Coupling::Ring),
        (["p1", "p2", "p3 - p1"], Coupling::Ring),
    ] {
        assert_eq!(
            system("q1^2 + q2^2 + q3^2", DissipationText::Forces(texts(&forces)), &[]).coupling(),
            expected
        );
    }
}

const EACH: DissipationForm =
    DissipationForm { zero: false, passive: Passive::Each, linear: true, coupled: false };

#[test]
fn friction() {
    let active = DissipationForm { passive: Passive::No, ..EACH };
    let curved = DissipationForm { linear: false, ..EACH };
    let in_sum = DissipationForm { passive: Passive::InSum, coupled: true, ..EACH };
    let coupled = DissipationForm { passive: Passive::No, coupled: true, ..EACH };
    for (forces, expected) in [
        (["0", "0"], DissipationForm::NONE),
        (["c*p1", "2*c*p2"], EACH),
        (["z*p1", "z*p2"], DissipationForm::NONE),
        (["z*p1", "p2"], EACH),
        (["-d*p1", "p2"], EACH),
        (["d*p1", "p2"], active),
        (["d^2*q1^2*p1", "p2*exp(q1 + q2)"], EACH),
        (["p1*(1 + q1^2)/(2 + abs(q2)*sqrt(q1))", "0"], EACH),
        (["-c*(1 - q1^2)*p1", "p2"], active),
        (["p1*q1^3", "p2"], active),
        (["c*abs(p1)*p1", "p2"], curved),
        (["p1^3", "tanh(c*p2)"], curved),
        (["p1^2", "p2"], DissipationForm { passive: Passive::No, linear: false, ..EACH }),
        (["p1 + 1", "p2"], DissipationForm { passive: Passive::No, linear: false, ..EACH }),
        (["c*(p1 - p2)", "c*(p2 - p1)"], in_sum),
        (["2*p1 + p2", "p1 + p2"], in_sum),
        // Only the symmetric part exerts power.
        (["p1 - 5*p2", "5*p1 + p2"], in_sum),
        (["p1 + 2*p2", "2*p1 + p2"], coupled),
        (["q1^2*(p1 - p2)", "q1^2*(p2 - p1)"], coupled),
        (["p1*p2^2", "p2"], DissipationForm { linear: false, coupled: true, ..EACH }),
    ] {
        let all = [("c", 0.3), ("d", -0.5), ("z", 0.0)];
        let parameters: Vec<_> =
            all.into_iter().filter(|(name, _)| forces.iter().any(|x| x.contains(name))).collect();
        // exp has no c and no d, but a p.
        let parameters: Vec<_> =
            parameters.into_iter().filter(|x| x.0 != "d" || forces[0].contains('d')).collect();
        let found = system("q1^2 + q2^2", DissipationText::Forces(texts(&forces)), &parameters)
            .dissipation_form();
        assert_eq!(found, expected, "{forces:?}");
    }
}

/// The matrix with 1 on the diagonal and a beside it is positive semidefinite for |a| ≤ 1.
#[test]
fn friction_is_passive_in_sum_if_it_is_in_every_lane() {
    let forces = DissipationText::Forces(texts(&["p1 + a*p2", "a*p1 + p2"]));
    let custom = system("q1^2 + q2^2", forces, &[("a", 0.5)]);
    let passive = |a: [f64; 8]| custom.lift(|_, _| f64x8::from(a)).dissipation_form().passive;
    let inside = [0.5, -0.5, 0.0, 0.9, -0.9, 0.1, 0.2, 0.3];
    assert_eq!(passive(inside), Passive::InSum);
    for lane in 0..8 {
        let with = |a: f64| std::array::from_fn(|k| if k == lane { a } else { inside[k] });
        // A pivot of 0 in one lane alone.
        assert_eq!(passive(with(1.0)), Passive::InSum, "lane {lane}");
        assert_eq!(passive(with(1.1)), Passive::No, "lane {lane}");
    }
}

/// The answer is the same in all units of q1, in which the entries differ by many magnitudes.
#[test]
fn friction_is_passive_in_sum_in_any_units() {
    let forces = DissipationText::Forces(texts(&["a*v1 + c*v2 + g*v3", "c*v1 + v2", "v3 - g*v1"]));
    for unit in [1e-150_f64, 1e-15, 1.0, 1e12, 1e150] {
        let passive = |a: f64, c: f64| {
            let parameters = [("a", a * unit * unit), ("c", c * unit), ("g", 0.3 * unit)];
            system("q1^2 + q2^2 + q3^2", forces.clone(), &parameters).dissipation_form().passive
        };
        for (a, c) in [(2.0, 1.0), (1.0, 1.0), (1.0, -1.0), (0.0, 0.0)] {
            assert_eq!(passive(a, c), Passive::InSum, "a = {a}, c = {c} in units {unit:e}");
        }
        for (a, c) in [(1.0, 1.001), (0.0, 1e-3), (-1e-3, 0.0), (-1e-17, 0.0)] {
            assert_eq!(passive(a, c), Passive::No, "a = {a}, c = {c} in units {unit:e}");
        }
    }
}

#[test]
fn a_friction_matrix() {
    for (rows, masses, expected) in [
        ([["2", "0"], ["0", "q1^2"]], ["1", "3"], EACH),
        (
            [["1", "-1"], ["-1", "1"]],
            ["1", "3"],
            DissipationForm { passive: Passive::InSum, coupled: true, ..EACH },
        ),
        (
            [["1", "-1"], ["-1", "0.9"]],
            ["1", "3"],
            DissipationForm { passive: Passive::No, coupled: true, ..EACH },
        ),
        ([["0", "0"], ["0", "0"]], ["1", "3"], DissipationForm::NONE),
        (
            [["0", "1"], ["1", "5"]],
            ["1", "3"],
            DissipationForm { passive: Passive::No, coupled: true, ..EACH },
        ),
        ([["p1^2", "0"], ["0", "1"]], ["1", "3"], DissipationForm { linear: false, ..EACH }),
    ] {
        let friction = DissipationText::Matrix(rows.iter().map(|row| texts(row)).collect());
        let potential = "q1^2 + q2^2".to_owned();
        let description = Description {
            potential,
            dissipation: friction,
            masses: texts(&masses),
            parameters: Vec::new(),
            ..Description::default()
        };
        assert_eq!(Custom::new(&description).unwrap().dissipation_form(), expected, "{rows:?}");
    }
}

/// D is computed from the velocity given, whichever way it is said.
#[test]
fn friction_follows_the_velocity() {
    let make = |friction| {
        let masses = texts(&["2", "3"]);
        Custom::new(&Description {
            potential: "q1*q2".to_owned(),
            dissipation: friction,
            masses,
            parameters: Vec::new(),
            ..Description::default()
        })
        .unwrap()
    };
    let forces = make(DissipationText::Forces(texts(&["4*p1", "p2*abs(p2)*q1"])));
    let mut d = [0.0; 2];
    forces.dissipation(&[5.0, 0.0], &[f64::NAN; 2], &[0.5, -2.0], &mut d);
    assert_eq!(d, [4.0, -180.0]);
    let rows = vec![texts(&["4", "q2"]), texts(&["q2", "p1^2"])];
    make(DissipationText::Matrix(rows)).dissipation(&[5.0, 7.0], &[3.0, 0.0], &[0.5, -2.0], &mut d);
    assert_eq!(d, [-12.0, -14.5]);
}

#[test]
fn parameters_change_without_compiling_and_lanes_may_differ() {
    let friction = || DissipationText::Forces(texts(&["c*p1"]));
    let custom = system("k*q1^2/2", friction(), &[("k", 2.0), ("c", 0.5)]);
    assert_eq!(custom.dissipation_form(), EACH);
    let active = custom.with("c", -0.5).unwrap();
    assert_eq!(active.dissipation_form().passive, Passive::No);
    assert_eq!(custom.with("c", 0.0).unwrap().dissipation_form(), DissipationForm::NONE);
    assert_eq!(active.parameters().collect::<Vec<_>>(), [("k", 2.0), ("c", -0.5)]);
    assert_eq!(active.energy(&[3.0], &[1.0]), 9.5);
    assert_eq!(custom.with("b", 1.0).unwrap_err().to_string(), "there is no parameter b");
    assert_eq!(
        custom.with("c", f64::NAN).unwrap_err().to_string(),
        "parameter c = NaN must be finite"
    );

    let ramp = f64x8::new([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
    let lanes = custom.map(f64x8::from).with("k", ramp).unwrap();
    let energies = lanes.energy(&[f64x8::from(2.0)], &[f64x8::from(0.0)]).to_array();
    assert_eq!(energies, [0.0, 2.0, 4.0, 6.0, 8.0, 10.0, 12.0, 14.0]);
    // One lane that feeds is enough to make it active.
    let mixed = lanes.with("c", ramp - f64x8::from(1.0)).unwrap();
    assert_eq!(mixed.dissipation_form().passive, Passive::No);
    assert_eq!(lanes.with("c", ramp).unwrap().dissipation_form(), EACH);
}

/// The periods of the coordinates of V with the forces D_j.
fn periods(potential: &str, forces: &[&str]) -> Vec<Option<f64>> {
    let description = Description {
        potential: potential.to_owned(),
        dissipation: if forces.is_empty() {
            DissipationText::None
        } else {
            DissipationText::Forces(forces.iter().map(|&force| force.to_owned()).collect())
        },
        parameters: vec![("k".to_owned(), 3.0)],
        ..Default::default()
    };
    Custom::new(&description).unwrap_or_else(|error| panic!("{potential}: {error}")).periods()
}

#[test]
fn a_coordinate_in_sines_of_one_frequency_recurs() {
    let full = std::f64::consts::TAU;
    for (potential, forces, expected) in [
        ("k*(1 - cos(q1))", &[][..], vec![Some(full)]),
        ("-cos(k*q1 + 1)", &[], vec![Some(full / 3.0)]),
        ("k*cos(q1/2)^2 + abs(sin(q1))*exp(sin(q1))", &[], vec![Some(full)]),
        ("k*sin(q1/2)^2 + cos(3*q1)*cos(q1)", &[], vec![Some(full)]),
        ("k*sin(2*q1) - cos(6*q1) + tan(4*q1)", &[], vec![Some(full / 2.0)]),
        ("k*cos(q1 - q2) + cos(2*q2)", &[], vec![Some(full), Some(full)]),
        ("k*cos(q1 - q2) + q2^2", &[], vec![Some(full), None]),
        ("cos(q1) + cos(k*q2)", &["p1", "sin(q2)^2*p2"], vec![Some(full), Some(full)]),
        ("cos(q1)", &["k*q1^2*p1"], vec![None]),
        ("cos(q1) + k*cos(sqrt(2)*q1)", &[], vec![None]),
        // A constant torque.
        ("cos(q1) + k*q1", &[], vec![Some(full)]),
        ("k*(q1 - sin(3*q1)) - 2*q1 + cos(2*q1)/k", &[], vec![Some(full)]),
        ("k*q1 + q2", &["sin(q1)*v1", "sin(q1 - 2*q2)*v2"], vec![Some(full), Some(full / 2.0)]),
        ("k*q2*(q1 + cos(q1))", &[], vec![None, None]),
        ("cos(q1) - k*q1 + q1*q2", &[], vec![None, None]),
        ("k/(q1 + 2*cos(q1)) + sin(q1)", &[], vec![None]),
        ("cos(q1) + k*exp(q1 + sin(q1))", &[], vec![None]),
        ("cos(q1)", &["k*(q1 + sin(q1))"], vec![None]),
        ("cos(q1*q2) + k", &[], vec![None, None]),
        ("cos(q1^2) + k", &[], vec![None]),
        ("k*q1^2", &[], vec![None]),
    ] {
        let found = periods(potential, forces);
        let same = found.iter().zip(&expected).all(|pair| match pair {
            (Some(found), Some(expected)) => (found - expected).abs() < 1e-12 * expected,
            (found, expected) => found.is_none() && expected.is_none(),
        });
        assert!(found.len() == expected.len() && same, "{potential}: {found:?}, not {expected:?}");
    }
}
