//! Collocation with step size control, and K exact after every step.
//!
//! Gauss collocation with K nodes τ_i, weights b_i and `a_ij = ∫_0^{τ_i} ℓ_j`,
//!
//! ```text
//! v = ∂H/∂p        f = ∂H/∂q + D(q, p, v)
//! p_i = p0 - h Σ_j a_ij f_j        q_i = q0 + h Σ_j a_ij v_j
//! p1 = p0 - h Σ b_i f_i            q1 = q0 + h Σ b_i v_i
//! w1 = w0 + h Σ b_i D(q_i, p_i, v_i) v_i
//! ```
//!
//! is solved by fixed-point sweeps until the remaining error is a tenth of that allowed for the
//! step. Then (q1, p1) is projected onto `H = H(q0, p0) - Σ Δw_j` along the gradient of H, scaled
//! by the tolerances. The projection is of the size of the error of the step. K is exact, and w is
//! not changed by the projection. Since the weights are positive, Δw ≥ 0 where the system is
//! passive. (Projection: E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration, IV.4.)
//! Steps that cannot be projected, near an equilibrium, and steps of stiff systems are taken by
//! [`crate::Collocation`], which conserves K without projection.
//!
//! The order in q, p and w is 8 (K = 4) for a relative tolerance above 1e-5, else 16 (K = 8), also
//! between steps: a sample is a step of its own from the beginning of the current step, with K
//! exact. The method is A-stable. Newton's method replaces the sweeps if these limit the step size
//! over many steps.
//!
//! A step aims at its share, by length, of the error allowed at the end. If errors neither decay
//! nor cancel, the error at the end equals the tolerance; if solutions converge, or errors cancel,
//! it is smaller, by a factor of a hundred or more. A step across a kink aims at the share of a
//! step of mean length.
//!
//! Steps do not allocate, with one exception: the first step that uses Newton's method, or is taken
//! near an equilibrium, allocates the workspace of [`crate::Collocation`]. Most runs never need it.
//!
//! A run **fails** with the last accepted state, and reports the
//! [`StepFailure`](afterbay_core::StepFailure) of the shortest step tried, or `Vanishes`.

mod engine;
mod estimate;
mod exact;
mod gauss;
mod initial_guess;
mod limits;
mod newton_estimate;
mod slopes;
mod stages;
mod stiffness;

use crate::adaptive::adaptive_of_orders;
use crate::linear::check_derivatives;
use afterbay_core::{Curvature, InputError, Quad, Tolerance, Vector};
use engine::Engine;
use gauss::Gauss;
use std::sync::LazyLock;

/// Adaptive collocation of order 8 or 16, depending on the tolerance, for
/// [`afterbay_core::integrate_within`] and [`afterbay_core::sample_within`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AdaptiveCollocation;

/// The least factor by which a step grows, since the matrix that continues the polynomial of a step
/// is kept as long as the step is. A choice.
const LEAST_GROWTH: f64 = 1.1;
/// The relative tolerance above which 4 nodes are used. A choice: there order 8 costs less.
const LEAST_COARSE_TOLERANCE: f64 = 1e-5;

static FOUR: LazyLock<Gauss<Quad, 4>> = LazyLock::new(Gauss::new);
static EIGHT: LazyLock<Gauss<Quad, 8>> = LazyLock::new(Gauss::new);

adaptive_of_orders!(AdaptiveCollocation, Engine, { Eight: 4, Sixteen: 8 }, LEAST_GROWTH);

impl<V: Vector> Order<V> {
    fn new<S>(system: &S, tolerance: &Tolerance, span: f64) -> Result<Self, InputError>
    where
        S: Curvature<V::Scalar> + ?Sized,
    {
        check_derivatives("adaptive-collocation", system)?;
        Ok(if tolerance.relative > LEAST_COARSE_TOLERANCE {
            Self::Eight(Box::new(Engine::new(system, &FOUR, tolerance, span)))
        } else {
            Self::Sixteen(Box::new(Engine::new(system, &EIGHT, tolerance, span)))
        })
    }
}
