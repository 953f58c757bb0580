//! What is known of public depth nets: the authors' own preprocessing, what the numbers mean, and whose the weights are.

use crate::synth::RelativeOutput;
use crate::synth::tract::{Scale, Signs};

/// Mean and deviation of colours, white being `scale`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Colours {
    pub mean: [f32; 3],
    pub std: [f32; 3],
    pub white: f32,
}

impl Colours {
    /// Colours of 0 to 1 as they are.
    pub const UNIT: Self = Self { mean: [0.0; 3], std: [1.0; 3], white: 1.0 };
    /// Colours of 0 to 255.
    pub const BYTES: Self = Self { white: 255.0, ..Self::UNIT };
    /// Mean and deviation of the ImageNet photos.
    pub const IMAGENET: Self = Self { mean: [0.485, 0.456, 0.406], std: [0.229, 0.224, 0.225], white: 1.0 };
    /// −1 to 1.
    pub const HALF: Self = Self { mean: [0.5; 3], std: [0.5; 3], white: 1.0 };
}

/// How large the picture is, where the file takes any size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    Long(u32),
    Short(u32),
    Exactly(u32, u32),
}

/// A family of nets.
pub(super) struct Family {
    pub name: &'static str,
    pub licence: &'static str,
    /// What a person must know before the pictures are sold.
    pub warning: Option<&'static str>,
    pub colours: Colours,
    pub side: Side,
    pub multiple: u32,
    pub output: RelativeOutput,
    pub is: fn(&Signs) -> bool,
}

const NOT_FOR_SALE: Option<&str> = Some("its weights are for non-commercial use alone");
const BY_VERSION: Option<&str> =
    Some("version 2 of these weights is for non-commercial use alone; version 1 is Apache-2.0");

/// A vision transformer of the DINOv2 kind, which patches of 14 pixels tell.
const DINO: Family = Family {
    name: "Depth Anything, Small",
    licence: "Apache-2.0",
    warning: None,
    colours: Colours::IMAGENET,
    side: Side::Short(518),
    multiple: 14,
    output: RelativeOutput::Nearness,
    is: |signs| is_dino(signs, 384),
};

/// The families, those with a plainer sign first.
pub(super) static FAMILIES: &[Family] = &[
    Family {
        name: "Depth Anything 3",
        licence: "Apache-2.0 (Mono, Metric, Small, Base)",
        warning: Some("the weights of Large, Giant and Nested are for non-commercial use alone"),
        side: Side::Long(504),
        output: RelativeOutput::Distance,
        is: |signs| has_patch(signs, 14) && (signs.answers("sky") || signs.answers("extrinsics")),
        ..DINO
    },
    Family {
        name: "MoGe",
        licence: "MIT",
        colours: Colours::UNIT,
        output: RelativeOutput::Points,
        is: |signs| signs.answers("points") && signs.inputs.iter().any(|port| port.name == "num_tokens"),
        ..DINO
    },
    Family {
        name: "Metric3D",
        licence: "not said (code: BSD-2-Clause)",
        warning: Some("nobody says whose its weights are"),
        colours: Colours::BYTES,
        side: Side::Exactly(1064, 616),
        output: RelativeOutput::Distance,
        is: |signs| signs.answers("normal_confidence") || signs.answers("predicted_normal"),
        ..DINO
    },
    Family {
        name: "Depth Pro",
        licence: "Apple AMLR (research)",
        warning: NOT_FOR_SALE,
        colours: Colours::HALF,
        side: Side::Exactly(1536, 1536),
        multiple: 1,
        output: RelativeOutput::Metres,
        is: |signs| {
            signs.pictures().any(|port| port.dims.ends_with(&[Some(1536), Some(1536)])) && signs.outputs.len() == 2
        },
    },
    Family {
        name: "Depth Anything V2 Metric",
        licence: "Apache-2.0 (Small), CC-BY-NC-4.0 (Base, Large)",
        warning: Some("the weights of Base and Large are for non-commercial use alone"),
        output: RelativeOutput::Metres,
        is: |signs| has_patch(signs, 14) && is_metric(signs),
        ..DINO
    },
    DINO,
    Family {
        name: "Depth Anything, Base",
        licence: "CC-BY-NC-4.0 (V2), Apache-2.0 (V1)",
        warning: BY_VERSION,
        is: |signs| is_dino(signs, 768),
        ..DINO
    },
    Family {
        name: "Depth Anything, Large",
        licence: "CC-BY-NC-4.0 (V2), Apache-2.0 (V1)",
        warning: BY_VERSION,
        is: |signs| is_dino(signs, 1024),
        ..DINO
    },
    Family {
        name: "Tiefenrausch (One Shot 3D Photography)",
        licence: "MIT",
        warning: None,
        colours: Colours::UNIT,
        side: Side::Long(384),
        multiple: 32,
        output: RelativeOutput::LogNearness,
        is: |signs| signs.answers("log_disparity"),
    },
    Family {
        name: "GLPN",
        licence: "Apache-2.0",
        warning: None,
        colours: Colours::UNIT,
        side: Side::Long(640),
        multiple: 32,
        output: RelativeOutput::Metres,
        is: |signs| signs.patch.is_none() && is_metric(signs),
    },
    Family {
        name: "DPT-Large (MiDaS 3)",
        licence: "MIT",
        warning: None,
        colours: Colours::HALF,
        side: Side::Exactly(384, 384),
        multiple: 32,
        output: RelativeOutput::Nearness,
        is: |signs| signs.patch == Some([16, 1024]) && ends_in(signs, "Relu"),
    },
    Family {
        name: "MiDaS 2.1",
        licence: "MIT",
        warning: None,
        colours: Colours::UNIT,
        side: Side::Exactly(384, 384),
        multiple: 32,
        output: RelativeOutput::Nearness,
        is: |signs| signs.normalises == Some(Scale::Unit) && signs.patch.is_none() && ends_in(signs, "Relu"),
    },
];

/// The family that a file's signs tell, if they do.
pub(super) fn of(signs: &Signs) -> Option<&'static Family> {
    FAMILIES.iter().find(|family| (family.is)(signs))
}

fn has_patch(signs: &Signs, side: usize) -> bool {
    signs.patch.is_some_and(|[patch, _]| patch == side)
}

fn is_dino(signs: &Signs, width: usize) -> bool {
    signs.patch == Some([14, width]) && signs.outputs.len() == 1 && !is_metric(signs)
}

/// Whether the last operations make metres: a share of a greatest distance.
fn is_metric(signs: &Signs) -> bool {
    let at = |name: &str| signs.end.iter().position(|(operator, _)| operator == name);
    let greatest = signs.end.iter().any(|(operator, by)| operator == "Mul" && by.is_some_and(|by| by >= 5.0));
    greatest && at("Sigmoid").is_some_and(|sigmoid| sigmoid < 6)
}

/// Whether an operation stands at the end, behind what only turns axes.
fn ends_in(signs: &Signs, name: &str) -> bool {
    let plain = ["Squeeze", "Unsqueeze", "Identity", "Reshape", "Cast", "Resize"];
    let last = signs.end.iter().find(|(operator, _)| !plain.contains(&operator.as_str()));
    last.is_some_and(|(operator, _)| operator == name)
}
