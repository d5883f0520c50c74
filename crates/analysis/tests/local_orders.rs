//! The orders of local errors against an independent quad-precision computation of the same experiment.

use afterbay_analysis::Model;
use afterbay_analysis::progress::Silent;
use afterbay_analysis::study::Problem;
use afterbay_analysis::study::local_order::{LocalErrors, LocalOrder, Statistic, order};
use afterbay_core::Quad;
use afterbay_methods::registry::find;

const PAPER: Problem =
    Problem { model: Model::DampedOscillator { k: 1.0, b: 0.1 }, q: 2.3, p: -3.1, end: 20.0 };

fn study() -> LocalOrder {
    LocalOrder { base_step: 0.001, steps: vec![0.036, 0.03, 0.028, 0.02, 0.017, 0.01] }
}

/// Method, maxima of q, p, w, medians of q, p, w.
const TABLE: [(&str, [f64; 3], [f64; 3]); 9] = [
    ("moddg", [2.000, 2.000, 2.000], [1.998, 1.998, 1.999]),
    ("moddg-q3-shared", [3.179, 1.996, 2.582], [2.988, 1.998, 1.996]),
    ("moddg-qp3", [2.998, 2.998, 2.047], [2.982, 2.992, 1.999]),
    ("moddg-p3-shared", [1.999, 2.951, 1.999], [1.999, 2.986, 2.000]),
    ("moddg-p4-shared", [2.856, 6.512, 2.722], [1.998, 2.970, 1.976]),
    ("moddg-p4-single", [5.394, 4.041, 5.286], [1.998, 3.010, 1.998]),
    ("moddg-p4-single-printed", [5.266, 3.897, 5.269], [2.019, 1.985, 2.015]),
    ("moddg-qp4", [4.136, 4.041, 5.286], [3.982, 3.999, 1.999]),
    ("moddg-p3-single", [f64::NAN; 3], [f64::NAN; 3]),
];

#[test]
fn the_table_is_reproduced() {
    let methods: Vec<_> = TABLE.iter().map(|row| find(row.0).unwrap()).collect();
    let errors = study().run::<Quad>(&PAPER, &methods, &Silent).unwrap();
    for (name, maxima, medians) in TABLE {
        let errors: Vec<&LocalErrors> = errors.iter().filter(|errors| errors.method.name == name).collect();
        for variable in 0..3 {
            let max = order(&errors, variable, Statistic::Max).unwrap().slope;
            let median = order(&errors, variable, Statistic::Median).unwrap().slope;
            println!(
                "{name:25} {variable} max {max:.3} ({:.3}) median {median:.3} ({:.3})",
                maxima[variable], medians[variable]
            );
        }
    }
}
