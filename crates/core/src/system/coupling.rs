//! The degrees of freedom that act on each other.

/// The pattern of degrees of freedom that act on each other: i acts on j if ∂H/∂q_j, ∂H/∂p_j or D_j
/// may depend on q_i or p_i.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Coupling {
    /// Neighbours in a row: |i - j| ≤ 1.
    Chain,
    /// Neighbours in a circle, of which the first and the last are neighbours too.
    Ring,
    /// Any pair.
    Dense,
}

impl Coupling {
    /// Whether i and j, of `n` degrees of freedom, may act on each other.
    pub fn joins(&self, n: usize, i: usize, j: usize) -> bool {
        let apart = i.abs_diff(j);
        match self {
            Self::Chain => apart <= 1,
            Self::Ring => apart <= 1 || apart + 1 == n,
            Self::Dense => true,
        }
    }

    /// Whether two colours suffice for `n` degrees of freedom, so that no two of the same colour
    /// act on each other.
    pub fn two_coloured(&self, n: usize) -> bool {
        match self {
            Self::Chain => true,
            Self::Ring => n.is_multiple_of(2),
            Self::Dense => false,
        }
    }

    /// The `n` degrees of freedom ordered by colour. No two of the same colour act on each other:
    /// the order is red-black for a chain and an even ring, with a third colour for the last of an
    /// odd ring. The dense pattern keeps the natural order.
    pub fn coloured(&self, n: usize) -> Vec<usize> {
        let last = match self {
            Self::Dense => return (0..n).collect(),
            Self::Ring if n % 2 == 1 && n > 1 => n - 1,
            Self::Chain | Self::Ring => n,
        };
        (0..last).step_by(2).chain((1..last).step_by(2)).chain(last..n).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_keep_neighbours_apart() {
        assert_eq!(Coupling::Chain.coloured(5), [0, 2, 4, 1, 3]);
        assert_eq!(Coupling::Ring.coloured(6), [0, 2, 4, 1, 3, 5]);
        assert_eq!(Coupling::Ring.coloured(5), [0, 2, 1, 3, 4]);
        assert_eq!(Coupling::Dense.coloured(3), [0, 1, 2]);
        assert_eq!(Coupling::Ring.coloured(1), [0]);
        let two = |n| [Coupling::Chain, Coupling::Ring, Coupling::Dense].map(|x| x.two_coloured(n));
        assert_eq!((two(5), two(6)), ([true, false, false], [true, true, false]));
    }
}
