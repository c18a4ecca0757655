//! From swims to an outcome.

use std::collections::BTreeSet;

use reconfiguration::vehicle::Vehicle;
use rov::configuration_matrix::ConfigurationMatrix;

use super::super::estimate::Quantity;
use super::super::filter::{Errors, errors};
use super::super::fit::{Likelihood, Problem};
use super::super::inference::Covariance;
use super::super::outcome::Residuals;
use super::super::search::{HELD_BACK, IdentifyError, LEAST_S};
use super::constants::{
    AXES, AXIS_NAMES, CURRENT_UNIT, DELAY_UNIT, LINEAR, Layout, MASS, QUADRATIC, Values, WEIGHT, WEIGHT_UNIT,
    believed_mass,
};
use super::data::{Prepared, Recording};
use super::model::Swimming;
use super::outcome::{Outcome, Prediction, Scale, Thruster};
use super::prediction::foretold;

/// Logs of ROVs of one kind at any θ.
#[derive(Clone)]
struct Rovs<'a> {
    logs: &'a [Prepared],
    columns: &'a [[f64; 4]],
    /// Bins of each that count.
    bins: Vec<usize>,
    layout: Layout,
}

impl Likelihood for Rovs<'_> {
    type Setting = Vec<f64>;
    const COORDINATES: usize = 4;

    fn logs(&self) -> usize {
        self.logs.len()
    }

    fn elements(&self) -> usize {
        self.layout.len()
    }

    fn log_of(&self, index: usize) -> Option<usize> {
        self.layout.log_of(index)
    }

    fn setting(&self, theta: &[f64], log: usize) -> Vec<f64> {
        self.logs[log].halves(self.layout.thrusters, DELAY_UNIT * theta[self.layout.delay(log)])
    }

    fn sets(&self, index: usize, log: usize) -> bool {
        index == self.layout.delay(log)
    }

    fn errors(&self, theta: &[f64], halves_n: &Vec<f64>, log: usize) -> Errors {
        let values = Values::new(theta, self.layout, log);
        let motion =
            Swimming { values: &values, columns: self.columns, halves_n, tilts: &self.logs[log].tilts };
        errors(&self.logs[log].bins[..self.bins[log]], &motion, &mut ())
    }
}

/// Identifies the constants of `vehicle` from all `recordings` of robots of that kind together.
///
/// # Errors
/// [`IdentifyError`].
pub fn identify(vehicle: &Vehicle, recordings: &[Recording], scale: Scale) -> Result<Outcome, IdentifyError> {
    let thrusters = vehicle.thrusters.len();
    let matrix = ConfigurationMatrix::of_vehicle(vehicle)
        .map_err(|error| IdentifyError::Vehicle(error.to_string()))?;
    let columns: Vec<[f64; 4]> =
        matrix.matrix().column_iter().map(|column| AXES.map(|axis| column[axis])).collect();
    let logs: Vec<Prepared> =
        recordings.iter().map(|recording| Prepared::new(recording, thrusters)).collect();
    let spans_s: Vec<f64> = logs.iter().map(|log| log.span_s(0, log.bins.len())).collect();
    let duration_s: f64 = spans_s.iter().sum();
    if duration_s < LEAST_S {
        return Err(IdentifyError::FewSwims { vehicle: vehicle.name.clone(), has_s: duration_s });
    }
    let layout = Layout { thrusters, logs: logs.len() };
    let (prior, deviation) = layout.prior(vehicle);
    let (fixed, known_means) = match scale {
        Scale::Mass => (vec![MASS[0], MASS[2]], Vec::new()),
        Scale::Thrust => (Vec::new(), sets(&columns, layout).into_iter().map(|set| (set, 0.0)).collect()),
    };
    let whole: Vec<usize> = logs.iter().map(|log| log.bins.len()).collect();
    let part: Vec<usize> = whole.iter().map(|&bins| (bins as f64 * (1.0 - HELD_BACK)) as usize).collect();
    let problem = |bins: Vec<usize>| Problem {
        model: Rovs { logs: &logs, columns: &columns, bins, layout },
        prior: prior.clone(),
        deviation: deviation.clone(),
        fixed: fixed.clone(),
        known_means: known_means.clone(),
    };
    let gains: Vec<usize> = (0..thrusters).map(|of| layout.gain(of)).collect();
    let first = problem(part.clone()).search_in_stages(prior.clone(), &gains);
    let mut every = Vec::new();
    for (log, (prepared, &from)) in logs.iter().zip(&part).enumerate() {
        let number = every.last().map_or(0, |last: &super::outcome::Foretold| last.start + 1);
        every.extend(foretold(prepared, &columns, &first.theta, layout, log, from, number));
    }
    let held_back_s = logs.iter().zip(&part).map(|(log, &from)| log.span_s(from, log.bins.len())).sum();
    let prediction = Prediction::of(&every, held_back_s);

    let all = problem(whole);
    let fit = all.search(first.theta);
    let covariance = Covariance::new(&all, &fit).ok_or(IdentifyError::Senseless)?;
    let theta = &fit.theta;
    let constants: Vec<_> = quantities(vehicle, &columns, layout, scale, theta)
        .iter()
        .map(|quantity| quantity.constant(theta, &covariance))
        .collect();
    let thruster = |of: usize| Thruster {
        number: of + 1,
        gain: Quantity::log("gain", &[(layout.gain(of), 1.0)], 1.0, 1.0).constant(theta, &covariance),
    };
    let elements: Vec<usize> =
        (0..layout.len()).filter(|&index| !Layout::is_noise(index) && !all.fixed.contains(&index)).collect();
    let mut notes = Vec::new();
    if !fit.converged {
        notes.push(format!("the search did not end by itself within {} steps", fit.steps));
    }
    let unshown: Vec<&str> =
        constants.iter().filter(|constant| !constant.shown).map(|constant| constant.name.as_str()).collect();
    if !unshown.is_empty() {
        notes.push(format!("hardly shown by these swims: {}", unshown.join(", ")));
    }
    if prediction.starts == 0 {
        let horizon_s = prediction.horizon_s;
        notes.push(format!("no swim that was held back is longer than {horizon_s} s: nothing is foretold"));
    }
    let residuals = Residuals::of(&fit.errors, Rovs::COORDINATES);
    if residuals.correlation.iter().any(|correlation| *correlation > 0.3) {
        notes.push("prediction errors hang together: poses are exact, or the water does what the model has no word for".to_owned());
    }
    let swims = || recordings.iter().flat_map(|recording| &recording.swims);
    let robots: BTreeSet<u16> = swims().map(|swim| swim.robot).collect();
    let of_log = |(log, errors): (&Prepared, &Errors)| -> Vec<(f64, [f64; 4])> {
        let bins = log.bins.iter().filter(|bin| !bin.begins);
        bins.zip(errors.e.chunks_exact(4)).map(|(bin, e)| (bin.t_s, [e[0], e[1], e[2], e[3]])).collect()
    };
    Ok(Outcome {
        vehicle: vehicle.name.clone(),
        robots: robots.into_iter().collect(),
        logs: recordings.iter().map(|recording| recording.name.clone()).collect(),
        swims: swims().count(),
        duration_s,
        fixes: logs.iter().flat_map(|log| &log.bins).map(|bin| bin.count).sum::<f64>() as usize,
        scale,
        scale_text: scale_text(vehicle, scale),
        thrusters: (0..thrusters).map(thruster).collect(),
        constants,
        indistinct: covariance.indistinct(&elements, |index| layout.name(index)),
        correlated: elements.iter().map(|&index| layout.name(index)).collect(),
        correlations: covariance.correlations(&elements),
        prediction,
        residuals,
        steps: first.steps + fit.steps,
        converged: fit.converged,
        notes,
        foretold: every,
        errors: logs.iter().zip(&fit.errors).flat_map(of_log).collect(),
    })
}

/// Thrusters that share a scale. What pushes up and down alone has one of its own: heave has no term in common with the other axes.
fn sets(columns: &[[f64; 4]], layout: Layout) -> Vec<Vec<usize>> {
    let level = |column: &[f64; 4]| [0, 1, 3].iter().any(|&axis| column[axis].abs() > 1e-6);
    let set = |wanted: bool| -> Vec<usize> {
        let of = columns.iter().enumerate().filter(|(_, column)| level(column) == wanted);
        of.map(|(thruster, _)| layout.gain(thruster)).collect()
    };
    [set(true), set(false)].into_iter().filter(|set| !set.is_empty()).collect()
}

fn scale_text(vehicle: &Vehicle, scale: Scale) -> String {
    let rests = match scale {
        Scale::Thrust => "thrusters that give on average what their law says, those that push up and down alone by themselves".to_owned(),
        Scale::Mass => {
            let [surge_kg, heave_kg] = [0, 2].map(|axis| believed_mass(vehicle, axis));
            format!(
                "the mass with the water that moves along, in surge {surge_kg:.2} and in heave {heave_kg:.2} kg, taken as known"
            )
        }
    };
    format!(
        "the common factor of thrust, mass and damping is not told by poses; it rests on {rests}: were that twice as great, so were \
         all of them. Dry mass and added mass are told only as their sum"
    )
}

fn quantities(
    vehicle: &Vehicle,
    columns: &[[f64; 4]],
    layout: Layout,
    scale: Scale,
    theta: &[f64],
) -> Vec<Quantity> {
    let body = &vehicle.body;
    let mut list = Vec::new();
    for (place, &axis) in AXES.iter().enumerate() {
        let (name, turns) = (AXIS_NAMES[place], axis >= 3);
        let mass = if turns { "inertia_yaw_kg_m2".to_owned() } else { format!("mass_{name}_kg") };
        list.push(Quantity::log(&mass, &[(MASS[place], 1.0)], 1.0, believed_mass(vehicle, axis)));
        let added =
            if turns { "added_inertia_yaw_kg_m2".to_owned() } else { format!("added_mass_{name}_kg") };
        let mut added = Quantity::log(&added, &[(MASS[place], 1.0)], 1.0, body.added_mass[axis]);
        added.less = believed_mass(vehicle, axis) - body.added_mass[axis];
        list.push(added);
        let unit = |moment: &str, force: &str| if turns { moment.to_owned() } else { force.to_owned() };
        let linear = format!("linear_damping_{name}_{}", unit("n_m_s", "n_s_m"));
        list.push(Quantity::log(&linear, &[(LINEAR[place], 1.0)], 1.0, body.linear_damping[axis]));
        let quadratic = format!("quadratic_damping_{name}_{}", unit("n_m_s2", "n_s2_m2"));
        list.push(Quantity::log(&quadratic, &[(QUADRATIC[place], 1.0)], 1.0, body.quadratic_damping[axis]));
        list.push(drag(name, turns, place, theta, body.linear_damping[axis], body.quadratic_damping[axis]));
    }
    let weight_n = body.weight_n - body.buoyancy_n;
    list.push(Quantity::linear("weight_in_water_n".to_owned(), WEIGHT, WEIGHT_UNIT, Some(weight_n), 1.0));
    if scale == Scale::Mass {
        for (set, name) in sets(columns, layout).iter().zip(["thruster_gain", "thruster_gain_heave"]) {
            let mean: Vec<(usize, f64)> = set.iter().map(|&index| (index, 1.0 / set.len() as f64)).collect();
            list.push(Quantity::log(name, &mean, 1.0, 1.0));
        }
    }
    for log in 0..layout.logs {
        let named = |what: &str, unit: &str| {
            if layout.logs > 1 { format!("{what}_{}{unit}", log + 1) } else { format!("{what}{unit}") }
        };
        for (axis, what) in ["current_north", "current_east"].into_iter().enumerate() {
            let name = named(what, "_m_s");
            list.push(Quantity::linear(name, layout.current(log, axis), CURRENT_UNIT, None, 0.02));
        }
        list.push(Quantity::linear(named("thrust_delay", "_s"), layout.delay(log), DELAY_UNIT, None, 0.05));
    }
    list
}

/// Drag at a speed as robots have it, which is told well where its linear and its quadratic part are not:
/// D = D1·ν + D2·ν²,   d ln D = (D1·ν/D)·d ln D1 + (D2·ν²/D)·d ln D2
fn drag(name: &str, turns: bool, place: usize, theta: &[f64], linear: f64, quadratic: f64) -> Quantity {
    let at = if turns { DRAG_AT_RAD_S } else { DRAG_AT_M_S };
    let parts = [theta[LINEAR[place]].exp() * at, theta[QUADRATIC[place]].exp() * at * at];
    let whole = parts[0] + parts[1];
    let terms = [(LINEAR[place], parts[0] / whole), (QUADRATIC[place], parts[1] / whole)];
    let (what, unit) = if turns { ("at_0_3_rad_s", "n_m") } else { ("at_0_2_m_s", "n") };
    let mut quantity =
        Quantity::log(&format!("drag_{name}_{what}_{unit}"), &terms, 1.0, linear * at + quadratic * at * at);
    let told: f64 = terms.iter().map(|&(index, weight)| weight * theta[index]).sum();
    quantity.factor = whole / told.exp();
    quantity
}

/// A robot swims from slot to slot at about this speed, m/s. *Assumed*.
const DRAG_AT_M_S: f64 = 0.2;
/// And turns at about this rate, rad/s. *Assumed*.
const DRAG_AT_RAD_S: f64 = 0.3;
