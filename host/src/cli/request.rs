//! A request of `flotilla plan`: one line of JSON.

use modboat::motion::Wrench;
use serde::Deserialize;

use super::filter;
use crate::answer::plan::{self, check_demand};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Request {
    pub(super) cells: Vec<[i32; 2]>,
    pub(super) demand: Wrench,
    #[serde(default)]
    pub(super) tail_rad: Tails,
}

impl Request {
    /// From a line, with a demand that can be computed with.
    pub(super) fn read(line: &str) -> Result<Self, String> {
        let request: Self = filter::read(line)?;
        check_demand(request.demand)?;
        Ok(request)
    }
}

#[derive(Default, Deserialize)]
#[serde(untagged, expecting = "must be a list of angles, null or \"previous\"")]
pub(super) enum Tails {
    #[default]
    Unknown,
    Angles(Vec<f64>),
    Word(Previous),
}

#[derive(Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Previous {
    Previous,
}

impl From<Tails> for plan::Tails {
    fn from(tails: Tails) -> Self {
        match tails {
            Tails::Unknown => Self::Unknown,
            Tails::Angles(angles) => Self::Angles(angles),
            Tails::Word(Previous::Previous) => Self::Previous,
        }
    }
}
