//! From logs to an outcome.

use thiserror::Error;

use super::constants::{
    CURRENT_UNIT, DRAG, GUST, GUST_TIME, INERTIA, LATENCY_UNIT, Layout, MASS, RATIO, ROTOR, TAIL_DRAG,
    TAIL_DRAG_UNIT, Values, YAW_DRAG,
};
use super::data::{Boat, Recording};
use super::estimate::Quantity;
use super::filter::{Errors, errors};
use super::fit::{Fit, Likelihood, Problem};
use super::inference::{Covariance, WIDTH};
use super::lag::lag;
use super::log::Prepared;
use super::model::Swimming;
use super::outcome::{Constant, Module, Outcome, Residuals, Scale};
use super::prediction::{Prediction, foretold};
use super::strokes::Instant;

/// Share of each log that is held back for predictions. *Assumed*.
pub const HELD_BACK: f64 = 0.25;
/// Least length of a log, s.
pub const LEAST_S: f64 = 10.0;

/// Why nothing is identified.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum IdentifyError {
    /// Too little of it.
    #[error("{log}: poses and tails together for {has_s:.1} s: {LEAST_S} s are needed")]
    Short {
        /// Which.
        log: String,
        /// How long it is, s.
        has_s: f64,
    },
    /// Too little of it, of a kind of ROV.
    #[error("{vehicle}: swims alone for {has_s:.1} s: {LEAST_S} s are needed")]
    FewSwims {
        /// Which kind.
        vehicle: String,
        /// How long it swims alone, s.
        has_s: f64,
    },
    /// Thrusters that cannot be.
    #[error("{0}")]
    Vehicle(String),
    /// No log at all.
    #[error("no log was given")]
    Nothing,
    /// The search found no place where the information can be inverted.
    #[error("the data show nothing: is the structure at rest?")]
    Senseless,
}

/// Logs of Modboats at any θ.
#[derive(Clone)]
struct Boats<'a> {
    logs: &'a [Prepared],
    /// Bins of each that count.
    bins: Vec<usize>,
    layout: Layout,
}

impl Likelihood for Boats<'_> {
    type Setting = Vec<Vec<Instant>>;
    const COORDINATES: usize = 3;

    fn logs(&self) -> usize {
        self.logs.len()
    }

    fn elements(&self) -> usize {
        self.layout.len()
    }

    fn log_of(&self, index: usize) -> Option<usize> {
        self.layout.log_of(index)
    }

    fn setting(&self, theta: &[f64], log: usize) -> Self::Setting {
        self.logs[log].instants(LATENCY_UNIT * theta[self.layout.latency(log)])
    }

    fn sets(&self, index: usize, log: usize) -> bool {
        index == self.layout.latency(log)
    }

    fn errors(&self, theta: &[f64], setting: &Self::Setting, log: usize) -> Errors {
        let (prepared, values) = (&self.logs[log], Values::new(theta, self.layout, log));
        let impulses = prepared.impulses(&values, setting);
        let bins = &prepared.bins[..self.bins[log]];
        errors(bins, &Swimming { values: &values, impulses: &impulses }, &mut ())
    }
}

/// Identifies the constants of `boat` from all `recordings` together.
///
/// # Errors
/// [`IdentifyError`].
pub fn identify(boat: &Boat, recordings: &[Recording], scale: Scale) -> Result<Outcome, IdentifyError> {
    if recordings.is_empty() {
        return Err(IdentifyError::Nothing);
    }
    let logs: Vec<Prepared> = recordings.iter().map(|recording| Prepared::new(boat, recording)).collect();
    for (log, recording) in logs.iter().zip(recordings) {
        let has_s = log.span_s(0, log.bins.len());
        if has_s < LEAST_S {
            return Err(IdentifyError::Short { log: recording.name.clone(), has_s });
        }
    }
    let layout = Layout { modules: boat.modules(), logs: logs.len() };
    let (prior, deviation) = layout.prior(boat);
    let (fixed, known_means) = match scale {
        Scale::Rotor => (vec![ROTOR], Vec::new()),
        Scale::Thrust => {
            let slopes = (0..layout.modules).map(|module| layout.slope(module)).collect();
            (Vec::new(), vec![(slopes, boat.belief.force_slope_n_rad.ln())])
        }
    };
    let whole: Vec<usize> = logs.iter().map(|log| log.bins.len()).collect();
    let part: Vec<usize> = whole.iter().map(|&bins| (bins as f64 * (1.0 - HELD_BACK)) as usize).collect();
    let problem = |bins: Vec<usize>| Problem {
        model: Boats { logs: &logs, bins, layout },
        prior: prior.clone(),
        deviation: deviation.clone(),
        fixed: fixed.clone(),
        known_means: known_means.clone(),
    };
    let first = problem(part.clone()).search_in_stages(prior.clone(), &[RATIO, ROTOR]);
    let foretold: Vec<_> = logs
        .iter()
        .zip(&part)
        .enumerate()
        .map(|(log, (prepared, &from))| {
            foretold(prepared, &first.theta, layout, log, from, boat.belief.period_s)
        })
        .collect();
    let ends = logs.iter().zip(whole.iter().zip(&part));
    let held_back_s = ends.map(|(log, (&all, &part))| log.span_s(part, all)).sum();
    let every: Vec<_> = foretold.concat();
    let prediction = Prediction::of(&every, held_back_s);

    let spans_s: Vec<f64> = logs.iter().map(|log| log.span_s(0, log.bins.len())).collect();
    let all = problem(whole);
    let fit = all.search(first.theta);
    let covariance = Covariance::new(&all, &fit).ok_or(IdentifyError::Senseless)?;
    let theta = &fit.theta;
    let constants: Vec<Constant> = quantities(boat, layout, scale, &spans_s, theta)
        .iter()
        .map(|q| q.constant(theta, &covariance))
        .collect();
    let ratios = ratios(boat, layout).iter().map(|q| q.constant(theta, &covariance)).collect();
    let modules = modules(boat, layout, recordings, theta, &covariance);
    let elements: Vec<usize> =
        (0..layout.len()).filter(|&index| !Layout::is_noise(index) && !all.fixed.contains(&index)).collect();
    let mut notes = Vec::new();
    if !fit.converged {
        notes.push(format!("the search did not end by itself within {} steps", fit.steps));
    }
    for constant in constants.iter().filter(|constant| !constant.shown) {
        notes.push(format!("{} is hardly shown by these data", constant.name));
    }
    let residuals = Residuals::of(&fit.errors, Boats::COORDINATES);
    if residuals.correlation.iter().any(|correlation| *correlation > 0.3) {
        notes.push(
            "prediction errors hang together: the water does what the model has no word for".to_owned(),
        );
    }
    let voltages: Vec<f64> = recordings.iter().filter_map(|recording| recording.battery_v).collect();
    Ok(Outcome {
        logs: recordings.iter().map(|recording| recording.name.clone()).collect(),
        duration_s: spans_s.iter().sum(),
        fixes: logs.iter().flat_map(|log| &log.bins).map(|bin| bin.count).sum::<f64>() as usize,
        battery_v: (!voltages.is_empty()).then(|| voltages.iter().sum::<f64>() / voltages.len() as f64),
        scale,
        scale_text: scale_text(boat, scale),
        constants,
        ratios,
        modules,
        indistinct: covariance.indistinct(&elements, |index| layout.name(index, &boat.ids)),
        correlated: elements.iter().map(|&index| layout.name(index, &boat.ids)).collect(),
        correlations: covariance.correlations(&elements),
        prediction,
        residuals,
        steps: first.steps + fit.steps,
        converged: fit.converged,
        notes,
        foretold,
        errors: traces(&logs, &fit),
    })
}

fn scale_text(boat: &Boat, scale: Scale) -> String {
    let rests = match scale {
        Scale::Rotor => format!("the rotor's moment of inertia, {} kg m2", boat.rotor_inertia_kg_m2),
        Scale::Thrust => format!("the mean slope of law (2), {} N/rad", boat.belief.force_slope_n_rad),
    };
    format!(
        "the common factor of thrust, mass, inertia and drag is not told by poses; it rests on {rests}, taken as known: were that \
         twice as great, so were all of them. Dry mass and added mass are told only as their sum"
    )
}

/// `spans_s` is how long each log is.
///
/// The mean of gusts over a log of length T cannot be told from a current: σ_g·√(2τ_g/T). (i13) has it, by the σ_g and τ_g that were
/// found, which come out small where they are small by chance; so half of it is added. *Measured*: intervals then hold the truth in 19
/// of 20 cases.
fn quantities(boat: &Boat, layout: Layout, scale: Scale, spans_s: &[f64], theta: &[f64]) -> Vec<Quantity> {
    let (structure, belief) = (&boat.structure, &boat.belief);
    let share = 1.0 / layout.modules as f64;
    let slopes: Vec<(usize, f64)> = (0..layout.modules).map(|module| (layout.slope(module), share)).collect();
    let offset: Vec<(usize, f64)> = slopes.iter().copied().chain([(RATIO, 1.0)]).collect();
    let (dry_kg, dry_kg_m2) = (structure.mass_kg(belief), structure.inertia_kg_m2(belief));
    let added = |name: &str, index: usize, dry: f64| {
        let mut added = Quantity::log(name, &[(index, 1.0)], 1.0 / dry, 0.0);
        (added.less, added.belief) = (1.0, None);
        added
    };
    let log = |name, index, factor, belief| Quantity::log(name, &[(index, 1.0)], factor, belief);
    let mut list = vec![
        log("drag_sway_n_s2_m2", DRAG[0], share, belief.drag_n_s2_m2),
        log("drag_surge_n_s2_m2", DRAG[1], share, belief.drag_n_s2_m2),
        log("structure_yaw_drag_n_m_s2", YAW_DRAG, 1.0, structure.yaw_drag_n_m_s2(belief)),
        Quantity { belief: None, ..log("mass_sway_kg", MASS[0], share, 0.0) },
        Quantity { belief: None, ..log("mass_surge_kg", MASS[1], share, 0.0) },
        added("added_mass_sway", MASS[0], dry_kg),
        added("added_mass_surge", MASS[1], dry_kg),
        Quantity { belief: None, ..log("structure_inertia_kg_m2", INERTIA, 1.0, 0.0) },
        added("added_inertia", INERTIA, dry_kg_m2),
        Quantity::log("force_slope_n_rad", &slopes, 1.0, belief.force_slope_n_rad),
        Quantity::log("force_offset_n", &offset, 1.0, belief.force_offset_n),
        Quantity::linear("tail_drag_n_m_s2".to_owned(), TAIL_DRAG, TAIL_DRAG_UNIT, None, 2e-5),
        Quantity { belief: None, ..log("gust_m_s", GUST, 1.0, 0.0) },
        Quantity { belief: None, ..log("gust_memory_s", GUST_TIME, 1.0, 0.0) },
    ];
    if scale == Scale::Thrust {
        list.push(log("rotor_inertia_kg_m2", ROTOR, 1.0, boat.rotor_inertia_kg_m2));
    }
    for (number, span_s) in spans_s.iter().enumerate() {
        let named = |what: &str, unit: &str| {
            if layout.logs > 1 { format!("{what}_{}{unit}", number + 1) } else { format!("{what}{unit}") }
        };
        for (axis, what) in ["current_east", "current_north"].into_iter().enumerate() {
            let index = layout.current(number, axis);
            let mean_m_s = 0.5 * theta[GUST].exp() * (2.0 * theta[GUST_TIME].exp() / span_s).sqrt();
            let current = Quantity::linear(named(what, "_m_s"), index, CURRENT_UNIT, None, 0.01);
            list.push(Quantity { besides: mean_m_s / CURRENT_UNIT, ..current });
        }
        let index = layout.latency(number);
        list.push(Quantity::linear(named("latency", "_s"), index, LATENCY_UNIT, None, 0.05));
    }
    list
}

fn ratios(boat: &Boat, layout: Layout) -> Vec<Quantity> {
    let (structure, belief) = (&boat.structure, &boat.belief);
    let share = 1.0 / layout.modules as f64;
    let slopes = |sign: f64| (0..layout.modules).map(move |module| (layout.slope(module), sign * share));
    let over = |index: usize| -> Vec<(usize, f64)> { slopes(1.0).chain([(index, -1.0)]).collect() };
    let (mass_kg, modules) = (1.5 * structure.mass_kg(belief), layout.modules as f64);
    let drag = modules * belief.drag_n_s2_m2;
    let thrust = modules * belief.force_slope_n_rad;
    let log = Quantity::log;
    vec![
        log("drag_over_mass_sway_1_m", &[(DRAG[0], 1.0), (MASS[0], -1.0)], 1.0, drag / mass_kg),
        log("drag_over_mass_surge_1_m", &[(DRAG[1], 1.0), (MASS[1], -1.0)], 1.0, drag / mass_kg),
        log("slope_over_mass_surge_m_s2_rad", &over(MASS[1]), modules, thrust / mass_kg),
        log("slope_over_drag_sway_m2_s2_rad", &over(DRAG[0]), modules, thrust / drag),
        log("slope_over_drag_surge_m2_s2_rad", &over(DRAG[1]), modules, thrust / drag),
        log("mass_sway_over_surge", &[(MASS[0], 1.0), (MASS[1], -1.0)], 1.0, 1.0),
        log("offset_over_slope_rad", &[(RATIO, 1.0)], 1.0, belief.force_offset_n / belief.force_slope_n_rad),
    ]
}

fn modules(
    boat: &Boat,
    layout: Layout,
    recordings: &[Recording],
    theta: &[f64],
    covariance: &Covariance,
) -> Vec<Module> {
    let share = 1.0 / layout.modules as f64;
    (0..layout.modules)
        .map(|module| {
            let index = layout.slope(module);
            let slope =
                Quantity::log("force_slope_n_rad", &[(index, 1.0)], 1.0, boat.belief.force_slope_n_rad);
            let gain: Vec<(usize, f64)> = (0..layout.modules)
                .map(|other| (layout.slope(other), f64::from(u8::from(other == module)) - share))
                .collect();
            Module {
                id: boat.ids.get(module).copied().unwrap_or_default(),
                force_slope_n_rad: slope.constant(theta, covariance),
                gain: Quantity::log("gain", &gain, 1.0, 1.0).constant(theta, covariance),
                lag_s: lag(recordings, module).map(|(mean_s, error_s)| [mean_s, WIDTH * error_s]),
            }
        })
        .collect()
}

/// Errors over time; a bin that begins a stretch has none.
fn traces(logs: &[Prepared], fit: &Fit) -> Vec<Vec<(f64, [f64; 3])>> {
    let of = |(log, errors): (&Prepared, &Errors)| {
        let bins = log.bins.iter().filter(|bin| !bin.begins);
        bins.zip(errors.e.chunks_exact(3)).map(|(bin, e)| (bin.t_s, [e[0], e[1], e[2]])).collect()
    };
    logs.iter().zip(&fit.errors).map(of).collect()
}
