//! A state machine of a PIO block, as far as the program needs it: one instruction a cycle, no delays, no side-set, no queues but
//! the receive queue as registers, the input shifting to the left.
//!
//! Source: RP2350 datasheet, section 11.4. Written from the encoding of the instructions, not from the assembler.

use pio::{Program, RP2040_MAX_PROGRAM_SIZE};
use std::vec::Vec;

/// An emulated state machine of a PIO block.
pub struct StateMachine {
    code: Vec<u16>,
    wrap: (u8, u8),
    /// Address of the next instruction.
    pub pc: u8,
    /// Scratch register X.
    pub x: u32,
    /// Scratch register Y.
    pub y: u32,
    isr: u32,
    /// What the processor reads.
    pub entries: [u32; 4],
}

impl StateMachine {
    /// At the first instruction.
    pub fn new(program: &Program<RP2040_MAX_PROGRAM_SIZE>) -> Self {
        let wrap = (program.wrap.source, program.wrap.target);
        Self { code: program.code.to_vec(), wrap, pc: 0, x: 0, y: 0, isr: 0, entries: [0; 4] }
    }

    /// One cycle with these levels at its pins, the first in bit 0.
    pub fn step(&mut self, pins: u32) {
        let code = self.code[usize::from(self.pc)];
        assert_eq!(code >> 8 & 0x1f, 0, "no delay and no side-set: {code:04x}");
        let (wrap_source, wrap_target) = self.wrap;
        let mut next = if self.pc == wrap_source { wrap_target } else { self.pc + 1 };
        // Three bits of each: which instruction, its upper and its lower field.
        match (code >> 13, code >> 5 & 7) {
            // JMP to the address in the lower five bits.
            (0b000, condition) => {
                let taken = match condition {
                    0b000 => true,
                    0b010 => {
                        let taken = self.x != 0;
                        self.x = self.x.wrapping_sub(1);
                        taken
                    }
                    _ => panic!("condition of a jump {condition}"),
                };
                if taken {
                    next = (code & 0x1f) as u8;
                }
            }
            // IN of so many bits.
            (0b010, source) => {
                let source = self.source(source, pins);
                let bits = code & 0x1f;
                self.isr = self.isr << bits | source & ((1 << bits) - 1);
            }
            // MOV to the receive queue: bit 4 tells it from PUSH, bit 3 says that the lower three are the entry.
            (0b100, 0b000) if code & 0b11000 == 0b11000 => {
                self.entries[usize::from(code & 0b111)] = self.isr;
            }
            // MOV, bits 4 and 3 the operation, bits 2 to 0 the source.
            (0b101, destination) => {
                let source = self.source(code & 7, pins);
                let moved = match code >> 3 & 3 {
                    0b00 => source,
                    0b01 => !source,
                    operation => panic!("operation of a move {operation}"),
                };
                match destination {
                    0b001 => self.x = moved,
                    0b010 => self.y = moved,
                    0b101 => next = (moved & 0x1f) as u8,
                    0b110 => self.isr = moved,
                    _ => panic!("destination of a move {destination}"),
                }
            }
            _ => panic!("instruction {code:04x}"),
        }
        self.pc = next;
    }

    fn source(&self, source: u16, pins: u32) -> u32 {
        match source {
            0b000 => pins,
            0b001 => self.x,
            0b010 => self.y,
            0b011 => 0,
            0b110 => self.isr,
            _ => panic!("source {source}"),
        }
    }
}
