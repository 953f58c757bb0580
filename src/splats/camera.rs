//! Where the reference view stands, and the rig of parallel cameras around it.

use glam::{Mat3, Vec2, Vec3};

use crate::field::{RelativeDepth, Size};

/// A pinhole camera: x right, y down, z forward.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Camera from world: a rotation.
    pub turn: Mat3,
    /// The world's origin as the camera sees it.
    pub shift: Vec3,
    /// Focal length in pixels, across and down.
    pub focal_px: Vec2,
    /// Where the axis meets the picture, in pixels (centres at integers).
    pub center_px: Vec2,
    /// Width and height of its picture.
    pub size: Size,
}

impl Camera {
    /// A camera that looks from a place at another, with y as down as it goes.
    pub fn looking(from: Vec3, at: Vec3, down: Vec3, focal_px: f32, size: Size) -> Self {
        let forward = (at - from).normalize_or(Vec3::Z);
        let right = down.cross(forward).try_normalize().unwrap_or_else(|| forward.any_orthonormal_vector());
        let turn = Mat3::from_cols(right, forward.cross(right), forward).transpose();
        Self::in_middle(turn, -(turn * from), focal_px, size)
    }

    /// At the origin, looking along z.
    pub fn at_origin(focal_px: f32, size: Size) -> Self {
        Self::in_middle(Mat3::IDENTITY, Vec3::ZERO, focal_px, size)
    }

    fn in_middle(turn: Mat3, shift: Vec3, focal_px: f32, size: Size) -> Self {
        let center_px = Vec2::new(size[0] as f32 - 1.0, size[1] as f32 - 1.0) / 2.0;
        Self { turn, shift, focal_px: Vec2::splat(focal_px), center_px, size }
    }

    /// The camera of the same place for pictures of another size.
    #[must_use]
    pub fn resized(&self, size: Size) -> Self {
        let ratio = Vec2::new(size[0] as f32 / self.size[0] as f32, size[1] as f32 / self.size[1] as f32);
        let center_px = (self.center_px + 0.5) * ratio - 0.5;
        Self { focal_px: self.focal_px * ratio, center_px, size, ..*self }
    }

    /// A place of the world as the camera sees it.
    pub fn seen(&self, world: Vec3) -> Vec3 {
        self.turn * world + self.shift
    }

    /// Where it stands in the world.
    pub fn place(&self) -> Vec3 {
        -(self.turn.transpose() * self.shift)
    }
}

/// The reference camera, and how far the cameras of the views stand apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rig {
    /// The camera of the reference view.
    pub camera: Camera,
    /// One view step, in the world's unit.
    pub step: f32,
    /// Inverse distance of what has disparity 0.
    pub zero: f32,
    /// What is nearer is not drawn, in the world's unit.
    pub near: f32,
}

/// A scene whose far end is this much less near than its near end (as a part of it) is given the whole usual range of
/// disparities, as relative depth is (`synth::range`).
const DEEP: f32 = 0.25;
/// Nothing is drawn that is nearer than this part of the near end's distance.
const TOO_NEAR: f32 = 0.15;

impl Rig {
    /// A rig for a scene between two inverse distances: the usual range of disparities, less for one that is flat.
    pub fn for_range(camera: Camera, [far, near]: [f32; 2]) -> Self {
        let deep = ((near - far) / (DEEP * near)).clamp(0.0, 1.0);
        let [low, high] = RelativeDepth::usual_range_px(camera.size[0]).map(|px| px * deep);
        let gain_px = (high - low) / (near - far).max(1e-6 * near);
        Self { camera, step: gain_px / camera.focal_px.x, zero: far - low / gain_px.max(1e-12), near: TOO_NEAR / near }
    }

    /// The same rig for views of another size.
    #[must_use]
    pub fn resized(&self, size: Size) -> Self {
        Self { camera: self.camera.resized(size), ..*self }
    }

    /// The same rig with cameras this many times as far apart.
    #[must_use]
    pub fn at_strength(&self, strength: f32) -> Self {
        Self { step: self.step * strength, ..*self }
    }

    /// Disparity of one inverse unit of distance, in pixels per view step.
    pub fn gain_px(&self) -> f32 {
        self.camera.focal_px.x * self.step
    }

    /// Disparity at an inverse distance, in pixels per view step: `D = f·b·(1/z − 1/z₀)`.
    pub fn disparity_px(&self, nearness: f32) -> f32 {
        self.gain_px() * (nearness - self.zero)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_camera_sees_what_it_looks_at_in_the_middle() {
        let camera = Camera::looking(Vec3::new(3.0, -2.0, 1.0), Vec3::new(0.0, 1.0, 5.0), Vec3::Y, 500.0, [640, 480]);
        let seen = camera.seen(Vec3::new(0.0, 1.0, 5.0));
        assert!(seen.truncate().length() < 1e-5 && (seen.z - 34f32.sqrt()).abs() < 1e-5);
        assert!((camera.place() - Vec3::new(3.0, -2.0, 1.0)).length() < 1e-5);
        assert!(camera.seen(Vec3::new(0.0, 2.0, 5.0)).y > 0.0, "down is down");
        assert!((camera.turn.determinant() - 1.0).abs() < 1e-5);
    }

    #[test]
    fn the_ends_of_a_deep_scene_have_the_usual_disparities() {
        let rig = Rig::for_range(Camera::at_origin(500.0, [540, 360]), [0.1, 1.0]);
        assert!((rig.disparity_px(0.1) + 0.8).abs() < 1e-4 && (rig.disparity_px(1.0) - 1.0).abs() < 1e-4);
        let flat = Rig::for_range(Camera::at_origin(500.0, [540, 360]), [0.95, 1.0]);
        assert!((flat.disparity_px(1.0) - 0.2).abs() < 1e-3, "{}", flat.disparity_px(1.0));
    }
}
