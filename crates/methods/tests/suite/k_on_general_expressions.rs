//! K on random H(q, p) at any step size, for every method that claims to keep it.

use crate::catalog::{As, Built, written_general};
use crate::k_on_expressions::{Count, judge, size};
use afterbay_core::{Grid, Method, Passive, PhasePlane, State, StateRef};
use afterbay_methods::registry::{self, FIXED};
use afterbay_methods::{Composition, GeneralIncrement};
use afterbay_systems::{DissipationText, GeneralDescription};
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};
use std::collections::BTreeMap;
use std::ops::ControlFlow;

/// The terms of a random H beside Σ (p_j² + q_j²/10)/2. No combination of them has poles.
const TERMS: [&str; 10] = [
    "p1^2*q1^2/4",
    "sqrt(1 + (p1 - q2)^2)",
    "p1*p2*cos(q1 - q2)/4",
    "(p1^2 + p2^2)/(2 + sin(q1))",
    "log(1 + p1^2*q2^2)",
    "(p1 - q2)^2/2",
    "exp(-p2^2)*cos(q2)",
    "max(0, p1 + q1)^2",
    "atan(p1 + 3*q2)",
    "(p2^2 + q2^2)^2/8",
];

/// The forces, with the velocity of the degree of freedom in the place of v.
const FORCES: [&str; 4] = ["0", "c*v", "c*abs(v)*v", "c*(1 + q1^2)*v"];

#[derive(Clone, Debug)]
struct Case {
    hamiltonian: String,
    force: &'static str,
    c: f64,
    h: f64,
    q: [f64; 2],
    p: [f64; 2],
}

fn case() -> impl Strategy<Value = Case> {
    let picks = prop::collection::vec((0..TERMS.len(), 0.1..1.0_f64), 1..4);
    let numbers = (-5.0..1.0_f64, 0.0..1.0_f64, 0..FORCES.len());
    let places = (prop::array::uniform2(-2.0..2.0_f64), prop::array::uniform2(-3.0..3.0_f64));
    (picks, numbers, places).prop_map(|(picks, (exponent, c, force), (q, p))| {
        let terms = picks.into_iter().map(|(term, scale)| format!(" + {scale:?}*{}", TERMS[term]));
        let hamiltonian = "(p1^2 + p2^2)/2 + (q1^2 + q2^2)/20".to_owned();
        let hamiltonian = terms.fold(hamiltonian, |sum, term| sum + &term);
        Case { hamiltonian, force: FORCES[force], c, h: 10f64.powf(exponent), q, p }
    })
}

fn system(hamiltonian: &str, force: &str, c: f64, n: usize) -> Built {
    let force = |j: usize| format!("{} + 0*c", force.replace('v', &format!("v{j}")));
    written_general(&GeneralDescription {
        hamiltonian: hamiltonian.to_owned(),
        dissipation: DissipationText::Forces((1..=n).map(force).collect()),
        parameters: vec![("c".to_owned(), c)],
        ..GeneralDescription::default()
    })
}

/// The largest sum of the terms of K between the pairs of sweeps of a composition, some of which
/// run backwards.
fn largest_within(
    system: &dyn PhasePlane<f64>,
    of: &Composition,
    h: f64,
    start: &State<Vec<f64>>,
) -> f64 {
    let pair = GeneralIncrement::new(Composition::pair());
    let mut workspace = pair.workspace(system).expect("it applies");
    let (mut state, fractions) = (start.clone(), of.fractions::<f64>().collect::<Vec<_>>());
    fractions.chunks(2).fold(0.0, |most: f64, pair_of| {
        let _ = pair.step(system, pair_of.iter().sum::<f64>() * h, &mut state, &mut workspace);
        most.max(size(system, &state))
    })
}

/// K, and passivity of the methods that use the mean velocity.
#[test]
fn every_method_keeps_k_on_random_hamiltonians() {
    let counts = std::cell::RefCell::new(BTreeMap::<_, Count>::new());
    TestRunner::new(Config { failure_persistence: None, ..Config::with_cases(150) })
        .run(&case(), |case| {
            let system = system(&case.hamiltonian, case.force, case.c, 2);
            let planes = system.planes::<f64>();
            prop_assert_eq!(system.dissipation_form().passive, Passive::Each);
            let start = State::new(case.q.to_vec(), case.p.to_vec()).unwrap();
            for row in FIXED.iter().filter(|row| row.keeps_k) {
                let Ok(bound) = registry::bind::<f64>(row, system.abilities()) else { continue };
                let (mut states, mut state) = (Vec::new(), start.clone());
                let mut show = |_: u64, at: StateRef<'_, f64>| {
                    let [q, p, w] = [at.q, at.p, at.w].map(<[f64]>::to_vec);
                    states.push(State { q, p, w, t: at.t });
                    ControlFlow::Continue(())
                };
                let grid = Grid { h: case.h, steps: 3 };
                let mut counts = counts.borrow_mut();
                let count = counts.entry(row.name).or_default();
                if let Err(error) = bound.run(grid, &mut state, 1, &mut show) {
                    count.fail(&error, &format!("{} on {case:?}", row.name));
                }
                let before = count.worst;
                let composition = match row.name {
                    "increment-4" => Some(Composition::suzuki4()),
                    "increment-6" => Some(Composition::yoshida6()),
                    "increment-8" => Some(Composition::kahan_li8()),
                    _ => None,
                };
                count.look(&*system, &states, |from| {
                    composition
                        .as_ref()
                        .map_or(0.0, |of| largest_within(&*planes, of, case.h, from))
                });
                if count.worst > before.max(3e-13) {
                    println!("{:.1e} {} on {case:?}", count.worst, row.name);
                }
                if row.name == "gonzalez" || row.name == "increment-2" {
                    for pair in states.windows(2) {
                        let violated = Passive::Each.violated(&pair[0].w, &pair[1].w);
                        prop_assert!(!violated, "{} on {case:?}", row.name);
                    }
                }
            }
            Ok(())
        })
        .unwrap();
    let counts = counts.into_inner();
    assert!(counts.len() > 10, "{counts:?}");
    judge(&counts, 3e-13, 0.2);
}

/// Steps from large states, one short enough to be taken. On the others the terms of an equation
/// differ so much that Newton's method stops at a state with w up to 1e16 times K.
#[test]
fn a_step_near_overflow_keeps_k_or_is_refused() {
    let one = "q1^2/20 + p1^2/2 + 0.5*log(1 + p1^2*0.3^2) + 0.7*sqrt(1 + p1^2)";
    let two = "(q1^2 + q2^2)/20 + (p1^2 + p2^2)/2 + 0.34*abs(p1)*p1^2/3 + 1.64*q1*p2";
    let scenes = [
        (one, 1e-104, vec![-1e100], vec![5e100]),
        (one, 6.67e-97, vec![-1.05e144], vec![5.67e144]),
        (two, 7.3e-94, vec![-3.08e146, -1.17e147], vec![-3.5, -3.6]),
        (two, 7.3e-94, vec![3.08e146, -1.17e147], vec![3.5e98, -3.6e100]),
    ];
    let mut count = Count::default();
    for (hamiltonian, h, q, p) in scenes {
        let system = system(hamiltonian, "c*abs(v)*v", 0.47, q.len());
        for row in FIXED.iter().filter(|row| row.keeps_k) {
            let Ok(bound) = registry::bind::<f64>(row, system.abilities()) else { continue };
            let before = State::new(q.clone(), p.clone()).unwrap();
            let mut state = before.clone();
            let mut show = |_: u64, _: StateRef<'_, f64>| ControlFlow::Continue(());
            if bound.run(Grid { h, steps: 1 }, &mut state, 1, &mut show).is_err() {
                continue;
            }
            count.look(&*system, &[before, state], |_| 0.0);
            assert!(count.worst <= 3e-13, "{}: {count:?} {hamiltonian}", row.name);
        }
    }
    assert!(count.taken > 0, "no step was taken");
}

/// A wall thinner than the step: no method takes the wall for a rounding of H. Each keeps K, or
/// ends with a failure.
#[test]
fn a_thin_wall_is_no_rounding() {
    for (width, h, q) in [(1e-6, 0.005, -0.0271), (1e-6, 0.02, 0.0), (1e-8, 0.1, 0.0)] {
        let system = system(&format!("p1^2/2 + {width:?}/(q1 - 1)^2"), "0", 0.0, 1);
        let mut completed = 0;
        for row in FIXED.iter().filter(|row| row.keeps_k) {
            let Ok(run) = system.bind(row, As::General) else { continue };
            let mut state = State::new(vec![q], vec![1.0]).unwrap();
            let (before, mut off) = (state.total(&*system), 0.0_f64);
            let outcome = run.run(Grid::new(h, 3.0).unwrap(), &mut state, 1, &mut |_, state| {
                off = off.max((state.total(&*system) - before).abs());
                ControlFlow::Continue(())
            });
            assert!(off < 1e-12, "{}, h = {h}: K is off by {off:e}", row.name);
            completed += u32::from(outcome.is_ok());
        }
        assert!(completed > 0, "{width} {h}");
    }
}
