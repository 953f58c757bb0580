//! Typed numbers of the lens, handed to the library.

use anyhow::{Result, bail};
use plenoscope::field::Glass;
use plenoscope::job::Job;
use plenoscope::scene::asked::{LensAsked, Usage, place};
use plenoscope::scene::real::{FORMATS, KnownLens};
use plenoscope::scene::sharp::Places;
use plenoscope::scene::{Edit, Focus, Scene};

use crate::cli::LensArgs;
use crate::values::{KeepSharp, KnownLength};

/// What the arguments ask for.
pub fn asked(args: &LensArgs) -> LensAsked {
    let band = |keep: &KeepSharp| if let KeepSharp::Band(range) = keep { Some([range.lo, range.hi]) } else { None };
    LensAsked {
        f_number: args.f_number,
        focus: args.focus,
        focus_disparity_px: args.focus_disparity,
        shape: args.lens.clone(),
        keep_sharp_px: args.keep_sharp.first().and_then(band),
        tilt_px: args.tilt.map(Into::into),
        highlights: args.highlights,
        grain: args.grain,
    }
}

/// What is to stay sharp.
enum Sharp {
    Nothing,
    Band,
    At(Places),
}

impl Sharp {
    fn of(args: &LensArgs, picture: [u32; 2]) -> Result<Self> {
        let mut places: Option<Places> = None;
        for value in &args.keep_sharp {
            match (*value, args.keep_sharp.len()) {
                (KeepSharp::Band(_), 1) => return Ok(Self::Band),
                (KeepSharp::At(_), 4..) | (KeepSharp::Band(_), _) => bail!(Usage(
                    "too much is to be kept sharp — a band of disparities or up to three pixels — leave some out"
                        .to_owned()
                )),
                (KeepSharp::At(at), _) => {
                    let at = place([at.0, at.1], picture)?;
                    places = Some(places.map_or_else(|| Places::from(at), |places| places.with(at)));
                }
            }
        }
        if places.is_some() && (args.focus.is_some() || args.focus_disparity.is_some() || args.tilt.is_some()) {
            let text =
                "the focus is named twice — --keep-sharp with pixels finds focus and tilt — leave the others out";
            bail!(Usage(text.to_owned()));
        }
        Ok(places.map_or(Self::Nothing, Self::At))
    }
}

/// The edit with what else the arguments name: places that stay sharp, faults, a distance, a known lens; for a picture of a
/// width.
pub fn further(args: &LensArgs, mut edit: Edit, scene: &Scene, picture_width: u32, job: &Job) -> Result<Edit> {
    let sharp = Sharp::of(args, scene.subject().size())?;
    edit.glass = Glass {
        anamorphic: args.anamorphic.unwrap_or(edit.glass.anamorphic),
        spherical: args.spherical.unwrap_or(edit.glass.spherical),
        fringes: args.fringes.unwrap_or(edit.glass.fringes),
        swirl: args.swirl.unwrap_or(edit.glass.swirl),
    };
    if let Sharp::At(places) = sharp {
        edit.focus = Focus::Through(places);
    }
    if let Some(metres) = args.distance {
        edit = scene.with_distance(&edit, Some(metres));
    }
    if let Some(length) = args.length {
        edit = of_length(scene, &edit, length)?;
    }
    if scene.goes_through(&edit) == Some(false) {
        job.sink.warning("no plane goes through these places: a band of depths keeps them sharp".to_owned());
    }
    match &args.as_lens {
        Some(lens) => as_lens(args, edit, lens, scene, job),
        None if args.f_number.is_none() && matches!(sharp, Sharp::At(_)) => {
            Ok(Edit { f_number: scene.widest(&edit, picture_width).unwrap_or(edit.f_number), ..edit })
        }
        None => Ok(edit),
    }
}

/// The edit with the distance of something of a known length.
fn of_length(scene: &Scene, edit: &Edit, KnownLength { ends, metres }: KnownLength) -> Result<Edit> {
    let size = scene.subject().size();
    let ends = [place([ends[0].0, ends[0].1], size)?, place([ends[1].0, ends[1].1], size)?];
    let Some(known) = scene.with_length(edit, ends, metres) else {
        bail!(Usage("the length has no length — its two pixels are the same, or nearly — name its ends".to_owned()));
    };
    Ok(known)
}

/// Opens as a lens does: at the f-number of its own that was typed, else all the way.
fn as_lens(args: &LensArgs, edit: Edit, lens: &KnownLens, scene: &Scene, job: &Job) -> Result<Edit> {
    let [widest, narrowest] = lens.f_numbers;
    let own = args.f_number.map_or(widest, |f| f.0);
    if !(widest..=narrowest).contains(&own) {
        bail!(Usage(format!(
            "this lens has no f/{own} — it goes from f/{widest} to f/{narrowest} — name one between: {}",
            lens.name
        )));
    }
    let (f_number, is_cut) = scene.f_number_of(&edit, lens, own);
    let edit = Edit { f_number, shape: lens.shape(own), ..edit };
    let reading = scene.reading(&edit, &FORMATS[0], 1);
    if is_cut {
        let text =
            format!("the aperture of {} at f/{own} is beyond what there is here: {}", lens.name, reading.title());
        job.sink.warning(text);
    }
    if let Some((focus, nearest)) = reading.focus_m.zip(lens.nearest_m).filter(|(focus, nearest)| focus < nearest) {
        job.sink.warning(format!("{} focuses from {nearest} m on, and the focus is at {focus:.2} m", lens.name));
    }
    Ok(edit)
}
