//! What a search for cycles is asked for, and what it costs to turn the tails.

use quantity::wrap_rad;

use super::choice::SMALL;
use super::neighbours::Rules;
use crate::motion::Wrench;
use crate::setting::Case;
use crate::transition::solver::Signs;

/// What turning the tails by a radian each costs against the share of demands about one that are met, 1/rad. Three modules
/// must turn now and then whatever they do: little.
const TRAVEL_1_RAD: f64 = 0.3;
const TRAVEL_OF_THREE_1_RAD: f64 = 1.2;
/// The same of up to three modules from where they happen to rest at the start.
const TRAVEL_AT_FIRST_1_RAD: f64 = 2.0;

/// What cycles are looked for.
#[derive(Clone, Copy)]
pub(super) struct Asked<'a> {
    pub(super) case: Case<'a>,
    pub(super) demand: Wrench,
    pub(super) tails: Option<&'a [f64]>,
    pub(super) loss_tolerant: bool,
    /// Which amplitudes may be negated for the way.
    pub(super) signs: Signs,
    /// Where the tails are not known, or rest in a neighbour's reach as at the start: all is open, and it happens once.
    pub(super) once: bool,
    /// Where cycles are looked for that turn the structure little.
    pub(super) quiet: Option<Quiet>,
}

/// What turning the structure costs.
#[derive(Clone, Copy)]
pub(super) struct Quiet {
    /// The sum of the angles that the tails swing about now, rad.
    pub(super) about_rad: f64,
    /// Price of [`Wobble::unrest_rad`](super::wobble::Wobble::unrest_rad), 1/rad.
    pub(super) price_1_rad: f64,
    /// Merit that cycles have at least: with little room about them they are soon left for others.
    pub(super) room: f64,
}

impl<'a> Asked<'a> {
    /// A way there, and no more.
    pub(super) fn plainly(case: Case<'a>, demand: Wrench, tails: Option<&'a [f64]>) -> Self {
        let signs = Signs::PerModule;
        Self { case, demand, tails, loss_tolerant: false, signs, once: false, quiet: None }
    }

    pub(super) fn rules(&self) -> Rules<'a> {
        Rules { case: self.case, loss_tolerant: self.loss_tolerant }
    }

    /// Whether a tail turns so far that it pushes on its way.
    pub(super) fn pushes(&self, poses_rad: impl Iterator<Item = f64>) -> bool {
        let opens_rad = 2.0 * self.case.parameters.force_offset_n / self.case.parameters.force_slope_n_rad;
        let tails = self.tails.unwrap_or_default();
        poses_rad.zip(tails).any(|(pose, tail)| wrap_rad(pose - tail).abs() > opens_rad)
    }

    /// What is taken off a score for the tails' travel by the shortest way.
    pub(super) fn price(&self, poses_rad: impl Iterator<Item = f64>) -> f64 {
        let Some(tails) = self.tails else { return 0.0 };
        let price_1_rad = match tails.len() {
            ..SMALL if self.once => TRAVEL_AT_FIRST_1_RAD,
            ..SMALL => TRAVEL_OF_THREE_1_RAD,
            _ => TRAVEL_1_RAD,
        };
        let travel_rad: f64 = poses_rad.zip(tails).map(|(pose, tail)| wrap_rad(pose - tail).abs()).sum();
        price_1_rad * travel_rad / tails.len() as f64
    }
}
