//! The overdamped oscillator with every method: each has a row, and its verdict follows from its
//! numbers.

use crate::paper::PAPER;
use afterbay_analysis::progress::Silent;
use afterbay_analysis::study::Problem;
use afterbay_analysis::study::decay::{self, Decay, DecayRow};
use afterbay_analysis::study::energy::{self, EnergyRow, EnergyRun};
use afterbay_analysis::study::outcome::{Ending, INTERRUPTED};
use afterbay_analysis::{Measured, Model};
use afterbay_core::{IntegrateError, System};
use afterbay_experiments::data::Files;
use afterbay_methods::registry::{FIXED, Row, find};
use afterbay_systems::{DAMPED_OSCILLATOR, DampedOscillator};

fn problem(b: f64) -> Problem {
    Problem {
        model: Model::of(&DAMPED_OSCILLATOR, &[1.0, b]),
        q: vec![1.0],
        p: vec![1.0],
        end: 2.0,
    }
}

fn decays(b: f64, methods: &[&'static Row]) -> Vec<DecayRow> {
    let problem = problem(b);
    let runs = energy::run(&problem, methods, 0.1, 1, &Silent).expect("runs");
    decay::rows(&problem, b, 0.1, &runs, &Silent).expect("rows")
}

/// Whether the loss of energy is right.
fn is_right(decay: Decay) -> bool {
    matches!(decay, Decay::Right | Decay::RightWithoutK)
}

fn all() -> Vec<&'static Row> {
    FIXED.iter().collect()
}

#[test]
fn the_report_has_a_line_for_every_method() {
    let (output, findings) = &*PAPER;
    let table = output
        .artifacts
        .iter()
        .find(|artifact| artifact.name == "data/overdamped.csv")
        .expect("a table");
    let mut reader = csv::Reader::from_reader(table.text.as_bytes());
    assert_eq!(
        reader.headers().expect("a header"),
        vec!["method", "b", "h", "R", "R_exact", "k_drift", "decay"]
    );
    let records: Vec<_> = reader.records().map(|record| record.expect("a row")).collect();
    let html = output.report.html(Files::default());
    for row in FIXED {
        for b in ["200", "5000"] {
            let lines =
                records.iter().filter(|r| &r[0] == row.name && r[1].trim_end_matches(".0") == b);
            assert_eq!(lines.count(), 1, "{} at b = {b}", row.name);
        }
    }
    // The rows are in the order of the registry, below the header of the table.
    let from = html.find("max |K - K₀|").expect("a table");
    let mut rest = &html[from..];
    for row in FIXED {
        let at = rest
            .find(&format!(">{}<", row.name))
            .unwrap_or_else(|| panic!("{} has no line", row.name));
        rest = &rest[at..];
    }
    let topic = "methods that decay rightly";
    let finding =
        findings.iter().find(|finding| finding.topic.starts_with(topic)).expect("a finding");
    let right = decays(5000.0, &all()).into_iter().zip(decays(200.0, &all()));
    let right = right.filter(|(stiff, soft)| is_right(stiff.decay) && is_right(soft.decay));
    let right: Vec<_> = right.map(|(row, _)| row.method).collect();
    let named = finding.statement.split(": ").next().expect("a list");
    assert_eq!(
        named.replace(" and ", ", ").split(", ").collect::<Vec<_>>(),
        right,
        "{}",
        finding.statement
    );
}

/// Three states of a run, h apart, with the given energies.
fn energy_run(energies: [f64; 3], drift: f64, ending: Ending) -> EnergyRun {
    let row = |i: usize| EnergyRow {
        method: "any",
        h: 0.1,
        t: 0.1 * i as f64,
        energy: energies[i],
        drift,
        ratio: i.checked_sub(1).map(|before| energies[i] / energies[before]),
        ratio_error: None,
        doubt_ratio: None,
        w_error: 0.0,
        doubt_w: 0.0,
        w: vec![0.0],
        s: Vec::new(),
        supplied: Vec::new(),
        pumped: Vec::new(),
    };
    let rows = (0..3).map(row).collect();
    let (w, violations) = (Measured::default(), Some(0));
    EnergyRun { method: "any", rows, steps: 2, drift, w, violations, ending }
}

fn completed() -> Ending {
    Ending::of::<()>(&Ok(()), 2, 2)
}

#[test]
fn numbers_decide() {
    // The energy at the start is 2, so that K is kept within 2e-12. The exact loss of the second
    // step is 0.01.
    let exact = 0.99;
    let judge = |energies, drift| Decay::judge(&energy_run(energies, drift, completed()), exact);
    let after = |loss: f64| [2.0, 1.5, 1.5 * (1.0 - loss)];
    for (loss, drift, expected) in [
        (0.01, 0.0, Decay::Right),
        (0.010_99, 1.9e-12, Decay::Right),
        (0.009_01, 1.9e-12, Decay::Right),
        (0.01, 2.1e-12, Decay::RightWithoutK),
        (0.01, f64::NAN, Decay::RightWithoutK),
        (0.011_01, 0.0, Decay::WrongWithK),
        (0.008_99, 1.9e-12, Decay::WrongWithK),
        (0.011_01, 2.1e-12, Decay::Wrong),
        (0.5, 1e-6, Decay::Wrong),
    ] {
        assert_eq!(judge(after(loss), drift), expected, "{loss} {drift}");
    }
    assert_eq!(judge([2.0, 2.0 + 1e-11, 1.0], 0.0), Decay::Diverged);
    assert_eq!(judge([2.0, 1.5, 2.1], 0.0), Decay::Diverged);
    assert_eq!(judge([2.0, f64::NAN, 1.0], 0.0), Decay::Diverged);
    // Growth within rounding does not count.
    assert_eq!(judge([2.0, 2.0 + 1e-12, 1.98], 0.0), Decay::Right);
    let stopped = Ending::of::<()>(&Ok(()), 2, 1);
    assert_eq!(
        Decay::judge(&energy_run(after(0.01), 0.0, stopped), exact),
        Decay::Failed(INTERRUPTED)
    );
}

#[test]
fn every_line_has_the_numbers_of_its_run() {
    for b in [200.0, 5000.0] {
        let system = DampedOscillator::new(1.0, b).expect("parameters");
        for row in decays(b, &all()) {
            assert!((row.exact.ln() + 0.2 / b).abs() < 0.01 / b, "{}", row.exact);
            // The first two steps, repeated by hand.
            let problem = problem(b);
            let method =
                problem.model.bind(find(row.method).expect("registered")).expect("applies");
            let mut state = problem.start::<f64>().expect("a state");
            let mut energies = vec![system.energy(&state.q, &state.p)];
            let steps = (0..2).try_for_each(|_| {
                method.step(0.1, &mut state)?;
                energies.push(system.energy(&state.q, &state.p));
                Ok::<_, IntegrateError>(())
            });
            let ratio =
                energies.get(2).map(|energy| energy / energies[1]).filter(|r| r.is_finite());
            match (ratio, row.ratio) {
                (Some(by_hand), Some(found)) => {
                    assert!((by_hand / found - 1.0).abs() < 1e-9, "{row:?} {by_hand}");
                }
                (by_hand, found) => assert_eq!(by_hand, found, "{row:?}"),
            }
            if let Decay::Failed(_) = row.decay {
                assert!(
                    energies.iter().all(|&energy| energy <= energies[0] * (1.0 + 1e-12)),
                    "{row:?}"
                );
            }
            if is_right(row.decay) || matches!(row.decay, Decay::Wrong | Decay::WrongWithK) {
                assert!(steps.is_ok() && row.k_drift.is_some(), "{row:?}");
            }
            let claims = find(row.method).expect("registered");
            // An A-stable method is bounded; an L-stable one vanishes.
            assert!(
                !claims.a_stable || !matches!(row.decay, Decay::Diverged | Decay::Failed(_)),
                "{row:?}"
            );
            assert!(!claims.l_stable || row.decay == Decay::Right, "{row:?}");
        }
    }
}

#[test]
fn names_do_not() {
    let pairs =
        [("moddg", Decay::WrongWithK), ("linear-exact", Decay::Right), ("rk4", Decay::Diverged)];
    for (name, expected) in pairs {
        for (other, _) in pairs {
            let mut row = *find(name).expect("registered");
            row.name = other;
            let decays = decays(200.0, &[Box::leak(Box::new(row))]);
            assert_eq!((decays[0].method, decays[0].decay), (other, expected), "{name} as {other}");
        }
    }
}

#[test]
fn what_fails_says_its_word() {
    // Simple iteration does not contract at h b/2 = 10.
    let [row] = &decays(200.0, &[find("moddg-fixed-point").expect("registered")])[..] else {
        panic!("one row")
    };
    assert_eq!((row.decay, row.ratio, row.k_drift), (Decay::Failed("not-contracting"), None, None));
    assert_eq!(row.decay.to_string(), "failed: not-contracting");
}
