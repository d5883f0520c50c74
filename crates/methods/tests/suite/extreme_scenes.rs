//! K on steps many orders of magnitude too long, and near the largest numbers: a step keeps it to
//! the rounding of its terms, or is refused.

use crate::bind::AnySeparable;
use crate::catalog::{As, Both, Built};
use crate::k_on_expressions::{Count, FRICTIONS, TERMS, bind, custom};
use afterbay_core::{Grid, IntegrateError, Mask, Quad, Scalar, State, StateRef, Tolerance};
use afterbay_methods::registry::{ADAPTIVE, FIXED, METHODS, Row, Run, Setting};
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};
use std::ops::ControlFlow;

/// The number of states of a run that are compared.
const MOST: usize = 200;
/// The largest change of K in a step, in roundings of its terms, as in the tests of ordinary steps.
const ROUNDINGS: f64 = 2700.0;
/// The same near overflow. The rounding of x^1.3 is 1.3 ln x roundings, and ln x is up to 700. The
/// steps that lost K changed it by 1e9 and more.
const LARGE_ROUNDINGS: f64 = 1e5;

/// A scene: the potential and friction, the step or the time of an adaptive run, and the state.
#[derive(Clone, Debug)]
struct Scene {
    potential: String,
    friction: &'static str,
    c: f64,
    h: f64,
    q: Vec<f64>,
    p: Vec<f64>,
}

impl Scene {
    fn system(&self) -> Built {
        custom(&self.potential, self.friction, self.q.len(), self.c)
    }

    /// The states that a method with a fixed step shows.
    fn states<T: Both>(&self, row: &Row, system: &Built) -> Vec<State<Vec<T>>> {
        let Some(run) = bind(row, system) else { return Vec::new() };
        let grid = Grid { h: T::from_f64(self.h), steps: 3 };
        self.follow(&run, &*system.separable(), grid.into(), row.name)
    }

    /// The states that a method shows within a tolerance.
    fn states_within(&self, row: &Row, relative: f64) -> Vec<State<Vec<f64>>> {
        let system = self.system();
        let run = system.bind(row, As::Curved).unwrap();
        let setting = Setting::Tolerance(Tolerance::all(relative), self.h.min(3.0));
        self.follow(&run, &*system.separable(), setting, row.name)
    }

    /// The first states of a run, as long as K is finite.
    fn follow<T: Both>(
        &self,
        run: &Run<T>,
        system: &AnySeparable<T>,
        setting: Setting<T>,
        name: &str,
    ) -> Vec<State<Vec<T>>> {
        let lift = |x: &[f64]| x.iter().map(|&x| T::from_f64(x)).collect::<Vec<_>>();
        let mut state = State::new(lift(&self.q), lift(&self.p)).unwrap();
        let mut states = Vec::new();
        let mut show = |_: u64, at: StateRef<'_, T>| {
            if states.len() == MOST || !at.total(system).is_finite().all() {
                return ControlFlow::Break(());
            }
            states.push(State { q: at.q.to_vec(), p: at.p.to_vec(), w: at.w.to_vec(), t: at.t });
            ControlFlow::Continue(())
        };
        let outcome = run.run(setting, &mut state, 1, &mut show);
        assert!(matches!(outcome, Ok(_) | Err(IntegrateError::Run(_))), "{name}: {outcome:?}");
        states
    }
}

/// Potentials that grow, beside those of the ordinary tests.
const GROWING: [&str; 6] =
    ["q1^4/4", "exp(q1)", "q1^6/6", "abs(q1 - q2)^3", "-q1^2/2", "cosh(q1/3)"];

/// Ordinary states with a step of up to 1e14.
fn long() -> impl Strategy<Value = Scene> {
    let terms = prop::collection::vec((0..TERMS.len() + GROWING.len(), 0.1..2.0_f64), 1..4);
    let numbers = (-3.0..14.0_f64, 0.0..1.0_f64, 1..3_usize, 0..FRICTIONS.len());
    let state = (prop::array::uniform2(-2.0..2.0_f64), prop::array::uniform2(-4.0..4.0_f64));
    (terms, numbers, state).prop_map(|(terms, (exponent, c, n, friction), (q, p))| {
        let wells = (1..=n).map(|j| format!("q{j}^2/20"));
        let all = || TERMS.iter().chain(&GROWING);
        let terms = terms
            .iter()
            .map(|&(i, scale)| format!("{scale:?}*{}", all().nth(i).expect("one of the terms")));
        let potential = wells.chain(terms).collect::<Vec<_>>().join(" + ");
        let potential = if n == 1 { potential.replace("q2", "0.3") } else { potential };
        let [q, p] = [q, p].map(|z| z[..n].to_vec());
        Scene { potential, friction: FRICTIONS[friction], c, h: 10f64.powf(exponent), q, p }
    })
}

/// States with H of 1e280 to 1e308, by large q, p or both, and steps of 1e-160 to 100.
fn large() -> impl Strategy<Value = Scene> {
    (long(), 280.0..308.2_f64, -160.0..2.0_f64, 0..3_usize).prop_filter_map(
        "H overflows",
        |(scene, target, exponent, kind)| {
            let (system, target) = (scene.system(), 10f64.powf(target));
            let grown = |power: f64| {
                let factor = 10f64.powf(power);
                let by = |z: &[f64], factor: f64| z.iter().map(|z| z * factor).collect::<Vec<_>>();
                let q = by(&scene.q, if kind == 1 { 1.0 } else { factor });
                let p = by(&scene.p, if kind == 2 { 1.0 } else { factor.min(1e150) });
                let energy = system.energy(&q, &p).abs();
                (q, p, energy)
            };
            let [mut low, mut high] = [0.0, 308.0];
            for _ in 0..60 {
                let middle: f64 = 0.5 * (low + high);
                if grown(middle).2 < target { low = middle } else { high = middle }
            }
            let (q, p, energy) = grown(low);
            let h = 10f64.powf(exponent);
            energy.is_finite().then(|| Scene { q, p, h, ..scene.clone() })
        },
    )
}

/// Compares K before and after each step of all methods.
fn check<T: Both>(cases: u32, scenes: impl Strategy<Value = Scene>, roundings: f64) {
    let taken = std::cell::Cell::new(0);
    TestRunner::new(Config { failure_persistence: None, ..Config::with_cases(cases) })
        .run(&scenes, |scene| {
            let system = scene.system();
            let exact = system.separable::<T>();
            for row in FIXED.iter().filter(|row| row.keeps_k) {
                let mut count = Count::default();
                count.look(&*exact, &scene.states::<T>(row, &system), |_| 0.0);
                taken.set(taken.get() + count.taken);
                prop_assert!(count.worst <= roundings * T::EPSILON, "{}: {count:?}", row.name);
            }
            Ok(())
        })
        .unwrap();
    assert!(taken.get() > cases, "{taken:?}");
}

#[test]
fn a_step_too_long_keeps_k_or_is_refused() {
    check::<f64>(70, long(), ROUNDINGS);
}

#[test]
fn a_step_too_long_keeps_k_or_is_refused_in_31_digits() {
    check::<Quad>(12, long(), ROUNDINGS);
}

#[test]
fn a_step_near_overflow_keeps_k_or_is_refused() {
    check::<f64>(100, large(), LARGE_ROUNDINGS);
}

#[test]
fn a_step_near_overflow_keeps_k_or_is_refused_in_31_digits() {
    check::<Quad>(20, large(), LARGE_ROUNDINGS);
}

#[test]
fn an_adaptive_run_near_overflow_keeps_k() {
    let taken = std::cell::Cell::new(0);
    TestRunner::new(Config { failure_persistence: None, ..Config::with_cases(60) })
        .run(&(large(), -12.0..-1.0_f64), |(scene, exponent)| {
            let system = scene.system();
            for row in ADAPTIVE.iter().filter(|row| row.keeps_k) {
                let mut count = Count::default();
                count.look(&*system, &scene.states_within(row, 10f64.powf(exponent)), |_| 0.0);
                taken.set(taken.get() + count.taken);
                let allowed = LARGE_ROUNDINGS * f64::EPSILON;
                prop_assert!(count.worst <= allowed, "{}: {count:?}", row.name);
            }
            Ok(())
        })
        .unwrap();
    assert!(taken.get() > 1000, "{taken:?}");
}

/// Steps on which K was lost without an error: the bound of the rounding of K grew with the step,
/// or was infinite.
#[test]
fn steps_that_lost_k() {
    let alone = "q1^2/20 + 0.20482725838432234*log(1 + q1^2 + 0.3^2)";
    let quartic = "q1^4/20 + 1.562236218862456*abs(q1)^1.5 + 0.6828884484217971*tanh(2*q1)*0.3";
    let wells = "q1^2/20 + 1.3624706411845844*sqrt(1 + (q1 - 0.3)^2) \
                 + 0.11032251599275256*q1^4/4 + 1.4830738972753883*(q1^2 - 1)^2";
    let wall = "q1^4/20 + 0.9250052290926503*log(1 + q1^2 + 0.3^2) + 1.0747504857338646*cosh(q1/3)";
    let fast = "q1^2/20 + 0.9793486996237014*(q1 - 0.3)^2/2 + 1.9115843033740578*abs(q1)^1.5";
    let cubic = "q1^2/20 + 0.1*abs(q1)^3 + 0.1*(1 + q1^2)^1.3";
    let (bounded, quadratic) = ("c*p/(1 + q1^2)", "c*(q1^2 - 1)*p");
    let scenes = [
        (alone, bounded, 0.2, 3.4e9, [0.2965807465686594, -1.3658376793828104]),
        (quartic, quadratic, 0.0, 4.863975392339067e13, [1.000459351871383, -2.892785033229326]),
        (wells, "c*p", 0.0, 1.0278581340940145e-43, [1.147785861811803e74, -1.854886915314175e74]),
        (wall, quadratic, 0.28598647245700104, 5.8e-24, [-1990.2989316039925, 3856.721981847394]),
        (fast, "c*abs(p)*p", 0.46, 1.0238688926880808e-113, [1.6, 1.0161473733393455e145]),
        (cubic, bounded, 0.49, 3.70150788727586e-37, [1.0296100946686981, 1.20259731627864e147]),
    ];
    for (potential, friction, c, h, [q, p]) in scenes {
        let potential = potential.to_owned();
        let scene = Scene { potential, friction, c, h, q: vec![q], p: vec![p] };
        let system = scene.system();
        for row in METHODS.iter().filter(|row| row.keeps_k) {
            let mut count = Count::default();
            if FIXED.iter().any(|fixed| fixed.name == row.name) {
                count.look(&*system, &scene.states(row, &system), |_| 0.0);
            } else {
                count.look(&*system, &scene.states_within(row, 1e-6), |_| 0.0);
            }
            assert!(count.worst <= ROUNDINGS * f64::EPSILON, "{} {count:?} {scene:?}", row.name);
        }
    }
}

/// The angles have no correct digit here, but their sine and cosine stay within 1, and the slopes
/// along an edge agree with them.
#[test]
fn k_at_angles_beyond_all_digits() {
    let potential = "q1^2/20 + q2^2/20 + 0.9*cos(q1 - q2) + 0.6/(2 + sin(q1)*cos(q2))";
    let system = custom(potential, "c*p", 2, 0.25);
    for scale in [1e12, 1e18, 1e30, 1e152] {
        let scene = Scene {
            potential: potential.to_owned(),
            friction: "c*p",
            c: 0.25,
            h: 2.25e-12,
            q: vec![-7.661358690749824 * scale, 4.790797717813381 * scale],
            p: vec![-5.87088764875693e-3 * scale, -1.479511747493908e-2 * scale],
        };
        let quad = system.separable::<Quad>();
        for row in FIXED.iter().filter(|row| row.keeps_k) {
            let mut count = Count::default();
            count.look(&*system, &scene.states(row, &system), |_| 0.0);
            assert!(count.worst <= ROUNDINGS * f64::EPSILON, "{} {count:?} {scene:?}", row.name);
            let mut count = Count::default();
            count.look(&*quad, &scene.states::<Quad>(row, &system), |_| 0.0);
            assert!(
                count.worst <= ROUNDINGS * <Quad as Scalar>::EPSILON,
                "{} {count:?} {scene:?}",
                row.name
            );
        }
    }
}
