//! Flows followed by series, compared with known solutions.

use super::*;
use crate::error::InputError;
use crate::numbers::{Interval, Quad, Scalar, Series};
use crate::run::Grid;
use crate::system::{State, System};

/// H = Σ (p_j² + q_j²)/2 + q1⁴/4 + (q1 - q2)²/2, D_j = c (1 + q_j²) v_j
struct Pair {
    c: f64,
}

impl<T: Scalar> System<T> for Pair {
    fn dof(&self) -> usize {
        2
    }
    fn energy(&self, q: &[T], p: &[T]) -> T {
        let (r, s) = (q[0] - q[1], q[0] * q[0]);
        (p[0] * p[0] + p[1] * p[1] + s + q[1] * q[1] + s * s.half() + r * r).half()
    }
    fn gradient(&self, q: &[T], p: &[T], hq: &mut [T], hp: &mut [T]) {
        let r = q[0] - q[1];
        (hq[0], hq[1]) = (q[0] + q[0] * q[0] * q[0] + r, q[1] - r);
        hp.copy_from_slice(p);
    }
    fn dissipation(&self, q: &[T], _p: &[T], v: &[T], d: &mut [T]) {
        (0..2).for_each(|j| d[j] = T::from_f64(self.c) * (T::one() + q[j] * q[j]) * v[j]);
    }
}

/// The errors of (q, p) and of w at the end of the reach, in roundings of the largest of
/// each, beside 48 terms in 31 digits. Those are good to 1e-31 there.
fn off<T: Scalar>(
    system: &Pair,
    [q, p]: [[f64; 2]; 2],
    back: bool,
    value: impl Fn(T) -> Quad,
) -> [f64; 2] {
    fn start<T: Scalar>(q: [f64; 2], p: [f64; 2]) -> State<[T; 2]> {
        State { q: q.map(T::from_f64), p: p.map(T::from_f64), w: [T::zero(); 2], t: T::zero() }
    }
    let short = Expansion::<[T; 2], 24>::about(system, &start(q, p));
    let tau = if back { -short.reach } else { short.reach };
    let found = short.at(T::from_f64(tau));
    let exact = Expansion::<[Quad; 2], 48>::about(system, &start(q, p)).at(Quad::from_f64(tau));
    let off = |found: &[T], exact: &[Quad]| {
        let most =
            |x: &mut dyn Iterator<Item = Quad>| x.map(|x| x.abs().to_f64()).fold(0.0, f64::max);
        let apart = most(&mut found.iter().zip(exact).map(|(&a, &b)| value(a) - b));
        apart / (T::EPSILON * most(&mut exact.iter().copied()))
    };
    [off(&[found.q, found.p].concat(), &[exact.q, exact.p].concat()), off(&found.w, &exact.w)]
}

#[test]
fn q_p_and_w_are_exact_to_rounding_at_the_end_of_the_reach() {
    let starts = [[[1.0, -0.5], [0.3, 0.8]], [[1.5, 0.2], [0.0; 2]], [[0.0; 2], [0.1, -2.0]]];
    for c in [0.01, 0.3, 5.0] {
        for from in starts {
            for back in [false, true] {
                let system = Pair { c };
                let found = [
                    off::<f64>(&system, from, back, Quad::from_f64),
                    off::<Quad>(&system, from, back, |x| x),
                ];
                println!("c = {c}, {from:?}: {found:.1?}");
                assert!(
                    found.iter().flatten().all(|&off| off < 16.0),
                    "{c} {from:?} {back}: {found:?}"
                );
            }
        }
    }
}

/// H = p²/2 + |q|: parabolas that meet at q = 0.
struct Roof;

impl<T: Scalar> System<T> for Roof {
    fn dof(&self) -> usize {
        1
    }
    fn energy(&self, q: &[T], p: &[T]) -> T {
        (p[0] * p[0]).half() + q[0].abs()
    }
    fn gradient(&self, q: &[T], p: &[T], hq: &mut [T], hp: &mut [T]) {
        hq[0] = T::select(q[0].lt(T::zero()), -T::one(), T::one());
        hp.copy_from_slice(p);
    }
    fn dissipation(&self, _q: &[T], _p: &[T], _v: &[T], d: &mut [T]) {
        d[0] = T::zero();
    }
    fn kinks(&self, q: &[T], _p: &[T], put: &mut dyn FnMut(T)) {
        put(q[0]);
    }
}

/// From (1, 0) to q = 0 in √2, and round in 4 √2, forward and back.
#[test]
fn a_force_that_jumps_is_followed_from_kink_to_kink() {
    let quarter = Quad::from_f64(2.0).sqrt();
    for h in [0.75, -0.75] {
        let start = State::new([Quad::from_f64(1.0)], [Quad::from_f64(0.0)]).unwrap();
        let states = trajectory::<_, _, 24>(&Roof, &start, Quad::from_f64(h), 40).unwrap();
        for (i, state) in states.iter().enumerate() {
            // The time since the last top or bottom, and which it was.
            let t = Quad::from_f64(i as f64 * 0.75);
            let half = ((t.to_f64() + quarter.to_f64()) / (2.0 * quarter.to_f64())).floor();
            let (side, t) = (1.0 - 2.0 * (half % 2.0), t - Quad::from_f64(2.0 * half) * quarter);
            let (q, p) = (Quad::from_f64(1.0) - (t * t).half(), -t * Quad::from_f64(h.signum()));
            let side = Quad::from_f64(side);
            let off = [state.q[0] - side * q, state.p[0] - side * p].map(|x| x.to_f64().abs());
            // At each kink the force, which jumps by 2, is that before it for up to two leaps.
            let elapsed = i as f64 * 0.75;
            let leap = 4.0 * <Quad as Scalar>::EPSILON * (0.75 + elapsed);
            let allowed = (1.0 + half) * 2.0 * 2.0 * leap * (1.0 + elapsed);
            assert!(off.iter().all(|&x| x < allowed), "{h} {i}: {off:?} {allowed:e}");
        }
    }
}

/// The end of a flow, with its defect enclosed.
fn enclosed<R, S>(ranges: R, system: &S, q: f64, p: f64, end: f64, pace: Pace) -> State<[Quad; 1]>
where
    R: System<Series<Interval, 24>>,
    S: System<Series<Quad, 24>>,
{
    let start = State::new([Quad::from_f64(q)], [Quad::from_f64(p)]).unwrap();
    let (defect, mut last) = (Enclosed::new(ranges), start.clone());
    let grid = Grid { h: Quad::from_f64(end), steps: 1 };
    follow(system, &defect, &start, grid, pace, &|| false, &mut |_, state| last = state).unwrap();
    last
}

/// H = p²/2 + f(q), D = g(p) p, each given with its slope by `f` and its value by `g`.
#[derive(Clone, Copy)]
enum Scene {
    /// V = q^n/n
    Power(u32),
    /// V = q²/2, D = 0.2 tanh(p/width)
    Rubbed(f64),
    /// V = q²/2 + 0.5 exp(-(q/width)²)
    Bump(f64),
}

impl Scene {
    fn slope<T: Scalar>(self, q: T) -> T {
        match self {
            Self::Power(n) => (1..n).fold(T::one(), |power, _| power * q),
            Self::Rubbed(_) => q,
            Self::Bump(width) => {
                let u = q / T::from_f64(width);
                q - u * (-(u * u)).exp() / T::from_f64(width)
            }
        }
    }
}

impl<T: Scalar> System<T> for Scene {
    fn dof(&self) -> usize {
        1
    }
    fn energy(&self, q: &[T], p: &[T]) -> T {
        let potential = match self {
            Self::Power(n) => self.slope(q[0]) * q[0] / T::from_f64(f64::from(*n)),
            Self::Rubbed(_) => (q[0] * q[0]).half(),
            Self::Bump(width) => {
                let u = q[0] / T::from_f64(*width);
                (q[0] * q[0]).half() + (-(u * u)).exp().half()
            }
        };
        (p[0] * p[0]).half() + potential
    }
    fn gradient(&self, q: &[T], p: &[T], hq: &mut [T], hp: &mut [T]) {
        hq[0] = self.slope(q[0]);
        hp.copy_from_slice(p);
    }
    fn dissipation(&self, _q: &[T], p: &[T], _v: &[T], d: &mut [T]) {
        d[0] = match self {
            Self::Rubbed(width) => {
                let u = p[0] / T::from_f64(*width);
                let e = (-(u.abs() + u.abs())).exp_m1();
                let tanh = -e / (e + T::from_f64(2.0));
                T::from_f64(0.2) * T::select(u.lt(T::zero()), -tanh, tanh)
            }
            _ => T::zero(),
        };
    }
}

/// Runge-Kutta of order 4 with very many steps.
fn by_steps(scene: Scene, q: f64, p: f64, end: f64, steps: u32) -> [f64; 3] {
    let rate = |[q, p, _]: [f64; 3]| {
        let mut d = [0.0];
        System::<f64>::dissipation(&scene, &[q], &[p], &[p], &mut d);
        [p, -scene.slope(q) - d[0], d[0] * p]
    };
    let h = end / f64::from(steps);
    let go = |z: [f64; 3], k: [f64; 3], h: f64| std::array::from_fn(|i| z[i] + h * k[i]);
    (0..steps).fold([q, p, 0.0], |z, _| {
        let a = rate(z);
        let b = rate(go(z, a, h / 2.0));
        let c = rate(go(z, b, h / 2.0));
        let d = rate(go(z, c, h));
        std::array::from_fn(|i| z[i] + h / 6.0 * (a[i] + 2.0 * (b[i] + c[i]) + d[i]))
    })
}

/// From (0, 1) only every n-th power of t occurs in q; from n = 24 on none is among the
/// coefficients.
#[test]
fn series_with_gaps_end_where_they_do() {
    for n in [4, 6, 10, 12, 20, 23, 24, 25, 30, 40] {
        let scene = Scene::Power(n);
        let found = enclosed(scene, &scene, 0.0, 1.0, 2.0, Pace::FULL);
        let (energy, start) = (found.energy(&scene).to_f64(), 0.5);
        let [q, p, _] = by_steps(scene, 0.0, 1.0, 2.0, 20_000);
        let off = (found.q[0].to_f64() - q).abs().max((found.p[0].to_f64() - p).abs());
        println!("{n}: off by {off:e}, energy by {:e}", energy - start);
        assert!(off < 1e-9, "{n}: {off:e}");
        assert!((found.energy(&scene) - Quad::from_f64(0.5)).abs().to_f64() < 1e-28, "{n}");
    }
}

/// A feature narrower than a stride leaves no trace in the coefficients on either side.
#[test]
fn narrow_features_are_met() {
    let widths = [0.1, 0.01, 0.001];
    let scenes =
        widths.iter().flat_map(|&w| [(Scene::Rubbed(w), 2.0, 0.0), (Scene::Bump(w), 1.3, 0.2)]);
    for (scene, q, p) in scenes {
        let found = enclosed(scene, &scene, q, p, 4.0, Pace::FULL);
        let check = enclosed(scene, &scene, q, p, 4.0, Pace::CHECK);
        let [found, check] = [found, check].map(|state| [state.q[0], state.p[0], state.w[0]]);
        let steps = by_steps(scene, q, p, 4.0, 1_000_000);
        for i in 0..3 {
            assert!((found[i].to_f64() - steps[i]).abs() < 1e-7, "{i}: {found:?} {steps:?}");
            assert!((found[i] - check[i]).abs().to_f64() < 1e-24, "{i}: {found:?} {check:?}");
        }
    }
}

/// Samples resolve features that take at least a 48th of a stride.
#[test]
fn samples_tell_what_they_may_miss() {
    let scene = Scene::Bump(0.05);
    let start = State::new([Quad::from_f64(1.3)], [Quad::from_f64(0.2)]).unwrap();
    let (mut last, grid) = (start.clone(), Grid { h: Quad::from_f64(4.0), steps: 1 });
    let mut see = |_, state| last = state;
    let defect = Sampled(&scene);
    let route =
        follow::<_, _, 24>(&scene, &defect, &start, grid, Pace::FULL, &|| false, &mut see).unwrap();
    let exact = enclosed(scene, &scene, 1.3, 0.2, 4.0, Pace::FULL);
    assert!(route.unseen > 1e-5 && route.unseen < 0.02, "{route:?}");
    assert!((last.q[0] - exact.q[0]).abs().to_f64() < 1e-20);
}

#[test]
fn a_flow_ends_where_it_is_asked_to() {
    let (scene, asked) = (Scene::Power(4), std::cell::Cell::new(0));
    let start = State::new([Quad::from_f64(1.0)], [Quad::from_f64(0.0)]).unwrap();
    let stop = || {
        asked.set(asked.get() + 1);
        asked.get() > 3
    };
    let (grid, mut seen) = (Grid { h: Quad::from_f64(100.0), steps: 1 }, 0);
    let defect = Sampled(&scene);
    let follow = |pace, stop: &dyn Fn() -> bool, see: &mut dyn FnMut(u64, State<[Quad; 1]>)| {
        follow::<_, _, 24>(&scene, &defect, &start, grid, pace, stop, see)
    };
    let route = follow(Pace::FULL, &stop, &mut |_, _| seen += 1).unwrap();
    assert!(route.interrupted && route.strides == 3 && seen == 1, "{route:?}");
    let error = follow(Pace::FULL.within(20), &|| false, &mut |_, _| {}).unwrap_err();
    assert!(matches!(error, InputError::Budget { limit: 20.0, .. }), "{error}");
}
