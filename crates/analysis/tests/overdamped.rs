//! The overdamped case with every method: each has its line, and what is made of it follows from its numbers.

use afterbay_analysis::Model;
use afterbay_analysis::paper::{self, Extent};
use afterbay_analysis::progress::Silent;
use afterbay_analysis::study::Problem;
use afterbay_analysis::study::decay::{self, Decay, DecayRow};
use afterbay_analysis::study::energy;
use afterbay_methods::registry::{METHODS, Row, find};

fn decays(b: f64, methods: &[&'static Row]) -> Vec<DecayRow> {
    let problem =
        Problem { model: Model::DampedOscillator { k: 1.0, b }, q: vec![1.0], p: vec![1.0], end: 2.0 };
    let books = energy::run(&problem, methods, 0.1, 1, &Silent).expect("runs");
    decay::rows(&problem, b, 0.1, &books, &Silent).expect("rows")
}

fn all() -> Vec<&'static Row> {
    METHODS.iter().collect()
}

#[test]
fn the_report_has_a_line_for_every_method() {
    let (output, findings) = paper::run(Extent::Quick, &Silent).expect("the paper runs");
    let table =
        output.artifacts.iter().find(|artifact| artifact.name == "data/overdamped.csv").expect("a table");
    let mut reader = csv::Reader::from_reader(table.text.as_bytes());
    assert_eq!(
        reader.headers().expect("a header"),
        vec!["method", "b", "h", "R", "R_exact", "k_drift", "decay"]
    );
    let records: Vec<_> = reader.records().map(|record| record.expect("a row")).collect();
    let html = output.report.html();
    for row in METHODS {
        for b in ["200", "5000"] {
            let lines = records.iter().filter(|r| &r[0] == row.name && r[1].trim_end_matches(".0") == b);
            assert_eq!(lines.count(), 1, "{} at b = {b}", row.name);
        }
    }
    // In the order of the registry, under the table's own header.
    let from = html.find("max |K - K₀|").expect("a table");
    let mut rest = &html[from..];
    for row in METHODS {
        let at = rest.find(&format!(">{}<", row.name)).unwrap_or_else(|| panic!("{} has no line", row.name));
        rest = &rest[at..];
    }
    let finding = findings.iter().find(|finding| finding.topic.contains("trust")).expect("a finding");
    assert!(finding.statement.starts_with("trust locally-exact and linear-exact:"), "{}", finding.statement);
}

#[test]
fn numbers_decide() {
    for b in [200.0, 5000.0] {
        for row in decays(b, &all()) {
            println!("{:24} {b} {:?} {} {:?} {}", row.method, row.ratio, row.exact, row.k_drift, row.decay);
            assert!((row.exact.ln() + 0.2 / b).abs() < 0.01 / b, "{}", row.exact);
            let loss_is_right =
                row.ratio.is_some_and(|ratio| (ratio - row.exact).abs() <= 0.1 * (1.0 - row.exact));
            let k_is_kept = row.k_drift.is_some_and(|drift| drift <= 1e-12);
            match row.decay {
                Decay::Right => assert!(loss_is_right && k_is_kept),
                Decay::RightWithoutK => assert!(loss_is_right && !k_is_kept),
                Decay::WrongWithK => assert!(!loss_is_right && k_is_kept),
                Decay::Wrong => assert!(!loss_is_right && !k_is_kept),
                Decay::Diverged | Decay::Failed(_) => {}
            }
            let claims = find(row.method).expect("registered");
            // Bounded is what A-stable promises, vanishing what L-stable does.
            assert!(!claims.a_stable || !matches!(row.decay, Decay::Diverged | Decay::Failed(_)), "{row:?}");
            assert!(!claims.l_stable || row.decay == Decay::Right, "{row:?}");
        }
    }
}

#[test]
fn names_do_not() {
    let pairs = [("moddg", Decay::WrongWithK), ("linear-exact", Decay::Right), ("rk4", Decay::Diverged)];
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
    // The simple iteration does not contract at h b/2 = 10.
    let [row] = &decays(200.0, &[find("moddg-fixed-point").expect("registered")])[..] else {
        panic!("one row")
    };
    assert_eq!((row.decay, row.ratio, row.k_drift), (Decay::Failed("not-contracting"), None, None));
    assert_eq!(row.decay.to_string(), "failed: not-contracting");
}
