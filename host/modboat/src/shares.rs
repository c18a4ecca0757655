//! What share of law (2) each module really gives, found while the structure swims: weed about the flippers, a weak battery.
//!
//! Every swim cycle is one period of a known mean wrench, and the mean of the poses over that period is free of the wobble. Three of them in a row
//! tell the mean acceleration, to which each module contributes by its swing of the plan:
//!
//! ```text
//! a = 2·[(p̄₃ − p̄₂)/h₂ − (p̄₂ − p̄₁)/h₁]/(h₁ + h₂),     v = (p̄₃ − p̄₁)/(h₁ + h₂)                     (h1)
//! (1 + μ)·M·a_x = Σ sᵢ·f_xᵢ − c_x·D·v_x|v_x| + d_x          sway
//!         M·a_y = Σ sᵢ·f_yᵢ − c_y·D·v_y|v_y| + d_y          surge                                  (h2)
//! (1 + ι)·I·α   = Σ sᵢ·τᵢ   − c_R·C_R·Ω|Ω| − m·M·v_x·v_y + d_Θ
//! fᵢ = ⅙·fᵢ(1) + ⅔·fᵢ(2) + ⅙·fᵢ(3)                                                                 (h3)
//! ```
//!
//! | symbol | unit | meaning |
//! |---|---|---|
//! | p̄ₖ, h | m and rad, s | mean pose over the period of cycle k; time between the middles of two |
//! | fᵢ(k), τᵢ(k) | N, N·m | what module i is planned to give in cycle k, mean over the interval, in S of cycle 2 |
//! | sᵢ | – | share of law (2) |
//! | μ, ι, c, m | – | errors of mass, inertia, drag; the Munk moment, as in the forgiving controller |
//! | d | N, N·m | what pushes besides; fixed to the world, and slowly changing |
//!
//! (h3) is exact where intervals are alike: a mean over one interval, differenced twice, sees a force that is constant within each interval with these
//! weights (the quadratic B-spline). (h2) is linear in all that is unknown, and a Kalman filter solves it cycle by cycle (module `regression`).
//!
//! A wrench that stays the same tells only three sums of the shares. What cannot be told apart stays uncertain, and [`Found::deviation`] says so.
//! Thrust, mass and drag that are all wrong by one factor move no pose otherwise: only shares relative to each other count
//! ([`ShareEstimator::relative`]).
//!
//! Poses that are older than their stamp belong in part to the cycle before: each delay of `DELAYS_S` has a filter of its own, and the one whose
//! innovations are the likeliest is believed (module `late`).
//!
//! Assumptions and limits: at most [`MODULES_MAX`] modules; cycles in which a module did not swim are left out by the caller.

use self::late::Late;
use self::means::Means;
use self::regression::Regression;
use crate::motion::Swing;
use crate::observer::{Fix, ObserverParameters};
use crate::parameters::Parameters;
use crate::structure::Structure;

mod late;
mod means;
mod regression;
#[cfg(test)]
mod tests;

/// Of more modules each moves the structure too little to be told apart, and the filter grows with their square.
pub const MODULES_MAX: usize = 100;

/// How much older than their stamp poses may be, s. *Assumed*: a motion capture that stamps on arrival.
const DELAYS_S: [f64; 5] = [0.0, 0.1, 0.2, 0.35, 0.5];
/// An interval begins where the one before ended, or this much later at most, s. *Assumed*: a pause that is short beside a cycle.
const PAUSE_MAX_S: f64 = 0.1;

/// A share of law (2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// The share.
    pub share: f64,
    /// Its standard deviation.
    pub deviation: f64,
}

/// One swim cycle that every module has swum.
#[derive(Clone, Copy, Debug)]
pub struct Swum<'a> {
    /// When the tails began to swing, s.
    pub start_s: f64,
    /// From the beginning of its transition to its end, s.
    pub interval_s: f64,
    /// By module.
    pub cycle: &'a [Swing],
    /// Sum of the unwrapped angles that the tails swing about, rad.
    pub about_rad: f64,
}

/// See the module's documentation.
#[derive(Clone, Debug)]
pub struct ShareEstimator {
    parameters: Parameters,
    positions_m: Vec<[f64; 2]>,
    means: Means,
    late: Vec<Late>,
    /// When the last cycle ended, s.
    end_s: Option<f64>,
}

impl ShareEstimator {
    /// That knows no more than `parameters`, of which each module's share may differ from the others' by `unsure`, a standard deviation, and
    /// takes m for `munk`. `None` if `unsure` is zero, and of a single module or more than [`MODULES_MAX`].
    #[must_use]
    pub fn new(
        structure: &Structure,
        parameters: &Parameters,
        observer: &ObserverParameters,
        (unsure, munk): (f64, f64),
    ) -> Option<Self> {
        if unsure == 0.0 || !(2..=MODULES_MAX).contains(&structure.len()) {
            return None;
        }
        let late =
            |delay_s| Late::new(delay_s, Regression::new(structure, parameters, observer, (unsure, munk)));
        Some(Self {
            parameters: parameters.clone(),
            positions_m: structure.positions_m(parameters.pitch_m),
            means: Means::new(parameters.period_s),
            late: DELAYS_S.into_iter().map(late).collect(),
            end_s: None,
        })
    }

    /// Takes a fix.
    pub fn update(&mut self, fix: &Fix) {
        self.means.update(fix);
        for late in &mut self.late {
            late.look(&self.means, self.parameters.period_s);
        }
    }

    /// Every module has swum this cycle, or will have. Cycles come in the order of their times.
    pub fn swum(&mut self, swum: &Swum<'_>) {
        let Swum { start_s, interval_s, cycle, about_rad } = *swum;
        let end_s = start_s + self.parameters.period_s;
        let begin_s = end_s - interval_s;
        if !self.end_s.is_some_and(|last_s| (begin_s - last_s).abs() <= PAUSE_MAX_S) {
            self.forget_cycles();
        }
        self.end_s = Some(end_s);
        let duty = self.parameters.period_s / interval_s;
        let given = |(swing, &at): (&Swing, &[f64; 2])| {
            swing.wrench(&self.parameters, at).to_array().map(|component| duty * component)
        };
        let given: Vec<[f64; 3]> = cycle.iter().zip(&self.positions_m).map(given).collect();
        for late in &mut self.late {
            late.swum(start_s, &given, about_rad);
        }
    }

    /// What follows does not go on from the cycles before: a module missed one, or the fleet held.
    pub fn forget_cycles(&mut self) {
        self.end_s = None;
        self.late.iter_mut().for_each(Late::forget_cycles);
    }

    fn likeliest(&self) -> Option<&Late> {
        self.late.iter().max_by(|a, b| a.likelihood().total_cmp(&b.likelihood()))
    }

    /// Shares over the mean of all, by module, and the deviation of that.
    pub fn relative(&self) -> impl Iterator<Item = Found> + '_ {
        self.likeliest().into_iter().flat_map(Late::relative)
    }

    /// m of (h2): by how much more mass with water the structure has in surge than in sway, as a share of what is believed.
    #[must_use]
    pub fn munk(&self) -> Option<Found> {
        self.likeliest().map(Late::munk)
    }
}
