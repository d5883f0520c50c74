//! Random expressions: their values, gradients, second derivatives and edges, against dual numbers
//! of the same expression evaluated straight from its tree.
//!
//! How far two evaluations may differ is measured: the tree is evaluated with every operation and
//! input off by up to 2⁻⁴⁰ of itself, and what that does, taken down to 2⁻⁵³, is what rounding may
//! do.

use afterbay_core::{Block, Curvature, Quad, Scalar, Separable, System};
use afterbay_systems::{Custom, CustomError, Description, DissipationText};
use num_dual::{Dual64, DualNum, HyperDual64};
use proptest::prelude::*;

#[derive(Clone, Debug)]
enum Tree {
    Number(f64),
    Q(usize),
    P(usize),
    Parameter,
    Negative(Box<Tree>),
    Binary(char, Box<Tree>, Box<Tree>),
    Power(Box<Tree>, i32),
    Call(&'static str, Box<Tree>),
}

impl Tree {
    fn text(&self) -> String {
        match self {
            Self::Number(x) => format!("{x:?}"),
            Self::Q(j) => format!("q{}", j + 1),
            Self::P(j) => format!("p{}", j + 1),
            Self::Parameter => "a".to_owned(),
            Self::Negative(x) => format!("(-{})", x.text()),
            Self::Binary(c, x, y) => format!("({} {c} {})", x.text(), y.text()),
            Self::Power(x, n) => format!("({})^{n}", x.text()),
            Self::Call(name, x) => format!("{name}({})", x.text()),
        }
    }

    /// With `noise` put on every input and result.
    fn at(&self, point: &Point, noise: &mut impl FnMut(f64) -> f64) -> HyperDual64 {
        let exact = match self {
            Self::Number(x) => HyperDual64::from(*x),
            Self::Q(j) => point.q[*j],
            Self::P(j) => point.p[*j],
            Self::Parameter => HyperDual64::from(point.parameter),
            Self::Negative(x) => -x.at(point, noise),
            Self::Binary(c, x, y) => {
                let (x, y) = (x.at(point, noise), y.at(point, noise));
                match c {
                    '+' => x + y,
                    '-' => x - y,
                    '*' => x * y,
                    // A quotient's derivatives cancel inside.
                    _ => x * shaken(y.recip(), noise),
                }
            }
            Self::Power(x, n) => x.at(point, noise).powi(*n),
            Self::Call(name, x) => {
                let x = x.at(point, noise);
                match *name {
                    "abs" if x.re < 0.0 => -x,
                    "abs" => x,
                    "sqrt" => x.sqrt(),
                    "exp" => x.exp(),
                    "log" => x.ln(),
                    "sin" => x.sin(),
                    "cos" => x.cos(),
                    // These lose digits in the quotient.
                    "tan" => shaken(x.sin(), noise) / shaken(x.cos(), noise),
                    "asin" => x.asin(),
                    "acos" => x.acos(),
                    "atan" => x.atan(),
                    "sinh" => x.sinh(),
                    "cosh" => x.cosh(),
                    _ => shaken(x.sinh(), noise) / shaken(x.cosh(), noise),
                }
            }
        };
        shaken(exact, noise)
    }

    /// Value, first derivatives by both marked inputs and the second, each with what rounding may
    /// do to it.
    fn oracle(&self, point: &Point) -> [[f64; 2]; 4] {
        let parts = |x: HyperDual64| [x.re, x.eps1, x.eps2, x.eps1eps2];
        let exact = parts(self.at(point, &mut |x| x));
        let mut seed = 0x9e37_79b9_7f4a_7c15_u64;
        let mut noise = move |x: f64| {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            let unit = (seed >> 11) as f64 / (1_u64 << 53) as f64;
            x * (1.0 + (2.0 * unit - 1.0) * 2f64.powi(-40))
        };
        let mut spread = [0.0_f64; 4];
        for _ in 0..8 {
            let noisy = parts(self.at(point, &mut noise));
            for k in 0..4 {
                let off = (noisy[k] - exact[k]).abs();
                // What is no number allows nothing to be said.
                spread[k] = if off.is_finite() { off.max(spread[k]) } else { f64::INFINITY };
            }
        }
        std::array::from_fn(|k| {
            [
                exact[k],
                64.0 * 2f64.powi(-13) * spread[k] + 8.0 * f64::EPSILON * exact[k].abs() + LEAST,
            ]
        })
    }
}

/// Second derivatives contain cubes of quotients, which underflow below the cube root of the least
/// number.
const LEAST: f64 = 1e-102;

fn shaken(x: HyperDual64, noise: &mut impl FnMut(f64) -> f64) -> HyperDual64 {
    HyperDual64::new(noise(x.re), noise(x.eps1), noise(x.eps2), noise(x.eps1eps2))
}

struct Point {
    q: [HyperDual64; N],
    p: [HyperDual64; N],
    parameter: f64,
}

const N: usize = 3;

const CASES: u32 = 1500;

impl Point {
    /// Inputs i and k marked, the coordinates first and the momenta after them.
    fn marked(q: &[f64], p: &[f64], parameter: f64, i: usize, k: usize) -> Self {
        let mark = |x: f64, at: usize| {
            HyperDual64::new(x, f64::from(u8::from(at == i)), f64::from(u8::from(at == k)), 0.0)
        };
        Self {
            q: std::array::from_fn(|j| mark(q[j], j)),
            p: std::array::from_fn(|j| mark(p[j], N + j)),
            parameter,
        }
    }
}

fn close(found: f64, [exact, slack]: [f64; 2]) -> bool {
    // Where noise alone moves it that far, rounding is not a matter of first order.
    !(exact.is_finite() && slack < 1e-6 * exact.abs().max(1e-6)) || (found - exact).abs() <= slack
}

fn algebraic(momenta: bool) -> impl Strategy<Value = Tree> {
    tree(momenta, &["abs", "sqrt"])
}

const ALL: [&str; 13] = [
    "abs", "sqrt", "exp", "log", "sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh",
    "tanh",
];

fn tree(momenta: bool, functions: &'static [&'static str]) -> impl Strategy<Value = Tree> {
    let state = if momenta {
        prop_oneof![(0..N).prop_map(Tree::Q), (0..N).prop_map(Tree::P)].boxed()
    } else {
        (0..N).prop_map(Tree::Q).boxed()
    };
    let number =
        prop_oneof![(0.1..3.0_f64), prop::sample::select(vec![0.0, 0.5, 1.0, 2.0, 3.0, 4.0])];
    let leaf =
        prop_oneof![6 => state, 2 => number.prop_map(Tree::Number), 1 => Just(Tree::Parameter)];
    leaf.prop_recursive(6, 48, 2, move |inner| {
        let boxed = |x: Tree| Box::new(x);
        prop_oneof![
            6 => (prop::sample::select(vec!['+', '-', '*', '/']), inner.clone(), inner.clone())
                .prop_map(move |(c, x, y)| Tree::Binary(c, boxed(x), boxed(y))),
            1 => inner.clone().prop_map(move |x| Tree::Negative(boxed(x))),
            2 => (inner.clone(), -3..6_i32).prop_map(move |(x, n)| Tree::Power(boxed(x), n)),
            2 => (prop::sample::select(functions), inner)
                .prop_map(move |(name, x)| Tree::Call(name, boxed(x))),
        ]
    })
}

fn system(potential: &Tree, friction: Option<&Tree>, parameter: f64) -> Option<Custom<f64>> {
    // The parameter must be used.
    let zero = || "0".to_owned();
    let friction = DissipationText::Forces(vec![
        friction.map_or_else(zero, Tree::text),
        "0*a".to_owned(),
        zero(),
    ]);
    let parameters = vec![("a".to_owned(), parameter)];
    let description = Description {
        potential: potential.text(),
        dissipation: friction,
        parameters,
        masses: Vec::new(),
        ..Description::default()
    };
    match Custom::new(&description) {
        Ok(system) => Some(system),
        // Some constants have no value: 1/(2 - 2).
        Err(CustomError::NotFinite { .. }) => None,
        Err(error) => panic!("{description:?}: {error}"),
    }
}

fn values() -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(-2.0..2.0_f64, N)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(CASES))]

    #[test]
    fn potentials(
        tree in tree(false, &ALL), q in values(), p in values(), parameter in 0.2..2.0_f64,
    ) {
        let Some(custom) = system(&tree, None, parameter) else { return Ok(()) };
        // What has an infinite part is refused, and has no value.
        if custom.check_at(&q, &p).is_err() {
            return Ok(());
        }
        let (mut hq, mut hp) = ([0.0; N], [0.0; N]);
        custom.gradient(&q, &p, &mut hq, &mut hp);
        let mut second = [[0.0; N]; N];
        custom.curvature(&q, &p, |block, i, j, x| if block == Block::Hqq { second[i][j] = x });
        for (i, row) in second.iter().enumerate() {
            for (j, &second) in row.iter().enumerate() {
                let exact = tree.oracle(&Point::marked(&q, &p, parameter, i, j));
                if !exact[0][0].is_finite() {
                    return Ok(());
                }
                let (v, text) = (custom.energy(&q, &[0.0; N]), tree.text());
                prop_assert!(close(v, exact[0]), "V of {text}: {exact:?}");
                prop_assert!(close(hq[i], exact[1]), "∂V/∂q of {text}: {} {exact:?} {i}", hq[i]);
                prop_assert!(close(custom.partial(&q, i, q[i]), exact[1]));
                prop_assert!(close(second, exact[3]), "{i} {j} of {text}: {second} {exact:?}");
            }
        }
        // The value in 31 digits is that in 16, and as exact.
        let lift = |x: &[f64]| x.iter().map(|&x| Quad::from_f64(x)).collect::<Vec<_>>();
        let quad = custom.map(Quad::from_f64).energy(&lift(&q), &lift(&[0.0; N])).to_f64();
        let exact = tree.oracle(&Point::marked(&q, &p, parameter, 0, 0));
        prop_assert!(close(quad, exact[0]), "{quad}");
    }

    #[test]
    fn forces(tree in tree(true, &ALL), q in values(), p in values(), parameter in 0.2..2.0_f64) {
        let Some(custom) = system(&Tree::Q(0), Some(&tree), parameter) else { return Ok(()) };
        // What has an infinite part is refused, and has no value.
        if custom.check_at(&q, &p).is_err() {
            return Ok(());
        }
        let mut d = [0.0; N];
        custom.dissipation(&q, &p, &p, &mut d);
        let drag = custom.dissipation_of(&q, &p, 0);
        let mut derivatives = [0.0; 2 * N];
        custom.curvature(&q, &p, |block, i, j, x| match block {
            Block::Dq => { assert_eq!(i, 0); derivatives[j] = x }
            Block::Dp => { assert_eq!(i, 0); derivatives[N + j] = x }
            Block::Hqq | Block::Hqp | Block::Hpp => {}
        });
        for (k, &derivative) in derivatives.iter().enumerate() {
            let exact = tree.oracle(&Point::marked(&q, &p, parameter, k, k));
            if !exact[0][0].is_finite() {
                return Ok(());
            }
            let text = tree.text();
            for d in [d[0], drag.value] {
                prop_assert!(close(d, exact[0]), "D of {text}: {d} {exact:?}");
            }
            prop_assert!(close(derivative, exact[1]), "{k} of {text}: {derivative} {exact:?}");
        }
        for (by, k) in [(drag.by_q, 0), (drag.by_p, N)] {
            prop_assert!(close(by, tree.oracle(&Point::marked(&q, &p, parameter, k, k))[1]));
        }
    }

    /// In closed form, for every length of the edge. A product may be made of large parts along the
    /// way, so that the formula is checked in 31 digits, where these cost nothing.
    #[test]
    fn edges(
        tree in algebraic(false), q in values(), to in -2.0..2.0_f64, parameter in 0.2..2.0_f64,
        digits in 0..9_i32,
    ) {
        let Some(custom) = system(&tree, None, parameter) else { return Ok(()) };
        if custom.check_at(&q, &[0.0; N]).is_err() {
            return Ok(());
        }
        let quad = custom.map(Quad::from_f64);
        let lift = |x: &[f64]| x.iter().map(|&x| Quad::from_f64(x)).collect::<Vec<_>>();
        let (start, rest) = (lift(&q), lift(&[0.0; N]));
        for j in 0..N {
            let to = Quad::from_f64(q[j] + (to - q[j]) * 10f64.powi(-digits));
            let mut end = start.clone();
            end[j] = to;
            let (edge, width) = (quad.divided_difference(&start, j, to), to - start[j]);
            let [a, b] = [&start, &end].map(|q| quad.energy(q, &rest));
            // Between two points there may be a pole; and where V is large its rounding is.
            let moderate =
                |x: [Quad; 3]| x.into_iter().all(|x| x.is_finite() && x.abs().to_f64() < 1e6);
            let text = tree.text();
            let along = moderate([a, b, edge.value]);
            if along {
                let off = (edge.value * width - (b - a)).abs().to_f64();
                prop_assert!(off < 1e-20, "{text} along q{} from {q:?} to {to:?}: {off:e}", j + 1);
            }
            let on_none = quad.divided_difference(&start, j, start[j]).value;
            let slope = quad.partial(&start, j, start[j]);
            if moderate([a, on_none, slope]) {
                let off = (on_none - slope).abs().to_f64();
                prop_assert!(off < 1e-20, "{text}: {on_none:?} {slope:?}");
            }
            let dual = |x: &[f64]| x.iter().map(|&x| Dual64::from_f64(x)).collect::<Vec<_>>();
            let (lifted, end) = (custom.map(Dual64::from_f64), Dual64::new(to.to_f64(), 1.0));
            let exact = lifted.divided_difference(&dual(&q), j, end).value;
            let edge = custom.divided_difference(&q, j, to.to_f64());
            if along && Scalar::is_finite(exact) && exact.eps.abs() < 1e3 && exact.re.abs() < 1e3 {
                let off = (exact.eps - edge.slope).abs();
                prop_assert!(off < 1e-6, "{text}: {exact:?} {edge:?}");
            }
        }
    }
}
