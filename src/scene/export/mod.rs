//! Saving what is seen, and all else that a light field can become: what is asked for, where it goes, and writing it.

mod kinds;
mod living;
mod write;

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::recipe::PictureSettings;
use super::{Edit, Movement, OutputSize, Recipe, Timeline};
use crate::io::formats::quilt;
use crate::io::save::{self, Keep};

pub use kinds::{Group, KINDS, Kind, Spec};
pub use write::{FileExport, Written, write, write_picture};

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

impl Existing {
    /// Where a file is really written; none where the old one stays.
    pub fn resolve(self, target: &Path) -> Option<PathBuf> {
        match self {
            Self::Number => Some(save::free_path(target)),
            Self::Leave if target.exists() => None,
            Self::Leave | Self::Replace => Some(target.to_owned()),
        }
    }
}

/// What is asked for, as the dialog shows it and the command line's options name it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Settings {
    /// What is written.
    #[serde(alias = "what")]
    pub kind: Kind,
    /// How pictures are kept; goes into recipes.
    pub picture: PictureSettings,
    /// Where to; none is beside the photo.
    pub folder: Option<PathBuf>,
    /// When the file exists.
    pub existing: Existing,
    /// Frames of a stack or an animation.
    pub frames: u16,
    /// Frames a second of an animation.
    pub frames_per_second: u16,
    /// What moves in it.
    #[serde(alias = "moving")]
    pub movement: Movement,
    /// Suffix of an animation.
    pub animation: String,
    /// How large an animation becomes.
    pub animation_size: OutputSize,
    /// How a film is written.
    pub film: Film,
    /// What moves in either where a timeline says it.
    #[serde(skip)]
    pub timeline: Option<Timeline>,
    /// What the edit comes from: where its depth is from, and what else its file held. Goes into pictures, if asked for.
    #[serde(skip)]
    pub recipe: Recipe,
    /// Distance between both eyes, in view steps.
    pub eyes_apart: f32,
    /// Which display a quilt is for, an index of [`quilt::DEVICES`].
    pub device: usize,
    /// Whether the photo's own file may be written over.
    #[serde(skip)]
    pub replaces_source: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            kind: Kind::Picture,
            picture: PictureSettings { keep: Keep::WithoutPosition, ..PictureSettings::default() },
            folder: None,
            existing: Existing::Number,
            frames: Self::FRAMES,
            frames_per_second: Self::FRAMES_PER_SECOND,
            movement: Movement::Focus,
            animation: "gif".to_owned(),
            animation_size: OutputSize::LongSide(Self::ANIMATION_PX),
            film: Film::default(),
            timeline: None,
            recipe: Recipe::default(),
            eyes_apart: Self::EYES_APART,
            device: 0,
            replaces_source: false,
        }
    }
}

/// How a film is written.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Film {
    /// How many frames.
    pub frames: u16,
    /// Whether so many it has, however long its timeline is.
    #[serde(skip)]
    pub is_cut: bool,
    /// So many a second.
    pub frames_per_second: u16,
    /// The name's ending: `mp4` or `webm`.
    pub ending: String,
    /// How large.
    pub size: OutputSize,
}

impl Default for Film {
    fn default() -> Self {
        Self {
            frames: 90,
            is_cut: false,
            frames_per_second: 30,
            ending: "mp4".to_owned(),
            size: OutputSize::Within([1920, 1080]),
        }
    }
}

impl Settings {
    /// Frames of a stack or an animation where nobody asks for another number.
    pub const FRAMES: u16 = 24;
    /// How many pictures a stack can have.
    pub const MOST_PICTURES: u16 = 250;
    /// How many frames an animation or a film can have: a minute at 50 a second.
    pub const MOST_FRAMES: u16 = 3000;
    /// Frames a second of an animation.
    pub const FRAMES_PER_SECOND: u16 = 12;
    /// Long side of an animation, in pixels.
    pub const ANIMATION_PX: u32 = 800;
    /// Distance between both eyes, in view steps.
    pub const EYES_APART: f32 = 2.0;

    /// Where the export of a file goes, or of a picture without one that has a name.
    pub fn target(&self, path: Option<&Path>, name: &str, edit: &Edit) -> PathBuf {
        let beside = path.and_then(Path::parent).map(Path::to_owned);
        let home = || directories::UserDirs::new().map(|dirs| dirs.picture_dir().unwrap_or(dirs.home_dir()).to_owned());
        let folder = self.folder.clone().or(beside).or_else(home).unwrap_or_default();
        folder.join(self.file_name(name, edit))
    }

    /// The name of the file or folder for a photo's.
    pub fn file_name(&self, name: &str, edit: &Edit) -> String {
        let plain = Path::new(name).file_stem().unwrap_or_default().to_string_lossy().into_owned();
        match self.kind {
            Kind::Picture => self.picture.file_name(Path::new(name), edit),
            Kind::Animation => format!("{plain}-{}.{}", self.movement.word(), self.animation),
            Kind::Video => format!("{plain}-{}.{}", self.movement.word(), self.film.ending),
            Kind::Quilt => self.device().file_name(&plain),
            kind => kind.spec().file.replace("{name}", &plain),
        }
    }

    /// The display that a quilt is for.
    pub fn device(&self) -> &'static quilt::Device {
        quilt::DEVICES.get(self.device).unwrap_or(&quilt::DEVICES[0])
    }

    /// How many frames an animation or a film has, and how many a second. A timeline says how long it is.
    pub fn frames_and_rate(&self) -> (u16, u16) {
        let (frames, rate) = match self.kind {
            Kind::Video | Kind::Frames => (self.film.frames, self.film.frames_per_second),
            _ => (self.frames, self.frames_per_second),
        };
        let is_timed = self.movement == Movement::Timeline && self.kind != Kind::FocalStack && !self.film.is_cut;
        let lasts = self.timeline.as_ref().filter(|_| is_timed);
        (lasts.map_or(frames, |timeline| timeline.frames(rate)), rate)
    }

    /// How large pictures, frames and stacks become.
    pub fn size(&self) -> OutputSize {
        match self.kind {
            Kind::Animation => self.animation_size,
            Kind::Video | Kind::Frames => self.film.size,
            _ => self.picture.size,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::FNumber;

    #[test]
    fn every_kind_has_a_place_of_its_own_beside_the_photo() {
        let edit = Edit { f_number: FNumber(2.0), ..Edit::default() };
        let target = |spec: &Spec| {
            let settings = Settings { kind: spec.kind, ..Settings::default() };
            let target = settings.target(Some(Path::new("/a/rose.heic")), "rose.heic", &edit);
            assert_eq!(target.parent(), Some(Path::new("/a")), "{:?}", spec.kind);
            target
        };
        let mut targets: Vec<_> = KINDS.iter().map(target).collect();
        assert_eq!(targets[0], Path::new("/a/rose-f2.jpg"));
        targets.sort();
        targets.dedup();
        assert_eq!(targets.len(), KINDS.len(), "no two kinds write the same file");
    }

    #[test]
    fn a_timeline_says_how_long_its_film_is() {
        let timeline = Timeline { seconds: 20.0, ..Timeline::default() };
        let timed = |kind, is_cut| Settings {
            kind,
            movement: Movement::Timeline,
            timeline: Some(timeline.clone()),
            film: Film { is_cut, ..Film::default() },
            ..Settings::default()
        };
        assert_eq!(timed(Kind::Video, false).frames_and_rate(), (600, 30));
        assert_eq!(timed(Kind::Animation, false).frames_and_rate(), (240, 12));
        assert_eq!(timed(Kind::Animation, true).frames_and_rate(), (Settings::FRAMES, 12));
        assert_eq!(timed(Kind::FocalStack, false).frames_and_rate().0, Settings::FRAMES);
    }

    #[test]
    fn settings_of_older_versions_open() {
        let old = r#"{"what": "FocalStack", "moving": "Viewpoint", "frames": 9}"#;
        let settings: Settings = serde_json::from_str(old).unwrap();
        assert_eq!((settings.kind, settings.movement, settings.frames), (Kind::FocalStack, Movement::Viewpoint, 9));
    }
}
