//! Radau IIA with step size control, and K exact after every step.
//!
//! ```text
//! z = (q, p)        f = (∂H/∂p, -∂H/∂q - D)        v = ∂H/∂p        Z_i = z0 + h Σ_j a_ij f(Z_j)
//! z1 = Z_s          w1_j = w0_j + h Σ_i b_i D_j(Z_i) v_j(Z_i) + share of the defect of K
//! ```
//!
//! E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, IV.5 and IV.8; J. Comput.
//! Appl. Math. 111 (1999) 93-111. The order in q, p and w is 2s - 1, also between steps: a sample
//! is a step of its own from the beginning of the current step, with K exact. It is 5 (s = 3) for a
//! tolerance above 1e-3, 13 (s = 7) up to 1e-8, and 9 (s = 5) between; the smaller of the relative
//! tolerances of (q, p) and w counts.
//!
//! The defect of K, of the size of the error of the step, is divided by the estimated errors: w
//! takes the energy that a fast decay dissipates unresolved, and (q, p) is projected along ∇H by
//! the rest (`radau/balance.rs`). K is exact, and Δw ≥ 0 where the system is passive. On linear
//! passive systems H ≥ 0 then cannot grow at any h. The step before K is restored is L-stable. The
//! projection may return a part of the decayed energy; it is then as large as the error, and the
//! step is rejected.
//!
//! The equations are solved by Newton's method to the accuracy the tolerance requires
//! (`radau/solve.rs`), decoupled into systems of N unknowns, or 2N if H is not separable
//! (`linear/phase_space.rs`). Steps do not allocate, except where K differs only by rounding, near
//! rest.
//!
//! A run **fails** with the last accepted state, and reports the
//! [`StepFailure`](afterbay_core::StepFailure) of the shortest step tried, or `Vanishes`. Systems
//! whose dense matrix does not fit in memory are refused.

use crate::adaptive::adaptive_of_orders;
use crate::radau::{Engine, Tables};
use afterbay_core::{Curvature, InputError, Quad, Tolerance, Vector};
use std::sync::LazyLock;

/// Adaptive Radau IIA of order 5, 9 or 13, depending on the tolerance, for
/// [`afterbay_core::integrate_within`] and [`afterbay_core::sample_within`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AdaptiveRadau;

/// The relative tolerance above which order 5 is used. A choice: there it costs less.
const LEAST_OF_ORDER_5: f64 = 1e-3;
/// The relative tolerance above which order 9 is used, and below it order 13. A choice.
const LEAST_OF_ORDER_9: f64 = 1e-8;
/// The least factor by which a step grows with several degrees of freedom, since the factorised
/// matrices are kept as long as the step is. A choice.
const LEAST_GROWTH: f64 = 1.2;

static THREE_STAGES: LazyLock<Tables<Quad, 3>> = LazyLock::new(Tables::new);
static FIVE_STAGES: LazyLock<Tables<Quad, 5>> = LazyLock::new(Tables::new);
static SEVEN_STAGES: LazyLock<Tables<Quad, 7>> = LazyLock::new(Tables::new);

adaptive_of_orders!(AdaptiveRadau, Engine, { Five: 3, Nine: 5, Thirteen: 7 }, match V::LEN {
    Some(1) => 1.0,
    _ => LEAST_GROWTH,
});

impl<V: Vector> Order<V> {
    fn new<S>(system: &S, tolerance: &Tolerance, span: f64) -> Result<Self, InputError>
    where
        S: Curvature<V::Scalar> + ?Sized,
    {
        let relative = tolerance.relative.min(tolerance.w_relative);
        Ok(if relative > LEAST_OF_ORDER_5 {
            Self::Five(Box::new(Engine::new(system, &THREE_STAGES, tolerance, span)?))
        } else if relative > LEAST_OF_ORDER_9 {
            Self::Nine(Box::new(Engine::new(system, &FIVE_STAGES, tolerance, span)?))
        } else {
            Self::Thirteen(Box::new(Engine::new(system, &SEVEN_STAGES, tolerance, span)?))
        })
    }
}
