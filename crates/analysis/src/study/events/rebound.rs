//! The momentum after an impact on a wall.

use afterbay_core::System;

/// The error of the velocity after an impact, in roundings of the one before. A choice.
const MET_ROUNDINGS: f64 = 4.0;
/// The largest error, as a share of the velocity before, that is a rounding of the terms of ∂H/∂p
/// once the search makes no progress.
const NOISE: f64 = 1e-9;
/// The most momenta tried.
const MOST_TRIED: u32 = 60;

/// Sets the momentum p_j after an impact on a wall that q_j meets: the impulse changes p_j alone,
/// and the velocity v_j = ∂H/∂p_j becomes -r v_j, with r the restitution. If H is separable, p_j
/// becomes -r p_j. If r = 1, and H is quadratic in p_j, H does not change.
///
/// If no such p_j is found, p does not change.
pub(super) fn rebound(
    system: &(impl System<f64> + ?Sized),
    q: &[f64],
    p: &mut [f64],
    j: usize,
    restitution: f64,
) {
    let start = p[j];
    let (mut hq, mut velocity) = (vec![0.0; q.len()], vec![0.0; q.len()]);
    let mut velocity_at = |p: &mut [f64], p_j: f64| {
        p[j] = p_j;
        system.gradient(q, p, &mut hq, &mut velocity);
        velocity[j]
    };
    let before = velocity_at(p, start);
    let off_at = |velocity: f64| velocity + restitution * before;
    // The secant method, from the momentum that is right for a separable H.
    let (mut last, mut last_off) = (start, off_at(before));
    let mut next = -restitution * start;
    if next == start {
        next = start - last_off;
    }
    for _ in 0..MOST_TRIED {
        let off = off_at(velocity_at(p, next));
        let is_noise = off.abs() >= last_off.abs() && off.abs() <= NOISE * before.abs();
        if off.abs() <= MET_ROUNDINGS * f64::EPSILON * before.abs() || is_noise {
            return;
        }
        let further = next - off * (next - last) / (off - last_off);
        (last, last_off, next) = (next, off, further);
        if !next.is_finite() {
            break;
        }
    }
    p[j] = start;
}

#[cfg(test)]
mod tests {
    use super::*;
    use afterbay_systems::{DampedDoublePendulum, Duffing};

    #[test]
    fn a_separable_system_has_its_momentum_reversed_to_the_bit() {
        let system = Duffing::new(1.0, 0.5, 0.1).expect("a system");
        for (p_1, restitution) in [(0.3, 1.0), (-0.7, 0.9), (1e-300, 0.5), (0.0, 1.0), (2.0, 0.0)] {
            let mut p = [p_1];
            rebound(&system, &[0.2], &mut p, 0, restitution);
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
                    rebound(&system, &q, &mut p, j, restitution);
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
}
