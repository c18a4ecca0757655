//! UF2 files: a program or data cut into blocks that each say where they belong, for a board that shows itself as a USB
//! drive.
//!
//! ```text
//! word 0x0A324655 │ word 0x9E5D5157 │ flags │ address │ payload bytes │ block │ blocks │ family │ data 476 │ word 0x0AB16F30
//! ```
//!
//! Words of 32 bits, little endian; 512 bytes in all, so that one block is one sector of the drive. Source: Microsoft, *USB
//! Flashing Format (UF2)*, github.com/microsoft/uf2; families, and that every payload is one whole page of flash on a page's
//! border: Raspberry Pi, pico-sdk 2, `src/common/boot_uf2_headers/include/boot/uf2.h`, and the boot ROM itself,
//! github.com/raspberrypi/pico-bootrom-rp2350, `src/nsboot/usb_virtual_disk.c`. It erases a sector of 4 KiB when the first block for it
//! comes, and restarts the board after the last block.
//!
//! Assumptions and limits: main flash only, one family a file, payloads of [`PAYLOAD`] bytes: what the RP2350 takes. No block
//! against RP2350-E10 stands in front, as picotool writes it: that erratum is about partition tables, and Flotilla has none.

use thiserror::Error;

/// Bytes of a block of a UF2 file.
pub const BLOCK: usize = 512;
/// Bytes of flash in a block: one page.
pub const PAYLOAD: usize = 256;

const MAGIC_START: [u32; 2] = [0x0A32_4655, 0x9E5D_5157];
const MAGIC_END: u32 = 0x0AB1_6F30;
/// The last word of the head is a family, not the size of a file.
const FLAG_FAMILY: u32 = 0x2000;
/// What flash holds where nothing was written.
const ERASED: u8 = 0xFF;

/// The UF2 family of a file: the chip or the kind of data that it is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Family(pub u32);

impl Family {
    /// A program for the RP2350's Arm cores, secure (pico-sdk's `RP2350_ARM_S_FAMILY_ID`, picotool's `rp2350-arm-s`).
    pub const RP2350_ARM_S: Self = Self(0xE48B_FF59);
    /// Anything for a fixed address of flash (`ABSOLUTE_FAMILY_ID`, `absolute`).
    pub const ABSOLUTE: Self = Self(0xE48B_FF57);
}

impl std::fmt::Display for Family {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match *self {
            Self::RP2350_ARM_S => f.write_str("rp2350-arm-s"),
            Self::ABSOLUTE => f.write_str("absolute"),
            Self(other) => write!(f, "{other:#010x}"),
        }
    }
}

/// One block of a file. It has no `Debug`: what is in it may be secret.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Block<'a> {
    /// Where its payload belongs.
    pub address: u32,
    /// A page of flash.
    pub payload: &'a [u8; PAYLOAD],
}

/// Why a file cannot be written, or is none. Blocks are counted from 1.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum Uf2Error {
    /// Nothing to write, or nothing there.
    #[error("has no block")]
    Empty,
    /// More blocks than can be counted.
    #[error("{0} blocks are too many")]
    Count(usize),
    /// The address is not on a page's border.
    #[error("address {0:#010x} is not a multiple of {PAYLOAD}")]
    Alignment(u32),
    /// More bytes than a page has.
    #[error("{0} bytes for one page of {PAYLOAD}")]
    Page(usize),
    /// The file ends within a block.
    #[error("{0} bytes are no whole number of blocks of {BLOCK}")]
    Length(usize),
    /// No block.
    #[error("block {0} has no UF2 magic")]
    Magic(usize),
    /// A block that is not for main flash, or does not say for whom.
    #[error("block {block} has flags {flags:#010x}: only {FLAG_FAMILY:#x}, a family, is known")]
    Flags { block: usize, flags: u32 },
    /// Another payload than a page.
    #[error("block {block} has {bytes} bytes where {PAYLOAD} are a page")]
    Payload { block: usize, bytes: u32 },
    /// Blocks are missing, or from another file.
    #[error("block {block} says that it is number {number} of {count}, from 0")]
    Number { block: usize, number: u32, count: u32 },
    /// The file begins for one family and goes on for another.
    #[error("block {block} is for {family}, the first one is not")]
    Family { block: usize, family: Family },
}

/// A file for `family` of pages: addresses, and at most [`PAYLOAD`] bytes each; the rest of a page stays erased.
///
/// # Errors
/// [`Uf2Error::Empty`], [`Uf2Error::Count`], [`Uf2Error::Alignment`], [`Uf2Error::Page`].
pub fn write<'a, I>(family: Family, pages: I) -> Result<Vec<u8>, Uf2Error>
where
    I: IntoIterator<Item = (u32, &'a [u8])>,
    I::IntoIter: ExactSizeIterator,
{
    let pages = pages.into_iter();
    if pages.len() == 0 {
        return Err(Uf2Error::Empty);
    }
    let count = u32::try_from(pages.len()).map_err(|_| Uf2Error::Count(pages.len()))?;
    // At its full length from the start: what is secret in it is in one place of memory.
    let mut file = Vec::with_capacity(pages.len() * BLOCK);
    for (number, (address, bytes)) in (0..count).zip(pages) {
        if !(address as usize).is_multiple_of(PAYLOAD) {
            return Err(Uf2Error::Alignment(address));
        }
        if bytes.len() > PAYLOAD {
            return Err(Uf2Error::Page(bytes.len()));
        }
        let [first, second] = MAGIC_START;
        let head = [first, second, FLAG_FAMILY, address, PAYLOAD as u32, number, count, family.0];
        let begin = file.len();
        head.iter().for_each(|word| file.extend_from_slice(&word.to_le_bytes()));
        let payload = file.len();
        file.extend_from_slice(bytes);
        file.resize(payload + PAYLOAD, ERASED);
        file.resize(begin + BLOCK - 4, 0);
        file.extend_from_slice(&MAGIC_END.to_le_bytes());
    }
    Ok(file)
}

/// Whether a file looks like UF2 at all.
#[must_use]
pub fn is_uf2(file: &[u8]) -> bool {
    word(file, 0) == MAGIC_START[0] && word(file, 1) == MAGIC_START[1]
}

/// Reads the family and the blocks of a file.
pub fn read(file: &[u8]) -> Result<(Family, Vec<Block<'_>>), Uf2Error> {
    let (blocks, rest) = file.as_chunks::<BLOCK>();
    if !rest.is_empty() {
        return Err(Uf2Error::Length(file.len()));
    }
    let family = Family(word(blocks.first().ok_or(Uf2Error::Empty)?, 7));
    let read = (1..).zip(blocks).map(|(block, bytes)| {
        if !is_uf2(bytes) || word(bytes, BLOCK / 4 - 1) != MAGIC_END {
            return Err(Uf2Error::Magic(block));
        }
        let [flags, address, length, number, count, of] = [2, 3, 4, 5, 6, 7].map(|k| word(bytes, k));
        if flags != FLAG_FAMILY {
            return Err(Uf2Error::Flags { block, flags });
        }
        if of != family.0 {
            return Err(Uf2Error::Family { block, family: Family(of) });
        }
        if length as usize != PAYLOAD {
            return Err(Uf2Error::Payload { block, bytes: length });
        }
        if number as usize != block - 1 || count as usize != blocks.len() {
            return Err(Uf2Error::Number { block, number, count });
        }
        if !(address as usize).is_multiple_of(PAYLOAD) {
            return Err(Uf2Error::Alignment(address));
        }
        let payload = bytes.get(32..).and_then(<[u8]>::first_chunk).ok_or(Uf2Error::Magic(block))?;
        Ok(Block { address, payload })
    });
    Ok((family, read.collect::<Result<_, _>>()?))
}

/// The `index`-th word; zero where there is none.
fn word(bytes: &[u8], index: usize) -> u32 {
    bytes.get(4 * index..).and_then(<[u8]>::first_chunk).map_or(0, |word| u32::from_le_bytes(*word))
}
