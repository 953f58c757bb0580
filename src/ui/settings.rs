//! What the window remembers between runs.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::hints::Hints;
use crate::render::cpu::Colormap;
use crate::scene::{DepthFrom, Edit, Making, export, trust};

/// Kept between runs.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(default)]
pub struct Settings {
    /// Dark, light, or the system's.
    pub theme: egui::ThemePreference,
    /// The language of the window by its tag; none is the system's.
    pub language: Option<String>,
    /// Colours of ray depths.
    pub colormap: Colormap,
    /// Long side of a view, in pixels.
    pub long_side: u32,
    /// Whether the occlusion net corrects the views.
    pub occlusion: bool,
    /// Where ray depths come from, where there is a choice.
    pub source: DepthFrom,
    /// Opened last, the latest first.
    pub recent: Vec<PathBuf>,
    /// What was open when the window was closed.
    pub last_file: Option<PathBuf>,
    /// The last edit.
    pub edit: Edit,
    /// What the export dialog said last.
    pub export: export::Settings,
    /// The sensor that lenses are read on.
    pub sensor: usize,
    /// Whether the inspector is shown.
    pub has_inspector: bool,
    /// Whether edits are kept beside their photos.
    pub keeps_edits: bool,
    /// Whether edges in focus are marked.
    pub peaking: bool,
    /// Whether what was invented is tinted.
    pub trust: bool,
    /// How much of a picture may be invented before the pad and the aperture say so, in per cent.
    pub trust_percent: f32,
    /// A folder of models to use instead of those in the program.
    pub models_folder: Option<PathBuf>,
    /// Whether photos that were dropped together were of one subject the last time.
    pub drops_one_subject: bool,
    /// Whether the first of several photos takes the mean of all, which has less noise.
    pub takes_mean: bool,
    /// What was told once.
    pub hints: Hints,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            theme: egui::ThemePreference::Dark,
            language: None,
            // Near and far are told apart without red and green.
            colormap: Colormap::Viridis,
            long_side: Making::LONG_SIDE,
            occlusion: true,
            source: DepthFrom::default(),
            recent: Vec::new(),
            last_file: None,
            edit: Edit::default(),
            export: export::Settings::default(),
            sensor: 0,
            has_inspector: true,
            keeps_edits: true,
            peaking: false,
            trust: false,
            trust_percent: 100.0 * trust::USUAL_LIMIT,
            models_folder: None,
            drops_one_subject: false,
            takes_mean: false,
            hints: Hints::default(),
        }
    }
}

impl Settings {
    /// Files in the list of recent ones.
    const RECENT: usize = 8;

    /// Puts a file at the head of the recent ones.
    pub fn remember(&mut self, path: &Path) {
        self.recent.retain(|other| other != path);
        self.recent.insert(0, path.to_owned());
        self.recent.truncate(Self::RECENT);
        self.last_file = Some(path.to_owned());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Movement, export::Kind};

    /// What a window kept.
    struct Kept(&'static str);

    impl eframe::Storage for Kept {
        fn get_string(&self, _: &str) -> Option<String> {
            Some(self.0.to_owned())
        }
        fn set_string(&mut self, _: &str, _: String) {}
        fn remove_string(&mut self, _: &str) {}
        fn flush(&mut self) {}
    }

    #[test]
    fn settings_of_older_versions_open() {
        let old = Kept(
            r#"(theme:Light,colormap:turbo,long_side:360,occlusion:false,source:Fused,recent:["/a.jpg"],
            last_file:Some("/a.jpg"),edit:(lens:(f_number:(2.0),shape:disc,focus:(disparity_px:0.5,tilt_px:(0.0,0.0)),
            keep_sharp_px:(0.0,0.0),highlights:0.0,grain:0.0),viewpoint:((dv:0.0,du:1.0)),focus_at:Some((0.5,0.5))),
            export:(what:FocalStack,picture:(format:jpeg,bits:8,quality:92,size:photo,keep:all,name:"{name}"),
            folder:None,existing:Replace,frames:9,frames_per_second:12,moving:Viewpoint,animation:"gif",
            animation_px:800,eyes_apart:2.0,device:0),has_inspector:true,keeps_edits:true,peaking:true,
            models_folder:None)"#,
        );
        let settings: Settings = eframe::get_value(&old, eframe::APP_KEY).unwrap();
        assert_eq!((settings.long_side, settings.source, settings.peaking), (360, DepthFrom::Fused, true));
        assert_eq!((settings.export.kind, settings.export.movement), (Kind::FocalStack, Movement::Viewpoint));
        assert_eq!(settings.edit, Edit::default(), "its numbers hung on a width that was not kept");
    }
}
