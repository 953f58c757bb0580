//! The thread that writes: one export after the other. Files are written aside, then renamed.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::super::document::Document;
use super::super::finals::scene_of;
use super::super::jobs::{Load, read};
use super::super::maker::Maker;
use super::super::state::Edit;
use super::super::subject;
use super::super::worker::{Event, JobId, Outbox, Work};
use super::{Existing, ExportSettings, What, series};
use crate::errors::sentence;
use crate::field::{LightField, Photo, RayDepths};
use crate::io::formats::depth_out::Seen;
use crate::io::formats::{FieldToWrite, depth_out, eslf, hci, ply, quilt, stanford, stereo, views};
use crate::io::save::{self, Keep, Origin, PictureOptions, SaveError};
use crate::job::{Cancel, Job, Progress, Sink, Stage};
use crate::render::lens::{self, Scene, Space};
use crate::render::{Picture, cpu};

/// Quality of the JPEG that carries the depth.
const GDEPTH_QUALITY: u8 = 95;

/// What is open, as it is seen now.
#[derive(Clone, Debug)]
pub struct Request {
    /// What and how.
    pub settings: ExportSettings,
    /// Where; none puts the picture into the clipboard.
    pub target: Option<PathBuf>,
    /// The lens and the viewpoint.
    pub edit: Edit,
    /// The views.
    pub field: Arc<LightField>,
    /// The views as they lie in their files, where they are shown brighter.
    pub stored: Option<Arc<LightField>>,
    /// Their ray depths.
    pub depths: Option<Arc<RayDepths>>,
    /// The photo they were made from.
    pub photo: Option<Arc<Photo>>,
}

/// A photo that is not open: it is opened, becomes a light field, and is written.
#[derive(Debug)]
pub struct FileRequest {
    /// The photo.
    pub path: PathBuf,
    /// What and how.
    pub settings: ExportSettings,
    /// The lens; the focus goes to the place that was clicked, else to this photo's own subject.
    pub edit: Edit,
    /// How light fields are made.
    pub load: Load,
}

/// A request to the thread that writes.
#[derive(Debug)]
pub enum Order {
    /// What is open.
    Shown(Box<Request>),
    /// Another photo.
    File(Box<FileRequest>),
}

/// The work of the thread that writes.
pub fn worker(threads: usize) -> impl Work<Order> {
    let mut maker = Maker::new(threads);
    move |job: JobId, order: Order, cancel: &Cancel, outbox: &Outbox| {
        let told = Told(job, outbox);
        let task = Job { cancel, sink: &told };
        let done = match order {
            Order::Shown(request) => export(&request, &task),
            Order::File(request) => file(&request, &mut maker, &task),
        };
        let event = match done {
            Err(_) if cancel.is_cancelled() => Event::Stopped,
            Ok(event) => event,
            Err(text) => Event::Failed(text),
        };
        outbox.send(job, event);
    }
}

/// Only how far it is goes to the window: depths and views of a queued photo are not those that are shown.
struct Told<'a>(JobId, &'a Outbox);

impl Sink for Told<'_> {
    fn progress(&self, progress: Progress) {
        self.1.send(self.0, Event::Progress(progress));
    }
    fn warning(&self, text: String) {
        log::info!("{text}");
    }
}

fn file(request: &FileRequest, maker: &mut Maker, job: &Job) -> Result<Event, String> {
    job.advance(Stage::Open, 0, 1).map_err(|stopped| stopped.to_string())?;
    let FileRequest { path, settings, load, .. } = request;
    let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
    let document = read(path, job)?;
    let made = maker.make(&document, load, job)?;
    let document = Document { field: Some(Arc::clone(&made.field)), depths: made.depths.clone(), ..document };
    let edit = focused(request.edit, &document);
    let shown = Request {
        settings: settings.clone(),
        target: Some(settings.target_of(Some(path), &name, &edit)),
        edit,
        field: made.field,
        stored: document.stored,
        depths: made.depths,
        photo: document.photo,
    };
    export(&shown, job)
}

/// The edit of one photo for another: disparities of two scenes cannot be compared, places can.
fn focused(mut edit: Edit, document: &Document) -> Edit {
    let (Some(depths), Some(grid)) = (&document.depths, document.grid()) else { return edit };
    let place = edit.focus_at.unwrap_or_else(|| subject::place(depths));
    if let Some(disparity) = document.disparity_at(grid.reference(), place) {
        let focus = &mut edit.lens.focus;
        focus.disparity_px += disparity - focus.at(place[0], place[1]);
    }
    edit
}

fn export(request: &Request, job: &Job) -> Result<Event, String> {
    job.advance(Stage::Save, 0, 1).map_err(|stopped| stopped.to_string())?;
    let target = match (&request.target, request.settings.existing) {
        (Some(target), Existing::Number) => save::free_path(target),
        (Some(target), Existing::Leave) if target.exists() => return Ok(Event::Skipped(target.clone())),
        (Some(target), _) => target.clone(),
        (None, _) => return Ok(Event::Copied(Arc::new(picture(request, job)?))),
    };
    write(&target, request, job).map_err(|error| sentence(error.as_ref()))?;
    Ok(Event::Saved(target))
}

/// Any error that has its own sentence.
pub(super) type AnyError = Box<dyn std::error::Error>;

fn write(target: &Path, request: &Request, job: &Job) -> Result<(), AnyError> {
    let Request { field, stored, depths, photo, settings, .. } = request;
    let depths = depths.as_deref();
    let source =
        FieldToWrite { depths, photo: photo.as_deref(), ..FieldToWrite::new(stored.as_ref().unwrap_or(field)) };
    let map = || depths.map(RayDepths::reference_map).ok_or_else(|| no_depths(target));
    match settings.what {
        What::Picture => return write_picture(target, request, job),
        What::FocalStack => return series::focal_stack(target, request, job),
        What::Animation => return series::animation(target, request, job),
        What::SideBySide | What::Anaglyph => {
            let [left, right] = stereo::eyes(settings.eyes_apart).map(|eye| cpu::view_with_depths(field, depths, eye));
            match settings.what {
                What::Anaglyph => stereo::write_anaglyph(target, &left, &right)?,
                _ => stereo::write_side_by_side(target, &left, &right)?,
            }
        }
        What::Views => views::write(target, &source, job)?,
        What::Eslf => eslf::write(target, &source, job)?,
        What::Hci => hci::write(target, &source, job)?,
        What::Stanford => stanford::write(target, &source, job)?,
        What::Quilt => {
            let reach = field.grid().cols() as f32 / 2.0;
            let view = |at| cpu::view_with_depths(field, depths, at);
            quilt::write(target, settings.device(), [-reach, reach - 1.0], &view, job)?;
        }
        What::DepthPng => depth_out::write_png16(target, &map()?)?,
        What::DepthPfm => depth_out::write_pfm(target, &map()?)?,
        What::Gdepth => {
            let seen = photo.as_deref().map_or(Seen::View(field.reference()), Seen::Photo);
            depth_out::write_gdepth(target, seen, &map()?, GDEPTH_QUALITY)?;
        }
        What::Ply => ply::write(target, &source)?,
    }
    Ok(())
}

fn no_depths(target: &Path) -> SaveError {
    let why = "there are no ray depths yet; wait until they have been measured".to_owned();
    SaveError::Encode { why, path: target.to_owned() }
}

/// By the lens renderer at photo size and in the photo's own colours; light fields from disk by their views.
fn write_picture(target: &Path, request: &Request, job: &Job) -> Result<(), AnyError> {
    let settings = &request.settings.picture;
    let origin = request.photo.as_ref().map(|photo| Origin::in_own_space(photo)).unwrap_or_default();
    let options = PictureOptions {
        format: Some(settings.format),
        bits: settings.bits,
        quality: settings.quality,
        keep: settings.keep,
        origin,
        replace_source: false,
    };
    save::check(target, &options)?;
    let Some((scene, size)) = scene(request, job)? else {
        let options = PictureOptions { keep: Keep::Nothing, ..options };
        return Ok(save::picture(target, &of_views(request), &options)?);
    };
    let bits = if settings.format.has_16_bits() { settings.bits } else { 8 };
    let pixels = lens::render_pixels(&scene, &request.edit.lens, size, bits, job)?;
    job.advance(Stage::Save, 0, 1)?;
    Ok(save::pixels(target, &pixels, &options)?)
}

/// The picture in sRGB, for the clipboard.
fn picture(request: &Request, job: &Job) -> Result<Picture, String> {
    let scene = scene(request, job).map_err(|error| sentence(error.as_ref()))?;
    let Some((scene, size)) = scene else { return Ok(of_views(request)) };
    let scene = scene.in_space(Space::Srgb);
    lens::render(&scene, &request.edit.lens, size, job).map_err(|error| sentence(&error))
}

/// The lens renderer's scene from where the eye is, and the picture's size; none for light fields from disk: their views
/// know the picture.
fn scene(request: &Request, job: &Job) -> Result<Option<(Scene, [u32; 2])>, AnyError> {
    let (Some(photo), Some(depths)) = (&request.photo, &request.depths) else { return Ok(None) };
    let size = request.settings.picture.size.of(photo.size());
    let scene = scene_of(photo, depths)?;
    Ok(Some((scene.seen_from(request.edit.viewpoint, size, job)?, size)))
}

/// The picture at light-field size, by the CPU twins.
fn of_views(request: &Request) -> Picture {
    let Edit { lens, viewpoint, .. } = request.edit;
    let depths = request.depths.as_deref();
    if lens.f_number.added_views() == 0.0 {
        return cpu::view_with_depths(&request.field, depths, viewpoint);
    }
    cpu::refocus_with_depths(&request.field, depths, &lens, viewpoint)
}
