//! Criterion benches of ROVs: `cargo bench -p rov --bench rov`; `-- allocation` after it runs a part.

#[path = "rov/allocation.rs"]
mod allocation;
#[path = "rov/order.rs"]
mod order;
#[path = "rov/second.rs"]
mod second;

use criterion::{criterion_group, criterion_main};

criterion_group!(benches, allocation::allocation, order::order, second::second);
criterion_main!(benches);
