//! The exact planner against what it promises, with the potential field beside it on the same demands.
//!
//! `cargo test -p tests --test all planner:: -- --nocapture` prints every table; with `FLOTILLA_FULL=1` in the environment on
//! ten times as many plans and more. Demands are uniform by volume in a share of the envelope (every wrench that modules
//! pushing up to F(2.6 rad) in any direction could give), one by one or in walks whose steps have a deviation of 0.03, or
//! 0.1, of half the bounding box along each axis. The potential field is asked the same; fewer in tables (d) to (f), which
//! say so.
//!
//! Tables are made one after the other, each on two threads, so that the one of times has the machine to itself. Times are
//! printed and never asserted.

mod border;
mod errors;
mod figure;
mod leaving;
mod outcomes;
mod outside;
mod power;
mod price;
mod times;

use std::sync::{Mutex, MutexGuard, PoisonError};

use modboat::structure::Structure;
use tests::stream::Sequence;

/// Error that counts as none.
const EXACT: f64 = 1e-6;
/// Walks of a closed loop, and longer steps for comparison.
const NEAR: Sequence = Sequence::Walk(0.03);
const FAR: Sequence = Sequence::Walk(0.1);
/// Share of the envelope that promises are about.
const SHARE: f64 = 0.6;

const RING: &str = "####\n#..#\n#..#\n####\n";

/// Whether the full counts are asked for.
fn full() -> bool {
    std::env::var("FLOTILLA_FULL").is_ok_and(|value| value != "0")
}

/// One table at a time.
fn alone() -> MutexGuard<'static, ()> {
    static ALONE: Mutex<()> = Mutex::new(());
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

fn structure(name: &str) -> Structure {
    match name {
        "ring" => Structure::from_picture(RING),
        "line of 12" => Structure::from_word("12x1"),
        word => Structure::from_word(word),
    }
    .expect("a structure")
}

/// The structures that promises are about; from four modules on they are stricter.
const SHAPES: [&str; 8] = ["3x1", "2x2", "4x1", "3x2", "3x3", "5x5", "ring", "line of 12"];

/// Prints a table in one piece, then fails with everything that was broken.
fn finish(table: &str, broken: &[String]) {
    print!("\n{table}");
    assert!(broken.is_empty(), "{} promises broken:\n{}", broken.len(), broken.join("\n"));
}
