//! Driven systems: forces F(q, t), whose work has an account of its own.
//!
//! ```text
//! q_j' = ∂H/∂p_j        p_j' = -∂H/∂q_j - D_j + F_j(q, t)
//! w_j' = D_j ∂H/∂p_j  (dissipated)        s_j' = F_j ∂H/∂p_j  (supplied)
//! K = H + Σ w_j - Σ s_j is constant
//! ```
//!
//! [`Driven`] makes an autonomous system of it, to which every method applies as it is. Each driven
//! degree of freedom j has a motor: one more degree of freedom m, whose coordinate is the time and
//! whose momentum is the energy it has supplied.
//!
//! ```text
//! H̃ = H + Σ p_m        D̃_j = D_j - F_j(q, q_m)        D̃_m = -F_j(q, q_m) v_j
//! q_m = t        p_m = s_j        w_m = -s_j        w̃_j = w_j - s_j
//! ```
//!
//! So H̃ + Σ w̃ = H + Σ w - Σ s. A discrete gradient passes one mean force and one mean velocity
//! to both D̃_j and D̃_m. The energy that leaves the account s_j therefore enters the account of j,
//! to rounding.

mod abilities;
mod curvature;

use super::dissipation::{Dissipation, DissipationForm, Passive};
use super::hamiltonian::System;
use super::harmonics::Harmonics;
use super::separable::{Separable, Supply};
use crate::error::InputError;
use crate::numbers::{Line, Scalar};
use std::sync::Arc;

/// Forces on some degrees of freedom, which depend on the coordinates and the time.
pub trait Drive<T: Scalar>: Send + Sync {
    /// The driven degrees of freedom, in increasing order.
    fn driven(&self) -> &[usize];

    /// F_j(q, t) for entry k of [`Drive::driven`].
    fn force(&self, k: usize, q: &[T], t: T) -> T;

    /// Passes the slopes of the F_j of [`Drive::force`] to `put`: ∂F_j/∂q_i with `Some(i)`, and
    /// ∂F_j/∂t with `None`. The slopes passed, and their order, must not depend on the state.
    fn slopes(&self, k: usize, q: &[T], t: T, put: &mut dyn FnMut(Option<usize>, T));

    /// Whether F_j for entry k of [`Drive::driven`] depends on q_j itself. Where it does not,
    /// methods compute it once a step.
    fn depends_on_own(&self, _k: usize) -> bool {
        true
    }

    /// Whether F_j for entry k of [`Drive::driven`] depends on any coordinate.
    fn depends_on_coordinates(&self, _k: usize) -> bool {
        true
    }

    /// F_j for entry k of [`Drive::driven`] as a sum of sines and cosines, if it is known to be one
    /// and depends on no coordinate. `linear-exact` takes the sum in place of the force;
    /// [`crate::validate::drive`] compares the two.
    fn harmonics(&self, _k: usize) -> Option<Harmonics<T>> {
        None
    }

    /// Passes to `put` the value of every function at whose zeros F may not be analytic
    /// ([`System::kinks`]).
    fn kinks(&self, _q: &[T], _t: T, _put: &mut dyn FnMut(T)) {}

    /// Passes to `put` the functions of [`Drive::kinks`] that depend on q, not on t alone
    /// ([`System::kinks_of_state`]).
    fn kinks_of_state(&self, q: &[T], t: T, put: &mut dyn FnMut(T)) {
        self.kinks(q, t, put);
    }

    /// Whether F may be singular at some time.
    fn may_be_singular(&self) -> bool {
        false
    }

    /// Whether F is singular at some time between two ([`System::is_singular_between`]).
    fn is_singular_between(&self, _from: T, _to: T) -> bool {
        false
    }

    /// The length of the next step from t, at most h > 0, that contains no break: an instant at
    /// which F jumps in t or has a kink. A step that starts before the next break ends just before
    /// it; one that starts at a break is a few roundings long and ends just after it.
    fn step_between_breaks(&self, _t: T, h: T) -> T {
        h
    }
}

/// A system with N degrees of freedom and a drive: N + M degrees of freedom, the last M of which
/// are the motors. The system may have a clock ([`crate::Clocked`]), which is then one of its N.
pub struct Driven<S: ?Sized, D: ?Sized> {
    system: Arc<S>,
    drive: Arc<D>,
    /// The number of degrees of freedom of the system alone.
    dof: usize,
    /// The motor of each degree of freedom, if it is driven.
    motors: Vec<Option<usize>>,
}

impl<S: ?Sized, D: ?Sized> Driven<S, D> {
    /// Adds a drive to a system.
    ///
    /// # Errors
    /// [`InputError::Unsupported`] if the drive acts on a degree of freedom that the system does
    /// not have, or twice on one, or if the system has a drive already.
    pub fn new<T: Scalar>(system: Arc<S>, drive: Arc<D>) -> Result<Self, InputError>
    where
        S: System<T>,
        D: Drive<T>,
    {
        let dof = system.dof();
        if (0..dof).any(|motor| system.driven_by(motor).is_some()) {
            let why = "the system has a drive already: add the forces of both";
            return Err(InputError::Unsupported { method: "a drive", why });
        }
        let mut motors = vec![None; dof];
        for (k, &j) in drive.driven().iter().enumerate() {
            let why = match motors.get_mut(j) {
                Some(motor @ None) => {
                    *motor = Some(k);
                    continue;
                }
                Some(_) => "it acts twice on one degree of freedom: add the forces",
                None => "it acts on a degree of freedom that the system does not have",
            };
            return Err(InputError::Unsupported { method: "a drive", why });
        }
        Ok(Self { system, drive, dof, motors })
    }

    /// The system alone.
    pub fn undriven(&self) -> &Arc<S> {
        &self.system
    }

    /// The forces on it.
    pub fn drive(&self) -> &Arc<D> {
        &self.drive
    }

    /// Writes D of the system and of its motors under these forces.
    #[inline(always)]
    fn under<T: Scalar>(&self, force: impl Fn(usize) -> T, q: &[T], p: &[T], v: &[T], d: &mut [T])
    where
        S: System<T>,
        D: Drive<T>,
    {
        let n = self.dof;
        self.system.dissipation(&q[..n], &p[..n], &v[..n], &mut d[..n]);
        self.add_forces(force, v, d);
    }

    /// Completes D, of which the part of the system is given, by these forces.
    #[inline(always)]
    fn add_forces<T: Scalar>(&self, force: impl Fn(usize) -> T, v: &[T], d: &mut [T])
    where
        D: Drive<T>,
    {
        let (d, of_motors) = d.split_at_mut(self.dof);
        for (k, &j) in self.drive.driven().iter().enumerate() {
            let force = force(k);
            d[j] -= force;
            of_motors[k] = -force * v[j];
        }
    }

    /// The motor of degree of freedom j and the number of its force.
    fn motor(&self, j: usize) -> Option<(usize, usize)> {
        self.motors.get(j).copied().flatten().map(|k| (self.dof + k, k))
    }
}

/// The number of points that are passed on together. A choice: the most nodes of a step.
const TOGETHER: usize = 8;

/// The first n entries of each of up to eight slices.
fn heads<'a, T>(of: &[&'a [T]], n: usize) -> [&'a [T]; TOGETHER] {
    std::array::from_fn(|i| of.get(i).map_or(&[][..], |x| &x[..n]))
}

/// The first n entries of each of up to eight slices, to write to.
fn heads_mut<'a, T>(of: &'a mut [&mut [T]], n: usize) -> [&'a mut [T]; TOGETHER] {
    let mut each = of.iter_mut();
    std::array::from_fn(|_| each.next().map_or(&mut [][..], |x| &mut x[..n]))
}

impl<T: Scalar, S: System<T> + ?Sized, D: Drive<T> + ?Sized> System<T> for Driven<S, D> {
    fn dof(&self) -> usize {
        self.dof + self.drive.driven().len()
    }

    fn check(&self) -> Result<(), InputError> {
        self.system.check()
    }

    fn energy(&self, q: &[T], p: &[T]) -> T {
        let (p, supplied) = p.split_at(self.dof);
        supplied.iter().fold(self.system.energy(&q[..self.dof], p), |sum, &s| sum + s)
    }

    fn gradient(&self, q: &[T], p: &[T], hq: &mut [T], hp: &mut [T]) {
        let (hq, no_force) = hq.split_at_mut(self.dof);
        let (hp, speed) = hp.split_at_mut(self.dof);
        self.system.gradient(&q[..self.dof], &p[..self.dof], hq, hp);
        no_force.fill(T::zero());
        speed.fill(T::one());
    }

    fn dissipation(&self, q: &[T], p: &[T], v: &[T], d: &mut [T]) {
        let (own, times) = q.split_at(self.dof);
        self.under(|k| self.drive.force(k, own, times[k]), q, p, v, d);
    }

    fn has_batches(&self) -> bool {
        self.system.has_batches()
    }

    fn gradients(&self, q: &[&[T]], p: &[&[T]], hq: &mut [&mut [T]], hp: &mut [&mut [T]]) {
        let n = self.dof;
        let points = q.chunks(TOGETHER).zip(p.chunks(TOGETHER));
        let slopes = hq.chunks_mut(TOGETHER).zip(hp.chunks_mut(TOGETHER));
        for ((q, p), (hq, hp)) in points.zip(slopes) {
            let count = q.len();
            let (q, p) = (heads(q, n), heads(p, n));
            let (mut own_hq, mut own_hp) = (heads_mut(hq, n), heads_mut(hp, n));
            let slopes = (&mut own_hq[..count], &mut own_hp[..count]);
            self.system.gradients(&q[..count], &p[..count], slopes.0, slopes.1);
            hq.iter_mut().for_each(|no_force| no_force[n..].fill(T::zero()));
            hp.iter_mut().for_each(|speed| speed[n..].fill(T::one()));
        }
    }

    fn dissipations(&self, q: &[&[T]], p: &[&[T]], v: &[&[T]], d: &mut [&mut [T]]) {
        let n = self.dof;
        let points = q.chunks(TOGETHER).zip(p.chunks(TOGETHER)).zip(v.chunks(TOGETHER));
        for (((q, p), v), d) in points.zip(d.chunks_mut(TOGETHER)) {
            let count = q.len();
            let [own_q, own_p, own_v] = [q, p, v].map(|x| heads(x, n));
            let mut own_d = heads_mut(d, n);
            let [own_q, own_p, own_v] = [&own_q, &own_p, &own_v].map(|x| &x[..count]);
            self.system.dissipations(own_q, own_p, own_v, &mut own_d[..count]);
            for ((q, v), d) in q.iter().zip(v).zip(d) {
                let (own, times) = q.split_at(n);
                self.add_forces(|k| self.drive.force(k, own, times[k]), v, d);
            }
        }
    }

    fn motor_forces(&self, q: &[T], forces: &mut [T]) -> bool {
        let (q, times) = q.split_at(self.dof);
        for (k, force) in forces[self.dof..].iter_mut().enumerate() {
            *force = self.drive.force(k, q, times[k]);
        }
        !(0..times.len()).any(|k| self.drive.depends_on_coordinates(k))
    }

    fn dissipation_under(&self, forces: &[T], q: &[T], p: &[T], v: &[T], d: &mut [T]) {
        self.under(|k| forces[self.dof + k], q, p, v, d);
    }

    fn dissipation_form(&self) -> DissipationForm {
        let coupled = self.system.dissipation_form().coupled;
        DissipationForm { coupled, passive: Passive::No, ..DissipationForm::GENERAL }
    }

    fn motors(&self) -> usize {
        self.system.motors() + self.drive.driven().len()
    }

    fn driven_by(&self, motor: usize) -> Option<usize> {
        self.drive.driven().get(motor.checked_sub(self.dof)?).copied()
    }

    fn kinks(&self, q: &[T], p: &[T], put: &mut dyn FnMut(T)) {
        let (q, times) = q.split_at(self.dof);
        self.system.kinks(q, &p[..self.dof], put);
        if let Some(&t) = times.first() {
            self.drive.kinks(q, t, put);
        }
    }

    fn kinks_of_state(&self, q: &[T], p: &[T], put: &mut dyn FnMut(T)) {
        let (q, times) = q.split_at(self.dof);
        self.system.kinks_of_state(q, &p[..self.dof], put);
        if let Some(&t) = times.first() {
            self.drive.kinks_of_state(q, t, put);
        }
    }

    fn step_between_breaks(&self, q: &[T], h: T) -> T {
        let (own, times) = q.split_at(self.dof);
        let h = self.system.step_between_breaks(own, h);
        times.first().map_or(h, |&t| self.drive.step_between_breaks(t, h))
    }

    fn has_breaks(&self) -> bool {
        self.system.has_breaks()
    }

    fn may_be_singular(&self) -> bool {
        self.system.may_be_singular() || self.drive.may_be_singular()
    }

    fn is_singular_between(&self, from: &[T], to: &[T]) -> bool {
        let ((from, start), (to, end)) = (from.split_at(self.dof), to.split_at(self.dof));
        let times = start.first().zip(end.first());
        self.system.is_singular_between(from, to)
            || times.is_some_and(|(&start, &end)| self.drive.is_singular_between(start, end))
    }
}

impl<T: Scalar, S: Separable<T> + ?Sized, D: Drive<T> + ?Sized> Separable<T> for Driven<S, D> {
    fn mass(&self, j: usize) -> T {
        if j < self.dof { self.system.mass(j) } else { T::one() }
    }

    fn partial(&self, q: &[T], j: usize, at: T) -> T {
        if j < self.dof { self.system.partial(&q[..self.dof], j, at) } else { T::zero() }
    }

    fn divided_difference(&self, q: &[T], j: usize, to: T) -> Line<T> {
        if j < self.dof {
            self.system.divided_difference(&q[..self.dof], j, to)
        } else {
            Line { value: T::zero(), slope: T::zero() }
        }
    }

    fn has_exact_divided_differences(&self) -> bool {
        self.system.has_exact_divided_differences()
    }

    fn is_singular_along(&self, q: &[T], j: usize, to: T) -> bool {
        if j < self.dof {
            self.system.is_singular_along(&q[..self.dof], j, to)
        } else {
            self.drive.is_singular_between(q[j], to)
        }
    }

    fn dissipation_of(&self, q: &[T], p: &[T], j: usize) -> Dissipation<T> {
        let zero = T::zero();
        let (q, times) = q.split_at(self.dof);
        if j >= self.dof {
            return Dissipation { value: zero, by_q: zero, by_p: zero };
        }
        let mut drag = self.system.dissipation_of(q, &p[..self.dof], j);
        if let Some((_, k)) = self.motor(j) {
            drag.value -= self.drive.force(k, q, times[k]);
            if self.drive.depends_on_own(k) {
                self.drive.slopes(k, q, times[k], &mut |by, slope| {
                    if by == Some(j) {
                        drag.by_q -= slope;
                    }
                });
            }
        }
        drag
    }

    fn friction_of(&self, q: &[T], p: &[T], j: usize) -> Dissipation<T> {
        if j < self.dof {
            self.system.friction_of(&q[..self.dof], &p[..self.dof], j)
        } else {
            self.dissipation_of(q, p, j)
        }
    }

    fn supply(&self, q: &[T], j: usize) -> Option<Supply<T>> {
        let (motor, k) = self.motor(j)?;
        let force = self.drive.force(k, &q[..self.dof], q[motor]);
        Some(Supply { motor, force, depends_on_own: self.drive.depends_on_own(k) })
    }
}
