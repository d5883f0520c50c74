//! A stiff degree of freedom beside a slow one: the tolerance bounds the errors of both.

use crate::catalog::{As, Built, written};
use afterbay_core::{State, StateRef, Tolerance};
use afterbay_methods::registry::{Setting, find};
use afterbay_systems::{Description, DissipationText};
use std::ops::ControlFlow;

const METHODS: [&str; 2] = ["adaptive-collocation", "adaptive-radau"];
const TOLERANCES: [f64; 5] = [1e-4, 1e-5, 1e-6, 1e-8, 1e-10];
/// The largest error relative to the tolerance, which allows twice itself at the size 1.
const LARGEST_SHARE: f64 = 5.0;
/// The strong friction b.
const FRICTION: f64 = 1e6;
/// The time span of a run.
const END: f64 = 30.0;

/// All runs from (q, p) end at the exact (q, p) within the tolerance, in few steps.
fn check(name: &str, system: &Built, from: [[f64; 2]; 2], exact: [[f64; 2]; 2], most: u64) {
    for method in METHODS {
        for tolerance in TOLERANCES {
            let [q, p] = from.map(Vec::from);
            let mut state = State::new(q, p).unwrap();
            let run = system.bind(find(method).unwrap(), As::Separable).expect("it applies");
            let mut show = |_: u64, _: StateRef<'_, f64>| ControlFlow::Continue(());
            let setting = Setting::Tolerance(Tolerance::all(tolerance), END);
            let done = run.run(setting, &mut state, 1, &mut show).expect("it runs");
            let found = state.q.iter().chain(&state.p);
            let apart = found.zip(exact.as_flattened()).map(|(a, b)| (a - b).abs());
            let share = apart.fold(0.0, f64::max) / tolerance;
            assert!(share <= LARGEST_SHARE, "{name}, {method}, {tolerance:e}: {share:e}");
            assert!(done.accepted < most, "{name}, {method}, {tolerance:e}: {done:?}");
        }
    }
}

fn springs(potential: &str, friction: [[f64; 2]; 2]) -> Built {
    let rows = friction.map(|row| row.map(|x| format!("{x:e}")).to_vec()).to_vec();
    let still = friction == [[0.0; 2]; 2];
    written(&Description {
        potential: potential.into(),
        dissipation: if still { DissipationText::None } else { DissipationText::Matrix(rows) },
        ..Description::default()
    })
}

/// q'' + b q' + q = 0 from (1, 1): q and p.
fn overdamped(t: f64) -> [f64; 2] {
    let fast = -(FRICTION / 2.0 + (FRICTION * FRICTION / 4.0 - 1.0).sqrt());
    let slow = 1.0 / fast;
    let share = (1.0 - slow) / (fast - slow);
    let [a, c] = [(1.0 - share) * (slow * t).exp(), share * (fast * t).exp()];
    [a + c, slow * a + fast * c]
}

#[test]
fn an_oscillator_beside_a_stiff_spring_at_rest_is_right() {
    let system = springs("5e9*q1^2 + q2^2/2", [[0.0; 2]; 2]);
    let exact = [[0.0, END.cos()], [0.0, -END.sin()]];
    // Sweeps take 1e5 steps before they give way to Newton's method.
    check("spring", &system, [[0.0, 1.0], [0.0; 2]], exact, 200_000);
}

#[test]
fn an_oscillator_beside_strong_friction_is_right() {
    let system = springs("(q1^2 + q2^2)/2", [[FRICTION, 0.0], [0.0, 0.0]]);
    let [q, p] = overdamped(END);
    let exact = [[q, END.cos()], [p, -END.sin()]];
    check("friction", &system, [[1.0, 1.0], [1.0, 0.0]], exact, 300);
}

/// Turns the coordinates of the system above: friction couples both degrees of freedom then.
#[test]
fn an_oscillator_beside_strong_friction_is_right_in_turned_coordinates() {
    let [c, s] = [0.6, 0.8];
    let b = FRICTION;
    let system = springs("(q1^2 + q2^2)/2", [[b * c * c, b * c * s], [b * c * s, b * s * s]]);
    let turned = |[x, y]: [f64; 2]| [c * x - s * y, s * x + c * y];
    let [q, p] = overdamped(END);
    let exact = [turned([q, END.cos()]), turned([p, -END.sin()])];
    check("turned", &system, [turned([1.0, 1.0]), turned([1.0, 0.0])], exact, 300);
}
