//! What is drawn at boot, from the chip's generator of true random numbers.
//!
//! Assumptions and limits: the generator's own tests are on, with the settings of embassy-rp for some milliseconds a block (RP2350
//! datasheet, section 12.12.2). A generator that fails them panics or hangs in its driver: the chip resets and draws anew.

use embassy_rp::Peri;
use embassy_rp::bind_interrupts;
use embassy_rp::peripherals::TRNG;
use embassy_rp::trng::{Config, InterruptHandler, Trng};

bind_interrupts!(struct Interrupts {
    TRNG_IRQ => InterruptHandler<TRNG>;
});

/// See the module's documentation.
#[derive(Clone, Copy, Debug)]
pub struct Drawn {
    /// What tells this life of the module from every other: `firmware::link::Identity::boot`.
    pub boot: [u8; 12],
    /// What the network's ports and numbers begin with.
    pub seed: u64,
}

/// Draws; takes some milliseconds.
pub fn draw(generator: Peri<'static, TRNG>) -> Drawn {
    let mut generator = Trng::new(generator, Interrupts, Config::default());
    let (mut boot, mut seed) = ([0; 12], [0; 8]);
    generator.blocking_fill_bytes(&mut boot);
    generator.blocking_fill_bytes(&mut seed);
    Drawn { boot, seed: u64::from_le_bytes(seed) }
}
