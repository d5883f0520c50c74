//! Expressions: from text to straight-line programs in any scalar.
//!
//! Numbers, the names of parameters, q1, q2, .. and p1, p2, .., + - * / ^, parentheses, the constant pi and the functions sin cos
//! tan asin acos atan sinh cosh tanh exp log sqrt abs; the grammar is in [`parse`]. A text becomes nodes of a [`graph`] that
//! equal terms share, derivatives are nodes of the same graph ([`derivative`]), what follows from their form alone is read off
//! it ([`structure`], [`ridge`], [`monomial`], [`singular`]), and each set of nodes that is wanted together becomes a [`program`].

mod compile;
mod derivative;
pub(crate) mod function;
pub(crate) mod graph;
pub(crate) mod monomial;
pub(crate) mod parse;
pub(crate) mod program;
pub(crate) mod ridge;
mod simplify;
mod singular;
pub(crate) mod structure;
