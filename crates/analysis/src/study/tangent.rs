//! The derivative of one step of a method by the state.
//!
//! ```text
//! z = (q, p)        z1 = Φ_h(z)        J_ij = ∂z1_i/∂z_j = [Φ_h(z + d_j e_j) - Φ_h(z)]_i/d_j
//! ```
//!
//! A driven system has q and p of its own degrees of freedom in z. Its motors stand at the time of
//! the step in all of these runs.
//!
//! Every step is taken in 106 bits. The displacement d_j is 2⁻⁵² of the size of z_j, so that the
//! difference has a truncation error of about 2⁻⁵² and a rounding error of about 2⁻¹⁰⁶ 2⁵²: both
//! are roundings of `f64`. The derivative is that of the method itself, of its nonlinear solver and
//! its quadratures too, and needs no second derivative of H. It costs 2N + 1 steps.
//!
//! Each step begins in a fresh workspace. A method with relaxation, whose steps depend on those
//! before through the lag of its time, is thus taken without its lag, which is of the order of its
//! local error.

use crate::Model;
use afterbay_core::{
    InputError, IntegrateError, Quad, Quantity, RunError, Scalar, State, StepFailure,
};
use afterbay_methods::registry::{Row, Run};
use faer::Mat;

/// 2⁻⁵², the displacement relative to the size of what is displaced.
const DISPLACEMENT: f64 = f64::EPSILON;

/// A method bound to a system in 106 bits.
pub struct Tangent {
    run: Run<Quad>,
    /// The number of degrees of freedom that are not motors.
    dof: usize,
}

impl Tangent {
    /// The steps of a method on a system.
    ///
    /// # Errors
    /// Those of `Model::bind_in`, and [`InputError::Unsupported`] where the method chooses its
    /// steps.
    pub fn new(model: &Model, row: &Row) -> Result<Self, InputError> {
        Ok(Self { run: model.bind_in(row)?, dof: model.degrees() })
    }

    /// Takes one step. The time of the state does not change.
    ///
    /// # Errors
    /// The failure of the step; the state is then unchanged.
    pub fn step(&self, h: Quad, state: &mut State<Vec<Quad>>) -> Result<(), IntegrateError> {
        self.run.step(h, state).map(drop)
    }

    /// Takes one step, and returns its 2N x 2N Jacobian by z = (q, p), the N entries of q first.
    ///
    /// # Errors
    /// The failure of the step or of one from a displaced state, and [`StepFailure::NonFinite`] for
    /// an entry that is not finite; the state is then unchanged.
    pub fn step_with_jacobian(
        &self,
        h: Quad,
        state: &mut State<Vec<Quad>>,
    ) -> Result<Mat<f64>, IntegrateError> {
        let n = self.dof;
        let mut end = state.clone();
        self.step(h, &mut end)?;
        let mut jacobian = Mat::zeros(2 * n, 2 * n);
        let sizes = [&state.q, &state.p].map(|part| size(&part[..n]));
        for j in 0..2 * n {
            let mut moved = state.clone();
            let part = if j < n { &mut moved.q } else { &mut moved.p };
            let d = Quad::from_f64(DISPLACEMENT * sizes[j / n]);
            part[j % n] += d;
            self.step(h, &mut moved)?;
            for (i, change) in difference(&moved, &end, n).enumerate() {
                let value = (change / d).to_f64();
                if !value.is_finite() {
                    let quantity = [Quantity::Coordinate, Quantity::Momentum][i / n];
                    let failure = StepFailure::NonFinite { quantity, dof: i % n, value };
                    return Err(RunError { step: 1, t: state.t.to_f64(), failure }.into());
                }
                jacobian[(i, j)] = value;
            }
        }
        *state = end;
        Ok(jacobian)
    }
}

/// The largest magnitude, by which entries that are 0 are displaced too; 1 if all are 0.
fn size(part: &[Quad]) -> f64 {
    let most = part.iter().map(|x| x.to_f64().abs()).fold(0.0, f64::max);
    if most > 0.0 { most } else { 1.0 }
}

/// The difference of (q, p), without motors.
fn difference<'a>(
    a: &'a State<Vec<Quad>>,
    b: &'a State<Vec<Quad>>,
    n: usize,
) -> impl Iterator<Item = Quad> + 'a {
    let parts = [(&a.q, &b.q), (&a.p, &b.p)].into_iter();
    parts.flat_map(move |(a, b)| a[..n].iter().zip(&b[..n]).map(|(&a, &b)| a - b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::Problem;
    use afterbay_methods::registry::{FIXED, find};
    use afterbay_systems::{DAMPED_OSCILLATOR, DUFFING};

    fn jacobian(model: Model, method: &str, h: f64, [q, p]: [f64; 2]) -> Mat<f64> {
        let problem = Problem { model, q: vec![q], p: vec![p], end: 1.0 };
        let tangent = Tangent::new(&problem.model, find(method).unwrap()).unwrap();
        let mut state = problem.start::<Quad>().unwrap();
        tangent.step_with_jacobian(Quad::from_f64(h), &mut state).unwrap()
    }

    fn check(found: &Mat<f64>, exact: [[f64; 2]; 2], most: f64, what: &str) {
        for (i, row) in exact.iter().enumerate() {
            for (j, exact) in row.iter().enumerate() {
                let off = (found[(i, j)] - exact).abs();
                assert!(off < most, "{what}: J{i}{j} = {:e}, not {exact:e}", found[(i, j)]);
            }
        }
    }

    /// q1 - q0 = h p̄ and p1 - p0 = -h (k q̄ + b p̄) solved for (q1, p1).
    #[test]
    fn moddg_of_the_damped_oscillator_has_its_closed_form() {
        for (h, k, b) in [(0.1, 1.0, 0.1), (0.7, 3.0, 2.0), (3.0, 0.5, 0.0)] {
            let model = Model::of(&DAMPED_OSCILLATOR, &[k, b]);
            let (s, d) = (h * h * k / 4.0, h * b / 2.0);
            let all = 1.0 + s + d;
            let exact = [[(1.0 - s + d) / all, h / all], [-h * k / all, (1.0 - s - d) / all]];
            for start in [[2.3, -3.1], [0.0, 1.0], [1e-9, 0.0]] {
                check(&jacobian(model.clone(), "moddg", h, start), exact, 1e-15, "moddg");
            }
        }
    }

    /// rk4 on z' = A z is the Taylor polynomial Σ (hA)^n/n! of degree 4.
    #[test]
    fn rk4_on_a_linear_system_is_a_polynomial() {
        let (h, k, b) = (0.3, 2.0, 0.7);
        let a = Mat::from_fn(2, 2, |i, j| [[0.0, h], [-h * k, -h * b]][i][j]);
        let mut exact = Mat::<f64>::identity(2, 2);
        for n in (1..=4).rev() {
            exact = Mat::<f64>::identity(2, 2) + &a * &exact * faer::Scale(1.0 / f64::from(n));
        }
        let exact = [0, 1].map(|i| [0, 1].map(|j| exact[(i, j)]));
        let model = Model::of(&DAMPED_OSCILLATOR, &[k, b]);
        check(&jacobian(model, "rk4", h, [0.4, 1.7]), exact, 1e-15, "rk4");
    }

    /// Central differences of steps in `f64` agree within their own errors, for every method.
    #[test]
    fn every_method_has_the_derivative_of_its_step() {
        let model = Model::of(&DUFFING, &[1.0, 0.5, 0.3]);
        let (h, z, d) = (0.1, [0.8, -0.6], 1e-5);
        let mut seen = 0;
        for row in FIXED.iter().filter(|row| model.bind(row).is_ok()) {
            let run = model.bind(row).unwrap();
            let image = |z: [f64; 2]| {
                let mut state = State::new(vec![z[0]], vec![z[1]]).unwrap();
                run.step(h, &mut state).unwrap();
                [state.q[0], state.p[0]]
            };
            let column = |j: usize| {
                let [mut a, mut b] = [z; 2];
                (a[j], b[j]) = (z[j] + d, z[j] - d);
                let (a, b) = (image(a), image(b));
                [0, 1].map(|i| (a[i] - b[i]) / (2.0 * d))
            };
            let columns = [column(0), column(1)];
            let exact = [0, 1].map(|i| [columns[0][i], columns[1][i]]);
            check(&jacobian(model.clone(), row.name, h, z), exact, 1e-9, row.name);
            seen += 1;
        }
        assert!(seen > 15, "{seen} methods");
    }
}
