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
//! force at the energy ε.
//!
//! There is no solution in closed form: references come from [`afterbay_core::taylor::trajectory`].
//! (P. M. Morse, Phys. Rev. 34 (1929) 57, for the potential.)

use crate::chain::{Bond, Chain};
use crate::family::{BY_SIZE, Family, Parameter, exactly};
use crate::{at_least_one, finite, positive};
use afterbay_core::{InputError, Line, Scalar, Slope, divided};

/// The chain with [`MorseBond`]s.
pub type MorseChain<T> = Chain<T, MorseBond<T>>;

/// u(r) = ε (1 - e^{-a r})²
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MorseBond<T> {
    epsilon: T,
    a: T,
}

impl<T: Scalar> MorseChain<T> {
    /// The chain of n masses with bonds of energy ε and inverse width a, and damping c.
    ///
    /// # Errors
    /// [`InputError::Parameter`] if n is 0, a is not positive, or another is not finite.
    pub fn new(n: usize, epsilon: T, a: T, c: T) -> Result<Self, InputError> {
        let (n, a) = (at_least_one(n)?, positive("a", a)?);
        Self::of(n, MorseBond { epsilon: finite("epsilon", epsilon)?, a }, c)
    }

    /// The system in another scalar.
    pub fn map<U: Scalar>(&self, f: impl Fn(T) -> U) -> MorseChain<U> {
        let MorseBond { epsilon, a } = self.bond;
        self.with(MorseBond { epsilon: f(epsilon), a: f(a) }, f)
    }
}

impl<T: Scalar> MorseBond<T> {
    /// u(r), for any scalar that the parameters can be lifted to.
    #[inline(always)]
    fn potential<S: Scalar>(&self, r: S, lift: impl Fn(T) -> S) -> S {
        let part = (-lift(self.a) * r).exp_m1();
        lift(self.epsilon) * (part * part)
    }
}

impl<T: Scalar> Bond<T> for MorseBond<T> {
    #[inline(always)]
    fn stored(&self, r: T) -> T {
        self.potential(r, |x| x)
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

    /// The divided difference of u, by slope arithmetic.
    #[inline]
    fn mean_tension(&self, r: T, s: T) -> Line<T> {
        divided::of_potential(r, s, |at| self.potential(at, Slope::constant))
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
}
