//! The periods of coordinates under a drive.

use afterbay_core::Drive;
use afterbay_systems::CustomDrive;

/// The most periods of V and D that make one of the forces.
const MOST_TURNS: u32 = 12;
/// The points (q, t) at which forces are compared.
const POINTS: usize = 64;
/// The periods, to either side of 0, among which these points lie.
const SPAN: f64 = 8.0;
/// The turns after which forces are compared. Many of them show a slow growth.
const TURNS: [f64; 2] = [1.0, 1000.0];
/// The largest change of a force over these turns, relative to its largest size at the points. It
/// covers the roundings of q after many turns, and periods given with ten digits.
const TOLERANCE: f64 = 1e-9;

/// The periods of coordinates that those of V and D leave under a drive: the least multiple of each
/// that is a period of all forces as well. A multiple is a period if the forces are the same there
/// at some points, as for a period in time that is given. A coordinate has none if no multiple is.
pub(super) fn under(drive: &CustomDrive<f64>, periods: &[Option<f64>]) -> Vec<Option<f64>> {
    let count = Drive::<f64>::driven(drive).len();
    let moved: Vec<usize> = (0..count).filter(|&k| drive.depends_on_coordinates(k)).collect();
    let of = |(j, own): (usize, &Option<f64>)| {
        let own = (*own)?;
        (1..=MOST_TURNS)
            .map(|turns| f64::from(turns) * own)
            .find(|&period| moved.iter().all(|&k| repeats(drive, k, j, period, periods)))
    };
    periods.iter().enumerate().map(of).collect()
}

/// Whether force k is the same after turns of coordinate j by a period.
fn repeats(
    drive: &CustomDrive<f64>,
    k: usize,
    j: usize,
    period: f64,
    periods: &[Option<f64>],
) -> bool {
    // Points without a pattern: multiples of the golden ratio.
    let share = |i: usize| 2.0 * (i as f64 * 1.618_033_988_749_895).fract() - 1.0;
    let point = |i: usize| {
        let place = |(n, own): (usize, &Option<f64>)| {
            own.map_or(1.0, |own| SPAN * own) * share(i + 7 * (n + 1))
        };
        let q: Vec<f64> = periods.iter().enumerate().map(place).collect();
        (drive.force(k, &q, SPAN * share(i)), q, SPAN * share(i))
    };
    let points: Vec<_> = (1..=POINTS).map(point).collect();
    let size = points.iter().map(|(before, ..)| before.abs()).fold(0.0, f64::max);
    points.into_iter().all(|(before, mut q, t)| {
        let start = q[j];
        TURNS.iter().all(|turns| {
            q[j] = start + turns * period;
            (drive.force(k, &q, t) - before).abs() <= TOLERANCE * size
        })
    })
}
