//! Any monocular-depth net with a manifest (`task = "relative-depth"`) as one more source of ray depth.

use super::net::Net;
use super::picture::{Signed, size_in_steps};
use super::{ColourOrder, Layout, Manifest, ModelFile, SynthError, upsample};
use crate::field::{DisparityMap, FieldError, Filter, RelativeDepth, Size, View, sides};
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

    /// Ray depth of the reference view at its size.
    pub(super) fn estimate(&self, photo: &View, threads: usize, job: &Job) -> Result<DisparityMap, SynthError> {
        let manifest = self.net.manifest();
        let size = working_size(manifest, photo.size());
        let input = relative_input(manifest, &Signed::resized(photo, size, Filter::Lanczos3));
        let [w, h] = sides(size);
        let shape = match manifest.relative.layout {
            Layout::Nchw => [1, 3, h, w],
            Layout::Nhwc => [1, h, w, 3],
        };
        let output = self.net.run(&shape, &input, threads, job.cancel)?;
        let [w, h] = self.net.map_size(&output)?;
        let range_px = manifest.disparity_range_px.unwrap_or_else(|| RelativeDepth::usual_range_px(w as u32));
        let greatest = output.iter().copied().fold(0.0, f32::max);
        let nearness = output.iter().map(|value| manifest.relative.output.nearness(*value, greatest)).collect();
        let map = clamped(&RelativeDepth::new([w as u32, h as u32], nearness)?, range_px)?;
        upsample::to_guide(&map, photo, job)
    }
}

/// The input's size: fixed by the manifest, or the photo's shape at the working long side.
fn working_size(manifest: &Manifest, photo: Size) -> Size {
    let fixed = manifest.relative.input_size;
    if fixed.iter().all(|side| *side > 0) {
        return fixed;
    }
    let side = manifest.working_long_side.as_slice()[0];
    size_in_steps(photo, side, manifest.multiple_of)
}

/// Colours in 0 … 1 in the order of the manifest, less its mean, over its deviation, in its layout.
fn relative_input(manifest: &Manifest, photo: &Signed) -> Vec<f32> {
    let rules = &manifest.relative;
    let value = |pixel: &glam::Vec4, c: usize| {
        let source = if rules.order == ColourOrder::Bgr { 2 - c } else { c };
        ((pixel[source] + 1.0) / 2.0 - rules.mean[c]) / rules.std[c]
    };
    match rules.layout {
        Layout::Nchw => (0..3).flat_map(|c| photo.pixels().iter().map(move |pixel| value(pixel, c))).collect(),
        Layout::Nhwc => photo.pixels().iter().flat_map(|pixel| (0..3).map(move |c| value(pixel, c))).collect(),
    }
}

/// Relative depth as disparity, outliers cut: a net's distances near 0 would lie beyond all measure.
fn clamped(depth: &RelativeDepth, [far, near]: [f32; 2]) -> Result<DisparityMap, FieldError> {
    let map = depth.stretched([far, near]);
    DisparityMap::new(map.size(), map.disparity_px().iter().map(|d| d.clamp(far, near)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synth::RelativeOutput;

    #[test]
    fn nearness_is_stretched_and_outliers_are_cut() {
        let mut nearness: Vec<f32> = (0..=100).map(|n| n as f32).collect();
        nearness[100] = 1e6;
        let map = clamped(&RelativeDepth::new([101, 1], nearness).unwrap(), [-1.0, 1.0]).unwrap();
        assert_eq!([0, 2, 98, 100].map(|x| map.at(x, 0)), [-1.0, -1.0, 1.0, 1.0]);
        assert!(map.at(50, 0).abs() < 1e-6);
    }

    #[test]
    fn distance_is_inverted_and_stays_finite_at_zero() {
        let of = |output: RelativeOutput| [0.0, 1.0, 2.0, 10.0].map(|value| output.nearness(value, 10.0));
        assert_eq!(of(RelativeOutput::Distance), [100.0, 1.0, 0.5, 0.1]);
        assert_eq!(of(RelativeOutput::Farness), [0.0, -1.0, -2.0, -10.0]);
        assert_eq!(of(RelativeOutput::Nearness), [0.0, 1.0, 2.0, 10.0]);
        assert!(RelativeOutput::Distance.nearness(0.0, 0.0).is_finite());
    }
}
