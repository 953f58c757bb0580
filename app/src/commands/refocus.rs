//! `refocus`: the picture that another lens would have taken.

use anyhow::Result;
use plenoscope::field::ViewOffset;
use plenoscope::io::save::{self, PictureOptions};
use plenoscope::job::Job;
use plenoscope::scene::asked::{self, Asked};
use plenoscope::scene::export;

use super::output::output;
use super::{input, lens_args};
use crate::cli::Refocus;

/// Renders the picture and writes it.
pub fn run(args: &Refocus, job: &Job) -> Result<()> {
    output(&args.output, &args.input, args.force).check()?;
    save::check(&args.output, &PictureOptions::default())?;
    let how = input::how(&args.synth, args.recipe.as_deref())?;
    let subject = how.open(&args.input, job)?;
    let Asked { scene, edit, settings } = asked(args).of(&subject, &how, &input::maker(&args.synth), job)?;
    Ok(export::write(&scene, &edit, &settings, &args.output, job)?)
}

/// The picture that the arguments ask for.
fn asked(args: &Refocus) -> asked::Refocus {
    asked::Refocus {
        lens: lens_args::asked(&args.lens),
        at: args.at.map(ViewOffset::from),
        size: args.size,
        quality: args.quality,
        bits: args.bits,
        strip_metadata: args.strip_metadata,
        replaces_source: args.force,
    }
}
