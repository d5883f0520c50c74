//! Stability where methods fail: a verdict for every (h, parameter), and for linear systems the
//! spectral radius of the step beside it.
//!
//! A [`Map`] runs every method over its cells, and each cell names its ending, a [`Verdict`]. What
//! is right is told by q, p and w at times along the run, each by its own size ([`SHARE`]), and by
//! sizes that no system has negative, whatever its potential ([`TOLERANCE`]); what is right but
//! late by means that do not depend on the phase. What the exact solution does comes from RK4 with
//! steps cut until nothing changes ([`References`]). Eight values of the parameter run side by side
//! where the method allows it, with the verdicts they have one at a time. [`atlas()`] sums a map
//! up: where each method first fails as h grows.

mod alone;
mod atlas;
mod halves;
mod image;
mod lanes;
mod map;
mod measure;
mod piece;
mod reference;
mod side;
mod spectrum;
mod track;
mod verdict;
mod walk;

pub use atlas::{AtlasRow, atlas};
pub use map::{MOST_STEPS, Map, MapError};
pub use measure::{KEPT, MOST_LOOKS, MOST_STATIONS};
pub use piece::StabilityRow;
pub use reference::References;
pub use verdict::{GROWTH, SHARE, TOLERANCE, Verdict, rules};
