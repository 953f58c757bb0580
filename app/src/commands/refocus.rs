//! `refocus`: the picture that another lens would have taken.

use anyhow::{Result, bail};
use plenoscope::field::{ViewOffset, ViewPoint};
use plenoscope::io::save::{self, Keep, PictureOptions};
use plenoscope::job::Job;
use plenoscope::scene::export::{self, Kind, Settings};
use plenoscope::scene::recipe::PictureSettings;
use plenoscope::scene::{Edit, OutputSize, Recipe, Scene, Subject};

use super::output::Output;
use super::{Usage, input, lens_args};
use crate::cli::{Refocus, SynthArgs};
use crate::values::{Pair, PictureSize};

/// Renders the picture and writes it.
pub fn run(args: &Refocus, job: &Job) -> Result<()> {
    let output = Output { file: &args.output, input: &args.input, force: args.force };
    output.check()?;
    save::check(&args.output, &PictureOptions::default())?;
    let recipe = args.recipe.as_deref().map(Recipe::read).transpose()?;
    let subject = input::subject(&args.input, &args.synth, job)?;
    let settings = settings(args, recipe.as_ref(), &subject, job)?;
    let need = Kind::Picture.need(settings.size());
    // A map that is given spares all nets.
    let lambertian = args.synth.lambertian || args.synth.disparity.is_some();
    let making = input::making_with(&SynthArgs { lambertian, ..args.synth.clone() }, recipe.as_ref());
    let scene = input::maker(&args.synth).scene(&subject, &making, need, job)?;
    let edit = edit(args, recipe.as_ref(), &scene)?;
    Ok(export::write(&scene, &edit, &settings, &args.output, job)?)
}

/// The recipe's edit, and what the arguments change of it.
fn edit(args: &Refocus, recipe: Option<&Recipe>, scene: &Scene) -> Result<Edit> {
    let base = recipe.map_or_else(lens_args::plain, |recipe| recipe.edit(scene.map().size()[0]));
    let edit = lens_args::edit(&args.lens, base, scene)?;
    let viewpoint = args.at.map_or(edit.viewpoint, |Pair(du, dv)| ViewPoint(ViewOffset { dv, du }));
    Ok(Edit { viewpoint, ..edit })
}

/// How the picture is kept: as the recipe says, else with the photo's own bits.
fn settings(args: &Refocus, recipe: Option<&Recipe>, subject: &Subject, job: &Job) -> Result<Settings> {
    let bits = subject.photo().map_or(8, |photo| photo.pixels().bits());
    let plain = || PictureSettings { bits, ..PictureSettings::default() };
    let mut picture = recipe.map_or_else(plain, |recipe| recipe.export.clone());
    picture.bits = args.bits.unwrap_or(picture.bits);
    picture.quality = args.quality.unwrap_or(picture.quality);
    if args.strip_metadata {
        picture.keep = Keep::Nothing;
    }
    if let Some(size) = args.size {
        picture.size = output_size(size);
        told(size, subject.size(), job)?;
    }
    Ok(Settings { picture, replaces_source: args.force, ..Settings::default() })
}

/// The size that was typed.
pub fn output_size(size: PictureSize) -> OutputSize {
    match size {
        PictureSize::Photo => OutputSize::Photo,
        PictureSize::LightField => OutputSize::LightField,
        PictureSize::Custom(size) => OutputSize::Within(size.0),
    }
}

/// Nothing is enlarged, and a photo keeps its shape: the person is told where that changes what was typed.
fn told(size: PictureSize, photo: [u32; 2], job: &Job) -> Result<()> {
    let PictureSize::Custom(wanted) = size else { return Ok(()) };
    if wanted.0[0] > photo[0] || wanted.0[1] > photo[1] {
        let [width, height] = photo;
        bail!(Usage(format!(
            "the picture would be larger than the photo — nothing is enlarged — at most {width}x{height}"
        )));
    }
    let [width, height] = OutputSize::Within(wanted.0).of(photo);
    if [width, height] != wanted.0 {
        job.sink.warning(format!("the photo's shape is kept: the picture has {width}x{height} pixels"));
    }
    Ok(())
}
