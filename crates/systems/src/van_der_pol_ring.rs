//! n Van der Pol oscillators in a circle, each joined to the next by a linear spring.
//!
//! ```text
//! q_j' = p_j        p_j' = -q_j + κ (q_{j+1} - 2 q_j + q_{j-1}) - D_j        w_j' = D_j p_j
//! H = Σ [p_j²/2 + q_j²/2 + κ/2 (q_{j+1} - q_j)²]
//! D_j = -μ (1 - q_j²) p_j        j = 1..n, q_{n+1} = q_1
//! ```
//!
//! Parameters: n ≥ 1 oscillators; the nonlinearity μ and the coupling κ, any finite numbers,
//! without a unit: q is measured in half-widths of the driven strip, time in periods of a single
//! oscillator over 2π. κ ≥ -1/4 keeps V from falling below 0. Two oscillators are joined by two
//! springs, one on either side. A single one has no spring and is the [`VanDerPol`] oscillator.
//!
//! Invariant: K = H + Σ w_j. For μ ≠ 0 every reservoir gives and takes by turns, so D is never
//! passive. Turning the circle or its direction takes solutions to solutions; one in which all move
//! as one is that of a single oscillator. There is no closed solution: references come from
//! `tests/data/many_degrees.py`, made by another library, and from
//! [`afterbay_core::taylor::trajectory`].

use crate::family::{BY_SIZE, Family, Parameter, exactly};
use crate::{VanDerPol, at_least_one, finite, inner, sum};
use afterbay_core::{
    Abilities, Block, Coupling, Curvature, Dissipation, DissipationForm, InputError, Line, Members,
    Scalar, SecondDerivatives, Separable, System, Uniform, f64x8,
};
use std::any::Any;
use std::sync::Arc;

/// V = Σ [q_j²/2 + κ/2 (q_{j+1} - q_j)²], around the circle, with D_j = -μ (1 - q_j²) p_j.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VanDerPolRing<T> {
    n: usize,
    single: VanDerPol<T>,
    /// κ; 0 for n = 1, where there is no bond.
    coupling: T,
}

impl<T: Scalar> VanDerPolRing<T> {
    /// The ring of n oscillators with nonlinearity μ and coupling κ.
    ///
    /// # Errors
    /// [`InputError::Parameter`] if n is 0 or another is not finite.
    pub fn new(n: usize, mu: T, coupling: T) -> Result<Self, InputError> {
        let (n, single) = (at_least_one(n)?, VanDerPol::new(mu)?);
        let coupling = finite("coupling", coupling)?;
        Ok(Self { n, single, coupling: if n == 1 { T::zero() } else { coupling } })
    }

    /// The system in another scalar.
    pub fn map<U: Scalar>(&self, f: impl Fn(T) -> U) -> VanDerPolRing<U> {
        VanDerPolRing { n: self.n, single: self.single.map(&f), coupling: f(self.coupling) }
    }

    /// ∂V/∂q_j where q_j is `at`.
    #[inline(always)]
    fn pull(&self, left: T, at: T, right: T) -> T {
        self.coupling.mul_add((at - left) + (at - right), at)
    }
}

/// The neighbours of j around the circle of n.
#[inline(always)]
fn beside(n: usize, j: usize) -> (usize, usize) {
    (if j == 0 { n - 1 } else { j - 1 }, if j + 1 == n { 0 } else { j + 1 })
}

impl<T: Scalar> System<T> for VanDerPolRing<T> {
    #[inline(always)]
    fn dof(&self) -> usize {
        self.n
    }

    #[inline]
    fn energy(&self, q: &[T], p: &[T]) -> T {
        let closing = q[0] - q[q.len() - 1];
        let bonds = sum(q, |&[a, b]| (b - a) * (b - a)) + closing * closing;
        (sum(p, |&[p]| p * p) + sum(q, |&[q]| q * q) + self.coupling * bonds).half()
    }

    #[inline]
    fn gradient(&self, q: &[T], p: &[T], hq: &mut [T], hp: &mut [T]) {
        let last = q.len() - 1;
        hq[0] = self.partial(q, 0, q[0]);
        hq[last] = self.partial(q, last, q[last]);
        inner(q, hq, |&[left, at, right]| self.pull(left, at, right));
        hp.copy_from_slice(p);
    }

    #[inline(always)]
    fn dissipation(&self, q: &[T], _p: &[T], v: &[T], d: &mut [T]) {
        for ((d, &q), &v) in d.iter_mut().zip(q).zip(v) {
            *d = self.single.dissipation_rate(q) * v;
        }
    }

    #[inline(always)]
    fn unit_mass(&self) -> bool {
        true
    }

    #[inline(always)]
    fn dissipation_form(&self) -> DissipationForm {
        self.single.dissipation_form()
    }

    #[inline(always)]
    fn coupling(&self) -> Coupling {
        Coupling::Ring
    }
}

impl<T: Scalar> Separable<T> for VanDerPolRing<T> {
    #[inline(always)]
    fn partial(&self, q: &[T], j: usize, at: T) -> T {
        let (left, right) = beside(q.len(), j);
        self.pull(q[left], at, q[right])
    }

    /// V is quadratic: the mean is the derivative in the middle.
    #[inline(always)]
    fn divided_difference(&self, q: &[T], j: usize, to: T) -> Line<T> {
        Line {
            value: self.partial(q, j, (q[j] + to).half()),
            slope: T::one().half() + self.coupling,
        }
    }

    #[inline(always)]
    fn has_exact_divided_differences(&self) -> bool {
        true
    }

    #[inline(always)]
    fn dissipation_of(&self, q: &[T], p: &[T], j: usize) -> Dissipation<T> {
        self.single.dissipation_of(&q[j..], &p[j..], 0)
    }
}

impl Uniform for VanDerPolRing<f64> {
    type Lanes = VanDerPolRing<f64x8>;

    fn lanes(&self) -> Result<VanDerPolRing<f64x8>, InputError> {
        Ok(self.map(f64x8::from))
    }
}

impl<T: Scalar> Curvature<T> for VanDerPolRing<T> {
    #[inline]
    fn curvature(&self, q: &[T], p: &[T], mut put: impl FnMut(Block, usize, usize, T)) {
        let twice = self.coupling + self.coupling;
        for j in 0..q.len() {
            let (left, right) = beside(q.len(), j);
            put(Block::Hqq, j, j, T::one() + twice);
            if left != right {
                put(Block::Hqq, j, left, -self.coupling);
                put(Block::Hqq, j, right, -self.coupling);
            } else if left != j {
                put(Block::Hqq, j, left, -twice);
            }
            put(Block::Hpp, j, j, T::one());
            let drag = self.dissipation_of(q, p, j);
            put(Block::Dq, j, j, drag.by_q);
            put(Block::Dp, j, j, drag.by_p);
        }
    }

    #[inline(always)]
    fn is_linear(&self) -> bool {
        self.single.is_linear()
    }
}

impl<T: Scalar> Abilities<T> for VanDerPolRing<T> {
    fn separable(self: Arc<Self>) -> Option<Arc<dyn Separable<T>>> {
        Some(self)
    }

    fn second_derivatives(self: Arc<Self>) -> Option<Arc<dyn SecondDerivatives<T>>> {
        Some(self)
    }

    fn is_uniform(&self) -> bool {
        true
    }

    fn uniform(self: Arc<Self>) -> Option<Arc<dyn Members>> {
        let of_f64 = (self as Arc<dyn Any + Send + Sync>).downcast::<VanDerPolRing<f64>>().ok();
        of_f64.map(|system| system as Arc<dyn Members>)
    }
}

impl Family for VanDerPolRing<f64> {
    type Of<T: Scalar> = VanDerPolRing<T>;

    const NAME: &'static str = "van-der-pol-ring";
    const EQUATIONS: &'static str =
        "V = Σ [q_j²/2 + κ/2 (q_{j+1} - q_j)²], periodic, D_j = -μ (1 - q_j²) p_j";
    const PARAMETERS: &'static [Parameter] =
        &[Parameter::new("n", "1"), Parameter::new("mu", "1"), Parameter::new("coupling", "1")];
    const RANGES: &'static str = "n ≥ 1 (coupling: κ)";
    const SOLUTION: &'static str = BY_SIZE;
    const DOF: Option<usize> = None;

    fn make<T: Scalar>(n: usize, parameters: &[T]) -> Result<VanDerPolRing<T>, InputError> {
        let [mu, coupling] = exactly(parameters)?;
        VanDerPolRing::new(n, mu, coupling)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_have_their_range() {
        let nan = f64::NAN;
        for (system, name) in [
            (VanDerPolRing::new(0, 1.0, 0.3), "n"),
            (VanDerPolRing::new(3, nan, 0.3), "mu"),
            (VanDerPolRing::new(3, 1.0, nan), "coupling"),
            (VanDerPolRing::new(1, 1.0, nan), "coupling"),
        ] {
            assert!(
                matches!(system, Err(InputError::Parameter { name: found, .. }) if found == name)
            );
        }
    }

    #[test]
    fn only_without_mu_is_it_passive() {
        let damping = |mu: f64| VanDerPolRing::new(3, mu, 0.3).unwrap().dissipation_form();
        assert_eq!(damping(0.0), DissipationForm::NONE);
        assert_eq!(damping(5.0), DissipationForm::LINEAR);
    }

    #[test]
    fn one_alone_is_a_van_der_pol_oscillator() {
        let (ring, single) =
            (VanDerPolRing::new(1, 1.5, 7.0).unwrap(), VanDerPol::new(1.5).unwrap());
        let (q, p, to) = ([0.75], [-1.25], -0.5);
        assert_eq!(ring.energy(&q, &p), single.energy(&q, &p));
        assert_eq!(ring.partial(&q, 0, to), single.partial(&q, 0, to));
        assert_eq!(ring.divided_difference(&q, 0, to), single.divided_difference(&q, 0, to));
        assert_eq!(ring.dissipation_of(&q, &p, 0), single.dissipation_of(&q, &p, 0));
    }

    #[test]
    fn two_are_joined_by_two_springs() {
        let ring = VanDerPolRing::new(2, 1.0, 0.5).unwrap();
        // q²/2 for each, and κ (q2 - q1)².
        assert_eq!(ring.energy(&[1.0, 3.0], &[0.0; 2]), 0.5 + 4.5 + 2.0);
        assert_eq!(ring.partial(&[1.0, 3.0], 0, 1.0), 1.0 - 2.0);
    }
}
