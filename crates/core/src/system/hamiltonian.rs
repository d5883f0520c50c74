//! The trait that every system implements.

use super::coupling::Coupling;
use super::dissipation::DissipationForm;
use crate::error::InputError;
use crate::numbers::Scalar;

/// A Hamiltonian system with N degrees of freedom and a dissipative force,
/// `q' = ∂H/∂p, p' = -∂H/∂q - D(q,p)`.
///
/// The interface has no t. Forces that depend on time are added by a [`crate::Drive`]; where V and
/// D depend on it, the time is a coordinate ([`crate::Clocked`]).
///
/// All slices have length N, the number of degrees of freedom. The N of a driven system includes
/// its motors ([`System::motors`]).
pub trait System<T: Scalar>: Send + Sync {
    /// N, the number of degrees of freedom, motors included.
    fn dof(&self) -> usize;

    /// Checks what a run needs at every state, such as masses. The time loops call it before the
    /// first step. The default accepts all.
    ///
    /// # Errors
    /// An [`InputError`] that names what is invalid.
    #[inline]
    fn check(&self) -> Result<(), InputError> {
        Ok(())
    }

    /// H(q, p)
    fn energy(&self, q: &[T], p: &[T]) -> T;

    /// Writes ∂H/∂q to `hq` and ∂H/∂p to `hp`.
    fn gradient(&self, q: &[T], p: &[T], hq: &mut [T], hp: &mut [T]);

    /// Writes D(q, p) to `d`, given the velocities v = ∂H/∂p at (q, p).
    ///
    /// Compute D = R(q, p) v from v. A discrete gradient passes its own mean velocity, so that
    /// `D·v = vᵀ R v ≥ 0` holds for a step as it does for the system.
    fn dissipation(&self, q: &[T], p: &[T], v: &[T], d: &mut [T]);

    /// Whether methods call [`System::gradients`] and [`System::dissipations`] instead of one point
    /// after another. Override the three together, where one of them is faster at several points;
    /// a batch has two to eight.
    #[inline(always)]
    fn has_batches(&self) -> bool {
        false
    }

    /// Writes the gradient at `(q[i], p[i])` to `hq[i]` and `hp[i]`: the same bits as
    /// [`System::gradient`]. The outer slices have one entry a point, the inner ones length N.
    fn gradients(&self, q: &[&[T]], p: &[&[T]], hq: &mut [&mut [T]], hp: &mut [&mut [T]]) {
        for ((q, p), (hq, hp)) in q.iter().zip(p).zip(hq.iter_mut().zip(hp)) {
            self.gradient(q, p, hq, hp);
        }
    }

    /// Writes D at `(q[i], p[i], v[i])` to `d[i]`: the same bits as [`System::dissipation`]. The
    /// outer slices have one entry a point, the inner ones length N.
    fn dissipations(&self, q: &[&[T]], p: &[&[T]], v: &[&[T]], d: &mut [&mut [T]]) {
        for ((q, p), (v, d)) in q.iter().zip(p).zip(v.iter().zip(d)) {
            self.dissipation(q, p, v, d);
        }
    }

    /// The properties of D that hold at every state. Methods omit work that these properties make
    /// unnecessary.
    #[inline(always)]
    fn dissipation_form(&self) -> DissipationForm {
        DissipationForm::GENERAL
    }

    /// Whether [`System::dissipation_form`] is found from the equations of D themselves. Methods
    /// that need D to couple no velocities compare the form of other systems with D.
    #[inline(always)]
    fn finds_dissipation_form(&self) -> bool {
        false
    }

    /// The degree of freedom that a motor drives; none for a clock.
    #[inline(always)]
    fn driven_by(&self, _motor: usize) -> Option<usize> {
        None
    }

    /// Whether H = Σ p_j²/2 + V(q), so that velocities equal momenta and need not be computed.
    #[inline(always)]
    fn unit_mass(&self) -> bool {
        false
    }

    /// The number of motors: those of a driven system ([`crate::Driven`]), and the clock of a
    /// system that depends on the time ([`crate::Clocked`]). They are the last degrees of freedom,
    /// and their velocity is 1, whatever their momentum.
    #[inline(always)]
    fn motors(&self) -> usize {
        0
    }

    /// Writes the force of each motor at q to its entry of `forces`, and returns whether the forces
    /// depend on the time alone. Stages at the same time then share them.
    #[inline(always)]
    fn motor_forces(&self, _q: &[T], _forces: &mut [T]) -> bool {
        true
    }

    /// Computes [`System::dissipation`] from the `forces` that [`System::motor_forces`] wrote at q.
    #[inline(always)]
    fn dissipation_under(&self, _forces: &[T], q: &[T], p: &[T], v: &[T], d: &mut [T]) {
        self.dissipation(q, p, v, d);
    }

    /// The pattern of degrees of freedom that act on each other.
    #[inline(always)]
    fn coupling(&self) -> Coupling {
        Coupling::Dense
    }

    /// Passes to `put` the value at (q, p) of every function at whose zeros ∇H or D may not be
    /// analytic, such as x of |x|. The functions and their order must be the same at all states.
    /// The default passes none: ∇H and D are analytic wherever they are defined. Taylor series are
    /// not continued across a zero.
    #[inline]
    fn kinks(&self, _q: &[T], _p: &[T], _put: &mut dyn FnMut(T)) {}

    /// Passes to `put` the functions of [`System::kinks`] that depend on more than the time.
    /// [`System::step_between_breaks`] ends no step at their zeros.
    #[inline]
    fn kinks_of_state(&self, q: &[T], p: &[T], put: &mut dyn FnMut(T)) {
        self.kinks(q, p, put);
    }

    /// The length of the next step from q, at most h > 0, without an instant at which D jumps in
    /// time or has a kink ([`crate::Drive::step_between_breaks`]).
    #[inline(always)]
    fn step_between_breaks(&self, _q: &[T], h: T) -> T {
        h
    }

    /// Whether V or D may jump or have a kink at an instant of the time. The time loop divides a
    /// fixed step there ([`System::step_between_breaks`]): the energy that V pumps jumps within
    /// such a step, and methods that keep K by a quadrature or a projection would fail. Breaks of
    /// the forces of a drive do not count, since every method keeps K across them.
    #[inline(always)]
    fn has_breaks(&self) -> bool {
        false
    }

    /// Whether H or D may be singular where (q, p) is finite. Only then are steps examined by
    /// [`System::is_singular_between`].
    #[inline(always)]
    fn may_be_singular(&self) -> bool {
        false
    }

    /// Whether H, D or the force of a drive is singular somewhere on the straight line between two
    /// points of the coordinates.
    ///
    /// A method that keeps K can step across a pole and keep K there. The time loops refuse a step
    /// whose ends have a singularity between them ([`crate::StepFailure::AcrossSingularity`]).
    #[inline(always)]
    fn is_singular_between(&self, _from: &[T], _to: &[T]) -> bool {
        false
    }
}
