//! Expansions strung together.

use super::defect::ALLOWED;
use super::{Defect, Expansion, Sampled};
use crate::error::InputError;
use crate::numbers::{Scalar, Series, Vector};
use crate::system::{State, System};

/// How a flow is followed.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    /// The longest stride, as a share of the reach of its expansion.
    pub share: f64,
    /// What is found is moved, by chance up or down, by so many roundings of the largest of q, of p and of
    /// w, in every entry that is not at rest: at the end of each stride, and where it is shown.
    pub off: f64,
    /// The most strides there may be.
    pub strides: usize,
}

impl Pace {
    /// As far as expansions reach, without disturbance.
    pub const FULL: Self = Self { share: 1.0, off: 0.0, strides: usize::MAX };

    /// Other strides than [`Pace::FULL`], disturbed at each by as much as one of those may err. How far
    /// the two come apart is what these errors grow to.
    pub const CHECK: Self = Self { share: 0.75, off: ALLOWED, strides: usize::MAX };

    /// The same with a limit on the number of strides.
    pub const fn within(self, strides: usize) -> Self {
        Self { strides, ..self }
    }
}

/// What was done to follow a flow.
#[derive(Clone, Copy, Debug, Default)]
pub struct Route {
    /// Expansions made.
    pub strides: usize,
    /// Features passed in less time than this may have been missed; 0 where the defect was enclosed.
    pub unseen: f64,
    /// It was asked to stop, and did before the end.
    pub interrupted: bool,
}

/// Strides after which it is seen how many there will be.
const FORESEEN: usize = 64;

/// Short strides one after the other that no kink takes, and how many of them make the leap over it
/// twice as long.
const SHORT: u32 = 128;
const TWICE: u32 = 4;

/// Follows the flow from `start` and gives its states at the times `i h`, i = 0..=count, to `see`, by
/// expansions with M terms.
///
/// Between [`System::kinks`] the flow is analytic. Expansions end short of a kink, ever nearer, until a
/// stride of some roundings of t leaps over it: what the field jumps by counts for no longer than that.
/// An expansion is left where its `defect` is no longer small. `stop` is asked before each.
///
/// # Errors
/// [`InputError::Length`] and [`InputError::NotFinite`] where `start` is no state of the system,
/// [`InputError::SolutionEnds`] where the solution leaves the numbers: the reach of the expansions
/// shrinks to nothing. So it does at a singularity such as √x at 0, and the time between kinks where the
/// flow sticks to one. [`InputError::Budget`] where more strides are needed than `pace` allows.
pub fn follow<S, V, const M: usize>(
    (system, defect): (&S, &dyn Defect<V, M>),
    start: &State<V>,
    (h, count): (V::Scalar, usize),
    pace: Pace,
    stop: &dyn Fn() -> bool,
    see: &mut dyn FnMut(usize, State<V>),
) -> Result<Route, InputError>
where
    V: Vector,
    S: System<Series<V::Scalar, M>> + ?Sized,
{
    let dof = system.dof();
    start.check(dof)?;
    let end = V::Scalar::from_f64(count as f64) * h;
    let mut dice = Dice(1);
    let mut route = Route::default();
    let trusted = |expansion: &Expansion<V, M>, origin: V::Scalar| {
        let ahead = (end - origin).to_f64();
        let limit = (pace.share * expansion.reach).min(ahead.abs()).copysign(ahead);
        let clear = expansion.clear(system, limit);
        let leaps = clear <= brief(origin.to_f64());
        if leaps { clear } else { clear * defect.solved(expansion, clear.copysign(ahead)) }
    };
    let mut expansion = Expansion::<V, M>::about(system, start);
    // The time of the point expanded about, and how far it serves from there.
    let mut origin = V::Scalar::zero();
    let mut clear = trusted(&expansion, origin);
    let mut short = 0;
    for i in 0..=count {
        let t = V::Scalar::from_f64(i as f64) * h;
        while (t - origin).to_f64().abs() > clear {
            if stop() {
                route.interrupted = true;
                return Ok(route);
            }
            let brief = brief(t.to_f64());
            short = if clear > brief { 0 } else { short + 1 };
            let leap = 4.0 * V::Scalar::EPSILON * t.to_f64().abs() * 2f64.powi((short / TWICE) as i32);
            let stride = clear.max(leap).copysign(h.to_f64());
            let mut state = expansion.at(V::Scalar::from_f64(stride));
            if state.check(dof).is_err() || expansion.reach <= brief || short > SHORT {
                return Err(InputError::SolutionEnds { t: (start.t + origin).to_f64() });
            }
            if pace.off > 0.0 {
                dice.disturb(&mut state, &expansion, stride, pace.off);
            }
            state.settle();
            origin += V::Scalar::from_f64(stride);
            route.strides += 1;
            route.unseen = route.unseen.max(defect.unseen(stride));
            route.check(pace.strides, origin.to_f64() / end.to_f64())?;
            expansion = Expansion::about(system, &state);
            clear = trusted(&expansion, origin);
        }
        let mut state = expansion.at(t - origin);
        if pace.off > 0.0 && i > 0 {
            dice.disturb(&mut state, &expansion, (t - origin).to_f64(), pace.off);
        }
        see(i, State { t: start.t + t, ..state });
    }
    Ok(route)
}

/// Strides no longer than this are those that end at a kink or a singularity.
fn brief(t: f64) -> f64 {
    1e-12 * t.abs()
}

impl Route {
    /// Are there more strides than there may be, or will there be, by the share of the time done?
    fn check(&self, limit: usize, share: f64) -> Result<(), InputError> {
        let will = self.strides as f64 / share;
        let early = self.strides > FORESEEN.max(limit / 16) && will > 4.0 * limit as f64;
        if self.strides > limit || early {
            return Err(InputError::Budget { steps: will.max(self.strides as f64), limit: limit as f64 });
        }
        Ok(())
    }
}

/// Signs by chance, the same in every run.
struct Dice(u64);

impl Dice {
    fn sign(&mut self) -> f64 {
        // Knuth's linear congruential generator.
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        if self.0 >> 63 == 0 { 1.0 } else { -1.0 }
    }

    /// Moves what the expansion moves, by so many roundings of the largest at τ.
    fn disturb<V: Vector, const M: usize>(
        &mut self,
        state: &mut State<V>,
        expansion: &Expansion<V, M>,
        tau: f64,
        off: f64,
    ) {
        let Expansion { series, .. } = expansion;
        let scales = expansion.scales(tau.abs());
        let parts = [(&mut state.q, &series.q), (&mut state.p, &series.p), (&mut state.w, &series.w)];
        for ((part, series), scale) in parts.into_iter().zip(scales) {
            for (x, series) in part.as_mut_slice().iter_mut().zip(series.as_slice()) {
                if series.0[1..].iter().any(|&c| c != V::Scalar::zero()) {
                    *x += V::Scalar::from_f64(self.sign() * off * V::Scalar::EPSILON * scale);
                }
            }
        }
    }
}

/// The exact flow from `start` at the times `i h`, i = 0..=count, from expansions with M terms: a
/// reference for systems without a closed solution. The defect is [`Sampled`]; [`follow`] tells how
/// narrow a feature may be missed, and follows systems whose defect can be [enclosed](super::Enclosed).
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
    let defect = Sampled(system);
    follow((system, &defect), start, (h, count), Pace::FULL, &|| false, &mut |_, state| states.push(state))?;
    Ok(states)
}
