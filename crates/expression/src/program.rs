//! Straight-line programs, run in registers on the stack.
//!
//! A program computes the operands of its results and nothing else. Nodes that depend on no input
//! are computed once, before all runs. They make up the frame that a run starts from.

use crate::function::Function;
use crate::graph::{Graph, Input, Node};
use crate::point::{Point, Points};
use afterbay_core::Scalar;
use thiserror::Error;

/// The largest number of registers of a program.
pub const REGISTERS: usize = 1024;
/// The number of registers of a small program.
pub(super) const SMALL: usize = 16;
/// Entries in a block of a frame. A frame is copied block by block, so that its length is padded to
/// a multiple.
pub const BLOCK: usize = 8;

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
        derivative: Option<Register>,
        a: Register,
        b: Register,
    },
    /// Gives the register as the result of this index.
    Give {
        index: u32,
        a: Register,
    },
}

/// A compiled set of nodes. It is evaluated without heap allocation.
#[derive(Clone, Debug)]
pub struct Program {
    /// Register k starts with entry k of the frame. The inputs follow.
    pub(super) frame: Box<[Node]>,
    pub(super) inputs: Box<[Input]>,
    pub(super) code: Box<[Instruction]>,
    /// The registers of the results that are read at the end of a run.
    pub(super) results: Box<[Register]>,
    pub(super) registers: usize,
}

/// Whether `T` has more than one `f64` in each lane. Its operations then cost so much that a call
/// per run, and decoding an instruction for each point, are negligible beside them.
pub const fn is_wide<T: Scalar>() -> bool {
    size_of::<T>() > size_of::<f64>() * T::LANES
}

/// A program needs more than [`REGISTERS`] values at one time.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[error("more than {REGISTERS} values are needed at one time")]
pub struct TooManyRegisters;

impl Program {
    /// The program with [`Input::End`] read in the place of q_j.
    pub fn moving(self, j: u32) -> Self {
        self.reading(|input| if input == Input::Coordinate(j) { Input::End } else { input })
    }

    /// The program with q_j and p_j read from [`Point::own`], and v_j from [`Point::end`].
    pub fn in_plane(self, j: u32) -> Self {
        self.reading(|input| match input {
            Input::Coordinate(k) if k == j => Input::OwnCoordinate,
            Input::Momentum(k) if k == j => Input::OwnMomentum,
            Input::Velocity(k) if k == j => Input::End,
            _ => input,
        })
    }

    /// This program with its inputs replaced.
    fn reading(mut self, other: impl Fn(Input) -> Input) -> Self {
        self.inputs.iter_mut().for_each(|input| *input = other(*input));
        for instruction in &mut self.code {
            if let Instruction::Load { input, .. } = instruction {
                *input = other(*input);
            }
        }
        self
    }

    /// The nodes of the frame, in order.
    pub fn frame_nodes(&self) -> &[Node] {
        &self.frame
    }

    /// The frame for these values of the parameters, padded with zeros to whole blocks.
    ///
    /// # Panics
    /// If the program mentions a parameter beyond the last.
    pub fn frame<T: Scalar>(&self, graph: &Graph, parameters: &[T]) -> Vec<T> {
        let values = graph.evaluate(&graph.all(&self.frame), parameters, &|_| T::zero());
        let mut frame: Vec<T> = self.frame.iter().filter_map(|x| values.get(x).copied()).collect();
        frame.resize(frame.len().next_multiple_of(BLOCK), T::zero());
        frame
    }

    /// The number of instructions, entries of the frame and inputs.
    pub fn size(&self) -> usize {
        self.code.len() + self.frame.len() + self.inputs.len()
    }

    /// The values of the first K results of [`Program::new`] at a point.
    ///
    /// # Panics
    /// If the program reads beyond the end of a part of the point.
    #[inline]
    pub fn results<T: Scalar, const K: usize>(&self, frame: &[T], point: &Point<'_, T>) -> [T; K] {
        if const { is_wide::<T>() } || self.registers > SMALL {
            let mut results = [T::zero(); K];
            self.shared(frame, point, &mut results, &mut |_, _| {});
            return results;
        }
        // Arrays of their own, which the compiler keeps in the processor's registers.
        let (mut registers, mut results) = ([T::zero(); SMALL], [T::zero(); K]);
        self.execute(&mut registers, frame, point, |_, _| {});
        self.read(&registers, &mut results);
        results
    }

    /// Runs a program with many registers or wide numbers. It is compiled once for all callers,
    /// since such a program hides the cost of the calls.
    #[inline(never)]
    fn shared<T: Scalar, P: Points<T>>(
        &self,
        frame: &[T],
        points: &P,
        results: &mut [P::Value],
        give: &mut dyn FnMut(u32, P::Value),
    ) {
        match self.registers {
            needed if needed <= SMALL => self.run_in::<T, P, SMALL>(frame, points, results, give),
            needed if needed <= 64 => self.run_in::<T, P, 64>(frame, points, results, give),
            _ => self.run_in::<T, P, REGISTERS>(frame, points, results, give),
        }
    }

    /// Runs the program in N registers. A separate function, so that a program does not reserve
    /// more of them than it needs.
    #[inline(never)]
    fn run_in<T: Scalar, P: Points<T>, const N: usize>(
        &self,
        frame: &[T],
        points: &P,
        results: &mut [P::Value],
        give: &mut dyn FnMut(u32, P::Value),
    ) {
        let mut registers = [P::equal(T::zero()); N];
        self.execute(&mut registers, frame, points, give);
        self.read(&registers, results);
    }

    /// Reads the results at the end of a run.
    #[inline(always)]
    fn read<V: Copy, const N: usize>(&self, registers: &[V; N], results: &mut [V]) {
        for (result, &register) in results.iter_mut().zip(&self.results) {
            *result = registers[register as usize & (N - 1)];
        }
    }

    /// Calls `give` with the index and the value of every result of [`Program::many`].
    ///
    /// # Panics
    /// If the program reads beyond the end of a part of the point.
    #[inline]
    pub fn run<T: Scalar>(&self, frame: &[T], point: &Point<'_, T>, give: impl FnMut(u32, T)) {
        self.run_on(frame, point, give);
    }

    /// Calls `give` with the index and the values, one a point, of every result of
    /// [`Program::many`]. Each instruction is decoded once for all points. The values are those of
    /// [`Program::run`] to the bit.
    ///
    /// # Panics
    /// If the program reads beyond the end of a part of a point.
    #[inline]
    pub fn run_at<T: Scalar, const P: usize>(
        &self,
        frame: &[T],
        points: &[Point<'_, T>; P],
        give: impl FnMut(u32, [T; P]),
    ) {
        self.run_on(frame, points, give);
    }

    #[inline(always)]
    fn run_on<T: Scalar, P: Points<T>>(
        &self,
        frame: &[T],
        points: &P,
        mut give: impl FnMut(u32, P::Value),
    ) {
        if const { is_wide::<T>() } || self.registers > SMALL {
            return self.shared(frame, points, &mut [], &mut give);
        }
        self.execute(&mut [P::equal(T::zero()); SMALL], frame, points, give);
    }

    /// Runs the program in N registers, each with one value a point. N is a power of two, so that
    /// the mask makes every index valid without a bounds check; all registers of the program are
    /// below N.
    #[inline(always)]
    fn execute<T: Scalar, P: Points<T>, const N: usize>(
        &self,
        r: &mut [P::Value; N],
        frame: &[T],
        points: &P,
        mut give: impl FnMut(u32, P::Value),
    ) {
        let at = |register: Register| register as usize & (N - 1);
        let mut blocks = r.as_chunks_mut::<BLOCK>().0.iter_mut().zip(frame.as_chunks::<BLOCK>().0);
        // The first block is copied on its own: its known length makes the copy a few instructions.
        if let Some((r, x)) = blocks.next() {
            *r = x.map(P::equal);
            blocks.for_each(|(r, x)| *r = x.map(P::equal));
        }
        for (k, &input) in (self.frame.len()..).zip(&self.inputs) {
            r[k & (N - 1)] = points.read(input);
        }
        for &instruction in &self.code {
            match instruction {
                Instruction::Load { to, input } => r[at(to)] = points.read(input),
                Instruction::Negative { to, a } => r[at(to)] = P::map([r[at(a)]], |[a]| -a),
                Instruction::Sum { to, a, b } => {
                    r[at(to)] = P::map([r[at(a)], r[at(b)]], |[a, b]| a + b);
                }
                Instruction::Difference { to, a, b } => {
                    r[at(to)] = P::map([r[at(a)], r[at(b)]], |[a, b]| a - b);
                }
                Instruction::Product { to, a, b } => {
                    r[at(to)] = P::map([r[at(a)], r[at(b)]], |[a, b]| a * b);
                }
                Instruction::Quotient { to, a, b } => {
                    r[at(to)] = P::map([r[at(a)], r[at(b)]], |[a, b]| a / b);
                }
                Instruction::ProductSum { to, a, b, c } => {
                    let arguments = [r[at(a)], r[at(b)], r[at(c)]];
                    r[at(to)] = P::map(arguments, |[a, b, c]| a.mul_add(b, c));
                }
                Instruction::ProductDifference { to, a, b, c } => {
                    let arguments = [r[at(a)], r[at(b)], r[at(c)]];
                    r[at(to)] = P::map(arguments, |[a, b, c]| (-a).mul_add(b, c));
                }
                Instruction::Of { function, to, a } => {
                    r[at(to)] = P::map([r[at(a)]], |[a]| function.at(a));
                }
                Instruction::Divided { function, to, derivative, a, b } => {
                    let lines = P::divided(function, r[at(a)], r[at(b)]);
                    r[at(to)] = lines.value;
                    if let Some(derivative) = derivative {
                        r[at(derivative)] = lines.slope;
                    }
                }
                Instruction::Give { index, a } => give(index, r[at(a)]),
            }
        }
    }
}
