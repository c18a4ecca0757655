//! `flotilla probe`: what a motion-capture system sends, and what is likely wrong with it.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use nalgebra::{Unit as Direction, UnitQuaternion, Vector3};
use pose::address::Address;
use pose::axes::{Axes, Pose, Unit, Up, heading_rad};
use pose::clock::Clock;
use pose::frame::{Body, Frame, Label};
use pose::source::{Link, Source, Status};
use pose::time::HostInstant;
use serde::Serialize;

use super::poses::LabArguments;
use super::{Failure, bad, could, signal, written};
use crate::run::lab::standard_unit;
use crate::run::roster::Roster;
use crate::run::scenario::{PoseParameters, Scenario};

#[derive(clap::Args)]
#[command(after_help = "Examples:\n  flotilla probe natnet:192.168.1.10 --up y\n  \
                        flotilla probe qtm:192.168.1.20 --roster fleet.toml --scenario my-boats.toml\n  flotilla probe vrpn:boat@tracker --json")]
pub(super) struct Arguments {
    /// natnet:HOST[:PORT], qtm:HOST[:PORT] or vrpn:[BODY,…@]HOST[:PORT]
    #[arg(value_name = "SOURCE")]
    source: Address,
    #[command(flatten)]
    lab: LabArguments,
    /// How the world lies in the laboratory: [pose] of this scenario
    #[arg(long, value_name = "SCENARIO")]
    scenario: Option<String>,
    /// Which body is which module
    #[arg(long, value_name = "FILE")]
    roster: Option<PathBuf>,
    /// How long to listen, s
    #[arg(long, value_name = "SECONDS", default_value_t = 5.0)]
    duration: f64,
    /// This machine's address in the network of a NatNet server
    #[arg(long, value_name = "ADDRESS")]
    interface: Option<std::net::Ipv4Addr>,
    /// Print the findings as JSON
    #[arg(long)]
    json: bool,
}

/// What was found.
#[derive(Debug, Serialize)]
struct Findings {
    source: String,
    server: Option<String>,
    protocol: Option<String>,
    transport: Option<String>,
    frames: u64,
    /// Hz.
    rate_hz: f64,
    /// Share of frames that are missing between those that came.
    lost_share: f64,
    /// Least time from exposure to arrival, s; null where the protocol does not show it.
    latency_s: Option<f64>,
    /// What frames take beyond that: mean and greatest, s.
    jitter_mean_s: f64,
    jitter_most_s: f64,
    bodies: Vec<BodyFindings>,
    /// Modules of the roster whose body was not seen.
    unseen: Vec<String>,
    /// What is likely wrong.
    advice: Vec<String>,
}

#[derive(Debug, Serialize)]
struct BodyFindings {
    body: String,
    tracked_share: f64,
    /// As the server says, in its unit and axes.
    position: [f64; 3],
    /// In the world; null where the axis that points up is not known.
    world_m: Option<[f64; 3]>,
    heading_rad: Option<f64>,
    module: Option<u16>,
}

/// What was seen of one body.
#[derive(Debug, Default)]
struct Seen {
    frames: u64,
    tracked: u64,
    last: Option<Body>,
}

/// What was heard.
#[derive(Default)]
struct Heard {
    frames: u64,
    first_s: f64,
    last_s: f64,
    numbers: Vec<u32>,
    bodies: BTreeMap<Label, Seen>,
    clock: Clock,
    late_sum_s: f64,
    late_most_s: f64,
}

impl Heard {
    fn take(&mut self, frame: &Frame, arrived: HostInstant) {
        if self.frames == 0 {
            self.first_s = arrived.seconds();
        }
        (self.frames, self.last_s) = (self.frames + 1, arrived.seconds());
        self.numbers.extend(frame.number);
        if let Some(reading) = self.clock.read(frame.captured, arrived) {
            self.late_sum_s += reading.late_s;
            self.late_most_s = self.late_most_s.max(reading.late_s);
        }
        for body in &frame.bodies {
            let seen = self.bodies.entry(body.label.clone()).or_default();
            seen.frames += 1;
            if body.tracked && body.position.iter().all(|number| number.is_finite()) {
                seen.tracked += 1;
                seen.last = Some(body.clone());
            }
        }
    }

    /// Share of numbers that are missing. A server that sends every eighth frame of its cameras has lost none.
    fn lost_share(&self) -> f64 {
        let steps = self.numbers.windows(2).map(|pair| pair[1].wrapping_sub(pair[0]));
        let mut steps: Vec<u32> = steps.filter(|step| (1..10_000).contains(step)).collect();
        steps.sort_unstable();
        let Some(&usual) = steps.get(steps.len() / 2) else { return 0.0 };
        let sent: f64 = steps.iter().map(|step| (f64::from(*step) / f64::from(usual)).round().max(1.0)).sum();
        1.0 - steps.len() as f64 / sent
    }
}

pub(super) fn main(arguments: &Arguments) -> Result<(), Failure> {
    if !(0.1..=3600.0).contains(&arguments.duration) {
        return Err(Failure::Bad(format!(
            "--duration = {} s: must lie between 0.1 and 3600",
            arguments.duration
        )));
    }
    let mut parameters = match &arguments.scenario {
        Some(scenario) => Scenario::open(scenario).map_err(bad)?.pose,
        None => PoseParameters::default(),
    };
    arguments.lab.apply(&mut parameters);
    let axes = parameters.axes(standard_unit(&arguments.source));
    let roster = match &arguments.roster {
        Some(path) => Some(Roster::read(path).map_err(bad)?),
        None => None,
    };
    let options = pose::address::Options { interface: arguments.interface, ..Default::default() };
    let mut source = arguments.source.open(options).map_err(bad)?;
    signal::watch();
    let heard = listen(source.as_mut(), arguments.duration)?;
    let findings = findings(arguments, source.as_ref(), &heard, axes.as_ref(), roster.as_ref())?;
    let mut out = std::io::stdout().lock();
    let told = match arguments.json {
        true => {
            serde_json::to_writer_pretty(&mut out, &findings).map_err(Into::into).and_then(|()| writeln!(out))
        }
        false => print(&mut out, &findings),
    };
    written(told.and_then(|()| out.flush()))?;
    match (heard.frames, findings.unseen.is_empty()) {
        (0, _) => Err(Failure::Could(format!("{}: no frames in {} s", findings.source, arguments.duration))),
        (_, false) => Err(Failure::Could(format!("never seen: {}", findings.unseen.join(", ")))),
        _ => Ok(()),
    }
}

fn listen(source: &mut dyn Source, duration_s: f64) -> Result<Heard, Failure> {
    let (began, mut heard) = (Instant::now(), Heard::default());
    while began.elapsed().as_secs_f64() < duration_s && !signal::STOP.load(Ordering::Relaxed) {
        let now = HostInstant(began.elapsed());
        while let Some(arrival) = source.poll(now).map_err(could)? {
            heard.take(&arrival.frame, arrival.arrived);
        }
        if let Some(exchange) = source.exchange() {
            heard.clock.exchanged(&exchange);
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    Ok(heard)
}

fn findings(
    arguments: &Arguments,
    source: &dyn Source,
    heard: &Heard,
    axes: Option<&Axes>,
    roster: Option<&Roster>,
) -> Result<Findings, Failure> {
    let by_number = matches!(arguments.source, Address::NatNet(_));
    let entries = roster.map(|roster| roster.bodies(by_number)).transpose().map_err(bad)?;
    let bodies = heard.bodies.iter().map(|(label, seen)| {
        let said = seen.last.as_ref().map(|body| Pose {
            position: body.position,
            attitude: UnitQuaternion::from_quaternion(body.attitude),
        });
        let world = said.and_then(|said| Some(axes?.to_world(&said)));
        BodyFindings {
            body: label.to_string(),
            tracked_share: seen.tracked as f64 / seen.frames.max(1) as f64,
            position: said.map_or([f64::NAN; 3], |said| said.position.into()),
            world_m: world.map(|world| world.position.into()),
            heading_rad: world.map(|world| heading_rad(&world.attitude)),
            module: entries.as_ref().and_then(|entries| Some(entries.of(label)?.module)),
        }
    });
    let labels: Vec<Label> = heard.bodies.keys().cloned().collect();
    let unseen = entries.iter().flat_map(|entries| entries.missing(&labels));
    let unseen = unseen.map(|entry| format!("module {} (body {})", entry.module, entry.body)).collect();
    let status = source.status();
    let server = status.server.as_ref();
    let span_s = heard.last_s - heard.first_s;
    Ok(Findings {
        source: arguments.source.to_string(),
        server: server.map(|server| server.application.clone()),
        protocol: server.map(|server| server.protocol.clone()),
        transport: server.map(|server| server.transport.clone()),
        frames: heard.frames,
        rate_hz: if span_s > 0.0 { heard.frames.saturating_sub(1) as f64 / span_s } else { 0.0 },
        lost_share: heard.lost_share(),
        latency_s: heard.clock.least_delay_s().map(|(delay_s, _)| delay_s),
        jitter_mean_s: heard.late_sum_s / heard.frames.max(1) as f64,
        jitter_most_s: heard.late_most_s,
        bodies: bodies.collect(),
        unseen,
        advice: advice(status, heard, axes),
    })
}

/// What is likely wrong.
fn advice(status: &Status, heard: &Heard, axes: Option<&Axes>) -> Vec<String> {
    let mut advice = Vec::new();
    if let Some(trouble) = &status.trouble {
        advice.push(format!("the connection: {trouble}"));
    }
    if heard.frames == 0 {
        advice.push(match status.link {
            Link::Connecting => "the server does not answer: is it on, is its streaming on, is it in this network, does a firewall \
                                 keep its port shut?"
                .to_owned(),
            Link::Connected | Link::Streaming => "connected, and no frames come: is it capturing? With multicast: is --interface this \
                                                  machine's address in the server's network?"
                .to_owned(),
        });
        return advice;
    }
    let seen: Vec<&Body> = heard.bodies.values().filter_map(|seen| seen.last.as_ref()).collect();
    if heard.bodies.is_empty() {
        advice.push(
            "frames come without bodies: switch on the streaming of rigid bodies (6DOF) at the server"
                .to_owned(),
        );
        return advice;
    }
    if seen.is_empty() {
        advice.push(
            "no body is tracked: are all markers in view, are the bodies defined and enabled?".to_owned(),
        );
        return advice;
    }
    let farthest = seen.iter().map(|body| body.position.norm()).fold(0.0, f64::max);
    match axes.map(|axes| axes.unit) {
        Some(Unit::Metre) | None if farthest > 100.0 => {
            advice.push(format!(
                "a body is {farthest:.0} from the origin: these look like millimetres (--unit mm)"
            ));
        }
        Some(Unit::Millimetre) if farthest < 20.0 => {
            advice.push(format!(
                "no body is further than {farthest:.2} from the origin: these look like metres (--unit m)"
            ));
        }
        _ => {}
    }
    // What floats is level: the axis that is up keeps its direction whatever the heading.
    let tilt = |axis: Direction<Vector3<f64>>| {
        let tilts = seen.iter().map(|body| {
            let turned = UnitQuaternion::from_quaternion(body.attitude) * axis;
            turned.angle(&axis)
        });
        tilts.fold(0.0, f64::max)
    };
    let (y, z) = (tilt(Vector3::y_axis()), tilt(Vector3::z_axis()));
    match axes.map(|axes| axes.up) {
        None if y < 0.2 && z > 0.4 => advice.push("bodies turn about y: it points up (--up y)".to_owned()),
        None if z < 0.2 && y > 0.4 => advice.push("bodies turn about z: it points up (--up z)".to_owned()),
        None => advice.push("say which axis points up: --up z or --up y".to_owned()),
        Some(Up::Z) if z > 0.4 && y < 0.2 => {
            advice.push("bodies are turned about y, and level if that points up: --up y?".to_owned());
        }
        Some(Up::Y) if y > 0.4 && z < 0.2 => {
            advice.push("bodies are turned about z, and level if that points up: --up z?".to_owned());
        }
        _ => {}
    }
    if heard.lost_share() > 0.05 {
        advice.push(format!(
            "{:.0} % of frames are lost: a wireless network, or one that is too busy?",
            100.0 * heard.lost_share()
        ));
    }
    advice
}

fn print(out: &mut impl Write, findings: &Findings) -> std::io::Result<()> {
    let Findings { source, server, protocol, transport, .. } = findings;
    let said = [server, protocol, transport].into_iter().flatten().cloned().collect::<Vec<_>>().join(", ");
    writeln!(out, "{source}: {}", if said.is_empty() { "no server" } else { &said })?;
    let latency =
        findings.latency_s.map_or("not shown by this protocol".to_owned(), |s| format!("{:.1} ms", 1e3 * s));
    writeln!(
        out,
        "  frames     {}, {:.1} Hz, {:.1} % lost; latency {latency}, jitter {:.1} ms on average, {:.1} ms at most",
        findings.frames,
        findings.rate_hz,
        100.0 * findings.lost_share,
        1e3 * findings.jitter_mean_s,
        1e3 * findings.jitter_most_s
    )?;
    for body in &findings.bodies {
        let [x, y, z] = body.position;
        write!(out, "  body       {}: {x:.3} {y:.3} {z:.3}", body.body)?;
        if let (Some([x, y, z]), Some(heading_rad)) = (body.world_m, body.heading_rad) {
            write!(out, " → world {x:.3} {y:.3} {z:.3} m, heading {heading_rad:.3} rad")?;
        }
        write!(out, ", tracked {:.0} %", 100.0 * body.tracked_share)?;
        match body.module {
            Some(module) => writeln!(out, ", module {module}")?,
            None => writeln!(out)?,
        }
    }
    findings.unseen.iter().try_for_each(|unseen| writeln!(out, "  unseen     {unseen}"))?;
    findings.advice.iter().try_for_each(|advice| writeln!(out, "  advice     {advice}"))
}
