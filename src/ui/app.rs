//! The window: events in, actions out, and a frame in between.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, sync_channel};

use eframe::egui_wgpu::RenderState;
use egui::util::undoer::Undoer;

use super::action::Action;
use super::dialogs::{Ask, Picked};
use super::document::{Document, Survey};
use super::jobs::{From, Load};
use super::stage::Stage;
use super::state::{Edit, Face, Pose, Settings};
use super::tiles::Tiled;
use super::toasts::Toasts;
use super::worker::{Event, JobId, Outbox, Worker};
use super::{Options, dialogs, export, finals, jobs, theme};
use crate::field::{ViewIndex, ViewOffset, ViewPoint};
use crate::job::Progress;

/// A job that runs, as the status line shows it.
#[derive(Clone, Debug)]
pub(super) struct Running {
    pub job: JobId,
    pub progress: Option<Progress>,
    pub since_secs: f64,
}

/// A dialog of the window's own.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Dialog {
    Export,
    Shortcuts,
    /// A box for a path, where the system shows no dialogs.
    Path(String),
    Settings,
}

/// The window.
pub struct App {
    pub(super) settings: Settings,
    pub(super) edit: Edit,
    pub(super) document: Document,
    pub(super) face: Face,
    pub(super) pose: Pose,
    pub(super) stage: Option<Stage>,
    pub(super) photo: Option<Tiled>,
    pub(super) at_rest: Option<(finals::Key, Tiled)>,
    asked_for: Option<finals::Key>,
    pub(super) loading: Option<Running>,
    pub(super) saving: Option<Running>,
    pub(super) toasts: Toasts,
    pub(super) dialog: Option<Dialog>,
    pub(super) generation: u64,
    pub(super) is_before_after: bool,
    pub(super) split: f32,
    pub(super) is_circling: bool,
    pub(super) is_drawer_open: bool,
    pub(super) canvas: egui::Rect,
    /// Place in the picture (0 to 1) that cross-hairs and epipolar images go through.
    pub(super) probe: egui::Vec2,
    pub(super) hovered_px: Option<f32>,
    /// When the picture last moved, so that the picture at rest waits for the hand.
    pub(super) moved_at_secs: f64,
    pub(super) is_moving: bool,
    undoer: Undoer<Edit>,
    is_new_file: bool,
    is_again: bool,
    events: Receiver<(JobId, Event)>,
    loader: Worker<Load>,
    saver: Worker<export::Request>,
    finisher: Worker<finals::Request>,
    asker: Worker<Ask>,
    folder: Worker<(PathBuf, bool)>,
    pub(super) threads: usize,
}

/// Letters between threads and window.
const LETTERS: usize = 256;
/// Rest before the picture at rest is asked for.
const REST_SECS: f64 = 0.2;

impl App {
    /// A window on egui's device; `storage` holds what the last one remembered.
    pub fn new(
        options: Options,
        ctx: &egui::Context,
        render: Option<&RenderState>,
        storage: Option<&dyn eframe::Storage>,
    ) -> Self {
        theme::install(ctx);
        let settings: Settings =
            storage.and_then(|storage| eframe::get_value(storage, eframe::APP_KEY)).unwrap_or_default();
        ctx.set_theme(settings.theme);
        let (sender, events) = sync_channel(LETTERS);
        let outbox = Outbox::new(sender, ctx.clone());
        let threads = options.threads;
        let mut app = Self {
            edit: settings.edit,
            settings,
            document: Document::default(),
            face: Face::default(),
            pose: Pose::default(),
            stage: render.map(Stage::new),
            photo: None,
            at_rest: None,
            asked_for: None,
            loading: None,
            saving: None,
            toasts: Toasts::default(),
            dialog: None,
            generation: 0,
            is_before_after: false,
            split: 0.5,
            is_circling: false,
            is_drawer_open: false,
            canvas: egui::Rect::ZERO,
            probe: egui::Vec2::splat(0.5),
            hovered_px: None,
            moved_at_secs: 0.0,
            is_moving: false,
            undoer: Undoer::default(),
            is_new_file: false,
            is_again: false,
            events,
            loader: Worker::spawn("synth", outbox.clone(), jobs::loader(options.models, threads)),
            saver: Worker::spawn("export", outbox.clone(), export::work),
            finisher: Worker::spawn("final", outbox.clone(), finals::worker()),
            asker: Worker::spawn("dialog", outbox.clone(), dialogs::work),
            folder: Worker::spawn("folder", outbox, super::neighbours::work),
            threads,
        };
        if let Some(long_side) = options.long_side {
            app.settings.long_side = long_side;
        }
        let last = if options.restores_last { app.settings.last_file.clone() } else { None };
        if let Some(file) = options.files.into_iter().next().or(last.filter(|path| path.exists())) {
            app.open(From::File(file));
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
        self.loading.is_some() || self.saving.is_some()
    }

    /// Opens a file, as if it had been dropped.
    pub fn open_file(&mut self, path: &std::path::Path) {
        self.open(From::File(path.to_owned()));
    }

    /// Where exports go.
    pub fn set_export_folder(&mut self, folder: &std::path::Path) {
        self.settings.export.folder = Some(folder.to_owned());
    }

    /// Opens a file; what is open stays usable until the new one is there.
    pub(super) fn open(&mut self, from: From) {
        self.is_again = matches!(from, From::Again(_));
        self.is_new_file = !self.is_again;
        let load = Load {
            from,
            long_side: self.settings.long_side,
            occlusion: self.settings.occlusion,
            source: self.settings.source,
        };
        self.loading = Some(Running { job: self.loader.replace(load), progress: None, since_secs: now() });
    }

    /// Makes the light field anew, after a setting changed.
    pub(super) fn make_again(&mut self) {
        if self.document.photo.is_some() {
            let document = Document { field: None, depths: None, survey: None, ..self.document.clone() };
            self.open(From::Again(Box::new(document)));
        }
    }

    /// Asks the system for a file or a folder.
    pub(super) fn ask(&mut self, ask: Ask) {
        self.asker.push(ask);
    }

    /// Starts the export that the dialog describes.
    pub(super) fn start_export(&mut self) {
        let target = self.settings.export.target(&self.document, &self.edit);
        self.save(Some(target));
    }

    fn save(&mut self, target: Option<PathBuf>) {
        let Some(field) = self.document.field.clone() else {
            self.toasts.error("nothing to export yet — the light field is still being made — wait for it to end");
            return;
        };
        let request = export::Request {
            settings: self.settings.export.clone(),
            target,
            edit: self.edit,
            field,
            depths: self.document.depths.clone(),
            photo: self.document.photo.clone(),
        };
        self.saving = Some(Running { job: self.saver.push(request), progress: None, since_secs: now() });
    }

    /// Opens the photo before or after this one.
    fn step_file(&mut self, is_next: bool) {
        if let Some(path) = self.document.path.clone() {
            self.folder.replace((path, is_next));
        }
    }

    /// Does what a person asked for.
    pub(super) fn apply(&mut self, action: Action, ctx: &egui::Context) {
        match action {
            Action::Open => {
                let folder = self.document.path.as_deref().and_then(|path| path.parent()).map(PathBuf::from);
                self.ask(Ask::Open { folder });
            }
            Action::OpenSample => self.open(From::Sample),
            Action::Paste => self.ask(Ask::Clipboard),
            Action::NextPhoto => self.step_file(true),
            Action::PreviousPhoto => self.step_file(false),
            Action::Export => self.dialog = self.document.field.is_some().then_some(Dialog::Export),
            Action::CopyPicture => self.save(None),
            Action::Stop => self.stop(),
            Action::Quit => ctx.send_viewport_cmd(egui::ViewportCommand::Close),
            Action::Undo => self.edit = self.undoer.undo(&self.edit).copied().unwrap_or(self.edit),
            Action::Redo => self.edit = self.undoer.redo(&self.edit).copied().unwrap_or(self.edit),
            Action::ResetLens => {
                self.edit.lens = Default::default();
                self.focus_on_subject();
            }
            Action::ResetViewpoint => self.look_from(ViewOffset::default()),
            Action::StepLeft => self.step_view(-1.0, 0.0),
            Action::StepRight => self.step_view(1.0, 0.0),
            Action::StepUp => self.step_view(0.0, -1.0),
            Action::StepDown => self.step_view(0.0, 1.0),
            Action::Circle => self.is_circling = !self.is_circling,
            Action::Picture => self.face = Face::Picture,
            Action::Views => self.face = Face::Views,
            Action::Depths => self.face = Face::Depths,
            Action::ToggleDepth => {
                self.face = if self.face == Face::Depths { Face::Picture } else { Face::Depths };
            }
            Action::BeforeAfter => self.is_before_after = !self.is_before_after,
            Action::Fit => self.pose = Pose::default(),
            Action::OneToOne => self.zoom_to_pixels(ctx.pixels_per_point()),
            Action::ZoomIn => self.zoom_by(1.25),
            Action::ZoomOut => self.zoom_by(0.8),
            Action::ToggleInspector => {
                self.settings.has_inspector = !self.settings.has_inspector;
                self.is_drawer_open = !self.is_drawer_open;
            }
            Action::FullScreen => {
                let is_full = ctx.input(|input| input.viewport().fullscreen.unwrap_or(false));
                ctx.send_viewport_cmd(egui::ViewportCommand::Fullscreen(!is_full));
            }
            Action::NextTheme => {
                use egui::ThemePreference as Theme;
                self.settings.theme = match self.settings.theme {
                    Theme::Dark => Theme::Light,
                    Theme::Light => Theme::System,
                    Theme::System => Theme::Dark,
                };
                ctx.set_theme(self.settings.theme);
            }
            Action::ClearRecent => self.settings.recent.clear(),
            Action::Shortcuts => {
                self.dialog = (self.dialog != Some(Dialog::Shortcuts)).then_some(Dialog::Shortcuts);
            }
        }
    }

    fn stop(&mut self) {
        if self.dialog.take().is_some() {
            return;
        }
        if self.loading.is_some() {
            self.loader.stop();
        } else if self.saving.is_some() {
            self.saver.stop();
        }
    }

    fn zoom_by(&mut self, factor: f32) {
        if let Some(size) = self.picture_size() {
            self.pose.zoom_at(self.canvas, size, self.canvas.center(), factor);
        }
    }

    fn zoom_to_pixels(&mut self, pixels_per_point: f32) {
        if let Some(size) = self.picture_size() {
            self.pose.one_to_one(self.canvas, size, 1.0 / pixels_per_point);
        }
    }

    /// Size of the picture that is looked at.
    pub(super) fn picture_size(&self) -> Option<egui::Vec2> {
        self.document.size().map(|[w, h]| egui::vec2(w as f32, h as f32))
    }

    /// Moves the eye.
    pub(super) fn look_from(&mut self, offset: ViewOffset) {
        if let Some(grid) = self.document.grid() {
            self.edit.viewpoint = ViewPoint(grid.clamp(offset));
        }
    }

    fn step_view(&mut self, du: f32, dv: f32) {
        let at = self.edit.viewpoint.0;
        self.look_from(ViewOffset { dv: (at.dv + dv).round(), du: (at.du + du).round() });
    }

    /// The view that is nearest to the eye.
    pub(super) fn nearest_view(&self) -> Option<ViewIndex> {
        self.document.grid().map(|grid| grid.nearest(self.edit.viewpoint.0))
    }

    /// Focus where the subject most likely is: what is rather near in the middle third.
    pub(super) fn focus_on_subject(&mut self) {
        let Some(depths) = &self.document.depths else { return };
        let ([w, h], map) = (depths.size(), depths.reference());
        let rows = (h / 3..(h * 2).div_ceil(3)).step_by(3);
        let mut middle: Vec<f32> = rows
            .flat_map(|y| (w / 3..(w * 2).div_ceil(3)).step_by(3).map(move |x| map[(y * w + x) as usize]))
            .collect();
        middle.sort_unstable_by(f32::total_cmp);
        if let Some(&disparity) = middle.get(middle.len() * 3 / 4) {
            self.edit.lens.focus.disparity_px = disparity;
        }
    }

    /// Takes in what the threads have sent. Never waits.
    fn drain(&mut self, ctx: &egui::Context) {
        while let Ok((job, event)) = self.events.try_recv() {
            let is_load = self.loading.as_ref().is_some_and(|running| running.job == job);
            let is_save = self.saving.as_ref().is_some_and(|running| running.job == job);
            match event {
                Event::Picked(picked) => self.picked(picked),
                Event::Final(rendered) => self.at_rest = Some((rendered.0, Tiled::new(rendered.1))),
                Event::Copied(picture) => {
                    let size = picture.size.map(|side| side as usize);
                    ctx.copy_image(egui::ColorImage::from_rgba_unmultiplied(size, &picture.to_srgb8()));
                    self.saving = None;
                    self.toasts.info("Copied the picture");
                }
                Event::Failed(text) => {
                    self.toasts.error(&text);
                    self.end(is_load, is_save);
                }
                Event::Stopped => self.end(is_load, is_save),
                Event::Warning(text) => self.toasts.info(&text),
                Event::Progress(progress) if is_load => set_progress(&mut self.loading, progress),
                Event::Progress(progress) if is_save => set_progress(&mut self.saving, progress),
                Event::Saved(path) => {
                    self.saving = None;
                    self.toasts.saved(path);
                }
                event if is_load => self.loaded(event, ctx),
                _ => {}
            }
        }
    }

    fn end(&mut self, is_load: bool, is_save: bool) {
        if is_load {
            self.loading = None;
        }
        if is_save {
            self.saving = None;
        }
    }

    fn loaded(&mut self, event: Event, ctx: &egui::Context) {
        match event {
            Event::Opened(document) => self.opened(*document, ctx),
            Event::Tiles(tiles) => self.photo = Some(Tiled::new(tiles)),
            // Made again with other settings: the old light field stays usable until the new one is complete.
            Event::Depths(_) | Event::View(..) if self.is_again => {}
            Event::Depths(depths) => self.take_depths(depths),
            Event::View(at, view) => {
                let grid = self.document.depths.as_ref().map(|depths| depths.grid());
                if let (Some(stage), Some(grid)) = (&mut self.stage, grid) {
                    stage.push_view(grid, at, &view);
                }
            }
            Event::Made(made) => {
                self.loading = None;
                self.generation += 1;
                let is_streamed = !self.is_again && self.document.photo.is_some();
                if let Some(stage) = &mut self.stage
                    && !is_streamed
                {
                    stage.push_field(&made.field);
                }
                self.document.field = Some(made.field);
                self.document.made_by = made.made_by;
                self.document.took_secs = made.took_secs;
                if let Some(depths) = made.depths {
                    let is_new = self.document.depths.as_ref().is_none_or(|old| !Arc::ptr_eq(old, &depths));
                    if is_new {
                        self.take_depths(depths);
                    }
                }
            }
            _ => {}
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
        self.at_rest = None;
        self.pose = Pose::default();
        self.face = Face::Picture;
        self.is_circling = false;
        self.edit.viewpoint = ViewPoint::default();
        self.edit.lens.focus = Default::default();
        self.edit.lens.keep_sharp_px = [0.0, 0.0];
        self.undoer = Undoer::default();
        self.probe = egui::Vec2::splat(0.5);
        document.warnings.iter().for_each(|warning| self.toasts.info(warning));
        if let Some(path) = &document.path {
            self.settings.remember(path);
        }
        ctx.send_viewport_cmd(egui::ViewportCommand::Title(format!("{} — Plenoscope", document.name)));
        let depths = document.depths.clone();
        self.document = document;
        if let Some(depths) = depths {
            self.take_depths(depths);
        }
    }

    fn take_depths(&mut self, depths: Arc<crate::field::RayDepths>) {
        self.document.survey = Some(Survey::new(&depths));
        if let Some(stage) = &mut self.stage {
            stage.push_depths(&depths);
        }
        self.document.depths = Some(depths);
        if self.is_new_file {
            self.focus_on_subject();
            self.is_new_file = false;
        }
    }

    fn picked(&mut self, picked: Picked) {
        match picked {
            Picked::Open(path) => self.open(From::File(path)),
            Picked::Folder(path) => self.settings.export.folder = Some(path),
            Picked::Pixels(size, rgba) => self.open(From::Pixels(size, rgba)),
            Picked::Unavailable => {
                if self.dialog.is_none() {
                    self.dialog = Some(Dialog::Path(String::new()));
                } else {
                    self.toasts.info("The system shows no folder dialog here: type the folder into the field");
                }
            }
            Picked::Nothing => {}
        }
    }

    /// Asks for the picture at rest once nothing has moved for a while.
    fn rest(&mut self, ctx: &egui::Context) {
        let Some(key) = self.key_at_rest(ctx.pixels_per_point()) else {
            self.asked_for = None;
            return;
        };
        let is_there = self.at_rest.as_ref().is_some_and(|(have, _)| *have == key);
        if is_there || self.asked_for == Some(key) {
            return;
        }
        let waited = now() - self.moved_at_secs;
        if self.is_moving || waited < REST_SECS {
            ctx.request_repaint_after(std::time::Duration::from_secs_f64(REST_SECS));
            return;
        }
        let Document { photo: Some(photo), field: Some(field), depths: Some(depths), .. } = &self.document else {
            return;
        };
        let (photo, field, depths) = (Arc::clone(photo), Arc::clone(field), Arc::clone(depths));
        self.finisher.replace(finals::Request { key, photo, field, depths });
        self.asked_for = Some(key);
    }

    /// What the picture at rest has to show; `None` where the draft, or the photo itself, is all there is.
    pub(super) fn key_at_rest(&self, pixels_per_point: f32) -> Option<finals::Key> {
        let size = self.picture_size()?;
        let photo = self.document.photo.as_ref()?;
        let is_possible = self.document.field.is_some()
            && self.document.depths.is_some()
            && self.face == Face::Picture
            && self.edit.viewpoint == ViewPoint::default()
            && self.edit.lens.f_number.added_views() > 0.0;
        let on_screen = self.pose.screen_rect(self.canvas, size) * pixels_per_point;
        let canvas = self.canvas * pixels_per_point;
        is_possible.then(|| finals::Key::new(self.edit.lens, self.generation, photo.size(), on_screen, canvas))
    }

    fn keep_history(&mut self, ctx: &egui::Context) {
        let time = ctx.input(|input| input.time);
        self.undoer.feed_state(time, &self.edit);
        if self.undoer.is_in_flux() {
            ctx.request_repaint_after(std::time::Duration::from_millis(500));
        }
    }

    fn circle(&mut self, ctx: &egui::Context) {
        if !self.is_circling {
            return;
        }
        let Some(grid) = self.document.grid() else { return };
        let radius = (grid.rows().min(grid.cols()) as f32 / 2.0 - 1.0).max(0.0);
        let angle = ctx.input(|input| input.time) as f32 * 1.6;
        self.edit.viewpoint = ViewPoint(ViewOffset { dv: radius * angle.sin(), du: radius * angle.cos() });
        self.is_moving = true;
        ctx.request_repaint();
    }

    fn read_keys(&mut self, ctx: &egui::Context) {
        for file in ctx.input(|input| input.raw.dropped_files.clone()).iter().take(1) {
            self.open(From::File(file.path().to_owned()));
        }
        if ctx.text_edit_focused() {
            return;
        }
        let events = ctx.input(|input| input.events.clone());
        for event in events {
            match event {
                egui::Event::Copy => self.save(None),
                egui::Event::Paste(text) => match dialogs::path_from_text(&text) {
                    Some(path) => self.open(From::File(path)),
                    None => self.apply(Action::Paste, ctx),
                },
                egui::Event::PasteImage(image) => {
                    let rgba = image.pixels.iter().flat_map(|pixel| pixel.to_srgba_unmultiplied()).collect();
                    self.open(From::Pixels(image.size.map(|side| side as u32), rgba));
                }
                _ => {}
            }
        }
        if self.dialog.is_some() && !matches!(self.dialog, Some(Dialog::Shortcuts)) {
            return;
        }
        for action in Action::ALL {
            let keys = action.spec().shortcut;
            if keys.is_some_and(|keys| ctx.input_mut(|input| input.consume_shortcut(&keys))) {
                self.apply(action, ctx);
            }
        }
    }

    fn show_dialog(&mut self, ctx: &egui::Context) {
        let is_open = match self.dialog.clone() {
            None => return,
            Some(Dialog::Export) => export::dialog(self, ctx),
            Some(Dialog::Shortcuts) => super::panels::sheet::show(ctx),
            Some(Dialog::Settings) => super::panels::settings::show(self, ctx),
            Some(Dialog::Path(text)) => super::panels::path_box::show(self, ctx, text),
        };
        if !is_open {
            self.dialog = None;
        }
    }
}

fn set_progress(running: &mut Option<Running>, progress: Progress) {
    if let Some(running) = running {
        running.progress = Some(progress);
    }
}

/// Seconds since the program began, for what is shown of time.
pub(super) fn now() -> f64 {
    static START: std::sync::OnceLock<std::time::Instant> = std::sync::OnceLock::new();
    START.get_or_init(std::time::Instant::now).elapsed().as_secs_f64()
}

impl eframe::App for App {
    fn logic(&mut self, ctx: &egui::Context, _frame: &mut eframe::Frame) {
        self.drain(ctx);
        if self.stage.as_mut().is_some_and(Stage::upload_some) {
            ctx.request_repaint();
        }
    }

    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        let ctx = ui.ctx().clone();
        self.read_keys(&ctx);
        let before = (self.edit, self.pose);
        self.is_moving = ctx.input(|input| input.pointer.any_down());
        self.circle(&ctx);
        super::panels::layout(self, ui);
        self.show_dialog(&ctx);
        self.toasts.show(&ctx);
        if before != (self.edit, self.pose) {
            self.moved_at_secs = now();
        }
        self.rest(&ctx);
        if !self.is_circling {
            self.keep_history(&ctx);
        }
    }

    fn save(&mut self, storage: &mut dyn eframe::Storage) {
        self.settings.edit = self.edit;
        eframe::set_value(storage, eframe::APP_KEY, &self.settings);
    }

    fn clear_color(&self, _visuals: &egui::Visuals) -> [f32; 4] {
        theme::DARK.surround.to_normalized_gamma_f32()
    }
}
