//! Basins of attraction: one attractor for all runs that reach it, and none where the motion goes
//! on to change.

use afterbay_analysis::Variable;
use afterbay_analysis::progress::Silent;
use afterbay_analysis::study::attractor::Kind;
use afterbay_analysis::study::basins::{Axis, BasinMap, Basins, Cell, MOST_ATTRACTORS, TOO_MANY};
use afterbay_analysis::study::dynamics::Dynamics;
use afterbay_analysis::study::outcome::Ending;
use afterbay_analysis::study::section::Section;
use afterbay_experiments::experiment;
use afterbay_experiments::scene::Scene;
use afterbay_methods::registry::{REFERENCE, find};

fn text(system: &str) -> String {
    format!("[system]\n{system}\n[initial]\nq = [0.0]\np = [0.0]\n[time]\nend = 1.0\nstep = 0.1\n")
}

fn axis(variable: Variable, count: u32) -> Axis {
    let values = (0..count).map(|i| -2.0 + 4.0 * f64::from(i) / f64::from(count - 1)).collect();
    Axis { variable, dof: 0, values }
}

/// The basins of an oscillator with k and b.
fn oscillator(k: f64, b: f64, longest: u64) -> Basins {
    let system = format!("name = \"damped-oscillator\"\nparameters = {{ k = {k:?}, b = {b:?} }}");
    Basins {
        problem: Scene::read(&text(&system)).unwrap_or_else(|error| panic!("{error}")).problem,
        section: Section::Stroboscopic { interval: Some(1.0) },
        axes: [axis(Variable::Q, 7), axis(Variable::P, 7)],
        longest,
    }
}

/// Runs that spiral into the rest for longer than they are compared side by side, and that creep to
/// it, show one attractor.
#[test]
fn slow_runs_to_one_rest_have_one_attractor() {
    for (k, b, longest) in [(1.0, 0.01, 1000), (1.0, 0.02, 50), (0.004, 1.0, 200)] {
        let study = oscillator(k, b, longest);
        let exact = study.run(&REFERENCE, 0.1, &Silent).unwrap();
        let mut own = study.run(find("rk4").unwrap(), 0.1, &Silent).unwrap();
        own.renumber(&exact);
        for found in [&exact, &own] {
            assert_eq!(found.attractors.len(), 1, "{k}, {b}: {:?}", found.attractors);
            assert_eq!(found.attractors[0].attractor.kind, Kind::Period(1), "{k}, {b}");
            assert!(found.cells.iter().all(|cell| cell.attractor == Some(0)), "{k}, {b}");
            assert!(!found.has_boundary(7) && found.uncertainty(7).is_none());
        }
    }
}

/// Motion that grows has no attractor, nor does one that falls for longer than it is followed.
#[test]
fn motion_that_goes_on_to_change_is_unsettled() {
    for (k, b) in [(1.0, -0.01), (1.0, -2e-4), (1.0, 2e-4), (1e-4, 1.0)] {
        let found = oscillator(k, b, 100).run(find("rk4").unwrap(), 0.2, &Silent).unwrap();
        assert!(found.attractors.len() <= 1, "{k}, {b}: {:?}", found.attractors);
        for (i, cell) in found.cells.iter().enumerate() {
            // The rest itself is a state that repeats. It is no attractor where motion grows.
            let outcome = match i {
                24 if b < 0.0 => "unstable",
                24 => "completed",
                _ => "unsettled",
            };
            assert!(outcome != "unstable" || cell.attractor.is_none(), "{k}, {b}: {cell:?}");
            let creeps = k < 1.0 && cell.attractor == Some(0);
            assert!(cell.ending.outcome == outcome || creeps, "{k}, {b}, {i}: {cell:?}");
        }
    }
}

/// A body that friction stops in free motion rests anywhere: at 25 places, on this grid, of which no
/// more are told apart than [`MOST_ATTRACTORS`].
#[test]
fn runs_beyond_the_most_attractors_say_so() {
    let system = "name = \"custom\"\npotential = \"0*q1\"\ndissipation = [\"0.5*v1\"]";
    let study = Basins {
        problem: Scene::read(&text(system)).unwrap_or_else(|error| panic!("{error}")).problem,
        section: Section::Stroboscopic { interval: Some(1.0) },
        axes: [axis(Variable::Q, 9), axis(Variable::P, 9)],
        longest: 1000,
    };
    let found = study.run(find("rk4").unwrap(), 0.05, &Silent).unwrap();
    let count = |outcome| found.cells.iter().filter(|cell| cell.ending.outcome == outcome).count();
    assert_eq!(found.attractors.len(), MOST_ATTRACTORS);
    assert_eq!((count("completed"), count(TOO_MANY)), (80, 1));
}

/// The interval of the section has nothing to do with a motion without a drive: a cycle is one
/// attractor, and the same one for methods whose periods differ a little, even where the interval
/// is nearly the period or three of them nearly twenty intervals.
#[test]
fn a_cycle_is_one_attractor_whatever_the_interval() {
    for (mu, interval, h) in
        [(1.0, 1.0, 0.1), (1.0, 0.5, 0.1), (1.0, 6.663287, 0.1), (2.0, 1.0, 0.05)]
    {
        let system = format!("name = \"van-der-pol\"\nparameters = {{ mu = {mu:?} }}");
        let study = Basins {
            problem: Scene::read(&text(&system)).unwrap_or_else(|error| panic!("{error}")).problem,
            section: Section::Stroboscopic { interval: Some(interval) },
            axes: [axis(Variable::Q, 4), axis(Variable::P, 4)],
            longest: 1000,
        };
        let exact = study.run(&REFERENCE, h, &Silent).unwrap();
        assert_eq!(exact.attractors.len(), 1, "{mu}, {interval}");
        for method in ["rk4", "moddg", "increment-4"] {
            let mut own = study.run(find(method).unwrap(), h, &Silent).unwrap();
            own.renumber(&exact);
            assert_eq!(own.attractors.len(), 1, "{method}, {mu}, {interval}");
            for cell in own.cells.iter().chain(&exact.cells) {
                assert_eq!(cell.attractor, Some(0), "{method}, {mu}, {interval}: {cell:?}");
            }
        }
    }
}

/// A cycle round an unstable rest is the attractor, and the rest is none; nor is a hill top.
#[test]
fn an_equilibrium_that_does_not_attract_is_no_attractor() {
    let custom = |potential: &str| {
        format!("name = \"custom\"\npotential = \"{potential}\"\ndissipation = [\"0.2*v1\"]")
    };
    let duffing = "name = \"duffing\"\nparameters = { alpha = -1.0, beta = 1.0, c = 0.2 }";
    let van_der_pol = "name = \"van-der-pol\"\nparameters = { mu = 1.0 }";
    for (system, attractors, outcome) in [
        (custom("1 - cos(pi*q1/2)"), 1, "completed"),
        (custom("-q1^2/2"), 0, "not-finite"),
        (duffing.to_owned(), 2, "completed"),
        (van_der_pol.to_owned(), 1, "completed"),
    ] {
        let study = Basins {
            problem: Scene::read(&text(&system)).unwrap_or_else(|error| panic!("{error}")).problem,
            section: Section::Stroboscopic { interval: Some(1.0) },
            axes: [axis(Variable::Q, 9), axis(Variable::P, 9)],
            longest: 1000,
        };
        let found = study.run(find("rk4").unwrap(), 0.1, &Silent).unwrap();
        assert_eq!(found.attractors.len(), attractors, "{system}: {:?}", found.attractors);
        assert_eq!(found.has_boundary(9), attractors > 1, "{system}");
        // Hill tops of the cosine are at the ends of the grid.
        let tops = if system.contains("cos") { [36, 44] } else { [40; 2] };
        for (i, cell) in found.cells.iter().enumerate() {
            let top = tops.contains(&i);
            assert_eq!(cell.ending.outcome, if top { "unstable" } else { outcome }, "{system} {i}");
            let reaches = !top && attractors > 0;
            assert_eq!(cell.attractor.is_some(), reaches, "{system} {i}: {cell:?}");
        }
    }
    let study = "[study.basins]\nmethods = [\"rk4\"]\n[study.basins.grid]\n\
                 q1 = { from = -2, to = 2, count = 9 }\np1 = { from = -2, to = 2, count = 9 }\n";
    let scene = Scene::read(&format!("{}{study}", text(&custom("-q1^2/2")))).unwrap();
    let (_, findings) = experiment::study(&scene, &Silent).unwrap();
    let said = &findings[0].statement;
    let right = "reference: 0 attractors, 1 of 81 cells on an unstable equilibrium or cycle and \
                 80 of 81 cells failed";
    assert!(said.contains(right), "{said}");
}

/// Equal cells in rows, numbered by a rule of their column; no attractor is unsettled.
fn map(width: usize, rule: fn(usize) -> Option<usize>) -> BasinMap {
    let cell = |i: usize| {
        let attractor = rule(i % width);
        let outcome = if attractor.is_some() { "completed" } else { "unsettled" };
        Cell { attractor, periods: 1, ending: Ending { outcome, failure: None } }
    };
    let cells = (0..width * width).map(cell).collect();
    BasinMap { row: &REFERENCE, h: 0.1, attractors: Vec::new(), cells }
}

#[test]
fn an_exponent_that_is_none_is_not_known() {
    // A straight boundary: twice as many cells are within twice the distance.
    let straight = map(40, |x| Some(usize::from(x > 19)));
    let alpha = straight.uncertainty(40).expect("a boundary");
    assert!(straight.has_boundary(40) && (alpha - 1.0).abs() < 0.25, "{alpha}");
    // Fewer cells differ from those farther away: no law ε^α with α > 0.
    let stripes = map(12, |x| Some(usize::from(x % 4 == 0)));
    assert!(stripes.has_boundary(12) && stripes.uncertainty(12).is_none());
    // Cells that have not settled are no basin.
    let open = map(40, |x| (x % 3 > 0).then_some(0));
    assert!(!open.has_boundary(40) && open.uncertainty(40).is_none());
}

/// Runs over the barrier of a well escape, and one rests on it. The share of the cells in which a
/// method agrees with the reference is that of the cells with an attractor.
#[test]
fn agreement_is_told_of_the_cells_with_an_attractor() {
    let system = "name = \"custom\"\npotential = \"q1^2/2 - q1^3/3\"\ndissipation = [\"0.2*p1\"]";
    let study = "[study.basins]\nmethods = [\"rk4\"]\n[study.basins.grid]\n\
                 q1 = { from = -2, to = 2, count = 9 }\np1 = { from = -2, to = 2, count = 9 }\n";
    let scene = Scene::read(&format!("{}{study}", text(system))).unwrap();
    let (_, findings) = experiment::study(&scene, &Silent).unwrap();
    let said = &findings[0].statement;
    let cells = said.split("100.0 % of the ").nth(1).and_then(|rest| rest.split(' ').next());
    let cells: usize =
        cells.and_then(|cells| cells.parse().ok()).unwrap_or_else(|| panic!("{said}"));
    assert!((10..70).contains(&cells), "{said}");
    for part in [
        "that of the reference in 100.0 % of the ".to_owned(),
        " cells where it has one, α = ".to_owned(),
        "1 of 81 cells on an unstable equilibrium or cycle and ".to_owned(),
        format!("and {} of 81 cells failed", 80 - cells),
    ] {
        assert!(said.contains(&part), "{part:?} in {said}");
    }
}

/// Runs of a system under a force, from a grid of states of the first coordinate.
fn under_a_force(
    system: &str,
    force: &str,
    [q, p]: [&str; 2],
    (extent, count): (f64, u32),
    longest: u64,
) -> Basins {
    let text = format!(
        "[system]\n{system}\n[drive]\nforce = {force}\n[initial]\nq = {q}\np = {p}\n[time]\n\
         end = 1.0\nstep = 0.1\n"
    );
    let axis = |variable| {
        let axis = axis(variable, count);
        Axis { values: axis.values.into_iter().map(|x| 0.5 * extent * x).collect(), ..axis }
    };
    Basins {
        problem: Scene::read(&text).unwrap_or_else(|error| panic!("{error}")).problem,
        section: Section::Stroboscopic { interval: None },
        axes: [axis(Variable::Q), axis(Variable::P)],
        longest,
    }
}

fn kinds(study: &Basins, h: f64) -> Vec<Kind> {
    let found = study.run(find("rk4").unwrap(), h, &Silent).unwrap();
    found.attractors.iter().map(|known| known.attractor.kind).collect()
}

/// Two chaotic masses have an attractor of four dimensions, which 4000 states do not fill.
#[test]
fn an_attractor_of_many_dimensions_is_one() {
    let system = "name = \"custom\"\npotential = \"q1^4/4 + q2^4/4 + 0.02*(q1 - q2)^2\"\n\
                  dissipation = [\"0.05*p1\", \"0.05*p2\"]";
    let force = "[\"7.5*cos(t)\", \"7.5*cos(t)\"]";
    let study = under_a_force(system, force, ["[2.5, 1.0]", "[0.0, 0.5]"], (1.0, 3), 300);
    assert_eq!(kinds(&study, 0.1), [Kind::Aperiodic]);
}

/// Runs that are chaotic for some thousand returns come to cycles of period 2 in the end.
#[test]
fn a_long_chaotic_transient_is_no_attractor() {
    let system = "name = \"duffing\"\nparameters = { alpha = 0.0, beta = 1.0, c = 0.005 }";
    let study = under_a_force(system, "[\"7.5*cos(t)\"]", ["[2.5]", "[0.0]"], (0.1, 5), 300);
    assert_eq!(kinds(&study, 0.1), [Kind::Period(2); 2]);
}

/// Chaos in each of two wells, on a grid that is a hundred times as large.
#[test]
fn attractors_that_are_small_beside_the_grid_are_told_apart() {
    let system = "name = \"custom\"\npotential = \"-q1^2/2 + q1^4/4\"\n\
                  dissipation = [\"0.25*p1\"]";
    for extent in [2.0, 70.0] {
        let force = "[\"0.268*cos(1.2*t)\"]";
        let study = under_a_force(system, force, ["[1.0]", "[0.0]"], (extent, 8), 300);
        assert_eq!(kinds(&study, 0.02), [Kind::Aperiodic; 2], "{extent}");
    }
}
