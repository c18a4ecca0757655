//! A remote ROV: its thrusts, from the pulses that it reports over the radio.
//!
//! The pulses last reported hold until the next report. After [`SILENCE`] without one the propellers are taken to
//! stand: a module that lives reports, and one that does not puts out no pulse.

use protocol::RovTelemetry;
use protocol::time::{Duration, FleetInstant};
use protocol::units::Volts;

use super::RovActuation;
use super::propellers::Propellers;

/// Time without a report after which no propeller turns any more. *Assumed.*
pub const SILENCE: Duration = Duration(500_000);

/// One remote ROV.
#[derive(Clone, Debug)]
pub struct RemoteRov {
    propellers: Propellers,
    battery: Volts,
    stepped: FleetInstant,
    /// Arrival of the newest report, and the time it was measured.
    newest: Option<(FleetInstant, FleetInstant)>,
}

impl RemoteRov {
    /// One whose thrusters are reversed where the flag says so, not heard of yet.
    #[must_use]
    pub fn new(reversed: &[bool]) -> Self {
        let propellers = Propellers::new(reversed);
        Self { propellers, battery: Volts(0.0), stepped: FleetInstant(0), newest: None }
    }

    /// Takes in a report. An older one, or the same again, changes nothing.
    pub fn report(&mut self, telemetry: &RovTelemetry, arrival: FleetInstant) {
        // A module that does not know the fleet time yet reports zero.
        let unknown = telemetry.at == FleetInstant(0);
        if !unknown && self.newest.is_some_and(|(_, measured)| telemetry.at <= measured) {
            return;
        }
        self.step(arrival.max(self.stepped));
        self.newest = Some((arrival, telemetry.at));
        self.battery = telemetry.battery;
        self.propellers.set_pulses(telemetry.pulses.iter().copied());
    }

    /// Lets time pass until `now`; times before the last are ignored.
    pub fn step(&mut self, now: FleetInstant) {
        if self.newest.is_none_or(|(arrival, _)| now.since(arrival) > SILENCE) {
            self.propellers.set_pulses([]);
        }
        self.propellers.step(now.as_secs_f64() - self.stepped.min(now).as_secs_f64(), self.battery);
        self.stepped = self.stepped.max(now);
    }

    /// Thrusts along each thruster's axis, N, as of the last [`step`](Self::step).
    #[must_use]
    pub fn thrusts_n(&self) -> &[f64] {
        self.propellers.thrusts_n()
    }

    /// Writes what the water feels of it, as of the last [`step`](Self::step), and the pulses that it reported.
    pub fn actuate(&self, actuation: &mut RovActuation) {
        actuation.write(&self.propellers, self.propellers.pulses());
    }
}

#[cfg(test)]
mod tests {
    use firmware::rov::thruster::law;
    use protocol::units::{Amperes, Newtons, PulseMicros};
    use protocol::{Faults, ModuleState};

    use super::*;

    fn report(at: u64, newtons: f32) -> RovTelemetry {
        RovTelemetry {
            at: FleetInstant(at),
            state: ModuleState::Executing,
            cycle: 1,
            pulses: [law::pulse(Newtons(newtons), Volts(15.0)), PulseMicros(1500.0)].into_iter().collect(),
            battery: Volts(15.0),
            current: Amperes(1.0),
            faults: Faults::default(),
        }
    }

    #[test]
    fn thrust_is_what_the_reports_say_and_ends_with_them() {
        let mut rov = RemoteRov::new(&[false, false]);
        rov.step(FleetInstant(1_000_000));
        assert_eq!(rov.thrusts_n().len(), 2);
        for ms in (1_000..2_000).step_by(20) {
            rov.report(&report(ms * 1_000, 8.0), FleetInstant(ms * 1_000 + 500));
            rov.report(&report(ms * 1_000 - 20_000, -8.0), FleetInstant(ms * 1_000 + 600));
            rov.step(FleetInstant(ms * 1_000 + 10_000));
        }
        assert!((rov.thrusts_n()[0] - 8.0).abs() < 0.01, "{:?} N", rov.thrusts_n());
        assert!(rov.thrusts_n()[1].abs() < 1e-12);
        for ms in 2_000..3_500 {
            rov.step(FleetInstant(ms * 1_000));
            let silent = ms > 1_980 + 500;
            assert!(silent || (rov.thrusts_n()[0] - 8.0).abs() < 0.01, "{ms} ms: {:?} N", rov.thrusts_n());
        }
        assert!(rov.thrusts_n()[0] < 0.01, "ten time constants of silence: {:?} N", rov.thrusts_n());
    }
}
