//! Events of a run, and states between its steps.

use afterbay_analysis::progress::{Progress, Silent};
use afterbay_analysis::study::events::{self, EventRow};
use afterbay_analysis::study::trajectory::Steps;
use afterbay_analysis::study::trajectory::{self, Trajectory};
use afterbay_experiments::ReportError;
use afterbay_experiments::experiment::{self, Results};
use afterbay_experiments::scene::Scene;
use afterbay_methods::registry::{ADAPTIVE, find};

/// A ball that falls with q'' = -g - c q' from height 1.
const BALL: &str = r#"
[system]
name = "custom"
potential = "g*q1"
dissipation = ["c*p1"]
parameters = { g = 9.81, c = 0.05 }
[initial]
q = [1.0]
p = [0.0]
[time]
end = 2.0
step = 0.02
[run]
methods = ["moddg", "leapfrog", "rk4", "increment-4", "collocation-6", "adaptive-dop853"]
tolerance = 1e-11
[run.events.floor]
of = "q1"
direction = "falling"
action = "bounce"
restitution = 0.9
"#;

/// The time of the first impact: the root of 1 - g t/c + g (1 - exp(-c t))/c², by mpmath.
const IMPACT: f64 = 0.453_228_999_530_087;

fn followed(text: &str, method: &str, h: f64) -> (Trajectory, Vec<EventRow>) {
    let scene = Scene::read(text).unwrap_or_else(|error| panic!("{error}"));
    let plan = scene.run.as_ref().unwrap();
    let steps = Steps { h, every: 1, tolerance: plan.tolerance };
    let row = find(method).unwrap();
    events::run(&scene.problem, row, steps, &plan.events, &Silent).unwrap()
}

#[test]
fn impacts_are_as_exact_as_the_method_and_keep_k() {
    for (method, order) in [("moddg", 2.0), ("rk4", 4.0), ("increment-4", 4.0)] {
        let error = |h: f64| (followed(BALL, method, h).1[0].t - IMPACT).abs();
        let (coarse, fine) = (error(0.2), error(0.1));
        let found = (coarse / fine).log2();
        assert!((found - order).abs() < 0.25, "{method}: {found} ({coarse:e}, {fine:e})");
    }
    for method in ["collocation-6", "adaptive-dop853"] {
        let off = followed(BALL, method, 0.02).1[0].t - IMPACT;
        assert!(off.abs() < 1e-12, "{method}: {off:e}");
    }
    for method in ["moddg", "increment-4", "collocation-6", "adaptive-dop853", "gonzalez"] {
        let (run, impacts) = followed(BALL, method, 0.02);
        assert!(run.ending.is_completed() && impacts.len() == 3, "{method}: {impacts:?}");
        for row in &run.rows {
            assert!((row.total - 9.81).abs() < 1e-13, "{method}: {row:?}");
            assert!(row.q[0] > -1e-12, "{method} is below the floor: {row:?}");
        }
        // w grows by friction and by impacts.
        assert!(run.rows.windows(2).all(|pair| pair[1].w[0] >= pair[0].w[0]), "{method}");
        // The grid goes on after an impact.
        assert!((run.rows[100].t - 2.0).abs() < 1e-13 && run.rows.len() == 101, "{method}");
    }
}

/// A ball that stays at the floor falls again in each step, by less than a rounding of zero where
/// the method chooses its steps.
#[test]
fn a_ball_that_does_not_rebound_stays_above_the_floor() {
    for (floor, restitution) in [(0.0, 0.0), (0.0, 1e-12), (-1e-5, 0.0), (-1e-5, 1e-8), (0.5, 0.0)]
    {
        let text = BALL.replace("restitution = 0.9", &format!("restitution = {restitution:e}"));
        let text = text.replace("of = \"q1\"", &format!("of = \"q1\"\nvalue = {floor:e}"));
        for tolerance in ["1e-6", "1e-11"] {
            let text = text.replace("1e-11", tolerance);
            for row in ADAPTIVE {
                let (run, impacts) = followed(&text, row.name, 0.02);
                let lowest = impacts.iter().map(|row| row.q[0]).fold(f64::INFINITY, f64::min);
                let name = format!("{} at {tolerance}, {restitution:e}, {floor:e}", row.name);
                assert_eq!(run.ending.outcome, "events-accumulate", "{name}");
                assert!(lowest > floor - 1e-12, "{name}: {lowest:e}");
                assert!(run.rows.iter().all(|row| row.q[0] > floor - 1e-12), "{name}");
            }
        }
    }
}

#[test]
fn an_expression_of_state_and_time_is_an_event() {
    let text = BALL.replace("of = \"q1\"", "when = \"q1 - 0.2*t^2\"");
    let text = text.replace("action = \"bounce\"\nrestitution = 0.9", "action = \"stop\"");
    let (run, found) = followed(&text, "increment-4", 0.02);
    assert!(run.ending.is_completed(), "{:?}", run.ending);
    assert_eq!(found.len(), 1);
    let last = run.rows.last().unwrap();
    assert_eq!(last.t, found[0].t);
    assert!((last.q[0] - 0.2 * last.t * last.t).abs() < 1e-15, "{last:?}");
}

#[test]
fn recorded_events_do_not_change_the_run() {
    let plain = BALL.split("[run.events").next().unwrap().to_owned() + "[run.events.low]\n";
    let text = plain + "of = \"H\"\nvalue = 9.5\n[run.events.half]\nof = \"q1\"\nvalue = 0.5\n";
    let text = text.replace("end = 2.0", "end = 0.4");
    for method in ["moddg", "rk4", "collocation-6"] {
        let (run, found) = followed(&text, method, 0.02);
        assert_eq!(found.len(), 1, "{found:?}");
        assert!((found[0].q[0] - 0.5).abs() < 1e-15, "{found:?}");
        let scene = Scene::read(&text).unwrap();
        let rows = [find(method).unwrap()];
        let alone = trajectory::run(&scene.problem, &rows, 0.02, 1, &Silent).unwrap();
        let (with, without) = (run.rows.last().unwrap(), alone[0].rows.last().unwrap());
        // The step with the event is taken in two parts.
        assert!((with.q[0] - without.q[0]).abs() < 1e-5, "{with:?}, {without:?}");
    }
}

/// A damped oscillator, whose states at any time are known.
const OSCILLATOR: &str = r#"
[system]
name = "damped-oscillator"
parameters = { k = 1.0, b = 0.2 }
[initial]
q = [1.0]
p = [-0.5]
[time]
end = 4.0
step = 0.1
[run]
methods = ["moddg"]
sample = 0.07
"#;

#[test]
fn states_between_steps_have_the_order_of_the_method_and_keep_k() {
    let scene = Scene::read(OSCILLATOR).unwrap();
    let spacing = 0.07;
    let dense = |method: &str, h: f64| {
        let steps = Steps { h, every: 1, tolerance: Some(1e-11) };
        let row = find(method).unwrap();
        trajectory::dense(&scene.problem, row, steps, spacing, &Silent).unwrap()
    };
    let exact = scene.problem.solution(spacing, 57, &Silent).unwrap();
    let error = |method: &str, h: f64| {
        let run = dense(method, h);
        assert!(run.ending.is_completed() && run.rows.len() == 58, "{method}");
        let mut largest = 0.0_f64;
        for (row, exact) in run.rows.iter().zip(exact.states()) {
            assert!((row.t - exact.t).abs() < 1e-13, "{row:?}");
            let parts = [(&row.q, exact.q), (&row.p, exact.p), (&row.w, exact.w)];
            for (found, exact) in parts {
                largest = largest.max((found[0] - exact[0]).abs());
            }
            if find(method).unwrap().keeps_k {
                assert!((row.total - run.rows[0].total).abs() < 1e-14, "{method}: {row:?}");
            }
        }
        largest
    };
    for (method, order) in
        [("leapfrog", 2.0), ("rk4", 4.0), ("increment-4", 4.0), ("gonzalez", 2.0)]
    {
        let found = (error(method, 0.2) / error(method, 0.1)).log2();
        assert!((found - order).abs() < 0.1, "{method}: {found}");
    }
    for method in ["linear-exact", "collocation-12", "adaptive-collocation"] {
        assert!(error(method, 0.1) < 1e-10, "{method}");
    }
}

/// Such runs take legs of 65,536 steps.
#[test]
fn failures_and_states_of_later_legs_have_their_steps() {
    // A ball that comes to rest by bouncing, after 8.6 units of time.
    let text = BALL.replace("end = 2.0", "end = 10.0").replace("c = 0.05", "c = 0");
    let text = format!("{text}[run.events.above]\nof = \"q1\"\nvalue = 2\n");
    let (run, impacts) = followed(&text, "moddg", 1e-4);
    assert_eq!(run.ending.outcome, "events-accumulate");
    let (last, failure) = (run.rows.last().unwrap(), run.ending.failure.unwrap());
    assert!(last.step > 80_000 && impacts.len() > 60, "{last:?}");
    assert!(failure.contains(&format!("step {}", last.step + 1)), "{failure}: {last:?}");
    assert!(failure.contains("event 2 of the list"), "{failure}");
    assert!(failure.ends_with("(event 2 is `floor`)"), "{failure}");
    let (steps, row) =
        (Steps { h: 1e-3, every: 1, tolerance: Some(1e-9) }, find("leapfrog").unwrap());
    let text = OSCILLATOR.replace("end = 4.0", "end = 100.0").replace("b = 0.2", "b = 0");
    let scene = Scene::read(&text).unwrap();
    let run = trajectory::dense(&scene.problem, row, steps, 0.0125, &Silent).unwrap();
    assert_eq!((run.rows.len(), run.ending.outcome), (8001, "completed"));
    for (n, row) in run.rows.iter().enumerate() {
        assert_eq!(row.step, (n as f64 * 12.5).ceil() as u64, "{row:?}");
        assert!((row.q[0] - row.t.cos() + 0.5 * row.t.sin()).abs() < 1e-4, "{row:?}");
    }
}

#[test]
fn the_tables_of_a_run_hold_its_events_and_its_samples() {
    let file = |text: &str, name: &str| {
        let (output, _) = experiment::run(&Scene::read(text).unwrap(), &Silent).unwrap();
        let found = output.artifacts.into_iter().find(|artifact| artifact.name == name);
        found.unwrap_or_else(|| panic!("{name}")).text
    };
    let events = file(BALL, "data/events.csv");
    assert!(events.starts_with("method,event,t,q1,p1,w1,H,K\nmoddg,floor,0.45"), "{events}");
    assert_eq!(events.lines().count(), 1 + 6 * 3, "{events}");
    let samples = file(OSCILLATOR, "data/trajectory.csv");
    assert_eq!(samples.lines().count(), 1 + 58);
    assert!(samples.lines().nth(2).unwrap().starts_with("moddg,1,0.07,"), "{samples}");
}

/// Studies and `pick` follow the motion without events: they take no scene in which a wall changes
/// it, and say that they go on where an event ends a run.
#[test]
fn what_is_measured_without_its_events_is_refused_or_said() {
    let study = "[study.global-order]\nmethods = [\"rk4\"]\nsteps = [0.1, 0.05]\n";
    let scene = Scene::read(BALL).expect("a scene");
    let refused = scene.refuse_changes().expect_err("a wall");
    assert_eq!(&BALL[refused.span.clone()], "action = \"bounce\"");
    assert_eq!(Scene::read(&format!("{BALL}{study}")).map(drop), Err(refused));
    let stop = BALL.replace("action = \"bounce\"\nrestitution = 0.9", "action = \"stop\"") + study;
    let scene = Scene::read(&stop).unwrap();
    assert_eq!(scene.refuse_changes(), Ok(()));
    let (_, findings) = experiment::study(&scene, &Silent).unwrap();
    let said = findings.iter().find(|finding| finding.topic == "Events").expect("a finding");
    let statement =
        "floor would end a run; studies and `pick` follow the motion to its end at t = 2.";
    assert_eq!(said.statement, statement);
    // Events that are only recorded need no word, and neither do runs, which take all of them.
    let record = stop.replace("\"stop\"", "\"record\"");
    for (text, command) in [
        (record, experiment::study as fn(&Scene, &dyn Progress) -> Result<Results, ReportError>),
        (stop, experiment::run),
    ] {
        let (_, findings) = command(&Scene::read(&text).unwrap(), &Silent).unwrap();
        assert!(findings.iter().all(|finding| finding.topic != "Events"), "{findings:?}");
    }
}

#[test]
fn mistakes_in_events_are_named() {
    for (from, to, message) in [
        ("of = \"q1\"", "of = \"q7\"", "there is no quantity q7"),
        ("of = \"q1\"", "of = \"q1 - 0.5\"", "an expression stands in `when`"),
        ("of = \"q1\"", "of = \"p1\"", "action does not belong here"),
        ("of = \"q1\"", "of = \"q1\"\nwhen = \"q1\"", "when does not belong here"),
        ("of = \"q1\"", "when = \"q1 + z\"", "z"),
        ("of = \"q1\"", "when = \"g - 2\"", "this is constant"),
        ("of = \"q1\"\n", "", "the key of is missing"),
        ("restitution = 0.9", "restitution = 1.5", "restitution = 1.5 must be from 0 to 1"),
        ("\"bounce\"", "\"stop\"", "restitution does not belong here"),
        ("tolerance = 1e-11", "tolerance = 1e-11\nsample = 0.1", "sample does not belong here"),
    ] {
        let error = Scene::read(&BALL.replace(from, to)).map(drop).unwrap_err();
        assert!(error.to_string().contains(message), "{to}: {error}");
    }
    for sample in ["0.0", "-1.0", "5.0", "1e-12"] {
        let error = Scene::read(&OSCILLATOR.replace("0.07", sample)).map(drop).unwrap_err();
        let message = error.to_string();
        assert!(message.contains("sample = ") || message.contains("output in bytes"), "{message}");
    }
}

/// A method that chooses its steps finds events in them, however far apart the rows of the table
/// are: cos t falls through -0.8 at 2.498, within the first row.
#[test]
fn events_do_not_depend_on_the_rows_of_a_method_that_chooses_its_steps() {
    let scene = r#"
[system]
name = "custom"
potential = "q1^2/2"
[initial]
q = [1.0]
p = [0.0]
[time]
end = 30.0
step = 10.0
[run]
methods = ["adaptive-dop853"]
tolerance = 1e-12
[run.events.low]
of = "q1"
value = -0.8
direction = "falling"
"#;
    let exact = |k: usize| (-0.8_f64).acos() + std::f64::consts::TAU * k as f64;
    // Steps of `adaptive-collocation` and `adaptive-radau` may be longer than the 1.3 that cos t
    // stays below -0.8: rows limit them.
    for (method, rows) in [
        ("adaptive-dop853", [10.0, 30.0, 0.1]),
        ("adaptive-verner98", [10.0, 30.0, 0.1]),
        ("adaptive-collocation", [1.0, 0.5, 0.1]),
        ("adaptive-radau", [1.0, 0.5, 0.1]),
    ] {
        for h in rows {
            let (run, found) = followed(scene, method, h);
            assert!(run.ending.is_completed() && found.len() == 5, "{method}: {found:?}");
            for (k, event) in found.iter().enumerate() {
                let off = event.t - exact(k);
                assert!(off.abs() < 1e-9, "{method} with rows of {h}: event {k} is off by {off:e}");
            }
            let last = run.rows.last().expect("a row");
            assert!((last.q[0] - 30.0_f64.cos()).abs() < 1e-9, "{method} with rows of {h}");
        }
    }
}
