//! The tether: the Ethernet controller of the board, a W5500, and the network behind it.
//!
//! It is used as a network card (raw frames); UDP and DHCP are done here. Nothing here holds the control loop up: all of it runs in
//! thread mode. A cable that was pulled out works again when it is put back.
//!
//! Assumptions and limits: the bus runs at no more than the 33.3 MHz that the W5500's data sheet guarantees. The controller has no
//! address of its own: `rp2350::hardware_address`.

use embassy_executor::Spawner;
use embassy_net::StackResources;
use embassy_net_wiznet::chip::W5500;
use embassy_net_wiznet::{Device, State};
use embassy_rp::gpio::{Input, Level, Output, Pull};
use embassy_rp::peripherals::{DMA_CH0, DMA_CH1, PIN_16, PIN_17, PIN_18, PIN_19, PIN_20, PIN_21, SPI0};
use embassy_rp::spi::{self, Spi};
use embassy_rp::{Peri, bind_interrupts, dma};
use embassy_time::{Delay, Duration, Timer, with_timeout};
use embedded_hal_bus::spi::ExclusiveDevice;
use protocol::Configuration;
use rp2350::link::{self, SOCKETS};
use rp2350::{hardware_address, watchdog};
use static_cell::ConstStaticCell;

use crate::LINK;

/// Greatest clock of the bus, Hz.
const BUS_HZ: u32 = 33_000_000;

/// Time after its reset within which the controller must answer; otherwise it is reset again. *Assumed*; usual is a tenth of it.
const STARTS_WITHIN: Duration = Duration::from_secs(2);

/// Frames that wait, each way.
const FRAMES: usize = 8;

bind_interrupts!(struct Interrupts {
    DMA_IRQ_0 => dma::InterruptHandler<DMA_CH0>, dma::InterruptHandler<DMA_CH1>;
});

type Bus = ExclusiveDevice<Spi<'static, SPI0, spi::Async>, Output<'static>, Delay>;
type Runner = embassy_net_wiznet::Runner<'static, W5500, Bus, Input<'static>, Output<'static>>;

/// Pins and parts of the chip that belong to the controller.
pub struct Parts {
    /// MISO.
    pub data_in: Peri<'static, PIN_16>,
    /// CSn.
    pub select: Peri<'static, PIN_17>,
    /// SCK.
    pub clock: Peri<'static, PIN_18>,
    /// MOSI.
    pub data_out: Peri<'static, PIN_19>,
    /// RSTn.
    pub reset: Peri<'static, PIN_20>,
    /// INTn.
    pub interrupt: Peri<'static, PIN_21>,
    /// What drives the bus.
    pub bus: Peri<'static, SPI0>,
    /// What feeds that.
    pub to_bus: Peri<'static, DMA_CH0>,
    /// What it feeds.
    pub from_bus: Peri<'static, DMA_CH1>,
}

/// Starts the controller and the network, and serves both for ever.
pub async fn run(spawner: Spawner, parts: Parts, configuration: &Configuration, seed: u64) -> ! {
    static STATE: ConstStaticCell<State<FRAMES, FRAMES>> = ConstStaticCell::new(State::new());
    static RESOURCES: ConstStaticCell<StackResources<SOCKETS>> = ConstStaticCell::new(StackResources::new());

    let mut settings = spi::Config::default();
    settings.frequency = BUS_HZ;
    let bus = Spi::new(
        parts.bus,
        parts.clock,
        parts.data_out,
        parts.data_in,
        parts.to_bus,
        parts.from_bus,
        Interrupts,
        settings,
    );
    let Ok(bus) = ExclusiveDevice::new(bus, Output::new(parts.select, Level::High), Delay);
    let interrupt = Input::new(parts.interrupt, Pull::Up);
    let reset = Output::new(parts.reset, Level::High);
    let address = hardware_address::of(configuration.fleet, configuration.module);
    let start = embassy_net_wiznet::new(address, STATE.take(), bus, interrupt, reset);
    let Ok(Ok((device, runner))) = with_timeout(STARTS_WITHIN, start).await else {
        // Without a tether there was no session, so nothing is interrupted. Not at once, so that the status LED is seen.
        Timer::after(STARTS_WITHIN).await;
        watchdog::reset()
    };
    let network = &configuration.network;
    let (stack, network_runner) =
        embassy_net::new(device, link::addresses(network.own), RESOURCES.take(), seed);
    // Tasks of which there is one each, so the tokens are there.
    spawner.spawn(drive(runner).unwrap());
    spawner.spawn(process(network_runner).unwrap());
    LINK.serve(stack, network.host).await
}

/// The driver of the controller.
#[embassy_executor::task]
async fn drive(runner: Runner) -> ! {
    runner.run().await
}

/// The network.
#[embassy_executor::task]
async fn process(mut runner: embassy_net::Runner<'static, Device<'static>>) -> ! {
    runner.run().await
}
