//! The least that a tool's cluster draws for its balance, whichever robots rest beside it: a bound by the dual of (16).
//!
//! While a robot is under way, m others rest, each in one of the places. With thrusts u_t, wrenches b_t of a newton of each thruster and the tool's
//! wrench τ, the power of any set S of places that balances the tool is at least, for every price y of a wrench,
//!
//! ```text
//! P(S) = min Σ P(u_t),  Σ b_t u_t = τ     ≥     y·τ − Σ_{p∈S} φ_p(y),      φ_p(y) = Σ_{t of p} max over u of (y·b_t) u − P(u)
//! min over |S| ≤ m of P(S)                ≥     y·τ − the m greatest φ_p(y)
//! ```
//!
//! P is the lower convex envelope of the law, which is below it. The right side is concave in y; the ellipsoid method (Shor 1977) brings it near its
//! greatest value, and every y that it looks at gives a bound. Which places touch each other is left out, which takes from the bound.
//!
//! The table is no convex law: below 1 N it rises in steps, far above its envelope, and what is told is its own power for the thrusts of the envelope.
//! There all sets are looked at where they are few, and else some; then the search tells what the least power was that it met
//! ([`Waits::least_met_w`](super::waits::Waits::least_met_w)), and its bound is taken down where that is less: a path's least cost is concave in λ and
//! not negative, so that c(λ) ≥ c(λ₀)·λ/λ₀. For those sets that no search met it is no proof.
//!
//! Where a robot alone cannot push in every direction, stability may serve roll and pitch ([`allocation`](super::super::allocation)); these cost nothing
//! then: the parts of y along them are zero.

use nalgebra::{Matrix6, Vector3, Vector6};
use reconfiguration::pose::Pose;
use reconfiguration::vehicle::Vehicle;

use super::super::cluster::Cluster;
use super::super::configuration_matrix::ConfigurationMatrix;
use super::super::order::{DESKS, Workers};
use super::super::power::{PowerLaw, limits_of};
use super::pricer::{Pricer, is_same};

/// A robot in a place, or a tool.
type Body<'a> = (Pose, &'a Vehicle);

/// Half axes of the first ellipsoid: prices of a newton, W/N, and of a newton metre, W/(N·m). A T200's last newton costs some 11 W.
const FORCE_W_N: f64 = 20.0;
const MOMENT_W_NM: f64 = 200.0;
/// Each step takes e^(−1/14) of the volume: the half axes end at 1e-6 of these.
const STEPS: usize = 1200;
/// Most sets of places whose balance is worked out beforehand: those of eight robots are 11 440.
const SETS_MOST: usize = 12_000;
/// What rounding may take off it.
const ROUNDING: f64 = 1.0 - 1e-9;

impl Pricer<'_> {
    /// What others draw at least while a robot moves, W, with one tool and robots that feel nothing themselves; and whether that is the least of
    /// some sets of robots only.
    pub(super) fn least_balance_w(&self, workers: &dyn Workers) -> (f64, bool) {
        let problem = self.problem;
        let [tool] = problem.tools.as_slice() else { return (0.0, false) };
        if self.layout.berths() > 0 {
            return (0.0, false);
        }
        // A start and a slot of one pose are one place.
        let mut seats: Vec<usize> = Vec::new();
        for place in 0..self.layout.places() {
            let is_new = |seat: &usize| {
                let (pose, vehicle) = self.places.body(*seat);
                let is_same = |&other: &usize| {
                    let (there, of) = self.places.body(other);
                    is_same(&there, &pose) && std::ptr::eq(of, vehicle)
                };
                !seats.iter().any(is_same)
            };
            let own: Vec<usize> = self.places.seats_of(place).filter(is_new).collect();
            seats.extend(own);
        }
        let resting = self.layout.robots() - 1;
        let tool = (tool.pose, &problem.vehicles[tool.vehicle]);
        let bound_w =
            bound_w(tool, &self.bodies(&seats), resting, &self.request.law, self.limits_n).unwrap_or(0.0);
        if !matches!(self.request.law, PowerLaw::Table(_)) || !self.places.has_one_vehicle() {
            return (bound_w, false);
        }
        let all_sets = sets_of(seats.len(), resting, SETS_MOST);
        let samples_sets = all_sets.is_none();
        let sets = all_sets.unwrap_or_else(|| {
            // All, the starts, the slots.
            let [all, starts] = [seats.len(), self.layout.robots()].map(|count| (1_u64 << count) - 1);
            vec![all, starts, all & !starts]
        });
        let chunks: Vec<&[u64]> = sets.chunks(sets.len().div_ceil(DESKS)).collect();
        workers.run(chunks.len(), &|chunk| {
            for set in chunks[chunk] {
                let chosen =
                    seats.iter().enumerate().filter(|(k, _)| set >> k & 1 == 1).map(|(_, seat)| *seat);
                // The least is kept there.
                let _ = self
                    .waits
                    .power_w(&self.places, &self.tools.iter().copied().chain(chosen).collect::<Vec<_>>());
            }
        });
        let met_w = self.waits.least_met_w();
        if met_w.is_finite() { (bound_w.max(met_w), samples_sets) } else { (bound_w, false) }
    }

    /// What share of bounds holds for what others were found to draw; see the module's documentation.
    pub(super) fn share_of_bounds(&self) -> f64 {
        if self.lambda_least_w > 0.0 {
            (self.waits.least_met_w() / self.lambda_least_w).min(1.0)
        } else {
            1.0
        }
    }
}

/// All sets of `size` of `count`, as bits; none where there are more than `most`.
fn sets_of(count: usize, size: usize, most: usize) -> Option<Vec<u64>> {
    let number = (0..size)
        .try_fold(1_usize, |number, k| Some(number.checked_mul(count.checked_sub(k)?)? / (k + 1)))?;
    if number > most {
        return None;
    }
    let mut sets = Vec::with_capacity(number);
    let mut set = (1_u64 << size) - 1;
    while size > 0 && set >> count == 0 {
        sets.push(set);
        // The next greater number with as many bits (Warren 2012, 2-1).
        let (low, carried) = (set & set.wrapping_neg(), set + (set & set.wrapping_neg()));
        set = carried | (((set ^ carried) >> 2) / low);
    }
    Some(sets)
}

/// Wrenches of a newton of the thrusters that work, about an origin.
fn pushes(body: Body<'_>, origin: &Pose, limits_n: (f64, f64)) -> Option<Vec<Vector6<f64>>> {
    let matrix = ConfigurationMatrix::of_cluster(&[(body.1, body.0)], origin).ok()?;
    let works = limits_of(body.1, limits_n).map(|(low_n, high_n)| high_n > low_n);
    let columns = matrix.matrix().column_iter().zip(works).filter(|(_, works)| *works);
    Some(columns.map(|(column, _)| column.into_owned()).collect())
}

/// Whether a robot alone can push in every direction.
fn pushes_everywhere(vehicle: &Vehicle, limits_n: (f64, f64)) -> bool {
    let here = Pose { position_m: [0.0; 3], yaw_rad: 0.0 };
    let gram =
        pushes((here, vehicle), &here, limits_n).map(|own| own.iter().map(|b| b * b.transpose()).sum());
    gram.is_some_and(|gram: Matrix6<f64>| gram.rank(1e-9 * gram.norm()) == 6)
}

/// The least power, W, with at most `resting` of `places` beside the tool, by y·τ less the greatest φ; all robots feel nothing themselves. `None`
/// for what is no cluster.
fn bound_w(
    tool: Body<'_>,
    places: &[Body<'_>],
    resting: usize,
    law: &PowerLaw,
    limits_n: (f64, f64),
) -> Option<f64> {
    let wrench = Cluster::new(&tool.0, &[tool]).ok()?.hydrostatics().restoring(&Vector3::z());
    let by_place: Option<Vec<_>> = places.iter().map(|&body| pushes(body, &tool.0, limits_n)).collect();
    let by_place = by_place?;
    let mut free = Vector6::repeat(1.0);
    if !places.iter().all(|(_, vehicle)| pushes_everywhere(vehicle, limits_n)) {
        (free[3], free[4]) = (0.0, 0.0);
    }
    // The value at y and its slope, in the directions that count.
    let value = |y: &Vector6<f64>| {
        let mut worth: Vec<(f64, Vector6<f64>)> = (by_place.iter())
            .map(|own| {
                own.iter().fold((0.0, Vector6::zeros()), |(phi, pushed), b| {
                    let (thrust_n, power_w) = law.response(y.dot(b), limits_n);
                    (phi + y.dot(b) * thrust_n - power_w, pushed + b * thrust_n)
                })
            })
            .collect();
        worth.sort_by(|a, b| b.0.total_cmp(&a.0));
        let (phi, pushed) = (worth.iter().take(resting))
            .fold((0.0, Vector6::zeros()), |(phi, pushed), own| (phi + own.0, pushed + own.1));
        (y.dot(&wrench) - phi, (wrench - pushed).component_mul(&free))
    };
    let axes = Vector6::from([FORCE_W_N, FORCE_W_N, FORCE_W_N, MOMENT_W_NM, MOMENT_W_NM, MOMENT_W_NM]);
    let mut shape = Matrix6::from_diagonal(&axes.component_mul(&axes));
    let (mut y, mut best_w) = (Vector6::zeros(), 0.0_f64);
    for _ in 0..STEPS {
        let (value_w, slope) = value(&y);
        best_w = best_w.max(value_w);
        let along = shape * slope;
        let width = slope.dot(&along).sqrt();
        if !(width > 0.0 && width.is_finite()) {
            break;
        }
        // y ← y + A g / (n + 1),  A ← n²/(n² − 1) (A − 2/(n + 1) A g gᵀ A),  g of length 1 in A
        let step = along / width;
        y += step / 7.0;
        shape = (shape - step * step.transpose() * (2.0 / 7.0)) * (36.0 / 35.0);
    }
    Some(ROUNDING * best_w)
}

#[cfg(test)]
mod tests {
    use rand::rngs::ChaCha8Rng;
    use rand::{RngExt, SeedableRng};

    use reconfiguration::problem::Rules;

    use super::super::super::balance::balance;
    use super::super::super::power;
    use super::*;

    /// Cells around the tool's, each beside one that is there.
    fn cells(rng: &mut ChaCha8Rng, count: usize) -> Vec<[i32; 3]> {
        let mut cells = vec![[0; 3]];
        while cells.len() <= count {
            let mut cell: [i32; 3] = cells[rng.random_range(0..cells.len())];
            cell[rng.random_range(0..3)] += if rng.random_bool(0.5) { 1 } else { -1 };
            if !cells.contains(&cell) {
                cells.push(cell);
            }
        }
        cells.split_off(1)
    }

    #[test]
    fn no_robots_that_rest_balance_the_tool_for_less() {
        let [robot, tool] = ["bluerov1", "tool-20n"].map(|name| Vehicle::built_in(name).expect("built in"));
        let rules = Rules::default();
        let limits_n = power::limits_n(rules.battery_v).expect("in the table");
        for law in [PowerLaw::table(rules.battery_v), PowerLaw::fitted(rules.battery_v)] {
            let law = law.expect("in the table");
            for seed in 0..12 {
                let mut rng = ChaCha8Rng::seed_from_u64(seed);
                let at = |cell: [i32; 3]| {
                    let [x, y, z] = std::array::from_fn(|k| f64::from(cell[k]) * robot.box_m[k]);
                    (Pose { position_m: [x, y, z], yaw_rad: 0.0 }, &robot)
                };
                let places: Vec<_> = cells(&mut rng, 8).into_iter().map(at).collect();
                let own = (Pose { position_m: [0.0; 3], yaw_rad: 0.0 }, &tool);
                let bounds_w = [4, 8].map(|resting| bound_w(own, &places, resting, &law, limits_n));
                let [bound_w, whole_w] = bounds_w.map(|bound_w| bound_w.expect("a cluster"));
                let mut least_w = f64::INFINITY;
                for set in (0..1_u32 << 8).filter(|set| set.count_ones() == 4) {
                    let chosen = (0..8).filter(|k| set >> k & 1 == 1).map(|k| places[k]);
                    let bodies: Vec<_> = std::iter::once(own).chain(chosen).collect();
                    if let Ok(balance) = balance(&bodies, &law, limits_n, &rules) {
                        least_w = least_w.min(balance.power_w);
                    }
                }
                println!(
                    "seed {seed}: any 4 of 8 {least_w:.3} W, bound {bound_w:.3} W, by all 8 {whole_w:.3} W"
                );
                assert!(
                    least_w.is_finite() && bound_w <= least_w * (1.0 + 1e-9),
                    "seed {seed}: {bound_w} {least_w}"
                );
                let share = if matches!(law, PowerLaw::Table(_)) { 0.2 } else { 0.5 };
                assert!(
                    bound_w > share * least_w && whole_w <= bound_w,
                    "seed {seed}: {bound_w} {least_w} {whole_w}"
                );
            }
        }
    }
}
