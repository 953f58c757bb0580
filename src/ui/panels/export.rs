//! The export dialog: what on the left, how and where on the right.

use std::path::{Path, PathBuf};

use egui::{Context, RichText, Ui, vec2};

use crate::io::formats::quilt;
use crate::io::save::{Format, Keep};
use crate::scene::export::{Existing, Group, KINDS, Kind, Settings};
use crate::scene::{Edit, Embed, Movement, OutputSize};
use crate::ui::action::Action;
use crate::ui::ask::Ask;
use crate::ui::open::Open;
use crate::ui::words::{self, heard, t};
use crate::ui::{theme, widgets};

const WIDTH: f32 = 700.0;
const LIST_WIDTH: f32 = 176.0;
/// Room for the longest kind's rows, so that the dialog does not change its size with each choice.
const HEIGHT: f32 = 400.0;

/// What the dialog shows and sets.
pub struct Export<'a> {
    /// What it said last.
    pub settings: &'a mut Settings,
    /// The photos it is about; none where that is what is open.
    pub photos: &'a [PathBuf],
    /// What is open.
    pub open: &'a Open,
    /// What is done to it.
    pub edit: &'a Edit,
}

/// Draws the dialog.
pub fn show(mut export: Export, ctx: &Context) -> Vec<Action> {
    let colors = theme::palette(ctx);
    let mut actions = Vec::new();
    let is_enter = widgets::takes_enter(ctx);
    let modal = widgets::modal(ctx, "export");
    let shown = modal.show(ctx, |ui| {
        ui.set_width(WIDTH.min(ctx.content_rect().width() - 80.0));
        ui.spacing_mut().item_spacing.y = 2.0 * theme::GRID;
        let count = export.photos.len();
        let title = if count > 0 { t!("export-photos", count = count) } else { t!("export").to_owned() };
        ui.label(RichText::new(title).font(theme::title(16.0)).color(colors.strong));
        ui.add_space(theme::GRID);
        let room = (ctx.content_rect().height() - 150.0).max(120.0);
        let scroll = egui::ScrollArea::vertical().max_height(room).min_scrolled_height(room);
        actions.extend(scroll.show(ui, |ui| body(ui, &mut export)).inner);
        ui.add_space(theme::GRID);
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if widgets::main_button(ui, t!("export")).clicked() || is_enter {
                actions.extend([Action::CloseDialog, Action::StartExport(export.photos.to_vec())]);
            }
            if widgets::button(ui, t!("cancel")).clicked() {
                actions.push(Action::CloseDialog);
            }
        });
    });
    if shown.should_close() {
        actions.push(Action::CloseDialog);
    }
    actions
}

/// What on the left, how and where on the right.
fn body(ui: &mut Ui, export: &mut Export) -> Option<Action> {
    let colors = theme::palette(ui.ctx());
    let columns = ui.horizontal_top(|ui| {
        ui.spacing_mut().item_spacing.x = 5.0 * theme::GRID;
        ui.vertical(|ui| {
            ui.set_width(LIST_WIDTH);
            ui.set_min_height(HEIGHT);
            kinds(ui, &mut export.settings.kind);
        });
        let right = ui.vertical(|ui| {
            ui.set_width(ui.available_width());
            ui.spacing_mut().item_spacing.y = 2.0 * theme::GRID;
            ui.label(RichText::new(heard(export.settings.kind.spec().hint)).color(colors.weak));
            ui.add_space(theme::GRID);
            rows(ui, export);
            place_rows(ui, export)
        });
        right.inner
    });
    columns.inner
}

fn kinds(ui: &mut Ui, kind: &mut Kind) {
    let colors = theme::palette(ui.ctx());
    ui.spacing_mut().item_spacing.y = 1.0;
    for (group, heading) in Group::ALL {
        ui.label(RichText::new(heard(heading)).font(theme::head()).color(colors.weak));
        ui.add_space(2.0);
        for spec in KINDS.iter().filter(|spec| spec.group == group) {
            let is_chosen = spec.kind == *kind;
            let text = RichText::new(heard(spec.label)).color(if is_chosen { colors.strong } else { colors.text });
            let fill = if is_chosen { colors.hovered } else { egui::Color32::TRANSPARENT };
            let button = egui::Button::new(text).fill(fill).min_size(vec2(LIST_WIDTH, 24.0)).right_text("");
            if ui.add(button).on_hover_text(heard(spec.hint)).clicked() {
                *kind = spec.kind;
            }
        }
        ui.add_space(2.0 * theme::GRID);
    }
}

/// What the kind asks for.
fn rows(ui: &mut Ui, export: &mut Export) {
    let Export { settings, open, .. } = export;
    match settings.kind {
        Kind::Picture => {
            size_row(ui, settings, open);
            format_rows(ui, settings);
        }
        Kind::Living => size_row(ui, settings, open),
        Kind::FocalStack => {
            pictures_row(ui, settings);
            size_row(ui, settings, open);
        }
        Kind::Animation => animation_rows(ui, settings),
        Kind::Video | Kind::Frames => film_rows(ui, settings),
        Kind::SideBySide | Kind::Mpo | Kind::Spatial | Kind::Anaglyph => {
            size_row(ui, settings, open);
            widgets::labelled(ui, t!("eyes-apart"), |ui| {
                let drag = egui::DragValue::new(&mut settings.eyes_apart).range(0.0..=16.0).speed(0.02);
                ui.add(widgets::spoken(drag).max_decimals(1).suffix(t!("suffix-views")));
                ui.weak(t!("more-is-deeper"));
            });
        }
        Kind::Quilt => {
            widgets::labelled(ui, t!("display"), |ui| {
                egui::ComboBox::from_id_salt("display").selected_text(settings.device().name).show_ui(ui, |ui| {
                    for (place, device) in quilt::DEVICES.iter().enumerate() {
                        ui.selectable_value(&mut settings.device, place, device.name);
                    }
                });
            });
            let [[cols, rows], [w, h]] = [settings.device().grid, settings.device().size];
            widgets::labelled(ui, "", |ui| {
                ui.weak(t!("quilt-holds", count = cols * rows, cols = cols, rows = rows, width = w, height = h));
            });
        }
        Kind::Views | Kind::Eslf | Kind::Hci | Kind::Stanford => {
            if let Some(field) = open.field() {
                let (grid, [w, h]) = (field.grid(), field.size());
                widgets::labelled(ui, t!("holds"), |ui| {
                    ui.weak(t!("views-of", cols = grid.cols(), rows = grid.rows(), width = w, height = h));
                });
            }
        }
        Kind::DepthPng | Kind::DepthPfm | Kind::Gdepth | Kind::Ply | Kind::Gaussians => {
            if let Some(rays) = open.rays() {
                let [w, h] = rays.depths.size();
                widgets::labelled(ui, t!("size"), |ui| {
                    ui.weak(t!("size-of-views", width = w, height = h));
                });
            }
        }
    }
}

/// How many pictures a stack has.
fn pictures_row(ui: &mut Ui, settings: &mut Settings) {
    widgets::labelled(ui, t!("frames"), |ui| {
        ui.add(egui::DragValue::new(&mut settings.frames).range(2..=Settings::MOST_PICTURES).speed(0.2));
    });
}

/// How many frames an animation or a film has, and how many a second. A timeline says how long it is.
fn frames_row(ui: &mut Ui, settings: &mut Settings) {
    let is_timed = settings.movement == Movement::Timeline && settings.timeline.is_some();
    let (count, rate_before) = settings.frames_and_rate();
    let (frames, rate) = match settings.kind {
        Kind::Animation => (&mut settings.frames, &mut settings.frames_per_second),
        _ => (&mut settings.film.frames, &mut settings.film.frames_per_second),
    };
    widgets::labelled(ui, t!("frames"), |ui| {
        if is_timed {
            ui.weak(count.to_string());
        } else {
            ui.add(egui::DragValue::new(frames).range(2..=Settings::MOST_FRAMES).speed(0.2));
        }
        ui.add(egui::DragValue::new(rate).range(1..=50).speed(0.1).suffix(t!("suffix-a-second")));
        ui.weak(t!("seconds", secs = words::fixed(f32::from(count) / f32::from(rate_before.max(1)), 1)));
    });
}

/// What moves: one of a list, of which the last needs a timeline.
fn movement_row(ui: &mut Ui, settings: &mut Settings) {
    widgets::labelled(ui, t!("moves"), |ui| {
        let name =
            |wanted: Movement| Movement::ALL.iter().find(|(movement, ..)| *movement == wanted).map_or("", |m| m.2);
        let chosen = egui::ComboBox::from_id_salt("moves").selected_text(heard(name(settings.movement)));
        chosen.show_ui(ui, |ui| {
            let has_timeline = settings.timeline.is_some();
            for (movement, _, label, hint) in Movement::ALL {
                if movement != Movement::Timeline || has_timeline {
                    ui.selectable_value(&mut settings.movement, movement, heard(label)).on_hover_text(heard(hint));
                }
            }
        });
    });
}

fn film_rows(ui: &mut Ui, settings: &mut Settings) {
    movement_row(ui, settings);
    frames_row(ui, settings);
    let is_film = settings.kind == Kind::Video;
    let film = &mut settings.film;
    widgets::labelled(ui, t!("fits-into"), |ui| {
        let all = [[1280, 720], [1920, 1080], [3840, 2160]].map(|size| (OutputSize::Within(size), size[1]));
        let names = all.map(|(size, height)| (size, format!("{height}p")));
        let names: Vec<_> = names.iter().map(|(size, name)| (*size, name.as_str())).collect();
        widgets::segmented(ui, t!("fits-into"), &mut film.size, &names);
    });
    if !is_film {
        return;
    }
    widgets::labelled(ui, t!("format"), |ui| {
        let all = [("mp4", "MP4"), ("webm", "WebM")].map(|(ending, name)| (ending.to_owned(), name));
        widgets::segmented(ui, t!("format"), &mut film.ending, &all);
    });
}

fn animation_rows(ui: &mut Ui, settings: &mut Settings) {
    movement_row(ui, settings);
    frames_row(ui, settings);
    widgets::labelled(ui, t!("long-side"), |ui| {
        let mut side = match settings.animation_size {
            OutputSize::LongSide(side) => side,
            _ => Settings::ANIMATION_PX,
        };
        if ui.add(egui::DragValue::new(&mut side).range(64..=4096).speed(4).suffix(t!("suffix-px"))).changed() {
            settings.animation_size = OutputSize::LongSide(side);
        }
    });
    widgets::labelled(ui, t!("format"), |ui| {
        let all = [("gif", "GIF"), ("apng", "APNG"), ("webp", "WebP")].map(|(suffix, name)| (suffix.to_owned(), name));
        widgets::segmented(ui, t!("format"), &mut settings.animation, &all);
    });
}

fn size_row(ui: &mut Ui, settings: &mut Settings, open: &Open) {
    let photo = open.photo().map(|photo| photo.whole_size());
    let views = open.field().map_or([0, 0], |field| field.size());
    let size = &mut settings.picture.size;
    widgets::labelled(ui, t!("size"), |ui| {
        let Some(photo) = photo else {
            let text = t!("size-of-views", width = views[0], height = views[1]);
            ui.weak(text);
            return;
        };
        let custom = if let OutputSize::LongSide(side) = *size { side } else { 2048 };
        let choices = [(OutputSize::Photo, t!("photo")), (OutputSize::LongSide(custom), t!("long-side"))];
        widgets::segmented(ui, t!("size"), size, &choices);
        if let OutputSize::LongSide(side) = size {
            ui.add(egui::DragValue::new(side).range(16..=60_000).speed(8).suffix(t!("suffix-px")));
        }
        let [w, h] = size.of(photo);
        ui.weak(t!("pixels", width = w, height = h));
    });
}

fn format_rows(ui: &mut Ui, settings: &mut Settings) {
    let settings = &mut settings.picture;
    widgets::labelled(ui, t!("format"), |ui| {
        let all = [(Format::Jpeg, "JPEG"), (Format::Png, "PNG"), (Format::Tiff, "TIFF"), (Format::WebP, "WebP")];
        widgets::segmented(ui, t!("format"), &mut settings.format, &all);
    });
    if settings.format == Format::Jpeg {
        widgets::labelled(ui, t!("quality"), |ui| {
            ui.add(egui::DragValue::new(&mut settings.quality).range(1..=100).suffix(" %"));
        });
    }
    if settings.format.has_16_bits() {
        widgets::labelled(ui, t!("bit-depth"), |ui| {
            widgets::segmented(ui, t!("bit-depth"), &mut settings.bits, &[(8, t!("bits-8")), (16, t!("bits-16"))]);
        });
    }
    widgets::labelled(ui, t!("metadata"), |ui| {
        let all = [
            (Keep::All, t!("keep-all")),
            (Keep::WithoutPosition, t!("without-place")),
            (Keep::Nothing, t!("drop-all")),
        ];
        widgets::segmented(ui, t!("metadata"), &mut settings.keep, &all);
    });
    let is_on = settings.keep != Keep::Nothing;
    let Embed { recipe, depth, photo } = &mut settings.embed;
    widgets::labelled(ui, t!("inside"), |ui| {
        let mut part = |value: &mut bool, name: &str, hint: &str| {
            let shown = ui.add_enabled(is_on, egui::Checkbox::new(value, name)).on_hover_text(hint);
            shown.on_disabled_hover_text(t!("inside-nothing"));
        };
        part(recipe, t!("inside-edit"), t!("inside-edit-hint"));
        part(depth, t!("inside-depth"), t!("inside-depth-hint"));
        part(photo, t!("photo"), t!("inside-photo-hint"));
    });
}

/// Name and folder; asks for a folder.
fn place_rows(ui: &mut Ui, export: &mut Export) -> Option<Action> {
    let Export { settings, photos, open, edit } = export;
    if settings.kind == Kind::Picture {
        widgets::labelled(ui, t!("name"), |ui| {
            let name = &mut settings.picture.name;
            let edit = egui::TextEdit::singleline(name).desired_width(f32::INFINITY);
            ui.add(edit).on_hover_text(t!("name-hint"));
        });
    }
    let target = match (photos.first(), open.document()) {
        (Some(path), _) => {
            let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
            settings.target(Some(path), &name, edit)
        }
        (None, Some(document)) => settings.target(document.path(), &document.subject.name, edit),
        (None, None) => PathBuf::new(),
    };
    let mut action = None;
    widgets::labelled(ui, t!("folder"), |ui| {
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if widgets::button(ui, t!("choose")).clicked() {
                action = Some(Action::Ask(Ask::Folder { folder: target.parent().map(Path::to_owned) }));
            }
            if settings.folder.is_some()
                && widgets::button(ui, t!("beside-photo")).on_hover_text(t!("beside-photo-hint")).clicked()
            {
                settings.folder = None;
            }
            let mut text = target.parent().unwrap_or(Path::new("")).display().to_string();
            let edit = egui::TextEdit::singleline(&mut text).desired_width(f32::INFINITY);
            if ui.add(edit).changed() {
                settings.folder = Some(PathBuf::from(text));
            }
        });
    });
    widgets::labelled(ui, t!("if-it-exists"), |ui| {
        let all = [
            (Existing::Number, t!("exists-number")),
            (Existing::Replace, t!("exists-replace")),
            (Existing::Leave, t!("exists-leave")),
        ];
        widgets::segmented(ui, t!("if-it-exists"), &mut settings.existing, &all);
    });
    let name = target.file_name().unwrap_or_default().to_string_lossy().into_owned();
    widgets::labelled(ui, t!("writes"), |ui| {
        ui.add(egui::Label::new(RichText::new(name).weak()).truncate());
    });
    action
}
