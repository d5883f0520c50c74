//! Dissipative Hamiltonian systems `q' = ∂H/∂p, p' = -∂H/∂q - D(q,p)`, one a file.
//!
//! Parameters are scalars like the state, so a system lives in any [`Scalar`]: `map` lifts the parameters of one
//! system into another scalar, `f64` into [`afterbay_core::Quad`] for a reference, into
//! [`afterbay_core::Series`] for Taylor coefficients, into dual numbers for derivatives. What a system knows of
//! itself is what it implements: every one here is [`afterbay_core::Separable`] with its edge in closed form and
//! [`afterbay_core::OrderRaising`]; the [`DampedOscillator`] is also linear, exactly solvable and misprinted.

mod damped_oscillator;
mod duffing;
mod modified_van_der_pol;
mod order_raising;
mod van_der_pol;

pub use damped_oscillator::DampedOscillator;
pub use duffing::Duffing;
pub use modified_van_der_pol::ModifiedVanDerPol;
pub use van_der_pol::VanDerPol;

use afterbay_core::{InputError, Mask, Scalar};

/// `value`, if every number it holds is finite.
fn finite<T: Scalar>(name: &'static str, value: T) -> Result<T, InputError> {
    if value.is_finite().all() {
        Ok(value)
    } else {
        Err(InputError::Parameter { name, value: value.to_f64(), range: "finite" })
    }
}

/// Is every number `value` holds at least 0?
#[inline(always)]
fn not_negative<T: Scalar>(value: T) -> bool {
    T::zero().le(value).all()
}
