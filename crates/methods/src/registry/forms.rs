//! The compiled forms of the methods: each once per scalar for every system, and some for one
//! system.

use super::run::{Once, Run, chosen, fixed};
use super::{Kind, Row};
use crate::moddg::ClosedForm;
use crate::moddg::steps::Plain;
use crate::{
    AdaptiveCollocation, AdaptiveDop853, Collocation, GeneralIncrement, Gonzalez, Increment,
    Leapfrog, LinearExact, LocallyExact, ModDg, Rk4, Tiled,
};
use afterbay_core::solver::{FixedPoint, Newton};
use afterbay_core::{
    Abilities, Corrected, InputError, Lanewise, Linear, Misprinted, OrderRaising, Quantity, Scalar,
    SecondDerivatives, Separable, Vector, f64x8,
};
use std::sync::Arc;

/// The reasons for refusing a system that lacks an ability.
const NOT_SEPARABLE: &str = "H is not separable";
const NO_DELTA: &str = "the system has no formula for δ";
const NOT_PRINTED: &str = "the paper prints δ for the damped oscillator only";
const NO_CURVATURE: &str = "the system has no second derivatives";

/// A system and the row of the method to bind to it.
struct Pair<'a, T: Scalar> {
    row: &'a Row,
    system: &'a Arc<dyn Abilities<T>>,
}

impl<T: Scalar> Pair<'_, T> {
    fn refused(&self, why: &'static str) -> InputError {
        InputError::Unsupported { method: self.row.name, why }
    }

    fn separable(&self) -> Result<Arc<dyn Separable<T>>, InputError> {
        self.system.clone().separable().ok_or_else(|| self.refused(NOT_SEPARABLE))
    }

    fn curvature(&self) -> Result<Arc<dyn SecondDerivatives<T>>, InputError> {
        self.system.clone().second_derivatives().ok_or_else(|| self.refused(NO_CURVATURE))
    }

    /// The system as a linear one with one degree of freedom, for which implicit steps have a
    /// closed form.
    fn closed(&self) -> Option<Arc<dyn Linear<T>>> {
        if self.system.dof() == 1 { self.system.clone().linear() } else { None }
    }

    fn order_raising(&self) -> Result<Arc<dyn OrderRaising<T>>, InputError> {
        self.separable()?;
        self.system.clone().order_raising().ok_or_else(|| self.refused(NO_DELTA))
    }

    fn misprinted(&self) -> Result<Arc<dyn Misprinted<T>>, InputError> {
        self.order_raising()?;
        self.system.clone().misprinted().ok_or_else(|| self.refused(NOT_PRINTED))
    }
}

/// Binds a fixed-step method to any system, with states stored in `V`.
pub(super) fn of_any<V>(
    row: &Row,
    system: &Arc<dyn Abilities<V::Scalar>>,
) -> Result<Run<V::Scalar>, InputError>
where
    V: Vector + 'static,
{
    let (name, pair) = (row.name, Pair { row, system });
    match row.kind {
        Kind::Leapfrog => fixed::<V, _, _>(name, Once(Leapfrog), pair.separable()?),
        Kind::Rk4 => fixed::<V, dyn Abilities<V::Scalar>, _>(name, Once(Rk4), system.clone()),
        Kind::Relaxed(method) => {
            fixed::<V, dyn Abilities<V::Scalar>, _>(name, Once(method), system.clone())
        }
        Kind::Gonzalez => fixed::<V, _, _>(name, Once(Gonzalez::default()), pair.curvature()?),
        Kind::LocallyExact => fixed::<V, _, _>(name, Once(LocallyExact), pair.curvature()?),
        Kind::LinearExact => fixed::<V, _, _>(name, Once(LinearExact), pair.curvature()?),
        Kind::Collocation(stages) => {
            fixed::<V, _, _>(name, Once(Collocation::new(stages)), pair.curvature()?)
        }
        Kind::Increment(composition) => match (pair.separable(), system.clone().phase_planes()) {
            (Ok(system), _) => fixed::<V, _, _>(name, Once(Increment::new(composition())), system),
            (_, Some(system)) => {
                fixed::<V, _, _>(name, Once(GeneralIncrement::new(composition())), system)
            }
            (Err(error), None) => Err(error),
        },
        Kind::ModDg => match pair.closed() {
            Some(system) => fixed::<V, _, _>(name, Once(ModDg::linear()), system),
            None => fixed::<V, _, _>(name, Once(ModDg::newton()), pair.separable()?),
        },
        Kind::ModDgFixedPoint => {
            let method = ModDg { steps: Plain, solver: FixedPoint };
            fixed::<V, _, _>(name, Once(method), pair.separable()?)
        }
        Kind::Raised(steps) => match pair.misprinted() {
            Ok(system) => fixed::<V, _, _>(name, Once(ModDg { steps, solver: ClosedForm }), system),
            Err(_) => {
                fixed::<V, _, _>(name, Once(ModDg { steps, solver: Newton }), pair.order_raising()?)
            }
        },
        Kind::Printed(steps) => {
            fixed::<V, _, _>(name, Once(ModDg { steps, solver: ClosedForm }), pair.misprinted()?)
        }
        Kind::AdaptiveCollocation | Kind::AdaptiveDop853 => {
            Err(pair.refused("it runs in f64 only"))
        }
    }
}

/// Binds any method to any system in `f64`.
pub(super) fn in_f64(row: &Row, system: &Arc<dyn Abilities<f64>>) -> Result<Run<f64>, InputError> {
    let (name, pair) = (row.name, Pair { row, system });
    match (row.kind, system.dof()) {
        (_, 0) => Err(InputError::Length { quantity: Quantity::Coordinate, expected: 1, found: 0 }),
        (Kind::AdaptiveCollocation, 1) => {
            chosen::<[f64; 1], _, _>(name, AdaptiveCollocation, pair.curvature()?)
        }
        (Kind::AdaptiveCollocation, _) => {
            chosen::<Vec<f64>, _, _>(name, AdaptiveCollocation, pair.curvature()?)
        }
        (Kind::AdaptiveDop853, 1) => {
            chosen::<[f64; 1], _, _>(name, AdaptiveDop853, pair.curvature()?)
        }
        (Kind::AdaptiveDop853, 2) => {
            chosen::<[f64; 2], _, _>(name, AdaptiveDop853, pair.curvature()?)
        }
        (Kind::AdaptiveDop853, _) => {
            chosen::<Vec<f64>, _, _>(name, AdaptiveDop853, pair.curvature()?)
        }
        (Kind::Increment(composition), _) => match system.clone().uniform() {
            Some(members) if Tiled::fits(&*members).is_ok() => {
                fixed::<Vec<f64>, _, _>(name, Tiled::new(composition()), members)
            }
            _ => of_any::<Vec<f64>>(row, system),
        },
        (_, 1) => of_any::<[f64; 1]>(row, system),
        _ => of_any::<Vec<f64>>(row, system),
    }
}

/// Binds a method to eight systems side by side. Each lane computes to the bit what it would alone,
/// provided the scalar's functions do. Methods that are implicit in all degrees of freedom at once
/// have no lanes, since pivots and the number of iterations depend on the system. A step that fails
/// in one lane changes none.
pub(super) fn in_lanes(
    row: &Row,
    system: &Arc<dyn Abilities<f64x8>>,
) -> Result<Run<f64x8>, InputError> {
    if system.dof() == 1 {
        stored_lanes::<[f64x8; 1]>(row, system)
    } else {
        stored_lanes::<Vec<f64x8>>(row, system)
    }
}

fn stored_lanes<V>(row: &Row, system: &Arc<dyn Abilities<f64x8>>) -> Result<Run<f64x8>, InputError>
where
    V: Vector<Scalar = f64x8> + 'static,
{
    let (name, pair) = (row.name, Pair { row, system });
    match row.kind {
        Kind::Leapfrog => fixed::<V, _, _>(name, Once(Leapfrog), pair.separable()?),
        Kind::Rk4 => fixed::<V, dyn Abilities<f64x8>, _>(name, Once(Rk4), system.clone()),
        Kind::Increment(composition) => {
            let (n, coupling) = (system.dof(), system.coupling());
            let red_and_black = system.is_uniform()
                && coupling.two_coloured(n)
                && !system.dissipation_form().coupled;
            let order = if red_and_black { coupling.coloured(n) } else { (0..n).collect() };
            fixed::<V, _, _>(
                name,
                Once(Increment::new(composition()).in_order(order)),
                pair.separable()?,
            )
        }
        Kind::ModDg => match pair.closed() {
            Some(system) => fixed::<V, _, _>(name, Once(ModDg::linear()), system),
            None => fixed::<V, _, _>(name, Once(ModDg::newton()), pair.separable()?),
        },
        _ => Err(pair.refused("it steps one system at a time")),
    }
}

/// Binds compensated coordinate increments ([`Increment::compensated`]) with coloured sweeps.
pub(super) fn compensated<T: Lanewise>(
    row: &Row,
    system: &Arc<dyn Abilities<T>>,
    exact: Arc<dyn Separable<Corrected<T>>>,
) -> Result<Run<T>, InputError> {
    let pair = Pair { row, system };
    let Kind::Increment(composition) = row.kind else {
        return Err(pair.refused("only coordinate increments can be compensated"));
    };
    let order = system.coupling().coloured(system.dof());
    let method = Increment::new(composition()).in_order(order).compensated(exact);
    fixed::<Vec<T>, _, _>(row.name, Once(method), pair.separable()?)
}
