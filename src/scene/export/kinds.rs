//! Everything that can be written: the one list that the dialog, the command line and its completions show.

use serde::{Deserialize, Serialize};

use crate::scene::{Need, OutputSize, Scene};

/// What is written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[allow(missing_docs, reason = "each one's label and hint stand in `KINDS`")]
pub enum Kind {
    #[default]
    Picture,
    FocalStack,
    Animation,
    Video,
    Frames,
    Living,
    SideBySide,
    Mpo,
    Spatial,
    Anaglyph,
    Views,
    Eslf,
    Hci,
    Stanford,
    Quilt,
    DepthPng,
    DepthPfm,
    Gdepth,
    Ply,
    Gaussians,
}

/// Where a kind stands in the dialog.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Group {
    /// Pictures for people.
    Pictures,
    /// All views.
    LightField,
    /// Disparities.
    Depth,
}

impl Group {
    /// All of them, in order, with their headings.
    pub const ALL: [(Self, &'static str); 3] =
        [(Self::Pictures, "Pictures"), (Self::LightField, "Light field"), (Self::Depth, "Depth")];
}

/// What there is to know of a kind.
#[derive(Clone, Copy, Debug)]
pub struct Spec {
    /// The kind.
    pub kind: Kind,
    /// How the command line calls it (`--as`).
    pub id: &'static str,
    /// Its name.
    pub label: &'static str,
    /// What it is good for.
    pub hint: &'static str,
    /// Where it stands in the dialog.
    pub group: Group,
    /// What a file of a photo's name is called: `{name}` is the photo's; none where settings say the rest.
    pub file: &'static str,
    /// Whether it is made of all views, and not of one map.
    pub is_of_views: bool,
}

/// All kinds, in the order of the dialog.
pub const KINDS: [Spec; 20] = [
    made_of_map(
        Kind::Picture,
        "picture",
        "Picture",
        "The refocused picture at the photo's own size",
        Group::Pictures,
        "",
    ),
    made_of_map(
        Kind::FocalStack,
        "focal-stack",
        "Focal stack",
        "A folder of pictures focused from far to near, one all sharp, and which is sharp where",
        Group::Pictures,
        "{name}-stack",
    ),
    made_of_map(
        Kind::Animation,
        "animation",
        "Animation",
        "A focus pull, an opening lens, or a turn of the viewpoint",
        Group::Pictures,
        "",
    ),
    made_of_map(
        Kind::Video,
        "video",
        "Video",
        "A film in AV1, MP4 or WebM: a focus pull, or what the timeline says",
        Group::Pictures,
        "",
    ),
    made_of_map(
        Kind::Frames,
        "frames",
        "PNG sequence",
        "A folder with each frame of that film as PNG, for programs that cut",
        Group::Pictures,
        "{name}-frames",
    ),
    made_of_map(
        Kind::Living,
        "html",
        "Living picture",
        "One HTML file to focus and to look round in, in any browser, without a connection",
        Group::Pictures,
        "{name}.html",
    ),
    made_of_map(
        Kind::SideBySide,
        "side-by-side",
        "Side by side",
        "Both eyes beside each other, for 3-D screens and glasses",
        Group::Pictures,
        "{name}_3D_SBS.png",
    ),
    made_of_map(
        Kind::Mpo,
        "mpo",
        "Stereo pair, MPO",
        "Both eyes as two JPEGs in one file, for 3-D screens and cameras",
        Group::Pictures,
        "{name}.mpo",
    ),
    made_of_map(
        Kind::Spatial,
        "spatial",
        "Spatial photo",
        "Both eyes as a spatial photo, one HEIC, for headsets and phones",
        Group::Pictures,
        "{name}-spatial.heic",
    ),
    made_of_map(
        Kind::Anaglyph,
        "anaglyph",
        "Anaglyph",
        "Both eyes in one picture, for red-cyan glasses",
        Group::Pictures,
        "{name}-anaglyph.png",
    ),
    made_of_views(
        Kind::Views,
        "views",
        "Views and ray depths",
        "A folder with each view as PNG and its ray depths as PFM; opens again as it is",
        Group::LightField,
        "{name}-views",
    ),
    made_of_views(
        Kind::Eslf,
        "eslf",
        "ESLF",
        "One lenslet picture, 14 × 14 pixels a lens, as the Light Field Toolbox reads it",
        Group::LightField,
        "{name}_eslf.png",
    ),
    made_of_views(
        Kind::Hci,
        "hci",
        "HCI folder",
        "As the 4-D light field benchmark's own scenes, with ray depths",
        Group::LightField,
        "{name}-hci",
    ),
    made_of_views(
        Kind::Stanford,
        "stanford",
        "Stanford folder",
        "Numbered views named as in the Stanford archive",
        Group::LightField,
        "{name}-stanford",
    ),
    made_of_views(
        Kind::Quilt,
        "quilt",
        "Looking Glass quilt",
        "Many viewpoints in one picture, for a holographic display",
        Group::LightField,
        "",
    ),
    made_of_map(
        Kind::DepthPng,
        "depth-png",
        "Depth map, PNG",
        "16-bit grey, white is near",
        Group::Depth,
        "{name}-depth.png",
    ),
    made_of_map(
        Kind::DepthPfm,
        "depth-pfm",
        "Depth map, PFM",
        "Disparity in pixels per view, every bit kept",
        Group::Depth,
        "{name}-depth.pfm",
    ),
    made_of_map(
        Kind::Gdepth,
        "gdepth",
        "Photo with depth",
        "A JPEG with the depth inside (GDepth), as phones write it",
        Group::Depth,
        "{name}-depth.jpg",
    ),
    made_of_views(
        Kind::Ply,
        "ply",
        "Point cloud",
        "PLY: each pixel as a coloured point in space",
        Group::Depth,
        "{name}.ply",
    ),
    made_of_views(
        Kind::Gaussians,
        "gaussians",
        "Gaussian splats",
        "PLY: a scene that splat viewers open, one Gaussian for each point that is seen; opens again",
        Group::LightField,
        "{name}-splats.ply",
    ),
];

const fn made_of_map(
    kind: Kind,
    id: &'static str,
    label: &'static str,
    hint: &'static str,
    group: Group,
    file: &'static str,
) -> Spec {
    Spec { kind, id, label, hint, group, file, is_of_views: false }
}

const fn made_of_views(
    kind: Kind,
    id: &'static str,
    label: &'static str,
    hint: &'static str,
    group: Group,
    file: &'static str,
) -> Spec {
    Spec { is_of_views: true, ..made_of_map(kind, id, label, hint, group, file) }
}

impl Kind {
    /// What there is to know of it.
    pub fn spec(self) -> &'static Spec {
        KINDS.iter().find(|spec| spec.kind == self).unwrap_or(&KINDS[0])
    }

    /// The kind that the command line calls so.
    pub fn named(id: &str) -> Option<Self> {
        KINDS.iter().find(|spec| spec.id == id).map(|spec| spec.kind)
    }

    /// Whether it is a folder of files.
    pub fn is_folder(self) -> bool {
        !self.spec().file.is_empty() && !self.spec().file.contains('.')
    }

    /// Whether it is what both eyes see.
    pub fn is_of_eyes(self) -> bool {
        matches!(self, Self::SideBySide | Self::Mpo | Self::Spatial | Self::Anaglyph)
    }

    /// What must be made of a subject for it.
    pub fn need(self, size: OutputSize) -> Need {
        match self {
            kind if kind == Self::Picture || kind.is_of_eyes() => Scene::need(size),
            kind if kind.spec().is_of_views => Need::Views,
            _ => Need::Map,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_has_one_line_and_one_name() {
        let mut ids: Vec<_> = KINDS.iter().map(|spec| spec.id).collect();
        assert!(KINDS.iter().all(|spec| Kind::named(spec.id) == Some(spec.kind) && spec.kind.spec().id == spec.id));
        let folders = [Kind::FocalStack, Kind::Frames, Kind::Views, Kind::Hci, Kind::Stanford];
        assert!(KINDS.iter().all(|spec| spec.kind.is_folder() == folders.contains(&spec.kind)));
        ids.sort_unstable();
        ids.dedup();
        assert_eq!(ids.len(), KINDS.len());
    }

    #[test]
    fn the_readme_has_the_same_lines() {
        let readme = include_str!("../../../README.md");
        for Spec { id, hint, .. } in KINDS {
            assert!(readme.contains(&format!("| `{id}` | {hint} |")), "README has no line of {id}");
        }
    }
}
