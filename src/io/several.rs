//! Files that hold several pictures of one subject: animations, motion-JPEG films, stereo pairs side by side, MPO,
//! spatial photos; and folders of photos.

use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use image::codecs::{gif::GifDecoder, png::PngDecoder, webp::WebPDecoder};
use image::{AnimationDecoder, Frames, ImageDecoder, ImageFormat};

use super::formats::phone::heic;
use super::open::{open_content, read_file};
use super::raster::{self, Raster, Samples};
use super::{OpenError, Opened, PhotoFile, Problem, avi, folder, formats, jpeg_parts};
use crate::field::{Photo, Size};
use crate::job::Job;

/// What names of pictures with both eyes beside each other end in.
const SIDE_BY_SIDE: [&str; 2] = ["_sbs", "-sbs"];
/// A picture of both eyes is at least this much wider than tall.
const WIDE: u32 = 2;
/// Most pictures of an animation or a film that are kept.
const MOST: usize = 40;
/// Type of a picture in an MPO that another eye sees (CIPA DC-007, "disparity").
const OTHER_EYE: u32 = 0x02_0002;

/// The files that paths stand for: those of a folder in natural order.
///
/// # Errors
/// A folder that cannot be read, or has no pictures.
pub fn listed(paths: &[PathBuf]) -> Result<Vec<PathBuf>, OpenError> {
    let mut all = Vec::with_capacity(paths.len());
    for path in paths {
        if path.is_dir() {
            let found = folder::pictures(path).map_err(Problem::from);
            let found = found.and_then(|found| if found.is_empty() { Err(Problem::EmptyFolder) } else { Ok(found) });
            all.extend(found.map_err(OpenError::at(Some(path)))?);
        } else {
            all.push(path.clone());
        }
    }
    Ok(all)
}

/// The photos of a folder in natural order; none where the path is no folder, is a light field, or has no pictures.
pub fn folder_of_photos(path: &Path, job: &Job) -> Option<Vec<PathBuf>> {
    let is_plain = path.is_dir() && matches!(formats::read_folder(path, job), Ok(None));
    let found = is_plain.then(|| folder::pictures(path).ok()).flatten();
    found.filter(|found| !found.is_empty())
}

/// The photos of a file, one after the other; mostly there is one.
///
/// # Errors
/// [`OpenError`]: it cannot be read, or is a light field.
pub fn photos(path: &Path, job: &Job) -> Result<Vec<PhotoFile>, OpenError> {
    read(path, job).map_err(OpenError::at(Some(path)))
}

fn read(path: &Path, job: &Job) -> Result<Vec<PhotoFile>, Problem> {
    let bytes = read_file(path)?;
    job.check()?;
    for frames in [animation(&bytes, job)?, film(&bytes, job)?] {
        if frames.len() > 1 {
            return Ok(frames);
        }
    }
    let photo = |bytes: &[u8]| match open_content(bytes, Some(path), job)? {
        Opened::Photo(file) => Ok(*file),
        Opened::LightField(file) => Err(Problem::Unsupported {
            format: file.info.format,
            reason: "it is a light field already".to_owned(),
            advice: "open it by itself",
        }),
    };
    let first = photo(&bytes)?;
    if is_side_by_side(path) && first.photo.size()[0] >= WIDE * first.photo.size()[1] {
        return halves(&first);
    }
    let others = mpo(&bytes).into_iter().filter_map(|bytes| photo(bytes).ok()).collect::<Vec<_>>();
    Ok(std::iter::once(first).chain(others).chain(heic::other_eye(&bytes)).collect())
}

fn is_side_by_side(path: &Path) -> bool {
    let stem = path.file_stem().map(|stem| stem.to_string_lossy().to_lowercase()).unwrap_or_default();
    SIDE_BY_SIDE.iter().any(|ending| stem.ends_with(ending))
}

/// Both halves of a picture, left first.
fn halves(file: &PhotoFile) -> Result<Vec<PhotoFile>, Problem> {
    let photo = &file.photo;
    let [width, height] = photo.size();
    let half = width / 2;
    let cut = |first: u32| -> Result<PhotoFile, Problem> {
        let rows = photo.srgb8().chunks_exact(width as usize * 4);
        let part = first as usize * 4..(first + half) as usize * 4;
        let rgba = rows.flat_map(|row| row[part.clone()].iter().copied()).collect();
        let mut cut = Photo::from_srgb8([half, height], rgba)?;
        if let Some(source) = photo.source() {
            cut = cut.with_source(source);
        }
        let mut info = file.info.clone();
        info.size = [half, height];
        Ok(PhotoFile { photo: Arc::new(cut), depth: None, carried: None, splats: None, info, warnings: Vec::new() })
    };
    Ok(vec![cut(0)?, cut(width - half)?])
}

/// Width, height and frames of a GIF, WebP or APNG that moves; nothing is decoded yet.
fn frames(bytes: &[u8]) -> Option<((u32, u32), Frames<'_>)> {
    let from = || Cursor::new(bytes);
    match image::guess_format(bytes).ok()? {
        ImageFormat::Gif => {
            let mut decoder = GifDecoder::new(from()).ok()?;
            decoder.set_limits(raster::still::limits_of_frames(decoder.dimensions())).ok()?;
            Some((decoder.dimensions(), decoder.into_frames()))
        }
        ImageFormat::WebP => {
            let decoder = WebPDecoder::new(from()).ok()?;
            decoder.has_animation().then(|| (decoder.dimensions(), decoder.into_frames()))
        }
        ImageFormat::Png => {
            let mut decoder = PngDecoder::with_limits(from(), raster::still::limits_beside()).ok()?;
            decoder.set_limits(raster::still::limits_of_frames(decoder.dimensions())).ok()?;
            let moves = decoder.is_apng().ok()?;
            let size = decoder.dimensions();
            moves.then(|| decoder.apng().ok()).flatten().map(|decoder| (size, decoder.into_frames()))
        }
        _ => None,
    }
}

/// The pictures of a GIF, WebP or APNG that moves; none of other files. Of many, some that are evenly apart.
fn animation(bytes: &[u8], job: &Job) -> Result<Vec<PhotoFile>, Problem> {
    // A broken one is told of where it is opened as a photo.
    let Some(((width, height), frames)) = frames(bytes) else { return Ok(Vec::new()) };
    // Before the first frame, for which a decoder takes the memory of the whole canvas.
    raster::check_size(width.into(), height.into(), 4 * MOST as u64, bytes.len().max(1 << 20))?;
    let (mut kept, mut every) = (Vec::new(), 1);
    for (number, frame) in frames.enumerate() {
        job.check()?;
        let Ok(frame) = frame else { break };
        if number % every != 0 {
            continue;
        }
        let picture = frame.into_buffer();
        let size: Size = [picture.width(), picture.height()];
        kept.push((size, picture.into_raw()));
        if kept.len() == 2 * MOST {
            let mut index = 0;
            kept.retain(|_| {
                index += 1;
                index % 2 == 1
            });
            every *= 2;
        }
    }
    kept.truncate(MOST);
    let file = |(size, rgba): (Size, Vec<u8>)| {
        let samples = Samples::Eight(rgba.as_chunks().0.to_vec());
        let (icc, exif, xmp, warnings) = (None, None, None, Vec::new());
        let raster = Raster { size, samples, has_alpha: true, icc, exif, xmp, orientation: 1, warnings };
        PhotoFile::from_raster(raster, "animation")
    };
    kept.into_iter().map(file).collect()
}

/// The pictures of a motion-JPEG film; none of other files. Of many, some that are evenly apart; what is damaged is left out.
fn film(bytes: &[u8], job: &Job) -> Result<Vec<PhotoFile>, Problem> {
    let all = avi::pictures(bytes);
    let count = all.len().min(MOST);
    let mut kept = Vec::with_capacity(count);
    for i in 0..count {
        job.check()?;
        kept.extend(avi::photo(all[i * all.len() / count]).ok());
    }
    Ok(kept)
}

/// The pictures of other eyes in a JPEG, as the index of its multi-picture format names them.
fn mpo(bytes: &[u8]) -> Vec<&[u8]> {
    /// Marker of application segment 2, and what an index begins with.
    const APP2: u8 = 0xe2;
    const HEAD: &[u8] = b"MPF\0";
    /// Tag of the list of pictures, and bytes of each.
    const ENTRIES: u32 = 0xb002;
    const ENTRY: usize = 16;
    if !bytes.starts_with(&[0xff, 0xd8]) {
        return Vec::new();
    }
    let parts = jpeg_parts::parse(bytes);
    let Some(index) = parts.segments.iter().find(|s| s.marker == APP2 && s.data.starts_with(HEAD)) else {
        return Vec::new();
    };
    let tiff = &index.data[HEAD.len()..];
    // Offsets count from the index's own head, which lies somewhere in the file.
    let base = tiff.as_ptr() as usize - bytes.as_ptr() as usize;
    let is_little = tiff.starts_with(b"II");
    let number = |at: usize, len: usize| -> Option<u32> {
        let bytes = tiff.get(at..at + len)?.iter();
        let add = |all: u32, byte: &u8| (all << 8) | u32::from(*byte);
        Some(if is_little { bytes.rev().fold(0, add) } else { bytes.fold(0, add) })
    };
    let pictures = || -> Option<Vec<&[u8]>> {
        let directory = number(4, 4)? as usize;
        let count = number(directory, 2)? as usize;
        let entry = (0..count).map(|i| directory + 2 + 12 * i).find(|at| number(*at, 2) == Some(ENTRIES))?;
        let (length, list) = (number(entry + 4, 4)? as usize, number(entry + 8, 4)? as usize);
        let other = |i: usize| {
            let at = list.checked_add(i * ENTRY)?;
            let (kind, size, offset) = (number(at, 4)? & 0xff_ffff, number(at + 4, 4)?, number(at + 8, 4)?);
            let start = base.checked_add(offset as usize)?;
            let end = start.checked_add(size as usize)?;
            if kind == OTHER_EYE && offset != 0 { bytes.get(start..end) } else { None }
        };
        Some((0..(length / ENTRY).min(MOST)).filter_map(other).collect())
    };
    pictures().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::Cancel;

    /// A GIF of 24×16 with one frame of another size.
    fn gif(width: u16, height: u16) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = gif::Encoder::new(&mut bytes, 24, 16, &[0, 0, 0, 255, 255, 255]).unwrap();
        let buffer = vec![1; usize::from(width) * usize::from(height)].into();
        encoder.write_frame(&gif::Frame { width, height, buffer, ..gif::Frame::default() }).unwrap();
        drop(encoder);
        bytes
    }

    #[test]
    fn a_frame_far_larger_than_its_canvas_takes_no_memory() {
        let first = |bytes: &[u8]| frames(bytes).unwrap().1.next().unwrap().is_ok();
        assert!(first(&gif(24, 16)) && first(&gif(600, 400)));
        assert!(!first(&gif(5000, 5000)));
        let job = Job { cancel: &Cancel::default(), sink: &() };
        let as_one_picture = |bytes: &[u8]| open_content(bytes, None, &job).is_ok();
        assert!(as_one_picture(&gif(600, 400)) && !as_one_picture(&gif(5000, 5000)));
    }
}
