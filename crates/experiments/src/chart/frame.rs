//! The frame of a chart: canvas, axes, titles and the room for a legend.

use kuva::render::axis::{add_axes_and_grid, add_labels_and_title};
use kuva::render::layout::{AxisLabelOverlap, ComputedLayout, Layout};
use kuva::render::render::{Primitive, Scene, TextAnchor};
use kuva::render::theme::Theme;

use super::axis::{Axis, Span};
use super::drawing::Drawing;
use super::look;

/// The size of legend and tick text in pixels.
pub(super) const TEXT: u32 = 13;

/// The colour of grid lines.
const GRID: &str = "#e4e4e4";

/// A chart under construction. It converts coordinates along the axes to pixels.
pub(super) struct Frame {
    title: String,
    layout: Layout,
    computed: ComputedLayout,
    /// The unit of coordinates along each axis in the layout.
    units: (f64, f64),
    minor: (Vec<f64>, Vec<f64>),
    own: Vec<(f64, String)>,
    scene: Scene,
}

impl Frame {
    /// A frame of `size` pixels, extended by `right` pixels on the right and `below` pixels at the
    /// bottom.
    pub(super) fn new(
        title: &str,
        (x, x_span): (&Axis, Span),
        (y, y_span): (&Axis, Span),
        size: (f64, f64),
        (right, below): (f64, f64),
    ) -> Self {
        let units = (x_span.unit(), y_span.unit());
        let of = |span: &Span, unit: f64| (span.lo / unit, span.hi / unit);
        let (xs, ys) = (of(&x_span, units.0), of(&y_span, units.1));
        let theme = Theme { grid_color: GRID.into(), ..Theme::light() };
        let mut layout = Layout::new(xs, ys)
            .with_width(size.0)
            .with_height(size.1)
            .with_theme(theme)
            .with_box_axes()
            .with_title(title)
            .with_title_wrap((size.0 / 9.5) as usize)
            .with_title_size(16)
            .with_x_label(&x.label)
            .with_x_label_wrap((size.0 / 9.0) as usize)
            .with_y_label(&y.label)
            .with_y_label_wrap((size.1 / 9.0) as usize)
            .with_label_size(14)
            .with_tick_size(TEXT)
            .with_x_label_overlap(AxisLabelOverlap::Thin)
            .with_x_tick_format(x_span.format())
            .with_y_tick_format(y_span.format())
            .with_x_tick_step(x_span.step / units.0)
            .with_y_tick_step(y_span.step / units.1);
        (layout.x_axis_min, layout.x_axis_max) = (Some(xs.0), Some(xs.1));
        (layout.y_axis_min, layout.y_axis_max) = (Some(ys.0), Some(ys.1));
        let computed = ComputedLayout::from_layout(&layout);
        let mut scene = Scene::new(size.0 + right, size.1 + below);
        scene.font_family = computed.font_family.clone();
        Self {
            title: title.into(),
            layout,
            computed,
            units,
            minor: (x_span.minor, y_span.minor),
            own: x_span.own,
            scene,
        }
    }

    /// Draws axes and titles over the contents. `grid` adds grid lines.
    pub(super) fn axes(&mut self, grid: bool) {
        self.layout.show_grid = grid;
        add_axes_and_grid(&mut self.scene, &self.computed, &self.layout);
        add_labels_and_title(&mut self.scene, &self.computed, &self.layout);
        let (left, top, _, bottom) = self.plot();
        for (x, label) in std::mem::take(&mut self.own) {
            let x = self.pixel((x, 0.0)).0;
            if grid && !label.is_empty() {
                self.add(look::stroke(
                    &[(x, top + 1.0), (x, bottom - 1.0)],
                    GRID.into(),
                    1.0,
                    None,
                ));
            }
            self.add(look::stroke(&[(x, bottom), (x, bottom + 5.0)], "#000000".into(), 1.0, None));
            self.add(text(label, (x, bottom + 14.0), TextAnchor::Middle));
        }
        for x in std::mem::take(&mut self.minor.0) {
            let x = self.pixel((x, 0.0)).0;
            self.add(look::stroke(&[(x, bottom), (x, bottom + 3.0)], "#000000".into(), 0.8, None));
        }
        for y in std::mem::take(&mut self.minor.1) {
            let y = self.pixel((0.0, y)).1;
            self.add(look::stroke(&[(left - 3.0, y), (left, y)], "#000000".into(), 0.8, None));
        }
    }

    /// The pixel of a pair of coordinates.
    pub(super) fn pixel(&self, (x, y): (f64, f64)) -> (f64, f64) {
        (self.computed.map_x(x / self.units.0), self.computed.map_y(y / self.units.1))
    }

    /// The area inside the axes in pixels: left, top, right, bottom.
    pub(super) fn plot(&self) -> (f64, f64, f64, f64) {
        let c = &self.computed;
        (c.margin_left, c.margin_top, c.width - c.margin_right, c.height - c.margin_bottom)
    }

    /// Adds an element to the drawing.
    pub(super) fn add(&mut self, thing: Primitive) {
        self.scene.add(thing);
    }

    /// Adds elements in a group with SVG attributes.
    pub(super) fn group(&mut self, attributes: &str, things: impl IntoIterator<Item = Primitive>) {
        let extra_attrs = Some(attributes.into());
        self.add(Primitive::GroupStart { transform: None, title: None, extra_attrs });
        things.into_iter().for_each(|thing| self.add(thing));
        self.add(Primitive::GroupEnd);
    }

    /// The finished chart.
    pub(super) fn drawing(self) -> Drawing {
        let Scene { width, height, elements, font_family, .. } = self.scene;
        Drawing { title: self.title, size: (width, height), elements, font: font_family }
    }
}

/// One line of text; `y` is the middle of its height.
pub(super) fn text(
    content: impl Into<String>,
    (x, y): (f64, f64),
    anchor: TextAnchor,
) -> Primitive {
    let y = y + 0.36 * f64::from(TEXT);
    Primitive::Text {
        x,
        y,
        content: content.into(),
        size: TEXT,
        anchor,
        rotate: None,
        bold: false,
        color: None,
    }
}

/// One line of grey text.
pub(super) fn note(content: impl Into<String>, at: (f64, f64), anchor: TextAnchor) -> Primitive {
    match text(content, at, anchor) {
        Primitive::Text { x, y, content, size, anchor, rotate, bold, .. } => {
            let color = Some(look::GREY.into());
            Primitive::Text { x, y, content, size, anchor, rotate, bold, color }
        }
        other => other,
    }
}

/// An upper estimate of the width of a text in pixels.
pub(super) fn width(text: &str) -> f64 {
    let em = |c: char| match c {
        'i' | 'j' | 'l' | '.' | ',' | ':' | ';' | '|' | '\'' | '!' | ' ' => 0.33,
        'f' | 't' | 'r' | '(' | ')' | '[' | ']' | '-' | '/' => 0.42,
        'm' | 'w' | 'M' | 'W' | '%' => 1.0,
        c if c.is_uppercase() || !c.is_ascii() => 0.72,
        _ => 0.62,
    };
    f64::from(TEXT) * text.chars().map(em).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_of_any_size_fill_the_plot() {
        for size in [1e200, 1.0, 1e-9, 1e-20, 1e-300] {
            let axis = Axis::linear("q");
            let span = || axis.exactly(-0.5 * size, size);
            let frame =
                Frame::new("", (&axis, span()), (&axis, span()), (800.0, 600.0), (0.0, 0.0));
            let (left, top, right, bottom) = frame.plot();
            let ends = [frame.pixel((-0.5 * size, -0.5 * size)), frame.pixel((size, size))];
            for (found, wanted) in ends.iter().zip([(left, bottom), (right, top)]) {
                let off = (found.0 - wanted.0).abs().max((found.1 - wanted.1).abs());
                assert!(off < 1e-6, "{size}: {found:?}, not {wanted:?}");
            }
        }
    }
}
