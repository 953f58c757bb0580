//! ESLF: Lytro's lenslet picture. Each lenslet is a block of N×N pixels, one for each view:
//! pixel `(y, x) = (j·N + v, i·N + u)` (LF Toolbox, `LFReadESLF.m`). N is 14 for the Illum.

use std::path::Path;
use std::sync::Arc;

use png::{BitDepth, ColorType};

use super::out::{self, FieldToWrite};
use crate::field::{LightField, View, ViewGrid, ViewIndex};
use crate::io::raster::{self, still::PNG, still::TIFF};
use crate::io::save::SaveError;
use crate::io::{FileInfo, LightFieldFile, Problem};
use crate::job::{Job, Stage};

const FORMAT: &str = "ESLF";
/// The block of an Illum, and the chunk in which we note another.
pub const LENSLET_PX: usize = 14;
const CHUNK: &str = "LensletSize";
/// Blocks that are looked for in a file that does not say.
const CANDIDATES: [usize; 7] = [14, 15, 9, 8, 7, 11, 13];
/// Views darker than this on average are shown with the protocol's γ.
const DARK: f32 = 0.25;
/// The γ of the paper's protocol.
pub const DARK_GAMMA: f32 = 0.4;

/// Reads a lenslet picture; `None` where the picture is none.
pub(super) fn read(bytes: &[u8], name: Option<&Path>, job: &Job) -> Result<Option<LightFieldFile>, Problem> {
    if ![PNG, TIFF].iter().any(|kind| (kind.begins)(bytes)) {
        return Ok(None);
    }
    let noted = lenslet_chunk(bytes);
    let named =
        name.and_then(Path::file_stem).is_some_and(|stem| stem.to_string_lossy().to_lowercase().contains("eslf"));
    let [width, height] = raster::header_size(bytes)?;
    // An Illum's picture, whole (7574×5264) or cropped to whole blocks.
    let by_size = width >= 2800 && height >= 2800 && width % 14 == 0 && height % 14 == 0;
    if noted.is_none() && !named && !by_size {
        return Ok(None);
    }
    let (size, pixels) = raster::decode_rgba8(bytes)?;
    job.check()?;
    let Some(block) = noted.or_else(|| guess_block(&pixels, size)) else {
        return if named { Err(Problem::damaged(FORMAT, "no period of lenslets is found in it")) } else { Ok(None) };
    };
    let field = views(&pixels, size, block, job)?;
    let mut info = FileInfo::light_field(FORMAT, &field);
    info.notes.push(("lenslet".to_owned(), format!("{block}×{block} px")));
    let mut file = LightFieldFile::new(Arc::new(field), None, info);
    file.display_gamma = shown_power(&file.field);
    Ok(Some(file))
}

/// The power that colours as the sensor saw them are raised to when they are shown; none where they are bright enough.
fn shown_power(field: &LightField) -> Option<f32> {
    let green = field.reference().rgba().chunks_exact(4).map(|px| px[1]);
    is_raw(green).then_some(DARK_GAMMA)
}

/// Whether colours are as the sensor saw them, without a display's curve: by the reference view's `green`.
pub fn is_raw(green: impl ExactSizeIterator<Item = u8>) -> bool {
    let count = green.len();
    let sum: u64 = green.map(u64::from).sum();
    (sum as f32 / count as f32 / 255.0) < DARK
}

/// The block size that our own writer notes.
fn lenslet_chunk(bytes: &[u8]) -> Option<usize> {
    let reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().ok()?;
    let texts = &reader.info().uncompressed_latin1_text;
    let size = texts.iter().find(|chunk| chunk.keyword == CHUNK)?.text.parse().ok()?;
    (2..=ViewGrid::MAX_SIDE).contains(&size).then_some(size)
}

/// The block size, from how the steps between neighbouring pixels repeat: they are large from lenslet to lenslet, and
/// at the rim of the lenslet's round picture.
fn guess_block(pixels: &[[u8; 4]], [width, height]: [u32; 2]) -> Option<usize> {
    let (w, h) = (width as usize, height as usize);
    let green = |x: usize, y: usize| f32::from(pixels[y * w + x][1]) * f32::from(pixels[y * w + x][3]) / 255.0;
    // A few hundred lines are enough.
    let lines = |n: usize| (0..n).step_by((n / 300).max(1));
    let across = lines(h).map(|y| (0..w).map(|x| green(x, y)).collect::<Vec<f32>>());
    let down = lines(w).map(|x| (0..h).map(|y| green(x, y)).collect::<Vec<f32>>());
    let (across, down): (Vec<_>, Vec<_>) = (across.collect(), down.collect());
    let score = |&n: &usize| contrast(&across, n).min(contrast(&down, n));
    let best = CANDIDATES.into_iter().max_by(|a, b| score(a).total_cmp(&score(b)))?;
    (score(&best) > 0.25).then_some(best)
}

/// How unevenly steps between neighbours are spread over a period: standard deviation over mean.
fn contrast(lines: &[Vec<f32>], period: usize) -> f32 {
    let mut sums = vec![0.0f64; period];
    for line in lines {
        let whole = (line.len() / period * period).saturating_sub(1);
        for (x, pair) in line.windows(2).take(whole).enumerate() {
            sums[x % period] += f64::from((pair[1] - pair[0]).abs());
        }
    }
    let mean = sums.iter().sum::<f64>() / period as f64;
    let variance = sums.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / period as f64;
    if mean > 0.0 { (variance.sqrt() / mean) as f32 } else { 0.0 }
}

/// Takes the views out; those at the rim that are transparent everywhere are dropped.
fn views(pixels: &[[u8; 4]], [width, height]: [u32; 2], block: usize, job: &Job) -> Result<LightField, Problem> {
    let (w, h) = (width as usize / block, height as usize / block);
    if w == 0 || h == 0 {
        return Err(Problem::damaged(FORMAT, format!("{width}×{height} pixels hold no lenslet of {block}×{block}")));
    }
    let pixel = |v: usize, u: usize, y: usize, x: usize| pixels[(y * block + v) * width as usize + x * block + u];
    let empty = |v: usize, u: usize| (0..h).all(|y| (0..w).all(|x| pixel(v, u, y, x)[3] == 0));
    let filled = |along: &dyn Fn(usize, usize) -> bool| {
        (0..block).filter(|&n| (0..block).any(|m| !along(n, m))).collect::<Vec<_>>()
    };
    let rows = filled(&|v, u| empty(v, u));
    let cols = filled(&|u, v| empty(v, u));
    let (Some(&top), Some(&bottom)) = (rows.first(), rows.last()) else {
        return Err(Problem::damaged(FORMAT, "all of it is transparent"));
    };
    let (left, right) = (cols[0], cols[cols.len() - 1]);
    let grid = ViewGrid::new(bottom + 1 - top, right + 1 - left)?;
    let take = |at: ViewIndex| {
        job.advance(Stage::Open, grid.layer_from_view(at) as u32, grid.count() as u32)?;
        let (v, u) = (top + usize::from(at.v), left + usize::from(at.u));
        let opaque = |[r, g, b, _]: [u8; 4]| [r, g, b, 255];
        let rgba = (0..h).flat_map(|y| (0..w).flat_map(move |x| opaque(pixel(v, u, y, x)))).collect();
        Ok(Arc::new(View::new([w as u32, h as u32], rgba)?))
    };
    let views = grid.views().map(take).collect::<Result<Vec<_>, Problem>>()?;
    Ok(LightField::new(grid, views)?)
}

/// Writes a lenslet picture: blocks of 14×14, the views in the middle, alpha 0 around them, as the LF Toolbox reads
/// it. The reference view of 8×8 lies at (7, 7). Larger grids get larger blocks, noted in the chunk `LensletSize`.
///
/// # Errors
/// [`SaveError`]; then nothing has been written.
pub fn write(path: &Path, source: &FieldToWrite, job: &Job) -> Result<(), SaveError> {
    let field = source.field;
    let grid = field.grid();
    let block = grid.rows().max(grid.cols()).max(LENSLET_PX);
    let (top, left) = ((block / 2).saturating_sub(grid.rows() / 2), (block / 2).saturating_sub(grid.cols() / 2));
    let [w, h] = field.size();
    let size = [w * block as u32, h * block as u32];
    let row = |line: usize| {
        let (y, v) = (line / block, line % block);
        let mut out = vec![0u8; size[0] as usize * 4];
        if v >= top && v - top < grid.rows() {
            for u in 0..grid.cols() {
                let view = field.view(ViewIndex { v: (v - top) as u8, u: u as u8 });
                for x in 0..w {
                    let at = (x as usize * block + left + u) * 4;
                    out[at..at + 4].copy_from_slice(&view.pixel(x, y as u32));
                }
            }
        }
        out
    };
    let texts = [(CHUNK, block.to_string()), ("Software", "Plenoscope".to_owned())];
    let mut stopped = Ok(());
    let rows = (0..size[1] as usize).map(row).take_while(|_| {
        stopped = job.check();
        stopped.is_ok()
    });
    let written = out::single(path, |out| out::png(out, size, (ColorType::Rgba, BitDepth::Eight), &texts, rows));
    stopped?;
    written
}
