//! Runs: methods, grids of times and tolerances, the time loops, and observers.

mod adaptive;
mod adaptive_run;
mod breaks;
mod controller;
mod event;
mod grid;
mod integrate;
mod method;
mod observer;
mod reservoir;
mod tolerance;
mod undefined;

pub use adaptive::{integrate_controlled, integrate_within, sample_within};
pub use adaptive_run::{AdaptiveRun, Statistics};
pub use breaks::step_in_parts;
pub use controller::StepControl;
pub use event::{Direction, Event, EventState, OnEvent, TakeStep, Watch, integrate_with_events};
pub use grid::Grid;
pub use integrate::{integrate, integrate_in};
pub use method::{Adaptive, Attempt, Effort, Method};
pub use observer::{Every, Observer};
pub use reservoir::STEPS_OF_BLOCK;
pub use tolerance::Tolerance;
