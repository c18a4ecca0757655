//! The radio of the board, a CYW43439, and the network behind it.
//!
//! Joins the network of the configuration, and joins it again for ever when it was lost. Nothing here holds the control loop up: all of it
//! runs in thread mode, and the swimming goes on without it.
//!
//! - **Power saving is off.** With it the radio sleeps between two beacons, and a datagram to the module waits for up to 0.1 s.
//! - **Clock of the bus.** 25 MHz of the 50 that the chip takes; both ends were seen to work with it on this board (embassy-rs/embassy,
//!   pull request 4792).
//!
//! Assumptions and limits: the name of the network is UTF-8, as the driver takes no other; a network with another name, or with none, is not joined.
//! Passphrases are those of WPA2 or WPA3. The driver panics where the radio refuses a command: the module resets then, and its
//! tail has to find its zero again.

use core::str;

use cyw43::{Control, JoinOptions, NetDriver, PowerManagementMode, SpiBus, State};
use cyw43_pio::{PioSpi, RM2_CLOCK_DIVIDER};
use embassy_executor::Spawner;
use embassy_futures::select::{Either, select};
use embassy_net::{Stack, StackResources};
use embassy_rp::gpio::{Level, Output};
use embassy_rp::peripherals::{DMA_CH0, PIN_23, PIN_24, PIN_25, PIN_29, PIO0};
use embassy_rp::pio::{self, Pio};
use embassy_rp::{Peri, bind_interrupts, dma};
use embassy_time::{Duration, Timer, with_timeout};
use protocol::configuration::{Host, Network};
use rp2350::link::{self, SOCKETS};
use rp2350::watchdog;
use static_cell::{ConstStaticCell, StaticCell};

use crate::{BOARD_LED, LINK};

/// Time after switch-on within which the radio must work; otherwise it is reset again. *Assumed*; usual is half a second.
const STARTS_WITHIN: Duration = Duration::from_secs(10);

/// Time to join the network; then the request is repeated. *Assumed*; usual are some seconds.
const JOINS_WITHIN: Duration = Duration::from_secs(20);

/// Pause before that request. *Assumed.*
const ASK_AGAIN: Duration = Duration::from_millis(500);

/// The output of the radio on which the board's LED hangs.
const LED: u8 = 0;

bind_interrupts!(struct Interrupts {
    PIO0_IRQ_0 => pio::InterruptHandler<PIO0>;
    DMA_IRQ_0 => dma::InterruptHandler<DMA_CH0>;
});

type Bus = SpiBus<Output<'static>, PioSpi<'static, PIO0, 0>>;

/// Pins and parts of the chip that belong to the radio.
pub struct Parts {
    /// Switches it on.
    pub power: Peri<'static, PIN_23>,
    /// The bus: data both ways, and the interrupt.
    pub data: Peri<'static, PIN_24>,
    /// The bus: chip select.
    pub select: Peri<'static, PIN_25>,
    /// The bus: clock.
    pub clock: Peri<'static, PIN_29>,
    /// What drives the bus.
    pub block: Peri<'static, PIO0>,
    /// What feeds that.
    pub dma: Peri<'static, DMA_CH0>,
}

/// Starts the radio and the network, and keeps the module in it for ever.
pub async fn run(spawner: Spawner, parts: Parts, network: &Network, seed: u64) -> ! {
    static STATE: StaticCell<State> = StaticCell::new();
    static RESOURCES: ConstStaticCell<StackResources<SOCKETS>> = ConstStaticCell::new(StackResources::new());

    let mut block = Pio::new(parts.block, Interrupts);
    let bus = PioSpi::new(
        &mut block.common,
        block.sm0,
        RM2_CLOCK_DIVIDER,
        block.irq0,
        Output::new(parts.select, Level::High),
        parts.data,
        parts.clock,
        dma::Channel::new(parts.dma, Interrupts),
    );
    let power = Output::new(parts.power, Level::Low);
    let start = cyw43::new(STATE.init_with(State::new), power, bus, &cyw43_setup::FW, &cyw43_setup::NVRAM);
    let Ok((device, mut radio, runner)) = with_timeout(STARTS_WITHIN, start).await else {
        // Without a radio there was no session, so nothing is interrupted.
        watchdog::reset()
    };
    // Tasks of which there is one each, so the tokens are there.
    spawner.spawn(drive(runner).unwrap());
    let set_up = async {
        radio.init(cyw43_setup::CLM).await;
        radio.set_power_management(PowerManagementMode::None).await;
    };
    if with_timeout(STARTS_WITHIN, set_up).await.is_err() {
        watchdog::reset();
    }
    let (stack, runner) = embassy_net::new(device, link::addresses(network.own), RESOURCES.take(), seed);
    spawner.spawn(process(runner).unwrap());
    spawner.spawn(carry(stack, network.host).unwrap());
    loop {
        stay_in(&mut radio, stack, network).await;
        show(&mut radio, BOARD_LED.try_take()).await;
        Timer::after(ASK_AGAIN).await;
    }
}

/// Joins the network, and returns when that failed or when it was lost.
async fn stay_in(radio: &mut Control<'static>, stack: Stack<'static>, network: &Network) {
    let Some(name) = str::from_utf8(&network.ssid).ok().filter(|name| !name.is_empty()) else { return };
    let options = match network.passphrase.bytes() {
        [] => JoinOptions::new_open(),
        passphrase => JoinOptions::new(passphrase),
    };
    let joined = with_timeout(JOINS_WITHIN, async {
        radio.join(name, options).await.ok()?;
        stack.wait_link_up().await;
        Some(())
    });
    if !matches!(joined.await, Ok(Some(()))) {
        return;
    }
    while let Either::Second(lit) = select(stack.wait_link_down(), BOARD_LED.wait()).await {
        show(radio, Some(lit)).await;
    }
}

/// Lets the board's LED show what the status LED shows, if that has changed.
async fn show(radio: &mut Control<'static>, lit: Option<bool>) {
    if let Some(lit) = lit {
        radio.gpio_set(LED, lit).await;
    }
}

/// The driver of the radio.
#[embassy_executor::task]
async fn drive(runner: cyw43::Runner<'static, Bus>) -> ! {
    runner.run().await
}

/// The network.
#[embassy_executor::task]
async fn process(mut runner: embassy_net::Runner<'static, NetDriver<'static>>) -> ! {
    runner.run().await
}

/// Datagrams.
#[embassy_executor::task]
async fn carry(stack: Stack<'static>, host: Host) -> ! {
    LINK.serve(stack, host).await
}
