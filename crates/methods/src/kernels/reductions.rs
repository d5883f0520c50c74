//! Sums and maxima over long vectors, in eight or sixteen independent parts: one part would be a
//! chain of dependent operations.

use afterbay_core::{Mask, Scalar};
use std::array::from_fn;

/// max(most, |x|).
#[inline(always)]
pub(crate) fn larger<T: Scalar>(most: T, x: &T) -> T {
    T::select(most.lt(x.abs()), x.abs(), most)
}

/// min(a, b); a if they cannot be compared.
#[inline(always)]
pub(crate) fn smaller<T: Scalar>(a: T, b: T) -> T {
    T::select(b.lt(a), b, a)
}

/// The largest size so far with one more, and a second number that is 0, or NaN once a size is not
/// finite: comparisons ignore NaN.
#[inline(always)]
pub(crate) fn see_size([most, poison]: [f64; 2], size: f64) -> [f64; 2] {
    [if size > most { size } else { most }, poison + 0.0 * size]
}

/// The largest of sizes, or NaN if they are not all finite.
#[inline(always)]
pub(crate) fn largest_if_finite<const N: usize>(sizes: [f64; N]) -> f64 {
    let most = sizes.into_iter().fold(0.0, |most, size| if size > most { size } else { most });
    most + 0.0 * sizes.into_iter().sum::<f64>()
}

/// The largest size with its index, or the first that is NaN; 0 for no sizes.
pub(crate) fn largest_entry(sizes: impl Iterator<Item = f64>) -> (f64, usize) {
    sizes.enumerate().fold((0.0_f64, 0), |(most, at), (k, size)| {
        let replaces = size > most || (size.is_nan() && !most.is_nan());
        if replaces { (size, k) } else { (most, at) }
    })
}

/// Σ |slope_j z_j|, the terms of ∇H·z whose rounding is that of z in H.
#[inline(always)]
pub(crate) fn terms<T: Scalar>(slope: &[T], z: &[T]) -> T {
    sum([slope, z], |[slope, z]| (slope * z).abs())
}

/// The largest |x_j| as an `f64`, 0 for no numbers. NaN is ignored.
#[inline]
pub(crate) fn max_norm<T: Scalar>(x: &[T]) -> f64 {
    largest(x).to_f64()
}

/// The largest |x_j|, 0 for no numbers. NaN is ignored.
#[inline]
pub(crate) fn largest<T: Scalar>(x: &[T]) -> T {
    let (chunks, rest) = x.as_chunks::<16>();
    let most = rest.iter().fold(T::zero(), larger);
    if chunks.is_empty() {
        return most;
    }
    let mut each = [most; 16];
    for chunk in chunks {
        each = from_fn(|k| larger(each[k], &chunk[k]));
    }
    each.iter().fold(most, larger)
}

/// [a · b, a · a], each equal to [`dot`].
pub(crate) fn products<T: Scalar>(a: &[T], b: &[T]) -> [T; 2] {
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<8>(), b.as_chunks::<8>());
    let (mut along, mut square) = ([T::zero(); 8], [T::zero(); 8]);
    for (a, b) in a.iter().zip(b) {
        for k in 0..8 {
            along[k] = a[k].mul_add(b[k], along[k]);
            square[k] = a[k].mul_add(a[k], square[k]);
        }
    }
    for ((along, square), (&a, &b)) in
        along.iter_mut().zip(&mut square).zip(a_rest.iter().zip(b_rest))
    {
        *along = a.mul_add(b, *along);
        *square = a.mul_add(a, *square);
    }
    [along, square].map(total)
}

/// a · b. Entry j is added to partial sum j mod 8.
pub(crate) fn dot<T: Scalar>(a: &[T], b: &[T]) -> T {
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<8>(), b.as_chunks::<8>());
    let mut sums = [T::zero(); 8];
    for (a, b) in a.iter().zip(b) {
        for k in 0..8 {
            sums[k] = a[k].mul_add(b[k], sums[k]);
        }
    }
    for (sum, (&a, &b)) in sums.iter_mut().zip(a_rest.iter().zip(b_rest)) {
        *sum = a.mul_add(b, *sum);
    }
    total(sums)
}

/// Σ_j term(x_j, y_j, ..) of the slices x, y, .., which have one length. Entry j is added to
/// partial sum j mod 8, or to a single sum for fewer than eight entries.
#[inline(always)]
pub(crate) fn sum<T: Scalar, const SLICES: usize>(
    slices: [&[T]; SLICES],
    term: impl Fn([T; SLICES]) -> T,
) -> T {
    let length = slices[0].len();
    let (mut blocks, mut rests) = ([[].as_slice(); SLICES], [[].as_slice(); SLICES]);
    for ((slice, blocks), rest) in slices.iter().zip(&mut blocks).zip(&mut rests) {
        (*blocks, *rest) = slice[..length].as_chunks::<8>();
    }
    let (mut sums, mut entries) = ([T::zero(); 8], [T::zero(); SLICES]);
    for block in 0..length / 8 {
        for (lane, sum) in sums.iter_mut().enumerate() {
            for (entry, blocks) in entries.iter_mut().zip(&blocks) {
                *entry = blocks[block][lane];
            }
            *sum += term(entries);
        }
    }
    for j in 0..length % 8 {
        for (entry, rest) in entries.iter_mut().zip(&rests) {
            *entry = rest[j];
        }
        sums[0] += term(entries);
    }
    if length < 8 { sums[0] } else { total(sums) }
}

/// The sum of eight partial sums.
fn total<T: Scalar>([a, b, c, d, e, f, g, h]: [T; 8]) -> T {
    ((a + b) + (c + d)) + ((e + f) + (g + h))
}

/// The largest |x_j - y_j|, 0 for no numbers. NaN is ignored.
#[inline]
pub(crate) fn largest_difference<T: Scalar>(x: &[T], y: &[T]) -> T {
    let ((x, x_rest), (y, y_rest)) = (x.as_chunks::<8>(), y.as_chunks::<8>());
    let rest = x_rest.iter().zip(y_rest);
    let most = rest.fold(T::zero(), |most, (&x, &y)| larger(most, &(x - y)));
    let mut each = [most; 8];
    for (x, y) in x.iter().zip(y) {
        each = from_fn(|k| larger(each[k], &(x[k] - y[k])));
    }
    each.iter().fold(most, larger)
}

/// Whether x and y have the same length and equal entries. Eight entries share one branch. NaN
/// equals nothing.
#[inline]
pub(crate) fn are_equal<T: Scalar>(x: &[T], y: &[T]) -> bool {
    let ((x, x_rest), (y, y_rest)) = (x.as_chunks::<8>(), y.as_chunks::<8>());
    let mut chunks = x.iter().zip(y);
    x.len() == y.len()
        && x_rest == y_rest
        && chunks.all(|(x, y)| (0..8).fold(true, |equal, k| equal & (x[k] == y[k])))
}

/// Whether all numbers are finite. A sum of x·0 stays 0 if all x are finite and is NaN otherwise.
#[inline]
pub(crate) fn all_finite<T: Scalar>(numbers: &[T]) -> bool {
    if numbers.len() < 8 {
        return numbers.iter().all(|x| x.is_finite().all());
    }
    finite_in_lanes(numbers).all()
}

/// The lanes in which all numbers are finite.
#[inline]
pub(crate) fn finite_in_lanes<T: Scalar>(numbers: &[T]) -> T::Mask {
    let zero = T::zero();
    sum([numbers], |[x]| x * zero).is_finite()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers of both signs and several sizes.
    fn numbers(count: usize, seed: f64) -> Vec<f64> {
        (0..count).map(|j| (seed + 1.3 * j as f64).sin() * 2_f64.powi(j as i32 % 9 - 4)).collect()
    }

    /// The dot product as it is defined: entry j is added to partial sum j mod 8.
    fn plain_dot(a: &[f64], b: &[f64]) -> f64 {
        let mut sums = [0.0; 8];
        for (j, (&a, &b)) in a.iter().zip(b).enumerate() {
            sums[j % 8] = f64::mul_add(a, b, sums[j % 8]);
        }
        let [a, b, c, d, e, f, g, h] = sums;
        ((a + b) + (c + d)) + ((e + f) + (g + h))
    }

    #[test]
    fn products_have_the_bits_of_the_plain_sums() {
        for count in [0, 1, 7, 8, 9, 16, 31, 100] {
            let (a, b) = (numbers(count, 0.4), numbers(count, 2.0));
            assert_eq!(dot(&a, &b), plain_dot(&a, &b));
            assert_eq!(products(&a, &b), [plain_dot(&a, &b), plain_dot(&a, &a)]);
        }
    }

    #[test]
    fn sums_are_those_of_partial_sums() {
        for count in [0, 1, 7, 8, 9, 16, 31, 100] {
            let (a, b) = (numbers(count, 0.4), numbers(count, 2.0));
            let found = sum([&a, &b], |[a, b]| a * b);
            let plain = a.iter().zip(&b).fold(0.0, |sum, (a, b)| sum + a * b);
            let size = a.iter().zip(&b).fold(0.0, |sum, (a, b)| sum + (a * b).abs());
            let bound = if count < 8 { 0.0 } else { count as f64 * f64::EPSILON * size };
            assert!((found - plain).abs() <= bound, "{count}: {found} {plain}");
        }
    }

    #[test]
    fn the_largest_number_is_found_wherever_it_is() {
        for count in [1, 15, 16, 17, 40] {
            for at in 0..count {
                let mut x = numbers(count, 1.0);
                x[at] = -17.0;
                assert_eq!((largest(&x), max_norm(&x)), (17.0, 17.0));
            }
        }
        assert_eq!(largest::<f64>(&[]), 0.0);
    }

    #[test]
    fn the_largest_difference_is_found_wherever_it_is() {
        for count in [1, 7, 8, 9, 20] {
            for at in 0..count {
                let (mut x, y) = (numbers(count, 1.0), numbers(count, 1.0));
                x[at] = y[at] - 17.0;
                assert!((largest_difference(&x, &y) - 17.0).abs() < 1e-13);
            }
        }
    }

    #[test]
    fn a_maximum_of_sizes_keeps_nan_wherever_it_stands() {
        let sizes = [1.0, 3.0, 2.0];
        assert_eq!(largest_if_finite(sizes), 3.0);
        assert_eq!(sizes.into_iter().fold([0.0; 2], see_size), [3.0, 0.0]);
        assert_eq!(largest_entry(sizes.into_iter()), (3.0, 1));
        assert_eq!(largest_entry([].into_iter()), (0.0, 0));
        for (at, wrong) in (0..3).zip([f64::NAN, f64::INFINITY, f64::NAN]) {
            let mut bad = sizes;
            bad[at] = wrong;
            assert!(largest_if_finite(bad).is_nan(), "{bad:?}");
            let [most, poison] = bad.into_iter().fold([0.0; 2], see_size);
            assert!((most + poison).is_nan(), "{bad:?}");
            assert_eq!(largest_entry(bad.into_iter()).1, at, "{bad:?}");
        }
        assert_eq!(largest_entry([f64::NAN, f64::NAN, 1.0].into_iter()).1, 0);
    }

    #[test]
    fn one_number_that_differs_is_found_wherever_it_is() {
        for count in [0, 1, 7, 8, 9, 16, 40] {
            let x = numbers(count, 1.0);
            assert!(are_equal(&x, &x));
            assert!(!are_equal(&x, &numbers(count + 1, 1.0)));
            for (at, wrong) in (0..count).zip([f64::NAN, 17.0].into_iter().cycle()) {
                let mut y = x.clone();
                y[at] = wrong;
                assert!(!are_equal(&x, &y));
            }
        }
    }

    #[test]
    fn one_number_that_is_not_finite_is_found_wherever_it_is() {
        for count in [1, 15, 16, 17, 40] {
            assert!(all_finite(&numbers(count, 1.0)));
            for (at, wrong) in (0..count).zip([f64::NAN, f64::INFINITY].into_iter().cycle()) {
                let mut x = numbers(count, 1.0);
                x[at] = wrong;
                assert!(!all_finite(&x));
            }
        }
    }
}
