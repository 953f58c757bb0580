//! From typed numbers to an edit: f-number, what is sharp, the shape.

use anyhow::{Result, bail};
use plenoscope::scene::{Edit, Focus, Scene};

use super::Usage;
use crate::cli::LensArgs;
use crate::values::Pair;

/// The edit where neither a recipe nor arguments say another: the plane of disparity 0 is sharp.
pub fn plain() -> Edit {
    Edit { focus: Focus::Disparity(0.0), ..Edit::default() }
}

/// An edit with what the arguments name. Disparities that were typed are in pixels of the scene's map.
pub fn edit(args: &LensArgs, mut edit: Edit, scene: &Scene) -> Result<Edit> {
    let share = |px: f32| px / scene.map().size()[0] as f32;
    edit.f_number = args.f_number.unwrap_or(edit.f_number);
    edit.shape = args.lens.unwrap_or(edit.shape);
    edit.highlights = args.highlights.unwrap_or(edit.highlights);
    edit.grain = args.grain.unwrap_or(edit.grain);
    if let Some(Pair(x, y)) = args.tilt {
        edit.tilt = [share(x), share(y)];
    }
    edit.focus = match (args.focus, args.focus_disparity, args.keep_sharp) {
        (Some(at), ..) => Focus::At(place(at, scene.subject().size())?),
        (None, Some(px), _) => Focus::Disparity(share(px)),
        (None, None, Some(band)) => Focus::Disparity(share((band.lo + band.hi) / 2.0)),
        (None, None, None) => edit.focus,
    };
    if let Some(band) = args.keep_sharp {
        let plane_px = scene.lens(&edit).focus.disparity_px;
        edit.keep_sharp = [share((band.lo - plane_px).min(0.0)), share((band.hi - plane_px).max(0.0))];
    }
    Ok(edit)
}

/// A pixel of the picture as a place from 0 to 1.
fn place(Pair(x, y): Pair, picture: [u32; 2]) -> Result<[f32; 2]> {
    let is_inside = |at: f32, side: u32| (-0.5..side as f32 - 0.5).contains(&at);
    if !(is_inside(x, picture[0]) && is_inside(y, picture[1])) {
        let (right, bottom) = (picture[0] - 1, picture[1] - 1);
        bail!(Usage(format!(
            "{x},{y} is outside the picture — pixels go from 0,0 to {right},{bottom} — name one of them"
        )));
    }
    Ok([(x + 0.5) / picture[0] as f32, (y + 0.5) / picture[1] as f32])
}
