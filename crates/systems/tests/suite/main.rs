//! All tests of the systems in one program.

#![cfg(test)]

mod batches;
mod check;
mod check_hard;
mod clock;
mod custom_built_in;
mod custom_expressions;
mod custom_general;
mod custom_kinks;
mod custom_members;
mod custom_memory;
mod custom_parse;
mod custom_slopes;
mod custom_structure;
mod derivatives;
mod drive;
mod exact_flow;
mod many_degrees;
mod many_degrees_references;
mod order_raising;
mod phase_plane;
