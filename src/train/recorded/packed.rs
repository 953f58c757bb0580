//! Packed light fields: the 8 × 8 views that training uses, in one file that is read without decoding.
//!
//! A Lytro ESLF picture holds 14 × 14 views behind a PNG of 39 million pixels, which takes longer to decode than a step takes to
//! compute. `data --pack` does that once. Each file is a PPM (any viewer shows it): view (v, u) is its tile in row v, column u. A
//! comment in its header says whether colours are raw, as a sensor saw them.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use anyhow::{Result, ensure};
use plenoscope::io::formats::eslf;
use rayon::prelude::*;

use super::{Field, found};
use crate::TrainError;
use crate::field::TrueField;
use crate::files;
use crate::nets::{SIDE, VIEWS};
use crate::scenes::raster::{Raster, Rgb};

/// End of a packed file's name.
pub const ENDING: &str = ".views.ppm";
/// What its header begins with, for colours that are shown as they are, and for raw ones.
const MARKS: [&str; 2] = ["P6\n# 8x8 views\n", "P6\n# 8x8 views, raw\n"];

/// Packs the light fields of a folder, those that are not packed yet; gives what is to be printed. `told` hears what goes on,
/// first how much there will be.
///
/// # Errors
/// A folder without light fields, a disk that cannot be written. What is packed stays.
pub fn pack(folder: &Path, out: &Path, stop: &AtomicBool, told: &(dyn Fn(&str) + Sync)) -> Result<String> {
    let files = found(folder)?;
    std::fs::create_dir_all(out)?;
    told(&beforehand(&files));
    let (packed, passed_over) = (AtomicUsize::new(0), AtomicUsize::new(0));
    files.par_iter().try_for_each(|file| -> Result<()> {
        ensure!(!stop.load(Ordering::Relaxed), "stopped; what is packed stays, and the same command goes on with it");
        let path = out.join(name(file));
        match Field::open(file) {
            _ if path.exists() => {}
            Ok(field) => {
                files::write(&path, &bytes(&field), "write the packed light field")?;
                told(&format!("packed {}", path.display()));
            }
            Err(error) => {
                passed_over.fetch_add(1, Ordering::Relaxed);
                told(&format!("passed over: {error}"));
                return Ok(());
            }
        }
        packed.fetch_add(1, Ordering::Relaxed);
        Ok(())
    })?;
    let [packed, passed_over] = [packed, passed_over].map(AtomicUsize::into_inner);
    Ok(format!("{packed} light fields in {}, {passed_over} passed over\n", out.display()))
}

/// Number and size, as far as the first one that can be read tells.
fn beforehand(files: &[PathBuf]) -> String {
    let one = files.iter().find_map(|file| Field::open(file).ok()).map_or(0, |field| field.rgb.len());
    let all = (one * files.len()) as f64 / 1e9;
    format!("{} light fields, about {all:.1} GB when packed", files.len())
}

/// The name of a light field's packed file.
fn name(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let stem = name.strip_suffix("_eslf.png").or(name.strip_suffix(ENDING)).unwrap_or(&name);
    format!("{stem}{ENDING}")
}

fn bytes(field: &Field) -> Vec<u8> {
    let (w, h) = (field.width, field.height);
    let mut bytes = format!("{}{} {}\n255\n", MARKS[usize::from(field.raw)], w * SIDE, h * SIDE).into_bytes();
    bytes.reserve(field.rgb.len());
    for row in 0..SIDE * h {
        for u in 0..SIDE {
            let view = row / h * SIDE + u;
            bytes.extend_from_slice(&field.rgb[(view * h + row % h) * w * 3..][..w * 3]);
        }
    }
    bytes
}

/// Reads a packed light field.
///
/// # Errors
/// A file that cannot be read, or is none of these.
pub(super) fn open(path: &Path) -> Result<Field, TrainError> {
    let failed = |source| TrainError::File { action: "read the packed light field", source, path: path.to_owned() };
    let bytes = std::fs::read(path).map_err(failed)?;
    of_bytes(&bytes).ok_or_else(|| unlike("this is no packed light field, or a part of one; pack it again", path))
}

/// A packed light field to be judged by.
///
/// # Errors
/// A file that cannot be read, or is no packed light field.
pub fn true_field(path: &Path) -> Result<TrueField, TrainError> {
    let field = open(path)?;
    let size = [field.width, field.height];
    let texel = |p: &[u8]| [0, 1, 2].map(|c| f32::from(p[c]) / 255.0);
    let view = |rgb: &[u8]| Raster { size, px: rgb.chunks_exact(3).map(texel).collect() };
    let mut views: Vec<Rgb> = field.rgb.chunks_exact(3 * size[0] * size[1]).map(view).collect();
    if field.raw {
        views.iter_mut().flat_map(|view| view.px.as_flattened_mut()).for_each(|c| *c = c.powf(eslf::DARK_GAMMA));
    }
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    Ok(TrueField { name, size, views, depths: Vec::new() })
}

fn unlike(why: &str, path: &Path) -> TrainError {
    TrainError::Data { why: format!("{why}: {}", path.display()) }
}

fn of_bytes(bytes: &[u8]) -> Option<Field> {
    let raw = MARKS.iter().position(|mark| bytes.starts_with(mark.as_bytes()))?;
    let mut lines = bytes[MARKS[raw].len()..].splitn(3, |byte| *byte == b'\n');
    let mut text = || std::str::from_utf8(lines.next()?).ok();
    let (wide, high) = text()?.split_once(' ')?;
    let [wide, high]: [usize; 2] = [wide.parse().ok()?, high.parse().ok()?];
    let depth = text()?;
    let rgb = lines.next()?;
    let whole = wide.checked_mul(high)?.checked_mul(3)? == rgb.len() && depth == "255";
    if !whole || rgb.is_empty() || wide % SIDE + high % SIDE != 0 {
        return None;
    }
    let (width, height) = (wide / SIDE, high / SIDE);
    let mut views = Vec::with_capacity(rgb.len());
    for row in 0..VIEWS * height {
        let (view, y) = (row / height, row % height);
        let from = ((view / SIDE * height + y) * wide + view % SIDE * width) * 3;
        views.extend_from_slice(&rgb[from..][..width * 3]);
    }
    // A mark that another rule made is not believed.
    Some(if raw == 1 {
        Field::of_lenslets(width, height, views)
    } else {
        Field { width, height, rgb: views, raw: false }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recorded::tests::{write_eslf, write_plane};
    use crate::rng::Rng;

    #[test]
    fn a_packed_folder_is_what_was_packed() {
        let folder = tempfile::tempdir().unwrap();
        let (from, to) = (folder.path().join("from"), folder.path().join("to"));
        std::fs::create_dir(&from).unwrap();
        write_eslf(&from);
        write_plane(&from.join("plane"), 0.3);
        std::fs::create_dir(from.join("notes")).unwrap();
        let (stop, quiet) = (AtomicBool::new(false), |_: &str| ());
        let told = pack(&from, &to, &stop, &quiet).unwrap();
        assert!(told.starts_with("2 light fields") && told.contains("1 passed over"), "{told}");
        for (file, packed) in [("IMG_1_eslf.png", "IMG_1.views.ppm"), ("plane", "plane.views.ppm")] {
            let (one, other) = (Field::open(&from.join(file)).unwrap(), Field::open(&to.join(packed)).unwrap());
            assert_eq!((one.width, one.height, one.raw), (other.width, other.height, other.raw));
            assert!(one.rgb == other.rgb);
        }
        let [one, other] = [from.join("plane"), to.join("plane.views.ppm")].map(|path| TrueField::open(&path).unwrap());
        assert!(one.views.iter().zip(&other.views).all(|(a, b)| a.px == b.px));
        let picture = image::open(to.join("plane.views.ppm")).unwrap();
        assert_eq!((picture.width(), picture.height()), (48 * 8, 36 * 8));
    }

    #[test]
    fn what_is_cut_off_is_none() {
        let field = Field { width: 3, height: 2, rgb: vec![7; 64 * 18], raw: false };
        let bytes = bytes(&field);
        assert!(of_bytes(&bytes).is_some());
        for end in [0, 10, 50, bytes.len() - 1] {
            assert!(of_bytes(&bytes[..end]).is_none(), "{end}");
        }
    }

    #[test]
    fn a_damaged_header_is_none_or_that_of_another_light_field() {
        let field = Field { width: 3, height: 2, rgb: vec![7; 64 * 18], raw: false };
        let whole = bytes(&field);
        let mut rng = Rng::new(5, 0);
        for _ in 0..5000 {
            let mut bytes = whole.clone();
            for _ in 0..1 + rng.below(4) {
                let at = 3 + rng.below(30);
                bytes[at] = b"0123456789 \n#-+,x\xff"[rng.below(18)];
            }
            if let Some(field) = of_bytes(&bytes) {
                assert_eq!(field.rgb.len(), 3 * VIEWS * field.width * field.height);
            }
        }
    }
}
