//! The module's side of the link: from a datagram to what a module may do, and back to a datagram.
//!
//! ```text
//! datagram → session ─ message → endpoint ─ cycle → Robot (modboat::robot or rov::lease)
//!                                 ↑    ↑
//!                              clock  failsafe
//! ```
//!
//! | file | what |
//! |---|---|
//! | [`session`] | lets one host in, opens and seals |
//! | [`endpoint`] | follows messages, posts reports; the kind of robot is its parameter |
//! | [`robot`] | what the kind of robot decides |
//! | [`clock`] | fleet time, from four-timestamp exchanges |
//! | [`failsafe`] | the module's state, and what leads from one to another |

pub mod clock;
pub mod endpoint;
pub mod failsafe;
pub mod robot;
pub mod session;
