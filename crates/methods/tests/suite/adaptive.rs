//! Methods with step size control: K and passivity at every step, the registry's flags, refusals
//! and failures.

use crate::bind::{Curved, curved, erased};
use crate::catalog::{As, chain, duffing, modified_van_der_pol, pendulum, ring, van_der_pol};
use afterbay_core::{
    Block, Curvature, DissipationForm, InputError, IntegrateError, Passive, State, StateRef,
    StepControl, StepFailure, System, Tolerance, integrate_controlled,
};
use afterbay_methods::AdaptiveVerner98;
use afterbay_methods::registry::{ADAPTIVE, Row, Setting};
use proptest::prelude::*;
use std::ops::ControlFlow;
use std::sync::Arc;

/// |ΔK| of a step in unit roundoffs of its terms: H, w, and the change of H due to a rounding of z.
fn drift(system: &dyn System<f64>, before: StateRef<'_, f64>, after: StateRef<'_, f64>) -> f64 {
    let mut scale = 0.0;
    for state in [before, after] {
        let n = state.q.len();
        let (mut hq, mut hp) = (vec![0.0; n], vec![0.0; n]);
        system.gradient(state.q, state.p, &mut hq, &mut hp);
        let terms = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a * b).abs()).sum::<f64>();
        let w = state.w.iter().map(|w| w.abs()).sum::<f64>();
        scale += state.energy(system).abs() + w + terms(&hq, state.q) + terms(&hp, state.p);
    }
    let drift = (after.total(system) - before.total(system)).abs();
    if drift == 0.0 { 0.0 } else { drift / (f64::EPSILON / 2.0 * scale) }
}

/// The projection onto K leaves up to 16 roundings, and each entry of w is rounded once.
const ROUNDINGS: f64 = 20.0;

/// Observes a run of a method: the largest change of K in a step, in roundings, and whether a
/// reservoir of a passive system decreased.
fn watch(
    row: &Row,
    system: &Arc<Curved<f64>>,
    tolerance: &Tolerance,
    end: f64,
    start: &State<Vec<f64>>,
) -> Result<(f64, bool), TestCaseError> {
    let (mut state, mut last) = (start.clone(), start.clone());
    let passive = system.dissipation_form().passive;
    let (mut worst, mut taken) = (0.0_f64, false);
    let statistics = erased(row, system.clone()).unwrap().run(
        Setting::Tolerance(*tolerance, end),
        &mut state,
        1,
        &mut |_, state| {
            worst = worst.max(drift(&**system, last.state_ref(), state));
            taken |= passive.violated(&last.w, state.w);
            last =
                State { q: state.q.to_vec(), p: state.p.to_vec(), w: state.w.to_vec(), t: state.t };
            ControlFlow::Continue(())
        },
    );
    let statistics =
        statistics.map_err(|error| TestCaseError::fail(format!("{}: {error}", row.name)))?;
    prop_assert!(
        statistics.least > 0.0 && statistics.largest <= end,
        "{}: {:?}",
        row.name,
        statistics
    );
    prop_assert_eq!(state.t, end);
    Ok((worst, taken))
}

/// Checks K and Δw ≥ 0 at every step of a run by each method.
fn check_k_and_w(
    system: Arc<Curved<f64>>,
    tolerance: Tolerance,
    end: f64,
    q: Vec<f64>,
    p: Vec<f64>,
) -> Result<(), TestCaseError> {
    let start = State::new(q, p).unwrap();
    for row in ADAPTIVE {
        let (drift, taken) = watch(row, &system, &tolerance, end, &start)?;
        prop_assert!(drift < ROUNDINGS, "{}: K by {} roundings", row.name, drift);
        prop_assert!(!(row.passive && taken), "{}: energy came back", row.name);
    }
    Ok(())
}

fn tolerance() -> impl Strategy<Value = Tolerance> {
    let one = || (-12.0..-0.5_f64).prop_map(|x| 10f64.powf(x));
    [one(), one(), one(), one()].prop_map(|[relative, absolute, w_relative, w_absolute]| {
        Tolerance { relative, absolute, w_relative, w_absolute }
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]
    #[test]
    fn books_of_one_degree(
        tolerance in tolerance(), c in -0.3..2.0, alpha in -3.0..3.0, beta in 0.1..3.0,
        z in [-2.0..2.0, -2.0..2.0],
    ) {
        check_k_and_w(duffing(alpha, beta, c).curved(), tolerance, 10.0, vec![z[0]], vec![z[1]])?;
        // With μ < 0 solutions diverge.
        let cycle = modified_van_der_pol(c.abs(), alpha, beta).curved();
        check_k_and_w(cycle, tolerance, 10.0, vec![z[0]], vec![z[1]])?;
        // Starts near the equilibrium on top of the barrier, and at the equilibrium.
        let wells = duffing(-1.0, 1.0, c.abs()).curved();
        check_k_and_w(wells.clone(), tolerance, 10.0, vec![1e-5 * z[0]], vec![0.0])?;
        check_k_and_w(wells, tolerance, 10.0, vec![0.0], vec![0.0])?;
    }

    #[test]
    fn books_of_many_degrees(
        tolerance in tolerance(), c in 0.0..1.0, z in prop::array::uniform20(-1.0..1.0),
    ) {
        let chain = chain(10, 0.5, c).curved();
        check_k_and_w(chain, tolerance, 5.0, z[..10].to_vec(), z[10..].to_vec())?;
        let ring = ring(3, c, 0.5).curved();
        check_k_and_w(ring, tolerance, 5.0, z[..3].to_vec(), z[3..6].to_vec())?;
        let pendulum = pendulum([1.0, 0.8], [1.0, 0.7], 3.0, [c, 0.3]).curved();
        check_k_and_w(pendulum, tolerance, 5.0, z[..2].to_vec(), z[2..4].to_vec())?;
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(80))]

    /// Slow waves: steps are much longer than the period of the fastest mode.
    #[test]
    fn books_of_a_smooth_chain(
        tolerance in tolerance(), c in 0.0..0.1, n in 30..60_usize, a in 0.1..2.0,
    ) {
        let phase = |i: usize| std::f64::consts::PI * i as f64 / (n + 1) as f64;
        let q = (1..=n).map(|i| a * phase(i).sin()).collect();
        check_k_and_w(chain(n, 1.0, c).curved(), tolerance, 100.0, q, vec![0.0; n])?;
    }
}

/// An oscillator with friction only in a narrow interval, too small to shorten steps, in which a
/// stage with a negative weight may lie.
#[derive(Clone, Copy)]
struct Gate {
    at: f64,
}

impl System<f64> for Gate {
    fn dof(&self) -> usize {
        1
    }
    fn energy(&self, q: &[f64], p: &[f64]) -> f64 {
        (q[0] * q[0] + p[0] * p[0]) / 2.0
    }
    fn gradient(&self, q: &[f64], p: &[f64], hq: &mut [f64], hp: &mut [f64]) {
        (hq[0], hp[0]) = (q[0], p[0]);
    }
    fn dissipation(&self, q: &[f64], _p: &[f64], v: &[f64], d: &mut [f64]) {
        d[0] = if (q[0] - self.at).abs() < 0.02 { 1e-3 * v[0] } else { 0.0 };
    }
    fn dissipation_form(&self) -> DissipationForm {
        DissipationForm { passive: Passive::Each, ..DissipationForm::GENERAL }
    }
}

impl Curvature<f64> for Gate {
    fn curvature(&self, _q: &[f64], _p: &[f64], mut put: impl FnMut(Block, usize, usize, f64)) {
        put(Block::Hqq, 0, 0, 1.0);
        put(Block::Hpp, 0, 0, 1.0);
    }
}

#[test]
fn what_is_not_passive_gives_energy_back() {
    let start = State::new(vec![1.0], vec![0.0]).unwrap();
    for row in ADAPTIVE {
        let tolerance =
            Tolerance { relative: 1e-2, absolute: 1e-2, w_relative: 10.0, w_absolute: 10.0 };
        let given = (-100..100).filter(|&i| {
            let gate: Arc<Curved<f64>> = Arc::new(Gate { at: 0.01 * f64::from(i) });
            watch(row, &gate, &tolerance, 20.0, &start).unwrap().1
        });
        let given = given.count();
        assert_eq!(given > 0, !row.passive, "{}: {given}", row.name);
    }
}

/// μ = 1000, on the slow part of the cycle, where the solution only decays between two jumps.
#[test]
fn stiff_systems_hold_back_what_is_not_a_stable() {
    let system = van_der_pol(1000.0);
    for row in ADAPTIVE {
        let mut state = State::new([2.0], [0.0]).unwrap();
        let within = system.bind(row, As::Curved).unwrap();
        let done = within.run(
            Setting::Tolerance(Tolerance::all(1e-4), 50.0),
            &mut state,
            1,
            &mut |_, _| ControlFlow::Continue(()),
        );
        let accepted = done.unwrap().accepted;
        assert!(
            if row.a_stable { accepted < 200 } else { accepted > 5000 },
            "{}: {accepted}",
            row.name
        );
    }
}

/// Forces near 1 that cancel, over a long time: the tolerance of a step is at least some roundings,
/// otherwise the steps would become arbitrarily short.
#[test]
fn tolerances_at_the_reach_of_the_scalar_are_met_as_well_as_can_be() {
    let system = van_der_pol(1000.0);
    for row in ADAPTIVE {
        let mut state = State::new([2.0], [0.0]).unwrap();
        let within = system.bind(row, As::Curved).unwrap();
        let tolerance = Tolerance::all(1e-13);
        let mut steps = 0;
        let done =
            within.run(Setting::Tolerance(tolerance, 2000.0), &mut state, 1, &mut |step, state| {
                steps = step;
                if step < 20_000 && state.t < 2.0 {
                    ControlFlow::Continue(())
                } else {
                    ControlFlow::Break(())
                }
            });
        assert!(done.is_ok() && state.t >= 2.0, "{}: {done:?}, {state:?} in {steps}", row.name);
    }
}

#[test]
fn what_cannot_be_done_is_refused() {
    let system = duffing(-1.0, 1.0, 0.1);
    let start = State::new([1.5], [0.5]).unwrap();
    for row in ADAPTIVE {
        let within = system.bind(row, As::Curved).unwrap();
        let mut state = start.clone();
        let mut run = |tolerance: f64, end: f64| {
            within
                .run(
                    Setting::Tolerance(Tolerance::all(tolerance), end),
                    &mut state,
                    1,
                    &mut |_, _| ControlFlow::Continue(()),
                )
                .unwrap_err()
        };
        for tolerance in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-16] {
            let refused = run(tolerance, 1.0);
            assert!(
                matches!(refused, IntegrateError::Input(InputError::Tolerance { .. })),
                "{tolerance}"
            );
        }
        for end in [-1.0, f64::NAN, f64::INFINITY] {
            let refused = run(1e-6, end);
            assert!(
                matches!(refused, IntegrateError::Input(InputError::Backwards { .. })),
                "{end}"
            );
        }
        let descending = [1.0, 0.5];
        let look = &mut |_: u64, _: StateRef<'_, f64>| ControlFlow::Continue(());
        let refused =
            within.sample(&Tolerance::all(1e-6), &descending, &mut state, look, &mut || false);
        assert!(matches!(refused, Err(IntegrateError::Input(InputError::Backwards { .. }))));
        assert_eq!(state, start);
    }
}

/// H = p²/2 and a force that is NaN beyond q = 1. With `pole`, V = ln (1 - q), and q reaches the
/// pole in finite time.
#[derive(Clone, Copy)]
struct Cliff {
    pole: bool,
}

impl System<f64> for Cliff {
    fn dof(&self) -> usize {
        1
    }
    fn energy(&self, q: &[f64], p: &[f64]) -> f64 {
        p[0] * p[0] / 2.0 + if self.pole { (1.0 - q[0]).ln() } else { 0.0 }
    }
    fn gradient(&self, q: &[f64], p: &[f64], hq: &mut [f64], hp: &mut [f64]) {
        let beyond = if q[0] > 1.0 { f64::NAN } else { 0.0 };
        (hq[0], hp[0]) = (if self.pole { -1.0 / (1.0 - q[0]) } else { beyond }, p[0]);
    }
    fn dissipation(&self, _q: &[f64], _p: &[f64], v: &[f64], d: &mut [f64]) {
        d[0] = 0.1 * v[0];
    }
    fn dissipation_form(&self) -> DissipationForm {
        DissipationForm { passive: Passive::Each, ..DissipationForm::LINEAR }
    }
}

impl Curvature<f64> for Cliff {
    fn curvature(&self, q: &[f64], _p: &[f64], mut put: impl FnMut(Block, usize, usize, f64)) {
        put(Block::Hqq, 0, 0, if self.pole { -(1.0 - q[0]).powi(-2) } else { 0.0 });
        put(Block::Hpp, 0, 0, 1.0);
        put(Block::Dp, 0, 0, 0.1);
    }
}

#[test]
fn failures_have_names_and_the_last_good_state() {
    for (row, pole) in ADAPTIVE.iter().flat_map(|row| [(row, false), (row, true)]) {
        let mut state = State::new([0.0], [1.0]).unwrap();
        let mut last = state.clone();
        let outcome = curved(row, Cliff { pole }).unwrap().run(
            Setting::Tolerance(Tolerance::all(1e-6), 10.0),
            &mut state,
            1,
            &mut |_, state| {
                last = State { q: [state.q[0]], p: [state.p[0]], w: [state.w[0]], t: state.t };
                ControlFlow::Continue(())
            },
        );
        println!("{}: {outcome:?} {state:?}", row.name);
        let Err(IntegrateError::Run(error)) = outcome else { panic!("{outcome:?}") };
        let named = matches!(
            error.failure,
            StepFailure::Vanishes { .. }
                | StepFailure::NonFinite { .. }
                | StepFailure::NotContracting { .. }
        );
        assert!(named, "{}: {error}", row.name);
        assert_eq!((state.clone(), error.t), (last, state.t));
        assert!(state.q[0] > 0.99 && state.q[0] <= 1.0, "{}: {state:?}", row.name);
    }
}

/// The lengths of the steps of a run with these options, and its end.
fn lengths(control: StepControl) -> (Vec<f64>, Result<(), IntegrateError>) {
    let system = &*duffing(-1.0, 1.0, 0.1).curved();
    let mut state = State::new(vec![1.5], vec![0.5]).unwrap();
    let (mut lengths, mut last) = (Vec::new(), 0.0);
    let mut look = |n: u64, state: &State<Vec<f64>>| {
        if n > 0 {
            lengths.push(state.t - last);
        }
        last = state.t;
        ControlFlow::Continue(())
    };
    let tolerance = Tolerance::all(1e-8);
    let method = AdaptiveVerner98;
    let done =
        integrate_controlled(&method, system, &tolerance, control, 20.0, &mut state, &mut look);
    (lengths, done.map(|_| ()))
}

#[test]
fn steps_stay_within_the_options_of_their_control() {
    const ROUNDED: f64 = 1.0 + 1e-12;
    let plain = StepControl::default();
    let (free, done) = lengths(plain);
    done.unwrap();
    let longest = free.iter().copied().fold(0.0, f64::max);
    let (short, done) =
        lengths(StepControl { initial: Some(0.01), largest: 0.5 * longest, ..plain });
    done.unwrap();
    assert!((short[0] - 0.01).abs() < 1e-12, "{short:?}");
    assert!(short.iter().all(|&h| h <= 0.5 * longest * ROUNDED), "{short:?}");
    let (slow, done) = lengths(StepControl { initial: Some(1e-3), largest_growth: 1.25, ..plain });
    done.unwrap();
    assert!(slow.windows(2).all(|pair| pair[1] <= 1.25 * pair[0] * (1.0 + 1e-9)), "{slow:?}");
    let aims = |target_error| lengths(StepControl { target_error, ..plain }).0.len();
    let [bold, shy] = [0.8, 0.02].map(aims);
    assert!(bold < free.len() && free.len() < shy, "{bold} {} {shy}", free.len());
    let (_, done) = lengths(StepControl { least: 2.0 * longest, ..plain });
    let Err(IntegrateError::Run(error)) = done else { panic!("{done:?}") };
    assert!(matches!(error.failure, StepFailure::Vanishes { .. }), "{error}");
}
