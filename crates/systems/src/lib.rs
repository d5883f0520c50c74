//! Dissipative Hamiltonian systems `q' = ∂H/∂p, p' = -∂H/∂q - D(q,p)`, one a file.
//!
//! Parameters are scalars like the state, so a system lives in any [`Scalar`]: `map` lifts the parameters of one
//! system into another scalar, `f64` into [`afterbay_core::Quad`] for a reference, into
//! [`afterbay_core::Series`] for Taylor coefficients, into dual numbers for derivatives. What a system knows of
//! itself is what it implements. Every one here has its [`afterbay_core::Curvature`]. All but the [`DampedDoublePendulum`] are
//! [`afterbay_core::Separable`], their edges in closed form; the pendulum knows its [`afterbay_core::PhasePlane`]s, in closed
//! form too. Those with one degree of freedom are [`afterbay_core::OrderRaising`], and the [`DampedOscillator`] is also linear,
//! exactly solvable and misprinted; the [`FputChain`] and the [`VanDerPolRing`] are [`afterbay_core::Uniform`].
//! [`Custom`] is any other separable system, its potential and friction given as text.

pub mod catalog;
mod custom;
mod damped_double_pendulum;
mod damped_oscillator;
mod duffing;
mod expression;
mod fput_chain;
mod modified_van_der_pol;
mod order_raising;
mod van_der_pol;
mod van_der_pol_ring;

pub use catalog::{
    DAMPED_DOUBLE_PENDULUM, DAMPED_OSCILLATOR, DUFFING, FPUT_CHAIN, Family, MODIFIED_VAN_DER_POL, SYSTEMS,
    SystemRow, VAN_DER_POL, VAN_DER_POL_RING,
};
pub use custom::{Custom, CustomError, Description, DissipationText, Place, Problem, Structure};
pub use damped_double_pendulum::DampedDoublePendulum;
pub use damped_oscillator::DampedOscillator;
pub use duffing::Duffing;
pub use fput_chain::FputChain;
pub use modified_van_der_pol::ModifiedVanDerPol;
pub use van_der_pol::VanDerPol;
pub use van_der_pol_ring::VanDerPolRing;

use afterbay_core::{InputError, Mask, Scalar};

/// `value`, if every number it holds is finite.
fn finite<T: Scalar>(name: &'static str, value: T) -> Result<T, InputError> {
    if value.is_finite().all() {
        Ok(value)
    } else {
        Err(InputError::Parameter { name, value: value.to_f64(), range: "finite" })
    }
}

/// `value`, if every number it holds is finite and above 0.
fn positive<T: Scalar>(name: &'static str, value: T) -> Result<T, InputError> {
    if T::zero().lt(value).and(value.is_finite()).all() {
        Ok(value)
    } else {
        Err(InputError::Parameter { name, value: value.to_f64(), range: "positive and finite" })
    }
}

/// The number of degrees of freedom, if there is one.
fn at_least_one(n: usize) -> Result<usize, InputError> {
    if n > 0 { Ok(n) } else { Err(InputError::Parameter { name: "n", value: 0.0, range: "at least 1" }) }
}

/// Is every number `value` holds at least 0?
#[inline(always)]
fn not_negative<T: Scalar>(value: T) -> bool {
    T::zero().le(value).all()
}

/// Is every number `value` holds 0?
#[inline(always)]
fn is_zero<T: Scalar>(value: T) -> bool {
    not_negative(value) && not_negative(-value)
}

/// A function of every member of a row but the first and the last, and of its neighbours. Eight side by side: lanes.
#[inline]
fn inner<T: Scalar>(x: &[T], to: &mut [T], of: impl Fn(&[T; 3]) -> T) {
    let last = x.len().saturating_sub(1);
    let (blocks, rest) = to[last.min(1)..last].as_chunks_mut::<8>();
    let done = 8 * blocks.len();
    for (to, x) in blocks.iter_mut().zip(x.array_windows::<10>().step_by(8)) {
        *to = std::array::from_fn(|j| of(&[x[j], x[j + 1], x[j + 2]]));
    }
    rest.iter_mut().zip(x[done..].array_windows()).for_each(|(to, x)| *to = of(x));
}

/// The sum of `term` over every K neighbours in `x`. Eight partial sums side by side: eight times fewer roundings, and
/// lanes.
#[inline]
fn sum<T: Scalar, const K: usize>(x: &[T], term: impl Fn(&[T; K]) -> T) -> T {
    let (mut sums, mut rest) = ([T::zero(); 8], x);
    while let Some(block) = rest.get(..7 + K) {
        sums.iter_mut().zip(block.array_windows()).for_each(|(sum, window)| *sum += term(window));
        rest = &rest[8..];
    }
    let last = rest.array_windows().fold(T::zero(), |sum, window| sum + term(window));
    // Short ones, of a length the compiler knows, add no zeros.
    if x.len() < 7 + K { last } else { sums.into_iter().fold(last, |sum, part| sum + part) }
}
