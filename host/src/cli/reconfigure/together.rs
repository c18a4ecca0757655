//! `--parallel`: several robots under way at once.

use reconfiguration::plan::Manner;

use crate::answer::reconfigure::{ParallelKind, Together};

#[derive(clap::Args)]
pub(super) struct ParallelArguments {
    /// Several robots under way at once, where that pays [default: one after the other]
    #[arg(long, value_enum, value_name = "CRITERION")]
    parallel: Option<ParallelKind>,
    /// What a second is worth, J/s, instead of the criterion of --parallel
    #[arg(long, value_name = "WEIGHT", requires = "parallel")]
    weight: Option<f64>,
}

impl ParallelArguments {
    /// What they ask for, or what is wrong with it.
    pub fn checked(&self, manner: Manner) -> Result<Together, String> {
        let together = Together { parallel: self.parallel, weight: self.weight };
        together.check(manner)?;
        Ok(together)
    }
}
