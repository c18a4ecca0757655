//! Where a configuration lives in the flash of a board: read off the linker's own file, `memory.x`, while this is compiled. A file that does
//! not say it does not compile.

/// A part of a board's memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Region {
    /// Its first address.
    pub origin: u32,
    /// Its bytes.
    pub length: u32,
}

/// The sector that `flotilla provision` writes, on both RP2350 boards.
pub const CONFIGURATION: Region = region(include_bytes!("../../../memory.x"), b"CONFIGURATION");

const _: () = assert!(
    CONFIGURATION.length as usize >= protocol::configuration::IMAGE_MAX
        && CONFIGURATION.origin.is_multiple_of(CONFIGURATION.length),
    "an image needs whole sectors of its own"
);

/// `NAME : ORIGIN = NUMBER, LENGTH = NUMBER` of a linker script.
const fn region(text: &[u8], name: &[u8]) -> Region {
    let mut at = 0;
    while at < text.len() {
        if starts(text, at, name) {
            let after = skip_spaces(text, at + name.len());
            if starts(text, after, b":") {
                let length = find(text, after, b"LENGTH");
                return Region {
                    origin: value(text, find(text, after, b"ORIGIN")),
                    length: value(text, length),
                };
            }
        }
        at += 1;
    }
    panic!("memory.x has no such region")
}

const fn starts(text: &[u8], at: usize, what: &[u8]) -> bool {
    let mut k = 0;
    while k < what.len() {
        if at + k >= text.len() || text[at + k] != what[k] {
            return false;
        }
        k += 1;
    }
    true
}

const fn skip_spaces(text: &[u8], mut at: usize) -> usize {
    while starts(text, at, b" ") {
        at += 1;
    }
    at
}

/// Behind the next `what` of the line.
const fn find(text: &[u8], mut at: usize, what: &[u8]) -> usize {
    while !starts(text, at, what) {
        assert!(at < text.len() && text[at] != b'\n', "a region has ORIGIN and LENGTH in one line");
        at += 1;
    }
    at + what.len()
}

/// The number behind `=`: decimal or hexadecimal, perhaps in K or M.
const fn value(text: &[u8], at: usize) -> u32 {
    let at = skip_spaces(text, at);
    assert!(starts(text, at, b"="), "ORIGIN and LENGTH have an = behind them");
    let at = skip_spaces(text, at + 1);
    let (mut at, base) = if starts(text, at, b"0x") { (at + 2, 16) } else { (at, 10) };
    let (begin, mut number) = (at, 0);
    while at < text.len() {
        let Some(digit) = (text[at] as char).to_digit(base) else { break };
        number = number * base + digit;
        at += 1;
    }
    assert!(at > begin, "ORIGIN and LENGTH are numbers");
    if starts(text, at, b"K") {
        number * 1024
    } else if starts(text, at, b"M") {
        number * 1024 * 1024
    } else {
        number
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regions_are_read_as_the_linker_reads_them() {
        // What stands in memory.x today: a sector at the end of 2 MiB.
        assert_eq!(CONFIGURATION, Region { origin: 0x101f_f000, length: 4096 });
        let text = b"MEMORY {\n /* B : */\n  A:ORIGIN=0,LENGTH=12\n BB : ORIGIN = 1, LENGTH = 1\n\
                     B  :  ORIGIN  =  0x2000beef , LENGTH = 2M }";
        assert_eq!(region(text, b"A"), Region { origin: 0, length: 12 });
        assert_eq!(region(&text[25..], b"B  "), Region { origin: 0x2000_beef, length: 2 << 20 });
    }
}
