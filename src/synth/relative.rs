//! Any monocular-depth net with a manifest (`task = "relative-depth"`) as one more source of ray depth.

use super::net::Net;
use super::picture::{Signed, size_in_steps};
use super::range::{Estimate, Metric};
use super::tract::Output;
use super::{
    ColourOrder, Layout, Manifest, ModelFile, RelativeOutput, RelativeRules, SynthError, SynthParams, upsample,
};
use crate::field::{DisparityMap, FieldError, Photo, RelativeDepth, Size, View, sides};
use crate::job::Job;

/// A net of somebody else: photo → relative depth.
pub(super) struct RelativeNet {
    net: Net,
}

impl RelativeNet {
    /// Takes a model; its answer may have any axes of length 1 around `[H, W]`, and another size than its input.
    pub(super) fn new(file: ModelFile) -> Self {
        Self { net: Net::unchecked(file) }
    }

    pub(super) fn net(&self) -> &Net {
        &self.net
    }

    /// Ray depth of the reference view at its size, and metres where the net knows them. The net sees the photo itself, at the size that is best for it.
    pub(super) fn estimate(
        &self,
        photo: &Photo,
        reference: &View,
        params: &SynthParams,
        job: &Job,
    ) -> Result<(DisparityMap, Option<Metric>), SynthError> {
        let manifest = self.net.manifest();
        let size = working_size(manifest, photo.size());
        let input = relative_input(manifest, &Signed::of_photo(photo, size, job)?);
        let outputs = self.net.run_all(&input_shape(manifest, size), &input, params.threads, job.cancel)?;
        let kind = manifest.relative.output;
        let ([w, h], values) = map_of(&outputs[0], kind).ok_or_else(|| self.net.no_map(&outputs[0]))?;
        let further = Further::of(&manifest.relative, &outputs, values.len(), w as f32 / sides(size)[0] as f32);
        let estimate = estimate_of(kind, [w as u32, h as u32], &values, further)?;
        let map = estimate.disparity(&params.camera, manifest.disparity_range_px)?;
        let metric = estimate.metric_scale(&params.camera, manifest.disparity_range_px);
        Ok((upsample::to_guide(&map, reference, job)?, metric))
    }
}

/// What a net answers beside its map.
#[derive(Default)]
struct Further {
    /// Where the sky is, `[y, x]` of the map.
    sky: Option<Vec<bool>>,
    /// Focal length in pixels of the map.
    focal_px: Option<f32>,
}

impl Further {
    /// Of the outputs in the order of [`RelativeRules::wiring`](super::RelativeRules::wiring); one of another size than
    /// the map says nothing. `ratio` is that of the map's width to the input's.
    fn of(rules: &RelativeRules, outputs: &[Output], pixels: usize, ratio: f32) -> Self {
        let mut rest = outputs.iter().skip(1);
        let mut next = |name: &String| if name.is_empty() { None } else { rest.next() };
        let (sky, focal) = (next(&rules.sky_output), next(&rules.focal_output));
        let is_sky = |output: &Output| output.iter().map(|share| *share > 0.5).collect();
        let sky = sky.filter(|output| output.len() == pixels).map(is_sky);
        let focal_px = focal.and_then(|output| output.first()).map(|px| px * ratio).filter(|px| px.is_finite());
        Self { sky, focal_px }
    }
}

/// What a net's numbers say.
fn estimate_of(kind: RelativeOutput, size: Size, values: &[f32], further: Further) -> Result<Estimate, FieldError> {
    let nearness = RelativeDepth::new(size, kind.nearness_of(values))?;
    let estimate = match kind {
        RelativeOutput::Metres => Estimate::metric(nearness, further.focal_px),
        _ => Estimate::relative(nearness),
    };
    Ok(match (further.sky, kind) {
        (Some(sky), _) => estimate.with_sky(sky),
        (None, RelativeOutput::Nearness) => estimate.with_zeros_as_sky(),
        (None, _) => estimate,
    })
}

/// The input's size: fixed by the manifest, or the photo's shape at the working long side.
pub(super) fn working_size(manifest: &Manifest, photo: Size) -> Size {
    let fixed = manifest.relative.input_size;
    if fixed.iter().all(|side| *side > 0) {
        return fixed;
    }
    let side = match manifest.relative.short_side {
        0 => manifest.working_long_side.as_slice()[0],
        short => long_side(photo, short),
    };
    size_in_steps(photo, side, manifest.multiple_of)
}

/// How much longer than its shorter side a picture may be to a net: panoramas are seen smaller.
const LONGEST: f32 = 3.0;

/// The long side at which a photo has this short side.
fn long_side([w, h]: Size, short: u32) -> u32 {
    let shape = (w.max(h) as f32 / w.min(h).max(1) as f32).min(LONGEST);
    (short as f32 * shape).round() as u32
}

/// Colours in 0 … 1 in the order of the manifest, less its mean, over its deviation, in its layout.
pub(super) fn relative_input(manifest: &Manifest, photo: &Signed) -> Vec<f32> {
    let rules = &manifest.relative;
    let value = |pixel: &glam::Vec4, c: usize| {
        let source = if rules.order == ColourOrder::Bgr { 2 - c } else { c };
        ((pixel[source] + 1.0) / 2.0 * rules.value_scale - rules.mean[c]) / rules.std[c]
    };
    match rules.layout {
        Layout::Nchw | Layout::Nvchw => {
            (0..3).flat_map(|c| photo.pixels().iter().map(move |pixel| value(pixel, c))).collect()
        }
        Layout::Nhwc => photo.pixels().iter().flat_map(|pixel| (0..3).map(move |c| value(pixel, c))).collect(),
    }
}

/// The shape of a picture of this size, as the manifest's layout has it.
pub(super) fn input_shape(manifest: &Manifest, size: Size) -> Vec<usize> {
    let [w, h] = sides(size);
    match manifest.relative.layout {
        Layout::Nchw => vec![1, 3, h, w],
        Layout::Nhwc => vec![1, h, w, 3],
        Layout::Nvchw => vec![1, 1, 3, h, w],
    }
}

/// Width, height and values of an answer that is one map: its axes that are longer than 1, or the last two; of points
/// their third coordinate. None where it is more.
pub(super) fn map_of(output: &Output, kind: RelativeOutput) -> Option<([usize; 2], Vec<f32>)> {
    let shape = output.shape();
    if kind == RelativeOutput::Points {
        let [.., h, w, 3] = *shape else { return None };
        return (output.len() == h * w * 3).then(|| ([w, h], output.chunks_exact(3).map(|point| point[2]).collect()));
    }
    let size = match shape.iter().copied().filter(|n| *n > 1).collect::<Vec<_>>()[..] {
        [h, w] => [w, h],
        _ => match *shape {
            [.., h, w] if output.len() == h * w => [w, h],
            _ => return None,
        },
    };
    Some((size, output.to_vec()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distance_is_inverted_and_stays_finite_at_zero() {
        let of = |output: RelativeOutput| [0.0, 1.0, 2.0, 10.0].map(|value| output.nearness(value, 10.0));
        assert_eq!(of(RelativeOutput::Distance), [100.0, 1.0, 0.5, 0.1]);
        assert_eq!(of(RelativeOutput::Farness), [0.0, -1.0, -2.0, -10.0]);
        assert_eq!(of(RelativeOutput::Nearness), [0.0, 1.0, 2.0, 10.0]);
        assert!(RelativeOutput::Distance.nearness(0.0, 0.0).is_finite());
    }
}
