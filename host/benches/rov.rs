//! Criterion benches of ROVs: `cargo bench -p host --bench rov`; `-- allocation` after it runs a part.

#[path = "rov/allocation.rs"]
mod allocation;
#[path = "rov/plan.rs"]
mod plan;
#[path = "rov/second.rs"]
mod second;

use criterion::{criterion_group, criterion_main};

criterion_group!(benches, allocation::allocation, plan::plan, second::second);
criterion_main!(benches);
