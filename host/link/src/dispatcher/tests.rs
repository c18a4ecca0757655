//! The dispatcher against real sessions: the tests play the modules, with the module's side of the protocol.
//!
//! | file | what |
//! |---|---|
//! | `played` | a module's side of the link, and nothing behind it |
//! | `joining` | who is taken in, who is not, and what is heard of whom |
//! | `delivery` | one cycle to each module |
//! | `two_phases` | one cycle to all modules or none |
//! | `orders` | stop, release and hold |
//! | `followed` | the same, followed by the module's firmware over a bad link |
//! | `sums` | the ledgers, in a storm |

mod delivery;
mod followed;
mod joining;
mod orders;
mod played;
mod sums;
mod two_phases;
