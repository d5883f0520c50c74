//! The scales of the axes of a sweep's charts.

use crate::chart::Axis;
use crate::scene::Sweep;
use crate::sheet::spaced;
use afterbay_analysis::Spacing;

/// The ratio of the largest to the least value from which an axis of results is logarithmic.
const WIDE: f64 = 50.0;

/// A logarithmic axis for positive results of several orders of magnitude.
pub(super) fn of_results(name: &str, values: impl Iterator<Item = f64>) -> Axis {
    let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
    for value in values.filter(|x| *x != 0.0) {
        least = least.min(value);
        most = most.max(value);
    }
    if least > 0.0 && most > WIDE * least { Axis::log(name) } else { Axis::linear(name) }
}

/// The axis of the quantity that is varied, in the spacing of its range. That of a list is the one
/// which its values are nearer to.
pub(super) fn of_varied(sweep: &Sweep, k: usize, values: impl Iterator<Item = f64>) -> Axis {
    let spacing = sweep.spacing(k).unwrap_or_else(|| nearer(values.collect()));
    spaced(&sweep.names[k], spacing)
}

/// The spacing that values are nearer to; linear if they are as near to both.
fn nearer(mut values: Vec<f64>) -> Spacing {
    values.sort_by(f64::total_cmp);
    values.dedup();
    if values.first().is_none_or(|least| *least <= 0.0) {
        return Spacing::Linear;
    }
    let logarithms: Vec<f64> = values.iter().map(|x| x.ln()).collect();
    if unevenness(&logarithms) < unevenness(&values) { Spacing::Log } else { Spacing::Linear }
}

/// The largest distance of sorted values from an even spacing, as a share of their range.
fn unevenness(values: &[f64]) -> f64 {
    let [first, .., last] = values else { return 0.0 };
    let even = |i: usize| i as f64 / (values.len() - 1) as f64;
    let off = |(i, x): (usize, &f64)| ((x - first) / (last - first) - even(i)).abs();
    values.iter().enumerate().map(off).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::nearer;
    use afterbay_analysis::Spacing::{Linear, Log};

    #[test]
    fn a_list_has_the_spacing_that_is_nearer() {
        let linear: Vec<f64> = (0..=100).map(|i| f64::from(i) / 100.0).collect();
        let lists = [
            (linear.clone(), Linear),
            (linear[1..].to_vec(), Linear),
            (vec![1e-3, 1e-2, 1e-1, 1.0], Log),
            (vec![1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0], Log),
            (vec![0.0, 1e-3, 1e-2, 1e-1, 1.0], Linear),
            (vec![1.0, 100.0], Linear),
            (vec![7.0], Linear),
        ];
        for (values, expected) in lists {
            assert_eq!(nearer(values.clone()), expected, "{values:?}");
        }
    }
}
