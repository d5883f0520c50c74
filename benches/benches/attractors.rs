//! Studies of attractors of the driven Duffing oscillator: a bifurcation diagram, in lanes and one
//! run at a time, beside loops written by hand for this equation; section points; and a map of
//! basins.
//!
//! The two of a ratio are run in turn, and each figure is the minimum over the turns.

use afterbay_analysis::progress::Silent;
use afterbay_analysis::study::Problem;
use afterbay_analysis::study::basins::{Axis, Basins};
use afterbay_analysis::study::bifurcation::Bifurcation;
use afterbay_analysis::study::dynamics::Dynamics;
use afterbay_analysis::study::poincare::Poincare;
use afterbay_analysis::study::section::Section;
use afterbay_analysis::{Spacing, Variable};
use afterbay_experiments::scene::Scene;
use afterbay_methods::registry::{Row, find};
use rayon::prelude::*;
use std::f64::consts::TAU;
use std::hint::black_box;
use std::time::Instant;

const SECTION: Section = Section::Stroboscopic { interval: None };
const STEPS: u64 = 64;
const C: f64 = 0.05;

const SCENE: &str = r#"
[system]
name = "duffing"
parameters = { alpha = 0.0, beta = 1.0, c = 0.05 }
[drive]
force = ["f*cos(omega*t)"]
parameters = { f = 7.5, omega = 1.0 }
[initial]
q = [2.5]
p = [0.0]
[time]
end = 1.0
step = 0.1
"#;

fn main() {
    // `cargo test` also runs benches, without this argument; small sizes then check that they work.
    let full = std::env::args().any(|argument| argument == "--bench");
    let (turns, values, returns, side) = if full { (5, 1000, 200, 400) } else { (1, 8, 2, 8) };
    let problem = Scene::read(SCENE).expect("a scene").problem;
    let methods = ["moddg", "rk4"].map(|name| find(name).expect("a method"));

    println!("{:44} {:>9} {:>9} {:>6}", "ns a step, all cores", "afterbay", "other", "ratio");
    let forces: Vec<f64> = (0..values).map(|i| 5.0 + 5.0 * i as f64 / values as f64).collect();
    let study = Bifurcation {
        problem: problem.clone(),
        section: SECTION,
        parameter: "f".into(),
        values: forces.clone(),
        spacing: Spacing::Linear,
        transient: returns,
        points: returns,
        follow: false,
    };
    let steps = 2 * returns * STEPS * values as u64;
    let mut seconds = 0.0;
    for (row, by_hand) in methods.into_iter().zip([by_hand_moddg as Step, by_hand_rk4]) {
        let hand = || forces.par_iter().map(|&f| hand_written(by_hand, f, returns)).sum::<f64>();
        let diagram = || drop(black_box(study.run(row, TAU / STEPS as f64, &Silent)));
        let [own, other] = least(turns, &[&diagram, &|| assert!(black_box(hand()).is_finite())]);
        report(&format!("{}, beside a loop by hand", row.name), [own, other], steps);
        seconds += own;
        let one =
            Bifurcation { follow: true, values: forces[..values / 8].to_vec(), ..study.clone() };
        let alone = || drop(black_box(one.run(row, TAU / STEPS as f64, &Silent)));
        let [single] = least(turns.min(2), &[&alone]);
        // Both ways, so twice the runs.
        let single =
            single * steps as f64 / (2.0 * (values / 8) as f64 * (2 * returns * STEPS) as f64);
        report(&format!("{}, beside one run at a time", row.name), [own, single], steps);
    }
    println!("the diagram of both methods: {seconds:.2} s");
    let [points] = least(turns.min(2), &[&|| section(&problem, methods[1], returns)]);
    let count = 64 * 80 * returns;
    println!(
        "{count} section points of rk4: {points:.2} s, {:.1e} a second",
        count as f64 / points
    );
    let [map] = least(1, &[&|| basins(side)]);
    println!("a map of {side} x {side} basins with moddg: {map:.1} s");
}

/// The least time of each of several tasks, run in turn.
fn least<const N: usize>(turns: usize, tasks: &[&dyn Fn(); N]) -> [f64; N] {
    let mut least = [f64::INFINITY; N];
    for _ in 0..turns {
        for (least, task) in least.iter_mut().zip(tasks) {
            let begin = Instant::now();
            task();
            *least = least.min(begin.elapsed().as_secs_f64());
        }
    }
    least
}

fn report(name: &str, [own, other]: [f64; 2], steps: u64) {
    let [a, b] = [own, other].map(|seconds| 1e9 * seconds / steps as f64);
    println!("{name:44} {a:9.2} {b:9.2} {:6.2}", own / other);
}

/// 64 runs side by side.
fn section(problem: &Problem, row: &'static Row, returns: u64) {
    let start = |i: u32| [vec![2.5 + 0.01 * f64::from(i)], vec![0.0]];
    let study = Poincare {
        problem: problem.clone(),
        section: SECTION,
        starts: (0..64).map(start).collect(),
        transient: 0,
        points: 80 * returns,
    };
    drop(black_box(study.run(row, TAU / STEPS as f64, &Silent)));
}

/// The basins of two coexisting oscillations.
fn basins(side: usize) {
    let text =
        SCENE.replace("alpha = 0.0, beta = 1.0, c = 0.05", "alpha = 1.0, beta = 0.2, c = 0.1");
    let text = text.replace("f = 7.5, omega = 1.0", "f = 0.4, omega = 1.35");
    let axis = |variable| {
        let values = (0..side).map(|i| -4.0 + 8.0 * i as f64 / side as f64).collect();
        Axis { variable, dof: 0, values }
    };
    let study = Basins {
        problem: Scene::read(&text).expect("a scene").problem,
        section: SECTION,
        axes: [axis(Variable::Q), axis(Variable::P)],
        longest: 400,
    };
    drop(black_box(study.run(find("moddg").expect("a method"), TAU / 1.35 / 64.0, &Silent)));
}

/// [q, p, w, s] at t, one step h further under the amplitude f.
type Step = fn([f64; 4], f64, f64, f64) -> [f64; 4];

/// The sum of the section points of one amplitude.
fn hand_written(step: Step, f: f64, returns: u64) -> f64 {
    let (mut z, h, mut sum) = ([2.5, 0.0, 0.0, 0.0], TAU / STEPS as f64, 0.0);
    for n in 0..2 * returns {
        for i in 0..STEPS {
            z = step(z, h * i as f64, h, f);
        }
        if n >= returns {
            sum += z[0] + z[1];
        }
    }
    sum
}

fn by_hand_rk4(z: [f64; 4], t: f64, h: f64, f: f64) -> [f64; 4] {
    let slope = |z: [f64; 4], t: f64| {
        let ([q, p, ..], push) = (z, f * t.cos());
        [p, -q * q * q - C * p + push, C * p * p, push * p]
    };
    let ahead = |k: [f64; 4], h: f64| std::array::from_fn(|i| h.mul_add(k[i], z[i]));
    let a = slope(z, t);
    let b = slope(ahead(a, 0.5 * h), t + 0.5 * h);
    let c = slope(ahead(b, 0.5 * h), t + 0.5 * h);
    let d = slope(ahead(c, h), t + h);
    std::array::from_fn(|i| z[i] + h / 6.0 * (a[i] + 2.0 * (b[i] + c[i]) + d[i]))
}

/// modDG with Newton's method for the mean momentum v, to rounding.
fn by_hand_moddg([q, p, w, s]: [f64; 4], t: f64, h: f64, f: f64) -> [f64; 4] {
    let push = f * (t + 0.5 * h).cos();
    let start = p + 0.5 * h * push;
    let mut v = start;
    for _ in 0..20 {
        let to = h.mul_add(v, q);
        let mean = 0.25 * (q + to) * (q * q + to * to);
        let slope = 0.25 * (q * q + 2.0 * q * to + 3.0 * to * to);
        let miss = v - start + 0.5 * h * (mean + C * v);
        let change = miss / (1.0 + 0.5 * h * h.mul_add(slope, C));
        v -= change;
        if change.abs() <= 1e-16 * v.abs() || change.abs() < 1e-15 {
            break;
        }
    }
    let way = h * v;
    [q + way, 2.0 * v - p, w + C * v * way, s + push * way]
}
