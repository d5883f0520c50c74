//! The red-black step of the damped β-chain written by hand: eight members at a time, stored by
//! colour.

use std::f64::consts::PI;
use std::hint::cold_path;
use wide::f64x8;

/// q, p and w of the members 1, 3, .. and 2, 4, .. of a chain with walls on both sides.
#[derive(Clone, Debug)]
pub struct Colours {
    beta: f64x8,
    c: f64x8,
    /// Eight members per vector; an odd number of rows, so that the walls need no special
    /// treatment.
    q: [Vec<f64x8>; 2],
    p: [Vec<f64x8>; 2],
    w: [Vec<f64x8>; 2],
}

/// The unit roundoff, with which corrections are compared.
const ROUNDING: f64 = f64::EPSILON / 2.0;

impl Colours {
    /// Creates a chain of `n` members, a multiple of 16, in the first mode. Lane k holds the k-th
    /// eighth of the chain, so that neighbours share a lane except at the ends of the eighths.
    pub fn new(n: usize, beta: f64, c: f64) -> Self {
        let rows = n / 16;
        let site = |colour: usize, row: usize| {
            f64x8::new(std::array::from_fn(|lane| {
                let j = 2 * (lane * rows + row) + colour + 1;
                (PI * j as f64 / (n + 1) as f64).sin()
            }))
        };
        let q = [0, 1].map(|colour| (0..rows).map(|row| site(colour, row)).collect());
        let zeros = || [0, 1].map(|_| vec![f64x8::ZERO; rows]);
        Self { beta: beta.into(), c: c.into(), q, p: zeros(), w: zeros() }
    }

    /// K = H + Σ w.
    pub fn total(&self) -> f64 {
        let q =
            |j: usize| self.q[j % 2][j / 2 % self.q[0].len()].to_array()[j / 2 / self.q[0].len()];
        let n = 16 * self.q[0].len();
        let at = |j: usize| if j == 0 || j == n + 1 { 0.0 } else { q(j - 1) };
        let bonds = (0..=n)
            .map(|j| (at(j + 1) - at(j)).powi(2))
            .map(|r| r / 2.0 + self.beta.to_array()[0] * r * r / 4.0);
        let kinetic = self.p.iter().flatten().map(|p| (*p * *p).reduce_add() / 2.0);
        let spent = self.w.iter().flatten().map(|w| w.reduce_add());
        bonds.chain(kinetic).chain(spent).sum()
    }

    /// Takes one step: half of it forward, half of it backward.
    pub fn step(&mut self, h: f64) {
        for colour in [0, 1, 1, 0] {
            self.sweep(colour, f64x8::splat(h / 2.0));
        }
    }

    fn sweep(&mut self, colour: usize, h: f64x8) {
        let last = self.q[0].len() - 1;
        let [red, black] = &mut self.q;
        let (q, beside) = if colour == 0 { (red, &*black) } else { (black, &*red) };
        let (p, w) = (&mut self.p[colour], &mut self.w[colour]);
        let (beta, c) = (self.beta, self.c);
        // The neighbour beyond the end of an eighth is in the next lane, and beyond the last eighth
        // is a wall.
        let lanes = beside[if colour == 0 { last } else { 0 }].to_array();
        let turned = f64x8::new(std::array::from_fn(|lane| match (colour, lane) {
            (0, 0) | (1, 7) => 0.0,
            (0, lane) => lanes[lane - 1],
            (_, lane) => lanes[lane + 1],
        }));
        let mut move_row = |row: usize, left: f64x8, right: f64x8| {
            let (q, p, w) = (&mut q[row], &mut p[row], &mut w[row]);
            (*q, *p, *w) = member(h, beta, c, [left, *q, right], *p, *w);
        };
        if colour == 0 {
            move_row(0, turned, beside[0]);
            for row in 1..=last {
                move_row(row, beside[row - 1], beside[row]);
            }
        } else {
            for row in 0..last {
                move_row(row, beside[row], beside[row + 1]);
            }
            move_row(last, beside[last], turned);
        }
    }
}

/// Updates eight members between their neighbours: Newton's iteration for the mean momentum v.
#[inline(always)]
fn member(
    h: f64x8,
    beta: f64x8,
    c: f64x8,
    [left, q, right]: [f64x8; 3],
    p: f64x8,
    w: f64x8,
) -> (f64x8, f64x8, f64x8) {
    let (one, half, quarter) = (f64x8::ONE, f64x8::splat(0.5), f64x8::splat(0.25));
    let (r, s) = (q - left, q - right);
    let (r2, s2) = (r * r, s * s);
    let (quarter_beta, half_beta, pull) = (beta * quarter, beta * half, h * half);
    // The left side of v + pull (mean force + c v) = p, and its derivative.
    let equation = |v: f64x8| {
        let to = h.mul_add(v, q);
        let (r1, s1) = (to - left, to - right);
        let (a, b) = (r + r1, s + s1);
        let (ka, kb) = (
            quarter_beta.mul_add(r1.mul_add(r1, r2), half),
            quarter_beta.mul_add(s1.mul_add(s1, s2), half),
        );
        let force = a.mul_add(ka, b * kb);
        let stiffness = (half_beta * r1).mul_add(a, ka) + (half_beta * s1).mul_add(b, kb);
        let residual = p - pull.mul_add(c.mul_add(v, force), v);
        (residual, pull.mul_add(h.mul_add(stiffness, c), one), pull * stiffness)
    };
    let (residual, slope, _) = equation(p);
    let missing = one - slope;
    let mut inverse = one + missing;
    let mut before = residual * inverse;
    let (mut rest, mut v) = (missing * missing, p + before);
    loop {
        let (residual, slope, stiff) = equation(v);
        let missing = slope.mul_neg_add(inverse, one);
        inverse = inverse.mul_add(missing, inverse);
        let update = residual * inverse;
        v += update;
        let (size, largest) = (update.abs(), before.abs());
        let off = ((rest + missing) * half).mul_neg_add(before, update).abs();
        let contraction = missing.abs().mul_add(largest, size);
        let next = contraction.mul_add(contraction, off * largest) * size;
        // The correction is usually below the rounding of v alone.
        if next.simd_lt(f64x8::splat(ROUNDING) * v.abs() * largest * largest).all() {
            break;
        }
        cold_path();
        let scale = v.abs() + inverse.abs() * (p.abs() + (stiff * q).abs());
        let lost = next.simd_lt(f64x8::splat(ROUNDING) * scale * largest * largest);
        let noise = size.simd_le(scale * f64x8::splat(1e-8)) & largest.simd_le(size + size);
        if (lost | noise).all() {
            break;
        }
        (before, rest) = (update, missing * missing);
    }
    (h.mul_add(v, q), v + v - p, (h * c * v).mul_add(v, w))
}
