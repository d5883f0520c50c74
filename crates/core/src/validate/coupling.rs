//! The degrees of freedom that act on each other.

use super::around::{Fields, moved, reach, rounding};
use crate::error::InputError;
use crate::quantity::Block;
use crate::system::System;

/// Checks that the fields of a degree of freedom do not change with one that may not act on it.
pub(super) fn coupling(system: &dyn System<f64>, q: &[f64], p: &[f64]) -> Result<(), InputError> {
    let (coupling, n) = (system.coupling(), q.len());
    let rule = "coupling() says that one does not act on the other";
    let blocks = [Block::Hqq, Block::Hqp, Block::Hpp, Block::Dq, Block::Dp];
    unmoved(system, q, p, &|i, j| !coupling.joins(n, i, j), &blocks, rule)
}

/// Moves every q_i and p_i and checks that the fields of each j that is `apart` from i, as far as
/// they belong to these blocks, do not change.
pub(super) fn unmoved(
    system: &dyn System<f64>,
    q: &[f64],
    p: &[f64],
    apart: &dyn Fn(usize, usize) -> bool,
    blocks: &[Block],
    rule: &'static str,
) -> Result<(), InputError> {
    let n = q.len();
    let before = Fields::at(system, q, p);
    for i in (0..n).filter(|&i| (0..n).any(|j| apart(i, j))) {
        for (by_q, share) in [(true, 0.618), (true, -0.414), (false, 0.618), (false, -0.414)] {
            let x = if by_q { q } else { p };
            let width = share * reach(x);
            let to = moved(x, i, x[i] + width);
            let after = if by_q { Fields::at(system, &to, p) } else { Fields::at(system, q, &to) };
            for j in (0..n).filter(|&j| apart(i, j)) {
                // ∂²H/∂q_i∂p_j is named by its q first.
                let changes = if by_q {
                    [
                        (Block::Hqq, [j, i], before.hq[j], after.hq[j]),
                        (Block::Hqp, [i, j], before.hp[j], after.hp[j]),
                        (Block::Dq, [j, i], before.d[j], after.d[j]),
                    ]
                } else {
                    [
                        (Block::Hqp, [j, i], before.hq[j], after.hq[j]),
                        (Block::Hpp, [j, i], before.hp[j], after.hp[j]),
                        (Block::Dp, [j, i], before.d[j], after.d[j]),
                    ]
                };
                for (block, [row, column], a, b) in changes {
                    let slack = rounding(n) * (a.abs() + b.abs());
                    if blocks.contains(&block) && b.is_finite() && (b - a).abs() > slack {
                        let found = (b - a) / width;
                        return Err(InputError::ContradictionBetween {
                            block,
                            row,
                            column,
                            given: 0.0,
                            found,
                            rule,
                        });
                    }
                }
            }
        }
    }
    Ok(())
}
