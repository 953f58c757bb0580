//! What is done when a person asks for it: one arm for each action of the list.

use std::path::{Path, PathBuf};

use super::action::Action;
use super::app::{App, Dialog};
use super::dialogs::Ask;
use super::export::work::{FileRequest, Order, Request};
use super::jobs::From;
use super::neighbours;
use super::queue::State;
use super::state::{Face, Pose};
use super::worker::JobId;
use crate::field::{ViewOffset, ViewPoint};
use crate::io::formats::layout::Layout;

impl App {
    /// Whether an action can be done now; the menu greys out what cannot.
    pub(super) fn can(&self, action: Action) -> bool {
        let has_field = self.document.field.is_some();
        let has_picture = self.picture_size().is_some();
        match action {
            Action::Export | Action::CopyPicture | Action::Peaking => has_field,
            Action::ResetViewpoint
            | Action::StepLeft
            | Action::StepRight
            | Action::StepUp
            | Action::StepDown
            | Action::Circle
            | Action::Views
            | Action::Depths
            | Action::ToggleDepth => self.document.grid().is_some(),
            Action::Opposite | Action::Transpose | Action::Serpentine => has_field && self.document.is_from_disk(),
            Action::OwnDepth | Action::BeforeAfter => self.document.photo.is_some(),
            Action::NextPhoto | Action::PreviousPhoto => self.document.path.is_some(),
            Action::Stop => self.is_busy(),
            Action::Undo => self.history.can_undo(&self.edit),
            Action::Redo => self.history.can_redo(&self.edit),
            Action::Fit
            | Action::OneToOne
            | Action::ZoomIn
            | Action::ZoomOut
            | Action::Picture
            | Action::CopyEdit
            | Action::PasteEdit
            | Action::ResetLens => has_picture,
            Action::ClearRecent => !self.settings.recent.is_empty(),
            _ => true,
        }
    }

    /// Does what a person asked for.
    pub(super) fn apply(&mut self, action: Action, ctx: &egui::Context) {
        if !self.can(action) {
            return;
        }
        let folder = || self.document.path.as_deref().and_then(Path::parent).map(PathBuf::from);
        match action {
            Action::Open => self.ask(Ask::Open { folder: folder() }),
            Action::OpenFolder => self.ask(Ask::OpenFolder { folder: folder() }),
            Action::OpenSample => self.open(From::Sample),
            Action::Paste => self.ask(Ask::Clipboard),
            Action::NextPhoto => self.step_file(true),
            Action::PreviousPhoto => self.step_file(false),
            Action::Export => self.dialog = Some(Dialog::Export),
            Action::ExportPhotos => self.ask(Ask::Photos { folder: folder() }),
            Action::Queue => self.is_queue_open = !self.is_queue_open,
            Action::CopyPicture => self.copy_picture(),
            Action::Settings => self.dialog = Some(Dialog::Settings),
            Action::Stop => self.stop(),
            Action::Quit => ctx.send_viewport_cmd(egui::ViewportCommand::Close),
            Action::Undo => self.edit = self.history.undo(&self.edit),
            Action::Redo => self.edit = self.history.redo(&self.edit),
            Action::CopyEdit => self.copy_edit(ctx),
            Action::PasteEdit => self.ask(Ask::PasteEdit),
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
            Action::OwnDepth => self.ask(Ask::DepthMap { folder: folder() }),
            Action::Opposite => self.lay_out(Layout::opposite),
            Action::Transpose => self.lay_out(|layout| Layout { transposed: !layout.transposed, ..layout }),
            Action::Serpentine => self.lay_out(|layout| Layout { serpentine: !layout.serpentine, ..layout }),
            _ => self.apply_to_view(action, ctx),
        }
    }

    /// What changes nothing but how it is looked at.
    fn apply_to_view(&mut self, action: Action, ctx: &egui::Context) {
        match action {
            Action::Picture => self.face = Face::Picture,
            Action::Views => self.face = Face::Views,
            Action::Depths => self.face = Face::Depths,
            Action::ToggleDepth => {
                self.face = if self.face == Face::Depths { Face::Picture } else { Face::Depths };
            }
            Action::BeforeAfter => self.is_before_after = !self.is_before_after,
            Action::Peaking => self.settings.peaking = !self.settings.peaking,
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
            Action::ClearRecent => {
                self.settings.recent.clear();
                self.workers.recents.push(Vec::new());
            }
            Action::Shortcuts => {
                self.dialog = (self.dialog != Some(Dialog::Shortcuts)).then_some(Dialog::Shortcuts);
            }
            _ => {}
        }
    }

    /// Opens the photo before or after this one.
    fn step_file(&mut self, is_next: bool) {
        if let Some(path) = self.document.path.clone() {
            self.workers.folder.replace(neighbours::Request::Step(path, is_next));
        }
    }

    /// Lays a light field from disk out anew; the old one stays until the new one has its ray depths.
    fn lay_out(&mut self, change: impl Fn(Layout) -> Layout) {
        let document = self.document.laid_out(change(self.document.layout));
        self.open(From::Again(Box::new(document)));
    }

    fn stop(&mut self) {
        if self.loading.is_some() {
            self.workers.loader.stop();
        } else if let Some(job) = self.queue.current().map(|task| task.job) {
            self.stop_task(job);
        }
    }

    /// Stops one export.
    pub(super) fn stop_task(&mut self, job: JobId) {
        if self.workers.saver.cancel(job) {
            self.queue.end(job, State::Stopped);
        }
    }

    /// Where the export that the dialog describes goes.
    pub(super) fn export_target(&self) -> PathBuf {
        let settings = &self.settings.export;
        match self.photos_to_export.first() {
            Some(path) => settings.target_of(Some(path), &file_name(path), &self.edit),
            None => settings.target(&self.document, &self.edit),
        }
    }

    /// Starts the export that the dialog describes.
    pub(super) fn start_export(&mut self) {
        let photos = std::mem::take(&mut self.photos_to_export);
        if photos.is_empty() {
            let target = self.export_target();
            let title = file_name(&target);
            self.save_shown(Some(target), title);
            return;
        }
        self.is_queue_open = true;
        for path in photos {
            let title = file_name(&path);
            let settings = self.settings.export.clone();
            let load = self.load(From::File(path.clone()));
            let request = FileRequest { path, settings, edit: self.edit, load };
            let job = self.workers.saver.push(Order::File(Box::new(request)));
            self.queue.add(job, title);
        }
    }

    pub(super) fn copy_picture(&mut self) {
        self.save_shown(None, "Copy picture".to_owned());
    }

    fn save_shown(&mut self, target: Option<PathBuf>, title: String) {
        let Some(field) = self.document.field.clone() else {
            self.toasts.error("nothing to export yet — the light field is still being made — wait for it to end");
            return;
        };
        let request = Request {
            settings: self.settings.export.clone(),
            target,
            edit: self.edit,
            field,
            stored: self.document.stored.clone(),
            depths: self.document.depths.clone(),
            photo: self.document.photo.clone(),
        };
        let job = self.workers.saver.push(Order::Shown(Box::new(request)));
        self.queue.add(job, title);
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

    /// Lets the viewpoint go round, one turn in four seconds.
    pub(super) fn circle(&mut self, ctx: &egui::Context) {
        if !self.is_circling {
            return;
        }
        let Some(grid) = self.document.grid() else { return };
        let radius = |side: usize| (side as f32 / 2.0 - 1.0).max(0.0);
        let angle = ctx.input(|input| input.time) as f32 * std::f32::consts::FRAC_PI_2;
        let (dv, du) = (radius(grid.rows()) * angle.sin(), radius(grid.cols()) * angle.cos());
        self.edit.viewpoint = ViewPoint(ViewOffset { dv, du });
        self.is_moving = true;
        ctx.request_repaint();
    }

    /// Focuses on a place of the reference view's picture, x and y from 0 to 1.
    pub(super) fn focus_on(&mut self, place: [f32; 2]) {
        let Some(grid) = self.document.grid() else { return };
        if let Some(disparity) = self.document.disparity_at(grid.reference(), place) {
            let focus = &mut self.edit.lens.focus;
            focus.disparity_px += disparity - focus.at(place[0], place[1]);
        }
    }

    /// Focuses where the subject most likely is.
    pub(super) fn focus_on_subject(&mut self) {
        let Some(place) = self.document.survey.as_ref().map(|survey| survey.subject) else { return };
        self.edit.focus_at = None;
        self.probe = place.into();
        self.focus_on(place);
    }
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}
