//! The momentum after an impact on a wall.

use afterbay_core::solver::zero_within;
use afterbay_core::{StepFailure, System};

/// The error of the velocity after an impact, in roundings of the one before. A choice.
const MET_ROUNDINGS: f64 = 4.0;
/// The largest error, as a share of the velocity before, of a momentum found to rounding: the terms
/// of ∂H/∂p may cancel. At a pole or a jump of ∂H/∂p it is larger.
const FOUND: f64 = 1e-6;
/// The first impulse tried, as a share of that of a separable H. A choice.
const FIRST_SHARE: f64 = 1.0 / 1024.0;
/// The ratio of each impulse tried to the one before. A choice.
const RATIO: f64 = 1.25;

/// Sets the momentum p_j after an impact on a wall that q_j meets: the impulse changes p_j alone,
/// against the velocity v_j = ∂H/∂p_j, and the velocity becomes -r v_j, with r the restitution. If
/// -r p_j has this velocity, as where H is separable, it is the new momentum, else the first one on
/// the way is. If r = 1, and H is quadratic or even in p_j, H does not change.
///
/// # Errors
/// [`StepFailure::NoRebound`] if no impulse is found, from 1/1024 of that of a separable H on, each
/// 5/4 of the one before. p does not change then.
pub(super) fn rebound(
    system: &(impl System<f64> + ?Sized),
    q: &[f64],
    p: &mut [f64],
    j: usize,
    restitution: f64,
) -> Result<(), StepFailure> {
    let start = p[j];
    let (mut hq, mut hp) = (vec![0.0; q.len()], vec![0.0; q.len()]);
    let mut velocity = |p_j: f64| {
        p[j] = p_j;
        system.gradient(q, p, &mut hq, &mut hp);
        hp[j]
    };
    let before = velocity(start);
    if before == 0.0 {
        return Ok(());
    }
    let mut off = |p_j: f64| velocity(p_j) + restitution * before;
    let met = MET_ROUNDINGS * f64::EPSILON * before.abs();
    if off(-restitution * start).abs() <= met {
        return Ok(());
    }
    // If p is 0, the search starts from the impulse of a unit mass.
    let momentum = if start == 0.0 { before.abs() } else { start.abs() };
    let whole = -before.signum() * (1.0 + restitution) * momentum;
    let (mut last, mut last_off) = (start, off(start));
    let mut share = FIRST_SHARE;
    loop {
        let next = start + whole * share;
        let next_off = off(next);
        if !next.is_finite() || !next_off.is_finite() {
            break;
        }
        if next_off == 0.0 {
            return Ok(());
        }
        if (next_off > 0.0) != (last_off > 0.0) {
            let at = |share: f64| last + share * (next - last);
            let (_, found) =
                zero_within((last_off, next_off), next, |share| Some((off(at(share)), at(share))));
            if off(found).abs() <= FOUND * before.abs() {
                return Ok(());
            }
        }
        (last, last_off, share) = (next, next_off, RATIO * share);
    }
    p[j] = start;
    Err(StepFailure::NoRebound { dof: j, velocity: 0.0 - restitution * before })
}

#[cfg(test)]
mod tests {
    use super::*;
    use afterbay_systems::{CustomGeneral, DampedDoublePendulum, Duffing, GeneralDescription};

    #[test]
    fn a_separable_system_has_its_momentum_reversed_to_the_bit() {
        let system = Duffing::new(1.0, 0.5, 0.1).expect("a system");
        for (p_1, restitution) in [(0.3, 1.0), (-0.7, 0.9), (1e-300, 0.5), (0.0, 1.0), (2.0, 0.0)] {
            let mut p = [p_1];
            rebound(&system, &[0.2], &mut p, 0, restitution).expect("an impulse");
            assert_eq!(p, [-restitution * p_1], "{p_1} {restitution}");
        }
    }

    #[test]
    fn an_impact_on_a_pendulum_reverses_the_velocity_and_keeps_the_energy() {
        let system: DampedDoublePendulum<f64> =
            DampedDoublePendulum::new([1.0, 0.7], [1.0, 1.2], 9.8, [0.0; 2]).expect("a system");
        let velocities = |q: &[f64], p: &[f64]| {
            let (mut hq, mut v) = ([0.0; 2], [0.0; 2]);
            system.gradient(q, p, &mut hq, &mut v);
            v
        };
        for (q, start) in [([0.0, 0.9], [-1.3, 2.1]), ([0.0, -2.0], [0.4, -0.1])] {
            for j in 0..2 {
                for restitution in [1.0, 0.8, 0.0] {
                    let mut p = start;
                    let (before, energy) = (velocities(&q, &p)[j], system.energy(&q, &p));
                    rebound(&system, &q, &mut p, j, restitution).expect("an impulse");
                    let after = velocities(&q, &p)[j];
                    assert!((after + restitution * before).abs() < 1e-14 * before.abs());
                    assert_eq!(p[1 - j], start[1 - j], "the impulse acts along the wall");
                    let lost = energy - system.energy(&q, &p);
                    assert!(lost > -1e-14 * energy.abs(), "{lost:e}");
                    assert!(restitution < 1.0 || lost.abs() < 1e-14 * energy.abs(), "{lost:e}");
                }
            }
        }
    }

    /// The velocities of a fast particle are near 1 over a long range of p, those of the second H
    /// are never below -1, and the third falls again beyond p = π/2: the first impulse counts.
    #[test]
    fn an_impulse_is_found_where_h_is_not_quadratic() {
        let system = |hamiltonian: &str| -> CustomGeneral<f64> {
            let hamiltonian = hamiltonian.to_owned();
            CustomGeneral::new(&GeneralDescription { hamiltonian, ..Default::default() })
                .expect("a system")
        };
        let after = |hamiltonian: &str, p_1: f64, restitution: f64| {
            let mut p = [p_1];
            let outcome = rebound(&system(hamiltonian), &[0.0], &mut p, 0, restitution);
            outcome.map(|()| p[0])
        };
        // p = v/√(1 - v²)
        for (p_1, restitution) in [(-20.0, 0.9), (-20.0, 0.5), (30.0, 0.99), (-1e4, 0.1)] {
            let v: f64 = -restitution * p_1 / f64::hypot(1.0, p_1);
            let found = after("sqrt(1 + p1^2)", p_1, restitution).expect("an impulse");
            let exact = v / (1.0 - v * v).sqrt();
            assert!((found / exact - 1.0).abs() < 1e-12, "{p_1} {restitution}: {found}");
        }
        let found = after("1 - cos(p1)", 2.5, 0.9).expect("an impulse");
        assert!((found + (0.9 * 2.5_f64.sin()).asin()).abs() < 1e-14, "{found}");
        let found = after("exp(p1) - p1", -0.5, 0.9).expect("an impulse");
        assert!((found.exp_m1() + 0.9 * (-0.5_f64).exp_m1()).abs() < 1e-15, "{found}");
        // The first momentum tried has the velocity, and a heavy mass needs a large one.
        for sign in [1.0, -1.0] {
            let found = after("p1^2/2 + 1023*p1", -1024.0, 1.0);
            assert_eq!(found, Ok(-1022.0));
            let found = after(&format!("p1^2/2e24 + {sign}e3*p1"), 1.0, 1.0).expect("an impulse");
            assert!((found / (sign * -2e27) - 1.0).abs() < 1e-12, "{found}");
        }
        assert_eq!(after("(p1^2 - 1)^2/4", 1.0, 0.5), Ok(1.0), "it does not move into the wall");
        for (hamiltonian, p_1) in [("exp(p1) - p1", 2.0), ("p1 + q1", 0.3), ("p1", 0.0)] {
            let failure = after(hamiltonian, p_1, 0.9).expect_err("no impulse");
            assert!(matches!(failure, StepFailure::NoRebound { dof: 0, .. }), "{failure}");
        }
    }
}
