//! A damped chain of n equal masses between two walls, neighbours joined by bonds of one kind.
//!
//! ```text
//! q_j' = p_j        p_j' = f(r_j) - f(r_{j-1}) - c p_j        w_j' = c p_j²        j = 1..n
//! H = Σ p_j²/2 + Σ_{i=0..n} u(r_i)                            D_j = c p_j
//! f = u'            r_i = q_{i+1} - q_i                       q_0 = q_{n+1} = 0
//! ```
//!
//! The mass is 1; c in 1/time is any finite number. c > 0 is passive in every degree of freedom,
//! c < 0 is active. K = H + Σ w_j is invariant, and so is H at c = 0; volumes in phase space shrink
//! by e^{-nct}.

use crate::{at_least_one, finite, inner, linear_dissipation, sum};
use afterbay_core::{
    Abilities, Block, Coupling, Curvature, Dissipation, DissipationForm, InputError, Line, Members,
    Scalar, SecondDerivatives, Separable, System,
};
use std::sync::Arc;

/// A bond of extension r, with the potential u(r) for a unit mass.
///
/// The bonds of Toda's chain:
///
/// ```
/// use afterbay_core::{Line, Scalar, divided, validate};
/// use afterbay_systems::{Bond, Chain};
///
/// /// u(r) = e^{-r} + r - 1
/// #[derive(Clone, Copy)]
/// struct Toda;
///
/// fn stored<T: Scalar>(r: T) -> T {
///     (-r).exp_m1() + r
/// }
///
/// impl<T: Scalar> Bond<T> for Toda {
///     fn stored(&self, r: T) -> T {
///         stored(r)
///     }
///     fn tension(&self, r: T) -> T {
///         -(-r).exp_m1()
///     }
///     fn stiffness(&self, r: T) -> T {
///         (-r).exp()
///     }
///     fn mean_tension(&self, r: T, s: T) -> Line<T> {
///         divided::of_potential(r, s, stored)
///     }
/// }
///
/// let chain = Chain::of(3, Toda, 0.1)?;
/// validate::separable(&chain, &[0.3, -0.2, 0.5], &[1.0, 0.0, -0.4])?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Bond<T: Scalar>: Copy + Send + Sync + Sized + 'static {
    /// Whether the chain of these bonds is [`afterbay_core::Uniform`] in `f64`.
    const UNIFORM: bool = false;

    /// u(r)
    fn stored(&self, r: T) -> T;

    /// f(r) = u'(r)
    fn tension(&self, r: T) -> T;

    /// f'(r)
    fn stiffness(&self, r: T) -> T;

    /// The mean of f from r to s, to rounding, and its derivative by s.
    fn mean_tension(&self, r: T, s: T) -> Line<T>;

    /// Whether f is linear.
    fn is_linear(&self) -> bool {
        false
    }

    /// The chain as [`Members`], if it is uniform and T is `f64`.
    fn members(_chain: Arc<Chain<T, Self>>) -> Option<Arc<dyn Members>> {
        None
    }
}

/// V = Σ u(r) over the bonds, with D_j = c p_j.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chain<T, B> {
    n: usize,
    pub(crate) bond: B,
    c: T,
}

impl<T: Scalar, B> Chain<T, B> {
    /// The chain of n masses with these bonds and the damping c.
    ///
    /// # Errors
    /// [`InputError::Parameter`] if n is 0 or c is not finite.
    pub fn of(n: usize, bond: B, c: T) -> Result<Self, InputError> {
        Ok(Self { n: at_least_one(n)?, bond, c: finite("c", c)? })
    }

    /// The chain in another scalar, with these bonds.
    pub(crate) fn with<U: Scalar, C>(&self, bond: C, f: impl Fn(T) -> U) -> Chain<U, C> {
        Chain { n: self.n, bond, c: f(self.c) }
    }
}

impl<T: Scalar, B: Bond<T>> System<T> for Chain<T, B> {
    #[inline(always)]
    fn dof(&self) -> usize {
        self.n
    }

    #[inline]
    fn energy(&self, q: &[T], p: &[T]) -> T {
        let stored = |r| self.bond.stored(r);
        let walls = stored(q[0]) + stored(-q[q.len() - 1]);
        sum(p, |&[p]| p * p).half() + (sum(q, |&[a, b]| stored(b - a)) + walls)
    }

    #[inline]
    fn gradient(&self, q: &[T], p: &[T], hq: &mut [T], hp: &mut [T]) {
        let (last, tension) = (q.len() - 1, |r| self.bond.tension(r));
        hq[0] = self.partial(q, 0, q[0]);
        hq[last] = self.partial(q, last, q[last]);
        // Each tension is computed twice, for both masses, so that the masses are independent.
        inner(q, hq, |&[left, at, right]| tension(at - left) - tension(right - at));
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

impl<T: Scalar, B: Bond<T>> Separable<T> for Chain<T, B> {
    #[inline(always)]
    fn partial(&self, q: &[T], j: usize, at: T) -> T {
        let [left, right] = beside(q, j);
        self.bond.tension(at - left) - self.bond.tension(right - at)
    }

    /// The mean tension of the left bond less that of the right bond.
    #[inline(always)]
    fn divided_difference(&self, q: &[T], j: usize, to: T) -> Line<T> {
        let [left, right] = beside(q, j);
        let before = self.bond.mean_tension(q[j] - left, to - left);
        let after = self.bond.mean_tension(right - q[j], right - to);
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

impl<T: Scalar, B: Bond<T>> Curvature<T> for Chain<T, B> {
    #[inline]
    fn curvature(&self, q: &[T], _p: &[T], mut put: impl FnMut(Block, usize, usize, T)) {
        let last = q.len() - 1;
        let mut left = self.bond.stiffness(q[0]);
        for j in 0..=last {
            let right = self.bond.stiffness(if j == last { -q[j] } else { q[j + 1] - q[j] });
            if j > 0 {
                put(Block::Hqq, j, j - 1, -left);
            }
            put(Block::Hqq, j, j, left + right);
            if j < last {
                put(Block::Hqq, j, j + 1, -right);
            }
            put(Block::Hpp, j, j, T::one());
            put(Block::Dp, j, j, self.c);
            left = right;
        }
    }

    #[inline(always)]
    fn is_linear(&self) -> bool {
        self.bond.is_linear()
    }
}

impl<T: Scalar, B: Bond<T>> Abilities<T> for Chain<T, B> {
    fn separable(self: Arc<Self>) -> Option<Arc<dyn Separable<T>>> {
        Some(self)
    }

    fn second_derivatives(self: Arc<Self>) -> Option<Arc<dyn SecondDerivatives<T>>> {
        Some(self)
    }

    fn is_uniform(&self) -> bool {
        B::UNIFORM
    }

    fn uniform(self: Arc<Self>) -> Option<Arc<dyn Members>> {
        B::members(self)
    }
}

/// The neighbours of q_j. Those of the first and the last mass are walls, at 0.
#[inline(always)]
fn beside<T: Scalar>(q: &[T], j: usize) -> [T; 2] {
    let left = if j == 0 { T::zero() } else { q[j - 1] };
    let right = if j + 1 == q.len() { T::zero() } else { q[j + 1] };
    [left, right]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{FputChain, MorseChain};
    use afterbay_core::Passive;

    #[test]
    fn the_sign_of_c_decides() {
        let damping = |c: f64| FputChain::new(3, 1.0, c).unwrap().dissipation_form();
        assert_eq!(damping(0.0), DissipationForm::NONE);
        let passive = DissipationForm { passive: Passive::Each, ..DissipationForm::LINEAR };
        assert_eq!(damping(0.1), passive);
        assert_eq!(damping(-0.1), DissipationForm::LINEAR);
    }

    /// For weak extension Morse's bonds are springs of stiffness 2 ε a².
    #[test]
    fn bonds_of_one_stiffness_have_equal_forces_near_rest() {
        let morse = MorseChain::new(3, 0.5, 1.0, 0.25).unwrap();
        let springs = FputChain::new(3, 0.0, 0.25).unwrap();
        let (q, p) = ([1e-7, -2e-7, 3e-7], [0.0; 3]);
        let [mut force, mut exact, mut hp] = [[0.0; 3]; 3];
        morse.gradient(&q, &p, &mut force, &mut hp);
        springs.gradient(&q, &p, &mut exact, &mut hp);
        for (force, exact) in force.into_iter().zip(exact) {
            assert!((force - exact).abs() < 1e-12, "{force} {exact}");
        }
    }
}
