//! The exact flow as a Taylor series in time, computed by evaluating the system on [`Series`].
//!
//! An [`Expansion`] is a polynomial in time with an estimate of its reach. [`follow`] computes a
//! trajectory by successive expansions. Each is used only as far as its defect z' - f(z) is small,
//! which is established by an enclosure of f along the polynomial ([`Enclosed`]) or by samples
//! ([`Sampled`]). No expansion is used across a kink.
//!
//! [`Series`]: crate::Series

mod corrections;
mod defect;
mod expansion;
mod kink;
mod reach;
mod trajectory;
mod units;

pub use corrections::corrections;
pub use defect::{Defect, Enclosed, SAMPLES, Sampled};
pub use expansion::{Expansion, expand};
pub use trajectory::{Pace, Route, follow, trajectory};
pub use units::InUnits;

#[cfg(test)]
mod tests;
