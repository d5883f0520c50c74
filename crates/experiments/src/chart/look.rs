//! Colours, dashes and markers after Okabe and Ito, which can be told apart without colour as well.

use afterbay_methods::registry::METHODS;
use kuva::render::color::Color;
use kuva::render::render::{PathData, Primitive};

/// Colours of curves. The yellow of the set is left out, since it is too pale for a line on white.
const CURVES: [&str; 7] =
    ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#000000", "#56b4e9"];

/// Dashes. There is one more than there are colours, so that a repeated colour has another dash.
const DASHES: [&str; 8] =
    ["", "9 3", "2.5 2.5", "10 3 2 3", "5 3", "12 3 2 3 2 3", "6 2 2 2", "1.5 4"];

/// Colours of the categories of a map. Any two of them differ by at least 25 in CIELAB, for normal
/// sight and for each kind of colour blindness.
pub(super) const CATEGORIES: [&str; 10] = [
    "#56b4e9", "#005599", "#f0e442", "#d55e00", "#000000", "#8822ff", "#885555", "#ff99aa",
    "#772200", "#bbff99",
];

/// The grey of guides, notes and cells without a value.
pub(super) const GREY: &str = "#6b6b6b";

/// Methods that often share a chart, in the order of the looks. The first seven differ in colour.
/// All other methods follow in the order of the registry. Methods in one chart of the paper differ
/// in colour or in mark.
const OFTEN_TOGETHER: [&str; 24] = [
    "moddg",
    "leapfrog",
    "rk4",
    "increment-2",
    "gonzalez",
    "adaptive-dop853",
    "collocation-4",
    "increment-4",
    "relaxed-rk4",
    "linear-exact",
    "moddg-fixed-point",
    "locally-exact",
    "adaptive-collocation",
    "increment-6",
    "increment-1",
    "relaxed-dop853",
    "splitting-2",
    "splitting-4",
    "splitting-6",
    "increment-8",
    "moddg-p4-shared",
    "adaptive-radau",
    "adaptive-verner87",
    "adaptive-verner98",
];

/// The index of the look of a method; `None` if the label does not begin with the name of a method.
fn place_of_method(label: &str) -> Option<usize> {
    let name = label.split([',', ' ']).next()?;
    let often = OFTEN_TOGETHER.iter().position(|often| *often == name);
    let others = METHODS.iter().filter(|row| !OFTEN_TOGETHER.contains(&row.name));
    often.or_else(|| {
        Some(OFTEN_TOGETHER.len() + others.map(|row| row.name).position(|other| other == name)?)
    })
}

/// The colour, dash and marker of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Look {
    nth: usize,
    /// Whether the line has no dashes: it is the only one of its plot.
    alone: bool,
    /// Whether it is grey: the reference.
    grey: bool,
}

/// The grey of a reference, pale enough for the curves above it to stand out.
const PALE: &str = "#b4b4b4";

/// The label of a reference, which is grey.
const REFERENCE: &str = "reference";

impl Look {
    /// The looks of the curves of one chart, by label. A method has the same look in every chart. A
    /// second curve of the same method has its colour, with another dash and marker. Other curves
    /// take the first free looks. A curve that is
    /// alone has no dashes, and the reference is grey.
    pub(super) fn of_labels<'a>(labels: impl IntoIterator<Item = &'a str>) -> Vec<Self> {
        let labels: Vec<&str> = labels.into_iter().collect();
        let places: Vec<_> = labels.iter().map(|label| place_of_method(label)).collect();
        let mut taken: Vec<usize> = places.iter().flatten().copied().collect();
        let mut seen = Vec::new();
        let alone = places.len() == 1;
        let look = |(place, label): (Option<usize>, &str)| {
            let grey = label == REFERENCE;
            if grey {
                return Self { nth: 0, alone: true, grey };
            }
            let (mut nth, stride) = place.map_or((0, 1), |place| (place, CURVES.len()));
            let own = place.is_some_and(|place| !seen.contains(&place));
            seen.extend(place);
            while !own && taken.contains(&nth) {
                nth += stride;
            }
            taken.push(nth);
            Self { nth, alone, grey }
        };
        places.into_iter().zip(labels).map(look).collect()
    }

    pub(super) fn colour(self) -> Color {
        if self.grey {
            return PALE.into();
        }
        CURVES[self.nth % CURVES.len()].into()
    }

    /// A line through `points`, in pixels.
    pub(super) fn line(self, points: &[(f64, f64)], width: f64) -> Primitive {
        let dash = if self.alone { "" } else { DASHES[self.nth % DASHES.len()] };
        stroke(points, self.colour(), width, (!dash.is_empty()).then_some(dash))
    }

    /// Markers at `points`, in pixels, as one path. Every second look is hollow.
    pub(super) fn markers(self, points: &[(f64, f64)], radius: f64) -> Primitive {
        let d = points.iter().map(|at| self.outline(*at, radius)).collect();
        let fill = if self.nth.is_multiple_of(2) { self.colour() } else { "#ffffff".into() };
        path(d, Some(fill), self.colour(), 1.5, None)
    }

    /// A filled circle.
    pub(super) fn disc(self, (x, y): (f64, f64), r: f64) -> Primitive {
        area(circle((x, y), r), self.colour())
    }

    /// Hollow squares with an arrow down, which mark upper bounds.
    pub(super) fn upper_bounds(self, points: &[(f64, f64)], r: f64) -> Primitive {
        let sign = |&(x, y): &(f64, f64)| {
            let (side, end, tip) = (2.0 * r, 3.5 * r, 0.7 * r);
            format!(
                "M{:.1} {:.1}h{side}v{side}h-{side}ZM{x:.1} {:.1}v{end}m-{tip} -{tip}l{tip} \
                 {tip}l{tip} -{tip}",
                x - r,
                y - r,
                y + r,
            )
        };
        path(points.iter().map(sign).collect(), None, self.colour(), 1.2, None)
    }

    /// The outline of one marker, as SVG path data.
    fn outline(self, (x, y): (f64, f64), r: f64) -> String {
        let corners = |radii: &[f64], turn: f64| {
            let point = |k: usize| {
                let angle = (turn + k as f64 / radii.len() as f64) * std::f64::consts::TAU;
                (x + radii[k] * angle.sin(), y - radii[k] * angle.cos())
            };
            format!("{}Z", trace((0..radii.len()).map(point)))
        };
        match self.nth % 6 {
            0 => circle((x, y), r),
            1 => corners(&[1.25 * r; 4], 0.125),
            2 => corners(&[1.35 * r; 3], 0.0),
            3 => corners(&[1.35 * r; 4], 0.0),
            4 => corners(&[1.35 * r; 3], 0.5),
            _ => corners(&[1.5 * r, 0.65 * r].repeat(5), 0.0),
        }
    }
}

/// Black rings around `points`, in pixels.
pub(super) fn rings(points: &[(f64, f64)], r: f64) -> Primitive {
    path(points.iter().map(|at| circle(*at, r)).collect(), None, "#000000".into(), 2.0, None)
}

/// A circle as SVG path data.
fn circle((x, y): (f64, f64), r: f64) -> String {
    let d = 2.0 * r;
    format!("M{:.1} {y:.1}a{r} {r} 0 1 0 {d} 0a{r} {r} 0 1 0 -{d} 0Z", x - r)
}

/// The colour of category `nth`.
pub(super) fn category(nth: usize) -> Color {
    CATEGORIES[nth % CATEGORIES.len()].into()
}

/// A line through `points`, in pixels.
pub(super) fn stroke(
    points: &[(f64, f64)],
    colour: Color,
    width: f64,
    dash: Option<&str>,
) -> Primitive {
    path(trace(points.iter().copied()), None, colour, width, dash)
}

/// An area without a border.
pub(super) fn area(d: String, fill: Color) -> Primitive {
    path(d, Some(fill), Color::None, 0.0, None)
}

fn path(
    d: String,
    fill: Option<Color>,
    stroke: Color,
    width: f64,
    dash: Option<&str>,
) -> Primitive {
    let stroke_dasharray = dash.map(Into::into);
    Primitive::Path(Box::new(PathData {
        d,
        fill,
        stroke,
        stroke_width: width,
        opacity: None,
        stroke_dasharray,
    }))
}

/// Path data through `points` to a tenth of a pixel.
fn trace(points: impl Iterator<Item = (f64, f64)>) -> String {
    points
        .enumerate()
        .map(|(i, (x, y))| format!("{}{x:.1} {y:.1}", if i == 0 { 'M' } else { 'L' }))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Normal sight, and protanopia, deuteranopia and tritanopia at full strength: matrices on
    /// linear RGB of G. M. Machado, M. M. Oliveira, L. A. F. Fernandes, IEEE Trans. Vis. Comput.
    /// Graph. 15 (2009).
    const SIGHTS: [[[f64; 3]; 3]; 4] = [
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        [
            [0.152286, 1.052583, -0.204868],
            [0.114503, 0.786281, 0.099216],
            [-0.003882, -0.048116, 1.051998],
        ],
        [
            [0.367322, 0.860646, -0.227968],
            [0.280085, 0.672501, 0.047413],
            [-0.011820, 0.042940, 0.968881],
        ],
        [
            [1.255528, -0.076749, -0.178779],
            [-0.078411, 0.930809, 0.147602],
            [0.004733, 0.691367, 0.303900],
        ],
    ];
    /// Linear RGB to CIE XYZ, each row divided by that of white.
    const XYZ: [[f64; 3]; 3] =
        [[0.43388, 0.37624, 0.18990], [0.2126, 0.7152, 0.0722], [0.01773, 0.10947, 0.87285]];

    fn of(matrix: &[[f64; 3]; 3], x: [f64; 3]) -> [f64; 3] {
        matrix.map(|row| row.iter().zip(x).map(|(a, x)| a * x).sum())
    }

    /// The colour in CIELAB as seen with a kind of sight.
    fn lab(colour: &str, sight: &[[f64; 3]; 3]) -> [f64; 3] {
        let channel = |i: usize| {
            let c =
                f64::from(u8::from_str_radix(&colour[i..i + 2], 16).expect("two digits")) / 255.0;
            if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
        };
        let seen = of(sight, [channel(1), channel(3), channel(5)]).map(|c| c.clamp(0.0, 1.0));
        let cubic = |t: f64| if t > 0.008856 { t.cbrt() } else { 7.787 * t + 16.0 / 116.0 };
        let [x, y, z] = of(&XYZ, seen).map(cubic);
        [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
    }

    /// Methods in charts of the paper: curves without marks, which differ in colour, and curves
    /// with marks.
    const WITHOUT_MARKS: [&[&str]; 3] = [
        &["leapfrog", "moddg", "rk4", "moddg-q4-shared"],
        &["leapfrog", "moddg", "rk4", "moddg-p4-shared"],
        &["leapfrog", "rk4", "increment-2", "increment-8", "gonzalez"],
    ];
    const WITH_MARKS: [&[&str]; 2] = [
        &[
            "leapfrog",
            "moddg",
            "moddg-q3-shared",
            "moddg-qp4",
            "rk4",
            "increment-4",
            "increment-8",
            "adaptive-collocation",
            "adaptive-dop853",
            "adaptive-radau",
            "adaptive-verner87",
            "adaptive-verner98",
        ],
        &[
            "leapfrog",
            "rk4",
            "gonzalez",
            "increment-1",
            "increment-2",
            "increment-4",
            "increment-6",
            "increment-8",
            "adaptive-collocation",
            "adaptive-dop853",
            "adaptive-radau",
            "adaptive-verner87",
            "adaptive-verner98",
        ],
    ];

    #[test]
    fn methods_in_one_chart_of_the_paper_differ_in_colour_or_mark() {
        let differ = |methods: &[&str], of: fn(Look) -> (usize, usize)| {
            let mut seen: Vec<_> =
                Look::of_labels(methods.iter().copied()).into_iter().map(of).collect();
            seen.sort_unstable();
            seen.dedup();
            assert_eq!(seen.len(), methods.len(), "{methods:?}");
        };
        WITHOUT_MARKS.iter().for_each(|methods| differ(methods, |look| (look.nth % 7, 0)));
        WITH_MARKS.iter().for_each(|methods| differ(methods, |look| (look.nth % 7, look.nth % 6)));
    }

    #[test]
    fn categories_are_told_apart_by_everyone() {
        for sight in &SIGHTS {
            for (i, a) in CATEGORIES.iter().enumerate() {
                for b in &CATEGORIES[..i] {
                    let [a, b] = [a, b].map(|colour| lab(colour, sight));
                    let distance =
                        a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
                    assert!(distance > 25.0, "{a:?} {b:?}: {distance}");
                }
            }
        }
    }
}
