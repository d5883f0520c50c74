//! The derivative of one step of a method by the state.
//!
//! ```text
//! z = (q, p)        z1 = Φ_h(z)        J_ij = ∂z1_i/∂z_j = [Φ_h(z + d_j e_j) - Φ_h(z)]_i/d_j
//! ```
//!
//! A driven system has q and p of its own degrees of freedom in z. Its motors stand at the time of
//! the step in all of these runs.
//!
//! Every step is taken in 106 bits. The displacement d_j is 2⁻⁵² of the size of q_j or of p_j
//! in this step, so that the difference has a truncation error of about 2⁻⁵² and a rounding
//! error of about 2⁻¹⁰⁶ 2⁵²: both are roundings of `f64`. The derivative is that of the method
//! itself, of its nonlinear solver and its quadratures too, and needs no second derivative of H.
//! It costs 2N + 1 steps.
//!
//! An entry that is far smaller than the largest q, or p, may have a unit of its own, or pass 0.
//! Its size is taken as the geometric mean of both: where it is smaller by a factor r, either error
//! is at most √r roundings.
//!
//! A motion that has settled at q ≠ 0 has momenta near 0. A displacement in proportion to them
//! changes q by less than a rounding. A displacement of p_j that moves q_j by less than 2⁻⁶⁴ of the
//! size of q is thus enlarged until it moves q_j by 2⁻⁵⁸ of that size, which is still less than the
//! rounding of q in `f64`. The step is then taken once more. Near rest, a displacement of p begins
//! at 2⁻⁵² of the impulse of the force in a step from a q displaced by its size.
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
/// 2⁻³³², the least size: that of a motion that decays for ever would underflow.
const LEAST: f64 = f64::from_bits((1023 - 332) << 52);
/// 2⁻⁵², the share of the largest entry below which one is a rounding of 0, and does not tell its
/// unit.
const ROUNDING_OF_ZERO: f64 = f64::EPSILON;
/// 2⁻²⁰, the size of p relative to that of an impulse, below which a motion is near rest.
const NEAR_REST: f64 = 1.0 / (1 << 20) as f64;
/// 2⁻¹², the least part of a displacement of q that one of p has to cause.
const LEAST_PART: f64 = 1.0 / (1 << 12) as f64;
/// 2⁻⁶, the part to which it is enlarged.
const ENLARGED_PART: f64 = 1.0 / (1 << 6) as f64;
/// 2⁻⁴⁴, the part below which the effect on q is rounding, and does not measure how much larger the
/// displacement must be.
const LOST_PART: f64 = 1.0 / (1_u64 << 44) as f64;
/// 2⁴⁰, the factor by which a displacement is then enlarged.
const LOST_FACTOR: f64 = (1_u64 << 40) as f64;
/// The most times that a displacement of p is enlarged.
const MOST_ENLARGEMENTS: u32 = 4;

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
        let [sizes_of_q, sizes_of_p] =
            [[&state.q, &end.q], [&state.p, &end.p]].map(|ends| sizes(ends.map(|x| &x[..n])));
        let step =
            Step { tangent: self, h, start: state, end: &end, sizes_of_q: sizes_of_q.as_deref() };
        let mut put = |j: usize, changes: &[f64]| {
            for (i, &value) in changes.iter().enumerate() {
                if !value.is_finite() {
                    let quantity = [Quantity::Coordinate, Quantity::Momentum][i / n];
                    let failure = StepFailure::NonFinite { quantity, dof: i % n, value };
                    return Err(RunError { step: 1, t: state.t.to_f64(), failure });
                }
                jacobian[(i, j)] = value;
            }
            Ok(())
        };
        let mut impulses = vec![0.0_f64; n];
        for j in 0..n {
            let size = step.size_of_q(j);
            let changes = step.column(j, DISPLACEMENT * size)?;
            for (impulse, slope) in impulses.iter_mut().zip(&changes[n..]) {
                *impulse = impulse.max(slope.abs() * size);
            }
            put(j, &changes)?;
        }
        let largest = impulses.iter().copied().fold(0.0, f64::max);
        for (j, impulse) in impulses.into_iter().enumerate() {
            // A momentum without a force, that of a free particle, begins as the others do.
            let impulse = if impulse > 0.0 { impulse } else { largest };
            let size = match sizes_of_p.as_ref().map(|sizes| sizes[j]) {
                Some(size) if size >= NEAR_REST * impulse => size,
                // A finite impulse: all entries were found finite.
                _ if impulse > 0.0 => impulse.max(LEAST),
                Some(size) => size,
                None => 1.0,
            };
            put(n + j, &step.column_of_momentum(n + j, DISPLACEMENT * size)?)?;
        }
        *state = end;
        Ok(jacobian)
    }
}

/// A step, whose derivatives are looked for.
struct Step<'a> {
    tangent: &'a Tangent,
    h: Quad,
    start: &'a State<Vec<Quad>>,
    end: &'a State<Vec<Quad>>,
    sizes_of_q: Option<&'a [f64]>,
}

impl Step<'_> {
    /// The size of q_j, 1 where all coordinates are 0.
    fn size_of_q(&self, j: usize) -> f64 {
        self.sizes_of_q.map_or(1.0, |sizes| sizes[j])
    }

    /// Column j of the Jacobian: the changes of the end of the step by a displacement d, over d.
    ///
    /// # Errors
    /// The failure of the step from the displaced state.
    fn column(&self, j: usize, d: f64) -> Result<Vec<f64>, IntegrateError> {
        let (n, d, mut moved) = (self.tangent.dof, Quad::from_f64(d), self.start.clone());
        let part = if j < n { &mut moved.q } else { &mut moved.p };
        part[j % n] += d;
        self.tangent.step(self.h, &mut moved)?;
        Ok(difference(&moved, self.end, n).map(|change| (change / d).to_f64()).collect())
    }

    /// Column j, that of a momentum, by a displacement d that is enlarged until the coordinate of
    /// this momentum shows it. A momentum that does not move its coordinate keeps d.
    ///
    /// # Errors
    /// The failure of the step from the state displaced by d.
    fn column_of_momentum(&self, j: usize, mut d: f64) -> Result<Vec<f64>, IntegrateError> {
        let first = self.column(j, d)?;
        let Some(sizes_of_q) = self.sizes_of_q else { return Ok(first) };
        let i = j - self.tangent.dof;
        // The part of a displacement of q_i that the displacement d causes.
        let part =
            |changes: &[f64], d: f64| (changes[i] * d / (DISPLACEMENT * sizes_of_q[i])).abs();
        let mut seen = part(&first, d);
        let mut larger = None;
        for _ in 0..MOST_ENLARGEMENTS {
            if seen >= LEAST_PART {
                break;
            }
            d *= if seen > LOST_PART { ENLARGED_PART / seen } else { LOST_FACTOR };
            let Ok(changes) = self.column(j, d) else { break };
            seen = part(&changes, d);
            larger = Some(changes);
        }
        Ok(larger.filter(|_| seen >= LEAST_PART).unwrap_or(first))
    }
}

/// The size of each entry, at least [`LEAST`]: the geometric mean of its largest magnitude at both
/// ends of a step and the largest of all. That of a rounding of 0 is the largest of all. None if
/// all are 0.
fn sizes(ends: [&[Quad]; 2]) -> Option<Vec<f64>> {
    let magnitude = |(a, b): (&Quad, &Quad)| a.to_f64().abs().max(b.to_f64().abs());
    let magnitudes: Vec<f64> = ends[0].iter().zip(ends[1]).map(magnitude).collect();
    let largest = magnitudes.iter().copied().fold(0.0, f64::max);
    let size = |own: f64| {
        let mean = if own > ROUNDING_OF_ZERO * largest {
            largest * (own / largest).sqrt()
        } else {
            largest
        };
        mean.max(LEAST)
    };
    (largest > 0.0).then(|| magnitudes.into_iter().map(size).collect())
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
