//! Choices of rest poses for structures of few modules.

/// Structures of so few modules are searched through.
pub(super) const SMALL: usize = 4;
/// Structures of so few modules have little to spare: more is tried.
pub(super) const FEW: usize = 8;

/// Choice of rest poses for structures of few modules.
#[derive(Clone, Copy, Debug)]
pub struct Choice {
    /// Which of the choices made it is.
    pub(super) number: usize,
    /// The most that they can be worth.
    pub(super) at_most: f64,
    /// By module, the rest of the list unused.
    pub(super) poses_rad: [f64; FEW],
}
