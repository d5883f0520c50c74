//! All tests of the methods, in one program: each method is compiled for each system once.

#![cfg(test)]

mod adaptive;
mod adaptive_accuracy;
mod adaptive_samples;
mod bind;
mod books;
mod chain_memory;
mod collocation;
mod collocation_estimate;
mod collocation_memory;
mod collocation_orders;
mod compensated;
mod cost_flags;
mod coupled_friction;
mod custom;
mod exact_edges;
mod failures;
mod fresh;
mod gonzalez;
mod gonzalez_memory;
mod gonzalez_references;
mod increment;
mod increment_general;
mod increment_local_orders;
mod increment_nets;
mod k_is_kept;
mod k_is_lost;
mod k_on_expressions;
mod linear_exact;
mod linear_scenes;
mod locally_exact;
mod many;
mod masses;
mod one_kernel;
mod order_table;
mod orders;
mod planes;
mod relaxed;
mod rest;
mod rubbed;
mod skew_friction;
mod slope;
mod stability_flags;
mod systems;
mod tiled;
