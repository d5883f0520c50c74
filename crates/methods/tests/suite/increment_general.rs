//! Coordinate increments without a separable H: orders, the adjoint, references, storage, failures.

use crate::bind::after;
use crate::catalog::{self, As, Both, Built};
use crate::many::orders::orders_at_end;
use crate::many::{self, InSeries, errors, exact_end};
use crate::planes::{Curved, Endless, TWISTED};
use crate::systems::{Springs, Twisted, start};
use afterbay_core::{
    DissipationForm, Grid, InputError, Method, PhasePlane, PlaneDissipation, Quad, Scalar, Slopes,
    State, StepFailure, System, Vector, integrate,
};
use afterbay_methods::registry::find;
use afterbay_methods::{Composition, GeneralIncrement};
use afterbay_systems::catalog::Expandable;
use allocation_counter::measure;

/// The pendulum of the references.
pub(crate) fn pendulum(c: [f64; 2]) -> Built {
    catalog::pendulum([1.0; 2], [1.0; 2], 9.81, c)
}

/// The orders of q, p and w at t = 1.
fn orders<T: Scalar>(
    system: &dyn PhasePlane<T>,
    series: &InSeries<T>,
    from: &State<Vec<T>>,
    method: &GeneralIncrement,
    counts: &[u64],
) -> [f64; 3] {
    orders_at_end(&exact_end(series, from, 1.0), counts, &mut |grid| {
        let mut state = from.clone();
        integrate(method, system, grid, &mut state, &mut ()).unwrap();
        state
    })
}

pub(crate) fn state<T: Scalar>(q: [f64; 2], p: [f64; 2]) -> State<Vec<T>> {
    many::start([&q, &p])
}

fn check_orders<T: Both + Expandable>(compositions: &[(Composition, f64, [u64; 3])]) {
    for (composition, order, counts) in compositions {
        let natural = GeneralIncrement::new(composition.clone());
        for method in [natural.clone(), natural.in_order(vec![1, 0])] {
            let swing = state([0.4, -0.3], [0.5, 0.7]);
            let curve = state([0.4, -0.7], [1.1, 0.2]);
            let (swinging, curved) = (pendulum([0.1, 0.2]), Curved([0.3, 0.2]));
            let (planes, series) = (&*swinging.planes(), &*swinging.series());
            let found = [
                orders::<T>(planes, series, &swing, &method, counts),
                orders::<T>(&curved, &curved, &curve, &method, counts),
            ];
            println!("{order} {found:.3?}");
            assert!(
                found.iter().flatten().all(|found| (found - order).abs() < 0.1),
                "{method:?}: {found:?}"
            );
        }
    }
}

#[test]
fn compositions_have_their_order_in_q_p_and_w() {
    check_orders::<f64>(&[
        (Composition::sweep(), 1.0, [1000, 2000, 4000]),
        (Composition::pair(), 2.0, [1000, 2000, 4000]),
        (Composition::suzuki4(), 4.0, [60, 84, 120]),
        (Composition::blanes_moan4(), 4.0, [60, 84, 120]),
        (Composition::yoshida6(), 6.0, [24, 30, 36]),
    ]);
}

#[test]
fn compositions_have_their_order_in_31_digits() {
    check_orders::<Quad>(&[
        (Composition::suzuki4(), 4.0, [60, 84, 120]),
        (Composition::yoshida6(), 6.0, [36, 48, 64]),
        (Composition::kahan_li8(), 8.0, [50, 60, 72]),
    ]);
}

/// A sweep of h followed by its adjoint of -h restores the state.
#[test]
fn the_adjoint_takes_a_sweep_back() {
    fn check<T: Scalar>(system: &dyn PhasePlane<T>, from: &State<Vec<T>>) {
        // A sweep of length zero, followed by the adjoint.
        let adjoint = Composition::alternating(&[0.0, 1.0]).unwrap();
        for h in [0.01, 0.1, 0.3] {
            let mut state = from.clone();
            for (composition, h) in [(Composition::sweep(), h), (adjoint.clone(), -h)] {
                let method = GeneralIncrement::new(composition);
                let mut workspace = method.workspace(system).unwrap();
                method.step(system, T::from_f64(h), &mut state, &mut workspace).unwrap();
            }
            let off: f64 = errors(&state, from).iter().sum();
            assert!(off < 32.0 * T::EPSILON, "{h}: {off:e}");
        }
    }
    check::<f64>(&*pendulum([0.1, 0.2]).planes(), &state([0.4, -0.3], [0.5, 0.7]));
    check::<Quad>(&*pendulum([0.1, 0.2]).planes(), &state([0.4, -0.3], [0.5, 0.7]));
    check::<f64>(&Curved([0.3, 0.2]), &state([0.4, -0.7], [1.1, 0.2]));
    check::<Quad>(&Curved([0.3, 0.2]), &state([0.4, -0.7], [1.1, 0.2]));
}

pub(crate) fn step(
    method: &GeneralIncrement,
    system: &dyn PhasePlane<f64>,
    h: f64,
    state: &mut State<Vec<f64>>,
) -> Result<(), StepFailure> {
    let mut workspace = method.workspace(system).unwrap();
    method.step(system, h, state, &mut workspace).map(|_| ())
}

#[test]
fn the_pendulum_ends_where_another_library_has_it() {
    const REFERENCES: &str = include_str!("../../../systems/tests/data/many_degrees.csv");
    let rows = |t: &str| -> [Vec<f64>; 3] {
        let lines = REFERENCES.lines().map(|line| line.split(',').collect::<Vec<_>>());
        let rows: Vec<_> =
            lines.filter(|row| row[0] == "damped-double-pendulum" && row[1] == t).collect();
        [3, 5, 7].map(|column| rows.iter().map(|row| row[column].parse().unwrap()).collect())
    };
    let system = pendulum([0.1, 0.2]);
    let run = system.bind(find("increment-8").unwrap(), As::General).unwrap();
    let [q, p, _] = rows("0");
    let start = State::new(q, p).unwrap();
    for t in ["2", "5"] {
        let state = after(&run, Grid::new(0.01, t.parse().unwrap()).unwrap(), &start);
        let [q, p, w] = rows(t);
        let off = errors(&state, &State { q, p, w, t: state.t }).into_iter().fold(0.0, f64::max);
        let drift = (state.total(&*system) - start.total(&*system)).abs();
        println!("t = {t}: off by {off:e}, K by {drift:e}");
        assert!(off < 1e-9 && drift < 1e-12, "{t}: {off:e} {drift:e}");
    }
}

#[test]
fn friction_that_couples_is_refused() {
    let method = GeneralIncrement::new(Composition::pair());
    let workspace = |method: &GeneralIncrement, system: &dyn PhasePlane<f64>| {
        Method::<Vec<f64>, _>::workspace(method, system)
    };
    match workspace(&method, &Twisted { c: 0.3, offset: 0.0 }) {
        Err(error @ InputError::Unsupported { .. }) => {
            assert!(error.to_string().contains("gonzalez"), "{error}");
        }
        other => panic!("{other:?}"),
    }
    let mut state = state([0.4, -0.7], [1.1, 0.2]);
    let (twisted, grid): (&dyn PhasePlane<f64>, _) = (&TWISTED, Grid::of(0.1, 1000).unwrap());
    let before = state.energy(twisted);
    integrate(&method, twisted, grid, &mut state, &mut ()).unwrap();
    assert!((state.energy(twisted) / before - 1.0).abs() < 2e-14 && state.w == [0.0; 2]);
    for order in [vec![], vec![0], vec![0, 0], vec![0, 1, 2]] {
        let method = GeneralIncrement::new(Composition::pair()).in_order(order);
        assert!(matches!(workspace(&method, twisted), Err(InputError::Unsupported { .. })));
    }
}

/// Nor does the erasure of the type of the system.
#[test]
fn storage_changes_no_bit() {
    fn run<V: Vector<Scalar = f64>, S: PhasePlane<f64> + ?Sized>(system: &S) -> Vec<u64> {
        let (from_q, from_p) = start::<f64>(5);
        let (mut q, mut p) = (V::zeros(5), V::zeros(5));
        q.as_mut_slice().copy_from_slice(&from_q);
        p.as_mut_slice().copy_from_slice(&from_p);
        let mut state = State::new(q, p).unwrap();
        let method = GeneralIncrement::new(Composition::kahan_li8());
        integrate(&method, system, Grid::of(0.1, 20).unwrap(), &mut state, &mut ()).unwrap();
        [state.q, state.p, state.w]
            .iter()
            .flat_map(|part| part.as_slice().iter().map(|x| x.to_bits()))
            .collect()
    }
    let ring = Springs::ring(5, 0.2);
    let (fixed, erased) = (run::<[f64; 5], _>(&ring), &ring as &dyn PhasePlane<f64>);
    assert_eq!(fixed, run::<Vec<f64>, _>(erased));
    assert_eq!(fixed, run::<nalgebra::SVector<f64, 5>, _>(erased));
}

#[test]
fn failures_have_names_and_leave_the_state_alone() {
    let fails = |a: f64, h: f64| {
        let start = state([0.5, 2.0], [0.1, 1.0]);
        let mut state = start.clone();
        let failure = step(&GeneralIncrement::new(Composition::pair()), &Endless(a), h, &mut state)
            .unwrap_err();
        assert_eq!(state, start);
        failure
    };
    let stalled = fails(5.0, 5.0);
    assert!(
        matches!(stalled, StepFailure::NewtonStalled { dof: 1, iterations, .. } if iterations > 10),
        "{stalled}"
    );
    assert!(matches!(fails(f64::NAN, 0.1), StepFailure::NonFinite { dof: 1, .. }));
    assert!(matches!(fails(f64::MAX, 0.1), StepFailure::NonFinite { dof: 1, .. }));
}

#[test]
fn a_step_allocates_nothing() {
    let system = &*pendulum([0.1, 0.2]).planes::<f64>();
    let method = GeneralIncrement::new(Composition::kahan_li8());
    for h in [0.05, 3.0] {
        let mut state = State::new(vec![1.2, -0.7], vec![0.0, 0.0]).unwrap();
        let mut workspace = Method::<Vec<f64>, _>::workspace(&method, system).unwrap();
        let mut failed = 0;
        let taken = measure(|| {
            for _ in 0..50 {
                failed += u64::from(method.step(system, h, &mut state, &mut workspace).is_err());
            }
        });
        assert_eq!(taken.count_total, 0);
        assert!(h > 1.0 || failed == 0, "{failed}");
    }
}

/// H = p0²/2 + p1²/2 + 2 q1⁴: q0 moves freely and is large.
struct Far;

impl System<f64> for Far {
    fn dof(&self) -> usize {
        2
    }
    fn energy(&self, q: &[f64], p: &[f64]) -> f64 {
        (p[0] * p[0] + p[1] * p[1]) / 2.0 + 2.0 * q[1].powi(4)
    }
    fn gradient(&self, q: &[f64], p: &[f64], hq: &mut [f64], hp: &mut [f64]) {
        hq.copy_from_slice(&[0.0, 8.0 * q[1].powi(3)]);
        hp.copy_from_slice(p);
    }
    fn dissipation(&self, _q: &[f64], _p: &[f64], _v: &[f64], d: &mut [f64]) {
        d.fill(0.0);
    }
    fn dissipation_form(&self) -> DissipationForm {
        DissipationForm::NONE
    }
}

impl PhasePlane<f64> for Far {
    fn slopes(&self, _q: &[f64], _p: &[f64], j: usize, [q, p]: [f64; 2]) -> Slopes<f64> {
        let far = f64::from(u8::from(j == 1));
        Slopes { hq: far * 8.0 * q.powi(3), hp: p, hqq: far * 24.0 * q * q, hqp: 0.0, hpp: 1.0 }
    }
    fn plane_dissipation(
        &self,
        _q: &[f64],
        _p: &[f64],
        _j: usize,
        _at: [f64; 2],
        _v: f64,
    ) -> PlaneDissipation<f64> {
        PlaneDissipation { value: 0.0, by_q: 0.0, by_p: 0.0, by_v: 0.0 }
    }
}

#[test]
fn what_is_far_away_loosens_nothing_else() {
    let method = GeneralIncrement::new(Composition::pair());
    for h in [0.1, 1.0, 3.0, 10.0] {
        for (q, p) in [(0.3, 1.0), (1.0, 0.0), (2.0, -1.0), (0.0, 3.0)] {
            let mut state = state([1e8, q], [0.0, p]);
            let before = Far.energy(&state.q, &state.p);
            let step = step(&method, &Far, h, &mut state);
            let change = (Far.energy(&state.q, &state.p) - before).abs() / before;
            assert!(step.is_err() || change < 1e-13, "{h} {q} {p}: {change:e}");
        }
    }
}
