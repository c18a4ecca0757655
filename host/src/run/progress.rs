//! Progress of a run, for a person to follow.

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

/// Reports nothing.
pub struct Quiet;

impl Progress for Quiet {
    fn at(&mut self, _t_s: f64, _duration_s: f64) {}
    fn note(&mut self, _text: &str) {}
}
