//! Motion of an ROV under a wrench, thrusts or pulses: `flotilla simulate`.

use std::fmt;

use firmware::rov::thruster::{law, t200};
use nalgebra::Vector6;
use protocol::units::{PulseMicros, Volts};
use reconfiguration::body::Body;
use reconfiguration::vehicle::{self, Vehicle};
use rov::cluster::Cluster;
use rov::configuration_matrix::ConfigurationMatrix;
use rov::dynamics::{Dynamics, State};
use rov::response::response;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserializer, Error, MapAccess, Visitor};
use serde::{Deserialize, Serialize};

/// Greatest time that is taken, s, and how many of them.
const TIME_MAX_S: f64 = 3600.0;
const TIMES_MAX: usize = 10_000;
/// Greatest thrust that is taken, N.
const THRUST_MAX_N: f64 = 1e4;

/// A request of `flotilla simulate`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Request {
    /// Which vehicle, instead of the usual one.
    pub vehicle: Option<Described>,
    /// Pose η: x, y, z (m, NED) and ZYX Euler angles (rad).
    pub eta: Vec<f64>,
    /// Velocity ν at the body origin, m/s and rad/s.
    pub nu: Vec<f64>,
    /// Wrench τ at the body origin, N and N·m.
    pub tau: Option<Vec<f64>>,
    /// Or one pulse a thruster, µs,
    pub pwm_us: Option<Vec<f64>>,
    /// and the battery's voltage, V.
    pub voltage_v: Option<f64>,
    /// When the motion is asked for, s.
    pub at_s: Vec<f64>,
}

/// A vehicle that comes with the program, by its name, or all of a body.
pub enum Described {
    /// By its name.
    Named(Box<Vehicle>),
    /// All of it; it has no thrusters.
    Body(Box<Body>),
}

impl<'de> Deserialize<'de> for Described {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct NameOrBody;
        impl<'de> Visitor<'de> for NameOrBody {
            type Value = Described;

            fn expecting(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
                to.write_str("a name or an object")
            }

            fn visit_str<E: Error>(self, name: &str) -> Result<Described, E> {
                let vehicle = Vehicle::built_in(name).ok_or_else(|| E::custom(vehicle::there_are(name)))?;
                Ok(Described::Named(Box::new(vehicle)))
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Described, A::Error> {
                let body = Body::deserialize(MapAccessDeserializer::new(map))?;
                Ok(Described::Body(Box::new(body)))
            }
        }
        deserializer.deserialize_any(NameOrBody)
    }
}

/// The motion.
#[derive(Serialize)]
pub struct Reply {
    /// In the order of the times that were asked for.
    pub states: Vec<Sample>,
}

/// The state at one time.
#[derive(Serialize)]
pub struct Sample {
    /// When, s.
    pub t_s: f64,
    /// Pose, Euler angles within (−π, π].
    pub eta: [f64; 6],
    /// Velocity.
    pub nu: [f64; 6],
}

/// The motion that a request asks for, of its own vehicle or else of the `usual` one.
///
/// # Errors
/// Which number cannot be, and what may be.
pub fn reply(request: Request, usual: Option<&Vehicle>) -> Result<Reply, String> {
    let (body, vehicle) = match (request.vehicle, usual) {
        (Some(Described::Named(vehicle)), _) => (vehicle.body.clone(), Some(*vehicle)),
        (Some(Described::Body(body)), _) => {
            body.validate().map_err(|error| format!("vehicle: {error}"))?;
            (*body, None)
        }
        (None, Some(vehicle)) => (vehicle.body.clone(), Some(vehicle.clone())),
        (None, None) => {
            return Err("vehicle: neither the request nor the command line says which".to_owned());
        }
    };
    let start = state(&request.eta, &request.nu)?;
    let tau = match (request.tau, request.pwm_us, request.voltage_v) {
        (Some(tau), None, None) => wrench(&tau)?,
        (None, Some(pulses_us), Some(voltage_v)) => pushed(vehicle.as_ref(), &pulses_us, voltage_v)?,
        _ => return Err("takes either tau, or pwm_us and voltage_v".to_owned()),
    };
    check_times(&request.at_s)?;
    let states =
        response(&dynamics(&body)?, &start, &tau, &request.at_s).map_err(|error| error.to_string())?;
    let sample = |(&t_s, state): (&f64, &State)| Sample { t_s, eta: state.eta(), nu: state.nu.into() };
    Ok(Reply { states: request.at_s.iter().zip(&states).map(sample).collect() })
}

/// The law of motion of a body.
///
/// # Errors
/// What is wrong with it.
pub fn dynamics(body: &Body) -> Result<Dynamics, String> {
    Dynamics::new(&Cluster::of(body)).map_err(|error| format!("vehicle: {error}"))
}

/// Pose and velocity as a state.
///
/// # Errors
/// Which number cannot be.
pub fn state(eta: &[f64], nu: &[f64]) -> Result<State, String> {
    let eta = six("eta", eta, [("m", 1e6), ("rad", 1e3)])?;
    let nu = six("nu", nu, [("m/s", 1e3), ("rad/s", 1e3)])?;
    Ok(State::from_eta(&eta, &nu))
}

/// A wrench at the body origin.
///
/// # Errors
/// Which number cannot be.
pub fn wrench(tau: &[f64]) -> Result<Vector6<f64>, String> {
    Ok(six("tau", tau, [("N", 1e6), ("N·m", 1e6)])?.into())
}

/// Whether these are times that are taken.
///
/// # Errors
/// Which is not, or that there are too many.
pub fn check_times(at_s: &[f64]) -> Result<(), String> {
    if at_s.len() > TIMES_MAX {
        return Err(format!("at_s has {} times: at most {TIMES_MAX}", at_s.len()));
    }
    match at_s.iter().position(|t_s| !(0.0..=TIME_MAX_S).contains(t_s)) {
        Some(index) => Err(format!("at_s[{index}] = {} s: must lie between 0 and {TIME_MAX_S}", at_s[index])),
        None => Ok(()),
    }
}

/// The wrench of thrusters that push so much along their axes, N: τ = T F   (9)
///
/// # Errors
/// A vehicle without thrusters, another number of thrusts, or one beyond ±1e4 N.
pub fn thrust(vehicle: Option<&Vehicle>, thrusts_n: &[f64]) -> Result<Vector6<f64>, String> {
    let vehicle = with_thrusters("thrust_n", vehicle)?;
    let count = vehicle.thrusters.len();
    if thrusts_n.len() != count {
        return Err(format!("thrust_n has {} thrusts for {count} thrusters", thrusts_n.len()));
    }
    if let Some(index) = thrusts_n.iter().position(|value| !value.is_finite() || value.abs() > THRUST_MAX_N) {
        let value = thrusts_n[index];
        return Err(format!("thrust_n[{index}] = {value:e} N: must be at most {THRUST_MAX_N:e} in size"));
    }
    let matrix = ConfigurationMatrix::of_vehicle(vehicle).map_err(|error| error.to_string())?;
    Ok(matrix.wrench(thrusts_n).into())
}

fn with_thrusters<'v>(key: &str, vehicle: Option<&'v Vehicle>) -> Result<&'v Vehicle, String> {
    let fit = vehicle.filter(|vehicle| !vehicle.thrusters.is_empty());
    fit.ok_or_else(|| format!("{key}: this vehicle has no thrusters"))
}

/// Six numbers within limits: three in the first unit, three in the second.
fn six(key: &str, values: &[f64], limits: [(&str, f64); 2]) -> Result<[f64; 6], String> {
    let six: [f64; 6] =
        values.try_into().map_err(|_| format!("{key} has {} numbers: must be 6", values.len()))?;
    for (index, value) in six.iter().enumerate() {
        let (unit, limit) = limits[index / 3];
        if !value.is_finite() || value.abs() > limit {
            return Err(format!("{key}[{index}] = {value:e} {unit}: must be at most {limit:e} in size"));
        }
    }
    Ok(six)
}

/// The wrench of thrusters that have read these pulses long enough: τ = T F(pulse, voltage)   (9)
///
/// # Errors
/// A vehicle without thrusters, another number of pulses, or one outside of what was measured.
pub fn pushed(vehicle: Option<&Vehicle>, pulses_us: &[f64], voltage_v: f64) -> Result<Vector6<f64>, String> {
    let vehicle = with_thrusters("pwm_us", vehicle)?;
    let thrusters = &vehicle.thrusters;
    if pulses_us.len() != thrusters.len() {
        return Err(format!("pwm_us has {} pulses for {} thrusters", pulses_us.len(), thrusters.len()));
    }
    let (low_v, high_v) = (f64::from(t200::VOLTAGE_MIN_V), f64::from(t200::VOLTAGE_MAX_V));
    if !(low_v..=high_v).contains(&voltage_v) {
        return Err(format!("voltage_v = {voltage_v} V: must lie between {low_v} and {high_v}"));
    }
    let (low_us, high_us) = (f64::from(t200::PULSE_MIN_US), f64::from(t200::PULSE_MAX_US));
    let mut thrusts_n = Vec::with_capacity(thrusters.len());
    for (index, (thruster, &pulse_us)) in thrusters.iter().zip(pulses_us).enumerate() {
        if !(low_us..=high_us).contains(&pulse_us) {
            return Err(format!("pwm_us[{index}] = {pulse_us} µs: must lie between {low_us} and {high_us}"));
        }
        let thrust_n = f64::from(law::thrust(PulseMicros(pulse_us as f32), Volts(voltage_v as f32)).0);
        // With its wires swapped the propeller turns the other way.
        thrusts_n.push(if thruster.reversed { -thrust_n } else { thrust_n });
    }
    let matrix = ConfigurationMatrix::of_vehicle(vehicle).map_err(|error| error.to_string())?;
    Ok(matrix.wrench(&thrusts_n).into())
}
