//! The components of a state that are compared. Periodic coordinates become points of a circle.

use crate::study::side::Side;
use afterbay_core::StateRef;

/// The map from a state to the components compared, z = (x, p, w). For most coordinates x holds
/// q_j. For a coordinate of period P it holds the point (P/2π) (cos 2πq_j/P, sin 2πq_j/P), which
/// has the scale of q_j and does not depend on the number of turns.
#[derive(Clone, Debug)]
pub(super) struct Image<T> {
    /// 2π/P of each coordinate.
    turns: Vec<Option<T>>,
}

impl Image<f64> {
    pub(super) fn new(periods: &[Option<f64>]) -> Self {
        Self {
            turns: periods.iter().map(|period| period.map(|p| std::f64::consts::TAU / p)).collect(),
        }
    }

    /// Images side by side; `None` if they differ in which coordinates are periodic.
    pub(super) fn beside<T: Side>(images: impl Fn(usize) -> Self) -> Option<Image<T>> {
        let all: Vec<Self> = (0..T::LANES).map(images).collect();
        let turn = |j: usize| {
            let each: Vec<Option<f64>> = all.iter().map(|image| image.turns[j]).collect();
            match each.iter().copied().collect::<Option<Vec<f64>>>() {
                Some(turns) => Some(Some(T::gather(|k| turns[k]))),
                None => each.iter().all(Option::is_none).then_some(None),
            }
        };
        let turns = (0..all[0].turns.len()).map(turn).collect::<Option<Vec<_>>>()?;
        Some(Image { turns })
    }

    /// The kind of each component of z (0, 1, 2 for x, p, w) and the coordinate it belongs to.
    pub(super) fn kinds(&self) -> Vec<(usize, usize)> {
        let places = self.turns.iter().enumerate().flat_map(|(j, turn)| {
            let numbers = if turn.is_some() { 2 } else { 1 };
            std::iter::repeat_n((0, j), numbers)
        });
        let rest =
            [1, 2].into_iter().flat_map(|kind| (0..self.turns.len()).map(move |j| (kind, j)));
        places.chain(rest).collect()
    }
}

impl<T: Side> Image<T> {
    /// The number of components of x.
    pub(super) fn places(&self) -> usize {
        self.turns.len() + self.turns.iter().flatten().count()
    }

    /// The number of components of z.
    pub(super) fn size(&self) -> usize {
        self.places() + 2 * self.turns.len()
    }

    /// Writes x.
    #[inline]
    pub(super) fn place(&self, q: &[T], x: &mut [T]) {
        let mut at = 0;
        for (&q, turn) in q.iter().zip(&self.turns) {
            match *turn {
                None => {
                    x[at] = q;
                    at += 1;
                }
                Some(turn) => {
                    let (sin, cos) = (turn * q).sin_cos();
                    (x[at], x[at + 1]) = (cos / turn, sin / turn);
                    at += 2;
                }
            }
        }
    }

    /// Writes z.
    #[inline]
    pub(super) fn of(&self, state: StateRef<'_, T>, z: &mut [T]) {
        let (x, rest) = z.split_at_mut(self.places());
        let (p, w) = rest.split_at_mut(self.turns.len());
        self.place(state.q, x);
        p.copy_from_slice(state.p);
        w.copy_from_slice(state.w);
    }
}
