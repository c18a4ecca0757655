//! Progress of a run, for a person to follow.

use std::cell::RefCell;

/// What a run reports while it goes on.
pub trait Progress {
    /// `t_s` of `duration_s` seconds have passed.
    fn at(&mut self, t_s: f64, duration_s: f64);
    /// Before the first second: `done` of `total` steps of what the run needs are done.
    fn preparing(&mut self, _what: &str, _done: u64, _total: u64) {}
    /// How the link is doing, in a few words.
    fn link(&mut self, _text: &str) {}
    /// Something worth a line: a module joins, the fleet holds.
    fn note(&mut self, text: &str);
}

/// Takes down what is noted, for a log, and passes it on.
pub(super) struct Noted<'a> {
    /// To whom.
    pub(super) progress: &'a mut dyn Progress,
    /// What was noted since the log took it.
    pub(super) notes: &'a RefCell<Vec<String>>,
}

impl Progress for Noted<'_> {
    fn at(&mut self, t_s: f64, duration_s: f64) {
        self.progress.at(t_s, duration_s);
    }

    fn preparing(&mut self, what: &str, done: u64, total: u64) {
        self.progress.preparing(what, done, total);
    }

    fn link(&mut self, text: &str) {
        self.progress.link(text);
    }

    fn note(&mut self, text: &str) {
        self.notes.borrow_mut().push(text.to_owned());
        self.progress.note(text);
    }
}

/// Reports nothing.
pub struct Quiet;

impl Progress for Quiet {
    fn at(&mut self, _t_s: f64, _duration_s: f64) {}
    fn note(&mut self, _text: &str) {}
}
