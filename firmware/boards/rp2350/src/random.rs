//! Random values of one boot, from the chip's generator of true random numbers.
//!
//! Assumptions and limits: the generator's own tests are on. It samples its oscillator every 100 cycles instead of 25, which takes some
//! ten milliseconds for a block, rarely a hundred times that, and seldom fails a test (RP2350 datasheet, sections 12.12.2 and
//! 12.12.4). Where one fails all the same the driver panics or waits for ever: the chip resets, and draws again.

use embassy_rp::Peri;
use embassy_rp::bind_interrupts;
use embassy_rp::peripherals::TRNG;
use embassy_rp::trng::{Config, InterruptHandler, Trng};

/// Cycles between two samples.
const SAMPLE_EVERY: u32 = 100;

bind_interrupts!(struct Interrupts {
    TRNG_IRQ => InterruptHandler<TRNG>;
});

/// Random values of one boot.
#[derive(Clone, Copy, Debug)]
pub struct Drawn {
    /// What tells this boot of the module from every other: `firmware::link::session::Identity::boot`.
    pub boot: [u8; 12],
    /// What the network's ports and numbers begin with.
    pub seed: u64,
}

/// Draws, and waits for it.
pub fn draw(generator: Peri<'static, TRNG>) -> Drawn {
    let mut config = Config::default();
    config.sample_count = SAMPLE_EVERY;
    let mut generator = Trng::new(generator, Interrupts, config);
    let (mut boot, mut seed) = ([0; 12], [0; 8]);
    generator.blocking_fill_bytes(&mut boot);
    generator.blocking_fill_bytes(&mut seed);
    Drawn { boot, seed: u64::from_le_bytes(seed) }
}
