//! Motions that have not settled are told from those that have.

use afterbay_analysis::progress::Silent;
use afterbay_analysis::study::attractor::Kind;
use afterbay_analysis::study::bifurcation::Bifurcation;
use afterbay_analysis::study::growing::GROWING;
use afterbay_analysis::study::poincare::Poincare;
use afterbay_analysis::study::section::{Crossing, Direction, Section};
use afterbay_analysis::{Spacing, Variable};
use afterbay_experiments::experiment::study;
use afterbay_experiments::scene::Scene;
use afterbay_methods::registry::find;

/// A linear oscillator has the period of its force. What is left of a transient has none.
#[test]
fn a_transient_has_no_period_of_its_own() {
    let text = "[system]\nname = \"duffing\"\nparameters = { alpha = 1.0, beta = 0.0, c = 0.01 }\n\
                [drive]\nforce = [\"cos(om*t)\"]\nparameters = { om = 0.9 }\n\
                [initial]\nq = [1.0]\np = [0.0]\n[time]\nend = 1.0\nstep = 0.1\n";
    let problem = Scene::read(text).unwrap_or_else(|error| panic!("{error}")).problem;
    for transient in [200, 300, 350, 400, 700] {
        let study = Bifurcation {
            problem: problem.clone(),
            section: Section::Stroboscopic { interval: None },
            parameter: "om".into(),
            spacing: Spacing::Linear,
            values: (0..41).map(|i| 0.5 + f64::from(i) / 40.0).collect(),
            transient,
            points: 60,
            follow: false,
        };
        let found = study.run(find("rk4").unwrap(), 0.1, &Silent).unwrap();
        for column in found.columns {
            let attractor = column.attractor().unwrap();
            let settled = attractor.kind == Kind::Period(1);
            // e^-0.005t is left.
            let right = settled || (transient < 700 && attractor.is_settling());
            assert!(right, "{transient}, {}: {}", column.value, attractor.describe());
        }
    }
}

/// A cycle that a run has grown up to is seen, and one that it still grows up to is not.
#[test]
fn a_motion_that_has_grown_up_to_its_cycle_does_not_grow() {
    let text = "[system]\nname = \"van-der-pol\"\nparameters = { mu = 0.01 }\n[initial]\n\
                q = [0.01]\np = [0.0]\n[time]\nend = 1.0\nstep = 0.1\n";
    let problem = Scene::read(text).unwrap_or_else(|error| panic!("{error}")).problem;
    let outcome = |transient| {
        let crossing =
            Crossing { variable: Variable::P, dof: 0, value: 0.0, direction: Direction::Falling };
        let study = Poincare {
            problem: problem.clone(),
            section: Section::Crossing(crossing),
            starts: vec![[vec![0.01], vec![0.0]]],
            transient,
            points: 40,
        };
        study.run(find("rk4").unwrap(), 0.1, &Silent).unwrap().endings[0].outcome
    };
    assert_eq!([outcome(60), outcome(400)], [GROWING, "completed"]);
}

/// D = (m - q² + q⁴) v: from m = 0.125 on there is no cycle any more, and rest attracts. After a
/// value that ends there, the next begins at the initial state.
#[test]
fn a_branch_that_comes_to_rest_begins_afresh() {
    let text = "[system]\nname = \"custom\"\npotential = \"q1^2/2\"\n\
                dissipation = [\"(m - q1^2 + q1^4)*v1\"]\nparameters = { m = 0.05 }\n\
                [initial]\nq = [1.0]\np = [0.0]\n[time]\nend = 1.0\nstep = 0.1\n\
                [study.bifurcation]\nmethods = [\"rk4\"]\nreference = false\n\
                parameter = { name = \"m\", from = 0.05, to = 0.2, count = 16 }\n\
                follow = true\ntransient = 300\npoints = 60\n";
    let scene = Scene::read(text).unwrap_or_else(|error| panic!("{error}"));
    let (_, findings) = study(&scene, &Silent).expect("it runs");
    let said = &findings[0].statement;
    let changes = "period 1 to rest at m = 0.13000, 1 to rest at m = 0.13000.";
    assert!(said.contains(changes), "{said}");
}
