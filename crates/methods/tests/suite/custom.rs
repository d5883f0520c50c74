//! Systems given by expressions agree with the built-in ones under every kind of method, and
//! conserve K.

use crate::bind::after;
use crate::catalog::{As, Built, chain, duffing, ring, written};
use crate::many::{self, errors};
use afterbay_core::{Grid, Quad, Scalar, State};
use afterbay_methods::registry::{Row, find};
use afterbay_systems::{Description, DissipationText};

fn custom(potential: &str, forces: Vec<String>, parameters: &[(&str, f64)]) -> Built {
    let parameters = parameters.iter().map(|&(name, value)| (name.to_owned(), value)).collect();
    let (potential, friction) = (potential.to_owned(), DissipationText::Forces(forces));
    written(&Description { potential, dissipation: friction, parameters, ..Description::default() })
}

/// Checks that both systems have the same end after 200 steps, and that the method keeps K.
fn same(row: &Row, own: &Built, built_in: &Built, start: &State<Vec<f64>>) {
    let grid = Grid::of(0.05, 200).unwrap();
    let a = after(&own.bind(row, As::Separable).unwrap(), grid, start);
    let b = after(&built_in.bind(row, As::Separable).unwrap(), grid, start);
    assert!(errors(&a, &b).iter().all(|&off| off < 1e-11), "{}: {a:?} {b:?}", row.name);
    let (drift, size) = (a.total(&**own) - start.total(&**own), 1.0 + start.total(&**own).abs());
    assert!(!row.keeps_k || drift.abs() < 1e-13 * size, "{}: K moves by {drift:e}", row.name);
}

fn all(own: &Built, built_in: &Built, start: &State<Vec<f64>>) {
    let names = ["leapfrog", "rk4", "increment-2", "gonzalez", "moddg"];
    for name in &names[..if start.dof() == 1 { 5 } else { 4 }] {
        same(find(name).unwrap(), own, built_in, start);
    }
}

#[test]
fn trajectories_are_those_of_the_built_in_systems() {
    let own = custom(
        "alpha*q1^2/2 + beta*q1^4/4",
        vec!["c*p1".to_owned()],
        &[("alpha", -1.0), ("beta", 1.0), ("c", 0.1)],
    );
    let start = State::new(vec![1.3], vec![0.4]).unwrap();
    all(&own, &duffing(-1.0, 1.0, 0.1), &start);

    let n = 5;
    let start =
        State::new(vec![0.9, -0.4, 0.3, 1.1, -0.2], vec![0.1, 0.0, -0.6, 0.2, 0.5]).unwrap();
    let bond = |i: usize| match i {
        0 => "q1^2/2 + beta*q1^4/4".to_owned(),
        _ if i == n => format!("q{n}^2/2 + beta*q{n}^4/4"),
        _ => format!("(q{} - q{i})^2/2 + beta*(q{} - q{i})^4/4", i + 1, i + 1),
    };
    let forces = |text: fn(usize) -> String| (1..=n).map(text).collect::<Vec<_>>();
    let potential = (0..=n).map(bond).collect::<Vec<_>>().join(" + ");
    let own = custom(&potential, forces(|j| format!("c*p{j}")), &[("beta", 0.5), ("c", 0.05)]);
    all(&own, &chain(n, 0.5, 0.05), &start);

    let member = |j: usize| format!("q{j}^2/2 + kappa/2*(q{} - q{j})^2", j % n + 1);
    let potential = (1..=n).map(member).collect::<Vec<_>>().join(" + ");
    let own = custom(
        &potential,
        forces(|j| format!("-mu*(1 - q{j}^2)*p{j}")),
        &[("mu", 0.7), ("kappa", 0.3)],
    );
    all(&own, &ring(n, 0.7, 0.3), &start);
}

/// A pendulum with masses, and friction between its members given as a matrix; in 31 digits, so
/// that accumulated rounding errors of 200 steps do not hide an error of a formula.
#[test]
fn what_is_not_polynomial_keeps_k_too() {
    let text = |x: &str| x.to_owned();
    let description = Description {
        potential: text(
            "-2*g*cos(q1) - g*cos(q2) + abs(q2)^3/9 + sqrt(1 + (q2 - q1)^2) + q1^4/(1 + q2^2)",
        ),
        dissipation: DissipationText::Matrix(vec![
            vec![text("c"), text("-c")],
            vec![text("-c"), text("c")],
        ]),
        masses: vec![text("2"), text("1")],
        parameters: vec![(text("g"), 1.5), (text("c"), 0.1)],
        ..Description::default()
    };
    let own = written(&description);
    let start = many::start([&[0.9, -0.4], &[0.1, 1.5]]);
    let run = own.bind::<Quad>(find("increment-2").unwrap(), As::Separable).unwrap();
    let own = own.separable::<Quad>();
    let end = after(&run, Grid::of(0.05, 200).unwrap(), &start);
    let drift = (end.total(&*own) - start.total(&*own)).to_f64();
    assert!(drift.abs() < 1e-27, "K moves by {drift:e}");
    assert!((end.w[0] + end.w[1]).to_f64() > 0.01, "{:?}", end.w);
}
