//! Where a frame stands against the reference frame, and where it sees a point.
//!
//! Lengths are in units of the first baseline. Places in a picture are *normalised*: from its middle, in long sides, so
//! that they do not hang on a size. A point is a place of the reference frame and its inverse depth.

use glam::{DMat3, DVec2, DVec3};

use crate::field::Size;

/// Nearest to the camera's own plane that a point may come, as a share of its depth.
const NEAREST: f64 = 0.05;

/// Pose of a frame: `X_frame = R·X_reference + t`, with a rotation that goes on while the rows are read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Rotation of frame coordinates from those of the reference frame.
    pub rotation: DMat3,
    /// Translation, in baselines.
    pub translation: DVec3,
    /// Rotation (axis · radians) that is added for each long side down from the middle: a rolling shutter.
    pub turning: DVec3,
}

impl Pose {
    /// The reference frame's.
    pub const REFERENCE: Self = Self { rotation: DMat3::IDENTITY, translation: DVec3::ZERO, turning: DVec3::ZERO };

    /// Where a point lies in the frame's own coordinates, times its depth in the reference frame. `ray` is its direction
    /// there, of depth 1.
    #[inline]
    pub fn transform(&self, ray: DVec3, row: f64, inverse_depth: f64) -> DVec3 {
        self.turned(ray, row) + self.translation * inverse_depth
    }

    /// A direction of the reference frame, seen in a row, in the frame's coordinates.
    #[inline]
    pub fn turned(&self, ray: DVec3, row: f64) -> DVec3 {
        let turned = self.rotation * ray;
        turned + (self.turning * row).cross(turned)
    }

    /// Where the frame's camera stands in the reference frame's coordinates.
    pub fn centre(&self) -> DVec3 {
        -(self.rotation.transpose() * self.translation)
    }
}

/// A lens of a pinhole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Focal(
    /// Focal length in long sides of the picture.
    pub f64,
);

impl Focal {
    /// Of a focal length as on 35-mm film, in millimetres.
    pub fn of_f35(mm: f32) -> Self {
        Self(f64::from(mm) / 36.0)
    }

    /// Direction of a place, of depth 1.
    #[inline]
    pub fn ray(self, at: DVec2) -> DVec3 {
        (at / self.0).extend(1.0)
    }

    /// Place of a point.
    #[inline]
    pub fn place(self, point: DVec3) -> DVec2 {
        self.0 * point.truncate() / point.z.max(NEAREST)
    }

    /// Where a frame sees the reference frame's point.
    #[inline]
    pub fn seen(self, pose: &Pose, at: DVec2, inverse_depth: f64) -> DVec2 {
        self.place(pose.transform(self.ray(at), at.y, inverse_depth))
    }
}

/// Normalised place of a pixel.
#[inline]
pub fn place_of_pixel([w, h]: Size, x: f64, y: f64) -> DVec2 {
    let long = f64::from(w.max(h));
    DVec2::new(x + 0.5 - f64::from(w) / 2.0, y + 0.5 - f64::from(h) / 2.0) / long
}

/// Pixel at a normalised place.
#[inline]
pub fn pixel_of_place([w, h]: Size, at: DVec2) -> DVec2 {
    let long = f64::from(w.max(h));
    at * long + DVec2::new(f64::from(w) / 2.0 - 0.5, f64::from(h) / 2.0 - 0.5)
}
