//! Search for singularities of a function along a line: poles, logarithms of 0, roots of negative
//! numbers.
//!
//! The function is enclosed over the whole line. Where the enclosure does not decide, the line is
//! halved until every part is decided or as short as rounding allows.

use super::interval::Interval;
use super::scalar::Scalar;

/// The number of enclosures after which a line that is still in doubt counts as singular.
const MOST_ENCLOSURES: usize = 4096;
/// The largest number of parts of the line that wait to be enclosed.
const MOST_WAITING: usize = 64;
/// The share of the largest coordinate of the line below which a part is not halved.
const SHORTEST: f64 = 1e-18;

/// The result of enclosing a function over a part of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Sight {
    /// The function has a value everywhere.
    Clear,
    /// It may have no value somewhere, if only by the rounding of the enclosure.
    Border,
    /// A divisor or the argument of a logarithm may be 0.
    Pole,
    /// The function has no value anywhere.
    Outside,
}

/// Whether a function is singular between two points of a line, which have the coordinates `from`
/// and `to`. `look` encloses the function over a part of the line. The result is false where a
/// coordinate is not finite, and true after 4096 enclosures that leave a part in doubt.
///
/// A part in doubt that cannot be halved any further counts as singular where it shows a
/// [`Sight::Pole`], and as regular where it shows a [`Sight::Border`].
#[inline]
pub fn is_singular([from, to]: [f64; 2], mut look: impl FnMut(Interval) -> Sight) -> bool {
    if !(from.is_finite() && to.is_finite()) {
        return false;
    }
    let shortest = SHORTEST * (from.abs() + to.abs());
    // A part is halved before the next one is enclosed, so that at most one part waits for each
    // halving.
    let mut waiting = [(0.0, 0.0); MOST_WAITING];
    waiting[0] = (from.min(to), from.max(to));
    let mut count = 1_usize;
    for _ in 0..MOST_ENCLOSURES {
        let Some(last) = count.checked_sub(1) else { return false };
        count = last;
        let (low, high) = waiting[last];
        let middle = 0.5 * low + 0.5 * high;
        let divisible =
            high - low > shortest && low < middle && middle < high && count + 2 <= MOST_WAITING;
        match look(Interval::new(low, high)) {
            Sight::Clear => {}
            Sight::Outside => return true,
            _ if divisible => {
                waiting[count..count + 2].copy_from_slice(&[(middle, high), (low, middle)]);
                count += 2;
            }
            Sight::Border => {}
            Sight::Pole => return true,
        }
    }
    true
}

/// An enclosure of `from + share (to - from)`, for shares between 0 and 1.
///
/// It lies between `from` and `to`, so that rounding does not move an end across a singularity
/// beside it.
pub fn between(from: Interval, to: Interval, share: Interval) -> Interval {
    let (line, hull) = (from + share * (to - from), from.hull(to));
    if line.is_bounded() && hull.is_bounded() {
        Interval::new(line.low().max(hull.low()), line.high().min(hull.high()))
    } else {
        hull
    }
}

/// An enclosure of one of the numbers a scalar holds: the number itself, or the neighbours of its
/// rounding to `f64` where the scalar has more digits.
pub fn enclosed<T: Scalar>(x: T, lane: usize) -> Interval {
    let x = x.lane(lane);
    if T::IS_EXTENDED { Interval::new(x.next_down(), x.next_up()) } else { Interval::from_f64(x) }
}

/// Whether f has no limit at x, or a jump. It decides where an enclosure cannot distinguish a pole
/// from a root or a modulus whose argument touches 0.
///
/// Compares the changes of f over ten halvings of the distance to x with those over ten halvings
/// before. Near a pole they grow, near a singularity of a logarithm they stay equal, and where f is
/// continuous they shrink.
pub fn diverges(x: f64, scale: f64, f: impl Fn(f64) -> f64) -> bool {
    let near = |power: i32| {
        let distance = scale * 2.0_f64.powi(power);
        [f(x - distance), f(x + distance)]
    };
    let change = |outer: i32, inner: i32| {
        let ([a, b], [c, d]) = (near(outer), near(inner));
        (a - c).abs() + (b - d).abs()
    };
    let [left, right] = near(-40);
    let (first, second) = (change(-20, -30), change(-30, -40) + (left - right).abs());
    let rounding = 16.0 * f64::EPSILON * (left.abs() + right.abs());
    // NaN counts as a divergence.
    !(second <= rounding || second < 0.5 * first)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_to_infinity_is_not_looked_at() {
        for ends in [[f64::INFINITY, 0.0], [0.0, f64::NEG_INFINITY], [f64::NAN, 1.0]] {
            assert!(!is_singular(ends, |_| Sight::Outside), "{ends:?}");
        }
        assert!(is_singular([0.0, 1.0], |_| Sight::Outside));
    }

    #[test]
    fn poles_logarithms_and_jumps_diverge() {
        let singular: [fn(f64) -> f64; 6] = [
            |x| 1.0 / x,
            |x| 1.0 / (x * x),
            f64::ln,
            |x| x.abs().ln(),
            |x| (1.0 / x).atan(),
            |x| (1.0 / x).sin(),
        ];
        for (i, f) in singular.into_iter().enumerate() {
            assert!(diverges(0.0, 1.0, f), "{i}");
        }
    }

    #[test]
    fn roots_and_moduli_do_not() {
        let regular: [fn(f64) -> f64; 5] =
            [f64::abs, |x| x.abs().sqrt(), |x| 1e6 + x.abs(), |x| x * x, |_| 3.0];
        for (i, f) in regular.into_iter().enumerate() {
            assert!(!diverges(0.0, 1.0, f), "{i}");
        }
    }

    #[test]
    fn a_pole_is_found_however_narrow() {
        let look =
            |at: f64| move |x: Interval| if x.contains(at) { Sight::Pole } else { Sight::Clear };
        assert!(is_singular([0.0, 1.0], look(0.3)) && is_singular([1.0, 0.0], look(1e-300)));
        assert!(!is_singular([0.0, 1.0], look(1.0 + 1e-15)));
        let border = |x: Interval| if x.contains(0.3) { Sight::Border } else { Sight::Clear };
        assert!(!is_singular([0.0, 1.0], border));
        assert!(is_singular([0.0, 1.0], |_| Sight::Border), "in doubt everywhere");
    }
}
