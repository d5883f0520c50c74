//! Coordinate increments whose roundings do not add up, for very long runs.
//!
//! What a step of [`Increment`] moves K by is a few roundings, and these need not be independent: the one of q1 = q0 + h v/m
//! and the force it meets next lean to one side where steps are long, and K drifts in proportion to time. Here
//!
//! ```text
//! v = p0 - F(v)                solved in f64, at the state in f64
//! ρ = p0 - v - F(v)            in extended precision, at the state carried
//! v + ρ/(1 + F')               goes into q1, p1 and w1, all carried as sums of two f64
//! ```
//!
//! One correction squares what is left of the equation, so K is kept to the rounding of extended precision in what is carried;
//! what a caller sees are the high parts, and K is off by their rounding, once. The low parts belong to the state the last step
//! produced, bit for bit: given any other, in any entry, they are 0 again.
//!
//! Sources: the carried state as in E. Hairer, R. I. McLachlan, A. Razakarivony, *Achieving Brouwer's law with implicit
//! Runge-Kutta methods*, BIT 48 (2008), for whom the compensated sum was enough: here the equation itself has to
//! be exact. The correction is iterative refinement with the residual in higher precision (Wilkinson 1963; N. J. Higham,
//! *Accuracy and Stability of Numerical Algorithms*, chapter 12).
//!
//! It fails where [`Increment`] does, and where a correction is no small one: `exact` is then not the same system.

use super::{Before, Increment, coordinate, friction, ordering, overall};
use crate::coordinate::{Along, Pull};
use afterbay_core::solver::{Equation, Newton, Root, Solver};
use afterbay_core::{
    Effort, InputError, Method, Quad, Quantity, Scalar, Separable, State, StepFailure, Vector, check,
};

/// [`Increment`] in `f64`, refined in extended precision.
#[derive(Clone, Debug)]
pub struct Compensated<P> {
    increment: Increment,
    exact: P,
}

impl<P> Compensated<P> {
    /// The method given, and the system it is for in extended precision.
    pub(super) fn new(increment: Increment, exact: P) -> Self {
        Self { increment, exact }
    }
}

/// The state carried, the one before the step, and what the increments need.
#[derive(Clone)]
pub struct Workspace<V: Vector> {
    carried: State<V::Of<Quad>>,
    before: Before<V::Of<Quad>>,
    order: Vec<usize>,
    /// Twice the mean momenta, where friction couples them.
    means: Option<V::Of<Quad>>,
}

/// The largest correction beside what enters the equation. What [`Newton`] leaves is much smaller.
const CORRECTION: f64 = 1e-8;

impl<V, S, P> Method<V, S> for Compensated<P>
where
    V: Vector<Scalar = f64>,
    S: Separable<f64> + ?Sized,
    P: Separable<Quad>,
{
    type Workspace = Workspace<V>;

    fn workspace(&self, system: &S) -> Result<Workspace<V>, InputError> {
        let n = system.dof();
        if self.exact.dof() != n {
            let (quantity, found) = (Quantity::Coordinate, self.exact.dof());
            return Err(InputError::Length { quantity, expected: n, found });
        }
        if self.exact.damping() != system.damping() {
            let why = "the system in extended precision has another damping";
            return Err(InputError::Unsupported { method: "increment", why });
        }
        check::masses(system)?;
        check::masses(&self.exact)?;
        friction::check::<V, S>(system)?;
        let order = ordering("increment", self.increment.order.as_ref(), n)?;
        let zeros = || V::Of::<Quad>::zeros(n);
        let carried = State { q: zeros(), p: zeros(), w: zeros(), t: Quad::ZERO };
        let means = system.damping().coupled.then(zeros);
        Ok(Workspace { carried, before: Before::new(n), order, means })
    }

    /// The low parts.
    fn has_memory(&self) -> bool {
        true
    }

    fn step(
        &self,
        system: &S,
        h: f64,
        state: &mut State<V>,
        workspace: &mut Workspace<V>,
    ) -> Result<Effort, StepFailure> {
        let Workspace { carried, before, order, means } = workspace;
        take_up(carried, state);
        let outcome = before.attempt(carried, |carried| {
            let overall = overall(&system.coupling(), state.q.as_slice());
            let mut effort = Effort::default();
            for (i, fraction) in self.increment.composition.fractions::<Quad>().enumerate() {
                let h = fraction * Quad::from_f64(h);
                let (there, back) = (order.iter().copied(), order.iter().rev().copied());
                let states = (&mut *state, &mut *carried);
                effort += match i % 2 {
                    0 => self.travel(system, h, overall, states, means.as_mut(), (there, back))?,
                    _ => self.travel(system, h, overall, states, means.as_mut(), (back, there))?,
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

impl<P: Separable<Quad>> Compensated<P> {
    /// A sweep there; where friction couples the momenta, half of it before and half after, on the way back.
    fn travel<V, S>(
        &self,
        system: &S,
        h: Quad,
        overall: f64,
        (state, carried): (&mut State<V>, &mut State<V::Of<Quad>>),
        mut means: Option<&mut V::Of<Quad>>,
        (there, back): (impl Iterator<Item = usize> + Clone, impl Iterator<Item = usize>),
    ) -> Result<Effort, StepFailure>
    where
        V: Vector<Scalar = f64>,
        S: Separable<f64> + ?Sized,
    {
        if let Some(means) = &mut means {
            friction::pass(&self.exact, h.half(), carried, means, there.clone())?;
            show(&carried.p, &mut state.p);
        }
        let effort = self.sweep(system, h, overall, (state, carried), there)?;
        if let Some(means) = means {
            friction::pass(&self.exact, h.half(), carried, means, back)?;
        }
        Ok(effort)
    }

    /// Moves every coordinate once, in the order given. Of `state` q and p are kept up.
    fn sweep<V, S>(
        &self,
        system: &S,
        h: Quad,
        overall: f64,
        (state, carried): (&mut State<V>, &mut State<V::Of<Quad>>),
        order: impl Iterator<Item = usize>,
    ) -> Result<Effort, StepFailure>
    where
        V: Vector<Scalar = f64>,
        S: Separable<f64> + ?Sized,
    {
        let damping = system.damping();
        let dissipative = !damping.zero && !damping.coupled;
        let (q, p) = (state.q.as_mut_slice(), state.p.as_mut_slice());
        let State { q: exact_q, p: exact_p, w, .. } = carried;
        let (exact_q, exact_p, w) = (exact_q.as_mut_slice(), exact_p.as_mut_slice(), w.as_mut_slice());
        let mut evaluations = 0;
        for j in order {
            let rough = coordinate(system, [h.to_f64(), overall], [j, j], [q, p], dissipative);
            let mut along = Along { system, j, q: &mut *q, p: &mut *p };
            let pull = Pull { coordinate: &rough, along: &mut along };
            let root = Newton.solve(j, rough.p, pull)?;
            let steps = [h, Quad::from_f64(overall)];
            let exact = coordinate(&self.exact, steps, [j, j], [exact_q, exact_p], dissipative);
            let mut along = Along { system: &self.exact, j, q: &mut *exact_q, p: &mut *exact_p };
            let root = refined(Pull { coordinate: &exact, along: &mut along }, root)?;
            let moved = exact.moved(root, along);
            (exact_q[j], exact_p[j]) = (moved.q, moved.p);
            (q[j], p[j]) = (moved.q.to_f64(), moved.p.to_f64());
            if dissipative {
                w[j] += moved.dw;
            }
            evaluations += moved.evaluations;
        }
        Ok(Effort { evaluations, iterations: evaluations })
    }
}

/// The solution of the equation in extended precision next to the one in `f64`.
#[inline(always)]
fn refined<P: Separable<Quad>>(
    mut equation: Pull<'_, '_, Quad, P>,
    root: Root<f64>,
) -> Result<Root<Quad>, StepFailure> {
    let v = Quad::from_f64(root.x);
    let (coordinate, pull) = (equation.coordinate, equation.at(Quad::ONE, v));
    let residual = coordinate.p - v - pull.value;
    let inverse = (1.0 + pull.slope.to_f64()).recip();
    let correction = residual.to_f64() * inverse;
    let enters = (coordinate.p.to_f64().abs() + pull.blur.to_f64()) * inverse.abs() + root.x.abs();
    let evaluations = root.evaluations + 1;
    if correction.abs() <= CORRECTION * enters {
        return Ok(Root { x: v + Quad::from_f64(correction), evaluations });
    }
    Err(StepFailure::NewtonStalled { dof: coordinate.dof, iterations: evaluations, update: correction })
}

/// The state given with the low parts carried, if it is the one they belong to, else without.
fn take_up<V: Vector<Scalar = f64>>(carried: &mut State<V::Of<Quad>>, state: &State<V>) {
    let parts = [(&mut carried.q, &state.q), (&mut carried.p, &state.p), (&mut carried.w, &state.w)]
        .map(|(carried, given)| (carried.as_mut_slice(), given.as_slice()));
    let same = |carried: &[Quad], given: &[f64]| {
        carried.iter().zip(given).all(|(carried, given)| carried.0.to_bits() == given.to_bits())
    };
    if !parts.iter().all(|(carried, given)| same(carried, given)) {
        for (carried, given) in parts {
            carried.iter_mut().zip(given).for_each(|(carried, &given)| *carried = Quad::from_f64(given));
        }
    }
}

/// The high parts.
fn show<V: Vector<Scalar = f64>>(carried: &V::Of<Quad>, state: &mut V) {
    let pairs = state.as_mut_slice().iter_mut().zip(carried.as_slice());
    pairs.for_each(|(state, carried)| *state = carried.to_f64());
}
