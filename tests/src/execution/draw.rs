//! Random scenarios, drawn from a seed: any shape of 3 to 49 modules, legs and headings of any kind, motors of the whole spread, gusts
//! and loss; and sharp ones, in which legs change as fast as a fleet can tell.
//!
//! A structure of N modules that surges and sways at v in a direction at β to its axes gives N·C_L·v²·√(cos⁴β + sin⁴β) against the
//! water's drag (19), and no more than N·F(A_max): speeds are drawn up to what that allows.

use std::f64::consts::PI;
use std::fmt::Write;

use host::run::scenario::Scenario;
use modboat::parameters::Parameters;
use protocol::time::Duration;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use sim::motor::SPREAD_MAX;

use super::Reboot;
use crate::random;

/// Modules, least and most.
const MODULES: [usize; 2] = [3, 49];
/// Length of a leg, s.
const LEG_S: [f64; 2] = [2.0, 20.0];
/// Greatest gusts, m/s. *Assumed*: a quarter of the greatest speed.
const GUST_M_S: f64 = 0.025;

/// A scenario as drawn, with reboots.
#[derive(Clone, Debug)]
pub struct Drawn {
    /// As a scenario file, for `flotilla run`.
    pub text: String,
    /// The same.
    pub scenario: Scenario,
    /// Modules that lose their power.
    pub reboots: Vec<Reboot>,
}

/// The greatest speed at `beta_rad` to an axis of the structure, m/s.
fn attainable_m_s(parameters: &Parameters, beta_rad: f64) -> f64 {
    let (sin, cos) = beta_rad.sin_cos();
    let shape = (cos.powi(4) + sin.powi(4)).sqrt();
    (parameters.thrust_n(parameters.amplitude_max_rad) / (parameters.drag_n_s2_m2 * shape)).sqrt()
}

/// The cells of a shape.
fn cells(rng: &mut ChaCha8Rng) -> Vec<[i32; 2]> {
    let rectangle = |cols: i32, rows: i32| -> Vec<[i32; 2]> {
        (0..rows).flat_map(|row| (0..cols).map(move |col| [col, row])).collect()
    };
    match rng.random_range(0..4) {
        0 => {
            let side = rng.random_range(2..=7);
            rectangle(side, side)
        }
        1 => {
            let length = rng.random_range(3..=16);
            if rng.random_bool(0.5) { rectangle(length, 1) } else { rectangle(1, length) }
        }
        _ => random::shape(rng.random_range(MODULES[0]..=MODULES[1]), rng),
    }
}

/// One leg, at `speed` of the attainable speed.
fn leg(text: &mut String, duration_s: f64, speed: f64, course_rad: f64, heading_rad: f64) {
    let speed_m_s = speed * attainable_m_s(&Parameters::default(), course_rad - heading_rad);
    let [x, y] = [course_rad.cos(), course_rad.sin()].map(|share| speed_m_s * share);
    let _ = writeln!(
        text,
        "[[leg]]\nduration_s = {duration_s:.3}\nvelocity_m_s = [{x:.5}, {y:.5}]\nheading_rad = {heading_rad:.5}"
    );
}

impl Drawn {
    /// Any run. With `reboots` one to three modules lose their power, and plans are asked to be tolerant of that.
    ///
    /// # Panics
    /// If what is drawn is no scenario.
    #[must_use]
    pub fn new(seed: u64, reboots: bool) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0x00EC_5EC5);
        let cells = cells(&mut rng);
        let tolerant = match rng.random_range(0..10) {
            _ if reboots => "power",
            0 => "off",
            1 => "power",
            _ => "prefer",
        };
        let loss = rng.random_range(0.0..0.4);
        let gust_m_s = rng.random_range(0.0..GUST_M_S);
        let tail_rad = if rng.random_bool(0.5) { 0.0 } else { rng.random_range(-PI..PI) };
        let mut text = format!(
            "name = \"execution-{seed}\"\n[structure]\ncells = {cells:?}\n[start]\ntail_rad = {tail_rad:.5}\n\
             [planner]\nloss_tolerant = \"{tolerant}\"\n[motor]\nspread = {SPREAD_MAX}\n\
             [tank]\ngust_m_s = {gust_m_s:.5}\n[radio]\nloss = {loss:.4}\n"
        );
        let mut length_s = 0.0;
        for _ in 0..rng.random_range(2..=5) {
            let duration_s = rng.random_range(LEG_S[0]..LEG_S[1]);
            let [course_rad, heading_rad] = [(); 2].map(|()| rng.random_range(-PI..PI));
            leg(&mut text, duration_s, rng.random_range(0.0..1.0), course_rad, heading_rad);
            length_s += duration_s;
        }
        let count = if reboots { rng.random_range(1..=3) } else { 0 };
        let reboots = (0..count)
            .map(|_| Reboot {
                module: rng.random_range(0..cells.len()),
                at_s: rng.random_range(0.0..length_s),
                off: Duration(rng.random_range(50_000..1_000_000)),
            })
            .collect();
        Self { scenario: parsed(&text), text, reboots }
    }

    /// The sharp one of this number: legs of two to four seconds, at 90 % of the attainable speed, each the other way round, with a
    /// heading more than a quarter turn off.
    ///
    /// # Panics
    /// If what is drawn is no scenario.
    #[must_use]
    pub fn sharp(number: u64) -> Self {
        const SIZES: [&str; 5] = ["3x1", "2x2", "3x3", "4x2", "5x5"];
        let mut rng = ChaCha8Rng::seed_from_u64(number ^ 0x5_4A29);
        let size = SIZES[number as usize % SIZES.len()];
        let mut text = format!("name = \"sharp-{number}\"\n[structure]\nsize = \"{size}\"\n");
        let (mut course_rad, mut heading_rad) = (rng.random_range(-PI..PI), rng.random_range(-PI..PI));
        for _ in 0..8 {
            leg(&mut text, rng.random_range(2.0..4.0), 0.9, course_rad, heading_rad);
            course_rad += PI + rng.random_range(-0.5..0.5);
            heading_rad += rng.random_range(0.5 * PI..1.5 * PI);
        }
        Self { scenario: parsed(&text), text, reboots: Vec::new() }
    }
}

fn parsed(text: &str) -> Scenario {
    Scenario::parse("drawn.toml", text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 0.0382 N against 4.5 N·s²/m²: 0.0921 m/s along an axis; at 45° each axis takes half of v², and 2^¼ more is possible.
    #[test]
    fn attainable_speeds_are_hand_worked() {
        let parameters = Parameters::default();
        assert!((attainable_m_s(&parameters, 0.0) - 0.092_135).abs() < 1e-5);
        assert!((attainable_m_s(&parameters, PI / 4.0) / 0.092_135 - 2.0_f64.powf(0.25)).abs() < 1e-4);
    }

    #[test]
    fn shapes_have_3_to_49_modules() {
        let sizes: Vec<usize> =
            (0..200).map(|seed| Drawn::new(seed, seed % 2 == 0).scenario.structure.len()).collect();
        assert!(sizes.iter().all(|size| (3..=49).contains(size)), "{sizes:?}");
        assert!(sizes.iter().any(|size| *size < 6) && sizes.iter().any(|size| *size > 40), "{sizes:?}");
    }
}
