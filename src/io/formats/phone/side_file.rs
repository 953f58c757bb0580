//! A depth map in a file beside the photo: `photo_DEPTH.jpg` (Lens Blur tools) or `photo_depth.png`.

use std::path::{Path, PathBuf};

use crate::field::Photo;
use crate::io::formats::depth_map::{self, NearEnd};
use crate::io::open::read_file;
use crate::io::{DepthKind, EmbeddedDepth};

const ENDINGS: [&str; 4] = ["_DEPTH", "_depth", "_Depth", "_disparity"];
const SUFFIXES: [&str; 8] = ["jpg", "png", "jpeg", "JPG", "PNG", "webp", "tif", "pfm"];

/// What was found beside a photo.
#[derive(Default)]
pub(crate) struct Found {
    pub(crate) depth: Option<EmbeddedDepth>,
    pub(crate) warning: Option<String>,
}

/// Looks for the map of a photo. A broken one, or one of another shape, is a warning.
pub(crate) fn find(path: &Path, photo: &Photo) -> Found {
    let Some(beside) = candidate(path) else { return Found::default() };
    let name = beside.display();
    let left_out = |why: String| {
        let warning = Some(format!("the depth map beside the photo is left out — {why}: {name}"));
        Found { depth: None, warning }
    };
    let map = match read_file(&beside).and_then(|bytes| depth_map::parse(&bytes)) {
        Ok(map) => map,
        Err(problem) => return left_out(problem.to_string()),
    };
    if !same_shape(map.size(), photo.size()) {
        return left_out("it has another shape".to_owned());
    }
    let end = map.near_end_guess();
    let which = if end == NearEnd::White { "white" } else { "black" };
    let guessed = || {
        format!(
            "the depth map beside the photo does not say which end is near — {which} is taken, as the lower part of a photo is mostly nearer: {name}"
        )
    };
    // A PFM holds disparities.
    let warning = (!map.is_disparity).then(guessed);
    let depth = EmbeddedDepth { kind: DepthKind::SideFile, map: map.nearness(end), metric: false };
    Found { depth: Some(depth), warning }
}

fn candidate(path: &Path) -> Option<PathBuf> {
    let stem = path.file_stem()?.to_str()?;
    let folder = path.parent()?;
    ENDINGS
        .iter()
        .flat_map(|ending| SUFFIXES.iter().map(move |suffix| format!("{stem}{ending}.{suffix}")))
        .map(|name| folder.join(name))
        .find(|path| path.is_file())
}

/// Whether two sizes have the same shape, give or take 2 %.
pub(crate) fn same_shape(a: [u32; 2], b: [u32; 2]) -> bool {
    let ratio = (f64::from(a[0]) * f64::from(b[1])) / (f64::from(a[1]) * f64::from(b[0]));
    (ratio - 1.0).abs() < 0.02
}
