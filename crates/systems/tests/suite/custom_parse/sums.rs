//! Sums over degrees of freedom, and entries by their number.

use super::custom;
use afterbay_core::System;
use afterbay_systems::{Custom, CustomError, Description, DissipationText};

/// A system of `n` degrees of freedom whose lists do not say so.
fn counted(potential: &str, n: usize) -> Result<Custom<f64>, CustomError> {
    let (potential, dof) = (potential.to_owned(), Some(n));
    Custom::new(&Description { potential, dof, ..Description::default() })
}

#[test]
fn sums_are_written_out() {
    let q = [0.3, -0.7, 1.1, 0.2, -0.4];
    for (short, long) in [
        (
            "sum(i, 1, n-1, exp(q[i+1] - q[i]) - 1)",
            "exp(q2 - q1) - 1 + (exp(q3 - q2) - 1) + (exp(q4 - q3) - 1) + (exp(q5 - q4) - 1)",
        ),
        (
            "sum(k, 1, n, (q[wrap(k+1)] - q[k])^4/k)",
            "(q2 - q1)^4/1 + (q3 - q2)^4/2 + (q4 - q3)^4/3 + (q5 - q4)^4/4 + (q1 - q5)^4/5",
        ),
        ("sum(i, 1, 2, sum(j, i, 2*i, i*q[j]))", "q1 + q2 + (2*q2 + 2*q3 + 2*q4)"),
        ("q1 + sum(i, 3, 2, (q[i] + 1)) + q[n]", "q1 + 0 + q5"),
        ("q[wrap(0)] + q[wrap(-n)]*q[-(1 - 2*2)]", "q5 + q5*q3"),
        ("sum(i, 4, 4, sin(q[i]))^2 + 0*n", "sin(q4)^2 + 0*q5"),
    ] {
        let long = custom(&format!("{long} + 0*q5")).unwrap();
        let short = counted(&format!("{short} + 0*n"), 5).unwrap();
        assert_eq!(short.dof(), 5);
        let ([mut a, mut b], zero) = ([[0.0; 5]; 2], [0.0; 5]);
        assert_eq!(short.energy(&q, &zero).to_bits(), long.energy(&q, &zero).to_bits());
        let mut v = [0.0; 5];
        short.gradient(&q, &zero, &mut a, &mut v);
        long.gradient(&q, &zero, &mut b, &mut v);
        assert_eq!(a, b);
    }
}

#[test]
fn a_list_numbers_its_entries() {
    let system = Custom::new(&Description {
        potential: "sum(i, 1, n, q[i]^2)".to_owned(),
        dissipation: DissipationText::Forces(vec!["i*p[i]".to_owned(); 3]),
        masses: vec!["1 + 0.5*i/n".to_owned(); 3],
        ..Description::default()
    })
    .unwrap();
    let (p, mut d) = ([1.0, 2.0, 3.0], [0.0; 3]);
    let (mut hq, mut v) = ([0.0; 3], [0.0; 3]);
    system.gradient(&[0.0; 3], &p, &mut hq, &mut v);
    system.dissipation(&[0.0; 3], &p, &v, &mut d);
    assert_eq!(d, [1.0, 4.0, 9.0]);
    assert_eq!(v, [1.0 / (1.0 + 0.5 / 3.0), 2.0 / (1.0 + 1.0 / 3.0), 3.0 / 1.5]);
}

#[test]
fn sums_that_mean_nothing_are_refused() {
    for (text, expected) in [
        ("q[0]", "q[0] does not exist: entries are counted from 1"),
        ("sum(i, 1, n, q[i+1])", "q[6] does not exist: entries are counted from 1 to 5"),
        ("sum(i, 1, n, p[i])", "p[1] has no place here: a potential is made of coordinates"),
        ("sum(i, 1, n, q[j])", "j is not known"),
        ("q[1.5]", ". where an operator or a closing bracket should be"),
        ("q[1", "the expression ends where an operator or a closing bracket should be"),
        ("sum(i, 1, n)", ") where an operator or a comma should be"),
        ("sum(1, 2, q1)", "1 cannot be the index of a sum"),
        ("sum(i, 1, 3, 1 +)", ") where a number"),
        ("q[3000000000]", "an index is at most"),
        ("q[2000000000*2000000000]", "an index is at most"),
        ("sum(i, 1, 2000000000, q[1])", "its sums are too long"),
        ("sum(i, 1, 9999, sum(j, 1, 9999, q[1]))", "its sums are too long"),
        ("q7 + 0*n", "q7 is beyond the last of 5 degrees of freedom"),
    ] {
        let error = counted(text, 5).unwrap_err().to_string();
        assert!(error.contains(expected), "{text}: {error}");
    }
    let error = custom("sum(i, 1, n, q[i])").unwrap_err().to_string();
    assert!(error.contains("the number of degrees of freedom is not known here"), "{error}");
    assert!(counted(&format!("q{}1{}", "[(".repeat(300), ")]".repeat(300)), 5).is_err());
}
