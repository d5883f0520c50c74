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
    /// largest entry of its kind, with a pseudo-random sign: at the end of each stride and where a
    /// state is passed on. The kinds are q, p and w, and q and p of motors.
    pub disturbance: f64,
    /// The largest number of strides.
    pub strides: usize,
}

impl Pace {
    /// The longest strides, without disturbance.
    pub const FULL: Self = Self { share: 1.0, disturbance: 0.0, strides: usize::MAX };

    /// Shorter strides than [`Pace::FULL`], each disturbed by the error that one of those may have.
    /// The distance of the two trajectories shows how these errors grow.
    pub const CHECK: Self =
        Self { share: 0.75, disturbance: ALLOWED_ROUNDINGS, strides: usize::MAX };

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
/// The flow is analytic between [`System::kinks`]. Strides approach a kink until a stride of a few
/// roundings of t crosses it, so that no expansion is used beyond a kink for longer than that. A
/// stride ends where its `defect` is no longer small. `stop` is called before each stride; if it
/// returns true, the computation is interrupted.
///
/// # Errors
/// [`InputError::Length`] and [`InputError::NotFinite`] if `start` is no state of the system.
/// [`InputError::End`] if the end of the grid is not finite. [`InputError::SolutionEnds`] if the
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
    start.check_with(dof, || system.motors())?;
    let end = V::Scalar::from_f64(steps as f64) * h;
    if !end.is_finite().all() {
        return Err(InputError::End { end: end.to_f64() });
    }
    let mut trajectory = Trajectory::new(system, defect, start, end, pace);
    for i in 0..=steps {
        let t = V::Scalar::from_f64(i as f64) * h;
        while !trajectory.covers(t) {
            if stop() {
                trajectory.route.interrupted = true;
                return Ok(trajectory.route);
            }
            trajectory.stride(t)?;
        }
        see(i, trajectory.at(t));
    }
    Ok(trajectory.route)
}

/// A trajectory up to the expansion in use. All times but `start` are counted from `start`.
struct Trajectory<'a, S: ?Sized, V: Vector, const M: usize> {
    system: &'a S,
    defect: &'a dyn Defect<V, M>,
    pace: Pace,
    /// The time at which the trajectory starts.
    start: V::Scalar,
    /// The end of the grid.
    end: V::Scalar,
    expansion: Expansion<V, M>,
    /// The time of the point of expansion.
    origin: V::Scalar,
    /// The length of the stride from there, over which the expansion is a solution.
    clear: f64,
    /// The number of shortest strides in a row.
    short: u32,
    dice: Dice,
    route: Route,
}

impl<'a, S, V, const M: usize> Trajectory<'a, S, V, M>
where
    V: Vector,
    S: System<Series<V::Scalar, M>> + ?Sized,
{
    fn new(
        system: &'a S,
        defect: &'a dyn Defect<V, M>,
        start: &State<V>,
        end: V::Scalar,
        pace: Pace,
    ) -> Self {
        let mut new = Self {
            system,
            defect,
            pace,
            start: start.t,
            end,
            expansion: Expansion::about(system, start),
            origin: V::Scalar::zero(),
            clear: 0.0,
            short: 0,
            dice: Dice(1),
            route: Route::default(),
        };
        new.clear = new.solved();
        new
    }

    /// The length of the next stride: up to a kink, and as long as the defect is small.
    fn solved(&self) -> f64 {
        let ahead = (self.end - self.origin).to_f64();
        let limit = (self.pace.share * self.expansion.reach).min(ahead.abs()).copysign(ahead);
        let clear = self.expansion.clear(self.system, limit);
        let leaps = clear <= shortest(self.origin.to_f64());
        if leaps {
            clear
        } else {
            clear * self.defect.solved(&self.expansion, clear.copysign(ahead))
        }
    }

    /// Whether the expansion in use is a solution up to t.
    fn covers(&self, t: V::Scalar) -> bool {
        (t - self.origin).to_f64().abs() <= self.clear
    }

    /// Moves the point of expansion by one stride, on the way to t.
    fn stride(&mut self, t: V::Scalar) -> Result<(), InputError> {
        let shortest = shortest(t.to_f64());
        self.short = if self.clear > shortest { 0 } else { self.short + 1 };
        let leap = leap::<V::Scalar>(t.to_f64(), self.short);
        let stride = self.clear.max(leap).copysign(self.end.to_f64());
        let mut state = self.expansion.at(V::Scalar::from_f64(stride));
        let is_invalid = state.check(self.system.dof()).is_err();
        if is_invalid || self.expansion.reach <= shortest || self.short > MOST_SHORT_STRIDES {
            return Err(InputError::SolutionEnds { t: (self.start + self.origin).to_f64() });
        }
        self.disturb(&mut state, stride);
        state.set_tiny_to_zero();
        self.origin += V::Scalar::from_f64(stride);
        self.route.strides += 1;
        self.route.unseen = self.route.unseen.max(self.defect.unseen(stride));
        self.route.check(self.pace.strides, self.origin.to_f64() / self.end.to_f64())?;
        self.expansion = Expansion::about(self.system, &state);
        self.clear = self.solved();
        Ok(())
    }

    /// The state at t, which the expansion in use covers. That at the start is not disturbed.
    fn at(&mut self, t: V::Scalar) -> State<V> {
        let mut state = self.expansion.at(t - self.origin);
        if t != V::Scalar::zero() {
            self.disturb(&mut state, (t - self.origin).to_f64());
        }
        State { t: self.start + t, ..state }
    }

    /// Disturbs a state at the time tau after the point of expansion, if the pace says so.
    fn disturb(&mut self, state: &mut State<V>, tau: f64) {
        let size = self.pace.disturbance;
        if size > 0.0 {
            self.dice.disturb(state, &self.expansion, self.system.motors(), tau, size);
        }
    }
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

    /// Disturbs the entries that are not at rest, by `size` unit roundoffs of the largest of their
    /// kind at τ. The times of all motors are disturbed alike: their forces would otherwise have
    /// kinks one after the other.
    fn disturb<V: Vector, const M: usize>(
        &mut self,
        state: &mut State<V>,
        expansion: &Expansion<V, M>,
        motors: usize,
        tau: f64,
        size: f64,
    ) {
        let Expansion { series, .. } = expansion;
        let scales = expansion.scales(tau.abs());
        let further_times = state.dof() - motors + 1..state.dof();
        let parts =
            [(&mut state.q, &series.q), (&mut state.p, &series.p), (&mut state.w, &series.w)];
        for (i, (part, series)) in parts.into_iter().enumerate() {
            let mut sign = 0.0;
            for (j, (x, series)) in
                part.as_mut_slice().iter_mut().zip(series.as_slice()).enumerate()
            {
                if series.c[1..].iter().any(|&c| c != V::Scalar::zero()) {
                    if i > 0 || !further_times.contains(&j) {
                        sign = self.sign();
                    }
                    let scale = scales[expansion.kinds(j)[i]];
                    *x += V::Scalar::from_f64(sign * size * V::Scalar::EPSILON * scale);
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
    let mut states = Vec::new();
    let (defect, grid) = (Sampled(system), Grid { h, steps: count as u64 });
    follow(system, &defect, start, grid, Pace::FULL, &|| false, &mut |_, state| {
        states.push(state);
    })?;
    Ok(states)
}
