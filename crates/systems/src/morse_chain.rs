//! The damped Morse chain: n equal masses between two walls, neighbours joined by bonds that break.
//!
//! ```text
//! q_j' = p_j        p_j' = f(r_j) - f(r_{j-1}) - c p_j        w_j' = c p_j²        j = 1..n
//! H = Σ p_j²/2 + Σ_{i=0..n} u(r_i)                            D_j = c p_j
//! u(r) = ε (1 - e^{-a r})²    f(r) = u'(r)    r_i = q_{i+1} - q_i    q_0 = q_{n+1} = 0
//! ```
//!
//! Parameters, for a unit mass: n ≥ 1 masses; the bond energy ε in length²/time² and the damping c
//! in 1/time, both any finite number; a > 0 in 1/length, the inverse width of the well. A bond is
//! as stiff as a spring of 2 ε a² near r = 0, stiffens when compressed, and for r → ∞ loses its
//! force at the energy ε. c > 0 is passive in every degree of freedom, c < 0 is active.
//!
//! Invariants: K = H + Σ w_j, and H itself at c = 0. There is no solution in closed form:
//! references come from [`afterbay_core::taylor::trajectory`]. (P. M. Morse, Phys. Rev. 34 (1929)
//! 57, for the potential.)

use crate::catalog::{BY_SIZE, Family, Parameter, exactly};
use crate::walls::{self, beside};
use crate::{at_least_one, finite, inner, linear_dissipation, positive, sum};
use afterbay_core::divided;
use afterbay_core::{
    Abilities, Block, Coupling, Curvature, Dissipation, DissipationForm, InputError, Line, Scalar,
    SecondDerivatives, Separable, Slope, System,
};
use std::sync::Arc;

/// V = Σ ε (1 - e^{-a r})² over the bonds, with D_j = c p_j.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MorseChain<T> {
    n: usize,
    epsilon: T,
    a: T,
    c: T,
}

impl<T: Scalar> MorseChain<T> {
    /// The chain of n masses with bonds of energy ε and inverse width a, and damping c.
    ///
    /// # Errors
    /// [`InputError::Parameter`] if n is 0, a is not positive, or another is not finite.
    pub fn new(n: usize, epsilon: T, a: T, c: T) -> Result<Self, InputError> {
        let (n, a) = (at_least_one(n)?, positive("a", a)?);
        Ok(Self { n, epsilon: finite("epsilon", epsilon)?, a, c: finite("c", c)? })
    }

    /// The system in another scalar.
    pub fn map<U: Scalar>(&self, f: impl Fn(T) -> U) -> MorseChain<U> {
        MorseChain { n: self.n, epsilon: f(self.epsilon), a: f(self.a), c: f(self.c) }
    }

    /// u(r), for any scalar that the parameters can be lifted to.
    #[inline(always)]
    fn stored<S: Scalar>(&self, r: S, lift: impl Fn(T) -> S) -> S {
        let part = (-lift(self.a) * r).exp_m1();
        lift(self.epsilon) * (part * part)
    }

    /// f(r) = 2 ε a e^{-a r} (1 - e^{-a r})
    #[inline(always)]
    fn tension(&self, r: T) -> T {
        let part = (-self.a * r).exp_m1();
        -(self.epsilon + self.epsilon) * self.a * (part * (part + T::one()))
    }

    /// f'(r) = 2 ε a² e^{-a r} (2 e^{-a r} - 1)
    #[inline(always)]
    fn stiffness(&self, r: T) -> T {
        let decay = (-self.a * r).exp();
        (self.epsilon + self.epsilon) * self.a * self.a * (decay * (decay + decay - T::one()))
    }

    /// The mean of f from r to s, and its derivative by s.
    #[inline(always)]
    fn mean_tension(&self, r: T, s: T) -> Line<T> {
        divided::of_potential(r, s, |at| self.stored(at, Slope::constant))
    }
}

impl<T: Scalar> System<T> for MorseChain<T> {
    #[inline(always)]
    fn dof(&self) -> usize {
        self.n
    }

    #[inline]
    fn energy(&self, q: &[T], p: &[T]) -> T {
        let bond = |r: T| self.stored(r, |x| x);
        let walls = bond(q[0]) + bond(-q[q.len() - 1]);
        sum(p, |&[p]| p * p).half() + (sum(q, |&[a, b]| bond(b - a)) + walls)
    }

    #[inline]
    fn gradient(&self, q: &[T], p: &[T], hq: &mut [T], hp: &mut [T]) {
        let last = q.len() - 1;
        hq[0] = self.partial(q, 0, q[0]);
        hq[last] = self.partial(q, last, q[last]);
        inner(q, hq, |&[left, at, right]| self.tension(at - left) - self.tension(right - at));
        hp.copy_from_slice(p);
    }

    #[inline(always)]
    fn dissipation(&self, _q: &[T], _p: &[T], v: &[T], d: &mut [T]) {
        d.iter_mut().zip(v).for_each(|(d, &v)| *d = self.c * v);
    }

    #[inline(always)]
    fn unit_mass(&self) -> bool {
        true
    }

    #[inline(always)]
    fn dissipation_form(&self) -> DissipationForm {
        linear_dissipation(self.c)
    }

    #[inline(always)]
    fn coupling(&self) -> Coupling {
        Coupling::Chain
    }
}

impl<T: Scalar> Separable<T> for MorseChain<T> {
    #[inline(always)]
    fn partial(&self, q: &[T], j: usize, at: T) -> T {
        let (left, right) = beside(q, j);
        self.tension(at - left) - self.tension(right - at)
    }

    /// The mean tension of the left bond less that of the right bond, by slope arithmetic.
    #[inline]
    fn divided_difference(&self, q: &[T], j: usize, to: T) -> Line<T> {
        let (left, right) = beside(q, j);
        let before = self.mean_tension(q[j] - left, to - left);
        let after = self.mean_tension(right - q[j], right - to);
        Line { value: before.value - after.value, slope: before.slope + after.slope }
    }

    #[inline(always)]
    fn has_exact_divided_differences(&self) -> bool {
        true
    }

    #[inline(always)]
    fn dissipation_of(&self, _q: &[T], p: &[T], j: usize) -> Dissipation<T> {
        Dissipation { value: self.c * p[j], by_q: T::zero(), by_p: self.c }
    }
}

impl<T: Scalar> Curvature<T> for MorseChain<T> {
    #[inline]
    fn curvature(&self, q: &[T], _p: &[T], put: impl FnMut(Block, usize, usize, T)) {
        walls::curvature(q, |r| self.stiffness(r), self.c, put);
    }
}

impl<T: Scalar> Abilities<T> for MorseChain<T> {
    fn separable(self: Arc<Self>) -> Option<Arc<dyn Separable<T>>> {
        Some(self)
    }

    fn second_derivatives(self: Arc<Self>) -> Option<Arc<dyn SecondDerivatives<T>>> {
        Some(self)
    }
}

impl Family for MorseChain<f64> {
    type Of<T: Scalar> = MorseChain<T>;

    const NAME: &'static str = "morse-chain";
    const EQUATIONS: &'static str =
        "V = Σ ε (1 - e^{-a r_i})², r_i = q_{i+1} - q_i, fixed ends, D_j = c p_j";
    const PARAMETERS: &'static [Parameter] = &[
        Parameter::new("n", "1"),
        Parameter::new("epsilon", "length²/time²"),
        Parameter::new("a", "1/length"),
        Parameter::new("c", "1/time"),
    ];
    const RANGES: &'static str = "n ≥ 1, a > 0";
    const SOLUTION: &'static str = BY_SIZE;
    const DOF: Option<usize> = None;

    fn make<T: Scalar>(n: usize, parameters: &[T]) -> Result<MorseChain<T>, InputError> {
        let [epsilon, a, c] = exactly(parameters)?;
        MorseChain::new(n, epsilon, a, c)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_have_their_range() {
        for (system, name) in [
            (MorseChain::new(0, 1.0, 1.0, 0.1), "n"),
            (MorseChain::new(3, f64::NAN, 1.0, 0.1), "epsilon"),
            (MorseChain::new(3, 1.0, 0.0, 0.1), "a"),
            (MorseChain::new(3, 1.0, 1.0, f64::INFINITY), "c"),
        ] {
            assert!(
                matches!(system, Err(InputError::Parameter { name: found, .. }) if found == name)
            );
        }
    }

    /// For weak extension the bonds are springs of stiffness 2 ε a², as in a chain without β.
    #[test]
    fn a_chain_near_rest_is_a_chain_of_springs() {
        let morse = MorseChain::new(3, 0.5, 1.0, 0.25).unwrap();
        let springs = crate::FputChain::new(3, 0.0, 0.25).unwrap();
        let (q, p) = ([1e-7, -2e-7, 3e-7], [0.0; 3]);
        let [mut force, mut exact, mut hp] = [[0.0; 3]; 3];
        morse.gradient(&q, &p, &mut force, &mut hp);
        springs.gradient(&q, &p, &mut exact, &mut hp);
        for (force, exact) in force.into_iter().zip(exact) {
            assert!((force - exact).abs() < 1e-12, "{force} {exact}");
        }
    }
}
