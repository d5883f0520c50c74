//! The description of a drive and how it is parsed.

use super::super::failure::{CustomError, Place};
use super::reader::{Reader, Rules, counted};
use afterbay_expression::{Graph, Node};
use std::ops::Range;

/// The forces of a drive, as texts of expressions in q1, q2, .., t and parameters.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DriveDescription {
    /// F_j(q, t), one for each degree of freedom.
    pub forces: Vec<String>,
    /// The names and values of parameters. Parameters of the system are allowed, and need not be
    /// used.
    pub parameters: Vec<(String, f64)>,
    /// Names of expressions; see [`crate::Description::definitions`].
    pub definitions: Vec<(String, String)>,
    /// The period of the forces in t, an expression in the parameters, where it is given.
    pub period: Option<String>,
}

/// A parsed drive of `dof` degrees of freedom.
pub(crate) struct DriveReading {
    pub(crate) graph: Graph,
    pub(crate) parameters: Vec<String>,
    /// F_j for each degree of freedom.
    pub(crate) forces: Vec<Node>,
    pub(crate) period: Option<Node>,
    pub(crate) places: Vec<(Place, Node, Range<usize>)>,
    /// The names of parameters and definitions that no force mentions.
    pub(crate) unused: Vec<String>,
}

impl DriveDescription {
    pub(crate) fn read(&self, dof: usize) -> Result<DriveReading, CustomError> {
        let mut reader = Reader::new(&self.parameters, &self.definitions, Some(dof))?;
        counted("list of forces", dof, self.forces.len())?;
        let rule = Err("a force of the drive is made of coordinates, t and parameters");
        let rules =
            Rules { dof: Some(dof), momenta: rule, velocities: rule, jumps: true, ..Rules::ALL };
        let read = |(j, text): (usize, &String)| Ok(reader.read(Place::Force(j), text, rules)?.0);
        let forces =
            self.forces.iter().enumerate().map(read).collect::<Result<_, CustomError>>()?;
        let rule = Err("a period is made of numbers and parameters");
        let rules = Rules::only_parameters(rule);
        let period = self.period.as_ref().map(|text| reader.read(Place::Period, text, rules));
        let period = period.transpose()?.map(|found| found.0);
        let Reader { graph, names: parameters, used, definitions, defined, places, .. } = reader;
        let named = parameters.iter().zip(used).filter(|x| !x.1).map(|x| x.0.clone());
        let also = definitions.iter().zip(defined).filter(|x| !x.1).map(|x| x.0.name.clone());
        let unused = named.chain(also).collect();
        Ok(DriveReading { graph, parameters, forces, period, places, unused })
    }
}
