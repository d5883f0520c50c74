//! Systems with a clock, with a drive, or with both, and the runs of every method on them.

use crate::many::InSeries;
use crate::slope::slope;
use afterbay_core::taylor::trajectory;
use afterbay_core::{
    Abilities, Accounts, Clocked, DissipationForm, Drive, Driven, Formulas, FromFormulas, Grid,
    Motors, Passive, Quad, Scalar, State, StateRef, Tolerance, accounts, with_motors,
};
use afterbay_methods::registry::{FIXED, METHODS, Needs, Row, Setting, bind};
use std::ops::ControlFlow;
use std::sync::Arc;

/// The parameters of Mathieu's equation.
pub(crate) const A: f64 = 1.2;
pub(crate) const B: f64 = 0.7;
pub(crate) const C: f64 = 0.3;
/// The masses of two particles.
pub(crate) const MASSES: [f64; 2] = [1.0, 2.0];

/// One or two particles. One type of them all, since the derivatives of each type of formulas are
/// compiled for themselves.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Model {
    /// Mathieu's equation with friction, V = (a - 2 b cos 2t) q²/2. The last coordinate is the
    /// time.
    Mathieu,
    /// Two particles in a well that breathes, coupled by a spring whose end moves, with drag that
    /// depends on the place, the velocity and the time. The last coordinate is the time.
    Breathing,
    /// [`Breathing`] with friction D = R(t) v, which couples the momenta, in place of drag.
    Rubbed,
    /// Two particles in a quartic well, coupled by a nonlinear spring, with drag that depends on
    /// the place.
    Pair { drag: bool },
    /// One particle in a quartic well.
    Single { drag: bool },
}

use Model::{Breathing, Mathieu, Pair, Rubbed, Single};

impl Model {
    fn has_clock(self) -> bool {
        matches!(self, Mathieu | Breathing | Rubbed)
    }
}

fn number<T: Scalar>(x: f64) -> T {
    T::from_f64(x)
}

/// sin and cos, compiled once for each number.
#[inline(never)]
fn sin_cos<T: Scalar>(angle: T) -> (T, T) {
    angle.sin_cos()
}

#[inline(never)]
fn quartic<T: Scalar>(q: T) -> T {
    (q * q * q * q).half().half()
}

impl Formulas for Model {
    fn dof(&self) -> usize {
        match self {
            Single { .. } => 1,
            Mathieu | Pair { .. } => 2,
            Breathing | Rubbed => 3,
        }
    }
    fn potential<T: Scalar>(&self, q: &[T]) -> T {
        match self {
            Mathieu => {
                let stiffness = number::<T>(A) - number::<T>(2.0 * B) * sin_cos(q[1] + q[1]).1;
                stiffness * (q[0] * q[0]).half()
            }
            Breathing | Rubbed | Pair { .. } => {
                let (mut breath, mut twist) = (T::one(), q[1] - q[0]);
                if self.has_clock() {
                    breath += number::<T>(0.3) * sin_cos(number::<T>(1.3) * q[2]).0;
                    twist -= number::<T>(0.4) * sin_cos(number::<T>(0.9) * q[2]).1;
                }
                breath * (q[0] * q[0] + q[1] * q[1]).half() + quartic(q[0]) - sin_cos(twist).1
            }
            Single { .. } => (q[0] * q[0]).half() + quartic(q[0]),
        }
    }
    fn dissipation<T: Scalar>(&self, q: &[T], v: &[T], j: usize) -> T {
        let cubic = number::<T>(0.1) * v[j] * v[j] * v[j];
        match self {
            Mathieu if j == 0 => number::<T>(C) * v[0],
            Breathing if j < 2 => {
                let wave = T::one() + sin_cos(q[2] + q[2]).1.half();
                number::<T>(0.3) * v[j] * wave * (T::one() + q[j] * q[j]) + cubic
            }
            Rubbed if j < 2 => {
                let cross = number::<T>(0.1) * (T::one() + sin_cos(q[2]).0.half());
                number::<T>(0.4) * v[j] + cross * v[1 - j]
            }
            Pair { drag: true } => {
                number::<T>(0.3) * v[j] * (T::one() + q[0] * q[1].half()) + cubic
            }
            Single { drag: true } => number::<T>(0.25) * v[0] * (T::one() + q[0] * q[0]),
            _ => T::zero(),
        }
    }
    fn dissipation_form(&self) -> DissipationForm {
        let passive = DissipationForm { passive: Passive::Each, ..DissipationForm::GENERAL };
        match self {
            Mathieu => DissipationForm { linear: true, ..passive },
            Breathing => passive,
            Rubbed => {
                DissipationForm { passive: Passive::InSum, linear: true, coupled: true, ..passive }
            }
            Pair { .. } | Single { .. } => DissipationForm::GENERAL,
        }
    }
    fn mass(&self, j: usize) -> f64 {
        match self {
            Breathing | Rubbed | Pair { .. } if j < 2 => MASSES[j],
            _ => 1.0,
        }
    }
    fn may_be_singular(&self) -> bool {
        false
    }
}

/// F_j = a_j cos(ω_j t) (1 + q_j²/4), or without the dependence on q_j.
#[derive(Clone, Copy)]
pub(crate) struct Shaker {
    pub(crate) driven: &'static [usize],
    pub(crate) amplitudes: [f64; 2],
    pub(crate) frequencies: [f64; 2],
    pub(crate) depends_on_place: bool,
}

impl Shaker {
    /// The force a cos ωt on the first degree of freedom.
    pub(crate) fn of_first(amplitude: f64, frequency: f64) -> Self {
        let (amplitudes, frequencies) = ([amplitude, 0.0], [frequency, 0.0]);
        Self { driven: &[0], amplitudes, frequencies, depends_on_place: false }
    }

    /// sin and cos of ω t times the amplitude.
    fn waves<T: Scalar>(&self, k: usize, t: T) -> [T; 2] {
        let (sin, cos) = sin_cos(number::<T>(self.frequencies[k]) * t);
        [sin, cos].map(|x| number::<T>(self.amplitudes[k]) * x)
    }

    fn profile<T: Scalar>(&self, k: usize, q: &[T]) -> T {
        let q = q[self.driven[k]];
        if self.depends_on_place { (q * q).half().half() + T::one() } else { T::one() }
    }
}

impl<T: Scalar> Drive<T> for Shaker {
    fn driven(&self) -> &[usize] {
        self.driven
    }
    fn force(&self, k: usize, q: &[T], t: T) -> T {
        self.waves(k, t)[1] * self.profile(k, q)
    }
    fn slopes(&self, k: usize, q: &[T], t: T, put: &mut dyn FnMut(Option<usize>, T)) {
        let [sin, cos] = self.waves(k, t);
        if self.depends_on_place {
            put(Some(self.driven[k]), cos * q[self.driven[k]].half());
        }
        put(None, -(number::<T>(self.frequencies[k]) * sin * self.profile(k, q)));
    }
    fn depends_on_own(&self, _k: usize) -> bool {
        self.depends_on_place
    }
}

/// A model, and what drives it.
#[derive(Clone, Copy)]
pub(crate) struct Scene {
    pub(crate) model: Model,
    pub(crate) drive: Option<Shaker>,
}

impl Scene {
    pub(crate) fn motors(&self) -> Motors {
        let driven = self.drive.map_or_else(Vec::new, |drive| drive.driven.to_vec());
        Motors { has_clock: self.model.has_clock(), driven }
    }

    /// The number of degrees of freedom without motors.
    fn dof(&self) -> usize {
        self.model.dof() - usize::from(self.model.has_clock())
    }

    pub(crate) fn system<T: Scalar>(&self) -> Arc<dyn Abilities<T>> {
        let mut system: Arc<dyn Abilities<T>> = Arc::new(FromFormulas(self.model));
        if self.model.has_clock() {
            system = Arc::new(Clocked::new(system).unwrap());
        }
        let Some(drive) = self.drive else { return system };
        let drive: Arc<dyn Drive<T>> = Arc::new(drive);
        Arc::new(Driven::new(system, drive).unwrap())
    }

    /// The system in power series. It has no abilities there.
    fn series(&self) -> Arc<InSeries<Quad>> {
        let mut system: Arc<InSeries<Quad>> = Arc::new(FromFormulas(self.model));
        if self.model.has_clock() {
            system = Arc::new(Clocked::new(system).unwrap());
        }
        match self.drive {
            Some(drive) => Arc::new(Driven::new(system, Arc::new(drive)).unwrap()),
            None => system,
        }
    }

    pub(crate) fn start<T: Scalar>(&self) -> State<Vec<T>> {
        let numbers = |x: [f64; 2]| x[..self.dof()].iter().map(|&x| T::from_f64(x)).collect();
        let state = State::new(numbers([1.1, -0.4]), numbers([0.6, 0.9])).unwrap();
        with_motors(&state, self.motors().count())
    }

    /// [q, p, w, s_t and s] of the degrees of freedom.
    pub(crate) fn parts<T: Scalar>(&self, state: StateRef<'_, T>) -> [Vec<T>; 4] {
        let (dof, found) = (self.dof(), accounts(state, &self.motors()).unwrap());
        let gained = found.pumped.into_iter().chain(found.s).collect();
        [state.q[..dof].to_vec(), state.p[..dof].to_vec(), found.w, gained]
    }

    /// The largest deviation of a motor from the time.
    fn late<T: Scalar>(&self, state: StateRef<'_, T>) -> f64 {
        let motors = state.q[self.dof()..].iter();
        motors.map(|&q| (q - state.t).to_f64().abs()).fold(0.0, f64::max)
    }

    /// Checks the methods with a fixed step that `takes` admits and that apply: the orders of the
    /// largest errors of q, p, w and s over [0, 1], K and the motors. Returns their number.
    pub(crate) fn check_orders(&self, takes: &dyn Fn(&Row) -> bool) -> usize {
        let (system, start) = (self.system::<Quad>(), self.start());
        let (total, mut tested) = (start.total(&*system), 0);
        let shortest = Quad::ONE / Quad::from_f64(REFERENCES as f64);
        let exact = trajectory(&*self.series(), &start, shortest, REFERENCES).unwrap();
        for row in FIXED.iter().filter(|row| takes(row)) {
            let Ok(run) = bind::<Quad>(row, system.clone()) else { continue };
            let (counts, mut errors) = (counts(row), [(); 4].map(|()| Vec::new()));
            let [mut off, mut late] = [0.0_f64; 2];
            for &steps in counts {
                let each = REFERENCES / steps as usize;
                let (mut state, h) = (start.clone(), shortest * Quad::from_f64(each as f64));
                let grid = Grid { h, steps };
                let mut worst = [0.0_f64; 4];
                run.run(grid, &mut state, 1, &mut |step, state| {
                    late = late.max(self.late(state));
                    off = off.max((state.total(&*system) - total).to_f64().abs());
                    let exact = self.parts(exact[step as usize * each].state_ref());
                    for ((worst, found), exact) in
                        worst.iter_mut().zip(self.parts(state)).zip(exact)
                    {
                        let far = found.iter().zip(exact).map(|(&a, b)| (a - b).to_f64().abs());
                        *worst = far.fold(*worst, f64::max);
                    }
                    ControlFlow::Continue(())
                })
                .unwrap();
                errors.iter_mut().zip(worst).for_each(|(errors, worst)| errors.push(worst));
            }
            let steps: Vec<f64> = counts.iter().map(|&count| 1.0 / count as f64).collect();
            for found in errors.map(|errors| slope(&steps, &errors)) {
                let order = row.order().number().expect("not exact");
                let apart = (found - f64::from(order)).abs();
                assert!(apart < 0.1, "{}: {found:.3}, not {order}", row.name);
            }
            assert!(!row.keeps_k || off < 1e-28, "{}: K is off by {off:e}", row.name);
            // The time loops compute t in `f64`. A relaxed step ends late by its lag.
            let most = if is_relaxed(row) { 1e-6 } else { 1e-15 };
            assert!(late < most, "{}: a motor is off by {late:e}", row.name);
            tested += 1;
        }
        tested
    }

    /// Runs every method over [0, 6], checks K and the motors, which may lag by `lag` under relaxed
    /// steps, and passes on the energies exchanged. Returns the number of methods.
    pub(crate) fn run_all(&self, lag: f64, see: &mut dyn FnMut(&Row, u64, Accounts<f64>)) -> usize {
        let (system, motors, mut tested) = (self.system::<f64>(), self.motors(), 0);
        for row in METHODS {
            let Ok(run) = bind::<f64>(row, system.clone()) else { continue };
            let mut state = self.start::<f64>();
            let total = state.total(&*system);
            let setting = if row.is_adaptive() {
                Setting::Tolerance(Tolerance::all(1e-8), 6.0)
            } else {
                Setting::Step(Grid::of(0.05, 120).unwrap())
            };
            run.run(setting, &mut state, 1, &mut |step, state| {
                let (late, most) = (self.late(state), if is_relaxed(row) { lag } else { 1e-13 });
                assert!(late < most, "{} at step {step}: a motor is off by {late:e}", row.name);
                let off = (state.total(&*system) - total).abs();
                assert!(!row.keeps_k || off < 1e-12, "{}: K is off by {off:e}", row.name);
                see(row, step, accounts(state, &motors).unwrap());
                ControlFlow::Continue(())
            })
            .unwrap_or_else(|error| panic!("{}: {error}", row.name));
            tested += 1;
        }
        tested
    }
}

/// The number of steps of the exact solution, a multiple of all [`counts`].
const REFERENCES: usize = 256 * 3 * 5 * 7;

/// Numbers of steps at which the leading term of the error dominates.
fn counts(row: &Row) -> &'static [u64] {
    // The next term of a step that is its own adjoint is two powers of h smaller.
    let symmetric = row.needs != Needs::Any;
    match row.order().number().unwrap_or(u32::MAX) {
        2..=4 if symmetric => &[64, 96, 128],
        0..=4 => &[128, 192, 256],
        5..=6 => &[32, 48, 64],
        7..=8 if symmetric => &[32, 40, 48],
        7..=8 => &[48, 64, 80],
        9..=12 => &[12, 16, 20],
        13..=14 => &[12, 14, 16],
        _ => &[8, 10, 12],
    }
}

pub(crate) fn is_relaxed(row: &Row) -> bool {
    row.name.starts_with("relaxed")
}
