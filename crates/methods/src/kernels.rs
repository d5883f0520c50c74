//! Fast forms of computations that other modules state plainly. Each gives the numbers of the plain
//! form to the bit; a test beside it, or in `tests/suite/tiled.rs`, compares the two.

pub(crate) mod reductions;
mod side_by_side;
mod tile;
mod tiled;

pub use tiled::Tiled;
