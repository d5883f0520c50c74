//! A linear system and its forces as x' = A x, with the energies as integrals of products of
//! linear functions of x.
//!
//! ```text
//! x = (q, p, 1, cos ω_1 t, sin ω_1 t, ..)
//! w_j' = (d_j x) (v_j x)        s_j' = (f_j x) (v_j x)
//! ```
//!
//! The rows d_j, v_j and f_j are those of D_j, ∂H/∂p_j and F_j. A is built from the unrounded
//! second derivatives, so that the flow conserves exactly the H they belong to.

use crate::legendre::widen;
use afterbay_core::{Block, Curvature, Harmonics, Quad, Scalar};

/// The forces of a drive.
#[derive(Clone, Debug)]
pub(super) struct Forces<T> {
    /// The distinct frequencies of all forces.
    pub(super) frequencies: Vec<T>,
    /// The driven degrees of freedom and F_j.
    pub(super) driven: Vec<(usize, Harmonics<T>)>,
}

impl<T: Scalar> Forces<T> {
    pub(super) fn none() -> Self {
        Self { frequencies: Vec::new(), driven: Vec::new() }
    }

    pub(super) fn new(driven: Vec<(usize, Harmonics<T>)>) -> Self {
        let mut frequencies = Vec::new();
        for term in driven.iter().flat_map(|(_, force)| &force.terms) {
            if !frequencies.contains(&term.frequency) {
                frequencies.push(term.frequency);
            }
        }
        Self { frequencies, driven }
    }
}

/// The rows of x' = A x and of the energies.
#[derive(Clone, Debug)]
pub(super) struct Equations {
    /// The number of degrees of freedom.
    pub(super) n: usize,
    /// The number of entries of x. The 1 is left out where there are no constant forces.
    pub(super) size: usize,
    /// The place of cos ω_1 t in x.
    pub(super) first_wave: usize,
    /// A
    pub(super) a: Vec<Quad>,
    /// The factors of each energy: d_j and v_j, then f_j and v_j of the driven degrees of freedom.
    pub(super) factors: [Vec<Quad>; 2],
    /// |A|, minimised over the ratio of the units of q and p, or the largest frequency.
    pub(super) rate: f64,
}

impl Equations {
    pub(super) fn new<T, S>(system: &S, forces: &Forces<T>) -> Self
    where
        T: Scalar,
        S: Curvature<T> + ?Sized,
    {
        let n = system.dof();
        let constant = fields(system, &vec![T::zero(); 2 * n]);
        let pushes = forces.driven.iter().map(|(_, force)| &force.constant);
        let free = constant.iter().flatten().chain(pushes).all(|&c| c == T::zero());
        let first_wave = if free { 2 * n } else { 2 * n + 1 };
        let size = first_wave + 2 * forces.frequencies.len();
        let mut slopes = hessian_rows(system, size);
        let mut d = dissipation_rows(system, size, &constant[2]);
        if !free {
            for j in 0..n {
                let [hq, hp, drag] = [0, 1, 2].map(|part| widen(constant[part][j]));
                slopes[j * size + 2 * n] = hq;
                slopes[(n + j) * size + 2 * n] = hp;
                d[j * size + 2 * n] = drag;
            }
        }
        let mut a = vec![Quad::ZERO; size * size];
        for j in 0..n {
            for k in 0..size {
                a[j * size + k] = slopes[(n + j) * size + k];
                a[(n + j) * size + k] = -slopes[j * size + k] - d[j * size + k];
            }
        }
        let mut v = slopes.split_off(n * size);
        for (j, force) in &forces.driven {
            let row = forces.row(force, first_wave, free, size);
            a[(n + j) * size..][..size].iter_mut().zip(&row).for_each(|(a, &f)| *a += f);
            d.extend(row);
            v.extend_from_within(j * size..(j + 1) * size);
        }
        let mut rate = rate(n, size, &a);
        for (k, &frequency) in forces.frequencies.iter().enumerate() {
            let (cos, frequency) = (first_wave + 2 * k, widen(frequency));
            let sin = cos + 1;
            (a[cos * size + sin], a[sin * size + cos]) = (-frequency, frequency);
            rate = rate.max(frequency.to_f64().abs());
        }
        Self { n, size, first_wave, a, factors: [d, v], rate }
    }
}

impl<T: Scalar> Forces<T> {
    /// The row of a force.
    fn row(&self, force: &Harmonics<T>, first_wave: usize, free: bool, size: usize) -> Vec<Quad> {
        let mut row = vec![Quad::ZERO; size];
        if !free {
            row[first_wave - 1] = widen(force.constant);
        }
        for term in &force.terms {
            let place = self.frequencies.iter().position(|&other| other == term.frequency);
            if let Some(k) = place {
                row[first_wave + 2 * k] += widen(term.cosine);
                row[first_wave + 2 * k + 1] += widen(term.sine);
            }
        }
        row
    }
}

/// ∂H/∂q, ∂H/∂p and D at z.
fn fields<T, S>(system: &S, z: &[T]) -> [Vec<T>; 3]
where
    T: Scalar,
    S: Curvature<T> + ?Sized,
{
    let (q, p) = z.split_at(system.dof());
    let zeros = || vec![T::zero(); q.len()];
    let mut all = [zeros(), zeros(), zeros()];
    let [hq, hp, d] = &mut all;
    system.gradient(q, p, hq, hp);
    system.dissipation(q, p, hp, d);
    all
}

/// The rows of ∂H/∂q and ∂H/∂p without their constant parts, made exactly symmetric.
fn hessian_rows<T, S>(system: &S, size: usize) -> Vec<Quad>
where
    T: Scalar,
    S: Curvature<T> + ?Sized,
{
    let n = system.dof();
    let origin = vec![T::zero(); n];
    let mut rows = vec![Quad::ZERO; 2 * n * size];
    system.curvature(&origin, &origin, |block, i, j, value| {
        let half = widen(value).half();
        let mut put = |i: usize, j: usize, value: Quad| rows[i * size + j] += value;
        match block {
            Block::Hqq => [(i, j), (j, i)].map(|(i, j)| put(i, j, half)),
            Block::Hpp => [(n + i, n + j), (n + j, n + i)].map(|(i, j)| put(i, j, half)),
            Block::Hqp => [(i, n + j), (n + j, i)].map(|(i, j)| put(i, j, half + half)),
            Block::Dq | Block::Dp => [(); 2],
        };
    });
    rows
}

/// The rows of D without its constant part, its value at the origin.
fn dissipation_rows<T, S>(system: &S, size: usize, constant: &[T]) -> Vec<Quad>
where
    T: Scalar,
    S: Curvature<T> + ?Sized,
{
    let n = system.dof();
    let mut z = vec![T::zero(); 2 * n];
    let mut rows = vec![Quad::ZERO; n * size];
    for k in 0..2 * n {
        z[k] = T::one();
        let [_, _, d] = fields(system, &z);
        z[k] = T::zero();
        for j in 0..n {
            rows[j * size + k] = widen(d[j]) - widen(constant[j]);
        }
    }
    rows
}

/// |A|, minimised over the ratio of the units of q and p.
fn rate(n: usize, size: usize, a: &[Quad]) -> f64 {
    let square = |rows: usize, columns: usize| {
        let entry = |i: usize, j: usize| a[(rows + i) * size + columns + j].to_f64();
        (0..n)
            .flat_map(|i| (0..n).map(move |j| (i, j)))
            .map(|(i, j)| entry(i, j).powi(2))
            .sum::<f64>()
    };
    (square(0, 0) + square(n, n) + 2.0 * square(0, n).sqrt() * square(n, 0).sqrt()).sqrt()
}
