//! The link between the host and its modules: radios, their faults, and the dispatcher.
//!
//! | file | what |
//! |---|---|
//! | [`loopback`] | a radio inside one process |
//! | [`faults`] | loss, delay, reordering, duplication, damage, replay, forgery: middleware over any radio |
//! | [`udp`] | a radio over a UDP socket |
//! | [`dispatcher`] | takes modules in, sends each cycle ahead and again until answered; sans-IO |
//! | [`member`] | what the host knows of one module |
//! | `live` | a session in force |
//! | `offers` | sessions that a module has not taken up yet |
//! | `plausible` | numbers in reports that no module can have |
//! | `spare` | buffers that are filled again |
//! | `rival` | two modules with one number |
//! | [`strangers`] | who was heard that is not followed |
//! | [`delivery`] | how a cycle gets to one module, or to all or none |
//! | [`identity`] | who the host is |
//! | [`ledger`] | what was sent, what came back |
//! | [`key_file`] | the files that keys are kept in |
//! | [`private_file`] | files that only their owner reads |
//! | [`entropy`] | random bytes for keys and nonces |

pub mod delivery;
pub mod dispatcher;
pub mod entropy;
pub mod faults;
pub mod identity;
pub mod key_file;
pub mod lead;
pub mod ledger;
mod live;
pub mod loopback;
pub mod member;
mod offers;
mod plausible;
pub mod private_file;
mod rival;
mod spare;
pub mod strangers;
pub mod udp;
