//! A net is read in a process of its own first ([`apart`](crate::apart)): a small file can ask for any amount of memory or
//! time while its graph is read and its constants are computed.

use std::io;
use std::path::Path;
use std::process::Child;
use std::thread;
use std::time::Duration;

use super::error::AdoptError;
use super::reading::Reading;
use crate::apart::{Bounds, Work};
use crate::job::{Cancel, Cancelled};
use crate::synth::memory;

/// Memory that the reading of a net may take, where so much is free.
const MOST_BYTES: u64 = 16 << 30;
/// Large nets take half a minute on slow machines.
const SECS: u64 = 300;
/// How often the cancel flag is looked at meanwhile.
const LOOK: Duration = Duration::from_millis(10);

/// Refuses a file that breaks the process that reads it. What else is wrong with it is not told here.
pub(super) fn check(path: &Path, picture: [u32; 2], cancel: &Cancel) -> Result<(), AdoptError> {
    let work = Work::ReadNet { path: path.to_owned(), picture };
    let Some(mut command) = work.command() else { return Ok(()) };
    match command.spawn() {
        Ok(child) => Reader(child).check(path, cancel),
        Err(error) => {
            log::warn!("no process can be started to read a net, so it is read here: {error}");
            Ok(())
        }
    }
}

/// Reads a net within limits, as [`adopt`](super::adopt()) does for a picture of so many pixels. Only whether that comes to
/// an end is told.
///
/// # Errors
/// Limits that the system does not set.
pub fn serve(path: &Path, picture: [u32; 2]) -> io::Result<()> {
    let memory = memory::free_bytes().map_or(MOST_BYTES, |free| free.min(MOST_BYTES));
    Bounds { memory, secs: SECS, is_shut: false }.set()?;
    // What is wrong with it is found again, and said, by whoever asked.
    _ = Reading::of(path, picture, &Cancel::default());
    Ok(())
}

/// A process that reads a net; whoever asked does not leave it behind.
struct Reader(Child);

impl Reader {
    fn check(mut self, path: &Path, cancel: &Cancel) -> Result<(), AdoptError> {
        loop {
            match self.0.try_wait().map_err(AdoptError::read(path))? {
                Some(status) if status.success() => return Ok(()),
                Some(status) => {
                    log::warn!("the process that read {} ended: {status}", path.display());
                    return Err(AdoptError::Unreadable { path: path.to_owned() });
                }
                None if cancel.is_cancelled() => return Err(Cancelled.into()),
                None => thread::sleep(LOOK),
            }
        }
    }
}

impl Drop for Reader {
    fn drop(&mut self) {
        // It has ended, or nobody waits for it.
        _ = self.0.kill();
        _ = self.0.wait();
    }
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use std::process::Command;

    use super::*;

    fn asked(program: &str, argument: &str, cancel: &Cancel) -> Result<(), AdoptError> {
        Reader(Command::new(program).arg(argument).spawn().unwrap()).check(Path::new("a.onnx"), cancel)
    }

    #[test]
    fn however_the_reader_ends_it_is_nothing_or_one_sentence() {
        assert!(asked("/bin/true", "", &Cancel::default()).is_ok());
        let said = asked("/bin/false", "", &Cancel::default()).unwrap_err();
        assert!(matches!(said, AdoptError::Unreadable { .. }), "{said}");
        assert_eq!(said.to_string().matches(" — ").count(), 2, "{said}");
    }

    #[test]
    fn a_reader_is_not_waited_for_once_it_was_stopped() {
        let cancel = Cancel::default();
        cancel.cancel();
        assert!(matches!(asked("/bin/sleep", "1000", &cancel), Err(AdoptError::Cancelled(_))));
    }
}
