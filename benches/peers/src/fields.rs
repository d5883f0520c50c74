//! The equations of motion in the form that other libraries require, y' = f(y) for y = (q, p, w),
//! written by hand for each scene.

/// A right-hand side with its derivative. Entries of y: q, then p, then w.
pub trait Field: Copy + 'static {
    /// f(y)
    fn rates(&self, y: &[f64], dy: &mut [f64]);
    /// J(y) v
    fn derivative(&self, y: &[f64], v: &[f64], jv: &mut [f64]);
}

/// A: k = 1, b = 0.1.
#[derive(Clone, Copy, Debug)]
pub struct Oscillator;

impl Field for Oscillator {
    #[inline(always)]
    fn rates(&self, y: &[f64], dy: &mut [f64]) {
        let (q, p) = (y[0], y[1]);
        let drag = 0.1 * p;
        (dy[0], dy[1], dy[2]) = (p, -q - drag, drag * p);
    }

    #[inline(always)]
    fn derivative(&self, y: &[f64], v: &[f64], jv: &mut [f64]) {
        (jv[0], jv[1], jv[2]) = (v[1], -v[0] - 0.1 * v[1], 0.2 * y[1] * v[1]);
    }
}

/// B: V = -q²/2 + q⁴/4, D = 0.1 p.
#[derive(Clone, Copy, Debug)]
pub struct Duffing;

impl Field for Duffing {
    #[inline(always)]
    fn rates(&self, y: &[f64], dy: &mut [f64]) {
        let (q, p) = (y[0], y[1]);
        let drag = 0.1 * p;
        (dy[0], dy[1], dy[2]) = (p, q * (1.0 - q * q) - drag, drag * p);
    }

    #[inline(always)]
    fn derivative(&self, y: &[f64], v: &[f64], jv: &mut [f64]) {
        let q = y[0];
        (jv[0], jv[1], jv[2]) = (v[1], (1.0 - 3.0 * q * q) * v[0] - 0.1 * v[1], 0.2 * y[1] * v[1]);
    }
}

/// C: V = q²/2, D = -μ (1 - q²) p.
#[derive(Clone, Copy, Debug)]
pub struct VanDerPol {
    /// μ
    pub mu: f64,
}

impl Field for VanDerPol {
    #[inline(always)]
    fn rates(&self, y: &[f64], dy: &mut [f64]) {
        let (q, p) = (y[0], y[1]);
        let drag = self.mu * (q * q - 1.0) * p;
        (dy[0], dy[1], dy[2]) = (p, -q - drag, drag * p);
    }

    #[inline(always)]
    fn derivative(&self, y: &[f64], v: &[f64], jv: &mut [f64]) {
        let (q, p) = (y[0], y[1]);
        let by_p = self.mu * (q * q - 1.0);
        let drag = 2.0 * self.mu * q * p * v[0] + by_p * v[1];
        (jv[0], jv[1], jv[2]) = (v[1], -v[0] - drag, drag * p + by_p * p * v[1]);
    }
}

/// D: β = 1, c = 0.01, any number of members, in loops that vectorise.
#[derive(Clone, Copy, Debug)]
pub struct Chain;

const DRAG: f64 = 0.01;

impl Field for Chain {
    #[inline]
    fn rates(&self, y: &[f64], dy: &mut [f64]) {
        let n = y.len() / 3;
        let (q, p) = (&y[..n], &y[n..2 * n]);
        let (dq, rest) = dy.split_at_mut(n);
        let (dp, dw) = rest.split_at_mut(n);
        let tension = |r: f64| r * (1.0 + r * r);
        let force = |left: f64, at: f64, right: f64| tension(right - at) - tension(at - left);
        dq.copy_from_slice(p);
        for ((dp, &p), &[left, at, right]) in dp[1..].iter_mut().zip(&p[1..]).zip(q.array_windows())
        {
            *dp = force(left, at, right) - DRAG * p;
        }
        dp[0] = force(0.0, q[0], q[1]) - DRAG * p[0];
        dp[n - 1] = force(q[n - 2], q[n - 1], 0.0) - DRAG * p[n - 1];
        dw.iter_mut().zip(p).for_each(|(dw, p)| *dw = DRAG * p * p);
    }

    #[inline]
    fn derivative(&self, y: &[f64], v: &[f64], jv: &mut [f64]) {
        let n = y.len() / 3;
        let stiffness = |r: f64, s: f64| (1.0 + 3.0 * r * r) * s;
        let at = |x: &[f64], j: usize| if (1..=n).contains(&j) { x[j - 1] } else { 0.0 };
        for j in 1..=n {
            let bond = |i: usize| stiffness(at(y, i + 1) - at(y, i), at(v, i + 1) - at(v, i));
            jv[j - 1] = v[n + j - 1];
            jv[n + j - 1] = bond(j) - bond(j - 1) - DRAG * v[n + j - 1];
            jv[2 * n + j - 1] = 2.0 * DRAG * y[n + j - 1] * v[n + j - 1];
        }
    }
}

/// E: unit masses, rods and gravity, c = 0.1, in canonical momenta.
#[derive(Clone, Copy, Debug)]
pub struct Pendulum;

impl Field for Pendulum {
    #[inline(always)]
    fn rates(&self, y: &[f64], dy: &mut [f64]) {
        let [a, b, p, r] = [y[0], y[1], y[2], y[3]];
        let (sin, cos) = (a - b).sin_cos();
        let inverse = 1.0 / (1.0 + sin * sin);
        let (u, v) = ((p - cos * r) * inverse, (2.0 * r - cos * p) * inverse);
        let whirl = sin * u * v;
        let drag = [0.1 * u, 0.1 * v];
        (dy[0], dy[1]) = (u, v);
        (dy[2], dy[3]) = (-whirl - 2.0 * a.sin() - drag[0], whirl - b.sin() - drag[1]);
        (dy[4], dy[5]) = (drag[0] * u, drag[1] * v);
    }

    #[inline(always)]
    fn derivative(&self, y: &[f64], t: &[f64], jv: &mut [f64]) {
        let [a, b, p, r] = [y[0], y[1], y[2], y[3]];
        let (sin, cos) = (a - b).sin_cos();
        let inverse = 1.0 / (1.0 + sin * sin);
        let (u, v) = ((p - cos * r) * inverse, (2.0 * r - cos * p) * inverse);
        let turn = t[0] - t[1];
        let (dsin, dcos) = (cos * turn, -sin * turn);
        // d(1/(1 + sin²)) / (1/(1 + sin²))
        let shrink = -2.0 * sin * dsin * inverse;
        let du = (t[2] - cos * t[3] - dcos * r) * inverse + u * shrink;
        let dv = (2.0 * t[3] - cos * t[2] - dcos * p) * inverse + v * shrink;
        let whirl = dsin * u * v + sin * (du * v + u * dv);
        (jv[0], jv[1]) = (du, dv);
        (jv[2], jv[3]) =
            (-whirl - 2.0 * a.cos() * t[0] - 0.1 * du, whirl - b.cos() * t[1] - 0.1 * dv);
        (jv[4], jv[5]) = (0.2 * u * du, 0.2 * v * dv);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenes;
    use std::f64::consts::PI;

    /// Irregular numbers in (-1, 1), at which fields are compared.
    fn scattered(n: usize, seed: f64) -> Vec<f64> {
        (1..=n).map(|j| (PI * seed * (j * j) as f64).sin()).collect()
    }

    /// Checks that the field of a scene agrees with its system, and its derivative with the field.
    fn check<F: Field>(name: &str, field: F) {
        let scene = scenes::all().into_iter().find(|scene| scene.name == name).unwrap();
        let n = scene.dof();
        let subject = scene.problem.model.system::<f64>().unwrap();
        let (y, v) = (scattered(3 * n, 0.31), scattered(3 * n, 0.47));
        let (mut hq, mut hp, mut d, mut dy) =
            (vec![0.0; n], vec![0.0; n], vec![0.0; n], vec![0.0; 3 * n]);
        subject.gradient(&y[..n], &y[n..2 * n], &mut hq, &mut hp);
        subject.dissipation(&y[..n], &y[n..2 * n], &hp, &mut d);
        field.rates(&y, &mut dy);
        for j in 0..n {
            let size = hq[j].abs() + d[j].abs() * (1.0 + hp[j].abs()) + 1.0;
            let off = (dy[j] - hp[j])
                .abs()
                .max((dy[n + j] + hq[j] + d[j]).abs())
                .max((dy[2 * n + j] - d[j] * hp[j]).abs());
            assert!(off < 1e-14 * size, "{name}, degree of freedom {j}: {off:e}");
        }
        let at = |step: f64| {
            let moved: Vec<_> = y.iter().zip(&v).map(|(y, v)| y + step * v).collect();
            let mut rates = vec![0.0; 3 * n];
            field.rates(&moved, &mut rates);
            rates
        };
        let mut jv = vec![0.0; 3 * n];
        field.derivative(&y, &v, &mut jv);
        let step = 1e-5;
        for (j, ((ahead, back), jv)) in at(step).iter().zip(at(-step)).zip(jv).enumerate() {
            let slope = (ahead - back) / (2.0 * step);
            assert!(
                (slope - jv).abs() < 1e-7 * (1.0 + jv.abs()),
                "{name}, row {j}: {slope:e} and {jv:e}"
            );
        }
    }

    #[test]
    fn fields_are_those_of_the_systems() {
        check("A", Oscillator);
        check("B", Duffing);
        check("C1", VanDerPol { mu: 1.0 });
        check("C2", VanDerPol { mu: 1000.0 });
        check("D64", Chain);
        check("D1024", Chain);
        check("E", Pendulum);
    }
}
