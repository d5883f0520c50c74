//! Sizes of the second derivatives of H, by which a rounding of (q, p) changes the forces and H.

use afterbay_core::{Block, Curvature, Scalar};

/// The largest absolute entries of H'' and ∂D at (q, p), block by block: each has units of its own.
pub(crate) struct SecondDerivatives {
    /// ∂²H/∂q∂q
    by_qq: f64,
    /// ∂D/∂q
    by_dq: f64,
    /// ∂²H/∂q∂p
    by_qp: f64,
    /// ∂D/∂p
    by_dp: f64,
    /// ∂²H/∂p∂p
    by_pp: f64,
}

impl SecondDerivatives {
    pub(crate) fn at<T: Scalar, S: Curvature<T> + ?Sized>(system: &S, q: &[T], p: &[T]) -> Self {
        let mut most = Self { by_qq: 0.0, by_dq: 0.0, by_qp: 0.0, by_dp: 0.0, by_pp: 0.0 };
        system.curvature(q, p, |block, _, _, entry| {
            let of_block = match block {
                Block::Hqq => &mut most.by_qq,
                Block::Hqp => &mut most.by_qp,
                Block::Hpp => &mut most.by_pp,
                Block::Dq => &mut most.by_dq,
                Block::Dp => &mut most.by_dp,
            };
            *of_block = of_block.max(entry.to_f64().abs());
        });
        most
    }

    /// The largest of all, whatever their units.
    pub(crate) fn largest(&self) -> f64 {
        let Self { by_qq, by_dq, by_qp, by_dp, by_pp } = *self;
        [by_qq, by_dq, by_qp, by_dp, by_pp].into_iter().fold(0.0, f64::max)
    }

    /// The largest |∂²H/∂q∂q|.
    pub(crate) fn of_potential(&self) -> f64 {
        self.by_qq
    }

    /// The changes of the velocities and of the forces by a rounding of q and p, times 1/ε, where
    /// |q| and |p| have these sizes.
    pub(crate) fn rounded(&self, [q, p]: [f64; 2]) -> [f64; 2] {
        let velocities = (self.by_pp * p).max(self.by_qp * q);
        let by_q = self.by_qq.max(self.by_dq) * q;
        [velocities, by_q.max(self.by_qp.max(self.by_dp) * p)]
    }
}

/// The largest |z_i ∂²H/∂z_i∂z_j z_j| at (q, p): an estimate of the terms that cancel inside H near
/// an equilibrium away from the origin. 0 where it overflows, since every error of K would be below
/// an infinite bound.
pub(crate) fn second_order<T: Scalar, S: Curvature<T> + ?Sized>(
    system: &S,
    q: &[T],
    p: &[T],
) -> f64 {
    let mut most = 0.0_f64;
    system.curvature(q, p, |block, i, j, entry| {
        let [a, b] = match block {
            Block::Hqq => [q[i], q[j]],
            Block::Hqp => [q[i], p[j]],
            Block::Hpp => [p[i], p[j]],
            Block::Dq | Block::Dp => return,
        };
        most = most.max((a * entry * b).to_f64().abs());
    });
    if most.is_finite() { most } else { 0.0 }
}
