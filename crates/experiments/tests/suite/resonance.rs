//! Resonance: amplitudes and energies of steady motions, against closed forms and each other.

use crate::sections::problem;
use afterbay_analysis::Spacing;
use afterbay_analysis::progress::{Progress, Silent};
use afterbay_analysis::study::bifurcation::Way;
use afterbay_analysis::study::dynamics::Dynamics;
use afterbay_analysis::study::resonance::{Resonance, ResonanceRow};
use afterbay_methods::registry::{REFERENCE, find};

/// The study of a system under a drive, from this start, at values of omega.
fn over(
    system: &str,
    drive: &str,
    start: [f64; 2],
    values: &[f64],
    [transient, periods]: [u64; 2],
) -> Resonance {
    let (values, spacing) = (values.to_vec(), Spacing::Linear);
    let (problem, parameter) = (problem(system, drive, start), "omega".into());
    Resonance { problem, parameter, values, spacing, transient, periods }
}

/// A hardening spring follows the upper branch where the frequency rises and the period falls.
#[test]
fn up_is_the_branch_of_rising_frequencies_also_over_periods() {
    let system = "name = \"duffing\"\nparameters = { alpha = 1.0, beta = 0.2, c = 0.1 }";
    let drive = "[drive]\nforce = [\"0.4*cos(2*pi*t/T)\"]\nparameters = { T = 6.0 }";
    let periods: Vec<f64> = (0..24).map(|i| 3.2 + 0.2 * f64::from(i)).collect();
    let study = over(system, drive, [0.0, 0.0], &periods, [100, 4]);
    let study = Resonance { parameter: "T".into(), ..study };
    let rows = study.run(find("moddg").unwrap(), 0.1, &Silent).unwrap();
    let between = |row: &&ResonanceRow| (row.frequency - 1.428).abs() < 1e-3;
    let found = rows.iter().filter(between).map(|row| (row.branch, row.amplitude[0].unwrap()));
    let found: Vec<_> = found.collect();
    let [(Way::Up, upper), (Way::Down, lower)] = found[..] else { panic!("{found:?}") };
    assert!(upper > 2.5 && lower < 0.5, "{upper} {lower}");
}

/// The amplitude of an angle that turns does not grow with the time it has turned.
#[test]
fn the_amplitude_of_an_angle_that_turns_does_not_depend_on_its_turns() {
    let system = "name = \"custom\"\npotential = \"-cos(q1)\"\ndissipation = [\"0.2*v1\"]";
    let drive = "[drive]\nforce = [\"0.5 + cos(omega*t)\"]\nparameters = { omega = 1.0 }";
    let study = |transient| over(system, drive, [0.0, 1.0], &[1.0, 1.2], [transient, 4]);
    let rows = |transient| study(transient).run(find("rk4").unwrap(), 0.05, &Silent).unwrap();
    let (short, long) = (rows(100), rows(700));
    for (short, long) in short.iter().zip(&long) {
        let [a, b] = [short, long].map(|row| row.amplitude[0].unwrap());
        assert_eq!((short.outcome, long.outcome), ("completed", "completed"));
        assert!((a - b).abs() < 1e-8 * b && b < 16.0, "{a} {b}");
    }
    assert!(long.iter().any(|row| row.amplitude[0].unwrap() > 2.0 * std::f64::consts::PI));
}

/// The study of a pendulum with this potential and this constant force, from q at rest.
fn pendulum(potential: &str, force: f64, q: f64) -> Vec<ResonanceRow> {
    let system =
        format!("name = \"custom\"\npotential = \"{potential}\"\ndissipation = [\"0.2*v1\"]");
    let drive = format!(
        "[drive]\nforce = [\"0.2*cos(omega*t) + {force}\"]\nparameters = {{ omega = 1.0 }}"
    );
    let study = over(&system, &drive, [q, 0.0], &[0.8, 1.2, 1.5], [150, 4]);
    study.run(find("rk4").unwrap(), 0.05, &Silent).unwrap()
}

/// The amplitudes of q1 in two studies, in pairs.
fn pairs(one: &[ResonanceRow], other: &[ResonanceRow]) -> Vec<[f64; 2]> {
    assert_eq!(one.len(), other.len());
    let amplitude = |row: &ResonanceRow| row.amplitude[0].unwrap();
    one.iter().zip(other).map(|(one, other)| [amplitude(one), amplitude(other)]).collect()
}

/// An angle that swings about half a turn has the amplitude of the same motion about 0, shifted.
#[test]
fn an_angle_that_swings_about_half_a_turn_is_shifted_by_half_a_turn() {
    for q in [-3.3, 3.3, 15.9] {
        for [zero, pi] in pairs(&pendulum("-cos(q1)", 0.0, 0.2), &pendulum("cos(q1)", 0.0, q)) {
            assert!((pi - zero - std::f64::consts::PI).abs() < 1e-6, "{q}: {zero} {pi}");
        }
    }
}

/// Neither the turns at the start nor those that an angle slips over several periods count.
#[test]
fn turns_before_the_steady_motion_do_not_count() {
    let expected = pendulum("-cos(q1)", 0.15, 0.2);
    for turns in [-3.0, 1.0, 40.0] {
        let found = pendulum("-cos(q1)", 0.15, 0.2 + turns * std::f64::consts::TAU);
        for [one, other] in pairs(&expected, &found) {
            assert!((one - other).abs() < 1e-9, "{turns}: {one} {other}");
        }
    }
    // From T = 8.5 to T = 6.75 this motion slips by turns, each over several periods.
    let system = "name = \"custom\"\npotential = \"-cos(q1)\"\ndissipation = [\"0.2*v1\"]";
    let drive = "[drive]\nforce = [\"0.6*cos(2*pi/T*t)\"]\nparameters = { T = 6.0 }";
    let study = Resonance {
        problem: problem(system, drive, [0.0, 0.0]),
        parameter: "T".into(),
        spacing: Spacing::Linear,
        values: vec![5.0, 6.75, 8.5, 10.25, 12.0],
        transient: 200,
        periods: 4,
    };
    let found = study.run(find("rk4").unwrap(), 0.05, &Silent).unwrap();
    for [up, down] in pairs(&found[4..5], &found[9..]) {
        assert!((up - down).abs() < 1e-8 && up < 1.0, "{up} {down}");
    }
}

#[test]
fn the_resonance_of_a_linear_oscillator_is_that_in_closed_form() {
    let system = "name = \"damped-oscillator\"\nparameters = { k = 1.0, b = 0.3 }";
    let drive = "[drive]\nforce = [\"f*cos(omega*t)\"]\nparameters = { f = 2.0, omega = 1.7 }";
    let study = over(system, drive, [0.0, 0.0], &[0.5, 0.9, 1.1, 2.0], [120, 2]);
    let found = study.run(&REFERENCE, 0.05, &Silent).unwrap();
    assert_eq!(found.len(), 8);
    for (row, &omega) in found.iter().zip(study.values.iter().cycle()) {
        let amplitude = 2.0 / f64::hypot(1.0 - omega * omega, 0.3 * omega);
        let energy = std::f64::consts::PI * 0.3 * omega * amplitude * amplitude;
        assert_eq!(row.outcome, "completed");
        assert!((row.frequency / omega - 1.0).abs() < 1e-14, "{row:?}");
        let off = row.amplitude[0].unwrap() / amplitude - 1.0;
        assert!(off.abs() < 1e-12, "{row:?}: {off:e}");
        for found in [row.supplied, row.dissipated] {
            let off = found.unwrap() / energy - 1.0;
            assert!(off.abs() < 1e-12, "{row:?}: {off:e}");
        }
    }
    // The amplitude of a method is off by its own error, which falls with its order.
    let error = |h: f64| {
        let row = &study.run(find("moddg").unwrap(), h, &Silent).unwrap()[1];
        row.amplitude[0].unwrap() * f64::hypot(1.0 - 0.81, 0.27) / 2.0 - 1.0
    };
    let order = (error(0.2) / error(0.1)).log2();
    assert!((order - 2.0).abs() < 0.1, "{order}");
}

#[test]
fn motion_that_does_not_repeat_is_not_steady() {
    let ueda = "name = \"duffing\"\nparameters = { alpha = 0.0, beta = 1.0, c = 0.05 }";
    let drive = "[drive]\nforce = [\"f*cos(omega*t)\"]\nparameters = { f = 7.5, omega = 1.0 }";
    let study = over(ueda, drive, [2.5, 0.0], &[1.0], [50, 4]);
    let found = study.run(find("increment-4").unwrap(), 0.05, &Silent).unwrap();
    assert!(found.iter().all(|row| row.outcome == "unsteady"), "{found:?}");
}

/// Steps as long as the period, in which a coordinate turns twice.
#[test]
fn amplitudes_between_long_steps_are_seen() {
    let system = "name = \"damped-oscillator\"\nparameters = { k = 400.0, b = 5.0 }";
    let drive = "[drive]\nforce = [\"f*sin(omega*t)\"]\nparameters = { f = 400.0, omega = 1.0 }";
    let study = over(system, drive, [0.0, 0.0], &[7.0, 15.0, 40.0], [200, 2]);
    for row in [&REFERENCE, find("linear-exact").unwrap()] {
        for found in study.run(row, 0.5, &Silent).unwrap() {
            let omega = found.frequency;
            let exact = 400.0 / f64::hypot(400.0 - omega * omega, 5.0 * omega);
            let off = found.amplitude[0].unwrap() / exact - 1.0;
            assert!(off.abs() < 1e-9, "{} at {omega}: {off:e}", row.name);
            assert_eq!(found.outcome, "completed", "{}", row.name);
        }
    }
}

/// A pendulum whose support moves up and down, below and above its threshold. A value after one at
/// which it comes to rest begins at the initial state.
#[test]
fn a_motion_that_comes_to_rest_is_not_measured() {
    let system = "name = \"custom\"\npotential = \"1 - cos(q1)\"\ndissipation = [\"0.1*v1\"]";
    let drive = "[drive]\nforce = [\"0.5*cos(omega*t)*sin(q1)\"]\nparameters = { omega = 2.0 }";
    let study = over(system, drive, [0.3, 0.0], &[1.8, 2.6, 3.5, 1.85], [400, 4]);
    let found = study.run(find("rk4").unwrap(), 0.05, &Silent).unwrap();
    let outcomes = |found: &[ResonanceRow]| found.iter().map(|row| row.outcome).collect::<Vec<_>>();
    assert_eq!(
        outcomes(&found[..4]),
        ["completed", "at-rest", "at-rest", "completed"],
        "{found:?}"
    );
    // A motion that still decays is not steady, however small it is.
    let short = Resonance { transient: 260, values: vec![3.5], ..study };
    assert_eq!(outcomes(&short.run(&REFERENCE, 0.05, &Silent).unwrap()), ["unsteady"; 2]);
}

/// Roundings about an equilibrium are rest, wherever it lies.
#[test]
fn a_start_at_an_equilibrium_rests() {
    for q in [0.0, 0.02_f64.sqrt(), 7.0_f64.sqrt()] {
        let system = format!(
            "name = \"custom\"\npotential = \"(q1^2 - {:?})^2/4\"\ndissipation = [\"0.1*v1\"]",
            q * q
        );
        let drive = "[drive]\nforce = [\"f*cos(omega*t)\"]\nparameters = { f = 0.0, omega = 1.0 }";
        let study = over(&system, drive, [q, 0.0], &[0.7, 1.3], [20, 4]);
        let found = study.run(find("rk4").unwrap(), 0.05, &Silent).unwrap();
        assert!(found.iter().all(|row| row.outcome == "at-rest"), "{q}: {found:?}");
    }
}

/// A run that the user stops ends within a value.
#[test]
fn a_curve_that_is_stopped_ends_at_once() {
    struct Stop(std::sync::atomic::AtomicU64);
    impl Progress for Stop {
        fn begin(&self, _: &str, _: usize) {}
        fn advance(&self) {}
        fn stopped(&self) -> bool {
            self.0.fetch_add(1, std::sync::atomic::Ordering::Relaxed) > 1000
        }
    }
    let system = "name = \"damped-oscillator\"\nparameters = { k = 1.0, b = 0.3 }";
    let drive = "[drive]\nforce = [\"cos(omega*t)\"]\nparameters = { omega = 1e-7 }";
    let study = over(system, drive, [0.0, 0.0], &[1e-7], [200, 2]);
    let (row, stop) = (find("rk4").unwrap(), Stop(0.into()));
    assert_eq!(study.run(row, 0.1, &stop).unwrap(), []);
}
