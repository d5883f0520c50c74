//! Splitting methods: drifts of q and kicks of p in turn, with K exact after every step.
//!
//! ```text
//! drift by a:         q ← q + a h p/m
//! kick by (a, b):     p½ = p - a h (∂V/∂q + D(q, p½))        p ← p½ - b h (∂V/∂q + D(q, p½))
//!                     w ← w + (a + b) h D(q, p½) p½/m
//! step:               drift a1, kick (a1, b1), drift b1 + a2, kick (a2, b2), .., drift bs
//! ```
//!
//! A drift followed by a kick is the symplectic Euler method with a reservoir. The numbers a and b
//! are the fractions of a [`Composition`], which alternates this method and its adjoint; its order
//! is that of the method. With one kick it is the Störmer-Verlet method that begins with q. The
//! coefficients of orders 4 and 6 are those of S. Blanes and P. C. Moan, J. Comput. Appl. Math. 142
//! (2002) 313-330. A kick needs one evaluation and no sums of earlier ones.
//!
//! Then (q, p) is projected onto K along ∇H (E. Hairer, C. Lubich, G. Wanner, Geometric Numerical
//! Integration, IV.4). The projection is of the size of the error of the step. If it would be too
//! long, as near v = 0 where p is tiny in its unit, a second one measures q and p by their changes
//! over the step. It does not change w. The workspace stores the (q, p) in which the last
//! step ended and its target of H, so that roundings of K do not accumulate. For any other (q, p) H
//! is computed anew.
//!
//! It is explicit if D_j is linear in p_j; otherwise each p½ solves a scalar equation. Systems
//! whose D couples the momenta are refused. With one kick the method is passive where D is. Higher
//! orders have negative kicks, which take dissipated energy out of w.
//!
//! A step **fails**, and leaves the state unchanged, where no small projection restores K. This
//! happens beyond the limit of stability, which the projection does not change: |hω| = 2, 6.3 and
//! 6.1 at orders 2, 4 and 6. It happens before that limit if the fastest mode has much of the
//! energy. For |hω| between 3.13 and 3.17 a mode grows by up to 1.4 % (order 4) or 0.8 % (order 6)
//! a step. The scalar must hold one number: there are no lanes.

mod balance;

use crate::commit::commit;
use crate::hidden_coupling::states_coupling;
use crate::increment::Composition;
use crate::kernels::reductions::sum;
use crate::kick::kick;
use crate::measured_rounding::EnergyRounding;
use crate::registry::binding::{Binding, Bound, Target};
use afterbay_core::{
    Effort, InputError, Method, Scalar, Separable, State, StepFailure, Vector, two_sum, validate,
};
use balance::{Balance, Norm};

/// A splitting method whose drifts and kicks are those of a composition.
#[derive(Clone, Debug, PartialEq)]
pub struct Splitting {
    composition: Composition,
}

impl Splitting {
    /// The method with the fractions of a composition, two for each kick.
    ///
    /// # Errors
    /// [`InputError::Parameter`] if the number of fractions is odd.
    pub fn new(composition: Composition) -> Result<Self, InputError> {
        let sweeps = composition.sweeps();
        if sweeps.is_multiple_of(2) {
            return Ok(Self { composition });
        }
        let value = sweeps as f64;
        Err(InputError::Parameter { name: "number of fractions", value, range: "even" })
    }
}

/// A splitting method of the registry, with its composition.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Splittings(pub(crate) fn() -> Composition);

impl Binding for Splittings {
    fn bind<V: Vector + 'static>(&self, target: &Target<'_, V::Scalar>) -> Bound<V::Scalar> {
        target.fixed::<V, _, _>(Splitting::new(self.0())?, target.separable()?)
    }
}

/// The end of the last step, and the vectors of a kick.
#[derive(Clone, Debug)]
pub struct Workspace<V: Vector> {
    q: V,
    p: V,
    w: V,
    /// The increments of w.
    gain: V,
    /// The target of H at (q, p) and its rounding error, if a step ended there.
    energy: [V::Scalar; 2],
    ended: bool,
    /// ∂H/∂q and ∂H/∂p
    hq: V,
    hp: V,
    /// 1/m_j
    inverse_mass: V,
    /// The friction coefficient γ_j, where D_j = γ_j p_j.
    rate: V,
    /// Unit momenta, at which D_j equals γ_j.
    ones: V,
    /// The fractions of the composition.
    fractions: Vec<V::Scalar>,
    /// The first motor of a driven system, or N.
    first_motor: usize,
    energy_rounding: EnergyRounding<V::Scalar>,
}

impl<V, S> Method<V, S> for Splitting
where
    V: Vector,
    S: Separable<V::Scalar> + ?Sized,
{
    type Workspace = Workspace<V>;

    fn workspace(&self, system: &S) -> Result<Workspace<V>, InputError> {
        validate::masses(system)?;
        if system.dissipation_form().coupled {
            let why = "D couples the momenta and p½ is solved one at a time: \
                       take relaxed-rk4 or gonzalez, or increment-2 if D is linear in the \
                       velocities and nothing drives the system";
            return Err(InputError::Unsupported { method: "splitting", why });
        }
        states_coupling("splitting", system, true)?;
        let n = system.dof();
        let zeros = || V::zeros(n);
        let (mut inverse_mass, mut ones) = (zeros(), zeros());
        for (j, inverse) in inverse_mass.as_mut_slice().iter_mut().enumerate() {
            *inverse = system.mass(j).recip();
        }
        ones.as_mut_slice().fill(V::Scalar::one());
        Ok(Workspace {
            q: zeros(),
            p: zeros(),
            w: zeros(),
            gain: zeros(),
            energy: [V::Scalar::zero(); 2],
            ended: false,
            hq: zeros(),
            hp: zeros(),
            inverse_mass,
            ones,
            rate: zeros(),
            fractions: self.composition.fractions().collect(),
            first_motor: n - system.motors(),
            energy_rounding: EnergyRounding::new(n),
        })
    }

    fn step(
        &self,
        system: &S,
        h: V::Scalar,
        state: &mut State<V>,
        workspace: &mut Workspace<V>,
    ) -> Result<Effort, StepFailure> {
        let mut evaluations = self.composition.sweeps() as u64 / 2;
        workspace.begin(system, state);
        let iterations = workspace.sweep(system, h)?;
        let target = workspace.target();
        let mut balance = workspace.project(system, target[0], state, Norm::Euclidean)?;
        if let Balance::Unrestored { .. } = balance {
            workspace.begin_again(system, h, state)?;
            evaluations *= 2;
            balance = workspace.project(system, target[0], state, Norm::OfChanges)?;
        }
        match balance {
            Balance::Kept => {}
            Balance::Restored { gradients } => evaluations += gradients,
            Balance::Unrestored { excess } => {
                workspace.begin_again(system, h, state)?;
                if !workspace.is_noise(system, target[0], state)? {
                    return Err(StepFailure::ProjectionFailed { excess });
                }
                evaluations += evaluations / 2 + 1;
            }
        }
        let Workspace { q, p, gain, w, .. } = &mut *workspace;
        let gains = state.w.as_slice().iter().zip(gain.as_slice());
        w.as_mut_slice().iter_mut().zip(gains).for_each(|(end, (&w, &gain))| *end = w + gain);
        let dissipative = !system.dissipation_form().zero;
        commit(state, [q.as_slice(), p.as_slice(), w.as_slice()], dissipative)?;
        (workspace.energy, workspace.ended) = (target, true);
        Ok(Effort { evaluations, iterations })
    }
}

impl<V: Vector> Workspace<V> {
    /// Copies the state, and computes H there unless the last step ended in it.
    #[inline]
    fn begin<S>(&mut self, system: &S, state: &State<V>)
    where
        S: Separable<V::Scalar> + ?Sized,
    {
        // Without a jump out of the loop, so that several numbers are compared at a time.
        let equal = |x: &V, y: &V| {
            x.as_slice().iter().zip(y.as_slice()).fold(true, |equal, (x, y)| equal & (x == y))
        };
        if !(self.ended && equal(&self.q, &state.q) && equal(&self.p, &state.p)) {
            self.copy(state);
            self.energy = [state.energy(system), V::Scalar::zero()];
        }
        self.ended = false;
    }

    fn copy(&mut self, state: &State<V>) {
        self.q.as_mut_slice().copy_from_slice(state.q.as_slice());
        self.p.as_mut_slice().copy_from_slice(state.p.as_slice());
    }

    /// The end of the step before the projection.
    #[cold]
    fn begin_again<S>(
        &mut self,
        system: &S,
        h: V::Scalar,
        state: &State<V>,
    ) -> Result<(), StepFailure>
    where
        S: Separable<V::Scalar> + ?Sized,
    {
        self.copy(state);
        self.sweep(system, h).map(drop)
    }

    /// H at the end of the step and its rounding error: gains far below the rounding of H add up.
    #[inline]
    fn target(&self) -> [V::Scalar; 2] {
        let [energy, rest] = self.energy;
        two_sum(energy, rest - sum([self.gain.as_slice()], |[gain]| gain))
    }

    /// Drifts and kicks from the copy of the state. Returns the number of iterations.
    #[inline]
    fn sweep<S>(&mut self, system: &S, h: V::Scalar) -> Result<u64, StepFailure>
    where
        S: Separable<V::Scalar> + ?Sized,
    {
        let mut iterations = 0;
        self.gain.as_mut_slice().fill(V::Scalar::zero());
        self.drift(self.fractions[0] * h);
        for kick in 0..self.fractions.len() / 2 {
            let [before, after] = [2 * kick, 2 * kick + 1].map(|k| self.fractions[k]);
            let next = self.fractions.get(2 * kick + 2).copied();
            iterations += self.kick(system, [before * h, after * h])?;
            self.drift((after + next.unwrap_or(V::Scalar::zero())) * h);
        }
        Ok(iterations)
    }

    /// q ← q + s p/m. The velocity of motors is 1.
    #[inline]
    fn drift(&mut self, s: V::Scalar) {
        let Self { q, p, inverse_mass, first_motor, .. } = self;
        let (q, motors) = q.as_mut_slice().split_at_mut(*first_motor);
        let parts = q.iter_mut().zip(p.as_slice()).zip(inverse_mass.as_slice());
        for ((q, &p), &inverse) in parts {
            *q = (s * inverse).mul_add(p, *q);
        }
        motors.iter_mut().for_each(|q| *q += s);
    }

    /// A kick by s before p½ and by t after it. Returns the number of iterations.
    #[inline]
    fn kick<S>(&mut self, system: &S, [s, t]: [V::Scalar; 2]) -> Result<u64, StepFailure>
    where
        S: Separable<V::Scalar> + ?Sized,
    {
        let Self { q, p, gain, hq, hp, inverse_mass, ones, rate, .. } = self;
        let (q, p, gain) = (q.as_slice(), p.as_mut_slice(), gain.as_mut_slice());
        let (hq, rate) = (hq.as_mut_slice(), rate.as_mut_slice());
        system.gradient(q, p, hq, hp.as_mut_slice());
        let form = system.dissipation_form();
        if form.zero && system.motors() == 0 {
            p.iter_mut().zip(&*hq).for_each(|(p, &hq)| *p = (s + t).mul_add(-hq, *p));
            return Ok(0);
        }
        if !form.linear || system.motors() > 0 {
            return self.kick_one_by_one(system, [s, t]);
        }
        // One call for all degrees of freedom.
        let inverse_mass = inverse_mass.as_slice();
        system.dissipation(q, ones.as_slice(), inverse_mass, rate);
        let parts = p.iter_mut().zip(gain).zip(&*hq).zip(&*rate).zip(inverse_mass);
        let keep = |rate| s.mul_add(rate, V::Scalar::one()).recip();
        // A division takes as long as all else.
        let equal = rate.iter().fold(true, |equal, x| equal & (*x == rate[0]));
        let shared = equal.then(|| keep(rate[0]));
        for ((((p, gain), &hq), &rate), &inverse) in parts {
            let half = s.mul_add(-hq, *p) * shared.unwrap_or_else(|| keep(rate));
            let drag = rate * half;
            *p = (-t).mul_add(hq + drag, half);
            *gain = ((s + t) * inverse * drag).mul_add(half, *gain);
        }
        Ok(0)
    }

    /// [`Self::kick`] for D that is not linear, or with a drive. The work of the drive,
    /// (s + t) F p½/m, is added to the motor.
    #[cold]
    fn kick_one_by_one<S>(&mut self, system: &S, [s, t]: [V::Scalar; 2]) -> Result<u64, StepFailure>
    where
        S: Separable<V::Scalar> + ?Sized,
    {
        let Self { q, p, gain, hq, rate: momenta, inverse_mass, first_motor, .. } = self;
        let (q, p, gain) = (q.as_slice(), p.as_mut_slice(), gain.as_mut_slice());
        let momenta = momenta.as_mut_slice();
        let mut iterations = 0;
        for j in 0..*first_motor {
            let supply = if *first_motor < q.len() { system.supply(q, j) } else { None };
            let pushed = supply.map_or(V::Scalar::zero(), |supply| supply.force);
            let force = pushed - hq.as_slice()[j];
            let kicked = s.mul_add(force, p[j]);
            let half = kick(system, q, momenta, j, kicked, s)?;
            iterations += half.iterations;
            let displacement = (s + t) * inverse_mass.as_slice()[j] * half.p;
            p[j] = t.mul_add(force - half.drag, half.p);
            gain[j] = displacement.mul_add(half.drag - pushed, gain[j]);
            if let Some(supply) = supply {
                p[supply.motor] = displacement.mul_add(supply.force, p[supply.motor]);
                gain[supply.motor] = displacement.mul_add(-supply.force, gain[supply.motor]);
            }
        }
        // The momentum of a clock is the energy pumped.
        let motors = p.iter_mut().zip(hq.as_slice()).skip(*first_motor);
        motors.for_each(|(p, &hq)| *p = (s + t).mul_add(-hq, *p));
        Ok(iterations)
    }
}
