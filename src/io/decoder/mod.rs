//! Decoders that are ports of C work in a process of their own ([`apart`](crate::apart)).
//!
//! The process gets the file and the task through a pipe and answers through another (`wire`). It can open no file, no
//! connection and no other program. However it ends, the answer is a picture or one sentence. Where the decoder works
//! within this program, panics are caught.

mod wire;

use std::io::{self, BufReader, Write};
use std::process::{Child, Stdio};

use super::Problem;
use super::raster::Samples;
use crate::apart::{Bounds, Work};
use crate::panics;
pub(crate) use wire::Task;

/// Twice what the largest picture takes, its planes, and what its threads need.
const BOUNDS: Bounds = Bounds { memory: 6 << 30, secs: 120, is_shut: true };

/// What a decoder makes of a file.
#[derive(Debug)]
pub(crate) struct Decoded {
    pub(crate) size: [u32; 2],
    pub(crate) pixels: RgbaPixels,
    pub(crate) has_alpha: bool,
    /// What else the decoder says, by task: nothing, the largest value, or colours by number.
    pub(crate) told: [u16; 4],
}

/// RGBA pixels as a decoder has them: one that gives plain bytes need not copy them before they go through the pipe.
#[derive(Debug)]
pub(crate) enum RgbaPixels {
    Bytes(Vec<u8>),
    Samples(Samples),
}

impl RgbaPixels {
    pub(crate) fn into_samples(self) -> Samples {
        match self {
            Self::Bytes(bytes) => Samples::Eight(bytes.as_chunks().0.to_vec()),
            Self::Samples(samples) => samples,
        }
    }
}

/// Does one task from stdin, within limits, and answers on stdout.
///
/// # Errors
/// Pipes that break; limits that the system does not set.
pub fn serve() -> io::Result<()> {
    let (task, bytes) = wire::read_request(&mut io::stdin().lock())?;
    BOUNDS.set()?;
    let answer = here(task, &bytes);
    let mut stdout = io::stdout().lock();
    wire::write_answer(&mut stdout, &answer)?;
    stdout.flush()
}

/// Does a task, elsewhere where that has been said.
pub(crate) fn decode(task: Task, bytes: &[u8]) -> Result<Decoded, Problem> {
    let Some(mut command) = Work::Decode.command() else { return here(task, bytes) };
    match command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn() {
        Ok(child) => Asked(child).answer(task, bytes),
        Err(error) => {
            log::warn!("a decoder cannot be started, so the picture is decoded here: {error}");
            here(task, bytes)
        }
    }
}

fn here(task: Task, bytes: &[u8]) -> Result<Decoded, Problem> {
    panics::caught(|| task.decode(bytes)).unwrap_or_else(|| Err(broke(task)))
}

fn broke(task: Task) -> Problem {
    Problem::damaged(task.format(), "its decoder cannot make sense of it")
}

/// A decoder at work; whoever asked does not leave it behind.
struct Asked(Child);

impl Asked {
    fn answer(mut self, task: Task, bytes: &[u8]) -> Result<Decoded, Problem> {
        let (Some(stdin), Some(stdout)) = (self.0.stdin.take(), self.0.stdout.take()) else { return Err(broke(task)) };
        #[cfg(target_os = "linux")]
        for pipe in [std::os::fd::AsFd::as_fd(&stdin), std::os::fd::AsFd::as_fd(&stdout)] {
            // Fewer turns; a system that does not allow it takes more of them.
            let _ = rustix::pipe::fcntl_setpipe_size(pipe, 1 << 20);
        }
        let mut stdin = stdin;
        // One that broke off no longer listens; it shows below.
        let _ = wire::write_request(&mut stdin, task, bytes);
        drop(stdin);
        match wire::read_answer(&mut BufReader::with_capacity(1 << 16, stdout), task) {
            Ok(answer) => answer,
            Err(error) => {
                let _ = self.0.kill();
                let status = self.0.wait();
                log::warn!("a decoder broke off: {error}, {status:?}");
                Err(broke(task))
            }
        }
    }
}

impl Drop for Asked {
    fn drop(&mut self) {
        // It has answered, or it was killed: neither takes long.
        let _ = self.0.wait();
    }
}

#[cfg(test)]
mod tests {
    use std::process::Command;

    use super::*;

    /// Asks a program that is no decoder.
    #[cfg(unix)]
    fn ask(program: &str) -> Problem {
        let mut command = Command::new(program);
        let child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        Asked(child).answer(Task::Avif, &[7; 1 << 20]).unwrap_err()
    }

    #[cfg(unix)]
    #[test]
    fn however_a_decoder_ends_it_is_one_sentence() {
        // One that ends at once, and one that says the wrong thing.
        for program in ["/bin/false", "/bin/cat"] {
            let said = ask(program).to_string();
            assert!(
                said.contains("AVIF") && said.contains("its decoder") && said.matches(" — ").count() == 2,
                "{said}"
            );
        }
    }
}
