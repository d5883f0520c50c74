//! Methods compiled for one system each, where measurements show a gain: for cheap steps of few
//! degrees of freedom, calls through a table of functions would take as long as the step itself.
//!
//! Each form computes to the bit what the form of [`afterbay_methods::registry::bind`] computes. A
//! system without a row here uses that form.

use afterbay_core::{Abilities, Curvature, InputError, Linear, Separable, Uniform, f64x8};
use afterbay_methods::registry::{Row, Run, inlined};
use afterbay_systems::{
    Custom, DampedDoublePendulum, DampedOscillator, Duffing, FputChain, ModifiedVanDerPol,
    VanDerPol, VanDerPolRing,
};
use std::any::Any;
use std::sync::Arc;

type Untyped = Arc<dyn Any + Send + Sync>;
type Form<T = f64> = Option<Result<Run<T>, InputError>>;

/// Binds a method to a system in the form compiled for it, or returns `None` if there is none.
pub fn bind(row: &Row, system: &Arc<dyn Abilities<f64>>) -> Form {
    const FORMS: [fn(&Row, Untyped) -> Form; 8] = [
        linear::<DampedOscillator<f64>>,
        one_degree::<Duffing<f64>>,
        one_degree::<VanDerPol<f64>>,
        one_degree::<ModifiedVanDerPol<f64>>,
        equal_members::<FputChain<f64>>,
        equal_members::<VanDerPolRing<f64>>,
        few_degrees::<DampedDoublePendulum<f64>>,
        one_degree::<Custom<f64>>,
    ];
    FORMS.iter().find_map(|form| form(row, system.clone()))
}

/// Binds a method to eight systems side by side in the form compiled for it, or returns `None` if
/// there is none.
pub fn bind_lanes(row: &Row, system: &Arc<dyn Abilities<f64x8>>) -> Form<f64x8> {
    const FORMS: [fn(&Row, Untyped) -> Form<f64x8>; 3] = [
        |row, system| inlined::linear_lanes::<DampedOscillator<f64x8>>(row, typed(system)?),
        |row, system| inlined::lanes::<Duffing<f64x8>>(row, typed(system)?),
        |row, system| inlined::lanes::<VanDerPol<f64x8>>(row, typed(system)?),
    ];
    FORMS.iter().find_map(|form| form(row, system.clone()))
}

/// The system, if it is an `S`.
fn typed<S: Send + Sync + 'static>(system: Untyped) -> Option<Arc<S>> {
    system.downcast::<S>().ok()
}

fn one_degree<S: Abilities<f64> + Separable<f64> + Curvature<f64>>(
    row: &Row,
    system: Untyped,
) -> Form {
    let system = typed::<S>(system).filter(|system| system.dof() == 1)?;
    inlined::one_degree(row, system)
}

fn linear<S>(row: &Row, system: Untyped) -> Form
where
    S: Abilities<f64> + Linear<f64> + Curvature<f64>,
{
    inlined::linear::<S>(row, typed(system)?)
}

fn few_degrees<S: Curvature<f64> + 'static>(row: &Row, system: Untyped) -> Form {
    inlined::few_degrees::<Vec<f64>, [f64; 2], S>(row, typed(system)?)
}

fn equal_members<S>(row: &Row, system: Untyped) -> Form
where
    S: Uniform + Curvature<f64> + 'static,
{
    inlined::equal_members::<S>(row, typed(system)?)
}
