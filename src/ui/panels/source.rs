//! Inspector sections: where ray depths come from, and what the light field is.

use egui::{Align, Label, Layout, RichText, Ui};

use crate::scene::{Content, DepthFrom, Recorded};
use crate::ui::action::Action;
use crate::ui::command::Command;
use crate::ui::open::Open;
use crate::ui::{theme, widgets};

/// Where a photo's ray depths come from.
pub fn source(open: &Open, wanted: &DepthFrom, models: &[String], ui: &mut Ui) -> Option<Action> {
    let Content::Photo(one) = &open.subject()?.content else { return None };
    let mut choices = vec![(DepthFrom::Network, "Network".to_owned())];
    if one.phone.is_some() {
        choices.extend([(DepthFrom::Phone, "Phone".to_owned()), (DepthFrom::Fused, "Fused".to_owned())]);
    }
    if one.own_map.is_some() {
        choices.push((DepthFrom::Map, "Your map".to_owned()));
    }
    let is_model = |source: &DepthFrom| matches!(source, DepthFrom::Model(_));
    // A source that this photo has not is the network, until a photo comes that has it.
    let is_there = choices.iter().any(|(choice, _)| choice == wanted) || is_model(wanted);
    let mut source = if is_there { wanted.clone() } else { DepthFrom::Network };
    let before = source.clone();
    let mut action = None;
    let ctx = ui.ctx().clone();
    widgets::section(
        ui,
        "Source of ray depths",
        |ui| {
            if widgets::link(ui, "depth map…").on_hover_text(Command::OwnDepth.tip(&ctx)).clicked() {
                action = Some(Action::Do(Command::OwnDepth));
            }
        },
        |ui| {
            if choices.len() > 1 {
                widgets::segmented(ui, "Source", &mut source, &choices);
            }
            if !models.is_empty() {
                model_menu(ui, &mut source, models);
            } else if choices.len() == 1 {
                row(ui, "Estimated by", "network");
            }
        },
    );
    if source != before { Some(Action::TakeDepths(source)) } else { action }
}

/// Further models, where the models folder holds some.
fn model_menu(ui: &mut Ui, source: &mut DepthFrom, models: &[String]) {
    let colors = theme::palette(ui.ctx());
    ui.horizontal(|ui| {
        ui.label(RichText::new("Model").color(colors.weak));
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let name = match &*source {
                DepthFrom::Model(id) => id.as_str(),
                _ => "built-in",
            };
            ui.menu_button(RichText::new(format!("{name} ▼")).color(colors.strong), |ui| {
                if ui.selectable_label(!matches!(source, DepthFrom::Model(_)), "built-in").clicked() {
                    *source = DepthFrom::Network;
                    ui.close();
                }
                for id in models {
                    let choice = DepthFrom::Model(id.clone());
                    if ui.selectable_label(*source == choice, id).clicked() {
                        *source = choice;
                        ui.close();
                    }
                }
            });
        });
    });
}

/// What the light field is; of a recorded one also how it was laid out.
pub fn light_field(open: &Open, ui: &mut Ui) -> Option<Action> {
    let field = open.field()?;
    let (grid, [w, h]) = (field.grid(), field.size());
    let mut action = None;
    widgets::section(
        ui,
        "Light field",
        |_| {},
        |ui| {
            row(ui, &format!("{} × {} views", grid.cols(), grid.rows()), &format!("{w} × {h} px"));
            match (open.subject().and_then(|subject| subject.recorded()), open.scene()) {
                (Some(recorded), _) => {
                    row(ui, "Made by", "from disk");
                    action = layout_rows(recorded, ui);
                }
                (None, Some(scene)) => {
                    row(ui, "Made by", &scene.made_by());
                    row(ui, "Took", &format!("{:.1} s", scene.took().as_secs_f32()));
                }
                (None, None) => {}
            }
        },
    );
    action
}

/// How the stored views were turned to fit, and what a person can turn over.
fn layout_rows(recorded: &Recorded, ui: &mut Ui) -> Option<Action> {
    let layout = recorded.layout;
    row(ui, "Views lie", &layout.to_string());
    // Turning both ways at once changes nothing but the sign.
    let toggles = [
        (Command::Opposite, layout.flip_u),
        (Command::Transpose, layout.transposed),
        (Command::Serpentine, layout.serpentine),
    ];
    let mut action = None;
    for (toggle, mut is_on) in toggles {
        if widgets::switch(ui, toggle.spec().label, &mut is_on, &toggle.tip(ui.ctx())) {
            action = Some(Action::Do(toggle));
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
