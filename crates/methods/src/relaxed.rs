//! Explicit Runge-Kutta methods with relaxation, which conserve K on any system.
//!
//! ```text
//! z = (q, p)        f = (∂H/∂p, -∂H/∂q - D)        v = ∂H/∂p
//! Z_i = z0 + η Σ_j a_ij f(Z_j)
//! d = η Σ_i b_i f(Z_i)        e_j = η Σ_i b_i D_j(Z_i) v_j(Z_i)
//! z1 = z0 + γ d        w1 = w0 + γ e        with γ near 1 such that H(z1) + Σ w1_j = K
//! ```
//!
//! Sources: D. I. Ketcheson, SIAM J. Numer. Anal. 57 (2019) 2850-2870; H. Ranocha and others, SIAM
//! J. Sci. Comput. 42 (2020) A612-A638. With a tableau of order r, γ = 1 + O(h^{r-1}), and (z1, w1)
//! is accurate to O(h^{r+1}) at the time t0 + γη, not at t0 + η. Since the grid times are fixed, η
//! is chosen such that γη ends at the grid point: η = (h - lag)/γ', where γ' is the γ of the last
//! step and the lag is the time by which the last step ended late. γ changes by O(h^r) from step to
//! step, which leaves a lag of O(h^{r+1}) that does not accumulate. Where γ' predicts γ badly, and
//! at the start, the stages are computed a second time with the γ just found. The orders at the
//! grid points are therefore r in q, p and w.
//!
//! The workspace stores the lag, γ', H and the target K. They are used only if the state is the one
//! with which the last step ended. K is then that of the first step, so its rounding errors do not
//! accumulate. For any other state K is computed anew and the lag is 0.
//!
//! [`Relaxed::rk4`], the classical tableau, has positive weights and γ > 0, so it is passive where
//! the system is. [`Relaxed::dop853`] of order 8 and [`Relaxed::verner98`] of order 9 have negative
//! weights and are not passive.
//!
//! K depends on γ through f·H''f, the curvature of H along the step. Where that is small beside its
//! terms, as on the flanks of a double well, where it changes sign, γ would be far from 1. Such a
//! step has γ = 1, and (q, p) is moved along ∇H instead, by the size of the error of the step. If γ
//! is not near 1 in a step from rest, in which a drive begins, the step has γ = 1 as well, and
//! (q, p) is moved along d (`rest.rs`).
//!
//! A step **fails** with [`StepFailure::NoRelaxationRoot`], and leaves the state unchanged, where γ
//! is not within ½ of 1, the move along ∇H longer than 1/16 of the increments, or that from rest
//! longer than four times d. This happens beyond the
//! limit of stability, which relaxation does not change (|hλ| ≈ 2.8 for rk4).
//!
//! Systems whose V or D has kinks in t are refused: a step that ends late by its error may
//! cross one, which moves γ and the time of the state. A step that changes K by roundings
//! alone has γ = 1. Terms that cancel inside H have roundings that |H| does not show; these are
//! measured. The roundings are taken from the w_j that gains most, if it gains more than that. The
//! scalar must hold one number: there are no lanes.

mod direction;
mod rest;
mod root;
mod track;

use crate::commit::commit;
use crate::registry::binding::{Binding, Bound, Target};
use crate::runge_kutta::{Classical, Dop853, Tableau, Verner98};
use afterbay_core::{
    Abilities, Effort, InputError, Method, Scalar, State, StepFailure, System, Vector,
};
use direction::Direction;
use root::Chord;
use track::{Known, Track};

/// An explicit Runge-Kutta method with relaxation.
#[derive(Clone, Copy, Debug)]
pub struct Relaxed(Scheme);

#[derive(Clone, Copy, Debug)]
enum Scheme {
    Classical,
    Dop853,
    Verner98,
}

impl Relaxed {
    /// The classical Runge-Kutta method, order 4.
    pub const fn rk4() -> Self {
        Self(Scheme::Classical)
    }

    /// The twelve-stage method DOP853, order 8.
    pub const fn dop853() -> Self {
        Self(Scheme::Dop853)
    }

    /// The sixteen-stage method of Verner's pair 9(8), order 9.
    pub const fn verner98() -> Self {
        Self(Scheme::Verner98)
    }
}

/// The stages are recomputed if the last γ differs from the new one by more than this share of γ -
/// 1. It bounds the lag of a step by the same share of h (γ - 1).
const PREDICTION_TOLERANCE: f64 = 0.125;

/// The direction of a step, the chord from the old state to the new one, and the data of the last
/// step.
#[derive(Clone, Debug)]
pub struct Workspace<V: Vector> {
    direction: Direction<V>,
    chord: Chord<V>,
    track: Track<V>,
}

impl Binding for Relaxed {
    fn bind<V: Vector + 'static>(&self, target: &Target<'_, V::Scalar>) -> Bound<V::Scalar> {
        target.fixed::<V, dyn Abilities<V::Scalar>, _>(*self, target.system.clone())
    }
}

impl<V, S> Method<V, S> for Relaxed
where
    V: Vector,
    S: System<V::Scalar> + ?Sized,
{
    type Workspace = Workspace<V>;

    fn workspace(&self, system: &S) -> Result<Workspace<V>, InputError> {
        if system.has_breaks() {
            let why = "V or D has a kink in t, and a step that ends late by its error may cross \
                       it: take another method, or put the force in [drive]";
            return Err(InputError::Unsupported { method: "relaxed", why });
        }
        let n = system.dof();
        let stages = match self.0 {
            Scheme::Classical => Classical::ROWS.len(),
            Scheme::Dop853 => Dop853::ROWS.len(),
            Scheme::Verner98 => Verner98::ROWS.len(),
        };
        Ok(Workspace {
            direction: Direction::new(system, stages),
            chord: Chord::new(n),
            track: Track::new(n),
        })
    }

    fn sums_reservoir(&self) -> bool {
        true
    }

    fn step(
        &self,
        system: &S,
        h: V::Scalar,
        state: &mut State<V>,
        workspace: &mut Workspace<V>,
    ) -> Result<Effort, StepFailure> {
        let Workspace { direction, chord, track } = workspace;
        let dissipative = !system.dissipation_form().zero;
        let known = track.known(system, h, state);
        let now = known.energy + state.reservoir();
        let ahead = h - known.lag;
        let mut guess = known.gamma;
        let mut effort = direction.begin(system, state);
        let take = |direction: &mut Direction<V>, guess| match self.0 {
            Scheme::Classical => direction.take::<Classical, S>(system, ahead / guess, state),
            Scheme::Dop853 => direction.take::<Dop853, S>(system, ahead / guess, state),
            Scheme::Verner98 => direction.take::<Verner98, S>(system, ahead / guess, state),
        };
        effort += take(direction, guess);
        let mut gamma = chord.relax(system, state, direction, [now, known.total])?;
        let far = (gamma - guess).abs().to_f64()
            > PREDICTION_TOLERANCE * (gamma - V::Scalar::one()).abs().to_f64();
        if far && direction.feel(state, gamma - guess) {
            guess = gamma;
            effort += take(direction, guess);
            gamma = chord.relax(system, state, direction, [now, known.total])?;
        }

        let Chord { q, p, w, .. } = chord;
        commit(state, [q.as_slice(), p.as_slice(), w.as_slice()], dissipative)?;
        let lag = gamma * (ahead / guess) - ahead;
        track.keep(h, state, Known { lag, gamma, energy: chord.energy, total: known.total });
        Ok(effort)
    }
}
