//! Increments of functions along an edge against their claimed derivatives.

/// Functions at a point of the edge.
pub(super) struct Sample {
    pub(super) value: Vec<f64>,
    /// Their claimed derivatives along the edge.
    pub(super) slope: Vec<f64>,
    /// The size of the terms of each function, which bounds its rounding error.
    pub(super) size: Vec<f64>,
}

/// A function whose increment is not the integral of its claimed slope.
pub(super) struct Discrepancy {
    pub(super) index: usize,
    /// The mean slope claimed over the edge.
    pub(super) given: f64,
    /// Its increment over the length of the edge.
    pub(super) found: f64,
}

/// The longest edge to one side on which the quadrature is exact to rounding, and the largest slope
/// on it.
#[derive(Clone, Copy)]
pub(super) struct Resolved {
    pub(super) width: f64,
    pub(super) steepest: f64,
}

/// The largest number of lengths of an edge, each a quarter of the one before: 4⁻²⁴ is 4e-15.
const MOST_LENGTHS: usize = 24;
/// The number of successive lengths on which a discrepancy must appear. The last edge is 64 times
/// shorter than the first.
const CONFIRMATIONS: usize = 4;

/// Compares increments along both edges from `x` with the means of the slopes. `claim` receives the
/// index of a function, the end of the edge and the mean by quadrature, and returns the mean to
/// compare.
pub(super) fn compare(
    x: f64,
    reach: f64,
    rounding: f64,
    sample: &dyn Fn(f64) -> Sample,
    claim: &dyn Fn(usize, f64, f64) -> f64,
) -> Result<Vec<Resolved>, Discrepancy> {
    let (rule, count) = (rule(), sample(x).value.len());
    let mut resolved = Vec::new();
    for side in [reach, -reach] {
        let mut doubts = vec![Some(0); count];
        for length in 0..MOST_LENGTHS {
            let to = x + side * 0.25_f64.powi(length as i32);
            if to == x || doubts.iter().all(Option::is_none) {
                break;
            }
            let edge = Edge::new(x, to - x, &rule, sample);
            for (index, doubt) in doubts.iter_mut().enumerate() {
                let Some(count) = *doubt else { continue };
                let Some((steepest, slack)) = edge.resolve(index, rounding) else {
                    *doubt = Some(0);
                    continue;
                };
                let given = claim(index, to, edge.halves[index]);
                let increment = edge.increment[index];
                if (increment - edge.width * given).abs() <= 2.0 * slack {
                    resolved.push(Resolved { width: edge.width, steepest });
                    *doubt = None;
                } else if count + 1 < CONFIRMATIONS {
                    *doubt = Some(count + 1);
                } else {
                    return Err(Discrepancy { index, given, found: increment / edge.width });
                }
            }
        }
    }
    Ok(resolved)
}

struct Edge {
    width: f64,
    increment: Vec<f64>,
    /// The mean slope by a quadrature over the whole edge, and below, by one over each half.
    whole: Vec<f64>,
    halves: Vec<f64>,
    steepest: Vec<f64>,
    size: Vec<f64>,
    argument: f64,
}

impl Edge {
    fn new(x: f64, width: f64, rule: &[[f64; 2]], sample: &dyn Fn(f64) -> Sample) -> Self {
        let (start, end) = (sample(x), sample(x + width));
        let zeros = || vec![0.0; start.value.len()];
        let mut edge = Self {
            width,
            increment: end.value.iter().zip(&start.value).map(|(b, a)| b - a).collect(),
            whole: zeros(),
            halves: zeros(),
            steepest: zeros(),
            size: zeros(),
            argument: x.abs().max((x + width).abs()),
        };
        let add = |mean: &mut [f64], weight: f64, slope: &[f64]| {
            mean.iter_mut().zip(slope).for_each(|(mean, slope)| *mean += weight * slope);
        };
        for &[at, weight] in rule {
            let node = sample(x + at * width);
            add(&mut edge.whole, weight, &node.slope);
            edge.enclose(&node);
            for half in [0.0, 0.5] {
                let node = sample(x + (half + at / 2.0) * width);
                add(&mut edge.halves, weight / 2.0, &node.slope);
                edge.enclose(&node);
            }
        }
        edge
    }

    fn enclose(&mut self, sample: &Sample) {
        self.steepest
            .iter_mut()
            .zip(&sample.slope)
            .for_each(|(most, x)| *most = x.abs().max(*most));
        self.size.iter_mut().zip(&sample.size).for_each(|(most, x)| *most = x.max(*most));
    }

    /// The largest slope and the rounding error of the increment, if the quadrature is accurate to
    /// rounding.
    fn resolve(&self, index: usize, rounding: f64) -> Option<(f64, f64)> {
        let steepest = self.steepest[index];
        let sizes = self.size[index] + (self.width.abs() + self.argument) * steepest;
        // Subnormal numbers have an absolute rounding.
        let slack = rounding * sizes + f64::MIN_POSITIVE;
        let off = self.width * (self.whole[index] - self.halves[index]);
        let finite = self.increment[index].is_finite() && slack.is_finite();
        (finite && off.abs() <= slack).then_some((steepest, slack))
    }
}

/// The number of intervals of the quadrature; even.
const INTERVALS: u32 = 16;

/// Nodes and weights of the Clenshaw-Curtis quadrature on [0, 1]. It is exact for polynomials up to
/// degree 16. The ends are nodes and the nodes are dense there, so that features at the given state
/// are not missed.
fn rule() -> Vec<[f64; 2]> {
    let n = f64::from(INTERVALS);
    let node = |k: u32| {
        let angle = f64::from(k) * std::f64::consts::PI / n;
        let end = |k: u32| if k == 0 || k == INTERVALS { 1.0 } else { 2.0 };
        // The mean of cos 2jx over the half circle is -1/(4j² - 1).
        let sum: f64 = (1..=INTERVALS / 2)
            .map(|j| {
                end(2 * j) * (2.0 * f64::from(j) * angle).cos() / (4.0 * f64::from(j * j) - 1.0)
            })
            .sum();
        [(angle / 2.0).sin().powi(2), end(k) / (2.0 * n) * (1.0 - sum)]
    };
    (0..=INTERVALS).map(node).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_are_exact() {
        let mean = |k: i32| rule().iter().map(|[at, weight]| weight * at.powi(k)).sum::<f64>();
        for k in 0..=17 {
            assert!((mean(k) - 1.0 / f64::from(k + 1)).abs() < 1e-15, "{k}: {}", mean(k));
        }
        assert!((mean(20) - 1.0 / 21.0).abs() > 1e-13);
    }
}
