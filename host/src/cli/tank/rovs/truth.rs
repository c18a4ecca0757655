//! The truth of ROVs, in a log of its own: `/truth/robots` at 20 Hz, and `/truth/event` as robots let go and take hold and thrusters fail.

use std::path::{Path, PathBuf};

use runlog::flotilla::{Event, Robot, Robots as RobotsMessage};
use runlog::ros::Time;
use runlog::writer::{FileWriter, Topic};

use super::super::super::Failure;
use super::super::cannot;
use super::Robots;

/// Pause between two samples, µs.
const EVERY_US: u64 = 50_000;

/// See the module's documentation.
pub(super) struct Truth {
    path: PathBuf,
    writer: FileWriter,
    robots: Topic<RobotsMessage>,
    events: Topic<Event>,
    /// The time of the tank, µs.
    at_us: u64,
}

impl Truth {
    pub(super) fn create(path: &Path) -> Result<Self, Failure> {
        let open = || {
            let mut writer = FileWriter::create(path)?;
            let (robots, events) = (writer.topic("/truth/robots")?, writer.topic("/truth/event")?);
            Ok(Self { path: path.to_owned(), writer, robots, events, at_us: 0 })
        };
        open().map_err(|error| cannot(path, &error))
    }

    /// The state at `at_us`, the time of the tank, and what has happened since the last time.
    pub(super) fn write(&mut self, at_us: u64, robots: &mut Robots) -> Result<(), Failure> {
        self.at_us = at_us;
        self.tell(at_us.is_multiple_of(EVERY_US), robots)
    }

    fn tell(&mut self, sampled: bool, robots: &mut Robots) -> Result<(), Failure> {
        let (at_us, at_ns) = (self.at_us, self.at_us * 1000);
        let stamp = Time::from_nanos(at_ns);
        let mut write = || {
            for (module, text) in robots.happened.drain(..) {
                let event = Event { stamp: stamp.clone(), module, text };
                self.writer.write(self.events, at_ns, &event)?;
            }
            if sampled {
                self.writer.write(self.robots, at_ns, &sample(stamp.clone(), at_us, robots))?;
            }
            Ok(())
        };
        write().map_err(|error| cannot(&self.path, &error))
    }

    /// The end, with the state that it leaves.
    pub(super) fn finish(mut self, robots: &mut Robots) -> Result<(), Failure> {
        self.tell(true, robots)?;
        self.writer.finish().map_err(|error| cannot(&self.path, &error))
    }
}

/// All robots as they are.
fn sample(stamp: Time, at_us: u64, robots: &Robots) -> RobotsMessage {
    let one = |(place, &id): (usize, &u16)| {
        let (state, actuation) = (&robots.water.states()[place], &robots.actuation[place]);
        Robot {
            id,
            eta: state.eta(),
            nu: state.nu.into(),
            power_w: actuation.thrusts_n.iter().map(|&thrust_n| robots.law.power_w(thrust_n)).sum(),
            thrusts_n: actuation.thrusts_n.clone(),
            pulses_us: actuation.pulses_us.clone(),
            arrived: robots.arrived[place],
            ..Robot::default()
        }
    };
    let since_s = robots.released_s.map_or(-1.0, |released_s| at_us as f64 * 1e-6 - released_s);
    let robots = robots.ids.iter().enumerate().map(one).collect();
    RobotsMessage { stamp, t_s: since_s, moving: -1, robots, ..RobotsMessage::default() }
}
