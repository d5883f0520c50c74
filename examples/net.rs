//! A periodic net of 1600 masses, solved with sparse linear algebra: V = Σ r²/2 over the springs
//! between neighbours + Σ q_j⁴/4, and D_j = C v_j. `cargo run --example net`

use afterbay_core::{Block, Curvature, Grid, State, System, integrate};
use afterbay_methods::{Gonzalez, LinearSolver};

const SIDE: usize = 40;
const N: usize = SIDE * SIDE;
const C: f64 = 0.05;

/// The masses beside mass j, which is in row j / SIDE and column j % SIDE.
fn beside(j: usize) -> [usize; 4] {
    let along = |step| j / SIDE * SIDE + (j + step) % SIDE;
    [along(1), along(SIDE - 1), (j + SIDE) % N, (j + N - SIDE) % N]
}

/// The force of its springs on mass j, towards smaller q_j. They store Σ pull(q, j) q_j / 2.
fn pull(q: &[f64], j: usize) -> f64 {
    4.0 * q[j] - beside(j).map(|i| q[i]).iter().sum::<f64>()
}

struct Net;
impl System<f64> for Net {
    fn dof(&self) -> usize {
        N
    }
    fn energy(&self, q: &[f64], p: &[f64]) -> f64 {
        (0..N).map(|j| (p[j] * p[j] + pull(q, j) * q[j]) / 2.0 + q[j].powi(4) / 4.0).sum()
    }
    fn gradient(&self, q: &[f64], p: &[f64], hq: &mut [f64], hp: &mut [f64]) {
        hq.iter_mut().enumerate().for_each(|(j, hq)| *hq = pull(q, j) + q[j].powi(3));
        hp.copy_from_slice(p);
    }
    fn dissipation(&self, _q: &[f64], _p: &[f64], v: &[f64], d: &mut [f64]) {
        d.iter_mut().zip(v).for_each(|(d, v)| *d = C * v);
    }
}

/// Every second derivative of H and derivative of D that is not always 0, each once.
impl Curvature<f64> for Net {
    fn curvature(&self, q: &[f64], _p: &[f64], mut put: impl FnMut(Block, usize, usize, f64)) {
        for (j, q) in q.iter().enumerate() {
            put(Block::Hqq, j, j, 4.0 + 3.0 * q * q);
            beside(j).iter().for_each(|&i| put(Block::Hqq, j, i, -1.0));
            put(Block::Hpp, j, j, 1.0);
            put(Block::Dp, j, j, C);
        }
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut state = State::new(vec![0.0; N], vec![0.0; N])?;
    state.p[0] = 10.0;
    let before = state.total(&Net);
    let sparse = Gonzalez { solver: Some(LinearSolver::Sparse) };
    integrate(&sparse, &Net, Grid::new(0.2, 40.0)?, &mut state, &mut ())?;
    let (lost, drift) = (state.reservoir(), (state.total(&Net) - before).abs() / before);
    println!("{lost:.4} of the energy {before} is dissipated. K is off by {drift:.0e} of itself.");
    if drift < 1e-12 { Ok(()) } else { Err("K is not kept".into()) }
}
