//! Maps of stability: eight cells in lanes compared with one at a time, two cores compared with
//! one, and a whole map.
//!
//! The alternatives are run in turn. Each figure is the minimum over the turns, since other load on
//! the machine only increases times. Their cells and rows must be equal.

use afterbay_analysis::Model;
use afterbay_analysis::progress::Silent;
use afterbay_analysis::study::Problem;
use afterbay_analysis::study::stability::{Map, StabilityRow};
use afterbay_methods::registry::{self, Row};
use afterbay_systems::{DAMPED_OSCILLATOR, DUFFING};
use rayon::ThreadPool;
use std::time::Instant;

const METHODS: [&str; 3] = ["leapfrog", "rk4", "moddg"];
/// The number of turns of which the minimum is taken.
const TURNS: usize = 21;
/// The number of steps of a cell.
const STEPS: u64 = 10_000;

fn main() {
    // `cargo test` also runs benches, without this argument; a single turn then checks that they
    // work.
    let full = std::env::args().any(|argument| argument == "--bench");
    let (turns, least_steps) = if full { (TURNS, STEPS) } else { (1, 100) };
    let pools = [1, 2].map(pool);

    println!(
        "{:36} {:>10} {:>10} {:>7}",
        "ns a step and cell, one core", "alone", "lanes", "ratio"
    );
    let (values, steps) = (spread(16, 0.02, 1.0, false), [0.02, 0.05, 0.1, 0.2]);
    for (model, name) in [(oscillator(), "b"), (duffing(), "c")] {
        for method in METHODS {
            let map = map(model.clone(), name, &values, &steps, least_steps);
            let [alone, lanes] = compare(&map, &rows(&[method]), &pools[0], turns);
            println!(
                "{:36} {alone:10.3} {lanes:10.3} {:7.2}",
                format!("{method}, {}", model.name()),
                alone / lanes
            );
        }
    }

    println!("\n{:36} {:>10} {:>10} {:>7}", "ms, lanes", "one core", "two", "ratio");
    let (values, steps) = (spread(64, 0.0, 1.0, false), spread(32, 0.01, 1.0, true));
    for model in [oscillator(), duffing()] {
        let name = if model.name() == "duffing" { "c" } else { "b" };
        let map = map(model.clone(), name, &values, &steps, least_steps);
        let [one, two] = cores(&map, &rows(&METHODS), &pools, turns);
        println!("{:36} {:10.1} {:10.1} {:7.2}", model.name(), one * 1e3, two * 1e3, one / two);
    }

    let count = if full { 200 } else { 16 };
    let (values, steps) = (spread(count, 0.0, 2.0, false), spread(count, 0.01, 3.0, true));
    let whole = map(duffing(), "c", &values, &steps, least_steps);
    let (mut cells, mut all, mut exact) = (Vec::new(), f64::INFINITY, f64::INFINITY);
    for _ in 0..turns.min(3) {
        let clock = Instant::now();
        cells = pools[1].install(|| {
            let references = whole.references(&Silent).expect("references");
            exact = exact.min(clock.elapsed().as_secs_f64());
            whole.judge(&rows(&METHODS), &references, &Silent).expect("cells")
        });
        all = all.min(clock.elapsed().as_secs_f64());
    }
    let done: u64 = cells.iter().map(|cell| cell.steps_done).sum();
    let right = cells.iter().filter(|cell| cell.outcome == "completed").count();
    println!(
        "\nDuffing, {count} x {count} cells of {least_steps} steps, {} methods, \
         two cores: {all:.2} s, of which references {exact:.2} s; \
         {right} of {} runs to the end, {done} steps",
        METHODS.len(),
        cells.len(),
    );
}

fn oscillator() -> Model {
    Model::of(&DAMPED_OSCILLATOR, &[1.0, 0.1])
}

fn duffing() -> Model {
    Model::of(&DUFFING, &[1.0, 0.5, 0.1])
}

fn map<'a>(
    model: Model,
    parameter: &'a str,
    values: &'a [f64],
    steps: &'a [f64],
    least_steps: u64,
) -> Map<'a> {
    let problem = Problem { model, q: vec![1.3], p: vec![-0.4], end: 1.0 };
    Map { problem, parameter, values, steps, end: 1.0, least_steps }
}

/// `count` values from `low` to `high`.
fn spread(count: usize, low: f64, high: f64, logarithmic: bool) -> Vec<f64> {
    let share = |i: usize| i as f64 / (count - 1) as f64;
    let at = |i| {
        if logarithmic { low * (high / low).powf(share(i)) } else { low + (high - low) * share(i) }
    };
    (0..count).map(at).collect()
}

fn rows(names: &[&str]) -> Vec<&'static Row> {
    names.iter().map(|name| registry::find(name).expect("a registered method")).collect()
}

fn pool(threads: usize) -> ThreadPool {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool")
}

fn seconds(run: impl Fn() -> Vec<StabilityRow>) -> (f64, Vec<StabilityRow>) {
    let clock = Instant::now();
    let cells = run();
    (clock.elapsed().as_secs_f64(), cells)
}

/// The times in ns per step and cell, one at a time and in lanes.
fn compare(map: &Map<'_>, methods: &[&'static Row], pool: &ThreadPool, turns: usize) -> [f64; 2] {
    pool.install(|| {
        let references = map.references(&Silent).expect("references");
        let mut least = [f64::INFINITY; 2];
        for _ in 0..turns {
            let (alone, one) =
                seconds(|| map.judge_alone(methods, &references, &Silent).expect("cells"));
            let (lanes, eight) =
                seconds(|| map.judge(methods, &references, &Silent).expect("cells"));
            assert_eq!(one, eight);
            let steps: u64 = one.iter().map(|cell| cell.steps_done).sum();
            least = [
                least[0].min(alone * 1e9 / steps as f64),
                least[1].min(lanes * 1e9 / steps as f64),
            ];
        }
        least
    })
}

/// The times of a map in seconds on each pool.
fn cores(
    map: &Map<'_>,
    methods: &[&'static Row],
    pools: &[ThreadPool; 2],
    turns: usize,
) -> [f64; 2] {
    let references = map.references(&Silent).expect("references");
    let mut least = [f64::INFINITY; 2];
    for _ in 0..turns {
        let found = pools.each_ref().map(|pool| {
            pool.install(|| seconds(|| map.judge(methods, &references, &Silent).expect("cells")))
        });
        assert_eq!(found[0].1, found[1].1);
        least = [least[0].min(found[0].0), least[1].min(found[1].0)];
    }
    least
}
