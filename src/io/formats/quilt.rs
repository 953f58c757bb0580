//! Looking Glass quilts: one picture of `cols × rows` tiles, the leftmost camera at the bottom left, then to the right,
//! then up (docs.lookingglassfactory.com). The name carries the layout: `stem_qs8x6a0.75.png`.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::Vec3;
use png::{BitDepth, ColorType};

use super::out;
use crate::field::Picture;
use crate::field::color::srgb8_from_linear;
use crate::field::{LightField, View, ViewGrid, ViewOffset, ViewPoint, bilinear, sides};
use crate::io::raster;
use crate::io::save::SaveError;
use crate::io::{FileInfo, LightFieldFile, Problem};
use crate::job::{Job, Stage};

const FORMAT: &str = "Looking Glass quilt";

/// A display: how its quilt is laid out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Device {
    /// How the command line calls it.
    pub id: &'static str,
    /// What people call it.
    pub name: &'static str,
    /// Tiles across and down.
    pub grid: [u32; 2],
    /// Width and height of the whole quilt, in pixels.
    pub size: [u32; 2],
    /// Width over height of one view, as it stands in the name.
    pub aspect: f32,
}

/// The displays that are known, as their maker recommends.
pub const DEVICES: [Device; 7] = [
    Device { id: "portrait", name: "Looking Glass Portrait", grid: [8, 6], size: [3360, 3360], aspect: 0.75 },
    Device { id: "go", name: "Looking Glass Go", grid: [11, 6], size: [4092, 4092], aspect: 0.5625 },
    Device {
        id: "16-landscape",
        name: "Looking Glass 16\" landscape",
        grid: [7, 7],
        size: [5999, 5999],
        aspect: 1.777,
    },
    Device {
        id: "32-landscape",
        name: "Looking Glass 32\" landscape",
        grid: [7, 7],
        size: [8190, 8190],
        aspect: 1.777,
    },
    Device {
        id: "16-portrait",
        name: "Looking Glass 16\" portrait",
        grid: [11, 6],
        size: [5995, 6000],
        aspect: 0.5625,
    },
    Device {
        id: "32-portrait",
        name: "Looking Glass 32\" portrait",
        grid: [11, 6],
        size: [8184, 8184],
        aspect: 0.5625,
    },
    Device { id: "65", name: "Looking Glass 65\"", grid: [8, 9], size: [8192, 8192], aspect: 1.777 },
];

impl Device {
    /// The name that displays understand: `stem_qs<cols>x<rows>a<aspect>.png`.
    pub fn file_name(&self, stem: &str) -> String {
        format!("{stem}_qs{}x{}a{}.png", self.grid[0], self.grid[1], self.aspect)
    }

    /// The path with a name that displays understand, in the folder of `path`.
    pub fn path(&self, path: &Path) -> PathBuf {
        let stem = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
        if layout(path).is_some() { path.to_owned() } else { path.with_file_name(self.file_name(&stem)) }
    }
}

/// Columns, rows and aspect in a quilt's name.
fn layout(path: &Path) -> Option<(u32, u32, f32)> {
    let stem = path.file_stem()?.to_str()?;
    let tail = &stem[stem.rfind("_qs")? + 3..];
    let (cols, rest) = tail.split_once('x')?;
    let (rows, aspect) = rest.split_once('a')?;
    let (cols, rows, aspect): (u32, u32, f32) = (cols.parse().ok()?, rows.parse().ok()?, aspect.parse().ok()?);
    ((1..=64).contains(&cols) && (1..=64).contains(&rows) && aspect > 0.0 && aspect.is_finite())
        .then_some((cols, rows, aspect))
}

/// Reads a quilt, told by its name, as one row of views: of more than 17, 17 at even distances.
pub(super) fn read(bytes: &[u8], name: Option<&Path>, job: &Job) -> Result<Option<LightFieldFile>, Problem> {
    let Some((cols, rows, aspect)) = name.and_then(layout) else { return Ok(None) };
    let ([width, height], pixels) = raster::decode_rgba8(bytes)?;
    let tile = [width / cols, height / rows];
    if tile[0] == 0 || tile[1] == 0 {
        return Err(Problem::damaged(FORMAT, format!("{width}×{height} pixels hold no {cols}×{rows} tiles")));
    }
    let total = (cols * rows) as usize;
    let kept = total.min(ViewGrid::MAX_SIDE);
    let take = |n: usize| {
        job.advance(Stage::Open, n as u32, kept as u32)?;
        let at = if kept > 1 { (n * (total - 1) + (kept - 1) / 2) / (kept - 1) } else { 0 } as u32;
        let (left, top) = (at % cols * tile[0], height - (at / cols + 1) * tile[1]);
        let row = |y: u32| &pixels[((top + y) * width + left) as usize..][..tile[0] as usize];
        let rgba = (0..tile[1]).flat_map(|y| row(y).iter().flat_map(|&[r, g, b, _]| [r, g, b, 255])).collect();
        Ok(Arc::new(View::new(tile, rgba)?))
    };
    let views = (0..kept).map(take).collect::<Result<Vec<_>, Problem>>()?;
    let field = LightField::new(ViewGrid::new(1, kept)?, views)?;
    let mut info = FileInfo::light_field(FORMAT, &field);
    info.notes.push(("tiles".to_owned(), format!("{cols}×{rows}, shown with aspect {aspect}")));
    let mut file = LightFieldFile::new(Arc::new(field), None, info);
    if kept < total {
        file.warn(format!("{kept} of the quilt's {total} views are used, at even distances"));
    }
    Ok(Some(file))
}

/// Writes a quilt. `view` gives the picture at any viewpoint, so that neighbours differ by fractions of a view step;
/// `span` is how far the eye goes, in view steps from the reference view, left and right. Every view is cut to the
/// display's aspect around its middle. Zero disparity stays in the display's plane.
///
/// # Errors
/// [`SaveError`]; then nothing has been written.
pub fn write(
    path: &Path,
    device: &Device,
    span: [f32; 2],
    view: &dyn Fn(ViewPoint) -> Picture,
    job: &Job,
) -> Result<(), SaveError> {
    let [cols, rows] = device.grid;
    let tile = [device.size[0] / cols, device.size[1] / rows];
    let total = cols * rows;
    let point = |n: u32| {
        let share = n as f32 / (total - 1).max(1) as f32;
        ViewPoint(ViewOffset { dv: 0.0, du: span[0] + share * (span[1] - span[0]) })
    };
    // One row of tiles at a time, from the top: there lie the last views.
    let mut stopped = Ok(());
    let band = |row: u32| {
        let tiles: Vec<Vec<u8>> =
            (0..cols).map(|col| fit(&view(point((rows - 1 - row) * cols + col)), tile, device.aspect)).collect();
        let line = move |y: usize| {
            let mut line = vec![0u8; device.size[0] as usize * 3];
            for (col, rgb) in tiles.iter().enumerate() {
                let bytes = tile[0] as usize * 3;
                line[col * bytes..(col + 1) * bytes].copy_from_slice(&rgb[y * bytes..(y + 1) * bytes]);
            }
            line
        };
        (0..tile[1] as usize).map(line)
    };
    let bands = (0..rows).take_while(|&row| {
        stopped = job.advance(Stage::Save, row, rows);
        stopped.is_ok()
    });
    // What is left at the bottom when the tiles do not fill the picture.
    let rest = (device.size[1] - tile[1] * rows) as usize;
    let lines = bands.flat_map(band).chain((0..rest).map(|_| vec![0u8; device.size[0] as usize * 3]));
    let written = out::single(path, |out| out::png(out, device.size, (ColorType::Rgb, BitDepth::Eight), &[], lines));
    stopped?;
    written
}

/// A picture cut to an aspect and scaled to a tile, in linear light: sRGB, `[y, x, 3]`.
fn fit(picture: &Picture, tile: [u32; 2], aspect: f32) -> Vec<u8> {
    let [w, h] = picture.size.map(|side| side as f32);
    let (cut_w, cut_h) = if w / h > aspect { (h * aspect, h) } else { (w, w / aspect) };
    let (scale_x, scale_y) = (cut_w / tile[0] as f32, cut_h / tile[1] as f32);
    // Shrinking averages as many taps as pixels fall together.
    let taps = |scale: f32| (scale.ceil() as usize).clamp(1, 8);
    let (nx, ny) = (taps(scale_x), taps(scale_y));
    let light = |i: usize| Vec3::from_slice(&picture.rgb_linear[i * 3..]);
    let mut rgb = Vec::with_capacity((tile[0] * tile[1] * 3) as usize);
    for y in 0..tile[1] {
        for x in 0..tile[0] {
            let mut sum = Vec3::ZERO;
            for (i, j) in (0..nx * ny).map(|n| (n % nx, n / nx)) {
                let at = |n: u32, k: usize, of: usize| n as f32 + (k as f32 + 0.5) / of as f32;
                let sx = (w - cut_w) / 2.0 + at(x, i, nx) * scale_x - 0.5;
                let sy = (h - cut_h) / 2.0 + at(y, j, ny) * scale_y - 0.5;
                sum += bilinear(sides(picture.size), sx, sy, light);
            }
            rgb.extend((sum / (nx * ny) as f32).to_array().map(srgb8_from_linear));
        }
    }
    rgb
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::Cancel;

    #[test]
    fn names_are_read_as_they_are_written() {
        assert_eq!(DEVICES[2].file_name("x"), "x_qs7x7a1.777.png");
        assert_eq!(layout(Path::new("a/x_qs5x9a1.777.png")), Some((5, 9, 1.777)));
        assert_eq!(layout(Path::new("steampunk_quilt_qs8x13a0.75.jpg")), Some((8, 13, 0.75)));
        assert_eq!(layout(Path::new("x_qs5x9.png")), None);
        assert_eq!(DEVICES[0].path(Path::new("q/cat.png")), Path::new("q/cat_qs8x6a0.75.png"));
    }

    #[test]
    fn the_leftmost_view_lies_at_the_bottom_left_and_comes_back_first() {
        let device = Device { id: "test", name: "test", grid: [3, 2], size: [13, 9], aspect: 1.0 };
        // Each viewpoint has its own grey.
        let gray = |point: ViewPoint| (point.0.du + 4.0) / 10.0;
        let view = |point| Picture { size: [8, 8], rgb_linear: vec![gray(point); 8 * 8 * 3] };
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join(device.file_name("q"));
        let job = Job { cancel: &Cancel::default(), sink: &() };
        write(&path, &device, [-4.0, 3.0], &view, &job).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let (size, px) = raster::decode_rgba8(&bytes).unwrap();
        assert_eq!(size, [13, 9]);
        assert_eq!(px[7 * 13][0], 0, "view 0, the leftmost, is black and at the bottom left");
        let file = read(&bytes, Some(&path), &job).unwrap().unwrap();
        let grays: Vec<u8> = file.field.views().iter().map(|view| view.pixel(1, 1)[0]).collect();
        assert!(grays.len() == 6 && grays.is_sorted() && grays[0] == 0 && grays[5] > 200, "{grays:?}");
    }
}
