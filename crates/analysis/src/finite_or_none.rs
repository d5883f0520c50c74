//! Numbers of a table that are empty cells where they are not finite.

use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Writes a number, or none.
pub(crate) fn serialize<S: Serializer>(number: &f64, to: S) -> Result<S::Ok, S::Error> {
    Some(*number).filter(|number| number.is_finite()).serialize(to)
}

/// Reads a number, NaN for none.
pub(crate) fn deserialize<'de, D: Deserializer<'de>>(source: D) -> Result<f64, D::Error> {
    Option::deserialize(source).map(|number| number.unwrap_or(f64::NAN))
}
