//! The systems that are built in, written as expressions: the same to rounding in everything they
//! say. And random polynomials are what they say they are.

use afterbay_core::{
    Block, Curvature, Quad, Scalar, Separable, Series, State, System, taylor, validate,
};
use afterbay_systems::{
    Custom, DampedOscillator, Description, DissipationText, Duffing, FputChain, ModifiedVanDerPol,
    VanDerPol, VanDerPolRing,
};
use proptest::prelude::*;

fn custom(potential: &str, forces: Vec<String>, parameters: &[(&str, f64)]) -> Custom<f64> {
    let parameters = parameters.iter().map(|&(name, value)| (name.to_owned(), value)).collect();
    let (potential, friction) = (potential.to_owned(), DissipationText::Forces(forces));
    Custom::new(&Description {
        potential,
        dissipation: friction,
        parameters,
        ..Description::default()
    })
    .unwrap()
}

fn chain(n: usize, beta: f64, c: f64) -> Custom<f64> {
    let bond = |i: usize| match i {
        0 => "q1^2/2 + beta*q1^4/4".to_owned(),
        _ if i == n => format!("q{n}^2/2 + beta*q{n}^4/4"),
        _ => format!("(q{} - q{i})^2/2 + beta*(q{} - q{i})^4/4", i + 1, i + 1),
    };
    let potential = (0..=n).map(bond).collect::<Vec<_>>().join(" + ");
    custom(&potential, (1..=n).map(|j| format!("c*p{j}")).collect(), &[("beta", beta), ("c", c)])
}

fn ring(n: usize, mu: f64, kappa: f64) -> Custom<f64> {
    let member = |j: usize| format!("q{j}^2/2 + kappa/2*(q{} - q{j})^2", j % n + 1);
    let potential = (1..=n).map(member).collect::<Vec<_>>().join(" + ");
    let forces = (1..=n).map(|j| format!("-mu*(1 - q{j}^2)*p{j}")).collect();
    custom(&potential, forces, &[("mu", mu), ("kappa", kappa)])
}

/// Both say the same, to some roundings of `size`.
fn same<B>(
    own: &Custom<f64>,
    built_in: &B,
    q: &[f64],
    p: &[f64],
    to: f64,
    size: f64,
) -> Result<(), TestCaseError>
where
    B: Separable<f64> + Curvature<f64>,
{
    let n = built_in.dof();
    prop_assert_eq!((own.dof(), own.dissipation_form()), (n, built_in.dissipation_form()));
    // One alone may be called a chain.
    prop_assert!(own.coupling() == built_in.coupling() || n == 1);
    let close = |what: &str, a: f64, b: f64| {
        prop_assert!((a - b).abs() <= 8.0 * f64::EPSILON * size, "{what}: {a} {b} of size {size}");
        Ok(())
    };
    close("energy", own.energy(q, p) / n as f64, built_in.energy(q, p) / n as f64)?;
    let [mut a, mut b] = [0; 2].map(|_| [0; 3].map(|_| vec![0.0; n]));
    let v: Vec<f64> = p.iter().map(|p| 0.5 * p).collect();
    for (part, fields) in
        [(own as &dyn Separable<f64>, &mut a), (built_in as &dyn Separable<f64>, &mut b)]
    {
        let [hq, hp, d] = fields;
        part.gradient(q, p, hq, hp);
        part.dissipation(q, p, &v, d);
    }
    for (a, b) in a.iter().flatten().zip(b.iter().flatten()) {
        close("gradient", *a, *b)?;
    }
    for j in 0..n {
        close("mass", own.mass(j), built_in.mass(j))?;
        for to in [to, q[j], q[j] + 1e-9, -q[j]] {
            close("partial", own.partial(q, j, to), built_in.partial(q, j, to))?;
            let (a, b) = (own.divided_difference(q, j, to), built_in.divided_difference(q, j, to));
            close("edge", a.value, b.value)?;
            close("slope of edge", a.slope, b.slope)?;
        }
        let (a, b) = (own.dissipation_of(q, p, j), built_in.dissipation_of(q, p, j));
        close("drag", a.value, b.value)?;
        close("drag by q", a.by_q, b.by_q)?;
        close("drag by p", a.by_p, b.by_p)?;
    }
    let second = |entries: &mut Vec<(Block, usize, usize, f64)>| {
        entries.retain(|x| x.3 != 0.0);
        entries.sort_by_key(|x| (x.0 as u8, x.1, x.2));
    };
    let (mut a, mut b) = (Vec::new(), Vec::new());
    own.curvature(q, p, |block, i, j, x| a.push((block, i, j, x)));
    built_in.curvature(q, p, |block, i, j, x| b.push((block, i, j, x)));
    second(&mut a);
    second(&mut b);
    prop_assert_eq!(a.len(), b.len());
    for (a, b) in a.into_iter().zip(b) {
        prop_assert_eq!((a.0, a.1, a.2), (b.0, b.1, b.2));
        close("curvature", a.3, b.3)?;
    }
    Ok(())
}

fn numbers(n: usize) -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(-3.0..3.0_f64, n)
}

proptest! {
    #[test]
    fn one_degree_of_freedom(
        k in 0.1..3.0_f64, x in -2.0..2.0_f64, y in -2.0..2.0_f64, z in -2.0..2.0_f64,
        q in numbers(1), p in numbers(1), to in -3.0..3.0_f64,
    ) {
        let one = |text: &str| vec![text.to_owned()];
        let own = custom("k*q1^2/2", one("b*p1"), &[("k", k), ("b", x)]);
        same(&own, &DampedOscillator::new(k, x).unwrap(), &q, &p, to, 200.0)?;
        let parameters = [("alpha", x), ("beta", y), ("c", z)];
        let own = custom("alpha*q1^2/2 + beta*q1^4/4", one("c*p1"), &parameters);
        same(&own, &Duffing::new(x, y, z).unwrap(), &q, &p, to, 200.0)?;
        let own = custom("q1^2/2", one("-mu*(1 - q1^2)*p1"), &[("mu", x)]);
        same(&own, &VanDerPol::new(x).unwrap(), &q, &p, to, 200.0)?;
        let parameters = [("mu", x), ("alpha", y), ("beta", z)];
        let own = custom("q1^2*(alpha/2 + beta/4*q1^2)", one("mu*(q1^2 - 1)*p1"), &parameters);
        same(&own, &ModifiedVanDerPol::new(x, y, z).unwrap(), &q, &p, to, 200.0)?;
    }

    #[test]
    fn chain_and_ring(
        n in 3..14_usize, x in -2.0..2.0_f64, y in -2.0..2.0_f64,
        q in numbers(14), p in numbers(14), to in -3.0..3.0_f64,
    ) {
        let (q, p) = (&q[..n], &p[..n]);
        same(&chain(n, x, y), &FputChain::new(n, x, y).unwrap(), q, p, to, 4000.0)?;
        if n > 3 {
            same(&ring(n, x, y), &VanDerPolRing::new(n, x, y).unwrap(), q, p, to, 200.0)?;
        }
    }

    /// What `check` asks of every system, of polynomials with random terms, masses and friction.
    #[test]
    fn random_polynomials_are_what_they_say(
        n in 1..5_usize,
        terms in prop::collection::vec(
            (-3.0..3.0_f64, 0..5_usize, 0..4_i32, 0..5_usize, 0..4_i32), 1..6,
        ),
        masses in prop::collection::vec(0.2..5.0_f64, 5),
        frictions in prop::collection::vec(
            (-2.0..2.0_f64, 0..5_usize, 0..3_i32, prop::bool::ANY), 5,
        ),
        q in numbers(5), p in numbers(5), matrix in prop::bool::ANY,
    ) {
        let term = |&(c, i, a, j, b): &(f64, usize, i32, usize, i32)| {
            format!("({c:?})*(q{} - q{})^{a}*q{}^{b}", i % n + 1, j % n + 1, j % n + 1)
        };
        let potential = terms.iter().map(term).collect::<Vec<_>>().join(" + ");
        let rate = |j: usize| {
            let (c, i, a, _) = frictions[j];
            format!("({c:?})*q{}^{a}", i % n + 1)
        };
        let friction = if matrix {
            let entry = |i: usize, j: usize| {
                if i == j || frictions[i].3 { rate(i.min(j)) } else { "0".to_owned() }
            };
            DissipationText::Matrix((0..n).map(|i| (0..n).map(|j| entry(i, j)).collect()).collect())
        } else {
            let force = |j: usize| {
                let other = if frictions[j].3 { j } else { frictions[j].1 % n };
                format!("{}*p{}", rate(j), other + 1)
            };
            DissipationText::Forces((0..n).map(force).collect())
        };
        let masses = masses[..n].iter().map(|m| format!("{m:?}")).collect();
        let parameters = Vec::new();
        let description = Description {
            potential,
            dissipation: friction,
            masses,
            parameters,
            ..Description::default()
        };
        let own = Custom::new(&description).unwrap();
        let (q, p) = (&q[..n], &p[..n]);
        for outcome in [validate::separable(&own, q, p), validate::curvature(&own, q, p)] {
            prop_assert!(outcome.is_ok(), "{}", outcome.unwrap_err());
        }
    }
}

/// A pendulum, whose edges are partly quadrature, on a pendulum's scale; and functions of every
/// kind.
#[test]
fn functions_are_what_they_say() {
    for potential in [
        "-cos(q1) + q1^2*q2^2 - cos(q2 - q1)",
        "exp(-q1^2/4) + sqrt(1 + (q2 - q1)^2)",
        "log(2 + q1^2) + atan(q2)*q1 + q2^2/(1 + q1^2)",
        "log(cosh(q1)) + tanh(q2/3)^2 + sinh(q1/4)*sin(q2/2)",
        "asin(q1/40) + acos(q2/40) + tan(q1/20)",
        "(4 + q1^2)^1.5 + (4 + q2^2)^-0.5 + 2^(q1/9)",
    ] {
        let own =
            custom(potential, vec!["0.1*p1".to_owned(), "0.2*p2*(1 + sin(q1)^2)".to_owned()], &[]);
        let (q, p) = ([0.7, -0.4], [0.3, 1.1]);
        assert_eq!(validate::separable(&own, &q, &p), Ok(()), "{potential}");
        assert_eq!(validate::curvature(&own, &q, &p), Ok(()), "{potential}");
    }
}

/// The same Taylor expansion in time, in 31 digits.
#[test]
fn references_are_those_of_the_built_in_system() {
    type Wide = Series<Quad, 20>;
    let lift = |x: f64| Wide::constant(Quad::from_f64(x));
    let own = chain(4, 0.7, 0.1).map(lift);
    let built_in = FputChain::new(4, 0.7, 0.1).unwrap().map(lift);
    let x = [0.9, -0.3, 0.4, 1.2].map(Quad::from_f64);
    let start = State::new(x, [0.1, 0.2, -0.3, 0.5].map(Quad::from_f64)).unwrap();
    let ends = [
        taylor::trajectory::<_, _, 20>(&own, &start, Quad::from_f64(0.5), 4).unwrap(),
        taylor::trajectory::<_, _, 20>(&built_in, &start, Quad::from_f64(0.5), 4).unwrap(),
    ];
    for (a, b) in ends[0].iter().zip(&ends[1]) {
        for j in 0..4 {
            for (a, b) in [(a.q[j], b.q[j]), (a.p[j], b.p[j]), (a.w[j], b.w[j])] {
                assert!((a - b).abs().to_f64() < 1e-28, "{a:?} {b:?}");
            }
        }
    }
    // A pendulum's energy is kept by its own expansion: sin and cos in 31 digits.
    let pendulum = custom("-cos(q1)", vec!["0.1*p1".to_owned()], &[]);
    let start = State::new([Quad::from_f64(2.0)], [Quad::from_f64(0.5)]).unwrap();
    let states =
        taylor::trajectory::<_, _, 20>(&pendulum.map(lift), &start, Quad::from_f64(1.0), 5)
            .unwrap();
    let quad = pendulum.map(Quad::from_f64);
    for state in &states {
        let drift = state.total(&quad) - start.total(&quad);
        assert!(drift.abs().to_f64() < 1e-27, "{drift:?}");
    }
}

/// Polynomials of linear forms are evaluated as such. With a term that is 0 but is none, as any
/// expression is: the same to rounding.
fn ridges(terms: &[Ridge], frictions: &[Ridge], n: usize, off: &str) -> Custom<f64> {
    let potential = terms.iter().map(|term| term.text(n)).collect::<Vec<_>>().join(" + ");
    let rate = |j: usize| {
        // A rate may depend on its own coordinate and on another one.
        let rate = Ridge { i: j, ..frictions[j % frictions.len()] };
        format!("({}{off})*p{}", rate.text(n), j + 1)
    };
    let parameters = &[("z", 0.0)][..usize::from(!off.is_empty())];
    custom(&format!("{potential}{off}"), (0..n).map(rate).collect(), parameters)
}

/// c ℓ^power with ℓ = a q_i + b q_j + offset, or c (s ℓ² + offset)^(power mod 3) with the same a
/// and b.
#[derive(Clone, Copy, Debug)]
struct Ridge {
    c: f64,
    weights: [f64; 2],
    offset: f64,
    i: usize,
    j: usize,
    power: u32,
    square: Option<f64>,
}

impl Ridge {
    fn text(&self, n: usize) -> String {
        let &Self { c, weights: [a, b], offset, i, j, power, square } = self;
        let form = format!("({a:?})*q{} + ({b:?})*q{}", i % n + 1, j % n + 1);
        match square {
            Some(s) => format!("({c:?})*(({s:?})*({form})^2 + ({offset:?}))^{}", power % 3),
            None => format!("({c:?})*({form} + ({offset:?}))^{power}"),
        }
    }

    /// More than any number on the way.
    fn size(&self) -> f64 {
        let Self { c, weights: [a, b], offset, power, square, .. } = self;
        let form = 6.0 * (a.abs() + b.abs()) + offset.abs() + 1.0;
        let power = *power as i32 + 1;
        8.0 * c.abs()
            * if square.is_some() {
                (3.0 * form * form).powi(power % 3 + 2)
            } else {
                form.powi(power)
            }
    }
}

fn ridge() -> impl Strategy<Value = Ridge> {
    let weight = || prop::sample::select(vec![-1.0, 0.0, 1.0, 0.7, -1.3]);
    let offset = prop::sample::select(vec![0.0, 1.0, -0.4]);
    let square = prop::option::of(prop::sample::select(vec![1.0, -1.0, 0.3]));
    (-2.0..2.0_f64, [weight(), weight()], offset, 0..20_usize, 0..20_usize, 0..8_u32, square)
        .prop_map(|(c, weights, offset, i, j, power, square)| Ridge {
            c,
            weights,
            offset,
            i,
            j,
            power,
            square,
        })
}

proptest! {
    #[test]
    fn polynomials_of_linear_forms(
        n in 1..20_usize,
        terms in prop::collection::vec(ridge(), 1..30), everywhere in prop::bool::ANY,
        frictions in prop::collection::vec(ridge(), 1..3),
        q in numbers(20), p in numbers(20), to in -3.0..3.0_f64,
    ) {
        let (q, p) = (&q[..n], &p[..n]);
        let mut terms = terms;
        if everywhere {
            let all = |term: Ridge| (0..n).map(move |i| Ridge { i, j: i + term.j, ..term });
            terms = terms.into_iter().take(3).flat_map(all).collect();
        }
        let [own, program] = ["", " + z*sin(q1)"].map(|more| ridges(&terms, &frictions, n, more));
        let size = terms.iter().chain(&frictions).map(Ridge::size).sum::<f64>();
        prop_assert!((own.energy(q, p) - program.energy(q, p)).abs() <= f64::EPSILON * size);
        let [mut a, mut b] = [0; 2].map(|_| [0; 3].map(|_| vec![0.0; n]));
        for (system, [hq, hp, d]) in [(&own, &mut a), (&program, &mut b)] {
            system.gradient(q, p, hq, hp);
            system.dissipation(q, p, hp, d);
        }
        let close = |what: &str, a: f64, b: f64| {
            prop_assert!((a - b).abs() <= f64::EPSILON * size, "{what}: {a} {b} of size {size}");
            Ok(())
        };
        for (a, b) in a.iter().flatten().zip(b.iter().flatten()) {
            close("field", *a, *b)?;
        }
        for j in 0..n {
            for to in [to, q[j], q[j] + 1e-9] {
                close("partial", own.partial(q, j, to), program.partial(q, j, to))?;
                let [a, b] = [&own, &program].map(|system| system.divided_difference(q, j, to));
                close("edge", a.value, b.value)?;
                close("slope of edge", a.slope, b.slope)?;
            }
            let (a, b) = (own.dissipation_of(q, p, j), program.dissipation_of(q, p, j));
            close("drag", a.value, b.value)?;
            close("drag by q", a.by_q, b.by_q)?;
            close("drag by p", a.by_p, b.by_p)?;
        }
    }
}
