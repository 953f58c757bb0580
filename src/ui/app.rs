//! A frame of the window: letters of the threads, keys, panels, dialogs, and what they ask for.

use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, sync_channel};
use std::time::Duration;

use eframe::egui_wgpu::RenderState;

use super::action::Action;
use super::apply::apply;
use super::event::Event;
use super::field_pictures::FieldPictures;
use super::hints::Hint;
use super::jobs::OpenFrom;
use super::look::{Face, Look};
use super::lost::{Loss, Tried};
use super::progress::now;
use super::rest::Seen;
use super::settings::Settings;
use super::window::{Options, Window};
use super::words::message;
use super::worker::{JobId, Outbox};
use super::{film, history, inbox, input, mending, panels, screen, spoken, theme, training, widgets};
use crate::field::{Lens, LightField};
use crate::repair::Repairs;
use crate::scene::{DepthFrom, Edit, Focus};

/// The window.
pub struct App {
    window: Window,
    events: Receiver<(JobId, Event)>,
    /// Whether the window was brought to its screen's size.
    is_fitted: bool,
    /// Whether a frame was drawn.
    has_begun: bool,
    /// What became of its device.
    loss: Loss,
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
        settings.language = options.language.clone().or(settings.language);
        settings.long_side = options.long_side.unwrap_or(settings.long_side);
        settings.source = settings.source.lasting();
        ctx.set_theme(settings.theme);
        let (sender, events) = sync_channel(LETTERS);
        let outbox = Outbox::new(sender, ctx.clone());
        let last = if options.restores_last { settings.last_file.clone() } else { None };
        let mut window = Window::new(&options, settings, &outbox, render, storage.is_some());
        match options.files.into_iter().next().or(last.filter(|path| path.exists())) {
            Some(file) => window.open(OpenFrom::File(file)),
            None if storage.is_some() => {
                window.workers.recents.push(window.settings.recent.clone());
            }
            None => {}
        }
        log::info!("the window has its device and its parts after {:.2} s", now());
        Self { window, events, is_fitted: false, has_begun: false, loss: Loss::default() }
    }

    /// The window after so many devices were lost, listening for the end of this one.
    pub(super) fn after(mut self, tried: Tried, loss: Loss, render: Option<&RenderState>, ctx: &egui::Context) -> Self {
        if let Some(render) = render {
            loss.watch(render, ctx);
        }
        if tried != Tried::None {
            self.window.toasts.info(message!("device-lost"));
        }
        self.loss = loss;
        self
    }

    /// Writes the last edit: a few hundred bytes, before the threads are gone.
    fn keep_last_edit(&mut self) {
        match self.window.unkept().map(|keep| keep.write()) {
            Some(Err(why)) => log::error!("{why}"),
            Some(Ok(Some(theirs))) => {
                log::error!("{}", history::edited_elsewhere(&theirs).in_english())
            }
            Some(Ok(None)) | None => {}
        }
    }

    /// What is done to the picture.
    pub fn edit(&self) -> &Edit {
        &self.window.edit
    }

    /// The lens as the window shows it, in pixels of the views' width.
    pub fn lens(&self) -> Lens {
        self.window.open.lens(&self.window.edit)
    }

    /// The light field, once it is complete.
    pub fn light_field(&self) -> Option<&Arc<LightField>> {
        self.window.open.field()
    }

    /// The source of depth that is looked at.
    pub fn source(&self) -> DepthFrom {
        self.window.looked_at()
    }

    /// Whether something is being opened, made or saved.
    pub fn is_busy(&self) -> bool {
        self.window.is_busy()
    }

    /// Whether nothing is on its way: no job, no upload, no picture at rest.
    pub fn is_at_rest(&self) -> bool {
        let is_uploading = self.window.pictures.as_ref().is_some_and(FieldPictures::is_uploading);
        let has_points = self.window.look.face != Face::Points || self.window.points.is_there();
        let is_drawn = self.window.rest.is_there() && has_points;
        !self.is_busy() && is_drawn && !is_uploading && self.is_mended() && self.is_shaped()
    }

    /// Whether all repairs are in what is shown.
    pub fn is_mended(&self) -> bool {
        self.window.open.scene().is_none_or(|scene| *scene.repairs() == self.window.repairs)
    }

    /// What was done to the depth.
    pub fn repairs(&self) -> &Repairs {
        &self.window.repairs
    }

    /// Whether the strength that is asked for is shown.
    fn is_shaped(&self) -> bool {
        self.window.open.wanted_strength(&self.window.edit).is_none()
    }

    /// The disparity at a place of the photo, x and y from 0 to 1, in pixels per view step.
    pub fn focus_depth_px(&self, place: [f32; 2]) -> Option<f32> {
        let reference = self.window.open.grid()?.reference();
        self.window.open.disparity_at(Some(reference), place.into())
    }

    /// Opens a file, as if it had been dropped.
    pub fn open_file(&mut self, path: &Path) {
        self.window.open(OpenFrom::File(path.to_owned()));
    }

    /// Chooses light fields to train on, as if in the dialog.
    pub fn train_on(&mut self, data: &Path) {
        training::choose(&mut self.window, data);
    }

    /// Where exports go.
    pub fn set_export_folder(&mut self, folder: &Path) {
        self.window.settings.export.folder = Some(folder.to_owned());
    }

    /// Does what a panel asked for; what it changed is seen in the next frame.
    fn apply(&mut self, actions: Vec<Action>, ctx: &egui::Context) {
        if !actions.is_empty() {
            ctx.request_repaint();
        }
        actions.into_iter().for_each(|action| apply(&mut self.window, action, ctx));
    }

    /// Lets the viewpoint go round.
    fn circle(&mut self, ctx: &egui::Context) {
        let Window { open, look, edit, .. } = &mut self.window;
        if let Some(grid) = open.grid().filter(|_| look.is_circling) {
            edit.viewpoint = Look::on_circle(grid, ctx.input(|input| input.time));
            look.is_moving = true;
            ctx.request_repaint();
        }
    }

    /// Lets the film run.
    fn play(&mut self, ctx: &egui::Context) {
        if self.window.film.is_playing() && film::run(&mut self.window, ctx.input(|input| input.time)) {
            self.window.look.is_moving = true;
            ctx.request_repaint();
        }
    }

    /// Takes note of what a person has found out.
    fn learn(&mut self, before: &Edit) {
        let Window { edit, settings, .. } = &mut self.window;
        if before.viewpoint != edit.viewpoint {
            settings.hints.learn(Hint::Look);
        }
        if before.focus != edit.focus && matches!(edit.focus, Focus::At(_)) {
            settings.hints.learn(Hint::Focus);
        }
    }

    /// Asks for the pictures that come late.
    fn ask_for_pictures(&mut self, ctx: &egui::Context) {
        let Window { open, edit, look, rest, settings, workers, shaping, asked, tint, points, .. } = &mut self.window;
        if let Some(request) = shaping.ask(open, edit, rest.generation(), asked, look.is_moving) {
            workers.shaper.replace(request);
        }
        let seen = Seen { open, edit, look };
        if let Some(request) = rest.ask(&seen, ctx) {
            workers.finisher.replace(request);
        }
        if look.face == Face::Points
            && let Some(scene) = open.scene()
        {
            let size = look.canvas.size() * ctx.pixels_per_point();
            let size = [size.x, size.y].map(|side| side.max(1.0) as u32);
            if let Some(request) = points.ask(scene, size, rest.generation(), ctx) {
                workers.points.replace(request);
            }
        }
        if settings.trust
            && let Some(request) = tint.ask(&seen, rest.generation(), asked)
        {
            workers.truster.replace(request);
        }
        if settings.peaking
            && let Some(request) = rest.ask_peaks(&seen)
        {
            workers.peaker.replace(request);
        }
    }

    /// Asks for what mending depth waits for.
    fn mend(&mut self) {
        let Window { open, mending, repairs, rest, workers, asked, .. } = &mut self.window;
        let Some(scene) = open.scene() else { return };
        match mending.ask(rest.generation(), scene, repairs, asked) {
            Some(request @ mending::Request::Mend(..)) => mending.begun(workers.mender.replace(request)),
            Some(request) => _ = workers.outliner.replace(request),
            None => {}
        }
    }

    /// Takes note of edits; once the hand rests, they are kept beside the photo.
    fn keep_history(&mut self, ctx: &egui::Context) {
        let time_secs = ctx.input(|input| input.time);
        let step = self.window.step();
        if !self.window.history.has_settled(time_secs, &step) {
            ctx.request_repaint_after(Duration::from_millis(500));
        } else if !self.window.look.is_moving {
            self.window.keep_edit();
        }
    }

    /// Toasts lie over the picture's lower left corner, above its read-out: they cover no control.
    fn toast_place(&self, ctx: &egui::Context) -> egui::Pos2 {
        match self.window.open.document() {
            Some(_) => self.window.look.canvas.left_bottom() + egui::vec2(8.0, -36.0),
            None => ctx.content_rect().left_bottom() + egui::vec2(44.0, -70.0),
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
        while let Ok((job, event)) = self.events.try_recv() {
            inbox::take(&mut self.window, job, event, ctx);
        }
        if self.loss.why().is_some() {
            // What is open is to be opened again.
            return ctx.send_viewport_cmd(egui::ViewportCommand::Close);
        }
        let Some(pictures) = &mut self.window.pictures else { return };
        pictures.is_streaming = self.window.loading.running().is_some();
        let frame = Duration::from_secs_f32(ctx.input(|input| input.unstable_dt).clamp(0.0, 0.25));
        if pictures.upload_some(frame) {
            ctx.request_repaint();
        }
    }

    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        // What draws panics without its device, unless there is nothing to draw.
        if self.loss.why().is_some() {
            return;
        }
        let ctx = ui.ctx().clone();
        let asked = input::read(&ctx, self.window.dialog.as_ref(), self.window.open.photo().is_some());
        self.apply(asked, &ctx);
        let before = (self.window.edit.clone(), self.window.look.pose);
        self.window.look.is_moving = ctx.input(|input| input.pointer.any_down());
        self.circle(&ctx);
        self.play(&ctx);
        let asked = panels::layout(&mut self.window, ui);
        self.apply(asked, &ctx);
        let asked = panels::dialog(&mut self.window, &ctx);
        self.apply(asked, &ctx);
        let asked = panels::queue(&mut self.window, &ctx);
        self.apply(asked, &ctx);
        let asked = panels::hint(&self.window, &ctx);
        self.apply(asked.into_iter().collect(), &ctx);
        self.learn(&before.0);
        let place = self.toast_place(&ctx);
        self.window.toasts.show(&ctx, place);
        spoken::show(&self.window, ui);
        widgets::show_focus(&ctx);
        let Window { edit, look, .. } = &mut self.window;
        if (&before.0, before.1) != (&*edit, look.pose) {
            look.moved_at_secs = now();
        }
        self.mend();
        self.ask_for_pictures(&ctx);
        if !self.window.look.is_circling && !self.window.film.is_playing() {
            self.keep_history(&ctx);
        }
        if !std::mem::replace(&mut self.has_begun, true) {
            log::info!("the first frame is laid out after {:.2} s", now());
        }
    }

    fn save(&mut self, storage: &mut dyn eframe::Storage) {
        self.window.settings.edit = self.window.edit.clone();
        eframe::set_value(storage, eframe::APP_KEY, &self.window.settings);
    }

    fn on_exit(&mut self) {
        self.loss.close();
        self.keep_last_edit();
    }

    /// The surround: nothing else is painted where it shows.
    fn clear_color(&self, visuals: &egui::Visuals) -> [f32; 4] {
        theme::of(visuals).surround.to_normalized_gamma_f32()
    }
}

impl Drop for App {
    /// A renderer that panics without its device leaves no time for [`on_exit`](eframe::App::on_exit).
    fn drop(&mut self) {
        if self.loss.why().is_some() || (std::thread::panicking() && self.loss.is_why()) {
            self.loss.remember(self.window.open.document().and_then(|document| document.subject.path.clone()));
            self.keep_last_edit();
        }
    }
}
