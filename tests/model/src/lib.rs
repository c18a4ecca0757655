//! The delivery protocol, checked over every order of events: two docked modules, a host, and a network that loses, repeats,
//! delays and reorders without bound.
//!
//! ```text
//! cargo test -p model
//! ```
//!
//! The checker (stateright) follows every sequence of [`Action`](fleet::Action)s from a fleet in session and at rest, looks at every
//! state once, and prints how many there were; where a property is broken it prints the shortest way there.
//!
//! | what | how it is modelled |
//! |---|---|
//! | time | slots: start n begins slot n for all at once, a cycle fills one slot, what is planned in a slot starts with the next |
//! | network | whatever was said in a session may come at any time, any number of times, in any order, or never. One order stands for all its copies, each with a number of its own: that takes in every loss, delay and replay, and leaves the replay window nothing to do. [`Config::once`](fleet::Config::once) sends once, with the real window |
//! | keys | symbols: [`SessionId`](said::SessionId) names the nonces on both sides. What was sealed in another session cannot be opened, so it is forgotten. Recording and replaying is the network's part |
//! | clocks | a module knows the fleet time or does not; it may doubt it whenever a cycle comes or is to start |
//! | boots, stops, stalls, holds | any time, as often as the [`Budget`](fleet::Budget) allows |
//! | modules | the real schedule, failsafe and window of the firmware; link and endpoint by the table in [`module`] |
//! | host | the real `DeliveryState`, `PhaseOutcome` and `Knowledge`; dispatcher and pilot by the table in [`host`] |
//!
//! | property | holds |
//! |---|---|
//! | A no two modules run different cycles at once | always |
//! | B nothing runs that is stale: of a session that is over, given up, made void by a hold or a stop, for a second time, after its start | always |
//! | C a prepared cycle runs only where the neighbour holds it, or held it until it booted, was stopped or told to hold | always |
//! | D `Certainly` and `CertainlyNot` are true, and plans set out from true poses, unless a module was stopped or booted since its report | always |
//! | G a stopped module runs nothing, from the stop on, and only a release that was sent after the stop ends it: not an earlier one that comes late, not a reboot of the host, not a replay | always |
//! | E once the network heals, both run a new prepared cycle within three slots | from every state, in one fair schedule of events ([`heal`]), with all that was under way delivered and with all of it lost |
//! | F direct cycles alone: every combination by the table in [`properties`] is safe, holding included | always, without boots and stops |
//! | F a prepared cycle is run by both or by none | **cannot**: the counterexample is the last commit, lost |
//!
//! What the checker found in the protocol as it was, and what was changed; each is a way to break it again
//! ([`Broken`](fleet::Broken)), as are those on purpose:
//!
//! | found | changed |
//! |---|---|
//! | a cycle that comes after the hold or stop that was sent after it was run | `NoFence`: such a cycle is ignored |
//! | a cycle that was held was refused when it came again (clock or battery in doubt by then), and one refused was accepted when it came again: the host was certain that it does not run, and it ran | `ForgetfulRefusals`: what was answered stays true |
//! | a module that boots after the commit made the host give the cycle up for all, if it stands before the others in the roster | `DropAfterCommit`: what is committed is not given up |
//! | a module that took a cycle and dropped it (clock in doubt, stopped) passed for running it, and the next plan set out from a pose where it was not | `AcceptanceIsProof`: only a report is proof |
//!
//! Broken on purpose besides: `NoCommit`, `HastyCommit`, `SameNonce`, `ReusedNumber`, and of stops `BlindRelease` (a late copy of a release ends
//! a later stop), `LateStop` (a stop waits for the end of the cycle), `StopOfOneHost` (a reboot of the host ends it).
//!
//! Assumptions and limits:
//! - Two modules, at most three cycles, one or two mishaps at a time, as each test says: beyond is not explored.
//! - Real link, endpoint, dispatcher and pilot are mirrored, not run. A difference between mirror and code is not seen here; the storms run
//!   the code.
//! - A host that has been silent for a slot may be taken for dead, whatever the clock says: more than can happen, as long as `lead_s` is
//!   shorter than the silence.
//! - The host's timer acts at once on what has come. Acknowledgements and reports can always be replayed; of two reports the older is
//!   ignored.
//! - Recordings of announcements of former boots, more offers than one for a nonce, transitions in two steps, thrust leases and
//!   fleets that swim without missing modules (`require`) are left out.
//! - A stop by another host is a stop that the module's own host does not know of, as a stall is: one event stands for both.
//! - States are told apart by hashes of 64 bits. Which module is which does not matter, so in a trace the two may change places at any
//!   step.

pub mod fleet;
pub mod heal;
pub mod host;
pub mod module;
pub mod properties;
pub mod run;
pub mod said;
pub mod slots;
