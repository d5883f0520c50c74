//! The error allowed for a step, given the tolerance of the run.
//!
//! Errors are those of q, of p, and of energies. Energies are w, and the momenta of motors, which
//! account for the energy of a drive. The coordinates of motors are times, which have no error.

use crate::kernels::reductions::see_size;
use afterbay_core::{Scalar, State, Tolerance, Vector, larger_or_nan};
use std::array::from_fn;

/// The error allowed for a step relative to its share of the error of the run. With the default
/// [`target_error`](afterbay_core::StepControl::target_error) of 0.2 steps aim at a fifth of the
/// allowed error, that is, at their share. The value is calibrated, not derived: where errors have
/// one sign and are not damped, as on an oscillator without friction, the error at the end then
/// equals the tolerance, and over the test set it is nowhere above ten times the tolerance
/// (`adaptive_accuracy` in the tests prints both).
pub(crate) const SHARES: f64 = 5.0;
/// Roundings of q, p and w that are allowed for any step.
pub(crate) const ROUNDINGS: f64 = 4.0;
/// The number of entries processed side by side.
const LANES: usize = 8;

/// The tolerance of a run over a time span.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Budget {
    tolerance: Tolerance,
    span: f64,
    /// The degrees of freedom without the motors, whose coordinates are the time.
    free: usize,
    /// [`SHARES`] over the span.
    rate: f64,
    /// The time passed in steps, their number, and 1 over the number of the next.
    passed: f64,
    steps: f64,
    next: f64,
}

impl Budget {
    pub(crate) fn new(tolerance: &Tolerance, span: f64, free: usize) -> Self {
        Self {
            tolerance: *tolerance,
            span,
            free,
            rate: SHARES / span,
            passed: 0.0,
            steps: 0.0,
            next: 1.0,
        }
    }

    pub(crate) fn relative(&self) -> f64 {
        self.tolerance.relative
    }

    /// The share of the run's error that a step of this length is allowed.
    pub(crate) fn share_of(&self, length: f64) -> f64 {
        if self.span > 0.0 { SHARES * length / self.span } else { SHARES }
    }

    /// The share of the run's error if all steps have the same: one over their number, which is
    /// estimated as the span over the mean length of the steps so far and of the next, of this
    /// length. The number of steps is least where all have the same error. The sum over the steps
    /// is about that of [`Self::share_of`], and it is larger where the first steps are the longest.
    #[inline]
    pub(crate) fn equal_share(&self, length: f64) -> f64 {
        if self.span > 0.0 { self.rate * (self.passed + length) * self.next } else { SHARES }
    }

    /// The errors of q, p and energies allowed for a step of this length, by [`Self::equal_share`],
    /// and at least a few roundings of the `sizes` of the state.
    #[inline]
    pub(crate) fn allowed_of_equal_steps<T: Scalar>(&self, sizes: Sizes, length: f64) -> [f64; 3] {
        let share = self.equal_share(length);
        let roundings = sizes.roundings(ROUNDINGS * T::EPSILON);
        let allowed = sizes.tolerated(&self.tolerance).map(|error| share * error);
        from_fn(|part| allowed[part].max(roundings[part]))
    }

    /// Counts an accepted step.
    #[inline]
    pub(crate) fn spend(&mut self, length: f64) {
        self.passed += length;
        self.steps += 1.0;
        self.next = (self.steps + 1.0).recip();
    }

    /// The errors of q, p and energies allowed at the end of the run, of which the given share is
    /// allowed for a step from `state`, at which H is `energy`. A step is always allowed a few
    /// roundings.
    #[inline]
    pub(crate) fn scales<V: Vector>(
        &self,
        state: &State<V>,
        energy: V::Scalar,
        share: f64,
    ) -> [f64; 3] {
        let rounding = ROUNDINGS * V::Scalar::EPSILON / share;
        scales(&self.tolerance, Sizes::of(state, energy, self.free), rounding)
    }
}

/// The sizes of a state.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sizes {
    /// max |q_j| and max |p_j|, without motors.
    pub(crate) q: f64,
    pub(crate) p: f64,
    /// The largest |w_j| or momentum of a motor.
    energies: f64,
    /// The larger of this and |H|: the rounding of an energy is that of the largest. An empty
    /// reservoir would need any number of steps otherwise.
    rounded_energies: f64,
}

impl Sizes {
    /// The sizes of `state`, at which H is `energy`, with `free` degrees of freedom before motors.
    #[inline(always)]
    pub(crate) fn of<V: Vector>(state: &State<V>, energy: V::Scalar, free: usize) -> Self {
        let [q, p] = [&state.q, &state.p].map(|x| size_of_first_or_nan(x, free));
        let mut energies = size_or_nan(&state.w);
        if free < V::LEN.unwrap_or(state.dof()) {
            let supplied = state.p.as_slice()[free..].iter();
            energies = supplied.fold(energies, |most, p| larger_or_nan(most, p.to_f64().abs()));
        }
        let rounded_energies = energy.to_f64().abs().max(energies);
        Self { q, p, energies, rounded_energies }
    }

    /// The errors of q, p and energies that a tolerance allows at these sizes.
    #[inline(always)]
    fn tolerated(&self, tolerance: &Tolerance) -> [f64; 3] {
        let &Tolerance { relative, absolute, w_relative, w_absolute } = tolerance;
        let &Self { q, p, energies, .. } = self;
        [relative * q + absolute, relative * p + absolute, w_relative * energies + w_absolute]
    }

    /// Errors of q, p and energies of this share of their sizes.
    #[inline(always)]
    fn roundings(&self, rounding: f64) -> [f64; 3] {
        [self.q, self.p, self.rounded_energies].map(|size| rounding * size)
    }
}

/// The errors of q, p and energies that a tolerance allows at these sizes, at least `rounding`
/// times the size.
#[inline(always)]
pub(crate) fn scales(tolerance: &Tolerance, sizes: Sizes, rounding: f64) -> [f64; 3] {
    let (allowed, roundings) = (sizes.tolerated(tolerance), sizes.roundings(rounding));
    from_fn(|part| allowed[part].max(roundings[part]))
}

/// max |x_j| over the first `count` entries, or NaN if one of them is not finite.
#[inline(always)]
pub(crate) fn size_of_first_or_nan<V: Vector>(x: &V, count: usize) -> f64 {
    let entries = x.as_slice();
    if count == entries.len() {
        return size_or_nan(x);
    }
    let sizes = entries[..count].iter().map(|x| x.to_f64().abs());
    sizes.fold(0.0, larger_or_nan)
}

/// max |x_j|, or NaN if an entry is not finite.
#[inline(always)]
pub(crate) fn size_or_nan<V: Vector>(x: &V) -> f64 {
    let see = |found: [f64; 2], x: &V::Scalar| see_size(found, x.to_f64().abs());
    let nothing = [0.0; 2];
    let [most, poison] = if V::LEN.is_some() {
        x.as_slice().iter().fold(nothing, see)
    } else {
        let (blocks, rest) = x.as_slice().as_chunks::<LANES>();
        let lanes = blocks
            .iter()
            .fold([nothing; LANES], |lanes, block| from_fn(|lane| see(lanes[lane], &block[lane])));
        let most = lanes.iter().fold(0.0, |most: f64, lane| most.max(lane[0]));
        let poison = lanes.iter().map(|lane| lane[1]).sum();
        rest.iter().fold([most, poison], see)
    };
    most + poison
}
