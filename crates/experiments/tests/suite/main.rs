//! All tests of scenes and reports in one program.

#![cfg(test)]

mod basins;
mod clocked;
mod driven;
mod events;
mod figures;
mod limit_cycle;
mod lyapunov;
mod lyapunov_of_stiff_motions;
mod many_degrees;
mod overdamped;
mod paper;
mod resonance;
mod scenes;
mod sections;
mod sentences;
mod settling;
mod sizes;
mod studies;
mod sweeps;
