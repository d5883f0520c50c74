//! Any text is parsed and evaluated, or refused, without a panic, and its divided difference times
//! the edge is the difference of its values.
//!
//! `AFTERBAY_FUZZ_CASES=10000000 cargo test -p afterbay-expression --test fuzz` looks for hours.
//! Texts of `corpus/expressions.txt` are drawn in every search, unchanged and with changes.

#![cfg(test)]

use afterbay_core::{Interval, Quad, Scalar};
use afterbay_expression::{Graph, Input, Kinds, Names, Point, Program, parse};
use proptest::prelude::*;
use proptest::sample::Index;

const CORPUS: &str = include_str!("corpus/expressions.txt");

/// The tokens that a mutation inserts into a text.
const TOKENS: [&str; 40] = [
    "q1",
    "q2",
    "q[i]",
    "p1",
    "v1",
    "k",
    "n",
    "i",
    "pi",
    "0",
    "1",
    "2",
    "0.5",
    "1e-300",
    "1e308",
    "nan",
    "+",
    "-",
    "*",
    "/",
    "^",
    "(",
    ")",
    ",",
    "[",
    "]",
    "sin(",
    "exp(",
    "log(",
    "sqrt(",
    "abs(",
    "min(",
    "max(",
    "mod(",
    "tanh(",
    "sum(i, 1, n, ",
    "wrap(",
    " ",
    "\n",
    "é",
];

/// The number of cases of a test: `usual`, unless the environment asks for another.
fn cases(usual: u32) -> ProptestConfig {
    let asked = std::env::var("AFTERBAY_FUZZ_CASES").ok().and_then(|cases| cases.parse().ok());
    ProptestConfig { cases: asked.unwrap_or(usual), ..ProptestConfig::default() }
}

/// A text with the grammar of expressions.
fn expression() -> impl Strategy<Value = String> {
    let leaf = prop::sample::select(&["q1", "q2", "k", "pi", "0", "1", "2", "0.3", "3", "n"][..]);
    leaf.prop_map(str::to_owned).prop_recursive(5, 24, 3, |part| {
        let function = prop::sample::select(
            &["sin", "cos", "tanh", "exp", "log", "sqrt", "abs", "atan", "sinh", "cosh"][..],
        );
        let operator = prop::sample::select(&["+", "-", "*", "/"][..]);
        prop_oneof![
            (part.clone(), operator, part.clone()).prop_map(|(a, op, b)| format!("({a}){op}({b})")),
            (function, part.clone()).prop_map(|(f, a)| format!("{f}({a})")),
            (part.clone(), 0..5_u32).prop_map(|(a, n)| format!("({a})^{n}")),
            (part.clone(), part.clone()).prop_map(|(a, b)| format!("max({a}, {b})")),
            part.prop_map(|a| format!("-({a})")),
        ]
    })
}

/// A text of the corpus or the grammar, with some tokens inserted and some characters taken out.
fn changed() -> impl Strategy<Value = String> {
    let lines: Vec<&str> = CORPUS.lines().collect();
    let good = prop_oneof![prop::sample::select(lines).prop_map(str::to_owned), expression()];
    let change = (any::<Index>(), prop::option::of(prop::sample::select(&TOKENS[..])));
    (good, prop::collection::vec(change, 0..5)).prop_map(|(good, changes)| {
        let mut text: Vec<char> = good.chars().collect();
        for (at, token) in changes {
            let at = at.index(text.len() + 1);
            match token {
                Some(token) => drop(text.splice(at..at, token.chars())),
                None if at < text.len() => drop(text.remove(at)),
                None => {}
            }
        }
        text.into_iter().collect()
    })
}

/// The parameter k, an edge of q1 from `a` to `b`, and q2.
type Place = (f64, f64, f64, f64);

fn place() -> impl Strategy<Value = Place> {
    let number = prop_oneof![-3.0..3.0, prop::sample::select(&[0.0, 1.0, -1.0, 1e-9][..])];
    (number.clone(), number.clone(), number.clone(), number)
}

/// An expression with its divided difference and its derivative.
struct Compiled {
    graph: Graph,
    program: Program,
}

impl Compiled {
    /// None if the text is refused, or needs more than coordinates.
    fn of(text: &str) -> Result<Option<Self>, TestCaseError> {
        let mut graph = Graph::default();
        let parameters = ["k".to_owned()];
        let names = Names { dof: Some(2), count: Some(2), ..Names::of(&parameters) };
        let node = match parse(&mut graph, &names, text) {
            Ok(parsed) => parsed.node,
            Err(error) => {
                prop_assert!(text.get(error.span.clone()).is_some(), "{}: {:?}", text, error.span);
                prop_assert!(!error.problem.to_string().is_empty());
                return Ok(None);
            }
        };
        if graph.depends(node, Kinds::MOMENTA) || graph.depends(node, Kinds::VELOCITIES) {
            return Ok(None);
        }
        let slope = graph.gradient(node, Kinds::COORDINATES, &[Input::Coordinate(0)])[0];
        let mean = graph.divided_difference(node, Input::Coordinate(0));
        let program = Program::new(&graph, &[node, mean, slope]).ok();
        Ok(program.map(|program| Self { graph, program }))
    }

    /// The values at both ends of the edge, and the divided difference.
    fn values<T: Scalar>(&self, (k, a, b, q2): Place) -> [T; 3] {
        let [k, a, b, q2] = [k, a, b, q2].map(T::from_f64);
        let frame = self.program.frame(&self.graph, &[k]);
        let at = |from: T| -> [T; 3] {
            let q = [from, q2];
            let point = Point { end: b, ..Point::new(&q, &[], &[]) };
            self.program.results(&frame, &point)
        };
        let ([at_a, mean, _], [at_b, ..]) = (at(a), at(b));
        [at_a, at_b, mean]
    }
}

/// The values at both ends of the edge, and the divided difference, in 106 bits and as intervals.
struct Values {
    long: [Quad; 3],
    intervals: [Interval; 3],
}

/// The values of a text, of which the intervals must contain those in 53 bits; none if the text has
/// no program.
fn values(text: &str, place: Place) -> Result<Option<Values>, TestCaseError> {
    let Some(compiled) = Compiled::of(text)? else { return Ok(None) };
    let intervals = compiled.values::<Interval>(place);
    for (x, interval) in compiled.values::<f64>(place).into_iter().zip(intervals) {
        let holds = !interval.is_bounded() || interval.contains(x);
        prop_assert!(holds, "{} at {:?}: {:e} is not in {:?}", text, place, x, interval);
    }
    Ok(Some(Values { long: compiled.values(place), intervals }))
}

/// The largest number that the checks of values take.
const LARGEST: f64 = 1e6;

/// The widest interval that the checks of values take. A wider one shows that 53 bits have lost all
/// digits, as those of sin(1e36) have, and 106 bits may then have lost them, too.
const WIDEST: f64 = 1e-6;

/// Checks that the divided difference times the edge is the difference of the values, in 106 bits,
/// where no number is large or without digits. Returns whether the text has values.
fn check(text: &str, place: Place) -> Result<bool, TestCaseError> {
    let Some(Values { long, intervals }) = values(text, place)? else { return Ok(false) };
    let (_, a, b, _) = place;
    let fits = |x: Interval| x.magnitude() < LARGEST && x.width() < WIDEST;
    if intervals.into_iter().all(fits) {
        let ([at_a, at_b, mean], width) = (long, Quad::from_f64(b) - Quad::from_f64(a));
        let off = (mean * width - (at_b - at_a)).to_f64().abs();
        prop_assert!(off <= 1e-12, "{} at {:?}: {:e}", text, place, off);
    }
    Ok(true)
}

proptest! {
    #![proptest_config(cases(3000))]

    #[test]
    fn any_text_is_parsed_or_refused(
        tokens in prop::collection::vec(prop::sample::select(&TOKENS[..]), 0..40),
        place in place(),
    ) {
        values(&tokens.concat(), place)?;
    }

    #[test]
    fn a_changed_text_is_parsed_or_refused(text in changed(), place in place()) {
        values(&text, place)?;
    }

    #[test]
    fn divided_differences_are_differences(text in expression(), place in place()) {
        check(&text, place)?;
    }
}

/// The least number of evaluations of the corpus: twenty of its lines at three places.
const EVALUATED: usize = 60;

#[test]
fn the_corpus_is_parsed_or_refused() {
    let mut evaluated = 0;
    for text in CORPUS.lines() {
        for place in [(0.7, 0.3, -1.2, 0.5), (0.0, 0.0, 0.0, 0.0), (2.0, 1.0, 1.0, 1.0)] {
            evaluated += usize::from(check(text, place).expect(text));
        }
    }
    assert!(evaluated >= EVALUATED, "{evaluated} evaluations");
}

/// The smallest numbers stay factors, since their products may have rounding errors.
#[test]
fn powers_of_two_times_the_smallest_numbers_are_evaluated() {
    let Values { long: found, .. } =
        values("q1*1e-310*2*2", (0.0, 1.0, 3.0, 0.0)).unwrap().unwrap();
    assert_eq!(found.map(Scalar::to_f64), [1.0, 3.0, 1.0].map(|x| x * (4.0 * 1e-310)));
}
