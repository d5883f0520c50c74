//! The time per step in ns (the time of an element) of every pair, measured separately.

use afterbay_benches::{STEPS, pairs};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use std::time::Duration;

fn steps(criterion: &mut Criterion) {
    for pair in pairs() {
        let mut group =
            criterion.benchmark_group(format!("{}: {}", pair.subject.name(), pair.name));
        group.throughput(Throughput::Elements(STEPS));
        group.bench_function("generic", |bencher| bencher.iter(&pair.generic));
        group.bench_function("by hand", |bencher| bencher.iter(&pair.by_hand));
        group.finish();
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .warm_up_time(Duration::from_millis(200))
        .measurement_time(Duration::from_millis(500))
        .sample_size(30)
        .without_plots();
    targets = steps
}
criterion_main!(benches);
