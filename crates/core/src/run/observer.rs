//! Observers of a run.

use crate::numbers::Vector;
use crate::system::State;
use std::ops::ControlFlow;

/// An observer receives the states of a run at the steps it asks for, the initial state (step 0)
/// included, and may end the run. A closure `FnMut(u64, &State<V>) -> ControlFlow<()>` is an
/// observer of every step, and `()` observes nothing.
///
/// It should end a run by `Break` and not by a panic: after a panic that is caught, the state of
/// the run has no meaning and may be empty, because the time loop moves it out while it steps.
pub trait Observer<V: Vector> {
    /// Receives the state after `step` steps. `Break` ends the run there.
    fn observe(&mut self, step: u64, state: &State<V>) -> ControlFlow<()>;

    /// The next step to observe after `step`; by default each. The run may pass states in between
    /// as well.
    #[inline(always)]
    fn next(&self, step: u64) -> u64 {
        step + 1
    }

    /// Whether the run ends between two observed states, which may be far apart. A run at given
    /// times asks before each of its steps.
    #[inline(always)]
    fn stops(&mut self) -> bool {
        false
    }
}

impl<V: Vector> Observer<V> for () {
    #[inline(always)]
    fn observe(&mut self, _step: u64, _state: &State<V>) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    #[inline(always)]
    fn next(&self, _step: u64) -> u64 {
        u64::MAX
    }
}

impl<V: Vector, F: FnMut(u64, &State<V>) -> ControlFlow<()>> Observer<V> for F {
    #[inline(always)]
    fn observe(&mut self, step: u64, state: &State<V>) -> ControlFlow<()> {
        self(step, state)
    }
}

/// An observer that passes on every `stride`-th step, by default from the initial state on. It
/// begins anew with each run.
#[derive(Clone, Debug)]
pub struct Every<O> {
    first: u64,
    stride: u64,
    next: u64,
    inner: O,
}

impl<O> Every<O> {
    /// Every `stride`-th step (0 counts as 1) goes to `inner`.
    pub fn new(stride: u64, inner: O) -> Self {
        Self::starting(0, stride, inner)
    }

    /// Step `first` and every `stride`-th step after it go to `inner`.
    pub fn starting(first: u64, stride: u64, inner: O) -> Self {
        Self { first, stride: stride.max(1), next: first, inner }
    }
}

impl<V: Vector, O: Observer<V>> Observer<V> for Every<O> {
    #[inline(always)]
    fn observe(&mut self, step: u64, state: &State<V>) -> ControlFlow<()> {
        if step == 0 {
            self.next = self.first;
        }
        if step != self.next {
            return ControlFlow::Continue(());
        }
        self.next = self.next.saturating_add(self.stride);
        if V::LEN.is_some() {
            // The observer gets a copy, so that the state of the loop can stay in registers.
            return self.inner.observe(step, &state.clone());
        }
        self.inner.observe(step, state)
    }

    #[inline(always)]
    fn next(&self, _step: u64) -> u64 {
        self.next
    }
}
