//! A pendulum, a Morse bond and the Hénon-Heiles system written in Rust, each with its edges in
//! closed form, for comparison with custom systems of the same expressions.

use afterbay_core::{Dissipation, DissipationForm, Line, Separable, System};

/// V = g (1 - cos q), D = c p
pub struct Pendulum {
    /// g
    pub g: f64,
    /// c
    pub c: f64,
}

/// V = d (1 - e^(-a (q - r)))², D = c p
pub struct Morse {
    /// d
    pub d: f64,
    /// a
    pub a: f64,
    /// r
    pub r: f64,
    /// c
    pub c: f64,
}

/// V = (q1² + q2²)/2 + q1² q2 - q2³/3, D_j = c p_j
pub struct HenonHeiles {
    /// c
    pub c: f64,
}

/// The common part of the three: unit masses, and friction proportional to the momentum.
macro_rules! rubbed {
    ($name:ident, $dof:literal, $potential:expr) => {
        impl System<f64> for $name {
            #[inline]
            fn dof(&self) -> usize {
                $dof
            }
            #[inline]
            fn energy(&self, q: &[f64], p: &[f64]) -> f64 {
                let potential: fn(&Self, &[f64]) -> f64 = $potential;
                p.iter().map(|p| p * p).sum::<f64>() / 2.0 + potential(self, q)
            }
            #[inline]
            fn gradient(&self, q: &[f64], p: &[f64], hq: &mut [f64], hp: &mut [f64]) {
                for (j, hq) in hq.iter_mut().enumerate() {
                    *hq = self.partial(q, j, q[j]);
                }
                hp.copy_from_slice(p);
            }
            #[inline]
            fn dissipation(&self, _q: &[f64], _p: &[f64], v: &[f64], d: &mut [f64]) {
                d.iter_mut().zip(v).for_each(|(d, v)| *d = self.c * v);
            }
            #[inline]
            fn dissipation_form(&self) -> DissipationForm {
                DissipationForm::LINEAR
            }
            #[inline]
            fn unit_mass(&self) -> bool {
                true
            }
        }
    };
}

rubbed!(Pendulum, 1, |s, q| s.g * (1.0 - q[0].cos()));
rubbed!(Morse, 1, |s, q| s.d * (1.0 - (-s.a * (q[0] - s.r)).exp()).powi(2));
rubbed!(HenonHeiles, 2, |_, q| {
    (q[0] * q[0] + q[1] * q[1]) / 2.0 + q[0] * q[0] * q[1] - q[1].powi(3) / 3.0
});

impl Separable<f64> for Pendulum {
    #[inline]
    fn partial(&self, _q: &[f64], _j: usize, at: f64) -> f64 {
        self.g * at.sin()
    }
    #[inline]
    fn divided_difference(&self, q: &[f64], _j: usize, to: f64) -> Line<f64> {
        let (middle, half) = ((q[0] + to) / 2.0, (to - q[0]) / 2.0);
        let ((sin, cos), (sin_half, cos_half)) = (middle.sin_cos(), half.sin_cos());
        let (sinc, bend) = if half.abs() < 1e-3 {
            (1.0 - half * half / 6.0, -half / 3.0)
        } else {
            let sinc = sin_half / half;
            (sinc, (cos_half - sinc) / half)
        };
        Line { value: self.g * sin * sinc, slope: self.g * (cos * sinc + sin * bend) / 2.0 }
    }
    #[inline]
    fn has_exact_divided_differences(&self) -> bool {
        true
    }
    #[inline]
    fn dissipation_of(&self, _q: &[f64], p: &[f64], _j: usize) -> Dissipation<f64> {
        Dissipation { value: self.c * p[0], by_q: 0.0, by_p: self.c }
    }
}

impl Separable<f64> for Morse {
    #[inline]
    fn partial(&self, _q: &[f64], _j: usize, at: f64) -> f64 {
        let e = (-self.a * (at - self.r)).exp();
        2.0 * self.d * self.a * e * (1.0 - e)
    }
    #[inline]
    fn divided_difference(&self, q: &[f64], _j: usize, to: f64) -> Line<f64> {
        let (start, width) = ((-self.a * (q[0] - self.r)).exp(), to - q[0]);
        let x = -self.a * width;
        let shrinks = x.exp_m1();
        let end = start + start * shrinks;
        // The divided difference of e^(-a q) and its derivative with respect to the end point.
        let (quotient, bend) = if x.abs() < 1e-5 {
            (1.0 + x / 2.0, 0.5 + x / 3.0)
        } else {
            (shrinks / x, (1.0 + shrinks - shrinks / x) / x)
        };
        let slope = -self.a * start * quotient;
        let sum = 2.0 - start - end;
        Line {
            value: -self.d * slope * sum,
            slope: self.d * (slope * -self.a * end - self.a * self.a * start * bend * sum),
        }
    }
    #[inline]
    fn has_exact_divided_differences(&self) -> bool {
        true
    }
    #[inline]
    fn dissipation_of(&self, _q: &[f64], p: &[f64], _j: usize) -> Dissipation<f64> {
        Dissipation { value: self.c * p[0], by_q: 0.0, by_p: self.c }
    }
}

impl Separable<f64> for HenonHeiles {
    #[inline]
    fn partial(&self, q: &[f64], j: usize, at: f64) -> f64 {
        if j == 0 { at + 2.0 * at * q[1] } else { at + q[0] * q[0] - at * at }
    }
    #[inline]
    fn divided_difference(&self, q: &[f64], j: usize, to: f64) -> Line<f64> {
        let from = q[j];
        if j == 0 {
            let stiffness = 0.5 + q[1];
            Line { value: (from + to) * stiffness, slope: stiffness }
        } else {
            let cubes = from * from + (from + to) * to;
            let value = (from + to) / 2.0 + q[0] * q[0] - cubes / 3.0;
            Line { value, slope: 0.5 - (from + 2.0 * to) / 3.0 }
        }
    }
    #[inline]
    fn has_exact_divided_differences(&self) -> bool {
        true
    }
    #[inline]
    fn dissipation_of(&self, _q: &[f64], p: &[f64], j: usize) -> Dissipation<f64> {
        Dissipation { value: self.c * p[j], by_q: 0.0, by_p: self.c }
    }
}
