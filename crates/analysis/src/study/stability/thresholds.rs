//! The thresholds of the verdicts: how far a run of a stability map may be from the exact solution.

/// The size of the motion A, in units of its largest in the exact solution, is right if
/// |ln(A/A_exact)| ≤ TOLERANCE (1 + |ln A_exact|). This allows 10 % of the decay in logarithm, and
/// 10 % of the size where there is no decay. Sizes below 1e-300, or below the roundings of the
/// reference, count as equal to that.
pub const TOLERANCE: f64 = 0.1;

/// Each component is right within this share of its own size: half the range of q_j or p_j along
/// the exact solution, or the largest |w_j|, but at least a hundredth of the largest such size
/// among the degrees of freedom. A periodic coordinate (see
/// [`Model::periods`](crate::Model::periods)) is judged as a point in the plane. The place of the
/// motion is right if its mean is within this share of the largest |q| of the exact solution.
pub const SHARE: f64 = 0.1;

/// A motion grows if A exceeds this number, which is about this many times the largest energy of
/// the exact solution, and H has risen by at least half of T. One that falls from an unstable
/// equilibrium, where the exact solution rests, does not grow.
pub const GROWTH: f64 = 1e3;

/// On a stability map, K counts as kept if it moves by at most this share of |H| + Σ |w_j| + T. The
/// roundings of 1e7 steps stay below this share, the error of an unresolved edge does not.
pub const KEPT_ON_MAPS: f64 = 1e-8;
