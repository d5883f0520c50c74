//! A branch of cycles in a parameter λ, by pseudo-arclength continuation.
//!
//! ```text
//! Φ(z; T, λ) = z        t · (x - x0 - s t) = 0        x = (z, T, λ)
//! ```
//!
//! x0 is the cycle before and t the direction of the branch there, so that folds are no obstacle:
//! the equations stay regular where dλ/ds = 0. The unknowns are measured by their sizes, λ by the
//! length of its range. Source: H. B. Keller, in Applications of Bifurcation Theory (1977),
//! 359-384.
//!
//! Where a test function changes its sign ([`Event`]), the bifurcation is located in s
//! (`locate.rs`). At a period doubling the branch of cycles of twice the period begins along
//! the eigenvector of the multiplier -1, and may be followed instead.

mod locate;
mod place;

use super::event;
use super::homoclinic::Approach;
use super::scales::scales_of;
use super::shooting::{Condition, Shooting, Solved, null_vector};
use super::{CycleFailure, Event, Point, phase, steps};
use afterbay_core::IntegrateError;
use faer::Mat;
use place::{Place, dot};

/// The longest step along the branch, and the first, measured by the sizes of the unknowns.
const LONGEST: f64 = 0.05;
const FIRST: f64 = 0.01;
/// The shortest step. If it fails, the branch ends with its failure.
const SHORTEST: f64 = 1e-7;
/// The cosine of the largest angle between two directions.
const STRAIGHT: f64 = 0.9;
/// The numbers of corrections of Newton's method up to which steps become longer, and from which
/// they become shorter.
const EASY: usize = 4;
const HARD: usize = 7;
/// The most cycles of a branch.
const MOST_POINTS: usize = 5_000;
/// The steps become shorter by this factor at each period doubling: the distance of the states of a
/// cycle from those of the cycle before falls by Feigenbaum's α = 2.50.
const ALPHA: f64 = 2.5;
/// The factor by which the size of an unknown may change before it is measured anew.
const RESCALED: f64 = 4.0;
/// Shares of its largest size on the branch: below the first a cycle is small, and below the second
/// it has shrunk.
const SMALL: f64 = 1e-4;
const SHRUNK: f64 = 1e-5;
/// The largest change of the parameter, as a share of its range, from a small cycle to one that has
/// shrunk, at which the cycles shrink to rest. At a Hopf bifurcation the parameter changes with the
/// square of the size of the cycle, and where a force vanishes with the size.
const UNCHANGED: f64 = 1e-6;
/// The least size with which an entry of q and p is measured, as a share of its largest size on the
/// branch, times the share that is left of the entry that has shrunk least. A choice.
const LEAST_SIZE: f64 = 0.1;
/// A branch of cycles in a parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Branch {
    /// The name of the parameter, of the system or of the drive.
    pub parameter: String,
    /// The value at which the branch begins.
    pub from: f64,
    /// The value at which it ends. It also ends where it comes back to the first value.
    pub to: f64,
    /// The number of period doublings to be found, if it is not 0. The branch goes over to the
    /// cycles of twice the period at each of them, and ends at the last. Otherwise it goes on with
    /// cycles that are no longer stable.
    pub doublings: usize,
}

impl Branch {
    /// Follows the branch from a cycle, and adds its cycles to `points`.
    ///
    /// # Errors
    /// The failure at which the branch ends before its end.
    pub(super) fn follow<'a>(
        &'a self,
        mut shooting: Shooting<'a>,
        solved: Solved,
        h: f64,
        points: &mut Vec<Point>,
    ) -> Result<(), CycleFailure> {
        let mut x = solved.x;
        x.push(self.from);
        shooting.parameter = Some(&self.parameter);
        shooting.scales.push((self.to - self.from).abs());
        let image = shooting.image(&x)?;
        let along = (self.to - self.from).signum();
        let mut toward = vec![0.0; x.len()];
        toward[x.len() - 1] = along;
        let at = Place::new(&shooting, x, image, &toward)?;
        points.push(Point { cycle: at.cycle.clone(), event: None });
        let (largest, small_from) = (shooting.scales.clone(), None);
        let approach = Approach::default();
        let mut walk = Walk {
            branch: self,
            h,
            shooting,
            at,
            longest: LONGEST,
            fresh: false,
            largest,
            small_from,
            approach,
        };
        for doublings in 1.. {
            let goes = walk.advance(points, self.doublings > 0)?;
            if goes == Goes::Ends || doublings == self.doublings {
                break;
            }
            walk.double()?;
        }
        Ok(())
    }
}

/// The continuation of a branch.
#[derive(PartialEq, Eq)]
enum Goes {
    /// The branch is at its end.
    Ends,
    /// The branch is at a period doubling, and goes on with the cycles of twice the period.
    Doubles,
}

/// A branch under way.
struct Walk<'a> {
    branch: &'a Branch,
    h: f64,
    shooting: Shooting<'a>,
    at: Place,
    /// The longest step.
    longest: f64,
    /// Whether the branch begins here at another one, so that a multiplier is 1 and the test
    /// functions have no sign yet.
    fresh: bool,
    /// The largest sizes of q and p so far.
    largest: Vec<f64>,
    /// The value of the parameter at the first of the small cycles, if the present one is small.
    small_from: Option<f64>,
    approach: Approach,
}

impl Walk<'_> {
    /// Goes along the branch to its end, or to the first period doubling if `doubles`.
    fn advance(&mut self, points: &mut Vec<Point>, doubles: bool) -> Result<Goes, CycleFailure> {
        let mut ds = FIRST.min(self.longest) * if self.fresh { 0.2 } else { 1.0 };
        loop {
            if points.len() >= MOST_POINTS {
                return Err(CycleFailure::TooManyCycles { limit: MOST_POINTS });
            }
            self.set_steps()?;
            let (next, corrections) = match self.step(ds) {
                Ok((next, _)) if dot(&next.along, &self.at.along) < STRAIGHT && ds > SHORTEST => {
                    ds /= 2.0;
                    continue;
                }
                Ok(found) => found,
                Err(CycleFailure::Run(IntegrateError::Interrupted)) => {
                    return Err(IntegrateError::Interrupted.into());
                }
                Err(failure) if ds <= SHORTEST => return Err(failure),
                Err(_) => {
                    ds /= 2.0;
                    continue;
                }
            };
            let limit = self.left_through(&next);
            let next = match limit {
                Some(limit) => self.at_value(&next, limit)?,
                None => next,
            };
            for (event, found) in self.located(&next) {
                points.push(Point { cycle: found.cycle.clone(), event: Some(event) });
                if event == Event::PeriodDoubling && doubles {
                    self.at = found;
                    return Ok(Goes::Doubles);
                }
            }
            points.push(Point { cycle: next.cycle.clone(), event: None });
            (self.at, self.fresh) = (next, false);
            let Place { x, image, .. } = &self.at;
            let mut scales = scales_of(&image.path, &image.residual, &image.monodromy, x);
            self.refuse_rest(&scales)?;
            self.refuse_homoclinic(&scales)?;
            self.keep_sizes(&mut scales);
            self.rescale(&scales);
            if limit.is_some() {
                return Ok(Goes::Ends);
            }
            if corrections <= EASY {
                ds = (1.5 * ds).min(self.longest);
            } else if corrections >= HARD {
                ds /= 1.5;
            }
        }
    }

    /// Ends the branch if its cycles shrink to rest at one value of the parameter. `scales` are the
    /// sizes of the last cycle.
    ///
    /// # Errors
    /// [`CycleFailure::ShrinksToRest`]
    fn refuse_rest(&mut self, scales: &[f64]) -> Result<(), CycleFailure> {
        let mut share = 0.0_f64;
        for (largest, &scale) in self.largest.iter_mut().zip(scales).take(self.shooting.size()) {
            *largest = largest.max(scale);
            share = share.max(scale / *largest);
        }
        if share > SMALL {
            self.small_from = None;
            return Ok(());
        }
        let value = self.at.x[self.at.x.len() - 1];
        let from = *self.small_from.get_or_insert(value);
        let range = (self.branch.to - self.branch.from).abs();
        if share < SHRUNK && (value - from).abs() < UNCHANGED * range {
            return Err(CycleFailure::ShrinksToRest { value });
        }
        Ok(())
    }

    /// Ends the branch if its period grows without bound while the parameter and the sizes of the
    /// cycle hardly change.
    ///
    /// # Errors
    /// [`CycleFailure::PeriodGrows`]
    fn refuse_homoclinic(&mut self, scales: &[f64]) -> Result<(), CycleFailure> {
        let (value, period) = (self.at.x[self.at.x.len() - 1], self.at.cycle.period);
        let range = (self.branch.to - self.branch.from).abs();
        let sizes = &scales[..self.shooting.size()];
        if self.approach.see(value / range, period, sizes) {
            return Err(CycleFailure::PeriodGrows { value, period });
        }
        Ok(())
    }

    /// Keeps the sizes of single entries of q and p from vanishing, as where a symmetric cycle is
    /// met: steps would become ever shorter there, and the branch would end in roundings.
    fn keep_sizes(&self, scales: &mut [f64]) {
        let (sizes, largest) = (&mut scales[..self.shooting.size()], &self.largest);
        let share = sizes.iter().zip(largest).map(|(size, most)| size / most).fold(0.0, f64::max);
        let least = largest.iter().map(|most| LEAST_SIZE * share * most);
        sizes.iter_mut().zip(least).for_each(|(size, least)| *size = size.max(least));
    }

    /// Measures q and p by the present cycle of these sizes, if it differs much in size from the
    /// one before.
    fn rescale(&mut self, scales: &[f64]) {
        let Self { shooting, at, .. } = self;
        let size = shooting.size();
        let factors = scales.iter().zip(&shooting.scales).map(|(new, old)| new / old);
        let factors: Vec<f64> = factors.take(size).collect();
        if factors.iter().all(|factor| (1.0 / RESCALED..=RESCALED).contains(factor)) {
            return;
        }
        for (j, factor) in factors.into_iter().enumerate() {
            at.image.matrix.col_mut(j).iter_mut().for_each(|entry| *entry *= factor);
            at.along[j] /= factor;
            shooting.scales[j] = scales[j];
        }
        let length = dot(&at.along, &at.along).sqrt();
        at.along.iter_mut().for_each(|x| *x /= length);
        at.tests = event::tests(&at.cycle, at.along[at.x.len() - 1]);
    }

    /// n for steps of nearly h at the present place.
    fn set_steps(&mut self) -> Result<(), CycleFailure> {
        let shooting = &mut self.shooting;
        let model = shooting.model_at(&self.at.x)?;
        let period = shooting.period(&model, &self.at.x)?;
        shooting.steps = steps(shooting.row, &model, self.h, shooting.multiple, period)?;
        Ok(())
    }

    /// The cycle at the distance ds along the branch, and the number of corrections it took.
    fn step(&self, ds: f64) -> Result<(Place, usize), CycleFailure> {
        self.solve(self.ahead(ds), self.at_distance(ds))
    }

    /// The point at the distance ds in the direction of the branch.
    fn ahead(&self, ds: f64) -> Vec<f64> {
        let Place { x, along, .. } = &self.at;
        let moved = x.iter().zip(along).zip(&self.shooting.scales);
        moved.map(|((x, t), scale)| x + ds * t * scale).collect()
    }

    /// The distance ds along the branch, as a condition.
    fn at_distance(&self, ds: f64) -> Condition {
        Condition { normal: self.at.along.clone(), at: self.ahead(ds) }
    }

    /// Solves the equations from a guess under a condition.
    fn solve(&self, guess: Vec<f64>, there: Condition) -> Result<(Place, usize), CycleFailure> {
        let Place { x, along, image, .. } = &self.at;
        let shooting = &self.shooting;
        let phase = shooting.free().then(|| phase(shooting, &image.path, x));
        let conditions: Vec<_> = phase.into_iter().chain([there]).collect();
        let Solved { x, image, corrections, .. } = shooting.solve(guess, &conditions)?;
        Ok((Place::new(shooting, x, image, along)?, corrections))
    }

    /// The end of the range of λ through which the branch leaves it, if it does.
    fn left_through(&self, next: &Place) -> Option<f64> {
        let Branch { from, to, .. } = self.branch;
        let value = *next.x.last()?;
        let beyond = |end: f64, other: f64| (value - end) * (end - other) >= 0.0;
        [(*to, *from), (*from, *to)]
            .into_iter()
            .find(|&(end, other)| beyond(end, other))
            .map(|x| x.0)
    }

    /// The cycle at a value of λ between the present place and the next.
    fn at_value(&self, next: &Place, value: f64) -> Result<Place, CycleFailure> {
        let (x, last) = (&self.at.x, self.at.x.len() - 1);
        let share = (value - x[last]) / (next.x[last] - x[last]);
        let guess = || x.iter().zip(&next.x).map(|(a, b)| a + share * (b - a));
        let mut there = Condition { normal: vec![0.0; last + 1], at: guess().collect() };
        (there.normal[last], there.at[last]) = (1.0, value);
        Ok(self.solve(guess().collect(), there)?.0)
    }

    /// Goes over to the cycles of twice the period at a period doubling.
    fn double(&mut self) -> Result<(), CycleFailure> {
        let (size, scales) = (self.shooting.size(), &self.shooting.scales);
        let monodromy = &self.at.image.monodromy;
        let matrix = Mat::from_fn(size, size, |i, j| {
            let unit = if i == j { 1.0 } else { 0.0 };
            (monodromy[(i, j)] + unit) * scales[j] / scales[i]
        });
        let mut along = null_vector(&matrix)?;
        along.resize(self.at.x.len(), 0.0);
        let shooting = &mut self.shooting;
        if shooting.free() {
            self.at.x[size] *= 2.0;
            shooting.scales[size] *= 2.0;
        }
        shooting.multiple = shooting.multiple.map(|multiple| 2 * multiple);
        self.set_steps()?;
        self.at.image = self.shooting.image(&self.at.x)?;
        (self.at.along, self.fresh) = (along, true);
        self.longest /= ALPHA;
        self.approach = Approach::default();
        Ok(())
    }
}
