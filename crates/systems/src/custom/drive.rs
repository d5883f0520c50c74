//! Forces of a drive, F_j(q, t), described by expressions.

use super::breaks::{Breaks, of_time_and_state};
use super::description::DriveDescription;
use super::failure::{CustomError, Place};
use super::programs::{Builder, Part, closed};
use super::wave::Wave;
use super::{checks, harmonics, period, time_point};
use afterbay_core::{Drive, Harmonics, Scalar};
use afterbay_expression::{Graph, Input, Kinds, Node};
use std::ops::Range;
use std::sync::Arc;

/// The points at which a period is compared with the forces.
const PERIOD_POINTS: usize = 16;
/// The largest change of a force over a period, relative to its size. It covers periods given with
/// ten digits.
const PERIOD_TOLERANCE: f64 = 1e-9;

/// The part of a drive that does not depend on the values of its parameters.
#[derive(Debug)]
struct Shape {
    graph: Graph,
    parameters: Vec<String>,
    places: Vec<(Place, Node, Range<usize>)>,
    /// The degrees of freedom whose force is not 0.
    driven: Vec<usize>,
    /// The programs of F_j, and of its slopes by the inputs, of each of them.
    forces: Vec<(Part, Vec<Part>, Vec<Input>)>,
    /// F_j of the driven degrees of freedom, and those among them that are waves.
    roots: Vec<Node>,
    waves: Vec<Option<Wave<Node>>>,
    /// The period, where it is given.
    period: Option<Node>,
    /// The functions at whose zeros forces may not be analytic: those of t, and the others.
    kinks: [Vec<Part>; 2],
    breaks: Breaks,
    poles: Breaks,
    closed: Vec<Node>,
    frames: Vec<Node>,
}

/// A drive with its parameters in a scalar. Clones and the same drive in other scalars share its
/// programs.
#[derive(Clone, Debug)]
pub struct CustomDrive<T> {
    shape: Arc<Shape>,
    parameters: Vec<T>,
    frames: Vec<T>,
    waves: Vec<Option<Wave<T>>>,
}

impl CustomDrive<f64> {
    /// Compiles the description of a drive on `dof` degrees of freedom. Returns the names of
    /// parameters that it does not mention, too.
    ///
    /// # Errors
    /// [`CustomError`], with the expression and the place in it.
    pub fn new(
        description: &DriveDescription,
        dof: usize,
    ) -> Result<(Self, Vec<String>), CustomError> {
        let reading = description.read(dof)?;
        let mut builder = Builder::new(reading.graph);
        let (mut driven, mut forces) = (Vec::new(), Vec::new());
        let mut nodes = Vec::new();
        for (j, &force) in reading.forces.iter().enumerate() {
            if builder.graph.is_zero(force) {
                continue;
            }
            let kinds = [Kinds::COORDINATES, Kinds::END];
            let (mut slopes, mut inputs) = (Vec::new(), Vec::new());
            for kind in kinds {
                let by = builder.graph.inputs(force, kind);
                slopes.extend(builder.graph.gradient(force, kind, &by));
                inputs.extend(by);
            }
            nodes.push(force);
            let part = builder.one(&[force])?;
            forces.push((part, builder.many(&slopes)?, inputs));
            driven.push(j);
        }
        let kinks = builder.graph.kinks(&nodes);
        let breaks = Breaks::new(&mut builder, &kinks, Input::End)?;
        let poles = builder.graph.poles(&nodes);
        let poles = Breaks::new(&mut builder, &poles, Input::End)?;
        let [of_time, of_state] = of_time_and_state(&builder.graph, &kinks, Input::End);
        let kinks = [builder.many(&of_time)?, builder.many(&of_state)?];
        let waves: Vec<_> =
            nodes.iter().map(|&force| Wave::new(&mut builder.graph, force)).collect();
        let Builder { graph, frames, .. } = builder;
        let places = reading.places;
        let evaluated = frames.iter().copied().chain(waves.iter().flatten().flat_map(Wave::nodes));
        let closed = closed(&graph, evaluated.collect(), &[], &places);
        let (parameters, period, roots) = (reading.parameters, reading.period, nodes);
        let shape = Shape {
            graph,
            parameters,
            places,
            driven,
            forces,
            roots,
            waves,
            period,
            kinks,
            breaks,
            poles,
            closed,
            frames,
        };
        let values = description.parameters.iter().map(|x| x.1).collect();
        let drive = Self::bind(Arc::new(shape), values).checked(dof)?;
        Ok((drive, reading.unused))
    }

    /// Checks that the parts that depend on the parameters alone are finite, and the period.
    fn checked(self, dof: usize) -> Result<Self, CustomError> {
        let shape = &self.shape;
        checks::closed_are_finite(&shape.graph, &shape.places, &shape.closed, &self.parameters)?;
        if let Some(period) = self.given_period() {
            self.check_period(period, dof)?;
        }
        Ok(self)
    }

    /// The drive with another value of a parameter, if it has one of this name. `dof` is the number
    /// of degrees of freedom.
    ///
    /// # Errors
    /// Those of [`super::Custom::with`], and an error if the given period is no longer one.
    pub fn with(&self, name: &str, value: f64, dof: usize) -> Result<Self, CustomError> {
        let parameters = checks::replaced(&self.shape.parameters, &self.parameters, name, value)?;
        Self::bind(Arc::clone(&self.shape), parameters).checked(dof)
    }

    /// A period of all forces in t: the one that is given, or one that their form shows, where t
    /// occurs only in sines and cosines whose frequencies are multiples of one.
    pub fn period(&self) -> Option<f64> {
        let shape = &self.shape;
        self.given_period()
            .or_else(|| period::in_time(&shape.graph, &shape.roots, &self.parameters))
    }

    fn given_period(&self) -> Option<f64> {
        let node = self.shape.period?;
        let graph = &self.shape.graph;
        graph.evaluate(&graph.all(&[node]), &self.parameters, &|_| 0.0).get(&node).copied()
    }

    /// Compares the forces at some points with those one period later.
    fn check_period(&self, period: f64, dof: usize) -> Result<(), CustomError> {
        if !(period > 0.0 && period.is_finite()) {
            return Err(CustomError::PeriodRange { period });
        }
        // Points without a pattern: multiples of the golden ratio.
        let point = |i: usize| (i as f64 * 1.618_033_988_749_895).fract();
        for (k, &j) in self.shape.driven.iter().enumerate() {
            for i in 1..=PERIOD_POINTS {
                let q: Vec<f64> = (0..dof).map(|n| 2.0 * point(i + 7 * n) - 1.0).collect();
                let t = period * point(i);
                let [before, after] = [t, t + period].map(|t| self.force(k, &q, t));
                let same = (after - before).abs() <= PERIOD_TOLERANCE * (before.abs() + 1.0);
                if before.is_finite() && after.is_finite() && !same {
                    return Err(CustomError::NoPeriod { period, dof: j, t, before, after });
                }
            }
        }
        Ok(())
    }

    /// Checks that all forces are finite at (q, t).
    ///
    /// # Errors
    /// [`CustomError::NotFinite`] with the first operation that is not.
    pub fn check_at(&self, q: &[f64], t: f64) -> Result<(), CustomError> {
        let shape = &self.shape;
        let operations: Vec<Node> = shape.places.iter().map(|x| x.1).collect();
        let values =
            shape.graph.evaluate(&shape.graph.all(&operations), &self.parameters, &|input| {
                match input {
                    Input::Coordinate(j) => q[j as usize],
                    _ => t,
                }
            });
        checks::first_not_finite(&shape.graph, &shape.places, &values)
    }
}

impl<T: Scalar> CustomDrive<T> {
    /// The drive in another scalar. `f` receives the name and the value of each parameter and
    /// returns the new value.
    pub fn lift<U: Scalar>(&self, f: impl Fn(&str, T) -> U) -> CustomDrive<U> {
        let parameters = self.parameters().map(|(name, x)| f(name, x)).collect();
        CustomDrive::bind(Arc::clone(&self.shape), parameters)
    }

    /// The names and values of the parameters.
    pub fn parameters(&self) -> impl Iterator<Item = (&str, T)> {
        self.shape.parameters.iter().map(String::as_str).zip(self.parameters.iter().copied())
    }

    fn bind(shape: Arc<Shape>, parameters: Vec<T>) -> Self {
        let closed = shape.graph.evaluate(&shape.closed, &parameters, &|_| T::zero());
        let at = |node: &Node| closed.get(node).copied().unwrap_or(T::zero());
        let frames = shape.frames.iter().map(at).collect();
        let waves =
            shape.waves.iter().map(|wave| wave.as_ref().map(|wave| wave.with(at))).collect();
        Self { shape, parameters, frames, waves }
    }

    fn frame(&self, part: &Part) -> &[T] {
        &self.frames[part.frame.clone()]
    }

    fn put_kinks(&self, parts: &[Part], q: &[T], t: T, put: &mut dyn FnMut(T)) {
        for part in parts {
            part.program.run(self.frame(part), &time_point(q, t), |_, x| put(x));
        }
    }
}

impl<T: Scalar> Drive<T> for CustomDrive<T> {
    fn driven(&self) -> &[usize] {
        &self.shape.driven
    }

    fn force(&self, k: usize, q: &[T], t: T) -> T {
        if let Some(wave) = &self.waves[k] {
            return wave.at(t);
        }
        let (part, ..) = &self.shape.forces[k];
        let [force] = part.program.results(self.frame(part), &time_point(q, t));
        force
    }

    fn slopes(&self, k: usize, q: &[T], t: T, put: &mut dyn FnMut(Option<usize>, T)) {
        let (_, slopes, inputs) = &self.shape.forces[k];
        for part in slopes {
            part.program.run(self.frame(part), &time_point(q, t), |index, slope| {
                put(
                    match inputs[index as usize] {
                        Input::Coordinate(j) => Some(j as usize),
                        _ => None,
                    },
                    slope,
                );
            });
        }
    }

    fn depends_on_own(&self, k: usize) -> bool {
        let (own, (_, _, inputs)) = (self.shape.driven[k], &self.shape.forces[k]);
        inputs.contains(&Input::Coordinate(own as u32))
    }

    fn depends_on_coordinates(&self, k: usize) -> bool {
        let (_, _, inputs) = &self.shape.forces[k];
        inputs.iter().any(|input| matches!(input, Input::Coordinate(_)))
    }

    fn harmonics(&self, k: usize) -> Option<Harmonics<T>> {
        harmonics::harmonics(&self.shape.graph, self.shape.roots[k], &self.parameters)
    }

    fn kinks(&self, q: &[T], t: T, put: &mut dyn FnMut(T)) {
        self.put_kinks(&self.shape.kinks[0], q, t, put);
        self.kinks_of_state(q, t, put);
    }

    fn kinks_of_state(&self, q: &[T], t: T, put: &mut dyn FnMut(T)) {
        self.put_kinks(&self.shape.kinks[1], q, t, put);
    }

    fn may_be_singular(&self) -> bool {
        !self.shape.poles.is_empty()
    }

    fn is_singular_between(&self, from: T, to: T) -> bool {
        self.shape.poles.is_between(&self.frames, [from, to])
    }

    fn step_between_breaks(&self, t: T, h: T) -> T {
        self.shape.breaks.step(&self.frames, t, h)
    }
}
