//! One table of ratios: the generic step relative to the one written by hand, and relative to RK4
//! for the damped oscillator.
//!
//! The three are run in turn. Each ratio is the median over the turns of the ratio within a turn,
//! since load that lasts longer than a millisecond slows all three alike. Each figure in ns is the
//! median of its own times.

use afterbay_benches::{Pair, Run, STEPS, pairs};
use std::time::Instant;

/// The number of turns, odd, of which the median is taken.
const TURNS: usize = 301;

fn main() {
    // `cargo test` also runs benches, without this argument; a single turn then checks that they
    // work.
    let turns = if std::env::args().any(|argument| argument == "--bench") { TURNS } else { 1 };
    let pairs = pairs();
    println!(
        "{:12}  {:36} {:>10} {:>10} {:>7} {:>6} {:>7}",
        "", "ns a step", "generic", "by hand", "ratio", "bar", "to rk4"
    );
    for pair in &pairs {
        let times = measure(pair, &pairs[0].generic, turns);
        let ratio = |a: usize, b: usize| median(times.iter().map(|turn| turn[a] / turn[b]));
        let [generic, by_hand] = [0, 1].map(|i| median(times.iter().map(|turn| turn[i])));
        let Pair { subject, name, .. } = pair;
        println!(
            "{:12}  {name:36} {generic:10.2} {by_hand:10.2} {:7.3} {:6.2} {:7.3}",
            subject.name(),
            ratio(0, 1),
            subject.bar(),
            ratio(0, 2)
        );
    }
}

/// For each turn, the times in ns per step of the generic run, of the one by hand and of
/// `reference`.
fn measure(pair: &Pair, reference: &Run, turns: usize) -> Vec<[f64; 3]> {
    let turn = || [&pair.generic, &pair.by_hand, reference].map(time);
    turn();
    (0..turns).map(|_| turn()).collect()
}

fn time(run: &Run) -> f64 {
    let start = Instant::now();
    let end = run();
    let elapsed = start.elapsed();
    assert!(end.is_some(), "the run failed");
    elapsed.as_secs_f64() * 1e9 / STEPS as f64
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}
