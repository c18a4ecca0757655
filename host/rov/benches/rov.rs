//! Criterion benches of ROVs: `cargo bench -p rov --bench rov`; `-- allocation` after it runs a part.

#[path = "rov/allocation.rs"]
mod allocation;
#[path = "rov/second.rs"]
mod second;

use criterion::{criterion_group, criterion_main};

criterion_group!(benches, allocation::allocation, second::second);
criterion_main!(benches);
