//! What every system tells of itself.

use super::coupling::Coupling;
use super::dissipation::DissipationForm;
use crate::numbers::Scalar;

/// A Hamiltonian system with N degrees of freedom and a dissipative force,
/// `q' = ∂H/∂p, p' = -∂H/∂q - D(q,p)`.
///
/// The interface has no t. K = H + Σ w_j would be constant for D(q,p,t) as well, but not for H(q,p,t),
/// where K' = ∂H/∂t.
///
/// All slices have length N, the number of degrees of freedom.
pub trait System<T: Scalar>: Send + Sync {
    /// N
    fn dof(&self) -> usize;

    /// H(q, p)
    fn energy(&self, q: &[T], p: &[T]) -> T;

    /// Writes ∂H/∂q to `hq` and ∂H/∂p to `hp`.
    fn gradient(&self, q: &[T], p: &[T], hq: &mut [T], hp: &mut [T]);

    /// Writes D(q, p) to `d`, given the velocities v = ∂H/∂p at (q, p).
    ///
    /// Where D is friction, D = R(q, p) v, compute it from v: a discrete gradient puts its own mean velocity in its place,
    /// and `D·v = vᵀ R v ≥ 0` then holds of the step as it does of the system.
    fn dissipation(&self, q: &[T], p: &[T], v: &[T], d: &mut [T]);

    /// What is known of D beforehand; methods take the shortest way it allows.
    #[inline(always)]
    fn dissipation_form(&self) -> DissipationForm {
        DissipationForm::GENERAL
    }

    /// Is H = Σ p_j²/2 + V(q)? Velocities are then momenta, and need not be computed.
    #[inline(always)]
    fn unit_mass(&self) -> bool {
        false
    }

    /// Who acts on whom.
    #[inline(always)]
    fn coupling(&self) -> Coupling {
        Coupling::Dense
    }

    /// Gives `put` numbers at (q, p) between whose zeros ∇H and D are analytic: x where |x| is in them. None, where they are
    /// analytic wherever they are defined. Taylor series are not carried across a zero.
    #[inline]
    fn kinks(&self, _q: &[T], _p: &[T], _put: &mut dyn FnMut(T)) {}
}
