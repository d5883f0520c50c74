//! Computes the end states of the test set by Taylor series in 106 bits, rounded to `f64`:
//!
//! ```text
//! cargo run --release -p afterbay-peers --example references > benches/peers/data/references.csv
//! ```
//!
//! This takes minutes, for C2 longer than for all others together. The row of C2 in the repository
//! is the end state computed by heyoka (`data/references.py`); this example has not confirmed it
//! yet. Names of scenes after `--` select these scenes.
//!
//! Each end state is computed with two numbers of terms, which take different steps. Their
//! difference is printed to stderr, with the largest number.

use afterbay_analysis::Model;
use afterbay_core::{ExactFlow, Quad, Scalar, Series, State, System, taylor};
use afterbay_peers::scenes;
use afterbay_systems::{DampedDoublePendulum, DampedOscillator, Duffing, FputChain, VanDerPol};
use std::time::Instant;

/// The end states computed with 16 and with 24 terms.
macro_rules! both {
    ($system:expr, $problem:expr) => {{
        let (system, problem) = ($system.map(Quad::from_f64), $problem);
        (
            end::<16>(&system.map(Series::constant), &problem.q, &problem.p, problem.end)?,
            end::<24>(&system.map(Series::constant), &problem.q, &problem.p, problem.end)?,
        )
    }};
}
type Ends = Vec<[Quad; 3]>;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("scene,dof,q,p,w");
    let named: Vec<_> = std::env::args().skip(1).collect();
    for scene in scenes::all() {
        if !named.is_empty() && !named.iter().any(|name| name == scene.name) {
            continue;
        }
        let clock = Instant::now();
        let problem = &*scene.problem;
        let (q, p) = (&problem.q, &problem.p);
        let Model::Listed(_, parameters) = &problem.model else {
            return Err("a system without a series".into());
        };
        let (coarse, fine) = match (problem.model.name(), &parameters[..]) {
            ("damped-oscillator", &[k, b]) => {
                let [k, b] = [k, b].map(Quad::from_f64);
                let exact = DampedOscillator::new(k, b)?;
                let mut state: State<Vec<Quad>> = problem.start()?;
                exact.flow(Quad::from_f64(problem.end), &mut state);
                let by_series = end::<24>(&exact.map(Series::constant), q, p, problem.end)?;
                (by_series, vec![[state.q[0], state.p[0], state.w[0]]])
            }
            ("duffing", &[alpha, beta, c]) => both!(Duffing::new(alpha, beta, c)?, problem),
            ("van-der-pol", &[mu]) => both!(VanDerPol::new(mu)?, problem),
            ("fput-chain", &[n, beta, c]) => both!(FputChain::new(n as usize, beta, c)?, problem),
            ("damped-double-pendulum", &[m1, m2, l1, l2, g, c1, c2]) => {
                both!(DampedDoublePendulum::new([m1, m2], [l1, l2], g, [c1, c2])?, problem)
            }
            _ => return Err("a system without a series".into()),
        };
        for (j, state) in fine.iter().enumerate() {
            let [q, p, w] = state.map(Scalar::to_f64);
            println!("{},{j},{q:?},{p:?},{w:?}", scene.name);
        }
        let entries = || coarse.iter().flatten().zip(fine.iter().flatten());
        let apart = entries().map(|(&a, &b)| (a - b).abs().to_f64()).fold(0.0, f64::max);
        let largest = entries().map(|(_, b)| b.abs().to_f64()).fold(0.0, f64::max);
        let seconds = clock.elapsed().as_secs_f64();
        eprintln!("{:6} {apart:.1e} apart, largest {largest:.1e}, {seconds:.1} s", scene.name);
    }
    Ok(())
}

fn end<const M: usize>(
    system: &impl System<Series<Quad, M>>,
    q: &[f64],
    p: &[f64],
    end: f64,
) -> Result<Ends, Box<dyn std::error::Error>> {
    let lift = |part: &[f64]| part.iter().map(|&x| Quad::from_f64(x)).collect::<Vec<_>>();
    let start = State::new(lift(q), lift(p))?;
    let states = taylor::trajectory::<_, _, M>(system, &start, Quad::from_f64(end), 1)?;
    let last = &states[1];
    Ok((0..q.len()).map(|j| [last.q[j], last.p[j], last.w[j]]).collect())
}
