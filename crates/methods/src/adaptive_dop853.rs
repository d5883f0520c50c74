//! DOP853 with step size control, and K exact after every step.
//!
//! The twelve stages of order 8, with error estimates from embedded weights of order 5 and 3,
//! combined as `e₅²/√(e₅² + e₃²/100)`: E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary
//! Differential Equations I, II.5 and II.10. The step, its error control and the projection onto K
//! are those of [`crate::adaptive_explicit`].
//!
//! The order in q, p and w is 8, also between steps. Two weights are negative, so the method is not
//! passive. The stability region contains the half disc |hλ| < 5.96, Re λ ≤ 0, the largest of the
//! explicit methods here per evaluation: where the fastest frequency limits the steps, as on long
//! chains, no other is cheaper. For stiff systems use [`crate::AdaptiveRadau`].
//!
//! A run **fails** with the last accepted state, and reports the
//! [`StepFailure`](afterbay_core::StepFailure) of the shortest step tried, or `Vanishes`.

use crate::adaptive_explicit::adaptive_explicit;
use crate::runge_kutta::Dop853;

/// DOP853 for [`afterbay_core::integrate_within`] and [`afterbay_core::sample_within`], projected
/// onto the initial value of K.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AdaptiveDop853;

adaptive_explicit!(AdaptiveDop853, Dop853);
