//! Systems given by expressions agree with the built-in ones under every kind of method, and
//! conserve K.

use afterbay_core::{Curvature, Grid, Method, Quad, Scalar, Separable, State, integrate};
use afterbay_methods::{Composition, Gonzalez, Increment, Leapfrog, ModDg, Rk4};
use afterbay_systems::{Custom, Description, DissipationText, Duffing, FputChain, VanDerPolRing};

fn custom(potential: &str, forces: Vec<String>, parameters: &[(&str, f64)]) -> Custom<f64> {
    let parameters = parameters.iter().map(|&(name, value)| (name.to_owned(), value)).collect();
    let (potential, friction) = (potential.to_owned(), DissipationText::Forces(forces));
    Custom::new(&Description {
        potential,
        dissipation: friction,
        parameters,
        ..Description::default()
    })
    .unwrap()
}

/// The end of a run of 200 steps, and the change of K.
fn run<M, S>(method: &M, system: &S, start: &State<Vec<f64>>) -> (State<Vec<f64>>, f64)
where
    M: Method<Vec<f64>, S>,
    S: Separable<f64>,
{
    let mut state = start.clone();
    integrate(method, system, Grid::of(0.05, 200).unwrap(), &mut state, &mut ()).unwrap();
    let drift = state.total(system) - start.total(system);
    (state, drift)
}

fn same<M, B>(
    name: &str,
    method: &M,
    own: &Custom<f64>,
    built_in: &B,
    start: &State<Vec<f64>>,
    keeps: bool,
) where
    M: Method<Vec<f64>, Custom<f64>> + Method<Vec<f64>, B>,
    B: Curvature<f64> + Separable<f64>,
{
    let ((a, drift), (b, _)) = (run(method, own, start), run(method, built_in, start));
    for (a, b) in [(&a.q, &b.q), (&a.p, &b.p), (&a.w, &b.w)] {
        for (a, b) in a.iter().zip(b) {
            assert!((a - b).abs() < 1e-11, "{name}: {a} {b}");
        }
    }
    assert!(
        !keeps || drift.abs() < 1e-13 * (1.0 + start.total(own).abs()),
        "{name}: K moves by {drift:e}"
    );
}

fn all<B: Curvature<f64> + Separable<f64>>(
    own: &Custom<f64>,
    built_in: &B,
    start: &State<Vec<f64>>,
) {
    same("leapfrog", &Leapfrog, own, built_in, start, false);
    same("rk4", &Rk4, own, built_in, start, false);
    same("increment-2", &Increment::new(Composition::pair()), own, built_in, start, true);
    same("gonzalez", &Gonzalez::default(), own, built_in, start, true);
    if start.dof() == 1 {
        same("moddg", &ModDg::newton(), own, built_in, start, true);
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
    all(&own, &Duffing::new(-1.0, 1.0, 0.1).unwrap(), &start);

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
    all(&own, &FputChain::new(n, 0.5, 0.05).unwrap(), &start);

    let member = |j: usize| format!("q{j}^2/2 + kappa/2*(q{} - q{j})^2", j % n + 1);
    let potential = (1..=n).map(member).collect::<Vec<_>>().join(" + ");
    let own = custom(
        &potential,
        forces(|j| format!("-mu*(1 - q{j}^2)*p{j}")),
        &[("mu", 0.7), ("kappa", 0.3)],
    );
    all(&own, &VanDerPolRing::new(n, 0.7, 0.3).unwrap(), &start);
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
    let own = Custom::new(&description).unwrap();
    let own = own.map(Quad::from_f64);
    let lift = |x: [f64; 2]| x.map(Quad::from_f64);
    let start = State::new(lift([0.9, -0.4]), lift([0.1, 1.5])).unwrap();
    let mut end = start.clone();
    let grid = Grid::of(0.05, 200).unwrap();
    integrate(&Increment::new(Composition::pair()), &own, grid, &mut end, &mut ()).unwrap();
    let drift = (end.total(&own) - start.total(&own)).to_f64();
    assert!(drift.abs() < 1e-27, "K moves by {drift:e}");
    assert!((end.w[0] + end.w[1]).to_f64() > 0.01, "{:?}", end.w);
}
