//! What all writers share: what they write, PNG and PFM files.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use png::{BitDepth, ColorType, Compression, Encoder};

use super::pfm;
use crate::field::{LightField, Photo, Provenance, RayDepths, View};
use crate::io::save::{SaveError, atomic};
use crate::job::{Job, Stage};

/// What is written: a light field, and what is known beside it.
#[derive(Clone, Copy, Debug)]
pub struct FieldToWrite<'a> {
    /// The views.
    pub field: &'a LightField,
    /// Their ray depths, for the formats that hold them or need them.
    pub depths: Option<&'a RayDepths>,
    /// Where each ray's colour comes from, where several photos saw the scene.
    pub provenance: Option<&'a Provenance>,
    /// The photo that the light field was made from.
    pub photo: Option<&'a Photo>,
    /// The models that made it: id and sha256.
    pub models: &'a [(String, String)],
}

impl<'a> FieldToWrite<'a> {
    /// Views without anything else.
    pub fn new(field: &'a LightField) -> Self {
        Self { field, depths: None, provenance: None, photo: None, models: &[] }
    }

    /// The ray depths, or why the format cannot be written.
    pub(super) fn need_depths(&self, path: &Path) -> Result<&'a RayDepths, SaveError> {
        let why = || "this format needs ray depths, and the light field has none; measure them first".to_owned();
        self.depths.ok_or_else(|| SaveError::Encode { why: why(), path: path.to_owned() })
    }
}

/// Writes one file inside a folder that is written aside.
pub(super) fn file(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> std::io::Result<()>,
) -> Result<(), SaveError> {
    let fail = |error: std::io::Error| SaveError::from_io(&error, path);
    let mut out = BufWriter::with_capacity(1 << 18, File::create(path).map_err(fail)?);
    write(&mut out).and_then(|()| out.flush()).map_err(fail)
}

/// Writes one file by itself: whole or not at all.
pub(super) fn single(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<&mut File>) -> std::io::Result<()>,
) -> Result<(), SaveError> {
    atomic(path, |file| {
        let mut out = BufWriter::with_capacity(1 << 18, file);
        write(&mut out).and_then(|()| out.flush()).map_err(|error| SaveError::from_io(&error, path))
    })
}

/// Writes a PNG from its rows; the texts become `tEXt` chunks.
pub(in crate::io) fn png(
    out: impl Write,
    size: [u32; 2],
    (color, depth): (ColorType, BitDepth),
    texts: &[(&str, String)],
    rows: impl Iterator<Item = Vec<u8>>,
) -> std::io::Result<()> {
    let mut encoder = Encoder::new(out, size[0], size[1]);
    encoder.set_color(color);
    encoder.set_depth(depth);
    encoder.set_compression(Compression::Fast);
    for (key, text) in texts {
        encoder.add_text_chunk((*key).to_owned(), text.clone()).map_err(of_system)?;
    }
    let mut writer = encoder.write_header().map_err(of_system)?;
    let mut stream = writer.stream_writer().map_err(of_system)?;
    for row in rows {
        stream.write_all(&row)?;
    }
    stream.finish().map_err(of_system)?;
    writer.finish().map_err(of_system)
}

/// The system's own error, where it is one: the encoder's conversion keeps its words and not what it is.
fn of_system(error: png::EncodingError) -> std::io::Error {
    match error {
        png::EncodingError::IoError(error) => error,
        other => std::io::Error::other(other),
    }
}

/// RGB rows of RGBA pixels.
pub(super) fn rgb_rows(rgba: &[u8], width: u32) -> impl Iterator<Item = Vec<u8>> {
    rgba.chunks_exact(width as usize * 4).map(|row| row.chunks_exact(4).flat_map(|px| [px[0], px[1], px[2]]).collect())
}

/// Writes one view as an 8-bit RGB PNG.
pub(super) fn view_png(path: &Path, view: &View) -> Result<(), SaveError> {
    let [width, _] = view.size();
    file(path, |out| png(out, view.size(), (ColorType::Rgb, BitDepth::Eight), &[], rgb_rows(view.rgba(), width)))
}

/// Writes one map as PFM.
pub(super) fn map_pfm(path: &Path, size: [u32; 2], values: &[f32]) -> Result<(), SaveError> {
    file(path, |out| pfm::write_pfm(out, size, values))
}

/// Writes all views, some at a time, under the names that `name` gives them.
pub(super) fn views(
    folder: &Path,
    field: &LightField,
    name: impl Fn(crate::field::ViewIndex) -> String + Sync,
    job: &Job,
) -> Result<(), SaveError> {
    use rayon::prelude::*;
    let all: Vec<_> = field.grid().views().collect();
    let done = std::sync::atomic::AtomicU32::new(0);
    all.par_iter().try_for_each(|&at| {
        view_png(&folder.join(name(at)), field.view(at))?;
        let done = done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1;
        Ok(job.advance(Stage::Save, done, all.len() as u32)?)
    })
}
