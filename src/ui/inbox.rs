//! What the threads have sent: taken in between two frames, never waited for.

use super::adding::Change;
use std::sync::Arc;

use egui::{Context, TextureOptions, ViewportCommand};

use super::action::Action;
use super::added::Shown;
use super::apply::apply;
use super::ask::Picked;
use super::compare::{self, Kept, make_again};
use super::dialog::Dialog;
use super::document::{Document, Sidecar};
use super::event::Event;
use super::history::History;
use super::jobs::OpenFrom;
use super::mending::Answer;
use super::near_end::Question;
use super::neighbours;
use super::open::{Made, Open};
use super::progress::Loading;
use super::queue::State;
use super::rays::Rays;
use super::strength::is_same;
use super::tiles::Tiled;
use super::training;
use super::window::Window;
use super::words::message;
use super::worker::JobId;
use crate::field::ViewPoint;
use crate::repair::Repairs;
use crate::scene::{Focus, OTHER_PHOTO, Scene};

/// Takes in one letter.
pub fn take(window: &mut Window, job: JobId, event: Event, ctx: &Context) {
    if window.loading.running().is_some_and(|running| running.job == job) {
        loaded(window, event, ctx);
    } else if window.adding.as_ref().is_some_and(|adding| adding.job == job) {
        added(window, event, ctx);
    } else if window.mending.running.as_ref().is_some_and(|mending| mending.job == job) {
        mended(window, event, ctx);
    } else if window.queue.has(job) {
        exported(window, job, event, ctx);
    } else {
        told(window, event, ctx);
    }
}

/// From the thread that tries nets.
fn added(window: &mut Window, event: Event, ctx: &Context) {
    match event {
        Event::Progress(progress) => window.adding.iter_mut().for_each(|adding| adding.tell(progress)),
        Event::Added(_) | Event::Failed(_) | Event::Stopped => {
            window.adding = None;
            told(window, event, ctx);
        }
        other => told(window, other, ctx),
    }
}

/// From the thread that mends.
fn mended(window: &mut Window, event: Event, ctx: &Context) {
    if let Event::Progress(progress) = event {
        window.mending.running.iter_mut().for_each(|running| running.tell(progress));
    } else {
        window.mending.running = None;
        told(window, event, ctx);
    }
}

/// From threads other than those that open and save, and from the loader once it is done.
fn told(window: &mut Window, event: Event, ctx: &Context) {
    match event {
        Event::Picked(picked) => self::picked(window, picked, ctx),
        Event::AtRest(key, tiles) => window.rest.put(key, tiles),
        Event::Trust(key, image) => window.tint.put(key, image, ctx),
        Event::Points(drawn) => window.points.put(*drawn, ctx),
        Event::Mending(answer) => mending(window, answer, ctx),
        Event::AtStrength(made) => at_strength(window, *made),
        Event::Peaks(peaks) => window.rest.put_peaks(peaks, ctx),
        Event::Thumbnail(path, image) => {
            let texture = ctx.load_texture("thumbnail", image, TextureOptions::LINEAR);
            window.thumbnails.push((path, texture));
        }
        Event::Models(models) => {
            window.models = models;
            if std::mem::take(&mut window.loses_net) {
                make_again(window);
            }
        }
        Event::Added(card) => {
            window.settings.source = card.source.clone();
            if window.open.photo().is_some() {
                window.source = card.source.clone();
                make_again(window);
            }
            window.dialog = Some(Dialog::Added(Box::new(Shown::new(*card, ctx))));
        }
        Event::Training(answer) => {
            if let Some(source) = training::take(window, answer, ctx) {
                compare::try_net(window, source);
            }
        }
        Event::Warning(text) => window.toasts.info(text),
        Event::Failed(text) => window.toasts.error(text),
        _ => {}
    }
}

fn exported(window: &mut Window, job: JobId, event: Event, ctx: &Context) {
    let Window { queue, toasts, .. } = window;
    match event {
        Event::Progress(progress) => queue.tell(job, progress),
        Event::Saved(path) => {
            queue.end(job, State::Done(path.clone()));
            // One at a time is told; of many the queue tells.
            if !queue.is_open {
                toasts.saved(path);
            }
        }
        Event::Skipped(path) => {
            queue.end(job, State::Skipped);
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            toasts.info(message!("left-as-it-was", name = name));
        }
        Event::Copied(picture) => {
            let size = picture.size.map(|side| side as usize);
            ctx.copy_image(egui::ColorImage::from_rgba_unmultiplied(size, &picture.to_srgb8()));
            queue.forget(job);
            toasts.info(message!("copied-picture", width = size[0], height = size[1]));
        }
        Event::Failed(text) => {
            toasts.error(text.clone());
            queue.end(job, State::Failed(text));
        }
        Event::Stopped => queue.end(job, State::Stopped),
        other => told(window, other, ctx),
    }
}

fn loaded(window: &mut Window, event: Event, ctx: &Context) {
    let is_again = matches!(window.loading, Loading::Again(_));
    match event {
        Event::Progress(progress) => window.loading.tell(progress),
        Event::Failed(text) => {
            window.toasts.error(text);
            window.loading = Loading::Idle;
            if window.compare.at().is_some() {
                compare::back(window);
            }
        }
        Event::Stopped => window.loading = Loading::Idle,
        Event::Several(photos) => {
            window.loading = Loading::Idle;
            apply(window, Action::Show(Dialog::Many(photos)), ctx);
        }
        Event::Opened(document, rays, preview) => {
            opened(window, *document, rays, ctx);
            window.photo = preview.map(Tiled::new);
        }
        Event::Tiles(tiles) => window.photo = Some(Tiled::new(tiles)),
        // Made again with other settings: the old light field stays usable until the new one is complete.
        Event::Rays(_) | Event::View(..) if is_again => {}
        Event::Rays(rays) => take_rays(window, rays),
        Event::View(at, view) => {
            // Ray depths tell the grid; the reference view, which comes before them, is the photo.
            if let (Some(pictures), Some(rays)) = (&mut window.pictures, window.open.rays()) {
                pictures.push_view(rays.depths.grid(), at, &view);
            }
        }
        Event::Made(made) => self::made(window, *made),
        other => told(window, other, ctx),
    }
}

/// A file was read: it takes the place of what was open.
fn opened(window: &mut Window, document: Document, rays: Option<Rays>, ctx: &Context) {
    if let Some(pictures) = &mut window.pictures {
        pictures.clear();
        if let Some(recorded) = document.subject.recorded() {
            pictures.push_field(&recorded.shown);
        }
    }
    window.loading.opened();
    window.rest.forget();
    window.compare.forget();
    window.look.begin();
    window.source = document.source().unwrap_or(&window.settings.source).clone();
    window.asked = window.making();
    window.edit = match &document.sidecar {
        Sidecar::Read(recipe) => recipe.edit(window.making().view_size(&document.subject)[0]),
        _ => window.edit.clone().for_new_photo(),
    };
    window.repairs = match &document.sidecar {
        Sidecar::Read(recipe) => recipe.repairs.clone(),
        _ => Repairs::default(),
    };
    window.mending.forget();
    window.film.forget();
    window.tint.forget();
    window.points.forget();
    window.timeline = match &document.sidecar {
        Sidecar::Read(recipe) => recipe.timeline.clone(),
        _ => None,
    };
    window.history = History::new(window.step(), window.source.clone());
    if let Some((_, recipe)) = &document.restored {
        // What lies beside the photo can be returned to.
        window.edit = recipe.edit(window.making().view_size(&document.subject)[0]);
        window.repairs = recipe.repairs.clone();
        window.timeline = recipe.timeline.clone();
        window.history.note(&window.step());
    }
    window.toasts.clear();
    document.warnings.iter().for_each(|warning| window.toasts.info(warning.clone()));
    match window.repairs.are_of(&document.subject.sign()) {
        true => window.repairs.left_out().into_iter().for_each(|text| window.toasts.info(text)),
        false => window.toasts.info(OTHER_PHOTO.to_owned()),
    }
    if let Some(path) = document.path() {
        window.settings.remember(path);
    }
    ctx.send_viewport_cmd(ViewportCommand::Title(format!("{} — Plenoscope", document.subject.name)));
    window.open = Open::new(document);
    if let Some(rays) = rays {
        take_rays(window, rays);
    }
}

/// Ray depths are there: the first of a file, or others.
fn take_rays(window: &mut Window, rays: Rays) {
    if let Some(pictures) = &mut window.pictures {
        pictures.push_depths(&rays.depths);
    }
    if window.open.rays().is_none() && window.edit.focus == Focus::Subject {
        window.look.probe = rays.survey.subject.into();
    }
    window.open.take_rays(rays);
}

/// The light field is complete.
fn made(window: &mut Window, made: Made) {
    let is_again = matches!(window.loading, Loading::Again(_));
    window.loading = Loading::Idle;
    let generation = window.rest.begin();
    if window.open.photo().is_some() {
        window.compare.keep(window.asked.clone(), &made, generation, &window.source);
    }
    if let Some(pictures) = &mut window.pictures
        && let Some(views) = made.scene.views()
    {
        // Views of a photo's first light field have come one by one.
        if is_again || window.open.photo().is_none() {
            pictures.push_field(&views.field);
        }
    }
    if let Some(views) = made.scene.views().filter(|_| is_again) {
        window.edit.viewpoint = ViewPoint(views.field.grid().clamp(window.edit.viewpoint.0));
    }
    let is_other_source = window.open.scene().is_some_and(|old| old.made_by() != made.scene.made_by());
    let are_new = window.open.rays().is_none_or(|old| !Arc::ptr_eq(&old.depths, &made.rays.depths));
    if are_new {
        take_rays(window, made.rays.clone());
    }
    window.open.take_made(made);
    // Laid out anew, or measured otherwise: what was sharp lies at another disparity. Who compares comes back to it.
    let is_elsewhere = is_other_source || window.open.photo().is_none();
    if is_again && is_elsewhere && window.compare.at().is_none() {
        mend_focus(window);
    }
    let photo = window.open.document().filter(|document| document.subject.photo().is_some());
    if let Some(path) = photo.and_then(Document::path) {
        window.workers.ahead.replace(neighbours::Request::Prefetch(path.to_owned()));
    }
}

/// The light field that is shown, deeper or flatter: the pictures at rest of that strength are the same.
fn at_strength(window: &mut Window, made: Made) {
    if window.open.scene().is_some_and(|shown| is_same(shown, &made.scene)) {
        show(window, made);
    }
}

/// A light field that was made before takes the place of what is shown.
pub fn show_again(window: &mut Window, kept: Kept) {
    window.rest.resume(kept.generation);
    show(window, kept.made);
}

fn show(window: &mut Window, made: Made) {
    if let Some(pictures) = &mut window.pictures
        && let Some(views) = made.scene.views()
    {
        pictures.push_field(&views.field);
    }
    take_rays(window, made.rays.clone());
    window.open.take_made(made);
}

/// What mending depth was waiting for is there.
fn mending(window: &mut Window, answer: Answer, ctx: &Context) {
    match answer {
        Answer::Kit(generation, mender) => window.mending.take_kit(generation, mender),
        Answer::Outline(region, image) => window.mending.take_outline(region, image, ctx),
        Answer::Mended(made) => {
            let first = |scene: &Scene| Arc::as_ptr(scene.as_made().unmended().map());
            if window.open.scene().is_some_and(|shown| first(shown) == first(&made.scene)) {
                window.rest.begin();
                show(window, *made);
                window.mending.mended();
            }
        }
    }
}

/// A disparity in focus means another place in other ray depths: the subject is taken instead.
pub fn mend_focus(window: &mut Window) {
    if matches!(window.edit.focus, Focus::Disparity(_)) {
        window.focus_on_subject();
    }
}

/// A dialog of the system's, or the clipboard, has led somewhere.
fn picked(window: &mut Window, picked: Picked, ctx: &Context) {
    let action = match picked {
        Picked::Open(path) => Action::Open(OpenFrom::File(path)),
        Picked::Folder(path) => return window.settings.export.folder = Some(path),
        Picked::Photos(photos) => Action::Show(Dialog::Export(photos)),
        Picked::DepthMap { path, size, readings } => {
            let question = Question::new(&path, size, readings, ctx);
            match window.open.size() {
                Some(photo) if question.fits(photo) => Action::Show(Dialog::NearEnd(question)),
                _ => Action::Refuse(message!("other-shape")),
            }
        }
        Picked::Opening(opening) => Action::TakeOpening(opening),
        Picked::Models(folder) => Action::UseModels(folder),
        Picked::LightFields(path) => Action::TrainOn(path),
        Picked::Net(path) => Action::ChangeNets(Change::Add(path)),
        Picked::Pixels(size, rgba) => Action::Open(OpenFrom::pasted(size, rgba)),
        Picked::Edit(recipe) => Action::PasteEdit(recipe),
        Picked::Preset(recipe) => Action::TakePreset(recipe),
        Picked::Presets(names) => Action::Show(Dialog::Presets { names, new: String::new() }),
        Picked::Unavailable(wanted) => Action::Show(Dialog::Path(wanted, String::new())),
        Picked::NoFolderDialog => {
            return window.toasts.info(message!("no-folder-dialog"));
        }
        Picked::Nothing => return,
    };
    apply(window, action, ctx);
}
