//! AVIF photos (AV1 Image File Format, version 1.1): stills and grids of them, decoded by rav1d, the port of dav1d.
//!
//! Of what may lie beside the picture, opacity, colour profile, EXIF and XMP are taken; depth maps are not.

mod coded;
#[cfg(test)]
mod tests;
mod yuv;

use std::sync::OnceLock;

use heifer::heifer_isobmff::boxes::Property;
use heifer::heifer_isobmff::{Error, HeifFile, ItemId};
use rayon::prelude::*;

use super::heif::{self, Cicp};
use super::{Channel, Raster, Samples, check_size, color, hdr};
use crate::field::sides;
use crate::io::Problem;
use crate::io::decoder::{self, Decoded, RgbaPixels, Task};
use crate::io::file_type::{FileType, Pixels};
use coded::Coded;

pub(crate) const FORMAT: &str = "AVIF";
/// AVIF pictures.
pub(crate) const TYPE: FileType = FileType {
    name: FORMAT,
    suffixes: &["avif"],
    begins: heif::is_avif,
    pixels: Some(Pixels { decode: |bytes, _| decode(bytes), header_size: |bytes, _| header_size(bytes) }),
    ..FileType::UNKNOWN
};
const ALPHA_URN: [&str; 2] = ["urn:mpeg:mpegB:cicp:systems:auxiliary:alpha", "urn:mpeg:hevc:2015:auxid:1"];

fn parse(bytes: &[u8]) -> Result<HeifFile<'_>, Problem> {
    HeifFile::parse(bytes).map_err(|error| match error {
        Error::MissingBox(kind) if kind.0 == *b"meta" && bytes.starts_with(b"\0\0\0") && is_sequence(bytes) => {
            unsupported("it is a film without a still".to_owned())
        }
        error => problem(error),
    })
}

fn is_sequence(bytes: &[u8]) -> bool {
    bytes.windows(4).take(1 << 16).any(|four| four == b"moov")
}

fn problem(error: impl std::fmt::Display) -> Problem {
    let text = error.to_string();
    if text.contains("unexpected end") { Problem::Truncated { format: FORMAT } } else { Problem::damaged(FORMAT, text) }
}

fn unsupported(reason: String) -> Problem {
    Problem::Unsupported { format: FORMAT, reason, advice: "save it as JPEG or PNG" }
}

/// Width and height from the header, before turns.
fn header_size(bytes: &[u8]) -> Result<[u32; 2], Problem> {
    let file = parse(bytes)?;
    Ok(Tiling::of(&file, file.primary_id, bytes.len())?.size)
}

/// Decodes the main picture.
fn decode(bytes: &[u8]) -> Result<Raster, Problem> {
    let file = parse(bytes)?;
    let id = file.primary_id;
    // What cannot be a picture need not be tried.
    let whole = Tiling::of(&file, id, bytes.len())?.size;
    let Decoded { size, pixels, has_alpha, told } = decoder::decode(Task::Avif, bytes)?;
    if size != whole {
        return Err(Problem::damaged(FORMAT, "its picture has another size than its header says"));
    }
    let cicp = Cicp { primaries: told[0], transfer: told[1], matrix: told[2], full_range: told[3] != 0 };
    let mut samples = pixels.into_samples();
    let mut warnings = Vec::new();
    let icc = file.icc_profile(id).ok().flatten().filter(|icc| color::is_rgb(icc)).map(<[u8]>::to_vec);
    if icc.is_none() {
        let (sdr, changed) = hdr::to_sdr(samples, cicp.transfer);
        samples = sdr;
        warnings.extend(changed.then(|| hdr::WARNING.to_owned()));
    }
    let (size, samples) = match heif::clean_aperture(&file, id, whole) {
        Some(part) => (part.size, part.cut(samples, whole)),
        None => (whole, samples),
    };
    Ok(Raster {
        size,
        samples,
        has_alpha,
        icc: icc.or_else(|| cicp.profile()),
        // Broken extras do not make a picture unreadable.
        exif: file.exif(id).ok().flatten(),
        xmp: file.xmp(id).ok().flatten(),
        // The container's turns; EXIF repeats them for those who do not know the container.
        orientation: heif::turn(&file, id),
        warnings,
    })
}

/// The decoder's part of it: all pixels, and the colours that they are told in by number.
pub(crate) fn decode_pixels(bytes: &[u8]) -> Result<Decoded, Problem> {
    let file = parse(bytes)?;
    let tiling = Tiling::of(&file, file.primary_id, bytes.len())?;
    let alpha = alpha_item(&file, file.primary_id).map(|alpha| Tiling::of(&file, alpha, bytes.len())).transpose()?;
    let is_deep = tiling.is_deep(&file) || alpha.as_ref().is_some_and(|alpha| alpha.is_deep(&file));
    let (samples, cicp) = if is_deep {
        let (pixels, cicp) = pixels(&file, &tiling, alpha.as_ref())?;
        (Samples::Sixteen(pixels), cicp)
    } else {
        let (pixels, cicp) = pixels(&file, &tiling, alpha.as_ref())?;
        (Samples::Eight(pixels), cicp)
    };
    let told = [cicp.primaries, cicp.transfer, cicp.matrix, u16::from(cicp.full_range)];
    Ok(Decoded { size: tiling.size, pixels: RgbaPixels::Samples(samples), has_alpha: alpha.is_some(), told })
}

/// Pictures of one size that are laid out row by row; one for a picture that is not a grid.
struct Tiling {
    size: [u32; 2],
    tile_size: [u32; 2],
    columns: usize,
    tiles: Vec<ItemId>,
}

impl Tiling {
    fn of(file: &HeifFile, id: ItemId, file_bytes: usize) -> Result<Self, Problem> {
        heif::check_parts(file, id, FORMAT)?;
        let tiling = match &file.item(id).map_err(problem)?.item_type.0 {
            b"av01" => Self { size: size(file, id)?, tile_size: size(file, id)?, columns: 1, tiles: vec![id] },
            b"grid" => Self::of_grid(file, id)?,
            other => return Err(unsupported(format!("its picture is of the kind '{}'", other.escape_ascii()))),
        };
        let [width, height] = tiling.size.map(u64::from);
        check_size(width, height, if tiling.is_deep(file) { 8 } else { 4 }, file_bytes)?;
        Ok(tiling)
    }

    /// A grid: its tiles cover it, and none lies outside (ISO/IEC 23008-12, 6.6.2.3).
    fn of_grid(file: &HeifFile, id: ItemId) -> Result<Self, Problem> {
        let grid = file.grid(id).map_err(problem)?;
        let tiles = file.referenced_items(id, b"dimg").to_vec();
        let [rows, columns] = [grid.rows, grid.columns].map(usize::from);
        if tiles.len() != rows * columns {
            let reason = format!("a grid of {rows}×{columns} pictures that has {}", tiles.len());
            return Err(Problem::damaged(FORMAT, reason));
        }
        let tile_size = size(file, tiles[0])?;
        for &tile in &tiles {
            if file.item(tile).map_err(problem)?.item_type.0 != *b"av01" || size(file, tile)? != tile_size {
                return Err(Problem::damaged(FORMAT, "the pictures of its grid do not belong together"));
            }
        }
        let whole = [grid.output_width, grid.output_height];
        let covered = |whole: u32, tile: u32, count: usize| {
            let (whole, tile, count) = (u64::from(whole), u64::from(tile), count as u64);
            tile * (count - 1) < whole && whole <= tile * count
        };
        if !covered(whole[0], tile_size[0], columns) || !covered(whole[1], tile_size[1], rows) {
            return Err(Problem::damaged(FORMAT, "the pictures of its grid do not cover it"));
        }
        Ok(Self { size: whole, tile_size, columns, tiles })
    }

    /// Whether it has more than 8 bits a channel (`av1C`: the second bit of the third byte).
    fn is_deep(&self, file: &HeifFile) -> bool {
        let flags = raw(file, self.tiles[0], *b"av1C").and_then(|config| config.get(2));
        flags.is_none_or(|flags| flags & 0x40 != 0)
    }

    /// Decodes all tiles and puts them together, a row of tiles at a time.
    fn assemble<P: Copy + Default + Send>(
        &self,
        file: &HeifFile,
        read: impl Fn(&Coded) -> Result<Vec<P>, Problem> + Sync,
    ) -> Result<Vec<P>, Problem> {
        let decode = |tile: &ItemId| {
            let data = file.item_data(*tile).map_err(problem)?;
            read(&coded::decode(&data, self.tile_size, operating_point(file, *tile))?)
        };
        if self.size == self.tile_size {
            return decode(&self.tiles[0]);
        }
        let [width, _] = sides(self.size);
        let [tile_width, tile_height] = sides(self.tile_size);
        let mut whole = vec![P::default(); width * self.size[1] as usize];
        for (band, tiles) in whole.chunks_mut(width * tile_height).zip(self.tiles.chunks(self.columns)) {
            let pixels: Vec<Vec<P>> = tiles.par_iter().map(decode).collect::<Result<_, _>>()?;
            for (y, row) in band.chunks_mut(width).enumerate() {
                for (to, tile) in row.chunks_mut(tile_width).zip(&pixels) {
                    to.copy_from_slice(&tile[y * tile_width..][..to.len()]);
                }
            }
        }
        Ok(whole)
    }
}

/// All pixels with their opacity, and the colours that they are told in.
fn pixels<T: Channel + Default + Send>(
    file: &HeifFile,
    tiling: &Tiling,
    alpha: Option<&Tiling>,
) -> Result<(Vec<[T; 4]>, Cicp), Problem> {
    let told = OnceLock::new();
    let told_by_container = Cicp::of(file, file.primary_id).or_else(|| Cicp::of(file, tiling.tiles[0]));
    let mut pixels: Vec<[T; 4]> = tiling
        .assemble(file, |coded| yuv::rgba(coded, *told.get_or_init(|| told_by_container.unwrap_or(coded.cicp))))?;
    if let Some(alpha) = alpha {
        if alpha.size != tiling.size {
            return Err(Problem::damaged(FORMAT, "its opacity has another size than the picture"));
        }
        let values: Vec<T> = alpha.assemble(file, |coded| Ok(yuv::alpha(coded, coded.cicp.full_range)))?;
        pixels.iter_mut().zip(values).for_each(|(px, alpha)| px[3] = alpha);
        if !file.referenced_items(file.primary_id, b"prem").is_empty() {
            pixels.iter_mut().for_each(straighten);
        }
    }
    // The tiling has at least one tile, so something has been told.
    let cicp = told.into_inner().ok_or(Problem::Truncated { format: FORMAT })?;
    Ok((pixels, cicp))
}

/// Takes the opacity out of colours that are multiplied with it.
fn straighten<T: Channel>(px: &mut [T; 4]) {
    let alpha: f32 = px[3].into();
    if alpha > 0.0 {
        let straight = |value: T| T::round((value.into() * T::MAX / alpha).min(T::MAX));
        *px = [straight(px[0]), straight(px[1]), straight(px[2]), px[3]];
    }
}

fn size(file: &HeifFile, id: ItemId) -> Result<[u32; 2], Problem> {
    let size = file.image_size(id).map_err(problem)?;
    size.map(<[u32; 2]>::from).ok_or_else(|| Problem::damaged(FORMAT, "a picture of it has no size"))
}

/// A property that the container's parser hands on as it is.
fn raw<'a>(file: &'a HeifFile, id: ItemId, kind: [u8; 4]) -> Option<&'a [u8]> {
    file.item_properties(id).ok()?.find_map(|property| match property {
        Property::Unknown(own, content) if own.0 == kind => Some(content.as_slice()),
        _ => None,
    })
}

/// Which of its layers a picture is shown with (`a1op`).
fn operating_point(file: &HeifFile, id: ItemId) -> u8 {
    raw(file, id, *b"a1op").and_then(|content| content.first()).copied().unwrap_or(0)
}

/// The opacity that belongs to a picture.
fn alpha_item(file: &HeifFile, id: ItemId) -> Option<ItemId> {
    let is_alpha = |property: &Property| matches!(property, Property::AuxiliaryType(urn) if ALPHA_URN.iter().any(|alpha| urn.starts_with(alpha)));
    let auxiliary = file.referencing_items(id, b"auxl");
    auxiliary.into_iter().find(|&aux| file.item_properties(aux).is_ok_and(|mut all| all.any(is_alpha)))
}
