//! Systems given by expressions compared with the same systems built in or written in Rust, under
//! the same methods: the cost of a custom system in a scene.
//!
//! The two are run in turn. Each figure is the minimum over the turns, since other load on the
//! machine only increases times. Because the load may affect one of the two more than the other,
//! all pairs are measured in several rounds, far apart. Each ratio is the ratio of the minima. Both
//! runs must end in the same state.

use afterbay_benches::written::{HenonHeiles, Morse, Pendulum};
use afterbay_core::{Curvature, Grid, Method, Separable, State, Vector, integrate};
use afterbay_methods::{
    Collocation, Composition, Gonzalez, Increment, Leapfrog, ModDg, Relaxed, Rk4,
};
use afterbay_systems::{
    Custom, DampedOscillator, Description, DissipationText, Duffing, FputChain, VanDerPol,
    VanDerPolRing,
};
use std::time::Instant;

/// The number of rounds over all pairs, and of turns per pair and round.
const ROUNDS: usize = 7;
const TURNS: usize = 61;
/// The number of degrees of freedom times the number of steps of a run.
const WORK: usize = 2_000;

fn main() {
    // `cargo test` also runs benches, without this argument; a single turn then checks that they
    // work.
    let (rounds, turns) = if std::env::args().any(|argument| argument == "--bench") {
        (ROUNDS, TURNS)
    } else {
        (1, 1)
    };
    let texts = |x: &[&str]| x.iter().map(|&x| x.to_owned()).collect::<Vec<_>>();
    let custom = |potential: &str, dissipation: Vec<String>, parameters: &[(&str, f64)]| {
        let parameters = parameters.iter().map(|&(name, value)| (name.to_owned(), value)).collect();
        let description = Description {
            potential: potential.to_owned(),
            dissipation: DissipationText::Forces(dissipation),
            parameters,
            ..Default::default()
        };
        Custom::new(&description).expect("a good description")
    };
    let oscillator = DampedOscillator::new(1.0, 0.1).expect("parameters in range");
    let own_oscillator = custom("k*q1^2/2", texts(&["b*p1"]), &[("k", 1.0), ("b", 0.1)]);
    let duffing = Duffing::new(1.0, 0.5, 0.1).expect("finite parameters");
    let own_duffing = custom(
        "alpha*q1^2/2 + beta*q1^4/4",
        texts(&["c*p1"]),
        &[("alpha", 1.0), ("beta", 0.5), ("c", 0.1)],
    );
    let van_der_pol = VanDerPol::new(1.0).expect("a finite parameter");
    let own_van_der_pol = custom("q1^2/2", texts(&["-mu*(1 - q1^2)*p1"]), &[("mu", 1.0)]);

    let n = 64;
    let bond = |i: usize| match i {
        0 => "q1^2/2 + beta*q1^4/4".to_owned(),
        _ if i == n => format!("q{n}^2/2 + beta*q{n}^4/4"),
        _ => format!("(q{} - q{i})^2/2 + beta*(q{} - q{i})^4/4", i + 1, i + 1),
    };
    let potential = (0..=n).map(bond).collect::<Vec<_>>().join(" + ");
    let dissipation: Vec<String> = (1..=n).map(|j| format!("c*p{j}")).collect();
    let clock = Instant::now();
    let own_chain = custom(&potential, dissipation, &[("beta", 0.5), ("c", 0.01)]);
    let compiled = clock.elapsed();
    let chain = FputChain::new(n, 0.5, 0.01).expect("parameters in range");
    let q: Vec<f64> = (0..n).map(|j| (0.7 * j as f64).sin()).collect();
    let start = State::new(q, vec![0.1; n]).expect("a finite state");

    let single = |j: usize| format!("q{j}^2/2 + kappa*(q{} - q{j})^2/2", j % n + 1);
    let potential = (1..=n).map(single).collect::<Vec<_>>().join(" + ");
    let dissipation: Vec<String> = (1..=n).map(|j| format!("-mu*(1 - q{j}^2)*p{j}")).collect();
    let own_ring = custom(&potential, dissipation, &[("mu", 1.0), ("kappa", 0.3)]);
    let ring = VanDerPolRing::new(n, 1.0, 0.3).expect("parameters in range");

    let pendulum = Pendulum { g: 1.5, c: 0.1 };
    let own_pendulum = custom("g*(1 - cos(q1))", texts(&["c*p1"]), &[("g", 1.5), ("c", 0.1)]);
    let morse = Morse { d: 2.0, a: 0.7, r: 1.0, c: 0.1 };
    let own_morse = custom(
        "d*(1 - exp(-a*(q1 - r)))^2",
        texts(&["c*p1"]),
        &[("d", 2.0), ("a", 0.7), ("r", 1.0), ("c", 0.1)],
    );
    let henon_heiles = HenonHeiles { c: 0.05 };
    let own_henon_heiles =
        custom("q1^2/2 + q2^2/2 + q1^2*q2 - q2^3/3", texts(&["c*p1", "c*p2"]), &[("c", 0.05)]);
    let inside = State::new([0.3, -0.1], [-0.2, 0.1]).expect("a finite state");

    let mut table = Table { turns, rows: Vec::new() };
    for _ in 0..rounds {
        table.with_one("damped oscillator", &own_oscillator, &oscillator);
        table.with_one("Duffing", &own_duffing, &duffing);
        table.with_one("Van der Pol", &own_van_der_pol, &van_der_pol);
        table.with_edges("pendulum", &own_pendulum, &pendulum);
        table.with_edges("Morse bond", &own_morse, &morse);
        let pair = Increment::new(Composition::pair());
        table.compare(
            "increment-2, Hénon-Heiles",
            &inside,
            &pair,
            &own_henon_heiles,
            &henon_heiles,
        );
        table.with_many("chain of 64", &start, &own_chain, &chain);
        table.with_many("ring of 64", &start, &own_ring, &ring);
    }
    table.print();
    println!("reading and compiling the chain of 64: {:.2} ms", compiled.as_secs_f64() * 1e3);
}

/// The measured times.
struct Table {
    turns: usize,
    /// For each name, the minimum times of the custom system and of the built-in one.
    rows: Vec<(String, [f64; 2])>,
}

impl Table {
    fn with_one<B>(&mut self, name: &str, own: &Custom<f64>, built_in: &B)
    where
        B: Separable<f64> + Curvature<f64>,
    {
        let start = State::new([1.3], [-0.4]).expect("a finite state");
        self.compare(&format!("moddg, {name}"), &start, &ModDg::newton(), own, built_in);
        self.with_any(name, &start, own, built_in);
    }

    /// Measures the methods that use edges, against a system written in Rust.
    fn with_edges<B: Separable<f64>>(&mut self, name: &str, own: &Custom<f64>, written: &B) {
        let start = State::new([1.3], [-0.4]).expect("a finite state");
        self.compare(&format!("moddg, {name}"), &start, &ModDg::newton(), own, written);
        let pair = Increment::new(Composition::pair());
        self.compare(&format!("increment-2, {name}"), &start, &pair, own, written);
    }

    fn with_many<B>(&mut self, name: &str, start: &State<Vec<f64>>, own: &Custom<f64>, built_in: &B)
    where
        B: Separable<f64> + Curvature<f64>,
    {
        self.compare(
            &format!("increment-2, {name}"),
            start,
            &Increment::new(Composition::pair()),
            own,
            built_in,
        );
        self.with_any(name, start, own, built_in);
    }

    fn with_any<V, B>(&mut self, name: &str, start: &State<V>, own: &Custom<f64>, built_in: &B)
    where
        V: Vector<Scalar = f64>,
        B: Separable<f64> + Curvature<f64>,
    {
        self.compare(&format!("leapfrog, {name}"), start, &Leapfrog, own, built_in);
        self.compare(&format!("rk4, {name}"), start, &Rk4, own, built_in);
        self.compare(&format!("relaxed-dop853, {name}"), start, &Relaxed::dop853(), own, built_in);
        self.compare(&format!("gonzalez, {name}"), start, &Gonzalez::default(), own, built_in);
        self.compare(&format!("collocation-4, {name}"), start, &Collocation::new(2), own, built_in);
    }

    fn compare<V, M, B>(
        &mut self,
        name: &str,
        start: &State<V>,
        method: &M,
        own: &Custom<f64>,
        built_in: &B,
    ) where
        V: Vector<Scalar = f64>,
        M: Method<V, Custom<f64>> + Method<V, B>,
        B: Separable<f64>,
    {
        let turn = || [time(start, method, own), time(start, method, built_in)];
        let ends = turn().map(|(_, end)| end);
        for (a, b) in ends[0].iter().zip(&ends[1]) {
            assert!((a - b).abs() < 1e-6, "{name}: {a} is not {b}");
        }
        let times = (0..self.turns).map(|_| turn().map(|(time, _)| time));
        let least =
            times.fold([f64::INFINITY; 2], |least, times| [0, 1].map(|i| least[i].min(times[i])));
        match self.rows.iter_mut().find(|row| row.0 == name) {
            Some((_, before)) => *before = [0, 1].map(|i| before[i].min(least[i])),
            None => self.rows.push((name.to_owned(), least)),
        }
    }

    fn print(&self) {
        println!(
            "{:40} {:>10} {:>10} {:>7}",
            "ns a degree of freedom and step", "custom", "in Rust", "ratio"
        );
        for (name, [custom, built_in]) in &self.rows {
            println!("{name:40} {custom:10.2} {built_in:10.2} {:7.2}", custom / built_in);
        }
    }
}

/// The time in ns per degree of freedom and step, and q at the end.
fn time<V, M, S>(start: &State<V>, method: &M, system: &S) -> (f64, Vec<f64>)
where
    V: Vector<Scalar = f64>,
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
