//! Numbers and functions of one number.
//!
//! A step is written once, for every [`Scalar`]: `f64`, [`Quad`] with 106 bits to see below the
//! rounding of `f64`, SIMD lanes ([`f64x8`]), [`Corrected`] numbers that carry their
//! rounding errors, [`Series`] for Taylor coefficients, [`Slope`] for divided differences,
//! [`Interval`] for enclosures, and dual numbers (feature `num-dual`). Divided differences
//! without cancellation are in [`divided`], means over an edge in [`quadrature`].

mod corrected;
pub mod divided;
#[cfg(feature = "num-dual")]
mod dual;
mod interval;
mod lanes;
mod larger;
mod line;
mod quad;
pub mod quadrature;
mod scalar;
mod series;
pub mod singularity;
mod slope;
mod two_sum;
mod vector;

pub use corrected::{Corrected, Lanewise};
pub use interval::Interval;
pub use larger::larger_or_nan;
pub use line::Line;
pub use qd::Quad;
pub use scalar::{Mask, Scalar};
pub(crate) use scalar::{first_not_finite, value_not_finite};
pub use series::Series;
pub use slope::{Ends, Slope};
pub use two_sum::two_sum;
pub use vector::{Single, Vector};
pub use wide::f64x8;
