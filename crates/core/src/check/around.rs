//! States around the one given.

use super::{Fields, reach};
use crate::System;

/// A state and what the system is there.
pub(super) struct Place {
    pub(super) q: Vec<f64>,
    pub(super) p: Vec<f64>,
    pub(super) fields: Fields,
}

const PLACES: usize = 32;

/// The state and some others within its reach, near and far, where the system is finite.
pub(super) fn around<S: System<f64> + ?Sized>(system: &S, q: &[f64], p: &[f64]) -> Vec<Place> {
    let place = |q: Vec<f64>, p: Vec<f64>| {
        let fields = Fields::at(system, &q, &p);
        Place { q, p, fields }
    };
    let others = (0..PLACES).map(|k| {
        let size = [1.0, 0.25, 0.01][k % 3];
        place(displaced(q, k, size), displaced(p, k + PLACES, size))
    });
    let here = place(q.to_vec(), p.to_vec());
    std::iter::once(here).chain(others.filter(|place| place.fields.finite().is_ok())).collect()
}

/// Where edges start: the state, and the first of the others. Where the state has zeros, products with them vanish along every
/// edge from it; the other has none.
pub(super) fn starts(places: &[Place]) -> &[Place] {
    &places[..places.len().min(2)]
}

/// Multiples of the golden ratio, modulo 1, fill an interval evenly.
pub(super) fn displaced(x: &[f64], k: usize, size: f64) -> Vec<f64> {
    let (golden, size) = ((5.0_f64.sqrt() - 1.0) / 2.0, size * reach(x));
    let offset = |i: usize| 2.0 * ((k * x.len() + i + 1) as f64 * golden).fract() - 1.0;
    x.iter().enumerate().map(|(i, x)| x + size * offset(i)).collect()
}
