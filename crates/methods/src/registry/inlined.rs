//! Methods compiled for one system each. [`bind`](super::bind) serves every system through dynamic
//! dispatch; the forms here serve systems whose steps are so cheap that the cost of these calls is
//! measurable.

use super::run::{Run, chosen, fixed};
use super::{Kind, Row};
use crate::moddg::steps::Plain;
use crate::{
    AdaptiveCollocation, AdaptiveDop853, Collocation, Gonzalez, Increment, Leapfrog, ModDg, Rk4,
    Tiled,
};
use afterbay_core::solver::FixedPoint;
use afterbay_core::{Abilities, Curvature, InputError, Linear, Separable, Uniform, Vector};
use std::sync::Arc;

/// Binds a method to a separable system with one degree of freedom. Returns `None` where
/// [`bind`](super::bind) is as fast.
///
/// # Errors
/// Those of [`bind`](super::bind).
pub fn one_degree<S>(row: &Row, system: Arc<S>) -> Option<Result<Run<f64>, InputError>>
where
    S: Abilities<f64> + Separable<f64> + Curvature<f64>,
{
    let name = row.name;
    match row.kind {
        Kind::Leapfrog => Some(fixed::<[f64; 1], S, _>(name, Leapfrog, system)),
        // Linear systems have a closed form.
        Kind::ModDg if system.clone().linear().is_none() => {
            Some(fixed::<[f64; 1], S, _>(name, ModDg::newton(), system))
        }
        Kind::ModDgFixedPoint => {
            let method = ModDg { steps: Plain, solver: FixedPoint };
            Some(fixed::<[f64; 1], S, _>(name, method, system))
        }
        Kind::Increment(composition) => {
            Some(fixed::<[f64; 1], S, _>(name, Increment::new(composition()), system))
        }
        _ => few_degrees::<[f64; 1], [f64; 1], S>(row, system),
    }
}

/// Binds a method to a linear system with one degree of freedom, with the closed form of implicit
/// steps. Returns `None` where [`bind`](super::bind) is as fast.
///
/// # Errors
/// Those of [`bind`](super::bind).
pub fn linear<S>(row: &Row, system: Arc<S>) -> Option<Result<Run<f64>, InputError>>
where
    S: Abilities<f64> + Linear<f64> + Curvature<f64>,
{
    match row.kind {
        Kind::ModDg => Some(fixed::<[f64; 1], S, _>(row.name, ModDg::linear(), system)),
        _ => one_degree(row, system),
    }
}

/// Binds a method to any system with few degrees of freedom. States are stored in `V` while the
/// method steps, and in `W` for `adaptive-dop853`. Returns `None` where [`bind`](super::bind) is as
/// fast.
///
/// # Errors
/// Those of [`bind`](super::bind).
pub fn few_degrees<V, W, S>(row: &Row, system: Arc<S>) -> Option<Result<Run<f64>, InputError>>
where
    V: Vector<Scalar = f64> + 'static,
    W: Vector<Scalar = f64> + 'static,
    S: Curvature<f64> + 'static,
{
    let name = row.name;
    match row.kind {
        Kind::Rk4 => Some(fixed::<V, S, _>(name, Rk4, system)),
        Kind::Relaxed(method) => Some(fixed::<V, S, _>(name, method, system)),
        Kind::Collocation(stages) => Some(fixed::<V, S, _>(name, Collocation::new(stages), system)),
        Kind::AdaptiveCollocation => Some(chosen::<V, S, _>(name, AdaptiveCollocation, system)),
        Kind::AdaptiveDop853 => Some(chosen::<W, S, _>(name, AdaptiveDop853, system)),
        _ => None,
    }
}

/// Binds a method to a chain or a ring of equal members. Returns `None` where [`bind`](super::bind)
/// is as fast, and for increments on systems that two colours do not separate.
///
/// # Errors
/// Those of [`bind`](super::bind).
pub fn equal_members<S>(row: &Row, system: Arc<S>) -> Option<Result<Run<f64>, InputError>>
where
    S: Uniform + Curvature<f64> + 'static,
    S::Lanes: 'static,
{
    let name = row.name;
    match row.kind {
        Kind::Increment(composition) if Tiled::fits(&*system).is_ok() => {
            Some(fixed::<Vec<f64>, S, _>(name, Tiled::new(composition()), system))
        }
        _ if system.dof() == 1 => None,
        Kind::Leapfrog => Some(fixed::<Vec<f64>, S, _>(name, Leapfrog, system)),
        Kind::Gonzalez => Some(fixed::<Vec<f64>, S, _>(name, Gonzalez::default(), system)),
        Kind::AdaptiveCollocation => {
            Some(chosen::<Vec<f64>, S, _>(name, AdaptiveCollocation, system))
        }
        Kind::AdaptiveDop853 if system.dof() == 2 => None,
        Kind::AdaptiveDop853 => Some(chosen::<Vec<f64>, S, _>(name, AdaptiveDop853, system)),
        _ => None,
    }
}
