//! What the window holds: what is open, what is done to it, how it is looked at, and the threads behind it.

use super::event::Listed;
use std::path::PathBuf;

use eframe::egui_wgpu::RenderState;

use super::compare::{Compare, Kept};
use super::dialog::{Broke, Dialog};
use super::document::{Document, Sidecar};
use super::field_pictures::FieldPictures;
use super::film::Film;
use super::history::{History, Keep, Step};
use super::jobs::{Load, OpenFrom};
use super::look::Look;
use super::mending::Mending;
use super::open::Open;
use super::points::Points;
use super::progress::{Loading, Running};
use super::queue::Queue;
use super::rest::AtRest;
use super::settings::Settings;
use super::sources::{self, Choice};
use super::strength::Shaping;
use super::tiles::Tiled;
use super::toasts::Toasts;
use super::training::Training;
use super::trust::Tint;
use super::words::{self, Language, message};
use super::worker::Outbox;
use super::workers::Workers;
use crate::crash;
use crate::repair::{MOST, Repair, Repairs};
use crate::scene::real::{KnownLens, known_lenses, published_lenses};
use crate::scene::training::{Trainer, TrainingError};
use crate::scene::{Content, DepthFrom, Edit, Focus, Making, OnePhoto, Recipe, Timeline};
use crate::synth::adopt::Shelf;
use crate::synth::{ModelSource, Scale};

/// What the window is started with.
#[derive(Clone, Debug)]
pub struct Options {
    /// Files to open; the first one is shown.
    pub files: Vec<PathBuf>,
    /// Where the nets come from.
    pub models: ModelSource,
    /// The nets that the person added.
    pub shelf: Option<Shelf>,
    /// The trainer; none is the one beside the program, or on the path.
    pub trainer: Option<PathBuf>,
    /// Where reports of faults lie, to be offered.
    pub crashes: Option<PathBuf>,
    /// The language of the window by its tag; none is what the settings say.
    pub language: Option<String>,
    /// Long side of a view, in pixels; none is what the settings say.
    pub long_side: Option<u32>,
    /// Threads for the nets; 0 is one for each core.
    pub threads: usize,
    /// Whether the file of the last run is opened when none is named.
    pub restores_last: bool,
}

/// All that the window holds. Panels borrow parts of it; actions and letters of the threads change it.
pub struct Window {
    /// Kept between runs.
    pub settings: Settings,
    /// What is open.
    pub open: Open,
    /// What is being opened or made.
    pub loading: Loading,
    /// What is done to the picture.
    pub edit: Edit,
    /// What was done before.
    pub history: History,
    /// How it is looked at.
    pub look: Look,
    /// The tool that mends depth.
    pub mending: Mending,
    /// What was done to the depth.
    pub repairs: Repairs,
    /// What moves in a film of it.
    pub timeline: Option<Timeline>,
    /// How that is looked at.
    pub film: Film,
    /// What was invented.
    pub tint: Tint,
    /// The scene as points.
    pub points: Points,
    /// The light field on the device.
    pub pictures: Option<FieldPictures>,
    /// The photo on the device.
    pub photo: Option<Tiled>,
    /// The strength that is on its way.
    pub shaping: Shaping,
    /// What is drawn over the draft.
    pub rest: AtRest,
    /// What is being exported.
    pub queue: Queue,
    /// What is told in a corner.
    pub toasts: Toasts,
    /// The dialog that is shown.
    pub dialog: Option<Dialog>,
    /// Small pictures of recent files.
    pub thumbnails: Vec<(PathBuf, egui::TextureHandle)>,
    /// Languages that can be spoken.
    pub languages: Vec<&'static Language>,
    /// Lenses that are known by name.
    pub lenses: Vec<KnownLens>,
    /// Further depth nets that ray depths can come from.
    pub models: Vec<Listed>,
    /// Where the ray depths of what is open come from, as it was chosen for it.
    pub source: DepthFrom,
    /// What was made of the open photo, and what is compared.
    pub compare: Compare,
    /// How what is open, or on its way, is made.
    pub asked: Making,
    /// Whether the net that made the light field is being taken away, so that it is to be made anew.
    pub loses_net: bool,
    /// What is trained.
    pub training: Training,
    /// The net that is being tried.
    pub adding: Option<Running>,
    /// Threads for the nets; 0 is one for each core.
    pub threads: usize,
    /// The threads.
    pub workers: Workers,
    started_with: ModelSource,
    trainer: Option<PathBuf>,
    /// The nets that the person added.
    shelf: Option<Shelf>,
}

/// What broke the last time, as a question.
fn offer(options: &Options) -> Option<Dialog> {
    let report = crash::take_unseen(options.crashes.as_deref()?)?;
    Some(Dialog::Broke(Box::new(Broke { report, is_shown: false })))
}

impl Window {
    /// A window with nothing in it. `remembers`: whether what is opened is kept for the next time.
    pub fn new(
        options: &Options,
        settings: Settings,
        outbox: &Outbox,
        render: Option<&RenderState>,
        remembers: bool,
    ) -> Self {
        let pictures = render.map(FieldPictures::new);
        let (lenses, broken) = if remembers { known_lenses() } else { (published_lenses(), Vec::new()) };
        let (languages, unreadable) = words::all(remembers);
        words::speak(words::best(&languages, settings.language.as_deref()));
        let mut toasts = Toasts::default();
        unreadable.into_iter().for_each(|fault| toasts.info(fault));
        broken.iter().for_each(|error| toasts.info(error.to_string()));
        Self {
            edit: settings.edit.clone(),
            settings,
            open: Open::default(),
            loading: Loading::default(),
            history: History::default(),
            look: Look::default(),
            mending: Mending::default(),
            tint: Tint::default(),
            points: Points::default(),
            repairs: Repairs::default(),
            timeline: None,
            film: Film::default(),
            photo: None,
            shaping: Shaping::default(),
            // A slow device drafts with every second view.
            rest: AtRest::of_every(if pictures.as_ref().is_some_and(FieldPictures::is_software) { 2 } else { 1 }),
            queue: Queue::default(),
            toasts,
            dialog: offer(options),
            thumbnails: Vec::new(),
            languages,
            lenses,
            models: Vec::new(),
            source: DepthFrom::Auto,
            compare: Compare::default(),
            asked: Making::default(),
            loses_net: false,
            training: Training::default(),
            adding: None,
            threads: options.threads,
            workers: Workers::spawn(outbox, pictures.as_ref(), remembers),
            pictures,
            started_with: options.models.clone(),
            trainer: options.trainer.clone(),
            shelf: options.shelf.clone(),
        }
    }

    /// The program that trains.
    ///
    /// # Errors
    /// There is none.
    pub fn trainer(&self) -> Result<Trainer, TrainingError> {
        self.trainer.as_deref().map_or_else(Trainer::found, |program| Ok(Trainer::new(program)))
    }

    /// Whether something is being opened, made or saved.
    pub fn is_busy(&self) -> bool {
        self.loading.running().is_some() || self.adding.is_some() || self.queue.is_busy()
    }

    /// Opens something; what is open stays usable until the new one is there.
    pub fn open(&mut self, from: OpenFrom) {
        self.keep_edit();
        let is_again = matches!(from, OpenFrom::Again(_));
        let source = if is_again { self.source.clone() } else { self.settings.source.clone() };
        self.load(from, Making { source, ..self.making() });
    }

    fn load(&mut self, from: OpenFrom, making: Making) {
        let is_again = matches!(from, OpenFrom::Again(_));
        self.asked = making.clone();
        let running = Running::new(self.workers.loader.replace(Load { from, making }));
        self.loading = if is_again { Loading::Again(running) } else { Loading::Opening(running) };
    }

    /// How light fields are made.
    pub fn making(&self) -> Making {
        let models = match (&self.started_with, &self.settings.models_folder) {
            (ModelSource::Embedded, Some(folder)) => ModelSource::Folder(folder.clone()),
            (started_with, _) => started_with.clone(),
        };
        let Settings { long_side, occlusion, .. } = &self.settings;
        Making {
            long_side: *long_side,
            occlusion: *occlusion,
            threads: self.threads,
            source: self.source.clone(),
            scale: Scale::default(),
            models,
            shelf: self.shelf.clone(),
            // Mended light fields are made of those that are open.
            repairs: Repairs::default(),
            strength: None,
        }
    }

    /// Takes what is known of the open photo's light field made in another way, or has it made. What is returned was
    /// made before.
    pub fn make(&mut self, making: Making) -> Option<Kept> {
        let document = self.open.document().filter(|document| document.subject.photo().is_some())?.clone();
        let kept = self.compare.take(&making);
        match kept {
            Some(_) => {
                self.workers.loader.stop();
                self.loading = Loading::Idle;
                self.asked = making;
            }
            None => self.load(OpenFrom::Again(Box::new(document)), making),
        }
        kept
    }

    /// All sources of depth that the open photo has.
    pub fn sources(&self) -> Vec<Choice> {
        self.one_photo().map(|one| sources::choices(one, &self.models)).unwrap_or_default()
    }

    /// The source of depth that is chosen for the open photo, as it stands among [`sources`](Self::sources).
    pub fn chosen(&self) -> DepthFrom {
        self.one_photo().map_or_else(|| self.source.clone(), |one| sources::present(&self.source, one, &self.models))
    }

    /// The source of depth that is looked at: that which is compared, or the chosen one.
    pub fn looked_at(&self) -> DepthFrom {
        self.compare.at().cloned().unwrap_or_else(|| self.chosen())
    }

    fn one_photo(&self) -> Option<&OnePhoto> {
        match &self.open.subject()?.content {
            Content::Photo(one) => Some(one),
            Content::Views(_) => None,
        }
    }

    /// Focuses where the subject most likely is.
    pub fn focus_on_subject(&mut self) {
        self.edit.focus = Focus::Subject;
        if let Some(rays) = self.open.rays() {
            self.look.probe = rays.survey.subject.into();
        }
    }

    /// Puts the edit beside the photo, if it has changed.
    pub fn keep_edit(&mut self) {
        if let Some(keep) = self.unkept() {
            self.workers.sidecar.push(keep);
        }
    }

    /// The edit, where it is to lie beside the photo and does not yet.
    pub fn unkept(&mut self) -> Option<Keep> {
        let document = self.open.document()?;
        let photo = document.subject.path.clone().filter(|_| document.subject.photo().is_some())?;
        let found = document.found;
        let is_kept = self.settings.keeps_edits && !matches!(document.sidecar, Sidecar::Unreadable);
        if !is_kept
            || self.look.is_circling
            || self.film.is_playing()
            || !self.history.take_unkept(&self.step(), &self.source)
        {
            return None;
        }
        let recipe = self.recipe();
        if let Some(document) = self.open.document_mut() {
            document.sidecar = Sidecar::Read(Box::new(recipe.clone()));
        }
        Some(Keep { photo, recipe, found })
    }

    /// The edit as a recipe, with what else its file held.
    pub fn recipe(&self) -> Recipe {
        let mut recipe = self.open.document().and_then(Document::recipe).cloned().unwrap_or_default();
        recipe.export = self.settings.export.picture.clone();
        recipe.timeline = self.timeline.clone();
        recipe.with_edit(self.edit.clone()).with_depth(&self.source).with_repairs(self.repairs.clone())
    }

    /// All that is undone as one.
    pub fn step(&self) -> Step {
        Step { edit: self.edit.clone(), repairs: self.repairs.clone(), timeline: self.timeline.clone() }
    }

    /// Puts back what was undone or done again.
    pub fn take_step(&mut self, step: Step) {
        (self.edit, self.repairs, self.timeline) = (step.edit, step.repairs, step.timeline);
    }

    /// Mends the depth; each repair is undone apart from others.
    pub fn repair(&mut self, repair: Repair) {
        let Some(subject) = self.open.subject() else { return };
        match self.repairs.with(repair, Some(&subject.sign())) {
            Some(repairs) => {
                self.history.note(&self.step());
                self.repairs = repairs;
                self.history.note(&self.step());
            }
            None => self.toasts.error(message!("repair-refused", most = MOST)),
        }
    }
}
