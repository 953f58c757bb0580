//! The depth net: photo → ray depths at the net's working scale (paper, §3.1).

use std::ops::Range;

use super::net::Net;
use super::picture::{Signed, size_in_steps};
use super::{Channels, ModelError, ModelFile, SynthError};
use crate::field::{DisparityMap, FieldError, Filter, Size, View, ViewGrid, disparity_scale, pixels, resample, sides};
use crate::job::Job;

/// Sides of the net's input are multiples of this at least, so that photos of odd shapes share nets made ready.
const STEP_PX: u32 = 16;

/// Pixels of the coarse pass along a side of the cells that two passes are compared by. Of drawn scenes 540 px wide, edges
/// and thin parts are alike with 3, 4 and 8; with 8 the order of what is near and far is a little worse.
const CELL_PX: u32 = 4;

/// How many times as large as the pass before another one is at least: with 1.4, what it says is no better.
const LARGER: f32 = 1.5;

/// The share of a layout that is taken over from the pass before.
const ALL_OF_IT: f32 = 1.0;

/// The share that is taken over from what the net says of the mirrored photo: both know the same.
const HALF: f32 = 0.5;

/// How many times as large as the first pass a photo is at most of which that pass sees all.
const ALL: f32 = 1.2;

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
    pub(super) size: Size,
    pub(super) maps: Vec<f32>,
}

impl NetDepths {
    /// The map of one view.
    pub(super) fn layer(&self, layer: usize) -> &[f32] {
        let plane = pixels(self.size);
        &self.maps[layer * plane..(layer + 1) * plane]
    }

    /// The map of the reference view.
    pub(super) fn reference(&self) -> Result<DisparityMap, FieldError> {
        let layer = self.grid.layer_from_view(self.grid.reference());
        DisparityMap::new(self.size, self.layer(layer).to_vec())
    }
}

/// One run of the net: how large it sees the photo, and whether mirrored.
#[derive(Clone, Copy)]
struct Look {
    size: Size,
    is_mirrored: bool,
}

/// Maps of one pass, `[layer, y, x]`, pixels per view step at width `size[0]`.
struct Pass {
    size: Size,
    maps: Vec<f32>,
}

impl DepthNet {
    /// Checks the model against its manifest. Those of the program are as its tests found them: a trial would take a fifth of
    /// the time to the first ray depths.
    pub(super) fn load(file: ModelFile) -> Result<Self, ModelError> {
        let grid = file.manifest.grid()?;
        let (channels, views) = (file.manifest.input_channels(), grid.count());
        let net = if file.is_built_in() {
            Net::unchecked(file)
        } else {
            Net::load(file, |h, w| vec![1, channels, h, w], |h, w| vec![1, views, h, w])?
        };
        Ok(Self { net, grid })
    }

    pub(super) fn net(&self) -> &Net {
        &self.net
    }

    pub(super) fn grid(&self) -> ViewGrid {
        self.grid
    }

    /// Whether its first pass sees nearly all pixels of a photo of this size, and so knows where the edges are.
    pub(super) fn sees_all_of(&self, photo: Size) -> bool {
        sees_all(photo, &self.pass_sizes(photo))
    }

    fn pass_sizes(&self, photo: Size) -> Vec<Size> {
        let manifest = self.net.manifest();
        pass_sizes(photo, manifest.working_long_side.as_slice(), manifest.multiple_of)
    }

    /// The runs of the net that ray depths come from, the first pass before all.
    fn looks(&self, photo: Size) -> Vec<Look> {
        let manifest = self.net.manifest();
        let mirrored = manifest.mirrored_long_side.map(|side| working_size(photo, side, manifest.multiple_of));
        let mirrored = mirrored.map(|size| Look { size, is_mirrored: true });
        let mut passes = self.pass_sizes(photo).into_iter().map(|size| Look { size, is_mirrored: false });
        passes.next().into_iter().chain(mirrored).chain(passes).collect()
    }

    /// Ray depths of all views at the finest working scale of the manifest.
    pub(super) fn estimate(&self, photo: &View, threads: usize, job: &Job) -> Result<NetDepths, SynthError> {
        let Pass { size, maps } = self.passes(photo, 0..self.grid.count(), threads, job)?;
        Ok(NetDepths { grid: self.grid, size, maps })
    }

    /// The reference view's alone.
    pub(super) fn reference(&self, photo: &View, threads: usize, job: &Job) -> Result<DisparityMap, SynthError> {
        let layer = self.grid.layer_from_view(self.grid.reference());
        let Pass { size, maps } = self.passes(photo, layer..layer + 1, threads, job)?;
        Ok(DisparityMap::new(size, maps)?)
    }

    /// All passes in one, of some of the views. A photo that is hardly larger than a pass before saw it is not seen again.
    fn passes(&self, photo: &View, layers: Range<usize>, threads: usize, job: &Job) -> Result<Pass, SynthError> {
        let looks = self.looks(photo.size());
        let id = &self.net.manifest().id;
        let none = || ModelError::Manifest { place: id.clone(), why: "no working scale".to_owned() };
        let (&first, further) = looks.split_first().ok_or_else(none)?;
        let shapes: Vec<_> = looks.iter().map(|look| self.input_shape(look.size)).collect();
        self.net.make_ready(&shapes, threads, job.cancel);
        // A net knows nothing of its picture's size: what it says of a larger one is as deep as if it were of the first one's.
        let pass = |look: Look| {
            let mut maps = self.said_of(photo, look, layers.clone(), threads, job)?;
            let unit = width_unit(photo.size(), first.size) * disparity_scale(first.size, look.size);
            maps.iter_mut().for_each(|d| *d *= unit);
            Ok::<_, SynthError>(Pass { size: look.size, maps })
        };
        further.iter().try_fold(pass(first)?, |before, &look| {
            let next = pass(look)?;
            let ([own, layout], share) =
                if look.is_mirrored { ([before, next], HALF) } else { ([next, before], ALL_OF_IT) };
            Ok(with_layout_of(own, &layout, share))
        })
    }

    fn input_shape(&self, size: Size) -> Vec<usize> {
        let [w, h] = sides(size);
        vec![1, self.net.manifest().input_channels(), h, w]
    }

    /// What the net says of the photo as it sees it, `[layer, y, x]`; of a mirrored one, mirrored back.
    fn said_of(
        &self,
        photo: &View,
        Look { size, is_mirrored }: Look,
        layers: Range<usize>,
        threads: usize,
        job: &Job,
    ) -> Result<Vec<f32>, SynthError> {
        // As soft as the pictures that the trainer shows its nets: sharper ones cost 0.005 of rank correlation.
        let mut seen = Signed::resized(photo, size, Filter::Linear);
        if is_mirrored {
            seen = mirrored(&seen);
        }
        let input = net_input(&seen, &self.net.manifest().inputs);
        let output = self.net.run(&self.input_shape(size), &input, threads, job.cancel)?;
        let plane = pixels(size);
        let mut maps: Vec<f32> = output.iter().skip(layers.start * plane).take(layers.len() * plane).copied().collect();
        if is_mirrored {
            maps.chunks_exact_mut(sides(size)[0]).for_each(<[f32]>::reverse);
        }
        Ok(maps)
    }
}

/// The size at which a net sees a photo.
fn working_size(photo: Size, long_side: u32, multiple_of: u32) -> Size {
    size_in_steps(photo, long_side, multiple_of * STEP_PX.div_ceil(multiple_of))
}

/// The sizes at which a net sees a photo, coarse first.
fn pass_sizes(photo: Size, long_sides: &[u32], multiple_of: u32) -> Vec<Size> {
    let mut sizes: Vec<Size> = long_sides.iter().map(|side| working_size(photo, *side, multiple_of)).collect();
    sizes.dedup_by(|finer, coarse| long_side(*finer) < LARGER * long_side(*coarse));
    sizes
}

fn sees_all(photo: Size, passes: &[Size]) -> bool {
    passes.first().is_some_and(|first| long_side(photo) < ALL * long_side(*first))
}

fn long_side(size: Size) -> f32 {
    size[0].max(size[1]) as f32
}

/// What turns the net's disparities into pixels of its picture's width: they are pixels of the picture without
/// stretch, whose long side it keeps.
fn width_unit(photo: Size, size: Size) -> f32 {
    disparity_scale(photo, size) * (long_side(photo) / long_side(size))
}

/// The channels that a net asks for, `[c, y, x]`.
fn net_input(photo: &Signed, channels: &[Channels]) -> Vec<f32> {
    let [w, h] = photo.sides();
    let unit = |i: usize, n: usize| if n > 1 { 2.0 * i as f32 / (n - 1) as f32 - 1.0 } else { 0.0 };
    let mut input = Vec::new();
    for group in channels {
        match group {
            Channels::Rgb => (0..3).for_each(|c| input.extend(photo.pixels().iter().map(|pixel| pixel[c]))),
            Channels::Yx => {
                input.extend((0..w * h).map(|i| unit(i / w, h)));
                input.extend((0..w * h).map(|i| unit(i % w, w)));
            }
        }
    }
    input
}

fn mirrored(photo: &Signed) -> Signed {
    let [w, _] = photo.sides();
    Signed::from_fn(photo.size(), |x, y| photo.at(w - 1 - x, y))
}

/// The detail of `own` maps, and so much of the layout of others, which is what both say of cells of some pixels.
fn with_layout_of(own: Pass, layout: &Pass, share: f32) -> Pass {
    let ratio = disparity_scale(layout.size, own.size);
    let cells = layout.size.map(|side| side.div_ceil(CELL_PX));
    let planes = own.maps.chunks_exact(pixels(own.size)).zip(layout.maps.chunks_exact(pixels(layout.size)));
    let merged = planes.flat_map(|(own_map, layout_map)| {
        let in_own = resample::<1>(own_map, own.size, cells, Filter::Linear);
        let in_layout = resample::<1>(layout_map, layout.size, cells, Filter::Linear);
        let change: Vec<f32> = in_layout.iter().zip(&in_own).map(|(l, o)| share * (l * ratio - o)).collect();
        let change = resample::<1>(&change, cells, own.size, Filter::Linear);
        own_map.iter().zip(change).map(|(o, c)| o + c).collect::<Vec<f32>>()
    });
    Pass { maps: merged.collect(), size: own.size }
}

#[cfg(test)]
mod tests {
    use glam::Vec4;

    use super::*;
    use crate::job::Cancel;
    use crate::synth::library::sha256;
    use crate::synth::tract::graph_tests::{DataType, Graph};
    use crate::synth::{LongSides, Manifest, ModelBytes};

    /// A net that answers how far to the right a pixel lies, −1 … 1.
    fn columns(mirrored_long_side: Option<u32>) -> DepthNet {
        let graph = Graph::new(13)
            .input("x", DataType::Float, &[Some(1), Some(2), None, None])
            .weights("w", &[1, 2, 1, 1], &[0.0, 1.0])
            .node("Conv", &["x", "w"], &["y"], vec![])
            .output("y");
        let bytes: &[u8] = graph.bytes().leak();
        let manifest = Manifest {
            sha256: sha256(bytes),
            views: [1, 1],
            inputs: vec![Channels::Yx],
            working_long_side: LongSides::One(64),
            mirrored_long_side,
            ..Manifest::default()
        };
        let onnx = ModelBytes::Embedded(bytes);
        DepthNet::load(ModelFile { manifest, onnx, bytes: 0, folder: None, place: String::new() }).unwrap()
    }

    #[test]
    fn what_is_said_of_the_mirrored_photo_is_mirrored_back() {
        let (photo, cancel) = (View::new([64, 48], vec![90; 64 * 48 * 4]).unwrap(), Cancel::default());
        let row = |net: DepthNet| {
            let map = net.reference(&photo, 1, &Job { cancel: &cancel, sink: &() }).unwrap();
            map.disparity_px()[..64].to_vec()
        };
        let (once, twice) = (row(columns(None)), row(columns(Some(48))));
        assert!(once[4] < -0.8 && once[59] > 0.8, "{once:?}");
        // At the row's ends cells say less than pixels do.
        assert!(twice[4..60].iter().all(|d| d.abs() < 0.02), "the mean of opposites is nothing: {twice:?}");
    }

    #[test]
    fn coordinates_run_from_minus_one_to_one_over_the_picture() {
        let photo = Signed::from_fn([3, 2], |x, y| Vec4::splat((y * 3 + x) as f32));
        let input = net_input(&photo, &[Channels::Yx, Channels::Rgb]);
        assert_eq!(input[..6], [-1.0, -1.0, -1.0, 1.0, 1.0, 1.0]);
        assert_eq!(input[6..12], [-1.0, 0.0, 1.0, -1.0, 0.0, 1.0]);
        assert_eq!(input[12..18], [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
    }

    #[test]
    fn photos_of_odd_shapes_share_few_sizes() {
        let sizes: std::collections::BTreeSet<_> = (180..=202).map(|h| working_size([270, h], 270, 1)).collect();
        assert_eq!(sizes, [[272, 176], [272, 192], [272, 208]].into());
        assert_eq!(working_size([4000, 3000], 128, 16), [128, 96]);
        assert_eq!(working_size([3000, 2000], 112, 16), [112, 80]);
        assert_eq!(working_size([100, 25], 128, 12), [96, 24]);
        assert_eq!(working_size([5000, 3], 128, 16), [128, 16]);
    }

    #[test]
    fn a_photo_is_not_seen_again_where_it_is_hardly_larger() {
        let seen = |photo: Size| pass_sizes(photo, &[192, 540], 16);
        assert_eq!(seen([4000, 3000]), [[192, 144], [544, 400]]);
        assert_eq!(seen([270, 180]), [[192, 128]]);
        assert_eq!(seen([3, 5000]), [[16, 192], [16, 544]], "the long side counts");
        assert_eq!(seen([100, 75]).len(), 1);
        let all = [[176, 132], [270, 180], [540, 405]].map(|photo| sees_all(photo, &seen(photo)));
        assert_eq!(all, [true, false, false], "the first pass knows where edges are");
    }

    #[test]
    fn a_mirrored_picture_starts_with_the_other_end_of_each_row() {
        let photo = mirrored(&Signed::from_fn([3, 2], |x, y| Vec4::splat((y * 3 + x) as f32)));
        assert_eq!(photo.pixels().iter().map(|pixel| pixel.x).collect::<Vec<_>>(), [2.0, 1.0, 0.0, 5.0, 4.0, 3.0]);
    }

    #[test]
    fn half_of_a_layout_is_the_mean_of_both() {
        let flat = |size: Size, d: f32| Pass { size, maps: vec![d; pixels(size)] };
        let merged = with_layout_of(flat([64, 32], 1.0), &flat([32, 16], 0.1), HALF);
        // As wide again, 0.1 px are 0.2.
        assert!(merged.maps.iter().all(|d| (d - 0.6).abs() < 1e-6), "{:?}", merged.maps[0]);
    }

    #[test]
    fn disparities_are_those_of_the_picture_without_stretch() {
        // Landscape: the width is the long side. Portrait: the net saw a width of 80 where 85⅓ had been right.
        assert!((width_unit([3000, 2000], [112, 80]) - 1.0).abs() < 1e-6);
        assert!((width_unit([2000, 3000], [80, 128]) - 80.0 / (2.0 / 3.0 * 128.0)).abs() < 1e-6);
    }

    #[test]
    fn merging_takes_layout_from_the_coarse_map_and_thin_things_from_the_fine_one() {
        // A post two pixels wide, which the coarse pass does not see, and a slope, which the fine one does not.
        let post = |x: u32| if x == 32 || x == 33 { 0.5 } else { 0.0 };
        let fine = Pass { size: [64, 32], maps: (0..64 * 32).map(|i| post(i % 64)).collect() };
        let coarse = Pass { size: [32, 16], maps: (0..32 * 16).map(|i| (i % 32) as f32 * 0.01).collect() };
        let merged = with_layout_of(fine, &coarse, ALL_OF_IT);
        let at = |x: usize| merged.maps[16 * 64 + x];
        assert!(
            (at(32) - at(28) - 0.5).abs() < 0.06 && (at(33) - at(37) - 0.5).abs() < 0.06,
            "{} and {}: the post stands out",
            at(32) - at(28),
            at(33) - at(37)
        );
        assert!((at(52) - at(12) - 2.0 * 0.2).abs() < 0.06, "{} and {}", at(52), at(12));
    }
}
