//! Inspector sections: where ray depths come from, and what the light field is.

use egui::{Align, Button, Label, Layout, RichText, Ui};

use crate::scene::{Content, DepthFrom, Recorded};
use crate::ui::action::Action;
use crate::ui::adding::Change;
use crate::ui::ask::Ask;
use crate::ui::command::Command;
use crate::ui::event::Listed;
use crate::ui::open::Open;
use crate::ui::sources::{self, Choice};
use crate::ui::words::{self, heard, id, t};
use crate::ui::{theme, widgets};

/// Where ray depths come from, and can.
pub struct Sources<'a> {
    /// The source that is looked at.
    pub looked_at: DepthFrom,
    /// All that can be used.
    pub all: Vec<Choice>,
    /// Further depth nets, broken ones too.
    pub nets: &'a [Listed],
}

/// Where a photo's ray depths come from.
pub fn source(open: &Open, sources: &Sources, ui: &mut Ui) -> Option<Action> {
    let Content::Photo(one) = &open.subject()?.content else { return None };
    if one.splats.is_some() {
        return None;
    }
    let mut choices = vec![(DepthFrom::Network, t!("source-network").to_owned())];
    choices.extend(sources::of_photo(one));
    let mut source = sources.looked_at.clone();
    let (mut beside, mut action) = (None, None);
    let ctx = ui.ctx().clone();
    widgets::section(
        ui,
        id!("section-source"),
        |ui| {
            let mut link = |ui: &mut Ui, label: &str, command: Command| {
                if widgets::link(ui, label).on_hover_text(command.tip(&ctx)).clicked() {
                    beside = Some(Action::Do(command));
                }
            };
            link(ui, t!("link-depth-map"), Command::OwnDepth);
            if sources.all.len() > 1 {
                link(ui, t!("link-compare"), Command::CompareSources);
            }
        },
        |ui| {
            if choices.len() > 1 {
                widgets::segmented(ui, t!("source"), &mut source, &choices);
            }
            action = model_menu(ui, &mut source, sources.nets);
        },
    );
    if source != sources.looked_at { Some(Action::TakeDepths(source)) } else { action.or(beside) }
}

/// Further depth nets, and what can be done with them.
fn model_menu(ui: &mut Ui, source: &mut DepthFrom, nets: &[Listed]) -> Option<Action> {
    let colors = theme::palette(ui.ctx());
    let mut action = None;
    ui.horizontal(|ui| {
        ui.label(RichText::new(t!("model")).color(colors.weak));
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let name = source.net_name().unwrap_or(t!("model-built-in"));
            ui.menu_button(RichText::new(format!("{name} ▼")).color(colors.strong), |ui| {
                if ui.selectable_label(source.net_name().is_none(), t!("model-built-in")).clicked() {
                    *source = DepthFrom::Network;
                    ui.close();
                }
                nets.iter().for_each(|net| net_entry(ui, source, net));
                ui.separator();
                action = net_actions(ui, source, nets);
            });
        });
    });
    action
}

/// One net; a broken one says why on hover.
fn net_entry(ui: &mut Ui, source: &mut DepthFrom, net: &Listed) {
    let choice = net.source();
    let label = Button::selectable(*source == choice, &net.name);
    let entry = ui.add_enabled(net.fault.is_none(), label);
    if let Some(fault) = &net.fault {
        entry.on_disabled_hover_text(fault);
    } else if entry.clicked() {
        *source = choice;
        ui.close();
    }
}

/// Add one; use the chosen one always; remove it. A broken one can be removed too.
fn net_actions(ui: &mut Ui, source: &DepthFrom, nets: &[Listed]) -> Option<Action> {
    let mut action = None;
    let tip = t!("add-net-hint");
    if ui.button(t!("add-net")).on_hover_text(tip).clicked() {
        action = Some(Action::Ask(Ask::Net));
    }
    let chosen = nets.iter().find(|net| net.is_added && *source == net.source());
    if let Some(net) = chosen {
        let mut is_preferred = net.is_preferred;
        if ui.checkbox(&mut is_preferred, t!("use-for-all")).clicked() {
            action = Some(Action::ChangeNets(Change::Prefer(is_preferred.then(|| net.name.clone()))));
        }
    }
    let broken = nets.iter().filter(|net| net.is_added && net.fault.is_some());
    for net in chosen.into_iter().chain(broken) {
        if ui.button(t!("remove-net", name = &net.name)).clicked() {
            action = Some(Action::ChangeNets(Change::Remove(net.name.clone())));
        }
    }
    if action.is_some() {
        ui.close();
    }
    action
}

/// What the light field is; of a recorded one also how it was laid out.
pub fn light_field(open: &Open, ui: &mut Ui) -> Option<Action> {
    let field = open.field()?;
    let (grid, [w, h]) = (field.grid(), field.size());
    let mut action = None;
    widgets::section(
        ui,
        id!("section-light-field"),
        |_| {},
        |ui| {
            row(ui, &t!("views-count", cols = grid.cols(), rows = grid.rows()), &t!("pixels", width = w, height = h));
            match (open.subject().and_then(|subject| subject.recorded()), open.scene()) {
                (Some(recorded), _) => {
                    row(ui, t!("made-by"), t!("from-disk"));
                    action = layout_rows(recorded, ui);
                }
                (None, Some(scene)) => {
                    row(ui, t!("made-by"), &heard(&scene.made_by()));
                    row(ui, t!("took"), &t!("seconds", secs = words::fixed(scene.took().as_secs_f32(), 1)));
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
    row(ui, t!("views-lie"), &heard(&layout.to_string()));
    // Turning both ways at once changes nothing but the sign.
    let toggles = [
        (Command::Opposite, layout.flip_u),
        (Command::Transpose, layout.transposed),
        (Command::Serpentine, layout.serpentine),
    ];
    let mut action = None;
    for (toggle, mut is_on) in toggles {
        if widgets::switch(ui, toggle.spec().label(), &mut is_on, &toggle.tip(ui.ctx())) {
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
