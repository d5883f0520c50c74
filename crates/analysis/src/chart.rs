//! Charts as SVG text: curves on linear or logarithmic axes, and maps of cells over two parameters.
//!
//! The drawing is kuva's (axes, titles, SVG); what is added here is what kuva has no word for:
//! logarithmic axes far below 1e-10, curves of twenty thousand points, a look for each curve that
//! survives print and colour blindness, and legends that never lie on the data.

mod axis;
mod frame;
mod heat;
mod line;
mod look;
mod thin;

pub use axis::{Axis, Scale};
pub use heat::{Cells, HeatMap};
pub use line::{Curve, LineChart, Style};
