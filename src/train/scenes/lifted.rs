//! Photos lifted to light fields: by their mask, by their nearness map, or by both.

use super::cutout::Cutout;
use super::layer::{Layer, Scene};
use super::library::{Picture, nearness_from_byte};
use super::place::{Canvas, Place, Tone, ground, turned_size};
use super::raster::Raster;
use super::{Kind, Sample, Source, add_noise, render, walls};
use crate::rng::Rng;

/// The share of lifted maps before which a cut-out of another photo is put.
const GUESTS: f32 = 0.35;
/// The share of masked photos whose surround gives way to a wall.
const WALLS: f32 = 0.12;

/// Colours of a raster premultiplied by a coverage of 0 … 255.
pub fn premultiplied(rgb: &Raster<[f32; 3]>, alpha: &Raster<f32>) -> Raster<[f32; 4]> {
    let px = rgb.px.iter().zip(&alpha.px).map(|(c, a)| {
        let a = (a / 255.0).clamp(0.0, 1.0);
        [c[0] * a, c[1] * a, c[2] * a, a]
    });
    Raster { size: rgb.size, px: px.collect() }
}

/// Left, top, right, bottom of what a layer covers.
pub fn covered(rgba: &Raster<[f32; 4]>) -> [usize; 4] {
    let [w, h] = rgba.size;
    let mut bounds = [w, h, 0, 0];
    for (y, row) in rgba.px.chunks_exact(w).enumerate() {
        let mut hits = row.iter().enumerate().filter(|(_, texel)| texel[3] > 0.002).map(|(x, _)| x);
        if let Some(first) = hits.next() {
            let last = hits.next_back().unwrap_or(first);
            bounds = [bounds[0].min(first), bounds[1].min(y), bounds[2].max(last + 1), y + 1];
        }
    }
    if bounds[2] == 0 { [0; 4] } else { bounds }
}

/// Nearness 0.02 … 1 of a stored map as it lies on the canvas.
fn placed_nearness(map: &Raster<u8>, place: &Place, size: [usize; 2]) -> Raster<f32> {
    place.fill(map, size).map(|&byte| 0.05 + 0.95 * nearness_from_byte(byte))
}

fn sample(scene: &Scene, views: Vec<usize>, place: &Place, kind: Kind, origin: &str) -> Sample {
    let (rgb, disparity) = render(scene, &views);
    Sample {
        size: scene.size,
        views,
        rgb,
        disparity,
        subject: None,
        yx: place.yx,
        kind,
        origin: origin.to_owned(),
        worth: 1.0,
    }
}

/// Depth of the two layers of a masked photo.
struct Depths {
    back: Raster<f32>,
    front: Raster<f32>,
    rough: bool,
}

fn two_layers(
    canvas: &Canvas,
    place: &Place,
    cutout: &Cutout,
    depths: &Depths,
    back: Raster<[f32; 3]>,
    tone: &Tone,
) -> Scene {
    let full = canvas.full();
    let to_px = |nearness: &Raster<f32>| nearness.map(|&z| canvas.disparity(z));
    let colour = tone.apply(&place.fill(&cutout.subject().front, full));
    let rgba = premultiplied(&colour, &place.fill(&cutout.subject().alpha, full));
    let bounds = covered(&rgba);
    let subject = Layer { rgba, disparity: to_px(&depths.front), bounds, rough: depths.rough };
    let layers = vec![Layer::whole(back, to_px(&depths.back), depths.rough), subject];
    Scene { layers, margin: canvas.margin, size: canvas.size }
}

/// A masked photo without any chance: a low ground and a domed subject.
pub fn plain(picture: &Picture, size: [usize; 2], views: Vec<usize>, range_px: f32) -> Sample {
    let canvas = Canvas::new(size, range_px);
    let place = Place::whole(picture.rgb.size, &canvas);
    let full = canvas.full();
    let tone = Tone::plain();
    let Some(cutout) = picture.cutout() else {
        let back = low_ground(&place, full).map(|&z| canvas.disparity(z));
        let layers = vec![Layer::whole(tone.apply(&place.fill(&picture.rgb, full)), back, false)];
        return sample(&Scene { layers, margin: canvas.margin, size }, views, &place, Kind::Lifted, &picture.id);
    };
    let behind = tone.apply(&place.fill(&cutout.behind, full));
    let depths = usual_depths(&place, cutout, full);
    let scene = two_layers(&canvas, &place, cutout, &depths, behind, &tone);
    let mut sample = sample(&scene, views, &place, Kind::Lifted, &picture.id);
    sample.subject = Some(subject(&canvas, &place, cutout));
    sample
}

fn subject(canvas: &Canvas, place: &Place, cutout: &Cutout) -> Vec<u8> {
    canvas.crop(&place.fill(&cutout.subject().alpha, canvas.full()).map(|&a| (a + 0.5) as u8))
}

impl Source {
    /// A masked photo as two layers.
    pub(super) fn lifted(&self, rng: &mut Rng, crop: [usize; 2], views: Vec<usize>, picture: &Picture) -> Sample {
        let Some(cutout) = picture.cutout().filter(|_| self.config.augment) else {
            return plain(picture, crop, views, self.config.range_px());
        };
        let canvas = self.canvas(rng, crop);
        let place = self.place(rng, picture.rgb.size, &canvas);
        let full = canvas.full();
        let tone = Tone::random(rng, self.config.variety);
        let wall = rng.chance(WALLS);
        let depths = match &cutout.nearness {
            _ if wall => {
                Depths { back: walls::upright(rng, full), front: usual_front(&place, cutout, full), rough: false }
            }
            Some([front, back]) if rng.chance(by_map(picture)) => Depths {
                back: placed_nearness(back, &place, full),
                front: placed_nearness(front, &place, full),
                rough: true,
            },
            _ => chosen_depths(rng, &place, cutout, full),
        };
        let mut behind = if wall {
            tone.apply(&walls::wall(rng, full, &cutout.behind))
        } else {
            tone.apply(&place.fill(&cutout.behind, full))
        };
        if rng.chance(0.3) {
            behind.blur(rng.range(0.3, 3.0) * self.config.long_side as f32 / 288.0);
        }
        let scene = two_layers(&canvas, &place, cutout, &depths, behind, &tone);
        let mut sample = sample(&scene, views, &place, Kind::Lifted, &picture.id);
        sample.worth = if picture.nearness.is_some() && !picture.is_flower() { picture.worth } else { 0.8 };
        add_noise(rng, &mut sample.rgb, &self.config);
        sample.subject = Some(subject(&canvas, &place, cutout));
        sample
    }

    /// A nearness map lifted, after some quarter turns; where there is a mask too, the subject is a layer of its own.
    pub(super) fn pseudo(
        &self,
        rng: &mut Rng,
        crop: [usize; 2],
        views: Vec<usize>,
        picture: &Picture,
        turns: usize,
    ) -> Sample {
        let canvas = self.canvas(rng, crop);
        let place = self.place(rng, turned_size(picture.rgb.size, turns), &canvas).turned(picture.rgb.size, turns);
        let full = canvas.full();
        let tone = if self.config.augment { Tone::random(rng, self.config.variety) } else { Tone::plain() };
        let cutout = picture.cutout();
        let mut scene = match cutout.and_then(|cutout| cutout.nearness.as_ref().map(|maps| (cutout, maps))) {
            Some((cutout, [front, back])) => {
                let [front, back] = [front, back].map(|map| placed_nearness(map, &place, full));
                let behind = tone.apply(&place.fill(&cutout.behind, full));
                two_layers(&canvas, &place, cutout, &Depths { back, front, rough: true }, behind, &tone)
            }
            None => {
                let rgb = tone.apply(&place.fill(&picture.rgb, full));
                let map = picture.nearness.as_ref().map(|map| placed_nearness(map, &place, full));
                let map = map.unwrap_or_else(|| ground(rng, &place, full)).map(|&z| canvas.disparity(z));
                Scene { layers: vec![Layer::whole(rgb, map, true)], margin: canvas.margin, size: crop }
            }
        };
        let guest = self.config.augment && rng.chance(GUESTS) && self.add_guest(rng, &canvas, &mut scene);
        let mut sample = sample(&scene, views, &place, Kind::Pseudo, &picture.id);
        sample.worth = picture.worth;
        if let Some(holes) = &picture.holes {
            forget(&mut sample, &place.fill(holes, full), canvas.margin);
        }
        if self.config.augment {
            add_noise(rng, &mut sample.rgb, &self.config);
        }
        // Where a guest stands before it, its mask no longer tells what is in front; nor what is below, when it is turned.
        sample.subject = cutout.filter(|_| !guest && turns == 0).map(|cutout| subject(&canvas, &place, cutout));
        sample
    }
}

/// How often a masked photo that has a map is lifted by it. By rule a flower is a flat cut-out before a ground without
/// stems: better than what the maps of others say of it, worse than what a net of ours does. Anything else by rule would
/// contradict what the maps teach of like photos.
fn by_map(picture: &Picture) -> f32 {
    match (picture.is_flower(), picture.taught) {
        (false, _) => 1.0,
        (true, true) => 0.75,
        (true, false) => 0.3,
    }
}

/// Takes back the ray depths of what the map has no depth of; `holes` lies on the canvas.
fn forget(sample: &mut Sample, holes: &Raster<f32>, margin: usize) {
    let [w, h] = sample.size;
    for (k, &layer) in sample.views.iter().enumerate() {
        let (du, dv) = super::steps(layer);
        for (i, d) in sample.disparity[k * w * h..][..w * h].iter_mut().enumerate() {
            let [x, y] = [i % w, i / w].map(|at| (at + margin) as f32);
            if holes.tap(x + du * *d, y + dv * *d) > 64.0 {
                *d = f32::NAN;
            }
        }
    }
}

/// Ground that rises towards the picture's bottom and stays far behind a subject.
fn low_ground(place: &Place, full: [usize; 2]) -> Raster<f32> {
    Raster::from_fn(full, |_, y| 0.05 + 0.4 * place.row(y).powf(1.5))
}

/// A domed subject at the focal plane.
fn usual_front(place: &Place, cutout: &Cutout, full: [usize; 2]) -> Raster<f32> {
    place.fill(&cutout.subject().dome, full).map(|&dome| 0.82 + 0.18 * dome / 255.0)
}

/// A domed subject at the focal plane before a low ground.
fn usual_depths(place: &Place, cutout: &Cutout, full: [usize; 2]) -> Depths {
    Depths { back: low_ground(place, full), front: usual_front(place, cutout, full), rough: false }
}

/// Mostly the usual depths: what a photo cannot tell, a net can only learn where it is always the same. Else drawn by
/// chance: a ground or wall, and a domed subject before it.
fn chosen_depths(rng: &mut Rng, place: &Place, cutout: &Cutout, full: [usize; 2]) -> Depths {
    if rng.chance(0.75) {
        return usual_depths(place, cutout, full);
    }
    let (base, height) = (rng.range(0.65, 0.9), rng.range(0.05, 0.25));
    let front = place.fill(&cutout.subject().dome, full).map(|&dome| base + height * dome / 255.0);
    let mut back = ground(rng, place, full);
    back.px.iter_mut().zip(&front.px).for_each(|(back, front)| *back = back.min(front - 0.1));
    Depths { back, front, rough: false }
}
