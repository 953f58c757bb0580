//! `synth` and `export`: everything that a light field can become.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use plenoscope::aside;
use plenoscope::io::save::SaveError;
use plenoscope::job::Job;
use plenoscope::scene::Edit;
use plenoscope::scene::export::{self, Group, Kind, Settings};
use plenoscope::scene::recipe::PictureSettings;

use super::output::Output;
use super::{input, lens_args, refocus};
use crate::cli::{Export, Synth};

/// Makes a light field of a photo and writes it.
pub fn synth(args: &Synth, job: &Job) -> Result<()> {
    let subject = input::subject(&args.photo, &args.synth, job)?;
    if subject.photo().is_none() {
        bail!(
            "this is a light field already — synth takes a photo — use `plenoscope export`: {}",
            args.photo.display()
        );
    }
    let settings = Settings { kind: args.format, ..Settings::default() };
    let target = target(&args.output, &settings, &args.photo);
    Output { file: &target, input: &args.photo, force: false }.check_written(args.format)?;
    let making = input::making_with(&args.synth, input::recipe(&args.recipe)?.as_ref());
    let scene = input::maker(&args.synth).scene(&subject, &making, args.format.need(settings.size()), job)?;
    make_folder(&target)?;
    Ok(export::write(&scene, &Edit::default(), &settings, &target, job)?)
}

/// Opens, makes what is needed, and writes.
pub fn run(args: &Export, job: &Job) -> Result<()> {
    let settings = settings(args);
    let target = target(&args.output, &settings, &args.input);
    Output { file: &target, input: &args.input, force: args.force }.check_written(args.kind)?;
    let scene = input::scene(&args.input, &args.synth, &args.recipe, args.kind.need(settings.size()), job)?;
    let recipe = input::recipe(&args.recipe)?;
    let base = recipe.map_or_else(lens_args::plain, |recipe| recipe.edit(scene.map().size()[0]));
    let edit = lens_args::edit(&args.lens, base, &scene)?;
    let edit = match (args.kind, args.lens.f_number, &args.recipe.recipe) {
        (Kind::Animation, None, None) => Edit { f_number: args.motion.usual_f_number(), ..edit },
        _ => edit,
    };
    if args.kind.spec().group == Group::LightField {
        make_folder(&target)?;
    }
    Ok(export::write(&scene, &edit, &settings, &target, job)?)
}

fn settings(args: &Export) -> Settings {
    let mut settings = Settings {
        kind: args.kind,
        picture: PictureSettings::default(),
        frames: args.frames,
        frames_per_second: args.frames_per_second,
        movement: args.motion,
        eyes_apart: args.eyes_apart,
        replaces_source: args.force,
        ..Settings::default()
    };
    if let Some(size) = args.size {
        settings.picture.size = refocus::output_size(size);
        settings.animation_size = settings.picture.size;
    }
    settings
}

/// Where it is written: formats of one file go into a folder that is named, under the name that readers know.
fn target(output: &Path, settings: &Settings, input: &Path) -> PathBuf {
    let is_file = output.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("png"));
    let name = input.file_name().map_or_else(|| "photo".to_owned(), |name| name.to_string_lossy().into_owned());
    match settings.kind {
        Kind::Eslf if !is_file => output.join(settings.file_name(&name, &Edit::default())),
        Kind::Quilt if is_file => settings.device().path(output),
        Kind::Quilt => output.join(settings.file_name(&name, &Edit::default())),
        _ => output.to_owned(),
    }
}

/// Light fields may go into a folder that is not there yet.
fn make_folder(target: &Path) -> Result<()> {
    let folder = aside::parent(target);
    std::fs::create_dir_all(folder).map_err(|error| SaveError::from_io(&error, folder).into())
}
