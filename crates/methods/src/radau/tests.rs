//! Steps of fixed length, whatever their error. Systems are type-erased, so that each engine is
//! compiled once.

use super::share::Allowed;
use super::{Engine, Tables};
use afterbay_core::taylor::trajectory;
use afterbay_core::{
    Effort, Quad, Scalar, SecondDerivatives, Series, State, System, Tolerance, Vector,
};
use afterbay_systems::{DampedDoublePendulum, DampedOscillator, FputChain, VanDerPolRing};

/// A system with second derivatives.
type Curved<T> = dyn SecondDerivatives<T>;

/// Errors of the iteration below the rounding of `Quad`, and a projection as large as necessary.
const TIGHT: f64 = 1e-29;
const LOOSE: f64 = 1e30;

fn allowed(share: f64) -> Allowed {
    Allowed { scales: [1.0; 3], free: 1, share, relative: [1.0; 3], rounding: 1e-30 }
}

impl<V: Vector, const S: usize> Engine<V, S> {
    /// Takes a step, without control of its error.
    fn take(
        &mut self,
        system: &Curved<V::Scalar>,
        h: V::Scalar,
        state: &mut State<V>,
        solved: f64,
    ) -> Effort {
        self.begin(system, state);
        let shift = self.kept_h.map(|kept| [V::Scalar::one(), h / kept]);
        let mut effort = Effort::default();
        self.solve(system, h, state, allowed(solved), shift, &mut effort).unwrap();
        self.estimate(h, allowed(LOOSE), true);
        assert_eq!(self.balance(system, state, allowed(LOOSE), 0.0), Ok(None));
        self.accept(state);
        effort
    }
}

fn far(a: &[Quad], b: &[Quad]) -> f64 {
    a.iter().zip(b).map(|(&a, &b)| (a - b).to_f64().abs()).fold(0.0, f64::max)
}

/// The largest errors of q, p and w at t = 1 after `count` steps from several states, and of K in
/// one of them. The leading error term may vanish at one state.
fn errors<const S: usize>(
    system: &Curved<Quad>,
    series: &dyn System<Series<Quad, 24>>,
    count: u32,
) -> [f64; 4] {
    const STARTS: [[[f64; 2]; 2]; 3] =
        [[[0.6, -0.4], [0.3, 0.5]], [[0.5, -0.3], [0.2, 0.7]], [[1.0, 0.5], [0.2, -0.7]]];
    let tables = Tables::<Quad, S>::new();
    let h = Quad::from_f64(f64::from(count)).recip();
    let mut squares = [0.0; 4];
    for start in STARTS {
        let [q, p] = start.map(|x| x.map(Quad::from_f64).to_vec());
        let mut state = State::new(q, p).unwrap();
        let exact = trajectory::<_, _, 24>(series, &state, Quad::ONE, 1).unwrap().pop().unwrap();
        let tolerance = Tolerance::all(1e-20);
        let mut engine = Engine::<Vec<Quad>, S>::new(system, &tables, &tolerance, 1.0).unwrap();
        let k = state.total(system);
        for _ in 0..count {
            engine.take(system, h, &mut state, TIGHT);
        }
        let drift = (state.total(system) - k).abs().to_f64();
        let found =
            [far(&state.q, &exact.q), far(&state.p, &exact.p), far(&state.w, &exact.w), drift];
        for (square, error) in squares.iter_mut().zip(found) {
            *square += error * error;
        }
    }
    squares.map(f64::sqrt)
}

/// Slopes of the logarithms of the errors, by least squares.
fn check_orders<const S: usize>(
    name: &str,
    system: &Curved<Quad>,
    series: &dyn System<Series<Quad, 24>>,
    counts: &[u32],
) {
    let errors: Vec<[f64; 4]> =
        counts.iter().map(|&count| errors::<S>(system, series, count)).collect();
    let x: Vec<f64> = counts.iter().map(|&count| -f64::from(count).ln()).collect();
    let mean = |y: &[f64]| y.iter().sum::<f64>() / y.len() as f64;
    let slopes = [0, 1, 2].map(|part| {
        let y: Vec<f64> = errors.iter().map(|errors| errors[part].ln()).collect();
        let (mx, my) = (mean(&x), mean(&y));
        let product: f64 = x.iter().zip(&y).map(|(x, y)| (x - mx) * (y - my)).sum();
        product / x.iter().map(|x| (x - mx).powi(2)).sum::<f64>()
    });
    println!("{name}, {S} stages: {slopes:.3?} from {errors:?}");
    let order = (2 * S - 1) as f64;
    for slope in slopes {
        assert!((slope - order).abs() < 0.1, "{name}: {slopes:?}");
    }
    for errors in errors {
        assert!(errors[3] < 1e-28, "{name}: K by {:e}", errors[3]);
    }
}

/// A chain, and a double pendulum, which is not separable: coupled, nonlinear and damped.
fn chain() -> FputChain<Quad> {
    FputChain::new(2, 1.0, 0.25).unwrap().map(Quad::from_f64)
}

fn pendulum() -> DampedDoublePendulum<Quad> {
    let pendulum = DampedDoublePendulum::new([1.0, 0.75], [1.0, 0.5], 1.0, [0.125, 0.25]);
    pendulum.unwrap().map(Quad::from_f64)
}

#[test]
fn three_stages_have_order_5() {
    let (chain, pendulum) = (chain(), pendulum());
    let ring = VanDerPolRing::new(2, 0.5, 0.25).unwrap().map(Quad::from_f64);
    check_orders::<3>("chain", &chain, &chain.map(Series::constant), &[40, 80, 160]);
    check_orders::<3>("pendulum", &pendulum, &pendulum.map(Series::constant), &[80, 160, 320]);
    check_orders::<3>("ring", &ring, &ring.map(Series::constant), &[40, 80, 160]);
}

#[test]
fn five_stages_have_order_9() {
    let (chain, pendulum) = (chain(), pendulum());
    check_orders::<5>("chain", &chain, &chain.map(Series::constant), &[20, 40, 80]);
    check_orders::<5>("pendulum", &pendulum, &pendulum.map(Series::constant), &[240, 320, 400]);
}

/// With more friction than above, so that the leading error term of w is not small beside the next.
/// The double pendulum reaches the rounding of 31 digits before its errors are asymptotic.
#[test]
fn seven_stages_have_order_13() {
    let chain = FputChain::new(2, 1.0, 1.0).unwrap().map(Quad::from_f64);
    check_orders::<7>("chain", &chain, &chain.map(Series::constant), &[20, 25, 32, 40]);
}

/// The energy that a decay of b h = 20 dissipates within one step, by w and by the weights alone.
/// The exact value and the share of the weights are those of the oscillator with b = 200 from (1,
/// 1).
#[test]
fn w_takes_the_dissipation_that_the_weights_miss() {
    let system = DampedOscillator::new(1.0, 200.0).unwrap();
    let tables = Tables::<Quad, 3>::new();
    let mut engine =
        Engine::<Vec<f64>, 3>::new(&system, &tables, &Tolerance::all(1e-2), 1.0).unwrap();
    let mut state = State::new(vec![1.0], vec![1.0]).unwrap();
    let k = state.total(&system);
    engine.take(&system, 0.1, &mut state, 1e-15);
    let weights: f64 =
        (0..3).map(|i| 0.1 * engine.tables.weights[i] * engine.kept.loss[i][0]).sum();
    println!("w = {:.4}, by the weights {weights:.4}", state.w[0]);
    assert!((state.w[0] - 0.4955).abs() < 2e-3 && (state.total(&system) - k).abs() < 1e-15);
    assert!((weights - 0.283).abs() < 2e-3);
    // The projection would give the rest back to (q, p): 0.65 in p.
    assert!(state.p[0].abs() < 0.1, "{state:?}");
}

/// On oscillations without friction nothing is dissipated: (q, p) is projected, and w stays.
#[test]
fn numerical_damping_is_not_dissipation() {
    let tables = Tables::<Quad, 3>::new();
    for b in [0.0, 1e-9] {
        let system = DampedOscillator::new(1.0, b).unwrap();
        let mut engine =
            Engine::<Vec<f64>, 3>::new(&system, &tables, &Tolerance::all(1e-2), 1.0).unwrap();
        let mut state = State::new(vec![1.0], vec![0.0]).unwrap();
        for _ in 0..100 {
            engine.take(&system, 0.9, &mut state, 1e-15);
        }
        assert!((state.energy(&system) - 0.5).abs() < 1e-6, "{b}: {state:?}");
        assert!(state.w[0].abs() <= 100.0 * b, "{b}: {state:?}");
    }
}

/// The first correction solves linear equations, and the second shows it. A wrong matrix still
/// converges, but more slowly.
#[test]
fn a_linear_step_takes_two_corrections() {
    fn corrections<const S: usize>(beta: f64) -> u64 {
        let system = FputChain::new(3, beta, 0.5).unwrap();
        let tables = Tables::<Quad, S>::new();
        let mut engine =
            Engine::<Vec<f64>, S>::new(&system, &tables, &Tolerance::all(1e-2), 1.0).unwrap();
        let mut state = State::new(vec![0.6, -0.4, 0.2], vec![0.3, 0.5, -0.1]).unwrap();
        engine.take(&system, 0.25, &mut state, 1e-12).iterations
    }
    for corrections in [corrections::<3>, corrections::<5>, corrections::<7>] {
        assert_eq!(corrections(0.0), 2);
        assert!(corrections(1.0) > 2);
    }
}
