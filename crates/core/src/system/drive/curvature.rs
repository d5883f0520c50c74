//! Second derivatives of a driven system.

use super::{Drive, Driven};
use crate::numbers::Scalar;
use crate::quantity::Block;
use crate::system::abilities::SecondDerivatives;
use crate::system::hessian::Curvature;

impl<T, S, D> Curvature<T> for Driven<S, D>
where
    T: Scalar,
    S: SecondDerivatives<T> + ?Sized,
    D: Drive<T> + ?Sized,
{
    fn curvature(&self, q: &[T], p: &[T], mut put: impl FnMut(Block, usize, usize, T)) {
        let (q, times) = q.split_at(self.dof);
        let p = &p[..self.dof];
        let (mut hq, mut v) = (vec![T::zero(); self.dof], vec![T::zero(); self.dof]);
        self.system.gradient(q, p, &mut hq, &mut v);
        let mut own = Sum(Vec::new());
        for (k, &j) in self.drive.driven().iter().enumerate() {
            let motor = self.dof + k;
            self.drive.slopes(k, q, times[k], &mut |by, slope| {
                let by = by.unwrap_or(motor);
                own.add((Block::Dq, j, by), -slope);
                own.add((Block::Dq, motor, by), -slope * v[j]);
            });
        }
        let forces: Vec<T> =
            times.iter().enumerate().map(|(k, &t)| self.drive.force(k, q, t)).collect();
        self.system.each(q, p, &mut |entries| {
            for &(block, row, column, value) in entries {
                put(block, row, column, value + own.take((block, row, column)));
                // D_m = -F_j ∂H/∂p_j also depends on the state by ∂H/∂p_j.
                let (j, block, by) = match block {
                    Block::Hpp => (row, Block::Dp, column),
                    Block::Hqp => (column, Block::Dq, row),
                    _ => continue,
                };
                if let Some((motor, k)) = self.motor(j) {
                    own.add((block, motor, by), -forces[k] * value);
                }
            }
        });
        for ((block, row, column), value) in own.0 {
            put(block, row, column, value);
        }
    }
}

/// Entries of blocks, each once.
struct Sum<T>(Vec<((Block, usize, usize), T)>);

impl<T: Scalar> Sum<T> {
    fn add(&mut self, place: (Block, usize, usize), value: T) {
        match self.0.iter_mut().find(|entry| entry.0 == place) {
            Some(entry) => entry.1 += value,
            None => self.0.push((place, value)),
        }
    }

    /// Removes an entry; 0 if there is none.
    fn take(&mut self, place: (Block, usize, usize)) -> T {
        let found = self.0.iter().position(|entry| entry.0 == place);
        found.map_or(T::zero(), |index| self.0.remove(index).1)
    }
}
