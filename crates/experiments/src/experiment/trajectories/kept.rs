//! The states of a run that are kept: all of them as rows of a table, and some for charts.

use afterbay_analysis::Model;
use afterbay_analysis::rows::{Rows, RowsFile};
use afterbay_analysis::study::trajectory::{TrajectoryRow, columns};
use serde::{Deserialize, Serialize};
use std::io::{self, BufRead, BufReader};

/// The most states that charts are made of, and the most numbers of them. A choice: twice the
/// states that are kept where a scene does not give `every`, and 32 MB.
const SHOWN: u64 = 20_000;
const NUMBERS: u64 = 1 << 22;
/// The least of these limits, of a system with very many degrees of freedom: the rows of a map.
const LEAST_SHOWN: u64 = 128;

/// The states of a run.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Kept {
    pub(super) rows: Rows,
    /// The last state.
    pub(super) last: Option<TrajectoryRow>,
}

/// The stride of the states that charts show, of `count` states of a model.
pub(super) fn stride(count: u64, model: &Model) -> u64 {
    let columns = columns(model).len() as u64;
    count.div_ceil((NUMBERS / columns).clamp(LEAST_SHOWN, SHOWN)).max(1)
}

/// Reads every `stride`-th of `count` states from a table, and the last.
pub(super) fn thinned(
    file: &RowsFile,
    (count, stride): (u64, u64),
    (method, model): (&'static str, &Model),
) -> io::Result<Vec<TrajectoryRow>> {
    let mut lines = BufReader::new(file.open()?);
    let (mut rows, mut line) = (Vec::new(), String::new());
    for n in 0..count {
        if !n.is_multiple_of(stride) && n + 1 < count {
            lines.skip_until(b'\n')?;
            continue;
        }
        line.clear();
        lines.read_line(&mut line)?;
        let row = TrajectoryRow::read(method, &line, model);
        rows.push(row.ok_or(io::ErrorKind::InvalidData)?);
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;
    use afterbay_analysis::progress::Silent;
    use afterbay_analysis::rows::{RowWriter, Shelf};
    use afterbay_analysis::study::trajectory::run;

    /// A driven system that depends on t, so that a row has all columns.
    const SCENE: &str = r#"
        [system]
        name = "custom"
        potential = "0.5*(1 + 0.2*cos(t))*q1^2 + 0.1*q1^2*q2^2 + 0.5*q2^2"
        dissipation = ["0.1*p1", "0.05*p2"]
        [drive]
        force = ["0.3*cos(1.2*t)", "0"]
        [initial]
        q = [1.0, 0.3]
        p = [0.0, -1e-300]
        [time]
        end = 300.0
        step = 0.01
        [run]
        methods = ["rk4"]
    "#;

    #[test]
    fn states_are_read_back_to_the_bit_and_charts_take_a_bounded_number() {
        let scene = Scene::read(SCENE).expect("a scene");
        let (model, rk4) = (&scene.problem.model, scene.run.expect("runs").methods);
        let found = run(&scene.problem, &rk4, scene.step, 1, &Silent).expect("a run");
        let all = &found[0].rows;
        assert_eq!(all.len(), 30_001);
        let folder = tempfile::tempdir().expect("a folder");
        let shelf = Shelf::new(folder.path(), "");
        let mut writer = RowWriter::after(Rows::default(), "rk4", Some(&shelf)).expect("a file");
        for row in all {
            assert!(writer.push(row).is_continue());
        }
        let rows = writer.finish().expect("rows");
        let (count, file) = (rows.count, rows.located(Some(&shelf)));
        let read = |stride| thinned(&file, (count, stride), ("rk4", model)).expect("rows");
        let bits = |row: &TrajectoryRow| format!("{row:?}");
        assert!(read(1).iter().map(bits).eq(all.iter().map(bits)));
        assert_eq!(stride(count, model), 2);
        let shown = read(7);
        assert_eq!(shown.len(), 4287);
        assert_eq!(shown.last().map(bits), all.last().map(bits), "the last state is shown");
        assert!(shown[..4286].iter().enumerate().all(|(n, row)| row.step == 7 * n as u64));
        let balance = &found[0].balance;
        let drift = all.iter().map(|row| (row.total - all[0].total).abs()).fold(0.0, f64::max);
        assert_eq!(balance.drift, drift);
        // The largest H from a state on, less its own.
        let later = all.iter().rev().scan(f64::NEG_INFINITY, |most, row| {
            *most = most.max(row.energy);
            Some(*most - row.energy)
        });
        let rise = later.fold(0.0, f64::max);
        assert!(rise > 0.1, "the drive raises H: {rise}");
        assert_eq!(balance.rise(), Some(rise));
    }

    #[test]
    fn charts_of_large_systems_take_fewer_states() {
        let text = |n: usize| {
            let zeros = vec!["0"; n - 1].join(", ");
            format!(
                "[system]\nname = \"fput-chain\"\n\
                 parameters = {{ n = {n}, beta = 0.3, c = 0.01 }}\n\
                 [initial]\nq = [1, {zeros}]\np = [0, {zeros}]\n[time]\nend = 4\nstep = 0.01\n"
            )
        };
        for (n, expected) in [(2, 50), (100, 73), (2000, 1433)] {
            let model = Scene::read(&text(n)).expect("a scene").problem.model;
            assert_eq!(stride(1_000_000, &model), expected, "{n}");
        }
    }
}
