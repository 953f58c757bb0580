//! Light-field and depth formats: one file each, and [`TABLE`], which says who reads and writes what.

pub mod depth_map;
pub mod depth_out;
pub mod eslf;
mod grid_names;
pub mod hci;
pub mod layout;
pub mod lytro;
mod matching;
mod out;
pub mod pfm;
pub(crate) mod phone;
pub mod ply;
pub mod quilt;
pub mod stanford;
pub mod stereo;
#[cfg(test)]
mod tests;
pub mod views;

use std::path::Path;
use std::sync::Arc;

use super::sniff::Sniffed;
use super::{LightFieldFile, Problem};
use crate::job::Job;

pub use out::FieldToWrite;

/// What of a light field survives being written and read again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Keeps {
    /// Every view and every ray depth, bit for bit.
    ViewsAndDepths,
    /// Every view, bit for bit; no ray depths.
    Views,
    /// The ray depths of one view, bit for bit.
    OneMap,
    /// Something made from it: it does not come back.
    Made,
}

/// One line of the table.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// How the command line calls it where it is written: `--as`, `--format`, a command, or a file's ending.
    pub id: &'static str,
    /// What people call it.
    pub name: &'static str,
    /// Where it is read, the module that does it.
    pub reader: Option<&'static str>,
    /// Where it is written, the module that does it.
    pub writer: Option<&'static str>,
    /// What comes back.
    pub keeps: Keeps,
    /// The suffix of a written file; none for a folder.
    pub suffix: Option<&'static str>,
}

/// Who reads and writes what. The README's table has the same lines; a test compares them.
pub const TABLE: [Entry; 19] = [
    both("refocus", "photo: JPEG, PNG, TIFF, WebP", "raster", Keeps::Made, Some("jpg")),
    read_only("photo: HEIC, AVIF, BMP, PNM, GIF (first frame)", "raster"),
    both(
        "views",
        "folder of views (`view_V_U.png`, `disparity_V_U.pfm`, `lightfield.json`)",
        "views",
        Keeps::ViewsAndDepths,
        None,
    ),
    both("hci", "HCI 4-D benchmark scene", "hci", Keeps::ViewsAndDepths, None),
    both("stanford", "Stanford archive", "stanford", Keeps::Views, None),
    both("eslf", "ESLF lenslet picture", "eslf", Keeps::Views, Some("png")),
    both("quilt", "Looking Glass quilt", "quilt", Keeps::Made, Some("png")),
    both(".pfm", "depth map: PFM", "pfm", Keeps::OneMap, Some("pfm")),
    both(".png", "depth map: 16-bit PNG", "depth_map", Keeps::Made, Some("png")),
    both("gdepth", "phone depth: GDepth", "phone::gdepth", Keeps::Made, Some("jpg")),
    read_only("folder of views with other names", "grid_names"),
    read_only("phone depth: Dynamic Depth", "phone::dynamic"),
    read_only("phone depth: Apple portrait (HEIC, JPEG)", "phone::apple"),
    read_only("phone depth: spatial photo (HEIC)", "phone::spatial"),
    read_only("phone depth: file beside the photo (`_DEPTH`)", "phone::side_file"),
    read_only("processed Lytro file (`-stk.lfp`)", "lytro"),
    write_only("side-by-side", "side-by-side stereo", "stereo", "png"),
    write_only("anaglyph", "red-cyan anaglyph (Dubois)", "stereo", "png"),
    write_only("ply", "PLY point cloud", "ply", "ply"),
];

const fn both(
    id: &'static str,
    name: &'static str,
    module: &'static str,
    keeps: Keeps,
    suffix: Option<&'static str>,
) -> Entry {
    Entry { id, name, reader: Some(module), writer: Some(module), keeps, suffix }
}

const fn read_only(name: &'static str, module: &'static str) -> Entry {
    Entry { id: "", name, reader: Some(module), writer: None, keeps: Keeps::Made, suffix: None }
}

const fn write_only(id: &'static str, name: &'static str, module: &'static str, suffix: &'static str) -> Entry {
    Entry { id, name, reader: None, writer: Some(module), keeps: Keeps::Made, suffix: Some(suffix) }
}

/// The line of a name on the command line.
pub fn by_id(id: &str) -> Option<&'static Entry> {
    TABLE.iter().find(|entry| !entry.id.is_empty() && entry.id == id)
}

/// Files that stand for the folder they lie in.
pub(crate) fn is_index_file(path: &Path) -> bool {
    let name = path.file_name().map(|n| n.to_string_lossy().to_lowercase()).unwrap_or_default();
    matches!(name.as_str(), "lightfield.json" | "parameters.cfg") && path.is_file()
}

/// A light field in a folder, or `None` where the folder holds none.
pub(crate) fn read_folder(path: &Path, job: &Job) -> Result<Option<LightFieldFile>, Problem> {
    if let Some(file) = hci::read(path, job)? {
        return Ok(Some(file));
    }
    views::read(path, job)
}

/// A light field in one file, or `None` where the file is an ordinary picture.
pub(crate) fn read_single(
    bytes: &[u8],
    format: Sniffed,
    name: Option<&Path>,
    job: &Job,
) -> Result<Option<LightFieldFile>, Problem> {
    if let Some(file) = quilt::read(bytes, format, name, job)? {
        return Ok(Some(file));
    }
    eslf::read(bytes, format, name, job)
}

/// Looks whether foreign views lie as we think they do, and turns them where they clearly do not. The person is told,
/// and can turn them back ([`layout::Layout::apply`]).
fn check_layout(file: &mut LightFieldFile) {
    let note = "rows and columns are checked by what fits together; the common sign is taken as it lies";
    file.info.notes.push(("layout".to_owned(), note.to_owned()));
    let Some(guess) = layout::better_than_stored(&file.field) else { return };
    file.field = Arc::new(guess.layout.apply(&file.field));
    let grid = file.field.grid();
    file.info.views = Some([grid.rows(), grid.cols()]);
    file.layout = guess.layout;
    file.warn(format!("the views were laid out anew, because they fit together better so: {}", guess.layout));
}
