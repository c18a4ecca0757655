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
//! | `numbers` | reports with numbers that no module can have |
//! | `doubled` | two modules with one number, and one that boots |
//! | `strangers` | who is named as what |
//! | `sums` | the ledgers, in a storm |

mod delivery;
mod doubled;
mod followed;
mod joining;
mod numbers;
mod orders;
mod played;
mod strangers;
mod sums;
mod two_phases;
