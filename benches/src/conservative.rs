//! A system without dissipation at the type level, so that the compiler can evaluate
//! `dissipation_form()`.

use afterbay_core::{Dissipation, DissipationForm, Line, Separable, System};
use afterbay_systems::Duffing;

/// The Duffing oscillator without its damping.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Conservative(pub(crate) Duffing<f64>);

impl System<f64> for Conservative {
    #[inline(always)]
    fn dof(&self) -> usize {
        1
    }
    #[inline(always)]
    fn energy(&self, q: &[f64], p: &[f64]) -> f64 {
        self.0.energy(q, p)
    }
    #[inline(always)]
    fn gradient(&self, q: &[f64], p: &[f64], hq: &mut [f64], hp: &mut [f64]) {
        self.0.gradient(q, p, hq, hp);
    }
    #[inline(always)]
    fn dissipation(&self, _q: &[f64], _p: &[f64], _v: &[f64], d: &mut [f64]) {
        d[0] = 0.0;
    }
    #[inline(always)]
    fn dissipation_form(&self) -> DissipationForm {
        DissipationForm::NONE
    }
}

impl Separable<f64> for Conservative {
    #[inline(always)]
    fn partial(&self, q: &[f64], j: usize, at: f64) -> f64 {
        self.0.partial(q, j, at)
    }
    #[inline(always)]
    fn divided_difference(&self, q: &[f64], j: usize, to: f64) -> Line<f64> {
        self.0.divided_difference(q, j, to)
    }
    #[inline(always)]
    fn has_exact_divided_differences(&self) -> bool {
        true
    }
    #[inline(always)]
    fn dissipation_of(&self, _q: &[f64], _p: &[f64], _j: usize) -> Dissipation<f64> {
        Dissipation { value: 0.0, by_q: 0.0, by_p: 0.0 }
    }
}
