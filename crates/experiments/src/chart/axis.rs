//! Axes: labels, ranges and ticks.

use std::sync::Arc;

use kuva::render::layout::TickFormat;

/// The most ticks at the places of points.
pub(super) const MOST_TICKS: usize = 8;
/// The least distance of their labels, as a share of the axis.
const LABEL: f64 = 0.09;

/// The range below which coordinates are drawn in its units.
const LEAST_RANGE: f64 = 1e-9;

/// The largest number that a linear axis shows. Differences of larger ones may overflow.
const LARGEST: f64 = 1e300;

/// The scale of an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// Equal steps for equal differences.
    Linear,
    /// Equal steps for equal ratios. Only positive, finite values can be shown.
    Log,
}

/// An axis: its label, with the unit, and its scale.
#[derive(Debug, Clone)]
pub struct Axis {
    /// The text beside the axis, for instance `time t [s]`.
    pub label: String,
    /// Linear or logarithmic.
    pub scale: Scale,
}

impl Axis {
    /// A linear axis.
    pub fn linear(label: impl Into<String>) -> Self {
        Self { label: label.into(), scale: Scale::Linear }
    }

    /// A logarithmic axis.
    pub fn log(label: impl Into<String>) -> Self {
        Self { label: label.into(), scale: Scale::Log }
    }

    /// The coordinate of `value` along this axis (its decimal logarithm on a logarithmic axis), or
    /// `None` if the axis cannot show it.
    pub(super) fn place(&self, value: f64) -> Option<f64> {
        let at = match self.scale {
            Scale::Linear if value.abs() > LARGEST => return None,
            Scale::Linear => value,
            Scale::Log if value > 0.0 => value.log10(),
            Scale::Log => return None,
        };
        at.is_finite().then_some(at)
    }

    /// The span that contains all `coordinates`, with a margin at both ends.
    pub(super) fn span(&self, coordinates: impl Iterator<Item = f64>) -> Span {
        let (lo, hi) = extent(coordinates).unwrap_or((0.0, 1.0));
        let (lo, hi) = if is_flat(lo, hi) { (lo, lo) } else { (lo, hi) };
        let air = match lo.abs() {
            _ if hi > lo => 0.03 * (hi - lo),
            0.0 => 1.0,
            size => 0.5 * size.max(1e-300),
        };
        match self.scale {
            Scale::Linear => {
                let end = |v: f64, air: f64| if v == 0.0 && hi > lo { 0.0 } else { v + air };
                self.exactly(end(lo, -air), end(hi, air))
            }
            Scale::Log => {
                let (lo, hi) = if hi > lo { (lo - air, hi + air) } else { (lo - 0.5, hi + 0.5) };
                self.exactly(lo, hi)
            }
        }
    }

    /// The span from `lo` to `hi`, coordinates along this axis, with its ticks.
    pub(super) fn exactly(&self, lo: f64, hi: f64) -> Span {
        let (lo, hi) = if hi > lo { (lo, hi) } else { (lo - 0.5, lo + 0.5) };
        match self.scale {
            Scale::Linear => {
                let step = round_step((hi - lo) / 6.0);
                Span {
                    lo,
                    hi,
                    step,
                    minor: Vec::new(),
                    own: Vec::new(),
                    label: Arc::new(move |v| number(v, step, lo.abs().max(hi.abs()))),
                }
            }
            Scale::Log if decades(lo, hi, 1.0) < 2.0 => {
                // Fewer than two powers of ten are visible: label powers of two, or finer steps.
                let step = if hi - lo > 0.62 { 2f64.log10() } else { round_step((hi - lo) / 5.0) };
                Span {
                    lo,
                    hi,
                    step,
                    minor: Vec::new(),
                    own: Vec::new(),
                    label: Arc::new(power_of_ten),
                }
            }
            Scale::Log => {
                let step = decades_per_label(lo, hi);
                let minor =
                    if step > 1.0 || hi - lo > 6.5 { Vec::new() } else { between_decades(lo, hi) };
                Span {
                    lo,
                    hi,
                    step,
                    minor,
                    own: Vec::new(),
                    label: Arc::new(|v| format!("10{}", superscript(v.round() as i32))),
                }
            }
        }
    }
}

/// The part of an axis that a chart shows, in coordinates along the axis.
pub(super) struct Span {
    pub(super) lo: f64,
    pub(super) hi: f64,
    /// The distance of labelled ticks, which stand at its multiples.
    pub(super) step: f64,
    /// Ticks without a label.
    pub(super) minor: Vec<f64>,
    /// Labelled ticks in place of those at the multiples of `step`.
    pub(super) own: Vec<(f64, String)>,
    label: Arc<dyn Fn(f64) -> String + Send + Sync>,
}

impl Span {
    /// The number by which coordinates are divided for the layout, which takes a range below
    /// 2e-16 for none.
    pub(super) fn unit(&self) -> f64 {
        let range = self.hi - self.lo;
        if range < LEAST_RANGE { range } else { 1.0 }
    }

    /// The format of the tick labels, of coordinates in the unit.
    pub(super) fn format(&self) -> TickFormat {
        let (label, unit) = (self.label.clone(), self.unit());
        TickFormat::Custom(Arc::new(move |v| label(v * unit)))
    }

    /// The span with ticks at `places` on a logarithmic axis, if there are few. A tick too near to
    /// the one before has no label.
    pub(super) fn with_ticks_at(mut self, mut places: Vec<f64>) -> Self {
        places.sort_by(f64::total_cmp);
        // The multiples of a step contain 0, which cannot be left out.
        if !(2..=MOST_TICKS).contains(&places.len()) || (self.lo <= 0.0 && self.hi >= 0.0) {
            return self;
        }
        let (mut last, room) = (f64::NEG_INFINITY, LABEL * (self.hi - self.lo));
        let tick = |place: f64| {
            let label = power_of_ten(place);
            let near = place - last < room;
            if !near {
                last = place;
            }
            (place, if near { String::new() } else { label })
        };
        self.own = places.into_iter().map(tick).collect();
        (self.minor, self.step) = (Vec::new(), 1e9);
        self
    }

    /// The coordinates and labels of the labelled ticks.
    pub(super) fn ticks(&self) -> Vec<(f64, String)> {
        let first = (self.lo / self.step - 1e-9).ceil() as i64;
        let last = (self.hi / self.step + 1e-9).floor() as i64;
        (first..=last).map(|k| k as f64 * self.step).map(|v| (v, (self.label)(v))).collect()
    }
}

/// The smallest and the largest of the finite values.
pub(super) fn extent(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.filter(|v| v.is_finite()).fold(None, |seen, v| match seen {
        None => Some((v, v)),
        Some((lo, hi)) => Some((lo.min(v), hi.max(v))),
    })
}

/// Whether `lo` and `hi` are equal up to rounding.
fn is_flat(lo: f64, hi: f64) -> bool {
    hi - lo <= 1e-9 * lo.abs().max(hi.abs())
}

/// The number of multiples of `step` from `lo` to `hi`.
fn decades(lo: f64, hi: f64, step: f64) -> f64 {
    (hi / step).floor() - (lo / step).ceil() + 1.0
}

/// The number of decades between labels that gives at most eight labels.
fn decades_per_label(lo: f64, hi: f64) -> f64 {
    [1.0, 2.0, 3.0, 4.0, 5.0, 10.0, 20.0, 50.0]
        .into_iter()
        .find(|step| decades(lo, hi, *step) <= 8.0)
        .unwrap_or(100.0)
}

/// The coordinates of 2, 3, .. 9 times each power of ten.
fn between_decades(lo: f64, hi: f64) -> Vec<f64> {
    (lo.floor() as i32..=hi.floor() as i32)
        .flat_map(|k| (2..=9).map(move |m| f64::from(k) + f64::from(m).log10()))
        .filter(|v| (lo..=hi).contains(v))
        .collect()
}

/// The smallest normal number that is 1, 2 or 5 times a power of ten and not below `step`.
fn round_step(step: f64) -> f64 {
    let power = 10f64.powf(step.log10().floor());
    [1.0, 2.0, 5.0]
        .into_iter()
        .map(|m| m * power)
        .find(|s| *s >= step * 0.999)
        .unwrap_or(10.0 * power)
        .max(f64::MIN_POSITIVE)
}

/// The label of a tick on a linear axis, with as many digits as `step` requires.
fn number(v: f64, step: f64, largest: f64) -> String {
    if v.abs() < 1e-9 * step {
        return "0".into();
    }
    if largest < 1e6 && step >= 0.9e-4 {
        let decimals = (-(step * 1.001).log10().floor()).max(0.0) as usize;
        return format!("{v:.decimals$}").replace('-', "−");
    }
    let power = largest.log10().floor();
    let decimals = (power - (step * 1.001).log10().floor()).max(0.0) as usize;
    format!("{:.decimals$}×10{}", v / 10f64.powf(power), superscript(power as i32))
        .replace('-', "−")
}

/// Ten to a power, which may be larger or smaller than any number.
fn power_of_ten(exponent: f64) -> String {
    let v = 10f64.powf(exponent);
    if (1e-3..1e5).contains(&v) {
        return three_digits(v);
    }
    let power = (exponent + 1e-9).floor();
    format!("{}×10{}", three_digits(10f64.powf(exponent - power)), superscript(power as i32))
}

/// Three significant digits without trailing zeros.
fn three_digits(v: f64) -> String {
    let decimals = (2.0 - v.log10().floor()).max(0.0) as usize;
    let text = format!("{v:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}

/// An exponent in superscript digits.
fn superscript(exponent: i32) -> String {
    let raised = |c| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        c => char::from_u32('⁰' as u32 + c as u32 - '0' as u32).unwrap_or(c),
    };
    exponent.to_string().chars().map(raised).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(span: &Span) -> Vec<String> {
        span.ticks().into_iter().map(|(_, text)| text).collect()
    }

    #[test]
    fn decades_are_labelled_with_powers_of_ten() {
        let span = Axis::log("h").span([-3.2, 0.4].into_iter());
        assert_eq!(labels(&span), ["10⁻³", "10⁻²", "10⁻¹", "10⁰"]);
    }

    #[test]
    fn a_log_axis_has_two_to_eight_labels() {
        for lo in [-320.0, -60.0, -17.3, -9.0, -1.7, -0.4] {
            for width in [0.0, 0.2, 1.1, 3.0, 8.0, 8.9, 40.0, 300.0] {
                let span = Axis::log("e").span([lo, lo + width].into_iter());
                let n = span.ticks().len();
                assert!((2..=8).contains(&n), "{n} labels from {lo} over {width} decades");
                assert!(width < 2.0 || span.ticks().iter().all(|(v, _)| v.fract() == 0.0));
            }
        }
    }

    #[test]
    fn a_short_log_axis_may_end_beyond_the_largest_and_the_least_number() {
        let label = |value: f64| labels(&Axis::log("e").span([value.log10()].into_iter()));
        assert_eq!(label(1e308), ["4.49×10³⁰⁷", "8.99×10³⁰⁷", "1.8×10³⁰⁸"]);
        assert_eq!(label(5e-324).len(), 3);
        assert_eq!([-400.0, -5.0, 309.0].map(power_of_ten), ["1×10⁻⁴⁰⁰", "1×10⁻⁵", "1×10³⁰⁹"]);
    }

    #[test]
    fn a_linear_axis_of_the_least_numbers_has_labels() {
        for end in [5e-324, 1e-320, 1e-308] {
            assert!(labels(&Axis::linear("t").span([0.0, end].into_iter())).len() < 10, "{end:e}");
        }
    }

    #[test]
    fn short_exact_log_axes_count_in_powers_of_two() {
        let span = Axis::log("h").exactly(0.2f64.log10(), 2.1f64.log10());
        assert_eq!(labels(&span), ["0.25", "0.5", "1", "2"]);
    }

    #[test]
    fn few_places_have_the_ticks() {
        let at = |steps: &[f64]| {
            let places: Vec<f64> = steps.iter().map(|h: &f64| h.log10()).collect();
            let own = Axis::log("h").span(places.iter().copied()).with_ticks_at(places).own;
            own.into_iter().map(|(_, label)| label).collect::<Vec<_>>()
        };
        assert_eq!(at(&[0.1, 0.05, 0.0125]), ["0.0125", "0.05", "0.1"]);
        assert_eq!(at(&[0.1, 0.0101, 0.01]), ["0.01", "", "0.1"], "no room for a label");
        let many: Vec<f64> = (1..10).map(|i| 0.01 * f64::from(i)).collect();
        assert!(at(&many).is_empty() && at(&[0.1]).is_empty());
    }

    #[test]
    fn an_axis_of_zeros_has_the_numbers_about_0() {
        let span = Axis::linear("q").span([0.0, 0.0].into_iter());
        assert_eq!(labels(&span), ["−1.0", "−0.5", "0", "0.5", "1.0"]);
    }

    #[test]
    fn small_numbers_are_written_with_powers() {
        assert_eq!(
            [3.05e-5, 1e-3, 12.0, 2.5e7].map(|v: f64| power_of_ten(v.log10())),
            ["3.05×10⁻⁵", "0.001", "12", "2.5×10⁷"]
        );
    }

    #[test]
    fn linear_ticks_carry_the_digits_of_their_step() {
        assert_eq!(
            labels(&Axis::linear("t").exactly(0.0, 1.0)),
            ["0", "0.2", "0.4", "0.6", "0.8", "1.0"]
        );
        assert_eq!(labels(&Axis::linear("q").exactly(-2e-6, 2e-6))[0], "−2×10⁻⁶");
        assert_eq!(labels(&Axis::linear("n").exactly(0.0, 4e7))[1], "1×10⁷");
    }

    #[test]
    fn a_linear_axis_has_no_place_for_numbers_whose_differences_overflow() {
        let axis = Axis::linear("q");
        let shown: Vec<f64> =
            [-1.2e308, -1e300, 0.0, 1.2e308].into_iter().filter_map(|v| axis.place(v)).collect();
        assert_eq!(shown, [-1e300, 0.0]);
        let span = axis.span(shown.into_iter());
        assert!(span.lo.is_finite() && span.hi.is_finite() && span.step.is_finite());
    }

    #[test]
    fn a_log_axis_has_no_place_for_zero_or_less() {
        let axis = Axis::log("e");
        assert_eq!(axis.place(1e-15), Some(-15.0));
        assert!([0.0, -1.0, f64::NAN, f64::INFINITY].into_iter().all(|v| axis.place(v).is_none()));
    }
}
