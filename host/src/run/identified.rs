//! Identified constants as tables of a scenario, or keys of a vehicle file.
//!
//! `[modboat]` has one drag for both axes, the mean of the two, and a drag of each module about its own axis, which is what is left of the
//! structure's yaw drag C_R once the strip sum over the modules is taken off (see `modboat::structure`):
//!
//! ```text
//! C_L = ½(C_sway + C_surge),   C_R,own = max(0, C_R/N − C_L·mean r³)
//! ```
//!
//! Masses go into `[control]` and `[observer]`, as factors on the dry mass and inertia of `[modboat]`. By how much more mass and drag there is in
//! surge than in sway goes into `[control.forgiving]`. What a boat is known to be, its heading may be held to more firmly than one that is only
//! believed: the time constant there is the shortest whose loop is stable from 0.5 to 1.3 times the thrust with a phase margin of 16°, with the
//! latency that was found.

use std::fmt::Write;

use identify::data::Boat;
use identify::outcome::{Constant, Outcome};
use identify::rov;
use modboat::control::ControlConfig;
use modboat::control::forgiving::ForgivingConfig;
use modboat::control::margins::{Axis, Loop, Margins};
use modboat::observer::ObserverParameters;
use reconfiguration::vehicle::Vehicle;

use super::scenario::Timing;

/// Time constants of the heading that are tried, s; without one of them it stays as it is.
const HEADING_S: [f64; 6] = [1.6, 1.8, 2.0, 2.25, 2.5, 2.75];
/// What the heading loop of an identified boat keeps: factors on the thrust at which it is still stable, and phase, rad. *Assumed*: thrust
/// over inertia is found within some percent, and the factors k of the controller go on learning.
const STANDS: ([f64; 2], f64) = ([0.5, 1.3], 0.28);

/// The shortest of [`HEADING_S`] whose loop keeps [`STANDS`], with its margins.
fn heading_time_s(boat: &Boat, latency_s: f64) -> Option<(f64, Margins)> {
    let lead_s = Timing::default().lead_s + latency_s.max(0.0);
    HEADING_S.into_iter().find_map(|time_s| {
        let forgiving = ForgivingConfig { heading_time_s: time_s, ..ForgivingConfig::default() };
        let control = ControlConfig { forgiving, ..ControlConfig::default() };
        let observer = ObserverParameters::default();
        let Boat { structure, belief, .. } = boat;
        let sampled = Loop { structure, parameters: belief, control: &control, observer: &observer, lead_s };
        let ([least, most], phase_rad) = STANDS;
        let margins = sampled.margins(Axis::Heading)?;
        let stands = margins.least_gain <= least && margins.gain >= most && margins.phase_rad >= phase_rad;
        stands.then_some((time_s, margins))
    })
}

/// Speed at which gusts are taken to twist a boat, m/s. *Assumed*: that of the paper's experiments.
const SPEED_M_S: f64 = 0.05;
/// What the pace of d_Θ is at least, and at most, rad/s² in a second.
const TWIST: (f64, f64) = (1e-3, 4e-3);

/// How fast gusts across the way change what the Munk moment turns a boat by: M_surge − M_sway times speed and gust, over I; with the memory
/// τ, a random walk of √(2/τ) of that in a second.
fn twist_rad_s2(beyond_kg: f64, inertia_kg_m2: f64, gust_m_s: f64, memory_s: f64) -> f64 {
    let twist = beyond_kg.abs() * SPEED_M_S * gust_m_s / inertia_kg_m2 * (2.0 / memory_s).sqrt();
    TWIST.0.hypot(twist).min(TWIST.1)
}

/// How far a share may be off that was identified, a standard deviation. *Assumed*: five times what it is off, for what changes from day to day.
const SHARE_FOUND: f64 = 0.05;

/// The tables, with what is to be said of them as comments.
#[must_use]
pub fn tables(boat: &Boat, outcome: &Outcome) -> String {
    let of = |name: &str| outcome.constant(name).map_or(f64::NAN, |constant| constant.value);
    let (structure, belief) = (&boat.structure, &boat.belief);
    let modules = structure.len() as f64;
    let drag = 0.5 * (of("drag_sway_n_s2_m2") + of("drag_surge_n_s2_m2"));
    let cubes: f64 =
        structure.positions_m(belief.pitch_m).iter().map(|[x, y]| x.hypot(*y).powi(3)).sum::<f64>();
    let own = (of("structure_yaw_drag_n_m_s2") - drag * cubes) / modules;
    let wet_kg = 0.5 * (of("mass_sway_kg") + of("mass_surge_kg"));
    let wet_kg_m2 = of("structure_inertia_kg_m2");
    let (mass, inertia) = (wet_kg / belief.module_mass_kg, wet_kg_m2 / structure.inertia_kg_m2(belief));
    let latencies = outcome.constants.iter().filter(|constant| constant.name.starts_with("latency"));
    let latency_s = latencies.map(|constant| constant.high).fold(0.0, f64::max);
    let mut text = String::new();
    let mut line = |line: String| {
        let _ = writeln!(text, "{line}");
    };
    line(format!("# {}", outcome.logs.join(", ")));
    line("[modboat]".to_owned());
    line(format!("force_slope_n_rad = {:.5}", of("force_slope_n_rad")));
    // Law (2) gives no negative thrust at its least amplitude: a scenario that says so is refused.
    let most_n = belief.amplitude_min_rad * of("force_slope_n_rad");
    line(format!("force_offset_n = {:.5}", of("force_offset_n").min(0.999 * most_n)));
    line(format!("module_mass_kg = {} # as it was believed: weigh it", belief.module_mass_kg));
    line(format!(
        "drag_n_s2_m2 = {drag:.4} # sway {:.4}, surge {:.4}",
        of("drag_sway_n_s2_m2"),
        of("drag_surge_n_s2_m2")
    ));
    let less = if own < 0.0 { " # the structure's is less than the sum over its modules" } else { "" };
    line(format!("yaw_drag_n_m_s2 = {:.6}{less}", own.max(1e-6)));
    if outcome.modules.iter().all(|module| module.gain.shown) {
        let shares = outcome.modules.iter().map(|module| format!("{:.4}", module.gain.value.clamp(0.1, 4.0)));
        line(format!("module_share = [{}]", shares.collect::<Vec<_>>().join(", ")));
    }
    line("\n[control]".to_owned());
    line(factor("added_mass_factor", mass, 0.0));
    line(factor("added_inertia_factor", inertia, 1.0));
    line("\n[control.forgiving]".to_owned());
    let munk = (of("mass_surge_kg") - of("mass_sway_kg")) / wet_kg;
    line(format!("munk = {:.4}", munk.clamp(-0.7, 0.7)));
    let difference = (of("drag_surge_n_s2_m2") - of("drag_sway_n_s2_m2")) / drag;
    line(format!("drag_difference = {:.4}", difference.clamp(-1.9, 1.9)));
    line(format!(
        "twist_rad_s2 = {:.5}",
        twist_rad_s2(munk * wet_kg * modules, wet_kg_m2, of("gust_m_s"), of("gust_memory_s"))
    ));
    line(format!("unsure_share = {SHARE_FOUND} # module_share and munk were found"));
    if let Some((time_s, Margins { least_gain, gain, phase_rad })) = heading_time_s(boat, latency_s) {
        let degrees = phase_rad.to_degrees();
        line(format!(
            "heading_time_s = {time_s} # stable with {least_gain:.2} to {gain:.2} times the thrust, phase margin {degrees:.0}°"
        ));
    }
    line("\n[observer]".to_owned());
    line(factor("added_mass", mass - 1.0, 0.0));
    line(factor("added_inertia", inertia - 1.0, 0.0));
    text
}

/// A factor that a scenario takes from `least` to 10.
fn factor(key: &str, value: f64, least: f64) -> String {
    let taken = value.clamp(least, 10.0);
    let doubt = if (taken - value).abs() > 1e-9 {
        format!(" # {value:.4} was found: the dry mass or inertia of [modboat] is too great, or too small")
    } else {
        String::new()
    };
    format!("{key} = {taken:.4}{doubt}")
}

/// Keys of a vehicle file: what these swims show, beside what the file has for what they do not.
#[must_use]
pub fn keys(vehicle: &Vehicle, outcome: &rov::outcome::Outcome) -> String {
    let body = &vehicle.body;
    let mut text = format!("# {}: {}\n", vehicle.name, outcome.logs.join(", "));
    let mut unshown = Vec::new();
    // What is hardly shown stays as it was believed.
    let mut of = |name: &str, belief: f64| match outcome.constant(name) {
        Some(Constant { value, shown: true, .. }) => *value,
        _ => {
            unshown.push(name.to_owned());
            belief
        }
    };
    let axes = [("surge", 0), ("sway", 1), ("heave", 2)];
    let mut lists = [
        ("added_mass", body.added_mass),
        ("linear_damping", body.linear_damping),
        ("quadratic_damping", body.quadratic_damping),
    ];
    for (name, axis) in axes {
        lists[0].1[axis] = of(&format!("added_mass_{name}_kg"), body.added_mass[axis]).max(0.0);
        lists[1].1[axis] = of(&format!("linear_damping_{name}_n_s_m"), body.linear_damping[axis]);
        lists[2].1[axis] = of(&format!("quadratic_damping_{name}_n_s2_m2"), body.quadratic_damping[axis]);
    }
    lists[0].1[5] = of("added_inertia_yaw_kg_m2", body.added_mass[5]).max(0.0);
    lists[1].1[5] = of("linear_damping_yaw_n_m_s", body.linear_damping[5]);
    lists[2].1[5] = of("quadratic_damping_yaw_n_m_s2", body.quadratic_damping[5]);
    let weight_n = of("weight_in_water_n", body.weight_n - body.buoyancy_n);
    let _ = writeln!(text, "weight_in_water_n = {weight_n:.3}");
    for (key, values) in lists {
        let values: Vec<String> = values.iter().map(|value| format!("{value:.4}")).collect();
        let _ = writeln!(text, "{key} = [{}]", values.join(", "));
    }
    if !unshown.is_empty() {
        let _ = writeln!(text, "# hardly shown, and left as they were: {}", unshown.join(", "));
    }
    text
}
