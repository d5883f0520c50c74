//! A system by name, with its parameters.

use crate::Subject;
use afterbay_core::{Corrected, InputError, Lanewise, Scalar, System, f64x8};
use afterbay_methods::registry::{self, AdaptiveRow, Row, Run, Within};
use afterbay_systems::{
    Custom, CustomError, DampedDoublePendulum, DampedOscillator, Duffing, FputChain, ModifiedVanDerPol,
    VanDerPol, VanDerPolRing,
};
use serde::{Serialize, Serializer};
use thiserror::Error;

/// A system and its parameters.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "name", content = "parameters", rename_all = "kebab-case")]
pub enum Model {
    /// `V = k q²/2, D = b p`
    DampedOscillator {
        /// Stiffness.
        k: f64,
        /// DissipationForm.
        b: f64,
    },
    /// `V = α q²/2 + β q⁴/4, D = c p`
    Duffing {
        /// Linear stiffness; negative for a double well.
        alpha: f64,
        /// Cubic stiffness.
        beta: f64,
        /// DissipationForm.
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
        /// DissipationForm.
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
    /// Whatever its expressions say.
    Custom(#[serde(serialize_with = "parameters_alone")] Custom<f64>),
}

/// Of a custom system the record names the parameters; its expressions stand in the scene.
fn parameters_alone<S: Serializer>(custom: &Custom<f64>, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(custom.parameters())
}

/// Where a parameter is kept.
enum Parameter<'a> {
    Real(&'a mut f64),
    Count(&'a mut usize),
}

/// A system that cannot be made.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ModelError {
    /// A parameter the system does not have.
    #[error("there is no parameter {name}")]
    NoParameter {
        /// The name asked for.
        name: String,
    },
    /// A number of degrees of freedom that is not whole.
    #[error("parameter {name} = {value:?} must be a whole number")]
    Whole {
        /// Its name.
        name: String,
        /// The value given.
        value: f64,
    },
    /// A custom system that is none with this value.
    #[error(transparent)]
    Custom(#[from] CustomError),
}

/// Eight runs of one method side by side.
pub struct Lanes {
    /// The method, bound to the systems.
    pub run: Run<f64x8>,
    /// The systems.
    pub system: Box<dyn System<f64x8>>,
}

/// Eight systems, and a method bound to them, where it goes there.
fn beside<S: System<f64x8> + Clone + 'static>(
    row: &Row,
    system: S,
    bind: impl FnOnce(&Row, S) -> Result<Option<Run<f64x8>>, InputError>,
) -> Result<Option<Lanes>, InputError> {
    let run = bind(row, system.clone())?;
    Ok(run.map(|run| Lanes { run, system: Box::new(system) }))
}

/// Does the same with whatever system it is, made of parameters that `$lift` has taken by name and value into a scalar.
macro_rules! with_system {
    ($model:expr, $lift:expr, separable $system:ident => $one:expr, general $other:ident => $two:expr) => {{
        let lift = $lift;
        match $model {
            Model::DampedOscillator { k, b } => {
                let $system = DampedOscillator::new(lift("k", *k), lift("b", *b))?;
                $one
            }
            Model::Duffing { alpha, beta, c } => {
                let $system = Duffing::new(lift("alpha", *alpha), lift("beta", *beta), lift("c", *c))?;
                $one
            }
            Model::VanDerPol { mu } => {
                let $system = VanDerPol::new(lift("mu", *mu))?;
                $one
            }
            Model::ModifiedVanDerPol { mu, alpha, beta } => {
                let $system =
                    ModifiedVanDerPol::new(lift("mu", *mu), lift("alpha", *alpha), lift("beta", *beta))?;
                $one
            }
            Model::FputChain { n, beta, c } => {
                let $system = FputChain::new(*n, lift("beta", *beta), lift("c", *c))?;
                $one
            }
            Model::VanDerPolRing { n, mu, coupling } => {
                let $system = VanDerPolRing::new(*n, lift("mu", *mu), lift("coupling", *coupling))?;
                $one
            }
            Model::Custom(custom) => {
                let $system = custom.lift(lift);
                $one
            }
            Model::DampedDoublePendulum { m1, m2, l1, l2, g, c1, c2 } => {
                let masses = [lift("m1", *m1), lift("m2", *m2)];
                let lengths = [lift("l1", *l1), lift("l2", *l2)];
                let frictions = [lift("c1", *c1), lift("c2", *c2)];
                let $other = DampedDoublePendulum::new(masses, lengths, lift("g", *g), frictions)?;
                $two
            }
        }
    }};
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
            Self::Custom(_) => "custom",
        }
    }

    /// The number of degrees of freedom.
    pub fn dof(&self) -> usize {
        match self {
            Self::FputChain { n, .. } | Self::VanDerPolRing { n, .. } => *n,
            Self::Custom(custom) => System::<f64>::dof(custom),
            Self::DampedDoublePendulum { .. } => 2,
            Self::DampedOscillator { .. }
            | Self::Duffing { .. }
            | Self::VanDerPol { .. }
            | Self::ModifiedVanDerPol { .. } => 1,
        }
    }

    /// The period of each coordinate of which V and D know no more than where it is on a circle;
    /// none of the others, see [`Custom::periods`].
    pub fn periods(&self) -> Vec<Option<f64>> {
        match self {
            Self::Custom(custom) => custom.periods(),
            Self::DampedDoublePendulum { .. } => vec![Some(std::f64::consts::TAU); 2],
            _ => vec![None; self.dof()],
        }
    }

    /// The names of the parameters.
    pub fn parameters(&self) -> Vec<&str> {
        match self {
            Self::Custom(custom) => custom.parameters().map(|(name, _)| name).collect(),
            _ => {
                let row = SYSTEMS.iter().find(|row| row.name == self.name());
                row.map_or(Vec::new(), |row| row.parameters.to_vec())
            }
        }
    }

    /// The same model with another value of a parameter.
    ///
    /// # Errors
    /// [`ModelError::NoParameter`], [`ModelError::Whole`] for n, and what the value makes of a custom system.
    pub fn with(&self, name: &str, value: f64) -> Result<Self, ModelError> {
        if let Self::Custom(custom) = self {
            return Ok(Self::Custom(custom.with(name, value)?));
        }
        let mut changed = self.clone();
        let unknown = || ModelError::NoParameter { name: name.into() };
        match changed.parameter(name).ok_or_else(unknown)? {
            Parameter::Real(x) => *x = value,
            Parameter::Count(n) if value.fract() == 0.0 && (0.0..=1e9).contains(&value) => {
                *n = value as usize;
            }
            Parameter::Count(_) => return Err(ModelError::Whole { name: name.into(), value }),
        }
        Ok(changed)
    }

    fn parameter(&mut self, name: &str) -> Option<Parameter<'_>> {
        use Parameter::{Count, Real};
        let parameters: Vec<(&str, Parameter<'_>)> = match self {
            Self::DampedOscillator { k, b } => vec![("k", Real(k)), ("b", Real(b))],
            Self::Duffing { alpha, beta, c } => {
                vec![("alpha", Real(alpha)), ("beta", Real(beta)), ("c", Real(c))]
            }
            Self::VanDerPol { mu } => vec![("mu", Real(mu))],
            Self::ModifiedVanDerPol { mu, alpha, beta } => {
                vec![("mu", Real(mu)), ("alpha", Real(alpha)), ("beta", Real(beta))]
            }
            Self::FputChain { n, beta, c } => vec![("n", Count(n)), ("beta", Real(beta)), ("c", Real(c))],
            Self::VanDerPolRing { n, mu, coupling } => {
                vec![("n", Count(n)), ("mu", Real(mu)), ("coupling", Real(coupling))]
            }
            Self::DampedDoublePendulum { m1, m2, l1, l2, g, c1, c2 } => {
                let names = ["m1", "m2", "l1", "l2", "g", "c1", "c2"];
                names.into_iter().zip([m1, m2, l1, l2, g, c1, c2].map(Real)).collect()
            }
            Self::Custom(_) => Vec::new(),
        };
        parameters.into_iter().find(|(known, _)| *known == name).map(|(_, parameter)| parameter)
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

    /// Increments bound to the system in `f64` or lanes of it, their roundings kept from adding up
    /// ([`registry::compensated`]).
    ///
    /// # Errors
    /// [`InputError::Parameter`], and [`InputError::Unsupported`] where the method does not apply.
    pub fn bind_compensated<T: Lanewise>(&self, row: &Row) -> Result<Run<T>, InputError> {
        with_system!(
            self,
            |_: &str, x| T::from_f64(x),
            separable system => {
                let exact = system.map(Corrected::exact);
                registry::compensated(row, system, exact)
            },
            general _system => Err(InputError::Unsupported { method: row.name, why: "H is not separable" })
        )
    }

    /// A method that chooses its steps, bound to the system.
    ///
    /// # Errors
    /// [`InputError::Parameter`]
    pub fn bind_adaptive(&self, row: &AdaptiveRow) -> Result<Within, InputError> {
        with_system!(
            self,
            |_: &str, x| x,
            separable system => registry::adaptive(row, system),
            general system => registry::adaptive(row, system)
        )
    }

    /// Eight runs side by side, the parameter `name` of each its own; none where the system or the method has no such form.
    ///
    /// # Errors
    /// [`InputError::Parameter`], and [`InputError::Unsupported`] where the method does not apply.
    pub fn bind_lanes(&self, row: &Row, name: &str, values: [f64; 8]) -> Result<Option<Lanes>, InputError> {
        let lift = |parameter: &str, x| if parameter == name { f64x8::from(values) } else { f64x8::splat(x) };
        match *self {
            Self::DampedOscillator { k, b } => {
                let system = DampedOscillator::new(lift("k", k), lift("b", b))?;
                beside(row, system, registry::linear_lanes)
            }
            Self::FputChain { n, beta, c } => {
                let system = FputChain::new(n, lift("beta", beta), lift("c", c))?;
                beside(row, system, registry::uniform_lanes)
            }
            Self::VanDerPolRing { n, mu, coupling } => {
                let system = VanDerPolRing::new(n, lift("mu", mu), lift("coupling", coupling))?;
                beside(row, system, registry::uniform_lanes)
            }
            _ => with_system!(
                self,
                lift,
                separable system => beside(row, system, registry::lanes),
                general _system => Ok(None)
            ),
        }
    }

    /// The system itself, in the scalar asked for.
    ///
    /// # Errors
    /// [`InputError::Parameter`] for a parameter out of range.
    pub fn subject<T: Scalar>(&self) -> Result<Box<dyn Subject<T>>, InputError> {
        with_system!(
            self,
            |_: &str, x| T::from_f64(x),
            separable system => Ok(Box::new(system)),
            general system => Ok(Box::new(system))
        )
    }
}

/// A system in the list of systems.
#[derive(Clone, Debug, Serialize)]
pub struct SystemRow {
    /// Its name in scenes and tables.
    pub name: &'static str,
    /// Its equations.
    pub equations: &'static str,
    /// The names of its parameters.
    pub parameters: &'static [&'static str],
    /// What they may be.
    pub ranges: &'static str,
    /// What is known of its solution.
    pub solution: &'static str,
    /// The system, all of its parameters 0.
    #[serde(skip)]
    empty: Model,
}

impl SystemRow {
    /// The system with these parameters.
    ///
    /// # Errors
    /// [`ModelError`]. That values are in their ranges is seen by [`Model::subject`].
    pub fn model<'a>(&self, values: impl IntoIterator<Item = (&'a str, f64)>) -> Result<Model, ModelError> {
        values.into_iter().try_fold(self.empty.clone(), |model, (name, value)| model.with(name, value))
    }
}

/// Every system there is.
pub static SYSTEMS: [SystemRow; 7] = [
    SystemRow {
        name: "damped-oscillator",
        equations: "V = k q²/2, D = b p",
        parameters: &["k", "b"],
        ranges: "k > 0 (b < 0 feeds energy in)",
        solution: "exact: q, p and w",
        empty: Model::DampedOscillator { k: 0.0, b: 0.0 },
    },
    SystemRow {
        name: "duffing",
        equations: "V = α q²/2 + β q⁴/4, D = c p",
        parameters: &["alpha", "beta", "c"],
        ranges: "any (alpha < 0 < beta: double well)",
        solution: BY_SERIES,
        empty: Model::Duffing { alpha: 0.0, beta: 0.0, c: 0.0 },
    },
    SystemRow {
        name: "van-der-pol",
        equations: "V = q²/2, D = -μ (1 - q²) p",
        parameters: &["mu"],
        ranges: "any (mu > 0: limit cycle)",
        solution: BY_SERIES,
        empty: Model::VanDerPol { mu: 0.0 },
    },
    SystemRow {
        name: "modified-van-der-pol",
        equations: "V = α q²/2 + β q⁴/4, D = -μ (1 - q²) p",
        parameters: &["mu", "alpha", "beta"],
        ranges: "any",
        solution: BY_SERIES,
        empty: Model::ModifiedVanDerPol { mu: 0.0, alpha: 0.0, beta: 0.0 },
    },
    SystemRow {
        name: "fput-chain",
        equations: "V = Σ (r_i²/2 + β r_i⁴/4), r_i = q_{i+1} - q_i, fixed ends, D_j = c p_j",
        parameters: &["n", "beta", "c"],
        ranges: "n ≥ 1",
        solution: BY_SIZE,
        empty: Model::FputChain { n: 0, beta: 0.0, c: 0.0 },
    },
    SystemRow {
        name: "van-der-pol-ring",
        equations: "V = Σ [q_j²/2 + κ/2 (q_{j+1} - q_j)²], periodic, D_j = -μ (1 - q_j²) p_j",
        parameters: &["n", "mu", "coupling"],
        ranges: "n ≥ 1 (coupling: κ)",
        solution: BY_SIZE,
        empty: Model::VanDerPolRing { n: 0, mu: 0.0, coupling: 0.0 },
    },
    SystemRow {
        name: "damped-double-pendulum",
        equations: "H = p·M(q)⁻¹p/2 + V(q), not separable, D_j = c_j ∂H/∂p_j",
        parameters: &["m1", "m2", "l1", "l2", "g", "c1", "c2"],
        ranges: "m1, m2, l1, l2 > 0",
        solution: BY_SERIES,
        empty: Model::DampedDoublePendulum { m1: 0.0, m2: 0.0, l1: 0.0, l2: 0.0, g: 0.0, c1: 0.0, c2: 0.0 },
    },
];

/// What is known of a solution with few degrees of freedom.
const BY_SERIES: &str = "Taylor series with a doubt, in 106 bits";
/// What is known of a solution with any number of degrees of freedom.
const BY_SIZE: &str = "Taylor series with a doubt, in 106 bits; in 53 beyond 16 degrees of freedom";
