//! `info`: what a file is.

use anyhow::Result;
use plenoscope::io::{self, FileInfo, FileKind};
use plenoscope::job::Job;

use crate::cli::Info;
use crate::output::{say, say_json};

/// Opens the file and says what it is.
pub fn run(args: &Info, job: &Job) -> Result<()> {
    let opened = io::open(&args.file, job)?;
    let info = opened.info();
    if args.json {
        return say_json(info);
    }
    for warning in &info.warnings {
        job.sink.warning(warning.clone());
    }
    say(&describe(info))
}

/// The same for a person: one line for each thing that is known.
fn describe(info: &FileInfo) -> String {
    let kind = match info.kind {
        FileKind::Photo => "photo",
        FileKind::LightField => "light field",
        FileKind::Splats => "splats",
    };
    let mut lines = vec![("kind", kind.to_owned()), ("format", info.format.to_owned())];
    lines.push(("size", format!("{} × {} px, {} bits", info.size[0], info.size[1], info.bits)));
    if let Some([rows, cols]) = info.views {
        lines.push(("views", format!("{rows} × {cols}")));
    }
    if info.kind == FileKind::Photo {
        lines.push(("orientation", info.orientation.to_string()));
        lines.push(("profile", info.profile.clone().unwrap_or_else(|| "sRGB (none named)".to_owned())));
    }
    if let Some(depth) = &info.embedded_depth {
        let reach = depth.range_m.map(|[near, far]| format!(", {near:.2} … {far:.2} m")).unwrap_or_default();
        lines.push(("depth", format!("{} × {} px, {}{reach}", depth.size[0], depth.size[1], depth.kind)));
    }
    if let Some(f35_mm) = info.f35_mm {
        lines.push(("focal length", format!("{f35_mm} mm as on 35-mm film")));
    }
    if let Some([far, near]) = info.disparity_px {
        lines.push(("disparity", format!("{far:.2} … {near:.2} px per view step")));
    }
    let known = lines.iter().map(|(name, text)| format!("{name:14}{text}"));
    let notes = info.notes.iter().map(|(name, text)| format!("{name:14}{text}"));
    known.chain(notes).collect::<Vec<_>>().join("\n")
}
