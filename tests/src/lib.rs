//! What the tests of the whole system share: an independent checker of plans, random demands and shapes, and the figures
//! that tests print.
//!
//! | module | what |
//! |---|---|
//! | [`checker`] | whether a plan keeps its word, by code of its own |
//! | [`convert`] | from the host's types to the checker's numbers |
//! | [`demands`] | seeded demands inside a share of the envelope, alone or in a walk |
//! | [`execution`] | whether the tails of a run did what was planned, and kept clear |
//! | [`hidden`] | boats that differ from what is believed of them |
//! | [`public_maps`] | maps of public benchmarks, found where Cargo keeps a crate or where the environment says |
//! | [`random`] | seeded shapes and demands |
//! | [`reconfigure`] | seeded reconfigurations of ROVs |
//! | [`seeds`] | many seeds on all cores, and numbers from the environment |
//! | [`spoil`] | ways to spoil a plan of ROVs |
//! | [`statistics`] | the suite's own statistics as campaigns, a row a run |
//! | [`storm`] | whole fleets on a bad medium, with reboots, and the checks on them |
//! | [`stream`] | planners asked demand after demand, and what came of it |
//! | [`turned`] | seeded reconfigurations of ROVs at any heading, of two kinds |
//! | [`figures`] | quantiles |

pub mod checker;
pub mod convert;
pub mod demands;
pub mod execution;
pub mod figures;
pub mod hidden;
pub mod public_maps;
pub mod random;
pub mod reconfigure;
pub mod seeds;
pub mod shifted;
pub mod spoil;
pub mod statistics;
pub mod storm;
pub mod stream;
pub mod turned;
