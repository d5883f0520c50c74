//! Lyapunov exponents: the mean rates at which small displacements of (q, p) grow under the steps
//! of a method.
//!
//! ```text
//! J_k Q_k = Q_{k+1} R_k        λ_i = (1/t) Σ_k ln |R_k,ii|        t = Σ_k h
//! ```
//!
//! J_k is the Jacobian of step k ([`Tangent`]), with p in a unit in which it is about as large as
//! q; the columns of Q_k are 2N orthonormal vectors, and R_k is triangular. So these are the
//! exponents of the map that the method is, and those of the equations come from a reference with
//! small steps, in the same way. Sources: G. Benettin and others, Meccanica 15 (1980) 9-20 and
//! 21-30; I. Shimada and T. Nagashima, Prog. Theor. Phys. 61 (1979) 1605-1616; J.-P. Eckmann and D.
//! Ruelle, Rev. Mod. Phys. 57 (1985) 617-656; K. Geist, U. Parlitz and W. Lauterborn, Prog. Theor.
//! Phys. 83 (1990) 875-893.
//!
//! Two figures check the sum of the exponents. The mean of ln |det J_k|/h is computed by LU
//! decomposition, and must equal it to rounding. As h → 0 the sum converges to the mean of the
//! divergence of the equations, -Σ ∂D_j/∂p_j.
//!
//! The standard errors do not cover growth like a power of t. Neighbours on orbits of different
//! periods, as those of planets, separate like t, and a finite time gives ln(c t)/t in place of 0.
//! Their distance grows by 2^k from t/2 to t, whatever t is, where it grows like t^k, and by
//! exp(λt/2) in chaos. [`Spectrum::power`] is this k.
//!
//! [`Tangent`]: super::tangent::Tangent

mod growth;
mod standard_error;
mod walk;

use super::dynamics::{Dynamics, PiecePlan};
use super::metric;
use super::outcome::Ending;
use super::section::Section;
use super::stability::MapError;
use super::{Problem, numbered};
use crate::Model;
use crate::progress::{Piece, Progress};
use crate::words::{Word, by_name, word};
use afterbay_core::{Grid, InputError};
use afterbay_methods::registry::Row;
use growth::Growth;
use serde::{Deserialize, Serialize};
use standard_error::standard_error;
use walk::Walk;

/// The most steps of a run. Their numbers are exact in `f64` up to about 9.007e15.
const MOST_STEPS: f64 = 9e15;

/// The Lyapunov exponents of a problem.
#[derive(Clone, Debug)]
pub struct Lyapunov {
    /// The system, the initial state, and the end of time, which is not used.
    pub problem: Problem,
    /// The time before the exponents are measured, in which the motion comes to its attractor.
    /// Over its last part, as long as the interval between two rows, the vectors turn to their
    /// directions.
    pub transient: f64,
    /// The time over which they are measured.
    pub time: f64,
    /// The number of rows of each method, at equally spaced times.
    pub rows: u64,
}

/// A row of `lyapunov.csv`, under the [`columns`]. A run that fails has a last row with the time it
/// reached.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LyapunovRow {
    /// Name of the method, or "reference".
    #[serde(deserialize_with = "word")]
    pub method: Word,
    /// The step.
    pub h: f64,
    /// The time over which the exponents are measured, that of the transient not included.
    pub t: f64,
    /// λ_1 to λ_2N, the largest first.
    pub exponents: Vec<Option<f64>>,
    /// Their standard errors; none in the first row.
    pub standard_errors: Vec<Option<f64>>,
    /// Σ λ_i
    pub sum: Option<f64>,
    /// The mean of ln |det J|/h.
    pub mean_log_det: Option<f64>,
    /// The mean of -Σ ∂D_j/∂p_j over the states; none for a system without second derivatives.
    pub mean_divergence: Option<f64>,
    /// The outcome of the run.
    #[serde(deserialize_with = "word")]
    pub outcome: Word,
}

/// The names of the columns:
/// `method,h,t,exponent_1..2N,standard_error_1..2N,sum,mean_log_det,mean_divergence,outcome`.
pub fn columns(model: &Model) -> Vec<String> {
    let names = ["method", "h", "t"].map(String::from).into_iter();
    let last = ["sum", "mean_log_det", "mean_divergence", "outcome"].map(String::from);
    let n = 2 * model.degrees();
    let numbers = numbered("exponent_", n).chain(numbered("standard_error_", n));
    names.chain(numbers).chain(last).collect()
}

/// The exponents of a method and a step.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Spectrum {
    /// The method.
    #[serde(with = "by_name")]
    pub row: &'static Row,
    /// The step.
    pub h: f64,
    /// One row for each time.
    pub rows: Vec<LyapunovRow>,
    /// The mean rate ln(b/a)/(t/2) at which the motion grows, with a and b the largest differences
    /// of an entry of (q, p) from where it was at first, in the first and the second half of the
    /// time t: the largest rate of all entries. It is λ where the motion grows like displacements
    /// at a rate λ, and nearly 0 where it stays bounded. None with one row, and where the motion
    /// rests.
    pub growth: Option<f64>,
    /// The power of t with which displacements grow from the first to the second part of the time
    /// t, ln(b/a)/ln(t/t'), with a and b the largest sizes of the displacement of the largest
    /// exponent at the rows up to t', in the middle, and after it. It is k where displacements grow
    /// like t^k, and λt/(2 ln 2) where they grow at a rate λ. None with one row.
    pub power: Option<f64>,
    /// The outcome of the run.
    pub ending: Ending,
}

impl Spectrum {
    /// λ_1 to λ_2N over the whole time; none if the run did not reach its end.
    pub fn exponents(&self) -> Option<Vec<f64>> {
        let last = self.rows.last().filter(|_| self.ending.is_completed())?;
        last.exponents.iter().copied().collect()
    }
}

impl Dynamics for Lyapunov {
    type Piece = Spectrum;
    type Found = Spectrum;

    /// One piece.
    fn pieces(&self) -> Vec<PiecePlan> {
        vec![PiecePlan { key: String::new(), time: self.transient + self.time, runs: 1 }]
    }

    fn piece(
        &self,
        row: &'static Row,
        h: f64,
        _piece: usize,
        progress: &dyn Progress,
    ) -> Result<Spectrum, MapError> {
        let found = self.spectrum(row, h, progress)?;
        progress.advance();
        Ok(found)
    }

    fn join(&self, row: &'static Row, h: f64, pieces: Vec<Spectrum>) -> Spectrum {
        let ending = Ending::interrupted();
        let none = Spectrum { row, h, rows: Vec::new(), growth: None, power: None, ending };
        pieces.into_iter().next().unwrap_or(none)
    }
}

impl Lyapunov {
    /// The exponents of a method with steps of h. Where the drive has a period, the steps divide
    /// it, and are of nearly h.
    ///
    /// # Errors
    /// Invalid input. A run that fails keeps the rows it has.
    fn spectrum(
        &self,
        row: &'static Row,
        h: f64,
        progress: &dyn Progress,
    ) -> Result<Spectrum, InputError> {
        let model = &self.problem.model;
        let h = match model.drive_period() {
            Some(_) => Section::Stroboscopic { interval: None }.grid(model, h)?.h,
            None => Grid::<f64>::of(h, 1)?.h,
        };
        let rows = self.rows.max(1);
        let between = steps(self.time / rows as f64, h)?.max(1.0);
        let before = if self.transient == 0.0 { 0.0 } else { steps(self.transient, h)? };
        let all = before + rows as f64 * between;
        if all > MOST_STEPS {
            return Err(InputError::Budget { steps: all, limit: MOST_STEPS });
        }
        let [before, between] = [before, between].map(|steps| steps as u64);
        let turning = before.min(between);
        let mut walk = Walk::new(&self.problem, row, h, all as u64, progress)?;
        let (mut piece, none) = (Piece::new(progress), Growth::new(2 * model.degrees()));
        let (mut intervals, mut found) = (Vec::new(), Vec::new());
        let mut result = walk
            .take(before - turning, None, &mut piece)
            .and_then(|()| walk.take(turning, Some(&mut none.clone()), &mut piece));
        walk.from = walk.point();
        while result.is_ok() && (intervals.len() as u64) < rows {
            let mut growth = none.clone();
            result = walk.take(between, Some(&mut growth), &mut piece);
            if growth.steps > 0 {
                intervals.push(growth);
                found.push(of_intervals(&intervals, row.name, h));
            }
        }
        let ending = result.err().unwrap_or_else(Ending::completed);
        if found.is_empty() {
            found.push(of_intervals(&[none], row.name, h));
        }
        found.iter_mut().for_each(|row| row.outcome = ending.outcome);
        let (growth, power) = (of_motion(&intervals, &walk.from, h), of_displacements(&intervals));
        Ok(Spectrum { row, h, rows: found, growth, power, ending })
    }
}

/// The number of steps in a time.
fn steps(time: f64, h: f64) -> Result<f64, InputError> {
    if !(time > 0.0 && time.is_finite()) {
        return Err(InputError::End { end: time });
    }
    Ok((time / h).round())
}

/// The row that the growth over intervals gives. All but the last have the same number of steps.
fn of_intervals(intervals: &[Growth], method: &'static str, h: f64) -> LyapunovRow {
    let size = intervals[0].logs.len();
    let t = h * intervals.iter().map(|growth| growth.steps).sum::<u64>() as f64;
    let mean = |of: &dyn Fn(&Growth) -> f64| {
        let total: f64 = intervals.iter().map(of).sum();
        (t > 0.0).then_some(total / t)
    };
    let exponents: Vec<_> = (0..size).map(|i| mean(&|growth| growth.logs[i])).collect();
    let sum = exponents.iter().copied().sum();
    let mut spectrum: Vec<_> =
        (0..size).map(|i| (exponents[i], standard_error(intervals, i, h))).collect();
    // Over a short time, two exponents that differ by little come out in either order.
    let value = |exponent: Option<f64>| exponent.unwrap_or(f64::NEG_INFINITY);
    spectrum.sort_by(|a, b| value(b.0).total_cmp(&value(a.0)));
    let (exponents, standard_errors) = spectrum.into_iter().unzip();
    LyapunovRow {
        method,
        h,
        t,
        standard_errors,
        sum,
        exponents,
        mean_log_det: mean(&|growth| growth.log_det),
        mean_divergence: mean(&|growth| h * growth.divergence.unwrap_or(f64::NAN))
            .filter(|x| x.is_finite()),
        outcome: "",
    }
}

/// The mean rate at which the motion grows: [`Spectrum::growth`]. `from` is (q, p) at first.
/// Differences that are roundings count for no growth.
fn of_motion(intervals: &[Growth], from: &[f64], h: f64) -> Option<f64> {
    let half = intervals.len() / 2;
    let (first, second) = (&intervals[..half], &intervals[intervals.len() - half..]);
    let farthest =
        |part: &[Growth], j| part.iter().map(|each| each.farthest[j]).fold(0.0, f64::max);
    let whole: Vec<f64> = (0..from.len()).map(|j| farthest(intervals, j)).collect();
    let steps: u64 = intervals[half..].iter().map(|growth| growth.steps).sum();
    let rate = |j: usize| {
        let least = metric::rounding(&whole, j, from[j].abs() + whole[j]);
        let (a, b) = (farthest(first, j).max(least), farthest(second, j));
        (b > least).then(|| (b / a).ln() / (h * steps as f64))
    };
    (0..from.len()).filter_map(rate).filter(|rate| rate.is_finite()).reduce(f64::max)
}

/// The power of t with which displacements grow: [`Spectrum::power`].
fn of_displacements(intervals: &[Growth]) -> Option<f64> {
    let (half, size) = (intervals.len() / 2, intervals.first()?.logs.len());
    let sizes = |i: usize| {
        intervals.iter().scan(0.0, move |sum, growth| {
            *sum += growth.logs[i];
            Some(*sum)
        })
    };
    let end = |i: &usize| sizes(*i).last().unwrap_or(f64::NEG_INFINITY);
    let largest = (0..size).max_by(|i, j| end(i).total_cmp(&end(j)))?;
    let first = sizes(largest).take(half).fold(f64::NEG_INFINITY, f64::max);
    let second = sizes(largest).skip(half).fold(f64::NEG_INFINITY, f64::max);
    let steps = |part: &[Growth]| part.iter().map(|growth| growth.steps).sum::<u64>() as f64;
    let power = (second - first) / (steps(intervals) / steps(&intervals[..half])).ln();
    power.is_finite().then_some(power)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Silent;
    use afterbay_methods::registry::find;
    use afterbay_systems::catalog::DUFFING;

    #[test]
    fn more_steps_than_can_be_counted_are_refused() {
        let model = Model::of(&DUFFING, &[1.0, 0.0, 0.0]);
        let problem = Problem { model, q: vec![1.0], p: vec![0.0], end: 1.0 };
        let study = Lyapunov { problem, transient: 0.0, time: 1e30, rows: 3 };
        let refused = study.run(find("rk4").expect("a method"), 1.0, &Silent);
        let error = refused.expect_err("too many steps").to_string();
        assert!(error.starts_with("1e30 steps are more than 9e15"), "{error}");
    }

    const TEN: Growth = Growth {
        steps: 10,
        logs: Vec::new(),
        log_det: 0.0,
        divergence: None,
        farthest: Vec::new(),
    };

    /// The growth of a motion that begins at (q, p), by its largest distances from there in each
    /// interval of t = 1.
    fn rate(from: [f64; 2], farthest: &[[f64; 2]]) -> Option<f64> {
        let interval = |farthest: &[f64; 2]| Growth { farthest: farthest.to_vec(), ..TEN };
        of_motion(&farthest.iter().map(interval).collect::<Vec<_>>(), &from, 0.1)
    }

    #[test]
    fn the_rate_of_a_motion_is_that_between_its_halves() {
        let reaching = |farthest: &[f64]| {
            rate([0.0; 2], &farthest.iter().map(|&farthest| [farthest, 0.0]).collect::<Vec<_>>())
        };
        // From the end of the second interval of t = 1 to that of the fifth: from 3 to 3³.
        let rate = reaching(&[1.0, 3.0, 5.0, 9.0, 27.0]).unwrap();
        assert!((rate - 9.0_f64.ln() / 3.0).abs() < 1e-14, "{rate}");
        assert_eq!(reaching(&[2.0, 1.0, 1.5, 2.0]), Some(0.0));
        for no_rate in [&[][..], &[1.0], &[0.0, 0.0]] {
            assert_eq!(reaching(no_rate), None, "{no_rate:?}");
        }
    }

    /// p oscillates with an amplitude of a million, and q grows.
    #[test]
    fn a_coordinate_that_grows_is_seen_beside_a_larger_momentum() {
        let found = rate([0.0; 2], &[[1.0, 1e6], [3.0, 1e6], [9.0, 1e6], [27.0, 1e6]]).unwrap();
        assert!((found - 9.0_f64.ln() / 2.0).abs() < 1e-14, "{found}");
    }

    #[test]
    fn a_motion_that_leaves_a_rest_grows_from_a_rounding() {
        let found = rate([0.0; 2], &[[0.0; 2], [1.0, 0.0]]).unwrap();
        assert!((found - 1e10_f64.ln()).abs() < 1e-14 * found, "{found}");
    }

    #[test]
    fn roundings_of_a_rest_do_not_grow() {
        assert_eq!(rate([1e3, 0.0], &[[0.0; 2], [1e-13, 0.0], [2e-12, 0.0], [5e-11, 0.0]]), None);
        // Beyond them they do.
        let found = rate([1e3, 0.0], &[[0.0; 2], [1e-13, 0.0], [2e-7, 0.0], [1e-5, 0.0]]).unwrap();
        let rounding = 1e-12 * (1e3 + 1e-5);
        assert!((found - (1e-5_f64 / rounding).ln() / 2.0).abs() < 1e-14, "{found}");
    }

    #[test]
    fn the_power_of_t_is_that_between_the_parts_of_the_time() {
        let power = |n: i32, log_size: &dyn Fn(f64) -> f64| {
            // The largest exponent is the second one.
            let interval = |k: i32| {
                let log = log_size(f64::from(k + 1)) - log_size(f64::from(k));
                Growth { logs: vec![-1.0, log], ..TEN }
            };
            of_displacements(&(0..n).map(interval).collect::<Vec<_>>())
        };
        for (n, k) in [(2, 1.0), (3, 1.0), (50, 1.0), (50, 2.5), (51, 4.0)] {
            let found = power(n, &|t| k * (t + 1e-12).ln()).unwrap();
            assert!((found - k).abs() < 1e-9, "{n} intervals: {found}, not {k}");
        }
        let exponential = power(40, &|t| 0.5 * t).unwrap();
        assert!((exponential - 10.0 / 2.0_f64.ln()).abs() < 1e-12, "{exponential}");
        assert_eq!([power(0, &|t| t), power(1, &|t| t)], [None, None]);
    }

    #[test]
    fn the_standard_error_is_that_of_the_mean_of_intervals() {
        let interval =
            |log: f64| Growth { logs: vec![log], log_det: log, divergence: Some(-20.0), ..TEN };
        // Rates 1, 2 and 6 over t = 1 each: mean 3, s² = 7.
        let row = of_intervals(&[interval(1.0), interval(2.0), interval(6.0)], "rk4", 0.1);
        assert!((row.t - 3.0).abs() < 1e-15 && (row.sum.unwrap() - 3.0).abs() < 1e-14);
        assert!((row.standard_errors[0].unwrap() - (7.0_f64 / 3.0).sqrt()).abs() < 1e-14);
        assert!((row.mean_divergence.unwrap() + 2.0).abs() < 1e-14);
        // Rates that last for four intervals are a quarter as many: the error is twice that of
        // forty independent ones.
        let rate = |k: usize| if (k / 4).is_multiple_of(2) { 1.0 } else { -1.0 };
        let lasting: Vec<_> = (0..40).map(|k| interval(rate(k))).collect();
        let error = of_intervals(&lasting, "rk4", 0.1).standard_errors[0].unwrap();
        assert!((error - (1.0_f64 / 9.0).sqrt()).abs() < 1e-14, "{error}");
        let growth = Growth { logs: vec![1.0, 2.0], ..TEN };
        assert_eq!(of_intervals(&[growth], "rk4", 0.1).exponents, [Some(2.0), Some(1.0)]);
    }
}
