//! How the picture is looked at: face, zoom and pan, the probe, the line between before and after.

use super::words::{Message, message};
use egui::{Rect, Vec2, vec2};
use serde::{Deserialize, Serialize};

use crate::field::{ViewGrid, ViewOffset, ViewPoint};

/// The faces of the canvas.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Face {
    /// The refocused picture.
    #[default]
    Picture,
    /// The grid of all views.
    Views,
    /// Ray depths of the current view.
    Depths,
    /// The scene as points in space.
    Points,
}

/// The line between the photo and the picture.
#[derive(Clone, Copy, Debug)]
pub struct Split {
    /// Whether both are shown.
    pub is_shown: bool,
    /// Where it stands, as a share of the canvas's width.
    pub at: f32,
    /// Whether the hand holds it.
    pub is_held: bool,
}

/// How both eyes are shown at once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stereo {
    /// One picture for both.
    #[default]
    Off,
    /// In one picture, for red-cyan glasses.
    Anaglyph,
    /// Beside each other, left eye left.
    Parallel,
    /// Beside each other, left eye right: for eyes that cross.
    Crossed,
}

impl Stereo {
    /// The next one, and what it is called.
    pub fn next(self) -> (Self, Message) {
        match self {
            Self::Off => (Self::Anaglyph, message!("stereo-anaglyph")),
            Self::Anaglyph => (Self::Parallel, message!("stereo-parallel")),
            Self::Parallel => (Self::Crossed, message!("stereo-crossed")),
            Self::Crossed => (Self::Off, message!("stereo-off")),
        }
    }
}

/// A line over something whose length a person knows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Measure {
    /// None is asked for.
    #[default]
    Off,
    /// The next drag draws it.
    Asked,
    /// The hand draws it: its ends, places of the photo from 0 to 1.
    Drawn([[f32; 2]; 2]),
    /// It is there.
    Over([[f32; 2]; 2]),
}

/// How the picture is looked at: what of it changes nothing but that.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    /// Picture, views, ray depths or points.
    pub face: Face,
    /// Zoom and pan.
    pub pose: Pose,
    /// Where the picture has its room, as it was last drawn.
    pub canvas: Rect,
    /// Photo and picture side by side.
    pub split: Split,
    /// How both eyes are shown at once.
    pub stereo: Stereo,
    /// The ring that the hand holds, of what is kept sharp.
    pub held_ring: Option<usize>,
    /// The line over something of a known length.
    pub measure: Measure,
    /// Place in the picture (0 to 1) that cross-hairs and epipolar images go through.
    pub probe: Vec2,
    /// The disparity under the pointer.
    pub hovered_px: Option<f32>,
    /// Whether the viewpoint goes round.
    pub is_circling: bool,
    /// Whether something moves the picture now.
    pub is_moving: bool,
    /// When it last moved, so that the picture at rest waits for the hand.
    pub moved_at_secs: f64,
    /// Whether a narrow window shows its inspector.
    pub is_drawer_open: bool,
}

impl Default for Look {
    fn default() -> Self {
        Self {
            face: Face::Picture,
            pose: Pose::default(),
            canvas: Rect::ZERO,
            split: Split { is_shown: false, at: 0.5, is_held: false },
            stereo: Stereo::Off,
            held_ring: None,
            measure: Measure::Off,
            probe: Vec2::splat(0.5),
            hovered_px: None,
            is_circling: false,
            is_moving: false,
            moved_at_secs: 0.0,
            is_drawer_open: false,
        }
    }
}

impl Look {
    /// Another picture is looked at.
    pub fn begin(&mut self) {
        let whole = Self::default();
        (self.face, self.pose, self.probe, self.is_circling) = (whole.face, whole.pose, whole.probe, false);
        self.measure = Measure::Off;
    }

    /// Zooms about the canvas's middle.
    pub fn zoom_by(&mut self, picture: Vec2, factor: f32) {
        self.pose.zoom_at(self.canvas, picture, self.canvas.center(), factor);
    }

    /// The viewpoint on its way round, one turn in four seconds.
    pub fn on_circle(grid: ViewGrid, time_secs: f64) -> ViewPoint {
        let angle = time_secs as f32 * std::f32::consts::FRAC_PI_2;
        ViewPoint(ViewOffset { dv: grid.inner_radius() * angle.sin(), du: grid.inner_radius() * angle.cos() })
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
