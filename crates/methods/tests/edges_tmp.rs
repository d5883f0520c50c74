#[path = "suite/exact_edges.rs"]
mod exact_edges;
