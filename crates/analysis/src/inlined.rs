//! The systems for which methods are compiled apart, where that was measured to pay.

use afterbay_core::{Abilities, Curvature, InputError, Separable, Uniform};
use afterbay_methods::registry::{self, Row, Run};
use afterbay_systems::{DampedOscillator, Duffing, FputChain, ModifiedVanDerPol, VanDerPol, VanDerPolRing};
use std::any::Any;
use std::sync::Arc;

type Untyped = Arc<dyn Any + Send + Sync>;
type Form = Option<Result<Run<f64>, InputError>>;

/// Binds a method to a system in the form compiled for it; none where there is none.
pub(crate) fn bind(row: &Row, system: &Arc<dyn Abilities<f64>>) -> Form {
    const FORMS: [fn(&Row, Untyped) -> Form; 6] = [
        single::<DampedOscillator<f64>>,
        single::<Duffing<f64>>,
        single::<VanDerPol<f64>>,
        single::<ModifiedVanDerPol<f64>>,
        tiled::<FputChain<f64>>,
        tiled::<VanDerPolRing<f64>>,
    ];
    FORMS.iter().find_map(|form| form(row, system.clone()))
}

fn single<S: Abilities<f64> + Separable<f64> + Curvature<f64>>(row: &Row, system: Untyped) -> Form {
    registry::inlined(row, system.downcast::<S>().ok()?)
}

fn tiled<S: Uniform + 'static>(row: &Row, system: Untyped) -> Form {
    registry::tiled(row, system.downcast::<S>().ok()?)
}
