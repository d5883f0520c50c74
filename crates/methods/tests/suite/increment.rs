//! Coordinate increments on coupled, nonlinear, damped systems: orders, K, passivity, order of the coordinates.

use crate::slope;
use afterbay_core::taylor::trajectory;
use afterbay_core::{
    Coupling, Damping, Drag, Grid, InputError, Line, Method, Passive, Quad, Scalar, Separable, Series, State,
    StepFailure, System, Vector, integrate,
};
use afterbay_methods::registry::{METHODS, Row, separable};
use afterbay_methods::{Composition, Increment, ModDg};
use afterbay_systems::{Duffing, FputChain, VanDerPolRing};
use proptest::prelude::*;
use slope::slope;

const N: usize = 5;

fn chain<T: Scalar>() -> FputChain<T> {
    FputChain::new(N, T::from_f64(1.0), T::from_f64(0.3)).unwrap()
}

fn ring<T: Scalar>() -> VanDerPolRing<T> {
    VanDerPolRing::new(N, T::from_f64(0.8), T::from_f64(0.6)).unwrap()
}

fn start<T: Scalar>() -> State<[T; N]> {
    let q = [0.8, -0.3, 0.5, 1.1, -0.6].map(T::from_f64);
    let p = [0.2, 0.9, -0.7, 0.4, 0.5].map(T::from_f64);
    State::new(q, p).unwrap()
}

fn largest<T: Scalar>(a: &[T; N], b: &[T; N]) -> f64 {
    a.iter().zip(b).map(|(&a, &b)| (a - b).abs().to_f64()).fold(0.0, f64::max)
}

/// The order each composition is meant to have.
fn compositions() -> [(Composition, f64); 8] {
    [
        (Composition::sweep(), 1.0),
        (Composition::pair(), 2.0),
        (Composition::suzuki4(), 4.0),
        (Composition::blanes_moan4(), 4.0),
        (Composition::yoshida6(), 6.0),
        (Composition::mclachlan6(), 6.0),
        (Composition::blanes_moan6(), 6.0),
        (Composition::kahan_li8(), 8.0),
    ]
}

/// The end of the runs the orders are read from.
const END: f64 = 1.2;

/// The slopes of the errors of q, p and w at the end, against the number of steps.
fn orders<T, S, E>(system: &S, exact: &E, method: &Increment, counts: &[u64]) -> [f64; 3]
where
    T: Scalar,
    S: Separable<T>,
    E: System<Series<T, 24>>,
{
    let end = &trajectory::<_, _, 24>(exact, &start(), T::from_f64(END), 1).unwrap()[1];
    let errors: Vec<[f64; 3]> = counts
        .iter()
        .map(|&count| {
            let grid = Grid { h: T::from_f64(END) / T::from_f64(count as f64), steps: count };
            let mut state = start();
            integrate(method, system, grid, &mut state, &mut ()).unwrap();
            [largest(&state.q, &end.q), largest(&state.p, &end.p), largest(&state.w, &end.w)]
        })
        .collect();
    let steps: Vec<f64> = counts.iter().map(|&count| END / count as f64).collect();
    [0, 1, 2].map(|variable| slope(&steps, &errors.iter().map(|error| error[variable]).collect::<Vec<_>>()))
}

/// On chain and ring, in the natural order and coloured.
fn check_orders<T: Scalar>(counts: impl Fn(f64, &Coupling) -> Vec<u64>) {
    for (composition, order) in compositions() {
        let natural = Increment::new(composition);
        for (coupling, of_chain) in [(Coupling::Chain, true), (Coupling::Ring, false)] {
            let coloured = natural.clone().in_order(coupling.coloured(N));
            for method in [&natural, &coloured] {
                let found = if of_chain {
                    orders::<T, _, _>(&chain(), &chain(), method, &counts(order, &coupling))
                } else {
                    orders::<T, _, _>(&ring(), &ring(), method, &counts(order, &coupling))
                };
                println!("{order} {coupling:?} {found:.3?}");
                assert!(
                    found.iter().all(|found| (found - order).abs() < 0.1),
                    "{method:?} {coupling:?}: {found:?}"
                );
            }
        }
    }
}

#[test]
fn compositions_have_their_order_in_q_p_and_w() {
    // Small enough for the leading term, large enough to stand above rounding.
    check_orders::<f64>(|order, coupling| match order {
        1.0 | 2.0 => vec![1000, 2000, 4000],
        4.0 => vec![100, 140, 200],
        6.0 => vec![24, 30, 36],
        _ if *coupling == Coupling::Chain => vec![18, 20, 22],
        _ => vec![8, 9, 10, 11],
    });
}

#[test]
fn compositions_have_their_order_in_31_digits() {
    check_orders::<Quad>(|order, _| if order < 8.0 { vec![150, 220, 300] } else { vec![60, 80, 100] });
}

/// Steps of increments that violate passivity, on a chain of masses at several steps.
fn drained(row: &Row) -> usize {
    let system = FputChain::new(N, 1.0, 0.8).unwrap();
    let run = separable(row, system).unwrap();
    let mut count = 0;
    for h in [0.05, 0.3, 1.0] {
        let mut state: State<[f64; N]> = start();
        for _ in 0..200 {
            let before = state.w;
            if run.step(h, &mut state).is_err() {
                break;
            }
            count += usize::from(Passive::Each.violated(&before, &state.w));
        }
    }
    count
}

/// Orders of all rows are measured in `order_table`.
#[test]
fn the_registry_knows_which_increments_are_passive() {
    let rows: Vec<&Row> = METHODS.iter().filter(|row| row.name.starts_with("increment-")).collect();
    assert_eq!(rows.len(), 5);
    for row in rows {
        let count = drained(row);
        println!("{}: {count}", row.name);
        assert_eq!(row.passive, count == 0, "{}: {count} violations", row.name);
    }
}

/// Springs between all pairs, a quartic well each, masses, and damping of either sign.
#[derive(Clone, Debug)]
struct Net {
    masses: Vec<f64>,
    wells: Vec<[f64; 2]>,
    springs: Vec<Vec<f64>>,
    friction: Vec<f64>,
}

impl Net {
    /// The same with its coordinates renamed: the new j is the old `names[j]`.
    fn renamed(&self, names: &[usize]) -> Self {
        Self {
            masses: names.iter().map(|&i| self.masses[i]).collect(),
            wells: names.iter().map(|&i| self.wells[i]).collect(),
            springs: names.iter().map(|&i| names.iter().map(|&j| self.springs[i][j]).collect()).collect(),
            friction: names.iter().map(|&i| self.friction[i]).collect(),
        }
    }

    /// The sum of the sizes of all terms of K, each coordinate as large as it gets.
    fn magnitude(&self, before: &State<Vec<f64>>, after: &State<Vec<f64>>) -> f64 {
        let n = self.masses.len();
        let q = |j: usize| before.q[j].abs().max(after.q[j].abs());
        (0..n)
            .map(|j| {
                let kinetic = (before.p[j].powi(2) + after.p[j].powi(2)) / self.masses[j];
                let [a, b] = self.wells[j].map(f64::abs);
                let springs: f64 = (0..n).map(|i| self.springs[i][j].abs() * (q(i) + q(j)).powi(2)).sum();
                let work = (after.w[j] - before.w[j]).abs();
                kinetic
                    + a * q(j).powi(2)
                    + b * q(j).powi(4)
                    + springs
                    + before.w[j].abs()
                    + after.w[j].abs()
                    + work
            })
            .sum()
    }
}

impl System<f64> for Net {
    fn dof(&self) -> usize {
        self.masses.len()
    }
    fn energy(&self, q: &[f64], p: &[f64]) -> f64 {
        let n = q.len();
        (0..n)
            .map(|j| {
                let [a, b] = self.wells[j];
                let springs: f64 = (0..j).map(|i| self.springs[i][j] * (q[i] - q[j]).powi(2) / 2.0).sum();
                p[j] * p[j] / (2.0 * self.masses[j])
                    + a * q[j].powi(2) / 2.0
                    + b * q[j].powi(4) / 4.0
                    + springs
            })
            .sum()
    }
    fn gradient(&self, q: &[f64], p: &[f64], hq: &mut [f64], hp: &mut [f64]) {
        for j in 0..q.len() {
            hq[j] = self.partial(q, j, q[j]);
            hp[j] = p[j] / self.masses[j];
        }
    }
    fn dissipation(&self, q: &[f64], p: &[f64], _v: &[f64], d: &mut [f64]) {
        d.iter_mut().enumerate().for_each(|(j, d)| *d = self.drag(q, p, j).value);
    }
    fn damping(&self) -> Damping {
        let zero = self.friction.iter().all(|&c| c == 0.0);
        Damping {
            zero,
            passive: Passive::each_if(self.friction.iter().all(|&c| c >= 0.0)),
            ..Damping::LINEAR
        }
    }
}

impl Separable<f64> for Net {
    fn mass(&self, j: usize) -> f64 {
        self.masses[j]
    }
    fn partial(&self, q: &[f64], j: usize, at: f64) -> f64 {
        let springs: f64 = (0..q.len()).filter(|&i| i != j).map(|i| self.springs[i][j] * (at - q[i])).sum();
        self.wells[j][0] * at + self.wells[j][1] * at.powi(3) + springs
    }
    fn edge(&self, q: &[f64], j: usize, to: f64) -> Line<f64> {
        let ([a, b], from) = (self.wells[j], q[j]);
        let others = || (0..q.len()).filter(|&i| i != j);
        let springs: f64 = others().map(|i| self.springs[i][j] * ((from - q[i]) + (to - q[i])) / 2.0).sum();
        let stiffness: f64 = others().map(|i| self.springs[i][j] / 2.0).sum();
        let sum = from + to;
        let value = sum * (a / 2.0 + b / 4.0 * (from * from + to * to)) + springs;
        let slope = a / 2.0 + b / 4.0 * (from * from + to * to + 2.0 * to * sum) + stiffness;
        Line { value, slope }
    }
    /// c (1 + q²) p
    fn drag(&self, q: &[f64], p: &[f64], j: usize) -> Drag<f64> {
        let by_p = self.friction[j] * (1.0 + q[j] * q[j]);
        Drag { value: by_p * p[j], by_q: 2.0 * self.friction[j] * q[j] * p[j], by_p }
    }
}

/// A net without friction, whose D is no number.
struct Frictionless(Net);

impl System<f64> for Frictionless {
    fn dof(&self) -> usize {
        self.0.dof()
    }
    fn energy(&self, q: &[f64], p: &[f64]) -> f64 {
        self.0.energy(q, p)
    }
    fn gradient(&self, q: &[f64], p: &[f64], hq: &mut [f64], hp: &mut [f64]) {
        self.0.gradient(q, p, hq, hp);
    }
    fn dissipation(&self, _q: &[f64], _p: &[f64], _v: &[f64], d: &mut [f64]) {
        d.fill(f64::NAN);
    }
    fn damping(&self) -> Damping {
        Damping::NONE
    }
}

impl Separable<f64> for Frictionless {
    fn mass(&self, j: usize) -> f64 {
        self.0.mass(j)
    }
    fn partial(&self, q: &[f64], j: usize, at: f64) -> f64 {
        self.0.partial(q, j, at)
    }
    fn edge(&self, q: &[f64], j: usize, to: f64) -> Line<f64> {
        self.0.edge(q, j, to)
    }
    fn drag(&self, _q: &[f64], _p: &[f64], _j: usize) -> Drag<f64> {
        Drag { value: f64::NAN, by_q: f64::NAN, by_p: f64::NAN }
    }
}

/// A net of up to 40 masses in a state, a step size, and an order of the coordinates.
fn nets(friction: std::ops::Range<f64>) -> impl Strategy<Value = (Net, State<Vec<f64>>, f64, Vec<usize>)> {
    (1..=40_usize, -6.0..1.0_f64).prop_flat_map(move |(n, exponent)| {
        let net = (
            prop::collection::vec(0.1..10.0, n),
            prop::collection::vec([-1.0..2.0, 0.0..1.0], n),
            prop::collection::vec(prop::collection::vec(-0.3..1.0, n), n),
            prop::collection::vec(friction.clone(), n),
        );
        let state = (prop::collection::vec(-2.0..2.0, n), prop::collection::vec(-2.0..2.0, n));
        let order = Just((0..n).collect::<Vec<_>>()).prop_shuffle();
        (net, state, order).prop_map(move |((masses, wells, mut springs, friction), (q, p), order)| {
            for i in 0..n {
                let (above, below) = springs.split_at_mut(i);
                below[0][i] = 0.0;
                for (j, row) in above.iter_mut().enumerate() {
                    row[i] = below[0][j];
                }
            }
            let net = Net { masses, wells, springs, friction };
            (net, State::new(q, p).unwrap(), 10.0_f64.powf(exponent), order)
        })
    })
}

/// One step of a composition sweep by sweep, K checked at each: what the step itself passes through.
fn step_by_sweeps(
    net: &Net,
    composition: &[f64],
    h: f64,
    order: &[usize],
    state: &mut State<Vec<f64>>,
) -> Result<Option<StepFailure>, TestCaseError> {
    let back: Vec<usize> = order.iter().rev().copied().collect();
    for (i, fraction) in composition.iter().enumerate() {
        let order = if i % 2 == 0 { order.to_vec() } else { back.clone() };
        let sweep = Increment::new(Composition::sweep()).in_order(order);
        let before = state.clone();
        let mut workspace = Method::<Vec<f64>, Net>::workspace(&sweep, net).unwrap();
        if let Err(failure) = sweep.step(net, fraction * h, state, &mut workspace) {
            prop_assert_eq!(&before, &*state, "a failed step changes nothing");
            return Ok(Some(failure));
        }
        // A coordinate's step moves K by up to 16 roundings of its own terms (k_is_kept.rs), and summing K up costs one a
        // term: 16 + n of the sum of all of them.
        let roundings = 16.0 + net.masses.len() as f64;
        let drift = (state.total(net) - before.total(net)).abs();
        let bound = roundings * f64::EPSILON / 2.0 * net.magnitude(&before, state);
        prop_assert!(drift <= bound, "sweep {i}: K moves by {drift:e}, {:.1} of the bound", drift / bound);
    }
    Ok(None)
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(200) })]

    #[test]
    fn k_is_kept_by_every_sweep_of_any_net((net, start, h, order) in nets(-1.0..1.0)) {
        for composition in [vec![1.0], vec![0.5, 0.5], vec![0.4, 0.4, -0.6, -0.6, 0.4, 0.4, 0.4, 0.2]] {
            let mut by_sweeps = start.clone();
            let mut at_once = start.clone();
            let failure = step_by_sweeps(&net, &composition, h, &order, &mut by_sweeps)?;
            let method = Increment::new(Composition::alternating(&composition).unwrap()).in_order(order.clone());
            let mut workspace = Method::<Vec<f64>, Net>::workspace(&method, &net).unwrap();
            let outcome = method.step(&net, h, &mut at_once, &mut workspace);
            match failure {
                None => prop_assert_eq!(&by_sweeps, &at_once, "a composition is its sweeps"),
                Some(failure) => {
                    prop_assert_eq!(outcome, Err(failure));
                    prop_assert_eq!(&start, &at_once, "a failed step changes nothing");
                }
            }
        }
    }

    /// Where a failure says to take a smaller step, a smaller step is taken.
    #[test]
    fn the_advice_of_a_failure_holds((net, start, h, order) in nets(-1.0..1.0)) {
        let method = Increment::new(Composition::pair()).in_order(order.clone());
        let attempt = |h: f64| {
            let mut workspace = Method::<Vec<f64>, Net>::workspace(&method, &net).unwrap();
            method.step(&net, h, &mut start.clone(), &mut workspace)
        };
        if let Err(failure) = attempt(h) {
            prop_assert!(failure.to_string().contains("take a smaller step"), "{failure}");
            let taken = (1..=10).find(|&k| attempt(h / 2_f64.powi(k)).is_ok());
            prop_assert!(taken.is_some(), "h = {h}, and down to h/1024: {failure}");
        }
    }

    #[test]
    fn every_reservoir_only_fills_where_the_system_is_passive((net, start, h, order) in nets(0.0..1.0)) {
        for composition in [Composition::sweep(), Composition::pair()] {
            let method = Increment::new(composition).in_order(order.clone());
            let mut state = start.clone();
            let mut workspace = Method::<Vec<f64>, Net>::workspace(&method, &net).unwrap();
            if method.step(&net, h, &mut state, &mut workspace).is_ok() {
                prop_assert!(state.w.iter().all(|&w| w >= 0.0), "{:?}", state.w);
            }
        }
    }

    #[test]
    fn names_of_coordinates_mean_nothing((net, start, h, order) in nets(-0.5..0.5)) {
        let names: Vec<usize> = (0..order.len()).rev().collect();
        let rename = |part: &Vec<f64>| names.iter().map(|&i| part[i]).collect::<Vec<_>>();
        let renamed_order: Vec<usize> =
            order.iter().map(|old| names.iter().position(|name| name == old).unwrap()).collect();
        let h = h.min(0.1);
        let (mut state, mut renamed) = (start.clone(), State::new(rename(&start.q), rename(&start.p)).unwrap());
        let run = |net: &Net, order: &[usize], state: &mut State<Vec<f64>>| {
            let method = Increment::new(Composition::pair()).in_order(order.to_vec());
            let mut workspace = Method::<Vec<f64>, Net>::workspace(&method, net).unwrap();
            method.step(net, h, state, &mut workspace)
        };
        prop_assert_eq!(run(&net, &order, &mut state).is_ok(), run(&net.renamed(&names), &renamed_order, &mut renamed).is_ok());
        for (a, b) in rename(&state.q).iter().chain(&rename(&state.w)).zip(renamed.q.iter().chain(&renamed.w)) {
            prop_assert!((a - b).abs() <= 1e-12 * (1.0 + a.abs()), "{a} {b}");
        }
    }

    /// w keeps every bit, the sign of a zero too, and D is not asked for: the step is that of a D of zeros.
    #[test]
    fn without_friction_there_is_no_reservoir(
        (net, start, h, order) in nets(0.0..f64::MIN_POSITIVE),
        seed in 1.0..2.0_f64,
    ) {
        let still = Net { friction: vec![0.0; order.len()], ..net };
        let net = Frictionless(still.clone());
        for composition in [Composition::sweep(), Composition::pair(), Composition::suzuki4()] {
            let method = Increment::new(composition).in_order(order.clone());
            let mut state = start.clone();
            state.w.iter_mut().enumerate().for_each(|(j, w)| {
                *w = if j % 2 == 0 { -0.0 } else { (seed * j as f64).sin() };
            });
            let bits = |state: &State<Vec<f64>>| state.w.iter().map(|w| w.to_bits()).collect::<Vec<_>>();
            let (before, mut same) = (bits(&state), state.clone());
            let mut workspace = Method::<Vec<f64>, Net>::workspace(&method, &still).unwrap();
            let expected = method.step(&still, h, &mut same, &mut workspace);
            let mut workspace = Method::<Vec<f64>, Frictionless>::workspace(&method, &net).unwrap();
            prop_assert_eq!(method.step(&net, h, &mut state, &mut workspace), expected);
            prop_assert_eq!((&state.q, &state.p), (&same.q, &same.p));
            prop_assert_eq!(bits(&state), before);
        }
    }
}

#[test]
fn storage_changes_no_bit() {
    fn run<V: Vector<Scalar = f64>>() -> Vec<u64> {
        let vector = |from: [f64; N]| {
            let mut vector = V::zeros(N);
            vector.as_mut_slice().copy_from_slice(&from);
            vector
        };
        let from: State<[f64; N]> = start();
        let mut state = State::new(vector(from.q), vector(from.p)).unwrap();
        let method = Increment::new(Composition::kahan_li8());
        integrate(&method, &chain::<f64>(), Grid::of(0.1, 50).unwrap(), &mut state, &mut ()).unwrap();
        [state.q, state.p, state.w]
            .iter()
            .flat_map(|part| part.as_slice().iter().map(|x| x.to_bits()))
            .collect()
    }
    let fixed = run::<[f64; N]>();
    assert_eq!(fixed, run::<Vec<f64>>());
    assert_eq!(fixed, run::<nalgebra::DVector<f64>>());
    assert_eq!(fixed, run::<nalgebra::SVector<f64, N>>());
}

#[test]
fn with_one_degree_of_freedom_a_sweep_is_the_modified_discrete_gradient() {
    let system = Duffing::new(-1.0, 1.0, 0.2).unwrap();
    let grid = Grid::of(0.05, 400).unwrap();
    let (mut one, mut other) = (State::new([1.5], [0.5]).unwrap(), State::new([1.5], [0.5]).unwrap());
    integrate(&ModDg::newton(), &system, grid, &mut one, &mut ()).unwrap();
    integrate(&Increment::new(Composition::sweep()), &system, grid, &mut other, &mut ()).unwrap();
    assert_eq!(one, other);
}

#[test]
fn an_order_that_is_none_is_refused() {
    for order in [vec![], vec![0, 1, 2, 3], vec![0, 1, 2, 3, 3], vec![0, 1, 2, 3, 5]] {
        let method = Increment::new(Composition::pair()).in_order(order);
        let workspace = Method::<[f64; N], FputChain<f64>>::workspace(&method, &chain());
        assert!(matches!(workspace, Err(InputError::Unsupported { .. })));
    }
}

/// End states computed by mpmath to 30 digits (crates/systems/tests/data/many_degrees.py).
const REFERENCES: &str = include_str!("../../../systems/tests/data/many_degrees.csv");

/// (q, p, w) of a system at one of the times of the references.
fn reference(system: &str, t: &str) -> [Vec<f64>; 3] {
    let rows = REFERENCES.lines().skip(1).map(|line| line.split(',').collect::<Vec<_>>());
    let rows: Vec<_> = rows.filter(|row| row[0] == system && row[1] == t).collect();
    [3, 5, 7].map(|column| rows.iter().map(|row| row[column].parse().unwrap()).collect())
}

#[test]
fn end_states_are_those_of_another_library() {
    fn check<S: Separable<f64>>(name: &str, times: [&str; 2], system: &S) {
        let [q, p, _] = reference(name, "0");
        for t in times {
            let [q1, p1, w1] = reference(name, t);
            let mut state = State::new(q.clone(), p.clone()).unwrap();
            let grid = Grid::new(0.02, t.parse().unwrap()).unwrap();
            let before = state.total(system);
            integrate(&Increment::new(Composition::kahan_li8()), system, grid, &mut state, &mut ()).unwrap();
            let found = state.q.iter().chain(&state.p).chain(&state.w);
            let off =
                found.zip(q1.iter().chain(&p1).chain(&w1)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(off < 1e-9, "{name} at t = {t}: {off:e}");
            assert!((state.total(system) - before).abs() < 1e-12);
        }
    }
    check("fput-chain", ["5", "20"], &FputChain::new(8, 1.0, 0.05).unwrap());
    check("van-der-pol-ring", ["5", "10"], &VanDerPolRing::new(5, 1.0, 0.3).unwrap());
}
