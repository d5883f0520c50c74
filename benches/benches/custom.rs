//! Systems written as expressions beside the same systems built in, through the same methods: what a scene of one's own costs.
//!
//! The two are run in turn. A figure is the least over the turns, as a busy machine makes a run slower and never faster; a ratio is that
//! of the least. They end in the same state.

use afterbay_core::{Curvature, Grid, Method, Separable, State, integrate};
use afterbay_methods::{Composition, Gonzalez, Increment, Leapfrog, ModDg, Rk4};
use afterbay_systems::{Custom, DampedOscillator, Description, Duffing, FputChain, Friction, VanDerPol};
use std::time::Instant;

/// Turns of which the least is taken.
const TURNS: usize = 301;
/// Degrees of freedom times steps in one run.
const WORK: usize = 2_000;

fn main() {
    // `cargo test` runs benches too, without this argument: once is enough to see that they work.
    let turns = if std::env::args().any(|argument| argument == "--bench") { TURNS } else { 1 };
    let texts = |x: &[&str]| x.iter().map(|&x| x.to_owned()).collect::<Vec<_>>();
    let custom = |potential: &str, dissipation: Vec<String>, parameters: &[(&str, f64)]| {
        let parameters = parameters.iter().map(|&(name, value)| (name.to_owned(), value)).collect();
        let description = Description {
            potential: potential.to_owned(),
            friction: Friction::Forces(dissipation),
            parameters,
            ..Default::default()
        };
        Custom::new(&description).expect("a good description")
    };
    println!("{:40} {:>10} {:>10} {:>7}", "ns a degree of freedom and step", "custom", "built in", "ratio");

    let oscillator = DampedOscillator::new(1.0, 0.1).expect("parameters in range");
    let own = custom("k*q1^2/2", texts(&["b*p1"]), &[("k", 1.0), ("b", 0.1)]);
    all_with_one("damped oscillator", turns, &own, &oscillator);
    let duffing = Duffing::new(1.0, 0.5, 0.1).expect("finite parameters");
    let own =
        custom("alpha*q1^2/2 + beta*q1^4/4", texts(&["c*p1"]), &[("alpha", 1.0), ("beta", 0.5), ("c", 0.1)]);
    all_with_one("Duffing", turns, &own, &duffing);
    let van_der_pol = VanDerPol::new(1.0).expect("a finite parameter");
    let own = custom("q1^2/2", texts(&["-mu*(1 - q1^2)*p1"]), &[("mu", 1.0)]);
    all_with_one("Van der Pol", turns, &own, &van_der_pol);

    let n = 64;
    let bond = |i: usize| match i {
        0 => "q1^2/2 + beta*q1^4/4".to_owned(),
        _ if i == n => format!("q{n}^2/2 + beta*q{n}^4/4"),
        _ => format!("(q{} - q{i})^2/2 + beta*(q{} - q{i})^4/4", i + 1, i + 1),
    };
    let potential = (0..=n).map(bond).collect::<Vec<_>>().join(" + ");
    let dissipation: Vec<String> = (1..=n).map(|j| format!("c*p{j}")).collect();
    let clock = Instant::now();
    let own = custom(&potential, dissipation, &[("beta", 0.5), ("c", 0.01)]);
    let compiled = clock.elapsed();
    let chain = FputChain::new(n, 0.5, 0.01).expect("parameters in range");
    let q: Vec<f64> = (0..n).map(|j| (0.7 * j as f64).sin()).collect();
    let start = State::new(q, vec![0.1; n]).expect("a finite state");
    compare("increment-2, chain of 64", turns, &start, &Increment::new(Composition::pair()), &own, &chain);
    compare("leapfrog, chain of 64", turns, &start, &Leapfrog, &own, &chain);
    compare("rk4, chain of 64", turns, &start, &Rk4, &own, &chain);
    compare("gonzalez, chain of 64", turns, &start, &Gonzalez::default(), &own, &chain);
    println!("reading and compiling the chain of 64: {:.2} ms", compiled.as_secs_f64() * 1e3);
}

fn all_with_one<B>(name: &str, turns: usize, own: &Custom<f64>, built_in: &B)
where
    B: Separable<f64> + Curvature<f64>,
{
    let start = State::new([1.3], [-0.4]).expect("a finite state");
    compare(&format!("moddg, {name}"), turns, &start, &ModDg::newton(), own, built_in);
    compare(&format!("leapfrog, {name}"), turns, &start, &Leapfrog, own, built_in);
    compare(&format!("rk4, {name}"), turns, &start, &Rk4, own, built_in);
}

fn compare<V, M, B>(name: &str, turns: usize, start: &State<V>, method: &M, own: &Custom<f64>, built_in: &B)
where
    V: afterbay_core::Vector<Scalar = f64>,
    M: Method<V, Custom<f64>> + Method<V, B>,
    B: Separable<f64>,
{
    let turn = || [time(start, method, own), time(start, method, built_in)];
    let ends = turn().map(|(_, end)| end);
    for (a, b) in ends[0].iter().zip(&ends[1]) {
        assert!((a - b).abs() < 1e-6, "{name}: {a} is not {b}");
    }
    let times: Vec<[f64; 2]> = (0..turns).map(|_| turn().map(|(time, _)| time)).collect();
    let [custom, plain] = [0, 1].map(|i| times.iter().map(|turn| turn[i]).fold(f64::INFINITY, f64::min));
    let ratio = custom / plain;
    println!("{name:40} {custom:10.2} {plain:10.2} {ratio:7.2}");
}

/// ns a degree of freedom and step, and q at the end.
fn time<V, M, S>(start: &State<V>, method: &M, system: &S) -> (f64, Vec<f64>)
where
    V: afterbay_core::Vector<Scalar = f64>,
    M: Method<V, S>,
    S: Separable<f64>,
{
    let mut state = start.clone();
    let steps = WORK / state.dof();
    let grid = Grid::of(0.01, steps as u64).expect("a grid");
    let clock = Instant::now();
    integrate(method, system, grid, &mut state, &mut ()).expect("a run");
    let elapsed = clock.elapsed().as_secs_f64() * 1e9 / WORK as f64;
    (elapsed, state.q.as_slice().to_vec())
}
