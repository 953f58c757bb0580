//! Training on one's own light fields: the curves of its losses, the contact sheet, and what can be done with it.

use std::collections::BTreeMap;

use egui::{Color32, Context, RichText, Sense, Stroke, Ui, WidgetInfo, pos2, vec2};

use crate::ui::action::Action;
use crate::ui::ask::Ask;
use crate::ui::training::{Training, Wanted};
use crate::ui::words::t;
use crate::ui::{theme, widgets};

const WIDTH: f32 = 640.0;
const CURVES_HEIGHT: f32 = 120.0;
const SHEET_HEIGHT: f32 = 320.0;
/// Losses that have a curve: views, those before the occlusion net, how far ray depths disagree.
const SHOWN: [&str; 3] = ["full", "lambertian", "consistency"];

/// Draws the dialog.
pub fn show(training: &Training, has_photo: bool, ctx: &Context) -> Vec<Action> {
    let colors = theme::palette(ctx);
    let mut actions = Vec::new();
    let shown = widgets::modal(ctx, "training").show(ctx, |ui| {
        ui.set_width(WIDTH.min(ctx.content_rect().width() - 6.0 * theme::GRID));
        ui.spacing_mut().item_spacing.y = 2.0 * theme::GRID;
        ui.label(RichText::new(t!("training")).font(theme::title(16.0)).color(colors.strong));
        ui.label(RichText::new(stands(training)).color(colors.weak));
        if !training.told.losses.is_empty() {
            curves(&training.told.losses, ui);
        }
        if let Some(sheet) = &training.sheet {
            ui.label(RichText::new(t!("training-sheet")).small().color(colors.weak));
            egui::ScrollArea::vertical().max_height(SHEET_HEIGHT).show(ui, |ui| {
                let scale = (ui.available_width() / sheet.size_vec2().x).min(1.0);
                let image = egui::Image::new((sheet.id(), sheet.size_vec2() * scale));
                ui.add(image.alt_text(t!("training-sheet")));
            });
        }
        ui.horizontal(|ui| buttons(training, has_photo, ui, &mut actions));
    });
    if shown.should_close() {
        actions.push(Action::CloseDialog);
    }
    actions
}

/// Where the run stands, in a line.
fn stands(training: &Training) -> String {
    let name = training.run.as_ref().and_then(|run| run.data.file_name()).unwrap_or_default().to_string_lossy();
    let name = &*name;
    let [step, all] = training.told.steps;
    match training.running {
        _ if training.run.is_none() => t!("training-what").to_owned(),
        Some((_, true)) => t!("training-ends", name = name, step = step),
        Some((_, false)) if step == 0 => t!("training-begins", name = name),
        Some((_, false)) => t!("training-runs", name = name, step = step, all = all),
        None if step == 0 => t!("training-waits", name = name),
        None => t!("training-rests", name = name, step = step, all = all),
    }
}

fn buttons(training: &Training, has_photo: bool, ui: &mut Ui, actions: &mut Vec<Action>) {
    let mut button = |ui: &mut Ui, is_possible: bool, text: &str, action: Action| {
        ui.add_enabled_ui(is_possible, |ui| {
            if widgets::button(ui, text).clicked() {
                actions.push(action);
            }
        });
    };
    let (is_running, step) = (training.is_running(), training.told.steps[0]);
    button(ui, !is_running, t!("training-choose"), Action::Ask(Ask::LightFields));
    match training.running {
        Some((_, is_ending)) => button(ui, !is_ending, t!("training-pause"), Action::Train(Wanted::Rest)),
        None => {
            let text = if step == 0 { t!("training-start") } else { t!("training-go-on") };
            button(ui, training.run.is_some(), text, Action::Train(Wanted::Train));
        }
    }
    let is_usable = has_photo && !is_running && step > 0;
    button(ui, is_usable, t!("training-use"), Action::Train(Wanted::Use));
    button(ui, true, t!("close"), Action::CloseDialog);
}

/// The losses, each over its own range, the latest value beside its name.
fn curves(losses: &BTreeMap<String, Vec<[f32; 2]>>, ui: &mut Ui) {
    let colors = theme::palette(ui.ctx());
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), CURVES_HEIGHT), Sense::hover());
    ui.painter().rect_filled(rect, theme::RADIUS - 2, colors.well);
    let shown = SHOWN.iter().filter_map(|name| losses.get_key_value(*name)).zip(theme::CHANNELS);
    let mut said = Vec::new();
    let mut legend: Vec<(String, Color32)> = Vec::new();
    for ((name, curve), color) in shown {
        let (first, last) = (curve[0], curve[curve.len() - 1]);
        let most = curve.iter().map(|[_, value]| *value).fold(f32::MIN_POSITIVE, f32::max);
        let at = |[step, value]: &[f32; 2]| {
            let along = (step - first[0]) / (last[0] - first[0]).max(1.0);
            let inner = rect.shrink(3.0);
            pos2(inner.left() + along * inner.width(), inner.bottom() - value / most * inner.height())
        };
        ui.painter().line(curve.iter().map(at).collect(), Stroke::new(1.4, color));
        said.push(format!("{name} {:.4}", last[1]));
        legend.push((format!("{name} {:.4}", last[1]), color));
    }
    response.widget_info(|| WidgetInfo::labeled(egui::Role::Image, true, t!("training-said", text = said.join(", "))));
    ui.horizontal(|ui| {
        for (text, color) in &legend {
            let (mark, _) = ui.allocate_exact_size(vec2(theme::GRID * 2.0, theme::GRID * 2.0), Sense::hover());
            ui.painter().rect_filled(mark, 1, *color);
            ui.label(RichText::new(text).small().color(colors.weak));
        }
    });
}
