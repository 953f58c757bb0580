//! The depth net: photo → ray depths at the net's working scale (paper, §3.1).

use glam::Vec4;

use super::net::Net;
use super::picture::Signed;
use super::resample::{Filter, resample};
use super::{Channels, ModelError, ModelFile, SynthError};
use crate::field::{DisparityMap, View, ViewGrid, fit_long_side};
use crate::job::Job;

/// Sides of the net's input are multiples of this at least, so that photos of odd shapes share nets made ready.
const BUCKET_PX: usize = 16;

/// The depth net of a manifest with `task = "ray-depth"`.
pub(super) struct DepthNet {
    net: Net,
    grid: ViewGrid,
}

/// The net's maps at its working scale.
///
/// # Shapes
/// - `maps`: `[v, u, y, x]`, pixels per view step at width `size[0]`
pub(super) struct NetDepths {
    pub(super) grid: ViewGrid,
    pub(super) size: [usize; 2],
    pub(super) maps: Vec<f32>,
}

impl NetDepths {
    /// The map of one view.
    pub(super) fn layer(&self, layer: usize) -> &[f32] {
        let plane = self.size[0] * self.size[1];
        &self.maps[layer * plane..(layer + 1) * plane]
    }

    /// The map of the reference view.
    pub(super) fn reference(&self) -> DisparityMap {
        let layer = self.grid.layer_from_view(self.grid.reference());
        DisparityMap { size: self.size.map(|side| side as u32), disparity_px: self.layer(layer).to_vec() }
    }
}

impl DepthNet {
    /// Checks the model against its manifest.
    pub(super) fn load(file: ModelFile) -> Result<Self, ModelError> {
        let grid = file.manifest.grid()?;
        let (channels, views) = (file.manifest.input_channels(), grid.count());
        let net = Net::load(file, |h, w| vec![1, channels, h, w], |h, w| vec![1, views, h, w])?;
        Ok(Self { net, grid })
    }

    pub(super) fn net(&self) -> &Net {
        &self.net
    }

    pub(super) fn grid(&self) -> ViewGrid {
        self.grid
    }

    /// Ray depths at the finest working scale of the manifest.
    pub(super) fn estimate(&self, photo: &View, threads: usize, job: &Job) -> Result<NetDepths, SynthError> {
        let mut merged: Option<NetDepths> = None;
        for side in self.net.manifest().working_long_side.as_slice() {
            let size = fit_long_side(photo.size(), *side).map(|side| side as usize);
            let fine = self.at_scale(&Signed::resized(photo, size), threads, job)?;
            merged = Some(match merged {
                Some(coarse) => with_order_of(fine, &coarse),
                None => fine,
            });
        }
        merged
            .ok_or_else(|| ModelError::Manifest { place: self.net.tag().id, why: "no working scale".to_owned() }.into())
    }

    fn at_scale(&self, photo: &Signed, threads: usize, job: &Job) -> Result<NetDepths, SynthError> {
        let manifest = self.net.manifest();
        let padded = bucket(photo.size, manifest.multiple_of as usize);
        let input = net_input(photo, padded, &manifest.inputs);
        let shape = [1, manifest.input_channels(), padded[1], padded[0]];
        let output = self.net.run(&shape, &input, threads, job.cancel)?;
        Ok(NetDepths { grid: self.grid, size: photo.size, maps: crop(&output, padded, photo.size) })
    }
}

/// The size at which a net is made ready for a picture.
fn bucket(size: [usize; 2], multiple_of: usize) -> [usize; 2] {
    size.map(|side| side.next_multiple_of(multiple_of * BUCKET_PX.div_ceil(multiple_of)))
}

/// The channels that a net asks for, `[c, y, x]`, the last row and column repeated up to the padded size.
fn net_input(photo: &Signed, padded: [usize; 2], channels: &[Channels]) -> Vec<f32> {
    let mut input = Vec::new();
    let mut plane = |value: &dyn Fn(usize, usize) -> f32| {
        let [w, h] = photo.size;
        let places = (0..padded[1]).flat_map(|y| (0..padded[0]).map(move |x| (x.min(w - 1), y.min(h - 1))));
        input.extend(places.map(|(x, y)| value(x, y)));
    };
    let unit = |i: usize, n: usize| if n > 1 { 2.0 * i as f32 / (n - 1) as f32 - 1.0 } else { 0.0 };
    for group in channels {
        match group {
            Channels::Rgb => {
                let colour = |c: fn(&Vec4) -> f32| move |x: usize, y: usize| c(&photo.pixels[y * photo.size[0] + x]);
                plane(&colour(|p| p.x));
                plane(&colour(|p| p.y));
                plane(&colour(|p| p.z));
            }
            Channels::Yx => {
                plane(&|_, y| unit(y, photo.size[1]));
                plane(&|x, _| unit(x, photo.size[0]));
            }
        }
    }
    input
}

/// Takes the padding off every map.
fn crop(maps: &[f32], padded: [usize; 2], size: [usize; 2]) -> Vec<f32> {
    let rows = maps.chunks_exact(padded[0] * padded[1]).flat_map(|map| map.chunks_exact(padded[0]).take(size[1]));
    rows.flat_map(|row| row[..size[0]].iter().copied()).collect()
}

/// The fine maps' detail on the coarse maps' order: what the fine scale says blurred to the coarse one is replaced.
fn with_order_of(fine: NetDepths, coarse: &NetDepths) -> NetDepths {
    let ratio = fine.size[0] as f32 / coarse.size[0] as f32;
    let mut maps = Vec::with_capacity(fine.maps.len());
    for layer in 0..fine.grid.count() {
        let blurred = resample::<1>(fine.layer(layer), fine.size, coarse.size, Filter::Linear);
        let change: Vec<f32> = coarse.layer(layer).iter().zip(&blurred).map(|(c, b)| c * ratio - b).collect();
        let change = resample::<1>(&change, coarse.size, fine.size, Filter::Linear);
        maps.extend(fine.layer(layer).iter().zip(&change).map(|(f, c)| f + c));
    }
    NetDepths { maps, ..fine }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_run_from_minus_one_to_one_over_the_picture_and_the_padding_repeats_them() {
        let photo = Signed { size: [3, 2], pixels: (0..6).map(|i| Vec4::splat(i as f32)).collect() };
        let input = net_input(&photo, [4, 2], &[Channels::Yx, Channels::Rgb]);
        assert_eq!(input[..8], [-1.0, -1.0, -1.0, -1.0, 1.0, 1.0, 1.0, 1.0]);
        assert_eq!(input[8..12], [-1.0, 0.0, 1.0, 1.0]);
        assert_eq!(input[16..24], [0.0, 1.0, 2.0, 2.0, 3.0, 4.0, 5.0, 5.0]);
        assert_eq!(crop(&input[16..24], [4, 2], [3, 2]), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
    }

    #[test]
    fn photos_of_odd_shapes_share_few_sizes() {
        let sizes: std::collections::BTreeSet<_> = (180..=202).map(|h| bucket([270, h], 1)).collect();
        assert_eq!(sizes, [[272, 192], [272, 208]].into());
        assert_eq!(bucket([112, 75], 16), [112, 80]);
        assert_eq!(bucket([100, 25], 12), [120, 48]);
    }

    #[test]
    fn merging_takes_order_from_the_coarse_map_and_detail_from_the_fine_one() {
        let grid = ViewGrid::new(1, 1).unwrap();
        let fine = NetDepths { grid, size: [32, 32], maps: (0..1024).map(|i| ((i % 2) as f32 - 0.5) * 0.2).collect() };
        let coarse = NetDepths { grid, size: [16, 16], maps: vec![1.0; 256] };
        let merged = with_order_of(fine, &coarse);
        assert!((merged.maps[16 * 32 + 16] - 1.9).abs() < 1e-4 && (merged.maps[16 * 32 + 17] - 2.1).abs() < 1e-4);
    }
}
