//! The exact solution at the stations of a run, and the deviations allowed there.

use super::image::Image;
use crate::study::side::Side;

/// The exact solution at the stations.
#[derive(Clone, Debug)]
pub(super) struct Track<T> {
    pub(super) image: Image<T>,
    /// z at the start.
    pub(super) origin: Vec<T>,
    /// K at the start.
    pub(super) total: T,
    /// 1 divided by the deviation allowed to each component of z; 0 for one that is not judged.
    by_allowed: Vec<T>,
    /// z at each station, one after the other.
    stations: Vec<T>,
}

/// The least size of a component, as a share of the largest of its kind.
const LEAST: f64 = 0.01;
/// A size below this share of the largest number of its kind is rounding; the component is at rest.
const ROUNDING: f64 = 1e-12;

/// The size of each component of z, from its least and its largest value along the exact solution,
/// whose largest energy is given: half the range of x and p, and the largest |w|. Both components
/// of a point on a circle have the larger size. No size is less than [`LEAST`] of the largest of
/// its kind. Those of p_j and w_j are infinite where x_j rests, since roundings have none.
pub(super) fn sizes(image: &Image<f64>, [low, high]: [&[f64]; 2], energy: f64) -> Vec<f64> {
    let kinds = image.kinds();
    let magnitude = |i: usize| low[i].abs().max(high[i].abs());
    let own = |i: usize| if kinds[i].0 == 2 { magnitude(i) } else { 0.5 * (high[i] - low[i]) };
    let most = |kind: usize, of: &dyn Fn(usize) -> f64| {
        (0..kinds.len()).filter(|&i| kinds[i].0 == kind).map(of).fold(0.0, f64::max)
    };
    let least = [0, 1, 2].map(|kind| LEAST * most(kind, &own));
    let [x, p, w] = [0, 1, 2].map(|kind| most(kind, &magnitude));
    let roundings = [x, p, w.max(energy)].map(|largest| ROUNDING * largest);
    // The two components of a point on a circle are two of one kind and coordinate.
    let joint = |of: (usize, usize)| {
        (0..kinds.len()).filter(|&i| kinds[i] == of).map(own).fold(0.0, f64::max)
    };
    let rests = |j: usize| joint((0, j)) <= roundings[0];
    let size = |&(kind, j): &(usize, usize)| {
        let size = joint((kind, j)).max(least[kind]) + roundings[kind];
        if kind > 0 && rests(j) { f64::INFINITY } else { size }
    };
    kinds.iter().map(size).collect()
}

impl Track<f64> {
    pub(super) fn new(
        image: Image<f64>,
        origin: Vec<f64>,
        total: f64,
        allowed: &[f64],
        stations: Vec<f64>,
    ) -> Self {
        let by_allowed =
            allowed.iter().map(|&allowed| if allowed > 0.0 { allowed.recip() } else { 0.0 });
        Self { image, origin, total, by_allowed: by_allowed.collect(), stations }
    }

    /// The deviation allowed to each component of z, infinite for one that is not judged.
    pub(super) fn allowed(&self) -> Vec<f64> {
        self.by_allowed.iter().map(|by| by.recip()).collect()
    }

    /// x at all stations.
    pub(super) fn places(&self) -> impl Iterator<Item = &f64> {
        let (size, places) = (self.image.size(), self.image.places());
        self.stations.chunks(size).flat_map(move |z| &z[..places])
    }

    /// Whether another solution agrees within a share of the allowed deviation at every station.
    pub(super) fn agrees(&self, other: &Self, share: f64) -> bool {
        let size = self.by_allowed.len();
        let apart = |(i, z): (usize, &[f64])| self.off(i, z);
        self.stations.len() == other.stations.len()
            && other.stations.chunks(size).enumerate().filter_map(apart).all(|off| off <= share)
    }
}

impl<T: Side> Track<T> {
    /// The tracks of eight cells side by side; `None` if they compare different components.
    pub(super) fn beside<'a>(of: impl Fn(usize) -> &'a Track<f64>) -> Option<Self> {
        let image = Image::beside(|k| of(k).image.clone())?;
        let gather = |part: &dyn Fn(&'a Track<f64>) -> &'a [f64]| -> Option<Vec<T>> {
            let length = part(of(0)).len();
            let same = (0..T::LANES).all(|k| part(of(k)).len() == length);
            same.then(|| (0..length).map(|i| T::gather(|k| part(of(k))[i])).collect())
        };
        Some(Self {
            image,
            origin: gather(&|track| &track.origin)?,
            total: T::gather(|k| of(k).total),
            by_allowed: gather(&|track| &track.by_allowed)?,
            stations: gather(&|track| &track.stations)?,
        })
    }

    /// The largest deviation of a component of z from the exact solution at a station, as a
    /// multiple of the allowed one; `None` if the solution has no such station.
    #[inline]
    pub(super) fn off(&self, station: usize, z: &[T]) -> Option<T> {
        let size = self.by_allowed.len();
        let exact = self.stations.get(station * size..(station + 1) * size)?;
        let off = |((&z, &exact), &by): ((&T, &T), &T)| (z - exact).abs() * by;
        let all = z.iter().zip(exact).zip(&self.by_allowed).map(off);
        Some(all.fold(T::zero(), |most, off| T::select(off.le(most), most, off)))
    }
}
