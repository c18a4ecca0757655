//! Campaigns in one piece, in shards that are killed, and under schedulers of other makers, which all have to come to the same rows.

mod command;
mod kills;
mod parallel;
mod program;
mod python;
mod slurm;
