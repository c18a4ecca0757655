//! `flotilla simulate`: a filter. One JSON request a line in, the motion of an ROV under that wrench (or those pulses)
//! out.

use super::{Failure, bad, filter};
use crate::answer::response::{Request, reply};
use crate::run::vehicles;

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

pub(super) fn main(arguments: &Arguments) -> Result<(), Failure> {
    let vehicle = match &arguments.vehicle {
        Some(name) => Some(vehicles::open(name).map_err(bad)?),
        None => None,
    };
    filter::run(|_, line| {
        let request: Request = filter::read(line)?;
        serde_json::to_string(&reply(request, vehicle.as_ref())?).map_err(|error| error.to_string())
    })
}
