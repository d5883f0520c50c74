//! The memory of the solution of linear equations by products with their matrix.

use super::rule::Modes;
use crate::linear::Gmres;
use afterbay_core::Scalar;

/// The largest number of products with the derivative for a correction. A choice: each keeps a
/// vector.
const MOST_PRODUCTS: usize = 60;

/// The memory of Newton's iteration with the exact derivative.
#[derive(Clone, Debug)]
pub(super) struct Krylov<T> {
    pub(super) gmres: Gmres,
    /// The γ to which a correction is added, and a copy to restore
    pub(super) base: [Vec<Modes<T>>; 2],
    pub(super) kept: [Vec<Modes<T>>; 2],
    /// The residual of γ, and the correction
    pub(super) missed: Vec<f64>,
    pub(super) correction: Vec<f64>,
}

impl<T: Scalar> Krylov<T> {
    pub(super) fn new(modes: &[Modes<T>], unknowns: usize) -> Self {
        let pair = || [modes.to_vec(), modes.to_vec()];
        Self {
            gmres: Gmres::new(unknowns, MOST_PRODUCTS.min(unknowns)),
            base: pair(),
            kept: pair(),
            missed: vec![0.0; unknowns],
            correction: vec![0.0; unknowns],
        }
    }

    /// Saves γ.
    pub(super) fn keep(&mut self, modes: [&mut [Modes<T>]; 2]) {
        self.kept.iter_mut().zip(modes).for_each(|(to, from)| to.copy_from_slice(from));
    }

    /// Restores the saved γ.
    pub(super) fn recall(&self, modes: [&mut [Modes<T>]; 2]) {
        self.kept.iter().zip(modes).for_each(|(from, to)| to.copy_from_slice(from));
    }
}
