//! `flotilla simulate`: a filter. One JSON request a line in, the motion of an ROV under that wrench (or those pulses)
//! out.

use std::fmt;

use nalgebra::Vector6;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserializer, Error, MapAccess, Visitor};
use serde::{Deserialize, Serialize};

use super::{Failure, bad, filter};
use crate::run::vehicles;
use firmware::rov::thruster::{law, t200};
use protocol::units::{PulseMicros, Volts};
use reconfiguration::body::Body;
use reconfiguration::vehicle::{self, Vehicle};
use rov::cluster::Cluster;
use rov::configuration_matrix::ConfigurationMatrix;
use rov::dynamics::{Dynamics, State};
use rov::response::response;

/// Greatest time that is taken, s, and how many of them.
const TIME_MAX_S: f64 = 3600.0;
const TIMES_MAX: usize = 10_000;

#[derive(clap::Args)]
#[command(after_help = "Example:\n  echo '{\"eta\":[0,0,0,0,0,0],\"nu\":[0,0,0,0,0,0],\
                        \"tau\":[10,0,0,0,0,0],\"at_s\":[1,5,20]}' | flotilla simulate bluerov1\n\n\
                        North-east-down; body x forward, y right, z down; ZYX Euler angles within (-pi, pi]; \"nu\" and\n\
                        \"tau\" at the body origin. Instead of \"tau\", \"pwm_us\" with one pulse a thruster and \"voltage_v\".\n\
                        \"vehicle\" in a request goes before VEHICLE: a name, or an object with mass_kg, weight_n,\n\
                        buoyancy_n, r_g_m, r_b_m, inertia_kg_m2 (about the centre of gravity), added_mass,\n\
                        linear_damping and quadratic_damping.")]
pub(super) struct Arguments {
    /// For requests that name no vehicle: one that comes with the program, or a TOML file
    #[arg(value_name = "VEHICLE")]
    vehicle: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Request {
    vehicle: Option<Described>,
    eta: Vec<f64>,
    nu: Vec<f64>,
    tau: Option<Vec<f64>>,
    pwm_us: Option<Vec<f64>>,
    voltage_v: Option<f64>,
    at_s: Vec<f64>,
}

/// A vehicle that comes with the program, by its name, or all of a body.
enum Described {
    Named(Box<Vehicle>),
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

#[derive(Serialize)]
struct Reply {
    states: Vec<Sample>,
}

#[derive(Serialize)]
struct Sample {
    t_s: f64,
    eta: [f64; 6],
    nu: [f64; 6],
}

pub(super) fn main(arguments: &Arguments) -> Result<(), Failure> {
    let vehicle = match &arguments.vehicle {
        Some(name) => Some(vehicles::open(name).map_err(bad)?),
        None => None,
    };
    filter::run(|_, line| answer(line, vehicle.as_ref()))
}

fn answer(line: &str, usual: Option<&Vehicle>) -> Result<String, String> {
    let request: Request = filter::read(line)?;
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
    let eta = six("eta", &request.eta, [("m", 1e6), ("rad", 1e3)])?;
    let nu = six("nu", &request.nu, [("m/s", 1e3), ("rad/s", 1e3)])?;
    let tau = match (request.tau, request.pwm_us, request.voltage_v) {
        (Some(tau), None, None) => six("tau", &tau, [("N", 1e6), ("N·m", 1e6)])?.into(),
        (None, Some(pulses_us), Some(voltage_v)) => pushed(vehicle.as_ref(), &pulses_us, voltage_v)?,
        _ => return Err("takes either tau, or pwm_us and voltage_v".to_owned()),
    };
    if request.at_s.len() > TIMES_MAX {
        return Err(format!("at_s has {} times: at most {TIMES_MAX}", request.at_s.len()));
    }
    for (index, t_s) in request.at_s.iter().enumerate() {
        if !(0.0..=TIME_MAX_S).contains(t_s) {
            return Err(format!("at_s[{index}] = {t_s} s: must lie between 0 and {TIME_MAX_S}"));
        }
    }
    let dynamics = Dynamics::new(&Cluster::of(&body)).map_err(|error| format!("vehicle: {error}"))?;
    let states = response(&dynamics, &State::from_eta(&eta, &nu), &tau, &request.at_s)
        .map_err(|error| error.to_string())?;
    let sample = |(&t_s, state): (&f64, &State)| Sample { t_s, eta: state.eta(), nu: state.nu.into() };
    let reply = Reply { states: request.at_s.iter().zip(&states).map(sample).collect() };
    serde_json::to_string(&reply).map_err(|error| error.to_string())
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
fn pushed(vehicle: Option<&Vehicle>, pulses_us: &[f64], voltage_v: f64) -> Result<Vector6<f64>, String> {
    let Some(vehicle) = vehicle.filter(|vehicle| !vehicle.thrusters.is_empty()) else {
        return Err("pwm_us: this vehicle has no thrusters".to_owned());
    };
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
