//! Figures on validation photos lifted to light fields, whose views and ray depths are known exactly.

use anyhow::Context as _;
use rayon::prelude::*;
use serde::Serialize;

use super::metrics::{correlation, l1, l1_where, mean};
use super::sheet::{depth_tile, usual_range};
use super::{CORNERS, Predictor, Rgb, photos, warp};
use crate::scenes::{Config, Mix, REFERENCE, Sample, Source, Split, steps};
use crate::warp::{RayEnd, ray_end};

/// Means over the scenes.
#[derive(Clone, Debug, Serialize)]
pub struct Figures {
    /// Scenes.
    pub count: usize,
    /// Corner views, mean L1 in 0 … 1: Lambertian views of the predicted ray depths.
    pub corner_l1: f32,
    /// Copying the photo.
    pub copy_l1: f32,
    /// Lambertian views of the true ray depths: no ray depth can do better.
    pub true_depth_l1: f32,
    /// Correlation of the predicted with the true ray depth of the reference view.
    pub correlation: f32,
    /// Mean absolute difference over all views, pixels per view step.
    pub mae_px: f32,
    /// What the reference view does not see, all views: L1 of the Lambertian views.
    pub hidden_lambertian_l1: Option<f32>,
    /// The same after the occlusion net.
    pub hidden_full_l1: Option<f32>,
    /// By how much the occlusion net lowers it, as a share.
    pub hidden_gain: Option<f32>,
}

/// What was found, and pictures of the first scenes.
pub struct Report {
    /// The figures.
    pub figures: Figures,
    /// Photo, true depth, predicted depth, a true corner view, the predicted one.
    pub tiles: Vec<Vec<Rgb>>,
}

/// Evaluates the first `count` validation flowers as constructed light fields. `seen` is told after each one how many
/// there are in all.
///
/// # Errors
/// What the data or the predictor says.
pub fn evaluate(
    data: &std::path::Path,
    predictor: &dyn Predictor,
    count: usize,
    seen: &dyn Fn(usize),
) -> anyhow::Result<Report> {
    let (source, photos) = held_out(data, photos::LONG_SIDE)?;
    let is_flower = |i: &usize| source.library().pictures[*i].id.starts_with("flowers");
    let flowers: Vec<usize> = photos.into_iter().filter(is_flower).take(count).collect();
    let mut scenes = Vec::with_capacity(flowers.len());
    let mut tiles = Vec::new();
    let all = flowers.len();
    for picture in flowers {
        let scene = Scene::new(&source.constructed(picture, all_views())).context("a scene of fewer than 64 views")?;
        let (found, row) = scene.compare(predictor)?;
        scenes.push(found);
        if tiles.len() < 12 {
            tiles.push(row);
        }
        seen(all);
    }
    Ok(Report { figures: figures(&scenes), tiles })
}

/// The engine over the validation photos, and which of them have a mask: flowers, then the others.
///
/// # Errors
/// A data folder that cannot be used.
pub fn held_out(data: &std::path::Path, long_side: usize) -> anyhow::Result<(Source, Vec<usize>)> {
    let mix = Mix { real: 0.0, solid: 0.0, ..Mix::default() };
    let config = Config { data: data.to_owned(), long_side, mix, split: Split::Val, ..Config::default() };
    let source = Source::new(&config)?;
    let mut photos: Vec<usize> = source.masked().collect();
    photos.sort_by_key(|&i| !source.library().pictures[i].is_flower());
    Ok((source, photos))
}

/// All views as samples hold them, the reference view first.
pub fn all_views() -> Vec<usize> {
    std::iter::once(REFERENCE).chain((0..64).filter(|&i| i != REFERENCE)).collect()
}

fn figures(scenes: &[Found]) -> Figures {
    let of = |what: fn(&Found) -> f32| mean(scenes.iter().map(what)).unwrap_or(0.0);
    let before = mean(scenes.iter().filter_map(|s| s.hidden));
    let full = mean(scenes.iter().filter_map(|s| s.hidden_full));
    Figures {
        count: scenes.len(),
        corner_l1: of(|s| s.corners[0]),
        copy_l1: of(|s| s.corners[1]),
        true_depth_l1: of(|s| s.corners[2]),
        correlation: of(|s| s.correlation),
        mae_px: of(|s| s.mae_px),
        hidden_lambertian_l1: before,
        hidden_full_l1: full,
        hidden_gain: before.zip(full).map(|(before, full)| 1.0 - full / before.max(1e-6)),
    }
}

/// What was found on one scene.
struct Found {
    /// Predicted, copied, true depth.
    corners: [f32; 3],
    correlation: f32,
    mae_px: f32,
    hidden: Option<f32>,
    hidden_full: Option<f32>,
}

/// A scene in `[v, u]` order.
struct Scene {
    size: [usize; 2],
    views: Vec<Rgb>,
    depths: Vec<Vec<f32>>,
}

impl Scene {
    /// None of a sample of fewer than 64 views.
    fn new(sample: &Sample) -> Option<Self> {
        let depths = sample.depths()?.into_iter().map(<[f32]>::to_vec).collect();
        Some(Self { size: sample.size, views: sample.pictures()?, depths })
    }

    fn compare(&self, predictor: &dyn Predictor) -> anyhow::Result<(Found, Vec<Rgb>)> {
        let reference = &self.views[REFERENCE];
        let count = reference.px.len();
        let prediction = predictor.predict(reference)?;
        let render = |layer: usize, disparity: &[f32]| {
            let (du, dv) = steps(layer);
            warp::lambertian(reference, disparity, du, dv)
        };
        let lambertian: Vec<Rgb> =
            (0..64).into_par_iter().map(|layer| render(layer, prediction.view(layer, count))).collect();
        let corner =
            |view: &dyn Fn(usize) -> Rgb| mean(CORNERS.iter().map(|&l| l1(&view(l), &self.views[l]))).unwrap_or(0.0);
        let own = prediction.view(REFERENCE, count);
        let error = |layer: usize| {
            let pairs = prediction.view(layer, count).iter().zip(&self.depths[layer]);
            mean(pairs.map(|(a, b)| (a - b).abs())).unwrap_or(0.0)
        };
        let hidden =
            |views: &[Rgb]| mean((0..64).filter_map(|l| l1_where(&views[l], &self.views[l], |i| self.is_hidden(l, i))));
        let found = Found {
            corners: [
                corner(&|l| lambertian[l].clone()),
                corner(&|_| reference.clone()),
                corner(&|l| render(l, &self.depths[l])),
            ],
            correlation: correlation(own.iter().copied().zip(self.depths[REFERENCE].iter().copied())),
            mae_px: mean((0..64).map(error)).unwrap_or(0.0),
            hidden: hidden(&lambertian),
            hidden_full: prediction.corrected.as_deref().and_then(hidden),
        };
        let full = prediction.corrected.as_deref().unwrap_or(&lambertian);
        let range = usual_range(&self.depths[REFERENCE]);
        let tiles = vec![
            reference.clone(),
            depth_tile(&self.depths[REFERENCE], self.size, range),
            depth_tile(own, self.size, usual_range(own)),
            self.views[0].clone(),
            full[0].clone(),
        ];
        Ok((found, tiles))
    }

    /// Whether the reference view sees something nearer where this ray of a view ends.
    fn is_hidden(&self, layer: usize, i: usize) -> bool {
        let end = ray_end(&self.depths[REFERENCE], self.size[0], i, steps(layer), self.depths[layer][i]);
        end == RayEnd::Hidden
    }
}
