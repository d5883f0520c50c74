//! The names of the quantities of a system in messages.

/// The meaning of a number in a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// q
    Coordinate,
    /// p
    Momentum,
    /// w
    Reservoir,
    /// -∂H/∂q or D
    Force,
    /// H
    Energy,
    /// ∂H/∂q
    Slope,
    /// ∂H/∂p
    Velocity,
    /// ∂V/∂q
    Partial,
    /// The mean of ∂V/∂q along an edge.
    Increment,
    /// m
    Mass,
    /// D
    Dissipation,
    /// ∂D_j/∂p_j
    DissipationSlope,
    /// w_j' = D_j ∂H/∂p_j, the power dissipated by one degree of freedom.
    ReservoirRate,
    /// Σ w_j', the power dissipated in all.
    TotalReservoirRate,
    /// F
    Drive,
}

impl Quantity {
    /// The name, followed by the degree of freedom, counted from 1, for a quantity that belongs to
    /// one.
    pub(crate) fn of(self, dof: usize) -> String {
        match self {
            Self::Energy | Self::TotalReservoirRate => self.to_string(),
            _ => format!("{self}{}", dof + 1),
        }
    }
}

impl std::fmt::Display for Quantity {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Coordinate => "q",
            Self::Momentum => "p",
            Self::Reservoir => "w",
            Self::Force => "force",
            Self::Energy => "H",
            Self::Slope => "∂H/∂q",
            Self::Velocity => "∂H/∂p",
            Self::Partial => "∂V/∂q",
            Self::Increment => "the mean of ∂V/∂q",
            Self::Mass => "m",
            Self::Dissipation => "D",
            Self::DissipationSlope => "∂D/∂p of ",
            Self::ReservoirRate => "w'",
            Self::TotalReservoirRate => "Σ w'",
            Self::Drive => "F",
        })
    }
}

/// A matrix of derivatives by degree of freedom i (row) and j (column).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Block {
    /// ∂²H/∂q_i∂q_j
    Hqq,
    /// ∂²H/∂q_i∂p_j
    Hqp,
    /// ∂²H/∂p_i∂p_j
    Hpp,
    /// ∂D_i/∂q_j
    Dq,
    /// ∂D_i/∂p_j
    Dp,
}

impl Block {
    /// The name of an entry. Row and column are counted from 0 here and from 1 in the name.
    pub(crate) fn of(self, row: usize, column: usize) -> String {
        let (i, j) = (row.saturating_add(1), column.saturating_add(1));
        match self {
            Self::Hqq => format!("∂²H/∂q{i}∂q{j}"),
            Self::Hqp => format!("∂²H/∂q{i}∂p{j}"),
            Self::Hpp => format!("∂²H/∂p{i}∂p{j}"),
            Self::Dq => format!("∂D{i}/∂q{j}"),
            Self::Dp => format!("∂D{i}/∂p{j}"),
        }
    }
}
