//! Methods compiled for one system each. [`bind`](super::bind) serves every system through dynamic
//! dispatch; the forms here serve systems whose steps are so cheap that the cost of these calls is
//! measurable.

use super::Row;
use super::run::{Run, chosen, fixed};
use crate::increment::Increments;
use crate::moddg::steps::Plain;
use crate::{
    AdaptiveCollocation, AdaptiveDop853, AdaptiveVerner87, AdaptiveVerner98, Collocation, Gonzalez,
    Leapfrog, ModDg, Relaxed, Rk4, Tiled,
};
use afterbay_core::solver::FixedPoint;
use afterbay_core::{
    Abilities, Adaptive, Curvature, InputError, Linear, Method, Separable, Single, System, Uniform,
    Vector, f64x8,
};
use std::sync::Arc;

type Form<T = f64> = Option<Result<Run<T>, InputError>>;

/// Binds the method of the row to `system` if it is an `M`. States are stored in `V`.
fn fixed_if<V, M, S>(row: &Row, system: &Arc<S>) -> Form<V::Scalar>
where
    V: Vector + 'static,
    S: System<V::Scalar> + 'static,
    M: Method<V, S> + Copy + Send + Sync + 'static,
    M::Workspace: Clone + Send + Sync + 'static,
{
    Some(fixed::<V, S, M>(row.name, *row.method::<M>()?, system.clone()))
}

/// Binds the method of the row, which has step size control, to `system` if it is an `M`.
fn chosen_if<V, M, S>(row: &Row, system: &Arc<S>) -> Form
where
    V: Vector<Scalar = f64> + 'static,
    S: System<f64> + 'static,
    M: Adaptive<V, S> + Copy + Send + Sync + 'static,
{
    Some(chosen::<V, S, M>(row.name, *row.method::<M>()?, system.clone()))
}

/// Binds a method to a separable system with one degree of freedom. Returns `None` where
/// [`bind`](super::bind) is as fast.
///
/// # Errors
/// Those of [`bind`](super::bind).
pub fn one_degree<S>(row: &Row, system: Arc<S>) -> Option<Result<Run<f64>, InputError>>
where
    S: Abilities<f64> + Separable<f64> + Curvature<f64>,
{
    if let Some(increments) = row.method::<Increments>() {
        return Some(fixed::<Single<f64>, S, _>(row.name, increments.in_sequence(), system));
    }
    // Linear systems have a closed form.
    if row.method::<ModDg>().is_some() && system.clone().linear().is_some() {
        return None;
    }
    fixed_if::<Single<f64>, Leapfrog, S>(row, &system)
        .or_else(|| fixed_if::<Single<f64>, ModDg, S>(row, &system))
        .or_else(|| fixed_if::<Single<f64>, ModDg<Plain, FixedPoint>, S>(row, &system))
        .or_else(|| few_degrees::<Single<f64>, Single<f64>, S>(row, system))
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
    match row.method::<ModDg>() {
        Some(_) => Some(fixed::<Single<f64>, S, _>(row.name, ModDg::linear(), system)),
        None => one_degree(row, system),
    }
}

/// Binds `leapfrog`, `rk4` or `moddg`, which maps compare most, to eight separable systems with one
/// degree of freedom side by side. Returns `None` for all other methods.
///
/// # Errors
/// Those of [`bind`](super::bind).
pub fn lanes<S>(row: &Row, system: Arc<S>) -> Option<Result<Run<f64x8>, InputError>>
where
    S: Abilities<f64x8> + Separable<f64x8>,
{
    explicit_lanes(row, &system).or_else(|| fixed_if::<Single<f64x8>, ModDg, S>(row, &system))
}

/// [`lanes`] of linear systems, with the closed form of modDG.
///
/// # Errors
/// Those of [`bind`](super::bind).
pub fn linear_lanes<S>(row: &Row, system: Arc<S>) -> Option<Result<Run<f64x8>, InputError>>
where
    S: Abilities<f64x8> + Linear<f64x8>,
{
    match row.method::<ModDg>() {
        Some(_) => Some(fixed::<Single<f64x8>, S, _>(row.name, ModDg::linear(), system)),
        None => explicit_lanes(row, &system),
    }
}

fn explicit_lanes<S: Separable<f64x8> + 'static>(row: &Row, system: &Arc<S>) -> Form<f64x8> {
    fixed_if::<Single<f64x8>, Leapfrog, S>(row, system)
        .or_else(|| fixed_if::<Single<f64x8>, Rk4, S>(row, system))
}

/// Binds a method to any system with few degrees of freedom. States are stored in `V` while the
/// method steps, and in `W` for the explicit methods with step size control. Returns `None` where
/// [`bind`](super::bind) is as fast.
///
/// # Errors
/// Those of [`bind`](super::bind).
pub fn few_degrees<V, W, S>(row: &Row, system: Arc<S>) -> Option<Result<Run<f64>, InputError>>
where
    V: Vector<Scalar = f64> + 'static,
    W: Vector<Scalar = f64> + 'static,
    S: Curvature<f64> + 'static,
{
    fixed_if::<V, Rk4, S>(row, &system)
        .or_else(|| fixed_if::<V, Relaxed, S>(row, &system))
        .or_else(|| fixed_if::<V, Collocation, S>(row, &system))
        .or_else(|| chosen_if::<V, AdaptiveCollocation, S>(row, &system))
        .or_else(|| chosen_if::<W, AdaptiveDop853, S>(row, &system))
        .or_else(|| chosen_if::<W, AdaptiveVerner98, S>(row, &system))
        .or_else(|| chosen_if::<W, AdaptiveVerner87, S>(row, &system))
}

/// Binds a method to a chain or a ring of equal members. Returns `None` where [`bind`](super::bind)
/// is as fast, and for increments on systems that two colours do not separate.
///
/// # Errors
/// Those of [`bind`](super::bind).
pub fn equal_members<S>(row: &Row, system: Arc<S>) -> Option<Result<Run<f64>, InputError>>
where
    S: Uniform + Curvature<f64> + 'static,
{
    if let Some(increments) = row.method::<Increments>()
        && Tiled::fits(&*system).is_ok()
    {
        return Some(fixed::<Vec<f64>, S, _>(row.name, increments.tiled(), system));
    }
    if system.dof() == 1 {
        return None;
    }
    fixed_if::<Vec<f64>, Leapfrog, S>(row, &system)
        .or_else(|| fixed_if::<Vec<f64>, Gonzalez, S>(row, &system))
}
