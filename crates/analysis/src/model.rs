//! A system by name, with its parameters.

use crate::Subject;
use afterbay_core::{InputError, Quad, Scalar};
use afterbay_methods::registry::{self, Row, Run};
use afterbay_systems::{
    DampedDoublePendulum, DampedOscillator, Duffing, FputChain, ModifiedVanDerPol, VanDerPol, VanDerPolRing,
};
use serde::Serialize;

/// A system and its parameters.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(tag = "name", content = "parameters", rename_all = "kebab-case")]
pub enum Model {
    /// `V = k q²/2, D = b p`
    DampedOscillator {
        /// Stiffness.
        k: f64,
        /// Damping.
        b: f64,
    },
    /// `V = α q²/2 + β q⁴/4, D = c p`
    Duffing {
        /// Linear stiffness; negative for a double well.
        alpha: f64,
        /// Cubic stiffness.
        beta: f64,
        /// Damping.
        c: f64,
    },
    /// `V = q²/2, D = -μ (1 - q²) p`
    VanDerPol {
        /// Activity.
        mu: f64,
    },
    /// `V = α q²/2 + β q⁴/4, D = -μ (1 - q²) p`
    ModifiedVanDerPol {
        /// Activity.
        mu: f64,
        /// Linear stiffness.
        alpha: f64,
        /// Cubic stiffness.
        beta: f64,
    },
    /// `V = Σ (r_i²/2 + β r_i⁴/4), D_j = c p_j`, fixed ends
    FputChain {
        /// Masses.
        n: usize,
        /// Cubic stiffness of the springs.
        beta: f64,
        /// Damping.
        c: f64,
    },
    /// `V = Σ [q_j²/2 + κ/2 (q_{j+1} - q_j)²], D_j = -μ (1 - q_j²) p_j`, periodic
    VanDerPolRing {
        /// Oscillators.
        n: usize,
        /// Activity.
        mu: f64,
        /// κ
        coupling: f64,
    },
    /// `H = p·M(q)⁻¹p/2 + V(q), D_j = c_j ∂H/∂p_j`
    DampedDoublePendulum {
        /// The upper mass.
        m1: f64,
        /// The lower mass.
        m2: f64,
        /// The upper rod.
        l1: f64,
        /// The lower rod.
        l2: f64,
        /// Gravity.
        g: f64,
        /// Friction of the upper rod.
        c1: f64,
        /// Friction of the lower rod.
        c2: f64,
    },
}

impl Model {
    /// The name in scenes and tables.
    pub fn name(&self) -> &'static str {
        match self {
            Self::DampedOscillator { .. } => "damped-oscillator",
            Self::Duffing { .. } => "duffing",
            Self::VanDerPol { .. } => "van-der-pol",
            Self::ModifiedVanDerPol { .. } => "modified-van-der-pol",
            Self::FputChain { .. } => "fput-chain",
            Self::VanDerPolRing { .. } => "van-der-pol-ring",
            Self::DampedDoublePendulum { .. } => "damped-double-pendulum",
        }
    }

    /// The number of degrees of freedom.
    pub fn dof(&self) -> usize {
        match *self {
            Self::FputChain { n, .. } | Self::VanDerPolRing { n, .. } => n,
            Self::DampedDoublePendulum { .. } => 2,
            Self::DampedOscillator { .. }
            | Self::Duffing { .. }
            | Self::VanDerPol { .. }
            | Self::ModifiedVanDerPol { .. } => 1,
        }
    }

    /// A method bound to the system in `f64`, by the shortest way there is.
    ///
    /// # Errors
    /// [`InputError::Parameter`], and [`InputError::Unsupported`] where the method does not apply.
    pub fn bind(&self, row: &Row) -> Result<Run<f64>, InputError> {
        match *self {
            Self::FputChain { n, beta, c } => registry::uniform(row, FputChain::new(n, beta, c)?),
            Self::VanDerPolRing { n, mu, coupling } => {
                registry::uniform(row, VanDerPolRing::new(n, mu, coupling)?)
            }
            _ => self.subject::<f64>()?.bind(row),
        }
    }

    /// Increments bound to the system in `f64`, their roundings kept from adding up ([`registry::compensated`]).
    ///
    /// # Errors
    /// [`InputError::Parameter`], and [`InputError::Unsupported`] where the method does not apply.
    pub fn bind_compensated(&self, row: &Row) -> Result<Run<f64>, InputError> {
        macro_rules! bound {
            ($system:expr) => {{
                let system = $system?;
                registry::compensated(row, system, system.map(Quad::from))
            }};
        }
        match *self {
            Self::DampedOscillator { k, b } => bound!(DampedOscillator::new(k, b)),
            Self::Duffing { alpha, beta, c } => bound!(Duffing::new(alpha, beta, c)),
            Self::VanDerPol { mu } => bound!(VanDerPol::new(mu)),
            Self::ModifiedVanDerPol { mu, alpha, beta } => bound!(ModifiedVanDerPol::new(mu, alpha, beta)),
            Self::FputChain { n, beta, c } => bound!(FputChain::new(n, beta, c)),
            Self::VanDerPolRing { n, mu, coupling } => bound!(VanDerPolRing::new(n, mu, coupling)),
            Self::DampedDoublePendulum { .. } => {
                Err(InputError::Unsupported { method: row.name, why: "H is not separable" })
            }
        }
    }

    /// The system itself, in the scalar asked for.
    ///
    /// # Errors
    /// [`InputError::Parameter`] for a parameter out of range.
    pub fn subject<T: Scalar>(&self) -> Result<Box<dyn Subject<T>>, InputError> {
        let t = T::from_f64;
        Ok(match *self {
            Self::DampedOscillator { k, b } => Box::new(DampedOscillator::new(t(k), t(b))?),
            Self::Duffing { alpha, beta, c } => Box::new(Duffing::new(t(alpha), t(beta), t(c))?),
            Self::VanDerPol { mu } => Box::new(VanDerPol::new(t(mu))?),
            Self::ModifiedVanDerPol { mu, alpha, beta } => {
                Box::new(ModifiedVanDerPol::new(t(mu), t(alpha), t(beta))?)
            }
            Self::FputChain { n, beta, c } => Box::new(FputChain::new(n, t(beta), t(c))?),
            Self::VanDerPolRing { n, mu, coupling } => Box::new(VanDerPolRing::new(n, t(mu), t(coupling))?),
            Self::DampedDoublePendulum { m1, m2, l1, l2, g, c1, c2 } => {
                let [m, l, c] = [[m1, m2], [l1, l2], [c1, c2]].map(|pair| pair.map(t));
                Box::new(DampedDoublePendulum::new(m, l, t(g), c)?)
            }
        })
    }
}

/// A system in the list of systems.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct SystemRow {
    /// Its name in scenes and tables.
    pub name: &'static str,
    /// Its equations.
    pub equations: &'static str,
    /// Its parameters and their ranges.
    pub parameters: &'static str,
    /// What is known of its solution.
    pub solution: &'static str,
}

/// Every system there is.
pub const SYSTEMS: &[SystemRow] = &[
    SystemRow {
        name: "damped-oscillator",
        equations: "V = k q²/2, D = b p",
        parameters: "k > 0, b (b < 0 feeds energy in)",
        solution: "exact: q, p and w",
    },
    SystemRow {
        name: "duffing",
        equations: "V = α q²/2 + β q⁴/4, D = c p",
        parameters: "alpha, beta, c (alpha < 0 < beta: double well)",
        solution: "Taylor series, to rounding",
    },
    SystemRow {
        name: "van-der-pol",
        equations: "V = q²/2, D = -μ (1 - q²) p",
        parameters: "mu (mu > 0: limit cycle)",
        solution: "Taylor series, to rounding",
    },
    SystemRow {
        name: "modified-van-der-pol",
        equations: "V = α q²/2 + β q⁴/4, D = -μ (1 - q²) p",
        parameters: "mu, alpha, beta",
        solution: "Taylor series, to rounding",
    },
    SystemRow {
        name: "fput-chain",
        equations: "V = Σ (r_i²/2 + β r_i⁴/4), r_i = q_{i+1} - q_i, fixed ends, D_j = c p_j",
        parameters: "n ≥ 1, beta, c",
        solution: BY_SIZE,
    },
    SystemRow {
        name: "van-der-pol-ring",
        equations: "V = Σ [q_j²/2 + κ/2 (q_{j+1} - q_j)²], periodic, D_j = -μ (1 - q_j²) p_j",
        parameters: "n ≥ 1, mu, coupling (κ)",
        solution: BY_SIZE,
    },
    SystemRow {
        name: "damped-double-pendulum",
        equations: "H = p·M(q)⁻¹p/2 + V(q), not separable, D_j = c_j ∂H/∂p_j",
        parameters: "m1, m2, l1, l2 > 0, g, c1, c2",
        solution: "Taylor series, to rounding",
    },
];

/// What is known of a solution with any number of degrees of freedom.
const BY_SIZE: &str = "Taylor series, to rounding; beyond 16 degrees of freedom increment-8, its step halved until two runs agree";
