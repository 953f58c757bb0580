//! The data engine: light fields with exact ray depths, composed on the fly from photos.
//!
//! [`Source::new`] decodes everything once; [`Source::sample`] is then a pure function of the seed and an index, so
//! a run can be repeated to the byte and resumed anywhere, from any number of threads. Kinds of sample ([`Kind`]):
//!
//! * **Lifted**: a masked photo as two layers, the subject with a soft edge before its surround, which is filled in
//!   behind it. Where the photo has a nearness map too, the map gives both layers their depth.
//! * **Collage**: one photo's background, cut-outs of others, blades, stems and leaves at sorted depths, each blurred
//!   by its distance from the focal plane. The ground may rise in any direction or be a fence, a wall, a hedge;
//!   subjects may hang anywhere: this is what keeps a net from believing that lower is always nearer.
//! * **Pseudo**: a nearness map lifted to ray depths of all views, by following each ray to its first crossing. Before
//!   every third one stands a cut-out of another photo, anywhere: what stands out is near, wherever it is.
//! * **Real**: windows of real light fields, near and wide; the reference view's ray depth is what a sweep over the views finds.
//! * **Solid**: scenes in three dimensions ([`solid`]), drawn from every view's own centre.
//!
//! On any of them may fall light that says nothing about depth (`shading`).
//!
//! Nearness 0 … 1 becomes a disparity of `range · (nearness − 0.85)` with a range of 1.2 px per view step at a long
//! side of 288 px, in proportion at others: the focal plane lies at the subject, backgrounds are negative.

mod collage;
mod cutout;
mod error;
mod fields;
pub mod layer;
mod library;
mod lifted;
mod manifest;
mod mix;
mod place;
mod plants;
pub mod raster;
mod real;
mod sample;
mod shading;
pub mod solid;
mod steady;
pub mod teach;
mod walls;
pub mod write;

#[cfg(test)]
mod tests;

use std::path::PathBuf;

use plenoscope::field::ViewGrid;
use serde::{Deserialize, Serialize};

use crate::rng::Rng;
pub use error::SceneError;
pub use fields::{Field, VALIDATION_LIGHT_FIELDS};
use layer::Scene;
pub use library::{Library, Picture, measured, read_rgb};
pub use mix::Mix;
use place::{Canvas, Place};
pub use sample::Sample;
use shading::Shade;
pub use solid::Curve;
use solid::Stock;

/// Layer of the reference view (4, 4).
pub const REFERENCE: usize = 36;
/// Usual share of lifted maps whose depth was measured.
pub const MEASURED: f32 = 0.15;
/// Usual share of lifted maps whose depth was not measured that are rooms with good maps.
pub const ROOMS: f32 = 0.2;
/// By how much the picture is larger of which a fine sample is a window: one of these.
pub const FINE: [usize; 2] = [2, 3];
/// Share of the rest that show flowers.
const FLOWERS: f32 = 0.2;
/// Tells the chance of turned photos from that of all else.
const TURNING: u64 = 0x7475_726e;
/// Tells the chance of shading from that of all else.
const SHADING: u64 = 0x7368_6164;
/// Nearness of the focal plane.
pub const FOCAL_NEARNESS: f32 = 0.85;

/// Which side of the split.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Split {
    /// To learn from.
    Train,
    /// To be judged by.
    #[serde(alias = "test")]
    Val,
}

/// What samples are made of and how.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// The folder that holds `flowers/`, `everyday/`, `everyday10k/`, `photos_depth/`, `lightfields/`, `meshes/` and
    /// `textures/`, or some of them.
    pub data: PathBuf,
    /// Maps of photos that take the place of those beside them, as `teach` writes them.
    pub maps: Option<PathBuf>,
    /// Long side in pixels of the whole picture: the working scale.
    pub long_side: usize,
    /// Width and height of a sample; never larger than `long_side`.
    pub crop: [usize; 2],
    /// Views in a sample, the reference view among them: 1 … 64.
    pub views_per_sample: usize,
    /// So many samples in a row have the same views (a batch).
    pub views_group: u64,
    /// Shares of the kinds.
    pub mix: Mix,
    /// Share of flowers (against everyday photos) among lifted photos and cut-outs.
    pub flowers: f32,
    /// Seed of everything.
    pub seed: u64,
    /// Training or validation pictures.
    pub split: Split,
    /// Camera noise on every view, where samples are augmented.
    pub noise: bool,
    /// Random crops, colours, noise and depths. Without, photos are whole (`crop` does not count) and as they are.
    pub augment: bool,
    /// How far framing, shape and colours of augmented samples vary; 1 is as much as photos do among themselves.
    pub variety: f32,
    /// Factors between which the ray depths of augmented samples are stretched. Where they differ, the focal plane lies
    /// anywhere from the far side to the near one in half of them: what works on ray depths must take any.
    pub stretch: [f32; 2],
    /// What the disparity of scenes in three dimensions is linear in.
    pub curve: Curve,
    /// Share of lifted maps whose depth was measured.
    pub measured: f32,
    /// Share of the other lifted maps that are rooms with good maps.
    pub rooms: f32,
    /// Share of lifted maps that lie on a side or upside down: what the row tells of them is wrong.
    pub turned: f32,
    /// Share of augmented samples on which falls light that says nothing about depth.
    pub shading: f32,
    /// Share of scenes in three dimensions that show what nets read wrongly: bare tops under uneven light, bright upper
    /// walls, portraits, wide land and streets under clouds, flowers from near, things on ledges and blossoms on boughs before the wide world.
    pub pitfalls: f32,
    /// Share of scenes in three dimensions of which a window is shown, [`FINE`] times as large: what passes
    /// over larger pictures see. Their ray depths spread as far as those of whole ones.
    pub fine: f32,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            data: PathBuf::from("data"),
            maps: None,
            long_side: 192,
            crop: [192, 144],
            views_per_sample: 5,
            views_group: 1,
            mix: Mix::default(),
            flowers: 0.6,
            seed: 1,
            split: Split::Train,
            noise: true,
            augment: true,
            variety: 1.0,
            stretch: [1.0; 2],
            curve: Curve::Camera,
            measured: MEASURED,
            rooms: ROOMS,
            turned: 0.0,
            shading: 0.0,
            pitfalls: 0.0,
            fine: 0.0,
        }
    }
}

impl Config {
    /// Pixels per view step between nearness 0 and 1.
    pub fn range_px(&self) -> f32 {
        1.2 * self.long_side as f32 / 288.0
    }

    fn check(&self) -> Result<(), SceneError> {
        let wrong = |what, got: String, expected| Err(SceneError::Config { what, got, expected });
        if !(32..=1024).contains(&self.long_side) {
            return wrong("long_side", self.long_side.to_string(), "32 to 1024 pixels");
        }
        if self.crop.iter().any(|side| !(16..=self.long_side).contains(side)) {
            return wrong("crop", format!("{:?}", self.crop), "two sides from 16 pixels to long_side");
        }
        if !(0.0..=4.0).contains(&self.variety) {
            return wrong("variety", self.variety.to_string(), "0 to 4");
        }
        let [least, most] = self.stretch;
        if !(0.0 < least && least <= most && most <= 8.0) {
            return wrong(
                "stretch",
                format!("{least} to {most}"),
                "two factors above 0 and up to 8, the smaller one first",
            );
        }
        if !(1..=64).contains(&self.views_per_sample) {
            return wrong("views_per_sample", self.views_per_sample.to_string(), "1 to 64");
        }
        let parts = [
            ("measured", self.measured),
            ("rooms", self.rooms),
            ("turned", self.turned),
            ("shading", self.shading),
            ("pitfalls", self.pitfalls),
            ("fine", self.fine),
        ];
        if let Some((what, got)) = parts.into_iter().find(|(_, part)| !(0.0..=1.0).contains(part)) {
            return wrong(what, got.to_string(), "a share from 0 to 1");
        }
        let Mix { lifted, collage, pseudo, real, solid } = self.mix;
        let shares = [lifted, collage, pseudo, real, solid];
        if shares.iter().any(|share| !(0.0..=1e6).contains(share)) || shares.iter().sum::<f32>() <= 0.0 {
            return wrong("mix", format!("{shares:?}"), "shares of at least 0, not all 0");
        }
        Ok(())
    }
}

/// How a sample was made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// A masked photo of two layers.
    Lifted,
    /// A composition.
    Collage,
    /// A lifted nearness map.
    Pseudo,
    /// A real light field.
    Real,
    /// A scene in three dimensions.
    Solid,
}

/// Makes samples. Shared by threads; [`Source::sample`] depends on nothing but the configuration and the index.
pub struct Source {
    config: Config,
    library: Library,
    /// Indices of pictures with a mask: flowers, and others.
    masked: [Vec<usize>; 2],
    /// Indices of pictures with a nearness map: everyday photos, flowers, rooms with good maps, and photos whose depth
    /// was measured.
    mapped: [Vec<usize>; 4],
    /// Meshes and textures, where the mix has scenes in three dimensions.
    stock: Option<Stock>,
}

impl Source {
    /// Decodes everything that `config` asks for.
    ///
    /// # Errors
    /// Settings that cannot work; files that are missing, broken or do not fit together; an empty folder.
    pub fn new(config: &Config) -> Result<Self, SceneError> {
        config.check()?;
        let stock = (config.mix.solid > 0.0).then(|| Stock::load(&config.data, config.split));
        // Such scenes are made of rules where there is nothing else.
        let library = match Library::load(config) {
            Err(empty @ SceneError::Empty { .. }) if stock.is_some() => {
                let notes = vec![format!("{empty}; all samples are drawn scenes")];
                Library { notes, ..Library::default() }
            }
            library => library?,
        };
        Ok(Self { stock, ..Self::from_library(config, library) })
    }

    /// A source over pictures that are in memory already.
    pub fn from_library(config: &Config, library: Library) -> Self {
        let pick = |wanted: &dyn Fn(&Picture) -> bool| -> Vec<usize> {
            (0..library.pictures.len()).filter(|&i| wanted(&library.pictures[i])).collect()
        };
        let flower = Picture::is_flower;
        let masked = [pick(&|p| p.mask.is_some() && flower(p)), pick(&|p| p.mask.is_some() && !flower(p))];
        let map = |p: &Picture| p.nearness.is_some() && !p.measured;
        let mapped = [
            pick(&|p| map(p) && !flower(p)),
            pick(&|p| map(p) && flower(p)),
            pick(&|p| map(p) && (manifest::WELL_LABELLED..1.0).contains(&p.worth)),
            pick(&|p| p.nearness.is_some() && p.measured),
        ];
        Self { config: config.clone(), library, masked, mapped, stock: None }
    }

    /// A sentence for each picture, mesh or texture that cannot be used and was left out.
    pub fn notes(&self) -> impl Iterator<Item = &str> {
        self.library.notes.iter().chain(self.stock.iter().flat_map(|stock| &stock.notes)).map(String::as_str)
    }

    /// The configuration.
    pub fn config(&self) -> &Config {
        &self.config
    }

    /// The pictures.
    pub fn library(&self) -> &Library {
        &self.library
    }

    /// Indices of the pictures that have a mask.
    pub fn masked(&self) -> impl Iterator<Item = usize> + '_ {
        self.masked.iter().flatten().copied()
    }

    /// Sample `index`, of the configured size.
    pub fn sample(&self, index: u64) -> Sample {
        self.sample_sized(index, self.config.crop)
    }

    /// The kind of sample `index`.
    pub fn kind_of(&self, index: u64) -> Kind {
        self.kind(&mut Rng::new(self.config.seed, index))
    }

    /// Sample `index` in another size, such as a batch of portrait crops.
    pub fn sample_sized(&self, index: u64, crop: [usize; 2]) -> Sample {
        self.sample_of_views(index, crop, self.views(index))
    }

    /// Its reference view alone.
    pub fn reference_alone(&self, index: u64, crop: [usize; 2]) -> Sample {
        self.sample_of_views(index, crop, vec![REFERENCE])
    }

    fn sample_of_views(&self, index: u64, crop: [usize; 2], views: Vec<usize>) -> Sample {
        let rng = &mut Rng::new(self.config.seed, index);
        let mut sample = match self.kind(rng) {
            Kind::Real => self.real(rng, crop, views),
            Kind::Solid => self.solid(rng, index, crop, views),
            Kind::Lifted => {
                let picture = self.masked_picture(rng, crop);
                self.lifted(rng, crop, views, picture)
            }
            Kind::Collage => self.collage(rng, crop, views),
            Kind::Pseudo => {
                let [others, flowers, rooms, measured] = &self.mapped;
                let rest = either(rng, FLOWERS, flowers, others);
                let rest = either(rng, self.config.rooms, rooms, rest);
                let list = either(rng, self.config.measured, measured, rest);
                let picture = self.framed(rng, list, crop);
                self.pseudo(rng, crop, views, picture, self.turns(index))
            }
        };
        self.shade(&mut sample, index);
        sample
    }

    /// Lets light fall on some samples, with a chance of its own: all else is as without.
    fn shade(&self, sample: &mut Sample, index: u64) {
        let rng = &mut Rng::new(self.config.seed ^ SHADING, index);
        if self.config.augment && rng.chance(self.config.shading) {
            Shade::random(rng).apply(&mut sample.rgb, sample.size);
        }
    }

    /// Quarter turns of sample `index`, with a chance of its own.
    fn turns(&self, index: u64) -> usize {
        let rng = &mut Rng::new(self.config.seed ^ TURNING, index);
        if self.config.augment && rng.chance(self.config.turned) { 1 + rng.below(3) } else { 0 }
    }

    /// Scene `index` in three dimensions as it is drawn for validation: the reference view alone.
    pub fn solid_scene(&self, index: u64, size: [usize; 2]) -> Sample {
        let plain = Canvas::new(size, self.config.range_px());
        self.solid_of(index, size, vec![REFERENCE], &plain)
    }

    /// A masked photo as it is: whole, its depth as [`Kind::Lifted`] gives it without chance. For validation.
    pub fn constructed(&self, picture: usize, views: Vec<usize>) -> Sample {
        let picture = &self.library.pictures[picture];
        let size = plenoscope::field::fit_long_side(picture.rgb.size.map(|s| s as u32), self.config.long_side as u32);
        lifted::plain(picture, size.map(|s| s as usize), views, self.config.range_px())
    }

    /// The kind of a sample: by the mix, of what there is.
    fn kind(&self, rng: &mut Rng) -> Kind {
        let Mix { lifted, collage, pseudo, real, solid } = self.config.mix;
        let masks = self.has_masks();
        let maps = self.mapped.iter().any(|list| !list.is_empty());
        let has = |share: f32, there: bool| if there { share } else { 0.0 };
        let fields = !self.library.fields.is_empty();
        let all = [Kind::Lifted, Kind::Collage, Kind::Pseudo, Kind::Real, Kind::Solid];
        let there = [masks, masks, maps, fields, self.stock.is_some()];
        let given = [lifted, collage, pseudo, real, solid];
        let shares: [f32; 5] = std::array::from_fn(|i| has(given[i], there[i]));
        if shares.iter().sum::<f32>() > 0.0 {
            return all[rng.weighted(&shares)];
        }
        all[there.iter().position(|&yes| yes).unwrap_or(0)]
    }

    /// The reference view, and others that are drawn anew for every group of samples.
    fn views(&self, index: u64) -> Vec<usize> {
        let rng = &mut Rng::new(self.config.seed ^ 0x71e5, index / self.config.views_group.max(1));
        let mut rest: Vec<usize> = (0..ViewGrid::PAPER.count()).filter(|&layer| layer != REFERENCE).collect();
        let count = self.config.views_per_sample.clamp(1, 64) - 1;
        if count < rest.len() {
            for i in 0..count {
                let other = i + rng.below(rest.len() - i);
                rest.swap(i, other);
            }
        }
        std::iter::once(REFERENCE).chain(rest.into_iter().take(count)).collect()
    }

    /// A picture of a list, preferably as wide or as tall as the crop is.
    fn framed(&self, rng: &mut Rng, list: &[usize], crop: [usize; 2]) -> &Picture {
        let wide = |size: [usize; 2]| size[0] >= size[1];
        let mut picture = &self.library.pictures[list[rng.below(list.len())]];
        for _ in 0..3 {
            if wide(picture.rgb.size) == wide(crop) {
                break;
            }
            picture = &self.library.pictures[list[rng.below(list.len())]];
        }
        picture
    }

    /// Whether there is a photo with a mask: without one there is no subject to cut out.
    fn has_masks(&self) -> bool {
        self.masked.iter().any(|list| !list.is_empty())
    }

    /// A picture with a mask, flower or other by the configured share.
    fn masked_picture(&self, rng: &mut Rng, crop: [usize; 2]) -> &Picture {
        let [flowers, others] = &self.masked;
        let list = either(rng, self.config.flowers, flowers, others);
        self.framed(rng, list, crop)
    }

    /// A scene in three dimensions.
    fn solid(&self, rng: &mut Rng, index: u64, crop: [usize; 2], views: Vec<usize>) -> Sample {
        let canvas = self.canvas(rng, crop);
        if self.config.fine > 0.0 && rng.chance(self.config.fine) {
            let larger = FINE[rng.below(FINE.len())];
            let whole = self.solid_of(index, crop.map(|side| larger * side), views, &canvas);
            return whole.cut(whole.telling_window(rng, crop), crop);
        }
        self.solid_of(index, crop, views, &canvas)
    }

    fn solid_of(&self, index: u64, crop: [usize; 2], views: Vec<usize>, canvas: &Canvas) -> Sample {
        let order = self.solid_order(crop, &views, canvas);
        let made = solid::make(&order, self.config.seed, index);
        let mut rgb = Vec::with_capacity(views.len() * 3 * crop[0] * crop[1]);
        for picture in &made.pictures {
            (0..3).for_each(|c| rgb.extend(picture.px.iter().map(|texel| texel[c])));
        }
        let disparity = made.disparities.concat();
        let (yx, origin) = ([-1.0, 1.0, -1.0, 1.0], made.kind.to_owned());
        Sample { size: crop, views, rgb, disparity, subject: None, yx, kind: Kind::Solid, origin, worth: 1.0 }
    }

    fn solid_order<'a>(&'a self, size: [usize; 2], views: &'a [usize], canvas: &Canvas) -> solid::Order<'a> {
        static NOTHING: std::sync::LazyLock<Stock> = std::sync::LazyLock::new(Stock::default);
        solid::Order {
            stock: self.stock.as_ref().unwrap_or(&NOTHING),
            photos: &self.library.pictures,
            masked: &self.masked[1],
            size,
            views,
            curve: self.config.curve,
            range_px: canvas.range_px,
            focus: canvas.focus,
            noise: self.config.noise && self.config.augment,
            pitfalls: self.config.pitfalls,
        }
    }

    fn canvas(&self, rng: &mut Rng, crop: [usize; 2]) -> Canvas {
        let [least, most] = if self.config.augment { self.config.stretch } else { [1.0; 2] };
        if least == most {
            return Canvas::new(crop, least * self.config.range_px());
        }
        let factor = rng.log_range(least, most);
        let focus = if rng.chance(0.5) { rng.unit() } else { FOCAL_NEARNESS };
        Canvas { focus, ..Canvas::new(crop, factor * self.config.range_px()) }
    }

    fn place(&self, rng: &mut Rng, picture: [usize; 2], canvas: &Canvas) -> Place {
        if self.config.augment {
            Place::random(rng, picture, canvas, &self.config)
        } else {
            Place::whole(picture, canvas)
        }
    }
}

/// One of two lists: the first with this probability, and wherever the other is empty.
fn either<'a>(rng: &mut Rng, share: f32, first: &'a [usize], other: &'a [usize]) -> &'a [usize] {
    let wanted = rng.chance(share);
    if (wanted || other.is_empty()) && !first.is_empty() { first } else { other }
}

/// Offsets of a view of the 8×8 grid, `(du, dv)`.
pub fn steps(layer: usize) -> (f32, f32) {
    let grid = ViewGrid::PAPER;
    let offset = grid.offset(grid.view_from_layer(layer));
    (offset.du, offset.dv)
}

/// Renders the views of a scene into a sample's arrays, `[view, channel, y, x]` and `[view, y, x]`.
fn render(scene: &Scene, views: &[usize]) -> (Vec<f32>, Vec<f32>) {
    let count = scene.size[0] * scene.size[1];
    let mut rgb = Vec::with_capacity(views.len() * 3 * count);
    let mut disparity = Vec::with_capacity(views.len() * count);
    for &layer in views {
        let (du, dv) = steps(layer);
        let view = scene.view(du, dv);
        (0..3).for_each(|c| rgb.extend(view.rgb.iter().map(|texel| texel[c].clamp(0.0, 1.0))));
        disparity.extend(view.disparity);
    }
    (rgb, disparity)
}

/// Camera noise, on every view anew.
fn add_noise(rng: &mut Rng, rgb: &mut [f32], config: &Config) {
    let deviation = rng.range(-0.005, 0.02).max(0.0);
    if deviation == 0.0 || !config.noise {
        return;
    }
    for pair in rgb.chunks_exact_mut(2) {
        let noise = rng.normals();
        (0..2).for_each(|i| pair[i] = (pair[i] + deviation * noise[i]).clamp(0.0, 1.0));
    }
}
