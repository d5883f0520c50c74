//! Methods compiled for one system, where that was measured to pay: cheap steps of one degree of freedom.

use super::run::{Run, chosen, fixed};
use super::{Kind, Row};
use crate::{AdaptiveCollocation, AdaptiveDop853, Leapfrog, ModDg, Rk4, Tiled};
use afterbay_core::{Abilities, Curvature, InputError, Separable, Uniform};
use std::sync::Arc;

/// Binds a method to a system with one degree of freedom in a form compiled for this system; none where
/// [`bind`](super::bind) is as fast.
///
/// # Errors
/// Those of [`bind`](super::bind).
pub fn inlined<S>(row: &Row, system: Arc<S>) -> Option<Result<Run<f64>, InputError>>
where
    S: Abilities<f64> + Separable<f64> + Curvature<f64>,
{
    let name = row.name;
    match row.kind {
        Kind::Leapfrog => Some(fixed::<[f64; 1], S, _>(name, Leapfrog, system)),
        Kind::Rk4 => Some(fixed::<[f64; 1], S, _>(name, Rk4, system)),
        Kind::ModDg if system.clone().linear().is_none() => {
            Some(fixed::<[f64; 1], S, _>(name, ModDg::newton(), system))
        }
        Kind::AdaptiveCollocation => Some(chosen::<[f64; 1], S, _>(name, AdaptiveCollocation, system)),
        Kind::AdaptiveDop853 => Some(chosen::<[f64; 1], S, _>(name, AdaptiveDop853, system)),
        _ => None,
    }
}

/// Binds coordinate increments to a chain or a ring of equal members in a form compiled for this system;
/// none for other methods and where two colours are not enough.
///
/// # Errors
/// Those of [`bind`](super::bind).
pub fn tiled<S: Uniform + 'static>(row: &Row, system: Arc<S>) -> Option<Result<Run<f64>, InputError>>
where
    S::Lanes: 'static,
{
    match row.kind {
        Kind::Increment(composition) if Tiled::fits(&*system).is_ok() => {
            Some(fixed::<Vec<f64>, S, _>(row.name, Tiled::new(composition()), system))
        }
        _ => None,
    }
}
