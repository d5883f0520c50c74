//! Whether small displacements from a cycle grow.

use super::survey::Survey;
use crate::progress::Unseen;
use crate::study::ensemble::{Ensemble, Watch};
use crate::study::ranges::Ranges;
use crate::study::section::point;
use crate::study::stability::largest_eigenvalue;
use afterbay_core::{InputError, StateRef};
use nalgebra::DMatrix;
use std::ops::ControlFlow;

/// The displacement from the cycle, in units of the distance.
const DISPLACED: f64 = 1e-5;
/// The least growth in a turn that counts as unstable. The differences of the displaced runs do not
/// resolve smaller growth where two multipliers are equal.
const GROWS: f64 = 5e-5;

impl Survey<'_> {
    /// Whether the largest multiplier of a cycle exceeds 1. Its matrix is that of differences of
    /// runs of one turn from both sides of a state on the cycle. No if one of these runs fails.
    pub(super) fn repels(&self, cycle: &[Vec<f64>]) -> Result<bool, InputError> {
        let Some(at) = cycle.last() else { return Ok(false) };
        let (periods, dof) = (self.metric.periods(), at.len() / 2);
        let offs: Vec<f64> = self.metric.units().iter().map(|unit| DISPLACED * unit).collect();
        let mut members = Vec::new();
        for (j, off) in offs.iter().enumerate().flat_map(|(j, &off)| [(j, -off), (j, off)]) {
            let mut at = at.clone();
            at[j] += off;
            let turn = Turn { returns: cycle.len() as u64, periods, dof, end: Vec::new() };
            members.push((self.basins.member_at(&at)?, turn));
        }
        let unseen = Unseen(self.ensemble.progress);
        let ended = Ensemble { progress: &unseen, ..self.ensemble }.follow(members)?;
        if ended.iter().any(|(_, ending)| !ending.is_completed()) {
            return Ok(false);
        }
        // In units, in which the eigenvalues are the same.
        let column = |pair: &[(Turn<'_>, _)]| -> Vec<f64> {
            let apart = self.metric.difference(&pair[0].0.end, &pair[1].0.end);
            apart.zip(&offs).map(|(apart, off)| apart / (2.0 * off)).collect()
        };
        let columns: Vec<Vec<f64>> = ended.chunks(2).map(column).collect();
        Ok(grows(&columns))
    }
}

/// Whether the spectral radius of a matrix exceeds 1, up to [`GROWS`]. No if its eigenvalues are
/// not found.
fn grows(columns: &[Vec<f64>]) -> bool {
    let matrix = DMatrix::from_fn(columns.len(), columns.len(), |i, j| columns[j][i]);
    largest_eigenvalue(matrix).is_some_and(|largest| largest > 1.0 + GROWS)
}

/// The state after one turn.
struct Turn<'a> {
    returns: u64,
    periods: &'a [Option<f64>],
    dof: usize,
    end: Vec<f64>,
}

impl Watch for Turn<'_> {
    fn see(&mut self, n: u64, state: StateRef<'_, f64>, _: &Ranges) -> ControlFlow<()> {
        if n < self.returns {
            return ControlFlow::Continue(());
        }
        self.end = point(self.periods, self.dof, state).concat();
        ControlFlow::Break(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_matrix_grows_by_its_largest_multiplier() {
        let (sin, cos) = 0.7_f64.sin_cos();
        let turned = |r: f64| [vec![r * cos, -9.0 * r * sin], vec![r * sin / 9.0, r * cos]];
        assert!(!grows(&turned(0.999)) && !grows(&turned(1.0)) && grows(&turned(1.0001)));
        // A drift, and what shrinks after it has grown.
        assert!(!grows(&[vec![1.0, 0.0], vec![5.0, 1.0]]));
        assert!(!grows(&[vec![0.9, 0.0], vec![1e6, 0.9]]));
        assert!(grows(&[vec![2.0, 0.0], vec![0.0, 0.1]]) && !grows(&[vec![0.0; 2], vec![0.0; 2]]));
    }
}
