//! Measurement of battery voltage and current, on two analogue inputs.
//!
//! U = code·U_ref/4096, low-passed, times the factors of the configuration (`firmware::provision`)
//!
//! | symbol | meaning | value | unit |
//! |---|---|---|---|
//! | U_ref | reference: the board's 3.3 V | 3.3 | V |
//! | τ | of the battery: its ripple under a motor is not its charge | 0.05, *assumed* | s |
//! | τ | of the current: longer than a period of the motor's PWM, shorter than the tail's | 0.005, *assumed* | s |
//!
//! A conversion takes 96 cycles of 48 MHz, 2 µs (RP2350 datasheet, section 12.4.3): both are waited for in the tick.
//!
//! Assumptions and limits: the 3.3 V are good to some percent, and with them the voltages. Divide by so much that a full battery
//! stays below 3.3 V. A conversion that fails, which the converter reports, changes nothing.

use core::convert::Infallible;
use core::sync::atomic::{AtomicU32, Ordering};

use embassy_rp::Peri;
use embassy_rp::adc::{Adc, AdcPin, Blocking, Channel, Config};
use embassy_rp::gpio::Pull;
use embassy_rp::peripherals::ADC;
use firmware::modboat::servo::CurrentSense;
use firmware::module::Supply;
use firmware::provision;
use protocol::configuration::SupplyConstants;
use protocol::time::Duration;
use protocol::units::{Amperes, Volts};

use crate::low_pass::LowPass;

/// One step of the converter.
const VOLTS_PER_CODE: f32 = 3.3 / 4096.0;

/// τ of the battery, µs.
const BATTERY_US: u32 = 50_000;

/// τ of the current, µs.
const CURRENT_US: u32 = 5_000;

/// One input, where something is wired to it.
struct Input {
    channel: Channel<'static>,
    filter: LowPass,
}

impl Input {
    /// What it shows now, if it ever showed anything.
    fn measure(&mut self, converter: &mut Adc<'static, Blocking>) -> Option<Volts> {
        match converter.blocking_read(&mut self.channel) {
            Ok(code) => Some(self.filter.update(f32::from(code) * VOLTS_PER_CODE)),
            Err(_) => self.filter.get(),
        }
        .map(Volts)
    }
}

/// Measures battery voltage and current.
pub struct PowerSensor {
    converter: Adc<'static, Blocking>,
    battery: Option<Input>,
    current: Option<Input>,
    constants: SupplyConstants,
}

impl PowerSensor {
    /// Measured once every `interval`. A pin that nothing is wired to, by the configuration, is left as it is.
    #[must_use]
    pub fn new(
        converter: Peri<'static, ADC>,
        battery: Peri<'static, impl AdcPin + 'static>,
        current: Peri<'static, impl AdcPin + 'static>,
        constants: SupplyConstants,
        interval: Duration,
    ) -> Self {
        let filter = |time_constant_us| LowPass::new(time_constant_us, interval.0);
        let battery = (constants.volts_per_volt > 0.0)
            .then(|| Input { channel: Channel::new_pin(battery, Pull::None), filter: filter(BATTERY_US) });
        let current = (constants.amperes_per_volt > 0.0)
            .then(|| Input { channel: Channel::new_pin(current, Pull::None), filter: filter(CURRENT_US) });
        Self { converter: Adc::new_blocking(converter, Config::default()), battery, current, constants }
    }

    /// Measures both. What is not wired is no number for the battery, and zero for the current.
    pub fn measure(&mut self) -> Supply {
        let Self { converter, battery, current, constants } = self;
        let battery = battery.as_mut().and_then(|input| input.measure(converter));
        let current = current.as_mut().and_then(|input| input.measure(converter));
        let current = current.and_then(|input| provision::current(constants, input));
        MOTOR_CURRENT
            .store(current.map_or(f32::NAN, |Amperes(amperes)| amperes).to_bits(), Ordering::Relaxed);
        Supply {
            battery: battery.map_or(Volts(f32::NAN), |input| provision::battery(constants, input)),
            current: current.unwrap_or_default(),
        }
    }
}

/// The current as last measured, A; no number where nothing is wired. The converter belongs to the sensor, the servo to the tail:
/// this is how one tells the other.
static MOTOR_CURRENT: AtomicU32 = AtomicU32::new(f32::NAN.to_bits());

/// The current of the motor, as the [`PowerSensor`] measured it last.
#[derive(Clone, Copy, Debug)]
pub struct MotorCurrent;

impl CurrentSense for MotorCurrent {
    type Error = Infallible;

    fn current(&mut self) -> Result<Option<Amperes>, Infallible> {
        let amperes = f32::from_bits(MOTOR_CURRENT.load(Ordering::Relaxed));
        Ok((!amperes.is_nan()).then_some(Amperes(amperes)))
    }
}
