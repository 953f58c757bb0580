//! A depth map in a file beside the photo: `photo_DEPTH.jpg` (Lens Blur tools) or `photo_depth.png`.

use std::path::{Path, PathBuf};

use crate::field::Photo;
use crate::io::formats::depth_map::{self, NearEnd};
use crate::io::open::read_file;
use crate::io::{DepthKind, EmbeddedDepth};

const ENDINGS: [&str; 4] = ["_DEPTH", "_depth", "_Depth", "_disparity"];
const SUFFIXES: [&str; 8] = ["jpg", "png", "jpeg", "JPG", "PNG", "webp", "tif", "pfm"];

/// Looks for the map of a photo. A broken one, or one of another shape, is a warning.
pub(crate) fn find(path: &Path, photo: &Photo, warnings: &mut Vec<String>) -> Option<EmbeddedDepth> {
    let beside = candidate(path)?;
    let name = beside.display();
    let read = read_file(&beside).and_then(|bytes| depth_map::parse(&bytes));
    let map = match read {
        Ok(map) => map,
        Err(problem) => {
            warnings.push(format!("the depth map beside the photo is left out — {problem}: {name}"));
            return None;
        }
    };
    if !same_shape(map.size, photo.size()) {
        warnings.push(format!("the depth map beside the photo is left out — it has another shape: {name}"));
        return None;
    }
    let end = map.near_end_guess();
    let which = if end == NearEnd::White { "white" } else { "black" };
    warnings.push(format!("the depth map beside the photo does not say which end is near; {which} is taken: {name}"));
    Some(EmbeddedDepth { kind: DepthKind::SideFile, size: map.size, inverse_depth: map.nearness(end), metric: false })
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
