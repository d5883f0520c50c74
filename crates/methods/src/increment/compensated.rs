//! Coordinate increments whose roundings do not add up, for very long runs.
//!
//! What a step of [`Increment`] moves K by is a few roundings, and these need not be independent:
//! the one of q1 = q0 + h v/m and the force it meets next lean to one side where steps are long,
//! and K drifts in proportion to time. Here
//!
//! ```text
//! v = p0 - F(v)                solved in f64, at the state in f64
//! ρ = p0 - v - F(v)            with what its roundings lose, at the state carried
//! v + ρ/(1 + F')               goes into q1, p1 and w1, all carried as sums of two f64
//! ```
//!
//! One correction squares what is left of the equation, and ρ is good to 105 bits ([`Corrected`]),
//! so K is kept to that in what is carried; what a caller sees is carried rounded, and K is off by
//! that rounding, once. What is carried beyond the state belongs to the state the last step
//! produced, number by number: given any other, in any entry, it is 0 again. Several numbers side
//! by side are each moved as they would be alone.
//!
//! Sources: the carried state as in E. Hairer, R. I. McLachlan, A. Razakarivony, *Achieving
//! Brouwer's law with implicit Runge-Kutta methods*, BIT 48 (2008), for whom the compensated sum
//! was enough: here the equation itself has to be exact. The correction is iterative refinement
//! with the residual in higher precision (Wilkinson 1963; N. J. Higham, *Accuracy and Stability of
//! Numerical Algorithms*, chapter 12).
//!
//! It fails where [`Increment`] does, and where a correction is no small one: `exact` is then not
//! the same system.

use super::{Before, Friction, Increment, coordinate, ordering, overall};
use crate::coordinate::{Along, Pull};
use afterbay_core::solver::{Equation, Newton, Root};
use afterbay_core::{
    Corrected, Effort, InputError, Lanewise, Mask, Method, Quantity, Scalar, Separable, State,
    StepFailure, Vector, validate,
};

/// The storage V with corrected numbers in it.
type InCorrected<V> = <V as Vector>::Of<Corrected<<V as Vector>::Scalar>>;

/// [`Increment`], its equations refined in [`Corrected`] arithmetic.
#[derive(Clone, Debug)]
pub struct Compensated<P> {
    increment: Increment,
    exact: P,
}

impl<P> Compensated<P> {
    /// The method given, and the system it is for in [`Corrected`] numbers.
    pub(super) fn new(increment: Increment, exact: P) -> Self {
        Self { increment, exact }
    }
}

/// The state carried, the one before the step, and what the increments need.
#[derive(Clone)]
pub struct Workspace<V: Vector>
where
    V::Scalar: Lanewise,
{
    carried: State<InCorrected<V>>,
    before: Before<InCorrected<V>>,
    order: Vec<usize>,
    /// Where friction couples the momenta.
    friction: Option<Friction<InCorrected<V>>>,
}

/// The largest correction beside what enters the equation. What [`Newton`] leaves is much smaller.
const CORRECTION: f64 = 1e-8;
/// Roundings that are left to the correction, which squares them: 1e-12 becomes 1e-24 times what F
/// bends.
const NEARLY: f64 = 8192.0;

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
            let why = "the system in corrected numbers has another damping";
            return Err(InputError::Unsupported { method: "increment", why });
        }
        validate::masses(system)?;
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
            let overall = overall(&system.coupling(), state.q.as_slice());
            let mut effort = Effort::default();
            let fractions = self.increment.composition.fractions::<Corrected<V::Scalar>>();
            for (i, fraction) in fractions.enumerate() {
                let h = fraction * Corrected::exact(h);
                let (there, back) = (order.iter().copied(), order.iter().rev().copied());
                let states = (&mut *state, &mut *carried);
                effort += match i % 2 {
                    0 => {
                        self.travel(system, h, overall, states, friction.as_mut(), (there, back))?
                    }
                    _ => {
                        self.travel(system, h, overall, states, friction.as_mut(), (back, there))?
                    }
                };
            }
            Ok(effort.shared_by(order.len()))
        });
        // Where the step has failed this is the state before.
        show(&carried.q, &mut state.q);
        show(&carried.p, &mut state.p);
        show(&carried.w, &mut state.w);
        outcome
    }
}

impl<P> Compensated<P> {
    /// A sweep there; where friction couples the momenta, half of it before and half after, on the
    /// way back.
    fn travel<V, S>(
        &self,
        system: &S,
        h: Corrected<V::Scalar>,
        overall: V::Scalar,
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
        let effort = self.sweep(system, h, overall, (state, carried), there)?;
        if let Some(friction) = friction {
            friction.pass(&self.exact, h.half(), carried, back)?;
            normalise(carried);
        }
        Ok(effort)
    }

    /// Moves every coordinate once, in the order given. Of `state` q and p are kept up.
    fn sweep<V, S>(
        &self,
        system: &S,
        h: Corrected<V::Scalar>,
        overall: V::Scalar,
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
            let rough = coordinate(system, [h.nearest(), overall], [j, j], [q, p], dissipative);
            let mut along = Along { system, j, q: &mut *q, p: &mut *p };
            let pull = Pull { coordinate: &rough, along: &mut along };
            let root = Newton::nearly(j, rough.p, pull, NEARLY)?;
            let steps = [h, Corrected::exact(overall)];
            let exact = coordinate(&self.exact, steps, [j, j], [exact_q, exact_p], dissipative);
            let mut along = Along { system: &self.exact, j, q: &mut *exact_q, p: &mut *exact_p };
            let root = refined(Pull { coordinate: &exact, along: &mut along }, root)?;
            let moved = exact.moved(root, along);
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

/// The solution of the equation in corrected numbers next to the rounded one.
#[inline(always)]
fn refined<T: Lanewise, P: Separable<Corrected<T>>>(
    mut equation: Pull<'_, '_, Corrected<T>, P>,
    root: Root<T>,
) -> Result<Root<Corrected<T>>, StepFailure> {
    let v = Corrected::exact(root.x);
    let (coordinate, pull) = (equation.coordinate, equation.at(Corrected::one(), v));
    let residual = (coordinate.p - v - pull.value).nearest();
    let inverse = (T::one() + pull.slope.rounded()).recip();
    let correction = residual * inverse;
    let sizes = coordinate.p.nearest().abs() + pull.value_rounding.rounded();
    let enters = sizes.mul_add(inverse.abs(), root.x.abs());
    let evaluations = root.evaluations + 1;
    if correction.abs().le(T::from_f64(CORRECTION) * enters).all() {
        return Ok(Root { x: v + Corrected::exact(correction), evaluations });
    }
    let update = correction.to_f64();
    Err(StepFailure::NewtonStalled { dof: coordinate.dof, iterations: evaluations, update })
}

/// The state given with what is carried beyond it, if it is the one that belongs to, else without.
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

/// Brings p and w to their normal form.
fn normalise<V: Vector<Scalar = Corrected<T>>, T: Lanewise>(carried: &mut State<V>) {
    for part in [&mut carried.p, &mut carried.w] {
        part.as_mut_slice().iter_mut().for_each(|x| *x = x.normalised());
    }
}

/// What is carried, rounded.
fn show<V: Vector>(carried: &InCorrected<V>, state: &mut V)
where
    V::Scalar: Lanewise,
{
    let pairs = state.as_mut_slice().iter_mut().zip(carried.as_slice());
    pairs.for_each(|(state, carried)| *state = carried.nearest());
}
