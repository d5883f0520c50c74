//! The leapfrog (Störmer-Verlet) method with a reservoir, called pqpLF in the paper (section 5).
//!
//! ```text
//! p½ = p0 - h/2 (V'(q0) + D(q0, p½))        q1 = q0 + h p½/m
//! p1 = p½ - h/2 (V'(q1) + D(q1, p½))        w1 = w0 + h/2 (D(q0, p½) + D(q1, p½)) p½/m
//! ```
//!
//! Order 2, symmetric, explicit if D is linear in its momentum. The forces at q1 are reused by the
//! next step. The error of K is O(h²). If D is passive, Δw ≥ 0. Unstable for hω larger than 2 (less
//! with damping), for any D. The equation for p½ is solved separately for each momentum, so systems
//! whose D couples the momenta are refused.

use crate::registry::binding::{Binding, Bound, InLanes, Target};
use afterbay_core::solver::{Newton, Sample, Solver};
use afterbay_core::{
    Effort, InputError, Mask, Method, Quantity, Scalar, Separable, State, StepFailure, Vector,
    validate,
};
use std::hint::cold_path;

/// The leapfrog method (pqpLF of the paper), for separable systems with any number of degrees of
/// freedom.
#[derive(Clone, Copy, Debug, Default)]
pub struct Leapfrog;

/// The new state, and the forces at the end of the last step, which the next step reuses.
#[derive(Clone, Debug)]
pub struct Workspace<V> {
    /// The q at which `force` and `rate` were evaluated; NaN before the first step.
    at: V,
    /// ∂V/∂q
    force: V,
    /// The friction coefficient γ_j, where D_j = γ_j p_j
    rate: V,
    velocity: V,
    p_half: V,
    drag: V,
    q: V,
    p: V,
    w: V,
    /// The force of the drive at both ends of the step.
    pushes: [V; 2],
    /// The motor of each degree of freedom, if it is driven; empty without a drive.
    motors: Vec<Option<usize>>,
    /// The first motor of a driven system, or N.
    first_motor: usize,
}

impl Binding for Leapfrog {
    const LANES: Option<InLanes<Self>> = Some(Self::bind_stored);

    fn bind<V: Vector + 'static>(&self, target: &Target<'_, V::Scalar>) -> Bound<V::Scalar> {
        target.fixed::<V, _, _>(*self, target.separable()?)
    }
}

impl<V, S> Method<V, S> for Leapfrog
where
    V: Vector,
    S: Separable<V::Scalar> + ?Sized,
{
    type Workspace = Workspace<V>;

    fn workspace(&self, system: &S) -> Result<Workspace<V>, InputError> {
        validate::masses(system)?;
        if system.dissipation_form().coupled {
            let why = "D couples the momenta and p½ is solved one at a time: \
                       take rk4, increment-2 or gonzalez";
            return Err(InputError::Unsupported { method: "leapfrog", why });
        }
        let zeros = || V::zeros(system.dof());
        let mut at = zeros();
        at.as_mut_slice().fill(V::Scalar::from_f64(f64::NAN));
        Ok(Workspace {
            at,
            force: zeros(),
            rate: zeros(),
            velocity: zeros(),
            p_half: zeros(),
            drag: zeros(),
            q: zeros(),
            p: zeros(),
            w: zeros(),
            pushes: [zeros(), zeros()],
            motors: motors(system),
            first_motor: system.dof() - system.motors(),
        })
    }

    #[inline(always)]
    fn is_memoryless(&self) -> bool {
        true
    }

    #[inline(always)]
    fn step(
        &self,
        system: &S,
        h: V::Scalar,
        state: &mut State<V>,
        workspace: &mut Workspace<V>,
    ) -> Result<Effort, StepFailure> {
        let n = state.dof();
        let damping = system.dissipation_form();
        let (half_h, one) = (h.half(), V::Scalar::one());
        let Workspace { at, force, rate, velocity, p_half, drag, q: q1, p: p1, w: w1, .. } =
            workspace;
        let Workspace { pushes, motors, first_motor, .. } = workspace;
        let (at, force, rate) = (at.as_mut_slice(), force.as_mut_slice(), rate.as_mut_slice());
        let (velocity, p_half, drag) =
            (velocity.as_mut_slice(), p_half.as_mut_slice(), drag.as_mut_slice());
        let (q1, p1, w1) = (q1.as_mut_slice(), p1.as_mut_slice(), w1.as_mut_slice());
        let (q0, p0, w0) = (state.q.as_slice(), state.p.as_slice(), state.w.as_slice());
        let unit_mass = system.unit_mass();
        let over_mass = |x: V::Scalar, j: usize| if unit_mass { x } else { x / system.mass(j) };
        // With several degrees of freedom the forces are computed together and stored. A single
        // force stays in a register; recomputing it costs less than checking whether the stored
        // value is valid.
        let single = V::LEN == Some(1);
        // With a motor there are two.
        let first_motor = if single { n } else { *first_motor };
        let known = !single && at == q0;
        let friction = |q: &[V::Scalar], p: &[V::Scalar], j: usize, is_driven: bool| {
            if is_driven { system.friction_of(q, p, j) } else { system.dissipation_of(q, p, j) }
        };
        let mut effort = Effort { evaluations: if known { 1 } else { 2 }, iterations: 0 };

        if !single && !known {
            at.copy_from_slice(q0);
            system.gradient(q0, p0, force, velocity);
            (0..n).for_each(|j| rate[j] = system.dissipation_of(q0, p0, j).by_p);
        }
        for j in 0..n {
            let force = if single { system.partial(q0, j, q0[j]) } else { force[j] };
            let mut kicked = (-half_h).mul_add(force, p0[j]);
            let push = if first_motor < n { system.supply(q0, j) } else { None };
            if let Some(push) = push {
                kicked = half_h.mul_add(push.force, kicked);
                pushes[0].as_mut_slice()[j] = push.force;
            }
            let step = over_mass(h, j);
            if damping.linear {
                let by_p = if single { system.dissipation_of(q0, p0, j).by_p } else { rate[j] };
                let keep = half_h.mul_add(by_p, one).recip();
                p_half[j] = kicked * keep;
                drag[j] = by_p * p_half[j];
                q1[j] = (step * keep).mul_add(kicked, q0[j]);
            } else {
                let root = Newton.solve(j, kicked, |s, p| {
                    p_half[j] = p;
                    let drag = friction(q0, p_half, j, push.is_some());
                    Sample {
                        value: s * half_h * drag.value,
                        slope: s * half_h * drag.by_p,
                        argument_rounding: V::Scalar::zero(),
                        value_rounding: V::Scalar::zero(),
                    }
                })?;
                p_half[j] = root.x;
                let value = friction(q0, p_half, j, push.is_some()).value;
                drag[j] = push.map_or(value, |push| value - push.force);
                q1[j] = step.mul_add(p_half[j], q0[j]);
                effort.iterations += u64::from(root.evaluations);
            }
        }
        for motor in first_motor..n {
            q1[motor] = q0[motor] + h;
        }
        let mut finite = V::Scalar::zero().is_finite();
        if !single {
            at.copy_from_slice(q1);
            system.gradient(q1, p_half, force, velocity);
        }
        for j in 0..n {
            let force = if single { system.partial(q1, j, q1[j]) } else { force[j] };
            let push = if first_motor < n { system.supply(q1, j) } else { None };
            let mut drag1 = friction(q1, p_half, j, push.is_some());
            if let Some(push) = push {
                drag1.value -= push.force;
                pushes[1].as_mut_slice()[j] = push.force;
            }
            if !single {
                rate[j] = drag1.by_p;
            }
            let dragged = if damping.linear {
                p_half[j] * (-half_h).mul_add(drag1.by_p, one)
            } else {
                (-half_h).mul_add(drag1.value, p_half[j])
            };
            p1[j] = (-half_h).mul_add(force, dragged);
            if !damping.zero {
                w1[j] = (over_mass(half_h, j) * (drag[j] + drag1.value)).mul_add(p_half[j], w0[j]);
                finite = finite.and(w1[j].is_finite());
            }
            finite = finite.and(p1[j].is_finite()).and(q1[j].is_finite());
        }
        if first_motor < n {
            for (j, &p) in p_half[..first_motor].iter().enumerate() {
                if let Some(motor) = motors.get(j).copied().flatten() {
                    let [start, end] = pushes.each_ref().map(|push| push.as_slice()[j]);
                    let work = over_mass(half_h, j) * (start + end) * p;
                    p1[motor] += work;
                    w1[motor] -= work;
                }
            }
        }
        if !finite.all() {
            return Err(failure(system, half_h, state, [q1, p1, w1]));
        }
        state.q.as_mut_slice().copy_from_slice(q1);
        state.p.as_mut_slice().copy_from_slice(p1);
        if !damping.zero {
            state.w.as_mut_slice().copy_from_slice(w1);
        }
        Ok(effort)
    }
}

/// The motor of each degree of freedom, if it is driven; empty without a drive.
fn motors<T: Scalar, S: Separable<T> + ?Sized>(system: &S) -> Vec<Option<usize>> {
    let first = system.dof() - system.motors();
    let origin = vec![T::zero(); system.dof()];
    let motor = |j| system.supply(&origin, j).map(|supply| supply.motor);
    if system.motors() > 0 { (0..first).map(motor).collect() } else { Vec::new() }
}

/// Reports why the new state is not finite. Inlining keeps the state in registers: its address does
/// not escape from the loop.
#[inline(always)]
fn failure<V, S>(
    system: &S,
    half_h: V::Scalar,
    state: &State<V>,
    [q, p, w]: [&[V::Scalar]; 3],
) -> StepFailure
where
    V: Vector,
    S: Separable<V::Scalar> + ?Sized,
{
    cold_path();
    for j in 0..state.dof() {
        let drag = system.dissipation_of(state.q.as_slice(), state.p.as_slice(), j);
        let slope = half_h.mul_add(drag.by_p, V::Scalar::one());
        if slope == V::Scalar::zero() {
            return StepFailure::Singular { dof: j, slope: 0.0 };
        }
    }
    StepFailure::non_finite(&[
        (Quantity::Coordinate, q),
        (Quantity::Momentum, p),
        (Quantity::Reservoir, w),
    ])
}
