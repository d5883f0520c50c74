//! Coordinate increments on nets of springs between all pairs: K, passivity, invariance under
//! renaming, and the advice of failures.

use afterbay_core::{
    Dissipation, DissipationForm, Effort, Line, Method, Passive, Separable, State, StepFailure,
    System,
};
use afterbay_methods::{Composition, Increment};
use proptest::prelude::*;

/// Springs between all pairs, a quartic well for each coordinate, masses, and damping of either
/// sign.
#[derive(Clone, Debug)]
struct Net {
    masses: Vec<f64>,
    wells: Vec<[f64; 2]>,
    springs: Vec<Vec<f64>>,
    friction: Vec<f64>,
}

impl Net {
    /// The same net with its coordinates renamed: the new j is the old `names[j]`.
    fn renamed(&self, names: &[usize]) -> Self {
        Self {
            masses: names.iter().map(|&i| self.masses[i]).collect(),
            wells: names.iter().map(|&i| self.wells[i]).collect(),
            springs: names
                .iter()
                .map(|&i| names.iter().map(|&j| self.springs[i][j]).collect())
                .collect(),
            friction: names.iter().map(|&i| self.friction[i]).collect(),
        }
    }

    /// The sum of all absolute terms of K, with each coordinate at its largest.
    fn magnitude(&self, before: &State<Vec<f64>>, after: &State<Vec<f64>>) -> f64 {
        let n = self.masses.len();
        let q = |j: usize| before.q[j].abs().max(after.q[j].abs());
        (0..n)
            .map(|j| {
                let kinetic = (before.p[j].powi(2) + after.p[j].powi(2)) / self.masses[j];
                let [a, b] = self.wells[j].map(f64::abs);
                let springs: f64 =
                    (0..n).map(|i| self.springs[i][j].abs() * (q(i) + q(j)).powi(2)).sum();
                let work = (after.w[j] - before.w[j]).abs();
                kinetic
                    + a * q(j).powi(2)
                    + b * q(j).powi(4)
                    + springs
                    + before.w[j].abs()
                    + after.w[j].abs()
                    + work
            })
            .sum()
    }
}

impl System<f64> for Net {
    fn dof(&self) -> usize {
        self.masses.len()
    }
    fn energy(&self, q: &[f64], p: &[f64]) -> f64 {
        let n = q.len();
        (0..n)
            .map(|j| {
                let [a, b] = self.wells[j];
                let springs: f64 =
                    (0..j).map(|i| self.springs[i][j] * (q[i] - q[j]).powi(2) / 2.0).sum();
                p[j] * p[j] / (2.0 * self.masses[j])
                    + a * q[j].powi(2) / 2.0
                    + b * q[j].powi(4) / 4.0
                    + springs
            })
            .sum()
    }
    fn gradient(&self, q: &[f64], p: &[f64], hq: &mut [f64], hp: &mut [f64]) {
        for j in 0..q.len() {
            hq[j] = self.partial(q, j, q[j]);
            hp[j] = p[j] / self.masses[j];
        }
    }
    fn dissipation(&self, q: &[f64], p: &[f64], _v: &[f64], d: &mut [f64]) {
        d.iter_mut().enumerate().for_each(|(j, d)| *d = self.dissipation_of(q, p, j).value);
    }
    fn dissipation_form(&self) -> DissipationForm {
        let zero = self.friction.iter().all(|&c| c == 0.0);
        DissipationForm {
            zero,
            passive: Passive::each_if(self.friction.iter().all(|&c| c >= 0.0)),
            ..DissipationForm::LINEAR
        }
    }
}

impl Separable<f64> for Net {
    fn mass(&self, j: usize) -> f64 {
        self.masses[j]
    }
    fn partial(&self, q: &[f64], j: usize, at: f64) -> f64 {
        let springs: f64 =
            (0..q.len()).filter(|&i| i != j).map(|i| self.springs[i][j] * (at - q[i])).sum();
        self.wells[j][0] * at + self.wells[j][1] * at.powi(3) + springs
    }
    fn divided_difference(&self, q: &[f64], j: usize, to: f64) -> Line<f64> {
        let ([a, b], from) = (self.wells[j], q[j]);
        let others = || (0..q.len()).filter(|&i| i != j);
        let springs: f64 =
            others().map(|i| self.springs[i][j] * ((from - q[i]) + (to - q[i])) / 2.0).sum();
        let stiffness: f64 = others().map(|i| self.springs[i][j] / 2.0).sum();
        let sum = from + to;
        let value = sum * (a / 2.0 + b / 4.0 * (from * from + to * to)) + springs;
        let slope = a / 2.0 + b / 4.0 * (from * from + to * to + 2.0 * to * sum) + stiffness;
        Line { value, slope }
    }
    /// c (1 + q²) p
    fn dissipation_of(&self, q: &[f64], p: &[f64], j: usize) -> Dissipation<f64> {
        let by_p = self.friction[j] * (1.0 + q[j] * q[j]);
        Dissipation { value: by_p * p[j], by_q: 2.0 * self.friction[j] * q[j] * p[j], by_p }
    }
}

/// A net that declares D = 0 and whose D is NaN.
struct Frictionless(Net);

impl System<f64> for Frictionless {
    fn dof(&self) -> usize {
        self.0.dof()
    }
    fn energy(&self, q: &[f64], p: &[f64]) -> f64 {
        self.0.energy(q, p)
    }
    fn gradient(&self, q: &[f64], p: &[f64], hq: &mut [f64], hp: &mut [f64]) {
        self.0.gradient(q, p, hq, hp);
    }
    fn dissipation(&self, _q: &[f64], _p: &[f64], _v: &[f64], d: &mut [f64]) {
        d.fill(f64::NAN);
    }
    fn dissipation_form(&self) -> DissipationForm {
        DissipationForm::NONE
    }
}

impl Separable<f64> for Frictionless {
    fn mass(&self, j: usize) -> f64 {
        self.0.mass(j)
    }
    fn partial(&self, q: &[f64], j: usize, at: f64) -> f64 {
        self.0.partial(q, j, at)
    }
    fn divided_difference(&self, q: &[f64], j: usize, to: f64) -> Line<f64> {
        self.0.divided_difference(q, j, to)
    }
    fn dissipation_of(&self, _q: &[f64], _p: &[f64], _j: usize) -> Dissipation<f64> {
        Dissipation { value: f64::NAN, by_q: f64::NAN, by_p: f64::NAN }
    }
}

/// A net of up to 40 masses, a state, a step size, and an order of the coordinates.
fn nets(
    friction: std::ops::Range<f64>,
) -> impl Strategy<Value = (Net, State<Vec<f64>>, f64, Vec<usize>)> {
    (1..=40_usize, -6.0..1.0_f64).prop_flat_map(move |(n, exponent)| {
        let net = (
            prop::collection::vec(0.1..10.0, n),
            prop::collection::vec([-1.0..2.0, 0.0..1.0], n),
            prop::collection::vec(prop::collection::vec(-0.3..1.0, n), n),
            prop::collection::vec(friction.clone(), n),
        );
        let state = (prop::collection::vec(-2.0..2.0, n), prop::collection::vec(-2.0..2.0, n));
        let order = Just((0..n).collect::<Vec<_>>()).prop_shuffle();
        (net, state, order).prop_map(
            move |((masses, wells, mut springs, friction), (q, p), order)| {
                for i in 0..n {
                    let (above, below) = springs.split_at_mut(i);
                    below[0][i] = 0.0;
                    for (j, row) in above.iter_mut().enumerate() {
                        row[i] = below[0][j];
                    }
                }
                let net = Net { masses, wells, springs, friction };
                (net, State::new(q, p).unwrap(), 10.0_f64.powf(exponent), order)
            },
        )
    })
}

/// Takes one step with a new workspace.
fn step(
    method: &Increment,
    net: &dyn Separable<f64>,
    h: f64,
    state: &mut State<Vec<f64>>,
) -> Result<Effort, StepFailure> {
    method.step(net, h, state, &mut method.workspace(net).unwrap())
}

/// Takes one step of a composition sweep by sweep, and checks K after each.
fn step_by_sweeps(
    net: &Net,
    composition: &[f64],
    h: f64,
    order: &[usize],
    state: &mut State<Vec<f64>>,
) -> Result<Option<StepFailure>, TestCaseError> {
    let back: Vec<usize> = order.iter().rev().copied().collect();
    for (i, fraction) in composition.iter().enumerate() {
        let order = if i % 2 == 0 { order.to_vec() } else { back.clone() };
        let sweep = Increment::new(Composition::sweep()).in_order(order);
        let before = state.clone();
        if let Err(failure) = step(&sweep, net, fraction * h, state) {
            prop_assert_eq!(&before, &*state, "a failed step changes nothing");
            return Ok(Some(failure));
        }
        // The step of a coordinate changes K by up to 16 roundings of its own terms (k_is_kept.rs),
        // and summing K adds one rounding per term: 16 + n roundings of the sum of all terms.
        let roundings = 16.0 + net.masses.len() as f64;
        let drift = (state.total(net) - before.total(net)).abs();
        let bound = roundings * f64::EPSILON / 2.0 * net.magnitude(&before, state);
        prop_assert!(
            drift <= bound,
            "sweep {i}: K moves by {drift:e}, {:.1} of the bound",
            drift / bound
        );
    }
    Ok(None)
}

proptest! {
    #![proptest_config(ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::with_cases(200)
    })]

    #[test]
    fn k_is_kept_by_every_sweep_of_any_net((net, start, h, order) in nets(-1.0..1.0)) {
        let backward = vec![0.4, 0.4, -0.6, -0.6, 0.4, 0.4, 0.4, 0.2];
        for composition in [vec![1.0], vec![0.5, 0.5], backward] {
            let mut by_sweeps = start.clone();
            let mut at_once = start.clone();
            let failure = step_by_sweeps(&net, &composition, h, &order, &mut by_sweeps)?;
            let composition = Composition::alternating(&composition).unwrap();
            let method = Increment::new(composition).in_order(order.clone());
            let outcome = step(&method, &net, h, &mut at_once);
            match failure {
                None => prop_assert_eq!(&by_sweeps, &at_once, "a composition is its sweeps"),
                Some(failure) => {
                    prop_assert_eq!(outcome, Err(failure));
                    prop_assert_eq!(&start, &at_once, "a failed step changes nothing");
                }
            }
        }
    }

    /// Where a failure advises a smaller step, a smaller step succeeds.
    #[test]
    fn the_advice_of_a_failure_holds((net, start, h, order) in nets(-1.0..1.0)) {
        let method = Increment::new(Composition::pair()).in_order(order.clone());
        let attempt = |h: f64| step(&method, &net, h, &mut start.clone());
        if let Err(failure) = attempt(h) {
            prop_assert!(failure.to_string().contains("take a smaller step"), "{failure}");
            let taken = (1..=10).find(|&k| attempt(h / 2_f64.powi(k)).is_ok());
            prop_assert!(taken.is_some(), "h = {h}, and down to h/1024: {failure}");
        }
    }

    #[test]
    fn every_reservoir_only_fills_where_the_system_is_passive(
        (net, start, h, order) in nets(0.0..1.0),
    ) {
        for composition in [Composition::sweep(), Composition::pair()] {
            let method = Increment::new(composition).in_order(order.clone());
            let mut state = start.clone();
            if step(&method, &net, h, &mut state).is_ok() {
                prop_assert!(state.w.iter().all(|&w| w >= 0.0), "{:?}", state.w);
            }
        }
    }

    #[test]
    fn names_of_coordinates_mean_nothing((net, start, h, order) in nets(-0.5..0.5)) {
        let names: Vec<usize> = (0..order.len()).rev().collect();
        let rename = |part: &Vec<f64>| names.iter().map(|&i| part[i]).collect::<Vec<_>>();
        let renamed_order: Vec<usize> =
            order.iter().map(|old| names.iter().position(|name| name == old).unwrap()).collect();
        let h = h.min(0.1);
        let mut state = start.clone();
        let mut renamed = State::new(rename(&start.q), rename(&start.p)).unwrap();
        let run = |net: &Net, order: &[usize], state: &mut State<Vec<f64>>| {
            let method = Increment::new(Composition::pair()).in_order(order.to_vec());
            step(&method, net, h, state)
        };
        let other = run(&net.renamed(&names), &renamed_order, &mut renamed);
        prop_assert_eq!(run(&net, &order, &mut state).is_ok(), other.is_ok());
        let expected = [rename(&state.q), rename(&state.w)].concat();
        for (a, b) in expected.iter().zip(renamed.q.iter().chain(&renamed.w)) {
            prop_assert!((a - b).abs() <= 1e-12 * (1.0 + a.abs()), "{a} {b}");
        }
    }

    /// w keeps every bit, including the sign of a zero, and D is not evaluated: the step is that of
    /// a D equal to zero.
    #[test]
    fn without_friction_there_is_no_reservoir(
        (net, start, h, order) in nets(0.0..f64::MIN_POSITIVE),
        seed in 1.0..2.0_f64,
    ) {
        let still = Net { friction: vec![0.0; order.len()], ..net };
        let net = Frictionless(still.clone());
        for composition in [Composition::sweep(), Composition::pair(), Composition::suzuki4()] {
            let method = Increment::new(composition).in_order(order.clone());
            let mut state = start.clone();
            state.w.iter_mut().enumerate().for_each(|(j, w)| {
                *w = if j % 2 == 0 { -0.0 } else { (seed * j as f64).sin() };
            });
            let bits = |state: &State<Vec<f64>>| -> Vec<u64> {
                state.w.iter().map(|w| w.to_bits()).collect()
            };
            let (before, mut same) = (bits(&state), state.clone());
            let expected = step(&method, &still, h, &mut same);
            prop_assert_eq!(step(&method, &net, h, &mut state), expected);
            prop_assert_eq!((&state.q, &state.p), (&same.q, &same.p));
            prop_assert_eq!(bits(&state), before);
        }
    }
}
