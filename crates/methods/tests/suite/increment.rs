//! Coordinate increments on chains and rings: orders, passivity of each row, storage, references.

use crate::bind::separable;
use crate::slope;
use afterbay_core::taylor::trajectory;
use afterbay_core::{
    Coupling, Grid, InputError, Method, Passive, Quad, Scalar, Separable, Series, State, System,
    Vector, integrate,
};
use afterbay_methods::registry::{FIXED, Row};
use afterbay_methods::{Composition, Increment, ModDg};
use afterbay_systems::{Duffing, FputChain, VanDerPolRing};
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

/// The compositions and their orders.
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

/// The end time of the runs from which the orders are measured.
const END: f64 = 1.2;

/// The slopes of the errors of q, p and w at the end, against the number of steps.
fn orders<T: Scalar>(
    system: &dyn Separable<T>,
    exact: &dyn System<Series<T, 24>>,
    method: &Increment,
    counts: &[u64],
) -> [f64; 3] {
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
    [0, 1, 2].map(|variable| {
        slope(&steps, &errors.iter().map(|error| error[variable]).collect::<Vec<_>>())
    })
}

/// Checks the orders on a chain and a ring, in the natural order and coloured.
fn check_orders<T: Scalar>(counts: impl Fn(f64, &Coupling) -> Vec<u64>) {
    for (composition, order) in compositions() {
        let natural = Increment::new(composition);
        for (coupling, of_chain) in [(Coupling::Chain, true), (Coupling::Ring, false)] {
            let coloured = natural.clone().in_order(coupling.coloured(N));
            for method in [&natural, &coloured] {
                let found = if of_chain {
                    orders::<T>(&chain(), &chain(), method, &counts(order, &coupling))
                } else {
                    orders::<T>(&ring(), &ring(), method, &counts(order, &coupling))
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
    // Steps small enough for the leading error term to dominate, and large enough for it to exceed
    // rounding.
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
    check_orders::<Quad>(
        |order, _| if order < 8.0 { vec![150, 220, 300] } else { vec![60, 80, 100] },
    );
}

/// The number of steps in which increments violate passivity, on a chain of masses at several step
/// sizes.
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

/// The orders of all rows are measured in `order_table`.
#[test]
fn increments_that_are_called_passive_are() {
    let rows: Vec<&Row> = FIXED.iter().filter(|row| row.name.starts_with("increment-")).collect();
    assert_eq!(rows.len(), 5);
    for row in rows {
        let count = drained(row);
        println!("{}: {count}", row.name);
        assert!(!row.passive || count == 0, "{}: {count} violations", row.name);
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
        integrate(&method, &chain::<f64>(), Grid::of(0.1, 50).unwrap(), &mut state, &mut ())
            .unwrap();
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
    let (mut one, mut other) =
        (State::new([1.5], [0.5]).unwrap(), State::new([1.5], [0.5]).unwrap());
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

/// (q, p, w) of a system at one of the reference times.
fn reference(system: &str, t: &str) -> [Vec<f64>; 3] {
    let rows = REFERENCES.lines().skip(1).map(|line| line.split(',').collect::<Vec<_>>());
    let rows: Vec<_> = rows.filter(|row| row[0] == system && row[1] == t).collect();
    [3, 5, 7].map(|column| rows.iter().map(|row| row[column].parse().unwrap()).collect())
}

#[test]
fn end_states_are_those_of_another_library() {
    fn check(name: &str, times: [&str; 2], system: &dyn Separable<f64>) {
        let [q, p, _] = reference(name, "0");
        for t in times {
            let [q1, p1, w1] = reference(name, t);
            let mut state = State::new(q.clone(), p.clone()).unwrap();
            let grid = Grid::new(0.02, t.parse().unwrap()).unwrap();
            let before = state.total(system);
            integrate(&Increment::new(Composition::kahan_li8()), system, grid, &mut state, &mut ())
                .unwrap();
            let found = state.q.iter().chain(&state.p).chain(&state.w);
            let off = found
                .zip(q1.iter().chain(&p1).chain(&w1))
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f64::max);
            assert!(off < 1e-9, "{name} at t = {t}: {off:e}");
            assert!((state.total(system) - before).abs() < 1e-12);
        }
    }
    check("fput-chain", ["5", "20"], &FputChain::new(8, 1.0, 0.05).unwrap());
    check("van-der-pol-ring", ["5", "10"], &VanDerPolRing::new(5, 1.0, 0.3).unwrap());
}
