//! What a system tells of itself: a small trait every system has, and abilities some have.

use crate::{Coupling, Mask, Scalar, edge};

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
    fn damping(&self) -> Damping {
        Damping::GENERAL
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

    /// Whether H may be singular where (q, p) is finite. Only then are steps examined by
    /// [`System::is_singular_between`].
    #[inline(always)]
    fn may_be_singular(&self) -> bool {
        false
    }

    /// Whether H is singular somewhere on the straight line between two points of the coordinates.
    ///
    /// A method that keeps K can step across a pole and keep K there. The time loops refuse a step
    /// whose ends have a singularity between them ([`crate::StepFailure::AcrossSingularity`]).
    #[inline(always)]
    fn is_singular_between(&self, _from: &[T], _to: &[T]) -> bool {
        false
    }
}

/// What is known of the dissipative force D for all (q, p).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Damping {
    /// D = 0: there is no reservoir to keep.
    pub zero: bool,
    /// Where the reservoir only fills, whatever the state.
    pub passive: Passive,
    /// D is linear in p. Where it is not coupled, D_j = γ_j(q) p_j, and `by_p` of [`Separable::drag`] is γ_j.
    pub linear: bool,
    /// D_j may depend on the momenta of others, as in D = C p.
    pub coupled: bool,
}

/// Where Δw ≥ 0 is owed: it is where D = R(q, p) ∂H/∂p with R positive semidefinite.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Passive {
    /// Nowhere: the system is active, or nothing is known.
    No,
    /// In the sum over the degrees of freedom, Σ D_j ∂H/∂p_j ≥ 0.
    InSum,
    /// In each of them, D_j ∂H/∂p_j ≥ 0: R is diagonal.
    Each,
}

impl Passive {
    /// In each degree of freedom if it is `true`, else nowhere.
    pub fn each_if(passive: bool) -> Self {
        if passive { Self::Each } else { Self::No }
    }

    /// Does a step that takes the reservoir from `before` to `after` violate passivity? This is the
    /// one definition of a violation: Σ_j Δw_j < 0 where R is positive semidefinite, and any
    /// Δw_j < 0 where R is diagonal as well.
    ///
    /// A step adds to w_j a few times, and each sum is rounded. So Δw_j counts as negative where it
    /// is below -4 u (|w_j before| + |w_j after|), with u the unit roundoff, and the sum over j
    /// where it is below the sum of these.
    #[inline]
    pub fn violated<T: Scalar>(self, before: &[T], after: &[T]) -> T::Mask {
        let rounding = T::from_f64(4.0 * T::EPSILON);
        let never = T::one().lt(T::zero());
        let (mut sum, mut noise, mut fallen) = (T::zero(), T::zero(), never);
        for (&before, &after) in before.iter().zip(after) {
            let (change, bound) = (after - before, rounding * (after.abs() + before.abs()));
            fallen = fallen.or(change.lt(-bound));
            sum += change;
            noise += bound;
        }
        match self {
            Self::No => never,
            Self::InSum => sum.lt(-noise),
            Self::Each => fallen.or(sum.lt(-noise)),
        }
    }
}

impl Damping {
    /// Nothing is known.
    pub const GENERAL: Self = Self { zero: false, passive: Passive::No, linear: false, coupled: false };
    /// D_j = γ_j(q) p_j, active.
    pub const LINEAR: Self = Self { linear: true, ..Self::GENERAL };
    /// D = 0.
    pub const NONE: Self = Self { zero: true, passive: Passive::Each, linear: true, coupled: false };
}

/// H = Σ p_j²/(2 m_j) + V(q), and D_j depending on no momentum but p_j unless [`Damping::coupled`] is said.
pub trait Separable<T: Scalar>: System<T> {
    /// m_j > 0
    #[inline(always)]
    fn mass(&self, _j: usize) -> T {
        T::one()
    }

    /// ∂V/∂q_j at the point q with its coordinate j moved to `at`.
    fn partial(&self, q: &[T], j: usize, at: T) -> T;

    /// The mean of ∂V/∂q_j along the edge from q to the point with coordinate j moved to `to`,
    /// `[V(.., to, ..) - V(q)] / (to - q_j)` without its cancellation, and its derivative by `to`.
    ///
    /// The default integrates [`Separable::partial`] by Gauss-Legendre quadrature ([`edge::by_quadrature`]), on
    /// parts of the edge where it must, and is NaN where these do not resolve it. Where V is written for
    /// every scalar, [`edge::of_potential`] is exact and faster, and [`crate::FromFormulas`] uses it
    /// unasked. Give that or a closed form where there is one, and say so in [`Separable::has_exact_edges`].
    #[inline]
    fn edge(&self, q: &[T], j: usize, to: T) -> Line<T> {
        edge::by_quadrature(q[j], to, |at| self.partial(q, j, at))
    }

    /// Is [`Separable::edge`] exact to roundings on every edge? Where it is not, as by default, the
    /// methods that rest on it compare K before and after each step: give the energy without cancellation.
    #[inline(always)]
    fn has_exact_edges(&self) -> bool {
        false
    }

    /// Whether V is singular between q and the point with coordinate j moved to `to`. An exact mean
    /// keeps K even across a pole, so only this refuses a step that leads there. It is asked where
    /// [`System::may_be_singular`].
    #[inline(always)]
    fn is_singular_along(&self, _q: &[T], _j: usize, _to: T) -> bool {
        false
    }

    /// D_j at (q, p) with its derivatives by q_j and p_j. The derivatives steer Newton's iteration and need not be exact,
    /// but for `by_p` where [`Damping::linear`] is claimed: it then stands for D itself.
    fn drag(&self, q: &[T], p: &[T], j: usize) -> Drag<T>;
}

/// V = ½ Σ k_ij q_i q_j, m_j = 1 and D_j = b_j p_j: the flow is linear, and an implicit step has a closed form.
pub trait Linear<T: Scalar>: Separable<T> {
    /// k_ij = k_ji
    fn stiffness(&self, i: usize, j: usize) -> T;
    /// b_j
    fn friction(&self, j: usize) -> T;
}

/// A function of one variable at a point: its value and its slope.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line<T> {
    /// f(x)
    pub value: T,
    /// f'(x)
    pub slope: T,
}

/// The dissipative force on one degree of freedom, and how it changes with that degree of freedom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drag<T> {
    /// D_j
    pub value: T,
    /// ∂D_j/∂q_j
    pub by_q: T,
    /// ∂D_j/∂p_j
    pub by_p: T,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn violated(passive: Passive, before: [f64; 2], after: [f64; 2]) -> bool {
        passive.violated(&before, &after)
    }

    #[test]
    fn a_violation_is_a_fall_of_the_sum_or_of_one_entry_where_each_only_fills() {
        // Both rise; one falls and the sum rises; one falls and the sum with it; both fall.
        let steps = [[1.0, 1.0], [-0.5, 1.0], [0.5, -1.0], [-0.1, -0.1]];
        let by = |passive| steps.map(|[a, b]| violated(passive, [2.0, 3.0], [2.0 + a, 3.0 + b]));
        assert_eq!(by(Passive::Each), [false, true, true, true]);
        assert_eq!(by(Passive::InSum), [false, false, true, true]);
        assert_eq!(by(Passive::No), [false; 4]);
    }

    #[test]
    fn a_rounding_of_w_is_no_violation() {
        let u = f64::EPSILON / 2.0;
        for passive in [Passive::Each, Passive::InSum] {
            assert!(!violated(passive, [1.0, 3.0], [1.0 - 4.0 * u, 3.0 - 8.0 * u]));
            assert!(violated(passive, [1.0, 3.0], [1.0 - 40.0 * u, 3.0]));
            // From an empty reservoir nothing can be rounded away.
            assert!(violated(passive, [0.0, 0.0], [-1e-300, 0.0]));
        }
    }
}
