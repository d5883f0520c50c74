//! A cycle on a branch, with the direction of the branch there.

use crate::study::limit_cycle::cycle::Cycle;
use crate::study::limit_cycle::event::{self, Tests};
use crate::study::limit_cycle::shooting::{Image, Shooting, null_vector};
use crate::study::limit_cycle::{CycleFailure, phase};
use faer::Mat;

/// A cycle on the branch.
#[derive(Clone)]
pub(super) struct Place {
    /// The unknowns (z, T, λ).
    pub(super) x: Vec<f64>,
    /// The direction of the branch, of length 1, measured by the sizes of the unknowns.
    pub(super) along: Vec<f64>,
    pub(super) image: Image,
    pub(super) cycle: Cycle,
    pub(super) tests: Tests,
}

impl Place {
    /// A cycle, with the direction that points toward another one.
    pub(super) fn new(
        shooting: &Shooting<'_>,
        x: Vec<f64>,
        image: Image,
        toward: &[f64],
    ) -> Result<Self, CycleFailure> {
        let phase = shooting.free().then(|| phase(shooting, &image.path, &x));
        let size = shooting.size();
        let rows = size + usize::from(phase.is_some());
        let matrix = Mat::from_fn(rows, x.len(), |i, j| match &phase {
            Some(phase) if i == size => phase.normal[j],
            _ => image.matrix[(i, j)] / shooting.scales[i],
        });
        let mut along = null_vector(&matrix)?;
        if dot(&along, toward) < 0.0 {
            along.iter_mut().for_each(|x| *x = -*x);
        }
        let cycle = Cycle::of(shooting, &x, &image)?;
        let tests = event::tests(&cycle, along[x.len() - 1]);
        Ok(Self { x, along, image, cycle, tests })
    }
}

/// a·b
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
