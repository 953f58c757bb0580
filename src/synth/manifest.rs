//! What a model says about itself: `models/<id>/manifest.toml`.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::tract::Wiring;
use super::{ModelError, ModelTag};
use crate::field::ViewGrid;
use crate::within::is_plain_name;

/// What a model is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Task {
    /// Photo → one ray-depth map a view: `[1, C, H, W] → [1, V·U, H, W]`, pixels per view step at its own long side.
    RayDepth,
    /// Lambertian views and ray depths → residual: `[1, 4, V·U, H, W] → [1, 3, V·U, H, W]`.
    Occlusion,
    /// What four corners say of a view → its ray depth, and beside it the net that corrects the blend's colours
    /// ([`CornerNets`](super::corners::CornerNets)).
    Corners,
    /// Photo → one map of relative (affine-unknown) depth, from anybody.
    RelativeDepth,
}

/// What a depth net is fed, channel by channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Channels {
    /// Red, green, blue, sRGB-encoded, −1 … 1.
    Rgb,
    /// y and x of the pixel: −1 on the first row (column), 1 on the last.
    Yx,
}

impl Channels {
    /// How many channels that is.
    pub fn count(self) -> usize {
        match self {
            Self::Rgb => 3,
            Self::Yx => 2,
        }
    }
}

/// Where the maps of the 63 other views come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum RayDepthsFrom {
    /// The refined map of the reference view, carried along its rays (`synth::lift`).
    #[default]
    Lift,
    /// The net's own maps.
    Net,
}

/// Long sides at which the depth net runs: one, or coarse and fine.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(untagged)]
pub enum LongSides {
    /// One pass.
    One(u32),
    /// Several passes, coarse first; each adds its detail. Of all, ray depths are as deep as if the picture had the first size.
    Several(Vec<u32>),
}

impl LongSides {
    /// All of them, coarse first.
    pub fn as_slice(&self) -> &[u32] {
        match self {
            Self::One(side) => std::slice::from_ref(side),
            Self::Several(sides) => sides,
        }
    }
}

/// How a `relative-depth` model wants its picture and what its numbers mean.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct RelativeRules {
    /// Width and height of the input; 0, 0 = any size, the longer side is `working_long_side`.
    pub input_size: [u32; 2],
    /// Subtracted from values in 0 … 1, in the order of `order`.
    pub mean: [f32; 3],
    /// Divided by afterwards.
    pub std: [f32; 3],
    /// Order of the colours: `rgb` or `bgr`.
    pub order: ColourOrder,
    /// `nchw`, `nhwc` or `nvchw`.
    pub layout: Layout,
    /// White as the net wants it, before mean and deviation: 1, or 255.
    pub value_scale: f32,
    /// Its shorter side, in pixels, where that and not `working_long_side` says how large the picture is; 0 = it does not.
    pub short_side: u32,
    /// What its numbers are.
    pub output: RelativeOutput,
    /// Name of the output with the map; empty for the first.
    pub output_name: String,
    /// Name of the output that is large where the picture shows sky; empty where there is none.
    pub sky_output: String,
    /// Name of the output with the focal length in pixels of its input; empty where there is none.
    pub focal_output: String,
    /// Inputs other than the picture, each with the number that it is given.
    pub extra_inputs: BTreeMap<String, f64>,
}

impl RelativeRules {
    /// Outputs in the order map, sky, focal length, as far as there are such, and the other inputs.
    pub fn wiring(&self) -> Wiring {
        let names = [&self.output_name, &self.sky_output, &self.focal_output];
        let outputs = names.into_iter().filter(|name| !name.is_empty()).cloned().collect();
        Wiring { outputs, numbers: self.extra_inputs.clone() }
    }
}

impl Default for RelativeRules {
    fn default() -> Self {
        Self {
            input_size: [0, 0],
            mean: [0.0; 3],
            std: [1.0; 3],
            order: ColourOrder::Rgb,
            layout: Layout::Nchw,
            value_scale: 1.0,
            short_side: 0,
            output: RelativeOutput::Nearness,
            output_name: String::new(),
            sky_output: String::new(),
            focal_output: String::new(),
            extra_inputs: BTreeMap::new(),
        }
    }
}

/// Order of the colour channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ColourOrder {
    /// Red first.
    Rgb,
    /// Blue first.
    Bgr,
}

/// Order of the input's axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Layout {
    /// `[1, 3, H, W]`.
    Nchw,
    /// `[1, H, W, 3]`.
    Nhwc,
    /// `[1, 1, 3, H, W]`: one of several views.
    Nvchw,
}

/// What a relative-depth net's numbers are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum RelativeOutput {
    /// Inverse depth up to scale and shift: larger is nearer.
    Nearness,
    /// Depth up to scale (metres, for example), 0 at the camera.
    Distance,
    /// Depth up to scale and shift: larger is farther.
    Farness,
    /// Logarithm of inverse depth: larger is nearer.
    LogNearness,
    /// Distance in metres, 0 at the camera.
    Metres,
    /// Points in space, `[H, W, 3]`: the third coordinate is the distance, up to scale.
    Points,
}

impl RelativeOutput {
    /// Whether its numbers are larger where the picture is nearer.
    pub(super) fn grows_nearer(self) -> bool {
        matches!(self, Self::Nearness | Self::LogNearness)
    }

    /// All numbers of a map as inverse depth, up to scale and shift.
    pub(super) fn nearness_of(self, values: &[f32]) -> Vec<f32> {
        let greatest = values.iter().copied().fold(0.0, f32::max);
        values.iter().map(|value| self.nearness(*value, greatest)).collect()
    }

    /// A number of the net as inverse depth, up to scale and shift; `greatest` is the largest number of its map.
    pub(super) fn nearness(self, value: f32, greatest: f32) -> f32 {
        match self {
            Self::Nearness => value,
            // What a net answers is finite, and its exponential has to be too.
            Self::LogNearness => value.clamp(-40.0, 40.0).exp(),
            // Nothing is nearer than a thousandth of the farthest: the numbers of a net reach 0 by mistake.
            Self::Distance | Self::Metres | Self::Points => 1.0 / value.max(greatest / 1000.0).max(f32::MIN_POSITIVE),
            Self::Farness => -value,
        }
    }
}

/// A model's manifest.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct Manifest {
    /// Name of the model and of its folder.
    pub id: String,
    /// What it is for.
    pub task: Task,
    /// The ONNX file, in the same folder.
    pub file: String,
    /// Checksum of that file, 64 hexadecimal digits.
    pub sha256: String,
    /// Further files with weights, in the same folder, each with its checksum.
    #[serde(default)]
    pub data_files: BTreeMap<String, String>,
    /// Licence of the weights.
    #[serde(default)]
    pub licence: String,
    /// What it was trained on.
    #[serde(default)]
    pub training_data: Vec<String>,
    /// Rows and columns of views.
    #[serde(default = "paper_views")]
    pub views: [usize; 2],
    /// Channels of a depth net's input, in order.
    #[serde(default = "only_rgb")]
    pub inputs: Vec<Channels>,
    /// Long side, in pixels, at which it works: of the depth net always, of the occlusion net at most.
    #[serde(default = "default_long_sides")]
    pub working_long_side: LongSides,
    /// Of a depth net, the long side at which it sees the photo once more, mirrored: what is broad is the mean of its
    /// first pass and this one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mirrored_long_side: Option<u32>,
    /// Its input's sides are multiples of this: the photo is stretched to the nearest.
    #[serde(default = "default_multiple")]
    pub multiple_of: u32,
    /// Least and greatest disparity it can say, pixels per view step at its own width. Of a relative-depth model: what
    /// its far and its near end become, by default [`RelativeDepth::usual_range_px`](crate::field::RelativeDepth::usual_range_px).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub disparity_range_px: Option<[f32; 2]>,
    /// Where the maps of the other views come from.
    #[serde(default)]
    pub ray_depths: RayDepthsFrom,
    /// Rules of a `relative-depth` model.
    #[serde(default)]
    pub relative: RelativeRules,
}

fn paper_views() -> [usize; 2] {
    [8, 8]
}

fn only_rgb() -> Vec<Channels> {
    vec![Channels::Rgb]
}

fn default_long_sides() -> LongSides {
    LongSides::One(540)
}

fn default_multiple() -> u32 {
    1
}

/// Whether a net may see a picture with a side as long.
fn is_side(side: u32) -> bool {
    (16..=8192).contains(&side)
}

impl Default for Manifest {
    fn default() -> Self {
        Self {
            id: String::new(),
            task: Task::RelativeDepth,
            file: String::new(),
            sha256: String::new(),
            data_files: BTreeMap::new(),
            licence: String::new(),
            training_data: Vec::new(),
            views: paper_views(),
            inputs: only_rgb(),
            working_long_side: default_long_sides(),
            mirrored_long_side: None,
            multiple_of: default_multiple(),
            disparity_range_px: None,
            ray_depths: RayDepthsFrom::default(),
            relative: RelativeRules::default(),
        }
    }
}

impl Manifest {
    /// As it stands in its file.
    pub fn to_toml(&self) -> String {
        toml::to_string(self).unwrap_or_default()
    }

    /// Reads and checks a manifest. `place` is named in errors.
    pub fn parse(text: &str, place: &str) -> Result<Self, ModelError> {
        let bad = |why: String| ModelError::Manifest { place: place.to_owned(), why };
        let manifest: Self = toml::from_str(text).map_err(|error| bad(error.message().to_owned()))?;
        manifest.check().map_err(bad)?;
        Ok(manifest)
    }

    /// Name and checksum.
    pub fn tag(&self) -> ModelTag {
        ModelTag { id: self.id.clone(), sha256: self.sha256.to_lowercase() }
    }

    /// Rows and columns of views that it makes.
    pub fn grid(&self) -> Result<ViewGrid, ModelError> {
        let [rows, cols] = self.views;
        ViewGrid::new(rows, cols)
            .map_err(|error| ModelError::Manifest { place: self.id.clone(), why: error.to_string() })
    }

    /// Channels of the depth net's input.
    pub fn input_channels(&self) -> usize {
        self.inputs.iter().map(|channels| channels.count()).sum()
    }

    fn check(&self) -> Result<(), String> {
        let sides = self.working_long_side.as_slice();
        let rules = &self.relative;
        let bad_range = |[lo, hi]: [f32; 2]| !(lo < hi && lo.is_finite() && hi.is_finite());
        ViewGrid::new(self.views[0], self.views[1]).map_err(|error| error.to_string())?;
        let faults = [
            (!is_plain_name(&self.id), "id must be a plain folder name"),
            (!is_plain_name(&self.file), "file must be a plain file name"),
            (!self.data_files.keys().all(|name| is_plain_name(name)), "data_files must be plain file names"),
            (self.sha256.len() != 64, "sha256 must have 64 hexadecimal digits"),
            (self.inputs.is_empty(), "inputs must name at least one of rgb, yx"),
            (sides.is_empty(), "working_long_side must name at least one size"),
            (sides.iter().any(|side| !is_side(*side)), "working_long_side must be 16 to 8192 pixels"),
            (
                self.mirrored_long_side.is_some_and(|side| !is_side(side)),
                "mirrored_long_side must be 16 to 8192 pixels",
            ),
            (
                self.mirrored_long_side.is_some() && self.ray_depths == RayDepthsFrom::Net,
                "mirrored_long_side is for the reference view alone, not for ray_depths = \"net\"",
            ),
            (!(1..=256).contains(&self.multiple_of), "multiple_of must be 1 to 256"),
            (self.disparity_range_px.is_some_and(bad_range), "disparity_range_px must be [least, greatest]"),
            (rules.mean.iter().any(|m| !m.is_finite()), "relative.mean must be three numbers"),
            (rules.std.iter().any(|s| !(*s > 0.0 && s.is_finite())), "relative.std must be positive"),
            (
                rules.input_size != [0, 0] && rules.input_size.iter().any(|side| !is_side(*side)),
                "relative.input_size must be [width, height] of 16 to 8192 pixels, or [0, 0] for any size",
            ),
            (
                rules.short_side != 0 && !is_side(rules.short_side),
                "relative.short_side must be 16 to 8192 pixels, or 0",
            ),
            (
                !(rules.value_scale > 0.0 && rules.value_scale.is_finite()),
                "relative.value_scale must be what white is: 1 or 255",
            ),
            (
                rules.output_name.is_empty() && !(rules.sky_output.is_empty() && rules.focal_output.is_empty()),
                "relative.output_name must name the map beside sky_output and focal_output",
            ),
        ];
        match faults.iter().find(|(wrong, _)| *wrong) {
            Some((_, why)) => Err((*why).to_owned()),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LEAST: &str = "id = \"d\"\ntask = \"ray-depth\"\nfile = \"model.onnx\"\n";

    fn with(more: &str) -> Result<Manifest, ModelError> {
        Manifest::parse(&format!("{LEAST}sha256 = \"{}\"\n{more}", "0".repeat(64)), "d/manifest.toml")
    }

    #[test]
    fn one_or_two_working_scales() {
        assert_eq!(with("working_long_side = 192").unwrap().working_long_side.as_slice(), [192]);
        assert_eq!(with("working_long_side = [128, 270]").unwrap().working_long_side.as_slice(), [128, 270]);
    }

    #[test]
    fn wrong_values_are_named() {
        for (line, word) in [
            ("multiple_of = 0", "multiple_of"),
            ("views = [0, 8]", "1 to 17"),
            ("working_long_side = []", "working_long_side"),
            ("mirrored_long_side = 8", "mirrored_long_side"),
            ("mirrored_long_side = 144\nray_depths = \"net\"", "reference view"),
            ("disparity_range_px = [4, -4]", "disparity_range_px"),
            ("inputs = [\"rgb\", \"lab\"]", "lab"),
            ("[relative]\nstd = [1, 0, 1]", "std"),
            ("[relative]\ninput_size = [0, 384]", "input_size"),
            ("[relative]\norder = \"grb\"", "grb"),
            ("[relative]\nmeen = [0, 0, 0]", "meen"),
            ("[relative]\nshort_side = 3", "short_side"),
            ("[relative]\nvalue_scale = 0", "value_scale"),
            ("[relative]\nsky_output = \"sky\"", "output_name"),
            ("[relative]\noutput = \"depth\"", "depth"),
            ("[data_files]\n\"../x\" = \"0\"", "data_files"),
            ("[data_files]\n\".\" = \"0\"", "data_files"),
        ] {
            let error = with(line).unwrap_err().to_string();
            assert!(error.contains(word), "{error} should name {word}");
        }
    }

    #[test]
    fn the_input_counts_its_channels() {
        assert_eq!(with("inputs = [\"rgb\", \"yx\"]").unwrap().input_channels(), 5);
    }
}
