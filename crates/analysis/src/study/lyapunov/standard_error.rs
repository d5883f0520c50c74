//! The standard error of an exponent: that of the mean of the rates over the intervals between two
//! rows, s/√n with s the standard deviation of n rates.
//!
//! It counts intervals as independent. In chaos correlations may last for many intervals, so
//! intervals are also joined to blocks of 2, 4, .., of which there are at least ten. The largest of
//! these errors is given (H. Flyvbjerg and H. G. Petersen, J. Chem. Phys. 91 (1989) 461-466). In
//! periodic and quasiperiodic motion the error falls as 1/t, and the standard error overestimates
//! it.

use super::growth::Growth;
use afterbay_core::larger_or_nan;
use std::iter;

/// The least number of blocks of more than one interval for a standard error. A choice.
const LEAST_BLOCKS: usize = 10;

/// The standard error of exponent i, the mean rate of growth over intervals of steps h; none for a
/// single interval.
pub(super) fn standard_error(intervals: &[Growth], i: usize, h: f64) -> Option<f64> {
    let rate = |block: &[Growth]| {
        let log: f64 = block.iter().map(|growth| growth.logs[i]).sum();
        log / (h * block.iter().map(|growth| growth.steps).sum::<u64>() as f64)
    };
    let mean = rate(intervals);
    let of_blocks = |length: usize| {
        let n = (intervals.len() / length) as f64;
        let off = |block: &[Growth]| (rate(block) - mean).powi(2);
        let square: f64 = intervals.chunks_exact(length).map(off).sum();
        (square / (n * (n - 1.0))).sqrt()
    };
    let is_enough = |length: &usize| intervals.len() / length >= LEAST_BLOCKS;
    let joined = iter::successors(Some(2), |length| Some(2 * length)).take_while(is_enough);
    (intervals.len() > 1).then(|| joined.map(of_blocks).fold(of_blocks(1), larger_or_nan))
}
