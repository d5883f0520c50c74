//! Every method on driven systems: the orders of q, p, w and s, and K, in 31 digits.

use crate::motors::{Model, Scene, Shaker, is_relaxed};
use afterbay_methods::registry::{Needs, Order, Row};

/// F_j = a_j cos(ω_j t) (1 + q_j²/4) on these particles.
fn shaken(model: Model, driven: &'static [usize]) -> Scene {
    let (amplitudes, frequencies) = ([1.5, -0.8], [1.7, 2.9]);
    let drive = Some(Shaker { driven, amplitudes, frequencies, depends_on_place: true });
    Scene { model, drive }
}

/// The lag of a relaxed step is one order smaller than its error. It hides the order of
/// `relaxed-verner98` at all steps that are long enough for errors above 31 digits.
fn shows(row: &Row) -> bool {
    row.order() != Order::Of(9)
}

#[test]
fn orders_where_both_are_driven() {
    assert_eq!(shaken(Model::Pair { drag: true }, &[0, 1]).check_orders(&shows), 23);
}

#[test]
fn orders_where_one_of_two_is_driven() {
    // The methods that move one coordinate at a time look for its motor.
    let separable = |row: &Row| matches!(row.needs, Needs::Separable | Needs::SeparableOrPlanes);
    assert_eq!(shaken(Model::Pair { drag: true }, &[1]).check_orders(&separable), 9);
}

#[test]
fn orders_of_one_degree_of_freedom() {
    assert_eq!(shaken(Model::Single { drag: true }, &[0]).check_orders(&shows), 24);
}

#[test]
fn friction_that_couples_the_momenta_may_be_driven() {
    let scene = shaken(Model::Rubbed, &[0]);
    assert_eq!(scene.check_orders(&|row| shows(row) && !is_relaxed(row)), 12);
    assert_eq!(scene.run_all(1e-5, &mut |_, _, _| {}), 20);
}

/// Checks that a system without friction dissipates nothing under any method.
fn check_frictionless(model: Model, driven: &'static [usize]) -> usize {
    // A relaxed step ends late by its lag, and the motor is at the time of its end.
    shaken(model, driven).run_all(1e-5, &mut |row, step, found| {
        let lost = found.w.iter().map(|w| w.abs()).fold(0.0, f64::max);
        let size = found.s.iter().map(|s| s.abs()).fold(1.0, f64::max);
        assert!(lost < 1e-13 * size, "{} at step {step}: w = {lost:e}", row.name);
    })
}

#[test]
fn motors_keep_the_time_and_nothing_is_lost_without_friction() {
    assert_eq!(check_frictionless(Model::Single { drag: false }, &[0]), 30);
    assert_eq!(check_frictionless(Model::Pair { drag: false }, &[0, 1]), 29);
    assert_eq!(check_frictionless(Model::Pair { drag: false }, &[1]), 29);
}
