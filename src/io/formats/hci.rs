//! The 4-D light field benchmark's folder (Honauer et al., Heidelberg and Konstanz): `input_Cam%03d.png` row by row,
//! `gt_disp_lowres*.pfm`, `parameters.cfg`. Its disparity has our sign.
//!
//! Its scenes have 9×9 views and the middle one, 040, for their centre, as here. The benchmark's own tools (its
//! `evaluation-toolkit`) take half the number of views for the centre's number, which in grids of even sides is another
//! view than ours: of 8×8 it is 032, the first of the middle row, and ours is 036. `gt_disp_lowres.pfm` and
//! `gt_depth_lowres.pfm` belong to the view that the tools show beside them. Their reader fits square grids only.

use std::collections::HashMap;
use std::io::Write;
use std::path::Path;
use std::sync::Arc;
use std::time::{SystemTime, UNIX_EPOCH};

use super::grid_names;
use super::out::{self, FieldToWrite};
use super::{pfm, views};
use crate::field::{RayDepths, ViewGrid, ViewIndex};
use crate::io::open::{MAX_TEXT_BYTES, read_up_to};
use crate::io::save::{self, SaveError};
use crate::io::{FileInfo, LightFieldFile, Opened, Problem};
use crate::job::Job;
use crate::within::plain_words;

const FORMAT: &str = "HCI 4-D benchmark";
pub(super) const CONFIG: &str = "parameters.cfg";

/// The numbers of `parameters.cfg`, by name; sections do not matter, as no name is in two of them.
pub(super) fn parse_config(text: &str) -> HashMap<String, String> {
    let pair =
        |line: &str| line.split_once('=').map(|(key, value)| (key.trim().to_lowercase(), value.trim().to_owned()));
    text.lines().filter(|line| !line.trim_start().starts_with(['#', ';', '['])).filter_map(pair).collect()
}

/// Reads a benchmark folder; `None` where the folder is none.
pub(super) fn read(folder: &Path, job: &Job) -> Result<Option<Opened>, Problem> {
    let has_views = folder.join("input_Cam000.png").is_file() || folder.join("input_Cam001.png").is_file();
    if !folder.join(CONFIG).is_file() && !has_views {
        return Ok(None);
    }
    let mut warnings = Vec::new();
    let config = match read_up_to(&folder.join(CONFIG), MAX_TEXT_BYTES) {
        Ok(bytes) => parse_config(&String::from_utf8_lossy(&bytes)),
        Err(_unreadable) => {
            warnings.push("parameters.cfg is missing, so the number of views tells the grid".to_owned());
            HashMap::new()
        }
    };
    let number = |name: &str| config.get(name).and_then(|text| text.parse::<f32>().ok()).filter(|n| n.is_finite());
    let grid = match (number("num_cams_y"), number("num_cams_x")) {
        (Some(rows), Some(cols)) => Some(ViewGrid::new(rows as usize, cols as usize)?),
        _ => None,
    };
    let Some(files) = grid_names::find(folder, grid)? else { return Ok(None) };
    let field = views::read_views(&files, job)?;
    let mut info = FileInfo::light_field(FORMAT, &field);
    info.disparity_px = number("disp_min").zip(number("disp_max")).map(|(low, high)| [low, high]);
    let scene = config.get("scene").map(|scene| plain_words(scene, views::MOST_LETTERS));
    info.notes.extend(scene.map(|scene| ("scene".to_owned(), scene)));
    let grid = field.grid();
    let name = |at: ViewIndex| folder.join(format!("gt_disp_lowres_Cam{:03}.pfm", grid.layer_from_view(at)));
    let depths = views::read_depths(&field, name, job, &mut warnings)?;
    let truth = folder.join("gt_disp_lowres.pfm");
    let reference_disparity = if !truth.is_file() {
        None
    } else if center(grid) == grid.reference() {
        let map = pfm::read_sized(&truth, field.size());
        map.map_err(|problem| warnings.push(format!("the disparity is left out — {problem}: {}", truth.display()))).ok()
    } else {
        if depths.is_none() {
            let at = center(grid);
            warnings.push(format!("the disparity is left out — it is that of view (v {}, u {})", at.v, at.u));
        }
        None
    };
    info.warnings.clone_from(&warnings);
    Ok(Some(LightFieldFile { reference_disparity, ..LightFieldFile::new(Arc::new(field), depths, info) }.into()))
}

/// The view that the benchmark's tools take for the centre.
fn center(grid: ViewGrid) -> ViewIndex {
    grid.view_from_layer(grid.count() / 2)
}

/// A camera that has the disparities of a light field: the benchmark's formulas need metres.
struct Camera {
    focal_mm: f32,
    sensor_mm: f32,
    focus_m: f32,
    baseline_mm: f32,
    max_side: f32,
}

impl Camera {
    /// A 100-mm lens focused at 4 m; the baseline is chosen so that the farthest point lies this side of infinity.
    fn for_range(range_px: [f32; 2], size: [u32; 2]) -> Self {
        let (focal_mm, sensor_mm, focus_m) = (100.0, 35.0, 4.0);
        let max_side = size[0].max(size[1]) as f32;
        // Disparity of a point at infinity is −offset: one view step's shift of the sensor.
        let offset_px = (-2.0 * range_px[0]).max(2.0);
        let baseline_mm = offset_px * focus_m * 1000.0 * sensor_mm / (focal_mm * max_side);
        Self { focal_mm, sensor_mm, focus_m, baseline_mm, max_side }
    }

    /// Depth of a disparity: `β·F / (d·F·sensor + β)`, β = baseline · focal length · pixels.
    fn depth_m(&self, disparity_px: f32) -> f32 {
        let beta = self.baseline_mm * self.focal_mm * self.max_side;
        let focus_mm = self.focus_m * 1000.0;
        beta * focus_mm / (disparity_px * focus_mm * self.sensor_mm + beta) / 1000.0
    }
}

/// Writes a benchmark folder: all views, the ray depths of all views, disparity and depth of the view that the benchmark
/// takes for the centre, and a `parameters.cfg` with a camera that has these disparities.
///
/// # Errors
/// [`SaveError`]; then nothing has been written.
pub fn write(path: &Path, source: &FieldToWrite, job: &Job) -> Result<(), SaveError> {
    let is_ours = |name: &str| {
        name == CONFIG
            || (name.starts_with("input_Cam") && name.ends_with(".png"))
            || (name.starts_with("gt_d") && name.ends_with(".pfm"))
    };
    let range = source.depths.map_or([-2.0, 2.0], RayDepths::range_px);
    let camera = Camera::for_range(range, source.field.size());
    save::folder(path, is_ours, |folder| {
        let grid = source.field.grid();
        out::views(folder, source.field, |at| format!("input_Cam{:03}.png", grid.layer_from_view(at)), job)?;
        if let Some(depths) = source.depths {
            for at in grid.views() {
                job.check()?;
                let name = format!("gt_disp_lowres_Cam{:03}.pfm", grid.layer_from_view(at));
                out::map_pfm(&folder.join(name), depths.size(), depths.view(at))?;
            }
            let truth = depths.view(center(grid));
            out::map_pfm(&folder.join("gt_disp_lowres.pfm"), depths.size(), truth)?;
            let metres: Vec<f32> = truth.iter().map(|&d| camera.depth_m(d)).collect();
            out::map_pfm(&folder.join("gt_depth_lowres.pfm"), depths.size(), &metres)?;
        }
        let scene = scene_name(path);
        out::file(&folder.join(CONFIG), |file| file.write_all(config(&camera, source, range, &scene).as_bytes()))
    })
}

fn config(camera: &Camera, source: &FieldToWrite, range: [f32; 2], scene: &str) -> String {
    let ([width, height], grid) = (source.field.size(), source.field.grid());
    format!(
        "[intrinsics]\nfocal_length_mm = {}\nimage_resolution_x_px = {width}\nimage_resolution_y_px = {height}\n\
         sensor_size_mm = {}\nfstop = 100.0\n\n\
         [extrinsics]\nnum_cams_x = {}\nnum_cams_y = {}\nbaseline_mm = {}\nfocus_distance_m = {}\n\
         center_cam_x_m = 0.0\ncenter_cam_y_m = 0.0\ncenter_cam_z_m = 0.0\n\
         center_cam_rx_rad = 0.0\ncenter_cam_ry_rad = 0.0\ncenter_cam_rz_rad = 0.0\n\n\
         [meta]\nscene = {scene}\ncategory = other\ndate = {}\nversion = v1.0\nauthors = Plenoscope\ncontact = none\n\
         disp_min = {}\ndisp_max = {}\nfrustum_disp_min = {}\nfrustum_disp_max = {}\ndepth_map_scale = 1.0\n",
        camera.focal_mm,
        camera.sensor_mm,
        grid.cols(),
        grid.rows(),
        camera.baseline_mm,
        camera.focus_m,
        today(),
        range[0],
        range[1],
        range[0].floor(),
        range[1].ceil(),
    )
}

/// The folder's name without what the tools' parser takes for more than text.
fn scene_name(path: &Path) -> String {
    let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    name.chars().map(|c| if c.is_alphanumeric() || " -_.".contains(c) { c } else { '_' }).collect()
}

/// Today's date, UTC, from the days since 1970 (H. Hinnant, "chrono-compatible low-level date algorithms").
fn today() -> String {
    let days = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs() / 86_400) + 719_468;
    let (era, of_era) = (days / 146_097, days % 146_097);
    let year_of_era = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let shifted = (5 * of_year + 2) / 153;
    let day = of_year - (153 * shifted + 2) / 5 + 1;
    let month = if shifted < 10 { shifted + 3 } else { shifted - 9 };
    format!("{:04}-{month:02}-{day:02}", era * 400 + year_of_era + u64::from(month <= 2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cameras_depths_give_the_disparities_back() {
        let camera = Camera::for_range([-1.6, 1.5], [512, 384]);
        let beta = camera.baseline_mm * camera.focal_mm * camera.max_side;
        for d in [-1.6f32, 0.0, 0.7, 1.5] {
            let depth_mm = camera.depth_m(d) * 1000.0;
            let focus_mm = camera.focus_m * 1000.0;
            let back = (beta * focus_mm / depth_mm - beta) / (focus_mm * camera.sensor_mm);
            assert!(depth_mm > 0.0 && (back - d).abs() < 1e-3, "{d} → {depth_mm} mm → {back}");
        }
    }

    #[test]
    fn the_centre_is_the_benchmarks() {
        let center = |rows, cols| center(ViewGrid::new(rows, cols).unwrap());
        assert_eq!(center(9, 9), ViewIndex { v: 4, u: 4 });
        assert_eq!(center(8, 8), ViewIndex { v: 4, u: 0 });
        assert_eq!(scene_name(Path::new("/a/100%\n= rose")), "100___ rose");
    }
}
