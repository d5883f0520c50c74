//! Passive linear systems, and the growth of states in a step, measured in the energy norm.

use crate::bind::{Curved, separable};
use crate::catalog::{self, As, chain};
use afterbay_core::{
    Block, Coupling, Curvature, Dissipation, DissipationForm, InputError, IntegrateError, Line,
    Passive, Separable, State, System,
};
use afterbay_methods::registry::{Row, Run};
use nalgebra::{DMatrix, DVector};

/// H = Σ p_j²/(2 m_j) + Σ k_j (q_{j+1} - q_j)²/2 with walls at both ends, D_j = c_j v_j.
#[derive(Clone)]
struct Network {
    mass: Vec<f64>,
    /// One spring more than masses.
    spring: Vec<f64>,
    friction: Vec<f64>,
}

/// A chain of 5 masses. Unless it is `stiff`, all parameters are of order 1.
fn network(stiff: bool) -> Network {
    let x = |j: usize, a: f64| (a * (j + 1) as f64).sin().abs();
    let size = |x: f64, decades: f64| if stiff { 10f64.powf(decades * x) } else { 0.5 + x };
    Network {
        mass: (0..5).map(|j| size(x(j, 1.7), 1.0)).collect(),
        spring: (0..6).map(|j| size(x(j, 2.3), 4.0)).collect(),
        friction: (0..5)
            .map(|j| if stiff && j == 2 { 0.0 } else { size(x(j, 3.1), 3.0) })
            .collect(),
    }
}

impl Network {
    fn at(&self, q: &[f64], j: usize, at: f64) -> f64 {
        let left = if j == 0 { 0.0 } else { q[j - 1] };
        let right = q.get(j + 1).copied().unwrap_or(0.0);
        self.spring[j] * (at - left) - self.spring[j + 1] * (right - at)
    }
}

impl System<f64> for Network {
    fn dof(&self) -> usize {
        self.mass.len()
    }
    fn energy(&self, q: &[f64], p: &[f64]) -> f64 {
        let end = |j: usize| if j == 0 || j > q.len() { 0.0 } else { q[j - 1] };
        let springs = (0..=q.len()).map(|j| self.spring[j] * (end(j + 1) - end(j)).powi(2));
        (springs.sum::<f64>() + p.iter().zip(&self.mass).map(|(p, m)| p * p / m).sum::<f64>()) / 2.0
    }
    fn gradient(&self, q: &[f64], p: &[f64], hq: &mut [f64], hp: &mut [f64]) {
        for j in 0..q.len() {
            (hq[j], hp[j]) = (self.at(q, j, q[j]), p[j] / self.mass[j]);
        }
    }
    fn dissipation(&self, _q: &[f64], _p: &[f64], v: &[f64], d: &mut [f64]) {
        d.iter_mut().zip(&self.friction).zip(v).for_each(|((d, c), v)| *d = c * v);
    }
    fn dissipation_form(&self) -> DissipationForm {
        DissipationForm { passive: Passive::Each, ..DissipationForm::LINEAR }
    }
    fn coupling(&self) -> Coupling {
        Coupling::Chain
    }
}

impl Separable<f64> for Network {
    fn mass(&self, j: usize) -> f64 {
        self.mass[j]
    }
    fn partial(&self, q: &[f64], j: usize, at: f64) -> f64 {
        self.at(q, j, at)
    }
    fn divided_difference(&self, q: &[f64], j: usize, to: f64) -> Line<f64> {
        let slope = (self.spring[j] + self.spring[j + 1]) / 2.0;
        Line { value: self.at(q, j, (q[j] + to) / 2.0), slope }
    }
    fn dissipation_of(&self, _q: &[f64], p: &[f64], j: usize) -> Dissipation<f64> {
        let by_p = self.friction[j] / self.mass[j];
        Dissipation { value: by_p * p[j], by_q: 0.0, by_p }
    }
}

impl Curvature<f64> for Network {
    fn curvature(&self, q: &[f64], _p: &[f64], mut put: impl FnMut(Block, usize, usize, f64)) {
        for j in 0..q.len() {
            put(Block::Hqq, j, j, self.spring[j] + self.spring[j + 1]);
            if j > 0 {
                put(Block::Hqq, j, j - 1, -self.spring[j]);
                put(Block::Hqq, j - 1, j, -self.spring[j]);
            }
            put(Block::Hpp, j, j, 1.0 / self.mass[j]);
            put(Block::Dp, j, j, self.friction[j] / self.mass[j]);
        }
    }
    fn is_linear(&self) -> bool {
        true
    }
}

type Bind = Box<dyn Fn(&Row) -> Result<Run<f64>, InputError>>;

/// A system, its bindings to methods, and coordinates in which H is half the squared norm.
pub(crate) struct Scene {
    pub(crate) name: String,
    /// The largest row sum of the absolute matrix of the flow.
    pub(crate) rate: f64,
    binds: Vec<Bind>,
    /// Lᵀ with L Lᵀ = H''.
    root: DMatrix<f64>,
}

impl Scene {
    fn new(name: impl Into<String>, system: &Curved<f64>, binds: Vec<Bind>) -> Self {
        let n = system.dof();
        let (mut hessian, mut friction) =
            (DMatrix::<f64>::zeros(2 * n, 2 * n), DMatrix::<f64>::zeros(n, n));
        let origin = vec![0.0; n];
        system.curvature(&origin, &origin, |block, i, j, x| match block {
            Block::Hqq => hessian[(i, j)] += x,
            Block::Hpp => hessian[(n + i, n + j)] += x,
            Block::Hqp => panic!("it is separable"),
            Block::Dq => panic!("friction is of the velocity"),
            Block::Dp => friction[(i, j)] += x,
        });
        let row = |i: usize| {
            if i < n {
                hessian.row(n + i).abs().sum()
            } else {
                hessian.row(i - n).abs().sum() + friction.row(i - n).abs().sum()
            }
        };
        let rate = (0..2 * n).map(row).fold(0.0, f64::max);
        let root = hessian.cholesky().expect("H is positive definite").l().transpose();
        Self { name: name.into(), rate, binds, root }
    }

    /// Binds the method in every possible way.
    pub(crate) fn bind(&self, row: &Row) -> Vec<Run<f64>> {
        let runs = self.binds.iter().map(|bind| bind(row));
        runs.filter_map(|run| match run {
            Ok(run) => Some(run),
            Err(InputError::Unsupported { .. }) => None,
            Err(error) => panic!("{}: {error}", row.name),
        })
        .collect()
    }

    /// Takes one step of the state with these coordinates.
    fn step(
        &self,
        run: &Run<f64>,
        h: f64,
        x: &DVector<f64>,
    ) -> Result<DVector<f64>, IntegrateError> {
        let z = self.root.solve_upper_triangular(x).expect("H is positive definite");
        let n = z.len() / 2;
        let mut state = State::new(z.as_slice()[..n].to_vec(), z.as_slice()[n..].to_vec()).unwrap();
        run.step(h, &mut state)?;
        Ok(&self.root * DVector::from_iterator(2 * n, state.q.into_iter().chain(state.p)))
    }

    /// Orthonormal states, none of them along an axis, where δ has its poles.
    fn basis(&self) -> DMatrix<f64> {
        let size = self.root.nrows();
        let v = DVector::from_fn(size, |i, _| 1.0 + (i as f64).sqrt());
        DMatrix::identity(size, size) - &v * v.transpose() * (2.0 / v.norm_squared())
    }

    /// The images of the basis under a step.
    fn images(&self, run: &Run<f64>, h: f64) -> Result<DMatrix<f64>, IntegrateError> {
        let basis = self.basis();
        let images = basis.column_iter().map(|x| self.step(run, h, &x.into_owned()));
        Ok(DMatrix::from_columns(&images.collect::<Result<Vec<_>, _>>()?))
    }

    /// The growth factor of states per step: the spectral radius of a linear step; otherwise the
    /// mean along orbits, with each state rescaled to the energy 1/2, since nonlinear steps are
    /// homogeneous.
    pub(crate) fn factor(&self, run: &Run<f64>, h: f64) -> Result<f64, IntegrateError> {
        let (basis, images) = (self.basis(), self.images(run, h)?);
        let size = basis.nrows();
        let mix = DVector::from_fn(size, |i, _| (1.3 * i as f64 + 0.4).cos());
        let linear = (self.step(run, h, &(&basis * &mix))? - &images * &mix).norm()
            <= 1e-9 * (1.0 + images.norm());
        if linear {
            // The basis is symmetric and its own inverse.
            return Ok(spectral_radius(&images * &basis));
        }
        let mut most = 0.0_f64;
        for start in basis.column_iter() {
            let (mut x, mut sum) = (start.into_owned(), 0.0);
            for _ in 0..ORBIT {
                let next = self.step(run, h, &x)?;
                sum += next.norm().ln();
                x = next.normalize();
            }
            most = most.max((sum / f64::from(ORBIT)).exp());
        }
        Ok(most)
    }

    /// The largest fraction of the energy left after a step of `reach` times the slowest time
    /// scale.
    pub(crate) fn longest(&self, run: &Run<f64>, reach: f64) -> Result<f64, IntegrateError> {
        let images = self.images(run, reach / self.rate)?;
        Ok(images.column_iter().map(|x| x.norm_squared()).fold(0.0, f64::max))
    }
}

/// The largest modulus of an eigenvalue: the limit of |Aᴺ|^(1/N), by repeated squaring to N = 2⁵⁰.
fn spectral_radius(mut power: DMatrix<f64>) -> f64 {
    let mut logarithm = 0.0;
    for squarings in 0..50 {
        let size = power.norm();
        if size == 0.0 {
            return 0.0;
        }
        logarithm += size.ln() * 0.5_f64.powi(squarings);
        power /= size;
        power = &power * &power;
    }
    logarithm.exp()
}

/// The number of steps of an orbit.
const ORBIT: u32 = 100;

fn oscillator(k: f64, b: f64) -> Scene {
    let system = catalog::oscillator(k, b);
    let binds = [As::Linear, As::Nonlinear].map(|form| -> Bind {
        let system = system.clone();
        Box::new(move |row| system.bind(row, form))
    });
    Scene::new(format!("oscillator k = {k}, b = {b}"), &*system.curved(), Vec::from(binds))
}

fn masses(stiff: bool) -> Scene {
    let system = network(stiff);
    let bound = system.clone();
    let name = if stiff { "stiff chain" } else { "chain" };
    Scene::new(name, &system, vec![Box::new(move |row| separable(row, bound.clone()))])
}

/// Undamped, under- and overdamped, stiff, coupled.
pub(crate) fn scenes() -> Vec<Scene> {
    let equal = chain(8, 0.0, 0.3);
    let curved = equal.curved();
    let bind: Bind = Box::new(move |row| equal.bind(row, As::Uniform));
    let equal = Scene::new("8 equal masses", &*curved, vec![bind]);
    let oscillators = [(1.0, 0.0), (1.0, 0.1), (1.0, 200.0), (1e4, 1.0), (1e4, 300.0), (0.01, 3.0)];
    oscillators
        .map(|(k, b)| oscillator(k, b))
        .into_iter()
        .chain([masses(true), masses(false), equal])
        .collect()
}

/// Damped, with all time scales of order 1.
pub(crate) fn gentle() -> [Scene; 3] {
    [oscillator(1.0, 2.5), oscillator(1.0, 1.0), masses(false)]
}
