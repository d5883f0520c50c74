//! Charts as SVG text or PNG pictures: curves on linear or logarithmic axes, and maps of cells over
//! two parameters.
//!
//! The crate kuva draws axes, titles and SVG elements. This module adds logarithmic axes far below
//! 1e-10, curves of twenty thousand points, styles of curves that remain distinct in print and for
//! colour-blind readers, and legends that never cover the data.

mod axis;
mod curve;
mod dots;
mod drawing;
mod frame;
mod heat;
mod legend;
mod line;
mod look;
mod panels;
mod thin;

pub use axis::{Axis, Scale};
pub use curve::{Curve, Style};
pub use drawing::Drawing;
pub use heat::{Cells, HeatMap};
pub use line::LineChart;
pub(crate) use panels::dwarf;
pub use panels::{Maps, Panels, coincide};
