//! A curve, and the canvas on which curves are drawn.

/// The canvas in pixels. A legend too wide to stand beside the plot increases its height.
pub(super) const CANVAS: (f64, f64) = (760.0, 480.0);

/// The style of a curve.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Style {
    /// A line through the points.
    Line,
    /// A line with a marker at each point. On a long curve only some points have markers.
    LineMarkers,
    /// A dot at each point, and no line.
    Dots,
    /// A black ring around each point, which has the mark of another curve, and no line.
    Ring,
}

/// One curve of a [`LineChart`](super::LineChart). Its label determines colour, dash and marker. A
/// label that begins with the name of a method has the same look in every chart.
#[derive(Debug, Clone)]
pub struct Curve {
    /// The name in the legend.
    pub label: String,
    /// The points in the order in which the line runs through them.
    pub points: Vec<(f64, f64)>,
    /// Points known only as upper bounds: hollow, with an arrow down, and not joined by a line.
    pub bounds: Vec<(f64, f64)>,
    /// The style.
    pub style: Style,
}
