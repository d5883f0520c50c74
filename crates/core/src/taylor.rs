//! The exact flow as a Taylor series in time, computed by evaluating the system on [`Series`].
//!
//! An [`Expansion`] is a polynomial in time and an estimate of how far it reaches. [`follow`] strings
//! expansions together: each is used only as far as its defect z' - f(z) is seen to be small, by an
//! enclosure of f along the polynomial ([`Enclosed`]) or by samples of it ([`Sampled`]), and no
//! expansion goes across a kink.
//!
//! [`Series`]: crate::Series

mod corrections;
mod defect;
mod expansion;
mod kink;
mod reach;
mod trajectory;

pub use corrections::corrections;
pub use defect::{Defect, Enclosed, SAMPLES, Sampled, enclosing};
pub use expansion::{Expansion, expand};
pub use trajectory::{Pace, Route, follow, trajectory};

#[cfg(test)]
mod tests;
