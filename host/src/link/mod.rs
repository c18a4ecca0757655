//! The link between the host and its modules: radios, their faults, and the dispatcher.
//!
//! | file | what |
//! |---|---|
//! | [`loopback`] | a radio inside one process |
//! | [`faults`] | loss, delay, reordering, duplication, damage: middleware over any radio |
//! | [`udp`] | a radio over a UDP socket |
//! | [`dispatcher`] | sends each cycle ahead and again until acknowledged; sans-IO |
//! | [`ledger`] | what was sent, what came back |

pub mod dispatcher;
pub mod faults;
pub mod ledger;
pub mod loopback;
pub mod udp;
