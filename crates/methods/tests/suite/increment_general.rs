//! Coordinate increments without a separable H: orders, the adjoint, references, storage, failures.

use crate::planes;
use crate::slope;
use crate::systems;
use afterbay_core::taylor::trajectory;
use afterbay_core::{
    Grid, InputError, Method, PhasePlane, Quad, Scalar, Series, State, StepFailure, System, Vector,
    integrate,
};
use afterbay_methods::{Composition, GeneralIncrement};
use afterbay_systems::DampedDoublePendulum;
use allocation_counter::measure;
use planes::{Curved, Endless, TWISTED};
use slope::slope;
use systems::{Springs, Twisted, start};

/// The pendulum of the references.
pub(crate) fn pendulum<T: Scalar>(c: [f64; 2]) -> DampedDoublePendulum<T> {
    let one = [T::one(); 2];
    DampedDoublePendulum::new(one, one, T::from_f64(9.81), c.map(T::from_f64)).unwrap()
}

/// The slopes of the errors of q, p and w at t = 1.
fn orders<T, S>(
    system: &S,
    from: &State<[T; 2]>,
    method: &GeneralIncrement,
    counts: &[u64],
) -> [f64; 3]
where
    T: Scalar,
    S: PhasePlane<T> + SeriesToo<T>,
{
    let end = &trajectory::<_, _, 24>(&system.series(), from, T::one(), 1).unwrap()[1];
    let far = |a: [T; 2], b: [T; 2]| {
        a.iter().zip(b).map(|(&a, b)| (a - b).to_f64().abs()).fold(0.0, f64::max)
    };
    let mut errors = [(); 3].map(|()| Vec::new());
    for &count in counts {
        let mut state = from.clone();
        let grid = Grid { h: T::one() / T::from_f64(count as f64), steps: count };
        integrate(method, system, grid, &mut state, &mut ()).unwrap();
        errors[0].push(far(state.q, end.q));
        errors[1].push(far(state.p, end.p));
        errors[2].push(far(state.w, end.w));
    }
    let steps: Vec<f64> = counts.iter().map(|&count| 1.0 / count as f64).collect();
    errors.map(|errors| slope(&steps, &errors))
}

/// The same system in Taylor series arithmetic.
trait SeriesToo<T: Scalar> {
    fn series(&self) -> impl System<Series<T, 24>>;
}
impl<T: Scalar> SeriesToo<T> for DampedDoublePendulum<T> {
    fn series(&self) -> impl System<Series<T, 24>> {
        self.map(Series::constant)
    }
}
impl<T: Scalar> SeriesToo<T> for Curved {
    fn series(&self) -> impl System<Series<T, 24>> {
        Self(self.0)
    }
}

pub(crate) fn state<T: Scalar>(q: [f64; 2], p: [f64; 2]) -> State<[T; 2]> {
    State::new(q.map(T::from_f64), p.map(T::from_f64)).unwrap()
}

fn check_orders<T: Scalar>(compositions: &[(Composition, f64, [u64; 3])]) {
    for (composition, order, counts) in compositions {
        let natural = GeneralIncrement::new(composition.clone());
        for method in [natural.clone(), natural.in_order(vec![1, 0])] {
            let swing = state([0.4, -0.3], [0.5, 0.7]);
            let curve = state([0.4, -0.7], [1.1, 0.2]);
            let found = [
                orders::<T, _>(&pendulum([0.1, 0.2]), &swing, &method, counts),
                orders::<T, _>(&Curved([0.3, 0.2]), &curve, &method, counts),
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
        (Composition::yoshida6(), 6.0, [60, 84, 120]),
        (Composition::kahan_li8(), 8.0, [50, 60, 72]),
    ]);
}

/// A sweep of h followed by its adjoint of -h restores the state.
#[test]
fn the_adjoint_takes_a_sweep_back() {
    fn check<T: Scalar, S: PhasePlane<T>>(system: &S, from: &State<[T; 2]>) {
        // A sweep of length zero, followed by the adjoint.
        let adjoint = Composition::alternating(&[0.0, 1.0]).unwrap();
        for h in [0.01, 0.1, 0.3] {
            let mut state = from.clone();
            for (composition, h) in [(Composition::sweep(), h), (adjoint.clone(), -h)] {
                let method = GeneralIncrement::new(composition);
                let mut workspace = Method::<[T; 2], S>::workspace(&method, system).unwrap();
                method.step(system, T::from_f64(h), &mut state, &mut workspace).unwrap();
            }
            let off = |a: [T; 2], b: [T; 2]| (a[0] - b[0]).abs() + (a[1] - b[1]).abs();
            let off = off(state.q, from.q) + off(state.p, from.p) + off(state.w, from.w);
            assert!(off.to_f64() < 64.0 * T::EPSILON, "{h}: {:e}", off.to_f64());
        }
    }
    check(&pendulum::<f64>([0.1, 0.2]), &state([0.4, -0.3], [0.5, 0.7]));
    check(&pendulum::<Quad>([0.1, 0.2]), &state([0.4, -0.3], [0.5, 0.7]));
    check::<f64, _>(&Curved([0.3, 0.2]), &state([0.4, -0.7], [1.1, 0.2]));
    check::<Quad, _>(&Curved([0.3, 0.2]), &state([0.4, -0.7], [1.1, 0.2]));
}

pub(crate) fn step<S: PhasePlane<f64>>(
    method: &GeneralIncrement,
    system: &S,
    h: f64,
    state: &mut State<[f64; 2]>,
) -> Result<(), StepFailure> {
    let mut workspace = Method::<[f64; 2], S>::workspace(method, system).unwrap();
    method.step(system, h, state, &mut workspace).map(|_| ())
}

#[test]
fn the_pendulum_ends_where_another_library_has_it() {
    const REFERENCES: &str = include_str!("../../../systems/tests/data/many_degrees.csv");
    let rows = |t: &str| -> [[f64; 2]; 3] {
        let lines = REFERENCES.lines().map(|line| line.split(',').collect::<Vec<_>>());
        let rows: Vec<_> =
            lines.filter(|row| row[0] == "damped-double-pendulum" && row[1] == t).collect();
        [3, 5, 7].map(|column| [0, 1].map(|j| rows[j][column].parse().unwrap()))
    };
    let system = pendulum::<f64>([0.1, 0.2]);
    for t in ["2", "5"] {
        let [q, p, _] = rows("0");
        let mut state = State::new(q, p).unwrap();
        let before = state.total(&system);
        let grid = Grid::new(0.01, t.parse().unwrap()).unwrap();
        integrate(
            &GeneralIncrement::new(Composition::kahan_li8()),
            &system,
            grid,
            &mut state,
            &mut (),
        )
        .unwrap();
        let off = [state.q, state.p, state.w]
            .iter()
            .zip(rows(t))
            .flat_map(|(a, b)| [a[0] - b[0], a[1] - b[1]])
            .fold(0.0, |most: f64, x| most.max(x.abs()));
        let drift = (state.total(&system) - before).abs();
        println!("t = {t}: off by {off:e}, K by {drift:e}");
        assert!(off < 1e-9 && drift < 1e-12, "{t}: {off:e} {drift:e}");
    }
}

#[test]
fn friction_that_couples_is_refused() {
    let method = GeneralIncrement::new(Composition::pair());
    let refused = Method::<[f64; 2], Twisted>::workspace(&method, &Twisted { c: 0.3, offset: 0.0 });
    match refused {
        Err(error @ InputError::Unsupported { .. }) => {
            assert!(error.to_string().contains("gonzalez"), "{error}");
        }
        other => panic!("{other:?}"),
    }
    let mut state = state([0.4, -0.7], [1.1, 0.2]);
    let before = System::<f64>::energy(&TWISTED, &state.q, &state.p);
    integrate(&method, &TWISTED, Grid::of(0.1, 1000).unwrap(), &mut state, &mut ()).unwrap();
    assert!((state.energy(&TWISTED) / before - 1.0).abs() < 2e-14 && state.w == [0.0; 2]);
    for order in [vec![], vec![0], vec![0, 0], vec![0, 1, 2]] {
        let method = GeneralIncrement::new(Composition::pair()).in_order(order);
        let refused = Method::<[f64; 2], Twisted>::workspace(&method, &TWISTED);
        assert!(matches!(refused, Err(InputError::Unsupported { .. })));
    }
}

#[test]
fn storage_changes_no_bit() {
    fn run<V: Vector<Scalar = f64>>() -> Vec<u64> {
        let (from_q, from_p) = start::<f64>(5);
        let (mut q, mut p) = (V::zeros(5), V::zeros(5));
        q.as_mut_slice().copy_from_slice(&from_q);
        p.as_mut_slice().copy_from_slice(&from_p);
        let mut state = State::new(q, p).unwrap();
        let method = GeneralIncrement::new(Composition::kahan_li8());
        integrate(&method, &Springs::ring(5, 0.2), Grid::of(0.1, 20).unwrap(), &mut state, &mut ())
            .unwrap();
        [state.q, state.p, state.w]
            .iter()
            .flat_map(|part| part.as_slice().iter().map(|x| x.to_bits()))
            .collect()
    }
    assert_eq!(run::<[f64; 5]>(), run::<Vec<f64>>());
    assert_eq!(run::<[f64; 5]>(), run::<nalgebra::SVector<f64, 5>>());
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
    let (system, method) =
        (pendulum::<f64>([0.1, 0.2]), GeneralIncrement::new(Composition::kahan_li8()));
    for h in [0.05, 3.0] {
        let mut state = State::new(vec![1.2, -0.7], vec![0.0, 0.0]).unwrap();
        let mut workspace = Method::<Vec<f64>, _>::workspace(&method, &system).unwrap();
        let mut failed = 0;
        let taken = measure(|| {
            for _ in 0..50 {
                failed += u64::from(method.step(&system, h, &mut state, &mut workspace).is_err());
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
    fn dissipation_form(&self) -> afterbay_core::DissipationForm {
        afterbay_core::DissipationForm::NONE
    }
}

impl PhasePlane<f64> for Far {
    fn slopes(
        &self,
        _q: &[f64],
        _p: &[f64],
        j: usize,
        [q, p]: [f64; 2],
    ) -> afterbay_core::Slopes<f64> {
        let far = f64::from(u8::from(j == 1));
        afterbay_core::Slopes {
            hq: far * 8.0 * q.powi(3),
            hp: p,
            hqq: far * 24.0 * q * q,
            hqp: 0.0,
            hpp: 1.0,
        }
    }
    fn plane_dissipation(
        &self,
        _q: &[f64],
        _p: &[f64],
        _j: usize,
        _at: [f64; 2],
        _v: f64,
    ) -> afterbay_core::PlaneDissipation<f64> {
        afterbay_core::PlaneDissipation { value: 0.0, by_q: 0.0, by_p: 0.0, by_v: 0.0 }
    }
}

#[test]
fn what_is_far_away_loosens_nothing_else() {
    let method = GeneralIncrement::new(Composition::pair());
    for h in [0.1, 1.0, 3.0, 10.0] {
        for (q, p) in [(0.3, 1.0), (1.0, 0.0), (2.0, -1.0), (0.0, 3.0)] {
            let mut state = State::new([1e8, q], [0.0, p]).unwrap();
            let before = Far.energy(&state.q, &state.p);
            let step = integrate(&method, &Far, Grid::of(h, 1).unwrap(), &mut state, &mut ());
            let change = (Far.energy(&state.q, &state.p) - before).abs() / before;
            assert!(step.is_err() || change < 1e-13, "{h} {q} {p}: {change:e}");
        }
    }
}
