//! Light-field and depth formats: one file each, and [`TABLE`], which says who reads and writes what.

pub mod depth_map;
pub mod depth_out;
pub mod eslf;
pub mod gaussians;
mod grid_names;
pub mod hci;
pub mod layout;
pub mod living;
pub mod lytro;
mod matching;
mod middlebury;
pub mod mpo;
pub(in crate::io) mod out;
pub mod pfm;
pub(crate) mod phone;
pub mod ply;
pub mod quilt;
pub mod stanford;
pub mod stereo;
pub mod stereo_heic;
#[cfg(test)]
mod tests;
pub mod views;

use std::path::Path;
use std::sync::Arc;

use heifer::heifer_isobmff::HeifFile;

use super::file_type::FileType;
use super::raster::{avif, still};
use super::save::SaveError;
use super::{EmbeddedDepth, LightFieldFile, Opened, PhotoFile, Problem, avi as film};
use crate::field::Photo;
use crate::job::Job;
use phone::{apple, dynamic, gdepth, heic, jpeg, side_file, spatial};

pub use out::FieldToWrite;

/// What a file or folder holds; nothing where it is of another format.
type Found<T> = Result<Option<T>, Problem>;
/// The depth in a photo's file, or what is wrong with it.
type FoundDepth = Option<Result<EmbeddedDepth, String>>;

/// How a format is told from others, and what opens it.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Reader {
    /// Files that their first bytes tell.
    Files(&'static [FileType]),
    /// A light field within one picture: told by what is in it, or by its name.
    Within(fn(&[u8], Option<&Path>, &Job) -> Found<LightFieldFile>),
    /// A folder: the file that stands for it, and what opens it if it is such a one.
    Folder(Option<&'static str>, fn(&Path, &Job) -> Found<Opened>),
    /// Depth in the photo of another line.
    Depth(DepthIn),
    /// Depth in a file beside a photo.
    Beside(fn(&Path, &Photo) -> side_file::Found),
    /// A picture of another line, given as a map: see [`depth_map`].
    AsMap,
}

/// What looks for depth in a photo's file; `None` where it is of another kind.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DepthIn {
    /// In a JPEG.
    pub(crate) jpeg: Option<fn(&jpeg::Extras) -> FoundDepth>,
    /// In a HEIC.
    pub(crate) heic: Option<fn(&HeifFile, &[u8]) -> FoundDepth>,
}

/// What writes a format.
#[derive(Clone, Copy, Debug)]
pub enum Writer {
    /// A whole light field.
    Field(fn(&Path, &FieldToWrite, &Job) -> Result<(), SaveError>),
    /// What is made from one; the module that does it.
    Made(&'static str),
}

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
    /// How it is told and opened, where it is read.
    pub(crate) reader: Option<Reader>,
    /// What writes it, where it is written.
    pub writer: Option<Writer>,
    /// What comes back.
    pub keeps: Keeps,
    /// The suffix of a written file; none for a folder.
    pub suffix: Option<&'static str>,
}

/// Who reads and writes what: [`open`](fn@super::open) walks it from the top, so what is told by more stands higher. The
/// README's table has the same lines; a test compares them.
pub static TABLE: [Entry; 25] = [
    made("refocus", "photo: JPEG, PNG, TIFF, WebP", "save", "jpg").read(Reader::Files(&[
        jpeg::TYPE,
        still::PNG,
        still::TIFF,
        still::WEBP,
    ])),
    read(
        "photo: HEIC, AVIF, BMP, PNM, GIF (first frame)",
        Reader::Files(&[heic::TYPE, avif::TYPE, still::BMP, still::PNM, still::GIF]),
    ),
    read("film: motion-JPEG in AVI (first picture; all with `burst`)", Reader::Files(&[film::TYPE])),
    field("hci", "HCI 4-D benchmark scene", Keeps::ViewsAndDepths, None, hci::write)
        .read(Reader::Folder(Some(hci::CONFIG), hci::read)),
    field("stanford", "Stanford archive", Keeps::Views, None, stanford::write)
        .read(Reader::Folder(None, stanford::read)),
    field(
        "views",
        "folder of views (`view_V_U.png`, `disparity_V_U.pfm`, `lightfield.json`)",
        Keeps::ViewsAndDepths,
        None,
        views::write,
    )
    .read(Reader::Folder(Some(views::INDEX_FILE), views::read)),
    read(
        "Middlebury stereo scene (`im0.png`, `disp0.pfm`, `calib.txt`)",
        Reader::Folder(Some(middlebury::CALIBRATION), middlebury::read),
    ),
    read("folder of views with other names", Reader::Folder(None, views::read_any)),
    made("quilt", "Looking Glass quilt", "quilt", "png").read(Reader::Within(quilt::read)),
    field("eslf", "ESLF lenslet picture", Keeps::Views, Some("png"), eslf::write).read(Reader::Within(eslf::read)),
    Entry { keeps: Keeps::OneMap, ..made(".pfm", "depth map: PFM", "depth_out", "pfm") }
        .read(Reader::Files(&[pfm::TYPE])),
    made(".png", "depth map: 16-bit PNG", "depth_out", "png").read(Reader::AsMap),
    read("phone depth: Dynamic Depth", Reader::Depth(DepthIn { jpeg: Some(dynamic::read), heic: None })),
    made("gdepth", "phone depth: GDepth", "depth_out", "jpg")
        .read(Reader::Depth(DepthIn { jpeg: Some(gdepth::read), heic: None })),
    read(
        "phone depth: Apple portrait (HEIC, JPEG)",
        Reader::Depth(DepthIn { jpeg: Some(apple::read_jpeg), heic: Some(heic::read_depth) }),
    ),
    made("spatial", "phone depth: spatial photo (HEIC)", "stereo_heic", "heic")
        .read(Reader::Depth(DepthIn { jpeg: None, heic: Some(spatial::read) })),
    read("phone depth: file beside the photo (`_DEPTH`)", Reader::Beside(side_file::find)),
    read("processed Lytro file (`-stk.lfp`)", Reader::Files(&[lytro::TYPE])),
    field("gaussians", "Gaussian splats (PLY)", Keeps::Made, Some("ply"), gaussians::write)
        .read(Reader::Files(&[gaussians::TYPE])),
    read("Gaussian splats (SPZ)", Reader::Files(&[gaussians::SPZ])),
    made("side-by-side", "side-by-side stereo", "stereo", "png"),
    made("mpo", "stereo pair (MPO)", "mpo", "mpo"),
    made("anaglyph", "red-cyan anaglyph (Dubois)", "stereo", "png"),
    made("html", "living picture (HTML)", "living", "html"),
    made("ply", "PLY point cloud", "ply", "ply"),
];

const fn read(name: &'static str, reader: Reader) -> Entry {
    Entry { id: "", name, reader: Some(reader), writer: None, keeps: Keeps::Made, suffix: None }
}

const fn made(id: &'static str, name: &'static str, module: &'static str, suffix: &'static str) -> Entry {
    let writer = Some(Writer::Made(module));
    Entry { id, name, reader: None, writer, keeps: Keeps::Made, suffix: Some(suffix) }
}

const fn field(
    id: &'static str,
    name: &'static str,
    keeps: Keeps,
    suffix: Option<&'static str>,
    write: fn(&Path, &FieldToWrite, &Job) -> Result<(), SaveError>,
) -> Entry {
    Entry { id, name, reader: None, writer: Some(Writer::Field(write)), keeps, suffix }
}

impl Entry {
    const fn read(self, reader: Reader) -> Self {
        Self { reader: Some(reader), ..self }
    }

    /// Whether it is read.
    pub fn is_read(&self) -> bool {
        self.reader.is_some()
    }
}

fn readers() -> impl Iterator<Item = Reader> {
    TABLE.iter().filter_map(|entry| entry.reader)
}

/// The line of a name on the command line.
pub fn by_id(id: &str) -> Option<&'static Entry> {
    TABLE.iter().find(|entry| !entry.id.is_empty() && entry.id == id)
}

/// The formats that first bytes tell.
pub(crate) fn file_types() -> impl Iterator<Item = &'static FileType> {
    readers().flat_map(|reader| if let Reader::Files(types) = reader { types } else { &[] })
}

/// Whether a file stands for the folder that it lies in.
pub(crate) fn is_index_file(path: &Path) -> bool {
    let name = path.file_name().map(|n| n.to_string_lossy().to_lowercase()).unwrap_or_default();
    readers().any(|reader| matches!(reader, Reader::Folder(Some(index), _) if index == name)) && path.is_file()
}

/// What is in a folder, or `None` where it is of no format.
pub(crate) fn read_folder(path: &Path, job: &Job) -> Found<Opened> {
    let open = |reader| if let Reader::Folder(_, open) = reader { open(path, job).transpose() } else { None };
    readers().find_map(open).transpose()
}

/// A light field in one file, or `None` where the file is an ordinary picture.
pub(crate) fn read_within(bytes: &[u8], name: Option<&Path>, job: &Job) -> Found<LightFieldFile> {
    let open = |reader| if let Reader::Within(open) = reader { open(bytes, name, job).transpose() } else { None };
    readers().find_map(open).transpose()
}

/// The first depth that a line of the table finds in a photo's file. What is broken is told, and the next line looks.
pub(crate) fn depth_in(warnings: &mut Vec<String>, read: impl Fn(DepthIn) -> FoundDepth) -> Option<EmbeddedDepth> {
    let found = readers().filter_map(|reader| if let Reader::Depth(depth) = reader { read(depth) } else { None });
    let mut told = |reason: String| warnings.push(depth_left_out(&reason));
    found.filter_map(|depth| depth.map_err(&mut told).ok()).next()
}

/// What is said of depth that is broken.
pub(crate) fn depth_left_out(reason: &str) -> String {
    format!("the depth map is left out — {reason}")
}

/// Looks for depth beside a photo that has none.
pub(crate) fn add_depth_beside(path: &Path, file: &mut PhotoFile) {
    for reader in readers() {
        if let (Reader::Beside(find), None) = (reader, &file.depth) {
            let beside = find(path, &file.photo);
            beside.depth.into_iter().for_each(|depth| file.set_depth(depth));
            beside.warning.into_iter().for_each(|text| file.warn(text));
        }
    }
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
