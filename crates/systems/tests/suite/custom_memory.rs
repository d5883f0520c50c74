//! Evaluating expressions allocates nothing, whatever the scalar.

use afterbay_core::{Curvature, Mask, Quad, Scalar, Separable, System, f64x8};
use afterbay_systems::{Custom, Description, DissipationText};

fn evaluate<T: Scalar>(custom: &Custom<T>) {
    let n = custom.dof();
    let q: Vec<T> = (0..n).map(|j| T::from_f64(0.1 + 0.01 * j as f64)).collect();
    let (p, mut hq, mut hp, mut d) = (q.clone(), q.clone(), q.clone(), q.clone());
    let used = allocation_counter::measure(|| {
        let mut sum = custom.energy(&q, &p);
        custom.gradient(&q, &p, &mut hq, &mut hp);
        custom.dissipation(&q, &p, &hp, &mut d);
        for j in 0..n {
            sum += custom.partial(&q, j, p[0])
                + custom.divided_difference(&q, j, p[0]).value
                + custom.dissipation_of(&q, &p, j).value;
        }
        custom.curvature(&q, &p, |_, _, _, x| sum += x);
        assert!(sum.is_finite().all() && custom.mass(0) == T::one());
    });
    assert_eq!(used.count_total, 0);
}

#[test]
fn evaluation_allocates_nothing() {
    // A few registers, and many: all pairs of 40.
    let pairs = |n: usize| {
        let pair = |i: usize, j: usize| format!("sqrt(1 + (q{i} - q{j})^2) + cos(q{i})*q{j}^2");
        let terms: Vec<String> = (1..=n).flat_map(|i| (1..i).map(move |j| pair(i, j))).collect();
        terms.join(" + ")
    };
    for n in [2, 8, 40] {
        let friction =
            DissipationText::Forces((1..=n).map(|j| format!("p{j}*(1 + q1^2) + p1*0.1")).collect());
        let description =
            Description { potential: pairs(n), dissipation: friction, ..Description::default() };
        let custom = Custom::new(&description).unwrap();
        evaluate(&custom);
        evaluate(&custom.map(Quad::from_f64));
        evaluate(&custom.map(f64x8::from_f64));
    }
}
