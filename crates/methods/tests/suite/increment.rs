//! Coordinate increments on chains and rings: orders, passivity of each row, storage, references.

use crate::bind::after;
use crate::catalog::{self, As, Both, Built};
use crate::many::orders::orders_at_end;
use crate::many::{self, exact_end};
use afterbay_core::{
    Coupling, Grid, InputError, Method, Passive, Quad, Scalar, Separable, State, Vector, integrate,
};
use afterbay_methods::registry::{FIXED, Row, find};
use afterbay_methods::{Composition, Increment};
use afterbay_systems::FputChain;
use afterbay_systems::catalog::Expandable;

const N: usize = 5;

fn chain() -> Built {
    catalog::chain(N, 1.0, 0.3)
}

fn start<T: Scalar>() -> State<Vec<T>> {
    many::start([&[0.8, -0.3, 0.5, 1.1, -0.6], &[0.2, 0.9, -0.7, 0.4, 0.5]])
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

/// The orders of q, p and w at the end.
fn orders<T: Both + Expandable>(listed: &Built, method: &Increment, counts: &[u64]) -> [f64; 3] {
    let system = &*listed.separable::<T>();
    orders_at_end(&exact_end(&*listed.series::<T>(), &start(), END), counts, &mut |grid| {
        let mut state = start();
        integrate(method, system, grid, &mut state, &mut ()).unwrap();
        state
    })
}

/// Checks the orders on a chain and a ring, in the natural order and coloured.
fn check_orders<T: Both + Expandable>(counts: impl Fn(f64, &Coupling) -> Vec<u64>) {
    for (composition, order) in compositions() {
        let natural = Increment::new(composition);
        for system in [chain(), catalog::ring(N, 0.8, 0.6)] {
            let coupling = system.coupling();
            let coloured = natural.clone().in_order(coupling.coloured(N));
            for method in [&natural, &coloured] {
                let found = orders::<T>(&system, method, &counts(order, &coupling));
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
    check_orders::<Quad>(|order, _| match order {
        1.0 | 2.0 => vec![150, 220, 300],
        4.0 => vec![100, 140, 200],
        _ => vec![60, 80, 100],
    });
}

/// The number of steps in which increments violate passivity, on a chain of masses at several step
/// sizes.
fn drained(row: &Row) -> usize {
    let run = catalog::chain(N, 1.0, 0.8).bind::<f64>(row, As::Separable).unwrap();
    let mut count = 0;
    for h in [0.05, 0.3, 1.0] {
        let mut state = start::<f64>();
        for _ in 0..200 {
            let before = state.w.clone();
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

/// Nor does the erasure of the type of the system.
#[test]
fn storage_changes_no_bit() {
    fn run<V: Vector<Scalar = f64>, S: Separable<f64> + ?Sized>(system: &S) -> Vec<u64> {
        let vector = |from: &[f64]| {
            let mut vector = V::zeros(N);
            vector.as_mut_slice().copy_from_slice(from);
            vector
        };
        let from = start::<f64>();
        let mut state = State::new(vector(&from.q), vector(&from.p)).unwrap();
        let method = Increment::new(Composition::kahan_li8());
        integrate(&method, system, Grid::of(0.1, 50).unwrap(), &mut state, &mut ()).unwrap();
        [state.q, state.p, state.w]
            .iter()
            .flat_map(|part| part.as_slice().iter().map(|x| x.to_bits()))
            .collect()
    }
    let erased = &*chain().separable::<f64>();
    let fixed = run::<[f64; N], _>(&FputChain::new(N, 1.0, 0.3).unwrap());
    assert_eq!(fixed, run::<Vec<f64>, _>(erased));
    assert_eq!(fixed, run::<nalgebra::DVector<f64>, _>(erased));
    assert_eq!(fixed, run::<nalgebra::SVector<f64, N>, _>(erased));
}

#[test]
fn with_one_degree_of_freedom_a_sweep_is_the_modified_discrete_gradient() {
    let start = State::new(vec![1.5], vec![0.5]).unwrap();
    let [one, other] = ["moddg", "increment-1"].map(|name| {
        let duffing = catalog::duffing(-1.0, 1.0, 0.2);
        let run = duffing.bind(find(name).unwrap(), As::Separable).unwrap();
        after(&run, Grid::of(0.05, 400).unwrap(), &start)
    });
    assert_eq!(one, other);
}

#[test]
fn an_order_that_is_none_is_refused() {
    for order in [vec![], vec![0, 1, 2, 3], vec![0, 1, 2, 3, 3], vec![0, 1, 2, 3, 5]] {
        let method = Increment::new(Composition::pair()).in_order(order);
        let workspace = Method::<Vec<f64>, _>::workspace(&method, &*chain().separable::<f64>());
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
    fn check(name: &str, times: [&str; 2], system: &Built) {
        let system = &*system.separable::<f64>();
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
    check("fput-chain", ["5", "20"], &catalog::chain(8, 1.0, 0.05));
    check("van-der-pol-ring", ["5", "10"], &catalog::ring(5, 1.0, 0.3));
}
