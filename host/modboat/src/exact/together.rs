//! Cycles about the direction in which each module serves the demand most, wherever they start: for demands near the border of the
//! envelope.
//!
//! From a diagonal no cycle pushes along the lattice's diagonals with more than 0.86 of the greatest thrust, so that free rest poses
//! leave a part of the envelope out. The thrusts of least greatest size that give the demand ([`Envelope::thrusts`]) are all of
//! one size and turn slowly from module to module. Tails that swing about such directions swing in step, and stay clear of each
//! other mostly as they are. Where they do not, about a pole of rotation, a module swings about another direction or rests, and
//! Newton's method in amplitudes and centre lines makes up for it.
//!
//! Limits: such a cycle starts in its neighbours' reach, so that nothing may miss it.

use std::f64::consts::PI;

use super::allocation::{Aim, Met};
use super::asked::Asked;
use super::neighbours::{Cycle, Rules};
use super::search::{CycleCandidate, Search};
use super::turning::Best;
use crate::envelope::Envelope;
use crate::motion::Wrench;
use crate::setting::Case;

/// Patterns of signs over the lattice: one for all, then by cell, by column, by row.
const PATTERNS: usize = 4;
/// Angles off the wanted direction that a module is offered, rad.
const OFF_RAD: [f64; 9] = [0.0, 0.15, -0.15, 0.3, -0.3, 0.6, -0.6, 0.9, -0.9];

/// The sign of a module's amplitude in a pattern.
fn sign(pattern: usize, [col, row]: [i32; 2]) -> f64 {
    let odd = match pattern {
        0 => 0,
        1 => col + row,
        2 => col,
        _ => row,
    };
    if odd % 2 == 0 { 1.0 } else { -1.0 }
}

impl Search {
    /// Cycles in step, polished. The nearest found, if none meets the demand; `None` if no way was found.
    pub fn turn_together(
        &mut self,
        case: Case<'_>,
        envelope: &Envelope,
        demand: Wrench,
        tails: Option<&[f64]>,
    ) -> Option<CycleCandidate> {
        let mut thrusts_n = std::mem::take(&mut self.thrusts_n);
        envelope.thrusts(demand, &mut thrusts_n);
        let asked = Asked::plainly(case, demand, tails);
        let mut best = Best::default();
        for pattern in 0..if thrusts_n.is_empty() { 0 } else { PATTERNS } {
            let met = self.swing_in_step(case, demand, pattern, &thrusts_n);
            self.consider(&asked, met, 0.0, &mut best);
            if best.met() {
                break;
            }
        }
        self.thrusts_n = thrusts_n;
        best.found
    }

    /// Puts such cycles in the allocation; whether they meet the demand.
    fn swing_in_step(
        &mut self,
        case: Case<'_>,
        demand: Wrench,
        pattern: usize,
        thrusts_n: &[[f64; 2]],
    ) -> bool {
        let aim = Aim { recentre: 0.0, roams: true, ..self.aim(&case, demand) };
        let Self { rest, law, allocation, .. } = self;
        let rules = Rules { case, loss_tolerant: false };
        // All rest out of reach; one module after another swings instead.
        allocation.begin(
            (0..thrusts_n.len())
                .map(|module| Cycle { turns: true, ..rest.cycle(module, rest.stations_rad(module)[0], 0.0) }),
        );
        for (module, &[x_n, y_n]) in thrusts_n.iter().enumerate() {
            let amplitude_rad = law.amplitude_rad(x_n.hypot(y_n) / case.parameters.share(module));
            // A tail pushes away from where it points (7).
            let centerline_rad = y_n.atan2(x_n) + PI;
            let given = sign(pattern, case.cells[module]);
            let offered = OFF_RAD.iter().flat_map(|&off_rad| [(off_rad, given), (off_rad, -given)]);
            let cycle = offered
                .map(|(off_rad, sign)| Cycle {
                    rest_rad: centerline_rad + off_rad + sign * amplitude_rad,
                    amplitude_rad: sign * amplitude_rad,
                    free: false,
                    turns: true,
                })
                .find(|&cycle| rules.allow_among(module, cycle, |other| allocation.cycles[other]));
            if let Some(cycle) = cycle {
                allocation.cycles[module] = cycle;
            }
        }
        allocation.polish(&rules, rest, law, &aim) == Met::Yes
    }
}
