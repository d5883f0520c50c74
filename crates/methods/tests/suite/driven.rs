//! Every method on driven systems: the orders of q, p, w and s, and K, in 31 digits.

use crate::slope::slope;
use afterbay_core::taylor::trajectory;
use afterbay_core::{
    Abilities, Drive, Driven, Formulas, FromFormulas, Grid, Motors, Quad, Scalar, Series, State,
    StateRef, Tolerance, accounts, with_motors,
};
use afterbay_methods::registry::{FIXED, METHODS, Needs, Row, Setting, bind};
use std::ops::ControlFlow;
use std::sync::Arc;

/// Two particles in a quartic well, coupled by a nonlinear spring, with drag that depends on the
/// place.
#[derive(Clone, Copy)]
struct Pair;

impl Formulas for Pair {
    fn dof(&self) -> usize {
        2
    }
    fn potential<T: Scalar>(&self, q: &[T]) -> T {
        let twist = q[1] - q[0];
        let quartic = (q[0] * q[0] * q[0] * q[0]).half().half();
        (q[0] * q[0] + q[1] * q[1]).half() + quartic - twist.sin_cos().1
    }
    fn dissipation<T: Scalar>(&self, q: &[T], v: &[T], j: usize) -> T {
        let number = T::from_f64;
        number(0.3) * v[j] * (T::one() + q[0] * q[1].half()) + number(0.1) * v[j] * v[j] * v[j]
    }
    fn mass(&self, j: usize) -> f64 {
        [1.0, 2.0][j]
    }
    fn may_be_singular(&self) -> bool {
        false
    }
}

/// One particle in a quartic well.
#[derive(Clone, Copy)]
struct Single;

impl Formulas for Single {
    fn dof(&self) -> usize {
        1
    }
    fn potential<T: Scalar>(&self, q: &[T]) -> T {
        (q[0] * q[0]).half() + (q[0] * q[0] * q[0] * q[0]).half().half()
    }
    fn dissipation<T: Scalar>(&self, q: &[T], v: &[T], _j: usize) -> T {
        T::from_f64(0.25) * v[0] * (T::one() + q[0] * q[0])
    }
    fn may_be_singular(&self) -> bool {
        false
    }
}

/// F_j = a_j cos(ω_j t) (1 + q_j²/4) on the first particles.
struct Shaker(&'static [usize]);

const AMPLITUDES: [f64; 2] = [1.5, -0.8];
const FREQUENCIES: [f64; 2] = [1.7, 2.9];

impl<T: Scalar> Drive<T> for Shaker {
    fn driven(&self) -> &[usize] {
        self.0
    }
    fn force(&self, k: usize, q: &[T], t: T) -> T {
        let (a, omega) = (T::from_f64(AMPLITUDES[k]), T::from_f64(FREQUENCIES[k]));
        let q = q[self.0[k]];
        a * (omega * t).sin_cos().1 * (q * q).half().half().mul_add(T::one(), T::one())
    }
    fn slopes(&self, k: usize, q: &[T], t: T, put: &mut dyn FnMut(Option<usize>, T)) {
        let (a, omega) = (T::from_f64(AMPLITUDES[k]), T::from_f64(FREQUENCIES[k]));
        let ((sin, cos), q) = ((omega * t).sin_cos(), q[self.0[k]]);
        put(Some(self.0[k]), a * cos * q.half());
        put(None, -(a * omega * sin * (q * q).half().half().mul_add(T::one(), T::one())));
    }
}

fn driven<T: Scalar, F: Formulas + Copy + 'static>(
    formulas: F,
    driven: &'static [usize],
) -> Driven<dyn Abilities<T>, dyn Drive<T>> {
    let system: Arc<dyn Abilities<T>> = Arc::new(FromFormulas(formulas));
    let drive: Arc<dyn Drive<T>> = Arc::new(Shaker(driven));
    Driven::new(system, drive).unwrap()
}

fn start(dof: usize, motors: usize) -> State<Vec<Quad>> {
    let numbers = |x: [f64; 2]| x[..dof].iter().map(|&x| Quad::from_f64(x)).collect();
    with_motors(&State::new(numbers([1.1, -0.4]), numbers([0.6, 0.9])).unwrap(), motors)
}

/// [q, p, w, s] of the degrees of freedom and the motors.
fn parts(state: StateRef<'_, Quad>, dof: usize, driven: &[usize]) -> [Vec<Quad>; 4] {
    let supplied: Vec<Quad> = state.w[dof..].iter().map(|&w| -w).collect();
    let mut lost = state.w[..dof].to_vec();
    driven.iter().zip(&state.p[dof..]).for_each(|(&j, &s)| lost[j] += s);
    [state.q[..dof].to_vec(), state.p[..dof].to_vec(), lost, supplied]
}

/// The orders of the largest errors of q, p, w and s over [0, 1], and the largest deviation of K.
fn orders<F: Formulas + Copy + 'static>(
    row: &Row,
    formulas: F,
    which: &'static [usize],
    counts: &[u64],
) -> Option<([f64; 4], f64)> {
    let system = Arc::new(driven::<Quad, F>(formulas, which));
    let run = bind::<Quad>(row, system.clone()).ok()?;
    let dof = formulas.dof();
    let start = start(dof, which.len());
    let series = driven::<Series<Quad, 24>, F>(formulas, which);
    let total = start.total(&*system);
    let (mut errors, mut off) = ([(); 4].map(|()| Vec::new()), 0.0_f64);
    for &count in counts {
        let mut state = start.clone();
        let grid = Grid::of(1.0 / count as f64, count).unwrap();
        let exact = trajectory::<_, _, 24>(&series, &start, grid.h, count as usize).unwrap();
        let mut worst = [0.0_f64; 4];
        run.run(grid, &mut state, 1, &mut |step, state| {
            off = off.max((state.total(&*system) - total).to_f64().abs());
            let exact = parts(exact[step as usize].state_ref(), dof, which);
            for ((worst, found), exact) in worst.iter_mut().zip(parts(state, dof, which)).zip(exact)
            {
                let far = found.iter().zip(exact).map(|(&a, b)| (a - b).to_f64().abs());
                *worst = far.fold(*worst, f64::max);
            }
            ControlFlow::Continue(())
        })
        .unwrap();
        errors.iter_mut().zip(worst).for_each(|(errors, worst)| errors.push(worst));
    }
    let steps: Vec<f64> = counts.iter().map(|&count| 1.0 / count as f64).collect();
    Some((errors.map(|errors| slope(&steps, &errors)), off))
}

/// Numbers of steps at which the leading term of the error dominates.
fn counts(row: &Row) -> &'static [u64] {
    match row.order() {
        0..=4 => &[128, 192, 256],
        5..=6 => &[48, 64, 96],
        7..=8 => &[48, 64, 80],
        9..=12 => &[12, 16, 20],
        13..=14 => &[12, 14, 16],
        _ => &[8, 10, 12],
    }
}

fn check<F: Formulas + Copy + 'static>(
    formulas: F,
    which: &'static [usize],
    takes: impl Fn(Needs) -> bool,
) -> usize {
    let mut tested = 0;
    // The lag of a relaxed step is one order smaller than its error. It hides the order of
    // `relaxed-verner98` at all steps that are long enough for errors above 31 digits.
    let shows = |row: &&Row| row.order() != 9;
    for row in FIXED.iter().filter(|row| takes(row.needs)).filter(shows) {
        let Some((found, off)) = orders(row, formulas, which, counts(row)) else { continue };
        for found in found {
            let off = (found - f64::from(row.order())).abs();
            assert!(off < 0.1, "{}: {found:.3}, not {}", row.name, row.order());
        }
        assert!(!row.keeps_k || off < 1e-28, "{}: K is off by {off:e}", row.name);
        tested += 1;
    }
    tested
}

#[test]
fn orders_where_both_are_driven() {
    assert_eq!(check(Pair, &[0, 1], |_| true), 23);
}

#[test]
fn orders_where_one_of_two_is_driven() {
    // The methods that move one coordinate at a time look for its motor.
    let separable = |needs| matches!(needs, Needs::Separable | Needs::SeparableOrPlanes);
    assert_eq!(check(Pair, &[1], separable), 9);
}

#[test]
fn orders_of_one_degree_of_freedom() {
    assert_eq!(check(Single, &[0], |_| true), 24);
}

/// The same particles without drag.
#[derive(Clone, Copy)]
struct Frictionless<F>(F);

impl<F: Formulas> Formulas for Frictionless<F> {
    fn dof(&self) -> usize {
        self.0.dof()
    }
    fn potential<T: Scalar>(&self, q: &[T]) -> T {
        self.0.potential(q)
    }
    fn dissipation<T: Scalar>(&self, _q: &[T], _v: &[T], _j: usize) -> T {
        T::zero()
    }
    fn mass(&self, j: usize) -> f64 {
        self.0.mass(j)
    }
    fn may_be_singular(&self) -> bool {
        false
    }
}

/// The largest deviation of a motor from the time, and the largest energy that a system without
/// friction has dissipated, over [0, 6] with every method.
fn check_frictionless<F: Formulas + Copy + 'static>(formulas: F, which: &'static [usize]) -> usize {
    let (dof, mut tested) = (formulas.dof(), 0);
    let system = Arc::new(driven::<f64, _>(Frictionless(formulas), which));
    for row in METHODS {
        let Ok(run) = bind::<f64>(row, system.clone()) else { continue };
        let numbers = |x: [f64; 2]| x[..dof].to_vec();
        let state = State::new(numbers([1.1, -0.4]), numbers([0.6, 0.9])).unwrap();
        let mut state = with_motors(&state, which.len());
        let total = state.total(&*system);
        let setting = if row.is_adaptive() {
            Setting::Tolerance(Tolerance::all(1e-8), 6.0)
        } else {
            Setting::Step(Grid::of(0.05, 120).unwrap())
        };
        run.run(setting, &mut state, 1, &mut |step, state| {
            let late = state.q[dof..].iter().map(|q| (q - state.t).abs()).fold(0.0, f64::max);
            // A relaxed step ends late by its lag, and the motor is at the time of its end.
            let most = if row.name.starts_with("relaxed") { 1e-5 } else { 1e-13 };
            assert!(late < most, "{} at step {step}: a motor is off by {late:e}", row.name);
            let motors = Motors { driven: which.to_vec(), ..Motors::default() };
            let found = accounts(state, &motors);
            let (w, s) = (found.w, found.s);
            let lost = w.iter().map(|w| w.abs()).fold(0.0, f64::max);
            let size = s.iter().map(|s| s.abs()).fold(1.0, f64::max);
            assert!(lost < 1e-13 * size, "{} at step {step}: w = {lost:e}", row.name);
            let off = (state.total(&*system) - total).abs();
            assert!(!row.keeps_k || off < 1e-12, "{}: K is off by {off:e}", row.name);
            ControlFlow::Continue(())
        })
        .unwrap_or_else(|error| panic!("{}: {error}", row.name));
        tested += 1;
    }
    tested
}

#[test]
fn motors_keep_the_time_and_nothing_is_lost_without_friction() {
    assert_eq!(check_frictionless(Single, &[0]), 30);
    assert_eq!(check_frictionless(Pair, &[0, 1]), 29);
    assert_eq!(check_frictionless(Pair, &[1]), 29);
}
