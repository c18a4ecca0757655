//! The LAN9118 Ethernet controller on a 32-bit bus, polled, as a device of smoltcp (Microchip DS00002266, "LAN9118").
//!
//! Frames go through four FIFOs: data and status, each way. Only what a Modboat needs is used: no filters but the
//! controller's own (unicast to its address, broadcast), no wake-up, one buffer a frame.
//!
//! Assumptions and limits: the emulator resets the controller with its address in place; if it is not, it is set to one
//! that smoltcp is told as well. A frame that arrived damaged is dropped.

use cortex_m::peripheral::NVIC;
use smoltcp::phy::{self, DeviceCapabilities, Medium};
use smoltcp::time::Instant;
use smoltcp::wire::EthernetAddress;

use crate::clock::Interrupt;
use crate::registers::Registers;

// Table 5-1, direct registers.
const RX_DATA: usize = 0x00;
const TX_DATA: usize = 0x20;
const RX_STATUS: usize = 0x40;
const TX_STATUS: usize = 0x48;
const IRQ_CFG: usize = 0x54;
const INT_STS: usize = 0x58;
const INT_EN: usize = 0x5c;
const BYTE_TEST: usize = 0x64;
const FIFO_INT: usize = 0x68;
const RX_CFG: usize = 0x6c;
const TX_CFG: usize = 0x70;
const HW_CFG: usize = 0x74;
const RX_FIFO_INF: usize = 0x7c;
const TX_FIFO_INF: usize = 0x80;
const MAC_CSR_CMD: usize = 0xa4;
const MAC_CSR_DATA: usize = 0xa8;

const BYTE_ORDER: u32 = 0x8765_4321;
const IRQ_ENABLE_ACTIVE_HIGH: u32 = 1 << 8 | 1 << 4 | 1;
const INT_RX_STATUS_LEVEL: u32 = 1 << 3;
const TX_ON: u32 = 1 << 1;
const SOFT_RESET: u32 = 1;
const MUST_BE_ONE: u32 = 1 << 20;
const TX_FIFO_KIB: u32 = 5 << 16;
const CSR_BUSY: u32 = 1 << 31;
const CSR_READ: u32 = 1 << 30;
const RX_ERROR: u32 = 1 << 15;
const TX_FIRST_AND_LAST: u32 = 1 << 13 | 1 << 12;

// Table 5-7, registers of the MAC.
const MAC_CR: u32 = 1;
const ADDRH: u32 = 2;
const ADDRL: u32 = 3;
const MAC_TX_RX: u32 = 1 << 3 | 1 << 2;
const MAC_FULL_DUPLEX: u32 = 1 << 20;

/// A whole frame without its check sequence.
const FRAME: usize = 1514;
/// And with it, up to a word.
const BUFFER: usize = 1520;

/// Driver of the LAN9118 Ethernet controller.
#[derive(Debug)]
pub struct Lan9118 {
    registers: Registers,
    received: [u8; BUFFER],
    sent: [u8; BUFFER],
}

impl Lan9118 {
    /// Resets and starts the controller; nothing where there is none.
    ///
    /// # Safety
    /// Only one may be in use.
    #[must_use]
    pub unsafe fn start(address: EthernetAddress) -> Option<Self> {
        // SAFETY: the controller's place on this board (Arm DAI 0386, table 3-2); the caller has no other.
        let registers = unsafe { Registers::at(0x4020_0000) };
        if registers.read(BYTE_TEST) != BYTE_ORDER {
            return None;
        }
        registers.write(HW_CFG, SOFT_RESET);
        while registers.read(HW_CFG) & SOFT_RESET != 0 {}
        registers.write(HW_CFG, MUST_BE_ONE | TX_FIFO_KIB);
        let [a, b, c, d, e, f] = address.0;
        write_mac(&registers, ADDRL, u32::from_le_bytes([a, b, c, d]));
        write_mac(&registers, ADDRH, u32::from_le_bytes([e, f, 0, 0]));
        write_mac(&registers, MAC_CR, MAC_TX_RX | MAC_FULL_DUPLEX);
        registers.write(RX_CFG, 0);
        registers.write(TX_CFG, TX_ON);
        // An interrupt while any frame waits.
        registers.write(FIFO_INT, 0);
        registers.write(INT_STS, u32::MAX);
        registers.write(IRQ_CFG, IRQ_ENABLE_ACTIVE_HIGH);
        registers.write(INT_EN, INT_RX_STATUS_LEVEL);
        Some(Self { registers, received: [0; BUFFER], sent: [0; BUFFER] })
    }

    /// Lets its interrupt come again: to be called when no frame waits any more.
    pub fn listen(&mut self) {
        self.registers.write(INT_STS, INT_RX_STATUS_LEVEL);
        // SAFETY: its handler does nothing but mask it again.
        unsafe { NVIC::unmask(Interrupt::Ethernet) };
    }

    /// Takes the next frame off the controller: its length.
    fn take(&mut self) -> Option<usize> {
        loop {
            if self.registers.read(RX_FIFO_INF) >> 16 & 0xff == 0 {
                return None;
            }
            let status = self.registers.read(RX_STATUS);
            // With the check sequence, up to a word.
            let words = ((status >> 16 & 0x3fff) as usize).div_ceil(4);
            let mut chunks = self.received.chunks_exact_mut(4);
            for _ in 0..words {
                let word = self.registers.read(RX_DATA);
                if let Some(chunk) = chunks.next() {
                    chunk.copy_from_slice(&word.to_le_bytes());
                }
            }
            let length = ((status >> 16 & 0x3fff) as usize).saturating_sub(4);
            if status & RX_ERROR == 0 && length <= FRAME {
                return Some(length);
            }
        }
    }

    fn can_send(&self) -> bool {
        // What became of frames that were sent: nothing can be done about it here.
        while self.registers.read(TX_FIFO_INF) >> 16 & 0xff != 0 {
            self.registers.read(TX_STATUS);
        }
        (self.registers.read(TX_FIFO_INF) & 0xffff) as usize >= BUFFER + 8
    }
}

/// The controller's interrupt came: no more of them until it [listens](Lan9118::listen) again. The main loop is awake now.
pub fn interrupted() {
    NVIC::mask(Interrupt::Ethernet);
}

fn write_mac(registers: &Registers, index: u32, value: u32) {
    registers.write(MAC_CSR_DATA, value);
    registers.write(MAC_CSR_CMD, CSR_BUSY | index);
    while registers.read(MAC_CSR_CMD) & CSR_BUSY != 0 {}
    // Table 5-6: a read makes sure that the write has been done.
    registers.write(MAC_CSR_CMD, CSR_BUSY | CSR_READ | index);
    while registers.read(MAC_CSR_CMD) & CSR_BUSY != 0 {}
}

/// A frame that came.
pub struct Received<'a>(&'a [u8]);

impl phy::RxToken for Received<'_> {
    fn consume<R, F: FnOnce(&[u8]) -> R>(self, f: F) -> R {
        f(self.0)
    }
}

/// Room for a frame.
pub struct Room<'a> {
    registers: &'a Registers,
    buffer: &'a mut [u8; BUFFER],
}

impl phy::TxToken for Room<'_> {
    fn consume<R, F: FnOnce(&mut [u8]) -> R>(self, len: usize, f: F) -> R {
        let length = len.min(FRAME);
        let result = f(&mut self.buffer[..length]);
        // Command A and B (section 3.12.2): one buffer, aligned to a word, the whole frame.
        #[expect(clippy::cast_possible_truncation, reason = "a frame's length")]
        let bytes = length as u32;
        self.registers.write(TX_DATA, TX_FIRST_AND_LAST | bytes);
        self.registers.write(TX_DATA, bytes);
        for chunk in self.buffer[..length.next_multiple_of(4)].chunks_exact(4) {
            let mut word = [0; 4];
            word.copy_from_slice(chunk);
            self.registers.write(TX_DATA, u32::from_le_bytes(word));
        }
        result
    }
}

impl phy::Device for Lan9118 {
    type RxToken<'a> = Received<'a>;
    type TxToken<'a> = Room<'a>;

    fn receive(&mut self, _timestamp: Instant) -> Option<(Received<'_>, Room<'_>)> {
        if !self.can_send() {
            return None;
        }
        let length = self.take()?;
        let Self { registers, received, sent } = self;
        Some((Received(&received[..length]), Room { registers, buffer: sent }))
    }

    fn transmit(&mut self, _timestamp: Instant) -> Option<Room<'_>> {
        self.can_send().then_some(Room { registers: &self.registers, buffer: &mut self.sent })
    }

    fn capabilities(&self) -> DeviceCapabilities {
        let mut capabilities = DeviceCapabilities::default();
        capabilities.medium = Medium::Ethernet;
        capabilities.max_transmission_unit = FRAME;
        capabilities
    }
}
