//! Detection of Rust's panic machinery in an image.
//!
//! Every panic ends in the handler (`rust_begin_unwind`) and comes there through functions of `core` with `panic` or `fail` in their
//! names: an image without them has no way to panic. One that may have some says which and why, in a file:
//!
//! ```text
//! core::panicking::panic_fmt    # the driver of the radio checks its own state
//! ```
//!
//! Limits: names are those that the compiler gives, and differ from one to the next. A panic whose function was inlined is found by what
//! it calls. Whether a function can be reached is not asked: the linker takes out what is not called.

use thiserror::Error;

/// Crates whose functions panics go through. `__rustc` has the handler, under a name that nothing else can have.
const CRATES: [&str; 4] = ["core", "alloc", "std", "__rustc"];
/// Parts of a path that are about nothing else.
const PARTS: [&str; 6] =
    ["panicking", "rust_begin_unwind", "rust_panic", "do_panic", "handle_alloc_error", "capacity_overflow"];

/// A line of the file that says nothing.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("{line}: {text:?}: a line is NAME # REASON")]
pub struct AllowError {
    /// Which line, from 1.
    pub line: usize,
    /// What stands there.
    pub text: String,
}

/// A function of the panic machinery that an image may hold.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Allowed {
    /// Its name.
    pub name: String,
    /// Why.
    pub reason: String,
}

/// Whether a function of this name belongs to the machinery.
#[must_use]
pub fn is_panic(function: &str) -> bool {
    // `<core::…::Type as …>::panic` too.
    let mut parts = function.trim_start_matches('<').split("::");
    let Some(first) = parts.next() else { return false };
    if first == "rust_begin_unwind" {
        return true;
    }
    CRATES.contains(&first)
        && parts.any(|part| {
            PARTS.contains(&part)
                || part.starts_with("panic_")
                || part.ends_with("_fail")
                || part.ends_with("_failed")
        })
}

/// Reads what may be there; empty lines and lines that are all comment are nothing.
pub fn allowed(text: &str) -> Result<Vec<Allowed>, AllowError> {
    let lines = (1..).zip(text.lines()).filter(|(_, line)| {
        let line = line.trim();
        !line.is_empty() && !line.starts_with('#')
    });
    lines
        .map(|(number, line)| match line.split_once('#').map(|(name, why)| (name.trim(), why.trim())) {
            Some((name, reason)) if !reason.is_empty() => {
                Ok(Allowed { name: name.to_owned(), reason: reason.to_owned() })
            }
            _ => Err(AllowError { line: number, text: line.to_owned() }),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_machinery_is_told_from_the_rest() {
        for name in [
            "core::panicking::panic",
            "core::panicking::panic_const::panic_const_div_by_zero",
            "core::option::unwrap_failed",
            "core::option::expect_failed",
            "core::result::unwrap_failed",
            "core::slice::index::slice_end_index_len_fail",
            "core::slice::index::slice_end_index_len_fail::do_panic::runtime",
            "core::slice::index::slice_index_fail",
            "core::slice::copy_from_slice_impl::len_mismatch_fail",
            "core::str::slice_error_fail",
            "core::cell::panic_already_borrowed",
            "alloc::raw_vec::capacity_overflow",
            "rust_begin_unwind",
            "__rustc::rust_begin_unwind",
        ] {
            assert!(is_panic(name), "{name}");
        }
        for name in [
            "core::fmt::write",
            "main",
            "HardFault",
            "firmware::modboat::homing::Search::Fail",
            "board::link_failed",
            "core::slice::index::get",
            "",
        ] {
            assert!(!is_panic(name), "{name}");
        }
    }

    #[test]
    fn what_may_be_there_has_a_reason() {
        let text = "# of the radio\n\ncore::panicking::panic_fmt # its driver checks itself\n";
        let expected = Allowed {
            name: "core::panicking::panic_fmt".to_owned(),
            reason: "its driver checks itself".to_owned(),
        };
        assert_eq!(allowed(text), Ok(vec![expected]));
        for bad in ["a::b", "a::b #", "a::b # \n"] {
            let error = allowed(&format!("# head\n{bad}")).unwrap_err();
            assert_eq!(error.line, 2, "{error}");
        }
    }
}
