//! An exact solution on its way, looked at for many steps h at once.

use super::measure::Scales;
use super::reference::{Event, Reference, Standing};
use super::side::{Side, lane_of};
use afterbay_core::{System, View};

/// A point of the solution.
struct Node<T> {
    /// q and p.
    point: [Vec<T>; 2],
    /// q' and, once it is asked for, p'; ∂H/∂q before.
    slopes: [Vec<T>; 2],
    asked: bool,
}

impl<T: Side> Node<T> {
    /// Finds p' = -∂H/∂q - D where that has not been done. `d` is room.
    fn ask(&mut self, system: &dyn System<T>, d: &mut [T]) {
        if self.asked {
            return;
        }
        let Self { point: [q, p], slopes: [dq, dp], .. } = self;
        system.dissipation(q, p, dq, d);
        dp.iter_mut().zip(d).for_each(|(dp, d)| *dp = -(*dp + *d));
        self.asked = true;
    }
}

/// The last two points of the solution, and what has been seen for each step.
pub(super) struct Walk<'a, T> {
    system: &'a dyn System<T>,
    before: Node<T>,
    now: Node<T>,
    /// The largest T and |q|² so far.
    pub(super) largest: [T; 2],
    pub(super) sums: Vec<Sums<T>>,
    between: [Vec<T>; 2],
    room: [Vec<T>; 3],
}

/// What has been seen for a step h.
pub(super) struct Sums<T> {
    /// q at the first look; what follows is measured from there, as the mean is not known yet.
    origin: Option<Vec<T>>,
    mean: Vec<T>,
    /// The means of |q - origin|² and T.
    away: T,
    kinetic: T,
    /// The largest T and |q|² up to the last look.
    pub(super) largest: [T; 2],
}

impl<'a, T: Side> Walk<'a, T> {
    pub(super) fn new(system: &'a dyn System<T>, dof: usize, steps: usize) -> Self {
        let zeros = || vec![T::zero(); dof];
        let node = || Node { point: [zeros(), zeros()], slopes: [zeros(), zeros()], asked: false };
        Self {
            system,
            before: node(),
            now: node(),
            largest: [T::zero(); 2],
            sums: (0..steps).map(|_| Sums::nothing(dof)).collect(),
            between: [zeros(), zeros()],
            room: [zeros(), zeros(), zeros()],
        }
    }

    /// Takes in the next point.
    pub(super) fn arrive(&mut self, state: View<'_, T>) {
        std::mem::swap(&mut self.before, &mut self.now);
        let Node { point: [q, p], slopes: [dq, hq], asked } = &mut self.now;
        q.copy_from_slice(state.q);
        p.copy_from_slice(state.p);
        self.system.gradient(q, p, hq, dq);
        *asked = false;
        let sizes = [kinetic(p, dq), q.iter().fold(T::zero(), |sum, &q| q.mul_add(q, sum))];
        for (largest, size) in self.largest.iter_mut().zip(sizes) {
            *largest = T::select(largest.lt(size), size, *largest);
        }
    }

    /// Looks at the share u of the way between the last two points, a time `length` apart.
    pub(super) fn look(&mut self, event: &Event, u: f64, length: f64) {
        let v = 1.0 - u;
        let of_points = [v * v * (1.0 + 2.0 * u), u * u * (1.0 + 2.0 * v)].map(T::from_f64);
        let of_slopes = [u * v * v, -u * u * v].map(|x| T::from_f64(x * length));
        let Self { system, before, now, between, room, .. } = &mut *self;
        before.ask(*system, &mut room[1]);
        now.ask(*system, &mut room[1]);
        for (part, between) in between.iter_mut().enumerate() {
            for (j, between) in between.iter_mut().enumerate() {
                let points = of_points[0] * before.point[part][j] + of_points[1] * now.point[part][j];
                *between =
                    points + of_slopes[0] * before.slopes[part][j] + of_slopes[1] * now.slopes[part][j];
            }
        }
        let [q, p] = &self.between;
        let [hq, _, hp] = &mut self.room;
        self.system.gradient(q, p, hq, hp);
        if let Some(sums) = self.sums.get_mut(event.step) {
            sums.look(q, kinetic(p, hp), T::from_f64(event.weight));
            sums.largest = self.largest;
        }
    }
}

/// T = ½ p·∂H/∂p
fn kinetic<T: Side>(p: &[T], hp: &[T]) -> T {
    p.iter().zip(hp).fold(T::zero(), |sum, (&p, &hp)| p.mul_add(hp, sum)).half().abs()
}

impl<T: Side> Sums<T> {
    pub(super) fn nothing(dof: usize) -> Self {
        let zero = T::zero();
        Self { origin: None, mean: vec![zero; dof], away: zero, kinetic: zero, largest: [zero; 2] }
    }

    fn look(&mut self, q: &[T], kinetic: T, weight: T) {
        let origin = self.origin.get_or_insert_with(|| q.to_vec());
        let mut away = T::zero();
        for ((&q, &origin), mean) in q.iter().zip(origin.iter()).zip(&mut self.mean) {
            away = (q - origin).mul_add(q - origin, away);
            *mean = weight.mul_add(q, *mean);
        }
        self.away = weight.mul_add(away, self.away);
        self.kinetic = weight.mul_add(kinetic, self.kinetic);
    }

    /// The reference of a lane, its standing not known.
    pub(super) fn reference(&self, k: usize) -> Reference {
        let [by_kinetic, by_reach] =
            self.largest.map(|x| x.lane(k)).map(|x| if x > 0.0 { x.recip() } else { 0.0 });
        let centre = lane_of(&self.mean, k);
        let origin = self.origin.as_ref().map_or_else(|| centre.clone(), |origin| lane_of(origin, k));
        let shift: f64 = centre.iter().zip(&origin).map(|(c, o)| (c - o) * (c - o)).sum();
        let away = (self.away.lane(k) - shift).max(0.0);
        let size = self.kinetic.lane(k) * by_kinetic + away * by_reach;
        let scales = Scales { by_kinetic, by_reach, centre };
        Reference { standing: Standing::Unsettled, scales, size }
    }
}
