//! The second derivatives of H and the derivatives of D, as nodes.

use super::failure::CustomError;
use super::programs::Builder;
use afterbay_core::Block;
use afterbay_expression::{Input, Kinds, Node};

/// The derivatives that are not zero everywhere.
#[derive(Default)]
pub(super) struct SecondDerivatives {
    /// The block of each, and its row and column there.
    pub(super) entries: Vec<(Block, usize, usize)>,
    pub(super) nodes: Vec<Node>,
}

impl SecondDerivatives {
    /// Adds row i of a block: the derivatives of `field`, which is ∂H/∂q_i, ∂H/∂p_i or D_i. Returns
    /// the one in the diagonal.
    pub(super) fn add_row(
        &mut self,
        builder: &mut Builder,
        (block, i): (Block, usize),
        field: Node,
    ) -> Result<Node, CustomError> {
        let by_coordinates = matches!(block, Block::Hqq | Block::Dq);
        let kinds = if by_coordinates { Kinds::COORDINATES } else { Kinds::MOMENTA };
        let by = builder.graph.inputs(field, kinds);
        let row = builder.graph.gradient(field, kinds, &by);
        let mut diagonal = builder.graph.number(0.0);
        for (input, node) in by.into_iter().zip(row) {
            let (Input::Coordinate(j) | Input::Momentum(j)) = input else { continue };
            if j as usize == i {
                diagonal = node;
            }
            if !builder.graph.is_zero(node) {
                self.entries.push((block, i, j as usize));
                self.nodes.push(node);
            }
        }
        builder.fits(self.nodes.len())?;
        Ok(diagonal)
    }
}
