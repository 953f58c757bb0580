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
use crate::render::Picture;

pub use out::Source;

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
    /// Its name on the command line (`--as`, `--format`), where it is written.
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

/// Who reads and writes what.
pub const TABLE: [Entry; 16] = [
    both("views", "views folder", "views", Keeps::ViewsAndDepths, None),
    both("hci", "HCI 4-D benchmark folder", "hci", Keeps::ViewsAndDepths, None),
    both("stanford", "Stanford archive folder", "stanford", Keeps::Views, None),
    both("eslf", "ESLF lenslet picture", "eslf", Keeps::Views, Some("png")),
    both("quilt", "Looking Glass quilt", "quilt", Keeps::Made, Some("png")),
    both("pfm", "PFM map", "pfm", Keeps::OneMap, Some("pfm")),
    both("depth-png", "depth map, 16-bit PNG", "depth_map", Keeps::Made, Some("png")),
    both("gdepth", "JPEG with GDepth", "phone::gdepth", Keeps::Made, Some("jpg")),
    read_only("folder of numbered views", "grid_names"),
    read_only("JPEG with Dynamic Depth", "phone::dynamic"),
    read_only("Apple portrait (HEIC, JPEG)", "phone::apple"),
    read_only("spatial photo (HEIC)", "phone::spatial"),
    read_only("processed Lytro file (-stk.lfp)", "lytro"),
    write_only("side-by-side", "side-by-side stereo picture", "stereo", "png"),
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

/// Linear light between pixels of a picture, edges go on.
fn tap(picture: &Picture, x: f32, y: f32) -> [f32; 3] {
    let [w, h] = picture.size.map(|side| side as usize);
    let (x, y) = (x.clamp(0.0, (w - 1) as f32), y.clamp(0.0, (h - 1) as f32));
    let (x0, y0) = (x as usize, y as usize);
    let (x1, y1) = ((x0 + 1).min(w - 1), (y0 + 1).min(h - 1));
    let (fx, fy) = (x - x0 as f32, y - y0 as f32);
    std::array::from_fn(|c| {
        let at = |x: usize, y: usize| picture.rgb_linear[(y * w + x) * 3 + c];
        (at(x0, y0) * (1.0 - fx) + at(x1, y0) * fx) * (1.0 - fy) + (at(x0, y1) * (1.0 - fx) + at(x1, y1) * fx) * fy
    })
}
