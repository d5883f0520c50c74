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
    /// 1 divided by the deviation allowed to each component of z.
    by_allowed: Vec<T>,
    /// z at each station, one after the other.
    stations: Vec<T>,
}

/// The least size of a component, as a share of the largest of its kind.
const LEAST: f64 = 0.01;
/// A size below this share of the largest number is rounding; the component is at rest.
const ROUNDING: f64 = 1e-12;

/// The size of each component of z, from its least and its largest value along the exact solution:
/// half the range of x and p, and the largest |w|. Both components of a point on a circle have the
/// larger size. No size is less than [`LEAST`] of the largest of its kind.
pub(super) fn sizes(image: &Image<f64>, low: &[f64], high: &[f64]) -> Vec<f64> {
    let kinds = image.kinds();
    let largest = low.iter().chain(high).fold(0.0, |most: f64, z| most.max(z.abs()));
    let own = |i: usize| match kinds[i].0 {
        2 => low[i].abs().max(high[i].abs()),
        _ => 0.5 * (high[i] - low[i]),
    };
    let most = |with: &dyn Fn(usize) -> bool| {
        (0..kinds.len()).filter(|&i| with(i)).map(own).fold(0.0, f64::max)
    };
    let of_kind = [0, 1, 2].map(|kind| most(&|i| kinds[i].0 == kind));
    let size = |i: usize| {
        // The two components of a point on a circle are neighbours.
        let beside = [i.saturating_sub(1), (i + 1).min(kinds.len() - 1)];
        let of_point = beside.into_iter().filter(|&k| kinds[k] == kinds[i]).map(own);
        let joint = of_point.fold(own(i), f64::max);
        joint.max(LEAST * of_kind[kinds[i].0]) + ROUNDING * largest
    };
    (0..kinds.len()).map(size).collect()
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

    /// The deviation allowed to each component of z.
    pub(super) fn allowed(&self) -> Vec<f64> {
        self.by_allowed.iter().map(|by| if *by > 0.0 { by.recip() } else { 0.0 }).collect()
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
