//! The warnings of a sweep. They count the points at which H rises though it can only fall, and
//! those at which a statement does not hold although all runs completed.

use super::Row;
use crate::claim::{Readings, counted, list};
use crate::experiment::trajectories;
use std::collections::BTreeMap;

/// The points at which something was seen.
struct Seen {
    count: usize,
    /// The largest number, and the first point that has it.
    most: f64,
    place: String,
}

/// The warnings of all points so far.
#[derive(Default)]
pub(super) struct Warnings {
    /// The rises of H by methods.
    rises: BTreeMap<String, Seen>,
    /// The statements that do not hold, by topics.
    failed: BTreeMap<String, Seen>,
}

impl Warnings {
    /// Takes the numbers of a point, and the topics of the statements that do not hold there.
    pub(super) fn see(&mut self, place: &str, rows: &[Row], failed: Vec<String>) {
        let is_rise =
            |row: &&Row| row.topic == trajectories::TOPIC && row.what == trajectories::RISE;
        for row in rows.iter().filter(is_rise) {
            add(&mut self.rises, row.of.clone(), row.value, place);
        }
        for topic in failed {
            add(&mut self.failed, topic, 1.0, place);
        }
    }

    /// Appends the readings of the warnings.
    pub(super) fn read(&self, readings: &mut Readings) {
        for (method, Seen { count, most, place }) in &self.rises {
            readings.add(method, "points with a rise", *count);
            readings.add(method, "largest rise", *most);
            readings.add(method, "where it rises most", place.as_str());
        }
        for (topic, Seen { count, place, .. }) in &self.failed {
            readings.add(topic, "points where it does not hold", *count);
            readings.add(topic, "where it does not hold first", place.as_str());
        }
    }
}

fn add(all: &mut BTreeMap<String, Seen>, of: String, number: f64, place: &str) {
    let none = || Seen { count: 0, most: f64::NEG_INFINITY, place: String::new() };
    let seen = all.entry(of).or_insert_with(none);
    seen.count += 1;
    if number > seen.most {
        (seen.most, seen.place) = (number, place.to_owned());
    }
}

/// The sentences of the warnings, and whether all statements hold.
pub(super) fn say(r: &Readings) -> (bool, String) {
    let rises = r.numbers("points with a rise").into_iter().map(|(method, count)| {
        let (most, place) =
            (r.number(method, "largest rise"), r.word(method, "where it rises most"));
        format!("{method} at {} (most at {place}, by {most:.0e})", counted(count, "point"))
    });
    let rises: Vec<String> = rises.collect();
    let mut said = String::new();
    if !rises.is_empty() {
        said = format!(" H can only fall, but it rises with {}.", list(rises));
    }
    let failed = r.numbers("points where it does not hold");
    for (topic, count) in &failed {
        let place = r.word(topic, "where it does not hold first");
        let points = counted(count, "point");
        said += &format!(" {topic}: does not hold at {points}, first at {place}.");
    }
    (failed.is_empty(), said)
}
