//! What the window remembers: the edit (undone and redone as one), the settings, and how the canvas stands.

use std::path::PathBuf;

use egui::{Rect, Vec2, vec2};
use serde::{Deserialize, Serialize};

use crate::field::{Lens, ViewPoint};
use crate::recipe::Recipe;
use crate::render::cpu::Colormap;

/// What is done to the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Edit {
    /// Aperture, focus, shape.
    pub lens: Lens,
    /// Where the eye is.
    pub viewpoint: ViewPoint,
    /// The place of the picture that was clicked to be sharp, x and y from 0 to 1; none once the focus was set by number.
    pub focus_at: Option<[f32; 2]>,
}

impl Edit {
    /// The edit that a recipe holds.
    pub fn of_recipe(recipe: &Recipe) -> Self {
        Self { lens: recipe.lens, viewpoint: recipe.viewpoint, focus_at: recipe.focus_at }
    }

    /// Puts the edit into a recipe; what else is in it stays.
    pub fn put_into(&self, recipe: &mut Recipe) {
        recipe.lens = self.lens;
        recipe.viewpoint = self.viewpoint;
        recipe.focus_at = self.focus_at;
    }

    /// The same edit for views of another width: disparities are in pixels.
    pub fn scaled(mut self, factor: f32) -> Self {
        let focus = &mut self.lens.focus;
        focus.disparity_px *= factor;
        focus.tilt_px = focus.tilt_px.map(|px| px * factor);
        self.lens.keep_sharp_px = self.lens.keep_sharp_px.map(|px| px * factor);
        self
    }
}

/// The three faces of the canvas.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Face {
    /// The refocused picture.
    #[default]
    Picture,
    /// The grid of all views.
    Views,
    /// Ray depths of the current view.
    Depths,
}

/// Where ray depths come from.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Source {
    /// The depth net.
    #[default]
    Network,
    /// What the phone measured.
    Phone,
    /// The phone's order and scale, the net's edges.
    Fused,
    /// A map of one's own.
    Map,
    /// Another model of the models folder, by name.
    Model(String),
}

impl Source {
    /// What is left of the choice at the next start. A map belongs to one photo and another model to the photos that
    /// it is good for: one that knows flowers alone takes a wall for near.
    pub fn lasting(self) -> Self {
        match self {
            Self::Map | Self::Model(_) => Self::Network,
            source => source,
        }
    }
}

/// Kept between runs.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(default)]
pub struct Settings {
    /// Dark, light, or the system's.
    pub theme: egui::ThemePreference,
    /// Colours of ray depths.
    pub colormap: Colormap,
    /// Long side of a view, in pixels.
    pub long_side: u32,
    /// Whether the occlusion net corrects the views.
    pub occlusion: bool,
    /// Where ray depths come from, where there is a choice.
    pub source: Source,
    /// Opened last, the latest first.
    pub recent: Vec<PathBuf>,
    /// What was open when the window was closed.
    pub last_file: Option<PathBuf>,
    /// The last edit.
    pub edit: Edit,
    /// What the export dialog said last.
    pub export: super::export::ExportSettings,
    /// Whether the inspector is shown.
    pub has_inspector: bool,
    /// Whether edits are kept beside their photos.
    pub keeps_edits: bool,
    /// Whether edges in focus are marked.
    pub peaking: bool,
    /// A folder of models to use instead of those in the program.
    pub models_folder: Option<PathBuf>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            theme: egui::ThemePreference::Dark,
            colormap: Colormap::default(),
            long_side: 540,
            occlusion: true,
            source: Source::default(),
            recent: Vec::new(),
            last_file: None,
            edit: Edit::default(),
            export: super::export::ExportSettings::default(),
            has_inspector: true,
            keeps_edits: true,
            peaking: false,
            models_folder: None,
        }
    }
}

impl Settings {
    /// Files in the list of recent ones.
    const RECENT: usize = 8;

    /// Puts a file at the head of the recent ones.
    pub fn remember(&mut self, path: &std::path::Path) {
        self.recent.retain(|other| other != path);
        self.recent.insert(0, path.to_owned());
        self.recent.truncate(Self::RECENT);
        self.last_file = Some(path.to_owned());
    }
}

/// How the picture lies in the canvas.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Magnification over the size that just fits.
    pub zoom: f32,
    /// The place of the picture (0 to 1) in the canvas's middle.
    pub center: Vec2,
}

impl Default for Pose {
    fn default() -> Self {
        Self { zoom: 1.0, center: Vec2::splat(0.5) }
    }
}

impl Pose {
    /// Zoom stays between the whole picture and this many times 1:1.
    const MOST_TIMES_PIXELS: f32 = 16.0;

    /// Size of the picture in points when it just fits.
    pub fn fit(canvas: Rect, picture: Vec2) -> Vec2 {
        picture * (canvas.width() / picture.x).min(canvas.height() / picture.y)
    }

    /// Where the picture lies on the screen.
    pub fn screen_rect(&self, canvas: Rect, picture: Vec2) -> Rect {
        let size = Self::fit(canvas, picture) * self.zoom;
        Rect::from_min_size(canvas.center() - self.center * size, size)
    }

    /// Zooms about a point of the screen, which keeps its place in the picture.
    pub fn zoom_at(&mut self, canvas: Rect, picture: Vec2, at: egui::Pos2, factor: f32) {
        let before = self.screen_rect(canvas, picture);
        let place = (at - before.min) / before.size();
        let most = Self::MOST_TIMES_PIXELS * picture.x / Self::fit(canvas, picture).x;
        self.zoom = (self.zoom * factor).clamp(1.0, most.max(1.0));
        let size = Self::fit(canvas, picture) * self.zoom;
        self.center = place - (at - canvas.center()) / size;
        self.keep_inside(canvas, picture);
    }

    /// Moves the picture by points of the screen.
    pub fn pan(&mut self, canvas: Rect, picture: Vec2, by: Vec2) {
        self.center -= by / (Self::fit(canvas, picture) * self.zoom);
        self.keep_inside(canvas, picture);
    }

    /// Sets the magnification so that one picture pixel is one screen pixel.
    pub fn one_to_one(&mut self, canvas: Rect, picture: Vec2, points_per_pixel: f32) {
        let zoom = picture.x * points_per_pixel / Self::fit(canvas, picture).x;
        self.zoom_at(canvas, picture, canvas.center(), zoom / self.zoom);
    }

    /// No empty space on a side while the other side has more.
    fn keep_inside(&mut self, canvas: Rect, picture: Vec2) {
        let size = Self::fit(canvas, picture) * self.zoom;
        let half = canvas.size() / size * 0.5;
        let keep = |c: f32, half: f32| if half >= 0.5 { 0.5 } else { c.clamp(half, 1.0 - half) };
        self.center = vec2(keep(self.center.x, half.x), keep(self.center.y, half.y));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::pos2;

    #[test]
    fn another_model_is_chosen_for_this_run_alone() {
        assert_eq!(Source::Model("flowers".to_owned()).lasting(), Source::Network);
        assert_eq!(Source::Fused.lasting(), Source::Fused);
    }

    #[test]
    fn zooming_keeps_what_is_under_the_pointer() {
        let canvas = Rect::from_min_size(pos2(10.0, 20.0), vec2(800.0, 600.0));
        let picture = vec2(4000.0, 3000.0);
        let mut pose = Pose::default();
        let at = pos2(300.0, 400.0);
        let place =
            |pose: &Pose| (at - pose.screen_rect(canvas, picture).min) / pose.screen_rect(canvas, picture).size();
        let before = place(&pose);
        pose.zoom_at(canvas, picture, at, 3.0);
        assert!((place(&pose) - before).length() < 1e-4);
        pose.one_to_one(canvas, picture, 1.0);
        assert!((pose.screen_rect(canvas, picture).width() - 4000.0).abs() < 0.1);
        pose.zoom_at(canvas, picture, at, 1e-3);
        assert_eq!(pose, Pose::default());
    }
}
