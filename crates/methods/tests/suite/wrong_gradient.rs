//! A gradient written by hand that is not that of H: no method loses K in silence.

use afterbay_core::{
    Abilities, Block, Curvature, Dissipation, Grid, IntegrateError, SecondDerivatives, Separable,
    State, StateRef, StepFailure, System, Tolerance,
};
use afterbay_methods::registry::{METHODS, Setting, bind};
use std::ops::ControlFlow;
use std::sync::Arc;

/// The mistake in ∇H.
#[derive(Clone, Copy, Debug)]
enum Mistake {
    /// The term q_j is taken times 1.1.
    Factor,
    /// The term q_j³ has the other sign.
    Sign,
    /// The coupling of neighbours is left out.
    Coupling,
    /// None.
    None,
}

/// H = Σ (p_j² + q_j²)/2 + q_j⁴/4 + Σ (q_{j+1} - q_j)²/2 with D = 0.1 v.
#[derive(Clone, Copy, Debug)]
struct Springs(Mistake, usize);

impl System<f64> for Springs {
    fn dof(&self) -> usize {
        self.1
    }
    fn energy(&self, q: &[f64], p: &[f64]) -> f64 {
        let each = q.iter().zip(p).map(|(q, p)| 0.5 * (p * p + q * q) + 0.25 * q.powi(4));
        let springs = q.windows(2).map(|q| 0.5 * (q[1] - q[0]) * (q[1] - q[0]));
        each.sum::<f64>() + springs.sum::<f64>()
    }
    fn gradient(&self, q: &[f64], p: &[f64], hq: &mut [f64], hp: &mut [f64]) {
        for j in 0..self.1 {
            hq[j] = self.partial(q, j, q[j]);
            hp[j] = p[j];
        }
    }
    fn dissipation(&self, _q: &[f64], _p: &[f64], v: &[f64], d: &mut [f64]) {
        d.iter_mut().zip(v).for_each(|(d, v)| *d = 0.1 * v);
    }
}

impl Separable<f64> for Springs {
    fn partial(&self, q: &[f64], j: usize, at: f64) -> f64 {
        let [factor, sign, coupling] = match self.0 {
            Mistake::Factor => [1.1, 1.0, 1.0],
            Mistake::Sign => [1.0, -1.0, 1.0],
            Mistake::Coupling => [1.0, 1.0, 0.0],
            Mistake::None => [1.0; 3],
        };
        let beside = [j.checked_sub(1), Some(j + 1)].map(|i| i.and_then(|i| q.get(i)));
        let springs: f64 = beside.iter().flatten().map(|&other| at - other).sum();
        factor * at + sign * at.powi(3) + coupling * springs
    }
    fn dissipation_of(&self, _q: &[f64], p: &[f64], j: usize) -> Dissipation<f64> {
        Dissipation { value: 0.1 * p[j], by_q: 0.0, by_p: 0.1 }
    }
}

impl Curvature<f64> for Springs {
    fn curvature(&self, q: &[f64], _p: &[f64], mut put: impl FnMut(Block, usize, usize, f64)) {
        for (j, q) in q.iter().enumerate() {
            let ends = usize::from(j > 0) + usize::from(j + 1 < self.1);
            put(Block::Hqq, j, j, 1.0 + 3.0 * q * q + ends as f64);
            put(Block::Hpp, j, j, 1.0);
            put(Block::Dp, j, j, 0.1);
            if j > 0 {
                put(Block::Hqq, j, j - 1, -1.0);
                put(Block::Hqq, j - 1, j, -1.0);
            }
        }
    }
}

impl Abilities<f64> for Springs {
    fn separable(self: Arc<Self>) -> Option<Arc<dyn Separable<f64>>> {
        Some(self)
    }
    fn second_derivatives(self: Arc<Self>) -> Option<Arc<dyn SecondDerivatives<f64>>> {
        Some(self)
    }
}

#[test]
fn a_wrong_gradient_is_told() {
    let (mut told, mut kept) = (0, 0);
    for mistake in [Mistake::Factor, Mistake::Sign, Mistake::Coupling, Mistake::None] {
        for (n, size) in [(1, 1.0), (3, 1.0), (3, 1e-5), (2, 30.0)] {
            if n == 1 && matches!(mistake, Mistake::Coupling) {
                continue;
            }
            let system = Arc::new(Springs(mistake, n));
            let start = |sign: f64| (0..n).map(|j| size * (0.7 + sign * 0.4 * j as f64)).collect();
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
                let name = format!("{} with {mistake:?}, N = {n}, size {size}", row.name);
                // The sign of a term that is 1e-10 of all is below what is looked for.
                assert!(off < 1e-9, "{name}: K off by {off:e}");
                if let Mistake::None = mistake {
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
        }
    }
    println!("told {told} times, kept {kept} times");
    assert!(told > 50 && kept > 50, "{told} {kept}");
}
