//! The binding of the schemes to systems: in closed form where the system is linear.

use super::driven::DrivenModDg;
use super::steps::{Equation, Plain, Printed, Raised};
use super::{ClosedForm, ModDg};
use crate::registry::binding::{Binding, Bound, InLanes, Target};
use afterbay_core::Vector;
use afterbay_core::solver::{FixedPoint, Newton};

impl Binding for ModDg {
    const LANES: Option<InLanes<Self>> = Some(Self::bind_stored);

    fn bind<V: Vector + 'static>(&self, target: &Target<'_, V::Scalar>) -> Bound<V::Scalar> {
        if let Some(system) = target.closed() {
            return target.fixed::<V, _, _>(ModDg::linear(), system);
        }
        let system = target.separable()?;
        if system.motors() > 0 {
            target.fixed::<V, _, _>(DrivenModDg, system)
        } else {
            target.fixed::<V, _, _>(*self, system)
        }
    }
}

impl Binding for ModDg<Plain, FixedPoint> {
    fn bind<V: Vector + 'static>(&self, target: &Target<'_, V::Scalar>) -> Bound<V::Scalar> {
        let system = target.separable()?;
        if system.motors() > 0 {
            return Err(target.refused("it takes no drive and no V or D that depends on t"));
        }
        target.fixed::<V, _, _>(*self, system)
    }
}

impl Binding for Raised {
    fn bind<V: Vector + 'static>(&self, target: &Target<'_, V::Scalar>) -> Bound<V::Scalar> {
        let steps = *self;
        match target.misprinted() {
            Ok(system) => target.fixed::<V, _, _>(ModDg { steps, solver: ClosedForm }, system),
            Err(_) => {
                target.fixed::<V, _, _>(ModDg { steps, solver: Newton }, target.order_raising()?)
            }
        }
    }

    fn poles(&self) -> &'static [Equation] {
        self.0.equations()
    }
}

impl Binding for Printed {
    fn bind<V: Vector + 'static>(&self, target: &Target<'_, V::Scalar>) -> Bound<V::Scalar> {
        let method = ModDg { steps: *self, solver: ClosedForm };
        target.fixed::<V, _, _>(method, target.misprinted()?)
    }

    fn poles(&self) -> &'static [Equation] {
        self.0.equations()
    }
}
