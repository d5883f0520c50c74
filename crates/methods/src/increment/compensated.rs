//! Coordinate increments with compensated rounding, for very long runs.
//!
//! A step of [`Increment`] changes K by a few roundings. On long steps these are correlated: the
//! rounding of q1 = q0 + h v/m and the force at the next step have a common bias, and K drifts in
//! proportion to time. This method computes
//!
//! ```text
//! v = p0 - F(v)                solved in f64, at the rounded state
//! ρ = p0 - v - F(v)            the residual, in corrected arithmetic at the carried state
//! v + ρ/(1 + F')               used in q1, p1 and w1, which are carried as sums of two f64
//! ```
//!
//! One correction squares the error of the equation, and ρ is accurate to 105 bits ([`Corrected`]),
//! so the carried state conserves K to that accuracy. The caller sees the carried state rounded to
//! f64, and its K differs by this one rounding. The carried remainders belong to the state that the
//! last step produced: if the given state differs from it in any entry, or in any lane, all
//! remainders are reset to 0.
//!
//! Sources: the carried state follows E. Hairer, R. I. McLachlan, A. Razakarivony, *Achieving
//! Brouwer's law with implicit Runge-Kutta methods*, BIT 48 (2008), where compensated summation
//! sufficed; here the equation itself must be solved accurately as well. The correction is
//! iterative refinement with the residual in higher precision (Wilkinson 1963; N. J. Higham,
//! *Accuracy and Stability of Numerical Algorithms*, chapter 12).
//!
//! A step fails where [`Increment`] fails, and where a correction is not small, since `exact` is
//! then not the same system.

use super::member::{Member, Stride, coordinate};
use super::sweep::largest_if_dense;
use super::{Before, Friction, Increment, ordering};
use crate::coordinate::{Edge, MomentumEquation};
use crate::hidden_coupling::states_coupling;
use afterbay_core::solver::{Equation, Newton, Root};
use afterbay_core::{
    Corrected, Effort, InputError, Lanewise, Mask, Method, Quantity, Scalar, Separable, State,
    StepFailure, Vector, validate,
};

/// The storage V with [`Corrected`] numbers as entries.
type InCorrected<V> = <V as Vector>::Of<Corrected<<V as Vector>::Scalar>>;

/// [`Increment`] with its equations refined in [`Corrected`] arithmetic.
#[derive(Clone, Debug)]
pub struct Compensated<P> {
    increment: Increment,
    exact: P,
}

impl<P> Compensated<P> {
    /// Combines the method with the same system in [`Corrected`] numbers.
    pub(super) fn new(increment: Increment, exact: P) -> Self {
        Self { increment, exact }
    }
}

/// The carried state, the state before the step, and the memory of the increments.
#[derive(Clone)]
pub struct Workspace<V: Vector>
where
    V::Scalar: Lanewise,
{
    carried: State<InCorrected<V>>,
    before: Before<InCorrected<V>>,
    order: Vec<usize>,
    /// Present if friction couples the momenta.
    friction: Option<Friction<InCorrected<V>>>,
}

/// The largest correction relative to the terms of the equation. A choice: the error that
/// [`Newton`] leaves is much smaller.
const LARGEST_CORRECTION: f64 = 1e-8;
/// The residual, in roundings, at which Newton's iteration may stop. The correction squares it:
/// 1e-12 becomes about 1e-24 times the second derivative of F.
const RESIDUAL_ROUNDINGS: f64 = 8192.0;

impl<V, S, P> Method<V, S> for Compensated<P>
where
    V: Vector,
    V::Scalar: Lanewise,
    S: Separable<V::Scalar> + ?Sized,
    P: Separable<Corrected<V::Scalar>>,
{
    type Workspace = Workspace<V>;

    fn workspace(&self, system: &S) -> Result<Workspace<V>, InputError> {
        let n = system.dof();
        if self.exact.dof() != n {
            let (quantity, found) = (Quantity::Coordinate, self.exact.dof());
            return Err(InputError::Length { quantity, expected: n, found });
        }
        if self.exact.dissipation_form() != system.dissipation_form() {
            let why = "the system in corrected numbers has a different kind of dissipation";
            return Err(InputError::Unsupported { method: "increment", why });
        }
        if system.motors() > 0 {
            let why = "compensated sums do not take a drive";
            return Err(InputError::Unsupported { method: "increment", why });
        }
        validate::masses(system)?;
        states_coupling("increment", system, true)?;
        validate::masses(&self.exact)?;
        let order = ordering("increment", self.increment.order.as_ref(), n)?;
        let zeros = || V::Of::<Corrected<V::Scalar>>::zeros(n);
        let carried = State { q: zeros(), p: zeros(), w: zeros(), t: Corrected::zero() };
        Ok(Workspace {
            carried,
            before: Before::new(n),
            order,
            friction: Friction::new(&self.exact)?,
        })
    }

    #[inline(always)]
    fn refuses_singularities(&self) -> bool {
        true
    }

    #[inline(always)]
    fn sums_reservoir(&self) -> bool {
        true
    }

    fn step(
        &self,
        system: &S,
        h: V::Scalar,
        state: &mut State<V>,
        workspace: &mut Workspace<V>,
    ) -> Result<Effort, StepFailure> {
        let Workspace { carried, before, order, friction } = workspace;
        take_up(carried, state);
        let outcome = before.attempt(carried, |carried| {
            let largest_q = largest_if_dense(&system.coupling(), state.q.as_slice());
            let mut effort = Effort::default();
            let fractions = self.increment.composition.fractions::<Corrected<V::Scalar>>();
            for (i, fraction) in fractions.enumerate() {
                let h = fraction * Corrected::exact(h);
                let (there, back) = (order.iter().copied(), order.iter().rev().copied());
                let states = (&mut *state, &mut *carried);
                effort += match i % 2 {
                    0 => {
                        self.travel(system, h, largest_q, states, friction.as_mut(), (there, back))?
                    }
                    _ => {
                        self.travel(system, h, largest_q, states, friction.as_mut(), (back, there))?
                    }
                };
            }
            Ok(effort.shared_by(order.len()))
        });
        // After a failed step this is the state before it.
        show(&carried.q, &mut state.q);
        show(&carried.p, &mut state.p);
        show(&carried.w, &mut state.w);
        outcome
    }
}

impl<P> Compensated<P> {
    /// Takes one sweep; if friction couples the momenta, between two half steps of friction that
    /// visit them in the orders `there` and `back`.
    fn travel<V, S>(
        &self,
        system: &S,
        h: Corrected<V::Scalar>,
        largest_q: V::Scalar,
        (state, carried): (&mut State<V>, &mut State<InCorrected<V>>),
        mut friction: Option<&mut Friction<InCorrected<V>>>,
        (there, back): (impl Iterator<Item = usize> + Clone, impl Iterator<Item = usize>),
    ) -> Result<Effort, StepFailure>
    where
        V: Vector,
        V::Scalar: Lanewise,
        S: Separable<V::Scalar> + ?Sized,
        P: Separable<Corrected<V::Scalar>>,
    {
        if let Some(friction) = &mut friction {
            friction.pass(&self.exact, h.half(), carried, there.clone())?;
            normalise(carried);
            show(&carried.p, &mut state.p);
        }
        let effort = self.sweep(system, h, largest_q, (state, carried), there)?;
        if let Some(friction) = friction {
            friction.pass(&self.exact, h.half(), carried, back)?;
            normalise(carried);
        }
        Ok(effort)
    }

    /// Updates every coordinate once, in the given order, and keeps q and p of `state` up to date.
    fn sweep<V, S>(
        &self,
        system: &S,
        h: Corrected<V::Scalar>,
        largest_q: V::Scalar,
        (state, carried): (&mut State<V>, &mut State<InCorrected<V>>),
        order: impl Iterator<Item = usize>,
    ) -> Result<Effort, StepFailure>
    where
        V: Vector,
        V::Scalar: Lanewise,
        S: Separable<V::Scalar> + ?Sized,
        P: Separable<Corrected<V::Scalar>>,
    {
        let damping = system.dissipation_form();
        let dissipative = !damping.zero && !damping.coupled;
        let (q, p) = (state.q.as_mut_slice(), state.p.as_mut_slice());
        let State { q: exact_q, p: exact_p, w, .. } = carried;
        let (exact_q, exact_p, w) =
            (exact_q.as_mut_slice(), exact_p.as_mut_slice(), w.as_mut_slice());
        let mut evaluations = 0;
        for j in order {
            let member = Member { index: j, dof: j };
            let stride = Stride { h: h.nearest(), largest_q };
            let rough = coordinate(system, stride, member, [q, p], dissipative);
            let mut edge = Edge { system, j, q: &mut *q, p: &mut *p };
            let equation = MomentumEquation { coordinate: &rough, edge: &mut edge };
            let root = Newton::nearly(j, rough.p, equation, RESIDUAL_ROUNDINGS)?;
            let stride = Stride { h, largest_q: Corrected::exact(largest_q) };
            let exact = coordinate(&self.exact, stride, member, [exact_q, exact_p], dissipative);
            let mut edge = Edge { system: &self.exact, j, q: &mut *exact_q, p: &mut *exact_p };
            let root = refined(MomentumEquation { coordinate: &exact, edge: &mut edge }, root)?;
            let moved = exact.moved(root, edge);
            (exact_q[j], exact_p[j]) = (moved.q.normalised(), moved.p.normalised());
            let to = exact_q[j].nearest();
            if system.may_be_singular() && system.is_singular_along(q, j, to) {
                let (from, to) = (q[j].to_f64(), to.to_f64());
                return Err(StepFailure::AcrossSingularity { dof: j, from, to });
            }
            (q[j], p[j]) = (exact_q[j].nearest(), exact_p[j].nearest());
            if dissipative {
                w[j] = (w[j] + moved.dw).normalised();
            }
            evaluations += moved.evaluations;
        }
        Ok(Effort { evaluations, iterations: evaluations })
    }
}

/// The solution of the equation in corrected numbers, starting from the solution in f64.
#[inline(always)]
fn refined<T: Lanewise, P: Separable<Corrected<T>>>(
    mut equation: MomentumEquation<'_, '_, Corrected<T>, P>,
    root: Root<T>,
) -> Result<Root<Corrected<T>>, StepFailure> {
    let v = Corrected::exact(root.x);
    let (coordinate, at_v) = (equation.coordinate, equation.at(Corrected::one(), v));
    let residual = (coordinate.p - v - at_v.value).nearest();
    let inverse = (T::one() + at_v.slope.rounded()).recip();
    let correction = residual * inverse;
    let sizes = coordinate.p.nearest().abs() + at_v.value_rounding.rounded();
    let enters = sizes.mul_add(inverse.abs(), root.x.abs());
    let evaluations = root.evaluations + 1;
    if correction.abs().le(T::from_f64(LARGEST_CORRECTION) * enters).all() {
        return Ok(Root { x: v + Corrected::exact(correction), evaluations });
    }
    let update = correction.to_f64();
    Err(StepFailure::NewtonStalled { dof: coordinate.dof, iterations: evaluations, update })
}

/// Carries on from `state`: keeps the remainders if it is the state of the last step, and else sets
/// all of them to 0.
fn take_up<V: Vector>(carried: &mut State<InCorrected<V>>, state: &State<V>)
where
    V::Scalar: Lanewise,
{
    let parts =
        [(&mut carried.q, &state.q), (&mut carried.p, &state.p), (&mut carried.w, &state.w)]
            .map(|(carried, given)| (carried.as_mut_slice(), given.as_slice()));
    let same = |carried: &[Corrected<V::Scalar>], given: &[V::Scalar]| {
        carried.iter().zip(given).all(|(carried, given)| carried.nearest() == *given)
    };
    if !parts.iter().all(|(carried, given)| same(carried, given)) {
        for (carried, given) in parts {
            carried
                .iter_mut()
                .zip(given)
                .for_each(|(carried, &given)| *carried = Corrected::exact(given));
        }
    }
}

/// Normalises the corrected numbers of p and w.
fn normalise<V: Vector<Scalar = Corrected<T>>, T: Lanewise>(carried: &mut State<V>) {
    for part in [&mut carried.p, &mut carried.w] {
        part.as_mut_slice().iter_mut().for_each(|x| *x = x.normalised());
    }
}

/// Rounds the carried state.
fn show<V: Vector>(carried: &InCorrected<V>, state: &mut V)
where
    V::Scalar: Lanewise,
{
    let pairs = state.as_mut_slice().iter_mut().zip(carried.as_slice());
    pairs.for_each(|(state, carried)| *state = carried.nearest());
}
