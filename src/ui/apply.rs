//! The one place where actions change the window: one arm for each action, and for each command of the menu.

use super::adding::{self, Change};
use super::progress::{Loading, Running};
use std::path::{Path, PathBuf};

use egui::{Context, ViewportCommand};

use super::action::Action;
use super::ask::{Ask, Preset};
use super::command::Command;
use super::compare::{self, make_again};
use super::dialog::Dialog;
use super::document::Document;
use super::film::{self, Cut};
use super::hints::Hint;
use super::jobs::OpenFrom;
use super::look::{Face, Pose};
use super::neighbours;
use super::open::Open;
use super::queue::State;
use super::saver::{Order, Queued, Shown};
use super::training;
use super::window::Window;
use super::words::{message, t};
use crate::crash;
use crate::field::{LensShape, ViewOffset, ViewPoint};
use crate::io::formats::layout::Layout;
use crate::scene::export::Settings;
use crate::scene::{Content, DepthFrom, Edit, Recipe, Subject, layers};

/// Does what a person asked for.
pub fn apply(window: &mut Window, action: Action, ctx: &Context) {
    crash::note(action.name());
    if !matches!(action, Action::Do(Command::PlayFilm)) {
        // What is done while a film runs is done to the edit that it began with.
        film::stop(window);
    }
    match action {
        Action::Do(command) if can(window, command) => obey(window, command, ctx),
        Action::Do(_) => {}
        Action::Open(from) => window.open(from),
        Action::Ask(ask) => {
            window.workers.asker.push(ask);
        }
        Action::Show(dialog) => window.dialog = Some(dialog),
        Action::CloseDialog => window.dialog = None,
        Action::Tell(text) => window.toasts.info(text),
        Action::Refuse(why) => window.toasts.error(why),
        Action::LookFrom(at) => {
            window.look.is_circling = false;
            look_from(window, at);
        }
        Action::FocusOnSubject => window.focus_on_subject(),
        Action::Repair(repair) => window.repair(repair),
        Action::Unrepair(number) => {
            window.history.note(&window.step());
            window.repairs = window.repairs.without(number);
            window.history.note(&window.step());
        }
        Action::TakeOpening(opening) => window.edit.shape = LensShape::Picture(opening),
        Action::PasteEdit(recipe) => paste_edit(window, &recipe),
        Action::TakePreset(recipe) => {
            window.edit = recipe.lens_over(&window.edit);
            window.settings.export.picture = recipe.export.clone();
            window.toasts.info(message!("preset-applied"));
        }
        Action::KeepPreset(name) => {
            let recipe = Box::new(window.recipe());
            window.workers.asker.push(Ask::Presets(Preset::Keep(name, recipe)));
        }
        Action::TakeDepths(source) => {
            if source != DepthFrom::Map {
                window.settings.source = source.clone();
            }
            window.source = source;
            make_again(window);
        }
        Action::TakeMap(map) => {
            if let Some(document) = window.open.document_mut() {
                document.subject = Subject::clone(&document.subject).with_own_map(map).into();
            }
            // Another map may have been there before.
            window.compare.forget_source(&DepthFrom::Map);
            window.source = DepthFrom::Map;
            make_again(window);
        }
        Action::UseModels(folder) => {
            window.settings.models_folder = Some(folder);
            make_again(window);
        }
        Action::ChangeNets(what) => change_nets(window, what),
        Action::TrainOn(data) => training::choose(window, &data),
        Action::Train(wanted) => training::obey(window, wanted),
        Action::Learn(hint) => window.settings.hints.learn(hint),
        Action::MakeAgain => make_again(window),
        Action::StartExport(photos) => start_export(window, photos),
        Action::Cut(cut) => film::cut(window, cut),
        Action::Playhead(moment) => film::go(window, moment),
        Action::StopTask(job) => {
            if window.workers.saver.cancel(job) {
                window.queue.end(job, State::Stopped);
            }
        }
    }
}

/// Trying a net takes seconds and is shown; what else is done with nets is done at once.
fn change_nets(window: &mut Window, what: Change) {
    if let Change::Remove(name) = &what {
        compare::lose_net(window, name);
    }
    // What the automatic choice was it may be no longer.
    if !matches!(what, Change::Add(_)) {
        window.compare.forget_source(&DepthFrom::Auto);
    }
    let is_added = matches!(what, Change::Add(_));
    let job = window.workers.adder.push(adding::Request { what, making: window.making() });
    if is_added {
        window.adding = Some(Running::new(job));
    }
}

/// The commands that can be done now; the menu greys out the others.
pub fn possible(window: &Window) -> Vec<Command> {
    Command::ALL.into_iter().filter(|command| can(window, *command)).collect()
}

fn can(window: &Window, command: Command) -> bool {
    let open = &window.open;
    match command {
        Command::Export | Command::CopyPicture => open.scene().is_some(),
        Command::Nearer | Command::Farther => open.rays().is_some(),
        Command::PlayFilm => window.timeline.is_some() && open.scene().is_some(),
        Command::AddKey => open.scene().is_some(),
        Command::Earlier | Command::Later => window.timeline.is_some(),
        Command::Film => open.document().is_some(),
        Command::Peaking | Command::Trust | Command::Stereo => open.field().is_some(),
        Command::ResetViewpoint
        | Command::StepLeft
        | Command::StepRight
        | Command::StepUp
        | Command::StepDown
        | Command::Circle
        | Command::Views
        | Command::Points
        | Command::Depths
        | Command::ToggleDepth => open.grid().is_some(),
        Command::Opposite | Command::Transpose | Command::Serpentine => matches!(open, Open::LightField(_)),
        Command::OwnDepth | Command::BeforeAfter => open.photo().is_some(),
        Command::NextPhoto | Command::PreviousPhoto => {
            open.document().is_some_and(|document| document.path().is_some())
        }
        Command::CompareSources => open.photo().is_some() && open.scene().is_some(),
        Command::KeepSource => window.compare.at().is_some(),
        Command::Stop => window.is_busy() || window.compare.at().is_some() || window.mending.is_on,
        Command::Repair => open.scene().is_some(),
        Command::Undo => window.history.can_undo(&window.step()),
        Command::Redo => window.history.can_redo(&window.step()),
        Command::Fit
        | Command::OneToOne
        | Command::ZoomIn
        | Command::ZoomOut
        | Command::Picture
        | Command::CopyEdit
        | Command::PasteEdit
        | Command::ResetLens => open.document().is_some(),
        Command::ClearRecent => !window.settings.recent.is_empty(),
        _ => true,
    }
}

fn obey(window: &mut Window, command: Command, ctx: &Context) {
    let ask = |window: &Window, ask: fn(Option<PathBuf>) -> Ask| {
        let path = window.open.subject().and_then(|subject| subject.path.as_deref());
        window.workers.asker.push(ask(path.and_then(Path::parent).map(PathBuf::from)));
    };
    if window.look.face == Face::Points && window.points.obey(command) {
        return;
    }
    match command {
        Command::Open => ask(window, |folder| Ask::Open { folder }),
        Command::OpenFolder => ask(window, |folder| Ask::OpenFolder { folder }),
        Command::ExportPhotos => ask(window, |folder| Ask::Photos { folder }),
        Command::OwnDepth => ask(window, |folder| Ask::DepthMap { folder }),
        Command::Paste => ask(window, |_| Ask::Clipboard),
        Command::PasteEdit => ask(window, |_| Ask::PasteEdit),
        Command::Presets => ask(window, |_| Ask::Presets(Preset::List)),
        Command::OpenSample => window.open(OpenFrom::Sample),
        Command::NextPhoto => step_file(window, true),
        Command::PreviousPhoto => step_file(window, false),
        Command::Export => {
            window.settings.hints.learn(Hint::Export);
            window.dialog = Some(Dialog::Export(Vec::new()));
        }
        Command::Queue => window.queue.is_open = !window.queue.is_open,
        Command::CopyPicture => save_shown(window, None, t!("command-copy-picture").to_owned()),
        Command::Train => window.dialog = Some(Dialog::Training),
        Command::Settings => window.dialog = Some(Dialog::Settings),
        Command::Stop => stop(window, ctx),
        Command::Quit => ctx.send_viewport_cmd(ViewportCommand::Close),
        Command::Undo => {
            let step = window.history.undo(window.step());
            window.take_step(step);
        }
        Command::Redo => {
            let step = window.history.redo(window.step());
            window.take_step(step);
        }
        Command::Repair => hold_repair(window),
        Command::CopyEdit => {
            ctx.copy_text(window.recipe().to_json());
            window.toasts.info(message!("edit-copied"));
        }
        Command::ResetLens => {
            window.edit = Edit { viewpoint: window.edit.viewpoint, ..Edit::default() };
            window.focus_on_subject();
        }
        Command::ResetViewpoint => look_from(window, ViewOffset::default()),
        Command::StepLeft => step_view(window, -1.0, 0.0),
        Command::StepRight => step_view(window, 1.0, 0.0),
        Command::StepUp => step_view(window, 0.0, -1.0),
        Command::StepDown => step_view(window, 0.0, 1.0),
        Command::CompareSources => compare::next(window),
        Command::KeepSource => compare::keep(window),
        Command::Nearer => step_layer(window, true),
        Command::Farther => step_layer(window, false),
        Command::Film => window.film.is_shown = !window.film.is_shown,
        Command::PlayFilm => film::toggle(window, ctx.input(|input| input.time)),
        Command::AddKey => film::cut(window, Cut::Add),
        Command::Earlier => film::cut(window, Cut::Step(-1.0)),
        Command::Later => film::cut(window, Cut::Step(1.0)),
        Command::Circle => window.look.is_circling = !window.look.is_circling,
        Command::Opposite => lay_out(window, Layout::opposite),
        Command::Transpose => lay_out(window, |layout| Layout { transposed: !layout.transposed, ..layout }),
        Command::Serpentine => lay_out(window, |layout| Layout { serpentine: !layout.serpentine, ..layout }),
        _ => look(window, command, ctx),
    }
}

/// What changes nothing but how it is looked at.
fn look(window: &mut Window, command: Command, ctx: &Context) {
    let Window { look, settings, open, .. } = window;
    match command {
        Command::Picture => look.face = Face::Picture,
        Command::Views => look.face = Face::Views,
        Command::Depths => look.face = Face::Depths,
        Command::Points => look.face = Face::Points,
        Command::ToggleDepth => {
            look.face = if look.face == Face::Depths { Face::Picture } else { Face::Depths };
        }
        Command::BeforeAfter => look.split.is_shown = !look.split.is_shown,
        Command::Stereo => {
            let (next, told) = look.stereo.next();
            look.stereo = next;
            window.toasts.info(told);
        }
        Command::Peaking => settings.peaking = !settings.peaking,
        Command::Trust => settings.trust = !settings.trust,
        Command::Fit => look.pose = Pose::default(),
        Command::OneToOne | Command::ZoomIn | Command::ZoomOut => {
            let Some(size) = open.picture_size() else { return };
            match command {
                Command::OneToOne => look.pose.one_to_one(look.canvas, size, 1.0 / ctx.pixels_per_point()),
                Command::ZoomIn => look.zoom_by(size, 1.25),
                _ => look.zoom_by(size, 0.8),
            }
        }
        Command::ToggleInspector => {
            settings.has_inspector = !settings.has_inspector;
            look.is_drawer_open = !look.is_drawer_open;
        }
        Command::FullScreen => {
            let is_full = ctx.input(|input| input.viewport().fullscreen.unwrap_or(false));
            ctx.send_viewport_cmd(ViewportCommand::Fullscreen(!is_full));
        }
        Command::NextTheme => {
            use egui::ThemePreference as Theme;
            settings.theme = match settings.theme {
                Theme::Dark => Theme::Light,
                Theme::Light => Theme::System,
                Theme::System => Theme::Dark,
            };
            ctx.set_theme(settings.theme);
        }
        Command::ClearRecent => {
            settings.recent.clear();
            window.workers.recents.push(Vec::new());
        }
        Command::Shortcuts => {
            let is_shown = matches!(window.dialog, Some(Dialog::Shortcuts));
            window.dialog = (!is_shown).then_some(Dialog::Shortcuts);
        }
        _ => {}
    }
}

/// Opens the photo before or after this one.
fn step_file(window: &Window, is_next: bool) {
    if let Some(path) = window.open.document().and_then(Document::path) {
        window.workers.folder.replace(neighbours::Request::Step(path.to_owned(), is_next));
    }
}

/// Lays a recorded light field out anew; the old one stays until the new one has its ray depths.
fn lay_out(window: &mut Window, change: impl Fn(Layout) -> Layout) {
    let Some(document) = window.open.document() else { return };
    let Some(recorded) = document.subject.recorded() else { return };
    let content = Content::Views(recorded.laid_out(change(recorded.layout)));
    let subject = Subject { content, ..Subject::clone(&document.subject) };
    window.open(OpenFrom::Again(Box::new(Document::from(subject))));
}

/// Takes the tool that mends depth, or puts it away. Things are chosen in the picture or its depth.
fn hold_repair(window: &mut Window) {
    window.mending.is_on = !window.mending.is_on;
    window.mending.choose(None);
    if window.mending.is_on {
        // What is chosen lies in the reference view.
        look_from(window, ViewOffset::default());
        (window.settings.has_inspector, window.look.is_drawer_open) = (true, true);
        if matches!(window.look.face, Face::Views | Face::Points) {
            window.look.face = Face::Picture;
        }
    }
}

fn stop(window: &mut Window, ctx: &Context) {
    if window.mending.chosen().is_some() {
        window.mending.choose(None);
    } else if window.mending.is_on {
        window.mending.is_on = false;
    } else if window.compare.at().is_some() {
        compare::back(window);
    } else if let Some(job) = window.loading.running().map(|running| running.job) {
        // What had not begun says nothing any more.
        if window.workers.loader.cancel(job) {
            window.loading = Loading::Idle;
        }
    } else if let Some(job) = window.adding.as_ref().map(|running| running.job) {
        if window.workers.adder.cancel(job) {
            window.adding = None;
        }
    } else if let Some(job) = window.queue.current().map(|task| task.job) {
        apply(window, Action::StopTask(job), ctx);
    }
}

/// Moves the eye.
fn look_from(window: &mut Window, at: ViewOffset) {
    if let Some(grid) = window.open.grid() {
        window.edit.viewpoint = ViewPoint(grid.clamp(at));
    }
}

fn step_view(window: &mut Window, du: f32, dv: f32) {
    let at = window.edit.viewpoint.0;
    look_from(window, ViewOffset { dv: (at.dv + dv).round(), du: (at.du + du).round() });
}

/// Focuses on the depth layer before or behind the one that is in focus.
fn step_layer(window: &mut Window, is_nearer: bool) {
    let Some(rays) = window.open.rays() else { return };
    let before = window.open.lens(&window.edit);
    let layers = &rays.survey.layers_px;
    let number = layers::nearest(layers, before.focus.disparity_px);
    let number = if is_nearer { number.saturating_sub(1) } else { (number + 1).min(layers.len() - 1) };
    let mut after = before.clone();
    after.focus.disparity_px = layers[number];
    window.open.turn(&mut window.edit, &before, &after);
}

/// Applies an edit of another photo: its place is in focus here too.
fn paste_edit(window: &mut Window, recipe: &Recipe) {
    let Some(subject) = window.open.subject() else {
        window.toasts.error(message!("edit-no-photo"));
        return;
    };
    window.edit = recipe.edit(window.making().view_size(subject)[0]);
    // Repairs belong to their photo.
    if !recipe.repairs.is_empty() && recipe.repairs.are_of(&subject.sign()) {
        window.repairs = recipe.repairs.clone();
    }
    let at = window.edit.viewpoint.0;
    look_from(window, at);
    window.toasts.info(message!("edit-applied"));
}

/// Starts the export that the dialog describes: of other photos, or of what is open.
fn start_export(window: &mut Window, photos: Vec<PathBuf>) {
    let settings = &window.settings.export;
    if photos.is_empty() {
        let Some(document) = window.open.document() else { return };
        let target = settings.target(document.path(), &document.subject.name, &window.edit);
        let title = name(&target);
        save_shown(window, Some(target), title);
        return;
    }
    window.queue.is_open = true;
    for path in photos {
        let (title, settings, making) = (name(&path), window.settings.export.clone(), window.making());
        let target = settings.target(Some(&path), &title, &window.edit);
        let recipe = Recipe::new(window.edit.clone(), settings.picture.clone());
        let job = window.workers.saver.push(Order::File(Box::new(Queued { path, recipe, settings, target, making })));
        window.queue.add(job, title);
    }
}

/// Saves what is shown, or copies it where there is no target.
fn save_shown(window: &mut Window, target: Option<PathBuf>, title: String) {
    let Some(scene) = window.open.scene().cloned() else {
        window.toasts.error(message!("nothing-to-export"));
        return;
    };
    let recipe = window.recipe().of_depth(window.source.clone());
    let settings = Settings { recipe, ..window.settings.export.clone() };
    let shown = Shown { scene, edit: window.edit.clone(), settings, target };
    let job = window.workers.saver.push(Order::Shown(Box::new(shown)));
    window.queue.add(job, title);
}

fn name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}
