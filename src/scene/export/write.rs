//! Writing what was asked for, of what is open or of a file. Everything is written aside, then renamed.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::{Existing, Kind, Settings, living};
use crate::field::{DisparityMap, Pixels};
use crate::io::formats::depth_map::GivenDepth;
use crate::io::formats::depth_out::Seen;
use crate::io::formats::{self, FieldToWrite, Writer, depth_out, mpo, ply, quilt, stereo, stereo_heic};
use crate::io::save::{self, AnimationOptions, PictureOptions, SaveError};
use crate::job::{Job, Stage};
use crate::render::cpu;
use crate::scene::recipe::PictureSettings;
use crate::scene::{Edit, MadeViews, Maker, Making, Recipe, Scene, SceneError, Subject, embed, series};

/// Quality of the JPEG that carries the depth.
const GDEPTH_QUALITY: u8 = 95;

/// What came of an export.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Written {
    /// The file or folder was written.
    Saved(PathBuf),
    /// It was there already, or came there meanwhile, and was left as it is.
    Skipped(PathBuf),
}

/// A file that is opened, of which as much is made as is needed, and which is written.
pub struct FileExport<'a> {
    /// The photo or light field.
    pub path: &'a Path,
    /// A map to use instead of any other depth.
    pub own_map: Option<&'a GivenDepth>,
    /// The edit.
    pub recipe: &'a Recipe,
    /// What is written, and how.
    pub settings: &'a Settings,
    /// Where it goes.
    pub target: &'a Path,
    /// Who makes the depth.
    pub maker: &'a Maker,
    /// How.
    pub making: &'a Making,
}

impl FileExport<'_> {
    /// Does all that; a target that is there already may be left as it is, and then nothing is opened.
    ///
    /// # Errors
    /// [`SceneError`]; then nothing has been written.
    pub fn run(&self, job: &Job) -> Result<Written, SceneError> {
        let Some(target) = self.settings.existing.resolve(self.target) else {
            return Ok(Written::Skipped(self.target.to_owned()));
        };
        let subject = Subject::open(self.path, job)?;
        let subject = Arc::new(match self.own_map {
            Some(map) => subject.with_own_map(map.clone()),
            None => subject,
        });
        let need = self.settings.kind.need(self.settings.size());
        let making = self.making.with_recipe(self.recipe);
        let scene = self.maker.scene(&subject, &making, need, job)?;
        let edit = self.recipe.edit(scene.map().size()[0]);
        let settings =
            Settings { recipe: self.recipe.clone().of_depth(making.source.clone()), ..self.settings.clone() };
        match write(&scene, &edit, &settings, &target, job) {
            Err(SceneError::Save(SaveError::Exists(target))) => Ok(Written::Skipped(target)),
            done => done.map(|()| Written::Saved(target)),
        }
    }
}

/// Writes what was asked for.
///
/// # Errors
/// [`SceneError`]; then nothing has been written.
pub fn write(scene: &Scene, edit: &Edit, settings: &Settings, target: &Path, job: &Job) -> Result<(), SceneError> {
    match settings.kind {
        Kind::Picture => write_picture(scene, edit, settings, target, job).map(drop),
        Kind::FocalStack => series::focal_stack(scene, edit, settings.size(), settings.frames, target, job),
        Kind::Animation | Kind::Video | Kind::Frames => {
            let (frames, frames_per_second) = settings.frames_and_rate();
            let options = AnimationOptions { frames_per_second, frames: frames.max(2).into() };
            let moving = series::Moving { movement: settings.movement, timeline: settings.timeline.as_ref() };
            let size = settings.size();
            match settings.kind {
                Kind::Frames => series::sequence(scene, edit, moving, size, (target, options.frames), job),
                _ => series::animation(scene, edit, moving, size, target, &options, job),
            }
        }
        Kind::Living => living::write(scene, edit, settings, target, job),
        kind if kind.is_of_eyes() => of_eyes(scene, edit, settings, target, job),
        Kind::DepthPng | Kind::DepthPfm | Kind::Gdepth => depth(scene, settings.kind, target, job),
        _ => of_views(scene, settings, target, job),
    }
}

/// Writes the refocused picture, in the photo's own colours and with its metadata, and says what stands in the file.
///
/// # Errors
/// [`SceneError`]; then nothing has been written.
pub fn write_picture(
    scene: &Scene,
    edit: &Edit,
    settings: &Settings,
    target: &Path,
    job: &Job,
) -> Result<Pixels, SceneError> {
    let mut options = picture_options(scene, settings);
    let format = save::check(target, &options)?;
    let pixels = scene.picture(edit, settings.size(), settings.picture.bits_in(format), job)?;
    job.advance(Stage::Save, 0, 1)?;
    options.carry = embed::carry(scene, edit, settings, job)?;
    save::pixels(target, &pixels, &options)?;
    Ok(pixels)
}

/// How a picture is written; the target's ending says the format.
fn picture_options(scene: &Scene, settings: &Settings) -> PictureOptions {
    let PictureSettings { bits, quality, keep, .. } = settings.picture;
    let origin = scene.origin(settings.size());
    let (replace, replace_source) = (settings.existing != Existing::Leave, settings.replaces_source);
    PictureOptions { bits, quality, keep, origin, replace_source, replace, ..PictureOptions::default() }
}

/// One map as a file.
fn depth(scene: &Scene, kind: Kind, target: &Path, job: &Job) -> Result<(), SceneError> {
    job.advance(Stage::Save, 0, 1)?;
    let map: &DisparityMap = scene.map();
    match (kind, scene.subject().photo(), scene.views()) {
        (Kind::DepthPng, ..) => depth_out::write_png16(target, map)?,
        (Kind::Gdepth, Some(photo), _) => depth_out::write_gdepth(target, Seen::Photo(photo), map, GDEPTH_QUALITY)?,
        (Kind::Gdepth, None, Some(views)) => {
            depth_out::write_gdepth(target, Seen::View(views.field.reference()), map, GDEPTH_QUALITY)?;
        }
        _ => depth_out::write_pfm(target, map)?,
    }
    Ok(())
}

/// The picture as both eyes see it, through the lens.
fn of_eyes(scene: &Scene, edit: &Edit, settings: &Settings, target: &Path, job: &Job) -> Result<(), SceneError> {
    let [left, right] = edit.for_eyes(settings.eyes_apart).map(|edit| scene.shown(&edit, settings.size(), job));
    let [left, right] = [&left?, &right?];
    job.advance(Stage::Save, 0, 1)?;
    match settings.kind {
        Kind::Anaglyph => stereo::write_anaglyph(target, left, right)?,
        Kind::Mpo => mpo::write(target, left, right)?,
        Kind::SideBySide => stereo::write_side_by_side(target, left, right)?,
        _ => {
            let (focal, step_m) = scene.camera(edit);
            let eyes = stereo_heic::Eyes { focal, apart_m: settings.eyes_apart * step_m };
            stereo_heic::write(target, [left, right], eyes, job)?;
        }
    }
    Ok(())
}

/// What is made of all views: light fields, quilts, point clouds.
fn of_views(scene: &Scene, settings: &Settings, target: &Path, job: &Job) -> Result<(), SceneError> {
    let MadeViews { field, depths, provenance } = scene.views().ok_or(SceneError::NoViews)?;
    // A dark light field is shown brighter, and written as it is.
    let stored = &scene.stored(job)?;
    let models: Vec<_> = scene.models().iter().map(|model| (model.id.clone(), model.sha256.clone())).collect();
    let photo = scene.subject().photo().map(AsRef::as_ref);
    let provenance = provenance.as_deref();
    let source = FieldToWrite { field: stored, depths: Some(depths), provenance, photo, models: &models };
    let view = |at| cpu::view_with_depths(field, Some(depths), at);
    job.advance(Stage::Save, 0, 1)?;
    let writer = formats::by_id(settings.kind.spec().id).and_then(|entry| entry.writer);
    if let Some(Writer::Field(write)) = writer {
        return Ok(write(target, &source, job)?);
    }
    if settings.kind == Kind::Ply {
        return Ok(ply::write(target, &source)?);
    }
    let reach = field.grid().cols() as f32 / 2.0;
    Ok(quilt::write(target, settings.device(), [-reach, reach - 1.0], &view, job)?)
}
