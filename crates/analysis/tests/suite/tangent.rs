//! The derivative of a step against closed forms and differences.

use afterbay_analysis::Model;
use afterbay_analysis::study::Problem;
use afterbay_analysis::study::tangent::Tangent;
use afterbay_core::{Quad, State};
use afterbay_methods::registry::{FIXED, find};
use afterbay_systems::{
    Custom, DAMPED_OSCILLATOR, DUFFING, Described, Description, DissipationText,
};
use faer::Mat;

fn jacobian(model: Model, method: &str, h: f64, [q, p]: [f64; 2]) -> Mat<f64> {
    let problem = Problem { model, q: vec![q], p: vec![p], end: 1.0 };
    let tangent = Tangent::new(&problem.model, find(method).unwrap()).unwrap();
    let mut state = problem.start::<Quad>().unwrap();
    tangent.step_with_jacobian(Quad::from_f64(h), &mut state).unwrap()
}

fn check(found: &Mat<f64>, exact: [[f64; 2]; 2], most: f64, what: &str) {
    for (i, row) in exact.iter().enumerate() {
        for (j, exact) in row.iter().enumerate() {
            let off = (found[(i, j)] - exact).abs();
            assert!(off < most, "{what}: J{i}{j} = {:e}, not {exact:e}", found[(i, j)]);
        }
    }
}

/// q1 - q0 = h p̄ and p1 - p0 = -h (k q̄ + b p̄) solved for (q1, p1).
#[test]
fn moddg_of_the_damped_oscillator_has_its_closed_form() {
    for (h, k, b) in [(0.1, 1.0, 0.1), (0.7, 3.0, 2.0), (3.0, 0.5, 0.0)] {
        let model = Model::of(&DAMPED_OSCILLATOR, &[k, b]);
        let (s, d) = (h * h * k / 4.0, h * b / 2.0);
        let all = 1.0 + s + d;
        let exact = [[(1.0 - s + d) / all, h / all], [-h * k / all, (1.0 - s - d) / all]];
        for start in [[2.3, -3.1], [0.0, 1.0], [1e-9, 0.0]] {
            check(&jacobian(model.clone(), "moddg", h, start), exact, 1e-15, "moddg");
        }
    }
}

/// rk4 on z' = A z is the Taylor polynomial Σ (hA)^n/n! of degree 4.
#[test]
fn rk4_on_a_linear_system_is_a_polynomial() {
    let (h, k, b) = (0.3, 2.0, 0.7);
    let a = Mat::from_fn(2, 2, |i, j| [[0.0, h], [-h * k, -h * b]][i][j]);
    let mut exact = Mat::<f64>::identity(2, 2);
    for n in (1..=4).rev() {
        exact = Mat::<f64>::identity(2, 2) + &a * &exact * faer::Scale(1.0 / f64::from(n));
    }
    let exact = [0, 1].map(|i| [0, 1].map(|j| exact[(i, j)]));
    let model = Model::of(&DAMPED_OSCILLATOR, &[k, b]);
    check(&jacobian(model, "rk4", h, [0.4, 1.7]), exact, 1e-15, "rk4");
}

/// A motion that has settled at q ≠ 0: the derivative of a step of a linear system is the same
/// at every state, also where p is far below the rounding of q, and where no unit is near 1.
#[test]
fn the_derivative_is_not_lost_beside_a_coordinate() {
    let h = 0.1;
    for (well, k, b) in [(1.0, 1.0, 3.0), (1e3, 1.0, 0.05), (-1e-9, 4.0, 0.0), (1e9, 1e-4, 0.0)] {
        let description = Description {
            potential: format!("{k:?}*(q1 - ({well:?}))^2/2"),
            dissipation: DissipationText::Forces(vec![format!("{b:?}*v1")]),
            ..Description::default()
        };
        let system = Custom::new(&description).unwrap();
        let system = Model::Custom(Described::Separable(system));
        let (s, d) = (h * h * k / 4.0, h * b / 2.0);
        let all = 1.0 + s + d;
        let exact = [[(1.0 - s + d) / all, h / all], [-h * k / all, (1.0 - s - d) / all]];
        for p in [0.0, 1e-300, 1e-40, 1e-20, 1e-12, 1.0] {
            let model = system.clone();
            let found = jacobian(model, "moddg", h, [well, p * well]);
            check(&found, exact, 1e-11, &format!("well {well:e}, p {p:e}"));
        }
    }
}

/// Two coupled coordinates, of which the second is measured in the unit u, or passes 0:
/// J_ij u_j/u_i is that of u = 1.
#[test]
fn the_derivative_does_not_depend_on_the_unit_of_a_coordinate() {
    let scaled = |u: f64, [q, p]: [f64; 2]| {
        let mass = (u * u).recip();
        let description = Description {
            potential: format!("q1^4/4 + (q1 - q2/({u:?}))^2 + sin(q2/({u:?}))"),
            dissipation: DissipationText::Forces(vec!["0.2*v1".into(), format!("0.3*{mass:?}*v2")]),
            masses: vec!["1".into(), format!("{mass:?}")],
            ..Description::default()
        };
        let model = Model::Custom(Described::Separable(Custom::new(&description).unwrap()));
        let problem = Problem { model, q: vec![1.3, q * u], p: vec![-0.4, p / u], end: 1.0 };
        let tangent = Tangent::new(&problem.model, find("rk4").unwrap()).unwrap();
        let mut state = problem.start::<Quad>().unwrap();
        let found = tangent.step_with_jacobian(Quad::from_f64(0.1), &mut state).unwrap();
        let sizes = [1.0, u, 1.0, 1.0 / u];
        Mat::from_fn(4, 4, |i, j| found[(i, j)] * sizes[j] / sizes[i])
    };
    for start in [[0.7, 0.2], [0.0, 0.0], [1e-9, -1e-13]] {
        let exact = scaled(1.0, start);
        for u in [1e-3, 1e-8, 1e-12, 1e6, 1e12] {
            let found = scaled(u, start);
            for (i, j) in (0..4).flat_map(|i| (0..4).map(move |j| (i, j))) {
                let off = (found[(i, j)] - exact[(i, j)]).abs();
                assert!(off < 1e-9, "u = {u:e}, {start:?}: J{i}{j} = {:e}", found[(i, j)]);
            }
        }
    }
}

/// A motion that decays for ever does not run out of digits.
#[test]
fn the_derivative_is_not_lost_near_the_least_number() {
    let model = Model::of(&DAMPED_OSCILLATOR, &[1.0, 0.5]);
    let exact = jacobian(model.clone(), "rk4", 0.1, [1.0, 0.5]);
    let exact = [0, 1].map(|i| [0, 1].map(|j| exact[(i, j)]));
    for size in [1e-90, 1e-200, 1e-300, 1e-320, 0.0] {
        let found = jacobian(model.clone(), "rk4", 0.1, [size, -0.3 * size]);
        check(&found, exact, 1e-14, &format!("size {size:e}"));
    }
}

/// Central differences of steps in `f64` agree within their own errors, for every method.
#[test]
fn every_method_has_the_derivative_of_its_step() {
    let model = Model::of(&DUFFING, &[1.0, 0.5, 0.3]);
    let (h, z, d) = (0.1, [0.8, -0.6], 1e-5);
    let mut seen = 0;
    for row in FIXED.iter().filter(|row| model.bind(row).is_ok()) {
        let run = model.bind(row).unwrap();
        let image = |z: [f64; 2]| {
            let mut state = State::new(vec![z[0]], vec![z[1]]).unwrap();
            run.step(h, &mut state).unwrap();
            [state.q[0], state.p[0]]
        };
        let column = |j: usize| {
            let [mut a, mut b] = [z; 2];
            (a[j], b[j]) = (z[j] + d, z[j] - d);
            let (a, b) = (image(a), image(b));
            [0, 1].map(|i| (a[i] - b[i]) / (2.0 * d))
        };
        let columns = [column(0), column(1)];
        let exact = [0, 1].map(|i| [columns[0][i], columns[1][i]]);
        check(&jacobian(model.clone(), row.name, h, z), exact, 1e-9, row.name);
        seen += 1;
    }
    assert!(seen > 15, "{seen} methods");
}
