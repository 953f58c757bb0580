//! Inspector sections: where ray depths come from, and what the light field is.

use egui::{Align, Label, Layout, RichText, Ui};

use crate::ui::action::Action;
use crate::ui::app::App;
use crate::ui::state::Source;
use crate::ui::{theme, widgets};

/// Where a photo's ray depths come from.
pub fn source(app: &mut App, ui: &mut Ui) {
    if app.document.is_from_disk() {
        return;
    }
    let mut choices = vec![(Source::Network, "Network".to_owned())];
    if app.document.phone.is_some() {
        choices.extend([(Source::Phone, "Phone".to_owned()), (Source::Fused, "Fused".to_owned())]);
    }
    if app.document.own_map.is_some() {
        choices.push((Source::Map, "Your map".to_owned()));
    }
    let is_model = |source: &Source| matches!(source, Source::Model(_));
    // A source that this photo has not is the network, until a photo comes that has it.
    let wanted = app.settings.source.clone();
    let is_there = choices.iter().any(|(choice, _)| *choice == wanted) || is_model(&wanted);
    let mut source = if is_there { wanted } else { Source::Network };
    let before = source.clone();
    let mut action = None;
    let ctx = ui.ctx().clone();
    let models = app.models.clone();
    widgets::section(
        ui,
        "Source of ray depths",
        |ui| {
            if widgets::link(ui, "depth map…").on_hover_text(Action::OwnDepth.tip(&ctx)).clicked() {
                action = Some(Action::OwnDepth);
            }
        },
        |ui| {
            if choices.len() > 1 {
                widgets::segmented(ui, "Source", &mut source, &choices);
            }
            if !models.is_empty() {
                model_menu(ui, &mut source, &models);
            } else if choices.len() == 1 {
                row(ui, "Estimated by", "network");
            }
        },
    );
    if source != before {
        app.set_source(source);
    }
    if let Some(action) = action {
        app.apply(action, &ctx);
    }
}

/// Further models, where the models folder holds some.
fn model_menu(ui: &mut Ui, source: &mut Source, models: &[String]) {
    let colors = theme::palette(ui.ctx());
    ui.horizontal(|ui| {
        ui.label(RichText::new("Model").color(colors.weak));
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let name = match &*source {
                Source::Model(id) => id.as_str(),
                _ => "built-in",
            };
            ui.menu_button(RichText::new(format!("{name} ▼")).color(colors.strong), |ui| {
                if ui.selectable_label(!matches!(source, Source::Model(_)), "built-in").clicked() {
                    *source = Source::Network;
                    ui.close();
                }
                for id in models {
                    let choice = Source::Model(id.clone());
                    if ui.selectable_label(*source == choice, id).clicked() {
                        *source = choice;
                        ui.close();
                    }
                }
            });
        });
    });
}

/// What the light field is; of one from disk also how it was laid out.
pub fn light_field(app: &mut App, ui: &mut Ui) {
    let Some(field) = app.document.field.clone() else { return };
    let (grid, [w, h]) = (field.grid(), field.size());
    let ctx = ui.ctx().clone();
    let mut action = None;
    widgets::section(
        ui,
        "Light field",
        |_| {},
        |ui| {
            row(ui, &format!("{} × {} views", grid.cols(), grid.rows()), &format!("{w} × {h} px"));
            row(ui, "Made by", &app.document.made_by);
            if app.document.took_secs > 0.0 && !app.document.is_from_disk() {
                row(ui, "Took", &format!("{:.1} s", app.document.took_secs));
            }
            if app.document.is_from_disk() {
                action = layout_rows(app, ui, &ctx);
            }
        },
    );
    if let Some(action) = action {
        app.apply(action, &ctx);
    }
}

/// How the stored views were turned to fit, and what a person can turn over.
fn layout_rows(app: &App, ui: &mut Ui, ctx: &egui::Context) -> Option<Action> {
    let layout = app.document.layout;
    row(ui, "Views lie", &layout.to_string());
    // Turning both ways at once changes nothing but the sign.
    let toggles = [
        (Action::Opposite, layout.flip_u),
        (Action::Transpose, layout.transposed),
        (Action::Serpentine, layout.serpentine),
    ];
    let mut action = None;
    for (toggle, mut is_on) in toggles {
        if widgets::switch(ui, toggle.spec().label, &mut is_on, &toggle.tip(ctx)) {
            action = Some(toggle);
        }
    }
    action
}

fn row(ui: &mut Ui, name: &str, value: &str) {
    let colors = theme::palette(ui.ctx());
    ui.horizontal(|ui| {
        ui.label(RichText::new(name).color(colors.weak));
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            ui.add(Label::new(RichText::new(value).color(colors.strong)).truncate()).on_hover_text(value);
        });
    });
}
