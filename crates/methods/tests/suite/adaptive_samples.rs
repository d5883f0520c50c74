//! Samples between the steps of methods with step size control.

use crate::bind::{Curved, erased};
use crate::catalog::{As, Built, chain, duffing, pendulum};
use crate::many::{errors, exact_end, start};
use crate::slope::slope;
use afterbay_core::taylor::trajectory;
use afterbay_core::{
    Adaptive, Driven, Quad, Scalar, State, StateRef, Tolerance, sample_within, with_motors,
};
use afterbay_methods::registry::{ADAPTIVE, Setting};
use afterbay_methods::{
    AdaptiveCollocation, AdaptiveDop853, AdaptiveRadau, AdaptiveVerner87, AdaptiveVerner98,
};
use afterbay_systems::{Custom, CustomDrive, Description, DissipationText, DriveDescription};
use std::ops::ControlFlow;
use std::sync::Arc;

fn far<T: Scalar>(a: &[T], b: &[T]) -> f64 {
    a.iter().zip(b).map(|(&a, &b)| (a - b).to_f64().abs()).fold(0.0, f64::max)
}

/// Samples are as accurate as steps, conserve K, and do not change the run.
#[test]
fn samples_are_steps() {
    let system = duffing(-1.0, 1.0, 0.1);
    let start = State::new(vec![1.5], vec![0.5]).unwrap();
    let k = start.total(&*system);
    let exact = trajectory(&*system.series::<f64>(), &start, 0.07, 300).unwrap();
    let times: Vec<f64> = exact.iter().map(|state| state.t).collect();
    for row in ADAPTIVE {
        let within = system.bind(row, As::Curved).unwrap();
        for tolerance in [1e-4, 1e-8, 1e-12] {
            let (mut state, mut seen, all) = (start.clone(), 0, Tolerance::all(tolerance));
            let label = format!("{} {tolerance:e}", row.name);
            let mut look = |n: u64, at: StateRef<'_, f64>| {
                assert_eq!((n, at.t), (seen, times[seen as usize]));
                let exact = &exact[seen as usize];
                let parts = [(at.q, &exact.q), (at.p, &exact.p), (at.w, &exact.w)];
                let error = parts.map(|(found, exact)| far(found, exact));
                assert!(error.iter().all(|&error| error < 10.0 * tolerance), "{label} {}", at.t);
                assert!((at.total(&*system) - k).abs() < 1e-14, "{label} {}: K", at.t);
                seen += 1;
                ControlFlow::Continue(())
            };
            let done = within.sample(&all, &times, &mut state, &mut look, &mut || false);
            assert!(done.is_ok() && seen == times.len() as u64, "{label}: {done:?}");
            let (mut alone, setting) = (start.clone(), Setting::Tolerance(all, times[300]));
            within.run(setting, &mut alone, 1, &mut |_, _| ControlFlow::Continue(())).unwrap();
            assert_eq!(state, alone);
        }
    }
}

/// The tolerance is that of the run, in however many parts it is computed. Another start between
/// two parts, as for an event within a step, changes nothing in this.
#[test]
fn a_run_in_many_parts_is_within_its_tolerance() {
    let system = duffing(-1.0, 1.0, 0.1);
    let start = State::new(vec![1.5], vec![0.5]).unwrap();
    let exact = trajectory(&*system.series::<f64>(), &start, 0.01, 1200).unwrap();
    for row in ADAPTIVE {
        let run = system.bind(row, As::Curved).unwrap();
        for (tolerance, interrupted) in [(1e-6, false), (1e-10, false), (1e-10, true)] {
            let mut state = start.clone();
            let mut step = run.stepper(Some(Tolerance::all(tolerance)), 12.0).unwrap();
            let mut unwatched = |_: StateRef<'_, f64>| ControlFlow::Continue(());
            for n in 1..=1200 {
                if interrupted {
                    step(0.003, &mut state.clone(), &mut unwatched).unwrap();
                }
                step(0.01, &mut state, &mut unwatched).unwrap();
                state.t = 0.01 * f64::from(n);
            }
            let end = &exact[1200];
            let parts = [(&state.q, &end.q), (&state.p, &end.p), (&state.w, &end.w)];
            let error = parts.map(|(found, exact)| far(found, exact)).into_iter();
            let error = error.fold(0.0, f64::max);
            assert!(error < 5.0 * tolerance, "{} {tolerance:e} {interrupted}: {error:e}", row.name);
        }
    }
}

/// The factor by which the tolerance of w is tighter than that of q and p, so that the sweeps
/// converge and only the order is measured.
const TIGHT: f64 = 1e-3;

/// The steps to measure: their number and order, the power of h with which their error estimate
/// grows, their tolerance, and the time span of the run they belong to, multiplied by h^order. The
/// error allowed of a step is then close to its error for each h.
#[derive(Clone, Copy)]
struct Steps {
    count: u64,
    order: u32,
    grows: u32,
    tolerance: f64,
    span: f64,
    /// The largest error of a step relative to the allowed one. Explicit steps are projected only
    /// if it is below 1. Stages of collocation are solved to a share of the allowed error, which
    /// must therefore be smaller than the error.
    largest: f64,
}

/// The squared errors of q, p and w at a sample in the middle of the last of these steps.
fn sampled<M: Adaptive<Vec<Quad>, Curved<Quad>>>(
    method: &M,
    system: &Curved<Quad>,
    [start, exact]: &[State<Vec<Quad>>; 2],
    steps: Steps,
) -> [f64; 3] {
    let h = exact.t / Quad::from_f64(steps.count as f64 - 0.5);
    let all = steps.tolerance;
    let tolerance =
        Tolerance { w_relative: TIGHT * all, w_absolute: TIGHT * all, ..Tolerance::all(all) };
    let span = steps.span * h.to_f64().powi(-(steps.order as i32));
    let mut workspace = method.workspace(system, &tolerance, span).unwrap();
    let (mut state, mut before) = (start.clone(), start.clone());
    for _ in 0..steps.count {
        before.clone_from(&state);
        let attempt = method.attempt(system, h, &state, &mut workspace).unwrap();
        assert_eq!(attempt.order, steps.grows);
        assert!(attempt.error <= steps.largest, "the error of a step is {:e}", attempt.error);
        method.accept(&mut state, &mut workspace);
    }
    let mut to = state.clone();
    method.between(system, h.half(), &before, &mut workspace, &mut to).unwrap();
    let moved = (to.total(system) - before.total(system)).abs().to_f64();
    assert!(moved < 1e-29, "K by {moved:e}");
    errors(&to, exact).map(|error| error * error)
}

/// Several states, since the leading error term may vanish at one of them.
const STARTS: [[[f64; 2]; 2]; 3] =
    [[[0.6, -0.4], [0.3, 0.5]], [[0.5, -0.3], [0.2, 0.7]], [[1.0, 0.5], [0.2, -0.7]]];

/// The slopes of the errors of samples at t = 1 equal the order of the steps.
fn orders<M: Adaptive<Vec<Quad>, Curved<Quad>>>(
    name: &str,
    method: &M,
    system: &Built,
    counts: &[u64],
    steps: Steps,
) {
    let (series, system) = (system.series(), &*system.curved());
    let ends: Vec<_> = STARTS
        .map(|[q, p]| {
            let start = start([&q, &p]);
            let exact = exact_end(&*series, &start, 1.0);
            [start, exact]
        })
        .to_vec();
    let errors: Vec<[f64; 3]> = counts
        .iter()
        .map(|&count| {
            let runs =
                ends.iter().map(|ends| sampled(method, system, ends, Steps { count, ..steps }));
            runs.fold([0.0; 3], |sum, run| [0, 1, 2].map(|part| sum[part] + run[part]))
                .map(f64::sqrt)
        })
        .collect();
    let lengths: Vec<f64> = counts.iter().map(|&count| 1.0 / (count as f64 - 0.5)).collect();
    let found = [0, 1, 2].map(|part| {
        let errors: Vec<f64> = errors.iter().map(|errors| errors[part]).collect();
        slope(&lengths, &errors)
    });
    println!("{name}, order {}: {found:.3?} from errors {errors:?}", steps.order);
    for slope in found {
        assert!((slope - f64::from(steps.order)).abs() < 0.1, "{name}: {found:?}, {errors:?}");
    }
}

#[test]
fn samples_have_the_order_of_steps_in_q_p_and_w() {
    let [chain, stiffer] = &[1.0, 2.0].map(|stiffness| chain(2, stiffness, 0.25));
    let pendulum = &pendulum([1.0, 0.75], [1.0, 0.5], 1.0, [0.125, 0.25]);
    let solved =
        Steps { count: 0, order: 8, grows: 8, tolerance: 0.0, span: 0.0, largest: f64::INFINITY };
    let eight = Steps { tolerance: 1e-3, span: 0.3, ..solved };
    let sixteen = Steps { order: 16, grows: 16, tolerance: 1e-5, span: 30.0, ..solved };
    orders("chain", &AdaptiveCollocation, chain, &[12, 16, 20, 26, 32, 40, 50], eight);
    let counts = [40, 50, 64, 80, 100, 125];
    let longer = Steps { span: 6e-3, ..eight };
    orders("pendulum", &AdaptiveCollocation, pendulum, &counts, longer);
    // On a stiffer chain errors of this order stay above the rounding of 31 digits. The estimate is
    // above the allowed error, so that steps are not projected, and samples are.
    let longer = [26, 27, 28, 29, 30, 31, 32];
    orders("stiffer chain", &AdaptiveCollocation, stiffer, &longer, sixteen);
    let explicit = Steps { span: 1e-15, largest: 1.0, ..eight };
    let counts = [12, 16, 20, 26, 32, 40, 50];
    let (many, most) = ([80, 100, 125, 160, 200, 250], [160, 200, 250, 320, 400, 500]);
    orders("chain", &AdaptiveDop853, chain, &counts, explicit);
    orders("pendulum", &AdaptiveDop853, pendulum, &most, explicit);
    // The leading error terms of Verner's pairs are small. On the pendulum that of order 8 is
    // hidden by the next down to 1000 steps (slopes 8.7 to 9.1), on the chain that of order 9 by
    // others until errors are rounding.
    orders("chain", &AdaptiveVerner87, chain, &many, explicit);
    let nine = Steps { order: 9, grows: 9, span: 1e-18, ..explicit };
    orders("pendulum", &AdaptiveVerner98, pendulum, &most, nine);
}

/// An oscillator with friction and this force.
fn driven_by(force: &str) -> Arc<Curved<f64>> {
    let forces = DriveDescription { forces: vec![force.into()], ..Default::default() };
    let (drive, _) = CustomDrive::new(&forces, 1).unwrap();
    let description = Description {
        potential: "q1^2/2".into(),
        dissipation: DissipationText::Forces(vec!["v1".into()]),
        ..Default::default()
    };
    let custom = Arc::new(Custom::new(&description).unwrap());
    Arc::new(Driven::new(custom, Arc::new(drive)).unwrap())
}

/// ∂F/∂t is infinite at the start.
#[test]
fn a_force_that_begins_as_a_root_of_the_time_is_followed() {
    for force in ["sqrt(t)", "sqrt(abs(sin(2*t)))"] {
        let system = driven_by(force);
        let ends = ADAPTIVE.iter().map(|row| {
            let mut state = with_motors(&State::new(vec![1.0], vec![0.0]).unwrap(), 1);
            let (run, all) = (erased(row, system.clone()).unwrap(), Tolerance::all(1e-9));
            let mut ignore = |_: u64, _: StateRef<'_, f64>| ControlFlow::Continue(());
            run.run(Setting::Tolerance(all, 11.0), &mut state, 1, &mut ignore)
                .unwrap_or_else(|error| panic!("{}, {force}: {error}", row.name));
            [state.q[0], state.p[0]]
        });
        let ends: Vec<_> = ends.collect();
        assert!(ends.iter().all(|end| far(end, &ends[0]) < 1e-8), "{force}: {ends:?}");
    }
}

/// Each third sample of a square wave of period 0.3 lies within a rounding of a jump, and so does
/// the end.
#[test]
fn samples_within_roundings_of_jumps_are_found() {
    let system = driven_by("0.3*sign(sin(2*pi*t/0.3))");
    let times: Vec<f64> = (1..=90).map(|n| 0.1 * f64::from(n)).collect();
    let ends = ADAPTIVE.iter().map(|row| {
        let mut state = with_motors(&State::new(vec![0.06], vec![1.8]).unwrap(), 1);
        let (run, all) = (erased(row, system.clone()).unwrap(), Tolerance::all(1e-8));
        let mut last = [0.0; 2];
        let mut see = |_: u64, at: StateRef<'_, f64>| {
            last = [at.q[0], at.p[0]];
            ControlFlow::Continue(())
        };
        run.sample(&all, &times, &mut state, &mut see, &mut || false)
            .unwrap_or_else(|error| panic!("{}: {error}", row.name));
        last
    });
    let ends: Vec<_> = ends.collect();
    for end in &ends {
        assert!(far(end, &ends[0]) < 1e-7, "{ends:?}");
    }
}

/// A sample at a jump of the force lies within the step across it, of some roundings of the time.
#[test]
fn samples_at_a_jump_of_the_force_are_found() {
    fn sampled<M: Adaptive<Vec<f64>, Curved<f64>>>(method: &M) {
        let description = Description {
            potential: "q1^2/2 + q1^4/4".into(),
            dissipation: DissipationText::Forces(vec!["0.1*v1".into()]),
            ..Default::default()
        };
        let custom = Custom::new(&description).unwrap();
        let forces = vec!["(sign(t - 2) - sign(t - 2.0001))*1e4".into()];
        let forces = DriveDescription { forces, ..Default::default() };
        let (drive, _) = CustomDrive::new(&forces, 1).unwrap();
        let system: &Curved<f64> = &Driven::new(Arc::new(custom), Arc::new(drive)).unwrap();
        let mut state = with_motors(&State::new(vec![0.5], vec![0.2]).unwrap(), 1);
        let (times, before) = ([1.0, 2.0, 2.0001, 3.0], state.total(system));
        let mut seen = Vec::new();
        let mut see = |_: u64, at: &State<Vec<f64>>| {
            let total = at.total(system);
            assert!((total - before).abs() < 1e-12 * 4.0, "{}: {total}", at.t);
            seen.push((at.t, at.p[0]));
            ControlFlow::Continue(())
        };
        let tolerance = Tolerance::all(1e-10);
        sample_within(method, system, &tolerance, &times, &mut state, &mut see).unwrap();
        assert_eq!(seen.iter().map(|state| state.0).collect::<Vec<_>>(), times);
        // The pulse adds 2e4 × 1e-4 to the momentum.
        assert!((seen[2].1 - seen[1].1 - 2.0).abs() < 1e-3, "{seen:?}");
    }
    sampled(&AdaptiveDop853);
    sampled(&AdaptiveVerner87);
    sampled(&AdaptiveVerner98);
    sampled(&AdaptiveRadau);
    sampled(&AdaptiveCollocation);
}
