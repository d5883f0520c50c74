//! Edges of random expressions beside 60-digit arithmetic, and the singularities between their
//! ends.

use afterbay_core::{Quad, Separable, f64x8};
use afterbay_systems::{Custom, Description};

/// Potentials, edges of q1 and their divided differences, from `slopes.py` beside it.
const TABLE: &str = include_str!("../data/slopes.csv");

/// Roundings of the sum of the magnitudes.
const ROUNDINGS: f64 = 1.0;

fn custom(potential: &str) -> Custom<f64> {
    let masses = vec!["1".to_owned(); 2];
    Custom::new(&Description { potential: potential.to_owned(), masses, ..Description::default() })
        .unwrap()
}

#[test]
fn slopes_are_within_roundings_of_the_magnitudes_of_their_terms() {
    let mut worst = (0.0, "");
    for line in TABLE.lines().skip(1) {
        let mut parts = line.splitn(5, ',');
        let [a, b, slope, size] =
            std::array::from_fn(|_| parts.next().unwrap().parse::<f64>().unwrap());
        let system = custom(parts.next().unwrap());
        let found = system.divided_difference(&[a, 0.75], 0, b).value;
        let off = (found - slope).abs() / (f64::EPSILON / 2.0 * size);
        assert!(off < ROUNDINGS, "{line}: {found:?} is off by {off} roundings");
        worst = if off > worst.0 { (off, line) } else { worst };
        let lanes = system.map(f64x8::splat);
        let found = lanes
            .divided_difference(&[f64x8::splat(a), f64x8::splat(0.75)], 0, f64x8::splat(b))
            .value;
        let off = (found.to_array()[3] - slope).abs() / (f64::EPSILON / 2.0 * size);
        assert!(off < 2.0 * ROUNDINGS, "{line}: {found:?} in lanes is off by {off} roundings");
        if [a, b].iter().all(|x| *x == 0.0 || x.abs() > 1e-200) {
            let quad = system.map(Quad::from);
            let found = quad.divided_difference(&[a, 0.75].map(Quad::from), 0, Quad::from(b)).value;
            let off = (found - Quad::from(slope)).abs().0;
            assert!(off < 1e-27 * size + f64::EPSILON / 2.0 * slope.abs(), "{line}: {found:?}");
        }
    }
    println!("the worst is off by {:.2} roundings: {}", worst.0, worst.1);
}

#[test]
fn an_edge_across_a_singularity_is_seen() {
    let cases = [
        ("1/q1", -1.0, 0.5),
        ("1/q1^2", -1.0, 1.0),
        ("q1^(-3)", 0.1, -0.2),
        ("log(q1)", 1.0, -1e-9),
        ("log(q1^2)", -2.0, 1.0),
        ("q1^1.3", 1.0, -1.0),
        ("q1^(-0.7)", 0.0, 1.0),
        ("tan(q1)", 1.5, 1.6),
        ("tan(q1)", 0.0, 1000.0),
        ("1/((q1 - 1)^2)", 0.0, 3.0),
        ("1/((q1 - q2)^2 + (q1 - 0.75)^4)", 0.0, 1.0),
        ("1/(sin(q1)*cos(q1)) + q1^2", 0.1, 1.6),
        ("atan(1/q1)", -1.0, 1.0),
        ("tanh(1/(q1^3 - q1))", 0.5, 1.5),
        ("exp(-1/q1)", 1.0, -1.0),
        ("sqrt(q1^2 - 1)", -2.0, 2.0),
        ("asin(q1^3 - 2*q1)", -1.3, 1.3),
        ("1/(abs(q1) - 0.3)", 0.0, 0.4),
        ("1/sinh(q1)", -1e-100, 1e-100),
        ("q2/(q1^2 - q2^2)", 0.7, 0.8),
        ("1/(q1^2 - 2)", 1.0, 2.0),
    ];
    for (potential, a, b) in cases {
        let system = custom(potential);
        for (a, b) in [(a, b), (b, a)] {
            assert!(system.is_singular_along(&[a, 0.75], 0, b), "{potential} from {a} to {b}");
            let lanes = system.map(f64x8::splat);
            let mut to = [a; 8];
            to[6] = b;
            let (q, to) = ([f64x8::splat(a), f64x8::splat(0.75)], f64x8::new(to));
            assert!(lanes.is_singular_along(&q, 0, to), "{potential} in a lane");
            let (q, to) = ([a, 0.75].map(Quad::from), Quad::from(b));
            assert!(system.map(Quad::from).is_singular_along(&q, 0, to), "{potential} in 106 bits");
        }
        assert!(!system.is_singular_along(&[0.1, 0.75], 1, 0.11), "{potential} along q2");
    }
}

#[test]
fn an_edge_beside_a_singularity_is_none_across_it() {
    let cases = [
        ("1/q1", 1e-12, 1e3),
        ("log(q1)", 1e-300, 1e3),
        ("tan(q1)", -1.57, 1.57),
        ("1/(q1^2 + 1e-12)", -1.0, 2.0),
        ("1/(q1^4 - 2*q1^2 + 1.0001)", -3.0, 3.0),
        ("sqrt(1 - cos(q1))", -1.0, 20.0),
        ("log(1 + q1^2) + 1/cosh(q1)", -40.0, 300.0),
        ("1/(2 + sin(q1))", -40.0, 300.0),
        ("acos(q1)", -1.0, 1.0),
        ("1/(q1 - 3)^2 + log(q1 + 2)", -1.9, 2.99),
        ("1/q2 + q1^4*exp(q1)", -2.0, 2.0),
    ];
    for (potential, a, b) in cases {
        let system = custom(potential);
        assert!(!system.is_singular_along(&[a, 0.75], 0, b), "{potential} from {a} to {b}");
        assert!(!system.is_singular_along(&[b, 0.75], 0, a), "{potential} from {b} to {a}");
    }
}
