//! Friction that couples the momenta, D = C(q) p: orders, K, passivity in sum, refusals.

use crate::bind::{AnySeparable, after, by_force};
use crate::many::orders::orders_at_end;
use crate::many::{exact_end, start};
use afterbay_core::{
    Dissipation, DissipationForm, InputError, Method, Passive, Scalar, Separable, State,
    StepFailure, System, integrate,
};
use afterbay_methods::registry::find;
use afterbay_methods::{Composition, Increment, Leapfrog, Splitting};
use allocation_counter::measure;
use proptest::prelude::*;

/// A chain with fixed ends, H = Σ p_j²/(2 m_j) + Σ q_j²/2 + Σ r²/2 + r⁴/4, and D = S R S ∂H/∂p with
/// S = diag(1 + s q_j²).
#[derive(Clone, Debug)]
struct Chain {
    masses: Vec<f64>,
    /// R = ± G Gᵀ
    friction: Vec<Vec<f64>>,
    /// s
    swell: f64,
    damping: DissipationForm,
}

const PASSIVE: DissipationForm =
    DissipationForm { zero: false, passive: Passive::InSum, linear: true, coupled: true };

const UNCOUPLED: DissipationForm = DissipationForm { coupled: false, ..PASSIVE };

impl Chain {
    fn new(masses: Vec<f64>, shape: &[Vec<f64>], swell: f64) -> Self {
        let row = |a: &Vec<f64>| {
            shape.iter().map(|b| a.iter().zip(b).map(|(a, b)| a * b).sum()).collect()
        };
        Self { masses, friction: shape.iter().map(row).collect(), swell, damping: PASSIVE }
    }

    fn resistance<T: Scalar>(&self, q: &[T], i: usize, j: usize) -> T {
        let swollen = |j: usize| (T::from_f64(self.swell) * q[j]).mul_add(q[j], T::one());
        T::from_f64(self.friction[i][j]) * swollen(i) * swollen(j)
    }

    /// The largest Σ |q| |∂V/∂q| of the springs between `a` and `b`: a rounding of q changes V by ε
    /// times this, which exceeds ε V where q is large and the springs are short.
    fn strain(a: &[f64], b: &[f64]) -> f64 {
        let ends = |j: Option<usize>| j.map_or([0.0; 2], |j| [a[j], b[j]]);
        let spring = |j: usize| {
            let (from, to) = (ends(j.checked_sub(1)), ends(Some(j)));
            let longest = |x: &[f64]| x.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
            let r = longest(&[to[0] - from[0], to[0] - from[1], to[1] - from[0], to[1] - from[1]]);
            (longest(&from) + longest(&to)) * (r + r.powi(3))
        };
        (0..a.len()).map(spring).sum()
    }

    /// The largest Σ |R_ij| |v_i| |v_j| if each p_j²/(2 m_j) and q_j²/2 is at most `most`.
    fn power(&self, most: f64) -> f64 {
        let n = self.masses.len();
        let swollen = (1.0 + self.swell * 2.0 * most).powi(2);
        let speed = |j: usize| (2.0 * most / self.masses[j]).sqrt();
        let pairs = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
        pairs.map(|(i, j)| self.friction[i][j].abs() * swollen * speed(i) * speed(j)).sum()
    }
}

impl<T: Scalar> System<T> for Chain {
    fn dof(&self) -> usize {
        self.masses.len()
    }
    fn energy(&self, q: &[T], p: &[T]) -> T {
        let n = q.len();
        let own = |j: usize| (p[j] * p[j] / T::from_f64(self.masses[j]) + q[j] * q[j]).half();
        let spring = |j: usize| {
            let r = if j == 0 { q[0] } else { q[j] - q[j - 1] };
            (r * r).half() * ((r * r).half() + T::one())
        };
        (0..n).fold(T::zero(), |sum, j| sum + own(j) + spring(j))
    }
    fn gradient(&self, q: &[T], p: &[T], hq: &mut [T], hp: &mut [T]) {
        for j in 0..q.len() {
            (hq[j], hp[j]) = (self.partial(q, j, q[j]), p[j] / T::from_f64(self.masses[j]));
        }
    }
    fn dissipation(&self, q: &[T], _p: &[T], v: &[T], d: &mut [T]) {
        for (i, d) in d.iter_mut().enumerate() {
            *d = (0..q.len()).fold(T::zero(), |sum, j| self.resistance(q, i, j).mul_add(v[j], sum));
        }
    }
    fn dissipation_form(&self) -> DissipationForm {
        self.damping
    }
}

impl<T: Scalar> Separable<T> for Chain {
    fn mass(&self, j: usize) -> T {
        T::from_f64(self.masses[j])
    }
    fn partial(&self, q: &[T], j: usize, at: T) -> T {
        let pull = |r: T| r * (r * r + T::one());
        let left = pull(if j == 0 { at } else { at - q[j - 1] });
        let right = q.get(j + 1).map_or(T::zero(), |&next| pull(at - next));
        at + left + right
    }
    fn dissipation_of(&self, q: &[T], p: &[T], j: usize) -> Dissipation<T> {
        let of = |k: usize| self.resistance(q, j, k) / T::from_f64(self.masses[k]);
        let value = (0..q.len()).fold(T::zero(), |sum, k| of(k).mul_add(p[k], sum));
        Dissipation { value, by_q: T::zero(), by_p: of(j) }
    }
}

fn four(swell: f64) -> Chain {
    let shape = [[0.5, -0.4, 0.1], [0.3, 0.6, -0.5], [-0.4, 0.2, 0.7], [0.6, -0.3, 0.2]];
    Chain::new(vec![1.0, 1.7, 0.6, 1.2], &shape.map(Vec::from), swell)
}

fn begin() -> State<Vec<f64>> {
    start([&[0.8, -0.3, 0.5, -0.6], &[0.2, 0.9, -0.7, 0.5]])
}

/// The orders of q, p and w at t = 1.
fn orders(system: &Chain, method: &Increment, counts: &[u64]) -> [f64; 3] {
    orders_at_end(&exact_end(system, &begin(), 1.0), counts, &mut |grid| {
        let mut state = begin();
        integrate::<_, AnySeparable<f64>, _, _>(method, system, grid, &mut state, &mut ()).unwrap();
        state
    })
}

#[test]
fn compositions_keep_their_order() {
    for swell in [0.0, 0.4] {
        for (composition, order, counts) in [
            (Composition::sweep(), 1.0, [1000, 2000, 4000]),
            (Composition::pair(), 2.0, [200, 400, 800]),
            (Composition::suzuki4(), 4.0, [60, 84, 120]),
            (Composition::blanes_moan4(), 4.0, [40, 56, 80]),
            (Composition::yoshida6(), 6.0, [24, 32, 40]),
        ] {
            let natural = Increment::new(composition);
            for method in [natural.clone(), natural.in_order(vec![2, 0, 3, 1])] {
                let found = orders(&four(swell), &method, &counts);
                println!("{order} {swell} {found:.3?}");
                assert!(
                    found.iter().all(|found| (found - order).abs() < 0.1),
                    "{method:?}: {found:?}"
                );
            }
        }
    }
}

#[test]
fn an_explicit_method_needs_nothing() {
    let (run, begin) = (by_force(find("rk4").unwrap(), four(0.4)).unwrap(), begin());
    let exact = exact_end(&four(0.4), &begin, 1.0);
    let found = orders_at_end(&exact, &[60, 84, 120], &mut |grid| after(&run, grid, &begin));
    assert!(found.iter().all(|found| (found - 4.0).abs() < 0.1), "{found:?}");
}

/// A chain of up to 10 masses whose R has any rank, in a state, a step size, and an order of the
/// coordinates.
fn chains() -> impl Strategy<Value = (Chain, State<Vec<f64>>, f64, Vec<usize>)> {
    (1..=10_usize).prop_flat_map(|n| (Just(n), 1..=n, -5.0..1.0_f64)).prop_flat_map(
        |(n, rank, exponent)| {
            let shape = prop::collection::vec(prop::collection::vec(-1.0..1.0, rank), n);
            let chain =
                (prop::collection::vec(0.1..10.0, n), shape, prop_oneof![Just(0.0), 0.0..1.0])
                    .prop_map(|(masses, shape, swell)| Chain::new(masses, &shape, swell));
            let part = || prop::collection::vec(-2.0..2.0, n);
            let state = (part(), part()).prop_map(|(q, p)| State::new(q, p).unwrap());
            let order = Just((0..n).collect::<Vec<_>>()).prop_shuffle();
            (chain, state, Just(10.0_f64.powf(exponent)), order)
        },
    )
}

fn step(
    method: &Increment,
    chain: &Chain,
    h: f64,
    state: &mut State<Vec<f64>>,
) -> Result<(), StepFailure> {
    let chain: &dyn Separable<f64> = chain;
    let mut workspace = method.workspace(chain).unwrap();
    method.step(chain, h, state, &mut workspace).map(|_| ())
}

/// K, with w summed first, so that its rounding error is not larger than that of H.
fn total(chain: &Chain, state: &State<Vec<f64>>) -> f64 {
    state.energy(chain) + state.w.iter().sum::<f64>()
}

proptest! {
    #![proptest_config(ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::with_cases(300)
    })]

    /// If friction is passive and V ≥ 0, every energy during a sweep is at most H at one of its
    /// ends.
    #[test]
    fn k_is_kept_by_every_sweep((chain, start, h, order) in chains()) {
        let s = 1.0 / (4.0 - 4.0_f64.cbrt());
        let suzuki = [s, s, 1.0 - 4.0 * s, s, s].map(|weight| [weight / 2.0; 2]).concat();
        let back: Vec<usize> = order.iter().rev().copied().collect();
        for composition in [vec![0.5, 0.5], suzuki] {
            let sweeps = Composition::alternating(&composition).unwrap();
            let method = Increment::new(sweeps).in_order(order.clone());
            let (mut by_sweeps, mut at_once) = (start.clone(), start.clone());
            let outcome = step(&method, &chain, h, &mut at_once);
            for (i, fraction) in composition.iter().enumerate() {
                let order = if i % 2 == 0 { &order } else { &back };
                let sweep = Increment::new(Composition::sweep()).in_order(order.clone());
                let before = by_sweeps.clone();
                if let Err(failure) = step(&sweep, &chain, fraction * h, &mut by_sweeps) {
                    prop_assert_eq!(&before, &by_sweeps, "a failed step changes nothing");
                    prop_assert_eq!(outcome, Err(failure));
                    prop_assert_eq!(&start, &at_once, "a failed step changes nothing");
                    return Ok(());
                }
                let most = before.energy(&chain).max(by_sweeps.energy(&chain));
                let held: f64 = before.w.iter().chain(&by_sweeps.w).map(|w| w.abs()).sum();
                // Each coordinate changes K by up to 16 roundings of its own terms, as in
                // `increment`, and sums of n terms in D and K add n roundings.
                let work = (fraction * h).abs() * chain.power(most);
                let strain = Chain::strain(&before.q, &by_sweeps.q);
                let roundings = (16.0 + order.len() as f64) * f64::EPSILON / 2.0;
                let bound = roundings * (2.0 * most + strain + held + work);
                let drift = (total(&chain, &by_sweeps) - total(&chain, &before)).abs();
                let share = drift / bound;
                prop_assert!(
                    drift <= bound,
                    "sweep {i}: K moves by {drift:e}, {share:.1} of the bound"
                );
            }
            prop_assert_eq!(outcome, Ok(()));
            prop_assert_eq!(&by_sweeps, &at_once, "a composition is its sweeps");
        }
    }

    /// Σ D̄_j p̄_j/m_j = v̄ᵀ R v̄ for any rounding of p̄. Each of its terms, including the entries
    /// of R, has fewer than 2 n + 8 roundings, and a pair consists of two sweeps of h/2 with two
    /// passes of h/4 each.
    #[test]
    fn the_reservoirs_fill_in_sum((chain, start, h, order) in chains()) {
        for composition in [Composition::sweep(), Composition::pair()] {
            let method = Increment::new(composition).in_order(order.clone());
            let mut state = start.clone();
            if step(&method, &chain, h, &mut state).is_ok() {
                let terms = h * chain.power(start.energy(&chain));
                let bound = (2.0 * order.len() as f64 + 8.0) * f64::EPSILON / 2.0 * terms;
                let gain: f64 = state.w.iter().sum();
                prop_assert!(gain >= -bound, "{gain:e}, {:.1} of the bound", gain / bound);
            }
        }
    }
}

#[test]
fn a_reservoir_alone_may_be_drained() {
    // v1 exerts on 2 the force that it loses: R = (1, -1)ᵀ (1, -1).
    let chain = Chain::new(vec![1.0, 1.0], &[vec![1.0], vec![-1.0]], 0.0);
    let mut state = State::new(vec![0.0, 0.0], vec![1.0, 0.2]).unwrap();
    step(&Increment::new(Composition::pair()), &chain, 0.1, &mut state).unwrap();
    assert!(state.w[0] > 0.0 && state.w[1] < 0.0 && state.w[0] + state.w[1] > 0.0, "{:?}", state.w);
}

fn refusal<M>(method: &M, chain: &Chain) -> Result<(), InputError>
where
    M: Method<Vec<f64>, AnySeparable<f64>>,
{
    method.workspace(chain).map(drop)
}

#[test]
fn what_is_coupled_and_not_linear_is_refused() {
    let chain = Chain { damping: DissipationForm { linear: false, ..PASSIVE }, ..four(0.0) };
    for composition in [Composition::sweep(), Composition::pair(), Composition::kahan_li8()] {
        match refusal(&Increment::new(composition), &chain) {
            Err(error @ InputError::Unsupported { method: "increment", .. }) => {
                let message = error.to_string();
                assert!(
                    message.contains("not linear") && message.contains("gonzalez"),
                    "{message}"
                );
            }
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn too_many_momenta_with_a_skew_part_are_refused() {
    let n = 513;
    let row = |j: usize| (0..n).map(|k| if k == j + 1 { 0.1 } else { 0.0 }).collect();
    let friction = (0..n).map(row).collect();
    let chain = Chain { masses: vec![1.0; n], friction, swell: 0.0, damping: PASSIVE };
    match refusal(&Increment::new(Composition::pair()), &chain) {
        Err(error @ InputError::Unsupported { method: "increment", .. }) => {
            let message = error.to_string();
            assert!(message.contains("not symmetric") && message.contains("gonzalez"), "{message}");
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn leapfrog_refuses_coupled_friction() {
    match refusal(&Leapfrog, &four(0.0)) {
        Err(error @ InputError::Unsupported { method: "leapfrog", .. }) => {
            assert!(error.to_string().contains("couples the momenta"), "{error}");
        }
        other => panic!("{other:?}"),
    }
    let diagonal = [[0.5, 0.0], [0.0, 0.3]].map(Vec::from);
    let uncoupled = Chain { damping: UNCOUPLED, ..Chain::new(vec![1.0; 2], &diagonal, 0.0) };
    assert_eq!(refusal(&Leapfrog, &uncoupled), Ok(()));
}

#[test]
fn methods_taken_by_their_type_refuse_a_friction_that_hides_its_coupling() {
    let chain = Chain { damping: UNCOUPLED, ..four(0.0) };
    let splitting = Splitting::new(Composition::blanes_moan4()).unwrap();
    for refused in [
        refusal(&Leapfrog, &chain),
        refusal(&splitting, &chain),
        refusal(&Increment::new(Composition::pair()), &chain),
    ] {
        match refused {
            Err(error @ InputError::Unsupported { .. }) => {
                assert!(error.to_string().contains("set `coupled`"), "{error}");
            }
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn a_singular_equation_is_named_and_leaves_the_state_alone() {
    // 1 + h/8 C22 = 0 in the first pass of a pair, after the first momentum has moved.
    let mut chain = Chain::new(vec![1.0, 1.0], &[vec![1.0], vec![1.0]], 0.0);
    chain.friction[1][1] = -16.0;
    chain.damping.passive = Passive::No;
    let start = State::new(vec![0.3, -0.2], vec![1.0, 0.2]).unwrap();
    let mut state = start.clone();
    let failure = step(&Increment::new(Composition::pair()), &chain, 0.5, &mut state).unwrap_err();
    assert_eq!(failure, StepFailure::Singular { dof: 1, slope: Some(0.0) });
    assert_eq!(state, start);
}

#[test]
fn a_step_allocates_nothing() {
    let method = Increment::new(Composition::suzuki4());
    let (chain, mut state): (&dyn Separable<f64>, _) = (&four(0.4), begin());
    let mut workspace = method.workspace(chain).unwrap();
    let taken = measure(|| {
        for _ in 0..50 {
            method.step(chain, 0.1, &mut state, &mut workspace).unwrap();
        }
    });
    assert_eq!(taken.count_total, 0);
}
