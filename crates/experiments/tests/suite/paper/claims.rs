//! Every finding follows from its readings: other readings, and broken methods, give other
//! sentences and verdicts.

use super::PAPER;
use afterbay_analysis::progress::{Progress, Silent};
use afterbay_analysis::study::pick::{self, Wanted};
use afterbay_experiments::claim::{Found, Readings, Said};
use afterbay_experiments::compare;
use afterbay_experiments::data::Files;
use afterbay_experiments::paper::{self, Extent};
use afterbay_experiments::record::Output;
use afterbay_experiments::report::Verdict;
use afterbay_experiments::scene::Scene;
use afterbay_experiments::{Finding, ReportError, experiment};
use afterbay_methods::registry::{FIXED, Row, find};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::LazyLock;

/// A scene that declares every study.
const SCENE: &str = r#"
[system]
name = "damped-oscillator"
parameters = { k = 1.0, b = 0.1 }
[initial]
q = [2.3]
p = [-3.1]
[time]
end = 2.0
step = 0.1
[run]
methods = ["moddg", "leapfrog", "rk4"]
[study.local-order]
base_step = 0.1
steps = [0.4, 0.2]
[study.global-order]
steps = [0.1, 0.05, 0.025]
[study.energy]
step = 0.1
[study.work-precision]
steps = [0.1, 0.01]
tolerances = [1e-6]
[study.long-run]
count = 1000
methods = ["moddg", "rk4"]
[study.stability]
methods = ["moddg", "rk4"]
steps = { from = 0.1, to = 10.0, count = 4, scale = "log" }
parameter = { name = "b", from = 0.0, to = 10.0, count = 4 }
"#;

static ALL: LazyLock<Vec<Finding>> = LazyLock::new(|| {
    let scene = Scene::read(SCENE).expect("a scene");
    let (run_output, run) = experiment::run(&scene, &Silent).expect("it runs");
    let (study_output, study) = experiment::study(&scene, &Silent).expect("it runs");
    let wanted = Wanted { error: 1e-3, at_end: true, keep_k: false, passive: false };
    let picked = pick::run(&scene.problem, wanted, &Silent).expect("it runs");
    let pick = experiment::pick(&scene, &picked).expect("a report").1;
    let compared = compared([run_output, study_output]);
    PAPER.1.iter().cloned().chain(run).chain(study).chain(pick).chain(compared).collect()
});

/// The findings of a comparison with another oscillator, and with other methods.
fn compared(of_scene: [Output; 2]) -> Vec<Finding> {
    let other = SCENE.replace("b = 0.1", "b = 0.2").replace(r#", "leapfrog""#, "");
    let other = Scene::read(&other).expect("a scene");
    let run = experiment::run(&other, &Silent).expect("it runs").0;
    let study = experiment::study(&other, &Silent).expect("it runs").0;
    let folder = tempfile::tempdir().expect("a folder");
    let files = Files { png: false, ..Files::default() };
    let both = of_scene.iter().zip([&run, &study]).enumerate().flat_map(|(i, (a, b))| {
        let [at, other] = ["a", "b"].map(|name| folder.path().join(format!("{i}{name}")));
        a.write(&at, files).expect("it is written");
        b.write(&other, files).expect("it is written");
        compare::compare(&at, &other).expect("results").findings
    });
    both.collect()
}

/// A deterministic generator of pseudo-random numbers.
struct Chance(u64);

impl Chance {
    fn next(&mut self) -> u64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        self.0 >> 33
    }

    fn below(&mut self, count: usize) -> usize {
        (self.next() % count as u64) as usize
    }

    fn one<T: Clone>(&mut self, of: &[T]) -> T {
        of[self.below(of.len())].clone()
    }
}

/// Other values of readings: the words that occur for each quantity, and numbers of any size.
struct Others(BTreeMap<String, BTreeSet<String>>);

impl Others {
    fn new(all: &[Finding]) -> Self {
        let mut words: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
        for reading in all.iter().flat_map(|finding| &finding.readings.0) {
            if let Found::Word(word) = &reading.found {
                words.entry(reading.what.clone()).or_default().insert(word.clone());
            }
        }
        Self(words)
    }

    /// Another value of a reading: a number of the pool, or a word that occurs for its quantity.
    fn of(&self, readings: &Readings, i: usize, pool: &[f64], chance: &mut Chance) -> Found {
        match &readings.0[i].found {
            Found::Word(_) => {
                let words = &self.0[&readings.0[i].what];
                let mut all = words.iter().map(String::as_str).chain(["failed", ""]);
                let at = chance.below(words.len() + 2);
                Found::Word(all.nth(at).expect("a word").to_owned())
            }
            Found::Number(_) if chance.below(10) == 0 => Found::Nothing,
            Found::Number(_) | Found::Nothing => Found::Number(chance.one(pool)),
        }
    }

    /// Gives `altered` the values of the readings, with some of them replaced. The new numbers are
    /// a few of `all`, so that some agree.
    fn some(&self, readings: &Readings, altered: &mut Readings, all: &[f64], chance: &mut Chance) {
        let share = chance.one(&[1, 3, 10]);
        let pool: Vec<_> = (0..=chance.below(3)).map(|_| chance.one(all)).collect();
        for i in 0..altered.0.len() {
            altered.0[i].found = if chance.below(10) < share {
                self.of(readings, i, &pool, chance)
            } else {
                readings.0[i].found.clone()
            };
        }
    }
}

/// Numbers of any size, those of the readings, and some close to each of them.
fn numbers(readings: &Readings) -> Vec<f64> {
    let of = readings.0.iter().filter_map(|one| match one.found {
        Found::Number(x) => Some([x, x + 1.0, 10.0 * x, 100.0 * x]),
        _ => None,
    });
    of.flatten().chain([0.0, 1e-16, 1e-7, 1e-3, 1.0, 2.0, 4.0, 1e3]).collect()
}

/// The words of a sentence, with `#` for every number.
fn words(sentence: &str) -> String {
    let (mut words, mut in_number) = (Vec::with_capacity(sentence.len()), false);
    for &byte in sentence.as_bytes() {
        let begins = byte.is_ascii_digit();
        if begins && !in_number {
            words.push(b'#');
        }
        in_number = begins || in_number && matches!(byte, b'.' | b'e' | b'-' | b'+');
        if !in_number {
            words.push(byte);
        }
    }
    String::from_utf8(words).expect("whole characters")
}

#[test]
fn numbers_are_told_from_words() {
    assert_eq!(words("moddg-qp3 off by 1.0e-5, at 3 of 20."), "moddg-qp# off by #, at # of #");
}

/// Whether each reading affects the sentence or the verdict.
fn rests_on_its_readings(finding: &Finding, others: &Others) -> Result<(), String> {
    let readings = &finding.readings;
    if readings.0.is_empty() {
        return Err(format!("{} rests on nothing", finding.topic));
    }
    let all = numbers(readings);
    for i in 0..readings.0.len() {
        let (mut chance, mut altered) = (Chance(1 + i as u64), readings.clone());
        // A reading may matter only in combination: the cost of a method that is not the cheapest
        // does not.
        let matters = (0..3000).any(|round| {
            if round >= 10 {
                others.some(readings, &mut altered, &all, &mut chance);
            }
            let before = finding.again(&altered).1;
            let other = others.of(&altered, i, &numbers(&altered), &mut chance);
            let kept = std::mem::replace(&mut altered.0[i].found, other);
            let changed = finding.again(&altered).1 != before;
            altered.0[i].found = kept;
            changed
        });
        if !matters {
            return Err(format!("{}: {:?} changes nothing", finding.topic, readings.0[i]));
        }
    }
    Ok(())
}

/// Whether the verdict can change, and whether the words alone reveal the verdict.
fn can_be_lost(finding: &Finding, others: &Others) -> Result<(), String> {
    let mut seen: BTreeMap<&str, BTreeSet<String>> = BTreeMap::new();
    let (mut chance, mut altered) = (Chance(1), finding.readings.clone());
    let all = numbers(&finding.readings);
    for _ in 0..20_000 {
        others.some(&finding.readings, &mut altered, &all, &mut chance);
        let (verdict, statement) = finding.again(&altered);
        let verdict = match verdict {
            Verdict::Holds => "holds",
            Verdict::Fails => "fails",
            Verdict::Note => "note",
        };
        seen.entry(verdict).or_default().insert(words(&statement));
    }
    let none = BTreeSet::new();
    let [holds, fails, note] =
        ["holds", "fails", "note"].map(|word| seen.get(word).unwrap_or(&none));
    if holds.is_empty() && fails.is_empty() {
        return Ok(());
    }
    // A verdict can become the opposite, and a note can become a failure.
    let good = if note.is_empty() { holds } else { note };
    if good.is_empty() || fails.is_empty() {
        return Err(format!("{} is always {:?}", finding.topic, finding.verdict));
    }
    match good.intersection(fails).next() {
        Some(words) if note.is_empty() => {
            Err(format!("{} says the same of both: {words}", finding.topic))
        }
        _ => Ok(()),
    }
}

#[test]
fn every_reading_of_every_finding_changes_its_sentence() {
    let others = Others::new(&ALL);
    ALL.par_iter().for_each(|finding| rests_on_its_readings(finding, &others).unwrap());
}

#[test]
fn every_verdict_can_be_lost_and_the_words_tell_which_it_is() {
    let others = Others::new(&ALL);
    ALL.par_iter().for_each(|finding| can_be_lost(finding, &others).unwrap());
}

#[test]
fn findings_that_do_not_follow_from_their_numbers_are_caught() {
    let readings = Readings::default().and("moddg", "error", 1e-9).and("moddg", "drift", 1e-15);
    let caught = |say: fn(&Readings) -> Said| {
        let finding = Finding::new("a finding", readings.clone(), say);
        let others = Others::new(std::slice::from_ref(&finding));
        [rests_on_its_readings(&finding, &others), can_be_lost(&finding, &others)]
            .map(|of| of.is_err())
    };
    // A correct finding, one that ignores a number, one with a constant verdict, and one with
    // constant words.
    assert_eq!(caught(right), [false, false]);
    assert_eq!(caught(ignores_the_drift), [true, false]);
    assert_eq!(caught(always_holds), [false, true]);
    assert_eq!(caught(says_the_same), [false, true]);
}

fn sizes(r: &Readings) -> (f64, f64) {
    (r.number("moddg", "error"), r.number("moddg", "drift"))
}

fn judged(holds: bool) -> Verdict {
    if holds { Verdict::Holds } else { Verdict::Fails }
}

fn right(r: &Readings) -> Said {
    let (error, drift) = sizes(r);
    let word = if error < 1e-6 { "is" } else { "is not" };
    (judged(error < 1e-6), format!("it {word} accurate: off by {error:e}, K by {drift:e}"))
}

fn ignores_the_drift(r: &Readings) -> Said {
    let error = sizes(r).0;
    let word = if error < 1e-6 { "is" } else { "is not" };
    (judged(error < 1e-6), format!("it {word} accurate: off by {error:e}, and keeps K"))
}

fn always_holds(r: &Readings) -> Said {
    (Verdict::Holds, right(r).1)
}

fn says_the_same(r: &Readings) -> Said {
    let (error, drift) = sizes(r);
    (judged(error < 1e-6), format!("it is accurate: off by {error:e}, K by {drift:e}"))
}

/// The registry with some methods replaced by others, which keep the names and the claims of the
/// first.
fn broken(places: &[(&'static str, &str)]) -> &'static [Row] {
    let row = |row: &Row| match places.iter().find(|(name, _)| *name == row.name) {
        Some((_, other)) => {
            let claims = *row;
            let mut row = *find(other).expect("a registered method");
            (row.name, row.keeps_k, row.local_order) =
                (claims.name, claims.keeps_k, claims.local_order);
            (row.passive, row.a_stable, row.l_stable) =
                (claims.passive, claims.a_stable, claims.l_stable);
            row
        }
        None => *row,
    };
    FIXED.iter().map(row).collect::<Vec<_>>().leak()
}

#[test]
fn broken_methods_are_found_out() {
    // Methods that lose K, have order 1, never fail, or are no longer right.
    let places = [
        ("moddg", "leapfrog"),
        ("rk4", "collocation-4"),
        ("increment-2", "increment-1"),
        ("gonzalez", "rk4"),
        ("moddg-q3-shared", "moddg"),
        ("moddg-p4-shared", "moddg-p4-single"),
        ("locally-exact", "moddg"),
    ];
    let found = paper::run_with(broken(&places), Extent::Quick, &Silent).expect("the paper runs").1;
    assert_eq!(found.len(), PAPER.1.len());
    for (now, before) in found.iter().zip(PAPER.1.iter()) {
        assert_eq!(now.topic, before.topic);
        // A sentence about the best of many methods need not name a broken one.
        let is_word = |c: char| c.is_alphanumeric() || c == '-';
        let named = |word: &str| places.iter().any(|(name, _)| word == *name);
        let names = |finding: &Finding| finding.statement.split(|c| !is_word(c)).any(named);
        if names(now) || names(before) {
            assert_ne!(now.statement, before.statement, "{}", now.topic);
        }
    }
    let lost: Vec<_> = found
        .iter()
        .zip(PAPER.1.iter())
        .filter(|(now, before)| before.verdict == Verdict::Holds && now.verdict == Verdict::Fails)
        .map(|(now, _)| now.topic.as_str())
        .collect();
    for topic in [
        "figure 4.2, \"even when we substitute simpler expression for the δ function\"",
        "modDG on duffing",
        "modDG on van-der-pol",
        "K with a reservoir for each degree of freedom",
        "K in a long run",
        "K against N",
        "orders on fput-chain",
        "orders on van-der-pol-ring",
        "orders on damped-double-pendulum",
    ] {
        assert!(lost.contains(&topic), "{topic} still holds; lost: {lost:#?}");
    }
}

#[test]
fn a_name_no_method_has_is_refused_before_anything_runs() {
    struct Nothing;
    impl Progress for Nothing {
        fn begin(&self, stage: &str, _total: usize) {
            panic!("{stage} begins");
        }
        fn advance(&self) {}
    }
    let without: Vec<Row> = FIXED.iter().filter(|row| row.name != "gonzalez").copied().collect();
    let refused = paper::run_with(without.leak(), Extent::Quick, &Nothing).unwrap_err();
    assert!(
        matches!(&refused, ReportError::Method { name, .. } if name == "gonzalez"),
        "{refused}"
    );
}
