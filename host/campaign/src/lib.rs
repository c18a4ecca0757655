//! Campaigns: studies of many runs, one row a run, on all cores of one machine or in shards on many.
//!
//! ```text
//! campaign.toml ─→ Study ─→ runs ─→ shard ─→ journal ─→ shard-3-of-8.parquet ─→ merge ─→ rows.parquet ─→ report
//! ```
//!
//! | module | what |
//! |---|---|
//! | [`work`] | numbered runs that make a row each |
//! | [`study`] | the campaign's file, and the runs that it makes |
//! | [`sampling`] | Sobol's sequence and Latin hypercubes |
//! | [`row`], [`cell`] | a run, executed, as a row |
//! | [`folder`], [`execute`] | a shard of the runs, in parallel, into the campaign's folder |
//! | [`journal`] | rows that outlive a process that is killed |
//! | [`table`] | rows as Parquet or CSV |
//! | [`merge`], [`report`] | shards as one file; means with intervals, and pictures |
//! | [`slurm`] | shards as an array of jobs |
//! | [`cli`] | the `flotilla-campaign` program, which `flotilla campaign` starts |
//!
//! A package of its own, so that the first command needs no Parquet.

pub mod cell;
pub mod cli;
pub mod execute;
pub mod folder;
pub mod journal;
pub mod merge;
pub mod report;
pub mod row;
pub mod sampling;
pub mod slurm;
mod statistics;
pub mod study;
pub mod table;
pub mod work;

pub use cli::main;
