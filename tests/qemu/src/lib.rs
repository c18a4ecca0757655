//! Emulated modules for tests: the image that `firmware/boards/build` made, in `qemu-system-arm`, on UDP ports of this machine.
//!
//! What a module did when is asked of the emulator's own clock, in lock step ([`modules`]); emulators on their own, in this machine's time, are
//! asked only for what holds at any speed.
//!
//! | module | what |
//! |---|---|
//! | [`mod@bench`] | a host for as many of them as are asked for |
//! | [`debugger`] | lets an emulator's time go on |
//! | [`emulator`] | one emulated module: started, listened to, killed |
//! | [`fleet`] | emulated modules as the fleet of a run |
//! | [`kept`] | the table of what the firmware takes |
//! | [`modules`] | emulated modules in lock step with their host |
//! | [`provisioned`] | its configuration |
//! | [`report`] | the line that an emulated module prints every second |
//! | [`stepped`] | one emulated module in lock step |
//! | [`storm`] | datagrams that no module may follow |

pub mod bench;
pub mod debugger;
pub mod emulator;
pub mod fleet;
pub mod kept;
pub mod modules;
pub mod provisioned;
pub mod report;
pub mod stepped;
pub mod storm;
