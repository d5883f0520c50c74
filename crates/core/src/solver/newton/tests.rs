//! Newton's iteration on equations whose solutions are known.

mod convergence;

use super::two_corrections::TwoCorrections;
use super::*;
use crate::numbers::f64x8;
use qd::Quad;

/// x + s (a x + b x³) = start
fn cubic<T: Scalar>(a: f64, b: f64) -> impl FnMut(T, T) -> Sample<T> {
    let (a, b) = (T::from_f64(a), T::from_f64(b));
    move |s, x| Sample {
        value: s * (a * x + b * x * x * x),
        slope: s * (a + T::from_f64(3.0) * b * x * x),
        argument_rounding: T::zero(),
        value_rounding: T::zero(),
    }
}

#[test]
fn one_newton_and_one_chord_correction_solve_an_ordinary_step() {
    let root = Newton.solve(0, 1.0, cubic(1e-4, 1e-5)).unwrap();
    assert!((root.x * (1.0 + 1e-4 + 1e-5 * root.x * root.x) - 1.0).abs() < 3e-16);
    assert_eq!(root.evaluations, 2);
}

/// The squares of these are no numbers any more, or not quite.
#[test]
fn small_numbers_take_no_more_evaluations() {
    for (a, evaluations) in [(1e-4, 2), (0.04, 3)] {
        for start in [1e-3, 1e-40, 1e-100, 1e-150, 1e-160, 1e-200, 1e-280] {
            let root = Newton.solve(0, start, cubic(a, 1e-5)).unwrap();
            let back = root.x * (1.0 + a + 1e-5 * root.x * root.x);
            assert!((back / start - 1.0).abs() < 4e-16, "{a} {start:e}: {:e}", root.x);
            assert!(root.evaluations <= evaluations, "{a} {start:e}: {}", root.evaluations);
            let lanes = Newton.solve(0, f64x8::from(start), cubic(a, 1e-5)).unwrap();
            assert_eq!(lanes.x.to_array()[3].to_bits(), root.x.to_bits(), "{a} {start:e}");
        }
    }
}

/// A number between `low` and `high` (linear congruential generator).
fn random(seed: &mut u64, low: f64, high: f64) -> f64 {
    *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    low + (high - low) * (*seed >> 11) as f64 / (1_u64 << 53) as f64
}

/// If the solution is small compared with the start, the second correction is as large as the
/// solution, and every bit of the inverse counts.
#[test]
fn two_evaluations_give_what_more_care_gives() {
    let (mut seed, mut taken, mut felt) = (1_u64, 0, 0);
    for _ in 0..20_000 {
        let [a, b, end, start] = [(-2e-3, 2e-3), (-1e-8, 1e-8), (-9.0, 0.5), (-4.0, 4.0)]
            .map(|(l, h)| random(&mut seed, l, h));
        let x = 10_f64.powf(end);
        let force = start - x - a * x - b * x * x * x;
        let mut nonlinear = cubic(a, b);
        let mut equation = |s: f64, x: f64| {
            let f = nonlinear(s, x);
            Sample { value: f.value + s * force, argument_rounding: s * force.abs(), ..f }
        };
        let Some(quick) = Newton::ordinary(start, &mut equation) else { continue };
        let first = equation(1.0, start);
        let pair = two_corrections::<f64, true>(1.0, start, start, first, &mut equation);
        let middle = pair.second.unwrap().0;
        let careful = iterate_to_rounding::<f64, _, true>(
            1.0,
            start,
            TwoCorrections { done: false, ..pair },
            &mut equation,
        );
        assert!(!careful.stalled);
        assert_eq!(
            (quick.x.to_bits(), 2),
            (careful.x.to_bits(), careful.evaluations),
            "{a} {b} {x} {start}"
        );
        taken += 1;
        felt += u32::from((quick.x - middle).abs() > 0.01 * quick.x.abs());
    }
    println!("{taken} in two evaluations, the second correction felt in {felt}");
    assert!(taken > 2000 && felt > 200, "{taken} {felt}");
}

/// In lanes too, some of which take two corrections and some three.
#[test]
fn a_third_correction_gives_what_more_care_gives() {
    let (mut seed, mut taken) = (1_u64, [0; 4]);
    for _ in 0..5_000 {
        let of: [[f64; 3]; 8] = std::array::from_fn(|_| {
            let ranges = [(-0.05, 0.05), (-6.0, -3.0), (-4.0, 4.0)];
            let [a, b, start] = ranges.map(|(low, high)| random(&mut seed, low, high));
            [a, 10_f64.powf(b).copysign(start), start]
        });
        let thirds = of.map(|[a, b, start]| {
            let mut equation = cubic(a, b);
            let first = equation(1.0, start);
            let pair = || two_corrections::<f64, true>(1.0, start, start, first, &mut cubic(a, b));
            if pair().done {
                return None;
            }
            let quick = pair().corrected_again(start, &mut equation)?;
            let careful = iterate_to_rounding::<f64, _, true>(1.0, start, pair(), &mut equation);
            assert!(!careful.stalled);
            assert_eq!(
                (quick.x.to_bits(), quick.evaluations),
                (careful.x.to_bits(), careful.evaluations),
                "{a} {b} {start}"
            );
            taken[quick.evaluations as usize] += 1;
            Some(quick.x)
        });
        let [a, b, start] = [0, 1, 2].map(|i| f64x8::from(of.map(|numbers| numbers[i])));
        let mut equation = |s: f64x8, x: f64x8| Sample {
            value: s * (a * x + b * x * x * x),
            slope: s * (a + f64x8::splat(3.0) * b * x * x),
            argument_rounding: f64x8::ZERO,
            value_rounding: f64x8::ZERO,
        };
        let first = equation(f64x8::ONE, start);
        let mut pair =
            two_corrections::<f64x8, true>(f64x8::ONE, start, start, first, &mut equation);
        let Some(lanes) = pair.corrected_again(start, &mut equation) else { continue };
        for (k, third) in thirds.into_iter().enumerate() {
            let [a, b, start] = of[k];
            let alone = third.or_else(|| Some(Newton::ordinary(start, cubic(a, b))?.x));
            let found = lanes.x.to_array()[k];
            assert_eq!(Some(found.to_bits()), alone.map(f64::to_bits), "{a} {b} {start}");
        }
        taken[0] += 1;
    }
    println!("{taken:?}: in all lanes, and by evaluations");
    assert!(taken[0] > 500 && taken[3] > 5000, "{taken:?}");
}

#[test]
fn stiff_and_steep_equations_are_solved_to_rounding() {
    for (a, b, start) in
        [(1e6, 0.0, 3.0), (5.0, 1e8, -2.0), (-0.5, 1e3, 1e-9), (0.0, 1.0, 1e6), (2.0, 3.0, 0.0)]
    {
        let f64_root = Newton.solve(0, start, cubic(a, b)).unwrap().x;
        let root = Newton.solve(0, Quad::from_f64(start), cubic(a, b)).unwrap().x;
        let value = root + cubic(a, b)(Quad::ONE, root).value;
        assert!((value.to_f64() - start).abs() <= 1e-28 * start.abs(), "{a} {b} {start}");
        assert!((f64_root - root.to_f64()).abs() <= 4e-16 * root.to_f64().abs(), "{a} {b} {start}");
    }
}

#[test]
fn the_solution_taken_is_the_one_that_leads_back_to_the_start() {
    // Three solutions: about -10, -0.1 and 10.1; only the last is reached from s = 0 with a rising
    // slope.
    let root = Newton.solve(0, 1.0, cubic(-11.0, 0.1)).unwrap();
    assert!((root.x - 10.05).abs() < 0.1, "{root:?}");
}

/// The double well V = q⁴/4 - q²/2 and a step h s from (q, p).
fn double_well(h: f64, q: f64) -> impl FnMut(f64, f64) -> Sample<f64> {
    move |s, v| {
        let (h, pull) = (s * h, s * h / 2.0);
        let to = q + h * v;
        Sample {
            value: pull * ((q + to) * (q * q + to * to) / 4.0 - (q + to) / 2.0),
            slope: pull * h * ((q * q + 2.0 * q * to + 3.0 * to * to) / 4.0 - 0.5),
            argument_rounding: 0.0,
            value_rounding: 0.0,
        }
    }
}

/// The solution that continues from s = 0, as far as its slope stays positive.
fn continued(start: f64, mut equation: impl FnMut(f64, f64) -> Sample<f64>) -> Option<f64> {
    let (mut x, parts) = (start, 4000);
    for k in 1..=parts {
        let s = f64::from(k) / f64::from(parts);
        for _ in 0..4 {
            let f = equation(s, x);
            if 1.0 + f.slope < 1e-4 {
                return None;
            }
            x -= (x + f.value - start) / (1.0 + f.slope);
        }
    }
    Some(x)
}

/// The cases, roots that are not the one continued, roots where none is, failures where one is.
fn continuations(cases: u32) -> [u32; 4] {
    let mut seed = 1_u64;
    let mut random = |low: f64, high: f64| random(&mut seed, low, high);
    let mut counts = [cases, 0, 0, 0];
    for _ in 0..cases {
        let (q, p, h) = (random(-2.0, 2.0), random(-2.0, 2.0), random(0.5, 5.0));
        let found = Newton.solve(0, p, double_well(h, q));
        match (continued(p, double_well(h, q)), found) {
            (Some(x), Ok(root)) => counts[1] += u32::from((root.x - x).abs() > 1e-6),
            (None, Ok(_)) => counts[2] += 1,
            (Some(_), Err(_)) => counts[3] += 1,
            (None, Err(_)) => {}
        }
    }
    counts
}

#[test]
fn no_pair_of_folds_is_jumped_over() {
    let (h, q, p) = (3.2959, -0.97049, 0.60874);
    let root = Newton.solve(0, p, double_well(h, q)).unwrap();
    assert!((2.0 * root.x - p + 0.34649).abs() < 1e-4, "{root:?}");
    let [cases, wrong, lost, failed] = continuations(2000);
    println!("{cases} {wrong} {lost} {failed}");
    // Slopes seen at points are no proof.
    assert!(wrong <= 2 && lost <= 4 && failed <= 1, "{cases}: {wrong} {lost} {failed}");
}

#[test]
fn slow_convergence_is_no_noise() {
    // V = q²/2, D = 1.4 p of which the slope is not known, h = 1, from q = 1 and p = 1e-3.
    for value_rounding in [0.0, 1e8] {
        let root = Newton.solve(0, 1e-3, |s: f64, v: f64| Sample {
            value: s * 0.5 * (1.0 + s * v / 2.0 + 1.4 * v),
            slope: s * s * 0.25,
            argument_rounding: s * 0.5,
            value_rounding: value_rounding * s * 0.5,
        });
        let exact = (1e-3 - 0.5) / 1.95;
        assert!((root.unwrap().x - exact).abs() < 4e-16, "{value_rounding}: {root:?} {exact}");
    }
}

#[test]
fn what_has_decayed_below_the_normal_numbers_is_solved() {
    // q'' = -q - 2 q' near rest, h = 0.05, from where q e^t = p e^t = 1.
    let mut seed = 1_u64;
    for _ in 0..2000 {
        let size = 10_f64.powf(random(&mut seed, -323.0, -300.0));
        let [q, p] = [1.0, -0.9].map(|x| x * size * random(&mut seed, 0.5, 1.0));
        let root = Newton.solve(0, p, |s: f64, v: f64| {
            let (h, pull) = (s * 0.05, s * 0.025);
            let to = h.mul_add(v, q);
            let slope = pull * (h * 0.5 + 2.0);
            Sample {
                value: pull * ((q + to) * 0.5 + 2.0 * v),
                slope,
                argument_rounding: pull * 0.5 * q.abs(),
                value_rounding: 0.0,
            }
        });
        let exact = (p - 0.025 * q) / (1.0 + 0.025 * 2.025);
        assert!(
            (root.unwrap().x - exact).abs() <= 1e-15 * exact.abs() + 1e-322,
            "{q:e} {p:e} {root:?}"
        );
    }
}

#[test]
fn a_slope_that_is_not_the_derivative_leads_to_the_solution() {
    // Corrections alone grow by the factor 3.
    let root = Newton.solve(0, 1.0, |s: f64, x: f64| Sample {
        value: s * 3.0 * x,
        slope: 0.0,
        argument_rounding: 0.0,
        value_rounding: 0.0,
    });
    assert!(root.is_ok_and(|root| (root.x - 0.25).abs() < 1e-16 && root.evaluations < 30));
}

#[test]
fn a_lost_solution_is_a_failure() {
    // x + s (x² - 4x + 6) = 0 has two solutions, which meet at s = (√6 - 2)/4, and none beyond.
    let failure = Newton
        .solve(1, 0.0, |s: f64, x: f64| Sample {
            value: s * (x * x - 4.0 * x + 6.0),
            slope: s * (2.0 * x - 4.0),
            argument_rounding: 0.0,
            value_rounding: 0.0,
        })
        .unwrap_err();
    let StepFailure::SeveralSolutions { dof: 1, share } = failure else { panic!("{failure}") };
    assert!((share - (6_f64.sqrt() - 2.0) / 4.0).abs() < 1e-5, "{share}");
}

#[test]
fn a_fork_is_a_failure() {
    // x + s (x³ - 2 x) = 0 has the solution 0, where the slope is 1 - 2 s, and ±√(2 - 1/s) beside
    // it from s = 1/2 on.
    let failure = Newton.solve(0, 0.0, cubic(-2.0, 1.0)).unwrap_err();
    let StepFailure::SeveralSolutions { dof: 0, share } = failure else { panic!("{failure}") };
    assert!(share > 0.49, "{share}");
    // x (1 - s) = 0 has no other solution, and at s = 1 any.
    let failure = Newton.solve(0, 0.0, cubic(-1.0, 0.0)).unwrap_err();
    assert!(matches!(failure, StepFailure::NewtonStalled { .. }), "{failure}");
}

/// Eight equations of the double well, with the lane as the last number.
fn double_wells(h: [f64; 8], q: [f64; 8]) -> impl FnMut(f64x8, f64x8) -> Sample<f64x8> {
    move |s, v| {
        let (s, v) = (s.to_array(), v.to_array());
        let f: [Sample<f64>; 8] = std::array::from_fn(|k| double_well(h[k], q[k])(s[k], v[k]));
        let each = |of: fn(&Sample<f64>) -> f64| f64x8::new(f.each_ref().map(of));
        Sample {
            value: each(|f| f.value),
            slope: each(|f| f.slope),
            argument_rounding: each(|f| f.argument_rounding),
            value_rounding: each(|f| f.value_rounding),
        }
    }
}

#[test]
fn side_by_side_each_has_what_it_has_alone() {
    let (mut seed, mut followed, mut failed) = (7_u64, 0, 0);
    for _ in 0..4000 {
        let mut eight = |low: f64, high: f64| [(); 8].map(|()| random(&mut seed, low, high));
        let (mut q, mut p, h) =
            (eight(-2.0, 2.0), eight(-2.0, 2.0), eight(-2.0, 0.3).map(|x| 10_f64.powf(x)));
        // One is at rest, one almost.
        (q[0], p[0], q[1], p[1]) = (0.0, 0.0, 1.0 + 1e-16 * q[1], 1e-200 * p[1]);
        let alone: [_; 8] = std::array::from_fn(|k| Newton.solve(0, p[k], double_well(h[k], q[k])));
        let direct = |k: usize| Newton::direct(p[k], double_well(h[k], q[k])).is_some();
        match Newton.solve(0, f64x8::new(p), double_wells(h, q)) {
            Ok(root) => {
                for (x, alone) in root.x.to_array().iter().zip(&alone) {
                    let alone = alone.as_ref().unwrap();
                    assert_eq!(x.to_bits(), alone.x.to_bits(), "{q:?} {p:?} {h:?}");
                    assert!(root.evaluations >= alone.evaluations);
                }
                followed += u32::from(!(0..8).all(direct));
            }
            Err(_) => {
                assert!(alone.iter().any(Result::is_err), "{q:?} {p:?} {h:?}");
                failed += 1;
            }
        }
    }
    println!("{followed} followed, {failed} failed");
    assert!(followed > 1000 && failed > 10, "{followed} {failed}");
}

#[test]
fn side_by_side_all_fail_where_one_is_lost() {
    let folded = |s: f64x8, x: f64x8| {
        let fold = f64x8::new([0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        let [two, four, six] = [2.0, 4.0, 6.0].map(f64x8::splat);
        Sample {
            value: s * fold * (x * x - four * x + six),
            slope: s * fold * (two * x - four),
            argument_rounding: x,
            value_rounding: x,
        }
    };
    let failure = Newton.solve(0, f64x8::splat(0.0), folded).unwrap_err();
    assert!(matches!(failure, StepFailure::NewtonStalled { .. }), "{failure}");
}
