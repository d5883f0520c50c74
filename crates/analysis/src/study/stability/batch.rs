//! Steps of a map that share one exact solution.

use super::measure::{Observation, Observations};

/// The largest ratio of the lengths of two runs in a batch.
const SPAN: f64 = 4.0;

/// An observation of the solution, for one step of a batch.
pub(super) struct Event {
    pub(super) t: f64,
    pub(super) step: usize,
    pub(super) observation: Observation,
}

/// Steps of the map whose runs end at about the same time. Longer runs would ask for longer steps
/// of RK4.
pub(super) struct Batch {
    /// Their indices in the map.
    pub(super) steps: Vec<usize>,
    /// Their observations in order of time.
    pub(super) events: Vec<Event>,
}

/// Groups all steps of a map into batches.
pub(super) fn batches(steps: &[(f64, &Observations)]) -> Vec<Batch> {
    let end = |&i: &usize| steps[i].0 * steps[i].1.count as f64;
    let mut order: Vec<usize> = (0..steps.len()).collect();
    order.sort_by(|a, b| end(a).total_cmp(&end(b)));
    let mut batches = Vec::new();
    while let Some(first) = order.first() {
        let most = SPAN * end(first);
        let rest = order.split_off(order.partition_point(|i| end(i) <= most).max(1));
        let of_step = |(step, &i): (usize, &usize)| {
            let (h, observations) = steps[i];
            observations.all().map(move |(n, observation)| Event {
                t: h * n as f64,
                step,
                observation,
            })
        };
        let mut events: Vec<Event> = order.iter().enumerate().flat_map(of_step).collect();
        events.sort_by(|a, b| a.t.total_cmp(&b.t).then(a.step.cmp(&b.step)));
        batches.push(Batch { steps: std::mem::replace(&mut order, rest), events });
    }
    batches
}
