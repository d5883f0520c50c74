//! An exact solution in progress, observed for many steps h at once.

use super::batch::Event;
use super::halves::Halves;
use super::image::Image;
use super::measure::{Scales, kinetic, larger};
use super::reference::{Reference, Standing};
use super::thresholds::SHARE;
use super::track::{Track, sizes};
use crate::study::side::{Side, lane_of};
use afterbay_core::{StateRef, System};

/// The longest leap of a component in a step, as a share of its size. Steps that leap over a motion
/// may damp it out alike, however often they are halved.
const LONGEST: f64 = 0.5;

/// A point of the solution.
struct Node<T> {
    /// q, p and w.
    point: [Vec<T>; 3],
    /// q', and p' and w' once computed; before that ∂H/∂q is stored in place of p'.
    slopes: [Vec<T>; 3],
    asked: bool,
}

impl<T: Side> Node<T> {
    /// Computes p' = -∂H/∂q - D and w' = D ∂H/∂p where that has not been done. `d` is workspace.
    fn ask(&mut self, system: &dyn System<T>, d: &mut [T]) {
        if self.asked {
            return;
        }
        let Self { point: [q, p, _], slopes: [dq, dp, dw], .. } = self;
        system.dissipation(q, p, dq, d);
        for (((dp, dw), dq), d) in dp.iter_mut().zip(dw).zip(dq).zip(d) {
            *dp = -(*dp + *d);
            *dw = *d * *dq;
        }
        self.asked = true;
    }
}

/// The last two points of the solution, and the observations for each step.
pub(super) struct Walk<'a, T> {
    system: &'a dyn System<T>,
    image: Image<T>,
    before: Box<Node<T>>,
    now: Box<Node<T>>,
    /// z and K at the first point.
    start: Option<(Vec<T>, T)>,
    /// The largest T and |x|² so far.
    largest: [T; 2],
    /// The least and the largest value of each number of z so far, and its longest leap from one
    /// point to the next.
    range: [Vec<T>; 3],
    pub(super) sums: Vec<Sums<T>>,
    between: [Vec<T>; 3],
    /// Workspace for ∂H/∂q, D and ∂H/∂p.
    workspace: [Vec<T>; 3],
    /// z at this point, at the one before, and between them.
    z: Vec<T>,
    last: Vec<T>,
    there: Vec<T>,
}

/// The observations for a step h.
pub(super) struct Sums<T> {
    /// x at the first observation in the second half. Means are taken relative to it, since the
    /// mean is not known yet.
    origin: Option<Vec<T>>,
    mean: Vec<T>,
    /// The means of |x - origin|² and T.
    away: T,
    kinetic: T,
    /// The largest T and |x|² at the last observation.
    largest: [T; 2],
    range: [Vec<T>; 3],
    halves: Halves<T>,
    /// z at the stations.
    stations: Vec<T>,
}

impl<'a, T: Side> Walk<'a, T> {
    pub(super) fn new(
        system: &'a dyn System<T>,
        image: Image<T>,
        dof: usize,
        steps: usize,
    ) -> Self {
        let zeros = || vec![T::zero(); dof];
        let three = || [zeros(), zeros(), zeros()];
        let node = || Box::new(Node { point: three(), slopes: three(), asked: false });
        let z = vec![T::zero(); image.size()];
        Self {
            system,
            before: node(),
            now: node(),
            start: None,
            largest: [T::zero(); 2],
            range: [z.clone(), z.clone(), z.clone()],
            sums: (0..steps).map(|_| Sums::nothing(&image)).collect(),
            between: three(),
            workspace: three(),
            last: z.clone(),
            there: z.clone(),
            z,
            image,
        }
    }

    /// Adds the next point.
    pub(super) fn arrive(&mut self, state: StateRef<'_, T>) {
        let Self { image, z, last, range: [low, high, leap], .. } = self;
        std::mem::swap(&mut self.before, &mut self.now);
        let Node { point: [q, p, w], slopes: [dq, hq, _], asked } = &mut *self.now;
        q.copy_from_slice(state.q);
        p.copy_from_slice(state.p);
        w.copy_from_slice(state.w);
        self.system.gradient(q, p, hq, dq);
        *asked = false;
        std::mem::swap(z, last);
        image.of(state, z);
        if self.start.is_none() {
            let energy = self.system.energy(q, p);
            self.start = Some((z.clone(), w.iter().fold(energy, |sum, &w| sum + w)));
            [&mut *low, high, last].into_iter().for_each(|part| part.copy_from_slice(z));
        }
        for (((&z, &last), low), (high, leap)) in
            z.iter().zip(&*last).zip(low).zip(high.iter_mut().zip(leap))
        {
            *low = T::select(z.lt(*low), z, *low);
            *high = larger(*high, z);
            *leap = larger(*leap, (z - last).abs());
        }
        let reach = z[..image.places()].iter().fold(T::zero(), |sum, &x| x.mul_add(x, sum));
        let sizes = [kinetic(p, dq), reach];
        for (largest, size) in self.largest.iter_mut().zip(sizes) {
            *largest = larger(*largest, size);
        }
    }

    /// Observes the solution at the share u of the way between the last two points, a time `length`
    /// apart.
    pub(super) fn observe(&mut self, event: &Event, u: f64, length: f64) {
        let v = 1.0 - u;
        let of_points = [v * v * (1.0 + 2.0 * u), u * u * (1.0 + 2.0 * v)].map(T::from_f64);
        let of_slopes = [u * v * v, -u * u * v].map(|x| T::from_f64(x * length));
        let Self { system, before, now, between, workspace, .. } = &mut *self;
        before.ask(*system, &mut workspace[1]);
        now.ask(*system, &mut workspace[1]);
        for (part, between) in between.iter_mut().enumerate() {
            for (j, between) in between.iter_mut().enumerate() {
                let points =
                    of_points[0] * before.point[part][j] + of_points[1] * now.point[part][j];
                *between = points
                    + of_slopes[0] * before.slopes[part][j]
                    + of_slopes[1] * now.slopes[part][j];
            }
        }
        let [q, p, w] = &self.between;
        let [hq, _, hp] = &mut self.workspace;
        self.system.gradient(q, p, hq, hp);
        let t = T::from_f64(event.t);
        self.image.of(StateRef { q, p, w, t }, &mut self.there);
        if let (Some(sums), Some((origin, _))) = (self.sums.get_mut(event.step), &self.start) {
            sums.observe(&self.there, kinetic(p, hp), event, origin);
            sums.largest = self.largest;
            for (to, from) in sums.range.iter_mut().zip(&self.range) {
                to.copy_from_slice(from);
            }
        }
    }

    /// The reference of a lane for each step, its standing not yet known.
    pub(super) fn references(&self, k: usize, image: &Image<f64>) -> Vec<Reference> {
        let (origin, total) = match &self.start {
            Some((origin, total)) => (lane_of(origin, k), total.lane(k)),
            None => (vec![0.0; image.size()], 0.0),
        };
        let of = |sums: &Sums<T>| sums.reference(k, image, &origin, total);
        self.sums.iter().map(of).collect()
    }

    /// The reference of a lane where only the start is known.
    pub(super) fn of_start(mut self, k: usize, image: &Image<f64>) -> Option<Reference> {
        let sums = self.sums.first_mut()?;
        (sums.largest, sums.range) = (self.largest, self.range.clone());
        self.references(k, image).pop()
    }
}

impl<T: Side> Sums<T> {
    fn nothing(image: &Image<T>) -> Self {
        let zero = T::zero();
        let zeros = || vec![zero; image.size()];
        Self {
            origin: None,
            mean: vec![zero; image.places()],
            away: zero,
            kinetic: zero,
            largest: [zero; 2],
            range: [zeros(), zeros(), zeros()],
            halves: Halves::nothing(image.size()),
            stations: Vec::new(),
        }
    }

    fn observe(&mut self, z: &[T], kinetic: T, event: &Event, start: &[T]) {
        let weight = T::from_f64(event.observation.weight);
        self.halves.add(event.observation.half, weight, z, start);
        if event.observation.station.is_some() {
            self.stations.extend_from_slice(z);
        }
        if event.observation.half == 0 {
            return;
        }
        let x = &z[..self.mean.len()];
        let origin = self.origin.get_or_insert_with(|| x.to_vec());
        let mut away = T::zero();
        for ((&x, &origin), mean) in x.iter().zip(origin.iter()).zip(&mut self.mean) {
            away = (x - origin).mul_add(x - origin, away);
            *mean = weight.mul_add(x, *mean);
        }
        self.away = weight.mul_add(away, self.away);
        self.kinetic = weight.mul_add(kinetic, self.kinetic);
    }

    fn reference(&self, k: usize, image: &Image<f64>, start: &[f64], total: f64) -> Reference {
        let [kinetic, reach] = self.largest.map(|x| x.lane(k));
        let [low, high, leap] = self.range.each_ref().map(|range| lane_of(range, k));
        let sizes = sizes(image, [&low, &high], total.abs() + kinetic);
        let moves = sizes[image.places()..].iter().any(|size| size.is_finite());
        let by = |x: f64| if x > 0.0 { x.recip().min(f64::MAX) } else { 0.0 };
        let (by_kinetic, by_reach) = (if moves { by(kinetic) } else { 0.0 }, by(reach));
        let centre = lane_of(&self.mean, k);
        let origin =
            self.origin.as_ref().map_or_else(|| centre.clone(), |origin| lane_of(origin, k));
        let shift: f64 = centre.iter().zip(&origin).map(|(c, o)| (c - o) * (c - o)).sum();
        let away = (self.away.lane(k) - shift).max(0.0);
        let size = self.kinetic.lane(k) * by_kinetic + away * by_reach;
        let leaps = leap.iter().zip(&sizes).any(|(leap, size)| *leap > LONGEST * size);
        let allowed: Vec<f64> = sizes.into_iter().map(|size| SHARE * size).collect();
        let track =
            Track::new(image.clone(), start.to_vec(), total, &allowed, lane_of(&self.stations, k));
        let scales = Scales { by_kinetic, by_reach, centre, track };
        let halves = self.halves.lane(k);
        let (standing, rests) = (Standing::Unsettled, !moves && kinetic > 0.0);
        Reference { standing, followed: false, leaps, rests, scales, size, floor: 0.0, halves }
    }
}
