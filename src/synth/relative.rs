//! Any monocular-depth net with a manifest (`task = "relative-depth"`) as one more source of ray depth.

use super::net::Net;
use super::picture::Signed;
use super::{ColourOrder, Layout, Manifest, ModelError, ModelFile, RelativeOutput, SynthError, upsample};
use crate::field::{DisparityMap, View, fit_long_side};
use crate::job::Job;

/// Share of the pixels that is left out at either end when relative depth is stretched to the manifest's range.
const TAIL: f32 = 0.02;

/// A net of somebody else: photo → relative depth.
pub(super) struct RelativeNet {
    net: Net,
}

impl RelativeNet {
    /// Checks the model against its manifest; its answer may have any axes of length 1 around `[H, W]`.
    pub(super) fn load(file: ModelFile) -> Result<Self, ModelError> {
        Ok(Self { net: Net::unchecked(file) })
    }

    /// Ray depth of the reference view at its size.
    pub(super) fn estimate(&self, photo: &View, threads: usize, job: &Job) -> Result<DisparityMap, SynthError> {
        let manifest = self.net.manifest();
        let size = working_size(manifest, photo.size());
        let input = relative_input(manifest, &Signed::resized(photo, size));
        let shape = match manifest.relative.layout {
            Layout::Nchw => [1, 3, size[1], size[0]],
            Layout::Nhwc => [1, size[1], size[0], 3],
        };
        let output = self.net.run(&shape, &input, threads, job.cancel)?;
        let [w, h] = self.net.map_size(&output)?;
        let map = DisparityMap { size: [w as u32, h as u32], disparity_px: stretched(manifest, &output) };
        Ok(upsample::to_guide(&map, photo))
    }
}

/// The input's size: fixed by the manifest, or the photo's shape at the working long side.
fn working_size(manifest: &Manifest, photo: [u32; 2]) -> [usize; 2] {
    let fixed = manifest.relative.input_size;
    if fixed.iter().all(|side| *side > 0) {
        return fixed.map(|side| side as usize);
    }
    let side = manifest.working_long_side.as_slice()[0];
    let multiple = manifest.multiple_of as usize;
    let nearest = |side: u32| ((side as usize + multiple / 2) / multiple).max(1) * multiple;
    fit_long_side(photo, side).map(nearest)
}

/// Colours in 0 … 1 in the order of the manifest, less its mean, over its deviation, in its layout.
fn relative_input(manifest: &Manifest, photo: &Signed) -> Vec<f32> {
    let rules = &manifest.relative;
    let value = |pixel: &glam::Vec4, c: usize| {
        let source = if rules.order == ColourOrder::Bgr { 2 - c } else { c };
        ((pixel[source] + 1.0) / 2.0 - rules.mean[c]) / rules.std[c]
    };
    match rules.layout {
        Layout::Nchw => (0..3).flat_map(|c| photo.pixels.iter().map(move |pixel| value(pixel, c))).collect(),
        Layout::Nhwc => photo.pixels.iter().flat_map(|pixel| (0..3).map(move |c| value(pixel, c))).collect(),
    }
}

/// Relative depth as disparity: nearness stretched to the manifest's range, but for a few outliers.
fn stretched(manifest: &Manifest, output: &[f32]) -> Vec<f32> {
    let sign = if manifest.relative.output == RelativeOutput::Distance { -1.0 } else { 1.0 };
    let nearness: Vec<f32> = output.iter().map(|value| value * sign).collect();
    let mut sorted = nearness.clone();
    sorted.sort_by(f32::total_cmp);
    let at = |share: f32| sorted[((sorted.len() - 1) as f32 * share) as usize];
    let (low, high) = (at(TAIL), at(1.0 - TAIL));
    let [lo, hi] = manifest.disparity_range_px;
    let scale = if high > low { (hi - lo) / (high - low) } else { 0.0 };
    nearness.iter().map(|n| (lo + (n - low) * scale).clamp(lo, hi)).collect()
}
