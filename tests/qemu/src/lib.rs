//! Emulated modules for tests: the image that `firmware/boards/build` made, in `qemu-system-arm`, on UDP ports of this machine.
//!
//! | module | what |
//! |---|---|
//! | [`mod@bench`] | a host for as many of them as are asked for |
//! | [`emulator`] | one emulated module: started, listened to, killed |
//! | [`fleet`] | emulated modules as the fleet of a run |
//! | [`kept`] | the table of what the firmware takes |
//! | [`provisioned`] | its configuration |
//! | [`report`] | the line that an emulated module prints every second |
//! | [`storm`] | datagrams that nobody should follow |

pub mod bench;
pub mod emulator;
pub mod fleet;
pub mod kept;
pub mod provisioned;
pub mod report;
pub mod storm;
