//! Expressions, from their text to derivatives, divided differences and programs in any scalar.
//!
//! An expression is made of numbers, named parameters, coordinates `q1, q2, ..`, momenta `p1, p2,
//! ..`, velocities `v1, v2, ..`, the operators `+ - * / ^`, parentheses, the constant `pi` and the
//! functions `sin` `cos` `tan` `asin` `acos` `atan` `sinh` `cosh` `tanh` `exp` `log` `ln` `sqrt`
//! `abs`, `min` and `max` of two numbers; of entries such as `q[i+1]`, and of sums such as `sum(i,
//! 1, n-1, (q[i+1] - q[i])^2)`, which are written out.
//!
//! 1. [`parse()`] reads a text into a [`Graph`], in which equal terms are one [`Node`].
//! 2. [`Graph::gradient`] adds the derivatives of a node by its inputs.
//! 3. [`Graph::divided_difference`] adds `(f(b) - f(a)) / (b - a)` along one coordinate, free of
//!    cancellation.
//! 4. [`Program::new`] compiles nodes to a straight-line program without heap allocation.
//! 5. [`Program::results`] evaluates the program in any [`Scalar`](afterbay_core::Scalar): `f64`,
//!    `Quad`, SIMD lanes, Taylor series, dual numbers.
//!
//! The properties that follow from the form of an expression alone are read off the graph: degrees
//! ([`Graph::degrees`]), signs ([`Graph::sign`]), singularities ([`Graph::may_be_singular`]),
//! and the forms that have faster kernels than a program ([`Graph::monomials`],
//! [`Graph::ridges`]). Simplifications are made only where they are exact.
//!
//! # Example
//!
//! The potential `V = k q²/2 - cos q` at `q = 0.3`, its derivative, and its divided difference
//! over the edge from 0.3 to 0.3 + 10⁻⁹, where the quotient of differences keeps seven digits.
//!
//! ```
//! use afterbay_expression::{Graph, Input, Kinds, Names, Point, Program, parse};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let mut graph = Graph::default();
//! let parameters = ["k".to_owned()];
//! let names = Names { dof: Some(1), ..Names::of(&parameters) };
//! let potential = parse(&mut graph, &names, "k*q1^2/2 - cos(q1)")?.node;
//! let slope = graph.gradient(potential, Kinds::COORDINATES, &[Input::Coordinate(0)])[0];
//! let mean = graph.divided_difference(potential, Input::Coordinate(0));
//!
//! // The part that depends on parameters alone is computed once and starts every run.
//! let program = Program::new(&graph, &[potential, slope, mean])?;
//! let k = 2.0;
//! let frame = program.frame(&graph, &[k]);
//!
//! let (a, b) = (0.3_f64, 0.3 + 1e-9);
//! let q = [a];
//! let point = Point { end: b, ..Point::new(&q, &[], &[]) };
//! let [potential, slope, mean] = program.results(&frame, &point);
//! assert!((potential - (a * a - a.cos())).abs() < 1e-15);
//! assert!((slope - (2.0 * a + a.sin())).abs() < 1e-15);
//! // V[a, b] = (a + b) + sin((a + b)/2) to the rounding of 1 - 10⁻¹⁹.
//! let exact = (a + b) + (0.5 * (a + b)).sin();
//! assert!((mean - exact).abs() < 1e-15);
//! # Ok(())
//! # }
//! ```
//!
//! # Limits
//!
//! A text has at most 65,536 bytes and 256 nested parentheses, a program 1024 values at a time,
//! an index at most [`MOST_DEGREES`]. Beyond them there is an error, never a panic.

mod call;
mod compile;
mod derivative;
mod function;
mod graph;
mod monomial;
mod parse;
mod point;
mod program;
mod ridge;
mod simplify;
mod singular;
mod slope;
mod structure;
mod truncated_power;

pub use function::{FUNCTIONS, FUNCTIONS_OF_TWO, FUNCTIONS_WITH_JUMPS, Function};
pub use graph::{Graph, Input, Kinds, Node, Term};
pub use monomial::Monomial;
pub use parse::{
    Definition, MOST_DEGREES, Names, ParseError, Parsed, Problem, evaluate, is_name, is_reserved,
    parse,
};
pub use point::Point;
pub use program::{BLOCK, Program, REGISTERS, TooManyRegisters, is_wide};
pub use ridge::{Base, Form, Ridge};
pub use structure::{Degrees, Sign};
