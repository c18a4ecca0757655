//! One tail with its hardware: encoder, current sensor and motor bridge around the [`TailServo`].
//!
//! ```text
//! Reference ─→ TailServo ─ drive ─→ RestWatch ─→ Bridge ─→ PWM, in1, in2
//!                 ↑ pose, rate       │             ↑ coast when blind
//!             TurnCounter ←─ Encoder ← rests, or not: before the drive
//! ```
//!
//! Assumptions and limits: [`Tail::tick`] is called at the fixed interval of the servo's parameters (1 ms). Single
//! encoder failures are ridden through on the last pose; after [`BLIND_TICKS`] in a row the motor coasts until
//! a reading is believed again. A closed loop without eyes would run away.

use embedded_hal::digital::OutputPin;
use embedded_hal::pwm::SetDutyCycle;
use protocol::configuration::{EncoderMounting, ServoConstants};
use protocol::time::Duration;
use protocol::units::{Amperes, Radians, RadiansPerSecond};

use crate::modboat::encoder::{Encoder, Reading, TurnCounter};
use crate::modboat::kept_zero::RestWatch;
use crate::modboat::motor::{Bridge, ErrorOf};
use crate::modboat::reference::Reference;
use crate::modboat::servo::{Command, CurrentSense, ServoError, TailServo};

/// Ticks without a believable reading after which the motor coasts.
pub const BLIND_TICKS: u8 = 10;

/// The tail after one tick, for telemetry.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TailStatus {
    /// Measured pose in (−π, π]; nothing before the first reading.
    pub pose: Option<Radians>,
    /// Whole turns since the first reading.
    pub turns: i32,
    /// Measured rate.
    pub rate: RadiansPerSecond,
    /// What the servo decided; zero when blind.
    pub command: Command,
    /// Measured motor current, if the board has a sensor and it answered.
    pub current: Option<Amperes>,
    /// True while no reading is believed and the motor coasts.
    pub blind: bool,
}

/// A tail and its hardware.
#[derive(Debug)]
pub struct Tail<E, S, P, A, B> {
    encoder: E,
    sense: S,
    bridge: Bridge<P, A, B>,
    counter: TurnCounter,
    servo: TailServo,
    rest: RestWatch,
    blind_ticks: u8,
    following_error_time: Duration,
}

impl<E: Encoder, S: CurrentSense, P: SetDutyCycle, A: OutputPin, B: OutputPin> Tail<E, S, P, A, B> {
    /// From its parts. Nothing is read or driven yet.
    ///
    /// # Errors
    /// [`ServoError`] for parameters no motor can have.
    pub fn new(
        encoder: E,
        mounting: EncoderMounting,
        sense: S,
        bridge: Bridge<P, A, B>,
        parameters: &ServoConstants,
    ) -> Result<Self, ServoError> {
        Ok(Self {
            encoder,
            sense,
            bridge,
            counter: TurnCounter::new(E::COUNTS_PER_TURN, mounting, parameters.interval),
            servo: TailServo::new(parameters)?,
            rest: RestWatch::new(parameters.interval),
            blind_ticks: BLIND_TICKS,
            following_error_time: parameters.following_error_time,
        })
    }

    /// Reads the encoder once without driving: where the tail stands, at boot or after an emergency stop.
    pub fn locate(&mut self) -> Option<Radians> {
        self.look();
        if self.is_blind() { None } else { self.counter.pose() }
    }

    /// Whether the encoder knows where in the turn it is; see [`Encoder::is_homed`].
    #[must_use]
    pub fn is_homed(&self) -> bool {
        self.encoder.is_homed()
    }

    /// Whether the encoder's index came elsewhere than it should since this was asked last; see [`Encoder::take_index_fault`].
    pub fn take_index_fault(&mut self) -> bool {
        self.encoder.take_index_fault()
    }

    /// How long the tail may be away from where it should be.
    #[must_use]
    pub const fn following_error_time(&self) -> Duration {
        self.following_error_time
    }

    /// Drives without feedback until the next tick, to find the zero of the encoder.
    ///
    /// # Errors
    /// The output of the bridge that failed.
    pub fn search(&mut self, drive: f32) -> Result<(), ErrorOf<P, A, B>> {
        self.let_go();
        self.bridge.drive(drive)
    }

    /// One turn of the loop: reads, decides, drives.
    ///
    /// # Errors
    /// The output of the bridge that failed.
    pub fn tick(&mut self, reference: &Reference) -> Result<TailStatus, ErrorOf<P, A, B>> {
        self.look();
        let current = self.sense.current().ok().flatten();
        let mut status = TailStatus {
            pose: self.counter.pose(),
            turns: self.counter.turns(),
            rate: self.counter.rate(),
            current,
            blind: self.is_blind(),
            ..TailStatus::default()
        };
        match status.pose.filter(|_| !status.blind) {
            Some(pose) => {
                status.command = self.servo.tick(reference, pose, status.rate, current);
                let rests = self.rest.update(pose, reference, status.command.drive);
                self.encoder.keep_zero(rests);
                self.bridge.drive(status.command.drive)?;
            }
            None => self.coast()?,
        }
        Ok(status)
    }

    /// Lets the tail run free until the next tick.
    ///
    /// # Errors
    /// The output of the bridge that failed.
    pub fn coast(&mut self) -> Result<(), ErrorOf<P, A, B>> {
        self.let_go();
        self.bridge.coast()
    }

    /// Shorts the motor until the next tick.
    ///
    /// # Errors
    /// The output of the bridge that failed.
    pub fn brake(&mut self) -> Result<(), ErrorOf<P, A, B>> {
        self.let_go();
        self.bridge.brake()
    }

    /// Pose, turns and rate as last read.
    #[must_use]
    pub const fn counter(&self) -> &TurnCounter {
        &self.counter
    }

    /// Gives the parts back: encoder, current sensor, bridge.
    pub fn release(self) -> (E, S, Bridge<P, A, B>) {
        (self.encoder, self.sense, self.bridge)
    }

    /// It is not held: what was known of how it is driven, and that it rests, is over.
    fn let_go(&mut self) {
        self.servo.forget();
        self.rest.forget();
        self.encoder.keep_zero(false);
    }

    fn look(&mut self) {
        let reading = match self.encoder.counts() {
            Ok(counts) => self.counter.update(counts),
            Err(_) => {
                self.counter.missed();
                Reading::Rejected
            }
        };
        self.blind_ticks = match reading {
            Reading::Taken | Reading::MovedOver => 0,
            Reading::Rejected => self.blind_ticks.saturating_add(1),
        };
    }

    /// True while no reading is believed.
    #[must_use]
    pub const fn is_blind(&self) -> bool {
        self.blind_ticks >= BLIND_TICKS
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::modboat::cycle::SwimCycle;
    use crate::modboat::reference::wrap;
    use crate::modboat::schedule::{Schedule, Verdict};
    use crate::modboat::waveform::Waveform;
    use crate::plant::Rig;
    use protocol::configuration::TailLimits;
    use protocol::time::FleetInstant;
    use protocol::{Delivery, TransitionLaw};

    const SMOOTH: TransitionLaw = TransitionLaw::RestToRest { ramp: Duration(50_000) };

    /// Follows the schedule in the rig from `from_us` to `to_us`; calls `look` after every tick.
    fn follow(
        rig: &Rig,
        tail: &mut crate::plant::RigTail,
        schedule: &Schedule,
        (from_us, to_us): (u64, u64),
        mut look: impl FnMut(u64, f64, Reference, TailStatus),
    ) {
        for now in (from_us..to_us).step_by(1000) {
            let reference = schedule.reference(FleetInstant(now));
            let angle_rad = rig.angle_rad();
            let status = tail.tick(&reference).unwrap();
            look(now, angle_rad, reference, status);
            rig.step_ms();
        }
    }

    fn swim(number: u32, start: u64, from: f32, rotation: f32, amplitude: f32, t_trans: u32) -> SwimCycle {
        let waveform =
            Waveform::new(Radians(from + rotation - amplitude), Radians(amplitude), Duration(1_500_000));
        let law = if t_trans == 0 { TransitionLaw::ConstantSpeed } else { SMOOTH };
        SwimCycle::new(number, FleetInstant(start), Radians(rotation), (Duration(t_trans), law), waveform)
    }

    #[test]
    fn tracks_the_widest_swing() {
        for amplitude in [2.6, -2.6, 0.9] {
            let rig = Rig::new(0.3);
            let mut tail = rig.tail();
            let mut schedule = Schedule::new(TailLimits::default(), tail.locate().unwrap());
            let cycle = swim(1, 0, 0.3, 0.0, amplitude, 0);
            assert_eq!(schedule.offer(FleetInstant(0), cycle, Delivery::Direct), Verdict::Accepted);
            let mut worst_rad = 0.0_f64;
            follow(&rig, &mut tail, &schedule, (0, 2_000_000), |_, angle_rad, reference, status| {
                worst_rad = worst_rad.max((f64::from(reference.angle_rad) - angle_rad).abs());
                assert!(!status.command.limited && !status.command.lagging && !status.blind);
            });
            assert!(worst_rad <= 0.006, "A = {amplitude}: {worst_rad} rad");
            std::println!("A = {amplitude} rad, T = 1.5 s: largest error {worst_rad:.4} rad");
        }
    }

    /// Follows one turn and the rest after it: the greatest error on the way, and how far beyond its end the tail gets, rad.
    fn turn(rotation: f32, transition: Duration, law: TransitionLaw, lags: bool) -> [f64; 2] {
        let rig = Rig::new(-1.0);
        let mut tail = rig.tail();
        let mut schedule = Schedule::new(TailLimits::default(), tail.locate().unwrap());
        let waveform = Waveform::new(Radians(-1.0 + rotation), Radians(0.0), Duration(1_500_000));
        let cycle = SwimCycle::new(1, FleetInstant(0), Radians(rotation), (transition, law), waveform);
        assert_eq!(schedule.offer(FleetInstant(0), cycle, Delivery::Direct), Verdict::Accepted);
        let end_rad = -1.0 + f64::from(rotation);
        let (mut overshoot_rad, mut lag_rad, mut last_rad) = (0.0_f64, 0.0_f64, 0.0);
        let mut lagged = false;
        let end_us = u64::from(transition.0) + 400_000;
        follow(&rig, &mut tail, &schedule, (0, end_us), |_, angle_rad, reference, status| {
            overshoot_rad = overshoot_rad.max((angle_rad - end_rad) * f64::from(rotation.signum()));
            lag_rad = lag_rad.max(f64::from(wrap(reference.angle_rad - angle_rad as f32).abs()));
            last_rad = angle_rad;
            lagged |= status.command.lagging;
        });
        std::println!(
            "{rotation} rad in {} µs: lag {lag_rad:.4}, overshoot {overshoot_rad:.4} rad",
            transition.0
        );
        assert_eq!(lagged, lags, "{rotation}");
        assert!((last_rad - end_rad).abs() < 0.005, "{rotation}: rests at {last_rad}");
        [lag_rad, overshoot_rad]
    }

    #[test]
    fn turns_from_rest_to_rest_without_leaving_its_path() {
        for (rotation, transition) in [(3.0, 350_000), (-3.0, 350_000), (core::f32::consts::TAU, 660_000)] {
            let [lag_rad, overshoot_rad] = turn(rotation, Duration(transition), SMOOTH, false);
            assert!(lag_rad <= 0.01 && overshoot_rad <= 0.005, "{rotation}: {lag_rad}, {overshoot_rad} rad");
        }
    }

    /// What a step of speed costs.
    #[test]
    fn turns_at_constant_speed_leave_the_path_at_both_ends() {
        for (rotation, least_rad, most_rad) in
            [(3.0, 0.02, 0.06), (-3.0, 0.02, 0.06), (core::f32::consts::TAU, 0.08, 0.2)]
        {
            let off = turn(rotation, Duration(500_000), TransitionLaw::ConstantSpeed, true);
            assert!(
                off.iter().all(|off_rad| (least_rad..most_rad).contains(off_rad)),
                "{rotation}: {off:?} rad"
            );
        }
    }

    #[test]
    fn goes_round_and_round_without_losing_itself() {
        let rig = Rig::new(0.0);
        let mut tail = rig.tail();
        let mut schedule = Schedule::new(TailLimits::default(), tail.locate().unwrap());
        for k in 0..20_u32 {
            let now = u64::from(k) * 2_000_000;
            let from = schedule.pose_at_end().0;
            let cycle = swim(k + 1, now, from, 4.0, 1.0, 500_000);
            assert_eq!(
                schedule.offer(FleetInstant(now), cycle, Delivery::Direct),
                Verdict::Accepted,
                "cycle {k}"
            );
            follow(&rig, &mut tail, &schedule, (now, now + 2_000_000), |_, _, _, status| {
                assert!(!status.command.lagging);
            });
        }
        assert!((rig.angle_rad() - 80.0).abs() < 0.01, "20 rotations of 4 rad: {}", rig.angle_rad());
        assert_eq!(tail.counter().turns(), 12);
        assert_eq!(tail.counter().rejected(), 0);
    }

    #[test]
    fn rides_through_single_failures_and_coasts_when_blind() {
        let rig = Rig::new(0.5);
        let mut tail = rig.tail();
        let target = Reference::at_rest(1.5);
        assert!(!tail.tick(&target).unwrap().blind);
        rig.fail_encoder(true);
        for _ in 1..BLIND_TICKS {
            let status = tail.tick(&target).unwrap();
            assert!(!status.blind && status.command.drive > 0.0);
        }
        let status = tail.tick(&target).unwrap();
        assert!(status.blind && status.command.drive == 0.0 && rig.drive() == 0.0);
        rig.fail_encoder(false);
        assert!(!tail.tick(&target).unwrap().blind && rig.drive() > 0.0);
        assert_eq!(tail.counter().rejected(), u32::from(BLIND_TICKS));
    }

    #[test]
    fn never_drives_before_it_has_seen() {
        let rig = Rig::new(0.5);
        rig.fail_encoder(true);
        let mut tail = rig.tail();
        assert_eq!(tail.locate(), None);
        let status = tail.tick(&Reference::at_rest(1.5)).unwrap();
        assert!(status.blind && rig.drive() == 0.0);
    }
}
