//! Motions that have not settled are told from those that have, and from rest.

use afterbay_analysis::progress::Silent;
use afterbay_analysis::study::attractor::Kind;
use afterbay_analysis::study::bifurcation::Bifurcation;
use afterbay_analysis::study::dynamics::Dynamics;
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
/// value that ends there, the next begins at the initial state. Upwards means that m grows, also in
/// a range given from its largest value.
#[test]
fn a_branch_that_comes_to_rest_begins_afresh() {
    let text = "[system]\nname = \"custom\"\npotential = \"q1^2/2\"\n\
                dissipation = [\"(m - q1^2 + q1^4)*v1\"]\nparameters = { m = 0.05 }\n\
                [initial]\nq = [1.0]\np = [0.0]\n[time]\nend = 1.0\nstep = 0.1\n\
                [study.bifurcation]\nmethods = [\"rk4\"]\nreference = false\n\
                parameter = { name = \"m\", from = 0.05, to = 0.2, count = 16 }\n\
                follow = true\ntransient = 300\npoints = 60\n";
    let changes = "period 1 to rest at m = 0.13000 upwards, rest to 1 at m = 0.12000 downwards.";
    for text in [text, &text.replace("from = 0.05, to = 0.2", "from = 0.2, to = 0.05")] {
        let said = said(text);
        assert!(said.contains(changes), "{said}");
    }
}

/// The statement of a scene with one study.
fn said(text: &str) -> String {
    let scene = Scene::read(text).unwrap_or_else(|error| panic!("{error}"));
    let (_, findings) = study(&scene, &Silent).expect("it runs");
    findings[0].statement.clone()
}

/// A damped oscillator about q = a, in a unit of length. Near a rest at a ≠ 0 the roundings of q
/// stop the momentum, so that a section is not met any more.
#[test]
fn a_rest_is_one_wherever_it_is() {
    let oscillator = |[unit, a]: [f64; 2], start: f64, more: &str| {
        let (rest, q) = (a * unit, (a + start) * unit);
        format!(
            "[system]\nname = \"custom\"\npotential = \"(q1-a)^2/2\"\ndissipation = [\"c*v1\"]\n\
             parameters = {{ a = {rest:e}, c = 0.1 }}\n[initial]\nq = [{q:e}]\np = [0.0]\n[time]\n\
             end = 1.0\nstep = 0.05\n{more}\nmethods = [\"rk4\"]\nreference = false\n"
        )
    };
    let values =
        "[study.bifurcation]\nparameter = { name = \"c\", from = 0.1, to = 4.0, count = 3 }";
    let section = "section = { of = \"q1\", value = 0.7, direction = \"both\" }";
    let never_met = format!("[study.poincare]\n{section}");
    for view in [[1.0, 0.0], [1.0, 1.0], [1.0, -3e4], [1e-12, 2.0], [1e9, 2.0]] {
        for start in [1.0, 0.0] {
            let of = |more: &str| said(&oscillator(view, start, more));
            assert_eq!(of("[study.poincare]"), "rk4, h = 0.05000: rest.", "{view:?} {start}");
            assert_eq!(of(&never_met), "rk4, h = 0.05000: rest.", "{view:?} {start}");
            assert_eq!(of(values), "rk4, h = 0.05000: rest throughout.", "{view:?} {start}");
        }
    }
    // A motion that goes on beside its section is no rest.
    let driven = "[drive]\nforce = [\"0.01*cos(2*t)\"]\n";
    let beside = said(&oscillator([1.0, 0.0], 1.0, &format!("{driven}{never_met}")));
    assert!(beside.contains("none (no-return"), "{beside}");
}

/// D = c v³ and a quadratic friction: the motion decays like a power of t. It has no attractor yet,
/// and none to be compared with.
#[test]
fn an_algebraic_decay_is_still_settling() {
    let scene = |friction: &str, more: &str| {
        format!(
            "[system]\nname = \"custom\"\npotential = \"q1^2/2\"\ndissipation = [\"{friction}\"]\n\
             parameters = {{ c = 0.1 }}\n[initial]\nq = [1.0]\np = [0.0]\n[time]\nend = 1.0\n\
             step = 0.05\n{more}\nmethods = [\"rk4\"]\ntransient = 400\n"
        )
    };
    for friction in ["c*v1^3", "c*v1*abs(v1)"] {
        for points in [40, 100] {
            let section = said(&scene(friction, &format!("[study.poincare]\npoints = {points}")));
            assert!(section.contains("reference: still settling;"), "{friction}: {section}");
        }
    }
    let values =
        "[study.bifurcation]\nparameter = { name = \"c\", from = 0.1, to = 0.2, count = 2 }";
    let diagram = said(&scene("c*v1^3", values));
    assert!(!diagram.contains("the attractor of the reference"), "{diagram}");
    assert!(diagram.contains("rk4, h = 0.05000: period none yet throughout."), "{diagram}");
}

/// The driven pendulum near its first doubled period comes to it slowly.
#[test]
fn a_slow_approach_to_a_cycle_is_still_settling() {
    let text = include_str!("../../../../scenes/driven-pendulum.toml");
    let problem = Scene::read(text).unwrap_or_else(|error| panic!("{error}")).problem;
    let study = Bifurcation {
        problem,
        section: Section::Stroboscopic { interval: None },
        parameter: "gamma".into(),
        spacing: Spacing::Linear,
        values: vec![1.0662, 1.0664],
        transient: 400,
        points: 64,
        follow: false,
    };
    let kinds = |transient| {
        let study = Bifurcation { transient, ..study.clone() };
        let found = study.run(find("rk4").unwrap(), 0.02, &Silent).unwrap();
        found
            .columns
            .iter()
            .map(|column| column.attractor().unwrap().describe())
            .collect::<Vec<_>>()
    };
    assert_eq!(kinds(400), ["still settling"; 2]);
    assert_eq!(kinds(2000), ["period 1", "period 2"]);
}

/// Chaos with friction, a torus, and chaos without friction, at all lengths of the stretch seen.
#[test]
fn chaos_and_tori_are_not_settling() {
    let pendulum = "potential = \"-omega0^2*cos(q1)\"\ndissipation = [\"2*beta*p1\"]\n\
                    parameters = { omega0 = 9.42477796, beta = 2.35619449 }\n[drive]\n\
                    force = [\"1.105*omega0^2*cos(6.283185307179586*t)\"]";
    let holmes = "potential = \"q1^4/4 - q1^2/2\"\ndissipation = [\"0.25*v1\"]\n[drive]\n\
                  force = [\"0.4*cos(t)\"]";
    let torus = "potential = \"q1^2/2\"\ndissipation = [\"-0.2*(1-q1^2)*v1\"]\n[drive]\n\
                 force = [\"0.15*cos(1.6180339887*t)\"]";
    let henon_heiles = "potential = \"q1^2/2 + q2^2/2 + q1^2*q2 - q2^3/3\"\ndissipation = \"0\"";
    for (system, h, start, section) in [
        (pendulum, 0.02, [[-1.57, 0.0], [0.0, 0.0]], None),
        (holmes, 0.1, [[1.0, 0.0], [0.0, 0.0]], None),
        (torus, 0.1, [[1.0, 0.0], [0.0, 0.0]], None),
        (henon_heiles, 0.1, [[0.0, -0.25], [0.42081678, 0.0]], Some(Variable::Q)),
    ] {
        let dof = if section.is_some() { 2 } else { 1 };
        let [q, p] = start.map(|part| part[..dof].to_vec());
        let text = format!(
            "[system]\nname = \"custom\"\n{system}\n[initial]\nq = {q:?}\np = {p:?}\n[time]\n\
             end = 1.0\nstep = {h}\n"
        );
        let problem = Scene::read(&text).unwrap_or_else(|error| panic!("{error}")).problem;
        let crossing = |variable| {
            let direction = Direction::Rising;
            Section::Crossing(Crossing { variable, dof: 0, value: 0.0, direction })
        };
        for points in [32, 64, 200] {
            // Stretches of one motion, some from other states.
            let starts = (0..8).map(|i| {
                let mut p = p.clone();
                p[dof - 1] += 0.01 * f64::from(i);
                [q.clone(), p]
            });
            let study = Poincare {
                problem: problem.clone(),
                section: section.map_or(Section::Stroboscopic { interval: None }, crossing),
                starts: starts.collect(),
                transient: 100,
                points,
            };
            for found in study.run(find("rk4").unwrap(), h, &Silent).unwrap().attractors() {
                assert_eq!(found.unwrap().describe(), "no period", "{system} {points}");
            }
        }
    }
}

/// Without friction nothing settles, whatever the distances of some points do.
#[test]
fn a_motion_without_friction_is_never_settling() {
    let text = "[system]\nname = \"custom\"\n\
                potential = \"q1^2/2 + q2^2/2 + q1^2*q2 - q2^3/3\"\n\
                dissipation = [\"c*v1\", \"c*v2\"]\nparameters = { c = 0.0 }\n[initial]\n\
                q = [0.0, -0.25]\np = [0.42081678, 0.0]\n[time]\nend = 100\nstep = 0.05\n\
                [study.poincare]\nmethods = [\"increment-4\"]\npoints = 400\n\
                section = { of = \"q1\", value = 0.0, direction = \"rising\" }\n";
    let beside = "increment-4, h = 0.05000: no period, as the reference.";
    assert_eq!(said(text), format!("reference: no period; {beside}"));
}

/// A diagram that is followed upwards and downwards has two runs at each value.
#[test]
fn a_diagram_names_its_directions() {
    let text = "[system]\nname = \"custom\"\npotential = \"(1+h*cos(w*t))*q1^2/2 + q1^4/4\"\n\
                dissipation = [\"0.1*v1\"]\nparameters = { h = 0.5, w = 2.0 }\n[initial]\n\
                q = [0.5]\np = [0.0]\n[time]\nend = 100\nstep = 0.1\n[study.bifurcation]\n\
                methods = [\"rk4\"]\nfollow = true\n\
                parameter = { name = \"w\", from = 1.6, to = 3.2, count = 5 }\n";
    assert_eq!(
        said(text),
        "reference: rest to 2 at w = 2.0000 upwards, rest to 2 at w = 2.0000 downwards, 2 to rest \
         at w = 1.6000 downwards; rk4, h = 0.1000: the attractor of the reference in all 10 runs."
    );
}
