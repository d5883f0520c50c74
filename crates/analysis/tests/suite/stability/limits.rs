//! Stability limits, and steps whose equation has several solutions, agree with theory.

use super::{cell, custom, rows, well};
use afterbay_analysis::Model;
use afterbay_analysis::progress::Silent;
use afterbay_analysis::study::Problem;
use afterbay_analysis::study::stability::{Map, Verdict};
use afterbay_systems::{DAMPED_OSCILLATOR, FPUT_CHAIN};

fn bounded(verdict: Verdict) -> bool {
    matches!(verdict, Verdict::Right | Verdict::Late | Verdict::Wrong | Verdict::Unjudged)
}

#[test]
fn explicit_methods_end_where_theory_says_and_moddg_nowhere() {
    // k = 4: ω = 2. Leap-frog ends at h ω = 2, RK4 at 2√2.
    let problem = Problem {
        model: Model::of(&DAMPED_OSCILLATOR, &[4.0, 0.0]),
        q: vec![1.0],
        p: vec![0.5],
        end: 1.0,
    };
    let limits = [1.0, 2_f64.sqrt()];
    let steps: Vec<f64> =
        limits.iter().flat_map(|limit| [limit * 0.999, limit * 1.001]).chain([30.0]).collect();
    let map = Map {
        problem,
        parameter: "b",
        values: &[0.0, 0.1, 3.0],
        steps: &steps,
        end: 1.0,
        least_steps: 2000,
    };
    let cells = map.run(&rows(&["leapfrog", "rk4", "moddg"]), &Silent).expect("a map");
    let cell = |method: &str, b: f64, h: f64| {
        cells
            .iter()
            .find(|row| row.method == method && row.value == b && row.h == h)
            .expect("a cell")
    };
    let radius =
        |method: &str, h: f64| cell(method, 0.0, h).spectral_radius.expect("a linear step");
    for (method, [below, above]) in
        [("leapfrog", [steps[0], steps[1]]), ("rk4", [steps[2], steps[3]])]
    {
        assert!(radius(method, below) < 1.0 + 1e-12 && radius(method, above) > 1.001, "{method}");
        assert!(bounded(cell(method, 0.0, below).verdict), "{method}");
        assert!(
            matches!(cell(method, 0.0, above).verdict, Verdict::Growing | Verdict::NotFinite),
            "{method}"
        );
    }
    for cell in cells.iter().filter(|cell| cell.method == "moddg") {
        assert!(cell.spectral_radius.expect("a linear step") < 1.0 + 1e-12, "{cell:?}");
        // Without friction no reference is found over a time of 60000, but the run is bounded.
        assert!(bounded(cell.verdict) && cell.steps_done == 2000, "{cell:?}");
    }
}

#[test]
fn a_chain_ends_with_its_fastest_mode() {
    // Without cubic springs: ω = 2 sin(nπ/(2(n + 1))), and leap-frog ends at h ω = 2.
    let n = 5;
    let fastest = 2.0 * (std::f64::consts::PI * 5.0 / 12.0).sin();
    let model = Model::of(&FPUT_CHAIN, &[n as f64, 0.0, 0.0]);
    let problem = Problem { model, q: vec![1.0, 0.0, -1.0, 0.3, 0.2], p: vec![0.0; n], end: 1.0 };
    let steps = [0.999, 1.001].map(|share| share * 2.0 / fastest);
    let map = Map {
        problem,
        parameter: "c",
        values: &[0.0, 0.2],
        steps: &steps,
        end: 1.0,
        least_steps: 1000,
    };
    let cells = map.run(&rows(&["leapfrog", "increment-2"]), &Silent).expect("a map");
    let radii: Vec<f64> =
        cells.iter().map(|row| row.spectral_radius.expect("a linear step")).collect();
    assert!((radii[0] - 1.0).abs() < 1e-9 && radii[1] > 1.03, "{radii:?}");
    assert!(radii[4..].iter().all(|&radius| radius < 1.0 + 1e-9), "{radii:?}");
    assert!(matches!(cells[1].verdict, Verdict::Growing | Verdict::NotFinite), "{:?}", cells[1]);
}

/// f(x) = x/h + h/8 x (x + 2)². The step of modDG from (1, p0) in the double well V = q⁴/4 - q²/2
/// moves by the root x = q1 - q0 of f(x) = p0.
fn step_equation(h: f64, x: f64) -> f64 {
    x / h + h / 8.0 * x * (x + 2.0).powi(2)
}

/// The turning points of f, if there are any: f' = 1/h + h/8 (3 x² + 8 x + 4) = 0.
fn turns(h: f64) -> Option<[f64; 2]> {
    let root = (64.0 - 12.0 * (4.0 + 8.0 / (h * h))).sqrt();
    (root > 0.0).then(|| [(-8.0 - root) / 6.0, (-8.0 + root) / 6.0])
}

#[test]
fn several_solutions_are_those_of_the_cubic() {
    let (h, p) = (4.0, -0.715);
    // f(x) = p has three real roots, since p lies between the values of f at its turning points.
    let [high, low] = turns(h).expect("it turns").map(|x| step_equation(h, x));
    assert!(low < p && p < high, "{low} {high}");
    // The root continued from h = 0 is to the right of both turning points, until the value at the
    // right one rises to p.
    let end = (0..4000)
        .map(|i| 2.5 + 2e-4 * f64::from(i))
        .find(|&h| turns(h).is_some_and(|[_, x]| step_equation(h, x) > p));
    let end = end.expect("the branch ends");
    for method in ["moddg", "increment-1"] {
        let of = |h: f64| cell(well(0.0), [1.0, p], method, h, h);
        for h in [end + 1e-3, h] {
            let found = of(h);
            assert_eq!(
                (found.verdict, found.steps_done, found.outcome),
                (Verdict::SeveralSolutions, 0, "several-solutions"),
                "{h}"
            );
        }
        assert_eq!(of(end - 1e-3).steps_done, 1);
    }
    // For p = -0.6 and h = 4 there are three roots as well, but the branch goes on.
    assert!(low < -0.6 && -0.6 < high);
    assert_eq!(cell(well(0.0), [1.0, -0.6], "moddg", h, h).steps_done, 1);
    // At the top of the barrier the solution bifurcates at h = 2.
    assert_eq!(cell(well(0.0), [0.0, 0.0], "moddg", 1.99, 4.0).outcome, "completed");
    assert_eq!(cell(well(0.0), [0.0, 0.0], "moddg", 2.01, 4.0).verdict, Verdict::SeveralSolutions);
}

/// A constant force moves the centre of a motion and does not change its growth.
#[test]
fn the_spectral_radius_does_not_depend_on_a_constant_force() {
    let radius = |potential: &str, method: &str| {
        let model = custom(potential, &["c*v1"], &[("c", 0.2)]);
        cell(model, [1.0, 0.5], method, 0.3, 3.0).spectral_radius.expect("an affine step")
    };
    for method in ["leapfrog", "rk4", "moddg", "gonzalez", "collocation-4", "linear-exact"] {
        let plain = radius("2*q1^2", method);
        let found = radius("2*q1^2 + 9.81*q1", method);
        assert!((found - plain).abs() < 1e-13, "{method}: {found} {plain}");
    }
}
