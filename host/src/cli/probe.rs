//! `flotilla probe`: what a motion-capture system sends, and what is likely wrong with it.

use std::io::Write;
use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use nalgebra::UnitQuaternion;
use pose::address::Address;
use pose::axes::{Axes, Pose, Unit, Up, heading_rad};
use pose::feed::Feed;
use pose::frame::Label;
use pose::gate::{Gate, Limits};
use pose::proposal::Proposal;
use pose::source::Link;
use pose::time::HostInstant;
use serde::Serialize;

use super::poses::{LabArguments, open};
use super::{Failure, bad, could, signal, written};
use crate::run::lab::standard_unit;
use crate::run::roster::Roster;
use crate::run::scenario::{PoseParameters, Scenario};

#[derive(clap::Args)]
#[command(after_help = "Examples:\n  flotilla probe natnet:192.168.1.10 --up y\n  \
                        flotilla probe qtm:192.168.1.20 --roster fleet.toml --scenario my-boats.toml\n  flotilla probe vrpn:boat@tracker --json")]
pub(super) struct Arguments {
    /// natnet:HOST[:PORT], qtm:HOST[:PORT], vrpn:[BODY,…@]HOST[:PORT] or ros2:[BODY=]/TOPIC[,…][@FRAME]
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
    /// Share of frames that are missing between those that came; null where frames have no numbers.
    lost_share: Option<f64>,
    /// Least time from exposure to arrival, s; null where the protocol does not show it.
    latency_s: Option<f64>,
    /// What half of the frames take beyond that at most, s.
    late_p50_s: f64,
    /// And 99 of 100.
    late_p99_s: f64,
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
    position: Option<[f64; 3]>,
    /// In the world; null where the axis that points up is not known.
    world_m: Option<[f64; 3]>,
    heading_rad: Option<f64>,
    module: Option<u16>,
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
    let source = open(&arguments.source, arguments.interface)?;
    let any = Axes::new(Up::Z, standard_unit(&arguments.source));
    let mut feed = Feed::new(source, Gate::new(axes.unwrap_or(any), Limits::default()));
    signal::watch();
    let proposal = listen(&mut feed, arguments.duration)?;
    let findings = findings(arguments, &feed, &proposal, axes.as_ref(), roster.as_ref())?;
    let mut out = std::io::stdout().lock();
    let told = match arguments.json {
        true => {
            serde_json::to_writer_pretty(&mut out, &findings).map_err(Into::into).and_then(|()| writeln!(out))
        }
        false => print(&mut out, &findings),
    };
    written(told.and_then(|()| out.flush()))?;
    match (findings.frames, findings.unseen.is_empty()) {
        (0, _) => Err(Failure::Could(format!("{}: no frames in {} s", findings.source, arguments.duration))),
        (_, false) => Err(Failure::Could(format!("never seen: {}", findings.unseen.join(", ")))),
        _ => Ok(()),
    }
}

/// Listens; the places of bodies, for what the axes probably are.
fn listen(feed: &mut Feed, duration_s: f64) -> Result<Proposal, Failure> {
    let (began, mut proposal) = (Instant::now(), Proposal::default());
    while began.elapsed().as_secs_f64() < duration_s && !signal::STOP.load(Ordering::Relaxed) {
        while feed.poll(HostInstant(began.elapsed())).map_err(could)?.is_some() {
            feed.figures()
                .bodies()
                .values()
                .filter_map(|body| body.position.as_ref())
                .for_each(|p| proposal.count(p));
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    Ok(proposal)
}

fn findings(
    arguments: &Arguments,
    feed: &Feed,
    proposal: &Proposal,
    axes: Option<&Axes>,
    roster: Option<&Roster>,
) -> Result<Findings, Failure> {
    let by_number = matches!(arguments.source, Address::NatNet(_));
    let entries = roster
        .map(|roster| roster.bodies(by_number, &roster.ids().collect::<Vec<_>>()))
        .transpose()
        .map_err(bad)?;
    let (figures, status) = (feed.figures(), feed.status());
    // Names come after the first frames: a number alone is the body that is named later.
    let is_named = |number: Option<i32>| {
        figures.bodies().keys().any(|label| label.name.is_some() && label.number == number)
    };
    let seen = figures.bodies().iter().filter(|(label, _)| label.name.is_some() || !is_named(label.number));
    let bodies = seen.clone().map(|(label, seen)| {
        let said = seen.position.zip(seen.attitude).map(|(position, attitude)| Pose {
            position,
            attitude: UnitQuaternion::from_quaternion(attitude),
        });
        let world = said.and_then(|said| Some(axes?.to_world(&said)));
        BodyFindings {
            body: label.to_string(),
            tracked_share: seen.tracked as f64 / seen.frames.max(1) as f64,
            position: said.map(|said| said.position.into()),
            world_m: world.map(|world| world.position.into()),
            heading_rad: world.map(|world| heading_rad(&world.attitude)),
            module: entries.as_ref().and_then(|entries| Some(entries.of(label)?.module)),
        }
    });
    let labels: Vec<Label> = seen.clone().map(|(label, _)| label.clone()).collect();
    let unseen = entries.iter().flat_map(|entries| entries.missing(&labels));
    let unseen = unseen.map(|entry| format!("module {} (body {})", entry.module, entry.body)).collect();
    let server = status.server.as_ref();
    Ok(Findings {
        source: arguments.source.to_string(),
        server: server.map(|server| server.application.clone()),
        protocol: server.map(|server| server.protocol.clone()),
        transport: server.map(|server| server.transport.clone()),
        frames: figures.frames(),
        rate_hz: figures.rate_hz(),
        lost_share: figures.missing_share(),
        latency_s: feed.gate().clock().least_delay_s().map(|(delay_s, _)| delay_s),
        late_p50_s: figures.late_s(0.5),
        late_p99_s: figures.late_s(0.99),
        bodies: bodies.collect(),
        unseen,
        advice: advice(feed, proposal, axes),
    })
}

/// What is likely wrong.
fn advice(feed: &Feed, proposal: &Proposal, axes: Option<&Axes>) -> Vec<String> {
    let (figures, status) = (feed.figures(), feed.status());
    let mut advice = Vec::new();
    if let Some(trouble) = &status.trouble {
        advice.push(format!("the connection: {trouble}"));
    }
    let positions = || figures.bodies().values().filter_map(|body| body.position);
    let one = if figures.frames() == 0 {
        Some(match status.link {
            Link::Connecting => {
                "the server does not answer: is it on, is its streaming on, is it in this network, does a firewall keep its \
                 port shut?"
            }
            Link::Connected | Link::Streaming => {
                "connected, and no frames come: is it capturing? With multicast: is --interface this machine's address in the \
                 server's network?"
            }
        })
    } else if figures.bodies().is_empty() {
        Some("frames come without bodies: switch on the streaming of rigid bodies (6DOF) at the server")
    } else if positions().next().is_none() {
        Some("no body is tracked: are all markers in view, are the bodies defined and enabled?")
    } else {
        None
    };
    if let Some(one) = one {
        advice.push(one.to_owned());
        return advice;
    }
    let farthest = positions().map(|position| position.norm()).fold(0.0, f64::max);
    match (axes.map(|axes| axes.unit), proposal.unit()) {
        (None | Some(Unit::Metre), Some(Unit::Millimetre)) => {
            advice.push(format!(
                "a body is {farthest:.0} from the origin: these look like millimetres (--unit mm)"
            ));
        }
        (Some(Unit::Millimetre), Some(Unit::Metre)) => {
            advice.push(format!(
                "no body is further than {farthest:.2} from the origin: these look like metres (--unit m)"
            ));
        }
        _ => {}
    }
    let word = |up| if up == Up::Z { "z" } else { "y" };
    match (axes.map(|axes| axes.up), proposal.up()) {
        (None, Some(up)) => {
            advice.push(format!("heights differ least along {0}: it points up (--up {0})", word(up)));
        }
        (None, None) => advice.push("say which axis points up: --up z or --up y".to_owned()),
        (Some(said), Some(up)) if said != up => {
            advice.push(format!("heights differ least along {0}: does it point up (--up {0})?", word(up)));
        }
        _ => {}
    }
    if let Some(share) = figures.missing_share().filter(|share| *share > 0.05) {
        advice.push(format!(
            "{:.0} % of frames are lost: a wireless network, or one that is too busy?",
            100.0 * share
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
    let lost = findings
        .lost_share
        .map_or("share lost not known".to_owned(), |share| format!("{:.1} % lost", 100.0 * share));
    writeln!(
        out,
        "  frames     {}, {:.1} Hz, {lost}; latency {latency}; half at most {:.0} ms later, 99 % at most {:.0} ms",
        findings.frames,
        findings.rate_hz,
        1e3 * findings.late_p50_s,
        1e3 * findings.late_p99_s
    )?;
    for body in &findings.bodies {
        write!(out, "  body       {}", body.body)?;
        if let Some([x, y, z]) = body.position {
            write!(out, ": {x:.3} {y:.3} {z:.3}")?;
        }
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
