//! Stability maps: a verdict for every (h, parameter), and for linear systems the spectral radius
//! of the step.
//!
//! A [`Map`] runs every method over its cells and gives each cell a [`Verdict`]. A run is right if
//! q, p and w agree with the exact solution at times along the run, each relative to its own size
//! ([`SHARE`]), and if the size of the motion agrees, measured by quantities that are nonnegative
//! for every potential ([`TOLERANCE`]). A run that is right but late agrees in means that do not
//! depend on the phase. The exact solution comes from RK4 with steps halved until nothing changes
//! ([`References`]). Eight values of the parameter run side by side where the method allows it,
//! with the verdicts they have alone. [`atlas()`] summarizes a map: where each method first fails
//! as h grows.

mod alone;
mod atlas;
mod batch;
mod error;
mod exact;
mod halves;
mod image;
mod lanes;
mod map;
mod measure;
mod piece;
mod reference;
mod spectrum;
mod thresholds;
mod tiles;
mod track;
mod verdict;
mod walk;

pub use atlas::{AtlasRow, atlas};
pub use error::MapError;
pub use map::{MOST_STEPS, Map};
pub use piece::StabilityRow;
pub use reference::References;
pub(crate) use spectrum::{balance, largest_eigenvalue};
pub use thresholds::{GROWTH, KEPT_ON_MAPS, SHARE, TOLERANCE};
pub use tiles::Tiles;
pub use verdict::{Verdict, rules};
