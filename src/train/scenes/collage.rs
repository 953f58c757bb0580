//! Compositions: one photo's background, cut-outs of others, and plants, at sorted depths.

use super::layer::{Layer, Scene};
use super::library::Picture;
use super::lifted::{covered, premultiplied};
use super::place::{Canvas, Place, Tone, ground};
use super::plants::{blades, leaves};
use super::raster::Raster;
use super::{FOCAL_NEARNESS, Kind, Sample, Source, add_noise, render, walls};
use crate::rng::Rng;

/// The share of compositions before a wall.
const WALLS: f32 = 0.4;

/// A cut-out as it lies on a canvas.
struct Sprite {
    rgb: Raster<[f32; 3]>,
    alpha: Raster<f32>,
    dome: Raster<f32>,
}

impl Source {
    /// A background and one to five things before it.
    pub(super) fn collage(&self, rng: &mut Rng, crop: [usize; 2], views: Vec<usize>) -> Sample {
        let canvas = self.canvas(rng, crop);
        let full = canvas.full();
        let back = self.masked_picture(rng, crop);
        let place = Place::random(rng, back.rgb.size, &canvas, &self.config);
        let tone = Tone::random(rng, self.config.variety);
        let mut nearness: Vec<f32> = (0..1 + rng.below(5)).map(|_| rng.range(0.3, 1.15)).collect();
        nearness.sort_by(f32::total_cmp);
        let mut layers = vec![self.backdrop(rng, back, &place, &canvas, nearness[0])];
        for &z in &nearness {
            let (mut rgba, dome) = self.thing(rng, &canvas, z, back);
            // Out of focus by its distance from the focal plane.
            rgba.blur((z - FOCAL_NEARNESS).abs() * rng.range(0.0, 2.5) * self.config.long_side as f32 / 288.0);
            let bounds = covered(&rgba);
            let disparity = Raster { size: full, px: dome.iter().map(|d| canvas.disparity(z + 0.12 * d)).collect() };
            layers.push(Layer { rgba, disparity, bounds, rough: false });
        }
        for layer in &mut layers {
            tint(layer, &tone);
        }
        let scene = Scene { layers, margin: canvas.margin, size: crop };
        let (mut rgb, disparity) = render(&scene, &views);
        add_noise(rng, &mut rgb, &self.config);
        let origin = format!("{} and {} more", back.id, nearness.len());
        Sample {
            size: crop,
            views,
            rgb,
            disparity,
            subject: None,
            yx: place.yx,
            kind: Kind::Collage,
            origin,
            worth: 0.8,
        }
    }

    /// Puts another photo's subject before everything that it covers, wherever that lies in the picture; says whether
    /// there was one to put.
    pub(super) fn add_guest(&self, rng: &mut Rng, canvas: &Canvas, scene: &mut Scene) -> bool {
        if !self.has_masks() {
            return false;
        }
        let picture = self.masked_picture(rng, canvas.size);
        let size = rng.range(0.2, 1.0);
        let Some(sprite) = sprite(rng, picture, canvas, size) else { return false };
        let apart = rng.range(0.05, 0.35) * canvas.range_px;
        let Some(under) = nearest_under(scene, &sprite.alpha) else { return false };
        let near = (under + apart).min(canvas.disparity(1.15));
        let rgba = premultiplied(&Tone::random(rng, self.config.variety).apply(&sprite.rgb), &sprite.alpha);
        let disparity = sprite.dome.map(|dome| near + 0.1 * canvas.range_px * dome / 255.0);
        scene.layers.push(Layer { bounds: covered(&rgba), rgba, disparity, rough: false });
        true
    }

    /// A photo without its subject on a ground, or a wall in its colours, that stays behind `nearest`; values 0 … 1.
    fn backdrop(&self, rng: &mut Rng, back: &Picture, place: &Place, canvas: &Canvas, nearest: f32) -> Layer {
        let full = canvas.full();
        let wall = rng.chance(WALLS);
        let mut rgb = if wall {
            walls::wall(rng, full, &back.rgb)
        } else {
            place.fill(back.cutout().map_or(&back.rgb, |cutout| &cutout.behind), full)
        };
        let blur = [0.0, 0.0, 1.0, 2.0, 3.0][rng.below(5)];
        rgb.blur(blur * self.config.long_side as f32 / 288.0);
        let mut depth = if wall { walls::upright(rng, full) } else { ground(rng, place, full) };
        depth.px.iter_mut().for_each(|z| *z = canvas.disparity(z.min(nearest - 0.05)));
        Layer::whole(rgb.map(|texel| texel.map(|c| c / 255.0)), depth, false)
    }

    /// One thing to stand in the scene: its colours 0 … 1, premultiplied, and its dome 0 … 1.
    fn thing(&self, rng: &mut Rng, canvas: &Canvas, z: f32, back: &Picture) -> (Raster<[f32; 4]>, Vec<f32>) {
        let full = canvas.full();
        let none = || vec![0.0; full[0] * full[1]];
        if rng.chance(0.28) {
            let layer = if rng.chance(0.6) { blades(rng, full, &back.rgb) } else { leaves(rng, full, &back.rgb) };
            return (layer, none());
        }
        let picture = self.masked_picture(rng, canvas.size);
        let Some(sprite) = sprite(rng, picture, canvas, z) else {
            return (blades(rng, full, &back.rgb), none());
        };
        let tone = Tone::random(rng, self.config.variety);
        (premultiplied(&tone.apply(&sprite.rgb), &sprite.alpha), sprite.dome.px.iter().map(|d| d / 255.0).collect())
    }
}

/// The largest disparity that a scene has under a coverage of 0 … 255.
fn nearest_under(scene: &Scene, alpha: &Raster<f32>) -> Option<f32> {
    let covered = || alpha.px.iter().enumerate().filter(|(_, a)| **a > 127.5).map(|(i, _)| i);
    let of = |layer: &Layer| {
        covered().filter(|&i| layer.rgba.px[i][3] > 0.5).map(|i| layer.disparity.px[i]).reduce(f32::max)
    };
    scene.layers.iter().filter_map(of).reduce(f32::max)
}

/// A photo's subject, scaled, turned and put anywhere; nearer ones larger.
fn sprite(rng: &mut Rng, picture: &Picture, canvas: &Canvas, z: f32) -> Option<Sprite> {
    let cutout = picture.cutout()?;
    let [l, t, r, b] = cutout.bounds.map(|edge| edge as f32);
    let [w, h] = canvas.size.map(|side| side as f32);
    let middle = [rng.range(0.05, 0.95) * w, rng.range(0.05, 0.95) * h];
    // The subject's larger side against the picture's smaller one.
    let size = rng.range(0.25, 0.85) * (0.5 + 0.7 * z) * w.min(h);
    let scale = size / (r - l).max(b - t).max(1.0);
    let (sin, cos) = f32::sin_cos(rng.range(-0.6, 0.6));
    let flip = if rng.chance(0.5) { -1.0 } else { 1.0 };
    let (look, smaller) = cutout.look(1.0 / scale);
    let from = [(l + r) / 2.0, (t + b) / 2.0].map(|at| (at + 0.5) / smaller - 0.5);
    let step = 1.0 / (scale * smaller);
    let place = Place::similar(from, middle, [flip * cos * step, sin * step], flip, canvas);
    let full = canvas.full();
    Some(Sprite {
        rgb: place.fill(&look.front, full),
        alpha: place.fill_inside(&look.alpha, full),
        dome: place.fill(&look.dome, full),
    })
}

/// Changes the tone of premultiplied colours.
fn tint(layer: &mut Layer, tone: &Tone) {
    for texel in &mut layer.rgba.px {
        let alpha = texel[3];
        if alpha > 0.002 {
            let straight = [texel[0], texel[1], texel[2]].map(|c| c / alpha * 255.0);
            let toned = tone.texel(straight);
            (0..3).for_each(|c| texel[c] = toned[c] * alpha);
        }
    }
}
