//! The summary of a sweep names the points that failed and repeats the warnings of the others.

use afterbay_analysis::progress::Silent;
use afterbay_experiments::data::Files;
use afterbay_experiments::experiment;
use afterbay_experiments::record::Output;
use afterbay_experiments::scene::Scene;

/// The results and the summary of a scene's runs.
fn run(text: &str) -> (Output, String) {
    let scene = Scene::read(text).unwrap_or_else(|error| panic!("{error}"));
    let (output, findings) = experiment::run(&scene, &Silent).expect("it runs");
    (output, findings.iter().map(|finding| finding.statement.clone()).collect())
}

fn table<'a>(output: &'a Output, name: &str) -> &'a str {
    let found = output.artifacts.iter().find(|artifact| artifact.name == name);
    &found.expect("a table").text
}

/// Steps of 0.1 are too long for rk4 where k = 10^4, and far too long where k = 10^30.
const STIFFER: &str = "[system]\nname = \"damped-oscillator\"\n\
    parameters = { k = 1.0, b = 0.1 }\n[initial]\nq = [2.3]\np = [-3.1]\n\
    [time]\nend = 2.0\nstep = 0.1\n[run]\nmethods = [\"moddg\", \"rk4\"]\n\
    [sweep]\nvary = { k = [1.0, 1e4, 1e30] }\n";

#[test]
fn runs_that_fail_say_at_which_point_and_give_no_end() {
    let (output, said) = run(STIFFER);
    assert!(said.contains("5 of 6 runs completed, did not: rk4 1."), "{said}");
    let failed: Vec<_> =
        output.manifest.runs.iter().filter(|run| run.outcome != "completed").collect();
    assert_eq!(failed.len(), 1, "{failed:?}");
    assert_eq!(failed[0].point.as_deref(), Some("k = 1e30"));
    let ends = |k: &str| {
        let rows = table(&output, "data/sweep_of_run.csv").lines();
        rows.filter(|row| row.contains(k) && row.contains("rk4,q1 at the end")).count()
    };
    assert_eq!([ends(",10000.0,"), ends(",1e30,")], [1, 0]);
    assert!(output.report.html(Files::default()).contains("k = 1e30"));
}

#[test]
fn a_rise_of_the_energy_at_a_point_is_told() {
    let (_, said) = run(STIFFER);
    assert!(said.contains("H can only fall, but it rises with rk4 at 2 points (most at"), "{said}");
    let (_, said) = run(&STIFFER.replace("[1.0, 1e4, 1e30]", "[1.0, 2.0]"));
    assert!(!said.contains("rises"), "{said}");
}

/// A chart has the scale of the range, whatever the number of its values.
#[test]
fn a_linear_range_has_a_linear_axis_with_its_0() {
    let chart = |vary: &str| {
        let (output, _) = run(&STIFFER.replace("k = [1.0, 1e4, 1e30]", vary));
        let charts = output.artifacts.into_iter().filter(|x| x.name.ends_with(".svg"));
        charts.map(|x| x.text).find(|text| text.contains("q1 at the end")).expect("a chart")
    };
    for vary in [
        "b = { from = 0.0, to = 1.0, count = 60 }",
        "b = { from = 0.0, to = 1.0, count = 12 }, k = { from = 1.0, to = 2.0, count = 5 }",
    ] {
        assert!(!chart(vary).contains("are not shown"), "{vary}");
    }
    let ticks = |vary: &str| chart(vary).contains("10⁻");
    assert!(ticks("b = { from = 1e-4, to = 1e-1, count = 4, scale = \"log\" }"));
    assert!(ticks("b = [1e-4, 1e-3, 1e-2, 1e-1]"));
    assert!(!ticks("b = [0.02, 0.25, 0.5, 0.75, 1.0]"));
}

/// The last state at a multiple of `sample` is not the end.
#[test]
fn numbers_name_the_time_of_the_last_sample() {
    let text = STIFFER.replace("[1.0, 1e4, 1e30]", "[1.0]");
    let (output, _) = run(&text.replace("[\"moddg\", \"rk4\"]", "[\"moddg\"]\nsample = 0.3"));
    let table = table(&output, "data/sweep_of_run.csv");
    assert!(table.contains("moddg,q1 at t = 1.8") && !table.contains("at the end"), "{table}");
}

/// A state that is kept between two steps comes before the later of them.
#[test]
fn samples_between_steps_do_not_raise_the_energy() {
    let text = STIFFER.split("[sweep]").next().expect("a scene");
    for sample in ["0.1", "0.025", "0.001"] {
        let methods = format!("[\"moddg\", \"rk4\"]\nsample = {sample}\ntolerance = 1e-8");
        let (_, said) = run(&text.replace("[\"moddg\", \"rk4\"]", &methods));
        assert!(said.contains("3 of 3 runs") && !said.contains("rises"), "{sample}: {said}");
    }
}
