//! Straight-line programs: what some nodes need and nothing else, in registers on the stack.
//!
//! What depends on no input has been computed before, once for all evaluations, and lies in the frame a run begins with.

use super::compile::compile;
use super::function::Function;
use super::graph::{Graph, Input, Node};
use afterbay_core::Scalar;

/// The most registers a program may have.
pub(crate) const REGISTERS: usize = 1024;
/// Frames are copied in blocks of this many, and filled up to whole ones.
pub(crate) const BLOCK: usize = 8;

pub(super) type Register = u16;

#[derive(Clone, Copy, Debug)]
pub(super) enum Instruction {
    Load {
        to: Register,
        input: Input,
    },
    Negative {
        to: Register,
        a: Register,
    },
    Sum {
        to: Register,
        a: Register,
        b: Register,
    },
    Difference {
        to: Register,
        a: Register,
        b: Register,
    },
    Product {
        to: Register,
        a: Register,
        b: Register,
    },
    Quotient {
        to: Register,
        a: Register,
        b: Register,
    },
    /// a b + c
    ProductSum {
        to: Register,
        a: Register,
        b: Register,
        c: Register,
    },
    /// c - a b
    ProductDifference {
        to: Register,
        a: Register,
        b: Register,
        c: Register,
    },
    Of {
        function: Function,
        to: Register,
        a: Register,
    },
    /// φ[a, b], and its derivative by b where that is wanted too.
    Divided {
        function: Function,
        to: Register,
        bend: Option<Register>,
        a: Register,
        b: Register,
    },
    /// The result of this index is in the register.
    Give {
        index: u32,
        a: Register,
    },
}

/// Where the inputs are read.
#[derive(Clone, Copy)]
pub(crate) struct Point<'a, T> {
    pub(crate) q: &'a [T],
    pub(crate) p: &'a [T],
    pub(crate) v: &'a [T],
    /// The end of the edge, or the coordinate moved.
    pub(crate) end: T,
}

impl<T: Copy> Point<'_, T> {
    #[inline(always)]
    fn read(&self, input: Input) -> T {
        match input {
            Input::Coordinate(j) => self.q[j as usize],
            Input::Momentum(j) => self.p[j as usize],
            Input::Velocity(j) => self.v[j as usize],
            Input::End => self.end,
        }
    }
}

/// A program with its results.
#[derive(Clone, Debug)]
pub(crate) struct Program {
    /// Register k holds entry k of the frame at the start, and the inputs follow.
    pub(crate) frame: Box<[Node]>,
    pub(super) inputs: Box<[Input]>,
    pub(super) code: Box<[Instruction]>,
    /// The registers of the results, unless they are given on the way.
    pub(super) results: Box<[Register]>,
    pub(super) registers: usize,
}

/// A program needs more registers than there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct TooManyRegisters;

impl Program {
    /// For a few results, all at the end of a run.
    pub(crate) fn new(graph: &Graph, results: &[Node]) -> Result<Self, TooManyRegisters> {
        compile(graph, results, &[])
    }

    /// For many, each given as soon as it is there: some programs, if it takes too many registers in one. A result is given with its index.
    pub(crate) fn many(graph: &Graph, results: &[(u32, Node)]) -> Result<Vec<Self>, TooManyRegisters> {
        let (mut programs, mut stack) = (Vec::new(), vec![results]);
        while let Some(part) = stack.pop() {
            match compile(graph, &[], part) {
                Ok(program) => programs.push(program),
                Err(TooManyRegisters) if part.len() > 1 => {
                    let (first, second) = part.split_at(part.len() / 2);
                    stack.extend([second, first]);
                }
                Err(error) => return Err(error),
            }
        }
        Ok(programs)
    }

    /// The same with the end of the edge in the place of q_j.
    pub(crate) fn moving(mut self, j: u32) -> Self {
        let moved = |input: &mut Input| {
            if *input == Input::Coordinate(j) {
                *input = Input::End;
            }
        };
        self.inputs.iter_mut().for_each(moved);
        for instruction in &mut self.code {
            if let Instruction::Load { input, .. } = instruction {
                moved(input);
            }
        }
        self
    }

    /// The length of its code.
    pub(crate) fn len(&self) -> usize {
        self.code.len() + self.frame.len() + self.inputs.len()
    }

    /// The results.
    #[inline]
    pub(crate) fn results<T: Scalar, const K: usize>(&self, frame: &[T], point: &Point<'_, T>) -> [T; K] {
        if self.registers > 16 {
            return self.large_results(frame, point);
        }
        self.last::<T, 16, K>(frame, point)
    }

    /// Apart, so that a small program does not reserve the registers of a large one.
    #[inline(never)]
    fn large_results<T: Scalar, const K: usize>(&self, frame: &[T], point: &Point<'_, T>) -> [T; K] {
        match self.registers {
            0..=64 => self.last::<T, 64, K>(frame, point),
            _ => self.last::<T, REGISTERS, K>(frame, point),
        }
    }

    #[inline(always)]
    fn last<T: Scalar, const N: usize, const K: usize>(&self, frame: &[T], point: &Point<'_, T>) -> [T; K] {
        let mut registers = [T::zero(); N];
        self.execute(&mut registers, frame, point, |_, _| {});
        let mut results = [T::zero(); K];
        results.iter_mut().zip(&self.results).for_each(|(x, &at)| *x = registers[at as usize & (N - 1)]);
        results
    }

    /// Gives every result with its index.
    #[inline]
    pub(crate) fn run<T: Scalar>(&self, frame: &[T], point: &Point<'_, T>, give: impl FnMut(u32, T)) {
        if self.registers > 16 {
            return self.large_run(frame, point, give);
        }
        self.execute(&mut [T::zero(); 16], frame, point, give);
    }

    #[inline(never)]
    fn large_run<T: Scalar>(&self, frame: &[T], point: &Point<'_, T>, give: impl FnMut(u32, T)) {
        match self.registers {
            0..=64 => self.execute(&mut [T::zero(); 64], frame, point, give),
            _ => self.execute(&mut [T::zero(); REGISTERS], frame, point, give),
        }
    }

    /// N is a power of two, and every register below it.
    #[inline(always)]
    fn execute<T: Scalar, const N: usize>(
        &self,
        r: &mut [T; N],
        frame: &[T],
        point: &Point<'_, T>,
        mut give: impl FnMut(u32, T),
    ) {
        let at = |register: Register| register as usize & (N - 1);
        let mut blocks = r.as_chunks_mut::<BLOCK>().0.iter_mut().zip(frame.as_chunks::<BLOCK>().0);
        // The first apart: a copy of known length is no call.
        if let Some((r, x)) = blocks.next() {
            *r = *x;
            blocks.for_each(|(r, x)| *r = *x);
        }
        for (k, &input) in (self.frame.len()..).zip(&self.inputs) {
            r[k & (N - 1)] = point.read(input);
        }
        for &instruction in &self.code {
            match instruction {
                Instruction::Load { to, input } => r[at(to)] = point.read(input),
                Instruction::Negative { to, a } => r[at(to)] = -r[at(a)],
                Instruction::Sum { to, a, b } => r[at(to)] = r[at(a)] + r[at(b)],
                Instruction::Difference { to, a, b } => r[at(to)] = r[at(a)] - r[at(b)],
                Instruction::Product { to, a, b } => r[at(to)] = r[at(a)] * r[at(b)],
                Instruction::Quotient { to, a, b } => r[at(to)] = r[at(a)] / r[at(b)],
                Instruction::ProductSum { to, a, b, c } => r[at(to)] = r[at(a)].mul_add(r[at(b)], r[at(c)]),
                Instruction::ProductDifference { to, a, b, c } => {
                    r[at(to)] = (-r[at(a)]).mul_add(r[at(b)], r[at(c)]);
                }
                Instruction::Of { function, to, a } => r[at(to)] = function.at(r[at(a)]),
                Instruction::Divided { function, to, bend, a, b } => {
                    let line = function.divided(r[at(a)], r[at(b)]);
                    r[at(to)] = line.value;
                    if let Some(bend) = bend {
                        r[at(bend)] = line.slope;
                    }
                }
                Instruction::Give { index, a } => give(index, r[at(a)]),
            }
        }
    }
}
