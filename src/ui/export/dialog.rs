//! The export dialog: what on the left, how and where on the right.

use std::path::{Path, PathBuf};

use egui::{Context, RichText, Ui, vec2};

use super::super::app::App;
use super::super::{dialogs, theme, widgets};
use super::{Existing, ExportSettings, Moving, What};
use crate::io::formats::quilt;
use crate::io::save::{Format, Keep};
use crate::recipe::OutputSize;

const WIDTH: f32 = 700.0;
const LIST_WIDTH: f32 = 176.0;
/// Room for the longest kind's rows, so that the dialog does not change its size with each choice.
const HEIGHT: f32 = 400.0;

/// Draws the dialog. Returns false once it is to be closed.
pub fn show(app: &mut App, ctx: &Context) -> bool {
    let colors = theme::palette(ctx);
    let photos = app.photos_to_export.len();
    let mut is_open = true;
    let modal = widgets::modal(ctx, "export");
    let shown = modal.show(ctx, |ui| {
        ui.set_width(WIDTH.min(ctx.content_rect().width() - 80.0));
        ui.spacing_mut().item_spacing.y = 2.0 * theme::GRID;
        let title = if photos > 0 { format!("Export {photos} photos") } else { "Export".to_owned() };
        ui.label(RichText::new(title).font(theme::title(16.0)).color(colors.strong));
        ui.add_space(theme::GRID);
        let room = (ctx.content_rect().height() - 150.0).max(120.0);
        egui::ScrollArea::vertical().max_height(room).min_scrolled_height(room).show(ui, |ui| body(ui, app));
        ui.add_space(theme::GRID);
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
    let stays = is_open && !shown.should_close();
    if !stays {
        app.photos_to_export.clear();
    }
    stays
}

/// What on the left, how and where on the right.
fn body(ui: &mut Ui, app: &mut App) {
    let colors = theme::palette(ui.ctx());
    ui.horizontal_top(|ui| {
        ui.spacing_mut().item_spacing.x = 5.0 * theme::GRID;
        ui.vertical(|ui| {
            ui.set_width(LIST_WIDTH);
            ui.set_min_height(HEIGHT);
            kinds(ui, &mut app.settings.export.what);
        });
        ui.vertical(|ui| {
            ui.set_width(ui.available_width());
            ui.spacing_mut().item_spacing.y = 2.0 * theme::GRID;
            let (_, hint) = app.settings.export.what.spec();
            ui.label(RichText::new(hint).color(colors.weak));
            ui.add_space(theme::GRID);
            rows(ui, app);
            place_rows(ui, app);
        });
    });
}

fn kinds(ui: &mut Ui, what: &mut What) {
    let colors = theme::palette(ui.ctx());
    ui.spacing_mut().item_spacing.y = 1.0;
    for (group, all) in What::GROUPS {
        ui.label(RichText::new(group).font(theme::head()).color(colors.weak));
        ui.add_space(2.0);
        for kind in all {
            let (label, hint) = kind.spec();
            let is_chosen = kind == what;
            let text = RichText::new(label).color(if is_chosen { colors.strong } else { colors.text });
            let fill = if is_chosen { colors.hovered } else { egui::Color32::TRANSPARENT };
            let button = egui::Button::new(text).fill(fill).min_size(vec2(LIST_WIDTH, 24.0)).right_text("");
            if ui.add(button).on_hover_text(hint).clicked() {
                *what = *kind;
            }
        }
        ui.add_space(2.0 * theme::GRID);
    }
}

/// What the kind asks for.
fn rows(ui: &mut Ui, app: &mut App) {
    let settings = &mut app.settings.export;
    match settings.what {
        What::Picture => {
            size_row(ui, app);
            format_rows(ui, &mut app.settings.export);
        }
        What::FocalStack => {
            frames_row(ui, settings, false);
            size_row(ui, app);
        }
        What::Animation => animation_rows(ui, settings),
        What::SideBySide | What::Anaglyph => {
            widgets::labelled(ui, "Eyes apart", |ui| {
                let drag = egui::DragValue::new(&mut settings.eyes_apart).range(0.5..=7.0).speed(0.02);
                ui.add(drag.max_decimals(1).suffix(" views"));
                ui.weak("more is deeper");
            });
        }
        What::Quilt => {
            widgets::labelled(ui, "Display", |ui| {
                let names: Vec<_> = quilt::DEVICES.iter().map(|device| device.name).enumerate().collect();
                widgets::segmented(ui, "Display", &mut settings.device, &names);
            });
            let [[cols, rows], [w, h]] = [settings.device().grid, settings.device().size];
            widgets::labelled(ui, "", |ui| {
                ui.weak(format!("{} viewpoints in {cols} × {rows} tiles, {w} × {h} px", cols * rows));
            });
        }
        What::Views | What::Eslf | What::Hci | What::Stanford => {
            if let Some(field) = &app.document.field {
                let (grid, [w, h]) = (field.grid(), field.size());
                widgets::labelled(ui, "Holds", |ui| {
                    ui.weak(format!("{} × {} views of {w} × {h} px", grid.cols(), grid.rows()));
                });
            }
        }
        What::DepthPng | What::DepthPfm | What::Gdepth | What::Ply => {
            if let Some(depths) = &app.document.depths {
                let [w, h] = depths.size();
                widgets::labelled(ui, "Size", |ui| {
                    ui.weak(format!("{w} × {h} px, that of the views"));
                });
            }
        }
    }
}

fn frames_row(ui: &mut Ui, settings: &mut ExportSettings, is_animation: bool) {
    widgets::labelled(ui, "Frames", |ui| {
        ui.add(egui::DragValue::new(&mut settings.frames).range(2..=200).speed(0.2));
        if is_animation {
            let rate = egui::DragValue::new(&mut settings.frames_per_second).range(1..=50).speed(0.1);
            ui.add(rate.suffix(" a second"));
            let secs = f32::from(settings.frames) / f32::from(settings.frames_per_second.max(1));
            ui.weak(format!("{secs:.1} s"));
        }
    });
}

fn animation_rows(ui: &mut Ui, settings: &mut ExportSettings) {
    widgets::labelled(ui, "Moves", |ui| {
        let all = [(Moving::Focus, "Focus"), (Moving::Aperture, "Aperture"), (Moving::Viewpoint, "Viewpoint")];
        widgets::segmented(ui, "Moves", &mut settings.moving, &all);
    });
    frames_row(ui, settings, true);
    widgets::labelled(ui, "Long side", |ui| {
        ui.add(egui::DragValue::new(&mut settings.animation_px).range(64..=4096).speed(4).suffix(" px"));
    });
    widgets::labelled(ui, "Format", |ui| {
        let all = [("gif", "GIF"), ("apng", "APNG"), ("webp", "WebP")].map(|(suffix, name)| (suffix.to_owned(), name));
        widgets::segmented(ui, "Format", &mut settings.animation, &all);
    });
}

fn size_row(ui: &mut Ui, app: &mut App) {
    let photo = app.document.photo.as_ref().map(|photo| photo.size());
    let views = app.document.field.as_ref().map_or([0, 0], |field| field.size());
    let size = &mut app.settings.export.picture.size;
    widgets::labelled(ui, "Size", |ui| {
        let Some(photo) = photo else {
            let text = format!("{} × {} px, that of the views", views[0], views[1]);
            ui.weak(text);
            return;
        };
        let custom = if let OutputSize::LongSide(side) = *size { side } else { 2048 };
        let choices = [(OutputSize::Photo, "Photo"), (OutputSize::LongSide(custom), "Long side")];
        widgets::segmented(ui, "Size", size, &choices);
        if let OutputSize::LongSide(side) = size {
            ui.add(egui::DragValue::new(side).range(16..=60_000).speed(8).suffix(" px"));
        }
        let [w, h] = size.of(photo);
        ui.weak(format!("{w} × {h} px"));
    });
}

fn format_rows(ui: &mut Ui, settings: &mut ExportSettings) {
    let settings = &mut settings.picture;
    widgets::labelled(ui, "Format", |ui| {
        let all = [(Format::Jpeg, "JPEG"), (Format::Png, "PNG"), (Format::Tiff, "TIFF"), (Format::WebP, "WebP")];
        widgets::segmented(ui, "Format", &mut settings.format, &all);
    });
    if settings.format == Format::Jpeg {
        widgets::labelled(ui, "Quality", |ui| {
            ui.add(egui::DragValue::new(&mut settings.quality).range(1..=100).suffix(" %"));
        });
    }
    if settings.format.has_16_bits() {
        widgets::labelled(ui, "Depth", |ui| {
            widgets::segmented(ui, "Depth", &mut settings.bits, &[(8, "8 bits"), (16, "16 bits")]);
        });
    }
    widgets::labelled(ui, "Metadata", |ui| {
        let all = [(Keep::All, "Keep all"), (Keep::WithoutPosition, "Without the place"), (Keep::Nothing, "Drop all")];
        widgets::segmented(ui, "Metadata", &mut settings.keep, &all);
    });
}

fn place_rows(ui: &mut Ui, app: &mut App) {
    if app.settings.export.what == What::Picture {
        widgets::labelled(ui, "Name", |ui| {
            let name = &mut app.settings.export.picture.name;
            let edit = egui::TextEdit::singleline(name).desired_width(f32::INFINITY);
            ui.add(edit).on_hover_text("{name}, {f} and {focus} are filled in");
        });
    }
    let target = app.export_target();
    widgets::labelled(ui, "Folder", |ui| {
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if widgets::button(ui, "Choose…").clicked() {
                app.ask(dialogs::Ask::Folder { folder: target.parent().map(Path::to_owned) });
            }
            if app.settings.export.folder.is_some()
                && widgets::button(ui, "Beside photo").on_hover_text("Write beside each photo").clicked()
            {
                app.settings.export.folder = None;
            }
            let mut text = target.parent().unwrap_or(Path::new("")).display().to_string();
            let edit = egui::TextEdit::singleline(&mut text).desired_width(f32::INFINITY);
            if ui.add(edit).changed() {
                app.settings.export.folder = Some(PathBuf::from(text));
            }
        });
    });
    widgets::labelled(ui, "If it exists", |ui| {
        let all = [(Existing::Number, "Add a number"), (Existing::Replace, "Replace"), (Existing::Leave, "Leave it")];
        widgets::segmented(ui, "If it exists", &mut app.settings.export.existing, &all);
    });
    let name = target.file_name().unwrap_or_default().to_string_lossy().into_owned();
    widgets::labelled(ui, "Writes", |ui| {
        ui.add(egui::Label::new(RichText::new(name).weak()).truncate());
    });
}
