//! K at any step size: exact edges, edges resolved by quadrature, and steps that are refused.

use crate::bind::AnySeparable;
use crate::catalog::{Built, written};
use crate::many;
use afterbay_core::{
    Dissipation, Formulas, FromFormulas, Line, Method, Quad, Scalar, Separable, State, StepFailure,
    System,
};
use afterbay_methods::{Composition, Increment, ModDg};
use afterbay_systems::{Description, DissipationText};

/// A pendulum given only by its force; with g = 9.81 it is that of the guide.
struct Pendulum {
    g: f64,
    c: f64,
}

impl System<f64> for Pendulum {
    fn dof(&self) -> usize {
        1
    }
    fn energy(&self, q: &[f64], p: &[f64]) -> f64 {
        p[0] * p[0] / 2.0 + self.g * (1.0 - q[0].cos())
    }
    fn gradient(&self, q: &[f64], p: &[f64], hq: &mut [f64], hp: &mut [f64]) {
        (hq[0], hp[0]) = (self.g * q[0].sin(), p[0]);
    }
    fn dissipation(&self, _q: &[f64], _p: &[f64], v: &[f64], d: &mut [f64]) {
        d[0] = self.c * v[0].abs() * v[0];
    }
}

impl Separable<f64> for Pendulum {
    fn partial(&self, _q: &[f64], _j: usize, at: f64) -> f64 {
        self.g * at.sin()
    }
    fn dissipation_of(&self, _q: &[f64], p: &[f64], _j: usize) -> Dissipation<f64> {
        let by_p = 2.0 * self.c * p[0].abs();
        Dissipation { value: self.c * p[0].abs() * p[0], by_q: 0.0, by_p }
    }
}

/// The ring of pendulums of the README, given only by its forces.
struct Ring;

impl System<f64> for Ring {
    fn dof(&self) -> usize {
        12
    }
    fn energy(&self, q: &[f64], p: &[f64]) -> f64 {
        (0..12)
            .map(|j| p[j] * p[j] / 2.0 - q[j].cos() + (q[(j + 1) % 12] - q[j]).powi(2) / 2.0)
            .sum()
    }
    fn gradient(&self, q: &[f64], p: &[f64], hq: &mut [f64], hp: &mut [f64]) {
        (0..12).for_each(|j| (hq[j], hp[j]) = (self.partial(q, j, q[j]), p[j]));
    }
    fn dissipation(&self, _q: &[f64], _p: &[f64], v: &[f64], d: &mut [f64]) {
        (0..12).for_each(|j| d[j] = 0.1 * v[j]);
    }
}

impl Separable<f64> for Ring {
    fn partial(&self, q: &[f64], j: usize, at: f64) -> f64 {
        at.sin() + 2.0 * at - q[(j + 1) % 12] - q[(j + 11) % 12]
    }
    fn dissipation_of(&self, _q: &[f64], p: &[f64], j: usize) -> Dissipation<f64> {
        Dissipation { value: 0.1 * p[j], by_q: 0.0, by_p: 0.1 }
    }
}

/// The pendulum from its formulas, as in the README with g = 1.
struct Written {
    g: f64,
    c: f64,
}

impl Formulas for Written {
    fn dof(&self) -> usize {
        1
    }
    fn potential<T: Scalar>(&self, q: &[T]) -> T {
        T::from_f64(self.g) * (T::one() - q[0].sin_cos().1)
    }
    fn dissipation<T: Scalar>(&self, _q: &[T], v: &[T], _j: usize) -> T {
        T::from_f64(self.c) * v[0].abs() * v[0]
    }
}

/// The largest change of K in some steps, relative to its terms.
fn drift<M: Method<Vec<f64>, AnySeparable<f64>>>(
    method: &M,
    system: &AnySeparable<f64>,
    h: f64,
    q: Vec<f64>,
    p: Vec<f64>,
) -> Result<f64, StepFailure> {
    let mut state = State::new(q, p).unwrap();
    let (before, mut worst) = (state.total(system), 0.0_f64);
    let mut workspace = method.workspace(system).unwrap();
    for _ in 0..50 {
        method.step(system, h, &mut state, &mut workspace)?;
        worst = worst.max((state.total(system) - before).abs() / before.abs().max(1.0));
    }
    Ok(worst)
}

#[test]
fn a_rotating_pendulum_keeps_k_at_any_step() {
    for (g, k) in [(1.0, 200.0_f64), (9.81, 200.0)] {
        for h in [0.01, 0.3, 1.0, 2.0, 7.0] {
            for c in [0.0, 0.01] {
                let (q, p) = (vec![0.3], vec![(2.0 * k).sqrt()]);
                let (by_force, written) = (Pendulum { g, c }, FromFormulas(Written { g, c }));
                let four = Increment::new(Composition::suzuki4());
                let found = [
                    drift(&ModDg::newton(), &by_force, h, q.clone(), p.clone()),
                    drift(&four, &by_force, h, q.clone(), p.clone()),
                    drift(&ModDg::newton(), &written, h, q.clone(), p.clone()),
                    drift(&four, &written, h, q, p),
                ];
                // The angle grows to 1000 h, and its rounding enters V at each of 500 substeps.
                let bound = 2e-13 + 5e-15 * g * 1e3 * h / k;
                for (i, drift) in found.into_iter().enumerate() {
                    // Long steps may have no solution that continues from h = 0.
                    if let Ok(drift) = drift {
                        assert!(drift < bound, "{i}: g = {g}, h = {h}, c = {c}: {drift:e}");
                    } else {
                        assert!(h > 0.9, "{i}: g = {g}, h = {h}, c = {c}: {drift:?}");
                    }
                }
            }
        }
    }
}

#[test]
fn the_ring_of_the_readme_keeps_k_on_long_steps() {
    for h in [0.05, 0.5, 2.0] {
        let q = (0..12).map(|j| (0.3 * f64::from(j)).sin()).collect();
        let found =
            drift(&Increment::new(Composition::pair()), &Ring, h, q, vec![6.0; 12]).unwrap();
        assert!(found < 1e-12, "{h}: {found:e}");
    }
}

#[test]
fn formulas_make_the_system() {
    let (by_force, written) =
        (Pendulum { g: 9.81, c: 0.1 }, FromFormulas(Written { g: 9.81, c: 0.1 }));
    for (q, p) in [(0.3, -0.7), (-2.0, 1.4), (0.0, 0.0)] {
        let [mut hq, mut hp, mut d] = [[0.0]; 3];
        written.gradient(&[q], &[p], &mut hq, &mut hp);
        written.dissipation(&[q], &[p], &hp, &mut d);
        let drag = |s: &dyn Separable<f64>| s.dissipation_of(&[q], &[p], 0);
        let (found, exact) = (drag(&written), drag(&by_force));
        assert!((written.energy(&[q], &[p]) - by_force.energy(&[q], &[p])).abs() < 1e-14);
        assert!((hq[0] - 9.81 * q.sin()).abs() < 1e-14 && hp[0] == p && d[0] == found.value);
        for (a, b) in
            [(found.value, exact.value), (found.by_q, exact.by_q), (found.by_p, exact.by_p)]
        {
            assert!((a - b).abs() < 1e-15, "{found:?} {exact:?}");
        }
    }
    // In 106 bits, in which an error of quadrature would be visible.
    let (system, start): (&dyn Separable<Quad>, _) = (&written, many::start([&[0.3], &[20.0]]));
    let mut end = start.clone();
    for _ in 0..20 {
        ModDg::newton().step(system, Quad::from_f64(0.7), &mut end, &mut ()).unwrap();
    }
    assert!((end.total(system) - start.total(system)).abs().0 < 1e-27);
}

/// V = q²/2 plus, at q = 1, a bump between all nodes of the quadrature, or a pole.
struct Narrow {
    pole: bool,
}

impl System<f64> for Narrow {
    fn dof(&self) -> usize {
        1
    }
    fn energy(&self, q: &[f64], p: &[f64]) -> f64 {
        let x = q[0] - 1.0;
        let rest = if self.pole { 0.1 / (x * x) } else { (x / 1e-4).tanh() };
        p[0] * p[0] / 2.0 + q[0] * q[0] / 2.0 + rest
    }
    fn gradient(&self, q: &[f64], p: &[f64], hq: &mut [f64], hp: &mut [f64]) {
        (hq[0], hp[0]) = (self.partial(q, 0, q[0]), p[0]);
    }
    fn dissipation(&self, _q: &[f64], _p: &[f64], _v: &[f64], d: &mut [f64]) {
        d[0] = 0.0;
    }
}

impl Separable<f64> for Narrow {
    fn partial(&self, _q: &[f64], _j: usize, at: f64) -> f64 {
        let x = at - 1.0;
        at + if self.pole { -0.2 / (x * x * x) } else { (x / 1e-4).cosh().powi(-2) * 1e4 }
    }
    fn dissipation_of(&self, _q: &[f64], _p: &[f64], _j: usize) -> Dissipation<f64> {
        Dissipation { value: 0.0, by_q: 0.0, by_p: 0.0 }
    }
}

#[test]
fn what_quadrature_does_not_see_is_refused() {
    let (moddg, pair) = (ModDg::newton(), Increment::new(Composition::pair()));
    let bump = Narrow { pole: false };
    let lost =
        |found: Result<f64, StepFailure>| matches!(found, Err(StepFailure::BalanceLost { .. }));
    assert!(lost(drift(&moddg, &bump, 0.5, vec![0.0], vec![3.0])));
    assert!(lost(drift(&pair, &bump, 0.5, vec![0.0], vec![3.0])));
    let pole = Narrow { pole: true };
    for found in [
        drift(&moddg, &pole, 0.5, vec![0.0], vec![30.0]),
        drift(&pair, &pole, 0.5, vec![0.0], vec![30.0]),
    ] {
        let Err(StepFailure::EdgeUnresolved { dof: 0, from, to }) = found else {
            panic!("{found:?}")
        };
        assert!(from < 1.0 && to > 1.0, "{from} {to}");
    }
}

/// [`Pendulum`] with a wrong divided difference.
struct Wrong(Pendulum);

impl System<f64> for Wrong {
    fn dof(&self) -> usize {
        1
    }
    fn energy(&self, q: &[f64], p: &[f64]) -> f64 {
        self.0.energy(q, p)
    }
    fn gradient(&self, q: &[f64], p: &[f64], hq: &mut [f64], hp: &mut [f64]) {
        self.0.gradient(q, p, hq, hp);
    }
    fn dissipation(&self, q: &[f64], p: &[f64], v: &[f64], d: &mut [f64]) {
        self.0.dissipation(q, p, v, d);
    }
}

impl Separable<f64> for Wrong {
    fn partial(&self, q: &[f64], j: usize, at: f64) -> f64 {
        self.0.partial(q, j, at)
    }
    fn divided_difference(&self, q: &[f64], _j: usize, to: f64) -> Line<f64> {
        let middle = (q[0] + to) / 2.0;
        Line { value: self.0.g * middle.sin(), slope: self.0.g * middle.cos() / 2.0 }
    }
    fn dissipation_of(&self, q: &[f64], p: &[f64], j: usize) -> Dissipation<f64> {
        self.0.dissipation_of(q, p, j)
    }
}

#[test]
fn an_edge_that_is_no_mean_is_refused() {
    let wrong = Wrong(Pendulum { g: 1.0, c: 0.1 });
    let found = drift(&ModDg::newton(), &wrong, 0.3, vec![0.3], vec![1.0]);
    assert!(matches!(found, Err(StepFailure::BalanceLost { .. })), "{found:?}");
}

pub(crate) fn custom(potential: &str, n: usize, c: f64) -> Built {
    let friction = DissipationText::Forces((1..=n).map(|j| format!("c*p{j}")).collect());
    let (potential, parameters) = (potential.to_owned(), vec![("c".to_owned(), c)]);
    written(&Description { potential, dissipation: friction, parameters, ..Description::default() })
}

#[test]
fn a_step_across_a_singularity_is_refused_by_name() {
    let cases = [
        ("1/q1", 1.0, -9.0),
        ("1/q1^2", 1.0, -9.0),
        ("-1/q1^2", -1.0, 9.0),
        ("-1/abs(q1)", 1.0, -5.0),
        ("log(q1)", 1.0, -9.0),
        ("-log(abs(q1))", 1.0, -9.0),
        ("tan(q1)^2", 0.0, 30.0),
        ("q1^2/2 + 1/((q1 - 1)^2)", 0.0, 30.0),
        ("q1^2/2 - 0.1/((q1 - 1)^2)", 0.0, 30.0),
        ("q1^(-3)", 1.0, -50.0),
    ];
    let (mut refused, mut turned) = (0, 0);
    for (potential, q, p) in cases {
        let system = &*custom(potential, 1, 0.1).separable::<f64>();
        for h in [0.3, 1.0, 4.0] {
            let mut state = State::new(vec![q], vec![p]).unwrap();
            let before = state.clone();
            for outcome in [ModDg::newton().step(system, h, &mut state.clone(), &mut ()), {
                let pair = Increment::new(Composition::pair());
                let mut workspace = pair.workspace(system).unwrap();
                pair.step(system, h, &mut state, &mut workspace)
            }] {
                match outcome {
                    Err(StepFailure::AcrossSingularity { dof, from, to }) => {
                        assert_eq!(dof, 0);
                        let seen = system.is_singular_along(&[from], 0, to);
                        assert!(seen, "{potential} from {from} to {to}");
                        refused += 1;
                    }
                    // A solution on this side of the singularity, which has repelled the particle.
                    Ok(_) => turned += 1,
                    Err(other) => panic!("{potential}, h = {h}: {other}"),
                }
            }
            let crossed = system.is_singular_along(&before.q, 0, state.q[0]);
            assert!(!crossed, "{potential}, h = {h}: from {q} to {}", state.q[0]);
        }
    }
    println!("{refused} refused, {turned} turned back");
    assert!(refused > 10 && turned > 5, "{refused} refused, {turned} turned back");
}
