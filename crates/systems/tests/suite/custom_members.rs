//! Chains and rings of equal members are found in the texts of their expressions.

use afterbay_core::{Abilities, Coupling, System, Uniform, validate};
use afterbay_systems::{Custom, Description, DissipationText};
use proptest::prelude::*;
use std::sync::LazyLock;

const N: usize = 20;

/// The system of V, of one D_j for all j, and of one mass.
fn system(potential: &str, dissipation: &str, mass: &str) -> Custom<f64> {
    let texts = |rule: &str| vec![rule.to_owned(); N];
    let description = Description {
        potential: potential.to_owned(),
        dissipation: DissipationText::Forces(texts(dissipation)),
        masses: texts(mass),
        ..Default::default()
    };
    Custom::new(&description).unwrap()
}

/// Systems of equal members, and whether they are rings.
const EQUAL: [(&str, &str, &str, bool); 9] = [
    ("sum(i, 1, n-1, exp(q[i+1] - q[i]) - (q[i+1] - q[i]) - 1)", "0.1*p[i]", "1", false),
    (
        "q1^2/2 + q1^4/8 + q[n]^2/2 + q[n]^4/8 \
         + sum(i, 1, n-1, (q[i+1] - q[i])^2/2 + (q[i+1] - q[i])^4/8)",
        "0.1*p[i]",
        "2",
        false,
    ),
    ("0.7*sum(i, 1, n-1, (1 - exp(q[i] - q[i+1]))^2)", "0.1*p[i]*abs(p[i])", "1", false),
    ("-2*(sum(i, 1, n-1, cos(q[i+1] - q[i])) + q1^2) ", "0.1*p[i]", "0.5", false),
    ("sum(i, 1, n, q[i]^2/2 + 0.3*(q[wrap(i+1)] - q[i])^2/2)", "-(1 - q[i]^2)*p[i]", "1", true),
    (
        "sum(i, 1, n, 1 - cos(q[i]) + (q[wrap(i+1)] - q[i])^2)",
        "(q[i] - q[wrap(i-1)])^2*p[i]",
        "1",
        true,
    ),
    ("sum(i, 1, n, sin(q[wrap(i+1)])*cos(q[i]))/4", "tanh(p[i])", "3", true),
    ("sum(i, 1, n-1, abs(q[i+1]*q[i]) + ln(2 + q[i+1]^2))", "0", "1", false),
    ("sum(i, 1, n, q[i]^4/4)", "0.1*p[i]", "1", false),
];

static SYSTEMS: LazyLock<[Custom<f64>; 9]> = LazyLock::new(|| {
    EQUAL.map(|(potential, dissipation, mass, _)| system(potential, dissipation, mass))
});

#[test]
fn chains_and_rings_of_equal_members_are_found() {
    for (potential, dissipation, mass, ring) in EQUAL {
        let system = system(potential, dissipation, mass);
        assert!(system.is_uniform(), "{potential}");
        assert_eq!(system.coupling() == Coupling::Ring, ring, "{potential}");
        assert!(system.lanes().is_ok(), "{potential}");
        assert_eq!(system.ends().is_none(), ring, "{potential}");
    }
}

#[test]
fn members_that_differ_are_no_chain() {
    let bonds = "sum(i, 1, n-1, exp(q[i+1] - q[i]) - q[i+1] + q[i])";
    for (potential, dissipation, mass) in [
        (format!("{bonds} + q7^2"), "p[i]", "1"),
        (format!("{bonds} + (q8 - q7)^2"), "p[i]", "1"),
        (format!("{bonds} + q1*q3"), "p[i]", "1"),
        (format!("{bonds} + (q1 - q[n])^2"), "p[i]", "1"),
        ("sum(i, 1, n-2, (q[i+2] - q[i])^2)".into(), "p[i]", "1"),
        ("sum(i, 1, n-1, i*(q[i+1] - q[i])^2)".into(), "p[i]", "1"),
        ("sum(i, 1, n, q[i])^2".into(), "p[i]", "1"),
        (bonds.to_owned(), "i*p[i]", "1"),
        (bonds.to_owned(), "p[i]*q[wrap(i+3)]^2", "1"),
        (bonds.to_owned(), "p[i]", "1 + i"),
    ] {
        let system = system(&potential, dissipation, mass);
        assert!(!system.is_uniform(), "{potential} {dissipation} {mass}");
        assert!(system.lanes().is_err() && system.ends().is_none(), "{potential}");
    }
}

#[test]
fn parameters_reach_the_members() {
    let description = Description {
        potential: "k*sum(i, 1, n-1, (q[i+1] - q[i])^4) + b*q1^2".into(),
        dissipation: DissipationText::Forces(vec!["c*p[i]".into(); N]),
        parameters: [("k", 2.0), ("c", 0.1), ("b", 3.0)].map(|(x, y)| (x.to_owned(), y)).into(),
        ..Default::default()
    };
    let system = Custom::new(&description).unwrap().with("k", 5.0).unwrap().with("b", 1.5).unwrap();
    let q: Vec<f64> = (0..N).map(|j| (j as f64).sin()).collect();
    validate::uniform(&system, &q, &q).unwrap();
}

proptest! {
    #[test]
    fn a_member_obeys_its_law_anywhere(
        which in 0..EQUAL.len(),
        q in prop::collection::vec(-2.0..2.0_f64, N),
        p in prop::collection::vec(-2.0..2.0_f64, N),
    ) {
        prop_assert_eq!(validate::uniform(&SYSTEMS[which], &q, &p), Ok(()), "{}", EQUAL[which].0);
    }
}
