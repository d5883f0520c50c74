//! What a step costs.

/// What a step costs for each degree of freedom. An evaluation is one of the force, ∂H/∂q and D.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cost {
    /// Explicit: so many evaluations and no equation. `leapfrog` takes one more at its first step,
    /// and at each with one degree of freedom, where that costs less than keeping the last; it
    /// solves a scalar equation where D is not linear in the momentum.
    Explicit(u32),
    /// Explicit: so many evaluations, and all but the first again where the last step's γ does not
    /// foretell its own.
    Relaxed(u32),
    /// Implicit, one degree of freedom at a time: so many sweeps over them, a scalar equation in
    /// each. An ordinary one takes two evaluations; `moddg` with its δ has closed forms of one on
    /// the damped oscillator.
    Sweeps(u32),
    /// Implicit in all degrees of freedom at once: q' and p' are polynomials of so many modes, s
    /// for order 2s.
    Modes(u32),
    /// Implicit in all of them: the flow of a matrix is followed until its end stays, once on
    /// linear systems.
    Paths,
    /// Implicit in all of them: q and p at four or eight nodes, as the error asks for.
    Nodes,
    /// The flow of a matrix, and no equation.
    Flow,
}

impl Cost {
    /// In words.
    pub fn describe(self) -> String {
        let plural =
            |n: u32, what: &str| if n == 1 { format!("1 {what}") } else { format!("{n} {what}s") };
        match self {
            Self::Explicit(evaluations) => plural(evaluations, "evaluation"),
            Self::Relaxed(evaluations) => {
                format!("{}, once or twice", plural(evaluations, "evaluation"))
            }
            Self::Sweeps(sweeps) => format!("scalar equations, {}", plural(sweeps, "sweep")),
            Self::Modes(modes) => format!("equations, {}", plural(modes, "mode")),
            Self::Nodes => "equations, 4 or 8 nodes".into(),
            Self::Paths => "matrix flow, iterated".into(),
            Self::Flow => "matrix flow".into(),
        }
    }
}
