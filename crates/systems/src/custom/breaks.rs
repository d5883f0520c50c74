//! The instants at which forces jump, have a kink or are singular in t.
//!
//! They are zeros of functions of t: x of |x|, √x, ln x and the sign of x, x - ⌊x⌋ and
//! x - ⌊x⌋ - 1 of ⌊x⌋, and divisors. The first zero is found by bisection. Parts of the time in
//! which interval arithmetic excludes a zero are left out, so that none is missed.

use super::failure::CustomError;
use super::programs::{Builder, Part};
use super::time_point;
use afterbay_core::{Interval, Scalar};
use afterbay_expression::{Graph, Input, Kinds, Node};

/// The width of a break on each side, in units in the last place of the time. It covers the
/// roundings of the times of stages.
const MARGIN: f64 = 8.0;
/// The most evaluations for one search. More are needed only where a function is 0 over a while or
/// touches 0 with several derivatives. The search then ends early, at a time that may be no break.
const MOST_EVALUATIONS: u32 = 4000;

/// The functions that depend on `time` alone, and the others. `time` is the t of a drive or the
/// coordinate of a clock.
pub(super) fn of_time_and_state(graph: &Graph, of: &[Node], time: Input) -> [Vec<Node>; 2] {
    let of_time = |&x: &Node| {
        let inputs = graph.inputs(x, Kinds::ALL);
        !inputs.is_empty() && inputs.iter().all(|input| *input == time)
    };
    let (of_time, of_state) = of.iter().copied().partition(of_time);
    [of_time, of_state]
}

/// The functions of t whose zeros are the breaks.
#[derive(Debug)]
pub(super) struct Breaks(Vec<Part>);

impl Breaks {
    /// The breaks at the zeros of those functions of `kinks` that depend on `time` alone.
    pub(super) fn new(
        builder: &mut Builder,
        kinks: &[Node],
        time: Input,
    ) -> Result<Self, CustomError> {
        let [of_time, _] = of_time_and_state(&builder.graph, kinks, time);
        if of_time.is_empty() {
            return Ok(Self(Vec::new()));
        }
        let parts = builder.many(&of_time)?.into_iter();
        let of_end = |Part { program, frame }| match time {
            Input::Coordinate(clock) => Part { program: program.moving(clock), frame },
            _ => Part { program, frame },
        };
        Ok(Self(parts.map(of_end).collect()))
    }

    /// The length of the next step from t, at most h > 0: up to just before the next break, or
    /// across the break at t. `frames` are the values of closed parts.
    pub(super) fn step<T: Scalar>(&self, frames: &[T], t: T, h: T) -> T {
        if self.is_empty() {
            return h;
        }
        T::from_lanes(|lane| {
            self.step_of_lane(&self.of_lane(frames, lane), t.lane(lane), h.lane(lane))
        })
    }

    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Whether a break lies between two times.
    pub(super) fn is_between<T: Scalar>(&self, frames: &[T], [from, to]: [T; 2]) -> bool {
        !self.is_empty()
            && (0..T::LANES).any(|lane| {
                let (a, b) = (from.lane(lane), to.lane(lane));
                let grain = MARGIN * f64::EPSILON * a.abs().max(b.abs());
                self.first(&self.of_lane(frames, lane), [a.min(b), a.max(b)], grain).is_some()
            })
    }

    /// The values of closed parts in one lane.
    fn of_lane<T: Scalar>(&self, frames: &[T], lane: usize) -> Vec<Vec<Interval>> {
        let at = |part: &Part| -> Vec<Interval> {
            let frame = frames[part.frame.clone()].iter();
            frame.map(|x| Interval::from_f64(x.lane(lane))).collect()
        };
        self.0.iter().map(at).collect()
    }

    fn step_of_lane(&self, frames: &[Vec<Interval>], t: f64, h: f64) -> f64 {
        // At t = 0 a step may be so short that its roundings vanish.
        let grain = (MARGIN * f64::EPSILON * t.abs().max((t + h).abs())).max(f64::MIN_POSITIVE);
        let Some([start, end]) = self.first(frames, [t, t + h], grain) else { return h };
        if start - t > 2.0 * grain {
            return start - t - grain;
        }
        // The break is left by growing strides, until no zero is near.
        let (mut clear, mut stride) = (end + grain, grain);
        while clear - t < h && self.may_be_zero(frames, [clear, clear + stride]) {
            clear += stride;
            stride += stride;
        }
        (clear - t).min(h)
    }

    /// The first part of a span, of a width of at most `grain`, in which a zero is not excluded.
    fn first(&self, frames: &[Vec<Interval>], span: [f64; 2], grain: f64) -> Option<[f64; 2]> {
        // The parts that are left, the earliest last.
        let mut parts = vec![span];
        let mut evaluations = 0;
        while let Some([a, b]) = parts.pop() {
            if !self.may_be_zero(frames, [a, b]) {
                continue;
            }
            evaluations += 1;
            let middle = 0.5 * a + 0.5 * b;
            if b - a <= grain || evaluations > MOST_EVALUATIONS || !(a < middle && middle < b) {
                return Some([a, b]);
            }
            parts.extend([[middle, b], [a, middle]]);
        }
        None
    }

    fn may_be_zero(&self, frames: &[Vec<Interval>], [a, b]: [f64; 2]) -> bool {
        let t = Interval::new(a, b);
        self.0.iter().zip(frames).any(|(part, frame)| {
            let mut zero = false;
            part.program.run(frame, &time_point(&[], t), |_, x: Interval| {
                zero |= x.contains(0.0) || !x.is_bounded();
            });
            zero
        })
    }
}
