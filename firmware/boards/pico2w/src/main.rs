//! A Modboat on a Raspberry Pi Pico 2 W.
//!
//! | GPIO | pin of the board | what | electrical |
//! |---|---|---|---|
//! | GP10 | 14 | motor bridge: PWM | 20 kHz |
//! | GP11 | 15 | motor bridge: in1 | 10 kΩ to 3.3 V; high with in2 low: counter-clockwise |
//! | GP12 | 16 | motor bridge: in2 | 10 kΩ to 3.3 V |
//! | GP13 | 17 | index: hall switch | low over the magnet, pulled up |
//! | GP14 | 19 | encoder: A | pulled up |
//! | GP15 | 20 | encoder: B | pulled up |
//! | GP16 | 21 | status LED | high: lit; a resistor and a LED to ground |
//! | GP26 | 31 | battery | 0 to 3.3 V, from a divider |
//! | GP27 | 32 | motor current | 0 to 3.3 V, from the bridge's sensor |
//! | GP23, 24, 25, 29 | none | radio | on the board |
//!
//! The board's own LED, which hangs on the radio, shows what the status LED shows as soon as the radio works.
//!
//! ```text
//! boot → random numbers, configuration → Modboat → control, in its interrupt      radio, network, in thread mode
//!                        └ none → blink
//! ```
//!
//! In reset the pins are not driven, and the two resistors pull both inputs of the bridge high: a TB6612FNG then brakes the motor, whatever
//! PWM does. They win over the pull-downs of the chip, tens of kΩ, and of the bridge, 200 kΩ. Once it runs, the program lets the tail
//! free until it knows where it is, which it does at once after a reset by the watchdog if the tail rested before.
//!
//! Assumptions and limits: 20 kHz is above hearing and within what a TB6612FNG takes (100 kHz). The bridge's standby pin is wired high.
//! What `memory.x`, the motor and the battery are is said at the top of the tree.
#![no_std]
#![no_main]

use embassy_executor::Spawner;
use embassy_rp::Peri;
use embassy_rp::gpio::{Level, Output};
use embassy_rp::peripherals::{PIN_10, PIN_11, PIN_12, PIN_13, PIN_14, PIN_15, PIO1, PWM_SLICE5};
use embassy_rp::pwm::Pwm;
use firmware::modboat::Modboat;
use firmware::modboat::motor::Bridge;
use firmware::provision::{self, NotProvisioned};
use protocol::Configuration;
use protocol::configuration::Robot;
use protocol::time::Duration;
use rp2350::encoder::IndexedEncoder;
use rp2350::link::Link;
use rp2350::status_led::{Light, StatusLed, Switch};
use rp2350::supply::{MotorCurrent, PowerSensor};
use rp2350::watchdog::{Scratch, Watchdog};
use rp2350::{configuration, control, priority, random, timer};

use crate::motor::MotorPwm;

mod motor;
mod radio;

/// Pulses of the motor bridge a second.
const MOTOR_PWM_HZ: f32 = 20_000.0;

static LINK: Link = Link::new();
static BOARD_LED: Switch = Switch::new();

type Boat = Modboat<IndexedEncoder, MotorCurrent, MotorPwm, Output<'static>, Output<'static>>;

/// What moves the tail and what sees it.
struct TailParts {
    slice: Peri<'static, PWM_SLICE5>,
    pwm: Peri<'static, PIN_10>,
    in1: Peri<'static, PIN_11>,
    in2: Peri<'static, PIN_12>,
    index: Peri<'static, PIN_13>,
    counter: Peri<'static, PIO1>,
    a: Peri<'static, PIN_14>,
    b: Peri<'static, PIN_15>,
    scratch: Scratch,
}

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let p = embassy_rp::init(embassy_rp::config::Config::default());
    let watchdog = Watchdog::start(p.WATCHDOG);
    let status_led =
        StatusLed::new([Light::Pin(Output::new(p.PIN_16, Level::Low)), Light::Switch(&BOARD_LED)]);
    let drawn = random::draw(p.TRNG);
    let parts = TailParts {
        slice: p.PWM_SLICE5,
        pwm: p.PIN_10,
        in1: p.PIN_11,
        in2: p.PIN_12,
        index: p.PIN_13,
        counter: p.PIO1,
        a: p.PIN_14,
        b: p.PIN_15,
        scratch: watchdog.scratch(),
    };
    let provisioned = configuration::read().map_err(NotProvisioned::from).and_then(|configuration| {
        let (boat, interval) = boat(&configuration, drawn.boot, parts)?;
        Ok((configuration, boat, interval))
    });
    let Ok((configuration, boat, interval)) = provisioned else { control::blink(status_led, watchdog).await };
    let power = PowerSensor::new(p.ADC, p.PIN_26, p.PIN_27, configuration.supply, interval);
    // Its only instance, so the token is there.
    priority::start().spawn(swim(boat, power, status_led, watchdog, interval).unwrap());
    let radio = radio::Parts {
        power: p.PIN_23,
        data: p.PIN_24,
        select: p.PIN_25,
        clock: p.PIN_29,
        block: p.PIO0,
        dma: p.DMA_CH0,
    };
    radio::run(spawner, radio, &configuration.network, drawn.seed).await
}

/// The Modboat of a configuration, and how often it ticks.
fn boat(
    configuration: &Configuration,
    boot: [u8; 12],
    parts: TailParts,
) -> Result<(Boat, Duration), NotProvisioned> {
    let Robot::Modboat(constants) = &configuration.robot else {
        return Err(NotProvisioned::Kind(configuration.kind()));
    };
    let interval = provision::servo_interval(&constants.servo)?;
    let quadrature = provision::quadrature(&constants.encoder)?;
    let TailParts { slice, pwm, in1, in2, index, counter, a, b, scratch } = parts;
    let encoder = IndexedEncoder::new(counter, a, b, index, quadrature, scratch);
    let settings = timer::settings(MOTOR_PWM_HZ).expect("the timer counts at 150 MHz");
    let pwm = MotorPwm(Pwm::new_output_a(slice, pwm, settings));
    let bridge = Bridge::new(pwm, Output::new(in1, Level::Low), Output::new(in2, Level::Low));
    let boat = provision::modboat(configuration, boot, encoder, MotorCurrent, bridge)?;
    Ok((boat, interval))
}

#[embassy_executor::task]
async fn swim(
    boat: Boat,
    power: PowerSensor,
    status_led: StatusLed,
    watchdog: Watchdog,
    interval: Duration,
) -> ! {
    control::run(boat, power, status_led, watchdog, &LINK, interval).await
}
