//! A net that was added: the sample's depth as it sees it, beside what is known of it.

use egui::{Context, RichText, Sense, TextureHandle, Ui, vec2};

use crate::ui::action::Action;
use crate::ui::added::Shown;
use crate::ui::adding::Change;
use crate::ui::near_end::PREVIEW;
use crate::ui::words::{self, heard, t};
use crate::ui::{theme, widgets};

/// Long side of each picture, in points.
const SIDE: f32 = PREVIEW as f32 * 0.75;

/// Draws the card.
pub fn show(shown: &Shown, ctx: &Context) -> Vec<Action> {
    let colors = theme::palette(ctx);
    let card = &shown.card;
    let mut actions = Vec::new();
    let modal = widgets::modal(ctx, "added");
    let drawn = modal.show(ctx, |ui| {
        ui.set_width(2.0 * SIDE + 16.0);
        ui.spacing_mut().item_spacing.y = 8.0;
        ui.label(RichText::new(t!("added-title", name = &card.name)).font(theme::title(16.0)).color(colors.strong));
        ui.horizontal_top(|ui| {
            ui.spacing_mut().item_spacing.x = 16.0;
            for (texture, name) in shown.textures.iter().zip([t!("the-sample"), t!("its-depth")]) {
                picture(ui, texture, name);
            }
        });
        for (name, value) in &card.facts {
            fact(ui, name.text(), &value.text());
        }
        if let Some(warning) = card.warning {
            ui.label(RichText::new(words::capital(&heard(warning))).color(colors.accent_text));
        }
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if widgets::main_button(ui, t!("done")).clicked() {
                actions.push(Action::CloseDialog);
            }
            let hint = t!("use-for-all-hint");
            if widgets::button(ui, t!("use-for-all")).on_hover_text(hint).clicked() {
                actions.extend([Action::ChangeNets(Change::Prefer(Some(card.name.clone()))), Action::CloseDialog]);
            }
            if widgets::button(ui, t!("remove")).clicked() {
                actions.extend([Action::ChangeNets(Change::Remove(card.name.clone())), Action::CloseDialog]);
            }
        });
    });
    if drawn.should_close() {
        actions.push(Action::CloseDialog);
    }
    actions
}

fn picture(ui: &mut Ui, texture: &TextureHandle, name: &str) {
    let size = texture.size_vec2();
    let size = size * (SIDE / size.max_elem());
    ui.vertical(|ui| {
        ui.set_max_width(SIDE);
        let (rect, response) = ui.allocate_exact_size(vec2(SIDE, size.y), Sense::hover());
        widgets::picture(
            ui.painter(),
            texture.id(),
            egui::Rect::from_center_size(rect.center(), size),
            widgets::WHOLE,
            1.0,
        );
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, name));
        let weak = theme::palette(ui.ctx()).weak;
        ui.vertical_centered(|ui| ui.label(RichText::new(name).small().color(weak)));
    });
}

fn fact(ui: &mut Ui, name: &str, value: &str) {
    let colors = theme::palette(ui.ctx());
    ui.horizontal_wrapped(|ui| {
        ui.label(RichText::new(name).color(colors.weak));
        ui.label(RichText::new(value).color(colors.strong));
    });
}
