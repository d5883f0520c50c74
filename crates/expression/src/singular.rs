//! The points of a line at which an expression has no value: poles, logarithms of 0, roots of
//! negative numbers.
//!
//! The program of the expression is run on intervals over parts of the line
//! ([`afterbay_core::singularity`]). What is looked for is a divisor or the argument of a logarithm
//! that may be 0, and the argument of a root or an inverse sine that may be outside its range.

use crate::function::Function;
use crate::graph::{Graph, Input, Kinds, Node, Term};
use crate::program::{Instruction, Program, REGISTERS, Register};
use afterbay_core::singularity::{Sight, is_singular};
use afterbay_core::{Interval, Scalar};
use std::collections::HashSet;

impl Graph {
    /// Whether the node may be singular where its operands are finite, judged by its form.
    pub fn may_be_singular(&self, of: Node) -> bool {
        !self.doubtful(of).is_empty()
    }

    /// The parts of the node that depend on coordinates alone and can be singular: it is singular
    /// where one of them is. Singularities whose place depends on momenta or velocities are not
    /// among them.
    pub fn singular_parts(&mut self, of: Node) -> Vec<Node> {
        let one = self.number(1.0);
        let is_placed = |graph: &Self, x: Node| {
            !graph.depends(x, Kinds::MOMENTA) && !graph.depends(x, Kinds::VELOCITIES)
        };
        let mut parts = Vec::new();
        for node in self.doubtful(of) {
            let part = match self.term(node) {
                Term::Quotient(_, b) if is_placed(self, b) => self.quotient(one, b),
                Term::Of(_, a) if is_placed(self, a) => node,
                _ => continue,
            };
            parts.push(part);
        }
        parts.sort_unstable();
        parts.dedup();
        parts
    }

    /// The operations that can be singular, as far as their form shows.
    fn doubtful(&self, of: Node) -> Vec<Node> {
        let (mut least, mut positive) = (HashSet::new(), HashSet::new());
        let all = self.all(&[of]);
        for &node in &all {
            let [not_negative, above] = self.signs(node, &least, &positive);
            if not_negative {
                least.insert(node);
            }
            if above {
                positive.insert(node);
            }
        }
        let moves = |x: Node| self.depends(x, Kinds::COORDINATES);
        let doubtful = |node: &Node| match self.term(*node) {
            Term::Quotient(_, b) => moves(b) && !positive.contains(&b),
            Term::Of(Function::Log, a) => moves(a) && !positive.contains(&a),
            Term::Of(Function::Sqrt, a) => moves(a) && !least.contains(&a),
            Term::Of(Function::Asin | Function::Acos, a) => moves(a),
            _ => false,
        };
        all.into_iter().filter(doubtful).collect()
    }

    /// Whether a node is ≥ 0, and whether it is > 0, judged by its form and the nodes for which
    /// that is known.
    fn signs(&self, node: Node, least: &HashSet<Node>, positive: &HashSet<Node>) -> [bool; 2] {
        let both =
            |known: &HashSet<Node>, a: Node, b: Node| known.contains(&a) && known.contains(&b);
        let (not_negative, above) = match self.term(node) {
            Term::Constant(bits) => (f64::from_bits(bits) >= 0.0, f64::from_bits(bits) > 0.0),
            Term::Pi | Term::Of(Function::Exp | Function::Cosh | Function::Sech, _) => (true, true),
            Term::Of(Function::Sqrt, a) => (true, positive.contains(&a)),
            Term::Of(
                Function::Abs | Function::Acos | Function::Fraction | Function::Truncated(_),
                _,
            ) => (true, false),
            Term::Sum(a, b) => {
                let one = positive.contains(&a) || positive.contains(&b);
                (both(least, a, b), both(least, a, b) && one)
            }
            Term::Product(a, b) => (a == b || both(least, a, b), both(positive, a, b)),
            Term::Quotient(a, b) => (both(least, a, b), both(positive, a, b)),
            _ => (false, false),
        };
        [not_negative, above]
    }
}

impl Program {
    /// Whether a result of the program is singular somewhere on a line, given the ends of the
    /// parameter of the line, the frame, and the inputs over a part of the line.
    pub fn is_singular(
        &self,
        line: [f64; 2],
        frame: &dyn Fn(usize) -> Interval,
        input: &dyn Fn(Input, Interval) -> Interval,
    ) -> bool {
        match self.registers {
            0..=16 => self.search::<16>(line, frame, input),
            17..=64 => self.search::<64>(line, frame, input),
            _ => self.search::<REGISTERS>(line, frame, input),
        }
    }

    fn search<const N: usize>(
        &self,
        line: [f64; 2],
        frame: &dyn Fn(usize) -> Interval,
        input: &dyn Fn(Input, Interval) -> Interval,
    ) -> bool {
        let mut registers = [Interval::zero(); N];
        is_singular(line, |part| self.sight(&mut registers, frame, &|x| input(x, part)))
    }

    /// One run over an interval.
    fn sight<const N: usize>(
        &self,
        r: &mut [Interval; N],
        frame: &dyn Fn(usize) -> Interval,
        input: &dyn Fn(Input) -> Interval,
    ) -> Sight {
        let mut worst = Sight::Clear;
        let at = |register: Register| register as usize & (N - 1);
        let product = |r: &[Interval; N], a: Register, b: Register| {
            if a == b { r[at(a)].square() } else { r[at(a)] * r[at(b)] }
        };
        (0..self.frame.len()).for_each(|k| r[k & (N - 1)] = frame(k));
        for (k, &x) in (self.frame.len()..).zip(&self.inputs) {
            r[k & (N - 1)] = input(x);
        }
        for &instruction in &self.code {
            match instruction {
                Instruction::Load { to, input: x } => r[at(to)] = input(x),
                Instruction::Negative { to, a } => r[at(to)] = -r[at(a)],
                Instruction::Sum { to, a, b } => r[at(to)] = r[at(a)] + r[at(b)],
                Instruction::Difference { to, a, b } => r[at(to)] = r[at(a)] - r[at(b)],
                Instruction::Product { to, a, b } => r[at(to)] = product(r, a, b),
                Instruction::Quotient { to, a, b } => {
                    if r[at(b)].contains(0.0) {
                        worst = worst.max(Sight::Pole);
                    }
                    r[at(to)] = r[at(a)] / r[at(b)];
                }
                Instruction::ProductSum { to, a, b, c } => r[at(to)] = product(r, a, b) + r[at(c)],
                Instruction::ProductDifference { to, a, b, c } => {
                    r[at(to)] = r[at(c)] - product(r, a, b);
                }
                Instruction::Of { function, to, a } => {
                    let (value, sight) = enclose(function, r[at(a)]);
                    worst = worst.max(sight);
                    r[at(to)] = value;
                }
                // Of values, not of divided differences.
                Instruction::Divided { to, .. } => r[at(to)] = Interval::WHOLE,
                Instruction::Give { .. } => {}
            }
        }
        worst
    }
}

/// The values of a function, where it has one, and whether it has one.
fn enclose(function: Function, x: Interval) -> (Interval, Sight) {
    let within = |least: f64, most: f64| {
        let (low, high) = (x.low().max(least), x.high().min(most));
        let sight = if low > high {
            Sight::Outside
        } else if low == x.low() && high == x.high() {
            Sight::Clear
        } else {
            Sight::Border
        };
        (Interval::new(low.min(high), high), sight)
    };
    match function {
        Function::Sqrt if x.is_bounded() => {
            let (inside, sight) = within(0.0, f64::INFINITY);
            (inside.sqrt(), sight)
        }
        Function::Asin | Function::Acos if x.is_bounded() => {
            let (inside, sight) = within(-1.0, 1.0);
            let arc = |x: f64| if function == Function::Asin { x.asin() } else { x.acos() };
            let ends = Interval::new(arc(inside.low()), arc(inside.high()));
            // Wider than the roundings of the library's functions.
            (ends + Interval::new(-1e-15, 1e-15), sight)
        }
        Function::Log if x.high() < 0.0 => (Interval::WHOLE, Sight::Outside),
        Function::Log if x.low() <= 0.0 => (Interval::WHOLE, Sight::Pole),
        // It increases.
        Function::Truncated(power) if x.is_bounded() && power.exponent::<f64>() > 0.0 => {
            let [low, high] = [x.low(), x.high()].map(|x| power.at(Interval::new(x, x)));
            (Interval::new(low.low(), high.high()), Sight::Clear)
        }
        _ => (function.at(x), Sight::Clear),
    }
}
