//! Figures on true light fields.

use rayon::prelude::*;
use serde::Serialize;

use super::metrics::{correlation, l1, mean, psnr, ssim};
use super::sheet::{depth_tile, epi_tile, usual_range};
use super::sweep::{Swept, picture, reference_depth};
use super::{CORNERS, Prediction, Predictor, Rgb, TrueField, warp};
use crate::loss::affine_fit;
use crate::scenes::{REFERENCE, steps};

/// How near a set of 64 views comes to the true ones.
#[derive(Clone, Debug, Serialize)]
pub struct Closeness {
    /// Mean absolute difference over all 64 views, values in 0 … 1.
    pub l1_01: f32,
    /// The same in −1 … 1.
    pub l1_11: f32,
    /// Over the 28 outermost views, in 0 … 1.
    pub outer_l1_01: f32,
    /// The same in −1 … 1.
    pub outer_l1_11: f32,
    /// dB, mean over the 63 other views.
    pub psnr: f32,
    /// Mean over the 63 other views.
    pub ssim: f32,
    /// L1 in 0 … 1 by columns from the reference view: u − 4 = −4 … 3, mean over all rows of views.
    pub l1_by_u: Vec<f32>,
}

/// The corner views, mean L1 in 0 … 1.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Corners {
    /// The reference view itself.
    pub copy: f32,
    /// The best plane.
    pub flat: f32,
    /// Lambertian views of the predicted ray depths.
    pub predicted: f32,
    /// After the best scale and shift.
    pub fit: f32,
    /// That scale and shift.
    pub fit_scale_shift: [f32; 2],
    /// Lambertian views of the swept depth of the reference view: about the best that one map can do.
    pub swept_depth: f32,
    /// Plane sweep over the true views, each pixel of each with its own plane.
    pub sweep: f32,
    /// (flat − fit) / (flat − sweep).
    pub closed: f32,
    /// The same of the swept depth in place of the fit.
    pub swept_depth_closed: f32,
    /// Closed / closed by the swept depth: the share of what one map for all views can reach.
    pub of_possible: f32,
}

/// The predicted ray depths against true ones.
#[derive(Clone, Debug, Serialize)]
pub struct Truth {
    /// Views whose ray depths are known: 64, or the reference view alone.
    pub views: usize,
    /// Correlation in the reference view.
    pub correlation: f32,
    /// Mean absolute difference over all of them, pixels per view step, raw.
    pub mae_px: f32,
    /// After the scale and shift that fit best: a photo tells neither.
    pub fit_mae_px: f32,
}

/// Everything about one light field.
#[derive(Clone, Debug, Serialize)]
pub struct Figures {
    /// Its name.
    pub name: String,
    /// The corner views.
    pub corners: Corners,
    /// Correlation of the predicted with the swept depth of the reference view, where the views tell it.
    pub depth_correlation: f32,
    /// Mean absolute difference there, in pixels per view step, raw.
    pub depth_mae_px: f32,
    /// The share of pixels where the views tell it.
    pub depth_known: f32,
    /// Against the ray depths that the file has.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub truth: Option<Truth>,
    /// The views as they come out: with the occlusion net, where there is one.
    pub full: Closeness,
    /// Without the occlusion net.
    pub lambertian: Closeness,
    /// Copying the photo.
    pub zero: Closeness,
    /// The best plane.
    pub plane: Closeness,
    /// The plane sweep.
    pub sweep: Closeness,
}

/// What was found, and pictures of it.
pub struct Report {
    /// The figures.
    pub figures: Figures,
    /// Photo, swept depth, predicted depth, true and predicted epipolar image.
    pub tiles: Vec<Rgb>,
}

/// Evaluates one light field.
///
/// # Errors
/// What the predictor says.
pub fn evaluate(field: &TrueField, predictor: &dyn Predictor) -> anyhow::Result<Report> {
    let prediction = predictor.predict(field.reference())?;
    let swept = reference_depth(field);
    let count = field.reference().px.len();
    let one_map = |layer: usize, disparity: &[f32]| {
        let (du, dv) = steps(layer);
        warp::lambertian(field.reference(), disparity, du, dv)
    };
    let render = |layer| one_map(layer, prediction.view(layer, count));
    let lambertian: Vec<Rgb> = (0..64).into_par_iter().map(render).collect();
    let (corners, plane) = corners(field, &prediction, &lambertian);
    let full = prediction.corrected.as_deref().unwrap_or(&lambertian);
    let own = prediction.view(REFERENCE, count);
    let known =
        || own.iter().zip(&swept.disparity_px).zip(&swept.known).filter(|(_, k)| **k).map(|((a, b), _)| (*a, *b));
    let sweep_views: Vec<Rgb> = (0..64).into_par_iter().map(|layer| picture(field, layer)).collect();
    let planes = (0..64).map(|layer| {
        let (du, dv) = steps(layer);
        warp::plane(field.reference(), plane, du, dv)
    });
    let tiles = tiles(field, &swept, own, full);
    let figures = Figures {
        name: field.name.clone(),
        corners: corners.beside(
            corner_mean(field, |layer| one_map(layer, &swept.disparity_px)),
            corner_mean(field, |layer| sweep_views[layer].clone()),
        ),
        depth_correlation: correlation(known()),
        depth_mae_px: mean(known().map(|(a, b)| (a - b).abs())).unwrap_or(0.0),
        depth_known: known().count() as f32 / count as f32,
        truth: truth(field, &prediction),
        full: closeness(field, full),
        lambertian: closeness(field, &lambertian),
        zero: closeness(field, &vec![field.reference().clone(); 64]),
        plane: closeness(field, &planes.collect::<Vec<_>>()),
        sweep: closeness(field, &sweep_views),
    };
    Ok(Report { figures, tiles })
}

/// None where the file has no ray depths. Rays of unknown depth do not count.
fn truth(field: &TrueField, prediction: &Prediction) -> Option<Truth> {
    let count = field.reference().px.len();
    let own = |layer| prediction.view(layer, count).iter().copied();
    let known = |pair: &(f32, f32)| pair.1.is_finite();
    let of_reference = own(REFERENCE).zip(field.own_reference_depth()?.iter().copied()).filter(known);
    let all = field.depths.iter().flat_map(|(layer, map)| own(*layer).zip(map.iter().copied()));
    let (predicted, truth): (Vec<f32>, Vec<f32>) = all.filter(known).unzip();
    let (scale, shift) = affine_fit(&predicted, &truth);
    let error = |scale: f32, shift: f32| mean(predicted.iter().zip(&truth).map(|(d, t)| (scale * d + shift - t).abs()));
    Some(Truth {
        views: field.depths.len(),
        correlation: correlation(of_reference),
        mae_px: error(1.0, 0.0)?,
        fit_mae_px: error(scale, shift)?,
    })
}

fn corner_mean(field: &TrueField, view: impl Fn(usize) -> Rgb + Sync) -> f32 {
    CORNERS.par_iter().map(|&layer| l1(&view(layer), &field.views[layer])).sum::<f32>() / 4.0
}

/// The corners' figures without the sweeps, and the best plane.
fn corners(field: &TrueField, prediction: &Prediction, lambertian: &[Rgb]) -> (Corners, f32) {
    let reference = field.reference();
    let count = reference.px.len();
    let least = |a: (f32, [f32; 2]), b: (f32, [f32; 2])| if b.0 < a.0 { b } else { a };
    let none = (f32::INFINITY, [0.0; 2]);
    let flat = (-10..=10).map(|i| i as f32 * 0.1).map(|plane| {
        let at = |layer| {
            let (du, dv) = steps(layer);
            warp::plane(reference, plane, du, dv)
        };
        (corner_mean(field, at), [0.0, plane])
    });
    let (flat, [_, plane]) = flat.fold(none, least);
    let scales = [0.15, 0.3, 0.45, 0.6, 0.8, 1.0, 1.3].map(|a| a / prediction.gain);
    let tries = scales.iter().flat_map(|&a| (-6..=6).map(move |i| [a, i as f32 * 0.1]));
    let fits = tries.map(|ab| {
        let at = |layer| {
            let (du, dv) = steps(layer);
            warp::affine(reference, prediction.view(layer, count), [du, dv], ab)
        };
        (corner_mean(field, at), ab)
    });
    let (fit, fit_scale_shift) = fits.fold(none, least);
    let copy = corner_mean(field, |_| reference.clone());
    let predicted = corner_mean(field, |layer| lambertian[layer].clone());
    (Corners { copy, flat, predicted, fit, fit_scale_shift, ..Corners::default() }, plane)
}

impl Corners {
    fn beside(self, swept_depth: f32, sweep: f32) -> Self {
        let closed = |l1: f32| (self.flat - l1) / (self.flat - sweep).max(1e-6);
        let (own, possible) = (closed(self.fit), closed(swept_depth));
        let of_possible = if possible > 0.0 { own / possible } else { 0.0 };
        Self { swept_depth, sweep, closed: own, swept_depth_closed: possible, of_possible, ..self }
    }
}

/// How near 64 views come to the true ones.
pub fn closeness(field: &TrueField, views: &[Rgb]) -> Closeness {
    let each: Vec<[f32; 3]> = (0..64)
        .into_par_iter()
        .map(|i| {
            let (a, b) = (&views[i], &field.views[i]);
            if i == REFERENCE { [l1(a, b), 0.0, 0.0] } else { [l1(a, b), psnr(a, b), ssim(a, b)] }
        })
        .collect();
    let rim = |i: &usize| [i / 8, i % 8].iter().any(|&k| k == 0 || k == 7);
    let over = |which: &dyn Fn(&usize) -> bool, what: usize| {
        mean((0..64).filter(|i| which(i)).map(|i| each[i][what])).unwrap_or(0.0)
    };
    let (l1_01, outer_l1_01) = (over(&|_| true, 0), over(&rim, 0));
    Closeness {
        l1_01,
        l1_11: 2.0 * l1_01,
        outer_l1_01,
        outer_l1_11: 2.0 * outer_l1_01,
        psnr: over(&|&i| i != REFERENCE, 1),
        ssim: over(&|&i| i != REFERENCE, 2),
        l1_by_u: (0..8).map(|u| over(&|i| i % 8 == u, 0)).collect(),
    }
}

fn tiles(field: &TrueField, swept: &Swept, own: &[f32], full: &[Rgb]) -> Vec<Rgb> {
    let (size, middle) = (field.size, field.size[1] / 2);
    vec![
        field.reference().clone(),
        depth_tile(&swept.disparity_px, size, usual_range(&swept.disparity_px)),
        depth_tile(own, size, usual_range(own)),
        epi_tile(|layer| &field.views[layer], middle, 4),
        epi_tile(|layer| &full[layer], middle, 4),
    ]
}
