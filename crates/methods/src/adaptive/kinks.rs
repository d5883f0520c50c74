//! The test whether a step passes a kink of the system.
//!
//! A method has its order only where the solution is smooth. Collocation then errs by the square of
//! its defect, but across a kink by the defect itself. An estimate that is raised to the order of
//! the step misses this error, since the larger terms of the smooth parts hide it.

use afterbay_core::{Scalar, System};

/// The power of h that relates the errors of two steps across a kink, if the second derivative of
/// the slopes jumps there, as that of p|p|.
pub(crate) const KINK_ORDER: u32 = 3;

/// The sides of the kinks on which the points of a step are: -1 or 1, or 0 as long as no point is
/// beside the kink.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sides(Vec<i8>);

impl Sides {
    /// Records the sides of the start (q, p) of a step. Returns whether the system has kinks.
    pub(crate) fn begin<T: Scalar, S: System<T> + ?Sized>(
        &mut self,
        system: &S,
        q: &[T],
        p: &[T],
    ) -> bool {
        let Self(sides) = self;
        sides.clear();
        system.kinks(q, p, &mut |x| sides.push(side(x)));
        !sides.is_empty()
    }

    /// Whether (q, p) is on the other side of a kink than the points before.
    pub(crate) fn passed<T: Scalar, S: System<T> + ?Sized>(
        &mut self,
        system: &S,
        q: &[T],
        p: &[T],
    ) -> bool {
        let (mut passed, mut before) = (false, self.0.iter_mut());
        system.kinks(q, p, &mut |x| {
            if let Some(before) = before.next() {
                let side = side(x);
                passed |= *before * side < 0;
                *before = if *before == 0 { side } else { *before };
            }
        });
        passed
    }
}

fn side<T: Scalar>(x: T) -> i8 {
    let x = x.to_f64();
    i8::from(x > 0.0) - i8::from(x < 0.0)
}
