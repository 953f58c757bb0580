//! Figures on validation photos: masks and nearness maps that no net has been trained on.

use std::borrow::Cow;

use plenoscope::field::DisparityMap;
use plenoscope::scene::{Salience, focus};
use serde::Serialize;

use super::metrics::{mean, median, spearman, within_rows};
use super::sheet::{depth_tile, usual_range};
use super::truth::interval;
use super::{EvalError, Predictor, Rgb};
use crate::scenes::raster::{Raster, distance_inside};
use crate::scenes::{Config, Library, Mix, Picture, REFERENCE, SceneError, Split};

/// The long side at which photos are judged, in pixels; steps of depth are in its pixels.
pub const LONG_SIDE: usize = 270;
/// By how much a subject must be nearer than its surround, in pixels per view step at [`LONG_SIDE`].
const IN_FRONT_PX: f32 = 0.05;
/// How near an edge of depth must be to the mask's edge, in pixels.
const ALIGNED_PX: isize = 3;
/// How wide the border is in which a frame of wrong depth would show, in pixels.
const BORDER_PX: usize = 12;
/// How far from the mask's edge an edge of depth is looked for, in pixels.
const SEARCH_PX: isize = 10;

/// Figures of one photo; none where it has no mask or no map.
#[derive(Clone, Debug, Default, Serialize)]
pub struct PhotoFigures {
    /// The photo.
    pub id: String,
    /// Median ray depth inside the mask minus that 3 to 15 px outside it.
    pub step_px: Option<f32>,
    /// The share of the mask's edge along which the steepest step of depth lies within 3 px and falls outward.
    pub aligned: Option<f32>,
    /// See [`border_slope`].
    pub border_slope: Option<f32>,
    /// Rank correlation with the nearness map.
    pub spearman: Option<f32>,
    /// Rank correlation of the row number with the nearness map: what a net must beat.
    pub rows_spearman: Option<f32>,
    /// Correlation after each row's mean is taken out.
    pub within_rows: Option<f32>,
    /// Whether the program focuses on the masked subject by itself.
    pub focused: Option<bool>,
}

/// Means over a folder.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// `flowers`, `everyday` or `everyday10k`.
    pub folder: String,
    /// Photos.
    pub count: usize,
    /// The share of masked photos whose subject stands in front.
    pub in_front: Option<f32>,
    /// Masked photos.
    pub masked: usize,
    /// Mean of [`PhotoFigures::aligned`].
    pub aligned: Option<f32>,
    /// Mean of [`PhotoFigures::border_slope`]: at most about 1 where there is no frame.
    pub border_slope: Option<f32>,
    /// Mean rank correlation.
    pub spearman: Option<f32>,
    /// That of the row number.
    pub rows_spearman: Option<f32>,
    /// Spearman above that of the row number, and its 95 % interval over photos.
    pub margin: Option<[f32; 3]>,
    /// Mean correlation within rows.
    pub within_rows: Option<f32>,
    /// The share of masked photos on whose subject the program focuses by itself.
    pub focused: Option<f32>,
}

/// The figures of all photos, their means by folder, and pictures of the first ones.
pub struct Report {
    /// One a folder.
    pub summaries: Vec<Summary>,
    /// One a photo.
    pub photos: Vec<PhotoFigures>,
    /// Photo, mask or nearness map, predicted depth.
    pub tiles: Vec<Vec<Rgb>>,
}

/// The validation photos of a data folder.
///
/// # Errors
/// Files that are missing, broken or do not fit together.
pub fn library(data: &std::path::Path, long_side: usize) -> Result<Library, SceneError> {
    let mix = Mix { real: 0.0, ..Mix::default() };
    // A library keeps its pictures a fifth larger than the scenes that are made of them.
    Library::load(&Config {
        data: data.to_owned(),
        long_side: long_side * 5 / 6,
        mix,
        split: Split::Val,
        ..Config::default()
    })
}

/// Evaluates photos; `tiles` of each folder come as pictures. `seen` is told after each photo how many there are in all.
///
/// # Errors
/// What the predictor says; nothing to evaluate.
pub fn evaluate(
    data: &std::path::Path,
    predictor: &dyn Predictor,
    tiles: usize,
    seen: &dyn Fn(usize),
) -> anyhow::Result<Report> {
    let library = library(data, LONG_SIDE)?;
    if library.pictures.is_empty() {
        return Err(EvalError::NoPhotos(data.to_owned()).into());
    }
    let mut report = Report { summaries: Vec::new(), photos: Vec::new(), tiles: Vec::new() };
    for folder in ["flowers", "everyday", "everyday10k"] {
        // Measured depth is judged elsewhere.
        let here = |p: &&Picture| !p.measured && p.id.split_once('/').is_some_and(|(own, _)| own == folder);
        let inside: Vec<&Picture> = library.pictures.iter().filter(here).collect();
        let mut photos = Vec::with_capacity(inside.len());
        for (i, picture) in inside.iter().enumerate() {
            let rgb = picture.rgb.map(|texel| texel.map(|c| f32::from(c) / 255.0));
            let prediction = predictor.predict(&rgb)?;
            let depth = prediction.view(REFERENCE, rgb.px.len());
            photos.push(photo(picture, depth));
            if i % inside.len().div_ceil(tiles.max(1)).max(1) == 0 && tiles > 0 {
                report.tiles.push(row(picture, rgb, depth));
            }
            seen(library.pictures.len());
        }
        report.summaries.push(summary(folder, &photos));
        report.photos.extend(photos);
    }
    Ok(report)
}

fn row(picture: &Picture, rgb: Rgb, depth: &[f32]) -> Vec<Rgb> {
    let size = rgb.size;
    let gray = |raster: &Raster<u8>| raster.map(|&value| [f32::from(value) / 255.0; 3]);
    let truth = picture.nearness.as_ref().or(picture.mask.as_ref()).map_or_else(|| rgb.clone(), gray);
    vec![rgb, truth, depth_tile(depth, size, usual_range(depth))]
}

/// The figures of one photo; `depth` is the reference view's, `[y, x]`.
pub fn photo(picture: &Picture, depth: &[f32]) -> PhotoFigures {
    let size = picture.rgb.size;
    let nearness: Option<Vec<f32>> =
        picture.nearness.as_ref().map(|map| map.px.iter().map(|&b| f32::from(b)).collect());
    let nearness = nearness.filter(|_| picture.id.starts_with("everyday"));
    let rows = || (0..depth.len()).map(|i| (i / size[0]) as f32).collect::<Vec<_>>();
    PhotoFigures {
        id: picture.id.clone(),
        step_px: picture.mask.as_ref().and_then(|mask| step(mask, depth)),
        aligned: picture.mask.as_ref().and_then(|mask| aligned(mask, depth)),
        border_slope: border_slope(depth, size),
        spearman: nearness.as_ref().map(|map| spearman(depth, map)),
        rows_spearman: nearness.as_ref().map(|map| spearman(&rows(), map)),
        within_rows: nearness.as_ref().map(|map| within_rows(depth, map, size[0])),
        focused: picture.mask.as_ref().and_then(|mask| focused(mask, &picture.rgb, depth)),
    }
}

/// Whether the place that the program takes for the subject's is on the mask; none where there is no mask, or no depth.
fn focused(mask: &Raster<u8>, rgb: &Raster<[u8; 3]>, depth: &[f32]) -> Option<bool> {
    let size = mask.size.map(|side| side as u32);
    let map = DisparityMap::new(size, depth.to_vec()).ok()?;
    let row = |y: usize| rgb.px[y * rgb.size[0]..][..rgb.size[0]].iter().flat_map(|&[r, g, b]| [r, g, b, 255]);
    let salience = Salience::of(size, |y| Cow::Owned(row(y).collect()));
    let [x, y] = focus::subject(&map, &salience);
    let at = |share: f32, side: usize| ((share * side as f32) as usize).min(side - 1);
    Some(mask.at(at(x, mask.size[0]), at(y, mask.size[1])) > 127)
}

fn summary(folder: &str, photos: &[PhotoFigures]) -> Summary {
    let masked: Vec<f32> = photos.iter().filter_map(|p| p.step_px).collect();
    let of = |what: fn(&PhotoFigures) -> Option<f32>| mean(photos.iter().filter_map(what));
    Summary {
        folder: folder.to_owned(),
        count: photos.len(),
        in_front: mean(masked.iter().map(|&step| f32::from(u8::from(step > IN_FRONT_PX)))),
        masked: masked.len(),
        aligned: of(|p| p.aligned),
        border_slope: of(|p| p.border_slope),
        spearman: of(|p| p.spearman),
        rows_spearman: of(|p| p.rows_spearman),
        margin: margin(photos),
        within_rows: of(|p| p.within_rows),
        focused: of(|p| p.focused.map(|is_on_it| f32::from(u8::from(is_on_it)))),
    }
}

fn margin(photos: &[PhotoFigures]) -> Option<[f32; 3]> {
    let margins: Vec<f32> = photos.iter().filter_map(|p| Some(p.spearman? - p.rows_spearman?)).collect();
    let [low, high] = interval(&margins);
    Some([mean(margins.iter().copied())?, low, high])
}

/// Median inside a mask minus median 3 … 15 px outside it; none where one of the two is empty.
pub fn step(mask: &Raster<u8>, depth: &[f32]) -> Option<f32> {
    let outside: Vec<bool> = mask.px.iter().map(|&m| m <= 127).collect();
    let distance = distance_inside(&outside, mask.size);
    let pick =
        |wanted: &dyn Fn(usize) -> bool| median((0..depth.len()).filter(|&i| wanted(i)).map(|i| depth[i]).collect());
    Some(pick(&|i| !outside[i])? - pick(&|i| (3.0..=15.0).contains(&distance[i]))?)
}

/// How much depth changes across the outer 12 px, at right angles to the picture's border, as a multiple of how much
/// it changes so elsewhere. A frame of wrong depth, as zero padding leaves it, stands out as a multiple far above 1.
/// None where nothing changes, or where the picture is too small.
pub fn border_slope(depth: &[f32], [w, h]: [usize; 2]) -> Option<f32> {
    if w <= 3 * BORDER_PX || h <= 3 * BORDER_PX {
        return None;
    }
    let (mut border, mut inside) = (Vec::new(), Vec::new());
    let mut put = |near: bool, step: f32| if near { border.push(step) } else { inside.push(step) };
    let near = |at: usize, side: usize| at < BORDER_PX || at + 1 >= side - BORDER_PX;
    for y in 0..h {
        (0..w - 1).for_each(|x| put(near(x, w), (depth[y * w + x + 1] - depth[y * w + x]).abs()));
    }
    for y in 0..h - 1 {
        (0..w).for_each(|x| put(near(y, h), (depth[(y + 1) * w + x] - depth[y * w + x]).abs()));
    }
    let inside = mean(inside.into_iter()).filter(|&slope| slope > 0.0)?;
    Some(mean(border.into_iter())? / inside)
}

/// See [`PhotoFigures::aligned`]. Along the mask's normal, 10 px to each side, the steepest change of depth is looked
/// for; edges nearer than that to the picture's border do not count.
pub fn aligned(mask: &Raster<u8>, depth: &[f32]) -> Option<f32> {
    let [w, h] = mask.size;
    let mut soft = mask.map(|&m| [f32::from(m) / 255.0]);
    soft.blur(2.0);
    let depth = Raster { size: mask.size, px: depth.to_vec() };
    let room = SEARCH_PX as usize + 1;
    let (mut good, mut all) = (0.0f32, 0.0f32);
    for y in room..h.saturating_sub(room) {
        for x in room..w.saturating_sub(room) {
            let inside = |x: usize, y: usize| mask.at(x, y) > 127;
            if !inside(x, y) || [(x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)].iter().all(|&(x, y)| inside(x, y)) {
                continue;
            }
            let slope = [soft.at(x + 1, y)[0] - soft.at(x - 1, y)[0], soft.at(x, y + 1)[0] - soft.at(x, y - 1)[0]];
            let long = slope[0].hypot(slope[1]);
            if long < 1e-4 {
                continue;
            }
            let outward = slope.map(|s| -s / long);
            let at = |k: isize| depth.tap(x as f32 + outward[0] * k as f32, y as f32 + outward[1] * k as f32);
            let fall = |k: isize| at(k) - at(k + 1);
            let steepest =
                (-SEARCH_PX..SEARCH_PX).max_by(|&a, &b| fall(a).abs().total_cmp(&fall(b).abs())).unwrap_or(0);
            all += 1.0;
            // Between pixels k and k + 1; the mask's edge lies between 0 and 1.
            good += f32::from(u8::from(steepest.abs() <= ALIGNED_PX && fall(steepest) > 0.0));
        }
    }
    (all > 0.0).then(|| good / all)
}
