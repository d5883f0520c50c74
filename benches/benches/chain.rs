//! The damped β-chain with an increasing number of members: the cost of a step of order 2 per
//! degree of freedom.
//!
//! Runs are timed in turn. Each figure is the median over the turns; each ratio is the median of
//! the ratios within a turn.

use afterbay_benches::chain::Colours;
use afterbay_core::{Coupling, Grid, Method, State, integrate};
use afterbay_methods::{Composition, Gonzalez, Increment, Leapfrog, Tiled};
use afterbay_systems::FputChain;
use std::f64::consts::PI;
use std::time::Instant;

/// The number of turns, odd, of which the median is taken.
const TURNS: usize = 11;
/// The number of members times the number of steps of a run.
const WORK: usize = 1 << 21;
const H: f64 = 0.05;

fn main() {
    // `cargo test` also runs benches, without this argument; a single turn then checks that they
    // work.
    let full = std::env::args().any(|argument| argument == "--bench");
    let (turns, sizes) =
        if full { (TURNS, &[112, 1008, 10_000, 100_000, 1_000_000][..]) } else { (1, &[112][..]) };
    let names = ["tiled", "by hand", "2 threads", "one by one", "gonzalez", "leapfrog"];
    println!("ns a degree of freedom and step, h = {H}, from the first mode");
    println!(
        "{:>8} {}   tiled/by hand  2 threads/1  tiled/gonzalez",
        "n",
        names.map(|name| format!("{name:>11}")).join("")
    );
    let mut line = Vec::new();
    for &n in sizes {
        let turns = if n > 100_000 { turns.min(3) } else { turns };
        let times: Vec<[f64; 6]> = (0..turns).map(|_| turn(n)).collect();
        let [tiled, hand, threads, one, gonzalez, leapfrog] =
            [0, 1, 2, 3, 4, 5].map(|i| median(times.iter().map(|turn| turn[i])));
        let ratio = |a: usize, b: usize| median(times.iter().map(|turn| turn[a] / turn[b]));
        println!(
            "{n:8} {tiled:11.2}{hand:11.2}{threads:11.2}{one:11.2}{gonzalez:11.2}{leapfrog:11.2}\
             {:16.3}  {:11.3}  {:14.3}",
            ratio(0, 1),
            ratio(2, 0),
            ratio(0, 4)
        );
        line.push(((n as f64).ln(), (tiled * n as f64).ln()));
    }
    if full {
        println!("log-log slope of the time of a tiled step: {:.3}", slope(&line));
    }
}

fn turn(n: usize) -> [f64; 6] {
    let pair = Composition::pair;
    let coloured = Increment::new(pair()).in_order(Coupling::Chain.coloured(n));
    [
        time(n, &Tiled::new(pair())),
        by_hand(n),
        time(n, &Tiled::new(pair()).on_threads(2)),
        time(n, &coloured),
        time(n, &Gonzalez::default()),
        time(n, &Leapfrog),
    ]
}

fn time<M: Method<Vec<f64>, FputChain<f64>>>(n: usize, method: &M) -> f64 {
    let system = FputChain::new(n, 1.0, 0.01).expect("parameters in range");
    let q = (1..=n).map(|j| (PI * j as f64 / (n + 1) as f64).sin()).collect();
    let mut state = State::new(q, vec![0.0; n]).expect("a finite state");
    let mut carry = |steps: usize| {
        integrate(method, &system, Grid::of(H, steps as u64).expect("a grid"), &mut state, &mut ())
            .expect("a run")
    };
    carry(1);
    let clock = Instant::now();
    carry(steps(n));
    clock.elapsed().as_secs_f64() * 1e9 / (n * steps(n)) as f64
}

fn by_hand(n: usize) -> f64 {
    let mut chain = Colours::new(n, 1.0, 0.01);
    let total = chain.total();
    chain.step(H);
    let clock = Instant::now();
    (0..steps(n)).for_each(|_| chain.step(H));
    let elapsed = clock.elapsed().as_secs_f64() * 1e9 / (n * steps(n)) as f64;
    // The extensions of the bonds of a long smooth chain are differences of nearly equal numbers.
    let rounding = 1e-12_f64.max(1e-15 * n as f64);
    assert!((chain.total() - total).abs() < rounding * total, "by hand, K is not kept");
    elapsed
}

fn steps(n: usize) -> usize {
    (WORK / n).max(8)
}

/// The slope of the least-squares line through the points.
fn slope(points: &[(f64, f64)]) -> f64 {
    let mean = |f: fn(&(f64, f64)) -> f64| points.iter().map(f).sum::<f64>() / points.len() as f64;
    let (x, y) = (mean(|point| point.0), mean(|point| point.1));
    let both: f64 = points.iter().map(|point| (point.0 - x) * (point.1 - y)).sum();
    both / points.iter().map(|point| (point.0 - x).powi(2)).sum::<f64>()
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}
