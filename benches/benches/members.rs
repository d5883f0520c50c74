//! Chains and rings of 200 equal members from one line of text, compared with the built-in ones,
//! under the same methods, bound as scenes bind them.
//!
//! The two are run in turn, and each figure is the minimum over the turns.

use afterbay_analysis::Model;
use afterbay_core::{Grid, State, StateRef};
use afterbay_methods::registry;
use afterbay_systems::catalog::SYSTEMS;
use afterbay_systems::{Custom, Described, Description, DissipationText};
use std::ops::ControlFlow;
use std::time::Instant;

const TURNS: usize = 41;
const MEMBERS: usize = 200;
const STEPS: u64 = 100;
const METHODS: [&str; 7] = [
    "increment-2",
    "increment-4",
    "leapfrog",
    "rk4",
    "relaxed-dop853",
    "gonzalez",
    "adaptive-dop853",
];

const FPUT: &str = "q1^2/2 + beta*q1^4/4 + q[n]^2/2 + beta*q[n]^4/4 \
    + sum(i, 1, n-1, (q[i+1] - q[i])^2/2 + beta*(q[i+1] - q[i])^4/4)";
const RING: &str = "sum(i, 1, n, q[i]^2/2 + coupling*(q[wrap(i+1)] - q[i])^2/2)";
const TODA: &str = "sum(i, 1, n-1, exp(q[i+1] - q[i]) - (q[i+1] - q[i]) - 1)";

fn main() {
    // `cargo test` also runs benches, without this argument; a single turn then checks that they
    // work.
    let turns = if std::env::args().any(|argument| argument == "--bench") { TURNS } else { 1 };
    println!("{:40} {:>8} {:>9} {:>6}", "ns a member and step", "text", "built in", "ratio");
    for (name, text, friction, parameters) in [
        ("fput-chain", FPUT, "c*p[i]", &[("beta", 0.5), ("c", 0.02)][..]),
        ("van-der-pol-ring", RING, "-mu*(1 - q[i]^2)*p[i]", &[("coupling", 0.3), ("mu", 0.5)]),
        ("toda", TODA, "c*p[i]", &[("c", 0.02)]),
    ] {
        let text = custom(text, friction, parameters);
        let built_in = SYSTEMS.iter().find(|row| row.name == name).map(|row| {
            let count = [("n", MEMBERS as f64)];
            let named = count.iter().chain(parameters).copied();
            Model::named(row, named).expect("parameters of the system")
        });
        for method in METHODS {
            let mut least = [f64::INFINITY; 2];
            for _ in 0..turns {
                least[0] = least[0].min(time(&text, method));
                if let Some(built_in) = &built_in {
                    least[1] = least[1].min(time(built_in, method));
                }
            }
            let ([own, other], name) = (least, format!("{method}, {name}"));
            match built_in {
                Some(_) => println!("{name:40} {own:8.2} {other:9.2} {:6.2}", own / other),
                None => println!("{name:40} {own:8.2}"),
            }
        }
    }
}

fn custom(potential: &str, friction: &str, parameters: &[(&str, f64)]) -> Model {
    let description = Description {
        potential: potential.to_owned(),
        dissipation: DissipationText::Forces(vec![friction.to_owned(); MEMBERS]),
        parameters: parameters.iter().map(|&(name, value)| (name.to_owned(), value)).collect(),
        ..Default::default()
    };
    Model::Custom(Described::Separable(Custom::new(&description).expect("a good description")))
}

/// The time of a run in ns a member and step. Adaptive methods are charged with the number of steps
/// of the others.
fn time(model: &Model, method: &str) -> f64 {
    let row = registry::find(method).expect("a method");
    let run = model.bind(row).expect("a method for the system");
    let at = |phase: f64| -> Vec<f64> {
        (0..MEMBERS).map(|j| 0.3 * (phase + 0.7 * j as f64).sin()).collect()
    };
    let mut state = State::new(at(0.0), at(1.0)).expect("a finite state");
    let grid = Grid::of(0.05, STEPS).expect("a grid");
    let setting = if row.is_adaptive() {
        registry::Setting::Tolerance(afterbay_core::Tolerance::all(1e-6), 5.0)
    } else {
        registry::Setting::Step(grid)
    };
    let show = &mut |_: u64, _: StateRef<'_, f64>| ControlFlow::Continue(());
    let clock = Instant::now();
    run.run(setting, &mut state, u64::MAX, show).expect("a run");
    clock.elapsed().as_secs_f64() * 1e9 / (STEPS as f64 * MEMBERS as f64)
}
