//! Invalid masses are refused before the first step, with an error that names the mass: by every
//! row of the registry, and by every method on formulas.

use crate::bind::{after, by_force, linear, nonlinear, separable};
use afterbay_core::{
    Block, Correction, Curvature, Dissipation, Formulas, FromFormulas, Grid, InputError,
    IntegrateError, Linear, Misprinted, OrderRaising, Scalar, Separable, State, System, Tolerance,
    integrate, integrate_within,
};
use afterbay_methods::moddg::ClosedForm;
use afterbay_methods::moddg::steps::Plain;
use afterbay_methods::registry::{FIXED, METHODS, Needs, Row, bind, find};
use afterbay_methods::{AdaptiveDop853, ModDg, Rk4};
use std::sync::Arc;

/// H = Σ [p_j²/(2 m_j) + q_j²/2] without friction, one mass each.
#[derive(Clone)]
struct Weights<const N: usize>([f64; N]);

impl<const N: usize> System<f64> for Weights<N> {
    fn dof(&self) -> usize {
        N
    }
    fn energy(&self, q: &[f64], p: &[f64]) -> f64 {
        (0..N).map(|j| (p[j] * p[j] / self.0[j] + q[j] * q[j]) / 2.0).sum()
    }
    fn gradient(&self, q: &[f64], p: &[f64], hq: &mut [f64], hp: &mut [f64]) {
        hq.copy_from_slice(q);
        (0..N).for_each(|j| hp[j] = p[j] / self.0[j]);
    }
    fn dissipation(&self, _q: &[f64], _p: &[f64], _v: &[f64], d: &mut [f64]) {
        d.fill(0.0);
    }
}

impl<const N: usize> Separable<f64> for Weights<N> {
    fn mass(&self, j: usize) -> f64 {
        self.0[j]
    }
    fn partial(&self, _q: &[f64], _j: usize, at: f64) -> f64 {
        at
    }
    fn dissipation_of(&self, _q: &[f64], _p: &[f64], _j: usize) -> Dissipation<f64> {
        Dissipation { value: 0.0, by_q: 0.0, by_p: 0.0 }
    }
}

impl Linear<f64> for Weights<1> {
    fn stiffness(&self, _i: usize, _j: usize) -> f64 {
        1.0
    }
    fn dissipation_rate(&self, _j: usize) -> f64 {
        0.0
    }
}

/// δ of the undamped oscillator, which is the same in both equations and has no pole.
const CORRECTION: Correction<f64> = Correction { third: 1.0 / 12.0, fourth: 0.0 };

impl OrderRaising<f64> for Weights<1> {
    fn delta_q(&self, _q: f64, _p: f64) -> Correction<f64> {
        CORRECTION
    }
    fn delta_p(&self, _q: f64, _p: f64) -> Correction<f64> {
        CORRECTION
    }
}

impl Misprinted<f64> for Weights<1> {
    fn printed_delta_q(&self, _q: f64, _p: f64) -> Correction<f64> {
        CORRECTION
    }
    fn printed_delta_p(&self, _q: f64, _p: f64) -> Correction<f64> {
        CORRECTION
    }
}

impl<const N: usize> Curvature<f64> for Weights<N> {
    fn curvature(&self, _q: &[f64], _p: &[f64], mut put: impl FnMut(Block, usize, usize, f64)) {
        for j in 0..N {
            put(Block::Hqq, j, j, 1.0);
            put(Block::Hpp, j, j, 1.0 / self.0[j]);
        }
    }
}

const NO_MASSES: [f64; 6] = [0.0, -0.0, -2.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY];

fn assert_mass<T>(row: &Row, found: Result<T, InputError>, at: usize, mass: f64) {
    let Err(error) = found else { panic!("{} takes m = {mass}", row.name) };
    let InputError::Mass { dof, value } = error else { panic!("{}: {error}", row.name) };
    assert_eq!((dof, value.to_bits()), (at, mass.to_bits()), "{}", row.name);
    assert!(
        error.to_string().starts_with(&format!("m{} = {mass:?} must be positive", at + 1)),
        "{error}"
    );
}

#[test]
fn what_is_no_mass_is_refused_with_one_degree_of_freedom() {
    for row in FIXED {
        // The others need second derivatives, which `linear` does not give.
        if !matches!(row.needs, Needs::Curvature | Needs::Linear) {
            assert!(linear::<f64, _>(row, Weights([2.0])).is_ok(), "{}", row.name);
        }
        for mass in NO_MASSES {
            assert_mass(row, linear::<f64, _>(row, Weights([mass])), 0, mass);
            if row.needs != Needs::Printed {
                let solved = nonlinear::<f64, _>(row, Weights([mass]));
                assert_mass(row, solved, 0, mass);
            }
        }
    }
}

#[test]
fn what_is_no_mass_is_refused_wherever_it_hangs() {
    let divides = |row: &&Row| matches!(row.needs, Needs::Separable | Needs::SeparableOrPlanes);
    let many: Vec<&Row> = FIXED.iter().filter(divides).collect();
    assert!(many.len() >= 6);
    for row in many {
        assert!(separable::<f64, _>(row, Weights([2.0, 1e-300, 1e300])).is_ok(), "{}", row.name);
        for (mass, at) in NO_MASSES.into_iter().zip([0, 1, 2, 0, 1, 2]) {
            let mut masses = [1.0, 2.0, 3.0];
            masses[at] = mass;
            assert_mass(row, separable::<f64, _>(row, Weights(masses)), at, mass);
        }
    }
}

#[test]
fn a_run_that_needs_a_mass_does_not_start_without_one() {
    fn run(system: &dyn Linear<f64>) -> Result<(), IntegrateError> {
        let start = State::new(vec![1.0], vec![0.5]).unwrap();
        let (method, mut state) = (ModDg { steps: Plain, solver: ClosedForm }, start.clone());
        let outcome = integrate(&method, system, Grid::of(0.1, 3).unwrap(), &mut state, &mut ());
        assert!(outcome.is_ok() || state == start);
        outcome.map(drop)
    }
    let refused = InputError::Mass { dof: 0, value: -1.0 };
    assert_eq!(run(&Weights([-1.0])), Err(IntegrateError::Input(refused.clone())));
    assert_eq!(run(&Weights([1.0])), Ok(()));
    // Methods of the registry are refused when they are bound.
    let bound = |name: &str, mass: f64| by_force::<f64, _>(find(name).unwrap(), Weights([mass]));
    for name in ["rk4", "leapfrog", "increment-2", "moddg"] {
        assert_eq!(bound(name, -1.0).err(), Some(refused.clone()), "{name}");
    }
    for name in ["rk4", "leapfrog", "increment-2", "moddg"] {
        let start = State::new(vec![1.0], vec![0.5]).unwrap();
        let end = after(&bound(name, 1.0).unwrap(), Grid::of(0.1, 3).unwrap(), &start);
        assert!(end.q != start.q && end.t > 0.25, "{name}: {end:?}");
    }
}

/// Two free particles on springs.
struct Springs(f64);

impl Formulas for Springs {
    fn dof(&self) -> usize {
        2
    }
    fn potential<T: Scalar>(&self, q: &[T]) -> T {
        (q[0] * q[0] + q[1] * q[1]).half()
    }
    fn dissipation<T: Scalar>(&self, _q: &[T], v: &[T], j: usize) -> T {
        v[j]
    }
    fn mass(&self, j: usize) -> f64 {
        [1.0, self.0][j]
    }
}

/// RK4 and DOP853 evaluate ∂H/∂p and would not notice.
#[test]
fn formulas_with_an_invalid_mass_are_not_run() {
    for mass in NO_MASSES {
        for row in METHODS {
            assert_mass(row, bind::<f64>(row, Arc::new(FromFormulas(Springs(mass)))), 1, mass);
        }
        let (system, start) = (FromFormulas(Springs(mass)), State::new([1.0; 2], [0.5; 2]));
        let mut state = start.clone().unwrap();
        let by_steps = integrate(&Rk4, &system, Grid::of(0.1, 3).unwrap(), &mut state, &mut ());
        let by_tolerance = integrate_within(
            &AdaptiveDop853,
            &system,
            &Tolerance::all(1e-6),
            1.0,
            &mut state,
            &mut (),
        );
        for refused in [by_steps.map(drop), by_tolerance.map(drop)] {
            let Err(IntegrateError::Input(InputError::Mass { dof: 1, value })) = refused else {
                panic!("m = {mass}: {refused:?}")
            };
            assert_eq!(value.to_bits(), mass.to_bits());
        }
        assert_eq!(Ok(state), start);
    }
}
