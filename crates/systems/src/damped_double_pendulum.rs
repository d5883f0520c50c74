//! The planar double pendulum with friction in the angles: a point mass on a massless rod, hung
//! from another.
//!
//! ```text
//! q_j' = v_j        p_j' = -∂H/∂q_j - c_j v_j        w_j' = c_j v_j²
//! v = M⁻¹ p         D_j = c_j v_j
//! H = p·M⁻¹p/2 + (m1 + m2) g l1 (1 - cos q1) + m2 g l2 (1 - cos q2)
//! M = [ (m1 + m2) l1²   B cos(q1 - q2) ;  B cos(q1 - q2)   m2 l2² ]         B = m2 l1 l2
//! ```
//!
//! q1, q2 are the angles of the two rods, each from the downward vertical (the second is not
//! counted from the first), p1, p2 the canonical momenta M q'. The potential energy is 0 where both
//! masses hang at rest.
//!
//! Parameters: masses m > 0 and lengths l > 0; gravity g in length/time² and friction c1, c2 in
//! mass length²/time, any finite numbers. c_j acts on the motion of rod j against the vertical, as
//! a medium around it would; friction in the joint between the rods would depend on v2 - v1, and is
//! not this. c_j ≥ 0 is passive in j, c_j < 0 active.
//!
//! M⁻¹ = [ M22  -M12 ; -M12  M11 ] / det M, and in det M = m2 l1² l2² (m1 + m2 sin²(q1 - q2)) > 0
//! nothing cancels. The rest follows from M v = p, differentiated: with X = B sin(q1 - q2) v1 v2
//! and u = B sin(q1 - q2) M⁻¹ (v2, v1),
//!
//! ```text
//! ∂H/∂q = (X + (m1 + m2) g l1 sin q1,  -X + m2 g l2 sin q2)        ∂v/∂q1 = -∂v/∂q2 = u
//! ∂X/∂q1 = -∂X/∂q2 = B [cos(q1 - q2) v1 v2 + sin(q1 - q2) (u1 v2 + v1 u2)]
//! ```
//!
//! Invariants: K = H + w1 + w2; H itself at c = 0, and p1 + p2 too if g = 0. H is not separable,
//! and the motion can be chaotic. There is no closed solution: references come from
//! `tests/data/many_degrees.py`, made by another library from Lagrange's equations, and from
//! [`afterbay_core::taylor::trajectory`].

mod phase_plane;

use crate::family::{BY_SERIES, Family, Parameter, exactly};
use crate::{finite, not_negative, positive};
use afterbay_core::{
    Abilities, Block, Coupling, Curvature, DissipationForm, InputError, Passive, PhasePlane,
    Scalar, SecondDerivatives, System,
};
use std::sync::Arc;

/// Two point masses m on rods of length l under gravity g, with D_j = c_j q_j'.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DampedDoublePendulum<T> {
    m: [T; 2],
    l: [T; 2],
    g: T,
    c: [T; 2],
}

/// The coefficients of the kinetic energy in a configuration, and the velocities.
struct Motion<T> {
    /// B sin(q1 - q2) and B cos(q1 - q2)
    arm: [T; 2],
    /// M⁻¹: its diagonal, and the entry beside it.
    diagonal: [T; 2],
    beside: T,
    /// v = M⁻¹ p
    v: [T; 2],
}

impl<T: Scalar> Motion<T> {
    /// u_j = ∂v_j/∂q1 = -∂v_j/∂q2
    #[inline(always)]
    fn by_angle(&self, j: usize) -> T {
        self.arm[0] * self.diagonal[j].mul_add(self.v[1 - j], self.beside * self.v[j])
    }
}

impl<T: Scalar> DampedDoublePendulum<T> {
    /// The pendulum of masses m1, m2 on rods l1, l2 under gravity g, with friction c1, c2.
    ///
    /// # Errors
    /// [`InputError::Parameter`] if a mass or a length is not positive, or anything not finite.
    pub fn new(m: [T; 2], l: [T; 2], g: T, c: [T; 2]) -> Result<Self, InputError> {
        Ok(Self {
            m: [positive("m1", m[0])?, positive("m2", m[1])?],
            l: [positive("l1", l[0])?, positive("l2", l[1])?],
            g: finite("g", g)?,
            c: [finite("c1", c[0])?, finite("c2", c[1])?],
        })
    }

    /// The system in another scalar.
    pub fn map<U: Scalar>(&self, f: impl Fn(T) -> U) -> DampedDoublePendulum<U> {
        DampedDoublePendulum {
            m: self.m.map(&f),
            l: self.l.map(&f),
            g: f(self.g),
            c: self.c.map(&f),
        }
    }

    /// The weight below each joint times the rod: (m1 + m2) g l1 and m2 g l2.
    #[inline(always)]
    fn weight(&self) -> [T; 2] {
        [(self.m[0] + self.m[1]) * self.g * self.l[0], self.m[1] * self.g * self.l[1]]
    }

    /// The motion at (q, p).
    #[inline(always)]
    fn motion(&self, q: &[T], p: &[T]) -> Motion<T> {
        let ([m1, m2], [l1, l2]) = (self.m, self.l);
        let (sin, cos) = (q[0] - q[1]).sin_cos();
        let (lever, total) = (m2 * l1 * l2, m1 + m2);
        let arm = [lever * sin, lever * cos];
        let inverse = ((m2 * sin).mul_add(sin, m1) * (lever * l1 * l2)).recip();
        let diagonal = [m2 * l2 * l2 * inverse, total * l1 * l1 * inverse];
        let beside = -(arm[1] * inverse);
        let v = [0, 1].map(|j| diagonal[j].mul_add(p[j], beside * p[1 - j]));
        Motion { arm, diagonal, beside, v }
    }
}

impl<T: Scalar> System<T> for DampedDoublePendulum<T> {
    #[inline(always)]
    fn dof(&self) -> usize {
        2
    }

    /// With 1 - cos x = 2 sin²(x/2), so that a pendulum nearly at rest keeps its digits.
    #[inline(always)]
    fn energy(&self, q: &[T], p: &[T]) -> T {
        let Motion { v, .. } = self.motion(q, p);
        let [s1, s2] = [q[0], q[1]].map(|q| q.half().sin_cos().0);
        let [weight1, weight2] = self.weight().map(|weight| weight + weight);
        (p[0] * v[0] + p[1] * v[1]).half() + (weight1 * (s1 * s1) + weight2 * (s2 * s2))
    }

    #[inline(always)]
    fn gradient(&self, q: &[T], p: &[T], hq: &mut [T], hp: &mut [T]) {
        let Motion { arm, v, .. } = self.motion(q, p);
        let [weight1, weight2] = self.weight();
        let whirl = arm[0] * v[0] * v[1];
        hq[0] = weight1.mul_add(q[0].sin_cos().0, whirl);
        hq[1] = weight2.mul_add(q[1].sin_cos().0, -whirl);
        (hp[0], hp[1]) = (v[0], v[1]);
    }

    #[inline(always)]
    fn dissipation(&self, _q: &[T], _p: &[T], v: &[T], d: &mut [T]) {
        (d[0], d[1]) = (self.c[0] * v[0], self.c[1] * v[1]);
    }

    /// D_j depends on both momenta, so it is linear only where there is none.
    #[inline(always)]
    fn dissipation_form(&self) -> DissipationForm {
        let passive = self.c.into_iter().all(not_negative);
        let zero = passive && self.c.into_iter().all(|c| not_negative(-c));
        DissipationForm { zero, passive: Passive::each_if(passive), linear: zero, coupled: false }
    }

    #[inline(always)]
    fn coupling(&self) -> Coupling {
        Coupling::Dense
    }
}

impl<T: Scalar> Curvature<T> for DampedDoublePendulum<T> {
    #[inline]
    fn curvature(&self, q: &[T], p: &[T], mut put: impl FnMut(Block, usize, usize, T)) {
        let (motion, weight) = (self.motion(q, p), self.weight());
        let u = [0, 1].map(|j| motion.by_angle(j));
        let Motion { arm: [sin, cos], diagonal, beside, v } = motion;
        let whirl = (cos * v[0]).mul_add(v[1], sin * (u[0] * v[1] + v[0] * u[1]));
        for i in 0..2 {
            for j in 0..2 {
                let (hqq, inverse) = if i == j {
                    (weight[i].mul_add(q[i].sin_cos().1, whirl), diagonal[i])
                } else {
                    (-whirl, beside)
                };
                // ∂v_j/∂q_i, and ∂v_i/∂q_j
                let (hqp, hpq) =
                    (if i == 0 { u[j] } else { -u[j] }, if j == 0 { u[i] } else { -u[i] });
                put(Block::Hqq, i, j, hqq);
                put(Block::Hqp, i, j, hqp);
                put(Block::Hpp, i, j, inverse);
                put(Block::Dq, i, j, self.c[i] * hpq);
                put(Block::Dp, i, j, self.c[i] * inverse);
            }
        }
    }
}

impl<T: Scalar> Abilities<T> for DampedDoublePendulum<T> {
    fn phase_planes(self: Arc<Self>) -> Option<Arc<dyn PhasePlane<T>>> {
        Some(self)
    }

    fn second_derivatives(self: Arc<Self>) -> Option<Arc<dyn SecondDerivatives<T>>> {
        Some(self)
    }
}

impl Family for DampedDoublePendulum<f64> {
    type Of<T: Scalar> = DampedDoublePendulum<T>;

    const NAME: &'static str = "damped-double-pendulum";
    const EQUATIONS: &'static str = "H = p·M(q)⁻¹p/2 + V(q), not separable, D_j = c_j ∂H/∂p_j";
    const PARAMETERS: &'static [Parameter] = &[
        Parameter::new("m1", "mass"),
        Parameter::new("m2", "mass"),
        Parameter::new("l1", "length"),
        Parameter::new("l2", "length"),
        Parameter::new("g", "length/time²"),
        Parameter::new("c1", "mass length²/time"),
        Parameter::new("c2", "mass length²/time"),
    ];
    const RANGES: &'static str = "m1, m2, l1, l2 > 0";
    const SOLUTION: &'static str = BY_SERIES;
    const DOF: Option<usize> = Some(2);
    const PERIOD: Option<f64> = Some(std::f64::consts::TAU);

    fn make<T: Scalar>(_n: usize, parameters: &[T]) -> Result<DampedDoublePendulum<T>, InputError> {
        let [m1, m2, l1, l2, g, c1, c2] = exactly(parameters)?;
        DampedDoublePendulum::new([m1, m2], [l1, l2], g, [c1, c2])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_have_their_range() {
        let nan = f64::NAN;
        let refused = |m, l, g, c| match DampedDoublePendulum::new(m, l, g, c) {
            Err(InputError::Parameter { name, .. }) => name,
            other => panic!("{other:?}"),
        };
        let one = [1.0; 2];
        assert_eq!(refused([0.0, 1.0], one, 9.81, one), "m1");
        assert_eq!(refused([1.0, nan], one, 9.81, one), "m2");
        assert_eq!(refused(one, [-1.0, 1.0], 9.81, one), "l1");
        assert_eq!(refused(one, [1.0, f64::INFINITY], 9.81, one), "l2");
        assert_eq!(refused(one, one, nan, one), "g");
        assert_eq!(refused(one, one, 9.81, [nan, 1.0]), "c1");
        assert_eq!(refused(one, one, 9.81, [0.0, nan]), "c2");
    }

    #[test]
    fn it_is_passive_if_both_rods_are() {
        let damping =
            |c| DampedDoublePendulum::new([1.0; 2], [1.0; 2], 9.81, c).unwrap().dissipation_form();
        assert_eq!(damping([0.0, -0.0]), DissipationForm::NONE);
        assert_eq!(
            damping([0.0, 0.1]),
            DissipationForm { passive: Passive::Each, ..DissipationForm::GENERAL }
        );
        assert_eq!(damping([0.1, -0.1]), DissipationForm::GENERAL);
    }

    #[test]
    fn energy_is_counted_from_rest() {
        let system = DampedDoublePendulum::new([2.0, 3.0], [0.5, 0.25], 8.0, [0.0; 2]).unwrap();
        assert_eq!(system.energy(&[0.0; 2], &[0.0; 2]), 0.0);
        let pi = std::f64::consts::PI;
        assert_eq!(system.energy(&[pi, 0.0], &[0.0; 2]), 2.0 * 5.0 * 8.0 * 0.5);
        assert_eq!(system.energy(&[0.0, pi], &[0.0; 2]), 2.0 * 3.0 * 8.0 * 0.25);
        // V is proportional to q², where 1 - cos q would round to 0.
        assert_eq!(system.energy(&[1e-20, 0.0], &[0.0; 2]), 5.0 * 8.0 * 0.5 * 1e-40 / 2.0);
    }

    /// Rods at right angles do not feel each other: p = (m1 + m2) l1² v1 and m2 l2² v2.
    #[test]
    fn momenta_are_canonical() {
        let system = DampedDoublePendulum::new([2.0, 3.0], [0.5, 0.25], 0.0, [0.0; 2]).unwrap();
        let (mut hq, mut v) = ([0.0; 2], [0.0; 2]);
        system.gradient(&[std::f64::consts::FRAC_PI_2, 0.0], &[1.0, 1.0], &mut hq, &mut v);
        assert!((v[0] - 0.8).abs() < 1e-15 && (v[1] - 16.0 / 3.0).abs() < 1e-14, "{v:?}");
    }
}
