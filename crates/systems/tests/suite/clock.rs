//! Systems given as text whose V and D depend on the time.

use afterbay_core::{Abilities, Clocked, Passive, System, validate};
use afterbay_expression::Problem;
use afterbay_systems::{
    Custom, CustomError, CustomGeneral, Described, Description, DissipationText,
    GeneralDescription, Place,
};
use std::sync::Arc;

fn description(potential: &str, forces: &[&str]) -> Description {
    Description {
        potential: potential.into(),
        dissipation: match forces {
            [] => DissipationText::None,
            forces => DissipationText::Forces(forces.iter().map(ToString::to_string).collect()),
        },
        ..Default::default()
    }
}

fn clocked(description: &Description) -> Clocked<Custom<f64>> {
    match Described::separable(description).unwrap() {
        Described::Clocked(system) => system,
        other => panic!("{other:?}"),
    }
}

/// V and D of two degrees of freedom, with t in V, in D, in both, and without friction.
const SYSTEMS: [(&str, &[&str]); 5] = [
    ("(1 + sin(t)/2)*q1^2 + q2^4/4 + cos(q1 - q2 - t)", &["0.3*v1*(1 + q2^2)", "v2^3/10"]),
    ("q1^2 + q2^4/4 + q1*q2", &["(2 + cos(t))*v1", "exp(-t)*v2"]),
    ("exp(-t)*(q1^2 + q2^2)", &["(1 + t^2)*v1", "v2"]),
    ("q1^2 + q2^2 + 0.1*q1*t", &[]),
    ("sqrt(1 + q1^2 + t^2) + q2^2/2", &["abs(t)*v1", "v2"]),
];

#[test]
fn a_system_with_a_clock_is_a_system() {
    for (potential, forces) in SYSTEMS {
        let system = clocked(&description(potential, forces));
        assert_eq!((System::<f64>::dof(&system), System::<f64>::motors(&system)), (3, 1));
        let (q, p) = ([0.6, -0.8, 0.4], [0.5, 1.1, -0.2]);
        assert_eq!(validate::system(&system, &q, &p), Ok(()), "{potential}");
        let separable = Arc::new(system.clone()).separable().unwrap();
        for (j, to) in [(0, 1.7), (1, -0.3), (2, 2.4)] {
            let mut end = q;
            end[j] = to;
            let rise = separable.energy(&end, &[0.0; 3]) - separable.energy(&q, &[0.0; 3]);
            let found = separable.divided_difference(&q, j, to).value * (to - q[j]);
            assert!((found - rise).abs() < 1e-14, "{potential} by {j}: {found}, not {rise}");
        }
        let curved = Arc::new(system).second_derivatives().unwrap();
        assert_eq!(validate::curvature(&*curved, &q, &p), Ok(()), "{potential}");
        assert!(!curved.is_constant(), "{potential}");
    }
}

#[test]
fn the_energy_is_that_at_the_time_plus_the_momentum_of_the_clock() {
    let system = clocked(&description("(3 - 2*cos(2*t))*q1^2/2", &["v1/10"]));
    let [q, p, t, of_clock] = [0.7, -0.4, 1.3, -5.0];
    let exact = p * p / 2.0 + (3.0 - 2.0 * f64::cos(2.0 * t)) * q * q / 2.0 + of_clock;
    let found: f64 = system.energy(&[q, t], &[p, of_clock]);
    assert!((found - exact).abs() < 1e-14, "{found}, not {exact}");
    let [mut hq, mut hp, mut d] = [[0.0; 2]; 3];
    system.gradient(&[q, t], &[p, of_clock], &mut hq, &mut hp);
    system.dissipation(&[q, t], &[p, of_clock], &hp, &mut d);
    let pumped = 2.0 * f64::sin(2.0 * t) * q * q;
    assert!((hq[1] - pumped).abs() < 1e-14, "{}, not {pumped}", hq[1]);
    assert_eq!((hp, d[1]), ([p, 1.0], 0.0));
    assert!((d[0] - p / 10.0).abs() < 1e-16, "{}", d[0]);
}

#[test]
fn what_does_not_depend_on_t_has_no_clock() {
    for potential in ["q1^2/2", "q1^2/2 + 0*t"] {
        let found = Described::separable(&description(potential, &["v1"])).unwrap();
        assert!(!found.has_clock() && found.dof() == 1, "{potential}");
    }
}

#[test]
fn friction_that_depends_on_t_is_passive_where_its_form_shows_it() {
    for (force, passive) in
        [("v1/10", Passive::Each), ("t^2*v1", Passive::Each), ("sin(t)*v1", Passive::No)]
    {
        let system = clocked(&description("cos(t)*q1^2", &[force]));
        assert_eq!(System::<f64>::dissipation_form(&system).passive, passive, "{force}");
    }
}

#[test]
fn the_period_in_time_is_found() {
    use std::f64::consts::{PI, TAU};
    for (potential, force, period) in [
        ("(1 - cos(2*t))*q1^2", "v1", Some(PI)),
        ("(1 - cos(2*t))*q1^2", "(2 + sin(t))*v1", Some(TAU)),
        ("(1 - cos(2*t))*q1^2 + cos(q1)", "(2 + sin(3*t))*v1", Some(TAU)),
        ("(1 - cos(2*t))*q1^2 + cos(q1)", "(2 + sin(sqrt(3)*t))*v1", None),
        ("t*q1", "v1", None),
        ("exp(sin(2*t))*q1^2", "t^2*v1", None),
        ("q1^2", "v1", None),
    ] {
        let found = Described::separable(&description(potential, &[force])).unwrap();
        assert_eq!(found.period_in_time(), period, "{potential}, {force}");
        assert_eq!(found.periods().len(), 1);
    }
}

#[test]
fn parameters_may_change() {
    let mut with = description("cos(omega*t)*q1^2", &["v1"]);
    with.parameters = vec![("omega".into(), 2.0)];
    let found = Described::separable(&with).unwrap().with("omega", 4.0).unwrap();
    assert_eq!(found.period_in_time(), Some(std::f64::consts::TAU / 4.0));
    assert!(matches!(found.with("b", 1.0), Err(CustomError::NoParameter { .. })));
}

#[test]
fn values_that_are_not_finite_are_found_at_the_time() {
    let system = Described::separable(&description("q1^2/(t - 1)", &["log(2 - t)*v1"])).unwrap();
    let place = |t| match system.check_at(&[1.0], &[1.0], t) {
        Err(CustomError::NotFinite { place, .. }) => Some(place),
        found => {
            assert_eq!(found, Ok(()));
            None
        }
    };
    assert_eq!(place(0.0), None);
    assert_eq!(place(1.0), Some(Place::Potential));
    assert_eq!(place(3.0), Some(Place::Dissipation(0)));
}

/// The rule that refuses t, and its place.
fn refused(found: Result<impl std::fmt::Debug, CustomError>) -> (Place, &'static str) {
    match found {
        Err(CustomError::Expression {
            place, problem: Problem::NoPlace { name, rule }, ..
        }) => {
            assert_eq!(name, "t");
            (place, rule)
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn the_time_is_refused_by_name_where_it_has_no_place() {
    let heavy = Description { masses: vec!["1 + t^2".into()], ..description("q1^2", &[]) };
    let (place, rule) = refused(Described::separable(&heavy));
    assert_eq!((place, rule), (Place::Mass(0), "a mass is made of numbers and parameters"));

    let mut defined = description("k*q1^2", &[]);
    defined.definitions = vec![("k".into(), "1 + t".into())];
    assert_eq!(refused(Described::separable(&defined)).0, Place::Definition(0));

    let forces = DissipationText::Forces(vec!["t*v1".into()]);
    for (hamiltonian, dissipation, place) in [
        ("p1^2/2 + t*q1", DissipationText::None, Place::Hamiltonian),
        ("p1^2/2 + q1^2", forces, Place::Dissipation(0)),
    ] {
        let hamiltonian = hamiltonian.to_owned();
        let general = GeneralDescription { hamiltonian, dissipation, ..Default::default() };
        let (found, rule) = refused(CustomGeneral::new(&general));
        assert_eq!(found, place);
        assert!(rule.contains("give `potential` and `mass`"), "{rule}");
    }

    for with_t in [true, false] {
        let mut named = description("t*q1^2", &[]);
        let list = vec![("t".to_owned(), 2.0)];
        if with_t {
            named.parameters = list;
        } else {
            named.definitions = vec![("t".into(), "2".into())];
        }
        let found = Described::separable(&named).unwrap_err();
        assert!(matches!(&found, CustomError::Name { name, .. } if name == "t"), "{found}");
    }
}

#[test]
fn the_time_needs_a_clock() {
    assert_eq!(Custom::new(&description("t*q1^2", &[])).unwrap_err(), CustomError::NeedsClock);
    assert_eq!(Described::separable(&description("t^2", &[])).unwrap_err(), CustomError::Empty);
}

#[test]
fn steps_end_where_v_or_d_has_a_kink_in_time() {
    use std::f64::consts::PI;
    for (potential, forces, expected) in [
        ("q1^2/2 + abs(sin(t))*q1/10", ["0.1*v1"], &[PI, 2.0 * PI][..]),
        ("q1^2/2 + t*q1/10", ["max(0.1, abs(t - 2.5))*v1"], &[2.4, 2.5, 2.6]),
        ("q1^2/2 + abs(q1 - t)/10", ["0.1*v1"], &[]),
    ] {
        let system = clocked(&description(potential, &forces));
        let (mut t, mut found) = (0.1, Vec::new());
        while t < 7.0 {
            let h = System::<f64>::step_between_breaks(&system, &[0.3, t], 0.3);
            assert!(h > 0.0, "{potential}: a step of {h:e} at {t}");
            if h < 1e-12 {
                found.push(t + h / 2.0);
            }
            t += h;
        }
        assert_eq!(found.len(), expected.len(), "{potential}: {found:?}");
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-13, "{potential}: {found}, not {expected}");
        }
    }
}
