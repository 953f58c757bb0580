//! Saving what is seen, and all else that a light field can become: what the dialog says, and where it goes.

pub mod dialog;
mod series;
pub mod work;

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::document::Document;
use super::state::Edit;
use crate::field::fit_long_side;
use crate::io::formats::quilt;
use crate::io::save::Keep;
use crate::recipe::{self, Recipe};

/// What is written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[allow(missing_docs, reason = "each one's label and hint stand in `What::spec`")]
pub enum What {
    #[default]
    Picture,
    FocalStack,
    Animation,
    SideBySide,
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
}

impl What {
    /// All of them, in the order of the dialog: heading, and what stands under it.
    pub const GROUPS: [(&'static str, &'static [Self]); 3] = [
        ("Pictures", &[Self::Picture, Self::FocalStack, Self::Animation, Self::SideBySide, Self::Anaglyph]),
        ("Light field", &[Self::Views, Self::Eslf, Self::Hci, Self::Stanford, Self::Quilt]),
        ("Depth", &[Self::DepthPng, Self::DepthPfm, Self::Gdepth, Self::Ply]),
    ];

    /// Its name, and what it is good for.
    pub fn spec(self) -> (&'static str, &'static str) {
        match self {
            Self::Picture => ("Picture", "The refocused picture at the photo's own size"),
            Self::FocalStack => (
                "Focal stack",
                "A folder of pictures focused from far to near, one all sharp, and which is sharp where",
            ),
            Self::Animation => ("Animation", "A focus pull, an opening lens, or a turn of the viewpoint"),
            Self::SideBySide => ("Side by side", "Both eyes beside each other, for 3-D screens and glasses"),
            Self::Anaglyph => ("Anaglyph", "Both eyes in one picture, for red-cyan glasses"),
            Self::Views => (
                "Views and ray depths",
                "A folder with each view as PNG and its ray depths as PFM; opens again as it is",
            ),
            Self::Eslf => ("ESLF", "One lenslet picture, 14 × 14 pixels a lens, as the Light Field Toolbox reads it"),
            Self::Hci => ("HCI folder", "As the 4-D light field benchmark's own scenes, with ray depths"),
            Self::Stanford => ("Stanford folder", "Numbered views named as in the Stanford archive"),
            Self::Quilt => ("Looking Glass quilt", "Many viewpoints in one picture, for a holographic display"),
            Self::DepthPng => ("Depth map, PNG", "16-bit grey, white is near"),
            Self::DepthPfm => ("Depth map, PFM", "Disparity in pixels per view, every bit kept"),
            Self::Gdepth => ("Photo with depth", "A JPEG with the depth inside (GDepth), as phones write it"),
            Self::Ply => ("Point cloud", "PLY: each pixel as a coloured point in space"),
        }
    }
}

/// What moves in an animation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Moving {
    /// The focus, from far to near.
    #[default]
    Focus,
    /// The aperture, from f/28 to what is set.
    Aperture,
    /// The viewpoint, in a circle.
    Viewpoint,
}

/// What happens when a file of that name exists.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Existing {
    /// The new file gets a number.
    #[default]
    Number,
    /// The old file goes.
    Replace,
    /// The old file stays, and nothing is written.
    Leave,
}

/// What the dialog said last.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ExportSettings {
    /// What is written.
    pub what: What,
    /// How pictures are kept; goes into recipes.
    pub picture: recipe::ExportSettings,
    /// Where to; none is beside the photo.
    pub folder: Option<PathBuf>,
    /// When the file exists.
    pub existing: Existing,
    /// Frames of a stack or an animation.
    pub frames: u16,
    /// Frames a second of an animation.
    pub frames_per_second: u16,
    /// What moves in it.
    pub moving: Moving,
    /// Suffix of an animation.
    pub animation: String,
    /// Long side of an animation, in pixels.
    pub animation_px: u32,
    /// Distance between both eyes, in view steps.
    pub eyes_apart: f32,
    /// Which display a quilt is for, an index of [`quilt::DEVICES`].
    pub device: usize,
}

impl Default for ExportSettings {
    fn default() -> Self {
        Self {
            what: What::Picture,
            picture: recipe::ExportSettings { keep: Keep::WithoutPosition, ..recipe::ExportSettings::default() },
            folder: None,
            existing: Existing::Number,
            frames: 24,
            frames_per_second: 12,
            moving: Moving::Focus,
            animation: "gif".to_owned(),
            animation_px: 800,
            eyes_apart: 2.0,
            device: 0,
        }
    }
}

impl ExportSettings {
    /// Where the export of a document goes.
    pub fn target(&self, document: &Document, edit: &Edit) -> PathBuf {
        self.target_of(document.path.as_deref(), &document.name, edit)
    }

    /// Where the export of a file goes, or of a picture without one that has a name.
    pub fn target_of(&self, path: Option<&Path>, name: &str, edit: &Edit) -> PathBuf {
        let beside = path.and_then(Path::parent).map(Path::to_owned);
        let home = || directories::UserDirs::new().map(|dirs| dirs.picture_dir().unwrap_or(dirs.home_dir()).to_owned());
        let folder = self.folder.clone().or(beside).or_else(home).unwrap_or_default();
        let mut recipe = Recipe::default();
        recipe.export = self.picture.clone();
        edit.put_into(&mut recipe);
        let stem = recipe.stem(Path::new(name));
        let plain = Path::new(name).file_stem().unwrap_or_default().to_string_lossy().into_owned();
        folder.join(match self.what {
            What::Picture => format!("{stem}.{}", self.picture.format.extension()),
            What::FocalStack => format!("{plain}-stack"),
            What::Animation => format!("{plain}-{}.{}", self.moving_word(), self.animation),
            What::SideBySide => format!("{plain}_3D_SBS.png"),
            What::Anaglyph => format!("{plain}-anaglyph.png"),
            What::Views => format!("{plain}-views"),
            What::Eslf => format!("{plain}_eslf.png"),
            What::Hci => format!("{plain}-hci"),
            What::Stanford => format!("{plain}-stanford"),
            What::Quilt => self.device().file_name(&plain),
            What::DepthPng => format!("{plain}-depth.png"),
            What::DepthPfm => format!("{plain}-depth.pfm"),
            What::Gdepth => format!("{plain}-depth.jpg"),
            What::Ply => format!("{plain}.ply"),
        })
    }

    fn moving_word(&self) -> &'static str {
        match self.moving {
            Moving::Focus => "focus",
            Moving::Aperture => "aperture",
            Moving::Viewpoint => "circle",
        }
    }

    /// The display that a quilt is for.
    pub fn device(&self) -> &'static quilt::Device {
        quilt::DEVICES.get(self.device).unwrap_or(&quilt::DEVICES[0])
    }

    /// Width and height of an animation of a picture.
    fn animation_size(&self, photo: [u32; 2]) -> [u32; 2] {
        fit_long_side(photo, self.animation_px.max(16))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::FNumber;

    #[test]
    fn every_kind_has_a_place_of_its_own_beside_the_photo() {
        let document = Document { name: "rose.heic".into(), path: Some("/a/rose.heic".into()), ..Document::default() };
        let mut edit = Edit::default();
        edit.lens.f_number = FNumber(2.0);
        let mut settings = ExportSettings::default();
        let mut targets = Vec::new();
        for what in What::GROUPS.iter().flat_map(|(_, all)| all.iter()) {
            settings.what = *what;
            let target = settings.target(&document, &edit);
            assert_eq!(target.parent(), Some(Path::new("/a")), "{what:?}");
            targets.push(target);
        }
        assert_eq!(targets[0], Path::new("/a/rose-f2.jpg"));
        let count = targets.len();
        targets.sort();
        targets.dedup();
        assert_eq!(targets.len(), count, "no two kinds write the same file");
    }
}
