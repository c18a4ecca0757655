//! An ROV on a WIZnet W5500-EVB-Pico2.
//!
//! | GPIO | pin of the board | what | electrical |
//! |---|---|---|---|
//! | GP0 to GP7 | 1, 2, 4, 5, 6, 7, 9, 10 | outputs 0 to 7: speed controllers of the thrusters | pulses, as many a second as the configuration says |
//! | GP22 | 29 | status LED | high: lit; a resistor and a LED to ground |
//! | GP25 | none | the board's own LED: shows the same | on the board |
//! | GP26 | 31 | battery | 0 to 3.3 V, from a divider |
//! | GP27 | 32 | battery current | 0 to 3.3 V, from its sensor |
//! | GP16 to GP21 | 21, 22, 24, 25, 26, 27 | Ethernet controller: leave them free | on the board |
//!
//! ```text
//! boot → random numbers, configuration → ROV → control, in its interrupt          tether, network, in thread mode
//!                        └ none → blink
//! ```
//!
//! Until the first tick every output is low. From then on the bank puts out neutral, until its controllers have had time to arm.
//!
//! Assumptions and limits: outputs are in pairs on one timer, and all timers run at one rate. What `memory.x` and the thrusters are is
//! said at the top of the tree.
#![no_std]
#![no_main]

use embassy_executor::Spawner;
use embassy_rp::Peri;
use embassy_rp::gpio::{Level, Output};
use embassy_rp::peripherals::{
    PIN_0, PIN_1, PIN_2, PIN_3, PIN_4, PIN_5, PIN_6, PIN_7, PWM_SLICE0, PWM_SLICE1, PWM_SLICE2, PWM_SLICE3,
};
use embassy_rp::pwm::{Pwm, PwmOutput};
use firmware::provision::{self, NotProvisioned};
use firmware::rov::Rov;
use firmware::rov::thruster::bank::BankError;
use protocol::Configuration;
use protocol::configuration::Robot;
use protocol::time::Duration;
use rp2350::link::Link;
use rp2350::status_led::{Light, StatusLed};
use rp2350::supply::PowerSensor;
use rp2350::watchdog::Watchdog;
use rp2350::{configuration, control, priority, random, timer};
use static_cell::StaticCell;

mod tether;

/// How often the thrusts are worked out: every second frame of 400 a second. *Assumed*: a controller of a thruster takes longer.
const INTERVAL: Duration = Duration(5_000);

static LINK: Link = Link::new();

/// The timers, each with the two pins that it drives.
struct Timers {
    first: (Peri<'static, PWM_SLICE0>, Peri<'static, PIN_0>, Peri<'static, PIN_1>),
    second: (Peri<'static, PWM_SLICE1>, Peri<'static, PIN_2>, Peri<'static, PIN_3>),
    third: (Peri<'static, PWM_SLICE2>, Peri<'static, PIN_4>, Peri<'static, PIN_5>),
    fourth: (Peri<'static, PWM_SLICE3>, Peri<'static, PIN_6>, Peri<'static, PIN_7>),
}

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let p = embassy_rp::init(embassy_rp::config::Config::default());
    let watchdog = Watchdog::start(p.WATCHDOG);
    let status_led = [Output::new(p.PIN_22, Level::Low), Output::new(p.PIN_25, Level::Low)];
    let status_led = StatusLed::new(status_led.map(Light::Pin));
    let drawn = random::draw(p.TRNG);
    let timers = Timers {
        first: (p.PWM_SLICE0, p.PIN_0, p.PIN_1),
        second: (p.PWM_SLICE1, p.PIN_2, p.PIN_3),
        third: (p.PWM_SLICE2, p.PIN_4, p.PIN_5),
        fourth: (p.PWM_SLICE3, p.PIN_6, p.PIN_7),
    };
    let provisioned = configuration::read().map_err(NotProvisioned::from).and_then(|configuration| {
        let rov = rov(&configuration, drawn.boot, timers)?;
        Ok((configuration, rov))
    });
    let Ok((configuration, rov)) = provisioned else { control::blink(status_led, watchdog).await };
    let power = PowerSensor::new(p.ADC, p.PIN_26, p.PIN_27, configuration.supply, INTERVAL);
    // Its only instance, so the token is there.
    priority::start().spawn(thrust(rov, power, status_led, watchdog).unwrap());
    let parts = tether::Parts {
        data_in: p.PIN_16,
        select: p.PIN_17,
        clock: p.PIN_18,
        data_out: p.PIN_19,
        reset: p.PIN_20,
        interrupt: p.PIN_21,
        bus: p.SPI0,
        to_bus: p.DMA_CH0,
        from_bus: p.DMA_CH1,
    };
    tether::run(spawner, parts, &configuration, drawn.seed).await
}

/// The ROV of a configuration.
fn rov(
    configuration: &Configuration,
    boot: [u8; 12],
    timers: Timers,
) -> Result<Rov<PwmOutput<'static>>, NotProvisioned> {
    static SLICES: StaticCell<[Pwm<'static>; 4]> = StaticCell::new();

    let Robot::Rov(constants) = &configuration.robot else {
        return Err(NotProvisioned::Kind(configuration.kind()));
    };
    let rate_hz = constants.bank.frame_rate_hz;
    let settings = timer::settings(rate_hz).ok_or(BankError::FrameRate(rate_hz))?;
    let Timers { first, second, third, fourth } = timers;
    let slices = SLICES.init([
        Pwm::new_output_ab(first.0, first.1, first.2, settings.clone()),
        Pwm::new_output_ab(second.0, second.1, second.2, settings.clone()),
        Pwm::new_output_ab(third.0, third.1, third.2, settings.clone()),
        Pwm::new_output_ab(fourth.0, fourth.1, fourth.2, settings),
    ]);
    // By reference: `Pwm::split` drops the slice, and that stops its timer.
    let outputs = slices.iter_mut().map(Pwm::split_by_ref).flat_map(|(a, b)| [a, b]).flatten();
    provision::rov(configuration, boot, outputs)
}

#[embassy_executor::task]
async fn thrust(
    rov: Rov<PwmOutput<'static>>,
    power: PowerSensor,
    status_led: StatusLed,
    watchdog: Watchdog,
) -> ! {
    control::run(rov, power, status_led, watchdog, &LINK, INTERVAL).await
}
