//! The binding of increments to systems: the variant, and the order of the coordinates, that fit.

use super::{Composition, GeneralIncrement, Increment};
use crate::kernels::Tiled;
use crate::registry::binding::{Binding, Bound, InLanes, Target};
use crate::registry::fixed;
use afterbay_core::{Corrected, Lanewise, Scalar, Separable, Single, Vector, f64x8};
use std::sync::Arc;

/// Coordinate increments in a composition of sweeps.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Increments(pub(crate) fn() -> Composition);

impl Binding for Increments {
    const LANES: Option<InLanes<Self>> = Some(Self::bind_lanes);

    fn bind<V: Vector + 'static>(&self, target: &Target<'_, V::Scalar>) -> Bound<V::Scalar> {
        match (target.separable(), target.system.clone().phase_planes()) {
            (Ok(system), _) => target.fixed::<V, _, _>(self.ordered(target), system),
            (_, Some(system)) => target.fixed::<V, _, _>(GeneralIncrement::new(self.0()), system),
            _ if target.system.driven().is_some() => {
                Err(target.refused("H is not separable and the system has a drive"))
            }
            (Err(error), None) => Err(error),
        }
    }

    fn bind_f64(&self, target: &Target<'_, f64>) -> Bound<f64> {
        match target.system.clone().uniform() {
            Some(members) if Tiled::fits(&*members).is_ok() => {
                fixed::<Vec<f64>, _, _>(target.name, self.tiled(), members)
            }
            _ => self.bind_stored(target),
        }
    }
}

impl Increments {
    /// The increments with the coordinates in their natural order.
    pub(crate) fn in_sequence(self) -> Increment {
        Increment::new(self.0())
    }

    /// The increments for chains and rings of equal members.
    pub(crate) fn tiled(self) -> Tiled {
        Tiled::new(self.0())
    }

    /// The increments in the order of coordinates that [`Tiled`] takes in chains and rings of equal
    /// members, so that results do not depend on the scalar, and in lanes agree to the bit.
    fn ordered<T: Scalar>(self, target: &Target<'_, T>) -> Increment {
        let system = target.system;
        let (n, coupling) = (system.dof(), system.coupling());
        let red_and_black =
            system.is_uniform() && coupling.two_coloured(n) && !system.dissipation_form().coupled;
        let all = self.in_sequence();
        if red_and_black { all.in_order(coupling.coloured(n)) } else { all }
    }

    fn bind_lanes(&self, target: &Target<'_, f64x8>) -> Bound<f64x8> {
        let (method, system) = (self.ordered(target), target.separable()?);
        if target.system.dof() == 1 {
            target.fixed::<Single<f64x8>, _, _>(method, system)
        } else {
            target.fixed::<Vec<f64x8>, _, _>(method, system)
        }
    }

    /// Binds compensated increments ([`Increment::compensated`]) with coloured sweeps. `exact` is
    /// the same system in [`Corrected`] numbers.
    pub(crate) fn compensated<T: Lanewise>(
        self,
        target: &Target<'_, T>,
        exact: Arc<dyn Separable<Corrected<T>>>,
    ) -> Bound<T> {
        let order = target.system.coupling().coloured(target.system.dof());
        let method = self.in_sequence().in_order(order).compensated(exact);
        target.fixed::<Vec<T>, _, _>(method, target.separable()?)
    }
}
