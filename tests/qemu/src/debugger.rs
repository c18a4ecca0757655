//! The debugger of an emulated module: GDB's remote protocol, as far as its file calls take it (GDB manual, appendix E.13).
//!
//! A program on the emulator that opens, reads or writes a file by semihosting stops the whole emulator until the debugger has
//! answered, at exactly that instruction. So the debugger decides what random bytes it gets, and when its time goes on.
//!
//! ```text
//! $Fopen,PATH/LENGTH,FLAGS,MODE#CK    $Fread,FILE,ADDRESS,COUNT#CK    $Fwrite,FILE,ADDRESS,COUNT#CK    → $F RESULT#CK
//! ```

use std::io::{Read, Write};
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::time::Instant;

use rand::Rng;
use rand::rngs::ChaCha8Rng;

use crate::emulator::PATIENCE;

/// Files that the program may have open: standard output and error are there without being opened.
const DICE: u64 = 3;
const STEPS: u64 = 4;

/// See the module's documentation. On this line nothing is lost: acknowledgements are read over, and a question counts as one.
#[derive(Debug)]
pub struct Debugger {
    stream: UnixStream,
    came: Vec<u8>,
    dice: ChaCha8Rng,
    /// Bytes of the call that waits for its answer.
    waiting: u64,
    /// What the program said over the debugger: a panic does.
    said: String,
}

impl Debugger {
    /// Takes hold of an emulator that stands at its first instruction, and listens at `path`. Its program will find `dice`
    /// where it looks for random bytes.
    ///
    /// # Panics
    /// If none is there.
    #[must_use]
    pub fn attach(path: &Path, dice: ChaCha8Rng) -> Self {
        let deadline = Instant::now() + PATIENCE;
        let stream = loop {
            match UnixStream::connect(path) {
                Ok(stream) => break stream,
                Err(error) => assert!(Instant::now() < deadline, "{}: {error}", path.display()),
            }
            std::thread::sleep(std::time::Duration::from_millis(2));
        };
        stream.set_read_timeout(Some(PATIENCE)).expect("a socket");
        let mut debugger = Self { stream, came: Vec::new(), dice, waiting: 0, said: String::new() };
        debugger.send("c");
        debugger
    }

    /// Serves the program until it writes to the file `steps`: what it writes. It stands still then.
    ///
    /// # Panics
    /// If it ends before.
    pub fn await_step(&mut self) -> Vec<u8> {
        loop {
            let packet = self.packet();
            let words: Vec<&str> = packet.split([',', '/']).collect();
            match words.as_slice() {
                ["Fopen", path, length, ..] => {
                    let path = self.memory(number(path), number(length));
                    let file = if path.starts_with(b"steps") { STEPS } else { DICE };
                    self.send(&format!("F{file:x}"));
                }
                ["Fread", _, address, length] => {
                    let mut bytes = vec![0; number(length) as usize];
                    self.dice.fill_bytes(&mut bytes);
                    let bytes: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
                    assert_eq!(self.ask(&format!("M{address},{length}:{bytes}")), "OK");
                    self.send(&format!("F{length}"));
                }
                ["Fwrite", file, address, length] => {
                    let bytes = self.memory(number(address), number(length));
                    if number(file) == STEPS {
                        self.waiting = number(length);
                        return bytes;
                    }
                    self.said.push_str(&String::from_utf8_lossy(&bytes));
                    self.send(&format!("F{length}"));
                }
                ["Fclose", ..] => self.send("F0"),
                _ => panic!("the emulator ended with {packet}: {}", self.said),
            }
        }
    }

    /// Lets the program go on.
    pub fn answer_step(&mut self) {
        self.send(&format!("F{:x}", self.waiting));
    }

    /// Lets the emulator look at everything that it listens to, once, while its program stands still.
    pub fn look_around(&mut self) {
        self.memory(0, 4);
    }

    fn memory(&mut self, address: u64, length: u64) -> Vec<u8> {
        let text = self.ask(&format!("m{address:x},{length:x}"));
        let pairs = text.as_bytes().chunks(2).filter_map(|pair| std::str::from_utf8(pair).ok());
        pairs
            .map(|pair| u8::from_str_radix(pair, 16).unwrap_or_else(|error| panic!("{text}: {error}")))
            .collect()
    }

    fn ask(&mut self, question: &str) -> String {
        self.send(question);
        self.packet()
    }

    fn send(&mut self, text: &str) {
        let sum = text.bytes().fold(0_u8, u8::wrapping_add);
        self.stream.write_all(format!("${text}#{sum:02x}").as_bytes()).expect("an emulator");
    }

    fn packet(&mut self) -> String {
        loop {
            let begin = self.came.iter().position(|byte| *byte == b'$');
            let end = self.came.iter().position(|byte| *byte == b'#');
            if let (Some(begin), Some(end)) = (begin, end)
                && self.came.len() >= end + 3
            {
                let text = String::from_utf8_lossy(&self.came[begin + 1..end]).into_owned();
                self.came.drain(..end + 3);
                return text;
            }
            let mut bytes = [0; 4096];
            let count =
                self.stream.read(&mut bytes).unwrap_or_else(|error| panic!("a silent emulator: {error}"));
            assert!(count > 0, "the emulator is gone: {}", self.said);
            self.came.extend(&bytes[..count]);
        }
    }
}

fn number(text: &str) -> u64 {
    u64::from_str_radix(text, 16).unwrap_or_else(|error| panic!("{text}: {error}"))
}
