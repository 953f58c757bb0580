//! From typed numbers to a lens: f-number, what is sharp, the shape.

use anyhow::{Result, bail};
use plenoscope::field::{DisparityMap, FocalPlane, Lens};

use super::Usage;
use crate::cli::LensArgs;
use crate::values::Pair;

/// A lens with what the arguments name. `map` is the disparity of the upright photo, which has `photo_size` pixels.
pub fn lens(args: &LensArgs, mut lens: Lens, photo_size: [u32; 2], map: &DisparityMap) -> Result<Lens> {
    if let Some(f_number) = args.f_number {
        lens.f_number = f_number;
    }
    if let Some(shape) = args.lens {
        lens.shape = shape;
    }
    lens.highlights = args.highlights.unwrap_or(lens.highlights);
    lens.grain = args.grain.unwrap_or(lens.grain);
    if let Some(Pair(x, y)) = args.tilt {
        lens.focus.tilt_px = [x, y];
    }
    focus(args, photo_size, map, &mut lens)?;
    Ok(lens)
}

/// Sets what is sharp: a pixel's depth, a disparity, or a band of disparities.
fn focus(args: &LensArgs, photo_size: [u32; 2], map: &DisparityMap, lens: &mut Lens) -> Result<()> {
    let plane = match (args.focus, args.focus_disparity, args.keep_sharp) {
        (Some(at), _, _) => Some(focus_at(at, photo_size, map, lens.focus)?),
        (None, Some(disparity_px), _) => Some(disparity_px),
        (None, None, Some(band)) => Some((band.lo + band.hi) / 2.0),
        (None, None, None) => None,
    };
    if let Some(disparity_px) = plane {
        lens.focus.disparity_px = disparity_px;
    }
    if let Some(band) = args.keep_sharp {
        let plane = lens.focus.disparity_px;
        lens.keep_sharp_px = [(band.lo - plane).min(0.0), (band.hi - plane).max(0.0)];
    }
    Ok(())
}

/// The disparity in the middle of the picture of the plane that goes through what is seen at a pixel.
pub fn focus_at(Pair(x, y): Pair, photo: [u32; 2], map: &DisparityMap, plane: FocalPlane) -> Result<f32> {
    let is_inside = |at: f32, side: u32| (-0.5..side as f32 - 0.5).contains(&at);
    if !(is_inside(x, photo[0]) && is_inside(y, photo[1])) {
        let (right, bottom) = (photo[0] - 1, photo[1] - 1);
        bail!(Usage(format!(
            "{x},{y} is outside the picture — pixels go from 0,0 to {right},{bottom} — name one of them"
        )));
    }
    let share = [(x + 0.5) / photo[0] as f32, (y + 0.5) / photo[1] as f32];
    let pixel = |share: f32, side: u32| ((share * side as f32) as u32).min(side - 1);
    let at = [0, 1].map(|axis| pixel(share[axis], map.size()[axis]));
    let tilted = FocalPlane { disparity_px: 0.0, ..plane };
    Ok(map.at(at[0], at[1]) - tilted.at(share[0], share[1]))
}
