//! Why a file did not open, in one sentence: what — why — what to do, path last.

use std::path::{Path, PathBuf};

use crate::field::FieldError;
use crate::job::Cancelled;

/// A file did not open.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// The caller stopped it.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// The file is at fault, or cannot be reached.
    #[error("{problem}{}", path.as_deref().map(|path| format!(": {}", path.display())).unwrap_or_default())]
    File {
        /// What is wrong with it.
        #[source]
        problem: Problem,
        /// The file or folder; none for bytes without a name.
        path: Option<PathBuf>,
    },
}

impl OpenError {
    /// A problem with a named file.
    pub(crate) fn at(path: Option<&Path>) -> impl FnOnce(Problem) -> Self {
        move |problem| match problem {
            Problem::Stopped(cancelled) => Self::Cancelled(cancelled),
            Problem::In { name, problem } => Self::File { problem: *problem, path: Some(name) },
            problem => Self::File { problem, path: path.map(Path::to_owned) },
        }
    }
}

/// What can be wrong with a file; parsers return it, [`OpenError`] adds the path.
#[derive(Debug, thiserror::Error)]
pub enum Problem {
    /// The system would not read it.
    #[error("could not read the file — {0} — check that it is there and that you may read it")]
    Read(#[from] std::io::Error),
    /// Nothing in it.
    #[error("could not open the file — it is empty — copy it again from where it came from")]
    Empty,
    /// No known start.
    #[error(
        "could not open the file — it is no picture and no light field — open a JPEG, PNG, WebP, TIFF, BMP, GIF, HEIC or AVIF photo, or a light field"
    )]
    Unknown,
    /// Known, but nobody here reads it.
    #[error("could not open the {format} file — {reason} — {advice}")]
    Unsupported {
        /// The format's name.
        format: &'static str,
        /// What it uses.
        reason: String,
        /// What to do.
        advice: &'static str,
    },
    /// Longer than what it should hold.
    #[error(
        "could not open the file — it has {length_kib} KiB, where {limit_kib} KiB are the most — choose another one"
    )]
    TooLong {
        /// Its length.
        length_kib: u64,
        /// The most that is read.
        limit_kib: u64,
    },
    /// It ends too early.
    #[error("could not open the {format} file — it is cut off — copy it again from where it came from")]
    Truncated {
        /// The format's name.
        format: &'static str,
    },
    /// Something in it contradicts itself.
    #[error(
        "could not open the {format} file — {reason} — copy it again, or save it anew with the program that made it"
    )]
    Damaged {
        /// The format's name.
        format: &'static str,
        /// What does not fit.
        reason: String,
    },
    /// More pixels than fit.
    #[error(
        "could not open the file — its header says {width}×{height} pixels, more than fit into {limit_mib} MiB — scale it down first"
    )]
    TooLarge {
        /// Width in the header.
        width: u64,
        /// Height in the header.
        height: u64,
        /// Most bytes of decoded pixels.
        limit_mib: u64,
    },
    /// More pixels than the file's length can stand for.
    #[error(
        "could not open the file — its header says {width}×{height} pixels, and it has only {file_kib} KiB — copy it again, or save it anew with the program that made it"
    )]
    Implausible {
        /// Width in the header.
        width: u64,
        /// Height in the header.
        height: u64,
        /// Length of the file.
        file_kib: usize,
    },
    /// A view is not there.
    #[error(
        "could not open the light field — view (v {v}, u {u}) of {rows}×{cols} is missing — put the file back into the folder"
    )]
    MissingView {
        /// Row.
        v: usize,
        /// Column.
        u: usize,
        /// Rows of the grid.
        rows: usize,
        /// Columns of the grid.
        cols: usize,
    },
    /// A view of another size than the others.
    #[error(
        "could not open the light field — one view has {width}×{height} pixels, the others {}×{} — make all views with one size", others[0], others[1]
    )]
    OddView {
        /// Its width.
        width: u32,
        /// Its height.
        height: u32,
        /// Width and height of the first view.
        others: [u32; 2],
    },
    /// Views and maps do not fit together.
    #[error("could not open the light field — {0} — make all views again with one size")]
    Field(#[from] FieldError),
    /// A disparity map with values that are no numbers.
    #[error(transparent)]
    Map(FieldError),
    /// A picture that no light passes, or too large for what it is.
    #[error("this picture cannot be the opening of a lens — {0} — take a small one in which white is open")]
    Opening(String),
    /// A folder without anything to open.
    #[error("could not open the folder — it holds no picture and no light field — choose another one")]
    EmptyFolder,
    /// Opened again, it is another picture.
    #[error("the photo has changed since it was opened — its file has another size now — open it again")]
    Changed,
    /// The problem is in another file than the one that was opened.
    #[error("{problem}: {}", name.display())]
    In {
        /// That file.
        name: PathBuf,
        /// What is wrong with it.
        problem: Box<Problem>,
    },
    /// The caller stopped it.
    #[error(transparent)]
    Stopped(#[from] Cancelled),
}

impl Problem {
    /// The same problem, told of a file inside the opened folder.
    pub(crate) fn of(path: &Path) -> impl FnOnce(Self) -> Self {
        move |problem| match problem {
            stopped @ (Self::Stopped(_) | Self::In { .. }) => stopped,
            problem => Self::In { name: path.to_owned(), problem: Box::new(problem) },
        }
    }

    /// Something in the file contradicts itself.
    pub(crate) fn damaged(format: &'static str, reason: impl ToString) -> Self {
        Self::Damaged { format, reason: part_of_a_sentence(&reason.to_string()) }
    }
}

/// What a library says, which may quote the file, as a part of one sentence: in one line, short, without full stop.
pub(crate) fn part_of_a_sentence(text: &str) -> String {
    const MOST_CHARS: usize = 200;
    let printable: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    let line = printable.split_whitespace().collect::<Vec<_>>().join(" ");
    line.trim_end_matches('.').chars().take(MOST_CHARS).collect()
}
