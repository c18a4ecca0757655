//! What a campaign is made of: numbered runs, each of which makes a row.
//!
//! A [`Study`](crate::study::Study) is such work, from a file. Programs have work of their own: the test suite's statistics are made so.

use std::panic::{AssertUnwindSafe, catch_unwind};

use serde_json::{Map, Value};
use sha2::{Digest, Sha256};

/// See the module's documentation.
pub trait Work: Sync {
    /// Its name.
    fn name(&self) -> &str;

    /// How many runs there are.
    fn runs(&self) -> usize;

    /// What the runs are made of, in words.
    fn told(&self) -> String;

    /// A text that is another for every other work: rows of one are no rows of the other. See [`fingerprint`].
    fn fingerprint(&self) -> String;

    /// Columns that are varied on a grid.
    fn grid(&self) -> Vec<String> {
        Vec::new()
    }

    /// Columns that are sampled.
    fn sampled(&self) -> Vec<String> {
        Vec::new()
    }

    /// Run `number`, from 0, executed, without its number. It must not panic.
    fn row(&self, number: usize) -> Map<String, Value>;
}

/// SHA-256 of `parts`, each with its length.
#[must_use]
pub fn fingerprint<'p>(parts: impl IntoIterator<Item = &'p [u8]>) -> String {
    let mut hash = Sha256::new();
    for part in parts {
        hash.update((part.len() as u64).to_le_bytes());
        hash.update(part);
    }
    hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

/// What `run` gives, or what its panic says: a run that panics takes no other with it.
///
/// # Errors
/// The panic's message.
pub fn caught<T>(run: impl FnOnce() -> T) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(run)).map_err(|panic| {
        let text = panic.downcast_ref::<String>().map(String::as_str);
        text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("panic").to_owned()
    })
}
