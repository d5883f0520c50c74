//! Trajectories by successive expansions.

use super::defect::ALLOWED_ROUNDINGS;
use super::{Defect, Expansion, Sampled};
use crate::error::InputError;
use crate::numbers::{Mask, Scalar, Series, Vector};
use crate::run::Grid;
use crate::system::{State, System};

/// The length of strides and the disturbances of a trajectory.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    /// The longest stride, as a share of the reach of its expansion.
    pub share: f64,
    /// The size of the disturbance of every entry that is not at rest, in unit roundoffs of the
    /// largest entry of q, of p and of w, with a pseudo-random sign: at the end of each stride and
    /// where a state is passed on.
    pub off: f64,
    /// The largest number of strides.
    pub strides: usize,
}

impl Pace {
    /// The longest strides, without disturbance.
    pub const FULL: Self = Self { share: 1.0, off: 0.0, strides: usize::MAX };

    /// Shorter strides than [`Pace::FULL`], each disturbed by the error that one of those may have.
    /// The distance of the two trajectories shows how these errors grow.
    pub const CHECK: Self = Self { share: 0.75, off: ALLOWED_ROUNDINGS, strides: usize::MAX };

    /// The pace with a limit on the number of strides.
    pub const fn within(self, strides: usize) -> Self {
        Self { strides, ..self }
    }
}

/// A summary of a computed trajectory.
#[derive(Clone, Copy, Debug, Default)]
pub struct Route {
    /// The number of expansions.
    pub strides: usize,
    /// The longest time of a feature that may have been missed, in the unit of time of the system;
    /// 0 if the defect was enclosed.
    pub unseen: f64,
    /// The computation was interrupted before the end.
    pub interrupted: bool,
}

/// The number of strides after which the total is extrapolated. A choice.
const STRIDES_BEFORE_FORECAST: usize = 64;

/// The largest number of successive shortest strides, and the number of them after which the stride
/// across a kink is doubled. Choices: 128/4 doublings lengthen it by 2³².
const MOST_SHORT_STRIDES: u32 = 128;
const STRIDES_PER_DOUBLING: u32 = 4;

/// Computes the flow from `start` by expansions with M terms and passes its states at the times of
/// the grid, counted from the start, to `see`.
///
/// The flow is analytic between [`System::kinks`]. Strides end just before a kink, closer each
/// time, until one of a few roundings of t crosses it; a jump of the field has an effect for no
/// longer than that. A stride ends where its `defect` is no longer small. `stop` is called before
/// each.
///
/// # Errors
/// [`InputError::Length`] and [`InputError::NotFinite`] if `start` is no state of the system.
/// [`InputError::Step`] if the end of the grid is not finite. [`InputError::SolutionEnds`] if the
/// strides shrink to 0: at a blow-up, at a singularity such as √x at 0, and where the flow stays on
/// a kink. [`InputError::Budget`] if more strides are needed than `pace` allows.
pub fn follow<S, V, const M: usize>(
    system: &S,
    defect: &dyn Defect<V, M>,
    start: &State<V>,
    Grid { h, steps }: Grid<V::Scalar>,
    pace: Pace,
    stop: &dyn Fn() -> bool,
    see: &mut dyn FnMut(u64, State<V>),
) -> Result<Route, InputError>
where
    V: Vector,
    S: System<Series<V::Scalar, M>> + ?Sized,
{
    let dof = system.dof();
    start.check(dof)?;
    let end = V::Scalar::from_f64(steps as f64) * h;
    if !end.is_finite().all() {
        return Err(InputError::Step { h: h.to_f64() });
    }
    let mut dice = Dice(1);
    let mut route = Route::default();
    let trusted = |expansion: &Expansion<V, M>, origin: V::Scalar| {
        let ahead = (end - origin).to_f64();
        let limit = (pace.share * expansion.reach).min(ahead.abs()).copysign(ahead);
        let clear = expansion.clear(system, limit);
        let leaps = clear <= shortest(origin.to_f64());
        if leaps { clear } else { clear * defect.solved(expansion, clear.copysign(ahead)) }
    };
    let mut expansion = Expansion::<V, M>::about(system, start);
    // The time of the point of expansion, and the length of the stride from there.
    let mut origin = V::Scalar::zero();
    let mut clear = trusted(&expansion, origin);
    let mut short = 0;
    for i in 0..=steps {
        let t = V::Scalar::from_f64(i as f64) * h;
        while (t - origin).to_f64().abs() > clear {
            if stop() {
                route.interrupted = true;
                return Ok(route);
            }
            let shortest = shortest(t.to_f64());
            short = if clear > shortest { 0 } else { short + 1 };
            let stride = clear.max(leap::<V::Scalar>(t.to_f64(), short)).copysign(h.to_f64());
            let mut state = expansion.at(V::Scalar::from_f64(stride));
            if state.check(dof).is_err()
                || expansion.reach <= shortest
                || short > MOST_SHORT_STRIDES
            {
                return Err(InputError::SolutionEnds { t: (start.t + origin).to_f64() });
            }
            if pace.off > 0.0 {
                dice.disturb(&mut state, &expansion, system.motors(), stride, pace.off);
            }
            state.set_tiny_to_zero();
            origin += V::Scalar::from_f64(stride);
            route.strides += 1;
            route.unseen = route.unseen.max(defect.unseen(stride));
            route.check(pace.strides, origin.to_f64() / end.to_f64())?;
            expansion = Expansion::about(system, &state);
            clear = trusted(&expansion, origin);
        }
        let mut state = expansion.at(t - origin);
        if pace.off > 0.0 && i > 0 {
            let tau = (t - origin).to_f64();
            dice.disturb(&mut state, &expansion, system.motors(), tau, pace.off);
        }
        see(i, State { t: start.t + t, ..state });
    }
    Ok(route)
}

/// The longest stride that counts as one that ends at a kink or a singularity, as a share of t.
const SHORTEST: f64 = 1e-12;

/// The longest stride that counts as one that ends at a kink or a singularity.
fn shortest(t: f64) -> f64 {
    SHORTEST * t.abs()
}

/// The stride across a kink at t after a number of successive shortest strides.
fn leap<T: Scalar>(t: f64, short: u32) -> f64 {
    4.0 * T::EPSILON * t.abs() * 2f64.powi((short / STRIDES_PER_DOUBLING) as i32)
}

impl Route {
    /// Checks the number of strides, and its extrapolation by the share of the time done.
    fn check(&self, limit: usize, share: f64) -> Result<(), InputError> {
        let will = self.strides as f64 / share;
        let early =
            self.strides > STRIDES_BEFORE_FORECAST.max(limit / 16) && will > 4.0 * limit as f64;
        if self.strides > limit || early {
            return Err(InputError::Budget {
                steps: will.max(self.strides as f64),
                limit: limit as f64,
            });
        }
        Ok(())
    }
}

/// Pseudo-random signs, the same in every run.
struct Dice(u64);

impl Dice {
    fn sign(&mut self) -> f64 {
        // Knuth's linear congruential generator.
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        if self.0 >> 63 == 0 { 1.0 } else { -1.0 }
    }

    /// Disturbs the entries that are not at rest, by `off` unit roundoffs of the largest at τ. The
    /// times of all motors are disturbed alike: their forces would otherwise jump or bend one after
    /// the other.
    fn disturb<V: Vector, const M: usize>(
        &mut self,
        state: &mut State<V>,
        expansion: &Expansion<V, M>,
        motors: usize,
        tau: f64,
        off: f64,
    ) {
        let Expansion { series, .. } = expansion;
        let scales = expansion.scales(tau.abs());
        let further_times = state.dof() - motors + 1..state.dof();
        let parts =
            [(&mut state.q, &series.q), (&mut state.p, &series.p), (&mut state.w, &series.w)];
        for (i, ((part, series), scale)) in parts.into_iter().zip(scales).enumerate() {
            let mut sign = 0.0;
            for (j, (x, series)) in
                part.as_mut_slice().iter_mut().zip(series.as_slice()).enumerate()
            {
                if series.c[1..].iter().any(|&c| c != V::Scalar::zero()) {
                    if i > 0 || !further_times.contains(&j) {
                        sign = self.sign();
                    }
                    *x += V::Scalar::from_f64(sign * off * V::Scalar::EPSILON * scale);
                }
            }
        }
    }
}

/// The flow from `start` at the times `i h`, i = 0..=count, by expansions with M terms: a reference
/// for systems without a closed solution. The defect is [`Sampled`]. [`follow`] accepts an
/// [enclosed](super::Enclosed) defect and reports how narrow a feature may have been missed.
///
/// # Errors
/// Those of [`follow`].
pub fn trajectory<S, V, const M: usize>(
    system: &S,
    start: &State<V>,
    h: V::Scalar,
    count: usize,
) -> Result<Vec<State<V>>, InputError>
where
    V: Vector,
    S: System<Series<V::Scalar, M>> + ?Sized,
{
    let mut states = Vec::with_capacity(count + 1);
    let (defect, grid) = (Sampled(system), Grid { h, steps: count as u64 });
    follow(system, &defect, start, grid, Pace::FULL, &|| false, &mut |_, state| {
        states.push(state);
    })?;
    Ok(states)
}
