//! Systems with any H(q, p) given as text, and the evaluation of expressions at several points.

use afterbay_core::{
    Coupling, DissipationForm, Passive, PhasePlane, Quad, State, System, validate,
};
use afterbay_systems::{
    Custom, CustomError, CustomGeneral, DampedDoublePendulum, Description, DissipationText,
    GeneralDescription, Place, Problem,
};
use proptest::prelude::*;

fn general(hamiltonian: &str, forces: &[&str]) -> Result<CustomGeneral<f64>, CustomError> {
    let forces: Vec<String> = forces.iter().map(ToString::to_string).collect();
    CustomGeneral::new(&GeneralDescription {
        hamiltonian: hamiltonian.into(),
        dissipation: match &forces[..] {
            [] => DissipationText::None,
            _ => DissipationText::Forces(forces),
        },
        ..GeneralDescription::default()
    })
}

/// Hamiltonians of two degrees of freedom that are smooth for q1 > 0.
const SMOOTH: [(&str, [&str; 2]); 6] = [
    ("p1^2/2 + p2^2/(2*q1^2) - 1/q1", ["0.1*v1", "0.2*q1^2*v2"]),
    ("p1^2/(2*(1 + q1^2)) + p2^2/2 + q1^2*q2^2", ["0.3*v1^3", "0.1*p2"]),
    ("sqrt(1 + p1^2 + p2^2) + (q1^2 + q2^2)/2", ["0.1*v1", "0.1*v2"]),
    ("(p1 - q2)^2/2 + (p2 + q1)^2/2 + q1^4/4 + cosh(q2)", ["0.2*v1", "0"]),
    ("exp(0.3*q1*p2) + exp(-0.2*q2*p1) + p1^2*p2^2", ["tanh(v1)", "abs(v2)*v2"]),
    ("log(1 + q1*p1^2) + atan(p2*q1) + q2^2*max(0, 1 + p2^2)", ["0", "0"]),
];

#[test]
fn every_claim_holds() {
    let without_friction = SMOOTH.map(|(hamiltonian, _)| (hamiltonian, &[][..]));
    let with_friction = SMOOTH.iter().map(|(hamiltonian, forces)| (*hamiltonian, &forces[..]));
    for (hamiltonian, forces) in with_friction.chain(without_friction) {
        let system = general(hamiltonian, forces).unwrap();
        for (q, p) in [([1.1, 0.3], [0.2, 0.7]), ([0.4, -0.8], [-1.2, 0.5])] {
            assert_eq!(validate::system(&system, &q, &p), Ok(()), "{hamiltonian}");
            assert_eq!(validate::curvature(&system, &q, &p), Ok(()), "{hamiltonian}");
            assert_eq!(system.check_at(&q, &p), Ok(()), "{hamiltonian}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::with_cases(500)
    })]

    /// Against the quotient of differences of H in 31 digits.
    #[test]
    fn means_are_divided_differences_of_h(
        index in 0..SMOOTH.len(), q1 in 0.2..3.0_f64, q2 in -2.0..2.0_f64,
        p in prop::array::uniform2(-2.0..2.0_f64), j in 0..2_usize, along_p: bool,
        share in 0.0..1.0_f64, exponent in -9.0..0.0_f64,
    ) {
        let (hamiltonian, forces) = SMOOTH[index];
        let system = general(hamiltonian, &forces).unwrap();
        let exact = system.map(Quad::from);
        let q = [q1, q2];
        let from = if along_p { p[j] } else { q[j] };
        // It stays where q1 > 0.
        let to = from + (share - 0.5) * 10.0_f64.powf(exponent) * 0.3;
        let energy = |at: f64| {
            let (mut q, mut p) = (q.map(Quad::from), p.map(Quad::from));
            if along_p { p[j] = Quad::from(at) } else { q[j] = Quad::from(at) }
            exact.energy(&q, &p)
        };
        prop_assume!(to != from);
        let quotient = (energy(to) - energy(from)) / (Quad::from(to) - Quad::from(from));
        let found = if along_p {
            system.along_p(&q, &p, j, q[j], [from, to])
        } else {
            system.along_q(&q, &p, j, [from, to], p[j])
        };
        let size = 1.0 + energy(from).0.abs() + quotient.0.abs();
        let bound = 1e-13 * size + 1e-28 * size / (to - from).abs();
        let off = (found.value - quotient.0).abs();
        prop_assert!(off <= bound, "{hamiltonian}: {off:e} > {bound:e}");
    }
}

/// The built-in pendulum and the same as text, at random states.
#[test]
fn a_double_pendulum_in_text_is_the_built_in_one() {
    let built_in = DampedDoublePendulum::new([1.0, 0.5], [1.0, 0.7], 9.81, [0.2, 0.1]).unwrap();
    let text = general(
        "(0.245*p1^2 + 1.5*p2^2 - 0.7*cos(q1 - q2)*p1*p2) / (0.49*(1 + 0.5*sin(q1 - q2)^2)) \
         + 14.715*(1 - cos(q1)) + 3.4335*(1 - cos(q2))",
        &["0.2*v1", "0.1*v2"],
    )
    .unwrap();
    for k in 0..50 {
        let x = |i: i32| (f64::from(7 * k + i) * 1.7).sin() * 2.0;
        let (q, p) = ([x(0), x(1)], [x(2), x(3)]);
        let fields = |system: &dyn System<f64>| {
            let [mut hq, mut hp, mut d] = [[0.0; 2]; 3];
            system.gradient(&q, &p, &mut hq, &mut hp);
            system.dissipation(&q, &p, &hp, &mut d);
            [[system.energy(&q, &p), 0.0], hq, hp, d].concat()
        };
        let (a, b) = (fields(&built_in), fields(&text));
        let off = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 1e-12, "{off:e}: {a:?} {b:?}");
    }
    let periods = text.periods();
    assert!(periods.iter().all(|period| (period.unwrap() - std::f64::consts::TAU).abs() < 1e-15));
}

#[test]
fn the_form_of_the_dissipation_is_seen() {
    let form = |forces: &[&str]| {
        general("p1^2/(2 + q1^2) + p2^2 + q1*q2", forces).unwrap().dissipation_form()
    };
    assert_eq!(form(&[]), DissipationForm::NONE);
    assert_eq!(form(&["0", "0*v1"]), DissipationForm::NONE);
    let each = DissipationForm { passive: Passive::Each, ..DissipationForm::GENERAL };
    assert_eq!(form(&["v1^3", "q1^2*v2"]), each);
    assert_eq!(form(&["-v1", "0"]), DissipationForm::GENERAL);
    // p1 is no velocity here.
    assert_eq!(form(&["p1", "0"]), DissipationForm::GENERAL);
    let coupled = DissipationForm { coupled: true, ..DissipationForm::GENERAL };
    assert_eq!(form(&["v2", "0"]), coupled);
    let in_sum = DissipationForm { passive: Passive::InSum, ..coupled };
    assert_eq!(form(&["2*v1 - v2", "2*v2 - v1"]), in_sum);
}

#[test]
fn structure_follows_from_the_form() {
    let chain = general("p1^2/(2 + q2^2) + p2^2 + p3^2 + q2*q3", &["v1", "0", "0"]).unwrap();
    assert_eq!(System::<f64>::coupling(&chain), Coupling::Chain);
    // v1 = ∂H/∂p1 depends on q2, so that D4 depends on it too: this is no ring.
    let far = general("p1^2/(2 + q2^2) + p2^2 + p3^2 + p4^2", &["0", "0", "0", "v1"]).unwrap();
    assert_eq!(System::<f64>::coupling(&far), Coupling::Dense);
}

/// A pole in coordinates is found on the way of a step; one that momenta move is not sought.
#[test]
fn singularities_in_coordinates_are_found() {
    let polar = general("p1^2/2 + p2^2/(2*q1^2) - 1/q1", &[]).unwrap();
    assert!(System::<f64>::may_be_singular(&polar));
    assert!(polar.is_singular_between(&[0.5, 0.0], &[-0.5, 0.0]));
    assert!(!polar.is_singular_between(&[0.5, 0.0], &[0.1, 3.0]));
    let moving = general("p1^2/2 + 1/(q1 - p1)", &[]).unwrap();
    assert!(!System::<f64>::may_be_singular(&moving));
}

/// A free particle in polar coordinates moves straight: r² = (1 + t)² + t².
#[test]
fn references_are_exact() {
    type Wide = afterbay_core::Series<Quad, 24>;
    let system = general("p1^2/2 + p2^2/(2*q1^2)", &[]).unwrap();
    let lifted = system.map(|x| Wide::constant(Quad::from(x)));
    let start =
        State::new([1.0, 0.0].map(Quad::from).to_vec(), [1.0, 1.0].map(Quad::from).to_vec());
    let states =
        afterbay_core::taylor::trajectory::<_, _, 24>(&lifted, &start.unwrap(), Quad::from(0.5), 4)
            .unwrap();
    for (i, state) in states.iter().enumerate() {
        let t = 0.5 * i as f64;
        let r = ((1.0 + t) * (1.0 + t) + t * t).sqrt();
        assert!((state.q[0].0 - r).abs() < 1e-15 * r, "{i}");
        assert!((state.q[1].0 - (t / (1.0 + t)).atan()).abs() < 1e-15, "{i}");
    }
}

#[test]
fn mistakes_name_their_place() {
    let error = general("p1^2/2 + v1", &[]).unwrap_err();
    assert!(matches!(error, CustomError::Expression { place: Place::Hamiltonian, .. }), "{error}");
    let error = general("p1^2/2 + p3", &["0", "v2"]).unwrap_err();
    let CustomError::Expression { problem: Problem::BeyondLast { name, dof: 2 }, .. } = &error
    else {
        panic!("{error}")
    };
    assert_eq!(name, "p3");
    assert!(matches!(general("1", &[]), Err(CustomError::Empty)));
    let system = general("p1^2/q1", &[]).unwrap();
    assert!(matches!(system.check_at(&[0.0], &[1.0]), Err(CustomError::NotFinite { .. })));
}

/// In the forces of a separable system v_j is p_j/m_j.
#[test]
fn velocities_are_momenta_over_masses() {
    let custom = |force: &str| {
        Custom::new(&Description {
            potential: "q1^2/2 + q2^4".into(),
            masses: vec!["3".into(), "5".into()],
            dissipation: DissipationText::Forces(vec!["0".into(), force.into()]),
            ..Description::default()
        })
        .unwrap()
    };
    let (by_v, by_p) = (custom("2*v2 + v1^3"), custom("2*p2/5 + (p1/3)^3"));
    let ([mut a, mut b], v) = ([[0.0; 2]; 2], [0.4, 0.2]);
    by_v.dissipation(&[1.0, 2.0], &[1.2, 1.0], &v, &mut a);
    by_p.dissipation(&[1.0, 2.0], &[1.2, 1.0], &v, &mut b);
    assert!((a[1] - b[1]).abs() < 1e-15 && a[1] > 0.4, "{a:?} {b:?}");
    assert_eq!(by_v.dissipation_form(), by_p.dissipation_form());
    assert_eq!(custom("0.1*v2").dissipation_form().passive, Passive::Each);
}

/// Compares the gradient and the dissipation at all points (q, p, v) with those at one at a time.
fn check_batches(system: &dyn System<f64>, points: &[[Vec<f64>; 3]]) {
    assert!(system.has_batches());
    let part = |k: usize| points.iter().map(|point| &point[k][..]).collect::<Vec<_>>();
    let [q, p, v] = [0, 1, 2].map(part);
    let [mut all, mut one] =
        [(); 2].map(|()| vec![[(); 3].map(|()| vec![0.0; system.dof()]); q.len()]);
    let (mut hq, mut hp, mut d) = (Vec::new(), Vec::new(), Vec::new());
    for [to_hq, to_hp, to_d] in &mut all {
        hq.push(&mut to_hq[..]);
        hp.push(&mut to_hp[..]);
        d.push(&mut to_d[..]);
    }
    system.gradients(&q, &p, &mut hq, &mut hp);
    system.dissipations(&q, &p, &v, &mut d);
    for (i, [hq, hp, d]) in one.iter_mut().enumerate() {
        system.gradient(q[i], p[i], hq, hp);
        system.dissipation(q[i], p[i], v[i], d);
    }
    let bits = |x: &[[Vec<f64>; 3]]| -> Vec<u64> {
        x.iter().flatten().flatten().map(|x| x.to_bits()).collect()
    };
    assert_eq!(bits(&all), bits(&one));
}

#[test]
fn several_points_give_the_numbers_of_each_in_a_large_program() {
    let n = 40;
    let pair = |i: usize, j: usize| format!("sqrt(1 + (q{i} - q{j})^2) + cos(q{i})*q{j}^2");
    let terms: Vec<String> = (1..=n).flat_map(|i| (1..i).map(move |j| pair(i, j))).collect();
    let system =
        Custom::new(&Description { potential: terms.join(" + "), ..Description::default() });
    let part = |i: usize| (0..n).map(|j| ((7 * i + j) as f64).sin()).collect();
    let points: Vec<_> = (0..19).map(|i| [part(i), part(i + 20), part(i + 40)]).collect();
    check_batches(&system.unwrap(), &points);
}

fn separable(potential: &str, forces: [&str; 2]) -> Custom<f64> {
    let description = Description {
        potential: potential.into(),
        dissipation: DissipationText::Forces(forces.map(str::to_owned).into()),
        masses: vec!["2".into(), "0.5".into()],
        ..Description::default()
    };
    Custom::new(&description).unwrap()
}

proptest! {
    /// Below, at and above the number of points that are evaluated together.
    #[test]
    fn several_points_give_the_numbers_of_each(
        points in prop::collection::vec((0.1..2.0, prop::array::uniform5(-2.0..2.0)), 0..20)
    ) {
        let points: Vec<_> = points
            .into_iter()
            .map(|(q1, [q2, p1, p2, v1, v2])| [vec![q1, q2], vec![p1, p2], vec![v1, v2]])
            .collect();
        for (hamiltonian, forces) in SMOOTH {
            check_batches(&general(hamiltonian, &forces).unwrap(), &points);
        }
        // The gradient by programs, the dissipation by programs, and both.
        prop_assert!(!separable("q1^2/2 + (q2 - q1)^4", ["0.1*p1", "0.2*p2"]).has_batches());
        for (potential, forces) in [
            ("sin(q1)*exp(q2) + q1^6", ["0.1*p1", "0.2*p2"]),
            ("q1^2/2 + (q2 - q1)^4", ["tanh(q2)*v1", "p2^3"]),
            ("cos(q1 - q2^2)/q1", ["sqrt(1 + v2^2)*p1", "0"]),
        ] {
            check_batches(&separable(potential, forces), &points);
        }
    }
}
