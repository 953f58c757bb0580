//! The inspector: lens, viewpoint, ray depths, source, light field; views at its foot.

use egui::{Align2, Color32, CursorIcon, Frame, Margin, Rect, RichText, ScrollArea, Sense, Ui, pos2, vec2};

use super::glass;
use super::mend;
use super::opening;
use super::real_lens::{self, RealLens};
use super::source::{self, Sources};
use super::strength;
use super::strip::{self, Views};
use crate::field::{FNumber, Histogram, Lens, ViewGrid, ViewIndex, ViewOffset, ViewPoint};
use crate::render::cpu::Colormap;
use crate::render::gpu::Draw;
use crate::repair::Repairs;
use crate::scene::Edit;
use crate::scene::real::KnownLens;
use crate::scene::trust::{Invented, USUAL_LIMIT};
use crate::ui::action::Action;
use crate::ui::command::Command;
use crate::ui::field_pictures::{FieldPictures, Slot};
use crate::ui::look::Look;
use crate::ui::mending::Mending;
use crate::ui::open::Open;
use crate::ui::rays::Survey;
use crate::ui::settings::Settings;
use crate::ui::sharp;
use crate::ui::theme::{self, GRID};
use crate::ui::widgets::{self, Number};
use crate::ui::words::{self, heard, id, t};

const STRIP_HEIGHT: f32 = 96.0;

/// What the inspector shows and sets.
pub struct Inspector<'a> {
    /// What is open.
    pub open: &'a Open,
    /// Lens and viewpoint.
    pub edit: &'a mut Edit,
    /// Whether the viewpoint goes round, and the line over something of a known length.
    pub look: &'a mut Look,
    /// Colours and marks.
    pub settings: &'a mut Settings,
    /// Where ray depths come from, and can.
    pub sources: Sources<'a>,
    /// Lenses that are known by name.
    pub lenses: &'a [KnownLens],
    /// Views and ray depths on the device.
    pub pictures: Option<&'a mut FieldPictures>,
    /// The tool that mends depth.
    pub mending: &'a mut Mending,
    /// What was done to the depth.
    pub repairs: &'a Repairs,
    /// How bright the picture is.
    pub histogram: Option<&'a Histogram>,
}

/// Draws the inspector.
pub fn show(shown: Inspector, ui: &mut Ui) -> Vec<Action> {
    let Inspector { open, edit, look, settings, sources, lenses, mut pictures, mending, repairs, histogram } = shown;
    let all = ui.max_rect();
    let strip = Rect::from_min_max(pos2(all.left(), all.bottom() - STRIP_HEIGHT), all.max);
    let body = Rect::from_min_max(all.min, pos2(all.right(), strip.top()));
    let mut actions = Vec::new();
    widgets::inside(ui, body, |ui| {
        ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
            Frame::new().inner_margin(Margin::symmetric(16, 14)).show(ui, |ui| {
                ui.set_width(theme::INSPECTOR_WIDTH - 32.0);
                actions.extend(mend::show(mending, repairs, ui));
                let before = open.lens(edit);
                let mut after = before.clone();
                let limit = settings.trust_percent / 100.0;
                let limits = open.invented().map(|invented| invented.limits(limit));
                let reads = open.scene().map(|scene| real_lens::title(scene, edit, settings));
                actions.extend(lens(&mut after, settings, limits.map(|limits| limits.widest), reads, ui));
                open.turn(edit, &before, &after);
                if let Some(text) = sharp::told(open, edit) {
                    ui.label(RichText::new(text).small().color(theme::palette(ui.ctx()).weak));
                    ui.add_space(2.0 * GRID);
                }
                if let Some(grid) = open.grid() {
                    let trust = open.invented().map(|invented| (invented, limit));
                    let width = open.rays().map_or(1, |rays| rays.depths.size()[0]) as f32 * open.strength().0;
                    let eye = Eye {
                        grid,
                        at: &mut edit.viewpoint,
                        pivot: (&mut edit.pivot, width),
                        is_circling: &mut look.is_circling,
                        trust,
                    };
                    actions.extend(viewpoint(eye, open.rays().map(|rays| &*rays.survey), ui));
                }
                actions.extend(ray_depths(open, edit.viewpoint, &mut settings.colormap, pictures.as_deref_mut(), ui));
                strength::show(open, edit, ui);
                // As far from what follows as a section.
                ui.add_space(4.0 * GRID);
                actions.extend(source::source(open, &sources, ui));
                actions.extend(source::light_field(open, ui));
                if let Some(counted) = histogram {
                    super::histogram::show(counted, ui);
                }
                if let Some(scene) = open.scene() {
                    actions.extend(real_lens::show(RealLens { scene, edit, look, settings, lenses }, ui));
                }
                glass::show(&mut edit.glass, ui);
            });
        });
    });
    ui.painter().hline(strip.x_range().shrink(16.0), strip.top(), (1.0, theme::palette(ui.ctx()).control));
    if let Some(views) = Views::new(open, edit.viewpoint, pictures.as_deref()) {
        actions.extend(widgets::inside(ui, strip, |ui| strip::show(&views, ui)));
    }
    actions
}

/// The lens; `reads`: what real one it is.
fn lens(
    lens: &mut Lens,
    settings: &mut Settings,
    widest: Option<FNumber>,
    reads: Option<String>,
    ui: &mut Ui,
) -> Option<Action> {
    let (mut chosen, mut action) = (None, None);
    let shape = lens.shape.clone();
    widgets::section(
        ui,
        id!("section-lens"),
        |ui| (chosen, action) = opening::menu(ui, &shape),
        |ui| {
            aperture(ui, &mut lens.f_number, widest.map(|widest| (widest, settings.trust_percent)));
            if let Some(text) = reads {
                ui.label(RichText::new(text).small().color(theme::palette(ui.ctx()).weak));
            }
            ui.add_space(GRID);
            focus(ui, lens);
            opening::numbers(ui, &mut lens.shape);
            widgets::switch(ui, t!("peaking"), &mut settings.peaking, &Command::Peaking.tip(ui.ctx()));
            widgets::switch(ui, t!("trust"), &mut settings.trust, &Command::Trust.tip(ui.ctx()));
            if settings.trust {
                let spec = Number {
                    label: t!("invented-most"),
                    range: [0.1, 50.0],
                    speed: 0.05,
                    decimals: 1,
                    prefix: "",
                    suffix: " %",
                    reset: 100.0 * USUAL_LIMIT,
                    hint: t!("invented-most-hint"),
                };
                widgets::number(ui, &mut settings.trust_percent, &spec);
            }
        },
    );
    lens.shape = chosen.unwrap_or_else(|| std::mem::take(&mut lens.shape));
    action
}

/// Place of an f-number on the slider: equal steps for equal ratios.
fn place_from_f(f: FNumber) -> f32 {
    (FNumber::PHOTO.0 / f.0).ln() / (FNumber::PHOTO.0 / FNumber::WIDEST.0).ln()
}

fn f_from_place(place: f32) -> FNumber {
    FNumber(FNumber::PHOTO.0 * (FNumber::WIDEST.0 / FNumber::PHOTO.0).powf(place))
}

/// `trust`: the widest opening before more of the picture is invented than so many per cent.
fn aperture(ui: &mut Ui, f: &mut FNumber, trust: Option<(FNumber, f32)>) {
    let colors = theme::palette(ui.ctx());
    let spec = Number {
        label: t!("aperture"),
        range: [FNumber::WIDEST.0, FNumber::PHOTO.0],
        speed: 0.05,
        decimals: 1,
        prefix: "f/",
        suffix: "",
        reset: FNumber::PAPER_WIDEST.0,
        hint: t!("aperture-hint"),
    };
    widgets::number(ui, &mut f.0, &spec);
    let mut place = place_from_f(*f);
    let reset = place_from_f(FNumber::PAPER_WIDEST);
    let response = widgets::slider(ui, t!("aperture-slider"), &mut place, reset);
    if response.changed() {
        *f = f_from_place(place);
    }
    let track = response.rect.shrink2(vec2(6.0, 0.0));
    if let Some((widest, percent)) = trust.filter(|(widest, _)| *widest != FNumber::WIDEST) {
        let at = pos2(track.left() + place_from_f(widest) * track.width(), response.rect.center().y - 5.0);
        widgets::marker(ui.painter(), at, colors.strong);
        response.on_hover_text(t!(
            "aperture-beyond",
            f = words::fixed(widest.0, 1),
            percent = words::fixed(percent, 1)
        ));
    }
    let (row, _) = ui.allocate_exact_size(vec2(ui.available_width(), 14.0), Sense::hover());
    for mark in [28.0f32, 14.0, 7.0, 3.5, 2.0, 1.0] {
        let at = place_from_f(FNumber(mark));
        let is_synthetic = mark < FNumber::PAPER_WIDEST.0;
        let color = colors.weak;
        let text = if mark == 28.0 { "f/28".to_owned() } else { words::shortest(mark) };
        let align = [Align2::CENTER_CENTER, Align2::LEFT_CENTER, Align2::RIGHT_CENTER]
            [if mark == 28.0 { 1 } else { usize::from(mark == 1.0) * 2 }];
        let x = if mark == 28.0 { row.left() } else { track.left() + at * track.width() };
        let x = if mark == 1.0 { row.right() } else { x };
        let label = ui.painter().text(pos2(x, row.center().y), align, text, theme::small(), color);
        let id = ui.scope_id().with(("mark", mark.to_bits()));
        let hit = ui.interact(label.expand(3.0), id, Sense::click()).on_hover_cursor(CursorIcon::PointingHand);
        hit.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, format!("f/{}", words::shortest(mark))));
        if hit.clicked() {
            f.0 = mark;
        }
        if is_synthetic {
            hit.on_hover_text(t!("synthetic-hint"));
        }
    }
    if f.0 < FNumber::PAPER_WIDEST.0 - 0.01 {
        ui.label(RichText::new(t!("synthetic")).small().color(colors.weak));
    }
}

fn focus(ui: &mut Ui, lens: &mut Lens) {
    let number = |label, range, hint| Number {
        label,
        range,
        speed: 0.005,
        decimals: 2,
        prefix: "",
        suffix: t!("suffix-px-view"),
        reset: 0.0,
        hint,
    };
    widgets::number(ui, &mut lens.focus.disparity_px, &number(t!("focus-number"), [-32.0, 32.0], t!("focus-hint")));
    let colors = theme::palette(ui.ctx());
    ui.horizontal(|ui| {
        let text = RichText::new(t!("keep-sharp")).color(colors.text);
        let label = ui.add(egui::Label::new(text).sense(Sense::click()));
        if label.double_clicked() {
            lens.keep_sharp_px = [0.0, 0.0];
        }
        label.on_hover_text(t!("keep-sharp-hint"));
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            ui.spacing_mut().item_spacing.x = 0.0;
            let [far, near] = &mut lens.keep_sharp_px;
            let near_spec = Number { suffix: "", ..number(t!("sharp-nearer"), [0.0, 32.0], t!("sharp-nearer-hint")) };
            widgets::drag_value(ui, near, &near_spec);
            ui.label(RichText::new("…").color(colors.weak));
            let far_spec = Number { suffix: "", ..number(t!("sharp-farther"), [-32.0, 0.0], t!("sharp-farther-hint")) };
            widgets::drag_value(ui, far, &far_spec);
        });
    });
    let tilt = |label, hint| Number { suffix: t!("suffix-px"), ..number(label, [-16.0, 16.0], hint) };
    let [across, down] = &mut lens.focus.tilt_px;
    widgets::number(ui, across, &tilt(t!("tilt-across"), t!("tilt-across-hint")));
    widgets::number(ui, down, &tilt(t!("tilt-down"), t!("tilt-down-hint")));
    let shares = [
        (&mut lens.highlights, t!("highlights"), t!("highlights-hint")),
        (&mut lens.grain, t!("grain"), t!("grain-hint")),
    ];
    for (share, label, hint) in shares {
        let mut percent = *share * 100.0;
        let spec = Number { speed: 0.5, decimals: 0, suffix: " %", ..number(label, [0.0, 100.0], hint) };
        if widgets::number(ui, &mut percent, &spec) {
            *share = percent / 100.0;
        }
    }
}

/// Where the eye is among the views.
struct Eye<'a> {
    grid: ViewGrid,
    at: &'a mut ViewPoint,
    /// What stays where it is, as a share of the width, and that width in pixels.
    pivot: (&'a mut f32, f32),
    is_circling: &'a mut bool,
    /// How much of each view was invented, and how much may be.
    trust: Option<(&'a Invented, f32)>,
}

fn viewpoint(mut eye: Eye, survey: Option<&Survey>, ui: &mut Ui) -> Option<Action> {
    let ctx = ui.ctx().clone();
    let link = |ui: &mut Ui, label: &str, command: Command| {
        let is_clicked = widgets::link(ui, label).on_hover_text(command.tip(&ctx)).clicked();
        is_clicked.then_some(Action::Do(command))
    };
    let (mut action, mut beside) = (None, None);
    widgets::section(
        ui,
        id!("section-viewpoint"),
        |ui| beside = link(ui, t!("link-centre"), Command::ResetViewpoint),
        |ui| {
            ui.horizontal_top(|ui| {
                pad(&mut eye, survey, ui);
                ui.add_space(2.0 * GRID);
                ui.vertical(|ui| {
                    ui.set_width(ui.available_width());
                    coordinates(&mut eye, ui);
                    ui.add_space(GRID);
                    let label = if *eye.is_circling { t!("link-stop-circle") } else { t!("link-circle") };
                    action = link(ui, label, Command::Circle);
                    ui.add_space(GRID);
                    let weak = theme::palette(&ctx).weak;
                    ui.label(RichText::new(t!("drag-to-look")).small().color(weak));
                });
            });
        },
    );
    action.or(beside)
}

fn coordinates(eye: &mut Eye, ui: &mut Ui) {
    let Eye { grid, at, .. } = eye;
    let [lo, hi] = [ViewIndex { v: 0, u: 0 }, ViewIndex { v: grid.rows() as u8 - 1, u: grid.cols() as u8 - 1 }];
    let (lo, hi) = (grid.offset(lo), grid.offset(hi));
    let spec = |label, range| Number {
        label,
        range,
        speed: 0.02,
        decimals: 1,
        prefix: "",
        suffix: "",
        reset: 0.0,
        hint: t!("step-hint"),
    };
    widgets::number(ui, &mut at.0.du, &spec("u", [lo.du, hi.du]));
    widgets::number(ui, &mut at.0.dv, &spec("v", [lo.dv, hi.dv]));
    let (pivot, width) = &mut eye.pivot;
    let mut px = **pivot * *width;
    let hint = t!("pivot-hint");
    if widgets::number(ui, &mut px, &Number { decimals: 2, speed: 0.01, hint, ..spec(t!("pivot"), [-32.0, 32.0]) }) {
        **pivot = px / *width;
    }
}

/// One cell a view: the brighter, the less of it was invented; amber where the eye is.
fn pad(eye: &mut Eye, survey: Option<&Survey>, ui: &mut Ui) {
    let grid = eye.grid;
    let colors = theme::palette(ui.ctx());
    let most = grid.rows().max(grid.cols()) as f32;
    let pitch = (128.0 / most).clamp(8.0, 18.0).floor();
    let size = vec2(grid.cols() as f32 * pitch, grid.rows() as f32 * pitch);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click_and_drag());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Group, true, t!("pad")));
    let zero = grid.reference();
    if let Some(at) = response.interact_pointer_pos() {
        let place = (at - rect.min) / pitch - vec2(0.5, 0.5);
        *eye.is_circling = false;
        let is_free = ui.input(|input| input.modifiers.shift);
        let step = |p: f32, zero: u8| if is_free { p - f32::from(zero) } else { p.round() - f32::from(zero) };
        *eye.at = ViewPoint(grid.clamp(ViewOffset { dv: step(place.y, zero.v), du: step(place.x, zero.u) }));
    }
    let here = grid.nearest(eye.at.0);
    for view in grid.views() {
        let min = rect.min + vec2(f32::from(view.u), f32::from(view.v)) * pitch;
        let cell = Rect::from_min_size(min, vec2(pitch, pitch)).shrink(1.0);
        let seen = survey.and_then(|survey| survey.seen.get(grid.layer_from_view(view)).copied());
        // Half a view invented is as dark as it gets.
        let share = seen.map_or(0.3, |seen| ((seen - 0.5) * 2.0).clamp(0.0, 1.0));
        let color = if view == here { colors.accent } else { mixed(colors.control, colors.bar, share) };
        ui.painter().rect_filled(cell, 2, color);
    }
    if let Some((invented, limit)) = eye.trust {
        rim(ui.painter(), rect.min, pitch, grid, |view| invented.of(view) <= limit);
    }
    let at = eye.at.0.to_vec2();
    let at = rect.min + vec2(at.x + f32::from(zero.u) + 0.5, at.y + f32::from(zero.v) + 0.5) * pitch;
    ui.painter().circle(at, 2.5, colors.strong, (1.0, colors.panel));
    response.on_hover_text(t!("pad-hint"));
}

/// A line round the views that hold something.
fn rim(painter: &egui::Painter, min: egui::Pos2, pitch: f32, grid: ViewGrid, holds: impl Fn(ViewIndex) -> bool) {
    let color = theme::palette(painter.ctx()).strong;
    let has = |v: i32, u: i32| {
        let is_inside = (0..grid.rows() as i32).contains(&v) && (0..grid.cols() as i32).contains(&u);
        is_inside && holds(ViewIndex { v: v as u8, u: u as u8 })
    };
    for (v, u) in (0..=grid.rows() as i32).flat_map(|v| (0..=grid.cols() as i32).map(move |u| (v, u))) {
        let at = min + vec2(u as f32, v as f32) * pitch;
        if has(v, u) != has(v, u - 1) {
            painter.line_segment([at, at + vec2(0.0, pitch)], (1.0, color));
        }
        if has(v, u) != has(v - 1, u) {
            painter.line_segment([at, at + vec2(pitch, 0.0)], (1.0, color));
        }
    }
}

fn mixed(a: Color32, b: Color32, t: f32) -> Color32 {
    a.lerp_to_gamma(b, t)
}

fn ray_depths(
    open: &Open,
    eye: ViewPoint,
    colormap: &mut Colormap,
    pictures: Option<&mut FieldPictures>,
    ui: &mut Ui,
) -> Option<Action> {
    let (view, rays, size) = (open.nearest_view(eye)?, open.rays()?, open.picture_size()?);
    let (mut map, range) = (*colormap, rays.survey.range_px);
    let draw = Draw::Depth { view, range, map };
    let mut action = None;
    widgets::section(
        ui,
        id!("section-depths"),
        |ui| colormap_menu(ui, &mut map),
        |ui| {
            let width = ui.available_width();
            let height = (width * size.y / size.x).min(150.0);
            let (rect, response) = ui.allocate_exact_size(vec2(width, height), Sense::click());
            response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, t!("depths-picture")));
            if let Some(id) = pictures.and_then(|pictures| pictures.show(Slot::Depth, draw)) {
                // The middle of the map, so that nothing is squeezed.
                let cut = (1.0 - height / (width * size.y / size.x)) / 2.0;
                let uv = Rect::from_min_max(pos2(0.0, cut), pos2(1.0, 1.0 - cut));
                widgets::picture(ui.painter(), id, rect, uv, 1.0);
            }
            let tip = format!("{}\n{}", Command::Depths.tip(ui.ctx()), Command::CompareSources.tip(ui.ctx()));
            if response.on_hover_text(tip).clicked() {
                action = Some(Action::Do(Command::Depths));
            }
            let colors = theme::palette(ui.ctx());
            let (row, _) = ui.allocate_exact_size(vec2(width, 16.0), Sense::hover());
            let y = row.center().y;
            let [far, near] = range.map(|d| words::signed(d, 2));
            let texts = [
                (pos2(row.left(), y), Align2::LEFT_CENTER, t!("depths-far", disparity = far)),
                (pos2(row.center().x, y), Align2::CENTER_CENTER, t!("px-view").to_owned()),
                (pos2(row.right(), y), Align2::RIGHT_CENTER, t!("depths-near", disparity = near)),
            ];
            for (at, align, text) in texts {
                ui.painter().text(at, align, text, theme::small(), colors.weak);
            }
        },
    );
    *colormap = map;
    action
}

fn colormap_menu(ui: &mut Ui, map: &mut Colormap) {
    let text = RichText::new(format!("{} ▼", heard(map.label()))).small().color(theme::palette(ui.ctx()).weak);
    ui.menu_button(text, |ui| {
        for choice in Colormap::ALL {
            if ui.selectable_label(*map == choice, heard(choice.label())).clicked() {
                *map = choice;
                ui.close();
            }
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_apertures_lie_at_equal_distances() {
        let places = [28.0, 14.0, 7.0, 3.5].map(|f| place_from_f(FNumber(f)));
        let steps: Vec<f32> = places.windows(2).map(|pair| pair[1] - pair[0]).collect();
        assert!(steps.iter().all(|step| (step - steps[0]).abs() < 1e-6));
        assert!((f_from_place(place_from_f(FNumber(5.6))).0 - 5.6).abs() < 1e-4);
        assert!((place_from_f(FNumber::WIDEST) - 1.0).abs() < 1e-6);
    }
}
