//! Chains and rings given by expressions, eight members at a time, move as they do one at a time.

use afterbay_core::{Grid, State, System, integrate};
use afterbay_methods::{Composition, Increment, Tiled};
use afterbay_systems::{Custom, Description, DissipationText, FputChain};

/// Toda's chain with free ends, the chain of Fermi, Pasta, Ulam and Tsingou between walls, and
/// rings of rotors and of Van der Pol oscillators.
const TEXTS: [(&str, &str); 4] = [
    ("sum(i, 1, n-1, exp(q[i+1] - q[i]) - (q[i+1] - q[i]) - 1)", "0.1*p[i]"),
    (
        "q1^2/2 + q1^4/8 + q[n]^2/2 + q[n]^4/8 + sum(i, 1, n-1, (q[i+1]-q[i])^2/2 + (q[i+1]-q[i])^4/8)",
        "0.02*p[i]",
    ),
    ("sum(i, 1, n, 2 - cos(q[wrap(i+1)] - q[i]) - cos(q[i]))", "0.1*abs(p[i])*p[i]"),
    ("sum(i, 1, n, q[i]^2/2 + 0.3*(q[wrap(i+1)] - q[i])^2/2)", "-0.5*(1 - q[i]^2)*p[i]"),
];

fn custom(n: usize, (potential, dissipation): (&str, &str)) -> Custom<f64> {
    let description = Description {
        potential: potential.to_owned(),
        dissipation: DissipationText::Forces(vec![dissipation.to_owned(); n]),
        ..Default::default()
    };
    Custom::new(&description).unwrap()
}

fn start(n: usize) -> State<Vec<f64>> {
    let at = |phase: f64| (0..n).map(|j| 0.7 * (phase + 1.7 * j as f64).sin()).collect();
    State::new(at(0.3), at(2.1)).unwrap()
}

/// The largest difference of q, p and w.
fn apart(a: &State<Vec<f64>>, b: &State<Vec<f64>>) -> f64 {
    let pairs = [(&a.q, &b.q), (&a.p, &b.p), (&a.w, &b.w)];
    let differences = pairs.into_iter().flat_map(|(a, b)| a.iter().zip(b));
    differences.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn eight_at_a_time_move_as_one_at_a_time() {
    for text in TEXTS {
        for n in [16, 18, 36, 1030] {
            for composition in [Composition::sweep(), Composition::pair(), Composition::suzuki4()] {
                let system = custom(n, text);
                let grid = Grid::of(0.1, 11).unwrap();
                let (mut eight, mut one) = (start(n), start(n));
                let tiled = Tiled::new(composition.clone());
                integrate(&tiled, &system, grid, &mut eight, &mut ()).unwrap();
                let order = system.coupling().coloured(n);
                let single = Increment::new(composition).in_order(order);
                integrate(&single, &system, grid, &mut one, &mut ()).unwrap();
                let off = apart(&eight, &one);
                assert!(off < 1e-13, "{} with {n} members: {off:e}", text.0);
                let (before, after) = (start(n).total(&system), eight.total(&system));
                assert!((after - before).abs() < 1e-13 * n as f64, "{}", text.0);
            }
        }
    }
}

#[test]
fn a_chain_from_text_moves_as_the_built_in_one() {
    let (n, grid) = (50, Grid::of(0.05, 40).unwrap());
    let (text, built_in) = (custom(n, TEXTS[1]), FputChain::new(n, 0.5, 0.02).unwrap());
    let method = Tiled::new(Composition::pair());
    let (mut a, mut b) = (start(n), start(n));
    integrate(&method, &text, grid, &mut a, &mut ()).unwrap();
    integrate(&method, &built_in, grid, &mut b, &mut ()).unwrap();
    let off = apart(&a, &b);
    assert!(off < 1e-12, "{off:e}");
}
