//! The coordinate-increment discrete gradient (T. Itoh, K. Abe, J. Comput. Phys. 76 (1988) 85-102)
//! with a vector reservoir, for N degrees of freedom.
//!
//! The coordinates are updated one after the other. Each moves along one edge of the box spanned by
//! the old and the new state:
//!
//! ```text
//! q1_j - q0_j = h p̄_j/m_j        p1_j - p0_j = -h (ΔV_j/Δq_j + D̄_j)
//! w1_j - w0_j = h D̄_j p̄_j/m_j
//! ΔV_j = V(q1_1 .. q1_j, q0_{j+1} ..) - V(q1_1 .. q1_{j-1}, q0_j ..)
//! D̄_j = D_j at the midpoint of the edge and p̄_j
//! ```
//!
//! The ΔV_j sum to V(q1) - V(q0), so K is exact for any step size, any N and any D. Each equation
//! is scalar: no linear algebra is needed, and a sweep costs O(N) if V couples neighbours only. One
//! sweep has order 1. Its adjoint is the sweep in reversed order. Half a step of each gives a
//! symmetric method of order 2; [`Composition`]s of these have higher orders. The method is passive
//! where D is, as long as no substep runs backwards in time; beyond order 2 some substeps do.
//!
//! If D = C(q) p couples the momenta, friction acts between the sweeps; [`friction`] shows that
//! this conserves K, the orders, and passivity of Σ Δw_j, for D = R(q) ∂H/∂p with R symmetric or
//! not. Coupled D that is not linear in the momenta is refused, and so is an unsymmetric R with
//! more than 512 degrees of freedom.
//!
//! A step **solves** one scalar equation for each coordinate, that of [`crate::moddg`], to rounding
//! by Newton's method with continuation from h = 0. A half step of coupled friction takes one
//! division for each momentum, or an elimination where R is not symmetric.
//!
//! A step **fails** and leaves the state unchanged where
//! - a number is not finite ([`StepFailure::NonFinite`]);
//! - the equation of a coordinate is not solved (`NewtonStalled`, `SeveralSolutions`), or that of
//!   coupled friction is singular (`Singular`);
//! - V is singular on an edge (`AcrossSingularity`);
//! - divided differences by quadrature are not resolved (`EdgeUnresolved`) or lose K
//!   (`BalanceLost`).

pub(crate) mod before;
mod binding;
mod compensated;
mod composition;
mod driven;
mod friction;
mod general;
mod member;
mod sweep;

pub(crate) use binding::Increments;
pub use compensated::Compensated;
pub use composition::Composition;
pub use general::GeneralIncrement;
pub(crate) use member::{Member, Stride, advance};
pub(crate) use sweep::sweep;

use crate::balance::{Account, check_step, second_order_of_potential};
use crate::hidden_coupling::states_coupling;
use afterbay_core::{
    Effort, InputError, Method, Scalar, Separable, State, StepFailure, Vector, validate,
};
use before::Before;
use friction::Friction;
use sweep::largest_if_dense;

/// The coordinate-increment discrete gradient, a composition of forward and backward sweeps.
#[derive(Clone, Debug)]
pub struct Increment {
    composition: Composition,
    order: Option<Vec<usize>>,
}

impl Increment {
    /// Uses `composition` with the coordinates in their natural order.
    pub fn new(composition: Composition) -> Self {
        Self { composition, order: None }
    }

    /// Updates the coordinates in the given order, for instance coloured
    /// ([`afterbay_core::Coupling::coloured`]). `order` must contain each of 0 to N - 1 exactly
    /// once; [`Method::workspace`] refuses others.
    pub fn in_order(self, order: Vec<usize>) -> Self {
        Self { order: Some(order), ..self }
    }

    /// Returns the compensated method, whose rounding errors do not accumulate over long runs.
    /// `exact` is the same system in [`afterbay_core::Corrected`] numbers, for instance
    /// `system.map(Corrected::from)`.
    pub fn compensated<P>(self, exact: P) -> Compensated<P> {
        Compensated::new(self, exact)
    }
}

/// The state before the step, the order of the coordinates, and the memory for coupled friction.
#[derive(Clone, Debug)]
pub struct Workspace<V: Vector> {
    before: Before<V>,
    order: Vec<usize>,
    /// The first motor of a driven system, or N.
    first_motor: usize,
    /// Present if friction couples the momenta.
    friction: Option<Friction<V>>,
}

impl<V, S> Method<V, S> for Increment
where
    V: Vector,
    S: Separable<V::Scalar> + ?Sized,
{
    type Workspace = Workspace<V>;

    fn workspace(&self, system: &S) -> Result<Workspace<V>, InputError> {
        validate::masses(system)?;
        states_coupling("increment", system, true)?;
        let n = system.dof();
        let order = ordering("increment", self.order.as_ref(), n)?;
        let (first_motor, friction) = (n - system.motors(), Friction::new(system)?);
        Ok(Workspace { before: Before::new(n), order, first_motor, friction })
    }

    #[inline(always)]
    fn is_memoryless(&self) -> bool {
        true
    }

    #[inline(always)]
    fn refuses_singularities(&self) -> bool {
        true
    }

    #[inline]
    fn step(
        &self,
        system: &S,
        h: V::Scalar,
        state: &mut State<V>,
        workspace: &mut Workspace<V>,
    ) -> Result<Effort, StepFailure> {
        let Workspace { before, order, first_motor, friction } = workspace;
        let first_motor = *first_motor;
        let sweeps = |state: &mut State<V>| {
            let largest_q = largest_if_dense(&system.coupling(), state.q.as_slice());
            let mut effort = Effort::default();
            for (i, fraction) in self.composition.fractions::<V::Scalar>().enumerate() {
                let stride = Stride { h: fraction * h, largest_q };
                let (there, back) = (order.iter().copied(), order.iter().rev().copied());
                effort += match (friction.as_mut(), i % 2) {
                    (None, 0) => sweep(system, stride, first_motor, state, there)?,
                    (None, _) => sweep(system, stride, first_motor, state, back)?,
                    (Some(friction), 0) => {
                        with_friction(system, stride, first_motor, state, friction, there, back)?
                    }
                    (Some(friction), _) => {
                        with_friction(system, stride, first_motor, state, friction, back, there)?
                    }
                };
            }
            Ok(effort.shared_by(order.len()))
        };
        before.attempt_and(state, sweeps, |before, after| balanced(system, before, after))
    }
}

/// Checks K over a step of a system whose edges are not exact.
#[inline(always)]
pub(crate) fn balanced<T: Scalar, S: Separable<T> + ?Sized>(
    system: &S,
    before: [&[T]; 3],
    after: [&[T]; 3],
) -> Result<(), StepFailure> {
    if system.has_exact_divided_differences() {
        return Ok(());
    }
    let account = |q: &[T], p: &[T]| {
        let energy = system.energy(q, p);
        let moving = p[..p.len() - system.motors()].iter().enumerate();
        let kinetic = moving.fold(T::zero(), |sum, (j, &p)| sum + p * p / system.mass(j));
        Account { energy, size: kinetic + energy.abs() }
    };
    let second_order = || second_order_of_potential(system, [before[0], after[0]], before[1]);
    check_step(before, after, account, second_order)
}

/// The given order, or the natural one.
fn ordering(
    method: &'static str,
    order: Option<&Vec<usize>>,
    n: usize,
) -> Result<Vec<usize>, InputError> {
    let order = order.cloned().unwrap_or_else(|| (0..n).collect());
    let mut sorted = order.clone();
    sorted.sort_unstable();
    if !sorted.into_iter().eq(0..n) {
        let why = "the order of the coordinates must contain each of them exactly once";
        return Err(InputError::Unsupported { method, why });
    }
    Ok(order)
}

/// Takes a sweep between two half steps of friction. The first half step visits the momenta in the
/// order `there`, the second in the order `back`.
fn with_friction<V, S>(
    system: &S,
    stride: Stride<V::Scalar>,
    first_motor: usize,
    state: &mut State<V>,
    friction: &mut Friction<V>,
    there: impl Iterator<Item = usize> + Clone,
    back: impl Iterator<Item = usize>,
) -> Result<Effort, StepFailure>
where
    V: Vector,
    S: Separable<V::Scalar> + ?Sized,
{
    friction.pass(system, stride.h.half(), state, there.clone())?;
    let effort = sweep(system, stride, first_motor, state, there)?;
    friction.pass(system, stride.h.half(), state, back)?;
    Ok(effort)
}
