//! `afterbay list`

use crate::arguments::{Format, What};
use crate::failure::Failure;
use crate::table::{self, Column};
use afterbay_methods::registry::{METHODS, Order, Row};
use afterbay_systems::{FUNCTIONS, FUNCTIONS_OF_TWO, FUNCTIONS_WITH_JUMPS, SYSTEMS, SystemRow};
use serde::{Serialize, Serializer};
use std::process::ExitCode;

#[derive(Serialize)]
struct Method {
    name: &'static str,
    #[serde(serialize_with = "number_or_word")]
    order: Order,
    #[serde(serialize_with = "number_or_word")]
    local_order_q: Order,
    #[serde(serialize_with = "number_or_word")]
    local_order_p: Order,
    #[serde(serialize_with = "number_or_word")]
    local_order_w: Order,
    keeps_k: bool,
    passive: bool,
    a_stable: bool,
    l_stable: bool,
    cost: String,
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
            a_stable: row.a_stable,
            l_stable: row.l_stable,
            cost: row.cost.describe(),
            needs: row.needs.describe(),
            about: row.about,
        }
    }
}

fn number_or_word<S: Serializer>(order: &Order, serializer: S) -> Result<S::Ok, S::Error> {
    match order.number() {
        Some(number) => serializer.serialize_u32(number),
        None => serializer.collect_str(order),
    }
}

/// A system, as a row of the list.
#[derive(Serialize)]
struct System {
    name: &'static str,
    equations: &'static str,
    parameters: Vec<&'static str>,
    /// The units of the parameters, for a unit mass.
    units: Vec<&'static str>,
    ranges: &'static str,
    solution: &'static str,
}

impl From<&SystemRow> for System {
    fn from(row: &SystemRow) -> Self {
        let parameters = row.parameters.iter().map(|parameter| parameter.name).collect();
        let units = row.parameters.iter().map(|parameter| parameter.unit).collect();
        let SystemRow { name, equations, ranges, solution, .. } = *row;
        Self { name, equations, parameters, units, ranges, solution }
    }
}

/// A word of expressions.
#[derive(Serialize)]
struct Word {
    write: String,
    meaning: &'static str,
}

/// The elements of expressions.
fn words() -> impl Iterator<Item = Word> {
    const OTHERS: [(&str, &str); 10] = [
        ("q1, q2, ..", "coordinates; also q[1], q[i+1]"),
        ("p1, p2, ..", "momenta; also p[1], p[i+1]"),
        ("v1, v2, ..", "in D: the velocities ∂H/∂p_j; also v[1], v[i+1]"),
        ("t", "the time, in V, D and forces"),
        ("+ - * / ^", "operators; -q1^2 is -(q1^2), and 2^3^2 is 2^(3^2)"),
        ("pi", "3.14159.."),
        ("n", "the number of degrees of freedom"),
        ("i", "in a rule for all degrees of freedom: the number of this one, from 1"),
        ("sum(i, 1, n-1, (q[i+1] - q[i])^2)", "the sum over a whole number i, both ends included"),
        ("q[wrap(i+1)]", "a periodic index: n+1 is 1, and 0 is n"),
    ];
    let others = OTHERS.map(|(write, meaning)| Word { write: write.into(), meaning });
    let of_one = FUNCTIONS.into_iter().chain(FUNCTIONS_WITH_JUMPS);
    let of_one = of_one.map(|(name, meaning)| Word { write: format!("{name}(x)"), meaning });
    let of_two =
        FUNCTIONS_OF_TWO.map(|(name, meaning)| Word { write: format!("{name}(x, y)"), meaning });
    others.into_iter().chain(of_one).chain(of_two)
}

/// The methods that take a step, then those that take a tolerance.
fn methods() -> impl Iterator<Item = Method> {
    METHODS.iter().map(Method::from)
}

/// The built-in systems, and the one that a scene describes.
fn systems() -> impl Iterator<Item = System> {
    let custom = System {
        name: "custom",
        equations: "H = Σ p_j²/(2 m_j) + V(q), or any H(q, p); D_j(q, p, v), by expressions",
        parameters: Vec::new(),
        units: Vec::new(),
        ranges: "named by the scene",
        solution: "Taylor series",
    };
    SYSTEMS.iter().map(|row| System::from(*row)).chain([custom])
}

pub(crate) fn run(what: What, format: Format) -> Result<ExitCode, Failure> {
    match (what, format) {
        (What::Functions, Format::Json) => table::json(&words().collect::<Vec<_>>())?,
        (What::Methods, Format::Json) => table::json(&methods().collect::<Vec<_>>())?,
        (What::Systems, Format::Json) => table::json(&systems().collect::<Vec<_>>())?,
        (What::Functions, Format::Table) => {
            let rows = words().map(|word| vec![word.write.to_string(), word.meaning.to_string()]);
            let columns = [Column::words("write", 0, 20), Column::words("what it is", 0, 30)];
            table::print(&columns, rows)?;
        }
        (What::Methods, Format::Table) => {
            let columns = [
                Column::of("method", 0),
                Column::of("order", 0),
                Column::of("orders of q, p, w", 5),
                Column::of("keeps K", 0),
                Column::of("passive", 2),
                Column::of("stable", 3),
                Column::words("a step costs", 4, 20),
                Column::words("needs", 1, 16),
                Column::words("what it is", 6, 30),
            ];
            table::print(&columns, methods().map(Method::cells))?;
        }
        (What::Systems, Format::Table) => {
            let columns = [
                Column::of("system", 0),
                Column::words("equations", 0, 30),
                Column::words("parameters", 1, 12),
                Column::words("they may be", 2, 16),
                Column::words("solution", 3, 40),
            ];
            table::print(&columns, systems().map(System::cells))?;
        }
    }
    Ok(ExitCode::SUCCESS)
}

impl Method {
    fn cells(self) -> Vec<String> {
        let yes = |flag| if flag { "yes" } else { "" }.to_string();
        let stable = match (self.a_stable, self.l_stable) {
            (_, true) => "A, L",
            (true, false) => "A",
            (false, false) => "",
        };
        let [q, p, w] = [self.local_order_q, self.local_order_p, self.local_order_w];
        vec![
            self.name.into(),
            self.order.to_string(),
            format!("{q} {p} {w}"),
            yes(self.keeps_k),
            yes(self.passive),
            stable.into(),
            self.cost,
            self.needs.into(),
            self.about.into(),
        ]
    }
}

impl System {
    fn cells(self) -> Vec<String> {
        vec![
            self.name.into(),
            self.equations.into(),
            self.parameters.join(", "),
            self.ranges.into(),
            self.solution.into(),
        ]
    }
}
