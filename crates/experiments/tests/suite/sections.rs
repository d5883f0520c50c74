//! Poincaré sections and bifurcation diagrams.

use afterbay_analysis::progress::Silent;
use afterbay_analysis::study::Problem;
use afterbay_analysis::study::basins::{Axis, Basins, TOO_MANY};
use afterbay_analysis::study::bifurcation::{Bifurcation, Way};
use afterbay_analysis::study::dynamics::Dynamics;
use afterbay_analysis::study::poincare::Poincare;
use afterbay_analysis::study::section::{Crossing, Direction, Section};
use afterbay_analysis::{Spacing, Variable};
use afterbay_experiments::experiment;
use afterbay_experiments::scene::Scene;
use afterbay_methods::registry::{REFERENCE, find};
use std::f64::consts::TAU;

const STROBE: Section = Section::Stroboscopic { interval: None };

pub(crate) fn problem(system: &str, drive: &str, start: [f64; 2]) -> Problem {
    let [q, p] = start;
    let text = format!(
        "[system]\n{system}\n{drive}\n[initial]\nq = [{q}]\np = [{p}]\n\
         [time]\nend = 1.0\nstep = 0.1\n"
    );
    Scene::read(&text).unwrap_or_else(|error| panic!("{error}")).problem
}

fn duffing() -> Problem {
    let system = "name = \"duffing\"\nparameters = { alpha = 0.0, beta = 1.0, c = 0.2 }";
    let drive = "[drive]\nforce = [\"f*cos(omega*t)\"]\nparameters = { f = 7.5, omega = 1.0 }";
    problem(system, drive, [2.5, 0.0])
}

/// The steady state of q'' + b q' + k q = f cos ωt at t = 0.
fn steady([k, b, f, omega]: [f64; 4]) -> [f64; 2] {
    let (re, im) = (k - omega * omega, b * omega);
    let size = re * re + im * im;
    [f * re / size, omega * f * im / size]
}

#[test]
fn steps_with_the_same_division_of_the_interval_run_once() {
    let text = "[system]\nname = \"damped-oscillator\"\nparameters = { k = 1.0, b = 0.1 }\n\
                [drive]\nforce = [\"cos(t)\"]\n\
                [initial]\nq = [1.0]\np = [0.0]\n[time]\nend = 20.0\nstep = 0.05\n\
                [study.poincare]\nmethods = [\"rk4\"]\nsteps = [0.1, 0.1001, 0.2]\n";
    let scene = Scene::read(text).unwrap();
    assert_eq!(scene.studies.poincare.unwrap().steps, [0.1, 0.2]);
}

#[test]
fn a_linear_oscillator_returns_to_its_steady_state() {
    let system = "name = \"damped-oscillator\"\nparameters = { k = 1.0, b = 0.8 }";
    let drive = "[drive]\nforce = [\"f*cos(omega*t)\"]\nparameters = { f = 2.0, omega = 1.7 }";
    let problem = problem(system, drive, [1.0, 0.0]);
    let exact = steady([1.0, 0.8, 2.0, 1.7]);
    let study = Poincare {
        problem,
        section: STROBE,
        starts: vec![[vec![1.0], vec![0.0]]],
        transient: 30,
        points: 20,
    };
    let found = study.run(&REFERENCE, 0.1, &Silent).unwrap();
    assert!(found.endings[0].is_completed());
    assert_eq!(found.rows.len(), 20);
    let period = TAU / 1.7;
    for (n, row) in found.rows.iter().enumerate() {
        assert!((row.q[0] - exact[0]).abs() < 1e-9, "{row:?}, {exact:?}");
        assert!((row.p[0] - exact[1]).abs() < 1e-9, "{row:?}, {exact:?}");
        assert!((row.t / period - (31 + n) as f64).abs() < 1e-12, "{row:?}");
    }
    // The step divides the period.
    assert!((period / found.h - (period / found.h).round()).abs() < 1e-9);
}

#[test]
fn runs_side_by_side_are_those_alone() {
    let values: Vec<f64> = (0..21).map(|i| 5.0 + 0.2 * f64::from(i)).collect();
    let study = |values: Vec<f64>| Bifurcation {
        problem: duffing(),
        section: STROBE,
        parameter: "f".into(),
        spacing: Spacing::Linear,
        values,
        transient: 3,
        points: 4,
        follow: false,
    };
    for method in ["moddg", "rk4", "leapfrog", "increment-4"] {
        let row = find(method).unwrap();
        let all = study(values.clone()).run(row, 0.1, &Silent).unwrap();
        assert_eq!(all.columns.len(), values.len());
        for (column, &value) in all.columns.iter().zip(&values) {
            let alone = study(vec![value]).run(row, 0.1, &Silent).unwrap();
            assert!(column.ending.is_completed());
            for (a, b) in column.points.iter().zip(&alone.columns[0].points) {
                let far = (a[0][0] - b[0][0]).abs() + (a[1][0] - b[1][0]).abs();
                // The last digits of sines differ in lanes, and chaos lets them grow.
                assert!(far < 1e-7, "{method}, f = {value}: {a:?} beside others, {b:?} alone");
            }
        }
    }
}

#[test]
fn a_run_that_fails_stays_in_the_diagram() {
    let study = Bifurcation {
        problem: duffing(),
        section: STROBE,
        parameter: "f".into(),
        spacing: Spacing::Linear,
        values: (0..12).map(|i| if i % 3 == 1 { 4000.0 } else { 5.0 + f64::from(i) }).collect(),
        transient: 5,
        points: 3,
        follow: false,
    };
    let found = study.run(find("rk4").unwrap(), 0.1, &Silent).unwrap();
    for (i, column) in found.columns.iter().enumerate() {
        let failed = i % 3 == 1;
        assert_eq!(column.ending.is_completed(), !failed, "{i}: {:?}", column.ending);
        assert_eq!(column.points.len(), if failed { 0 } else { 3 }, "{i}");
        if failed {
            let failure = column.ending.failure.as_deref().unwrap_or_default();
            assert!(failure.contains("step"), "{failure}");
        } else {
            let alone = Bifurcation { values: vec![column.value], ..study.clone() };
            let alone = alone.run(find("rk4").unwrap(), 0.1, &Silent).unwrap();
            let (a, b) = (&column.points[0], &alone.columns[0].points[0]);
            assert!((a[0][0] - b[0][0]).abs() < 1e-9, "{i}: {a:?}, {b:?}");
        }
    }
    let rows: Vec<_> = found.rows("f", 1).collect();
    assert_eq!(rows.len(), 8 * 3 + 4);
    assert_eq!(rows.iter().filter(|row| row.q == [None]).count(), 4);
}

#[test]
fn a_diagram_can_follow_its_attractor_both_ways() {
    // A softened resonance: two oscillations with the same drive, and hysteresis between them.
    let system = "name = \"duffing\"\nparameters = { alpha = 1.0, beta = 0.2, c = 0.1 }";
    let drive = "[drive]\nforce = [\"0.4*cos(omega*t)\"]\nparameters = { omega = 1.0 }";
    let study = Bifurcation {
        problem: problem(system, drive, [0.0, 0.0]),
        section: STROBE,
        parameter: "omega".into(),
        spacing: Spacing::Linear,
        values: (0..41).map(|i| 0.8 + 0.03 * f64::from(i)).collect(),
        transient: 150,
        points: 1,
        follow: true,
    };
    let found = study.run(find("increment-4").unwrap(), 0.1, &Silent).unwrap();
    let (up, down) = found.columns.split_at(41);
    assert!(up.iter().all(|column| column.way == Way::Up));
    assert!(down.iter().all(|column| column.way == Way::Down));
    let apart = |i: usize| {
        let [a, b] = [&up[i], &down[i]].map(|column| column.points[0].concat());
        assert_eq!(up[i].value, down[i].value);
        a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    assert!(apart(0) < 1e-6 && apart(40) < 1e-6, "{} {}", apart(0), apart(40));
    let both = (0..41).filter(|&i| apart(i) > 0.5).count();
    assert!((3..30).contains(&both), "{both} frequencies with two oscillations");
}

#[test]
fn the_largest_deflection_of_van_der_pol_is_found_to_rounding() {
    let system = "name = \"van-der-pol\"\nparameters = { mu = 1.0 }";
    let problem = problem(system, "", [2.0, 0.0]);
    let crossing =
        Crossing { variable: Variable::P, dof: 0, value: 0.0, direction: Direction::Falling };
    let study = Poincare {
        problem: problem.clone(),
        section: Section::Crossing(crossing),
        starts: vec![[vec![2.0], vec![0.0]], [vec![0.1], vec![0.0]]],
        transient: 20,
        points: 3,
    };
    let found = study.run(&REFERENCE, 0.05, &Silent).unwrap();
    assert_eq!(found.rows.len(), 6);
    for row in &found.rows {
        // The amplitude and the period are those of the literature to 12 digits.
        assert!((row.q[0] - 2.008_619_860_874_843).abs() < 1e-11, "{row:?}");
        assert!(row.p[0].abs() < 1e-14, "{row:?}");
    }
    let period = found.rows[1].t - found.rows[0].t;
    assert!((period - 6.663_286_859_323_13).abs() < 1e-11, "{period}");
    // Every method finds its own amplitude, off by its own error.
    let coarse = study.run(find("moddg").unwrap(), 0.05, &Silent).unwrap();
    let off = (coarse.rows[0].q[0] - 2.008_619_860_874_843).abs();
    assert!((1e-6..1e-2).contains(&off), "{off}");
}

/// Motion that grows all along has no attractor, so that no method can have that of the reference.
#[test]
fn motion_that_grows_has_no_attractor() {
    let linear = "name = \"damped-oscillator\"\nparameters = { k = 1.0, b = -0.1 }\n\
                  [drive]\nforce = [\"cos(2*t)\"]";
    let mathieu = "name = \"custom\"\npotential = \"(1-2*b*cos(2*t))*q1^2/2\"\n\
                   dissipation = [\"0.1*v1\"]\nparameters = { b = 0.3 }";
    let said = |system: &str, study: &str| {
        let text = format!(
            "[system]\n{system}\n[initial]\nq = [1.0]\np = [0.0]\n[time]\nend = 1.0\n\
             step = 0.1\n{study}\nmethods = [\"rk4\", \"moddg\"]\ntransient = 200\npoints = 8\n"
        );
        let scene = Scene::read(&text).unwrap_or_else(|error| panic!("{error}"));
        let (_, findings) = experiment::study(&scene, &Silent).unwrap();
        findings[0].statement.clone()
    };
    for system in [linear, mathieu] {
        let said = said(system, "[study.poincare]");
        assert_eq!(said.matches("no attractor (growing)").count(), 3, "{said}");
        assert!(!said.contains("reference,") && !said.contains("as the reference"), "{said}");
    }
    let values = |from: f64, to: f64| {
        let parameter = format!("{{ name = \"b\", from = {from:?}, to = {to:?}, count = 5 }}");
        format!("[study.bifurcation]\nparameter = {parameter}")
    };
    let all = said(linear, &values(-0.5, -0.1));
    assert_eq!(all.matches("period growing throughout").count(), 0, "{all}");
    assert_eq!(all.matches("5 runs grow and have no attractor").count(), 3, "{all}");
    assert!(!all.contains("the attractor of the reference"), "{all}");
    // Below the threshold of growth the rest attracts.
    let some = said(mathieu, &values(0.0, 0.4));
    assert!(
        some.contains("the attractor of the reference at both values where it has one"),
        "{some}"
    );
    assert_eq!(some.matches("3 runs grow and have no attractor").count(), 3, "{some}");
}

#[test]
fn a_section_that_is_never_met_is_named() {
    // Without friction the motion does not come to rest.
    let system = "name = \"damped-oscillator\"\nparameters = { k = 1.0, b = 0.0 }";
    let crossing =
        Crossing { variable: Variable::Q, dof: 0, value: 7.0, direction: Direction::Both };
    let study = Poincare {
        problem: problem(system, "", [1.0, 0.0]),
        section: Section::Crossing(crossing),
        starts: vec![[vec![1.0], vec![0.0]]],
        transient: 0,
        points: 1,
    };
    let found = study.run(find("moddg").unwrap(), 0.1, &Silent).unwrap();
    assert_eq!(found.endings[0].outcome, "no-return");
    let failure = found.endings[0].failure.as_deref().unwrap();
    assert!(failure.contains("not met within 1000000 steps after t = 0"), "{failure}");
}

fn axis(variable: Variable, count: u32) -> Axis {
    let values = (0..count).map(|i| -2.0 + 4.0 * f64::from(i) / f64::from(count - 1)).collect();
    Axis { variable, dof: 0, values }
}

#[test]
fn the_basins_of_a_double_well_are_those_of_its_stable_manifold() {
    let system = "name = \"duffing\"\nparameters = { alpha = -1.0, beta = 1.0, c = 0.25 }";
    let count = 41;
    let study = Basins {
        problem: problem(system, "", [0.0, 0.0]),
        section: Section::Stroboscopic { interval: Some(1.0) },
        axes: [axis(Variable::Q, count), axis(Variable::P, count)],
        longest: 1000,
    };
    let found = study.run(&REFERENCE, 0.05, &Silent).unwrap();
    // The two wells. The one state that lies on the saddle between them reaches neither.
    assert_eq!(found.attractors.len(), 2, "{:?}", found.attractors);
    // The stable manifold of the saddle, followed backwards in time, is the boundary: the well that
    // a state reaches is that of a fine run of another method.
    let run = study.problem.model.bind(find("increment-4").unwrap()).unwrap();
    let mut wrong = 0;
    for (i, cell) in found.cells.iter().enumerate() {
        let [q, p] = study.start(i);
        if q[0].abs() + p[0].abs() < 1e-12 {
            assert_eq!((cell.attractor, cell.ending.outcome), (None, "unstable"));
            continue;
        }
        let mut state = afterbay_core::State::new(q.clone(), p.clone()).unwrap();
        let grid = afterbay_core::Grid::<f64>::of(0.02, 5000).unwrap();
        let go_on =
            &mut |_: u64, _: afterbay_core::StateRef<'_, f64>| std::ops::ControlFlow::Continue(());
        run.run(grid, &mut state, 5000, go_on).unwrap();
        let attractor = cell.attractor.expect("every run settles");
        let well = &found.attractors[attractor].attractor.points()[0];
        if (state.q[0] - well[0]).abs().max((state.p[0] - well[1]).abs()) > 0.1 {
            wrong += 1;
        }
    }
    assert_eq!(wrong, 0);
    // The symmetry (q, p) -> (-q, -p) exchanges the wells.
    let shares = found.shares();
    let mut wells: Vec<f64> = shares.into_iter().filter(|share| *share > 0.1).collect();
    wells.sort_by(f64::total_cmp);
    assert_eq!(wells.len(), 2);
    assert!((wells[0] - wells[1]).abs() < 1e-12, "{wells:?}");
}

#[test]
fn coexisting_cycles_have_their_basins_and_their_numbers() {
    // Two oscillations under one drive: a large one and a small one.
    let system = "name = \"duffing\"\nparameters = { alpha = 1.0, beta = 0.2, c = 0.1 }";
    let drive = "[drive]\nforce = [\"0.4*cos(omega*t)\"]\nparameters = { omega = 1.35 }";
    let study = Basins {
        problem: problem(system, drive, [0.0, 0.0]),
        section: STROBE,
        axes: [axis(Variable::Q, 16), axis(Variable::P, 16)],
        longest: 400,
    };
    let exact = study.run(&REFERENCE, 0.1, &Silent).unwrap();
    assert_eq!(exact.attractors.len(), 2, "{:?}", exact.attractors);
    assert!(exact.cells.iter().all(|cell| cell.attractor.is_some()));
    let mut own = study.run(find("moddg").unwrap(), 0.1, &Silent).unwrap();
    own.renumber(&exact);
    let same = own.cells.iter().zip(&exact.cells).filter(|(a, b)| a.attractor == b.attractor);
    assert!(same.count() > 230, "of 256");
    let rows: Vec<_> = study.rows(&own).collect();
    assert_eq!(rows.len(), 256);
    assert_eq!((rows[1].q[0], rows[1].p[0]), (study.axes[0].values[1], study.axes[1].values[0]));
    assert!(rows.iter().all(|row| (1..=2).contains(&row.attractor) && row.periods < 400));
}

/// With eight steps a period the frequency of the midpoint rule, (2/h) atan(h/2), is 0.95, and the
/// amplitude at resonance 0.4 in place of 4.
#[test]
fn a_cycle_of_another_amplitude_has_a_number_of_its_own() {
    let system = "name = \"duffing\"\nparameters = { alpha = 1.0, beta = 0.0, c = 0.01 }";
    let drive = "[drive]\nforce = [\"0.04*cos(omega*t)\"]\nparameters = { omega = 1.0 }";
    let study = Basins {
        problem: problem(system, drive, [0.0, 0.0]),
        section: STROBE,
        axes: [axis(Variable::Q, 3), axis(Variable::P, 3)],
        longest: 1000,
    };
    let exact = study.run(&REFERENCE, 0.1, &Silent).unwrap();
    for (steps, number) in [(8.0, 1), (128.0, 0)] {
        let mut own = study.run(find("moddg").unwrap(), TAU / steps, &Silent).unwrap();
        own.renumber(&exact);
        for (own, exact) in own.cells.iter().zip(&exact.cells) {
            assert_eq!((exact.attractor, own.attractor), (Some(0), Some(number)), "{own:?}");
        }
    }
}

#[test]
fn a_system_without_friction_has_no_attractors_and_ends() {
    let system = "name = \"duffing\"\nparameters = { alpha = 1.0, beta = 1.0, c = 0.0 }";
    let study = Basins {
        problem: problem(system, "", [0.0, 0.0]),
        section: Section::Stroboscopic { interval: Some(1.0) },
        axes: [axis(Variable::Q, 12), axis(Variable::P, 12)],
        longest: 150,
    };
    let found = study.run(find("moddg").unwrap(), 0.1, &Silent).unwrap();
    assert_eq!(found.cells.len(), 144);
    let beyond = found.cells.iter().filter(|cell| cell.ending.outcome == TOO_MANY).count();
    assert!(beyond > 0, "every orbit is one of its own");
}

/// In one degree of freedom without a drive there is no chaos.
#[test]
fn a_kink_makes_no_chaos() {
    let system = "name = \"custom\"\npotential = \"q1^2/2 + 10*max(q1 - 1, 0)^1.5\"\n\
                  dissipation = [\"-0.1*v1 + 0.1*v1^3\"]";
    let crossing =
        Crossing { variable: Variable::Q, dof: 0, value: 0.0, direction: Direction::Rising };
    let study = Poincare {
        problem: problem(system, "", [0.0, 1.0]),
        section: Section::Crossing(crossing),
        starts: vec![[vec![0.0], vec![1.0]]],
        transient: 50,
        points: 8,
    };
    let found = study.run(&REFERENCE, 0.02, &Silent).unwrap();
    for pair in found.rows.windows(2) {
        let off = (pair[1].p[0] - pair[0].p[0]).abs();
        assert!(off < 1e-6, "{off:e}");
    }
}

/// A drive of frequency 0 is constant.
#[test]
fn a_value_at_which_the_drive_has_no_period_is_named() {
    for study in ["bifurcation", "resonance"] {
        let text = format!(
            "[system]\nname = \"duffing\"\nparameters = {{ alpha = 1.0, beta = 0.2, c = 0.1 }}\n\
             [drive]\nforce = [\"0.4*cos(omega*t)\"]\nparameters = {{ omega = 1.0 }}\n\
             [initial]\nq = [0.0]\np = [0.0]\n[time]\nend = 1.0\nstep = 0.1\n\
             [study.{study}]\nmethods = [\"rk4\"]\n\
             parameter = {{ name = \"omega\", from = -1.0, to = 1.0, count = 3 }}\n"
        );
        let error = Scene::read(&text).unwrap_err().to_string();
        assert!(error.contains("at omega = 0: the dependence on t shows no period"), "{error}");
    }
}
