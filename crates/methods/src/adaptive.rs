//! Step size control, shared by the adaptive methods: the error allowed for a step, and bounds of a
//! system's frequencies. The end of a step and its projection onto K stand here too; implicit
//! methods of fixed step use the projection.

mod budget;
mod end;
mod kinks;
mod noise;
mod orders;
mod projection;
mod rates;
mod slope_roundings;

pub(crate) use budget::{
    Budget, ROUNDINGS, SHARES, Sizes, scales, size_of_first_or_nan, size_or_nan,
};
pub(crate) use end::End;
pub(crate) use kinks::{KINK_ORDER, Kinks, Passage, roundings_of_time, time_rounding};
pub(crate) use noise::{ROUNDING_SUSPECTED_BELOW, is_noise, is_rounding_at_rest};
pub(crate) use orders::adaptive_of_orders;
pub(crate) use projection::{LARGEST_PROJECTION, Projection, REFUSED_ERROR};
pub(crate) use rates::Rates;
pub(crate) use slope_roundings::SlopeRoundings;
