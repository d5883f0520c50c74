//! Numbers in sentences, with as many digits as they need in any unit.

/// A number with four significant digits, and with an exponent where it is very small or large.
pub fn in_short(number: f64) -> String {
    let short: f64 = format!("{number:.3e}").parse().unwrap_or(number);
    let is_short = short == 0.0 || !short.is_finite() || (1e-3..1e6).contains(&short.abs());
    if is_short { short.to_string() } else { format!("{short:e}") }
}

/// A number with all its digits, and with an exponent where it is very small or large.
pub fn in_full(number: f64) -> String {
    let is_short = number == 0.0 || (1e-4..1e15).contains(&number.abs());
    if is_short { number.to_string() } else { format!("{number:e}") }
}

/// A measured number for a sentence, with its significant digits, zeros included, and with an
/// exponent where it is very small or large.
pub fn significant(number: f64, digits: usize) -> String {
    if number.is_nan() {
        return "not known".into();
    }
    let scientific = format!("{number:.*e}", digits.saturating_sub(1));
    let exponent = scientific.rsplit('e').next().and_then(|e| e.parse::<i32>().ok());
    match exponent {
        Some(e @ -3..6) => format!("{number:.*}", (digits as i32 - 1 - e).max(0) as usize),
        _ => scientific,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn significant_digits_do_not_depend_on_units() {
        let said = [0.13, 1.0, 9.99996, 123456.7, 1e7, 4e-15, -0.002].map(|x| significant(x, 5));
        let expected =
            ["0.13000", "1.0000", "10.000", "123457", "1.0000e7", "4.0000e-15", "-0.0020000"];
        assert_eq!(said, expected);
        assert_eq!([f64::NAN, f64::INFINITY].map(|x| significant(x, 5)), ["not known", "inf"]);
    }

    #[test]
    fn short_numbers_have_four_digits_at_most() {
        let said = [0.0, 0.5, 1.23456, 6e-12, -123_456.0, 2e9].map(in_short);
        assert_eq!(said, ["0", "0.5", "1.235", "6e-12", "-123500", "2e9"]);
    }
}
