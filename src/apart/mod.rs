//! Work that a stranger's file could break is done in a process of its own, so that its faults are not ours.
//!
//! The process is this program again, with limits (`bounds`): its memory and time end somewhere. A program that has not said how
//! it is started for such work ([`work_with`]), as Python's interpreter or a test, does the work within itself.

mod bounds;

use std::ffi::OsString;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::sync::OnceLock;

pub(crate) use bounds::Bounds;

/// The program that works for others; none works here.
static PROGRAM: OnceLock<PathBuf> = OnceLock::new();

/// First arguments of a program that is started for another.
const DECODE: &str = "--decode-for-another";
const READ_NET: &str = "--read-net-for-another";

/// What a program is started for, as its arguments say.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Work {
    /// To decode a picture: [`io::decoder::serve`](crate::io::decoder::serve).
    Decode,
    /// To read a net as if it were to be added: [`synth::adopt::serve`](crate::synth::adopt::serve).
    ReadNet {
        /// Its ONNX file.
        path: PathBuf,
        /// Width and height of the picture that it would be given.
        picture: [u32; 2],
    },
}

impl Work {
    /// What the arguments of a program ask for; none where they are a person's.
    pub fn asked_for(arguments: impl Iterator<Item = OsString>) -> Option<Self> {
        let number = |text: &OsString| text.to_str()?.parse().ok();
        match &*arguments.skip(1).collect::<Vec<_>>() {
            [work] if work == DECODE => Some(Self::Decode),
            [work, path, width, height] if work == READ_NET => {
                Some(Self::ReadNet { path: path.into(), picture: [number(width)?, number(height)?] })
            }
            _ => None,
        }
    }

    /// How a program is started for this, silent and deaf; none where it is to be done here.
    pub(crate) fn command(&self) -> Option<Command> {
        let mut command = Command::new(PROGRAM.get()?);
        match self {
            Self::Decode => command.arg(DECODE),
            Self::ReadNet { path, picture } => {
                command.arg(READ_NET).arg(path).args(picture.map(|side| side.to_string()))
            }
        };
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
        Some(command)
    }
}

/// From now on this program does what could break: started with arguments that [`Work::asked_for`] knows, it has
/// to serve that work. The first one stays.
pub fn work_with(program: PathBuf) {
    PROGRAM.get_or_init(|| program);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asked(arguments: &[&str]) -> Option<Work> {
        Work::asked_for(arguments.iter().map(OsString::from))
    }

    #[test]
    fn only_its_own_arguments_ask_for_work() {
        assert_eq!(asked(&["plenoscope", DECODE]), Some(Work::Decode));
        let net = Work::ReadNet { path: "a net.onnx".into(), picture: [640, 480] };
        assert_eq!(asked(&["plenoscope", READ_NET, "a net.onnx", "640", "480"]), Some(net));
        for others in [
            &["plenoscope"][..],
            &["plenoscope", "info", DECODE],
            &["plenoscope", DECODE, "x"],
            &["plenoscope", READ_NET, "a net.onnx", "640"],
            &["plenoscope", READ_NET, "a net.onnx", "640", "-1"],
        ] {
            assert_eq!(asked(others), None, "{others:?}");
        }
    }
}
