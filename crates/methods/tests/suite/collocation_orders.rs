//! Energy-preserving collocation has order 2 to 16 in q, p and w: errors against Taylor series, in
//! 31 digits.

use crate::bind::after;
use crate::catalog::{As, Built, chain, duffing, pendulum, ring};
use crate::many::orders::orders_at_end;
use crate::many::{errors, exact_end, start};
use afterbay_core::Quad;
use afterbay_methods::registry::find;

/// Checks that the global orders at `end` are 2s to within 0.05. The numbers of steps per unit of
/// time are those of [`PLAN`] times `finer`.
fn orders(system: &Built, from: [&[f64]; 2], end: f64, finer: f64) {
    let start = start(from);
    let exact = exact_end(&*system.series::<Quad>(), &start, end);
    for (stages, counts) in PLAN {
        let row = find(&format!("collocation-{}", 2 * stages)).unwrap();
        let run = system.bind(row, As::Curved).unwrap();
        let mut least = [0.0; 3];
        let counts = counts.map(|count| (count * finer * end).round() as u64);
        let found = orders_at_end(&exact, &counts, &mut |grid| {
            let found = after(&run, grid, &start);
            least = errors(&found, &exact);
            found
        });
        println!("s={stages} {found:.3?} {least:?}");
        let order = 2.0 * stages as f64;
        assert!(found.iter().all(|found| (found - order).abs() < 0.05), "{stages}: {found:?}");
        // The smallest errors are below the rounding of `f64`.
        let below = least.iter().all(|&error| error < f64::EPSILON / 2.0);
        assert!(stages < 5 || below, "{stages}: {least:?}");
    }
}

/// The stages, and the numbers of steps per unit of time.
const PLAN: [(usize, [f64; 3]); 8] = [
    (1, [120.0, 160.0, 220.0]),
    (2, [60.0, 80.0, 110.0]),
    (3, [40.0, 52.0, 70.0]),
    (4, [28.0, 36.0, 46.0]),
    (5, [22.0, 27.0, 33.0]),
    (6, [17.0, 21.0, 25.0]),
    (7, [14.0, 17.0, 20.0]),
    (8, [12.0, 14.0, 16.0]),
];

#[test]
fn of_a_chain() {
    orders(&chain(3, 0.5, 0.2), [&[0.5, -0.3, 0.8], &[0.2, 0.7, -0.4]], 1.0, 1.0);
}

#[test]
fn of_a_ring() {
    orders(&ring(3, 0.7, 0.4), [&[0.9, -0.5, 1.3], &[0.4, 1.2, -0.7]], 1.0, 1.0);
}

/// A system whose H is not separable.
#[test]
fn of_a_double_pendulum() {
    let pendulum = pendulum([1.0, 0.8], [1.0, 0.7], 3.0, [0.1, 0.2]);
    orders(&pendulum, [&[0.6, -0.4], &[0.3, 0.5]], 0.5, 2.0);
}

#[test]
fn of_duffing() {
    orders(&duffing(-1.0, 1.0, 0.1), [&[1.5], &[0.5]], 1.0, 1.0);
}
