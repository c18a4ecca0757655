//! A linked program, read from an ELF file: what it loads where, its sections, its functions.
//!
//! A section has an address to run at and, where it has contents, one to load from. It takes flash if it has contents, and RAM if it
//! has none (it is zeroed or left alone at start) or if the two addresses differ (it is copied at start). That holds for any
//! Cortex-M; no memory map is asked for.
//!
//! Assumptions and limits: 32 bits, as all Cortex-M. What is between two loaded pieces of one page is left erased.

use std::collections::BTreeMap;

use object::elf::{PT_LOAD, SHF_ALLOC, SHT_NOBITS};
use object::read::elf::{ElfFile32, ProgramHeader, SectionHeader};
use object::{Endianness, Object, ObjectSection, ObjectSymbol, SectionKind, SymbolKind};
use thiserror::Error;

use crate::uf2::{Family, PAYLOAD, Uf2Error, write};

/// Where the boot ROM of the RP2350 takes flash to be, from and up to but without: 32 MiB from `XIP_BASE` (see [`crate::uf2`]).
const FLASH: (u32, u32) = (0x1000_0000, 0x1200_0000);

/// Why a file is no program, or not one for a board.
#[derive(Debug, Error)]
pub enum ElfError {
    /// The file is damaged, or something else.
    #[error("is no ELF program of 32 bits: {0}")]
    Read(#[from] object::Error),
    /// A segment says that it is longer than the file.
    #[error("the segment for {0:#010x} is not all in the file")]
    Cut(u32),
    /// Two segments want different bytes in one place.
    #[error("two segments want different bytes at {0:#010x}")]
    Overlap(u32),
    /// What is loaded outside of flash is gone when the board restarts.
    #[error("bytes for {0:#010x}, which is not in the RP2350's flash")]
    NotFlash(u32),
    /// Nothing says what its functions are called.
    #[error("has no symbols: it was stripped")]
    NoSymbols,
    /// Its tables of lines.
    #[error("its lines: {0}")]
    Lines(String),
    /// Not to be had as UF2.
    #[error(transparent)]
    Uf2(#[from] Uf2Error),
}

/// A section of a linked program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Section {
    /// Its name, such as `.text`.
    pub name: String,
    /// Its size.
    pub bytes: u64,
    /// It takes so much flash.
    pub in_flash: bool,
    /// It takes so much RAM.
    pub in_ram: bool,
}

/// A function of a linked program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Function {
    /// Where it begins.
    pub address: u32,
    /// Its name as Rust writes it, without hash.
    pub name: String,
}

/// Pages of memory by address, and in each the bytes that are known.
type Pages = BTreeMap<u32, [Option<u8>; PAYLOAD]>;

/// A linked program, read from an ELF file.
#[derive(Debug)]
pub struct Program<'a> {
    file: ElfFile32<'a, Endianness>,
}

impl<'a> Program<'a> {
    /// Reads a linked program from the bytes of its ELF file.
    pub fn read(bytes: &'a [u8]) -> Result<Self, ElfError> {
        Ok(Self { file: ElfFile32::parse(bytes)? })
    }

    /// The program as a UF2 file for the RP2350.
    ///
    /// # Errors
    /// [`ElfError`], where it is not all in flash.
    pub fn uf2(&self) -> Result<Vec<u8>, ElfError> {
        let pages = self.pages()?;
        let outside = pages.keys().find(|address| !(FLASH.0..FLASH.1).contains(*address));
        if let Some(&address) = outside {
            return Err(ElfError::NotFlash(address));
        }
        let erased = |page: &[Option<u8>; PAYLOAD]| page.map(|byte| byte.unwrap_or(0xFF));
        let filled: Vec<(u32, [u8; PAYLOAD])> =
            pages.iter().map(|(&address, page)| (address, erased(page))).collect();
        Ok(write(Family::RP2350_ARM_S, filled.iter().map(|(address, page)| (*address, &page[..])))?)
    }

    /// What is loaded, by address.
    fn pages(&self) -> Result<Pages, ElfError> {
        let endian = self.file.endian();
        let mut pages = Pages::new();
        for segment in self.file.elf_program_headers() {
            if segment.p_type(endian) != PT_LOAD {
                continue;
            }
            let begin = segment.p_paddr(endian);
            let bytes = segment.data(endian, self.file.data()).map_err(|()| ElfError::Cut(begin))?;
            for (&byte, offset) in bytes.iter().zip(0_u32..) {
                let address = begin.checked_add(offset).ok_or(ElfError::Cut(begin))?;
                let within = address as usize % PAYLOAD;
                let page = pages.entry(address - within as u32).or_insert([None; PAYLOAD]);
                if page[within].replace(byte).is_some_and(|former| former != byte) {
                    return Err(ElfError::Overlap(address));
                }
            }
        }
        Ok(pages)
    }

    /// Everything in it that takes memory on the board, in the file's order.
    pub fn sections(&self) -> Result<Vec<Section>, ElfError> {
        let endian = self.file.endian();
        let mut sections = Vec::new();
        for section in self.file.sections() {
            let header = section.elf_section_header();
            let (bytes, empty) = (section.size(), header.sh_type(endian) == SHT_NOBITS);
            if !header.sh_flags(endian).contains(SHF_ALLOC) || bytes == 0 {
                continue;
            }
            let moved = self.load_address(header).is_some_and(|from| from != header.sh_addr(endian));
            let name = section.name()?.to_owned();
            sections.push(Section { name, bytes, in_flash: !empty, in_ram: empty || moved });
        }
        Ok(sections)
    }

    /// Where a section with contents is loaded.
    fn load_address(&self, header: &impl SectionHeader<Endian = Endianness, Word = u32>) -> Option<u32> {
        let endian = self.file.endian();
        let offset = header.sh_offset(endian);
        self.file.elf_program_headers().iter().find_map(|segment| {
            let within = offset.checked_sub(segment.p_offset(endian))?;
            let holds = segment.p_type(endian) == PT_LOAD && within < segment.p_filesz(endian);
            holds.then(|| segment.p_paddr(endian).wrapping_add(within))
        })
    }

    /// The names of its functions as Rust writes them, without hashes, sorted, each once.
    ///
    /// # Errors
    /// [`ElfError::NoSymbols`].
    pub fn functions(&self) -> Result<Vec<String>, ElfError> {
        let mut names: Vec<String> = self.places()?.into_iter().map(|function| function.name).collect();
        names.sort_unstable();
        names.dedup();
        Ok(names)
    }

    /// The program's functions by address.
    ///
    /// # Errors
    /// [`ElfError::NoSymbols`].
    pub fn places(&self) -> Result<Vec<Function>, ElfError> {
        let mut functions = Vec::new();
        for symbol in self.file.symbols() {
            if symbol.kind() == SymbolKind::Text && symbol.is_definition() {
                let name = format!("{:#}", rustc_demangle::demangle(symbol.name()?));
                // The lowest bit says that it is Thumb code.
                functions.push(Function { address: symbol.address() as u32 & !1, name });
            }
        }
        if functions.is_empty() {
            return Err(ElfError::NoSymbols);
        }
        functions.sort_unstable_by_key(|function| function.address);
        Ok(functions)
    }

    /// The program's executable sections: address and bytes of each.
    pub fn code(&self) -> Result<Vec<(u32, &'a [u8])>, ElfError> {
        let mut code = Vec::new();
        for section in self.file.sections().filter(|section| section.kind() == SectionKind::Text) {
            code.push((section.address() as u32, section.data()?));
        }
        Ok(code)
    }
}
