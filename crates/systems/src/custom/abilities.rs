//! What a custom system can do.

use super::Custom;
use afterbay_core::{Abilities, Scalar, SecondDerivatives, Separable};
use std::sync::Arc;

impl<T: Scalar> Abilities<T> for Custom<T> {
    fn separable(self: Arc<Self>) -> Option<Arc<dyn Separable<T>>> {
        Some(self)
    }

    fn second_derivatives(self: Arc<Self>) -> Option<Arc<dyn SecondDerivatives<T>>> {
        Some(self)
    }
}
