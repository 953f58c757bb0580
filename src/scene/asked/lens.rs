//! From typed numbers to an edit: f-number, what is sharp, the shape.

use super::Usage;
use crate::field::{FNumber, LensShape};
use crate::scene::{Edit, Focus, Scene};

/// What is to be sharp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FocusAsked {
    /// What the photo most likely is about, as in a window that has just opened it.
    Subject,
    /// A pixel of the upright photo, x and y.
    At([f32; 2]),
}

/// What a person turns on the lens; none is left as it is.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LensAsked {
    /// How wide open.
    pub f_number: Option<FNumber>,
    /// What is to be sharp. It goes before `focus_disparity_px`.
    pub focus: Option<FocusAsked>,
    /// The disparity that is to be sharp, in pixels of the scene's map per view step.
    pub focus_disparity_px: Option<f32>,
    /// Shape of the opening.
    pub shape: Option<LensShape>,
    /// Disparities that stay sharp, from far to near, in pixels of the scene's map per view step.
    pub keep_sharp_px: Option<[f32; 2]>,
    /// By how much the sharp disparity grows from left to right and from top to bottom, in the same pixels.
    pub tilt_px: Option<[f32; 2]>,
    /// How much clipped lights are brightened before they are blurred, 0 … 1.
    pub highlights: Option<f32>,
    /// How much of the photo's grain is put back into blurred parts, 0 … 1.
    pub grain: Option<f32>,
}

impl LensAsked {
    /// The edit where neither a recipe nor arguments say another: the plane of disparity 0 is sharp.
    pub fn plain() -> Edit {
        Edit { focus: Focus::Disparity(0.0), ..Edit::default() }
    }

    /// An edit with what is asked for.
    ///
    /// # Errors
    /// A focus outside the picture.
    pub fn edit(&self, mut edit: Edit, scene: &Scene) -> Result<Edit, Usage> {
        let share = |px: f32| px / scene.map().size()[0] as f32;
        edit.strength = scene.strength();
        edit.f_number = self.f_number.unwrap_or(edit.f_number);
        edit.shape = self.shape.clone().unwrap_or(edit.shape);
        edit.highlights = self.highlights.unwrap_or(edit.highlights);
        edit.grain = self.grain.unwrap_or(edit.grain);
        edit.tilt = self.tilt_px.map_or(edit.tilt, |tilt| tilt.map(share));
        edit.focus = match (self.focus, self.focus_disparity_px, self.keep_sharp_px) {
            (Some(FocusAsked::Subject), ..) => Focus::Subject,
            (Some(FocusAsked::At(at)), ..) => Focus::At(place(at, scene.subject().size())?),
            (None, Some(px), _) => Focus::Disparity(share(px)),
            (None, None, Some([lo, hi])) => Focus::Disparity(share((lo + hi) / 2.0)),
            (None, None, None) => edit.focus,
        };
        if let Some([lo, hi]) = self.keep_sharp_px {
            let plane_px = scene.lens(&edit).focus.disparity_px / scene.strength().0;
            edit.keep_sharp = [share((lo - plane_px).min(0.0)), share((hi - plane_px).max(0.0))];
        }
        Ok(edit)
    }
}

/// A pixel of the picture as a place from 0 to 1.
///
/// # Errors
/// It lies outside.
pub fn place([x, y]: [f32; 2], picture: [u32; 2]) -> Result<[f32; 2], Usage> {
    let is_inside = |at: f32, side: u32| (-0.5..side as f32 - 0.5).contains(&at);
    if !(is_inside(x, picture[0]) && is_inside(y, picture[1])) {
        let (right, bottom) = (picture[0] - 1, picture[1] - 1);
        return Err(Usage(format!(
            "{x},{y} is outside the picture — pixels go from 0,0 to {right},{bottom} — name one of them"
        )));
    }
    Ok([(x + 0.5) / picture[0] as f32, (y + 0.5) / picture[1] as f32])
}
