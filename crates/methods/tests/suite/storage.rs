//! The same arithmetic in every storage, and shortcuts for D = 0 that change no result.

use crate::bind::{AnySeparable, by_force};
use crate::catalog::{self, As, duffing, modified_van_der_pol, van_der_pol};
use crate::compensated::bits;
use crate::many::orders::check_orders;
use afterbay_core::{
    Dissipation, Grid, Line, Linear, Method, Scalar, Separable, Single, State, System, Vector,
    integrate,
};
use afterbay_methods::registry::{FIXED, find};
use afterbay_methods::{Leapfrog, ModDg, Rk4};
use afterbay_systems::{DampedOscillator, Duffing};
use nalgebra::{DVector, SVector};
use proptest::prelude::*;

/// q, p and w after 200 steps, as bits.
fn carry<V, S, M>(method: &M, system: &S, q: V, p: V) -> Vec<u64>
where
    V: Vector<Scalar = f64>,
    S: System<f64> + ?Sized,
    M: Method<V, S>,
{
    let (mut state, mut workspace) = (State::new(q, p).unwrap(), method.workspace(system).unwrap());
    for _ in 0..200 {
        method.step(system, 0.05, &mut state, &mut workspace).unwrap();
    }
    bits(&state)
}

/// The bits of the state after 200 steps by the time loop, and its time.
fn run<V: Vector<Scalar = f64>>(system: &dyn Linear<f64>, q: V, p: V) -> (Vec<u64>, f64) {
    let (mut state, grid) = (State::new(q, p).unwrap(), Grid::of(0.05, 200).unwrap());
    integrate(&ModDg::linear(), system, grid, &mut state, &mut ()).unwrap();
    (bits(&state), state.t)
}

/// Checks that every storage gives the same bits.
fn assert_storage_changes_no_bit<S, M>(method: &M, system: &S)
where
    S: System<f64> + ?Sized,
    M: Method<[f64; 1], S>
        + Method<Single<f64>, S>
        + Method<SVector<f64, 1>, S>
        + Method<Vec<f64>, S>
        + Method<DVector<f64>, S>,
{
    let (q, p) = (2.3, -3.1);
    let array = carry(method, system, [q], [p]);
    assert_eq!(array, carry(method, system, Single(q), Single(p)));
    assert_eq!(array, carry(method, system, SVector::<f64, 1>::new(q), SVector::<f64, 1>::new(p)));
    assert_eq!(array, carry(method, system, vec![q], vec![p]));
    assert_eq!(
        array,
        carry(method, system, DVector::from_element(1, q), DVector::from_element(1, p))
    );
}

fn assert_storage_changes_no_bit_of_solved(system: &dyn Separable<f64>) {
    assert_storage_changes_no_bit(&Leapfrog, system);
    assert_storage_changes_no_bit(&Rk4, system);
    assert_storage_changes_no_bit(&ModDg::newton(), system);
}

#[test]
fn storage_changes_no_bit() {
    let oscillator = DampedOscillator::new(1.0, 0.1).unwrap();
    assert_storage_changes_no_bit(&ModDg::linear(), &oscillator);
    let (q, p) = (2.3, -3.1);
    let array = run(&oscillator, [q], [p]);
    assert_eq!(array, run(&oscillator, Single(q), Single(p)));
    assert_eq!(array, run(&oscillator, SVector::<f64, 1>::new(q), SVector::<f64, 1>::new(p)));
    assert_eq!(array, run(&oscillator, vec![q], vec![p]));
    let vector = |x: f64| DVector::from_element(1, x);
    assert_eq!(array, run(&oscillator, vector(q), vector(p)));
    for listed in [
        catalog::oscillator(1.0, 0.1),
        duffing(-1.0, 0.5, 0.1),
        van_der_pol(0.7),
        modified_van_der_pol(0.7, 1.0, 0.3),
    ] {
        assert_storage_changes_no_bit_of_solved(&*listed.separable());
    }
}

#[test]
fn storage_changes_no_bit_of_two_degrees_of_freedom() {
    let (q, p) = ([0.7, -0.4], [0.3, 1.1]);
    let (vq, vp, sq, sp) = (q.to_vec(), p.to_vec(), SVector::from(q), SVector::from(p));
    let erased: &dyn Separable<f64> = &Coupled;
    let [leapfrog, rk4] = [carry(&Leapfrog, &Coupled, q, p), carry(&Rk4, &Coupled, q, p)];
    assert!(leapfrog.len() == 6 && rk4.len() == 6);
    assert_eq!(leapfrog, carry(&Leapfrog, erased, vq.clone(), vp.clone()));
    assert_eq!(rk4, carry(&Rk4, erased, vq, vp));
    assert_eq!(leapfrog, carry(&Leapfrog, erased, sq, sp));
    assert_eq!(rk4, carry(&Rk4, erased, sq, sp));
}

/// A system that does not declare D = 0.
struct Unaware<S>(S);

impl<S: System<f64>> System<f64> for Unaware<S> {
    fn dof(&self) -> usize {
        self.0.dof()
    }
    fn energy(&self, q: &[f64], p: &[f64]) -> f64 {
        self.0.energy(q, p)
    }
    fn gradient(&self, q: &[f64], p: &[f64], hq: &mut [f64], hp: &mut [f64]) {
        self.0.gradient(q, p, hq, hp);
    }
    fn dissipation(&self, q: &[f64], p: &[f64], v: &[f64], d: &mut [f64]) {
        self.0.dissipation(q, p, v, d);
    }
}

impl<S: Separable<f64>> Separable<f64> for Unaware<S> {
    fn partial(&self, q: &[f64], j: usize, at: f64) -> f64 {
        self.0.partial(q, j, at)
    }
    fn divided_difference(&self, q: &[f64], j: usize, to: f64) -> Line<f64> {
        self.0.divided_difference(q, j, to)
    }
    fn dissipation_of(&self, q: &[f64], p: &[f64], j: usize) -> Dissipation<f64> {
        self.0.dissipation_of(q, p, j)
    }
}

/// The largest difference of q and p after a step, in roundings of their size; w must not change.
fn compare<M: Method<[f64; 1], AnySeparable<f64>>>(
    method: &M,
    aware: &Duffing<f64>,
    [q, p, h]: [f64; 3],
) -> f64 {
    let systems: [&AnySeparable<f64>; 2] = [aware, &Unaware(*aware)];
    let [a, b] = systems.map(|system| {
        let mut state = State::new([q], [p]).unwrap();
        integrate(method, system, Grid::of(h, 1).unwrap(), &mut state, &mut ()).unwrap();
        state
    });
    assert!(a.w[0].to_bits() == 0 && b.w[0] == 0.0, "{a:?} {b:?}");
    let off = (a.q[0] - b.q[0]).abs().max((a.p[0] - b.p[0]).abs());
    off / (f64::EPSILON
        * [q, p, a.q[0], a.p[0]].into_iter().fold(f64::MIN_POSITIVE, |m, x| m.max(x.abs())))
}

proptest! {
    #![proptest_config(ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::with_cases(500)
    })]

    #[test]
    fn without_dissipation_the_step_is_the_conservative_one(
        q in -5.0..5.0_f64, p in -5.0..5.0_f64, h in 1e-3..0.3_f64,
    ) {
        let system = Duffing::new(1.0, 0.2, 0.0).unwrap();
        prop_assert_eq!(compare(&Leapfrog, &system, [q, p, h]), 0.0);
        prop_assert_eq!(compare(&Rk4, &system, [q, p, h]), 0.0);
        prop_assert!(compare(&ModDg::newton(), &system, [q, p, h]) <= 4.0);
    }

    #[test]
    fn closed_form_and_newton_agree(
        q in -10.0..10.0_f64, p in -10.0..10.0_f64, k in 1e-3..1e2_f64,
        b in -1.0..10.0_f64, log_h in -6.0..0.0_f64,
    ) {
        let system = DampedOscillator::new(k, b).unwrap();
        let start = State::new([q], [p]).unwrap();
        let (mut closed, mut solved) = (start.clone(), start);
        let grid = || Grid::of(10f64.powf(log_h), 1).unwrap();
        integrate(&ModDg::linear(), &system, grid(), &mut closed, &mut ()).unwrap();
        let erased: &AnySeparable<f64> = &system;
        integrate(&ModDg::newton(), erased, grid(), &mut solved, &mut ()).unwrap();
        // In units of energy, √k q and p are equivalent for both forms. Here σ > 1/2.
        let size = (p * p + k * q * q).sqrt();
        let off = [(closed.q[0] - solved.q[0]) * k.sqrt(), closed.p[0] - solved.p[0]];
        let dw = (closed.w[0] - solved.w[0]).abs();
        let unit = 16.0 * f64::EPSILON;
        prop_assert!(off.into_iter().all(|off| off.abs() <= unit * size), "{closed:?} {solved:?}");
        let energy = size * size + closed.w[0].abs();
        prop_assert!(dw <= unit * energy, "{closed:?} {solved:?}");
    }
}

#[test]
fn without_dissipation_every_reservoir_stays_exactly_as_it_was() {
    for system in [
        duffing(1.0, 0.5, 0.0),
        van_der_pol(0.0),
        modified_van_der_pol(0.0, 1.0, 0.5),
        catalog::oscillator(1.0, -0.0),
    ] {
        for row in FIXED {
            let Ok(run) = system.bind::<f64>(row, As::Nonlinear) else { continue };
            let mut state = State::new([1.3], [-0.7]).unwrap();
            state.w = [0.1];
            for _ in 0..100 {
                run.step(0.01, &mut state).unwrap();
            }
            assert_eq!(state.w[0].to_bits(), 0.1_f64.to_bits(), "{}", row.name);
        }
    }
    assert!(DampedOscillator::new(1.0, -0.0).unwrap().dissipation_rate(0) == 0.0);
}

/// Two masses 2 and 3 on springs with a quartic coupling, each with a friction of its own.
#[derive(Clone, Copy)]
struct Coupled;

const MASS: [f64; 2] = [2.0, 3.0];
const FRICTION: [f64; 2] = [0.2, 0.5];

impl<T: Scalar> System<T> for Coupled {
    fn dof(&self) -> usize {
        2
    }
    fn energy(&self, q: &[T], p: &[T]) -> T {
        let kinetic = (0..2).fold(T::zero(), |sum, j| sum + p[j] * p[j] / T::from_f64(MASS[j]));
        let coupling = (q[0] - q[1]) * (q[0] - q[1]);
        (kinetic + q[0] * q[0] + q[1] * q[1] + (coupling * coupling).half()).half()
    }
    fn gradient(&self, q: &[T], p: &[T], hq: &mut [T], hp: &mut [T]) {
        for j in 0..2 {
            (hq[j], hp[j]) = (self.partial(q, j, q[j]), p[j] / T::from_f64(MASS[j]));
        }
    }
    fn dissipation(&self, _q: &[T], p: &[T], _v: &[T], d: &mut [T]) {
        (d[0], d[1]) = (T::from_f64(FRICTION[0]) * p[0], T::from_f64(FRICTION[1]) * p[1]);
    }
}

impl<T: Scalar> Separable<T> for Coupled {
    fn mass(&self, j: usize) -> T {
        T::from_f64(MASS[j])
    }
    fn partial(&self, q: &[T], j: usize, at: T) -> T {
        let stretch = at - q[1 - j];
        at + stretch * stretch * stretch
    }
    fn dissipation_of(&self, _q: &[T], p: &[T], j: usize) -> Dissipation<T> {
        let by_p = T::from_f64(FRICTION[j]);
        Dissipation { value: by_p * p[j], by_q: T::zero(), by_p }
    }
}

#[test]
fn two_coupled_degrees_of_freedom_have_the_order() {
    let from: [&[f64]; 2] = [&[1.2, -0.6], &[0.5, 1.4]];
    for (name, order) in [("leapfrog", 2.0), ("rk4", 4.0)] {
        let run = by_force::<f64, _>(find(name).unwrap(), Coupled).unwrap();
        check_orders(name, (&run, &Coupled), from, (2.0, [40, 52, 72, 100]), (order, 0.1));
    }
}
