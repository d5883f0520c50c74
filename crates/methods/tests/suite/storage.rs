//! The same arithmetic in every storage, and shortcuts for D = 0 that change no result.

use crate::bind::nonlinear;
use crate::slope;
use afterbay_core::taylor::trajectory;
use afterbay_core::{
    Curvature, Dissipation, Grid, Linear, Method, OrderRaising, Scalar, Separable, State, System,
    Vector, integrate,
};
use afterbay_methods::registry::FIXED;
use afterbay_methods::{Leapfrog, ModDg, Rk4};
use afterbay_systems::{DampedOscillator, Duffing, ModifiedVanDerPol, VanDerPol};
use nalgebra::{DVector, SVector};
use proptest::prelude::*;
use slope::slope;

/// q, p, w and t after 200 steps, as bits.
fn carry<V, S, M>(method: &M, system: &S, q: V, p: V) -> [Vec<u64>; 4]
where
    V: Vector<Scalar = f64>,
    S: System<f64> + ?Sized,
    M: Method<V, S>,
{
    let mut state = State::new(q, p).unwrap();
    integrate(method, system, Grid::of(0.05, 200).unwrap(), &mut state, &mut ()).unwrap();
    let bits = |part: &[f64]| part.iter().map(|x| x.to_bits()).collect();
    [bits(state.q.as_slice()), bits(state.p.as_slice()), bits(state.w.as_slice()), bits(&[state.t])]
}

/// Checks that every storage gives the same bits.
fn assert_storage_changes_no_bit<S, M>(method: &M, system: &S)
where
    S: System<f64> + ?Sized,
    M: Method<[f64; 1], S>
        + Method<SVector<f64, 1>, S>
        + Method<Vec<f64>, S>
        + Method<DVector<f64>, S>,
{
    let (q, p) = (2.3, -3.1);
    let array = carry(method, system, [q], [p]);
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
    assert_storage_changes_no_bit_of_solved(&oscillator);
    assert_storage_changes_no_bit_of_solved(&Duffing::new(-1.0, 0.5, 0.1).unwrap());
    assert_storage_changes_no_bit_of_solved(&VanDerPol::new(0.7).unwrap());
    assert_storage_changes_no_bit_of_solved(&ModifiedVanDerPol::new(0.7, 1.0, 0.3).unwrap());
}

#[test]
fn storage_changes_no_bit_of_two_degrees_of_freedom() {
    let (q, p) = ([0.7, -0.4], [0.3, 1.1]);
    for w in [carry(&Leapfrog, &Coupled, q, p), carry(&Rk4, &Coupled, q, p)] {
        assert!(w.iter().take(3).all(|part| part.len() == 2));
    }
    let vec = |x: [f64; 2]| x.to_vec();
    assert_eq!(carry(&Leapfrog, &Coupled, q, p), carry(&Leapfrog, &Coupled, vec(q), vec(p)));
    assert_eq!(carry(&Rk4, &Coupled, q, p), carry(&Rk4, &Coupled, vec(q), vec(p)));
    let (sq, sp) = (SVector::from(q), SVector::from(p));
    assert_eq!(carry(&Leapfrog, &Coupled, q, p), carry(&Leapfrog, &Coupled, sq, sp));
    assert_eq!(carry(&Rk4, &Coupled, q, p), carry(&Rk4, &Coupled, sq, sp));
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
    fn divided_difference(&self, q: &[f64], j: usize, to: f64) -> afterbay_core::Line<f64> {
        self.0.divided_difference(q, j, to)
    }
    fn dissipation_of(&self, q: &[f64], p: &[f64], j: usize) -> Dissipation<f64> {
        self.0.dissipation_of(q, p, j)
    }
}

/// The largest difference of q and p after a step, in roundings of their size; w must not change.
fn compare<M, S>(method: &M, aware: &S, unaware: &Unaware<S>, q: f64, p: f64, h: f64) -> f64
where
    S: System<f64>,
    M: Method<[f64; 1], S> + Method<[f64; 1], Unaware<S>>,
{
    let (mut a, mut b) = (State::new([q], [p]).unwrap(), State::new([q], [p]).unwrap());
    let grid = || Grid::of(h, 1).unwrap();
    integrate(method, aware, grid(), &mut a, &mut ()).unwrap();
    integrate(method, unaware, grid(), &mut b, &mut ()).unwrap();
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
        let unaware = Unaware(system);
        prop_assert_eq!(compare(&Leapfrog, &system, &unaware, q, p, h), 0.0);
        prop_assert_eq!(compare(&Rk4, &system, &unaware, q, p, h), 0.0);
        prop_assert!(compare(&ModDg::newton(), &system, &unaware, q, p, h) <= 4.0);
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
        integrate(&ModDg::newton(), &system, grid(), &mut solved, &mut ()).unwrap();
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
    fn check<S: OrderRaising<f64> + Curvature<f64> + Copy + 'static>(system: S) {
        for row in FIXED {
            let Ok(run) = nonlinear::<f64, S>(row, system) else { continue };
            let mut state = State::new([1.3], [-0.7]).unwrap();
            state.w = [0.1];
            for _ in 0..100 {
                run.step(0.01, &mut state).unwrap();
            }
            assert_eq!(state.w[0].to_bits(), 0.1_f64.to_bits(), "{}", row.name);
        }
    }
    check(Duffing::new(1.0, 0.5, 0.0).unwrap());
    check(VanDerPol::new(0.0).unwrap());
    check(ModifiedVanDerPol::new(0.0, 1.0, 0.5).unwrap());
    let undamped = DampedOscillator::new(1.0, -0.0).unwrap();
    check(undamped);
    assert!(undamped.dissipation_rate(0) == 0.0);
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

/// The slopes of the largest errors of q, p and w of both degrees of freedom over [0, 2].
fn global_orders<M: Method<[f64; 2], Coupled>>(method: &M) -> Vec<f64> {
    let start = || State::new([1.2, -0.6], [0.5, 1.4]).unwrap();
    let counts = [40, 52, 64, 80, 100];
    let steps = counts.map(|count| 2.0 / count as f64);
    let errors: Vec<[f64; 6]> = counts
        .iter()
        .zip(steps)
        .map(|(&count, h)| {
            let exact = trajectory::<_, _, 20>(&Coupled, &start(), h, count).unwrap();
            let mut worst = [0.0_f64; 6];
            let mut look = |n: u64, state: &State<[f64; 2]>| {
                let exact = &exact[n as usize];
                let pairs = [(state.q, exact.q), (state.p, exact.p), (state.w, exact.w)];
                let off =
                    pairs.into_iter().flat_map(|(a, b)| [(a[0] - b[0]).abs(), (a[1] - b[1]).abs()]);
                worst.iter_mut().zip(off).for_each(|(worst, off)| *worst = worst.max(off));
                std::ops::ControlFlow::Continue(())
            };
            integrate(
                method,
                &Coupled,
                Grid::of(h, count as u64).unwrap(),
                &mut start(),
                &mut look,
            )
            .unwrap();
            worst
        })
        .collect();
    (0..6)
        .map(|i| slope(&steps, &errors.iter().map(|error| error[i]).collect::<Vec<_>>()))
        .collect()
}

#[test]
fn two_coupled_degrees_of_freedom_have_the_order() {
    for (found, order) in [(global_orders(&Leapfrog), 2.0), (global_orders(&Rk4), 4.0)] {
        println!("{found:.3?}");
        assert!(found.iter().all(|found| (found - order).abs() < 0.1), "{found:.3?}, not {order}");
    }
}
