//! Forces of a drive that are sums of sines and cosines of the time, found by their form.
//!
//! ```text
//! c + Σ_k (a_k cos ω_k t + b_k sin ω_k t)
//! ```
//!
//! Sums, negatives, multiples and quotients by closed terms keep this form, and so do products:
//!
//! ```text
//! 2 cos x cos y = cos(x - y) + cos(x + y)        2 sin x sin y = cos(x - y) - cos(x + y)
//! 2 sin x cos y = sin(x + y) + sin(x - y)
//! ```
//!
//! The argument of a sine or cosine is ωt + φ with closed ω and φ.

use afterbay_core::{Harmonic, Harmonics, Scalar};
use afterbay_expression::{Function, Graph, Input, Kinds, Node, Term};
use std::collections::HashMap;

/// The largest number of terms to which products are expanded.
const MOST_TERMS: usize = 64;

/// A term that depends on the time: rate t plus a sum of sines and cosines.
#[derive(Clone)]
struct Course<T> {
    /// `None` where the form has no multiple of t.
    rate: Option<T>,
    sum: Harmonics<T>,
}

/// `root` as a sum of sines and cosines of the end of an edge, which is the time of a drive.
pub(super) fn harmonics<T: Scalar>(
    graph: &Graph,
    root: Node,
    parameters: &[T],
) -> Option<Harmonics<T>> {
    let closed: Vec<Node> =
        graph.all(&[root]).into_iter().filter(|&node| graph.closed(node)).collect();
    let numbers = graph.evaluate(&closed, parameters, &|_| T::zero());
    let mut courses: HashMap<Node, Course<T>> = HashMap::new();
    for node in graph.cone(&[root], Kinds::ALL) {
        let at = |x: Node| match numbers.get(&x) {
            Some(&number) => Some(Course::constant(number)),
            None => courses.get(&x).cloned(),
        };
        let course = match graph.term(node) {
            Term::Input(Input::End) => {
                Course { rate: Some(T::one()), ..Course::constant(T::zero()) }
            }
            Term::Negative(a) => at(a)?.map(|x| -x),
            Term::Sum(a, b) => at(a)?.plus(at(b)?),
            Term::Difference(a, b) => at(a)?.plus(at(b)?.map(|x| -x)),
            Term::Product(a, b) => match (numbers.get(&a), numbers.get(&b)) {
                (Some(&a), _) => at(b)?.map(|x| a * x),
                (_, Some(&b)) => at(a)?.map(|x| x * b),
                (None, None) => at(a)?.times(&at(b)?)?,
            },
            Term::Quotient(a, b) => {
                let b = *numbers.get(&b)?;
                at(a)?.map(|x| x / b)
            }
            Term::Of(function @ (Function::Sin | Function::Cos), a) => at(a)?.wave(function)?,
            _ => return None,
        };
        courses.insert(node, course);
    }
    let course = match numbers.get(&root) {
        Some(&number) => Course::constant(number),
        None => courses.remove(&root)?,
    };
    course.rate.is_none().then_some(course.sum)
}

impl<T: Scalar> Course<T> {
    fn constant(number: T) -> Self {
        Self { rate: None, sum: Harmonics::constant(number) }
    }

    /// Applies a linear function to every coefficient.
    fn map(mut self, f: impl Fn(T) -> T) -> Self {
        self.rate = self.rate.map(&f);
        self.sum.constant = f(self.sum.constant);
        for term in &mut self.sum.terms {
            (term.cosine, term.sine) = (f(term.cosine), f(term.sine));
        }
        self
    }

    fn plus(mut self, other: Self) -> Self {
        self.rate = match (self.rate, other.rate) {
            (Some(a), Some(b)) => Some(a + b),
            (a, b) => a.or(b),
        };
        self.sum.constant += other.sum.constant;
        other.sum.terms.into_iter().for_each(|term| self.sum.add(term));
        self
    }

    /// The product, if neither factor has a multiple of t.
    fn times(&self, other: &Self) -> Option<Self> {
        if self.rate.or(other.rate).is_some() {
            return None;
        }
        let mut product = Harmonics::constant(self.sum.constant * other.sum.constant);
        for (constant, terms) in
            [(self.sum.constant, &other.sum.terms), (other.sum.constant, &self.sum.terms)]
        {
            for &Harmonic { frequency, cosine, sine } in terms {
                product.add(Harmonic {
                    frequency,
                    cosine: constant * cosine,
                    sine: constant * sine,
                });
            }
        }
        for x in &self.sum.terms {
            for y in &other.sum.terms {
                let (cosines, sines) = (x.cosine * y.cosine, x.sine * y.sine);
                let (mixed, other) = (x.sine * y.cosine, x.cosine * y.sine);
                product.add(Harmonic {
                    frequency: x.frequency - y.frequency,
                    cosine: (cosines + sines).half(),
                    sine: (mixed - other).half(),
                });
                product.add(Harmonic {
                    frequency: x.frequency + y.frequency,
                    cosine: (cosines - sines).half(),
                    sine: (mixed + other).half(),
                });
                if product.terms.len() > MOST_TERMS {
                    return None;
                }
            }
        }
        Some(Self { rate: None, sum: product })
    }

    /// The sine or cosine, if the term is ωt + φ.
    fn wave(&self, function: Function) -> Option<Self> {
        if !self.sum.terms.is_empty() {
            return None;
        }
        let (sin, cos) = self.sum.constant.sin_cos();
        let (cosine, sine) = if function == Function::Sin { (sin, cos) } else { (cos, -sin) };
        let mut sum = Harmonics::constant(T::zero());
        sum.add(Harmonic { frequency: self.rate?, cosine, sine });
        Some(Self { rate: None, sum })
    }
}
