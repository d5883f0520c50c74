//! The times of the settings that qualify, and whether two of them differ by more than noise.

use super::Candidate;
use super::setting::Choice;
use crate::progress::Progress;
use crate::study::Problem;
use afterbay_core::IntegrateError;
use serde::Serialize;

/// Further rounds in which settings near the fastest are timed in turn, so that a slow moment of
/// the machine does not fall on one of them alone.
const ROUNDS: usize = 3;
/// The ratio to the shortest time up to which a setting is near.
const NEAR: f64 = 2.0;
/// Times that differ by less than this share are equal, however well they repeat: another start of
/// the program places code and data elsewhere.
const LEAST_NOISE: f64 = 0.05;

/// The range of the times of one setting over the rounds, in seconds.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Times {
    /// The shortest.
    pub least: f64,
    /// The longest.
    pub most: f64,
}

impl Times {
    fn with(self, seconds: f64) -> Self {
        Self { least: self.least.min(seconds), most: self.most.max(seconds) }
    }

    /// Whether noise may have decided that these times are shorter than others.
    fn may_exceed(self, slower: Self) -> bool {
        slower.least <= self.most.max(self.least * (1.0 + LEAST_NOISE))
    }
}

/// Times every setting, and those near the fastest again.
pub(super) fn measure(
    qualified: &mut [(Candidate, Choice)],
    problem: &Problem,
    progress: &dyn Progress,
) -> Result<(), IntegrateError> {
    progress.begin("times", qualified.len());
    for round in 0..=ROUNDS {
        let all = qualified.iter().filter_map(|one| one.0.times);
        let limit = NEAR * all.fold(f64::INFINITY, |least, times| least.min(times.least));
        for (candidate, setting) in qualified.iter_mut() {
            let near = candidate.times.is_some_and(|times| times.least <= limit);
            if progress.stopped() {
                return Ok(());
            }
            if round > 0 && !near {
                continue;
            }
            let seconds = setting.time(problem, progress)?.as_secs_f64();
            if progress.stopped() {
                return Ok(());
            }
            let first = Times { least: seconds, most: seconds };
            let times = candidate.times.map_or(first, |times| times.with(seconds));
            candidate.times = Some(times);
            candidate.run.seconds = Some(times.least);
            if round == 0 {
                progress.advance();
            }
        }
    }
    Ok(())
}

/// The number of candidates after the first that may be as fast as it. They are sorted by time.
pub(super) fn ties(qualified: &[Candidate]) -> usize {
    let Some((winner, rest)) = qualified.split_first() else { return 0 };
    let Some(times) = winner.times else { return 0 };
    rest.iter()
        .take_while(|other| other.times.is_some_and(|slower| times.may_exceed(slower)))
        .count()
}

#[cfg(test)]
mod tests {
    use super::Times;

    #[test]
    fn times_that_overlap_or_differ_by_little_are_not_told_apart() {
        let times = |least, most| Times { least, most };
        assert!(times(1.0, 1.3).may_exceed(times(1.2, 1.2)));
        assert!(times(1.0, 1.0).may_exceed(times(1.04, 1.1)));
        assert!(!times(1.0, 1.3).may_exceed(times(1.4, 2.0)));
    }
}
