//! Search for several solutions of an equation.

use super::Equation;
use super::convergence::UPDATE_ROUNDINGS;
use crate::numbers::Scalar;

/// The search covers distances from x of its size times 2ᵏ, |k| up to this. A choice.
const LARGEST_POWER: i32 = 30;
/// The number of bisections of a bracket: all bits of an `f64` and some more.
const HALVINGS: u32 = 60;

/// Whether several solutions of `x = start - F(s, x)` are found. At growing distances from `x`,
/// changes of the sign of x + F - start beyond its rounding error are looked for, and bisected to
/// rule out poles. Two of them prove two solutions of a continuous F. A pair of solutions between
/// neighbouring sample points is missed.
#[cold]
pub(super) fn has_several_solutions<T: Scalar>(
    s: T,
    x: T,
    start: T,
    equation: &mut impl Equation<T>,
) -> bool {
    let mut excess = |at: T| -> Option<f64> {
        let f = equation.at(s, at);
        let value = (at - start + f.value).to_f64();
        let size = at.abs()
            + start.abs()
            + f.value.abs()
            + f.argument_rounding.abs()
            + f.value_rounding.abs();
        let noise = UPDATE_ROUNDINGS * T::EPSILON * size.to_f64();
        value.is_finite().then_some(if value.abs() <= noise { 0.0 } else { value })
    };
    let size = (x.abs() + start.abs()).to_f64();
    let size = if size > 0.0 { size } else { 1.0 };
    let away = |k: i32| T::from_f64(size * 2_f64.powi(k));
    let left = (-LARGEST_POWER..=LARGEST_POWER).rev().map(|k| x - away(k));
    let right = (-LARGEST_POWER..=LARGEST_POWER).map(|k| x + away(k));
    let (mut before, mut found) = (None, 0);
    for at in left.chain(right) {
        let Some(value) = excess(at).filter(|&value| value != 0.0) else { continue };
        if let Some((last, sign)) = before
            && value.signum() != sign
            && vanishes(&mut excess, [last, at], sign)
        {
            found += 1;
        }
        before = Some((at, value.signum()));
    }
    found > 1
}

/// Whether the excess is 0 at its change of sign. At a pole it grows instead.
fn vanishes<T: Scalar>(
    excess: &mut impl FnMut(T) -> Option<f64>,
    [mut low, mut high]: [T; 2],
    sign: f64,
) -> bool {
    let mut sizes = [f64::INFINITY; 2];
    for _ in 0..HALVINGS {
        let middle = low + (high - low).half();
        let Some(value) = excess(middle) else { return false };
        if value == 0.0 {
            return true;
        }
        sizes = [sizes[0].min(value.abs()), value.abs()];
        if value.signum() == sign { low = middle } else { high = middle }
    }
    sizes[1] <= sizes[0]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver::Sample;

    fn of(f: impl Fn(f64) -> f64) -> impl FnMut(f64, f64) -> Sample<f64> {
        move |s, x| Sample {
            value: s * f(x),
            slope: 0.0,
            argument_rounding: 0.0,
            value_rounding: 0.0,
        }
    }

    #[test]
    fn solutions_are_counted_and_poles_are_not() {
        assert!(!has_several_solutions(1.0, 0.3, 0.3, &mut of(|_| 0.0)));
        assert!(!has_several_solutions(1.0, 0.0, 1.0, &mut of(|x| x * x * x)));
        // -1, 0 and 1.
        assert!(has_several_solutions(1.0, 0.0, 0.0, &mut of(|x| x * x * x - 2.0 * x)));
        // Two at ±√2.
        assert!(has_several_solutions(1.0, 0.5, 0.5, &mut of(|x| x * x - x - 1.5)));
        // 2 and 4, and a pole at 3.5 between them.
        assert!(has_several_solutions(
            1.0,
            3.0,
            3.0,
            &mut of(|x| -x + 3.0 + (x - 2.0) * (x - 4.0) / (x - 3.5))
        ));
        // One solution, 2, and a pole at 3.5 at which the sign changes too.
        assert!(!has_several_solutions(1.0, 2.5, 0.0, &mut of(|x| -x + (x - 2.0) / (x - 3.5))));
    }
}
