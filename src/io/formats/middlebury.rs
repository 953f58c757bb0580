//! A stereo scene of the Middlebury benchmark (Scharstein et al., "High-resolution stereo datasets with subpixel-accurate
//! ground truth", GCPR 2014): it opens as its left photo `im0.png` with the depth that was measured.
//!
//! `disp0.pfm` holds the distance to the right photo's pixel, infinite where nothing was measured. With the numbers of
//! `calib.txt`, depth = baseline · focal length / (disparity + doffs), in mm.

use std::path::Path;

use super::{hci, pfm};
use crate::field::RelativeDepth;
use crate::io::file_type::FileType;
use crate::io::open::{MAX_TEXT_BYTES, read_file, read_up_to};
use crate::io::{DepthKind, EmbeddedDepth, Opened, Problem};
use crate::job::Job;

/// The file that stands for the folder.
pub(super) const CALIBRATION: &str = "calib.txt";

/// Width of a frame of 35-mm film.
const FILM_MM: f32 = 36.0;

/// Reads a scene's folder; `None` where the folder is none.
pub(super) fn read(folder: &Path, job: &Job) -> Result<Option<Opened>, Problem> {
    let [photo, map] = ["im0.png", "disp0.pfm"].map(|name| folder.join(name));
    if !photo.is_file() || !map.is_file() {
        return Ok(None);
    }
    let open = |bytes: Vec<u8>| FileType::of(&bytes)?.open(&bytes, job);
    let mut file = read_file(&photo).and_then(open).map_err(Problem::of(&photo))?.with_source(Some(&photo));
    file.info.format = "Middlebury stereo scene";
    job.check()?;
    match pfm::values_sized(&map, file.photo.size()) {
        Ok(disparity) => {
            let (size, scale) = (disparity.size(), Scale::of(folder));
            let mut inverse_depth = disparity.map(|px| (px + scale.offset_px) * scale.factor).into_pixels();
            inverse_depth.chunks_exact_mut(size[0] as usize).for_each(fill);
            let map = RelativeDepth::new(size, inverse_depth)?;
            let long_px = size[0].max(size[1]) as f32;
            file.info.f35_mm = file.info.f35_mm.or(scale.focal_px.map(|px| px / long_px * FILM_MM));
            file.set_depth(EmbeddedDepth { kind: DepthKind::SideFile, map, metric: scale.is_metric });
        }
        Err(problem) => file.warn(format!("the disparity is left out — {problem}: {}", map.display())),
    }
    Ok(Some(file.into()))
}

/// How disparity becomes inverse depth: `(disparity + offset) · factor`.
struct Scale {
    factor: f32,
    offset_px: f32,
    is_metric: bool,
    focal_px: Option<f32>,
}

impl Scale {
    /// From `calib.txt`; without it, disparities are in a unit of their own.
    fn of(folder: &Path) -> Self {
        let text = read_up_to(&folder.join(CALIBRATION), MAX_TEXT_BYTES).unwrap_or_default();
        let numbers = hci::parse_config(&String::from_utf8_lossy(&text));
        let number = |name: &str| {
            let first = numbers.get(name)?.trim_start_matches('[').split_whitespace().next()?;
            first.parse::<f32>().ok().filter(|n| n.is_finite())
        };
        // The focal length stands first in the camera's matrix.
        let focal_px = number("cam0").filter(|px| *px > 0.0);
        let per_px = number("baseline").zip(focal_px).map(|(baseline_mm, focal_px)| 1000.0 / (baseline_mm * focal_px));
        let factor = per_px.filter(|factor| factor.is_normal() && *factor > 0.0);
        let (offset_px, is_metric) = (number("doffs").unwrap_or(0.0), factor.is_some());
        Self { factor: factor.unwrap_or(1.0), offset_px, is_metric, focal_px }
    }
}

/// What was not measured is mostly hidden from the other eye, so it is as far as the farther side of its gap.
fn fill(row: &mut [f32]) {
    let mut start = 0;
    while let Some(gap) = row[start..].iter().position(|n| !n.is_finite()).map(|at| start + at) {
        let end = row[gap..].iter().position(|n| n.is_finite()).map_or(row.len(), |at| gap + at);
        let sides = [gap.checked_sub(1), Some(end)].into_iter().flatten().filter_map(|at| row.get(at).copied());
        let far = sides.reduce(f32::min).unwrap_or(0.0);
        row[gap..end].fill(far);
        start = end;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::PhotoFile;
    use crate::job::Cancel;

    fn open(path: &Path) -> PhotoFile {
        match crate::io::open(path, &Job { cancel: &Cancel::default(), sink: &() }).unwrap() {
            Opened::Photo(file) => *file,
            Opened::LightField(_) => panic!("a photo"),
        }
    }

    #[test]
    fn a_scene_opens_as_its_left_photo_with_metric_depth() {
        let dir = tempfile::tempdir().unwrap();
        image::RgbImage::from_pixel(4, 1, image::Rgb([9, 9, 9])).save(dir.path().join("im0.png")).unwrap();
        let mut map = Vec::new();
        pfm::write_pfm(&mut map, [4, 1], &[f32::INFINITY, 30.0, f32::INFINITY, 10.0]).unwrap();
        std::fs::write(dir.path().join("disp0.pfm"), &map).unwrap();
        assert!(!open(dir.path()).depth.unwrap().metric, "without its calibration");
        let calibration = "cam0=[1000 0 2; 0 1000 1; 0 0 1]\ndoffs=10\nbaseline=100\nwidth=4\nheight=1\n";
        std::fs::write(dir.path().join(CALIBRATION), calibration).unwrap();
        for path in [dir.path().to_owned(), dir.path().join(CALIBRATION)] {
            let file = open(&path);
            assert_eq!(file.info.f35_mm, Some(9000.0), "1000 px of focal length on 4 px");
            let depth = file.depth.unwrap();
            // 100 mm · 1000 px / (30 + 10) px = 2.5 m.
            let expected = [0.4, 0.4, 0.2, 0.2];
            assert!(depth.metric && depth.map.nearness().iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6));
        }
        std::fs::write(dir.path().join("disp0.pfm"), &map[..map.len() - 1]).unwrap();
        let file = open(dir.path());
        assert!(file.depth.is_none() && file.warnings.len() == 1, "{:?}", file.warnings);
    }
}
