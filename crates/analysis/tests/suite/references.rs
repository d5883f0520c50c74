//! References agree with an independent computation within their doubt.

mod units;

use afterbay_analysis::progress::{Progress, Silent};
use afterbay_analysis::study::{Problem, global_order};
use afterbay_analysis::{Doubt, Model, Solution};
use afterbay_core::taylor::{Pace, Sampled, follow};
use afterbay_core::{
    Grid, InputError, IntegrateError, Quad, Scalar, Series, State, System, Tolerance,
};
use afterbay_methods::registry::{Setting, find};
use afterbay_systems::{
    Custom, CustomDrive, CustomGeneral, DAMPED_OSCILLATOR, DUFFING, Described, Description,
    DissipationText, DriveDescription, FPUT_CHAIN, GeneralDescription, VAN_DER_POL,
};
use proptest::prelude::*;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicU64, Ordering};

fn described(potential: &str, friction: DissipationText) -> Custom<f64> {
    let parts = (Vec::new(), Vec::new());
    let potential = potential.to_owned();
    let description = Description {
        potential,
        dissipation: friction,
        masses: parts.0,
        parameters: parts.1,
        ..Description::default()
    };
    Custom::new(&description).expect("a system")
}

fn custom(potential: &str, dissipation: &[&str]) -> Custom<f64> {
    let forces = dissipation.iter().map(ToString::to_string).collect();
    let friction = if dissipation.is_empty() {
        DissipationText::None
    } else {
        DissipationText::Forces(forces)
    };
    described(potential, friction)
}

fn problem(model: Model, q: &[f64], p: &[f64], end: f64) -> Problem {
    Problem { model, q: q.to_vec(), p: p.to_vec(), end }
}

fn of(system: Custom<f64>, q: &[f64], p: &[f64], end: f64) -> Problem {
    problem(Model::Custom(Described::Separable(system)), q, p, end)
}

fn known(problem: &Problem, count: usize) -> Solution<f64> {
    problem.solution(problem.end / count as f64, count, &Silent).expect("a reference")
}

/// The state at the end in 106 bits, with another order, other strides and other samples of the
/// defect.
fn otherwise<S>(system: &S, problem: &Problem) -> State<Vec<Quad>>
where
    S: System<Series<Quad, 16>>,
{
    let start: State<Vec<Quad>> = problem.start().expect("a state");
    let (mut last, pace) = (start.clone(), Pace { share: 0.6, ..Pace::FULL });
    let (defect, grid) = (Sampled(system), Grid { h: Quad::from_f64(problem.end), steps: 1 });
    follow(system, &defect, &start, grid, pace, &|| false, &mut |_, state| last = state)
        .expect("a run");
    last
}

fn lifted(system: &Custom<f64>) -> Custom<Series<Quad, 16>> {
    system.map(|x| Series::constant(Quad::from_f64(x)))
}

/// The distance of a reference from a state at the end: of q, of p and of w.
fn off(found: &Solution<f64>, exact: &State<Vec<Quad>>) -> Doubt {
    let at = found.at(found.len() - 1);
    let apart = |a: &[f64], b: &[Quad]| {
        let differences = a.iter().zip(b).map(|(&a, &b)| (Quad::from_f64(a) - b).abs().to_f64());
        differences.fold(0.0, f64::max)
    };
    let [q, p, w] =
        [(at.q, &exact.q), (at.p, &exact.p), (at.w, &exact.w)].map(|(a, b)| apart(a, b));
    Doubt { q, p, w }
}

fn is_within(off: Doubt, doubt: Doubt) -> bool {
    off.q <= doubt.q && off.p <= doubt.p && off.w <= doubt.w
}

/// The state at the end by a Runge-Kutta method of order 8, run in `legs` parts of equal length, so
/// that no step is longer than a part. References by series do not use it; their doubt shows where
/// one by such runs has taken their place.
fn by_legs(problem: &Problem, legs: u32) -> State<Vec<f64>> {
    let dop853 = find("adaptive-dop853").expect("a method");
    let run = problem.model.bind(dop853).expect("it applies");
    let (mut state, tolerance) = (problem.start().expect("a state"), Tolerance::all(1e-12));
    for leg in 1..=legs {
        let end = problem.end * f64::from(leg) / f64::from(legs);
        run.run(Setting::Tolerance(tolerance, end), &mut state, u64::MAX, &mut |_, _| {
            ControlFlow::Continue(())
        })
        .expect("a run");
    }
    state
}

/// The largest difference of two states.
fn apart(found: &Solution<f64>, other: &State<Vec<f64>>) -> f64 {
    found
        .errors(found.len() - 1, other.state_ref())
        .map(|x| x.error)
        .into_iter()
        .fold(0.0, f64::max)
}

#[test]
fn powers_that_are_left_out_are_no_end() {
    let quartic = Model::of(&DUFFING, &[0.0, 1.0, 0.0]);
    let scene = problem(quartic, &[0.0], &[1.0], 2.0);
    let rk4 = [find("rk4").expect("a method")];
    let rows = global_order::run(&scene, &rk4, &[0.1, 0.05, 0.025], &Silent).expect("orders");
    for row in &rows {
        assert!(row.error.is_some_and(|error| (0.0..1e-4).contains(&error)), "{row:?}");
        if row.variable != "w" && row.h < 0.04 {
            assert!(row.order.is_some_and(|order| (order - 4.0).abs() < 0.2), "{row:?}");
        }
    }
    for potential in ["(q1^2+q2^2)^2/4", "(q1^2+q2^2)^4", "(q1-q2)^10 + q2^10", "q1^20 + q2^26"] {
        let system = custom(potential, &[]);
        let scene = of(system.clone(), &[0.0, 0.0], &[1.0, 0.5], 2.0);
        let found = known(&scene, 1);
        let (off, doubt) = (off(&found, &otherwise(&lifted(&system), &scene)), found.doubt_at(1));
        assert!(is_within(off, doubt) && doubt.qp() < 1e-15, "{potential}: {off:?} {doubt:?}");
        let steps = by_legs(&scene, 400);
        assert!(apart(&found, &steps) < 1e-10, "{potential}: {}", apart(&found, &steps));
    }
}

#[test]
fn features_narrower_than_a_stride_are_met() {
    let scenes = [
        ("q1^2/2", "0.2*tanh(p1/0.001)", 2.0, 0.0),
        ("q1^2/2 + 0.5*exp(-(q1/0.01)^2)", "0", 1.3, 0.2),
        ("q1^2/2 + 0.02*log(1 + exp((q1-0.4)/0.005))", "0.1*p1", 1.3, 0.2),
        ("q1^2/2 + 0.1*tanh(exp(40*(q1-1)))", "0.05*p1*(1+atan(p1/0.01))", 1.3, 0.2),
    ];
    for (potential, dissipation, q, p) in scenes {
        let scene = of(custom(potential, &[dissipation]), &[q], &[p], 4.0);
        let found = known(&scene, 1);
        let off = apart(&found, &by_legs(&scene, 8000));
        println!("{potential} {dissipation}: {off:e}, doubt {:?}", found.doubt_at(1));
        assert!(
            off < 1e-7 && found.doubt_at(1).most() < 1e-14,
            "{potential} {dissipation}: {off:e}"
        );
    }
}

/// The solution in 106 bits, whose doubt stays below the rounding of `f64` for long.
fn sharp(problem: &Problem, count: usize) -> Result<Solution<Quad>, IntegrateError> {
    let start = problem.start()?;
    problem.model.solution(&start, Quad::from_f64(problem.end / count as f64), count, &Silent)
}

#[test]
fn the_start_alone_is_a_solution() {
    let scene = problem(Model::of(&VAN_DER_POL, &[1.0]), &[0.5], &[-0.25], 1.0);
    let start = scene.start().expect("a state");
    let solution = scene.model.solution(&start, 0.1, 0, &Silent).expect("a solution");
    assert_eq!((solution.len(), solution.at(0).q[0]), (1, 0.5));
}

#[test]
fn chaos_gives_a_doubt_that_grows_like_it() {
    let system = custom("q1^2/2 + q2^2/2 + q1^2*q2 - q2^3/3", &["0", "0"]);
    let scene = of(system.clone(), &[0.0, -0.25], &[0.42, 0.0], 160.0);
    let found = sharp(&scene, 8).expect("a reference");
    let (exact, last) = (otherwise(&lifted(&system), &scene), found.at(8));
    let off = (0..2).map(|j| {
        let off = [last.q[j] - exact.q[j], last.p[j] - exact.p[j]].map(|x| x.abs().to_f64());
        off[0].max(off[1])
    });
    let (off, doubt, early) =
        (off.fold(0.0, f64::max), found.doubt_at(8).qp(), found.doubt_at(1).qp());
    println!("off by {off:e}, doubt {doubt:e}, early {early:e}");
    assert!(off <= doubt && doubt < 1e-12, "{off:e} {doubt:e}");
    assert!(early < 1e-26 && doubt > 100.0 * early, "{early:e} {doubt:e}");
}

#[test]
fn near_a_saddle_the_doubt_grows_and_at_it_nothing_moves() {
    let well = |c| Model::of(&DUFFING, &[-1.0, 1.0, c]);
    let rest = known(&problem(well(0.3), &[0.0], &[0.0], 100.0), 4);
    assert_eq!(rest.doubt(), Doubt::default());
    assert_eq!((rest.at(4).q, rest.at(4).p), (&[0.0][..], &[0.0][..]));
    // The motion approaches the saddle near its stable manifold, and leaves it.
    let system = custom("-q1^2/2 + q1^4/4", &[]);
    for slip in [0.0, 1e-9, 1e-14] {
        let scene = of(system.clone(), &[0.5], &[-(0.25_f64 - 0.031_25).sqrt() + slip], 40.0);
        let found = known(&scene, 1);
        let (off, doubt) = (off(&found, &otherwise(&lifted(&system), &scene)), found.doubt_at(1));
        println!("{slip:e}: off by {off:?}, doubt {doubt:?}");
        assert!(is_within(off, doubt), "{slip:e}: {off:?} {doubt:?}");
    }
}

#[test]
fn a_stiff_chain_has_a_reference_worth_the_name() {
    let n = 20;
    let model = Model::of(&FPUT_CHAIN, &[n as f64, 1e4, 0.0]);
    let q: Vec<f64> = (0..n).map(|j| 0.3 * (j as f64 * 0.7).sin()).collect();
    let scene = problem(model, &q, &vec![0.0; n], 0.5);
    let found = known(&scene, 1);
    let system = scene.model.system::<f64>().expect("a system");
    let energy = [0, 1].map(|i| found.at(i).energy(&*system));
    assert!((energy[1] / energy[0] - 1.0).abs() < 1e-12, "{energy:?}");
    let doubt = found.doubt_at(1).qp();
    let state = by_legs(&scene, 1);
    println!("doubt {doubt:e}, apart {:e}", apart(&found, &state));
    assert!(doubt < 1e-6 && apart(&found, &state) < 1e-5, "{doubt:e} {:e}", apart(&found, &state));
}

/// Asks to stop at the n-th check.
struct After(AtomicU64, u64);

impl Progress for After {
    fn begin(&self, _stage: &str, _total: usize) {}
    fn advance(&self) {}
    fn stopped(&self) -> bool {
        self.0.fetch_add(1, Ordering::Relaxed) >= self.1
    }
}

#[test]
fn references_end_where_they_are_asked_to() {
    let chain = |n| Model::of(&FPUT_CHAIN, &[n as f64, 100.0, 0.01]);
    let kink = Model::Custom(Described::Separable(custom("sqrt(4*q1^2)", &[])));
    let scenes = [
        problem(chain(8), &[1.0; 8], &[0.0; 8], 1000.0),
        problem(chain(300), &[0.5; 300], &[0.1; 300], 1000.0),
        problem(Model::of(&VAN_DER_POL, &[1e6]), &[2.0], &[0.0], 1000.0),
        problem(kink, &[1.0], &[0.0], 1000.0),
        problem(Model::of(&DAMPED_OSCILLATOR, &[1.0, 0.1]), &[1.0], &[0.0], 1000.0),
    ];
    for scene in scenes {
        for asked in [0, 3, 40] {
            let found = scene.solution(scene.end / 100.0, 100, &After(AtomicU64::new(0), asked));
            assert_eq!(found.map(|_| ()), Err(IntegrateError::Interrupted), "{scene:?}");
        }
    }
}

/// A potential of even powers, with friction in each degree of freedom.
fn polynomial() -> impl Strategy<Value = (String, Vec<String>, Vec<f64>, Vec<f64>)> {
    let term = (prop::collection::vec(-1_i32..=1, 6), 1_u32..=6, 1_u32..=20);
    let state = prop_oneof![2 => Just(0.0), 3 => -1.0..1.0_f64];
    let rub = prop_oneof![Just(0), Just(1), Just(2)];
    (1_usize..=6).prop_flat_map(move |n| {
        let terms = prop::collection::vec(term.clone(), 1..=3);
        let rubs = prop::collection::vec((rub.clone(), 1_u32..=9), n);
        let states = prop::collection::vec(state.clone(), 2 * n);
        (terms, rubs, states, any::<bool>()).prop_map(move |(terms, rubs, states, square)| {
            let form = |weights: &[i32]| {
                let parts =
                    weights.iter().take(n).enumerate().map(|(j, a)| format!("({a})*q{}", j + 1));
                parts.collect::<Vec<_>>().join(" + ")
            };
            let mut parts: Vec<String> = terms
                .iter()
                .map(|(weights, half, c)| format!("{c}/10*(({})/2)^{}", form(weights), 2 * half))
                .collect();
            parts.push(format!("0*q{n}"));
            if square {
                parts.extend((1..=n).map(|j| format!("q{j}^2/2")));
            }
            let rub = |(j, &(kind, c)): (usize, &(i32, u32))| match kind {
                0 => "0".to_owned(),
                1 => format!("{c}/10*p{}", j + 1),
                _ => format!("{c}/20*(1 + q{}^2)*p{}", j + 1, j + 1),
            };
            let rubs = rubs.iter().enumerate().map(rub).collect();
            (parts.join(" + "), rubs, states[..n].to_vec(), states[n..].to_vec())
        })
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    #[test]
    fn polynomials_are_known_to_their_doubt(
        (potential, rubs, q, p) in polynomial(), end in 0.2..1.5_f64,
    ) {
        let system = described(&potential, DissipationText::Forces(rubs));
        let scene = of(system.clone(), &q, &p, end);
        // Scenes that take too many strides are skipped.
        let Ok(sharp) = sharp(&scene, 1) else { return Ok(()) };
        let found = sharp.rounded();
        let (off, doubt) = (off(&found, &otherwise(&lifted(&system), &scene)), found.doubt_at(1));
        let end = found.at(1);
        let size = end.q.iter().chain(end.p).fold(1.0, |most: f64, x| most.max(x.abs()));
        prop_assert!(is_within(off, doubt), "{off:?} {doubt:?}");
        prop_assert!(sharp.doubt_at(1).qp() < 1e-24 * size, "{:?}", sharp.doubt_at(1));
    }

    #[test]
    fn features_of_any_width_are_met(
        width in -3.0..-0.5_f64, place in -1.5..1.5_f64, kind in 0..4_u32, q in -2.0..2.0_f64
    ) {
        let w = 10_f64.powf(width);
        let (potential, rub) = match kind {
            0 => (format!("q1^2/2 + {w}*tanh((q1-({place}))/{w})"), "0.1*p1".to_owned()),
            1 => (format!("q1^2/2 + 0.2*exp(-((q1-({place}))/{w})^2)"), "0".to_owned()),
            2 => ("q1^2/2".to_owned(), format!("0.3*tanh((p1-({place}))/{w})")),
            _ => ("q1^2/2".to_owned(), format!("0.1*p1*(1 + 4/(1 + ((p1-({place}))/{w})^2))")),
        };
        let scene = of(custom(&potential, &[&rub]), &[q], &[0.4], 3.0);
        let found = known(&scene, 1);
        let off = apart(&found, &by_legs(&scene, 3000));
        prop_assert!(off < 3e-6, "{off:e} {potential} {rub}");
        prop_assert!(found.doubt_at(1).most() < 1e-12, "{:?}", found.doubt_at(1));
    }
}

/// Two oscillators, of which the second is pushed to and fro. All forces jump and bend at the times
/// at which the run looks for it, whichever motor they belong to.
#[test]
fn forces_of_several_motors_jump_together() {
    for forces in [["0.1", "0.05*sign(sin(t))"], ["cos(t)", "abs(sin(t))"], ["0.1*t", "mod(t, 3)"]]
    {
        let forces = forces.map(str::to_owned).to_vec();
        let description = DriveDescription { forces, ..DriveDescription::default() };
        let (drive, _) = CustomDrive::new(&description, 2).expect("a drive");
        let system = custom("q1^2/2 + q2^2/2 + (q1 - q2)^4", &["0.1*v1", "0.1*v2"]);
        let model = Model::Custom(Described::Separable(system));
        let model = Model::Driven(Box::new(model), drive);
        let found = known(&problem(model, &[1.0, 0.5], &[0.3, 1.0], 20.0), 20);
        let doubt = found.doubt();
        assert!(doubt.qp() < 1e-13 && doubt.w < 1e-13, "{doubt:?}");
    }
}

/// Series take too many strides here: a fast decay beside a slow oscillation.
#[test]
fn a_stiff_linear_system_has_its_exact_flow() {
    let problem = of(custom("q1^2/2 + q2^2/2", &["1e6*v1", "0"]), &[0.0, 1.0], &[1.0, 0.0], 100.0);
    let found = known(&problem, 2);
    let (end, doubt) = (found.at(2), found.doubt());
    assert!(
        (end.q[1] - 100.0_f64.cos()).abs() < 1e-15 && (end.p[1] + 100.0_f64.sin()).abs() < 1e-15
    );
    // H falls from ½ to nearly 0.
    assert!((end.w[0] - 0.5).abs() < 1e-11, "{}", end.w[0]);
    assert!(doubt.most() < 1e-15, "{doubt:?}");
}

/// A relativistic particle with little angular momentum falls into the centre at t = 2.87897 (DOP853
/// of scipy). The root has a kink there, at which other methods took over: they crossed the centre.
#[test]
fn a_motion_that_ends_at_a_kink_has_no_reference_beyond() {
    let described = GeneralDescription {
        hamiltonian: "sqrt(1 + p1^2 + p2^2) - 1/sqrt(q1^2 + q2^2)".to_owned(),
        dissipation: DissipationText::Forces(vec!["0.01*v1".to_owned(), "0.01*v2".to_owned()]),
        ..GeneralDescription::default()
    };
    let system = Described::General(CustomGeneral::new(&described).expect("a system"));
    let problem = problem(Model::Custom(system), &[1.0, 0.0], &[0.0, 0.9], 3.0);
    let failure = problem.solution(0.05, 60, &Silent).map(|found| found.len());
    let Err(IntegrateError::Input(InputError::SolutionEnds { t })) = failure else {
        panic!("{failure:?}")
    };
    assert!((t - 2.87897).abs() < 1e-4, "{t}");
}

/// From rest, series end at the kink of the root, and increment-8 does not take such a friction.
/// The end is that of DOP853 of scipy at rtol = 3e-14.
#[test]
fn methods_that_take_the_system_give_the_reference_where_others_do_not() {
    let friction = [1, 2].map(|j| format!("0.6*v{j}*sqrt(v1^2 + v2^2)"));
    let system = custom("-cos(q1) - cos(q2) + (q1 - q2)^2/2", &friction.each_ref().map(|d| &**d));
    let found = known(&of(system, &[-0.2, 1.4], &[0.0, 0.0], 2.0), 2);
    let end = found.at(2);
    let exact = [
        0.4651560590606,
        -0.3060179891438,
        -0.4500916695554,
        -0.2845364130767,
        0.3372753414864,
        1.2008568282483,
    ];
    let ends = end.q.iter().chain(end.p).chain(end.w);
    for (found, exact) in ends.zip(exact) {
        assert!((found - exact).abs() < 1e-10, "{found} {exact}");
    }
}
