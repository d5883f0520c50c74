//! Branches of limit cycles in a parameter: their bifurcations, and where they end.

use super::*;

/// A branch with the period as an unknown ends at a cycle that is known.
#[test]
fn a_branch_leads_from_one_cycle_to_another() {
    let study = branch(study(van_der_pol(0.5), 60.0), "mu", [0.5, 2.0], 0);
    let found = study.run(&REFERENCE, 0.1, &Silent).unwrap();
    assert!(found.ending.is_completed() && found.points.len() > 10, "{:?}", found.ending);
    assert!(found.points.iter().all(|point| point.event.is_none()));
    let (last, exact) = (&found.points.last().unwrap().cycle, VAN_DER_POL[2].1);
    assert_eq!(last.value, Some(2.0));
    close("period", last.period, exact[0], 1e-8);
    close("amplitude", last.amplitude[0], exact[1], 1e-8);
}

/// The cycles of q'' - (μ - q²) q' + q = 0 begin at the Hopf bifurcation μ = 0.
#[test]
fn a_branch_ends_where_its_cycles_shrink_to_rest() {
    let system = "name = \"custom\"\npotential = \"q1^2/2\"\ndissipation = [\"-(mu - q1^2)*p1\"]\n\
                  parameters = { mu = 0.5 }";
    let study = branch(study(problem(system, "", [1.0, 0.0]), 60.0), "mu", [0.5, -0.3], 0);
    for (row, shift) in [(&REFERENCE, 1e-8), (row("rk4"), 1e-4)] {
        let found = study.run(row, 0.3, &Silent).unwrap();
        assert_eq!(found.ending.outcome, "shrinks-to-rest", "{:?}", found.ending);
        assert!(found.points.iter().all(|point| point.event.is_none()), "{}", row.name);
        let last = &found.points.last().unwrap().cycle;
        close("μ", last.value.unwrap(), 0.0, shift);
        assert!(last.amplitude[0] < 2e-5, "{}", last.amplitude[0]);
    }
}

/// The rotations of a pendulum with a torque g approach the homoclinic orbit of its saddle. There
/// g = 0.373474, by bisection: a run of RK4 with steps of 0.002 along the unstable manifold just
/// misses the next saddle, or passes it.
#[test]
fn a_branch_ends_where_its_period_grows_without_bound() {
    let system = "name = \"custom\"\npotential = \"1 - cos(q1) - g*q1\"\n\
                  dissipation = [\"0.3*v1\"]\nparameters = { g = 0.45 }";
    let study = branch(study(problem(system, "", [0.0, 3.0]), 60.0), "g", [0.45, 0.3], 0);
    let found = study.run(row("rk4"), 0.05, &Silent).unwrap();
    assert_eq!(found.ending.outcome, "period-grows", "{:?}", found.ending);
    let periods: Vec<f64> = found.points.iter().map(|point| point.cycle.period).collect();
    assert!(periods.windows(2).all(|pair| pair[1] > pair[0]), "{periods:?}");
    let above = found.points.last().unwrap().cycle.value.unwrap() - 0.373_474;
    assert!((0.0..1e-3).contains(&above), "{above}");
}

/// A force that vanishes leaves cycles as small as it is, and no bifurcation.
#[test]
fn a_branch_goes_on_where_its_cycles_shrink_with_a_force() {
    let drive = "[drive]\nforce = [\"f*cos(1.3*t)\"]\nparameters = { f = 1.0 }";
    let study = branch(study(oscillator(0.3, drive), 100.0), "f", [1.0, 1e-7], 0);
    let found = study.run(&REFERENCE, 0.1, &Silent).unwrap();
    assert!(found.ending.is_completed(), "{:?}", found.ending);
    let exact = 1e-7 / f64::hypot(1.0 - 1.69, 0.39);
    close("amplitude", found.points.last().unwrap().cycle.amplitude[0], exact, 1e-12);
}

/// With D = ε (c - q² + q⁴) p the amplitude satisfies c - A²/4 + A⁴/8 = 0 as ε → 0: two cycles meet
/// at c = 1/8, A = 1.
#[test]
fn a_branch_goes_round_a_fold() {
    let system = "name = \"custom\"\npotential = \"q1^2/2\"\n\
                  dissipation = [\"e*(c - q1^2 + q1^4)*p1\"]\nparameters = { e = 0.05, c = 0.0 }";
    let study = branch(study(problem(system, "", [1.4, 0.0]), 400.0), "c", [0.05, 0.15], 0);
    let found = study.run(row("increment-4"), 0.2, &Silent).unwrap();
    assert!(found.ending.is_completed(), "{:?}", found.ending);
    let folds: Vec<_> = found.events(Event::Fold).collect();
    assert_eq!(folds.len(), 1);
    close("c", folds[0].value.unwrap(), 0.125, 1e-3);
    close("amplitude", folds[0].amplitude[0], 1.0, 1e-2);
    close("multiplier", folds[0].nontrivial()[0][0], 1.0, 1e-8);
    let [first, last] = [found.points.first(), found.points.last()].map(|x| &x.unwrap().cycle);
    assert_eq!([first.value, last.value], [Some(0.05); 2]);
    assert!(first.is_stable() && !last.is_stable());
    for (cycle, sign) in [(first, 1.0), (last, -1.0)] {
        let square = 1.0 + sign * (1.0 - 8.0 * 0.05_f64).sqrt();
        close("amplitude", cycle.amplitude[0], square.sqrt(), 1e-2);
    }
}

/// A drive far from resonance gives Van der Pol's oscillator the amplitude A = f/|1 - ω²|, and as
/// μ → 0 its own oscillation is quenched if A² > 2. Below, a torus branches off.
#[test]
fn a_torus_branches_off_where_a_drive_quenches_no_more() {
    let drive = "[drive]\nforce = [\"f*cos(omega*t)\"]\nparameters = { f = 5.0, omega = 2.3 }";
    let system = "name = \"van-der-pol\"\nparameters = { mu = 0.1 }";
    let problem = problem(system, drive, [0.1, 0.0]);
    let study = branch(study(problem, 400.0), "f", [8.0, 4.0], 0);
    let found = study.run(row("increment-4"), 0.1, &Silent).unwrap();
    assert!(found.ending.is_completed(), "{:?}", found.ending);
    let events: Vec<_> = found.points.iter().filter_map(|point| point.event).collect();
    assert_eq!(events, [Event::NeimarkSacker]);
    let torus = found.events(Event::NeimarkSacker).next().unwrap();
    let exact = 2.0_f64.sqrt() * (2.3 * 2.3 - 1.0);
    close("f", torus.value.unwrap(), exact, 0.01 * exact);
    let [re, im] = torus.multipliers[0];
    close("|μ|", re.hypot(im), 1.0, 1e-9);
}

/// The cycles in one well of Holmes's oscillator: two folds, and then period doublings whose
/// distances fall by Feigenbaum's δ = 4.669. They are those of modDG at this step.
#[test]
fn a_cascade_of_period_doublings_has_feigenbaums_ratio() {
    let holmes = duffing([-1.0, 1.0, 0.25, 0.1, 1.0], [1.0, 0.0]);
    let study = branch(study(holmes, 400.0), "f", [0.1, 0.4], 5);
    let found = study.run(row("moddg"), 0.2, &Silent).unwrap();
    assert!(found.ending.is_completed(), "{:?}", found.ending);
    for fold in found.events(Event::Fold) {
        close("multiplier", fold.multipliers[0][0], 1.0, 1e-8);
    }
    assert_eq!(found.events(Event::Fold).count(), 2);
    let doublings: Vec<_> = found.events(Event::PeriodDoubling).collect();
    let multiples: Vec<_> = doublings.iter().map(|cycle| cycle.multiple.unwrap()).collect();
    assert_eq!(multiples, [1, 2, 4, 8, 16]);
    for cycle in &doublings {
        close("multiplier", cycle.multipliers[0][0], -1.0, 1e-8);
    }
    let values: Vec<_> = doublings.iter().map(|cycle| cycle.value.unwrap()).collect();
    let between: Vec<_> = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let ratios: Vec<_> = between.windows(2).map(|pair| pair[0] / pair[1]).collect();
    println!("{values:?} {ratios:?}");
    for ratio in &ratios {
        close("ratio", *ratio, 4.669_201_609, 0.05 * 4.669);
    }
}

/// A symmetric cycle of a hardening spring loses its symmetry.
#[test]
fn a_cycle_that_loses_its_symmetry_is_a_branching() {
    let study =
        branch(study(duffing([0.0, 1.0, 0.2, 1.0, 1.0], [1.0, 0.0]), 400.0), "f", [1.0, 4.0], 0);
    let found = study.run(row("moddg"), 0.2, &Silent).unwrap();
    let events: Vec<_> = found.points.iter().filter_map(|point| point.event).collect();
    assert_eq!(events, [Event::Branching], "{:?}", found.ending);
    let cycle = found.events(Event::Branching).next().unwrap();
    close("multiplier", cycle.multipliers[0][0], 1.0, 1e-6);
}

/// Two branches cross where a symmetry is lost, and Newton's method may go over to the other one.
/// The values are those at which the map over half a period, with the sign of (q, p) reversed, has
/// the multiplier -1, by DOP853 of scipy at a relative tolerance of 1e-13.
#[test]
fn the_loss_of_a_symmetry_is_located() {
    let pendulum =
        |c: f64| format!("name = \"custom\"\npotential = \"-cos(q1)\"\ndissipation = [\"{c}*v1\"]");
    let drive =
        |force: &str, f: f64| format!("[drive]\nforce = [\"{force}\"]\nparameters = {{ f = {f} }}");
    for (c, force, range, exact) in [
        (0.1, "-f*cos(2*t)*sin(q1)", [1.0, 1.3], 1.258_943_006_0),
        (0.3, "f*cos(0.7*t)", [0.7, 0.8], 0.757_312_650_1),
    ] {
        let problem = problem(&pendulum(c), &drive(force, range[0]), [0.5, 0.0]);
        let study = branch(study(problem, 400.0), "f", range, 0);
        for (row, close_to) in [(&REFERENCE, 2e-9), (row("rk4"), 1e-6)] {
            let found = study.run(row, 0.05, &Silent).unwrap();
            let events: Vec<_> = found.events(Event::Branching).collect();
            assert_eq!(events.len(), 1, "{}: {:?}", row.name, found.ending);
            close("f", events[0].value.unwrap(), exact, close_to);
            let off = |[re, im]: &[f64; 2]| (re - 1.0).hypot(*im);
            let nearest = events[0].nontrivial().iter().map(off).fold(f64::INFINITY, f64::min);
            assert!(nearest < 1e-7, "{}: {nearest:e}", row.name);
        }
    }
}

/// Two equal hardening oscillators, one of them driven: motions that whirl end at a motion in one
/// plane, which another branch passes. The branch goes over to the mirror image there, and the
/// whirl does not dissolve in roundings.
#[test]
fn a_branch_meets_a_pitchfork_once() {
    let text = "[system]\nname = \"custom\"\ndissipation = \"0.1*v[i]\"\n\
                potential = \"(q1^2+q2^2)/2 + (q1^2+q2^2)^2/4\"\n[drive]\n\
                force = [\"0.3*cos(w*t)\", \"0\"]\nparameters = { w = 1.38 }\n[initial]\n\
                q = [0.277, 1.0]\np = [1.5, 0.0]\n[time]\nend = 1.0\nstep = 0.2\n";
    let problem = Scene::read(text).unwrap_or_else(|error| panic!("{error}")).problem;
    let study = branch(study(problem, 200.0), "w", [1.38, 1.9], 0);
    let found = study.run(row("rk4"), 0.2, &Silent).unwrap();
    assert!(found.ending.is_completed(), "{:?}", found.ending);
    let events = found.points.iter().filter_map(|point| Some((point.event?, &point.cycle)));
    let near = |cycle: &Cycle| (cycle.value.unwrap() - 1.7665).abs() < 1e-3;
    let events: Vec<_> = events.filter(|(_, cycle)| near(cycle)).collect();
    assert_eq!(events.len(), 1, "{events:?}");
    assert_eq!(events[0].0, Event::Branching);
    assert!(events[0].1.amplitude[1] < 1e-4 * events[0].1.amplitude[0], "{events:?}");
}

/// The bifurcations of n equal oscillators under one force, in this range of its amplitude.
fn of_equal_parts(n: usize, well: f64, omega: f64, range: [f64; 2]) -> Vec<(Event, f64)> {
    let text = format!(
        "[system]\nname = \"custom\"\n\
         potential = \"sum(j, 1, n, q[j]^4/4 + ({well:?})*q[j]^2/2)\"\ndissipation = {:?}\n[drive]\nforce = {:?}\nparameters = {{ f = {:?} }}\n[initial]\n\
         q = {:?}\np = {:?}\n[time]\nend = 1.0\nstep = 0.1\n",
        (1..=n).map(|j| format!("0.3*v{j}")).collect::<Vec<_>>(),
        vec![format!("f*cos({omega:?}*t)"); n],
        range[0],
        vec![1.0; n],
        vec![0.0; n]
    );
    let problem = Scene::read(&text).unwrap_or_else(|error| panic!("{error}")).problem;
    let found = branch(study(problem, 300.0), "f", range, 0).run(row("rk4"), 0.1, &Silent).unwrap();
    assert!(found.ending.is_completed(), "{:?}", found.ending);
    let events = found.points.iter().filter_map(|point| Some((point.event?, point.cycle.value?)));
    events.collect()
}

/// Equal parts have their bifurcations at once: the test functions, which are products over all
/// multipliers, may keep their signs.
#[test]
fn bifurcations_of_equal_parts_are_those_of_one() {
    let doubling = |n| of_equal_parts(n, -1.0, 1.2, [0.2, 0.28]);
    let folds = |n| of_equal_parts(n, 1.0, 2.2, [0.5, 4.5]);
    assert_eq!(doubling(1).len(), 1);
    assert_eq!(folds(1).iter().map(|found| found.0).collect::<Vec<_>>(), [Event::Fold; 2]);
    for of in [&doubling as &dyn Fn(usize) -> Vec<(Event, f64)>, &folds] {
        let one = of(1);
        for n in [2, 3] {
            let all = of(n);
            assert_eq!(all.len(), one.len(), "{n}: {all:?}, {one:?}");
            for ((event, value), (exact, there)) in all.iter().zip(&one) {
                assert_eq!(event, exact, "{n}: {all:?}, {one:?}");
                close("f", *value, *there, 1e-6);
            }
        }
    }
}

/// As printed by `data/ring.py`.
const RING: f64 = 0.130_273_177_892_5;

/// Van der Pol's oscillators in a ring leave their common motion at once, in the two modes of each
/// wave number.
#[test]
fn a_ring_leaves_its_common_motion_in_two_modes_at_once() {
    let text = "[system]\nname = \"van-der-pol-ring\"\nparameters = { n = 3, mu = 1.0, coupling = \
                0.3 }\n[initial]\nq = [1.0, 1.0, 1.0]\np = [0.0, 0.0, 0.0]\n[time]\nend = 1.0\n\
                step = 0.1\n";
    let problem = Scene::read(text).unwrap_or_else(|error| panic!("{error}")).problem;
    let study = branch(study(problem, 100.0), "coupling", [0.3, 0.05], 0);
    let found = study.run(&REFERENCE, 0.1, &Silent).unwrap();
    let events = found.points.iter().filter_map(|point| Some((point.event?, point.cycle.value?)));
    let [(Event::Branching, value)] = events.collect::<Vec<_>>()[..] else { panic!("{found:?}") };
    close("coupling", value, RING, 1e-7);
}
