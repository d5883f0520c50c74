//! The test set, with end states accurate to the last digit or nearly so.

use afterbay_analysis::Model;
use afterbay_analysis::study::Problem;
use afterbay_systems::{
    DAMPED_DOUBLE_PENDULUM, DAMPED_OSCILLATOR, DUFFING, FPUT_CHAIN, VAN_DER_POL,
};
use std::f64::consts::PI;
use std::sync::Arc;

/// A problem of the test set.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The letter of the scene.
    pub name: &'static str,
    /// A description in words.
    pub about: &'static str,
    /// The system, the initial state and the end time.
    pub problem: Arc<Problem>,
    /// The number of steps of the coarsest run of a high-order method. A method of order 4 starts
    /// with 4 times as many, one of order 2 with 16 times.
    pub coarsest: u64,
}

impl Scene {
    /// The number of degrees of freedom.
    pub fn dof(&self) -> usize {
        self.problem.q.len()
    }

    /// (q, p, w) at the end, from `data/references.csv`; `None` if it is missing there.
    pub fn reference(&self) -> Option<Vec<f64>> {
        read(include_str!("../data/references.csv"), self.name, self.dof())
    }

    /// (q, p, w) at the start.
    pub fn start(&self) -> Vec<f64> {
        let Problem { q, p, .. } = &*self.problem;
        [&q[..], p, &vec![0.0; q.len()]].concat()
    }
}

/// The rows of a scene in the table: q first, then p, then w.
fn read(table: &str, name: &str, dof: usize) -> Option<Vec<f64>> {
    let mut reader = csv::Reader::from_reader(table.as_bytes());
    let rows: Vec<(String, usize, [f64; 3])> =
        reader.deserialize().collect::<Result<_, _>>().ok()?;
    let mut of: Vec<_> = rows.iter().filter(|row| row.0 == name).collect();
    of.sort_by_key(|row| row.1);
    (of.len() == dof)
        .then(|| (0..3).flat_map(|part| of.iter().map(move |row| row.2[part])).collect())
}

/// Every scene of the test set.
pub fn all() -> [Scene; 7] {
    let scene = |name, about, model, q: Vec<f64>, p: Vec<f64>, end, coarsest| {
        let problem = Arc::new(Problem { model, q, p, end });
        Scene { name, about, problem, coarsest }
    };
    let chain = |name, about, n: usize| {
        let q = (1..=n).map(|i| (PI * i as f64 / (n + 1) as f64).sin()).collect();
        scene(
            name,
            about,
            Model::of(&FPUT_CHAIN, &[n as f64, 1.0, 0.01]),
            q,
            vec![0.0; n],
            100.0,
            25,
        )
    };
    let pendulum = Model::of(&DAMPED_DOUBLE_PENDULUM, &[1.0, 1.0, 1.0, 1.0, 1.0, 0.1, 0.1]);
    let duffing = Model::of(&DUFFING, &[-1.0, 1.0, 0.1]);
    let pol = |mu| Model::of(&VAN_DER_POL, &[mu]);
    [
        scene(
            "A",
            "damped oscillator, k = 1, b = 0.1",
            Model::of(&DAMPED_OSCILLATOR, &[1.0, 0.1]),
            vec![2.3],
            vec![-3.1],
            100.0,
            12,
        ),
        scene("B", "Duffing, two wells, c = 0.1", duffing, vec![1.5], vec![0.5], 50.0, 16),
        scene("C1", "Van der Pol, μ = 1", pol(1.0), vec![2.0], vec![0.0], 50.0, 24),
        scene("C2", "Van der Pol, μ = 1000", pol(1000.0), vec![2.0], vec![0.0], 2000.0, 10_000),
        chain("D64", "FPUT chain, β = 1, N = 64", 64),
        chain("D1024", "FPUT chain, β = 1, N = 1024", 1024),
        scene("E", "damped double pendulum", pendulum, vec![1.5, -0.5], vec![0.0; 2], 5.0, 4),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_scene_has_its_end() {
        for scene in all() {
            let end = scene.reference().unwrap();
            assert!(
                end.len() == 3 * scene.dof() && end.iter().all(|x| x.is_finite()),
                "{}",
                scene.name
            );
        }
    }

    #[test]
    fn the_reference_keeps_k() {
        for scene in all() {
            let subject = scene.problem.model.system::<f64>().unwrap();
            let total = |y: &[f64]| {
                let n = scene.dof();
                subject.energy(&y[..n], &y[n..2 * n]) + y[2 * n..].iter().sum::<f64>()
            };
            let (start, end) = (scene.start(), scene.reference().unwrap());
            let size = end[2 * scene.dof()..]
                .iter()
                .map(|w| w.abs())
                .sum::<f64>()
                .max(total(&start).abs());
            assert!((total(&end) - total(&start)).abs() < 4e-15 * size, "{}", scene.name);
        }
    }

    #[test]
    fn a_table_with_a_row_too_few_is_no_reference() {
        let table = "scene,dof,q,p,w\nD64,0,1,2,3\nE,1,4,5,6\nE,0,1,2,3\n";
        assert_eq!(read(table, "D64", 64), None);
        assert_eq!(read(table, "E", 2), Some(vec![1.0, 4.0, 2.0, 5.0, 3.0, 6.0]));
    }
}
