//! `synth` and `export`: everything that a light field can become.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::Result;
use plenoscope::field::FNumber;
use plenoscope::job::Job;
use plenoscope::scene::asked::{self, How, Usage};
use plenoscope::scene::export::{self, Group, Kind, Settings};
use plenoscope::scene::recipe::PictureSettings;
use plenoscope::scene::{Edit, Embed, Movement, Subject};

use super::output::output;
use super::{input, lens_args};
use crate::cli::{Export, Synth};

/// Makes a light field of a photo, or of the four at its corners, and writes it.
pub fn synth(args: &Synth, job: &Job) -> Result<()> {
    let how = input::how(&args.synth, args.recipe.recipe.as_deref())?;
    let (subject, source) = match (&args.photo, args.corners.as_slice()) {
        (Some(photo), _) => (how.open(photo, job)?, photo),
        (None, [a, b, c, d]) => {
            let nets = input::corner_nets(&args.synth)?;
            let photos = [a, b, c, d].map(PathBuf::as_path);
            (Arc::new(Subject::between(photos, args.synth.long_side, nets.as_ref(), job)?), a)
        }
        (None, _) => return Err(Usage("name one photo, or four with --corners".to_owned()).into()),
    };
    if args.photo.is_some() {
        asked::check_is_photo(&subject)?;
    }
    let settings = Settings { kind: args.format, ..Settings::default() };
    let target = target(&args.output, &settings, source);
    output(&target, source, false).check_written(args.format)?;
    let scene = how.scene(&subject, &input::maker(&args.synth), args.format.need(settings.size()), job)?;
    asked::make_folder(&target)?;
    Ok(export::write(&scene, &Edit::default(), &settings, &target, job)?)
}

/// Opens, makes what is needed, and writes.
pub fn run(args: &Export, job: &Job) -> Result<()> {
    let how = input::how_of(&args.input, &args.synth, args.recipe.recipe.as_deref(), job)?;
    let settings = settings(args, &how)?;
    let target = target(&args.output, &settings, &args.input);
    output(&target, &args.input, args.force).check_written(args.kind)?;
    let subject = how.open(&args.input, job)?;
    let scene = how.scene(&subject, &input::maker(&args.synth), args.kind.need(settings.size()), job)?;
    let edit = how.edit(&lens_args::asked(&args.lens), &scene)?;
    let edit = lens_args::further(&args.lens, edit, &scene, scene.picture_size(settings.size())[0], job)?;
    let is_named = args.lens.f_number.is_some() || args.lens.as_lens.is_some() || how.recipe().is_some();
    let edit = match (args.kind, is_named) {
        (Kind::Animation | Kind::Video | Kind::Frames, false) => {
            Edit { f_number: settings.movement.usual_f_number(), ..edit }
        }
        (kind, false) if kind.is_of_eyes() => Edit { f_number: FNumber::PHOTO, ..edit },
        _ => edit,
    };
    if args.kind.spec().group == Group::LightField {
        asked::make_folder(&target)?;
    }
    Ok(export::write(&scene, &edit, &settings, &target, job)?)
}

fn settings(args: &Export, how: &How) -> Result<Settings> {
    let timeline = how.recipe().and_then(|recipe| recipe.timeline.as_ref());
    let embed = args.embed.asked().unwrap_or_default();
    if args.kind != Kind::Picture && embed != Embed::default() {
        return Err(
            Usage("--embed is for --as picture — other files have no room for it — leave it out".to_owned()).into()
        );
    }
    if args.kind == Kind::FocalStack && args.frames.is_some_and(|frames| frames > Settings::MOST_PICTURES) {
        let most = Settings::MOST_PICTURES;
        return Err(Usage(format!("a focal stack has at most {most} pictures — ask for fewer with --frames")).into());
    }
    let usual = if timeline.is_some() { Movement::Timeline } else { Movement::default() };
    let mut settings = Settings {
        kind: args.kind,
        picture: PictureSettings { embed, ..PictureSettings::default() },
        recipe: how.edited(),
        frames: args.frames.unwrap_or(Settings::FRAMES),
        frames_per_second: args.frames_per_second.unwrap_or(Settings::FRAMES_PER_SECOND),
        movement: args.motion.unwrap_or(usual),
        timeline: timeline.cloned(),
        eyes_apart: args.stereo.eyes_apart,
        device: args.stereo.display,
        replaces_source: args.force,
        ..Settings::default()
    };
    if let Some(size) = args.size {
        settings.picture.size = size;
        settings.animation_size = settings.picture.size;
        settings.film.size = size;
    }
    let film = &mut settings.film;
    film.frames_per_second = args.frames_per_second.unwrap_or(film.frames_per_second);
    (film.frames, film.is_cut) = (args.frames.unwrap_or(film.frames), args.frames.is_some());
    Ok(settings)
}

/// Where it is written, named after the input.
pub(super) fn target(output: &Path, settings: &Settings, input: &Path) -> PathBuf {
    let name = input.file_name().map_or_else(|| "photo".to_owned(), |name| name.to_string_lossy().into_owned());
    asked::field_target(output, settings, &name)
}
