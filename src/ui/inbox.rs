//! What the threads have sent: taken in between two frames, never waited for.

use std::sync::Arc;

use super::app::{App, Dialog};
use super::dialogs::{PathFor, Picked};
use super::document::{Document, Made, Survey};
use super::edits::History;
use super::jobs::From;
use super::near_end;
use super::neighbours;
use super::queue::State;
use super::rest::AtRest;
use super::state::{Edit, Face, Pose};
use super::tiles::Tiled;
use super::worker::{Event, JobId};
use crate::field::{RayDepths, ViewPoint};

impl App {
    /// Takes in what the threads have sent. Never waits.
    pub(super) fn drain(&mut self, ctx: &egui::Context) {
        while let Ok((job, event)) = self.events.try_recv() {
            if self.loading.as_ref().is_some_and(|running| running.job == job) {
                self.loaded(event, ctx);
            } else if self.queue.has(job) {
                self.exported(job, event, ctx);
            } else {
                self.told(event, ctx);
            }
        }
    }

    /// From threads other than those that open and save, and from the loader once it is done.
    fn told(&mut self, event: Event, ctx: &egui::Context) {
        match event {
            Event::Picked(picked) => self.picked(picked, ctx),
            Event::Final(rendered) => self.rest.put(rendered.0, rendered.1),
            Event::Peaks(peaks) => self.rest.put_peaks(*peaks, ctx),
            Event::Thumbnail(path, image) => {
                let texture = ctx.load_texture("thumbnail", image, egui::TextureOptions::LINEAR);
                self.thumbnails.push((path, texture));
            }
            Event::Models(models) => self.models = models,
            Event::Warning(text) => self.toasts.info(&text),
            Event::Failed(text) => self.toasts.error(&text),
            _ => {}
        }
    }

    fn exported(&mut self, job: JobId, event: Event, ctx: &egui::Context) {
        match event {
            Event::Progress(progress) => self.queue.tell(job, progress),
            Event::Saved(path) => {
                self.queue.end(job, State::Done(path.clone()));
                // One at a time is told; of many the queue tells.
                if !self.is_queue_open {
                    self.toasts.saved(path);
                }
            }
            Event::Skipped(path) => {
                self.queue.end(job, State::Skipped);
                let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
                self.toasts.info(&format!("{name} is there already and was left as it is"));
            }
            Event::Copied(picture) => {
                let size = picture.size.map(|side| side as usize);
                ctx.copy_image(egui::ColorImage::from_rgba_unmultiplied(size, &picture.to_srgb8()));
                self.queue.forget(job);
                self.toasts.info(&format!("Copied the picture, {} × {} px", size[0], size[1]));
            }
            Event::Failed(text) => {
                self.toasts.error(&text);
                self.queue.end(job, State::Failed(text));
            }
            Event::Stopped => self.queue.end(job, State::Stopped),
            other => self.told(other, ctx),
        }
    }

    fn loaded(&mut self, event: Event, ctx: &egui::Context) {
        match event {
            Event::Progress(progress) => {
                if let Some(running) = &mut self.loading {
                    running.tell(progress);
                }
            }
            Event::Failed(text) => {
                self.toasts.error(&text);
                self.loading = None;
            }
            Event::Stopped => self.loading = None,
            Event::Opened(document, preview) => {
                self.opened(*document, ctx);
                self.photo = preview.map(Tiled::new);
            }
            Event::Tiles(tiles) => self.photo = Some(Tiled::new(tiles)),
            // Made again with other settings: the old light field stays usable until the new one is complete.
            Event::Depths(..) | Event::View(..) if self.is_again => {}
            Event::Depths(depths, survey) => self.take_depths(depths, survey),
            Event::View(at, view) => {
                // Ray depths tell the grid; the reference view, which comes before them, is the photo.
                let grid = self.document.depths.as_ref().map(|depths| depths.grid());
                if let (Some(stage), Some(grid)) = (&mut self.stage, grid) {
                    stage.push_view(grid, at, &view);
                }
            }
            Event::Made(made) => self.made(*made),
            other => self.told(other, ctx),
        }
    }

    fn made(&mut self, made: Made) {
        // Its job's last words (models) come after it.
        self.loading = None;
        self.generation += 1;
        let is_streamed = !self.is_again && self.document.photo.is_some();
        if let Some(stage) = &mut self.stage
            && !is_streamed
        {
            stage.push_field(&made.field);
        }
        let width = |field: &Arc<crate::field::LightField>| field.size()[0] as f32;
        if let Some(old) = self.document.field.as_ref().filter(|_| self.is_again) {
            self.edit = self.edit.scaled(width(&made.field) / width(old));
        }
        if let Some(grid) = self.is_again.then(|| made.field.grid()) {
            self.edit.viewpoint = ViewPoint(grid.clamp(self.edit.viewpoint.0));
        }
        self.document.layout = made.of.layout;
        self.document.stored = made.of.stored;
        self.document.field = Some(made.field);
        let is_other_source = self.document.made_by != made.made_by;
        self.document.made_by = made.made_by;
        self.document.took_secs = made.took_secs;
        if let (Some(depths), Some(survey)) = (made.depths, made.survey) {
            let is_new = self.document.depths.as_ref().is_none_or(|old| !Arc::ptr_eq(old, &depths));
            if is_new {
                self.take_depths(depths, survey);
            }
        }
        // Laid out anew, or measured otherwise: what was sharp lies at another disparity.
        if self.is_again && self.edit.focus_at.is_none() && (is_other_source || self.document.is_from_disk()) {
            self.focus_on_subject();
        }
        if let Some(path) = self.document.path.clone().filter(|_| self.document.photo.is_some()) {
            self.workers.ahead.replace(neighbours::Request::Prefetch(path));
        }
    }

    fn opened(&mut self, document: Document, ctx: &egui::Context) {
        if let Some(stage) = &mut self.stage {
            stage.clear();
            if let Some(field) = &document.field {
                stage.push_field(field);
            }
        }
        self.photo = None;
        self.rest = AtRest::default();
        self.pose = Pose::default();
        self.face = Face::Picture;
        self.is_circling = false;
        self.edit = match &document.recipe {
            Some(recipe) => Edit::of_recipe(recipe),
            None => {
                let mut edit = Edit { lens: self.edit.lens, ..Edit::default() };
                edit.lens.focus = Default::default();
                edit.lens.keep_sharp_px = [0.0, 0.0];
                edit
            }
        };
        self.history = History::default();
        self.probe = egui::Vec2::splat(0.5);
        self.toasts.clear();
        document.warnings.iter().for_each(|warning| self.toasts.info(warning));
        if let Some(path) = &document.path {
            self.settings.remember(path);
        }
        ctx.send_viewport_cmd(egui::ViewportCommand::Title(format!("{} — Plenoscope", document.name)));
        let known = document.depths.clone().zip(document.survey.clone());
        self.document = document;
        if let Some((depths, survey)) = known {
            self.take_depths(depths, survey);
        }
    }

    fn take_depths(&mut self, depths: Arc<RayDepths>, survey: Arc<Survey>) {
        self.document.survey = Some(survey);
        if let Some(stage) = &mut self.stage {
            stage.push_depths(&depths);
        }
        self.document.depths = Some(depths);
        match self.edit.focus_at {
            Some(place) => self.focus_on(place),
            None if self.is_new_file && self.document.recipe.is_none() => self.focus_on_subject(),
            None => {}
        }
        if self.is_new_file {
            self.is_new_file = false;
            self.history.begin(self.edit);
        }
    }

    fn picked(&mut self, picked: Picked, ctx: &egui::Context) {
        match picked {
            Picked::Open(path) => self.open(From::File(path)),
            Picked::Folder(path) => self.settings.export.folder = Some(path),
            Picked::Photos(photos) => self.export_photos(photos),
            Picked::DepthMap { path, size, readings } => {
                self.ask_near_end(near_end::Question::new(&path, size, readings, ctx));
            }
            Picked::Models(folder) => self.use_models(folder),
            Picked::Pixels(size, rgba) => self.open(From::Pixels(size, rgba)),
            Picked::Edit(recipe) => self.paste_edit(&recipe),
            Picked::Unavailable(wanted) => self.dialog = Some(Dialog::Path(wanted, String::new())),
            Picked::NoFolderDialog => {
                self.toasts.info("The system shows no folder dialog here: type the folder into the field");
            }
            Picked::Nothing => {}
        }
    }

    /// What a typed path is for.
    pub(super) fn use_path(&mut self, wanted: PathFor, path: std::path::PathBuf) {
        match wanted {
            PathFor::Open => self.open(From::File(path)),
            PathFor::Export => self.export_photos(vec![path]),
            PathFor::DepthMap => self.ask(super::dialogs::Ask::ReadDepthMap(path)),
            PathFor::Models => self.use_models(path),
        }
    }

    /// Opens the export dialog for photos that are not open.
    pub(super) fn export_photos(&mut self, photos: Vec<std::path::PathBuf>) {
        self.photos_to_export = photos;
        self.dialog = Some(Dialog::Export);
    }

    fn use_models(&mut self, folder: std::path::PathBuf) {
        self.settings.models_folder = Some(folder);
        self.make_again();
    }

    fn ask_near_end(&mut self, question: near_end::Question) {
        let fits = self.document.size().is_some_and(|size| question.fits(size));
        if fits {
            self.near_end = Some(question);
            self.dialog = Some(Dialog::NearEnd);
        } else {
            self.toasts
                .error("this depth map is not this photo's — it has another shape — use one of the photo's shape");
        }
    }
}
