//! Progress on a terminal; silence in a pipe.

use indicatif::{ProgressBar, ProgressStyle};

use crate::run::progress::Progress;

/// A bar over the seconds of a run, with notes above it.
pub struct Bar {
    bar: ProgressBar,
    link: String,
}

impl Bar {
    /// A bar on standard error, hidden unless that is a terminal.
    pub fn new(title: &str) -> Self {
        let bar = ProgressBar::new(1);
        if let Ok(style) = ProgressStyle::with_template("{prefix} {bar:24} {msg}") {
            bar.set_style(style.progress_chars("━╸─"));
        }
        bar.set_prefix(title.to_owned());
        Self { bar, link: String::new() }
    }
}

impl Progress for Bar {
    fn at(&mut self, t_s: f64, duration_s: f64) {
        self.bar.set_length((duration_s * 10.0) as u64);
        self.bar.set_position((t_s * 10.0) as u64);
        self.bar.set_message(format!("{t_s:.0} of {duration_s:.0} s  {}", self.link));
    }

    fn link(&mut self, text: &str) {
        text.clone_into(&mut self.link);
    }

    fn preparing(&mut self, what: &str, done: u64, total: u64) {
        self.bar.set_length(total);
        self.bar.set_position(done);
        self.bar.set_message(what.to_owned());
    }

    fn note(&mut self, text: &str) {
        self.bar.println(text);
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
