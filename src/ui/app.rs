//! The window: what it holds, and a frame of it. What comes in lies in `inbox`, what a person does in `input` and
//! `commands`, edits and their history in `edits`, the picture at rest in `rest`.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, sync_channel};
use std::time::Duration;

use eframe::egui_wgpu::RenderState;

use super::dialogs::{Ask, PathFor};
use super::document::Document;
use super::edits::History;
use super::export::work::Order;
use super::jobs::{From, Load};
use super::neighbours::{self, Ahead};
use super::progress::{Running, now};
use super::queue::Queue;
use super::rest::AtRest;
use super::stage::Stage;
use super::state::{Edit, Face, Pose, Settings, Source};
use super::tiles::Tiled;
use super::toasts::Toasts;
use super::worker::{Event, JobId, Outbox, Worker};
use super::{Options, dialogs, edits, export, finals, jobs, near_end, panels, peaking, recents, screen, theme};
use crate::field::{ViewIndex, ViewPoint};
use crate::synth::ModelSource;

/// A dialog of the window's own.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Dialog {
    Export,
    Shortcuts,
    /// A box for a path, where the system shows no dialogs.
    Path(PathFor, String),
    Settings,
    /// Which end of a depth map is near.
    NearEnd,
    /// Several files were dropped: open the first, or export them all.
    Many(Vec<PathBuf>),
}

/// The threads behind the window.
pub(super) struct Workers {
    pub loader: Worker<Load>,
    pub saver: Worker<Order>,
    pub finisher: Worker<finals::Request>,
    pub peaker: Worker<peaking::Request>,
    pub asker: Worker<Ask>,
    pub folder: Worker<neighbours::Request>,
    pub ahead: Worker<neighbours::Request>,
    pub sidecar: Worker<edits::Keep>,
    pub recents: Worker<Vec<PathBuf>>,
}

impl Workers {
    /// `remembers`: whether what was opened is kept for the next time.
    fn spawn(outbox: &Outbox, threads: usize, stage: Option<&Stage>, remembers: bool) -> Self {
        let out = || outbox.clone();
        let ahead = Ahead::default();
        Self {
            loader: Worker::spawn("synth", out(), jobs::loader(threads, ahead.clone(), remembers)),
            saver: Worker::spawn("export", out(), export::work::worker(threads)),
            finisher: Worker::spawn("final", out(), finals::worker(stage.and_then(Stage::lens_renderer))),
            peaker: Worker::spawn("peaking", out(), peaking::work),
            asker: Worker::spawn("dialog", out(), dialogs::work),
            folder: Worker::spawn("folder", out(), neighbours::worker(ahead.clone())),
            ahead: Worker::spawn("ahead", out(), neighbours::worker(ahead)),
            sidecar: Worker::spawn("sidecar", out(), edits::keep),
            recents: Worker::spawn("recents", out(), recents::work),
        }
    }
}

/// The window.
pub struct App {
    pub(super) settings: Settings,
    pub(super) edit: Edit,
    pub(super) history: History,
    pub(super) document: Document,
    pub(super) face: Face,
    pub(super) pose: Pose,
    pub(super) stage: Option<Stage>,
    pub(super) photo: Option<Tiled>,
    pub(super) rest: AtRest,
    pub(super) loading: Option<Running>,
    pub(super) queue: Queue,
    pub(super) is_queue_open: bool,
    /// Photos that the export dialog is about, where it is not what is open.
    pub(super) photos_to_export: Vec<PathBuf>,
    pub(super) toasts: Toasts,
    pub(super) dialog: Option<Dialog>,
    pub(super) near_end: Option<near_end::Question>,
    pub(super) thumbnails: Vec<(PathBuf, egui::TextureHandle)>,
    /// Further models that ray depths can come from.
    pub(super) models: Vec<String>,
    pub(super) generation: u64,
    pub(super) is_before_after: bool,
    pub(super) split: f32,
    /// Whether the hand holds the line between photo and picture.
    pub(super) is_splitting: bool,
    pub(super) is_circling: bool,
    pub(super) is_drawer_open: bool,
    pub(super) canvas: egui::Rect,
    /// Place in the picture (0 to 1) that cross-hairs and epipolar images go through.
    pub(super) probe: egui::Vec2,
    pub(super) hovered_px: Option<f32>,
    /// When the picture last moved, so that the picture at rest waits for the hand.
    pub(super) moved_at_secs: f64,
    pub(super) is_moving: bool,
    /// Whether the window was brought to its screen's size.
    is_fitted: bool,
    pub(super) is_new_file: bool,
    pub(super) is_again: bool,
    pub(super) threads: usize,
    pub(super) events: Receiver<(JobId, Event)>,
    pub(super) workers: Workers,
    started_with: ModelSource,
}

/// Letters between threads and window.
const LETTERS: usize = 256;

impl App {
    /// A window on egui's device; `storage` holds what the last one remembered.
    pub fn new(
        options: Options,
        ctx: &egui::Context,
        render: Option<&RenderState>,
        storage: Option<&dyn eframe::Storage>,
    ) -> Self {
        theme::install(ctx);
        let mut settings: Settings =
            storage.and_then(|storage| eframe::get_value(storage, eframe::APP_KEY)).unwrap_or_default();
        settings.long_side = options.long_side.unwrap_or(settings.long_side);
        settings.source = settings.source.lasting();
        ctx.set_theme(settings.theme);
        let (sender, events) = sync_channel(LETTERS);
        let outbox = Outbox::new(sender, ctx.clone());
        let threads = options.threads;
        let stage = render.map(Stage::new);
        let mut app = Self {
            edit: settings.edit,
            settings,
            history: History::default(),
            document: Document::default(),
            face: Face::default(),
            pose: Pose::default(),
            photo: None,
            rest: AtRest::default(),
            loading: None,
            queue: Queue::default(),
            is_queue_open: false,
            photos_to_export: Vec::new(),
            toasts: Toasts::default(),
            dialog: None,
            near_end: None,
            thumbnails: Vec::new(),
            models: Vec::new(),
            generation: 0,
            is_before_after: false,
            split: 0.5,
            is_splitting: false,
            is_circling: false,
            is_drawer_open: false,
            canvas: egui::Rect::ZERO,
            probe: egui::Vec2::splat(0.5),
            hovered_px: None,
            moved_at_secs: 0.0,
            is_moving: false,
            is_fitted: false,
            is_new_file: false,
            is_again: false,
            threads,
            events,
            workers: Workers::spawn(&outbox, threads, stage.as_ref(), storage.is_some()),
            stage,
            started_with: options.models,
        };
        let last = if options.restores_last { app.settings.last_file.clone() } else { None };
        match options.files.into_iter().next().or(last.filter(|path| path.exists())) {
            Some(file) => app.open(From::File(file)),
            None if storage.is_some() => {
                app.workers.recents.push(app.settings.recent.clone());
            }
            None => {}
        }
        app
    }

    /// The lens and the viewpoint.
    pub fn edit(&self) -> &Edit {
        &self.edit
    }

    /// The light field, once it is complete.
    pub fn light_field(&self) -> Option<&Arc<crate::field::LightField>> {
        self.document.field.as_ref()
    }

    /// Whether something is being opened, made or saved.
    pub fn is_busy(&self) -> bool {
        self.loading.is_some() || self.queue.is_busy()
    }

    /// Whether nothing is on its way: no job, no upload, no picture at rest.
    pub fn is_at_rest(&self) -> bool {
        !self.is_busy() && self.rest.is_there() && !self.stage.as_ref().is_some_and(Stage::is_uploading)
    }

    /// The disparity at a place of the photo, x and y from 0 to 1, in pixels per view step.
    pub fn focus_depth_px(&self, place: [f32; 2]) -> Option<f32> {
        self.document.disparity_at(self.document.grid()?.reference(), place)
    }

    /// Opens a file, as if it had been dropped.
    pub fn open_file(&mut self, path: &Path) {
        self.open(From::File(path.to_owned()));
    }

    /// Where exports go.
    pub fn set_export_folder(&mut self, folder: &Path) {
        self.settings.export.folder = Some(folder.to_owned());
    }

    /// Opens a file; what is open stays usable until the new one is there.
    pub(super) fn open(&mut self, from: From) {
        self.keep_now();
        self.is_again = matches!(from, From::Again(_));
        self.is_new_file = !self.is_again;
        self.loading = Some(Running::new(self.workers.loader.replace(self.load(from))));
    }

    /// How a light field is made of something.
    pub(super) fn load(&self, from: From) -> Load {
        let models = match (&self.started_with, &self.settings.models_folder) {
            (ModelSource::Embedded, Some(folder)) => ModelSource::Folder(folder.clone()),
            (started_with, _) => started_with.clone(),
        };
        Load {
            from,
            long_side: self.settings.long_side,
            occlusion: self.settings.occlusion,
            source: self.settings.source.clone(),
            models,
        }
    }

    /// Makes the light field anew, after a setting changed.
    pub(super) fn make_again(&mut self) {
        if self.document.photo.is_some() {
            let document = Document { field: None, depths: None, survey: None, ..self.document.clone() };
            self.open(From::Again(Box::new(document)));
        }
    }

    /// Takes ray depths from elsewhere.
    pub(super) fn set_source(&mut self, source: Source) {
        if self.settings.source != source {
            self.settings.source = source;
            self.make_again();
        }
    }

    /// Asks the system for a file or a folder, or the clipboard for what is in it.
    pub(super) fn ask(&mut self, ask: Ask) {
        self.workers.asker.push(ask);
    }

    /// Size of the picture that is looked at.
    pub(super) fn picture_size(&self) -> Option<egui::Vec2> {
        self.document.size().map(|[w, h]| egui::vec2(w as f32, h as f32))
    }

    /// The view that is nearest to the eye.
    pub(super) fn nearest_view(&self) -> Option<ViewIndex> {
        self.document.grid().map(|grid| grid.nearest(self.edit.viewpoint.0))
    }

    /// Whether the photo itself is what the lens shows.
    pub(super) fn shows_photo_itself(&self) -> bool {
        self.edit.lens.f_number.added_views() == 0.0 && self.edit.viewpoint == ViewPoint::default()
    }

    /// Toasts lie over the picture's lower left corner, above its read-out: they cover no control.
    fn toast_place(&self, ctx: &egui::Context) -> egui::Pos2 {
        match self.picture_size() {
            Some(_) => self.canvas.left_bottom() + egui::vec2(8.0, -36.0),
            None => ctx.content_rect().left_bottom() + egui::vec2(44.0, -70.0),
        }
    }

    fn show_dialog(&mut self, ctx: &egui::Context) {
        let is_open = match self.dialog.clone() {
            None => return,
            Some(Dialog::Export) => export::dialog::show(self, ctx),
            Some(Dialog::Shortcuts) => panels::sheet::show(ctx),
            Some(Dialog::Settings) => panels::settings::show(self, ctx),
            Some(Dialog::Path(wanted, text)) => panels::path_box::show(self, ctx, wanted, text),
            Some(Dialog::NearEnd) => near_end::show(self, ctx),
            Some(Dialog::Many(files)) => panels::many::show(self, ctx, &files),
        };
        if !is_open {
            self.dialog = None;
        }
    }
}

impl eframe::App for App {
    fn logic(&mut self, ctx: &egui::Context, frame: &mut eframe::Frame) {
        if let Some(secs) = frame.info().cpu_usage {
            log::trace!(
                "frame: {:.1} ms, {:.1} ms after the one before",
                secs * 1e3,
                ctx.input(|i| i.unstable_dt) * 1e3
            );
        }
        self.is_fitted = self.is_fitted || screen::fit(ctx);
        self.drain(ctx);
        if let Some(stage) = &mut self.stage {
            stage.is_streaming = self.loading.is_some();
        }
        let frame = Duration::from_secs_f32(ctx.input(|input| input.unstable_dt).clamp(0.0, 0.25));
        if self.stage.as_mut().is_some_and(|stage| stage.upload_some(frame)) {
            ctx.request_repaint();
        }
    }

    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        let ctx = ui.ctx().clone();
        self.read_input(&ctx);
        let before = (self.edit, self.pose);
        self.is_moving = ctx.input(|input| input.pointer.any_down());
        self.circle(&ctx);
        panels::layout(self, ui);
        self.show_dialog(&ctx);
        panels::queue::show(self, &ctx);
        let place = self.toast_place(&ctx);
        self.toasts.show(&ctx, place);
        if before != (self.edit, self.pose) {
            self.moved_at_secs = now();
        }
        // A focus that was set by number is at no place of the picture any more.
        let is_focused = before.0.lens.focus.disparity_px != self.edit.lens.focus.disparity_px;
        if is_focused && before.0.focus_at == self.edit.focus_at {
            self.edit.focus_at = None;
        }
        self.rest(&ctx);
        self.mark_peaks();
        if !self.is_circling {
            self.keep_history(&ctx);
        }
    }

    fn save(&mut self, storage: &mut dyn eframe::Storage) {
        self.settings.edit = self.edit;
        eframe::set_value(storage, eframe::APP_KEY, &self.settings);
    }

    fn on_exit(&mut self) {
        self.keep_at_exit();
    }

    /// The surround: nothing else is painted where it shows.
    fn clear_color(&self, visuals: &egui::Visuals) -> [f32; 4] {
        theme::of(visuals).surround.to_normalized_gamma_f32()
    }
}
