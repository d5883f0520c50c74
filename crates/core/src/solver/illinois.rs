//! The zero of a function between two points at which its signs differ.

/// The most evaluations. Bisection alone would take 53.
const MOST_EVALUATIONS: usize = 100;

/// The share in (0, 1] of a step after which a function is zero, and the result of `at` there.
/// `off` and `beyond` are the values of the function at the ends, which differ in sign, and `end`
/// is the result at the second end.
///
/// Regula falsi with the rule of Illinois (M. Dowell and P. Jarratt, BIT 11 (1971) 168-174) finds
/// the share to rounding. Where `at` fails, the end of the bracket so far with the smaller value is
/// taken. At a pole the ends of the bracket lie on both sides of it, and their values are large.
pub fn zero_within<R>(
    (mut off, mut beyond): (f64, f64),
    end: R,
    mut at: impl FnMut(f64) -> Option<(f64, R)>,
) -> (f64, R) {
    // The values and shares at the ends of the bracket, and the results there.
    let (mut low, mut high) = (0.0, 1.0);
    let (mut below, mut above) = (None, (beyond, (high, end)));
    let mut moved = None;
    for _ in 0..MOST_EVALUATIONS {
        let secant = (low * beyond - high * off) / (beyond - off);
        // The secant is NaN if a value is infinite; the midpoint replaces it.
        let share = if secant.is_nan() { 0.5 * (low + high) } else { secant };
        if above.0 == 0.0 || !(low < share && share < high) {
            break;
        }
        let Some((now, there)) = at(share) else { break };
        let is_beyond = now == 0.0 || (now > 0.0) == (beyond > 0.0);
        if is_beyond {
            (high, beyond, above) = (share, now, (now, (share, there)));
            off *= if moved == Some(true) { 0.5 } else { 1.0 };
        } else {
            (low, off, below) = (share, now, Some((now, (share, there))));
            beyond *= if moved == Some(false) { 0.5 } else { 1.0 };
        }
        moved = Some(is_beyond);
    }
    match below {
        Some((value, below)) if value.abs() < above.0.abs() => below,
        _ => above.1,
    }
}

#[cfg(test)]
mod tests {
    use super::zero_within;

    #[test]
    fn a_zero_is_found_to_rounding() {
        let zero =
            |f: &dyn Fn(f64) -> f64| zero_within((f(0.0), f(1.0)), (), |x| Some((f(x), ()))).0;
        assert!((zero(&|x| x.exp() - 2.0) - 2f64.ln()).abs() < 1e-15);
        assert!((zero(&|x| (x - 0.3).powi(3)) - 0.3).abs() < 1e-5);
        assert!((zero(&|x| (1e6 * (x - 0.77)).tanh()) - 0.77).abs() < 1e-15);
        assert!((zero(&|x| 1.0 - 2.0 * x) - 0.5).abs() < 1e-16);
        // The function begins at infinity.
        assert!((zero(&|x| 1.0 / x - 3.0) - 1.0 / 3.0).abs() < 1e-15);
        // The end itself is the zero.
        assert_eq!(zero(&|x| x - 1.0), 1.0);
    }
}
