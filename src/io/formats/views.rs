//! A folder of views: our own `views` folder (with `lightfield.json`), and any folder whose file names count views.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use png::{BitDepth, ColorType};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::grid_names::{self, GridFiles};
use super::out::{self, FieldToWrite};
use super::{layout, pfm};
use crate::field::{DisparityMap, LightField, Photo, Provenance, RayDepths, Seen, View, ViewGrid, ViewIndex};
use crate::io::open::{MAX_TEXT_BYTES, read_file, read_up_to};
use crate::io::save::{self, SaveError};
use crate::io::{FileInfo, LightFieldFile, Opened, Problem, raster};
use crate::job::{Job, Stage};
use crate::within::plain_words;

/// The index file of a `views` folder.
pub const INDEX_FILE: &str = "lightfield.json";
/// The most bytes that the views of a light field may take: 17×17 of a megapixel, and some more.
const MAX_FIELD_BYTES: u64 = 3 << 29;
const FORMAT: &str = "views folder";
/// The most letters of a stranger's word that are shown.
pub(super) const MOST_LETTERS: usize = 200;
/// Views of one scene differ by less than this when they are moved onto each other, on average.
const UNRELATED: f32 = 0.05;

/// The parts of `lightfield.json` that matter to a reader; everything else in it is let be.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Index {
    grid: Option<[usize; 2]>,
    reference_view: Option<[usize; 2]>,
    disparity_px_min_max: Option<[f32; 2]>,
    disparity_px_2_98: Option<[f32; 2]>,
    name: Option<String>,
    camera: Option<String>,
    scene: Option<String>,
}

/// Reads our own folder, which has an index; `None` where there is none.
pub(super) fn read(folder: &Path, job: &Job) -> Result<Option<Opened>, Problem> {
    if folder.join(INDEX_FILE).is_file() { read_any(folder, job) } else { Ok(None) }
}

/// Reads a folder of views; `None` where its names do not fill a grid.
pub(super) fn read_any(folder: &Path, job: &Job) -> Result<Option<Opened>, Problem> {
    let index = read_index(folder)?;
    let grid = index.0.grid.map(|[rows, cols]| ViewGrid::new(rows, cols)).transpose()?;
    match grid_names::find(folder, grid)? {
        Some(files) => read_files(FORMAT, folder, &files, index, job),
        None => Ok(None),
    }
}

/// Reads the files of a folder, if they are views; what is wrong with its index has been said.
pub(super) fn read_files(
    format: &'static str,
    folder: &Path,
    files: &GridFiles,
    (index, index_warning): (Index, Option<String>),
    job: &Job,
) -> Result<Option<Opened>, Problem> {
    let field = match read_views(files, job) {
        // A running number alone is what photos have too: only pictures that fit together are views.
        Ok(field) if files.running && !are_views(&field) => return Ok(None),
        Err(Problem::TooLarge { .. } | Problem::Implausible { .. }) if files.running => return Ok(None),
        Err(Problem::In { problem, .. }) if files.running && matches!(*problem, Problem::OddView { .. }) => {
            return Ok(None);
        }
        read => read?,
    };
    let mut info = FileInfo::light_field(format, &field);
    info.disparity_px = index.disparity_px_min_max.or(index.disparity_px_2_98);
    for (name, text) in [("name", index.name), ("camera", index.camera), ("scene", index.scene)] {
        info.notes.extend(text.map(|text| (name.to_owned(), plain_words(&text, MOST_LETTERS))));
    }
    let mut warnings: Vec<String> = index_warning.into_iter().collect();
    let reference = field.grid().reference();
    if let Some(other) =
        index.reference_view.filter(|&[v, u]| v != usize::from(reference.v) || u != usize::from(reference.u))
    {
        warnings.push(format!(
            "the reference view is ({}, {}) here, not {other:?} as lightfield.json says",
            reference.v, reference.u
        ));
    }
    let name = |at: ViewIndex| folder.join(format!("disparity_{}_{}.pfm", at.v, at.u));
    let depths = read_depths(&field, name, job, &mut warnings)?;
    info.warnings = warnings;
    let provenance = read_provenance(folder, &field);
    if files.corners {
        info.notes.push(("views".to_owned(), "the corners alone".to_owned()));
    }
    let mut file = LightFieldFile::new(Arc::new(field), depths, info);
    file.provenance = provenance;
    file.corners = files.corners;
    // Our own folders say how they lie; of others it is found out.
    if index.grid.is_none() && file.depths.is_none() && !files.corners {
        super::check_layout(&mut file);
    }
    Ok(Some(file.into()))
}

/// Whether pictures with a running number, which photos have too, fit together as views of one scene in this order.
fn are_views(field: &LightField) -> bool {
    layout::guess(field).first().is_some_and(|best| best.error <= UNRELATED) && layout::is_in_order(field)
}

/// The index, or an empty one; a broken one is a warning, as the names tell the grid too.
pub(super) fn read_index(folder: &Path) -> Result<(Index, Option<String>), Problem> {
    let path = folder.join(INDEX_FILE);
    if !path.is_file() {
        return Ok((Index::default(), None));
    }
    let bytes = read_up_to(&path, MAX_TEXT_BYTES).map_err(Problem::of(&path))?;
    Ok(match serde_json::from_slice(&bytes) {
        Ok(index) => (index, None),
        Err(error) => (
            Index::default(),
            Some(format!("lightfield.json cannot be read ({error}), so the file names tell the grid")),
        ),
    })
}

/// Decodes all views, some at a time; all must have the size of the first.
pub(super) fn read_views(files: &GridFiles, job: &Job) -> Result<LightField, Problem> {
    let first = &files.files[0];
    let size = read_file(first).and_then(|bytes| view_size(&bytes)).map_err(Problem::of(first))?;
    check_memory(files, size)?;
    let done = AtomicU32::new(0);
    let total = files.files.len() as u32;
    // Progress is told from this thread's pool; the sink is `Sync`.
    let views: Result<Vec<Arc<View>>, Problem> = files
        .files
        .par_iter()
        .map(|path| {
            job.check()?;
            let view = read_view(path, size)?;
            job.advance(Stage::Open, done.fetch_add(1, Ordering::Relaxed), total)?;
            Ok(Arc::new(view))
        })
        .collect();
    Ok(LightField::new(files.grid, views?)?)
}

/// Refuses views that do not fit into memory together, or whose headers claim more than their files can hold.
fn check_memory(files: &GridFiles, [width, height]: [u32; 2]) -> Result<(), Problem> {
    let height = u64::from(height) * files.grid.count() as u64;
    let lengths = files.files.iter().map(|path| std::fs::metadata(path).map_or(0, |file| file.len()));
    raster::check_size_within(MAX_FIELD_BYTES, [width.into(), height], 4, lengths.sum::<u64>() as usize)
}

/// Width and height of a view that its header tells.
fn view_size(bytes: &[u8]) -> Result<[u32; 2], Problem> {
    raster::header_size(bytes)
}

/// Decodes a view, if it is as large as the others.
fn read_view(path: &Path, size: [u32; 2]) -> Result<View, Problem> {
    let read = || {
        let bytes = read_file(path)?;
        let [w, h] = view_size(&bytes)?;
        if [w, h] != size {
            return Err(Problem::OddView { width: w, height: h, others: size });
        }
        raster::decode_view(&bytes)
    };
    read().map_err(Problem::of(path))
}

/// Reads one PFM for each view. None there: no ray depths. Some broken: a warning, and no ray depths.
pub(super) fn read_depths(
    field: &LightField,
    name: impl Fn(ViewIndex) -> PathBuf + Sync,
    job: &Job,
    warnings: &mut Vec<String>,
) -> Result<Option<Arc<RayDepths>>, Problem> {
    let grid = field.grid();
    if !name(ViewIndex { v: 0, u: 0 }).is_file() {
        return Ok(None);
    }
    let views: Vec<ViewIndex> = grid.views().collect();
    let maps: Vec<Result<Vec<f32>, String>> = views
        .par_iter()
        .map(|&at| {
            let path = name(at);
            let map = pfm::read_sized(&path, field.size());
            map.map(DisparityMap::into_disparity_px).map_err(|problem| format!("{problem}: {}", path.display()))
        })
        .collect();
    job.check()?;
    match maps.into_iter().collect::<Result<Vec<_>, _>>() {
        Ok(maps) => Ok(Some(Arc::new(RayDepths::new(grid, field.size(), maps.concat())?))),
        Err(reason) => {
            warnings.push(format!("the ray depths are left out — {reason}"));
            Ok(None)
        }
    }
}

/// Reads where rays come from; none where one file is missing or broken, as the light field is whole without.
fn read_provenance(folder: &Path, field: &LightField) -> Option<Arc<Provenance>> {
    let grid = field.grid();
    let views: Vec<ViewIndex> = grid.views().collect();
    let one = |at: &ViewIndex| {
        let bytes = read_file(&folder.join(seen_name(*at))).ok()?;
        let size = raster::header_size(&bytes).ok().filter(|size| *size == field.size())?;
        let (_, pixels) = raster::decode_rgba8(&bytes).ok().filter(|decoded| decoded.0 == size)?;
        Some(pixels.into_iter().map(|pixel| Seen::of_grey(pixel[0])).collect::<Vec<_>>())
    };
    let first = one(&views[0])?;
    let rest = views[1..].par_iter().map(one).collect::<Option<Vec<_>>>()?;
    Provenance::new(grid, field.size(), [first, rest.concat()].concat()).ok().map(Arc::new)
}

/// The names of [`seen_name`] without their numbers.
pub(super) const SEEN_PATTERN: &str = "seen_#_#.png";

/// The file that says where a view's rays come from.
fn seen_name(at: ViewIndex) -> String {
    format!("seen_{}_{}.png", at.v, at.u)
}

/// `lightfield.json` as it is written.
#[derive(Serialize)]
struct WrittenIndex<'a> {
    format: &'a str,
    grid: [usize; 2],
    reference_view: [u8; 2],
    size_xy: [u32; 2],
    disparity_px_min_max: Option<[f32; 2]>,
    photo: Option<String>,
    models: Vec<WrittenModel<'a>>,
    convention: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    seen: Option<WrittenSeen<'a>>,
}

/// Where the rays come from: shares of all of them.
#[derive(Serialize)]
struct WrittenSeen<'a> {
    in_the_photo: f32,
    in_another_photo: f32,
    invented: f32,
    files: &'a str,
}

#[derive(Serialize)]
struct WrittenModel<'a> {
    id: &'a str,
    sha256: &'a str,
}

/// The sign convention, for people.
const CONVENTION: &str = "view(v,u)[y, x] = reference[y + (v-v0)*D, x + (u-u0)*D] with (v0, u0) the reference view; \
    v counts views downwards, u to the right; D is the ray's own disparity in disparity_V_U.pfm, in pixels per view \
    step; D > 0 is nearer than the focal plane";

/// What stands in the files of [`seen_name`], for people.
const SEEN: &str = "seen_V_U.png: 255 the reference photo saw the ray, 128 another photo did, 0 it is invented";

/// Writes our `views` folder: `view_V_U.png`, `disparity_V_U.pfm`, `lightfield.json`; of several photos also
/// `seen_V_U.png`.
///
/// # Errors
/// [`SaveError`]; then nothing has been written.
pub fn write(path: &Path, source: &FieldToWrite, job: &Job) -> Result<(), SaveError> {
    let is_ours = |name: &str| {
        name == INDEX_FILE
            || (name.starts_with("view_") && name.ends_with(".png"))
            || (name.starts_with("seen_") && name.ends_with(".png"))
            || (name.starts_with("disparity_") && name.ends_with(".pfm"))
    };
    save::folder(path, is_ours, |folder| {
        out::views(folder, source.field, |at| format!("view_{}_{}.png", at.v, at.u), job)?;
        if let Some(depths) = source.depths {
            for at in depths.grid().views() {
                job.check()?;
                let name = format!("disparity_{}_{}.pfm", at.v, at.u);
                out::map_pfm(&folder.join(name), depths.size(), depths.view(at))?;
            }
        }
        if let Some(provenance) = source.provenance {
            provenance.grid().views().collect::<Vec<_>>().into_par_iter().try_for_each(|at| {
                let grey = provenance.picture(at);
                let rows = grey.pixels().chunks_exact(grey.size()[0] as usize).map(<[u8]>::to_vec);
                let kind = (ColorType::Grayscale, BitDepth::Eight);
                out::file(&folder.join(seen_name(at)), |file| out::png(file, grey.size(), kind, &[], rows))
            })?;
        }
        let index = serde_json::to_vec_pretty(&index_of(source)).unwrap_or_default();
        out::file(&folder.join(INDEX_FILE), |file| file.write_all(&index))
    })
}

fn index_of<'a>(source: &FieldToWrite<'a>) -> WrittenIndex<'a> {
    let grid = source.field.grid();
    let reference = grid.reference();
    let name = |photo: &Photo| Some(photo.source()?.file_name()?.to_string_lossy().into_owned());
    WrittenIndex {
        format: "plenoscope views",
        grid: [grid.rows(), grid.cols()],
        reference_view: [reference.v, reference.u],
        size_xy: source.field.size(),
        disparity_px_min_max: source.depths.map(RayDepths::range_px),
        photo: source.photo.and_then(name),
        models: source.models.iter().map(|(id, sha256)| WrittenModel { id, sha256 }).collect(),
        convention: CONVENTION,
        seen: source.provenance.map(|provenance| WrittenSeen {
            in_the_photo: provenance.share(Seen::Reference),
            in_another_photo: provenance.share(Seen::Frame),
            invented: provenance.share(Seen::Invented),
            files: SEEN,
        }),
    }
}
