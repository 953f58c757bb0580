//! Pictures that know how they were made: what goes into them, and the way back to photo and edit.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::export::Settings;
use super::recipe::LARGEST_BYTES;
use super::{DepthFrom, Edit, Recipe, Scene, SceneError, Subject};
use crate::aside;
use crate::field::{DisparityMap, Metadata, Photo, PhotoPixels, Pixels, Samples, ViewOffset};
use crate::io::carried::{Carried, PhotoTag};
use crate::io::save::{Carry, Format, Keep, Origin, PictureOptions, encode};
use crate::io::{self, Opened, exif};
use crate::job::{Cancelled, Job, Stage};
use crate::within;

/// Files beside a picture that are looked at for its photo.
const MOST_FILES: usize = 10_000;

/// What goes into a picture beside its pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(from = "Vec<Part>", into = "Vec<Part>")]
pub struct Embed {
    /// The recipe with its repairs, and which photo it is of.
    pub recipe: bool,
    /// The depth map.
    pub depth: bool,
    /// The photo's file itself, with the recipe.
    pub photo: bool,
}

/// One part of that, as recipes and the command line name it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Part {
    /// The recipe.
    Recipe,
    /// The depth map.
    Depth,
    /// The photo.
    Photo,
}

impl From<Vec<Part>> for Embed {
    fn from(parts: Vec<Part>) -> Self {
        let has = |part| parts.contains(&part);
        Self { recipe: has(Part::Recipe), depth: has(Part::Depth), photo: has(Part::Photo) }
    }
}

impl From<Embed> for Vec<Part> {
    fn from(Embed { recipe, depth, photo }: Embed) -> Self {
        let all = [(recipe, Part::Recipe), (depth, Part::Depth), (photo, Part::Photo)];
        all.into_iter().filter(|(is_in, _)| *is_in).map(|(_, part)| part).collect()
    }
}

/// What a picture of a scene takes along, as its settings say; nothing where no metadata goes along.
///
/// # Errors
/// [`SceneError`]: stopped.
pub(super) fn carry(scene: &Scene, edit: &Edit, settings: &Settings, job: &Job) -> Result<Carry, SceneError> {
    let Embed { recipe, depth, photo } = settings.picture.embed;
    if settings.picture.keep == Keep::Nothing {
        return Ok(Carry::default());
    }
    let depth = if depth { Some(Arc::new(seen_depth(scene, edit, job)?)) } else { None };
    if !recipe && !photo {
        return Ok(Carry { depth, ..Carry::default() });
    }
    job.advance(Stage::Save, 0, 1)?;
    let subject = scene.subject();
    let found = file_of(subject, photo, job);
    let tag = found.as_ref().map(|(name, file)| PhotoTag::of(name, file));
    let stays = photo && !(settings.picture.keep == Keep::WithoutPosition && tells_place(subject, job));
    Ok(Carry {
        recipe: Some(recipe_of(scene, edit, settings, job)),
        photo: tag,
        file: found.map(|(_, file)| file).filter(|_| stays),
        depth,
    })
}

/// The disparity of what the picture shows, from where the eye is.
fn seen_depth(scene: &Scene, edit: &Edit, job: &Job) -> Result<DisparityMap, SceneError> {
    if edit.viewpoint.0 == ViewOffset::default() {
        return Ok(DisparityMap::clone(scene.map()));
    }
    let size = scene.map().size();
    let pivot_px = edit.pivot_px(size[0], scene.strength());
    Ok(scene.rgbd()?.seen_from(edit.viewpoint, pivot_px, size, job)?.disparity().clone())
}

/// The whole recipe in one line.
fn recipe_of(scene: &Scene, edit: &Edit, settings: &Settings, job: &Job) -> String {
    if settings.recipe.depth == Some(DepthFrom::Map) {
        job.sink.warning("A map of your own does not go into the picture: name it again with its edit".to_owned());
    }
    let depth = settings.recipe.depth.clone().unwrap_or_default();
    let mut recipe = settings.recipe.clone();
    recipe.export = settings.picture.clone();
    recipe.with_edit(edit.clone()).with_depth(&depth).with_repairs(scene.repairs().clone()).to_line()
}

/// Whether a photo's file says where it was taken; the person is told why it stays out.
fn tells_place(subject: &Subject, job: &Job) -> bool {
    let Some(Metadata { exif, xmp, .. }) = subject.photo().map(|photo| photo.metadata()) else { return false };
    let in_xmp = |xmp: &[u8]| xmp.windows(8).any(|window| window == b"exif:GPS");
    let tells = exif.as_deref().is_some_and(exif::has_position) || xmp.as_deref().is_some_and(in_xmp);
    if tells {
        job.sink.warning(
            "The photo does not go into the picture: its file says where it was taken, which is to be left out"
                .to_owned(),
        );
    }
    tells
}

/// The name and the file of a subject. Where there is none, as of a pasted picture, one is made if it is to go along.
fn file_of(subject: &Subject, is_wanted: bool, job: &Job) -> Option<(String, Arc<[u8]>)> {
    let named = |file| Some((subject.name.clone(), file));
    if let Some(file) = &subject.file {
        return named(Arc::clone(file));
    }
    match &subject.path {
        Some(path) if path.is_file() => match within::bytes(path, io::MAX_FILE_BYTES) {
            Ok(file) => named(file.into()),
            Err(error) => {
                job.sink.warning(format!("The picture will not know its photo: {error}"));
                None
            }
        },
        Some(_) => None,
        None => Some((format!("{}.png", subject.name), png(subject.photo().filter(|_| is_wanted)?)?)),
    }
}

/// A photo that is no file as one.
fn png(photo: &Photo) -> Option<Arc<[u8]>> {
    let samples = match photo.pixels() {
        PhotoPixels::Eight(px) => Samples::Eight(px.chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect()),
        PhotoPixels::Sixteen(px) => Samples::Sixteen(px.chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect()),
    };
    let options = PictureOptions { origin: Origin::in_own_space(photo), ..PictureOptions::default() };
    let mut file = std::io::Cursor::new(Vec::new());
    encode(&mut file, Format::Png, &Pixels { size: photo.size(), samples }, &options).ok()?;
    Some(file.into_inner().into())
}

/// A photo, and the edit that a picture of it carried.
pub struct Restored {
    /// The photo.
    pub subject: Subject,
    /// The edit.
    pub recipe: Recipe,
}

impl Restored {
    /// Opens the photo that a picture was made of: the one in it, else the one right beside it that has its hash.
    ///
    /// # Errors
    /// One sentence: the picture carries no edit, or one that cannot be used; the photo is not there.
    pub fn open(picture: &Path, job: &Job) -> Result<Self, SceneError> {
        let none = || {
            SceneError::Refused(format!(
                "this picture carries no edit — it was not exported with one — name a recipe: {}",
                picture.display()
            ))
        };
        match io::open(picture, job)? {
            Opened::Photo(file) => Self::of(&file.carried.ok_or_else(none)?, picture, job),
            Opened::LightField(_) => Err(none()),
        }
    }

    /// The same of what was found in a picture.
    ///
    /// # Errors
    /// As above.
    pub fn of(found: &Result<Carried, String>, picture: &Path, job: &Job) -> Result<Self, SceneError> {
        let unusable = |why: &str| {
            SceneError::Refused(format!(
                "the edit in this picture cannot be used — {why} — open the photo itself: {}",
                picture.display()
            ))
        };
        let carried = found.as_ref().map_err(|why| unusable(why))?;
        if carried.recipe.len() as u64 > LARGEST_BYTES {
            return Err(unusable("it is larger than any edit"));
        }
        let recipe = Recipe::from_json(&carried.recipe).map_err(|why| unusable(&within::plain_words(&why, 200)))?;
        let tag = carried.photo.as_ref().ok_or_else(|| unusable("it was made of no single file"))?;
        let subject = match &carried.file {
            Some(file) => inside(file, tag, job)?,
            None => match beside(tag, picture, job)? {
                Some(photo) => Subject::open(&photo, job)?,
                None => {
                    let name = within::plain_words(&tag.name, 80);
                    return Err(SceneError::Refused(format!(
                        "the photo that this picture was made of is not beside it — {name} was moved or changed — put it \
                         into the same folder: {}",
                        picture.display()
                    )));
                }
            },
        };
        // As it was called, so that the picture of it is the same again.
        Ok(Self { subject: Subject { name: tag.name.clone(), ..subject }, recipe })
    }
}

/// The photo in a picture. Files beside it are not looked at.
fn inside(file: &Arc<[u8]>, tag: &PhotoTag, job: &Job) -> Result<Subject, SceneError> {
    let name = Path::new(&tag.name);
    let opened = io::open_bytes(file, Some(name))?;
    opened.info().warnings.iter().for_each(|warning| job.sink.warning(warning.clone()));
    Ok(Subject { path: None, file: Some(Arc::clone(file)), ..Subject::from_opened(opened, name) })
}

/// The file with a tag in a picture's folder: first the one of its name.
fn beside(tag: &PhotoTag, picture: &Path, job: &Job) -> Result<Option<PathBuf>, Cancelled> {
    let folder = aside::parent(picture);
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten().take(MOST_FILES);
    let as_long = |path: &PathBuf| path.metadata().is_ok_and(|facts| facts.is_file() && facts.len() == tag.bytes);
    let others = entries.map(|entry| entry.path());
    for path in std::iter::once(folder.join(&tag.name)).chain(others).filter(as_long) {
        job.check()?;
        let most = tag.bytes.min(io::MAX_FILE_BYTES);
        if within::bytes(&path, most).is_ok_and(|file| tag.is_of(&file)) {
            return Ok(Some(path));
        }
    }
    Ok(None)
}
