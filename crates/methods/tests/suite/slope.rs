//! The empirical order of convergence.

/// The slope of log(error) against log(h), by least squares.
pub(crate) fn slope(steps: &[f64], errors: &[f64]) -> f64 {
    let logs = |x: &[f64]| x.iter().map(|x| x.ln()).collect::<Vec<_>>();
    let (x, y) = (logs(steps), logs(errors));
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
    let (x_mean, y_mean) = (mean(&x), mean(&y));
    let products = x.iter().zip(&y).map(|(x, y)| (x - x_mean) * (y - y_mean));
    let squares = x.iter().map(|x| (x - x_mean).powi(2));
    products.sum::<f64>() / squares.sum::<f64>()
}
