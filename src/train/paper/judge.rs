//! What each method makes of a light field that it never saw, from its reference view alone (one: from its corners).

use std::collections::BTreeMap;

use anyhow::Result;
use plenoscope::job::{Cancel, Job};
use rayon::prelude::*;
use serde::Serialize;

use super::method::Method;
use crate::batch::Batch;
use crate::checkpoint::Checkpoint;
use crate::config::Config;
use crate::eval::light_field::closeness;
use crate::eval::metrics::correlation;
use crate::eval::{CORNERS, Rgb, TrueField, metrics, warp};
use crate::field::light_field;
use crate::loss::{self, Maps};
use crate::nets::{REFERENCE, VIEWS};
use crate::run::Nets;
use crate::scenes::raster::Raster;
use crate::scenes::steps;
use crate::{corners, step, view_step};

/// Bars of the histogram of disparities, over ±[`HISTOGRAM_PX`] across the whole aperture.
pub const BARS: usize = 32;
/// Half the histogram's width: px between the outermost views, at the size that is judged.
pub const HISTOGRAM_PX: f32 = 8.0;
/// Views from one end of the aperture to the other.
const ACROSS: f32 = 7.0;

/// 64 views, and the ray depths `[v, y, x]` that they were made with.
pub struct Made {
    /// The views.
    pub views: Vec<Rgb>,
    /// Px per view step; of methods with geometry.
    pub depths: Option<Vec<f32>>,
}

/// Figures of one method on one light field.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Figures {
    /// Mean L1 over all 64 views, values in 0 … 1.
    pub l1: f32,
    /// Over the 28 outermost.
    pub outermost_l1: f32,
    /// By columns of views, u = −4 … 3.
    pub l1_by_u: Vec<f32>,
    /// Over the 59 views that neither the method nor one that is given the corners knows.
    pub unseen_l1: f32,
    /// Mean |D(x, u) − D(x + D, u − 1)|, px: how much ray depths differ along epipolar lines (ψ_c).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub inconsistency_px: Option<f32>,
    /// Correlation of the reference view's ray depths with those measured from all views.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depth_correlation: Option<f32>,
}

/// What is found on one light field: little enough to be kept of a hundred.
pub struct Judged {
    /// Its name.
    pub name: String,
    /// By the name of the method; `lambertian` is [`Method::Ours`] before the occlusion net.
    pub figures: BTreeMap<&'static str, Figures>,
    /// Rays of ours by their disparity, as [`count`] counts them; none where it is not trained.
    pub disparities: Option<[u64; BARS]>,
}

/// One light field with everything that was made of it: hundreds of megabytes, so it is kept of one.
pub struct Shown {
    /// The true views.
    pub field: TrueField,
    /// Ray depth of the reference view, px per view step: the file's own, else measured from all views.
    pub measured: Vec<f32>,
    /// By the names of [`Judged::figures`].
    pub made: BTreeMap<&'static str, Made>,
}

/// Key of ours before the occlusion net.
pub const LAMBERTIAN: &str = "lambertian";
/// Key of the views that the measured depth gives.
pub const MEASURED: &str = "measured-depth";
/// Key of the four corners blended as they are, the nearer one more.
pub const BLEND: &str = "corners-blended";
/// Key of the four corners warped by the depth that a sweep over them finds.
pub const SWEPT: &str = "corners-swept";
/// Key of the photo copied to all views.
pub const COPY: &str = "copy";

/// The names that people read.
pub fn title(name: &str) -> &str {
    let of = |method: &Method| method.name() == name;
    match Method::ALL.iter().find(|method| of(method)) {
        Some(method) => method.title(),
        None => match name {
            LAMBERTIAN => "ours, Lambertian",
            MEASURED => "the photo warped by the depth of all views",
            COPY => "the photo copied",
            BLEND => "the four corners blended",
            SWEPT => "the four corners warped by their swept depth",
            _ => name,
        },
    }
}

/// The light field with views of at most `long_side`.
pub fn shrunk(field: TrueField, long_side: usize) -> TrueField {
    let [w, h] = field.size;
    if w.max(h) <= long_side {
        return field;
    }
    let scale = long_side as f32 / w.max(h) as f32;
    let size = [w, h].map(|side| ((side as f32 * scale).round() as usize).max(2));
    let views = field.views.par_iter().map(|view| view.resized(size)).collect();
    TrueField { views, size, depths: Vec::new(), ..field }
}

/// Judges the nets that there are by one light field.
///
/// # Errors
/// What the nets and the sweeps say.
pub fn judge(field: TrueField, nets: &BTreeMap<Method, Nets>, config: &Config) -> Result<(Judged, Shown)> {
    let batch = batch_of(&field);
    let measured = field.reference_disparity()?.px;
    let mut made = BTreeMap::new();
    for (method, nets) in nets {
        for (name, views) in predicted(*method, nets, &batch, config)? {
            made.insert(name, views);
        }
    }
    made.insert(MEASURED, by_one_map(&field, &measured));
    made.insert(COPY, Made { views: vec![field.reference().clone(); VIEWS], depths: None });
    made.insert(BLEND, Made { views: pictures(&corners::blended(&batch)?, field.size), depths: None });
    made.insert(SWEPT, by_corners(&field)?);
    let figures = made.iter().map(|(name, made)| (*name, figures(&field, made, &measured))).collect();
    let ours = made.get(Method::Ours.name()).and_then(|made| made.depths.as_ref());
    let disparities = ours.map(|depths| count(depths));
    Ok((Judged { name: field.name.clone(), figures, disparities }, Shown { field, measured, made }))
}

/// As `plenoscope synth --corners` makes them.
fn by_corners(field: &TrueField) -> Result<Made> {
    let whole = light_field(&field.views)?;
    let given = CORNERS.map(|layer| whole.view(whole.grid().view_from_layer(layer)).clone());
    let cancel = Cancel::default();
    let (made, depths) = plenoscope::synth::corners::between(&given, &Job { cancel: &cancel, sink: &() })?;
    Ok(Made { views: TrueField::of_views(&made), depths: Some(depths.disparity_px().to_vec()) })
}

/// What ours makes of a photo, for its time to be taken.
///
/// # Errors
/// What the nets say.
pub fn synthesized(nets: &Nets, photo: &Rgb, config: &Config) -> Result<Vec<(&'static str, Made)>> {
    let field =
        TrueField { name: String::new(), size: photo.size, views: vec![photo.clone(); VIEWS], depths: Vec::new() };
    predicted(Method::Ours, nets, &batch_of(&field), config)
}

/// One sample: the light field itself, which the nets see the reference view of.
fn batch_of(field: &TrueField) -> Batch {
    let maps = Maps { samples: 1, views: (0..VIEWS).collect(), height: field.size[1], width: field.size[0] };
    let plane = |view: &Rgb, c: usize| view.px.iter().map(move |texel| texel[c]).collect::<Vec<_>>();
    Batch {
        first_sample: 0,
        views: field.views.iter().flat_map(|view| (0..3).flat_map(|c| plane(view, c))).collect(),
        truth: vec![f32::NAN; maps.len()],
        yx: vec![[-1.0, 1.0, -1.0, 1.0]],
        worth: vec![1.0],
        subjects: vec![Vec::new()],
        maps,
    }
}

/// The views of a method, and of ours those before the occlusion net, too.
fn predicted(method: Method, nets: &Nets, batch: &Batch, config: &Config) -> Result<Vec<(&'static str, Made)>> {
    let size = [batch.maps.width, batch.maps.height];
    let (net, second) = match (method, nets.pair()) {
        (Method::Flow | Method::Regression, [Some(net), _]) => {
            let views = pictures(&view_step::infer(net, batch, config)?, size);
            return Ok(vec![(method.name(), Made { views, depths: None })]);
        }
        (_, [Some(net), Some(second)]) => (net, second),
        _ => return Ok(Vec::new()),
    };
    if method == Method::Corners {
        let (views, depths) = corners::infer([net, second], batch, config)?;
        return Ok(vec![(method.name(), Made { views: pictures(&views, size), depths: Some(depths) })]);
    }
    let depths = step::infer_all_depths(net.best(), &net.arch.graph(), batch, config)?;
    let [lambertian, full] = both(second, batch, &depths, config)?.map(|views| pictures(&views, size));
    let mut made = vec![(method.name(), Made { views: full, depths: Some(depths.clone()) })];
    if method == Method::Ours {
        made.push((LAMBERTIAN, Made { views: lambertian, depths: Some(depths) }));
    }
    Ok(made)
}

fn both(net: &Checkpoint, batch: &Batch, depths: &[f32], config: &Config) -> Result<[Vec<f32>; 2]> {
    let (lambertian, full) = step::infer_views(net.best(), &net.arch.graph(), batch, depths, config)?;
    Ok([lambertian, full])
}

/// Views `[v, 3, y, x]` as pictures.
fn pictures(values: &[f32], size: [usize; 2]) -> Vec<Rgb> {
    let p = size[0] * size[1];
    let texel = |view: &[f32], i: usize| [0, 1, 2].map(|c| view[c * p + i].clamp(0.0, 1.0));
    let picture = |view: &[f32]| Raster { size, px: (0..p).map(|i| texel(view, i)).collect() };
    values.chunks_exact(3 * p).map(picture).collect()
}

/// Lambertian views of one map that all views are lifted from.
fn by_one_map(field: &TrueField, map: &[f32]) -> Made {
    let depths = crate::field::lifted(map, field.size);
    let count = map.len();
    let view = |layer: usize| {
        let (du, dv) = steps(layer);
        warp::lambertian(field.reference(), &depths[layer * count..][..count], du, dv)
    };
    Made { views: (0..VIEWS).into_par_iter().map(view).collect(), depths: Some(depths) }
}

fn figures(field: &TrueField, made: &Made, measured: &[f32]) -> Figures {
    let near = closeness(field, &made.views);
    let unseen = |layer: &usize| *layer != REFERENCE && !CORNERS.contains(layer);
    let unseen = (0..VIEWS).filter(unseen).map(|layer| metrics::l1(&made.views[layer], &field.views[layer]));
    let maps = Maps { samples: 1, views: (0..VIEWS).collect(), height: field.size[1], width: field.size[0] };
    let of_depths = |depths: &Vec<f32>| loss::consistency(&maps, depths, 1.0, &mut vec![0.0; depths.len()]);
    let own = |depths: &Vec<f32>| depths[REFERENCE * measured.len()..][..measured.len()].to_vec();
    Figures {
        l1: near.l1_01,
        outermost_l1: near.outer_l1_01,
        l1_by_u: near.l1_by_u,
        unseen_l1: metrics::mean(unseen).unwrap_or(0.0),
        inconsistency_px: made.depths.as_ref().map(of_depths),
        depth_correlation: made.depths.as_ref().map(|d| correlation(own(d).into_iter().zip(measured.iter().copied()))),
    }
}

/// Ray depths as a histogram of disparities across the whole aperture; what lies beyond is in its outermost bars.
fn count(depths: &[f32]) -> [u64; BARS] {
    let mut histogram = [0; BARS];
    for d in depths {
        let place = (d * ACROSS / HISTOGRAM_PX + 1.0) * 0.5 * BARS as f32;
        histogram[place.clamp(0.0, (BARS - 1) as f32) as usize] += 1;
    }
    histogram
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_histogram_has_every_ray_and_its_ends_the_rest() {
        let histogram = count(&[0.01, -0.01, 9.0, -9.0, -9.0]);
        assert_eq!((histogram[0], histogram[BARS / 2 - 1], histogram[BARS / 2], histogram[BARS - 1]), (2, 1, 1, 1));
    }
}
