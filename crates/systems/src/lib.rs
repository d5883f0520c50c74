//! Dissipative Hamiltonian systems `q' = ∂H/∂p, p' = -∂H/∂q - D(q,p)`, one a file.
//!
//! Parameters have the type of the state, so that a system works with any [`Scalar`]. `map`
//! converts a system from `f64` to [`afterbay_core::Quad`] for references, to
//! [`afterbay_core::Series`] for Taylor coefficients, or to dual numbers for derivatives.
//!
//! All systems have second derivatives ([`afterbay_core::Curvature`]). All but the
//! [`DampedDoublePendulum`] and [`CustomGeneral`], which are [`afterbay_core::PhasePlane`]s, are
//! [`afterbay_core::Separable`]. Divided differences have closed forms; those of expressions come
//! from slope arithmetic. The systems with one degree of freedom are
//! [`afterbay_core::OrderRaising`]. The [`DampedOscillator`] is also linear and exactly solvable,
//! and the system whose δ the paper misprints. The [`FputChain`] and the [`VanDerPolRing`] are
//! [`afterbay_core::Uniform`]. [`Custom`] is any other separable system, with potential and
//! dissipation given as text, and [`CustomGeneral`] one with any H(q, p).

pub mod catalog;
mod chain;
mod custom;
mod damped_double_pendulum;
mod damped_oscillator;
mod duffing;
mod family;
mod fput_chain;
mod modified_van_der_pol;
mod morse_chain;
mod order_raising;
mod van_der_pol;
mod van_der_pol_ring;

pub use catalog::{
    DAMPED_DOUBLE_PENDULUM, DAMPED_OSCILLATOR, DUFFING, FPUT_CHAIN, MODIFIED_VAN_DER_POL,
    MORSE_CHAIN, SYSTEMS, SystemRow, VAN_DER_POL, VAN_DER_POL_RING,
};
pub use chain::{Bond, Chain};
pub use custom::{
    Custom, CustomDrive, CustomError, CustomFunction, CustomGeneral, Described, Description,
    DissipationText, DriveDescription, FUNCTIONS, FUNCTIONS_OF_TWO, FUNCTIONS_WITH_JUMPS,
    FunctionDescription, GeneralDescription, Place, Problem, Structure, whole_multiples,
};
pub use damped_double_pendulum::DampedDoublePendulum;
pub use damped_oscillator::DampedOscillator;
pub use duffing::Duffing;
pub use family::{Family, Parameter};
pub use fput_chain::{CubicSpring, FputChain};
pub use modified_van_der_pol::ModifiedVanDerPol;
pub use morse_chain::{MorseBond, MorseChain};
pub use van_der_pol::VanDerPol;
pub use van_der_pol_ring::VanDerPolRing;

use afterbay_core::{DissipationForm, InputError, Mask, Passive, Scalar};

/// `value`, if it is finite in every lane.
fn finite<T: Scalar>(name: &'static str, value: T) -> Result<T, InputError> {
    if value.is_finite().all() {
        Ok(value)
    } else {
        Err(InputError::Parameter { name, value: value.to_f64(), range: "finite" })
    }
}

/// `value`, if it is finite and positive in every lane.
fn positive<T: Scalar>(name: &'static str, value: T) -> Result<T, InputError> {
    if T::zero().lt(value).and(value.is_finite()).all() {
        Ok(value)
    } else {
        Err(InputError::Parameter { name, value: value.to_f64(), range: "positive and finite" })
    }
}

/// The number of degrees of freedom, if it is at least 1.
fn at_least_one(n: usize) -> Result<usize, InputError> {
    if n > 0 {
        Ok(n)
    } else {
        Err(InputError::Parameter { name: "n", value: 0.0, range: "at least 1" })
    }
}

/// Whether `value` is at least 0 in every lane.
#[inline(always)]
fn not_negative<T: Scalar>(value: T) -> bool {
    T::zero().le(value).all()
}

/// Whether `value` is 0 in every lane.
#[inline(always)]
fn is_zero<T: Scalar>(value: T) -> bool {
    not_negative(value) && not_negative(-value)
}

/// The form of D_j = c p_j: passive in each degree of freedom for c ≥ 0, absent for c = 0.
#[inline(always)]
fn linear_dissipation<T: Scalar>(c: T) -> DissipationForm {
    let passive = Passive::each_if(not_negative(c));
    DissipationForm { zero: is_zero(c), passive, ..DissipationForm::LINEAR }
}

/// Writes a function of each entry and its two neighbours, for all entries but the first and the
/// last. Blocks of eight let the compiler use SIMD lanes.
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

/// The sum of `term` over all K neighbours in `x`. Eight partial sums have smaller rounding errors
/// and let the compiler use SIMD lanes.
#[inline]
fn sum<T: Scalar, const K: usize>(x: &[T], term: impl Fn(&[T; K]) -> T) -> T {
    let (mut sums, mut rest) = ([T::zero(); 8], x);
    while let Some(block) = rest.get(..7 + K) {
        sums.iter_mut().zip(block.array_windows()).for_each(|(sum, window)| *sum += term(window));
        rest = &rest[8..];
    }
    let last = rest.array_windows().fold(T::zero(), |sum, window| sum + term(window));
    // Short arrays add no zeros.
    if x.len() < 7 + K { last } else { sums.into_iter().fold(last, |sum, part| sum + part) }
}
