//! The leapfrog (Störmer-Verlet) method with a reservoir, called pqpLF in the paper (section 5).
//!
//! ```text
//! p½ = p0 - h/2 (V'(q0) + D(q0, p½))        q1 = q0 + h p½/m
//! p1 = p½ - h/2 (V'(q1) + D(q1, p½))        w1 = w0 + h/2 (D(q0, p½) + D(q1, p½)) p½/m
//! ```
//!
//! The method has order 2, is symmetric, and is explicit if D_j is linear in p_j. The next step
//! reuses the forces at q1. The error of K is O(h²). If D is passive, Δw ≥ 0. The method is
//! unstable for hω > 2; damping D_j = b p_j does not change this limit. The equation for p½ is
//! solved separately for each momentum, so systems whose D couples the momenta are refused.

mod together;

use crate::commit::{not_finite_by_value, store};
use crate::hidden_coupling::states_coupling;
use crate::kernels::reductions::are_equal;
use crate::kick::kick;
use crate::registry::binding::{Binding, Bound, InLanes, Target};
use afterbay_core::{
    DissipationForm, Effort, InputError, Mask, Method, Scalar, Separable, State, StepFailure,
    Vector, validate,
};

/// The leapfrog method (pqpLF of the paper), for separable systems with any number of degrees of
/// freedom.
#[derive(Clone, Copy, Debug, Default)]
pub struct Leapfrog;

/// The new state, and the forces there, which the next step reuses where it begins there.
#[derive(Clone, Debug)]
pub struct Workspace<V> {
    /// ∂V/∂q
    force: V,
    /// The friction coefficient γ_j, where D_j = γ_j p_j.
    rate: V,
    /// Unit momenta, at which D_j equals γ_j.
    ones: V,
    /// 1/m_j
    inverse_mass: V,
    velocity: V,
    p_half: V,
    drag: V,
    /// The q of the new state. Between steps it is the q of `force` and `rate`, except for a single
    /// degree of freedom, which stores neither. It is NaN before the first step and after a step
    /// without a p½.
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
                       take rk4 or gonzalez, or increment-2 if D is linear in the velocities and \
                       nothing drives the system";
            return Err(InputError::Unsupported { method: "leapfrog", why });
        }
        states_coupling("leapfrog", system, true)?;
        let zeros = || V::zeros(system.dof());
        let [mut q, mut ones, mut inverse_mass] = [(); 3].map(|()| zeros());
        q.as_mut_slice().fill(V::Scalar::from_f64(f64::NAN));
        ones.as_mut_slice().fill(V::Scalar::one());
        for (j, inverse) in inverse_mass.as_mut_slice().iter_mut().enumerate() {
            *inverse = system.mass(j).recip();
        }
        Ok(Workspace {
            force: zeros(),
            rate: zeros(),
            ones,
            inverse_mass,
            velocity: zeros(),
            p_half: zeros(),
            drag: zeros(),
            q,
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
        let (unit_mass, damping) = (system.unit_mass(), system.dissipation_form());
        let mut step = Step { workspace, system, unit_mass, damping, h, state };
        let evaluations = step.find_forces();
        let iterations = step.kick_and_drift()?;
        let finite = step.kick();
        step.supply();
        let Workspace { q, p, w, .. } = workspace;
        if !finite {
            return Err(failure(system, h, &state.clone(), [q.copied(), p.copied(), w.copied()]));
        }
        store(state, [q, p, w].map(|end| end.as_slice()), !damping.zero);
        Ok(Effort { evaluations, iterations })
    }
}

/// A step of size h from `state`.
struct Step<'a, V: Vector, S: ?Sized> {
    workspace: &'a mut Workspace<V>,
    system: &'a S,
    unit_mass: bool,
    damping: DissipationForm,
    h: V::Scalar,
    state: &'a State<V>,
}

impl<V: Vector, S: Separable<V::Scalar> + ?Sized> Step<'_, V, S> {
    /// A single force stays in a register; recomputing it costs less than checking whether a stored
    /// value is valid. With several degrees of freedom the forces are computed together and stored.
    const SINGLE: bool = matches!(V::LEN, Some(1));

    /// The number of degrees of freedom before the motors. With a motor there are at least two.
    #[inline(always)]
    fn free(&self) -> usize {
        if Self::SINGLE { self.state.dof() } else { self.workspace.first_motor }
    }

    /// Computes the forces at q0, unless the last step did. Returns the number of evaluations of
    /// the step.
    #[inline(always)]
    fn find_forces(&mut self) -> u64 {
        if Self::SINGLE {
            return 2;
        }
        let (q0, p0) = (self.state.q.as_slice(), self.state.p.as_slice());
        if are_equal(self.workspace.q.as_slice(), q0) {
            return 1;
        }
        let together = self.is_together();
        let Self { workspace: Workspace { force, rate, velocity, q, .. }, system, .. } = self;
        q.assign(q0);
        system.gradient(q0, p0, force.as_mut_slice(), velocity.as_mut_slice());
        if together {
            self.find_rates();
        } else {
            let rates = rate.as_mut_slice().iter_mut().enumerate();
            rates.for_each(|(j, rate)| *rate = system.dissipation_of(q0, p0, j).by_p);
        }
        2
    }

    /// p½ = p0 - h/2 (V'(q0) + D(q0, p½)), q1 = q0 + h p½/m. Returns the number of iterations.
    #[inline(always)]
    fn kick_and_drift(&mut self) -> Result<u64, StepFailure> {
        if self.is_together() {
            self.kick_and_drift_together();
            return Ok(0);
        }
        let (n, first_motor) = (self.state.dof(), self.free());
        let Self { workspace, system, unit_mass, damping, h, state } = self;
        let Workspace {
            force, rate, inverse_mass, p_half, drag, q: q1, pushes: [pushes, _], ..
        } = &mut **workspace;
        let inverse_mass = inverse_mass.as_slice();
        let (force, rate, p_half) = (force.as_slice(), rate.as_slice(), p_half.as_mut_slice());
        let (drag, q1, pushes) = (drag.as_mut_slice(), q1.as_mut_slice(), pushes.as_mut_slice());
        let (q0, p0, half_h) = (state.q.as_slice(), state.p.as_slice(), h.half());
        let mut iterations = 0;
        for j in 0..n {
            let force = if Self::SINGLE { system.partial(q0, j, q0[j]) } else { force[j] };
            let mut kicked = (-half_h).mul_add(force, p0[j]);
            let push = if first_motor < n { system.supply(q0, j) } else { None };
            if let Some(push) = push {
                kicked = half_h.mul_add(push.force, kicked);
                pushes[j] = push.force;
            }
            let step = if *unit_mass { *h } else { *h * inverse_mass[j] };
            if damping.linear {
                let by_p =
                    if Self::SINGLE { system.dissipation_of(q0, p0, j).by_p } else { rate[j] };
                let keep = half_h.mul_add(by_p, V::Scalar::one()).recip();
                p_half[j] = kicked * keep;
                drag[j] = by_p * p_half[j];
                q1[j] = (step * keep).mul_add(kicked, q0[j]);
            } else {
                // Some entries of q1 have moved already, and the forces are those at q0.
                let half = kick(*system, q0, p_half, j, kicked, half_h)
                    .inspect_err(|_| q1.fill(V::Scalar::from_f64(f64::NAN)))?;
                drag[j] = push.map_or(half.drag, |push| half.drag - push.force);
                q1[j] = step.mul_add(half.p, q0[j]);
                iterations += half.iterations;
            }
        }
        for motor in first_motor..n {
            q1[motor] = q0[motor] + *h;
        }
        Ok(iterations)
    }

    /// p1 = p½ - h/2 (V'(q1) + D(q1, p½)), w1 = w0 + h/2 (D(q0, p½) + D(q1, p½)) p½/m. Returns
    /// whether the new state is finite.
    #[inline(always)]
    fn kick(&mut self) -> bool {
        let (n, first_motor, half_h) = (self.state.dof(), self.free(), self.h.half());
        if !Self::SINGLE {
            let Self { workspace: Workspace { force, velocity, q, p_half, .. }, .. } = self;
            let (force, velocity) = (force.as_mut_slice(), velocity.as_mut_slice());
            self.system.gradient(q.as_slice(), p_half.as_slice(), force, velocity);
        }
        if self.is_together() {
            return self.kick_together();
        }
        let Self { workspace, system, unit_mass, damping, state, .. } = self;
        let Workspace { force, rate, inverse_mass, p_half, drag, q, p, w, pushes, .. } =
            &mut **workspace;
        let inverse_mass = inverse_mass.as_slice();
        let (force, rate, p_half) = (force.as_mut_slice(), rate.as_mut_slice(), p_half.as_slice());
        let (drag, pushes, w0) = (drag.as_slice(), pushes[1].as_mut_slice(), state.w.as_slice());
        let (q1, p1, w1) = (q.as_slice(), p.as_mut_slice(), w.as_mut_slice());
        let mut finite = V::Scalar::zero().is_finite();
        for j in 0..n {
            let force = if Self::SINGLE { system.partial(q1, j, q1[j]) } else { force[j] };
            let push = if first_motor < n { system.supply(q1, j) } else { None };
            let mut drag1 = system.friction_of(q1, p_half, j);
            if let Some(push) = push {
                drag1.value -= push.force;
                pushes[j] = push.force;
            }
            if !Self::SINGLE {
                rate[j] = drag1.by_p;
            }
            let dragged = if damping.linear {
                p_half[j] * (-half_h).mul_add(drag1.by_p, V::Scalar::one())
            } else {
                (-half_h).mul_add(drag1.value, p_half[j])
            };
            p1[j] = (-half_h).mul_add(force, dragged);
            if !damping.zero {
                let half_step = if *unit_mass { half_h } else { half_h * inverse_mass[j] };
                w1[j] = (half_step * (drag[j] + drag1.value)).mul_add(p_half[j], w0[j]);
                finite = finite.and(w1[j].is_finite());
            }
            finite = finite.and(p1[j].is_finite()).and(q1[j].is_finite());
        }
        finite.all()
    }

    /// Adds the work of a drive, h/2 (F(q0) + F(q1)) p½/m, to its motors.
    #[inline(always)]
    fn supply(&mut self) {
        let (first_motor, half_h) = (self.free(), self.h.half());
        if first_motor == self.state.dof() {
            return;
        }
        let Workspace { p_half, inverse_mass, p, w, pushes, motors, .. } = &mut *self.workspace;
        for (j, motor) in motors.iter().enumerate() {
            let Some(motor) = *motor else { continue };
            let [start, end] = pushes.each_ref().map(|push| push.as_slice()[j]);
            let step = half_h * inverse_mass.as_slice()[j];
            let work = step * (start + end) * p_half.as_slice()[j];
            p.as_mut_slice()[motor] += work;
            w.as_mut_slice()[motor] -= work;
        }
    }
}

/// Reports why the step h from `state` does not end in a finite q, p and w. It takes copies, so
/// that the vectors of the loop can stay in registers.
#[cold]
#[inline(never)]
fn failure<V, S>(system: &S, h: V::Scalar, state: &State<V>, end: [V; 3]) -> StepFailure
where
    V: Vector,
    S: Separable<V::Scalar> + ?Sized,
{
    for j in 0..state.dof() {
        let drag = system.dissipation_of(state.q.as_slice(), state.p.as_slice(), j);
        if h.half().mul_add(drag.by_p, V::Scalar::one()) == V::Scalar::zero() {
            return StepFailure::Singular { dof: j, slope: Some(0.0) };
        }
    }
    not_finite_by_value(end)
}

/// The motor of each degree of freedom, if it is driven; empty without a drive.
fn motors<T: Scalar, S: Separable<T> + ?Sized>(system: &S) -> Vec<Option<usize>> {
    let first = system.dof() - system.motors();
    let origin = vec![T::zero(); system.dof()];
    let motor = |j| system.supply(&origin, j).map(|supply| supply.motor);
    if system.motors() > 0 { (0..first).map(motor).collect() } else { Vec::new() }
}
