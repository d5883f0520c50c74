//! References of systems that are not analytic, against closed solutions and a series written for
//! one of them.

use afterbay_core::{InputError, Quad, Separable, Series, State, System, taylor};
use afterbay_systems::{Custom, Description, DissipationText};

type Wide = Series<Quad, 24>;

fn system(potential: &str, dissipation: &str) -> Custom<f64> {
    let friction = match dissipation {
        "" => DissipationText::None,
        text => DissipationText::Forces(vec![text.to_owned()]),
    };
    let description = Description {
        potential: potential.to_owned(),
        dissipation: friction,
        masses: Vec::new(),
        parameters: Vec::new(),
        ..Description::default()
    };
    Custom::new(&description).unwrap()
}

/// q, p and w at the times `i h`.
fn follow(
    system: &Custom<f64>,
    [q, p]: [f64; 2],
    h: f64,
    count: usize,
) -> Result<Vec<[f64; 3]>, InputError> {
    let lifted = system.map(|x| Wide::constant(Quad::from(x)));
    let start = State::new(vec![Quad::from(q)], vec![Quad::from(p)]).unwrap();
    let states = taylor::trajectory::<_, _, 24>(&lifted, &start, Quad::from(h), count)?;
    Ok(states.iter().map(|state| [&state.q, &state.p, &state.w].map(|part| part[0].0)).collect())
}

/// Thrown up in air: p = tan until the top, -tanh after it, with V = q and D = |p| p.
#[test]
fn a_throw_in_air_turns_at_the_top() {
    for drag in ["abs(p1)*p1", "sqrt(p1^2)*p1", "p1*(p1^2)^0.5"] {
        let states = follow(&system("q1", drag), [0.0, 1.0], 0.25, 16).unwrap();
        let top = std::f64::consts::FRAC_PI_4;
        for (i, [q, p, w]) in states.into_iter().enumerate() {
            let t = 0.25 * i as f64 - top;
            let height = 0.5 * 2f64.ln();
            let exact = if t < 0.0 {
                [height + t.cos().ln(), -t.tan()]
            } else {
                [height - t.cosh().ln(), -t.tanh()]
            };
            let w_exact = 0.5 - exact[1] * exact[1] / 2.0 - exact[0];
            let off = [q - exact[0], p - exact[1], w - w_exact];
            assert!(off.iter().all(|x| x.abs() < 4e-15), "{drag} {i}: {off:?}");
        }
    }
}

/// Parabolas under a roof, from its ridge too, and over a kink touched twice within a short time: V
/// = |q| + 3 q has a force that does not change its sign.
#[test]
fn a_force_that_jumps_is_followed_from_kink_to_kink() {
    for roof in ["abs(q1)", "sqrt(q1^2)", "(q1^2)^0.5"] {
        let states = follow(&system(roof, ""), [1.0, 0.0], 2.0 * 2f64.sqrt(), 5).unwrap();
        for (i, [q, p, _]) in states.into_iter().enumerate() {
            let side = if i % 2 == 0 { 1.0 } else { -1.0 };
            assert!((q - side).abs() < 1e-14 && p.abs() < 1e-14, "{roof} {i}: {q} {p}");
        }
    }
    let states = follow(&system("abs(q1)", ""), [0.0, 1.0], 1.0, 8).unwrap();
    for (i, [q, p, _]) in states.into_iter().enumerate() {
        let exact = [[0.0, 1.0], [0.5, 0.0], [0.0, -1.0], [-0.5, 0.0]][i % 4];
        assert!((q - exact[0]).abs() < 1e-15 && (p - exact[1]).abs() < 1e-15, "{i}: {q} {p}");
    }
    // Up through 0 with p = 2^-10, half of that in time above it, and down again with the other
    // slope of p.
    let (start, kink) = (2.0, 2f64.powi(-10));
    let height = (kink * kink - start * start) / 4.0;
    let states = follow(&system("abs(q1) + 3*q1", ""), [height, start], 50.0, 1).unwrap();
    let left = 50.0 - (start - kink) / 2.0 - 2.0 * kink / 4.0;
    let [q, p, _] = states[1];
    let exact = [-kink * left - left * left, -kink - 2.0 * left];
    assert!((q - exact[0]).abs() < 1e-12 && (p - exact[1]).abs() < 1e-13, "{q} {p} {exact:?}");
}

/// A pendulum in a fluid, from a series of its own for either sign of p in 50 digits.
#[test]
fn a_pendulum_in_a_fluid() {
    let states =
        follow(&system("9.81*(1 - cos(q1))", "0.1*abs(p1)*p1"), [3.0, 0.0], 20.0, 1).unwrap();
    let exact = [0.171_297_544_040_079_16, -0.906_636_553_048_406_4, 18.967_256_390_468_463];
    for (found, exact) in states[1].into_iter().zip(exact) {
        assert!((found - exact).abs() < 8e-16 * exact.abs().max(1.0), "{:?}", states[1]);
    }
}

/// What comes to lie on a kink, to a power that is not whole at 0, or to a |x| of which nothing but
/// its square is said, has no series to go on with: it is not stepped over.
#[test]
fn where_series_end_is_said() {
    for (potential, drag, start) in [
        ("q1^2/2", "0.3*p1/abs(p1)", [1.0, 0.5]),
        ("abs(q1)^1.5", "", [1.0, 0.0]),
        ("(q1^2)^0.75", "", [1.0, 0.0]),
        ("sqrt(4*q1^2)", "", [1.0, 0.0]),
        ("exp(log(q1^2)/2)", "", [1.0, 0.0]),
        ("q1", "sqrt(4*p1^2)*p1", [0.0, 1.0]),
    ] {
        let ends = follow(&system(potential, drag), start, 20.0, 1).unwrap_err();
        let InputError::SolutionEnds { t } = ends else { panic!("{potential}: {ends}") };
        assert!(t > 0.1 && t < 20.0, "{potential} {drag}: {t}");
    }
}

/// Of min and max the operand that is not taken does not enter, however large it is.
#[test]
fn min_and_max_are_one_of_their_operands() {
    for potential in [
        "min(1e20, q1^2/2)",
        "min(q1^2/2, 1e20)",
        "max(-1e300, q1^2/2)",
        "max(q1^2/2, -1e300)",
        "min(max(-1e9/q1^12, q1^2/2), 1e9/q1^12)",
    ] {
        let system = system(potential, "");
        assert_eq!(system.energy(&[0.6], &[0.0]), 0.6 * 0.6 / 2.0, "{potential}");
        assert_eq!(system.partial(&[0.6], 0, 0.6), 0.6, "{potential}");
        let mean = system.divided_difference(&[0.6], 0, 1.0).value;
        assert!((mean - 0.8).abs() < 1e-15, "{potential}: {mean}");
    }
    // Across the kink the mean is that of both parts, on edges of any length.
    for cap in [3.0, 3e12] {
        let system = system(&format!("min({cap}, {cap}*q1^2)"), "");
        for length in [1.0, 1e-3, 1e-9, 1e-15] {
            let (from, to) = (1.0 - length / 3.0, 1.0 + length);
            let rise = system.divided_difference(&[from], 0, to).value * (to - from);
            let exact = cap * (1.0 - from) * (1.0 + from);
            assert!((rise - exact).abs() < 4.0 * f64::EPSILON * cap, "{cap} {length}: {rise}");
        }
    }
}

/// A power of max(x, 0), or of |x|, has the derivatives of the truncated power on both sides of 0
/// and at 0, and divided differences on edges of any length across it.
#[test]
fn powers_of_positive_parts_have_derivatives() {
    let part = |x: f64, power: f64| if x > 0.0 { x.powf(power) } else { 0.0 };
    type Slopes<'a> = &'a dyn Fn(f64) -> [f64; 2];
    let cases: [(&str, Slopes<'_>); 6] = [
        ("max(q1, 0)^2.5", &|x| [part(x, 2.5), 2.5 * part(x, 1.5)]),
        ("max(0, -q1)^2.5", &|x| [part(-x, 2.5), -2.5 * part(-x, 1.5)]),
        ("max(q1, 0)^1.6", &|x| [part(x, 1.6), 1.6 * part(x, 0.6)]),
        ("sqrt(max(q1, 0))^5", &|x| [part(x, 2.5), 2.5 * part(x, 1.5)]),
        ("(-min(q1, 0))^(4/3)", &|x| [part(-x, 4.0 / 3.0), -4.0 / 3.0 * part(-x, 1.0 / 3.0)]),
        ("abs(q1)^2.5", &|x: f64| [part(x.abs(), 2.5), 2.5 * part(x.abs(), 1.5).copysign(x)]),
    ];
    for (potential, exact) in cases {
        let system = system(potential, "");
        for from in [-2.0, -1e-9, 0.0, 1e-9, 0.7] {
            let [value, slope] = exact(from);
            let off = (system.energy(&[from], &[0.0]) - value).abs();
            assert!(off <= 1e-14 * value, "{potential} at {from}: off by {off}");
            let off = (system.partial(&[from], 0, from) - slope).abs();
            assert!(off <= 1e-14 * slope.abs(), "{potential} at {from}: slope off by {off}");
            for to in [-1.0, -1e-12, 0.0, 1e-15, 0.5, 0.7 + 1e-7] {
                let found = system.divided_difference(&[from], 0, to).value;
                let [before, after] = [from, to].map(|q| system.energy(&[q], &[0.0]));
                let (rise, bound) = (after - before, 4.0 * f64::EPSILON * (after + before));
                let off = (found * (to - from) - rise).abs();
                assert!(off <= bound, "{potential} from {from} to {to}: {found}, off by {off}");
            }
        }
    }
}
