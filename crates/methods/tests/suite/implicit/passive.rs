//! Passivity of `locally-exact` with friction that is not linear in the velocities, and its
//! exactness for D that depends on q.

use super::scenes::{Rubs, Web, drift, falls, wave};
use crate::bind::Curved;
use afterbay_core::{Method, Passive, State};
use afterbay_methods::{LinearExact, LocallyExact};
use afterbay_systems::{Custom, Description, DissipationText};

fn custom(potential: &str, friction: &[&str]) -> Custom<f64> {
    let friction = DissipationText::Forces(friction.iter().map(ToString::to_string).collect());
    Custom::new(&Description {
        potential: potential.into(),
        dissipation: friction,
        ..Description::default()
    })
    .unwrap()
}

/// Checks that steps of `locally-exact` conserve K and are passive where the system is.
fn only_fills(
    name: &str,
    system: &Curved<f64>,
    h: f64,
    steps: u32,
    q: Vec<f64>,
    p: Vec<f64>,
) -> u32 {
    let mut state = State::new(q, p).unwrap();
    let mut workspace = LocallyExact.workspace(system).unwrap();
    let passive = system.dissipation_form().passive;
    assert!(passive != Passive::No, "{name} owes nothing");
    for step in 0..steps {
        let before = state.clone();
        if LocallyExact.step(system, h, &mut state, &mut workspace).is_err() {
            return step;
        }
        assert_eq!(falls(passive, &before.w, &state.w), 0, "{name}, h = {h}, step {step}");
        let roundings = drift(system, h, &before, &state);
        assert!(
            roundings < 16.0,
            "{name}, h = {h}, step {step}: K is off by {roundings} roundings"
        );
    }
    steps
}

#[test]
fn the_wind_in_the_plane_takes_energy_only() {
    let texts =
        custom("(q1^2 + 2*q2^2)/2", &["0.4*p1*sqrt(p1^2 + p2^2)", "0.4*p2*sqrt(p1^2 + p2^2)"]);
    for h in [0.01, 0.1, 0.5, 1.0] {
        assert_eq!(only_fills("texts", &texts, h, 200, vec![1.0, -0.3], vec![0.2, 0.9]), 200);
        let web = Web::new(2, 1.0, 0.4, 0.0, 0.0, Rubs::Wind);
        assert_eq!(only_fills("web", &web, h, 200, vec![1.0, -0.3], vec![0.2, 0.9]), 200);
    }
}

#[test]
fn every_kind_of_friction_takes_energy_only() {
    for n in [2, 3, 5, 50] {
        for (rubs, g) in [
            (Rubs::Wind, 0.0),
            (Rubs::Wind, 0.7),
            (Rubs::Unevenly, 0.0),
            (Rubs::Unevenly, 0.7),
            (Rubs::Linearly, 0.7),
        ] {
            for beta in [0.0, 1.0] {
                let web = Web::new(n, 2.0, 0.3, g, beta, rubs);
                let name = format!("{rubs:?}, g = {g}, β = {beta}, N = {n}");
                let done = only_fills(&name, &web, 0.1, 20, wave(n, 1.0), wave(n, 2.3));
                assert_eq!(done, 20, "{name}");
                only_fills(&name, &web, 0.7, 20, wave(n, 1.0), wave(n, 2.3));
            }
        }
    }
}

/// H quadratic and D linear in both q and p: one step of any length is the exact flow, including w.
#[test]
fn friction_that_depends_on_q_linearly_is_exact() {
    for forces in
        [["0.3*p1 + 0.4*q1", "0.2*p2"], ["0.3*p1 + 0.4*q2 + 0.1*p2", "0.2*p2 - 0.3*q1 + 0.05*q2"]]
    {
        let system: &Curved<f64> = &custom("q1^2 + q2^2 + q1*q2", &forces);
        assert!(system.is_constant(), "{forces:?}");
        for h in [0.1, 1.0, 4.0] {
            let [mut a, mut b] =
                [0, 1].map(|_| State::new(vec![1.0, -0.4], vec![0.3, 0.8]).unwrap());
            LocallyExact
                .step(system, h, &mut a, &mut LocallyExact.workspace(system).unwrap())
                .unwrap();
            LinearExact
                .step(system, h, &mut b, &mut LinearExact.workspace(system).unwrap())
                .unwrap();
            for (a, b) in a.q.iter().chain(&a.p).chain(&a.w).zip(b.q.iter().chain(&b.p).chain(&b.w))
            {
                assert!((a - b).abs() < 1e-13 * (1.0 + h), "{forces:?}, h = {h}: {a} {b}");
            }
        }
    }
}
