//! What lies where: the picture takes all the room there is, its other faces lie in line with it.

mod added;
mod broke;
mod canvas;
mod depths;
mod empty;
mod epi;
mod export;
mod glass;
mod hint;
mod histogram;
mod inspector;
mod many;
mod measure;
mod mend;
mod near_end;
mod opening;
mod path_box;
mod points;
mod presets;
mod queue;
mod real_lens;
mod repair;
mod ruler;
mod settings;
mod sheet;
mod source;
mod status;
mod strength;
mod strip;
mod timeline;
mod top_bar;
mod training;
mod views;

use crate::ui::words::t;
use egui::{Align2, Context, Rect, Ui, pos2, vec2};

use super::action::Action;
use super::apply;
use super::dialog::Dialog;
use super::look::Face;
use super::open::Open;
use super::rest::Seen;
use super::theme;
use super::widgets::{WHOLE, inside, panel, veil_label};
use super::window::Window;
use canvas::Canvas;
use depths::Depths;
use epi::Epis;
use export::Export;
use inspector::Inspector;
use repair::Repairing;
use ruler::Ruler;
use source::Sources;
use status::Status;
use strip::Views;
use top_bar::TopBar;

const TOP_HEIGHT: f32 = 44.0;
const STATUS_HEIGHT: f32 = 26.0;
const RULER_HEIGHT: f32 = 96.0;
const TIMELINE_HEIGHT: f32 = 80.0;
const MARGIN: f32 = 10.0;
const GAP: f32 = 6.0;

/// Draws the whole window.
pub fn layout(window: &mut Window, ui: &mut Ui) -> Vec<Action> {
    let all = ui.max_rect();
    let colors = theme::palette(ui.ctx());
    let is_narrow = all.width() < theme::NARROW_WIDTH;
    let top = Rect::from_min_max(all.min, pos2(all.right(), all.top() + TOP_HEIGHT));
    let status = Rect::from_min_max(pos2(all.left(), all.bottom() - STATUS_HEIGHT), all.max);
    let mut main = Rect::from_min_max(top.left_bottom(), status.right_top());
    let mut actions = Vec::new();

    if window.open.document().is_some() {
        let is_shown = if is_narrow { window.look.is_drawer_open } else { window.settings.has_inspector };
        let side = Rect::from_min_max(pos2(main.right() - theme::INSPECTOR_WIDTH, main.top()), main.max);
        // A drawer lies over the canvas, so it is drawn last; a panel has its own room.
        if is_shown && !is_narrow {
            main.max.x = side.left();
        }
        actions.extend(picture_area(window, ui, main, is_narrow));
        if is_shown {
            actions.extend(panel(ui, side, colors.panel, |ui| inspector(window, ui)));
        }
    } else {
        let (recent, thumbnails) = (&window.settings.recent, &window.thumbnails);
        actions.extend(inside(ui, main, |ui| empty::show(recent, thumbnails, ui)));
    }
    actions.extend(panel(ui, top, colors.panel, |ui| top_bar(window, ui, is_narrow)));
    actions.extend(inside(ui, status, |ui| status_line(window, ui)));
    empty::drop_hint(window.open.document().is_some(), ui, all);
    actions
}

/// Picture, epipolar images and ruler.
fn picture_area(window: &mut Window, ui: &mut Ui, area: Rect, is_narrow: bool) -> Vec<Action> {
    let colors = theme::palette(ui.ctx());
    let ruler = Rect::from_min_max(pos2(area.left(), area.bottom() - RULER_HEIGHT), area.max);
    let film = if window.film.is_shown { TIMELINE_HEIGHT } else { 0.0 };
    let line = Rect::from_min_max(pos2(area.left(), ruler.top() - film), pos2(area.right(), ruler.top()));
    let work = Rect::from_min_max(area.min, line.right_top()).shrink(MARGIN);
    let has_epis = !is_narrow && window.look.face == Face::Picture;
    let room = if has_epis { theme::EPI_THICKNESS + GAP } else { 0.0 };
    let canvas = Rect::from_min_max(work.min, work.max - vec2(room, room));
    window.look.canvas = canvas;
    let mut actions = inside(ui, canvas, |ui| face(window, ui, canvas));
    compared(window, ui, canvas);
    if has_epis {
        let row = Rect::from_min_max(pos2(canvas.left(), canvas.bottom() + GAP), pos2(canvas.right(), work.bottom()));
        let column = Rect::from_min_max(pos2(canvas.right() + GAP, canvas.top()), pos2(work.right(), canvas.bottom()));
        let corner = Rect::from_min_max(pos2(column.left(), row.top()), work.max);
        let Window { open, edit, look, pictures, mending, .. } = window;
        let epis = Epis { open, edit, look, pictures: pictures.as_mut(), reach: mending.reach };
        actions.extend(inside(ui, work, |ui| epi::show(epis, ui, [row, column, corner])));
    }
    if window.film.is_shown {
        let Window { timeline, film, .. } = &mut *window;
        actions.extend(panel(ui, line, colors.panel, |ui| timeline::show(timeline::Shown { timeline, film }, ui)));
    }
    let before = window.open.lens(&window.edit);
    let mut after = before.clone();
    let shown = Ruler {
        survey: window.open.rays().map(|rays| &*rays.survey),
        lens: &mut after,
        hovered_px: window.look.hovered_px,
        is_loading: window.loading.running().is_some(),
    };
    actions.extend(panel(ui, ruler, colors.panel, |ui| ruler::show(shown, ui)));
    window.open.turn(&mut window.edit, &before, &after);
    actions
}

/// The picture's present face.
fn face(window: &mut Window, ui: &mut Ui, area: Rect) -> Vec<Action> {
    let Window { open, edit, look, pictures, photo, rest, settings, mending, repairs, tint, points, .. } = window;
    let pictures = pictures.as_mut();
    match look.face {
        Face::Picture => {
            let (photo, has_peaks) = (photo.as_mut(), settings.peaking);
            let size = open.subject().map(|subject| settings.export.picture.size.of(subject.whole_size()));
            let picture_width = size.map_or(1, |size| size[0]);
            canvas::show(Canvas { open, edit, look, pictures, photo, rest, has_peaks, picture_width }, ui, area);
        }
        Face::Views => {
            let views = Views::new(open, edit.viewpoint, pictures.as_deref());
            return views.map_or_else(Vec::new, |views| views::show(&views, ui, area));
        }
        Face::Points => {
            points::show(open, points, rest.generation(), ui, area);
            return Vec::new();
        }
        Face::Depths => {
            depths::show(Depths { open, edit, look, pictures, colormap: settings.colormap }, ui, area);
        }
    }
    let seen = Seen { open, edit, look };
    if settings.trust
        && let (Some(tint), Some(size)) = (tint.texture(&seen, rest.generation()), open.picture_size())
    {
        let rect = canvas::turned(open, edit, look.pose.screen_rect(area, size));
        ui.painter_at(area.intersect(rect)).image(tint.id(), rect, WHOLE, theme::AS_IS);
    }
    if !mending.is_on {
        return Vec::new();
    }
    // Over the picture, so that the pointer is the tool's.
    let repairing = Repairing { open, edit, look, mending, repairs, colormap: settings.colormap };
    repair::show(repairing, ui, area).into_iter().collect()
}

/// Which source of depth is looked at; on the ray depths always, else while it is compared with another.
fn compared(window: &Window, ui: &Ui, canvas: Rect) {
    let is_compared = window.compare.at().is_some();
    if !is_compared && window.look.face != Face::Depths {
        return;
    }
    let all = window.sources();
    let Some(index) = all.iter().position(|(source, _)| *source == window.looked_at()) else { return };
    let (name, count) = (&all[index].1, all.len());
    let text = match (is_compared, window.loading.running()) {
        (true, Some(_)) => t!("source-made", name = name, number = index + 1, count = count),
        (true, None) => t!("source-compared", name = name, number = index + 1, count = count),
        (false, _) if count > 1 => t!("source-alone", name = name, count = count),
        (false, _) => name.clone(),
    };
    veil_label(ui, canvas.left_top() + vec2(8.0, 8.0), Align2::LEFT_TOP, &text);
}

fn inspector(window: &mut Window, ui: &mut Ui) -> Vec<Action> {
    let (source, sources) = (window.looked_at(), window.sources());
    let Window { open, edit, look, pictures, settings, models, lenses, mending, repairs, rest, photo, .. } = window;
    let of_photo = photo.as_ref().and_then(|photo| photo.histogram());
    let histogram = if edit.shows_photo_itself() { of_photo } else { rest.histogram().or(of_photo) };
    let pictures = pictures.as_mut();
    let sources = Sources { looked_at: source, all: sources, nets: models };
    inspector::show(
        Inspector { open, edit, look, settings, sources, lenses, pictures, mending, repairs, histogram },
        ui,
    )
}

fn top_bar(window: &mut Window, ui: &mut Ui, is_narrow: bool) -> Vec<Action> {
    let possible = apply::possible(window);
    let Window { open, look, settings, .. } = window;
    let (document, recent) = (open.document(), &settings.recent);
    top_bar::show(TopBar { document, look, possible: &possible, recent, is_narrow }, ui)
}

fn status_line(window: &Window, ui: &Ui) -> Option<Action> {
    let Window { open, queue, look, threads, .. } = window;
    let drawn_by = match &window.pictures {
        None => t!("no-device"),
        Some(pictures) if pictures.is_software() => t!("the-processor"),
        Some(pictures) => pictures.adapter.as_str(),
    };
    let loading = window.loading.running().or(window.adding.as_ref());
    let mending = window.mending.running.as_ref();
    status::show(&Status { open, loading, mending, queue, look, drawn_by, threads: *threads }, ui)
}

/// Draws the dialog that is open.
pub fn dialog(window: &mut Window, ctx: &Context) -> Vec<Action> {
    let Window { open, edit, settings, dialog, timeline, languages, training, .. } = window;
    match dialog {
        None => Vec::new(),
        Some(Dialog::Export(photos)) => {
            settings.export.timeline.clone_from(timeline);
            export::show(Export { settings: &mut settings.export, photos, open, edit }, ctx)
        }
        Some(Dialog::Shortcuts) => sheet::show(ctx),
        Some(Dialog::Presets { names, new }) => presets::show(names, new, ctx),
        Some(Dialog::Settings) => settings::show(settings, languages, ctx),
        Some(Dialog::Training) => training::show(training, open.photo().is_some(), ctx),
        Some(Dialog::Path(wanted, text)) => path_box::show(*wanted, text, ctx),
        Some(Dialog::NearEnd(question)) => near_end::show(question, ctx),
        Some(Dialog::Added(shown)) => added::show(shown, ctx),
        Some(Dialog::Many(files)) => many::show(files, settings, ctx),
        Some(Dialog::Broke(broke)) => broke::show(broke, ctx),
    }
}

/// Draws what is told once.
pub fn hint(window: &Window, ctx: &Context) -> Option<Action> {
    hint::show(window, ctx)
}

/// Draws the queue over the canvas's lower right corner, while it is open.
pub fn queue(window: &mut Window, ctx: &Context) -> Vec<Action> {
    let corner = match window.open {
        Open::Nothing => ctx.content_rect().right_bottom() - vec2(44.0, 70.0),
        _ => window.look.canvas.right_bottom() - vec2(8.0, 8.0),
    };
    queue::show(&mut window.queue, corner, ctx)
}
