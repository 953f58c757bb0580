//! Depth mended by hand: the tool that is held, what it has chosen, the stroke that is drawn, and the list of repairs.
//!
//! A stroke's draft is a map of the views' size, changed point by point in the frame that hears of it. Outlines, that
//! map, and the light field with all repairs come from a thread ([`work`]).

use egui::{ColorImage, TextureHandle, TextureOptions};

use super::event::Event;
use super::jobs::Progressing;
use super::open::Made;
use super::progress::Running;
use super::theme;
use super::words::{Id, id};
use super::worker::{JobId, Outbox};
use crate::errors::sentence;
use crate::field::DisparityMap;
use crate::job::{Cancel, Job, Progress, Stage};
use crate::render::cpu::Colormap;
use crate::repair::{Brush, Draft, Guide, Mender, Operation, Place, Region, Repair, Repairs, Stroke};
use crate::scene::{Making, Need, Scene, SceneError};

/// What the hand does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tool {
    /// Chooses the thing that is clicked.
    Thing,
    /// Draws round a thing.
    Lasso,
    /// Paints.
    Brush(Brush),
}

impl Tool {
    /// All of them, with what they are called.
    pub const ALL: [(Self, Id); 6] = [
        (Self::Thing, id!("tool-thing")),
        (Self::Lasso, id!("tool-lasso")),
        (Self::Brush(Brush::Nearer), id!("tool-nearer")),
        (Self::Brush(Brush::Farther), id!("tool-farther")),
        (Self::Brush(Brush::Smooth), id!("tool-smooth")),
        (Self::Brush(Brush::Sharpen), id!("tool-edge")),
    ];
}

/// How far a lasso moves to an edge, as a share of the longer side.
const SNAP: f32 = 0.015;
/// Points of a path that lie closer than this are one, as a share of a side.
const CLOSE: f32 = 0.002;
/// How clearly the draft of a stroke covers the picture.
const DRAFT_ALPHA: f32 = 0.75;

/// The tool and all that it holds.
pub struct Mending {
    /// Whether it is held.
    pub is_on: bool,
    /// What it does.
    pub tool: Tool,
    /// How far a thing reaches, as a share of the longer side.
    pub reach: f32,
    /// By how much a thing is moved, in pixels of views of the usual width.
    pub by_px: f32,
    /// Diameter of the brush, as a share of the longer side.
    pub brush: f32,
    /// How much the brush does, 0 … 1.
    pub strength: f32,
    /// The repair that the pointer is on in the list.
    pub pointed_at: Option<usize>,
    /// The light field that is being mended.
    pub running: Option<Running>,
    chosen: Option<Region>,
    outline: Option<(Region, TextureHandle)>,
    outline_asked_for: Option<(u64, Region)>,
    path: Vec<Place>,
    kit: Option<(u64, Box<Mender>)>,
    kit_asked_for: Option<u64>,
    hand: Option<Hand>,
    mended_for: Option<(u64, Repairs)>,
}

impl Default for Mending {
    fn default() -> Self {
        Self {
            is_on: false,
            tool: Tool::Thing,
            reach: Self::REACH,
            by_px: Self::BY_PX,
            brush: Self::BRUSH,
            strength: Self::STRENGTH,
            pointed_at: None,
            running: None,
            chosen: None,
            outline: None,
            outline_asked_for: None,
            path: Vec::new(),
            kit: None,
            kit_asked_for: None,
            hand: None,
            mended_for: None,
        }
    }
}

/// A stroke that is being drawn, or whose light field is being made.
struct Hand {
    mender: Mender,
    draft: Draft,
    image: ColorImage,
    texture: TextureHandle,
    is_down: bool,
}

/// What the thread is asked for.
pub enum Request {
    /// The map that drafts are made on.
    Kit(u64, Scene),
    /// The pixels of a thing.
    Outline(Region, Box<Mender>),
    /// The light field with these repairs.
    Mend(Box<Scene>, Repairs, Box<Making>),
}

/// What the thread answers.
pub enum Answer {
    /// The map that drafts of a light field are made on.
    Kit(u64, Box<Mender>),
    /// A thing's pixels, tinted.
    Outline(Region, ColorImage),
    /// The light field, mended.
    Mended(Box<Made>),
}

impl Mending {
    /// How far a thing reaches at first.
    pub const REACH: f32 = 0.15;
    /// By how much a thing is moved at first.
    pub const BY_PX: f32 = 0.25;
    /// The brush's diameter at first.
    pub const BRUSH: f32 = 0.06;
    /// The brush's strength at first.
    pub const STRENGTH: f32 = 0.5;
    /// Reaches and diameters that can be set.
    pub const SIZES: [f32; 2] = [0.005, 1.0];

    /// Another file is open.
    pub fn forget(&mut self) {
        let Self { is_on, tool, reach, by_px, brush, strength, .. } = *self;
        *self = Self { is_on, tool, reach, by_px, brush, strength, ..Self::default() };
    }

    /// The thing that is chosen.
    pub fn chosen(&self) -> Option<&Region> {
        self.chosen.as_ref()
    }

    /// Chooses a thing, or none.
    pub fn choose(&mut self, region: Option<Region>) {
        if region.is_none() {
            self.outline = None;
        }
        self.chosen = region;
    }

    /// The lasso that is being drawn.
    pub fn lasso(&self) -> Option<&[Place]> {
        (self.tool == Tool::Lasso && !self.path.is_empty()).then_some(&self.path[..])
    }

    /// Grows or shrinks what the tool reaches.
    pub fn grow(&mut self, factor: f32) {
        let [least, most] = Self::SIZES;
        let size = if matches!(self.tool, Tool::Brush(_)) { &mut self.brush } else { &mut self.reach };
        *size = (*size * factor).clamp(least, most);
        let reach = self.reach;
        if let Some(Region::Click { size, .. }) = &mut self.chosen {
            *size = reach;
        }
    }

    /// The tinted pixels of the chosen thing, as they were last found.
    pub fn outline(&self) -> Option<&TextureHandle> {
        self.outline.as_ref().filter(|_| self.chosen.is_some()).map(|(_, texture)| texture)
    }

    /// The depth as the stroke leaves it, over the picture.
    pub fn draft(&self) -> Option<&TextureHandle> {
        self.hand.as_ref().map(|hand| &hand.texture)
    }

    /// The pointer goes down at a place, or on to one.
    pub fn draw_to(&mut self, place: Place, look: ([f32; 2], Colormap), ctx: &egui::Context) {
        let far = |last: &Place| (last[0] - place[0]).abs().max((last[1] - place[1]).abs()) > CLOSE;
        if !self.path.last().is_none_or(far) {
            return;
        }
        if let (true, Tool::Brush(brush), Some((_, kit))) = (self.path.is_empty(), self.tool, &self.kit) {
            self.hand = Some(Hand::new(kit, brush, [self.brush, self.strength], ctx));
        }
        self.path.push(place);
        if let Some(hand) = &mut self.hand {
            hand.extend(place, look);
        }
    }

    /// The pointer goes up: what was drawn is a stroke, or chooses a thing.
    pub fn finish(&mut self) -> Option<Repair> {
        let path = std::mem::take(&mut self.path);
        if let Some(hand) = &mut self.hand {
            hand.is_down = false;
        }
        match self.tool {
            Tool::Brush(brush) if !path.is_empty() => {
                Some(Repair::Stroke(Stroke { brush, path, size: self.brush, strength: self.strength }))
            }
            Tool::Lasso if path.len() > 2 => {
                self.choose(Some(Region::Lasso { outline: path, snap: SNAP }));
                None
            }
            _ => None,
        }
    }

    /// What is to be asked of the thread now, for the light field with this number.
    pub fn ask(&mut self, generation: u64, scene: &Scene, repairs: &Repairs, how: &Making) -> Option<Request> {
        if *scene.repairs() != *repairs {
            let wanted = Some((generation, repairs.clone()));
            if self.hand.as_ref().is_some_and(|hand| hand.is_down) || self.mended_for == wanted {
                return None;
            }
            self.mended_for = wanted;
            return Some(Request::Mend(Box::new(scene.clone()), repairs.clone(), Box::new(how.clone())));
        }
        if !self.is_on {
            return None;
        }
        let Some((_, kit)) = self.kit.as_ref().filter(|(of, _)| *of == generation) else {
            let is_new = self.kit_asked_for.replace(generation) != Some(generation);
            return is_new.then(|| Request::Kit(generation, scene.clone()));
        };
        let region = self.chosen.clone()?;
        let is_known = self.outline.as_ref().is_some_and(|(known, _)| *known == region);
        let wanted = Some((generation, region.clone()));
        if is_known || self.outline_asked_for == wanted {
            return None;
        }
        self.outline_asked_for = wanted;
        Some(Request::Outline(region, kit.clone()))
    }

    /// The thread mends the light field now.
    pub fn begun(&mut self, job: JobId) {
        let mut running = Running::new(job);
        running.tell(Progress { stage: Stage::Mend, done: 0, total: 1 });
        self.running = Some(running);
    }

    /// The map that drafts are made on is there.
    pub fn take_kit(&mut self, generation: u64, mender: Box<Mender>) {
        self.kit = Some((generation, mender));
        // What was found on another map is found anew.
        self.outline_asked_for = None;
    }

    /// A thing's pixels are there.
    pub fn take_outline(&mut self, region: Region, image: ColorImage, ctx: &egui::Context) {
        let texture = ctx.load_texture("thing", image, TextureOptions::LINEAR);
        self.outline = Some((region, texture));
    }

    /// The light field is mended: it takes the draft's place.
    pub fn mended(&mut self) {
        self.mended_for = None;
        if self.hand.as_ref().is_some_and(|hand| !hand.is_down) {
            self.hand = None;
        }
    }

    /// The chosen thing with something done to it.
    pub fn repair(&self, what: Operation) -> Option<Repair> {
        Some(Repair::Region { of: self.chosen.clone()?, what })
    }
}

impl Hand {
    fn new(kit: &Mender, brush: Brush, [size, strength]: [f32; 2], ctx: &egui::Context) -> Self {
        let mender = kit.clone();
        let draft = mender.begin(brush, size, strength);
        let image = ColorImage::filled(mender.sides(), egui::Color32::TRANSPARENT);
        let texture = ctx.load_texture("stroke", image.clone(), TextureOptions::NEAREST);
        Self { mender, draft, image, texture, is_down: true }
    }

    /// Goes on to a place, and draws what has changed there.
    fn extend(&mut self, place: Place, (range_px, map): ([f32; 2], Colormap)) {
        let Some(rect) = self.mender.extend(&mut self.draft, place) else { return };
        let width = self.image.size[0];
        let mut part = ColorImage::filled(rect.size, egui::Color32::TRANSPARENT);
        for y in 0..rect.size[1] {
            for x in 0..rect.size[0] {
                let i = (rect.at[1] + y) * width + rect.at[0] + x;
                if self.draft.has(i) {
                    let place = (self.mender.disparity_px()[i] - range_px[0]) / (range_px[1] - range_px[0]);
                    let [r, g, b] = map.srgb(place.clamp(0.0, 1.0)).map(|c| (c * 255.0 + 0.5) as u8);
                    self.image.pixels[i] = egui::Color32::from_rgb(r, g, b).gamma_multiply(DRAFT_ALPHA);
                }
                part.pixels[y * rect.size[0] + x] = self.image.pixels[i];
            }
        }
        self.texture.set_partial(rect.at, part, TextureOptions::NEAREST);
    }
}

/// The work of the thread.
pub fn work(job: JobId, request: Request, cancel: &Cancel, outbox: &Outbox) {
    let answer = match request {
        Request::Kit(generation, scene) => kit(&scene).map(|mender| Answer::Kit(generation, Box::new(mender))),
        Request::Outline(region, mender) => Ok(Answer::Outline(region.clone(), tinted(&mender, &region))),
        Request::Mend(scene, repairs, how) => {
            let (task, strength) = (Job { cancel, sink: &Progressing(job, outbox) }, scene.strength());
            let mended = scene.mended(&repairs, &task);
            let made = mended.and_then(|mended| mended.at_strength(strength, &how, Need::Views, &task));
            made.and_then(Made::of).map(|made| Answer::Mended(Box::new(made)))
        }
    };
    let event = match answer {
        _ if cancel.is_cancelled() => Event::Stopped,
        Ok(answer) => Event::Mending(answer),
        Err(error) => Event::Failed(sentence(&error).into()),
    };
    outbox.send(job, event);
}

/// A mender of the views' size, at strength 1: repairs are kept so.
fn kit(scene: &Scene) -> Result<Mender, SceneError> {
    let reference = scene.made_views()?.field.reference();
    let map: DisparityMap = scene.as_made().map().resized(reference.size())?;
    Ok(Mender::new(&map, Guide::new(reference, reference.size())))
}

/// A thing's pixels, its rim clearer.
fn tinted(mender: &Mender, region: &Region) -> ColorImage {
    let mask = mender.region(region);
    let [inside, rim] = [0.22, 0.95].map(|alpha| theme::PEAK.gamma_multiply(alpha));
    let pixel = |i: usize| match mask.has(i) {
        true if mask.is_rim(i) => rim,
        true => inside,
        false => egui::Color32::TRANSPARENT,
    };
    ColorImage::new(mask.sides(), (0..mask.sides()[0] * mask.sides()[1]).map(pixel).collect())
}
