//! `refocus`: the picture that another lens would have taken.

use anyhow::Result;
use plenoscope::field::ViewOffset;
use plenoscope::io::save::{self, PictureOptions};
use plenoscope::job::Job;
use plenoscope::scene::asked::{self, Asked};
use plenoscope::scene::export;
use plenoscope::scene::real::{FORMATS, Reading};
use serde::Serialize;

use super::output::output;
use super::{input, lens_args};
use crate::cli::Refocus;
use crate::output::say_json;

/// Renders the picture and writes it.
pub fn run(args: &Refocus, job: &Job) -> Result<()> {
    output(&args.output, &args.input, args.force).check()?;
    save::check(&args.output, &PictureOptions::default())?;
    let how = input::how_of(&args.input, &args.synth, args.recipe.as_deref(), job)?;
    let subject = how.open(&args.input, job)?;
    let Asked { scene, edit, settings } = asked(args).of(&subject, &how, &input::maker(&args.synth), job)?;
    let width = scene.picture_size(settings.size())[0];
    let edit = lens_args::further(&args.lens, edit, &scene, width, job)?;
    export::write(&scene, &edit, &settings, &args.output, job)?;
    let reading = scene.reading(&edit, &FORMATS[args.sensor], width);
    log::info!("{}: {}", reading.title(), reading.lines().join(", "));
    if args.json { say_json(&Answer { f_number: edit.f_number.0, reading }) } else { Ok(()) }
}

/// What is printed: the slider's f-number, and the lens in numbers of a real one.
#[derive(Serialize)]
struct Answer {
    f_number: f32,
    #[serde(rename = "real_lens")]
    reading: Reading,
}

/// The picture that the arguments ask for.
fn asked(args: &Refocus) -> asked::Refocus {
    asked::Refocus {
        lens: lens_args::asked(&args.lens),
        at: args.at.map(ViewOffset::from),
        size: args.size,
        quality: args.quality,
        bits: args.bits,
        embed: args.embed.asked(),
        strip_metadata: args.strip_metadata,
        replaces_source: args.force,
    }
}
