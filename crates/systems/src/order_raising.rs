//! δ from the Taylor series of the exact flow, for the systems without a closed form of it.

use crate::{Duffing, ModifiedVanDerPol, VanDerPol};
use afterbay_core::{Correction, OrderRaising, Scalar, Series, taylor};

macro_rules! by_series {
    ($($system:ident),*) => {$(
        impl<T: Scalar> OrderRaising<T> for $system<T> {
            fn delta_q(&self, q: T, p: T) -> Correction<T> {
                taylor::corrections(&self.map(Series::constant), q, p)[0]
            }

            fn delta_p(&self, q: T, p: T) -> Correction<T> {
                taylor::corrections(&self.map(Series::constant), q, p)[1]
            }
        }
    )*};
}

by_series!(Duffing, VanDerPol, ModifiedVanDerPol);
