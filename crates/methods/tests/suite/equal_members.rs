//! Chains and rings given by expressions, eight members at a time, move as they do one at a time.

use crate::bind::AnyMembers;
use crate::catalog::{chain, ring, written};
use crate::many::errors;
use crate::tiled::{one_at_a_time, side_by_side};
use afterbay_core::{Grid, Quad, Scalar, State};
use afterbay_methods::Composition;
use afterbay_methods::registry::{bind, find};
use afterbay_systems::{Description, DissipationText};
use std::sync::Arc;

/// Toda's chain with free ends, the chain of Fermi, Pasta, Ulam and Tsingou between walls, and
/// rings of rotors and of Van der Pol oscillators.
const TEXTS: [(&str, &str); 4] = [
    ("sum(i, 1, n-1, exp(q[i+1] - q[i]) - (q[i+1] - q[i]) - 1)", "0.1*p[i]"),
    (
        "q1^2/2 + q1^4/8 + q[n]^2/2 + q[n]^4/8 \
         + sum(i, 1, n-1, (q[i+1]-q[i])^2/2 + (q[i+1]-q[i])^4/8)",
        "0.02*p[i]",
    ),
    ("sum(i, 1, n, 2 - cos(q[wrap(i+1)] - q[i]) - cos(q[i]))", "0.1*abs(p[i])*p[i]"),
    ("sum(i, 1, n, q[i]^2/2 + 0.3*(q[wrap(i+1)] - q[i])^2/2)", "-0.5*(1 - q[i]^2)*p[i]"),
];

fn custom(n: usize, (potential, dissipation): (&str, &str)) -> Arc<AnyMembers> {
    let description = Description {
        potential: potential.to_owned(),
        dissipation: DissipationText::Forces(vec![dissipation.to_owned(); n]),
        ..Default::default()
    };
    written(&description).members()
}

fn start(n: usize) -> State<Vec<f64>> {
    let at = |phase: f64| (0..n).map(|j| 0.7 * (phase + 1.7 * j as f64).sin()).collect();
    State::new(at(0.3), at(2.1)).unwrap()
}

/// The largest difference of q, p and w.
fn apart(a: &State<Vec<f64>>, b: &State<Vec<f64>>) -> f64 {
    errors(a, b).into_iter().fold(0.0, f64::max)
}

#[test]
fn eight_at_a_time_move_as_one_at_a_time() {
    for text in TEXTS {
        for n in [16, 18, 36, 1030] {
            for composition in [Composition::sweep(), Composition::pair(), Composition::suzuki4()] {
                let system = &*custom(n, text);
                let grid = Grid::of(0.1, 11).unwrap();
                let eight = side_by_side(system, &composition, 1, grid, start(n));
                let one = one_at_a_time(system, &composition, grid, start(n));
                let off = apart(&eight, &one);
                assert!(off < 1e-13, "{} with {n} members: {off:e}", text.0);
                let (before, after) = (start(n).total(system), eight.total(system));
                assert!((after - before).abs() < 1e-13 * n as f64, "{}", text.0);
            }
        }
    }
}

#[test]
fn a_chain_from_text_moves_as_the_built_in_one() {
    let (n, grid) = (50, Grid::of(0.05, 40).unwrap());
    let (text, built_in) = (custom(n, TEXTS[1]), chain(n, 0.5, 0.02).members());
    let end = |system: &AnyMembers| side_by_side(system, &Composition::pair(), 1, grid, start(n));
    let off = apart(&end(&*text), &end(&*built_in));
    assert!(off < 1e-12, "{off:e}");
}

/// Chains and rings of equal members move by colours, whatever the scalar.
#[test]
fn the_order_of_the_coordinates_is_the_same_in_every_scalar() {
    for (system, n) in [(chain(4, 0.3, 0.1), 4), (chain(21, 0.3, 0.1), 21), (ring(6, 1.0, 0.5), 6)]
    {
        let q: Vec<f64> = (0..n).map(|j| (1.3 * j as f64).sin()).collect();
        let p: Vec<f64> = (0..n).map(|j| (0.7 * j as f64).cos()).collect();
        for name in ["increment-1", "increment-2", "increment-8"] {
            let row = find(name).unwrap();
            let mut state = State::new(q.clone(), p.clone()).unwrap();
            bind::<f64>(row, system.abilities()).unwrap().step(0.2, &mut state).unwrap();
            let [q, p] = [&q, &p].map(|part| part.iter().map(|&x| Quad::from_f64(x)).collect());
            let mut exact = State::<Vec<Quad>>::new(q, p).unwrap();
            let h = Quad::from_f64(0.2);
            bind::<Quad>(row, system.abilities()).unwrap().step(h, &mut exact).unwrap();
            let off = |found: &[f64], exact: &[Quad]| {
                let apart = found.iter().zip(exact).map(|(x, y)| (x - y.to_f64()).abs());
                apart.fold(0.0, f64::max)
            };
            let off = off(&state.q, &exact.q).max(off(&state.p, &exact.p));
            assert!(off < 1e-13, "{name} with {n} members: {off:e}");
        }
    }
}
