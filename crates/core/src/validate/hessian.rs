//! Tests of the second derivatives against increments of the first.

use super::along::{Sample, compare};
use super::around::{Fields, Place, around, moved, reach, rounding, starts};
use super::system;
use crate::error::InputError;
use crate::quantity::Block;
use crate::system::{Entry, SecondDerivatives};

/// Validates by [`system()`], and compares the second derivatives with increments of ∂H/∂q, ∂H/∂p
/// and D. No entry may be missing, given twice or outside the pattern of
/// [`crate::System::coupling`]. The places must be the same at all states, and the values as well
/// if [`Curvature::is_linear`](crate::Curvature::is_linear).
///
/// # Errors
/// Those of [`system()`].
pub fn curvature(s: &dyn SecondDerivatives<f64>, q: &[f64], p: &[f64]) -> Result<(), InputError> {
    system(s, q, p)?;
    let here = entries(s, q, p);
    places(s, &here, q.len())?;
    let others = around(s, q, p);
    for place in &others {
        let there = entries(s, &place.q, &place.p);
        let same = |a: &Entry<f64>, b: &Entry<f64>| (a.0, a.1, a.2) == (b.0, b.1, b.2);
        if s.is_constant()
            && let Some((there, &here)) = there.iter().zip(&here).find(|(a, b)| a.3 != b.3)
        {
            return refuse(
                here,
                there.3,
                "is_linear() is said, and it must be the same at every state",
            );
        }
        let differing = there.iter().zip(&here).find(|(a, b)| !same(a, b)).map(|(_, b)| b);
        let longer = if there.len() < here.len() { &here } else { &there };
        if let Some(&entry) = differing.or(longer.get(there.len().min(here.len()))) {
            return refuse(
                entry,
                f64::NAN,
                "the entries must be the same ones in the same order at every state",
            );
        }
    }
    for Place { q, p, .. } in starts(&others) {
        for j in 0..q.len() {
            column(s, q, p, j, true)?;
            column(s, q, p, j, false)?;
        }
    }
    Ok(())
}

fn entries(s: &dyn SecondDerivatives<f64>, q: &[f64], p: &[f64]) -> Vec<Entry<f64>> {
    let mut entries = Vec::new();
    s.each(q, p, &mut |some| entries.extend_from_slice(some));
    entries
}

fn refuse(
    (block, row, column, given): Entry<f64>,
    found: f64,
    rule: &'static str,
) -> Result<(), InputError> {
    Err(InputError::ContradictionBetween { block, row, column, given, found, rule })
}

/// Checks that every entry is finite, in the pattern and given once.
fn places(
    s: &dyn SecondDerivatives<f64>,
    entries: &[Entry<f64>],
    n: usize,
) -> Result<(), InputError> {
    let coupling = s.coupling();
    for &entry in entries {
        let (_, i, j, x) = entry;
        if i >= n || j >= n || !coupling.joins(n, i, j) {
            return refuse(entry, 0.0, "coupling() has no place for it");
        }
        if !x.is_finite() {
            return refuse(entry, x, "it must be finite");
        }
    }
    let mut sorted: Vec<Entry<f64>> = entries.to_vec();
    sorted.sort_by_key(|&(block, i, j, _)| (block as u8, i, j));
    for (a, b) in sorted.iter().zip(sorted.iter().skip(1)) {
        if (a.0, a.1, a.2) == (b.0, b.1, b.2) {
            return refuse(*a, b.3, "it is given twice");
        }
    }
    Ok(())
}

/// The derivatives by q_j, or by p_j, against the increments of ∂H/∂q, ∂H/∂p and D.
fn column(
    s: &dyn SecondDerivatives<f64>,
    q: &[f64],
    p: &[f64],
    j: usize,
    by_q: bool,
) -> Result<(), InputError> {
    let (n, x) = (q.len(), if by_q { q } else { p });
    let sample = |at: f64| {
        let (q, p) = if by_q { (&*moved(q, j, at), p) } else { (q, &*moved(p, j, at)) };
        let Fields { hq, hp, d, .. } = Fields::at(s, q, p);
        let value = [hq, hp, d].concat();
        let (mut slope, mut size) =
            (vec![0.0; 3 * n], value.iter().map(|x| x.abs()).collect::<Vec<_>>());
        for (block, i, k, x) in entries(s, q, p) {
            // Entries that are not finite at the given state have been refused before.
            if i >= n || k >= n {
                continue;
            }
            let mut put = |row: usize, column: usize, of_q: bool, argument: f64| {
                size[row] += (x * argument).abs();
                if column == j && of_q == by_q {
                    slope[row] = x;
                }
            };
            match block {
                Block::Hqq => put(i, k, true, q[k]),
                Block::Hqp => {
                    put(i, k, false, p[k]);
                    put(n + k, i, true, q[i]);
                }
                Block::Hpp => put(n + i, k, false, p[k]),
                Block::Dq => put(2 * n + i, k, true, q[k]),
                Block::Dp => put(2 * n + i, k, false, p[k]),
            }
        }
        Sample { value, slope, size }
    };
    compare(x[j], reach(x), rounding(n), &sample, &|_, _, mean| mean).map(drop).or_else(|found| {
        let i = found.index % n;
        let (block, row, column) = match (found.index / n, by_q) {
            (0, true) => (Block::Hqq, i, j),
            (0, false) => (Block::Hqp, i, j),
            (1, true) => (Block::Hqp, j, i),
            (1, false) => (Block::Hpp, i, j),
            (_, true) => (Block::Dq, i, j),
            (_, false) => (Block::Dp, i, j),
        };
        let present = entries(s, q, p).iter().any(|x| (x.0, x.1, x.2) == (block, row, column));
        let rule = if present { "it must be the derivative of the field" } else { "it is missing" };
        refuse((block, row, column, found.given), found.found, rule)
    })
}
