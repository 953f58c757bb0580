//! The timeline: its keys along a line, the playhead, and how the film goes.

use egui::containers::menu::{MenuButton, MenuConfig};
use egui::scroll_area::ScrollBarVisibility;
use egui::{Align, Layout, PopupCloseBehavior, Rect, Sense, Ui, WidgetInfo, pos2, vec2};

use crate::scene::timeline::{Ease, Preset, Run, SECONDS, Timeline};
use crate::ui::action::Action;
use crate::ui::command::Command;
use crate::ui::film::{Cut, Film};
use crate::ui::words::{self, Id, Message, id, t};
use crate::ui::{theme, widgets};

/// Half the width of a key.
const HALF: f32 = 6.0;

/// What the panel shows and sets.
pub struct Shown<'a> {
    /// The timeline; none before it has a key.
    pub timeline: &'a mut Option<Timeline>,
    /// How it is looked at.
    pub film: &'a mut Film,
}

/// Ready-made timelines by their names.
const PRESETS: [(Preset, Id); 5] = [
    (Preset::Pull, id!("preset-pull")),
    (Preset::Subjects, id!("preset-subjects")),
    (Preset::Circle, id!("preset-circle")),
    (Preset::Breathing, id!("preset-breathing")),
    (Preset::Dolly, id!("preset-dolly")),
];

/// Draws the panel.
pub fn show(mut shown: Shown, ui: &mut Ui) -> Vec<Action> {
    let rect = ui.max_rect().shrink2(vec2(14.0, 8.0));
    let row = Rect::from_min_max(rect.min, pos2(rect.right(), rect.top() + 26.0));
    let mut actions = Vec::new();
    widgets::inside(ui, row, |ui| {
        // Where large text leaves no room for all of it.
        egui::ScrollArea::horizontal().id_salt("film").scroll_bar_visibility(ScrollBarVisibility::AlwaysHidden).show(
            ui,
            |ui| {
                ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                    ui.spacing_mut().item_spacing.x = 2.0 * theme::GRID;
                    verbs(&mut shown, ui, &mut actions);
                    if let Some(timeline) = shown.timeline {
                        ui.add_space(2.0 * theme::GRID);
                        manner(timeline, ui);
                    }
                });
            },
        );
    });
    let track = Rect::from_min_max(pos2(rect.left(), row.bottom() + 8.0), rect.max);
    actions.extend(line(&mut shown, ui, track));
    actions
}

fn verbs(shown: &mut Shown, ui: &mut Ui, actions: &mut Vec<Action>) {
    let play = if shown.film.is_playing() { t!("film-stop") } else { t!("film-play") };
    let has_keys = shown.timeline.is_some();
    ui.add_enabled_ui(has_keys, |ui| {
        if widgets::button(ui, play).on_hover_text(Command::PlayFilm.tip(ui.ctx())).clicked() {
            actions.push(Action::Do(Command::PlayFilm));
        }
    });
    let at_key = shown.timeline.as_ref().is_some_and(|timeline| timeline.key_at(shown.film.moment).is_some());
    let label = if at_key { t!("set-key") } else { t!("add-key") };
    if widgets::button(ui, label).on_hover_text(Command::AddKey.tip(ui.ctx())).clicked() {
        actions.push(Action::Do(Command::AddKey));
    }
    ui.add_enabled_ui(at_key, |ui| {
        if widgets::button(ui, t!("remove-key")).clicked() {
            actions.push(Action::Cut(Cut::Remove));
        }
    });
    let holds = &mut shown.film.holds;
    let values = [
        (&mut holds.focus, t!("hold-focus")),
        (&mut holds.aperture, t!("hold-aperture")),
        (&mut holds.eye, t!("hold-eye")),
        (&mut holds.strength, t!("hold-strength")),
    ];
    // Several of them are turned at one opening of the menu.
    let stays = MenuConfig::new().close_behavior(PopupCloseBehavior::CloseOnClickOutside);
    let (response, _) = MenuButton::new(t!("key-holds")).config(stays).ui(ui, |ui| {
        for (value, name) in values {
            ui.checkbox(value, name);
        }
    });
    response.on_hover_text(t!("key-holds-hint"));
    ui.menu_button(t!("film-presets"), |ui| {
        for (preset, name) in PRESETS {
            if ui.button(name.text()).on_hover_text(name.hint()).clicked() {
                actions.push(Action::Cut(Cut::Take(preset)));
                ui.close();
            }
        }
        if ui.add_enabled(has_keys, egui::Button::new(t!("film-none"))).on_hover_text(t!("film-none-hint")).clicked() {
            actions.push(Action::Cut(Cut::Clear));
            ui.close();
        }
    });
}

/// How it goes from key to key, how it ends, and how long it is.
fn manner(timeline: &mut Timeline, ui: &mut Ui) {
    let eases = [
        (Ease::Smooth, t!("ease-smooth")),
        (Ease::Linear, t!("ease-even")),
        (Ease::In, t!("ease-in")),
        (Ease::Out, t!("ease-out")),
    ];
    chosen(ui, t!("easing"), &mut timeline.ease, &eases);
    let runs = [(Run::Once, t!("run-once")), (Run::Loop, t!("run-loop")), (Run::PingPong, t!("run-ping-pong"))];
    chosen(ui, t!("at-the-end"), &mut timeline.run, &runs);
    let drag = widgets::spoken(egui::DragValue::new(&mut timeline.seconds)).range(SECONDS[0]..=SECONDS[1]).speed(0.02);
    let response = ui.add(drag.max_decimals(1).suffix(t!("suffix-s"))).on_hover_text(t!("seconds-hint"));
    response.widget_info(|| WidgetInfo::labeled(egui::Role::SpinButton, true, t!("film-seconds")));
}

/// One of several, that unfolds.
fn chosen<T: Copy + PartialEq>(ui: &mut Ui, name: &str, value: &mut T, all: &[(T, &str)]) {
    let text = all.iter().find(|(one, _)| one == value).map_or("", |(_, text)| *text);
    let shown = egui::ComboBox::from_id_salt(name).selected_text(text).width(86.0).show_ui(ui, |ui| {
        for (one, text) in all {
            ui.selectable_value(value, *one, *text);
        }
    });
    let said = t!("chosen-said", name = name, value = text);
    shown.response.widget_info(|| WidgetInfo::labeled(egui::Role::ComboBox, true, &said));
}

/// The line with the playhead and the keys.
fn line(shown: &mut Shown, ui: &mut Ui, area: Rect) -> Option<Action> {
    let colors = theme::palette(ui.ctx());
    let track = area.shrink2(vec2(HALF, 0.0));
    let x = |moment: f32| track.left() + moment * track.width();
    let moment_at = |x: f32| ((x - track.left()) / track.width()).clamp(0.0, 1.0);
    let middle = track.center().y;
    ui.painter().rect_filled(Rect::from_center_size(track.center(), vec2(track.width(), 4.0)), 2, colors.control);
    let head = ui.interact(area, ui.scope_id().with("playhead"), Sense::click_and_drag());
    let (seconds, moment) = (shown.timeline.as_ref().map_or(1.0, |timeline| timeline.seconds), shown.film.moment);
    head.widget_info(|| WidgetInfo::slider(true, f64::from(moment * seconds), t!("playhead")));
    let mut action = head.interact_pointer_pos().map(|at| Action::Playhead(moment_at(at.x)));
    let steps = widgets::arrows(ui, &head);
    if steps != 0.0 {
        action = Some(Action::Cut(Cut::Step(steps)));
    }
    let Some(timeline) = shown.timeline.as_mut() else {
        let text = t!("timeline-empty");
        ui.painter().text(
            pos2(track.center().x, middle - 9.0),
            egui::Align2::CENTER_CENTER,
            text,
            theme::small(),
            colors.weak,
        );
        return action;
    };
    let mut moved = None;
    for (number, key) in timeline.keys.iter().enumerate() {
        let at = pos2(x(key.at), middle);
        let place = Rect::from_center_size(at, vec2(2.0 * HALF, 4.0 * HALF));
        let response = ui.interact(place, ui.scope_id().with(("key", number)), Sense::click_and_drag());
        let said = t!(
            "key-said",
            number = number + 1,
            secs = words::fixed(key.at * timeline.seconds, 1),
            what = Message::heard(key.told())
        );
        response.widget_info(|| WidgetInfo::labeled(egui::Role::Button, true, &said));
        if let Some(pointer) = response.interact_pointer_pos().filter(|_| response.dragged()) {
            moved = Some((number, moment_at(pointer.x)));
        } else if response.clicked() {
            action = Some(Action::Playhead(key.at));
        }
        let is_lit = response.hovered() || response.has_focus() || timeline.key_at(moment) == Some(number);
        let color = if is_lit { colors.accent } else { colors.text };
        let corners = [vec2(0.0, -HALF), vec2(HALF, 0.0), vec2(0.0, HALF), vec2(-HALF, 0.0)].map(|by| at + by);
        ui.painter().add(egui::Shape::convex_polygon(corners.to_vec(), color, (1.0, colors.panel)));
        response.on_hover_text(said);
    }
    if let Some((number, at)) = moved {
        timeline.shift(number, at);
        action = Some(Action::Playhead(timeline.keys[number].at));
    }
    ui.painter().vline(x(moment), area.y_range(), (2.0, colors.accent));
    action
}
