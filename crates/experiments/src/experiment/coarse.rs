//! The warning that an error is coarse: it is an absolute one where q or p stays small.

use crate::claim::{Readings, sci};

/// The largest size of q or p that is judged. From 1 on, a tolerance is a relative error.
const SMALL: f64 = 0.1;
/// The share of the size of q or p from which on an error is coarse.
const COARSE: f64 = 0.01;

/// Adds the error, and the largest |q_j| and |p_j| of a motion for which it is coarse.
pub(super) fn read(error: f64, [q, p]: [f64; 2], readings: &mut Readings) {
    for (name, size) in [("q", q), ("p", p)] {
        if size > 0.0 && size < SMALL && error > COARSE * size {
            readings.add(name, "size", size);
            readings.add("the error", "coarse", error);
        }
    }
}

/// The warning, with the name of the error and what it is: "tolerance", "an absolute error below
/// 1". `None` where the error is not coarse.
pub(super) fn say([name, what]: [&str; 2], r: &Readings) -> Option<String> {
    let sizes = r.numbers("size").into_iter();
    let sizes: Vec<String> =
        sizes.map(|(name, size)| format!("|{name}| is {} at most", sci(size))).collect();
    (!sizes.is_empty()).then(|| {
        format!(
            "The {name} {} is {what}, but {}. Choose units in which q and p are near 1, or a \
             smaller {name}.",
            sci(r.number("the error", "coarse")),
            sizes.join(" and ")
        )
    })
}
