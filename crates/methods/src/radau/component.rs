//! The error of one degree of freedom before and after the filter, and what kind of motion it is.

/// The phase h ω over a step above which the step does not resolve an oscillation. A choice.
const FAST: f64 = 4.0;
/// An error that the filter divides by more than this decays within the step for the most part. It
/// divides that of an oscillation by 1.6 at most where hω ≤ 8. A choice.
const DAMPED: f64 = 4.0;
/// A difference that this many roundings of q and p may cause counts as noise. A choice.
const DIFFERENCE_ROUNDINGS: f64 = 16.0;

/// The error of (q, p) of one degree of freedom, in units of the scales.
pub(super) struct Component {
    /// The difference to the embedded method.
    pub(super) raw: [f64; 2],
    /// The solution x of `(1 - h μ J) x = raw`.
    pub(super) filtered: [f64; 2],
    /// ΔD, the change of D by the slopes of x, times h μ.
    pub(super) friction: f64,
}

impl Component {
    /// Δq and Δp: the changes by the slopes of the error, times h μ.
    #[inline(always)]
    fn changes(&self) -> [f64; 2] {
        [self.filtered[0] - self.raw[0], self.raw[1] - self.filtered[1]]
    }

    /// Whether the error (a, b) oscillates with hω > 4. With
    ///
    /// ```text
    /// s² = |Δq Δp|/|a b|   r = |ΔD|/|b|   Δq = h μ (∂v/∂p b + ..)   Δp = h μ (∂²H/∂q² a + ..)
    /// ```
    ///
    /// this is s > 4 μ, and r < 2 s: it is not overdamped.
    #[inline(always)]
    pub(super) fn oscillates(&self, eigenvalue: f64) -> bool {
        let ([a, b], [q, p]) = (self.filtered, self.changes());
        let (of_spring, fast) = ((q * p).abs(), FAST * eigenvalue);
        of_spring > fast * fast * (a * b).abs()
            && self.friction * self.friction * a.abs() < 4.0 * of_spring * b.abs()
    }

    /// Whether most of the error decays within the step.
    #[inline(always)]
    pub(super) fn decays(&self) -> bool {
        let largest = |[a, b]: [f64; 2]| a.abs().max(b.abs());
        DAMPED * largest(self.filtered) < largest(self.raw)
    }

    /// Whether roundings of q and p may cause an error of this size. A rounding of q changes p by
    /// the force of the springs, one of p changes q by v. Both sizes are in units of the scales.
    #[inline(always)]
    pub(super) fn is_noise(&self, error: f64, rounding: f64) -> bool {
        let ([a, b], [q, p]) = (self.filtered, self.changes());
        let noise = DIFFERENCE_ROUNDINGS * rounding;
        error * a.abs() < noise * (p - self.friction).abs() || error * b.abs() < noise * q.abs()
    }
}
