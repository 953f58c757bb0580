//! Saving what is seen: the dialog, its settings, and the thread's work. Files are written aside, then renamed.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::app::App;
use super::document::Document;
use super::jobs::sentence;
use super::state::Edit;
use super::widgets;
use super::worker::{Event, JobId, Outbox};
use super::{dialogs, theme};
use crate::field::{LightField, Photo, RayDepths, ViewPoint, fit_long_side};
use crate::io::save::{self, Format, Keep, Origin, PictureOptions};
use crate::job::{Cancel, Job, Progress, Sink, Stage};
use crate::render::{cpu, lens};

/// What is saved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum What {
    /// The refocused picture.
    #[default]
    Picture,
    /// All views and ray depths, as a folder.
    Views,
}

/// How large the picture is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Size {
    /// The photo's own.
    #[default]
    Photo,
    /// This long side, in pixels.
    LongSide(u32),
    /// The light field's, by its views.
    Views,
}

/// What happens when a file of that name exists.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Existing {
    /// The new file gets a number.
    #[default]
    Number,
    /// The old file goes.
    Replace,
}

/// What the dialog said last.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ExportSettings {
    /// Picture or folder.
    pub what: What,
    /// How large.
    pub size: Size,
    /// Suffix of the picture: `png`, `jpg`, `tif` or `webp`.
    pub suffix: String,
    /// Bits of a channel, 8 or 16.
    pub bits: u8,
    /// Quality of a JPEG, 1 … 100.
    pub quality: u8,
    /// Whether EXIF and XMP go along.
    pub keeps_metadata: bool,
    /// Whether the place goes along with them.
    pub keeps_place: bool,
    /// Where to; none is beside the photo.
    pub folder: Option<PathBuf>,
    /// Name without suffix: `{name}`, `{f}` and `{focus}` are filled in.
    pub template: String,
    /// When the file exists.
    pub existing: Existing,
}

impl Default for ExportSettings {
    fn default() -> Self {
        Self {
            what: What::Picture,
            size: Size::Photo,
            suffix: "jpg".to_owned(),
            bits: 8,
            quality: 92,
            keeps_metadata: true,
            keeps_place: false,
            folder: None,
            template: "{name}-f{f}".to_owned(),
            existing: Existing::Number,
        }
    }
}

impl ExportSettings {
    const SUFFIXES: [&'static str; 4] = ["jpg", "png", "tif", "webp"];

    /// Where the export goes.
    pub fn target(&self, document: &Document, edit: &Edit) -> PathBuf {
        let beside = document.path.as_deref().and_then(Path::parent).map(Path::to_owned);
        let home = || directories::UserDirs::new().map(|dirs| dirs.picture_dir().unwrap_or(dirs.home_dir()).to_owned());
        let folder = self.folder.clone().or(beside).or_else(home).unwrap_or_default();
        let stem = Path::new(&document.name).file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let name = self
            .template
            .replace("{name}", &stem)
            .replace("{f}", &format!("{:.1}", edit.lens.f_number.0))
            .replace("{focus}", &format!("{:+.2}", edit.lens.focus.disparity_px))
            .replace(['/', '\\'], "-");
        match self.what {
            What::Picture => folder.join(format!("{name}.{}", self.suffix)),
            What::Views => folder.join(format!("{name}-views")),
        }
    }

    /// Long side of a picture by the lens renderer; `None` where the views' own picture is saved: for light fields from
    /// disk, and from viewpoints that only the views have seen.
    fn long_side(&self, photo: Option<&Photo>, edit: &Edit) -> Option<u32> {
        let [w, h] = photo?.size();
        let is_centred = edit.viewpoint == ViewPoint::default();
        match self.size {
            _ if !is_centred => None,
            Size::Views => None,
            Size::Photo => Some(w.max(h)),
            Size::LongSide(side) => Some(side.clamp(16, w.max(h))),
        }
    }

    fn options(&self, photo: Option<&Photo>) -> PictureOptions {
        let keep = match (self.keeps_metadata, self.keeps_place) {
            (false, _) => Keep::Nothing,
            (true, false) => Keep::WithoutPosition,
            (true, true) => Keep::All,
        };
        PictureOptions {
            format: Format::of(Path::new(&format!("x.{}", self.suffix))),
            bits: self.bits,
            quality: self.quality,
            keep,
            origin: photo.map(Origin::in_srgb).unwrap_or_default(),
            replace_source: false,
        }
    }
}

/// A request to the thread that writes.
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
    /// Their ray depths.
    pub depths: Option<Arc<RayDepths>>,
    /// The photo they were made from.
    pub photo: Option<Arc<Photo>>,
}

/// The work of the thread that writes.
pub fn work(job: JobId, request: Request, cancel: &Cancel, outbox: &Outbox) {
    struct Told<'a>(JobId, &'a Outbox);
    impl Sink for Told<'_> {
        fn progress(&self, progress: Progress) {
            self.1.send(self.0, Event::Progress(progress));
        }
    }
    let told = Told(job, outbox);
    let done = export(&request, &Job { cancel, sink: &told });
    outbox.send(
        job,
        match done {
            _ if cancel.is_cancelled() => Event::Stopped,
            Ok(event) => event,
            Err(text) => Event::Failed(text),
        },
    );
}

fn export(request: &Request, job: &Job) -> Result<Event, String> {
    job.advance(Stage::Save, 0, 1).map_err(|stopped| stopped.to_string())?;
    let target = match &request.target {
        Some(target) if request.settings.existing == Existing::Number => save::free_path(target),
        Some(target) => target.clone(),
        None => return Ok(Event::Copied(Arc::new(picture(request)))),
    };
    match request.settings.what {
        What::Picture => write_picture(&target, request, job)?,
        What::Views => super::export_views::write(&target, &request.field, request.depths.as_deref(), job)?,
    }
    Ok(Event::Saved(target))
}

/// By the lens renderer at photo size and in the photo's own colours, or by the views at theirs.
fn write_picture(target: &Path, request: &Request, job: &Job) -> Result<(), String> {
    let photo = request.photo.as_ref();
    let mut options = request.settings.options(photo.map(Arc::as_ref));
    let long_side = request.settings.long_side(photo.map(Arc::as_ref), &request.edit);
    let (Some(photo), Some(depths), Some(long_side)) = (photo, &request.depths, long_side) else {
        return save::picture(target, &picture(request), &options).map_err(|error| sentence(&error));
    };
    options.origin = Origin::in_own_space(photo);
    save::check(target, &options).map_err(|error| sentence(&error))?;
    let scene = super::finals::scene_of(photo, &request.field, depths).map_err(|error| sentence(&error))?;
    let size = fit_long_side(photo.size(), long_side);
    let pixels = lens::render_pixels(&scene, &request.edit.lens, size, request.settings.bits, job);
    save::pixels(target, &pixels.map_err(|error| sentence(&error))?, &options).map_err(|error| sentence(&error))
}

/// The picture at light-field size, by the CPU twins.
fn picture(request: &Request) -> crate::render::Picture {
    let Edit { lens, viewpoint } = request.edit;
    let depths = request.depths.as_deref();
    if lens.f_number.added_views() == 0.0 {
        return cpu::view_with_depths(&request.field, depths, viewpoint);
    }
    cpu::refocus_with_depths(&request.field, depths, &lens, viewpoint)
}

/// The dialog, while it is open. Returns false once it is to be closed.
pub fn dialog(app: &mut App, ctx: &egui::Context) -> bool {
    let colors = theme::palette(ctx);
    let mut is_open = true;
    let modal = widgets::modal(ctx, "export");
    let shown = modal.show(ctx, |ui| {
        ui.set_width(440.0);
        ui.spacing_mut().item_spacing.y = 2.0 * theme::GRID;
        ui.label(egui::RichText::new("Export").font(theme::title(16.0)).color(colors.strong));
        ui.add_space(theme::GRID);
        let settings = &mut app.settings.export;
        widgets::segmented(
            ui,
            "What",
            &mut settings.what,
            &[(What::Picture, "Picture"), (What::Views, "Views and ray depths")],
        );
        ui.add_space(theme::GRID);
        if settings.what == What::Picture {
            size_row(ui, app);
            format_rows(ui, &mut app.settings.export);
        }
        place_rows(ui, app);
        ui.add_space(2.0 * theme::GRID);
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if widgets::main_button(ui, "Export").clicked() {
                app.start_export();
                is_open = false;
            }
            if widgets::button(ui, "Cancel").clicked() {
                is_open = false;
            }
        });
    });
    is_open && !shown.should_close()
}

fn size_row(ui: &mut egui::Ui, app: &mut App) {
    let has_photo = app.document.photo.is_some() && app.edit.viewpoint == ViewPoint::default();
    let views = app.document.field.as_ref().map_or([0, 0], |field| field.size());
    let size = &mut app.settings.export.size;
    widgets::labelled(ui, "Size", |ui| {
        if !has_photo {
            let text = format!("{} × {} — that of the views", views[0], views[1]);
            ui.label(text).on_hover_text("Away from the centre only the views know the picture");
            return;
        }
        let custom = if let Size::LongSide(side) = *size { side } else { 2048 };
        let choices = [(Size::Photo, "Photo"), (Size::LongSide(custom), "Long side"), (Size::Views, "Views")];
        widgets::segmented(ui, "Size", size, &choices);
        match size {
            Size::LongSide(side) => {
                ui.add(egui::DragValue::new(side).range(16..=60_000).speed(8).suffix(" px"));
            }
            Size::Views => {
                ui.weak(format!("{} × {}", views[0], views[1]));
            }
            Size::Photo => {
                ui.weak(app.document.photo.as_ref().map_or(String::new(), |photo| {
                    let [w, h] = photo.size();
                    format!("{w} × {h}")
                }));
            }
        }
    });
}

fn format_rows(ui: &mut egui::Ui, settings: &mut ExportSettings) {
    widgets::labelled(ui, "Format", |ui| {
        let names = ["JPEG", "PNG", "TIFF", "WebP"];
        let choices: Vec<_> = ExportSettings::SUFFIXES.into_iter().map(str::to_owned).zip(names).collect();
        widgets::segmented(ui, "Format", &mut settings.suffix, &choices);
    });
    if settings.suffix == "jpg" {
        widgets::labelled(ui, "Quality", |ui| {
            ui.add(egui::DragValue::new(&mut settings.quality).range(1..=100).suffix(" %"));
        });
    }
    let has_16_bits = Format::of(Path::new(&format!("x.{}", settings.suffix))).is_some_and(Format::has_16_bits);
    if has_16_bits {
        widgets::labelled(ui, "Depth", |ui| {
            widgets::segmented(ui, "Depth", &mut settings.bits, &[(8, "8 bits"), (16, "16 bits")]);
        });
    } else {
        settings.bits = 8;
    }
    widgets::labelled(ui, "Metadata", |ui| {
        ui.checkbox(&mut settings.keeps_metadata, "Keep");
        ui.add_enabled(settings.keeps_metadata, egui::Checkbox::new(&mut settings.keeps_place, "with the place"));
    });
}

fn place_rows(ui: &mut egui::Ui, app: &mut App) {
    let target = app.settings.export.target(&app.document, &app.edit);
    widgets::labelled(ui, "Name", |ui| {
        let edit = egui::TextEdit::singleline(&mut app.settings.export.template).desired_width(f32::INFINITY);
        ui.add(edit).on_hover_text("{name}, {f} and {focus} are filled in");
    });
    widgets::labelled(ui, "Folder", |ui| {
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if widgets::button(ui, "Choose…").clicked() {
                app.ask(dialogs::Ask::Folder { folder: target.parent().map(Path::to_owned) });
            }
            let mut text = target.parent().unwrap_or(Path::new("")).display().to_string();
            let edit = egui::TextEdit::singleline(&mut text).desired_width(f32::INFINITY);
            if ui.add(edit).changed() {
                app.settings.export.folder = Some(PathBuf::from(text));
            }
        });
    });
    let existing = &mut app.settings.export.existing;
    widgets::labelled(ui, "If it exists", |ui| {
        widgets::segmented(
            ui,
            "If it exists",
            existing,
            &[(Existing::Number, "Add a number"), (Existing::Replace, "Replace")],
        );
    });
    let name = target.file_name().unwrap_or_default().to_string_lossy().into_owned();
    widgets::labelled(ui, "", |ui| {
        ui.add(egui::Label::new(egui::RichText::new(name).small().weak()).truncate());
    });
}
