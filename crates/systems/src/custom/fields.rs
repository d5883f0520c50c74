//! The energy of a described system, its derivatives and its dissipation, by kernels and programs.

use super::Custom;
use super::programs::{Part, run_at};
use super::shape::{DissipationKernel, DividedDifference, Potential};
use afterbay_core::singularity::{between, enclosed};
use afterbay_core::{
    Block, Coupling, Curvature, Dissipation, DissipationForm, Interval, Line, Scalar, Separable,
    System,
};
use afterbay_expression::{Input, Point};

impl<T: Scalar> Custom<T> {
    fn frame(&self, part: &Part) -> &[T] {
        &self.frames[part.frame.clone()]
    }

    /// Runs programs and writes their results.
    #[inline(never)]
    fn fill(&self, parts: &[Part], point: &Point<'_, T>, to: &mut [T]) {
        for part in parts {
            part.program.run(self.frame(part), point, |j, x| to[j as usize] = x);
        }
    }

    /// Computes ∂H/∂p.
    #[inline(always)]
    fn velocities(&self, p: &[T], hp: &mut [T]) {
        if self.unit_mass {
            hp.copy_from_slice(p);
            return;
        }
        for (j, hp) in hp.iter_mut().enumerate() {
            *hp = p[j] * self.inverse_masses[j];
        }
    }

    /// Whether the part of V has no value somewhere between q and q with q_j moved to `to`.
    #[cold]
    fn is_singular(&self, part: &Part, q: &[T], j: usize, to: T) -> bool {
        let frame = self.frame(part);
        (0..T::LANES).any(|lane| {
            part.program.is_singular(
                [q[j].lane(lane), to.lane(lane)],
                &|k| enclosed(frame[k], lane),
                &|input, end| match input {
                    Input::Coordinate(i) => enclosed(q[i as usize], lane),
                    Input::End => end,
                    _ => Interval::WHOLE,
                },
            )
        })
    }

    /// Whether D has no value somewhere on a line, of which a share gives an enclosure of each
    /// coordinate.
    #[cold]
    fn is_dissipation_singular(
        &self,
        coordinate: impl Fn(usize, Interval, usize) -> Interval,
    ) -> bool {
        self.shape.singular_dissipations.iter().any(|part| {
            let frame = self.frame(part);
            (0..T::LANES).any(|lane| {
                let input = |input, share| match input {
                    Input::Coordinate(i) => coordinate(i as usize, share, lane),
                    _ => Interval::WHOLE,
                };
                part.program.is_singular([0.0, 1.0], &|k| enclosed(frame[k], lane), &input)
            })
        })
    }

    #[inline(never)]
    fn run<const K: usize>(&self, part: &Part, q: &[T], p: &[T], end: T) -> [T; K] {
        part.program.results(self.frame(part), &Point { end, ..Point::new(q, p, &[]) })
    }
}

impl<T: Scalar> System<T> for Custom<T> {
    #[inline]
    fn dof(&self) -> usize {
        self.shape.dof
    }

    #[inline]
    fn energy(&self, q: &[T], p: &[T]) -> T {
        let potential = match &self.shape.potential {
            Potential::Ridges { once, .. } => once.total(&self.frames, q),
            Potential::Programs { value, .. } => {
                let [potential] = self.run(value, q, p, T::zero());
                potential
            }
        };
        let twice = p
            .iter()
            .zip(&self.inverse_masses)
            .fold(T::zero(), |sum, (&p, &m)| (p * p).mul_add(m, sum));
        twice.half() + potential
    }

    #[inline(always)]
    fn gradient(&self, q: &[T], p: &[T], hq: &mut [T], hp: &mut [T]) {
        match &self.shape.potential {
            Potential::Ridges { along, .. } => along.slopes(&self.frames, q, hq),
            Potential::Programs { gradient, .. } => {
                self.fill(gradient, &Point::new(q, p, &[]), hq);
            }
        }
        self.velocities(p, hp);
    }

    #[inline(always)]
    fn dissipation(&self, q: &[T], p: &[T], v: &[T], d: &mut [T]) {
        match &self.shape.dissipation_kernel {
            DissipationKernel::Constant(rates) if rates.is_empty() => d.fill(T::zero()),
            DissipationKernel::Constant(_) => {
                for (j, d) in d.iter_mut().enumerate() {
                    *d = self.rates[j][1] * v[j];
                }
            }
            DissipationKernel::Linear(rates) => {
                rates.values(&self.frames, q, d);
                for (j, d) in d.iter_mut().enumerate() {
                    *d *= if self.unit_mass { v[j] } else { self.masses[j] * v[j] };
                }
            }
            DissipationKernel::General { forces, .. } => {
                self.fill(forces, &Point::new(q, p, v), d);
            }
        }
    }

    #[inline]
    fn has_batches(&self) -> bool {
        matches!(self.shape.potential, Potential::Programs { .. })
            || matches!(self.shape.dissipation_kernel, DissipationKernel::General { .. })
    }

    fn gradients(&self, q: &[&[T]], p: &[&[T]], hq: &mut [&mut [T]], hp: &mut [&mut [T]]) {
        match &self.shape.potential {
            Potential::Ridges { along, .. } => {
                q.iter().zip(hq).for_each(|(q, hq)| along.slopes(&self.frames, q, hq));
            }
            Potential::Programs { gradient, .. } => {
                let point = |i| Point::new(q[i], p[i], &[]);
                run_at(gradient, &self.frames, q.len(), point, |i, j, x| hq[i][j as usize] = x);
            }
        }
        p.iter().zip(hp).for_each(|(p, hp)| self.velocities(p, hp));
    }

    fn dissipations(&self, q: &[&[T]], p: &[&[T]], v: &[&[T]], d: &mut [&mut [T]]) {
        let DissipationKernel::General { forces, .. } = &self.shape.dissipation_kernel else {
            for i in 0..d.len() {
                self.dissipation(q[i], p[i], v[i], d[i]);
            }
            return;
        };
        let point = |i| Point::new(q[i], p[i], v[i]);
        run_at(forces, &self.frames, q.len(), point, |i, j, x| d[i][j as usize] = x);
    }

    #[inline(always)]
    fn unit_mass(&self) -> bool {
        self.unit_mass
    }

    #[inline(always)]
    fn dissipation_form(&self) -> DissipationForm {
        self.dissipation_form
    }

    fn finds_dissipation_form(&self) -> bool {
        true
    }

    #[inline]
    fn coupling(&self) -> Coupling {
        self.shape.structure.coupling.clone()
    }

    /// The arguments of each |x|, √x and ln x in ∂V/∂q_j and D_j.
    fn kinks(&self, q: &[T], p: &[T], put: &mut dyn FnMut(T)) {
        let point = Point::new(q, p, &[]);
        for part in &self.shape.kinks[0] {
            part.program.run(self.frame(part), &point, |_, x| put(x));
        }
        self.kinks_of_state(q, p, put);
    }

    fn kinks_of_state(&self, q: &[T], p: &[T], put: &mut dyn FnMut(T)) {
        let point = Point::new(q, p, &[]);
        for part in &self.shape.kinks[1] {
            part.program.run(self.frame(part), &point, |_, x| put(x));
        }
    }

    fn step_between_breaks(&self, q: &[T], h: T) -> T {
        match (&self.shape.breaks, q.last()) {
            (Some(breaks), Some(&t)) => breaks.step(&self.frames, t, h),
            _ => h,
        }
    }

    #[inline(always)]
    fn has_breaks(&self) -> bool {
        self.shape.breaks.as_ref().is_some_and(|breaks| !breaks.is_empty())
    }

    #[inline(always)]
    fn may_be_singular(&self) -> bool {
        self.shape.may_be_singular
    }

    #[cold]
    fn is_singular_between(&self, from: &[T], to: &[T]) -> bool {
        let on_line = |i: usize, share, lane| {
            let [from, to] = [from, to].map(|q| enclosed(q[i], lane));
            between(from, to, share)
        };
        if self.is_dissipation_singular(on_line) {
            return true;
        }
        let Potential::Programs { value, .. } = &self.shape.potential else { return false };
        let frame = self.frame(value);
        (0..T::LANES).any(|lane| {
            value.program.is_singular([0.0, 1.0], &|k| enclosed(frame[k], lane), &|input, share| {
                match input {
                    Input::Coordinate(i) => on_line(i as usize, share, lane),
                    _ => Interval::WHOLE,
                }
            })
        })
    }
}

impl<T: Scalar> Separable<T> for Custom<T> {
    #[inline]
    fn mass(&self, j: usize) -> T {
        self.masses[j]
    }

    #[inline(always)]
    fn partial(&self, q: &[T], j: usize, at: T) -> T {
        match &self.shape.potential {
            Potential::Ridges { along, .. } => along.slope(&self.frames, q, j, at),
            Potential::Programs { partials, .. } => {
                let [slope] = self.run(&partials[j], q, &[], at);
                slope
            }
        }
    }

    #[inline(always)]
    fn divided_difference(&self, q: &[T], j: usize, to: T) -> Line<T> {
        match &self.shape.potential {
            Potential::Ridges { along, .. } => along.mean(&self.frames, q, j, to),
            Potential::Programs { edges, .. } => match &edges[j] {
                DividedDifference::Polynomial(polynomial) => {
                    polynomial.mean(&self.frames, q, j, to)
                }
                DividedDifference::Program(part) => {
                    let [value, slope] = self.run(part, q, &[], to);
                    Line { value, slope }
                }
            },
        }
    }

    #[inline(always)]
    fn has_exact_divided_differences(&self) -> bool {
        true
    }

    #[inline(always)]
    fn is_singular_along(&self, q: &[T], j: usize, to: T) -> bool {
        if !self.shape.may_be_singular {
            return false;
        }
        let of_potential = match &self.shape.potential {
            Potential::Programs { singular, .. } => {
                singular[j].as_ref().is_some_and(|part| self.is_singular(part, q, j, to))
            }
            Potential::Ridges { .. } => false,
        };
        of_potential
            || self.is_dissipation_singular(|i, share, lane| {
                let from = enclosed(q[i], lane);
                if i == j { between(from, enclosed(to, lane), share) } else { from }
            })
    }

    #[inline(always)]
    fn dissipation_of(&self, q: &[T], p: &[T], j: usize) -> Dissipation<T> {
        let [value, by_q, by_p] = match &self.shape.dissipation_kernel {
            DissipationKernel::Constant(_) => match self.rates.get(j) {
                Some(&[rate, _]) => [rate * p[j], T::zero(), rate],
                None => [T::zero(); 3],
            },
            DissipationKernel::Linear(rates) => {
                let Line { value: rate, slope } = rates.value(&self.frames, q, j);
                [rate * p[j], slope * p[j], rate]
            }
            DissipationKernel::General { local_dissipations, .. } => {
                self.run(&local_dissipations[j], q, p, T::zero())
            }
        };
        Dissipation { value, by_q, by_p }
    }
}

impl<T: Scalar> Curvature<T> for Custom<T> {
    #[inline]
    fn curvature(&self, q: &[T], p: &[T], mut put: impl FnMut(Block, usize, usize, T)) {
        self.inverse_masses.iter().enumerate().for_each(|(j, &m)| put(Block::Hpp, j, j, m));
        let point = Point::new(q, p, &[]);
        for part in &self.shape.curvature {
            part.program.run(self.frame(part), &point, |index, x| {
                let (block, i, j) = self.shape.entries[index as usize];
                put(block, i, j, x);
            });
        }
    }

    fn is_linear(&self) -> bool {
        self.shape.structure.linear
    }
}
