//! States around the given one, and the functions of a system there.

use crate::error::InputError;
use crate::quantity::Quantity;
use crate::system::System;

/// A state and the functions of the system there.
pub(super) struct Place {
    pub(super) q: Vec<f64>,
    pub(super) p: Vec<f64>,
    pub(super) fields: Fields,
}

/// The number of states around the given one. A choice.
const STATES_AROUND: usize = 32;

/// The state and others at several distances from it, as far as the system is finite there.
pub(super) fn around(system: &dyn System<f64>, q: &[f64], p: &[f64]) -> Vec<Place> {
    let place = |q: Vec<f64>, p: Vec<f64>| {
        let fields = Fields::at(system, &q, &p);
        Place { q, p, fields }
    };
    let others = (0..STATES_AROUND).map(|k| {
        let size = [1.0, 0.25, 0.01][k % 3];
        place(displaced(q, k, size), displaced(p, k + STATES_AROUND, size))
    });
    let here = place(q.to_vec(), p.to_vec());
    std::iter::once(here).chain(others.filter(|place| place.fields.finite().is_ok())).collect()
}

/// The states from which edges start: the given one and the first of the others. If the given one
/// has zeros, products with them vanish along every edge from it; the other has no zeros.
pub(super) fn starts(places: &[Place]) -> &[Place] {
    &places[..places.len().min(2)]
}

/// x displaced by multiples of the golden ratio modulo 1, which are evenly distributed.
pub(super) fn displaced(x: &[f64], k: usize, size: f64) -> Vec<f64> {
    let (golden, size) = ((5.0_f64.sqrt() - 1.0) / 2.0, size * reach(x));
    let offset = |i: usize| 2.0 * ((k * x.len() + i + 1) as f64 * golden).fract() - 1.0;
    x.iter().enumerate().map(|(i, x)| x + size * offset(i)).collect()
}

/// The largest value of a function of a place at any of the places.
pub(super) fn most(places: &[Place], of: impl Fn(&Place) -> f64) -> f64 {
    places.iter().fold(0.0, |most, place| of(place).abs().max(most))
}

/// The functions of a system at a state.
#[derive(Clone, Debug)]
pub(super) struct Fields {
    pub(super) h: f64,
    pub(super) hq: Vec<f64>,
    pub(super) hp: Vec<f64>,
    pub(super) d: Vec<f64>,
}

impl Fields {
    pub(super) fn at(system: &dyn System<f64>, q: &[f64], p: &[f64]) -> Self {
        Self::over(0.0, system, q, p)
    }

    /// The functions of a system that writes them over this value.
    pub(super) fn over(value: f64, system: &dyn System<f64>, q: &[f64], p: &[f64]) -> Self {
        let [mut hq, mut hp, mut d] = [(); 3].map(|()| vec![value; q.len()]);
        system.gradient(q, p, &mut hq, &mut hp);
        system.dissipation(q, p, &hp, &mut d);
        Self { h: system.energy(q, p), hq, hp, d }
    }

    pub(super) fn finite(&self) -> Result<(), InputError> {
        let parts = [
            (Quantity::Energy, std::slice::from_ref(&self.h)),
            (Quantity::Slope, &self.hq),
            (Quantity::Velocity, &self.hp),
            (Quantity::Dissipation, &self.d),
        ];
        parts.into_iter().try_for_each(|(quantity, part)| finite(quantity, part))
    }
}

/// Checks that the entries are finite.
pub(super) fn finite(quantity: Quantity, part: &[f64]) -> Result<(), InputError> {
    match part.iter().enumerate().find(|(_, x)| !x.is_finite()) {
        Some((dof, &value)) => Err(InputError::NotFinite { quantity, dof, value }),
        None => Ok(()),
    }
}

/// The relative rounding error allowed for a formula of up to a thousand operations, summed over n
/// terms.
pub(super) fn rounding(n: usize) -> f64 {
    f64::EPSILON / 2.0 * (1000.0 + n as f64)
}

/// The distance from the state up to which claims are tested.
pub(super) fn reach(x: &[f64]) -> f64 {
    x.iter().fold(1.0, |reach, x| x.abs().max(reach))
}

/// x with its entry j replaced.
pub(super) fn moved(x: &[f64], j: usize, to: f64) -> Vec<f64> {
    x.iter().enumerate().map(|(i, &x)| if i == j { to } else { x }).collect()
}
