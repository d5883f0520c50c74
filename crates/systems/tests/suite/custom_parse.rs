//! The values of expressions, and the errors reported for invalid ones.

mod sums;

use afterbay_core::{Quad, Scalar, System};
use afterbay_systems::{Custom, CustomError, Description, DissipationText, Place, Problem};
use proptest::prelude::*;
use std::ops::Range;

fn custom(potential: &str) -> Result<Custom<f64>, CustomError> {
    Custom::new(&Description { potential: potential.to_owned(), ..Description::default() })
}

/// V at q1 = 3, q2 = 2, .., q10 = 10.
fn value(text: &str) -> f64 {
    let system = custom(&format!("{text} + 0*q12 + q12")).unwrap();
    let mut q = vec![3.0, 2.0, 0.5, -1.5, 0.0, 0.0, 0.0, 0.0, 0.0, 10.0, 0.0, 0.0];
    q.truncate(system.dof());
    system.energy(&q, &vec![0.0; system.dof()])
}

#[test]
fn expressions_mean_what_they_say() {
    for (text, expected) in [
        ("-q1^2", -9.0),
        ("(-q1)^2", 9.0),
        ("2^3^2", 512.0),
        ("2^-3", 0.125),
        ("2^-q2", 0.25),
        ("-2^-2^2", -0.0625),
        ("q10", 10.0),
        ("1 - 2 - 3", -4.0),
        ("16/4/2", 2.0),
        ("16/4*2", 8.0),
        ("2 + 3*4^2/8 - 1", 7.0),
        ("--3", 3.0),
        ("-+-+3", 3.0),
        ("2*-3", -6.0),
        ("q1^0", 1.0),
        ("q5^0", 1.0),
        ("q1^0.5^2", 3.0_f64.powf(0.25)),
        ("q1^1.5", 3.0 * 3.0_f64.sqrt()),
        ("q1^-2.5", 3.0_f64.powf(-2.5)),
        ("q4^3", -3.375),
        ("q4^-3", -1.0 / 3.375),
        ("q1^q2", 9.0),
        ("1e3 + 1.5e-1 + .5 + 5. + 1E+1", 1015.65),
        ("007", 7.0),
        ("\t1\n+\r\n2 ", 3.0),
        ("sin(pi/6)", 0.5),
        ("tan(pi/4)", 1.0),
        ("log(exp(q2))", 2.0),
        ("sqrt(q1 + 1)", 2.0),
        ("abs(q4)", 1.5),
        ("asin(q3)", 0.5_f64.asin()),
        ("asin(1) + asin(-1)", 0.0),
        ("acos(-1)", std::f64::consts::PI),
        ("acos(q3)", 0.5_f64.acos()),
        ("atan(q1)", 3.0_f64.atan()),
        ("sinh(q4)", (-1.5_f64).sinh()),
        ("cosh(q4)", (-1.5_f64).cosh()),
        ("tanh(q4)", (-1.5_f64).tanh()),
        ("tanh(1e300) + tanh(-1e300)", 0.0),
        ("sinh(1e-9)*1e9", 1.0),
        ("1/sinh(267*q1)", 0.0),
        ("(((((q1)))))", 3.0),
    ] {
        let found = value(text);
        assert!(
            (found - expected).abs() <= 4.0 * f64::EPSILON * expected.abs().max(1.0),
            "{text} = {found}, not {expected}"
        );
    }
}

/// What is not exact in 16 digits is left to the scalar.
#[test]
fn constants_have_the_digits_of_the_scalar() {
    let at = |text: &str, q: f64| {
        custom(text).unwrap().map(Quad::from_f64).energy(&[Quad::from_f64(q)], &[Quad::zero()])
    };
    let (third, pi) = (at("1/3*q1", 3.0) - Quad::one(), at("sin(pi) + 0*q1 + q1*0 + q1 - q1", 1.0));
    assert!(third.abs().to_f64() < 1e-31, "{third:?}");
    assert!(pi.abs().to_f64() < 1e-31, "{pi:?}");
}

fn problem(text: &str) -> (Range<usize>, Problem) {
    match custom(text) {
        Err(CustomError::Expression { place: Place::Potential, span, problem }) => (span, problem),
        other => panic!("{text}: {other:?}"),
    }
}

#[test]
fn what_is_wrong_is_said_and_where() {
    let unexpected =
        |found: &str, expected| Problem::Unexpected { found: found.to_owned(), expected };
    let (operand, operator) = ("a number, a name or a parenthesis", "an operator or the end");
    let close = "an operator or a closing parenthesis";
    let unknown = |name: &str, nearest: Option<&str>| Problem::Unknown {
        name: name.to_owned(),
        nearest: nearest.map(Into::into),
        known: "q1, q2, .., t, pi".into(),
    };
    let ends = |expected| Problem::Ends { expected };
    let no_sign =
        |left: &str, right: &str| Problem::NoSign { left: left.into(), right: right.into() };
    let index = |name: &str| Problem::Index { name: name.to_owned() };
    let number = |text: &str| Problem::Number { text: text.to_owned() };
    for (text, span, expected) in [
        ("", 0..0, ends(operand)),
        ("  ", 2..2, ends(operand)),
        ("q1 +", 4..4, ends(operand)),
        ("q1 + * 2", 5..6, unexpected("*", operand)),
        ("(q1", 3..3, ends(close)),
        ("q1)", 2..3, unexpected(")", operator)),
        ("()", 1..2, unexpected(")", operand)),
        ("2 q1", 2..4, no_sign("2", "q1")),
        ("2q1", 1..3, no_sign("2", "q1")),
        ("q1(1 - q1)", 2..3, no_sign("q1", "(")),
        ("(1 - q1) q1", 9..11, no_sign(")", "q1")),
        ("(1 - q1)(q1)", 8..9, no_sign(")", "(")),
        ("sin(2 q1)", 6..8, no_sign("2", "q1")),
        ("1.2.3", 3..4, unexpected(".", operator)),
        ("1e", 1..2, no_sign("1", "e")),
        ("q1 ** 2", 4..5, unexpected("*", operand)),
        ("q1 = 2", 3..4, unexpected("=", operator)),
        ("1, 2", 1..2, unexpected(",", operator)),
        ("sin q1", 4..6, unexpected("q1", "the parenthesis of a function")),
        ("sin()", 4..5, unexpected(")", operand)),
        ("sin(q1, q2)", 6..7, unexpected(",", close)),
        ("α*q1", 0..2, unexpected("α", operand)),
        ("q1*α", 3..5, unexpected("α", operand)),
        ("q1\0", 2..3, unexpected("\0", operator)),
        ("\u{feff}q1", 0..3, unexpected("\u{feff}", operand)),
        (".", 0..1, unexpected(".", operand)),
        ("1 + sine(q1)", 4..8, unknown("sine", Some("sin"))),
        ("sqr(q1)", 0..3, unknown("sqr", Some("sqrt"))),
        ("q1*Pi", 3..5, unknown("Pi", Some("pi"))),
        ("nan", 0..3, unknown("nan", Some("tan"))),
        ("inf + q1", 0..3, unknown("inf", None)),
        ("q", 0..1, unknown("q", None)),
        ("q1*gravity", 3..10, unknown("gravity", None)),
        ("q1_", 0..3, unknown("q1_", None)),
        ("q0", 0..2, index("q0")),
        ("1 + q01", 4..7, index("q01")),
        ("q99999999999999999999999", 0..24, index("q99999999999999999999999")),
        ("q100001", 0..7, index("q100001")),
        ("q1 + 1e400", 5..10, number("1e400")),
        ("1e-400*q1", 0..6, number("1e-400")),
        (
            "q1 + p1",
            5..7,
            Problem::NoPlace {
                name: "p1".to_owned(),
                rule: "a potential is made of coordinates, t and parameters",
            },
        ),
    ] {
        assert_eq!(problem(text), (span, expected), "{text:?}");
    }
}

#[test]
fn the_nearest_parameter_is_named() {
    let description = Description {
        potential: "alhpa*q1 + alpha*q1".to_owned(),
        parameters: vec![("alpha".to_owned(), 1.0)],
        ..Description::default()
    };
    let error = Custom::new(&description).unwrap_err().to_string();
    assert_eq!(error, "the potential, bytes 0..5: alhpa is not known: do you mean alpha?");
}

#[test]
fn size_and_nesting_are_bounded() {
    let nested =
        |n: usize, open: &str, close: &str| format!("{}q1{}", open.repeat(n), close.repeat(n));
    assert!(custom(&nested(256, "(", ")")).is_ok());
    for text in [
        nested(257, "(", ")"),
        nested(30_000, "(", ")"),
        nested(30_000, "-", ""),
        nested(10_000, "sin(", ")"),
        nested(20_000, "2^", ""),
        "(".repeat(60_000),
    ] {
        assert_eq!(problem(&text).1, Problem::TooDeep);
    }
    let long = "(".repeat(100_000);
    assert_eq!(problem(&long), (0..100_000, Problem::TooLong { bytes: 100_000 }));
    // Long and shallow is fine, and a long name is not repeated in full.
    let sum = vec!["q1"; 20_000].join("+");
    assert_eq!(custom(&sum).unwrap().energy(&[0.5], &[0.0]), 10_000.0);
    let Problem::Unknown { name, .. } = problem(&"x".repeat(60_000)).1 else { panic!() };
    assert_eq!(name.len(), 64);
}

#[test]
fn descriptions_are_checked() {
    let text = |x: &[&str]| x.iter().map(|&x| x.to_owned()).collect::<Vec<_>>();
    let good = Description {
        potential: "k*q1^2/2 + q2^2".to_owned(),
        dissipation: DissipationText::Forces(text(&["p1", "p2"])),
        masses: text(&["1", "2*k"]),
        parameters: vec![("k".to_owned(), 2.0)],
        ..Description::default()
    };
    assert_eq!(Custom::new(&good).unwrap().dof(), 2);
    let says = |change: &dyn Fn(&mut Description)| {
        let mut bad = good.clone();
        change(&mut bad);
        Custom::new(&bad).unwrap_err().to_string()
    };
    let matrix =
        |rows: &[&[&str]]| DissipationText::Matrix(rows.iter().map(|row| text(row)).collect());
    let put = |name: &str, value: f64| (name.to_owned(), value);
    for (error, expected) in [
        (
            says(&|x| x.masses = text(&["1", "2", "3"])),
            "the dissipation has 2 entries where there are 3 degrees",
        ),
        (
            says(&|x| x.dissipation = DissipationText::Forces(text(&["p1"]))),
            "the dissipation has 1 entry where there are 2",
        ),
        (
            says(&|x| {
                x.dissipation = DissipationText::Forces(text(&["p1", "p2", "p3"]));
            }),
            "the dissipation has 3 entries where there are 2",
        ),
        (
            says(&|x| x.potential.push_str(" + q3")),
            "bytes 18..20: q3 is beyond the last of 2 degrees of freedom",
        ),
        (
            says(&|x| x.dissipation = DissipationText::Forces(text(&["p1", "c*p2"]))),
            "entry 2 of the dissipation, bytes 0..1: c is not known",
        ),
        (
            says(&|x| x.dissipation = DissipationText::Forces(text(&["p1", "p2 + p3"]))),
            "entry 2 of the dissipation, bytes 5..7: p3 is beyond",
        ),
        (
            says(&|x| x.dissipation = matrix(&[&["1", "0"]])),
            "the friction matrix has 1 entry where there are 2",
        ),
        (
            says(&|x| x.dissipation = matrix(&[&["1", "0"], &["1"]])),
            "the row of the friction matrix has 1 entry",
        ),
        (
            says(&|x| x.dissipation = matrix(&[&["1", "0"], &["1", "q"]])),
            "entry 2, 2 of the friction matrix, bytes 0..1: q is not known",
        ),
        (says(&|x| x.masses = text(&["1", "k - 2"])), "m2 = 0.0 must be positive and finite"),
        (
            says(&|x| x.masses = text(&["1", "k*q1"])),
            "mass 2, bytes 2..4: q1 has no place here: a mass is made of numbers",
        ),
        (says(&|x| x.masses = text(&["1", "1/(k - 2)"])), "mass 2, bytes 0..9, is inf there"),
        (
            says(&|x| x.potential.push_str("*log(k - 3)")),
            "the potential, bytes 16..26, is NaN there",
        ),
        (says(&|x| x.parameters.push(put("c", 1.0))), "parameter c is not used"),
        (
            says(&|x| x.parameters.push(put("k", 1.0))),
            "a parameter cannot be called \"k\": the name is taken",
        ),
        (says(&|x| x.parameters.push(put("q1", 1.0))), "\"q1\": the name means something else"),
        (says(&|x| x.parameters.push(put("pi", 1.0))), "\"pi\": the name means something else"),
        (says(&|x| x.parameters.push(put("i", 1.0))), "\"i\": i is the number of the degree"),
        (says(&|x| x.parameters.push(put("n", 1.0))), "\"n\": n is the number of degrees"),
        (says(&|x| x.parameters.push(put("sin", 1.0))), "\"sin\": the name means something else"),
        (says(&|x| x.parameters.push(put("2k", 1.0))), "\"2k\": a name is made of letters"),
        (says(&|x| x.parameters.push(put("", 1.0))), "\"\": a name is made of letters"),
        (says(&|x| x.parameters[0].1 = f64::NAN), "parameter k = NaN must be finite"),
        (
            says(&|x| *x = Description { potential: "1".to_owned(), ..Description::default() }),
            "there is no degree of freedom",
        ),
    ] {
        assert!(error.contains(expected), "{error}\nsays nothing of\n{expected}");
    }
}

#[test]
fn parameters_follow_those_they_are_made_of() {
    let mut description = Description {
        potential: "omega^2*q1^2/2 + shift*q1".to_owned(),
        parameters: vec![("k".to_owned(), 9.0), ("m".to_owned(), 4.0)],
        definitions: [("shift", "omega + 1"), ("omega", "sqrt(k/m)")]
            .map(|(name, text)| (name.to_owned(), text.to_owned()))
            .to_vec(),
        ..Description::default()
    };
    let system = Custom::new(&description).unwrap();
    assert_eq!(system.energy(&[2.0], &[0.0]), 2.25 * 2.0 + 5.0);
    assert_eq!(system.with("k", 16.0).unwrap().energy(&[2.0], &[0.0]), 4.0 * 2.0 + 6.0);
    description.definitions[1].1 = "sqrt(k/m) + 0*shift".to_owned();
    let error = Custom::new(&description).unwrap_err().to_string();
    assert!(error.contains("it is defined by itself"), "{error}");
    description.definitions[1].1 = "q1".to_owned();
    let error = Custom::new(&description).unwrap_err().to_string();
    assert!(error.contains("a parameter is made of numbers and other parameters"), "{error}");
}

/// Each definition of a chain is read when those that it mentions are known. In rounds, the time
/// would grow like the cube of their number.
#[test]
fn a_long_chain_of_parameters_is_read() {
    let count = 600;
    let link = |j: usize| (format!("a{j:03}"), format!("a{:03} + 1", j + 1));
    let description = Description {
        potential: "a000*q1^2".to_owned(),
        parameters: vec![(format!("a{count:03}"), 1.0)],
        definitions: (0..count).map(link).collect(),
        ..Description::default()
    };
    let system = Custom::new(&description).unwrap();
    assert_eq!(system.energy(&[1.0], &[0.0]), 601.0);
}

#[test]
fn what_is_not_finite_at_a_state_is_found() {
    let system = custom("q1^2 + 3*log(q2 - q1)").unwrap();
    assert_eq!(system.check_at(&[0.0, 1.0], &[0.0, 0.0]), Ok(()));
    let place = Place::Potential;
    let error = system.check_at(&[2.0, 2.0], &[0.0, 0.0]).unwrap_err();
    assert_eq!(error, CustomError::NotFinite { place, span: 9..21, value: f64::NEG_INFINITY });
    let error = system.check_at(&[0.0], &[0.0, 0.0]).unwrap_err();
    assert_eq!(error.to_string(), "q has 1 entry and the number of degrees of freedom is 2");
    // The cube overflows, and V is 0.
    let cube = custom("1 + q1^-3").unwrap();
    assert_eq!(cube.check_at(&[1e90], &[0.0]), Ok(()));
    let error = cube.check_at(&[1e110], &[0.0]).unwrap_err();
    assert_eq!(error, CustomError::NotFinite { place, span: 4..9, value: f64::INFINITY });
    // The value is finite, the slope is not.
    let error = custom("sqrt(q1)").unwrap().check_at(&[0.0], &[0.0]).unwrap_err();
    assert_eq!(error.to_string(), "∂H/∂q1 = inf is not finite");
    let error = custom("q1").unwrap().check_at(&[f64::NAN], &[0.0]).unwrap_err();
    assert_eq!(error.to_string(), "q1 = NaN is not finite");
}

/// Too much is refused, and soon.
#[test]
fn what_couples_too_many_is_refused() {
    let square = |n: usize| {
        let sum: Vec<String> = (1..=n).map(|j| format!("q{j}")).collect();
        format!("exp(-({})^2)", sum.join("+"))
    };
    assert!(custom(&square(100)).is_ok());
    assert!(matches!(custom(&square(5000)), Err(CustomError::TooLarge { .. })));
}

proptest! {
    #[test]
    fn no_text_makes_it_panic(
        text in "\\PC*", other in "[-+*/^()q1p2.e 0-9a-z]{0,60}",
        bytes in prop::collection::vec(any::<u8>(), 0..80),
    ) {
        for text in [&text, &other, &*String::from_utf8_lossy(&bytes)] {
            match custom(text) {
                Ok(system) => {
                    let [q, p] = [0.3, 0.1].map(|x| vec![x; system.dof()]);
                    drop(system.check_at(&q, &p));
                }
                Err(CustomError::Expression { span, .. }) => {
                    let part = text.get(span.clone());
                    prop_assert!(part.is_some(), "{span:?} is no part of {text:?}");
                }
                Err(_) => {}
            }
        }
    }
}

/// A parameter may have the name of a velocity only where it is none.
#[test]
fn a_parameter_with_the_name_of_a_velocity_is_refused_where_both_are_meant() {
    let with = |potential: &str, force: &str, name: &str| {
        Custom::new(&Description {
            potential: potential.into(),
            dissipation: DissipationText::Forces(vec![force.into()]),
            parameters: vec![(name.into(), 2.0)],
            ..Default::default()
        })
    };
    let CustomError::Expression { problem, .. } = with("q1^2", "0.3*v1", "v1").unwrap_err() else {
        panic!("it is an expression")
    };
    assert_eq!(problem, Problem::Ambiguous { name: "v1".into() });
    // In V there are no velocities, v0 is none, and there is no v5 here.
    assert!(with("v1*q1^2", "p1", "v1").is_ok());
    assert!(with("q1^2", "v0*p1", "v0").is_ok());
    assert!(with("q1^2", "v5*p1", "v5").is_ok());
}
