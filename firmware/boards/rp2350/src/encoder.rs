//! An incremental encoder and the switch of its index, as the encoder of a tail.
//!
//! The edges are counted by a state machine of PIO block 1, the program [`counter`]; the count and the switch go through
//! `firmware::modboat::quadrature`, once a tick. Its zero outlives a reset by the watchdog in the scratch registers of that
//! (`firmware::modboat::kept_zero`).
//!
//! Assumptions and limits: A and B are two pins in a row, A the lower. All three inputs have the chip's pull-up, some tens of kΩ, for
//! open-collector outputs; the switch pulls low over its magnet. Lines swapped: say `reversed` in the configuration, or swap them.

use embassy_rp::Peri;
use embassy_rp::bind_interrupts;
use embassy_rp::gpio::{Input, Pin, Pull};
use embassy_rp::peripherals::PIO1;
use embassy_rp::pio::{
    Config, Direction, FifoJoin, InterruptHandler, Pio, PioPin, ShiftConfig, ShiftDirection, StateMachine,
};
use firmware::modboat::encoder::Encoder;
use firmware::modboat::kept_zero::KeptQuadrature;
use firmware::modboat::quadrature::{Quadrature, READINGS};

use crate::counter;
use crate::watchdog::Scratch;

bind_interrupts!(struct Interrupts {
    PIO1_IRQ_0 => InterruptHandler<PIO1>;
});

/// It has not passed its index yet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotHomed;

/// An incremental encoder with an index switch, as a tail's encoder.
pub struct IndexedEncoder {
    counter: StateMachine<'static, PIO1, 0>,
    index: Input<'static>,
    quadrature: KeptQuadrature<Scratch>,
}

impl IndexedEncoder {
    /// Counting from now on, from where the tail stood if `scratch` knows that.
    #[must_use]
    pub fn new(
        block: Peri<'static, PIO1>,
        a: Peri<'static, impl PioPin + 'static>,
        b: Peri<'static, impl PioPin + 'static>,
        index: Peri<'static, impl Pin>,
        quadrature: Quadrature,
        scratch: Scratch,
    ) -> Self {
        let Pio { mut common, sm0: mut counter, .. } = Pio::new(block, Interrupts);
        let mut lines = [common.make_pio_pin(a), common.make_pio_pin(b)];
        for line in &mut lines {
            line.set_pull(Pull::Up);
            line.set_schmitt(true);
        }
        let [a, b] = &lines;
        counter.set_pin_dirs(Direction::In, &[a, b]);
        let mut config = Config::default();
        config.use_program(&common.load_program(&counter::program()), &[]);
        config.set_in_pins(&[a, b]);
        config.fifo_join = FifoJoin::RxAsStatus;
        config.shift_in =
            ShiftConfig { direction: ShiftDirection::Left, auto_fill: false, ..ShiftConfig::default() };
        counter.set_config(&config);
        counter.set_enable(true);
        let quadrature = KeptQuadrature::boot(quadrature, scratch);
        Self { counter, index: Input::new(index, Pull::Up), quadrature }
    }
}

impl Encoder for IndexedEncoder {
    type Error = NotHomed;

    const COUNTS_PER_TURN: u32 = READINGS;

    fn counts(&mut self) -> Result<u32, NotHomed> {
        // The count wraps at 2³², as the quadrature takes it.
        let count = self.counter.get_rxf_entry(counter::ENTRY).cast_signed();
        self.quadrature.update(count, self.index.is_low()).ok_or(NotHomed)
    }

    fn is_homed(&self) -> bool {
        self.quadrature.is_homed()
    }

    fn take_index_fault(&mut self) -> bool {
        self.quadrature.take_fault()
    }

    fn keep_zero(&mut self, resting: bool) {
        self.quadrature.keep_zero(resting);
    }
}
