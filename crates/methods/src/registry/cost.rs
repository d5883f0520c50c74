//! The cost of a step.

/// The cost of a step per degree of freedom. One evaluation is an evaluation of the force, ∂H/∂q
/// and D.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cost {
    /// Explicit, with this number of evaluations and no equation. `leapfrog` takes one more at its
    /// first step, and at each step with one degree of freedom, where reevaluating the force is
    /// cheaper than storing it. It solves a scalar equation if D is not linear in the momentum.
    Explicit(u32),
    /// Explicit, with this number of evaluations. All but the first are repeated if the γ of the
    /// last step does not predict the new one.
    Relaxed(u32),
    /// Explicit, with this number of evaluations, and one of ∇H at the end unless K is exact there
    /// already. A kick solves a scalar equation if D is not linear in the momentum.
    Kicks(u32),
    /// Implicit in one degree of freedom at a time: this number of sweeps, with a scalar equation
    /// for each degree of freedom. A typical equation takes two evaluations; on the damped
    /// oscillator, `moddg` with its δ has closed forms with one.
    Sweeps(u32),
    /// Implicit in all degrees of freedom at once: q' and p' are polynomials with this number of
    /// coefficients, s for order 2s.
    Modes(u32),
    /// Implicit in all degrees of freedom: integrates a linear flow repeatedly until its end
    /// converges; once on linear systems.
    Paths,
    /// Implicit in all degrees of freedom: q and p at four or eight nodes, depending on the
    /// tolerance.
    Nodes,
    /// Implicit in all degrees of freedom: q and p at three, five or seven stages, depending on the
    /// tolerance.
    Stages,
    /// The flow of a constant matrix; no equation is solved.
    Flow,
}

impl Cost {
    /// A description in words.
    pub fn describe(self) -> String {
        let plural =
            |n: u32, what: &str| if n == 1 { format!("1 {what}") } else { format!("{n} {what}s") };
        match self {
            Self::Explicit(evaluations) => plural(evaluations, "evaluation"),
            Self::Relaxed(evaluations) => {
                format!("{}, once or twice", plural(evaluations, "evaluation"))
            }
            Self::Kicks(kicks) => format!("{}, 1 of ∇H", plural(kicks, "evaluation")),
            Self::Sweeps(sweeps) => format!("scalar equations, {}", plural(sweeps, "sweep")),
            Self::Modes(modes) => format!("equations, {}", plural(modes, "mode")),
            Self::Nodes => "equations, 4 or 8 nodes".into(),
            Self::Stages => "equations, 3, 5 or 7 stages".into(),
            Self::Paths => "matrix flow, iterated".into(),
            Self::Flow => "matrix flow".into(),
        }
    }
}
