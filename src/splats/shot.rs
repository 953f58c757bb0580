//! From where a picture of a cloud is taken, and what a lens does to its light.

use glam::{Vec2, Vec3};

use super::{Blend, Rig};
use crate::field::{Lens, ramp};

/// Light that a spherical aberration moves at most; as in the layered lens.
const MOST_SPHERICAL: f32 = 0.8;

/// From where a picture is taken, and what is done to its light.
#[derive(Clone, Copy, Debug)]
pub struct Shot<'a> {
    /// The reference camera and the step.
    pub rig: Rig,
    /// Where the eye is, in view steps from the reference view.
    pub from: Vec2,
    /// Where the middle of its lens is: what is sharp stands as it is seen from there.
    pub middle: Vec2,
    /// The lens whose sharp surface stays where it is, in pixels of this width.
    pub lens: Option<&'a Lens>,
    /// Standard deviation of the part of the opening that this eye stands for, in view steps.
    pub blur: f32,
    /// The eye's place on the opening, over its radius, squared.
    pub rim: f32,
    /// The eye's place in the world.
    pub(super) eye: Vec3,
}

impl<'a> Shot<'a> {
    /// What an eye sees that stands some view steps beside the reference camera.
    pub fn view(rig: Rig, from: Vec2) -> Self {
        let camera = &rig.camera;
        let beside = from * rig.gain_px() / camera.focal_px;
        let eye = camera.place() + camera.turn.transpose() * beside.extend(0.0);
        Self { rig, from, middle: from, lens: None, blur: 0.0, rim: 0.0, eye }
    }

    /// The same as one of many eyes on a lens's opening.
    pub fn through(rig: Rig, from: Vec2, middle: Vec2, lens: &'a Lens, blur: f32, rim: f32) -> Self {
        Self { lens: Some(lens), middle, blur, rim, ..Self::view(rig, from) }
    }

    /// How far a disparity at a place is from what is sharp, in pixels per view step.
    #[inline]
    pub(super) fn away_px(&self, disparity_px: f32, at: Vec2) -> f32 {
        let size = self.rig.camera.size;
        let place = |at: f32, side: u32| (at + 0.5) / side as f32;
        self.lens.map_or(0.0, |lens| lens.defocus_px(disparity_px, place(at.x, size[0]), place(at.y, size[1])))
    }

    /// The light of something as the lens shows it: clipped lights brightened where they are blurred, and more of it
    /// towards the middle or the rim by a spherical aberration; as the layered lens does.
    #[inline]
    pub(super) fn lit(&self, color: [f32; 3], away_px: f32, blend: Blend) -> [f32; 3] {
        let Some(lens) = self.lens.filter(|lens| lens.highlights > 0.0 || lens.glass.spherical != 0.0) else {
            return color;
        };
        let blur = away_px * lens.f_number.added_views();
        let clipped = ramp(0.85, 1.0, color[0].max(color[1]).max(color[2]));
        let bright = 1.0 + 9.0 * lens.highlights.max(0.0) * clipped * ramp(1.0, 8.0, blur.abs());
        let moved = -blur.signum() * MOST_SPHERICAL * lens.glass.spherical * ramp(2.0, 4.0, blur.abs());
        let gain = bright * (1.0 + moved * (2.0 * self.rim - 1.0)).max(0.0);
        let gain = if blend == Blend::Encoded { gain.powf(1.0 / 2.2) } else { gain };
        color.map(|value| value * gain)
    }
}
