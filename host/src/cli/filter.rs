//! What `plan` and `simulate` share: one JSON request a line in, one JSON answer a line out, flushed; a line that is
//! no request gives an `{"error": …}` line and the stream goes on.

use std::io::{BufRead, Read, Write};

use reader::Document;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::{Failure, complain, written};

/// No line is longer, bytes; a request to `plan` for 1024 modules has less than a tenth of it.
const LINE_MAX: u64 = 1 << 20;

#[derive(Serialize)]
struct Refusal {
    error: String,
}

/// Answers line by line until the input ends or the output is closed; `answer` is told the line's number, from 1.
pub(super) fn run(mut answer: impl FnMut(u64, &str) -> Result<String, String>) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    let mut bad = 0;
    let mut input = std::io::stdin().lock();
    for number in 1_u64.. {
        let line =
            next_line(&mut input).map_err(|error| Failure::Could(format!("standard input: {error}")))?;
        let Some(line) = line else { break };
        let answer = match line.and_then(|line| answer(number, &line)) {
            Ok(answer) => answer,
            Err(error) => {
                bad += 1;
                complain(&format!("line {number}: {error}"));
                serde_json::to_string(&Refusal { error }).unwrap_or_default()
            }
        };
        let outcome = writeln!(out, "{answer}").and_then(|()| out.flush());
        let gone = outcome.is_err();
        written(outcome)?;
        if gone {
            return Ok(());
        }
    }
    if bad == 0 { Ok(()) } else { Err(Failure::Bad(String::new())) }
}

/// A request, or what is wrong with it and where.
pub(super) fn read<T: DeserializeOwned>(line: &str) -> Result<T, String> {
    // Its line is always 1: which request of the stream it is, is said elsewhere.
    Document::json(line)
        .and_then(|document| document.read())
        .map_err(|mistake| format!("column {}: {}", mistake.column, mistake.message))
}

/// The next line, or why it is none; nothing at the end of the input.
fn next_line(input: &mut impl BufRead) -> std::io::Result<Option<Result<String, String>>> {
    let mut line = Vec::new();
    if input.take(LINE_MAX).read_until(b'\n', &mut line)? == 0 {
        return Ok(None);
    }
    if line.len() as u64 == LINE_MAX && !line.ends_with(b"\n") {
        input.skip_until(b'\n')?;
        return Ok(Some(Err(format!("is longer than {LINE_MAX} bytes"))));
    }
    Ok(Some(match String::from_utf8(line) {
        // One line out for each in: a program that waits for the answer to an empty line must not wait for ever.
        Ok(line) if line.trim().is_empty() => Err("is empty: a request is a JSON object".to_owned()),
        // Without its end, so that what is cut short is told at its last column.
        Ok(line) => Ok(line.trim_end().to_owned()),
        Err(error) => Err(format!("column {}: is not UTF-8", error.utf8_error().valid_up_to() + 1)),
    }))
}
