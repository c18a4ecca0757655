//! Criterion benches of Modboat planning: two tails, whole plans, transitions.
//!
//! `cargo bench -p modboat --bench modboat` first prints how plans by the table of distances compare with plans by the
//! collision regions; `-- geometry` or `-- "plan exact"` after it runs a part.

mod comparison;
mod demands;
mod geometry;
mod planning;
mod transitions;

use criterion::{criterion_group, criterion_main};

criterion_group!(
    benches,
    comparison::print,
    geometry::geometry,
    planning::plan,
    planning::transition,
    transitions::solver
);
criterion_main!(benches);
