//! Statistics used by the studies.

use statrs::distribution::{ContinuousCDF, StudentsT};

/// A straight line fitted by least squares.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// The slope.
    pub slope: f64,
    /// Half the width of the 95 % confidence interval of the slope (Student's t); none with only
    /// two points.
    pub margin: Option<f64>,
    /// The number of points.
    pub points: usize,
}

/// Fits `y = a + slope x` to points. Returns `None` with fewer than two distinct x, or where a
/// number is not finite.
pub fn fit(points: &[(f64, f64)]) -> Option<Fit> {
    let n = points.len() as f64;
    let mean = |f: fn(&(f64, f64)) -> f64| points.iter().map(f).sum::<f64>() / n;
    let (x_mean, y_mean) = (mean(|point| point.0), mean(|point| point.1));
    let (mut sxx, mut sxy, mut syy) = (0.0, 0.0, 0.0);
    for (x, y) in points {
        let (dx, dy) = (x - x_mean, y - y_mean);
        sxx += dx * dx;
        sxy += dx * dy;
        syy += dy * dy;
    }
    let slope = sxy / sxx;
    if points.len() < 2 || !slope.is_finite() {
        return None;
    }
    let margin = (points.len() > 2).then(|| {
        let freedom = n - 2.0;
        let residual = (syy - slope * sxy).max(0.0);
        let quantile =
            StudentsT::new(0.0, 1.0, freedom).map_or(f64::INFINITY, |t| t.inverse_cdf(0.975));
        quantile * (residual / freedom / sxx).sqrt()
    });
    Some(Fit { slope, margin, points: points.len() })
}

/// The median; 0 for an empty list.
pub fn median(values: &mut [f64]) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    match values.len() {
        0 => 0.0,
        n if n % 2 == 1 => values[n / 2],
        n => f64::midpoint(values[n / 2 - 1], values[n / 2]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_found_with_its_confidence() {
        // Anscombe's first set: slope 0.5001, standard error 0.1179, t(9) = 2.262.
        let y = [8.04, 6.95, 7.58, 8.81, 8.33, 9.96, 7.24, 4.26, 10.84, 4.82, 5.68];
        let x = [10.0, 8.0, 13.0, 9.0, 11.0, 14.0, 6.0, 4.0, 12.0, 7.0, 5.0];
        let points: Vec<_> = x.into_iter().zip(y).collect();
        let fit = fit(&points).unwrap();
        assert!((fit.slope - 0.500_090_909).abs() < 1e-9);
        assert!((fit.margin.unwrap() - 0.117_906 * 2.262_157).abs() < 1e-5);
    }

    #[test]
    fn too_little_is_no_line() {
        assert_eq!(fit(&[]), None);
        assert_eq!(fit(&[(1.0, 2.0)]), None);
        assert_eq!(fit(&[(1.0, 2.0), (1.0, 3.0)]), None);
        assert_eq!(fit(&[(1.0, f64::NAN), (2.0, 3.0)]), None);
        assert_eq!(
            fit(&[(1.0, 2.0), (2.0, 5.0)]),
            Some(Fit { slope: 3.0, margin: None, points: 2 })
        );
    }

    #[test]
    fn the_median_is_in_the_middle() {
        assert_eq!(median(&mut [3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(&mut [4.0, 1.0, 2.0, 3.0]), 2.5);
        assert_eq!(median(&mut []), 0.0);
    }
}
