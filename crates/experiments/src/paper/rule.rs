//! The rule by which all figures of the paper are judged.

use super::{BASE_STEP, FIGURE_STEP};
use crate::claim::fixed;
use crate::findings::KEPT;

/// The largest difference of two orders that agree.
pub(super) const AGREEMENT: f64 = 0.05;
/// The largest ratio of two sizes of one magnitude.
pub(super) const MAGNITUDE: f64 = 10.0;

/// Whether two orders agree.
pub(super) fn agree(order: f64, printed: f64) -> bool {
    (order - printed).abs() <= AGREEMENT
}

/// Whether two sizes are of one magnitude.
pub(super) fn alike(a: f64, b: f64) -> bool {
    (b..=MAGNITUDE * b).contains(&a) || (a..=MAGNITUDE * a).contains(&b)
}

/// An order for a sentence.
pub(super) fn order(order: f64) -> String {
    fixed(order, 3)
}

/// The rule for the report, one paragraph per entry.
pub(super) fn paragraphs() -> [String; 5] {
    [
        format!(
            "The rule by which every figure of the paper is judged. Variant: the paper requires \
             that δ leave K conserved. A figure is therefore judged by the scheme with the same δ, \
             with correct coefficients, in all three equations. K counts as kept if max |K - K₀| \
             is at most {KEPT:.0e} of the energy at the start, as measured and not as claimed.",
        ),
        "Statistic: a figure holds if it agrees both with the maximum over the grid, which the \
         paper uses, and with the median, which the grid points near the poles of δ hardly affect."
            .into(),
        format!(
            "Window: [0, 20] from q₀ = 2.3, p₀ = -3.1, since the paper gives none, with its base \
             grid of {BASE_STEP} and its six steps. Figures over time use h = {FIGURE_STEP}, the \
             smallest of them.",
        ),
        format!(
            "Agreement: orders agree within {AGREEMENT}, and sizes \"of one magnitude\" within a \
             factor of {MAGNITUDE}. Errors are T as defined in section 2 of the paper.",
        ),
        format!(
            "Each order is accompanied by the variant that fits the printed number best: of all \
             variants with this δ, with correct or printed coefficients, with K kept or not, the \
             one whose maximum is nearest. Figures 4.2 and 4.3 are also shown at the base step h = \
             {BASE_STEP}.",
        ),
    ]
}
