//! Every method on systems whose V and D depend on the time: the orders of q, p, w and s_t, K, the
//! clock and the reservoirs.

use crate::bind::after;
use crate::motors::{A, B, C, MASSES, Model, Scene, Shaker, is_relaxed};
use afterbay_core::{Abilities, Clocked, Grid};
use afterbay_methods::registry::{Order, Row, bind, find};
use afterbay_systems::VanDerPol;
use std::sync::Arc;

fn alone(model: Model) -> Scene {
    Scene { model, drive: None }
}

/// The first particle is driven by F = 0.7 cos(1.7 t), too.
fn shaken(model: Model) -> Scene {
    Scene { model, drive: Some(Shaker::of_first(0.7, 1.7)) }
}

/// The lag of a step of relaxed-rk4 is of order 5. In Mathieu's equation it is so large that the
/// order 4 shows only with more than a thousand steps.
fn is_not_relaxed(row: &Row) -> bool {
    !is_relaxed(row)
}

#[test]
fn orders_for_mathieus_equation() {
    assert_eq!(alone(Model::Mathieu).check_orders(&is_not_relaxed), 22);
}

#[test]
fn orders_of_two_degrees_of_freedom() {
    // The relaxed methods of orders 8 and 9 do not show them at these steps, for the same reason.
    let shows = |row: &Row| !is_relaxed(row) || row.order() == Order::Of(4);
    assert_eq!(alone(Model::Breathing).check_orders(&shows), 22);
}

#[test]
fn orders_with_a_drive_too() {
    assert_eq!(shaken(Model::Mathieu).check_orders(&is_not_relaxed), 22);
}

#[test]
fn orders_where_friction_couples_the_momenta() {
    assert_eq!(alone(Model::Rubbed).check_orders(&is_not_relaxed), 17);
}

/// The classical Runge-Kutta method over [0, 1] for y' = f(t, y).
fn runge_kutta<const N: usize>(y: [f64; N], f: impl Fn(f64, [f64; N]) -> [f64; N]) -> [f64; N] {
    const STEPS: usize = 4000;
    let h = 1.0 / STEPS as f64;
    let moved = |y: [f64; N], h: f64, k: [f64; N]| std::array::from_fn(|i| y[i] + h * k[i]);
    (0..STEPS).fold(y, |y, n| {
        let t = n as f64 * h;
        let a = f(t, y);
        let b = f(t + h / 2.0, moved(y, h / 2.0, a));
        let c = f(t + h / 2.0, moved(y, h / 2.0, b));
        let d = f(t + h, moved(y, h, c));
        std::array::from_fn(|i| y[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]))
    })
}

/// [q, p, w, s_t] of Mathieu's equation with friction, from its definition.
fn mathieu(t: f64, [q, p, _, _]: [f64; 4]) -> [f64; 4] {
    let stiffness = A - 2.0 * B * (2.0 * t).cos();
    let pumped = 4.0 * B * (2.0 * t).sin() * q * q / 2.0;
    [p, -stiffness * q - C * p, C * p * p, pumped]
}

/// [q1, q2, p1, p2, w1, w2, s_t] of the pair, from its definition.
fn pair(t: f64, [q1, q2, p1, p2, ..]: [f64; 7]) -> [f64; 7] {
    let (q, v) = ([q1, q2], [p1 / MASSES[0], p2 / MASSES[1]]);
    let breath = 1.0 + 0.3 * (1.3 * t).sin();
    let pull = (q2 - q1 - 0.4 * (0.9 * t).cos()).sin();
    let d: [f64; 2] = std::array::from_fn(|j| {
        let wave = 1.0 + (2.0 * t).cos() / 2.0;
        0.3 * v[j] * wave * (1.0 + q[j] * q[j]) + 0.1 * v[j].powi(3)
    });
    let forces = [-breath * q1 - q1.powi(3) + pull, -breath * q2 - pull];
    let pumped = 0.39 * (1.3 * t).cos() * (q1 * q1 + q2 * q2) / 2.0 + pull * 0.36 * (0.9 * t).sin();
    [v[0], v[1], forces[0] - d[0], forces[1] - d[1], d[0] * v[0], d[1] * v[1], pumped]
}

/// q, p, w and s_t at t = 1 by a method of high order.
fn end(model: Model) -> Vec<f64> {
    let scene = alone(model);
    let run = bind::<f64>(find("collocation-6").unwrap(), scene.system()).unwrap();
    let state = after(&run, Grid::of(1.0 / 400.0, 400).unwrap(), &scene.start());
    scene.parts(state.state_ref()).concat()
}

#[test]
fn the_solution_is_that_of_the_equations_with_time() {
    let of_mathieu = runge_kutta([1.1, 0.6, 0.0, 0.0], mathieu);
    let of_pair = runge_kutta([1.1, -0.4, 0.6, 0.9, 0.0, 0.0, 0.0], pair);
    for (model, exact) in [(Model::Mathieu, &of_mathieu[..]), (Model::Breathing, &of_pair[..])] {
        let found = end(model);
        assert_eq!(found.len(), exact.len());
        for (found, exact) in found.iter().zip(exact) {
            assert!((found - exact).abs() < 1e-12, "{found:?}, not {exact:?}");
        }
    }
}

/// Checks that the reservoirs of a passive method lose no energy, whatever is pumped into the
/// system.
fn check_all(scene: Scene) -> usize {
    let mut before = Vec::new();
    scene.run_all(1e-4, &mut |row, step, found| {
        let lost = step > 0 && before.iter().zip(&found.w).any(|(a, b)| *b < a - 1e-15);
        assert!(!row.passive || !lost, "{}: w falls at step {step}", row.name);
        before = found.w;
    })
}

#[test]
fn every_method_keeps_the_time_and_k_and_stays_passive() {
    assert_eq!(check_all(alone(Model::Mathieu)), 30);
    assert_eq!(check_all(alone(Model::Breathing)), 29);
    assert_eq!(check_all(shaken(Model::Mathieu)), 30);
    assert_eq!(check_all(shaken(Model::Breathing)), 29);
}

#[test]
fn a_clock_needs_another_coordinate() {
    let alone: Arc<dyn Abilities<f64>> = Arc::new(VanDerPol::new(1.0).unwrap());
    assert!(Clocked::new(alone).is_err());
}

#[test]
fn a_clock_refuses_a_driven_system() {
    let driven = shaken(Model::Pair { drag: true }).system::<f64>();
    let refused = Clocked::new(driven).err().unwrap().to_string();
    assert!(refused.contains("the system is driven"), "{refused}");
}
