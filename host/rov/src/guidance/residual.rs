//! Residual of a robot or docked cluster: which thruster gives nothing, by what the observer finds that no model knows.
//!
//! ```text
//! w = M a_u − w̄                 what has become unknown lately
//! p_k = −T_k f_k                 what would have, had thruster k died: f_k is its thrust, late as the observer is
//! share = (w·p)/(p·p)            explained = (w·p)²/((w·w)(p·p))        sums over a second, moments in units of ℓ
//! ```
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | w̄ | slow mean of M a_u; it rests while there is something to be explained | N, N·m |
//! | f_k | thrust of thruster k that should be given, through three lags of 1/ω: the observer's own law from a push to a_u | N |
//! | ℓ | [`ARM_M`], which makes moments comparable with forces | m |
//!
//! A thruster is found when it explains [`EXPLAINED`] of what there is, with a share between [`SHARES`], for [`SURE_S`].
//!
//! The thrust that answers a current looks alike, once it is there: a thruster that is found is a suspect. It is taken out, and M a_u
//! after [`TRIAL_S`] is the verdict ([`Residual::is_explained`]): of a dead one w̄ is left, of a sound one all of it.
//!
//! Assumptions and limits: one thruster at a time, and it gives nothing at all. One that dies before a new cluster has
//! settled, some seconds from a docking or undocking, is taken for the water's doing. A thruster that is asked for less than some
//! [`LEAST_N`] cannot be told from noise, and is not missed either.

use nalgebra::Vector6;

use super::super::configuration_matrix::ConfigurationMatrix;
use super::observer::BANDWIDTH_RAD_S;

/// ℓ, m: half a hull.
pub const ARM_M: f64 = 0.15;
/// Less than this is no residual, N. *Assumed*: some six times what noise of 2 mm and 0.01 rad makes of it while the observer is calm.
pub const LEAST_N: f64 = 0.12;
/// So much of the residual is to be explained. *Assumed.*
pub const EXPLAINED: f64 = 0.85;
/// Least and greatest share of its thrust that is missing. *Assumed.*
pub const SHARES: [f64; 2] = [0.6, 1.5];
/// For this time, s. *Assumed.*
pub const SURE_S: f64 = 1.0;
/// Time constant of the sums, s.
const MEMORY_S: f64 = 0.7;
/// Time constant of w̄, s: slow against the lag of a calm observer, or w̄ would follow what is to be explained.
const SLOW_S: f64 = 8.0;
/// How long a suspect is out, s. *Assumed*: a calm observer shows four fifths of what is left by then.
pub const TRIAL_S: f64 = 3.5;
/// After this time what is not explained is taken for the water's doing, s.
const GIVEN_UP_S: f64 = 12.0;

/// In a cluster that is new nothing is suspected until M a_u has stayed at its mean of [`MEMORY_S`] for this time, s. *Assumed.*
const SETTLED_S: f64 = 1.5;
/// Nor longer than this, s. *Assumed.*
const SETTLES_S: f64 = 15.0;

/// Three lags in a row.
type Lags = [f64; 3];

#[derive(Clone, Copy, Debug, Default)]
struct Suspect {
    lags: Lags,
    wp: f64,
    pp: f64,
    sure_s: f64,
    cleared: bool,
}

/// See the module's documentation.
#[derive(Clone, Debug)]
pub struct Residual {
    suspects: Vec<Suspect>,
    mean: Option<Vector6<f64>>,
    ww: f64,
    /// For how long there has been something to be explained, s.
    open_s: f64,
    age_s: f64,
    /// M a_u of late, and for how long it has stayed there, s.
    recent: Option<Vector6<f64>>,
    settled_s: f64,
}

impl Residual {
    /// Of a body with so many thrusters, of which nothing is known.
    #[must_use]
    pub fn new(thrusters: usize) -> Self {
        Self {
            suspects: vec![Suspect::default(); thrusters],
            mean: None,
            ww: 0.0,
            open_s: 0.0,
            age_s: 0.0,
            recent: None,
            settled_s: 0.0,
        }
    }

    /// w̄: M a_u as it was before there was something to be explained, and the root mean square of w since.
    #[must_use]
    pub fn charge(&self) -> (Vector6<f64>, f64) {
        (self.mean.unwrap_or_default(), self.ww.sqrt())
    }

    /// A suspect was sound: it is none for as long as the same is to be explained.
    pub fn clear(&mut self, thruster: usize) {
        if let Some(suspect) = self.suspects.get_mut(thruster) {
            (suspect.cleared, suspect.sure_s) = (true, 0.0);
        }
    }

    /// Whether `unknown`, M a_u with the suspect out, is w̄ again, by the charge that the trial began with.
    #[must_use]
    pub fn is_explained(&(mean, size): &(Vector6<f64>, f64), unknown: &Vector6<f64>) -> bool {
        scaled(&(unknown - mean)).norm() < 0.5 * size
    }

    /// Lets `dt_s` pass: `unknown` is M a_u, `thrusts_n` what the thrusters should give, N. The thruster that gives nothing, when it is
    /// found.
    pub fn update(
        &mut self,
        dt_s: f64,
        matrix: &ConfigurationMatrix,
        unknown: &Vector6<f64>,
        thrusts_n: &[f64],
    ) -> Option<usize> {
        self.age_s += dt_s;
        let recent = *self.recent.get_or_insert(*unknown);
        self.recent = Some(recent + (unknown - recent) * (dt_s / MEMORY_S).min(1.0));
        if self.settled_s < SETTLED_S && self.age_s < SETTLES_S {
            let stays = scaled(&(unknown - recent)).norm() < LEAST_N;
            self.settled_s = if stays { self.settled_s + dt_s } else { 0.0 };
            self.mean = Some(*unknown);
        }
        let mean = *self.mean.get_or_insert(*unknown);
        let w = scaled(&(unknown - mean));
        let (forgotten, lag) = ((dt_s / MEMORY_S).min(1.0), (BANDWIDTH_RAD_S * dt_s).min(1.0));
        self.ww += (w.norm_squared() - self.ww) * forgotten;
        let is_open = self.ww > LEAST_N * LEAST_N;
        self.open_s = if is_open { self.open_s + dt_s } else { 0.0 };
        if self.open_s > GIVEN_UP_S {
            (self.mean, self.open_s) = (Some(*unknown), 0.0);
            self.suspects.iter_mut().for_each(|suspect| suspect.cleared = false);
        } else if !is_open {
            self.mean = Some(mean + (unknown - mean) * (dt_s / SLOW_S).min(1.0));
        }
        let mut found: Option<(usize, f64)> = None;
        let columns = matrix.matrix().column_iter();
        for (k, ((suspect, column), &thrust_n)) in
            self.suspects.iter_mut().zip(columns).zip(thrusts_n).enumerate()
        {
            let mut given_n = thrust_n;
            for stage in &mut suspect.lags {
                *stage += (given_n - *stage) * lag;
                given_n = *stage;
            }
            let p = scaled(&(-column.into_owned() * given_n));
            suspect.wp += (w.dot(&p) - suspect.wp) * forgotten;
            suspect.pp += (p.norm_squared() - suspect.pp) * forgotten;
            let share = suspect.wp / suspect.pp.max(1e-12);
            let explained = suspect.wp * share / self.ww.max(1e-12);
            let fits = is_open
                && !suspect.cleared
                && explained > EXPLAINED
                && (SHARES[0]..=SHARES[1]).contains(&share);
            suspect.sure_s = if fits { suspect.sure_s + dt_s } else { 0.0 };
            if suspect.sure_s > SURE_S && found.is_none_or(|(_, best)| explained > best) {
                found = Some((k, explained));
            }
        }
        found.map(|(k, _)| k)
    }
}

/// Moments in units of ℓ.
fn scaled(w: &Vector6<f64>) -> Vector6<f64> {
    let moment = 1.0 / ARM_M;
    w.component_mul(&Vector6::new(1.0, 1.0, 1.0, moment, moment, moment))
}

#[cfg(test)]
mod tests;
