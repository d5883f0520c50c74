//! Studies of attractors do not depend on the units and the origin of the coordinates, and no
//! coordinate hides another one.

use afterbay_analysis::progress::Silent;
use afterbay_analysis::study::Problem;
use afterbay_analysis::study::attractor::Kind;
use afterbay_analysis::study::basins::{Axis, Basins, Known};
use afterbay_analysis::study::bifurcation::{Bifurcation, Column};
use afterbay_analysis::study::dynamics::Dynamics;
use afterbay_analysis::study::limit_cycle::{Branch, Cycle, LimitCycle};
use afterbay_analysis::study::lyapunov::Lyapunov;
use afterbay_analysis::study::poincare::Poincare;
use afterbay_analysis::study::resonance::Resonance;
use afterbay_analysis::study::section::Section;
use afterbay_analysis::{Spacing, Variable};
use afterbay_experiments::scene::Scene;
use afterbay_methods::registry::find;
use std::f64::consts::{PI, TAU};

const STROBE: Section = Section::Stroboscopic { interval: None };

/// The size s of the second coordinate, and its origin a.
const VIEWS: [[f64; 2]; 6] =
    [[1.0, 0.0], [1e-5, 0.0], [1e5, 0.0], [1.0, 1e5], [1.0, -1e5], [1e-3, 7.0]];

/// A system of a coordinate q1 of size 1 and x = (q2 - a)/s with the potential V(x) and the
/// friction D(x, x'), each under its own force.
fn problem(v: &str, d: &str, force: &str, [s, a]: [f64; 2], [x, rate]: [f64; 2]) -> Problem {
    let [v, d] = [v, d].map(|of| of.replace('x', "((q2 - a)/s)").replace('y', "(s*p2)"));
    let mass = 1.0 / (s * s);
    let drive = match force {
        "" => String::new(),
        force => format!(
            "[drive]\nforce = [\"0.3*cos(omega*t)\", \"{force}/{s:?}\"]\n\
             parameters = {{ f = 0.4, omega = 1.0 }}\n"
        ),
    };
    let text = format!(
        "[system]\nname = \"custom\"\npotential = \"2*q1^2 + {v}\"\nmass = [1.0, {mass:?}]\n\
         dissipation = [\"0.5*p1\", \"({d})/s\"]\nparameters = {{ a = {a:?}, s = {s:?} }}\n{drive}\
         [initial]\nq = [0.5, {:?}]\np = [0.0, {:?}]\n[time]\nend = 1.0\nstep = 0.1\n",
        a + s * x,
        rate / s,
    );
    Scene::read(&text).unwrap_or_else(|error| panic!("{error}\n{text}")).problem
}

/// A particle in two wells, under a force.
fn wells(force: &str, view: [f64; 2]) -> Problem {
    problem("(x^2 - 1)^2/4", "0.25*y", force, view, [1.0, 0.0])
}

#[test]
fn a_bifurcation_diagram_has_the_same_kinds_in_all_units() {
    let kinds = |view| {
        let study = Bifurcation {
            problem: wells("f*cos(omega*t)", view),
            section: STROBE,
            parameter: "f".into(),
            spacing: Spacing::Linear,
            values: vec![0.2, 0.26, 0.4],
            transient: 400,
            points: 60,
            follow: false,
        };
        let found = study.run(find("rk4").unwrap(), 0.1, &Silent).unwrap();
        let kind = |column: &Column| column.attractor().unwrap().kind;
        found.columns.iter().map(kind).collect::<Vec<_>>()
    };
    for view in VIEWS {
        assert_eq!(kinds(view), [Kind::Period(1), Kind::Period(1), Kind::Aperiodic], "{view:?}");
    }
}

#[test]
fn a_section_has_the_same_attractors_in_all_units() {
    let kinds = |force: &str, view| {
        let problem = wells(force, view);
        let starts = vec![[problem.q.clone(), problem.p.clone()]];
        let study = Poincare { problem, section: STROBE, starts, transient: 200, points: 60 };
        let found = study.run(find("rk4").unwrap(), 0.1, &Silent).unwrap();
        found.attractors()[0].as_ref().unwrap().describe()
    };
    for view in VIEWS {
        assert_eq!(kinds("f*cos(omega*t)", view), "no period", "{view:?}");
        assert_eq!(kinds("0.5*f*cos(omega*t)", view), "period 1", "{view:?}");
    }
}

#[test]
fn basins_are_the_same_in_all_units() {
    let found = |force: &str, [s, a]: [f64; 2]| {
        let values = |unit: f64, origin: f64| {
            (0..12).map(|i| origin + unit * (-2.0 + f64::from(i) * 4.0 / 11.0)).collect()
        };
        let axis = |variable, values| Axis { variable, dof: 1, values };
        let section = match force {
            "" => Section::Stroboscopic { interval: Some(1.0) },
            _ => STROBE,
        };
        let study = Basins {
            problem: wells(force, [s, a]),
            section,
            axes: [axis(Variable::Q, values(s, a)), axis(Variable::P, values(1.0 / s, 0.0))],
            longest: 400,
        };
        let map = study.run(find("rk4").unwrap(), 0.1, &Silent).unwrap();
        map.cells.iter().map(|cell| cell.attractor).collect::<Vec<_>>()
    };
    for force in ["", "0.2*f*cos(omega*t)"] {
        let exact = found(force, VIEWS[0]);
        let of = |well| exact.iter().filter(|&&reached| reached == Some(well)).count();
        assert!(of(0) > 40 && of(1) > 40 && of(0) + of(1) == 144, "{exact:?}");
        for view in VIEWS {
            assert_eq!(found(force, view), exact, "{force} {view:?}");
        }
    }
}

/// The places of attractors are printed to a thousandth of the grid, in any unit.
#[test]
fn basins_name_their_attractors_in_all_units() {
    for (s, at) in [(1.0, "1"), (1e-9, "1e-9")] {
        let values = |unit: f64| [-1.5, -0.7, 0.7, 1.5].map(|x| x * unit).to_vec();
        let axis = |variable, unit| Axis { variable, dof: 1, values: values(unit) };
        let study = Basins {
            problem: wells("", [s, 0.0]),
            section: Section::Stroboscopic { interval: Some(1.0) },
            axes: [axis(Variable::Q, s), axis(Variable::P, 0.1 / s)],
            longest: 400,
        };
        let map = study.run(find("rk4").unwrap(), 0.1, &Silent).unwrap();
        let mut said: Vec<_> = map.attractors.iter().map(Known::describe).collect();
        said.sort();
        let exact = [format!("rest, (0, -{at}, 0, 0)"), format!("rest, (0, {at}, 0, 0)")];
        assert_eq!(said, exact, "{s}");
    }
}

#[test]
fn cycles_are_the_same_in_all_units() {
    let found = |[v, d, force]: [&str; 3], view| -> Cycle {
        let problem = problem(v, d, force, view, [1.0, 0.0]);
        let study = LimitCycle { problem, transient: 300.0, multiple: None, branch: None };
        let found = study.run(find("increment-4").unwrap(), 0.1, &Silent).unwrap();
        assert!(found.ending.is_completed(), "{view:?}: {:?}", found.ending);
        found.points[0].cycle.clone()
    };
    let van_der_pol = ["x^2/2", "2*(x^2 - 1)*y", ""];
    for of in [van_der_pol, ["(x^2 - 1)^2/4", "0.25*y", "0.5*f*cos(omega*t)"]] {
        let exact = found(of, VIEWS[0]);
        for view in VIEWS.into_iter().chain([[1e-8, 0.0], [1e9, 0.0]]) {
            let cycle = found(of, view);
            assert_eq!(cycle.multiple, exact.multiple);
            assert!((cycle.period / exact.period - 1.0).abs() < 1e-9, "{view:?}: {cycle:?}");
            let both = cycle.multipliers.iter().zip(&exact.multipliers);
            let off = both.map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1])).fold(0.0, f64::max);
            assert!(off < 1e-8, "{view:?}: {cycle:?}, {exact:?}");
        }
    }
}

/// Displacements of each coordinate, and the tangent vectors, are measured in its own unit.
#[test]
fn lyapunov_exponents_are_the_same_in_all_units() {
    let found = |s: f64| {
        let problem = problem("x^4/4 + 0.3*q1*x", "0.2*y", "f*cos(omega*t)", [s, 0.0], [1.0, 0.2]);
        let study = Lyapunov { problem, transient: 2.0, time: 20.0, rows: 4 };
        let found = study.run(find("rk4").unwrap(), 0.1, &Silent).unwrap();
        found.exponents().unwrap_or_else(|| panic!("{s:e}: {}", found.ending.describe()))
    };
    let exact = found(1.0);
    for powers in [-40, -20, 20, 40] {
        let exponents = found(2.0_f64.powi(powers));
        for (a, b) in exact.iter().zip(&exponents) {
            assert!((a - b).abs() < 1e-9, "2^{powers}: {exponents:?}, {exact:?}");
        }
    }
}

#[test]
fn resonance_is_the_same_in_all_units() {
    let found = |view| {
        let study = Resonance {
            problem: wells("f*cos(omega*t)", view),
            parameter: "omega".into(),
            spacing: Spacing::Linear,
            values: vec![0.6, 1.0, 1.4],
            transient: 100,
            periods: 4,
        };
        let rows = study.run(find("rk4").unwrap(), 0.1, &Silent).unwrap();
        rows.iter().map(|row| row.outcome).collect::<Vec<_>>()
    };
    for view in VIEWS {
        let branch = ["completed", "unsteady", "unsteady"];
        assert_eq!(found(view), [branch, branch].concat(), "{view:?}");
    }
}

#[test]
fn an_interval_after_which_the_drive_does_not_repeat_is_refused() {
    let grid = |interval| {
        let section = Section::Stroboscopic { interval: Some(interval) };
        section.grid(&wells("f*cos(omega*t)", VIEWS[0]).model, 0.1)
    };
    assert!(grid(2.0 * TAU).is_ok());
    assert_eq!(
        grid(PI).unwrap_err().to_string(),
        "parameter interval = 3.141592653589793 must be a multiple of the period of the drive"
    );
}

#[test]
fn turns_of_an_angle_do_not_hide_its_period() {
    let text = "[system]\nname = \"custom\"\npotential = \"-cos(q1)\"\ndissipation = [\"0.5*p1\"]\n\
                [drive]\nforce = [\"f*cos(2*t/3)\"]\nparameters = { f = 1.45 }\n\
                [initial]\nq = [0.0]\np = [0.0]\n[time]\nend = 1.0\nstep = 0.1\n";
    let problem = Scene::read(text).unwrap_or_else(|error| panic!("{error}")).problem;
    for transient in [500.0, 50_000.0] {
        let problem = problem.clone();
        let study = LimitCycle { problem, transient, multiple: None, branch: None };
        let found = study.run(find("moddg").unwrap(), 0.1, &Silent).unwrap();
        assert!(found.ending.is_completed(), "{transient}: {:?}", found.ending);
        // It turns once in each period of the drive, and not by the same way in the next.
        let cycle = &found.points[0].cycle;
        assert!(cycle.multiple == Some(2) && cycle.is_stable(), "{transient}: {cycle:?}");
    }
}

/// The cycle of a scene of two masses.
fn cycle_of(system: &str, drive: &str, start: [f64; 2], transient: f64) -> Cycle {
    let text = format!(
        "[system]\nname = \"custom\"\n{system}\n{drive}\n[initial]\nq = {start:?}\np = [0.0, 0.0]\n\
         [time]\nend = 1.0\nstep = 0.1\n"
    );
    let problem = Scene::read(&text).unwrap_or_else(|error| panic!("{error}")).problem;
    let study = LimitCycle { problem, transient, multiple: None, branch: None };
    let found = study.run(find("rk4").unwrap(), 0.1, &Silent).unwrap();
    assert!(found.ending.is_completed(), "{system} {drive}: {:?}", found.ending);
    found.points[0].cycle.clone()
}

#[test]
fn a_coordinate_that_hardly_moves_leaves_a_cycle_isolated() {
    let weak = |v: &str| format!("{v} + 100*q2^2/2 + 1e-6*q1*q2");
    let system = |d: &str| {
        let v = weak("q1^2/2");
        format!("potential = \"{v}\"\nmass = [1.0, 1e4]\ndissipation = [\"{d}\", \"100*v2\"]")
    };
    let free = cycle_of(&system("0.2*(q1^2 - 1)*v1"), "", [1.0, 0.0], 600.0);
    assert!((free.period - 6.298_88).abs() < 1e-4 && free.is_stable(), "{free:?}");
    let drive = "[drive]\nforce = [\"cos(1.3*t)\", \"0\"]";
    let driven = cycle_of(&system("0.2*v1"), drive, [1.0, 0.0], 600.0);
    // f/|k - omega^2 + i b omega|
    let exact = f64::hypot(1.0 - 1.69, 0.26).recip();
    assert!((driven.amplitude[0] - exact).abs() < 1e-3 && driven.is_stable(), "{driven:?}");
}

#[test]
fn a_small_cycle_is_found_from_afar() {
    let system = "potential = \"(q1^2 + q2^2)/2\"\ndissipation = [\"0.2*p1\", \"0.2*p2\"]";
    let drive = "[drive]\nforce = [\"2e-8*cos(1.3*t)\", \"0\"]";
    let near = cycle_of(system, drive, [0.0, 0.0], 300.0);
    let far = cycle_of(system, drive, [1.0, 0.0], 300.0);
    assert!((far.amplitude[0] / near.amplitude[0] - 1.0).abs() < 1e-9, "{near:?} {far:?}");
}

#[test]
fn roundings_of_a_coordinate_at_rest_are_no_motion() {
    let text = "[system]\nname = \"custom\"\npotential = \"q1^2/2 + 1e6*(q2 - 1000.1)^2/2\"\n\
                dissipation = [\"0.2*p1\", \"2*p2\"]\n\
                [drive]\nforce = [\"0.001*cos(1.3*t)\", \"0\"]\n\
                [initial]\nq = [0.0, 1000.1000001]\np = [0.0, 0.0]\n\
                [time]\nend = 1.0\nstep = 0.001\n";
    let problem = Scene::read(text).unwrap_or_else(|error| panic!("{error}")).problem;
    let starts = vec![[problem.q.clone(), problem.p.clone()]];
    let study = Poincare { problem, section: STROBE, starts, transient: 40, points: 20 };
    let found = study.run(find("rk4").unwrap(), 0.001, &Silent).unwrap();
    assert_eq!(found.attractors()[0].as_ref().unwrap().kind, Kind::Period(1));
}

/// Van der Pol's cycle beside a mass that rests, at 0 and far from it.
#[test]
fn a_coordinate_that_never_moves_leaves_a_cycle_where_it_is() {
    let beside = |place: f64| {
        let system = format!(
            "potential = \"q1^2/2 + 3*(q2 - {place:?})^2\"\n\
             dissipation = [\"(q1^2 - 1)*v1\", \"0.3*v2\"]"
        );
        cycle_of(&system, "", [1.0, place], 60.0)
    };
    for place in [0.0, 1000.1] {
        let cycle = beside(place);
        assert!((cycle.period - 6.663_28).abs() < 1e-4 && cycle.is_stable(), "{place}: {cycle:?}");
    }
}

/// A branch that begins where a coordinate hardly moves, and leads to where it does.
#[test]
fn a_branch_leads_from_hardly_any_motion_to_more() {
    let text = "[system]\nname = \"custom\"\npotential = \"q1^2/2 + 2*q2^2 + c*q1*q2\"\n\
                dissipation = [\"(q1^2 - 1)*v1\", \"v2\"]\nparameters = { c = 1e-8 }\n\
                [initial]\nq = [1.0, 0.0]\np = [0.0, 0.0]\n[time]\nend = 1.0\nstep = 0.1\n";
    let problem = Scene::read(text).unwrap_or_else(|error| panic!("{error}")).problem;
    let branch = Some(Branch { parameter: "c".into(), from: 1e-8, to: 1.0, doublings: 0 });
    let study = LimitCycle { problem, transient: 60.0, multiple: None, branch };
    let found = study.run(find("rk4").unwrap(), 0.1, &Silent).unwrap();
    assert!(found.ending.is_completed(), "{:?} after {}", found.ending, found.points.len());
    let [first, last] = [found.points.first(), found.points.last()].map(|x| &x.unwrap().cycle);
    assert!(first.amplitude[1] < 1e-7 && last.amplitude[1] > 0.1, "{first:?} {last:?}");
}
