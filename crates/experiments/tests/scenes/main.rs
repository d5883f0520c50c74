//! Scenes: texts that are read, and texts that are refused.

mod bad;
mod file;
mod fuzz;
mod refused;
mod sweep;

use cpu_time::ThreadTime;
use std::time::Duration;

/// Longer than any text takes that is read in time proportional to its length: the longest take a
/// second without optimisation. Work that grows as the square of the length takes minutes.
const SOON: Duration = Duration::from_secs(20);

/// The result, and the processor time of the one thread that found it: other work on the machine is
/// not counted.
fn soon<T: Send>(find: impl Fn() -> T + Sync) -> (Duration, T) {
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    one.install(|| {
        let clock = ThreadTime::now();
        let found = find();
        (clock.elapsed(), found)
    })
}
