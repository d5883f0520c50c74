//! `afterbay list`

use crate::arguments::{Format, What};
use crate::failure::Failure;
use crate::table;
use afterbay_analysis::SYSTEMS;
use afterbay_methods::registry::{METHODS, Row};
use serde::Serialize;
use std::process::ExitCode;

#[derive(Serialize)]
struct Method {
    name: &'static str,
    order: u32,
    local_order_q: u32,
    local_order_p: u32,
    local_order_w: u32,
    keeps_k: bool,
    passive: bool,
    needs: &'static str,
    about: &'static str,
}

impl From<&Row> for Method {
    fn from(row: &Row) -> Self {
        let [local_order_q, local_order_p, local_order_w] = row.local_order;
        Self {
            name: row.name,
            order: row.order(),
            local_order_q,
            local_order_p,
            local_order_w,
            keeps_k: row.keeps_k,
            passive: row.passive,
            needs: row.needs.describe(),
            about: row.about,
        }
    }
}

pub(crate) fn run(what: What, format: Format) -> Result<ExitCode, Failure> {
    match (what, format) {
        (What::Methods, Format::Json) => table::json(&METHODS.iter().map(Method::from).collect::<Vec<_>>())?,
        (What::Systems, Format::Json) => table::json(&SYSTEMS)?,
        (What::Methods, Format::Table) => {
            let yes = |flag| if flag { "yes" } else { "" }.to_string();
            let rows = METHODS.iter().map(|row| {
                let [q, p, w] = row.local_order;
                vec![
                    row.name.into(),
                    row.order().to_string(),
                    format!("{q} {p} {w}"),
                    yes(row.keeps_k),
                    yes(row.passive),
                    row.needs.describe().into(),
                    row.about.into(),
                ]
            });
            table::print(&["method", "order", "of q p w", "keeps K", "passive", "needs", "what"], rows)?;
        }
        (What::Systems, Format::Table) => {
            let rows = SYSTEMS
                .iter()
                .map(|row| [row.name, row.equations, row.parameters, row.solution].map(String::from).into());
            table::print(&["system", "equations", "parameters", "solution"], rows)?;
        }
    }
    Ok(ExitCode::SUCCESS)
}
