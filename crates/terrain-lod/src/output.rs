//! What goes to stdout: results, whole and at once.

use std::io::{ErrorKind, Write};

use crate::fault::{Cause, Fault};

/// Six decimals: more than any of our numbers means, and the same text on every machine.
pub fn tidy(number: f64) -> f64 {
    (number * 1e6).round() / 1e6
}

/// Prints a text. A reader that has seen enough (`| head`) is no failure.
pub fn print(text: &str) -> Result<(), Fault> {
    match std::io::stdout().lock().write_all(text.as_bytes()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Fault::new(Cause::Io, format_args!("cannot write to stdout: {error}")))
        }
        _ => Ok(()),
    }
}
