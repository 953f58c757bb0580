//! What the program says: answers on stdout, one line of error on stderr.

use std::io::{ErrorKind, Write};

use anyhow::{Result, anyhow};
use serde::Serialize;

/// Writes an answer to stdout. A reader that has gone away (`| head`) is no error.
pub fn say(text: &str) -> Result<()> {
    write_out(format!("{text}\n").as_bytes())
}

/// Writes one JSON object to stdout.
pub fn say_json(object: &impl Serialize) -> Result<()> {
    let text = serde_json::to_string_pretty(object)
        .map_err(|error| anyhow!("the answer cannot be written as JSON — {error} — leave --json out"))?;
    say(&text)
}

/// Writes bytes to stdout.
pub fn write_out(bytes: &[u8]) -> Result<()> {
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(bytes).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(anyhow!("the answer cannot be written — {error} — look where stdout goes"))
        }
        _ => Ok(()),
    }
}
