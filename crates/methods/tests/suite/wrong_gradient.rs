//! A gradient written by hand that is not that of H: no method loses K in silence.

use afterbay_core::{
    Abilities, Block, Curvature, Dissipation, Grid, IntegrateError, SecondDerivatives, Separable,
    State, StateRef, StepFailure, System, Tolerance,
};
use afterbay_methods::registry::{METHODS, Setting, bind, find};
use std::ops::ControlFlow;
use std::sync::Arc;

/// The mistake in ∇H.
#[derive(Clone, Copy, Debug)]
enum Mistake {
    /// A's slope is taken times 1.1.
    Factor,
    /// B's slope has the other sign.
    Sign,
    /// The coupling of neighbours is left out.
    Coupling,
    /// None.
    None,
}

/// The terms A, B and C of V = Σ A(q_j) + B(q_j) + Σ C(q_{j+1} - q_j).
#[derive(Clone, Copy, Debug)]
enum Terms {
    /// q²/2, q⁴/4 and d²/2.
    Powers,
    /// 1 - cos q, (1 - cos 2q)/4 and 1 - cos d, which are bounded.
    Waves,
}

impl Terms {
    fn values(self, q: f64) -> [f64; 3] {
        match self {
            Self::Powers => [0.5 * q * q, 0.25 * q.powi(4), 0.5 * q * q],
            // Without the cancellation of 1 - cos q.
            Self::Waves => {
                let wave = 2.0 * (0.5 * q).sin().powi(2);
                [wave, 0.5 * q.sin().powi(2), wave]
            }
        }
    }
    fn slopes(self, q: f64) -> [f64; 3] {
        match self {
            Self::Powers => [q, q.powi(3), q],
            Self::Waves => [q.sin(), 0.5 * (2.0 * q).sin(), q.sin()],
        }
    }
    fn second_derivatives(self, q: f64) -> [f64; 3] {
        match self {
            Self::Powers => [1.0, 3.0 * q * q, 1.0],
            Self::Waves => [q.cos(), (2.0 * q).cos(), q.cos()],
        }
    }
}

/// A chain of n with H = Σ p_j²/2 + V and D = 0.1 v.
#[derive(Clone, Copy, Debug)]
struct Chain {
    terms: Terms,
    mistake: Mistake,
    n: usize,
}

impl System<f64> for Chain {
    fn dof(&self) -> usize {
        self.n
    }
    fn energy(&self, q: &[f64], p: &[f64]) -> f64 {
        let site = |&q: &f64| self.terms.values(q)[..2].iter().sum::<f64>();
        let couplings: f64 = q.windows(2).map(|q| self.terms.values(q[1] - q[0])[2]).sum();
        p.iter().map(|p| 0.5 * p * p).sum::<f64>() + q.iter().map(site).sum::<f64>() + couplings
    }
    fn gradient(&self, q: &[f64], p: &[f64], hq: &mut [f64], hp: &mut [f64]) {
        for j in 0..self.n {
            hq[j] = self.partial(q, j, q[j]);
            hp[j] = p[j];
        }
    }
    fn dissipation(&self, _q: &[f64], _p: &[f64], v: &[f64], d: &mut [f64]) {
        d.iter_mut().zip(v).for_each(|(d, v)| *d = 0.1 * v);
    }
}

impl Separable<f64> for Chain {
    fn partial(&self, q: &[f64], j: usize, at: f64) -> f64 {
        let factors = match self.mistake {
            Mistake::Factor => [1.1, 1.0, 1.0],
            Mistake::Sign => [1.0, -1.0, 1.0],
            Mistake::Coupling => [1.0, 1.0, 0.0],
            Mistake::None => [1.0; 3],
        };
        let beside = [j.checked_sub(1), Some(j + 1)].map(|i| i.and_then(|i| q.get(i)));
        let coupling: f64 = beside.iter().flatten().map(|&q| self.terms.slopes(at - q)[2]).sum();
        let [a, b, _] = self.terms.slopes(at);
        factors[0] * a + factors[1] * b + factors[2] * coupling
    }
    fn dissipation_of(&self, _q: &[f64], p: &[f64], j: usize) -> Dissipation<f64> {
        Dissipation { value: 0.1 * p[j], by_q: 0.0, by_p: 0.1 }
    }
}

impl Curvature<f64> for Chain {
    fn curvature(&self, q: &[f64], _p: &[f64], mut put: impl FnMut(Block, usize, usize, f64)) {
        for j in 0..self.n {
            put(Block::Hqq, j, j, self.terms.second_derivatives(q[j])[..2].iter().sum());
            put(Block::Hpp, j, j, 1.0);
            put(Block::Dp, j, j, 0.1);
            if j > 0 {
                let coupling = self.terms.second_derivatives(q[j] - q[j - 1])[2];
                for (i, k) in [(j, j), (j - 1, j - 1)] {
                    put(Block::Hqq, i, k, coupling);
                }
                for (i, k) in [(j, j - 1), (j - 1, j)] {
                    put(Block::Hqq, i, k, -coupling);
                }
            }
        }
    }
}

impl Abilities<f64> for Chain {
    fn separable(self: Arc<Self>) -> Option<Arc<dyn Separable<f64>>> {
        Some(self)
    }
    fn second_derivatives(self: Arc<Self>) -> Option<Arc<dyn SecondDerivatives<f64>>> {
        Some(self)
    }
}

#[test]
fn a_wrong_gradient_is_told() {
    for terms in [Terms::Powers, Terms::Waves] {
        let mut kept = 0;
        for mistake in [Mistake::Factor, Mistake::Sign, Mistake::Coupling, Mistake::None] {
            let mut told = 0;
            for (n, size) in [(1, 1.0), (3, 1.0), (3, 1e-5), (2, 30.0)] {
                if n == 1 && matches!(mistake, Mistake::Coupling) {
                    continue;
                }
                let [more_told, more_kept] = runs(Chain { terms, mistake, n }, size);
                told += more_told;
                kept += more_kept;
            }
            let is_right = matches!(mistake, Mistake::None);
            assert_eq!(told == 0, is_right, "{terms:?} with {mistake:?}: {told}");
            assert!(is_right || told >= 10, "{terms:?} with {mistake:?}: {told}");
        }
        assert!(kept > 50, "{terms:?}: {kept}");
    }
}

/// Runs every method that keeps K from numbers of a size, and checks that none of them loses K.
/// Returns how many said that the gradient is not that of H, and how many came to the end.
fn runs(system: Chain, size: f64) -> [u32; 2] {
    let n = system.n;
    let system = Arc::new(system);
    let start = |sign: f64| (0..n).map(|j| size * (0.7 + sign * 0.4 * j as f64)).collect();
    let (mut told, mut kept) = (0, 0);
    for row in METHODS.iter().filter(|row| row.keeps_k) {
        let Ok(run) = bind::<f64>(row, system.clone()) else { continue };
        let mut state: State<Vec<f64>> = State::new(start(1.0), start(-1.0)).unwrap();
        let before = state.total(&*system);
        let mut show = |_: u64, _: StateRef<'_, f64>| ControlFlow::Continue(());
        let setting = match row.is_adaptive() {
            true => Setting::Tolerance(Tolerance::all(1e-6), 1.0),
            false => Setting::Step(Grid::of(0.01 / size.max(1.0), 100).unwrap()),
        };
        let ended = run.run(setting, &mut state, 1, &mut show);
        let off = ((state.total(&*system) - before) / before).abs();
        let name = format!("{} with {system:?}, size {size}", row.name);
        // The sign of a term that is 1e-10 of all is below what is looked for.
        assert!(off < 1e-9, "{name}: K off by {off:e}");
        if let Mistake::None = system.mistake {
            assert!(ended.is_ok(), "{name}: {ended:?}");
        }
        match ended {
            Ok(_) => kept += 1,
            Err(IntegrateError::Run(error)) => {
                told += u32::from(matches!(error.failure, StepFailure::NotGradient { .. }));
            }
            Err(error) => panic!("{name}: {error}"),
        }
    }
    [told, kept]
}

/// V = q⁴/4 whose `partial` is wrong by a factor, while its gradient is right.
#[derive(Clone, Copy, Debug)]
struct WrongPartial {
    factor: f64,
}

impl System<f64> for WrongPartial {
    fn dof(&self) -> usize {
        1
    }
    fn energy(&self, q: &[f64], p: &[f64]) -> f64 {
        0.5 * p[0] * p[0] + 0.25 * q[0].powi(4)
    }
    fn gradient(&self, q: &[f64], p: &[f64], hq: &mut [f64], hp: &mut [f64]) {
        (hq[0], hp[0]) = (q[0].powi(3), p[0]);
    }
    fn dissipation(&self, _q: &[f64], _p: &[f64], v: &[f64], d: &mut [f64]) {
        d[0] = 0.1 * v[0];
    }
}

impl Separable<f64> for WrongPartial {
    fn partial(&self, _q: &[f64], _dof: usize, at: f64) -> f64 {
        self.factor * at.powi(3)
    }
    fn dissipation_of(&self, _q: &[f64], p: &[f64], _dof: usize) -> Dissipation<f64> {
        Dissipation { value: 0.1 * p[0], by_q: 0.0, by_p: 0.1 }
    }
}

impl Abilities<f64> for WrongPartial {
    fn separable(self: Arc<Self>) -> Option<Arc<dyn Separable<f64>>> {
        Some(self)
    }
}

#[test]
fn a_wrong_partial_is_told() {
    for factor in [1.2, 1.01, 0.5, -1.0, 1.0] {
        for name in ["moddg", "increment-2", "increment-4"] {
            let system = Arc::new(WrongPartial { factor });
            let run = bind::<f64>(find(name).unwrap(), system).unwrap();
            let mut state = State::new(vec![1.0], vec![0.0]).unwrap();
            let mut show = |_: u64, _: StateRef<'_, f64>| ControlFlow::Continue(());
            let setting = Setting::Step(Grid::of(1e-3, 1000).unwrap());
            let ended = run.run(setting, &mut state, 1, &mut show);
            match ended {
                Ok(_) => assert_eq!(factor, 1.0, "{name}"),
                Err(IntegrateError::Run(error)) => {
                    let told = matches!(error.failure, StepFailure::NotPartial { dof: 0, .. });
                    assert!(told && error.step == 1 && factor != 1.0, "{name}, {factor}: {error}");
                }
                Err(error) => panic!("{name}, {factor}: {error}"),
            }
        }
    }
}
