//! `flotilla tank`: a laboratory in a box. The scenario's modules, Modboats or ROVs, as firmware on UDP sockets of their own, the water around them, and a
//! motion-capture server over it: what `flotilla run --radio udp --pose …` meets here is what it meets in a laboratory.

use std::net::{Ipv4Addr, SocketAddr, SocketAddrV4};
use std::path::{Path, PathBuf};

use clap::ValueEnum;
use link::udp::UdpRadio;
use modboat::bounds::{Place, centres_m};
use nalgebra::{UnitQuaternion, Vector3};
use pose::axes::{Axes, Pose, Unit, Up};
use pose::frame::Label;
use pose::natnet::message::{COMMAND_PORT, DATA_PORT, GROUP, Version};
use pose::natnet::server::{NatNetServer, Settings, Transport};
use pose::qtm::server::QtmServer;
use pose::server::Server;
use pose::time::HostInstant;
use pose::vrpn::server::VrpnServer;
use record::PoseSample;
use runlog::flotilla::{BoatState, Contact};
use runlog::ros::{Header, JointState, Time};
use runlog::writer::{FileWriter, Topic};
use sim::TailState;
use sim::lab::{CameraParameters, Cameras, Fault, LabError};
use sim::mocap::MocapParameters;
use sim::module::{Boat, SimModule, TICK};
use sim::tank::Tank;

use super::module::{MODBOAT_REPORTS, radio, resolve, setup};
use super::poses::LabArguments;
use super::real_time::{Live, live};
use super::run::fleet;
use super::{Failure, bad, could, tell};
use crate::answer::reconfigure::PowerKind;
use crate::run::experiment::water;
use crate::run::scenario::{PoseParameters, Scenario, UpAxis};

mod rovs;

/// What a server and its network take at least, s. *Assumed.*
const LATENCY_S: f64 = 0.004;

#[derive(clap::Args)]
#[command(
    after_help = "Example, in two terminals:\n  flotilla tank holonomic-1 --mocap natnet --latency 0.02 --jitter 0.01 --loss 0.02\n  \
                        flotilla run holonomic-1 --radio udp --pose natnet:127.0.0.1 --up z\n\n\
                        ROVs:\n  flotilla tank i-to-l --mocap qtm --latency 0.03 --current 0.05,0 --fail-thruster 3,1@80\n  \
                        flotilla reconfigure i-to-l --criterion energy --radio udp --pose qtm:127.0.0.1 --up z\n\n\
                        Faults: KIND[:BODIES]@START[+LENGTH], such as blind@20+10, swap:1,2@30, clock:3600@15;\n\
                        there are blind, dead, frozen, swap:A,B, lost:A, away:A, nan:A, clock:SECONDS, slow and doubled"
)]
pub(super) struct Arguments {
    /// A scenario file, or one that comes with the program, as for `flotilla run`
    #[arg(default_value = super::run::DEFAULT)]
    scenario: String,
    /// Where the host listens for modules
    #[arg(long, value_name = "ADDRESS", default_value = "127.0.0.1:4870")]
    host: String,
    /// The fleet's key file [default: flotilla/fleet.key in $XDG_CONFIG_HOME or ~/.config]
    #[arg(long, value_name = "FILE")]
    key: Option<PathBuf>,
    /// Which modules there are and where each sits; of ROVs, which body is whose [default: 1, 2, … in the scenario's order]
    #[arg(long, value_name = "FILE")]
    roster: Option<PathBuf>,
    /// Seed of everything random, instead of the scenario's
    #[arg(long)]
    seed: Option<u64>,
    /// What the motion capture speaks
    #[arg(long, value_enum, default_value_t = Protocol::Natnet)]
    mocap: Protocol,
    /// Where it listens [default: the protocol's own port on this machine alone]
    #[arg(long, value_name = "ADDRESS")]
    listen: Option<SocketAddr>,
    /// Version of NatNet
    #[arg(long, value_name = "VERSION", default_value = "4.1", value_parser = ["3.0", "3.1", "4.0", "4.1"])]
    natnet: String,
    /// Let NatNet send to the group 239.255.42.99 out of the interface with this address
    #[arg(long, value_name = "ADDRESS")]
    multicast: Option<Ipv4Addr>,
    #[command(flatten)]
    lab: LabArguments,
    /// Mean time from a frame's exposure to its sending, s [default: 0.004, or the scenario's if that is more]
    #[arg(long, value_name = "SECONDS")]
    latency: Option<f64>,
    /// Greatest deviation from it, s
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0)]
    jitter: f64,
    /// Share of frames that are lost, instead of the scenario's
    #[arg(long, value_name = "SHARE")]
    loss: Option<f64>,
    /// Noise of each coordinate, m, instead of the scenario's
    #[arg(long, value_name = "METRES")]
    noise: Option<f64>,
    /// Noise of each turn, rad, instead of the scenario's
    #[arg(long, value_name = "RADIANS")]
    attitude_noise: Option<f64>,
    /// Frames a second, instead of the scenario's
    #[arg(long, value_name = "HERTZ")]
    rate: Option<f64>,
    /// Velocity of the water about ROVs along the scenario's x and y, m/s
    #[arg(long, value_name = "X,Y", value_parser = clap::value_parser!(rovs::Current), allow_hyphen_values = true)]
    current: Option<rovs::Current>,
    /// A thruster of an ROV that fails, from 1, and when: seconds after the water lets go
    #[arg(long, value_name = "ROBOT,THRUSTER@SECONDS", value_parser = clap::value_parser!(rovs::Dead))]
    fail_thruster: Option<rovs::Dead>,
    /// What thrust costs, of ROVs
    #[arg(long, value_enum, default_value_t = PowerKind::Table)]
    power: PowerKind,
    /// The server's clock less this machine's, s
    #[arg(long, value_name = "SECONDS", default_value_t = 86_400.0, allow_hyphen_values = true)]
    clock: f64,
    /// What goes wrong, and when; may be repeated
    #[arg(long, value_name = "FAULT", value_parser = clap::value_parser!(Fault))]
    fault: Vec<Fault>,
    /// End by itself after so many seconds
    #[arg(long, value_name = "SECONDS")]
    duration: Option<f64>,
    /// Write the truth to this log: pose and contacts; of ROVs, poses, thrusts and dockings
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// What a motion capture speaks.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Protocol {
    /// As OptiTrack Motive
    Natnet,
    /// As Qualisys Track Manager
    Qtm,
    /// As a VRPN server
    Vrpn,
}

pub(super) fn main(arguments: &Arguments) -> Result<(), Failure> {
    if let Some(seconds) = arguments.duration.filter(|seconds| !(*seconds > 0.0 && *seconds <= 1e7)) {
        return Err(Failure::Bad(format!("--duration = {seconds} s: must lie between 0 and 10000000")));
    }
    if rovs::is_meant(&arguments.scenario) {
        return rovs::main(arguments);
    }
    if arguments.current.is_some() || arguments.fail_thruster.is_some() {
        return Err(Failure::Bad(
            "--current and --fail-thruster belong to ROVs; [tank] has the current of Modboats".to_owned(),
        ));
    }
    let scenario = Scenario::open(&arguments.scenario).map_err(bad)?;
    let mut boats = boats(arguments, &scenario)?;
    let labels: Vec<Label> =
        boats.ids.iter().map(|id| Label::new(i32::from(*id), &format!("module-{id}"))).collect();
    let server = serve(arguments, &labels)?;
    let axes = axes(arguments, &scenario.pose);
    let seed = arguments.seed.unwrap_or(scenario.seed);
    let mut cameras = cameras(arguments, &scenario.mocap, seed, axes, labels)?;
    tell(&format!("{} modules, host at {}", boats.modules.len(), arguments.host));
    tell(&format!("motion capture on {}", server.address()));
    let mut truth = arguments.out.as_deref().map(Truth::create).transpose()?;
    film(arguments, server, &mut cameras, |live| {
        boats.step(live)?;
        if let Some(truth) = &mut truth {
            truth.write(live.tick.now.0, &boats)?;
        }
        Ok(boats.poses())
    })?;
    truth.map_or(Ok(()), Truth::finish)?;
    boats.judge()
}

/// Real time until told to end: `step` lets the bodies live through a tick, and tells where they are.
fn film(
    arguments: &Arguments,
    mut server: Box<dyn Server>,
    cameras: &mut Cameras,
    mut step: impl FnMut(&Live) -> Result<Vec<Pose>, Failure>,
) -> Result<(), Failure> {
    live(arguments.duration, |live| {
        let poses = step(&live)?;
        let now = HostInstant(std::time::Duration::from_micros(live.tick.now.0));
        let tick_s = live.tick.now.as_secs_f64();
        cameras.look(tick_s, &poses);
        server.set_clock_ahead_ns((cameras.clock_ahead_s(tick_s) * 1e9) as i64);
        while let Some(frame) = cameras.poll(tick_s) {
            server.send(now, &frame);
        }
        if live.hears && !cameras.is_dead(tick_s) {
            server.poll(now);
        }
        Ok(())
    })
}

/// Modboats on sockets of their own, in one water.
struct Boats {
    ids: Vec<u16>,
    modules: Vec<SimModule<UdpRadio>>,
    tails: Vec<TailState>,
    water: Tank,
    positions_m: Vec<[f64; 2]>,
}

impl Boats {
    fn step(&mut self, &Live { tick, hears }: &Live) -> Result<(), Failure> {
        if tick.gap.is_some() {
            self.water.skip(tick.now.as_secs_f64() - f64::from(TICK.as_secs_f32()));
        }
        for (module, tail) in self.modules.iter_mut().zip(&mut self.tails) {
            module.live(tick.now, hears).map_err(could)?;
            module.actuate(tail);
        }
        self.water.step(f64::from(TICK.as_secs_f32()), &self.tails);
        Ok(())
    }

    /// Says whether tails touched.
    fn judge(&self) -> Result<(), Failure> {
        let least_mm = 1e3 * self.water.least_clearance_m();
        match self.water.contacts() {
            [] if least_mm.is_finite() => {
                tell(&format!("no contacts; tails never closer than {least_mm:.1} mm"));
            }
            [] => tell("no contacts; no two tails can meet"),
            [first, ..] => {
                let (count, t_s) = (self.water.contacts().len(), first.t_s);
                let (a, b) = (self.ids[first.modules.0], self.ids[first.modules.1]);
                return Err(Failure::Could(format!(
                    "{count} tail contacts, the first between modules {a} and {b} at {t_s:.2} s of the tank"
                )));
            }
        }
        Ok(())
    }

    /// Every module in the world.
    fn poses(&self) -> Vec<Pose> {
        let PoseSample { position_m, heading_rad, .. } = self.water.pose();
        let attitude = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), heading_rad);
        let centres = centres_m(&self.positions_m, Place { position_m, heading_rad });
        centres.map(|[x, y]| Pose { position: Vector3::new(x, y, 0.0), attitude }).collect()
    }
}

/// The truth, in a log of its own: `/truth/state` at 20 Hz, `/truth/tails` at 50 Hz, `/truth/contact` as they come.
struct Truth {
    path: PathBuf,
    writer: FileWriter,
    states: Topic<BoatState>,
    tails: Topic<JointState>,
    contacts: Topic<Contact>,
    told: usize,
}

impl Truth {
    fn create(path: &Path) -> Result<Self, Failure> {
        let open = || {
            let mut writer = FileWriter::create(path)?;
            let (states, tails) = (writer.topic("/truth/state")?, writer.topic("/truth/tails")?);
            let contacts = writer.topic("/truth/contact")?;
            Ok(Self { path: path.to_owned(), writer, states, tails, contacts, told: 0 })
        };
        open().map_err(|error| cannot(path, &error))
    }

    /// The state at `at_us`, the time of the tank.
    fn write(&mut self, at_us: u64, boats: &Boats) -> Result<(), Failure> {
        let at_ns = at_us * 1000;
        let stamp = Time::from_nanos(at_ns);
        let mut write = || {
            if at_us.is_multiple_of(50_000) {
                let PoseSample { position_m, heading_rad, velocity_m_s, yaw_rate_rad_s, .. } =
                    boats.water.pose();
                let stamp = stamp.clone();
                let state = BoatState { stamp, position_m, heading_rad, velocity_m_s, yaw_rate_rad_s };
                self.writer.write(self.states, at_ns, &state)?;
            }
            if at_us.is_multiple_of(20_000) {
                let header = Header { stamp: stamp.clone(), frame_id: "structure".to_owned() };
                let tails = JointState {
                    header,
                    name: boats.ids.iter().map(|id| format!("tail_{id}")).collect(),
                    position: boats.tails.iter().map(|tail| tail.angle_rad).collect(),
                    velocity: boats.tails.iter().map(|tail| tail.rate_rad_s).collect(),
                    ..JointState::default()
                };
                self.writer.write(self.tails, at_ns, &tails)?;
            }
            while let Some(contact) = boats.water.contacts().get(self.told) {
                let contact = Contact {
                    stamp: stamp.clone(),
                    index: self.told as u32,
                    began_s: contact.t_s,
                    modules: [contact.modules.0, contact.modules.1].map(|module| boats.ids[module]),
                    overlap_m: -contact.clearance_m,
                };
                self.writer.write(self.contacts, at_ns, &contact)?;
                self.told += 1;
            }
            Ok(())
        };
        write().map_err(|error| cannot(&self.path, &error))
    }

    fn finish(self) -> Result<(), Failure> {
        self.writer.finish().map_err(|error| cannot(&self.path, &error))
    }
}

fn cannot(path: &Path, error: &std::io::Error) -> Failure {
    Failure::Could(format!("{}: cannot write: {error}", path.display()))
}

fn boats(arguments: &Arguments, scenario: &Scenario) -> Result<Boats, Failure> {
    let host = resolve(&arguments.host)?;
    let roster = fleet(arguments.roster.as_deref(), scenario)?;
    let seats = roster.seats(&scenario.structure).map_err(bad)?;
    let ids: Vec<u16> = seats.into_iter().map(|id| id.0).collect();
    let seed = arguments.seed.unwrap_or(scenario.seed);
    let module = |&id: &u16| {
        let setup = setup(arguments.key.as_deref(), id, MODBOAT_REPORTS)?;
        let motors = seed.wrapping_add(u64::from(id));
        let boat =
            Boat::new(&scenario.modboat, &scenario.motor, scenario.start.tail_rad, motors).map_err(bad)?;
        SimModule::new(&setup, boat, radio(None, host)?, host).map_err(bad)
    };
    let modules = ids.iter().map(module).collect::<Result<Vec<_>, Failure>>()?;
    let water = water(scenario, seed).map_err(bad)?;
    let positions_m = scenario.structure.positions_m(scenario.modboat.pitch_m);
    Ok(Boats { tails: vec![TailState::default(); ids.len()], ids, modules, water, positions_m })
}

/// The laboratory: as the scenario says, z up where it does not.
fn axes(arguments: &Arguments, pose: &PoseParameters) -> Axes {
    let mut parameters = PoseParameters { up: pose.up.or(Some(UpAxis::Z)), ..pose.clone() };
    arguments.lab.apply(&mut parameters);
    let standard = if arguments.mocap == Protocol::Qtm { Unit::Millimetre } else { Unit::Metre };
    parameters.axes(standard).unwrap_or(Axes::new(Up::Z, standard))
}

fn cameras(
    arguments: &Arguments,
    mocap: &MocapParameters,
    seed: u64,
    axes: Axes,
    labels: Vec<Label>,
) -> Result<Cameras, Failure> {
    let parameters = CameraParameters {
        rate_hz: arguments.rate.unwrap_or(mocap.rate_hz),
        position_noise_m: arguments.noise.unwrap_or(mocap.position_noise_m),
        attitude_noise_rad: arguments.attitude_noise.unwrap_or(mocap.heading_noise_rad),
        latency_s: arguments.latency.unwrap_or(mocap.latency_s.max(LATENCY_S)),
        jitter_s: arguments.jitter,
        loss: arguments.loss.unwrap_or(mocap.loss),
        clock_ahead_s: arguments.clock,
    };
    Cameras::new(parameters, axes, labels, arguments.fault.clone(), seed ^ 0x3C0D).map_err(
        |error| match error {
            LabError::Parameter(error) => Failure::Bad(format!("--{error}")),
            LabError::Fault(error) => Failure::Bad(format!("--fault: {error}")),
        },
    )
}

fn serve(arguments: &Arguments, labels: &[Label]) -> Result<Box<dyn Server>, Failure> {
    let port = match arguments.mocap {
        Protocol::Natnet => COMMAND_PORT,
        Protocol::Qtm => pose::qtm::packet::PORT,
        Protocol::Vrpn => pose::vrpn::message::PORT,
    };
    let address = arguments.listen.unwrap_or_else(|| SocketAddrV4::new(Ipv4Addr::LOCALHOST, port).into());
    Ok(match arguments.mocap {
        Protocol::Natnet => {
            let version = match arguments.natnet.as_str() {
                "3.0" => Version::V3_0,
                "3.1" => Version::V3_1,
                "4.0" => Version::V4_0,
                _ => Version::V4_1,
            };
            let transport = match arguments.multicast {
                None => Transport::Unicast,
                Some(interface) => {
                    let group = SocketAddrV4::new(GROUP, DATA_PORT);
                    Transport::Multicast { group, interface }
                }
            };
            let settings = Settings { version, transport, clock_ahead_ns: (arguments.clock * 1e9) as i64 };
            Box::new(NatNetServer::new(address, settings, labels).map_err(bad)?)
        }
        Protocol::Qtm => Box::new(QtmServer::new(address, labels).map_err(bad)?),
        Protocol::Vrpn => Box::new(VrpnServer::new(address, labels).map_err(bad)?),
    })
}
