//! Typed numbers of the lens, handed to the library.

use plenoscope::scene::asked::LensAsked;

use crate::cli::LensArgs;

/// What the arguments ask for.
pub fn asked(args: &LensArgs) -> LensAsked {
    LensAsked {
        f_number: args.f_number,
        focus: args.focus.map(Into::into),
        focus_disparity_px: args.focus_disparity,
        shape: args.lens,
        keep_sharp_px: args.keep_sharp.map(|range| [range.lo, range.hi]),
        tilt_px: args.tilt.map(Into::into),
        highlights: args.highlights,
        grain: args.grain,
    }
}
