//! The damped β-chain of Fermi, Pasta, Ulam and Tsingou: n equal masses between two walls,
//! neighbours joined by springs that harden.
//!
//! ```text
//! q_j' = p_j        p_j' = f(r_j) - f(r_{j-1}) - c p_j        w_j' = c p_j²        j = 1..n
//! H = Σ p_j²/2 + Σ_{i=0..n} (r_i²/2 + β r_i⁴/4)               D_j = c p_j
//! r_i = q_{i+1} - q_i        f(r) = r + β r³                  q_0 = q_{n+1} = 0
//! ```
//!
//! Parameters: n ≥ 1 masses; β in 1/length² and c in 1/time, both any finite number. A mass of 1 on
//! a spring of stiffness 1 fixes the unit of time. β < 0 softens the springs and leaves V unbounded
//! below.
//!
//! The mirror image of a solution, q_j ↔ q_{n+1-j}, is a solution, and so is its negative. For
//! β = 0 mode i, q_j = sin(πij/(n+1)), is a damped oscillator with ω² = 4 sin²(πi/(2n+2)).
//! Otherwise references come from `tests/data/many_degrees.py`, made by another library, and from
//! [`afterbay_core::taylor::trajectory`].

use crate::chain::{Bond, Chain};
use crate::family::{BY_SIZE, Family, Parameter, exactly};
use crate::{at_least_one, finite, is_zero};
use afterbay_core::{InputError, Line, Members, Scalar, Uniform, f64x8};
use std::any::Any;
use std::sync::Arc;

/// The chain with [`CubicSpring`]s.
pub type FputChain<T> = Chain<T, CubicSpring<T>>;

/// u(r) = r²/2 + β r⁴/4
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CubicSpring<T> {
    beta: T,
}

impl<T: Scalar> FputChain<T> {
    /// The chain of n masses with springs of stiffness 1 + 3 β r² and damping c.
    ///
    /// # Errors
    /// [`InputError::Parameter`] if n is 0 or another is not finite.
    pub fn new(n: usize, beta: T, c: T) -> Result<Self, InputError> {
        Self::of(at_least_one(n)?, CubicSpring { beta: finite("beta", beta)? }, c)
    }

    /// The system in another scalar.
    pub fn map<U: Scalar>(&self, f: impl Fn(T) -> U) -> FputChain<U> {
        self.with(CubicSpring { beta: f(self.bond.beta) }, f)
    }
}

impl<T: Scalar> Bond<T> for CubicSpring<T> {
    const UNIFORM: bool = true;

    #[inline(always)]
    fn stored(&self, r: T) -> T {
        let square = r * r;
        (square * self.beta.half().mul_add(square, T::one())).half()
    }

    #[inline(always)]
    fn tension(&self, r: T) -> T {
        r * self.beta.mul_add(r * r, T::one())
    }

    /// f'(r) = 1 + 3 β r²
    #[inline(always)]
    fn stiffness(&self, r: T) -> T {
        let slope = self.beta * (r * r);
        T::one() + (slope + slope + slope)
    }

    /// `(r + s) [1/2 + β/4 (r² + s²)]`
    #[inline(always)]
    fn mean_tension(&self, r: T, s: T) -> Line<T> {
        let (sum, half_beta) = (r + s, self.beta.half());
        let stiffness = half_beta.half().mul_add(s.mul_add(s, r * r), T::one().half());
        Line { value: sum * stiffness, slope: (half_beta * s).mul_add(sum, stiffness) }
    }

    #[inline(always)]
    fn is_linear(&self) -> bool {
        is_zero(self.beta)
    }

    fn members(chain: Arc<FputChain<T>>) -> Option<Arc<dyn Members>> {
        let of_f64 = (chain as Arc<dyn Any + Send + Sync>).downcast::<FputChain<f64>>().ok();
        of_f64.map(|chain| chain as Arc<dyn Members>)
    }
}

impl Uniform for FputChain<f64> {
    type Lanes = FputChain<f64x8>;

    fn lanes(&self) -> Result<FputChain<f64x8>, InputError> {
        Ok(self.map(f64x8::from))
    }
}

impl Family for FputChain<f64> {
    type Of<T: Scalar> = FputChain<T>;

    const NAME: &'static str = "fput-chain";
    const EQUATIONS: &'static str =
        "V = Σ (r_i²/2 + β r_i⁴/4), r_i = q_{i+1} - q_i, fixed ends, D_j = c p_j";
    const PARAMETERS: &'static [Parameter] = &[
        Parameter::new("n", "1"),
        Parameter::new("beta", "1/length²"),
        Parameter::new("c", "1/time"),
    ];
    const RANGES: &'static str = "n ≥ 1";
    const SOLUTION: &'static str = BY_SIZE;
    const DOF: Option<usize> = None;

    fn make<T: Scalar>(n: usize, parameters: &[T]) -> Result<FputChain<T>, InputError> {
        let [beta, c] = exactly(parameters)?;
        FputChain::new(n, beta, c)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use afterbay_core::{Separable, System};

    #[test]
    fn parameters_have_their_range() {
        let nan = f64::NAN;
        for (system, name) in [
            (FputChain::new(0, 1.0, 0.1), "n"),
            (FputChain::new(3, nan, 0.1), "beta"),
            (FputChain::new(3, 1.0, f64::INFINITY), "c"),
        ] {
            assert!(
                matches!(system, Err(InputError::Parameter { name: found, .. }) if found == name)
            );
        }
    }

    /// One mass hangs on two bonds of length q: V = q² + β q⁴/2.
    #[test]
    fn one_mass_is_a_duffing_oscillator() {
        let (chain, duffing) =
            (FputChain::new(1, 0.5, 0.25).unwrap(), crate::Duffing::new(2.0, 1.0, 0.25).unwrap());
        let (q, p, to) = ([1.5], [-0.5], -0.75);
        assert_eq!(chain.energy(&q, &p), duffing.energy(&q, &p));
        assert_eq!(chain.partial(&q, 0, to), duffing.partial(&q, 0, to));
        assert_eq!(chain.divided_difference(&q, 0, to), duffing.divided_difference(&q, 0, to));
        assert_eq!(chain.dissipation_of(&q, &p, 0), duffing.dissipation_of(&q, &p, 0));
    }
}
