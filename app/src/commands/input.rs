//! What a command works on: a scene, of which as much is made as the command needs.

use std::path::Path;
use std::sync::Arc;

use anyhow::Result;
use plenoscope::io::formats::depth_map::GivenDepth;
use plenoscope::io::formats::pfm;
use plenoscope::job::Job;
use plenoscope::scene::{DepthFrom, Maker, Making, Need, Recipe, Scene, Subject};
use plenoscope::synth::ModelSource;
use plenoscope::synth::adopt::Shelf;
use plenoscope::synth::cache::Cache;

use crate::cli::{RecipeArgs, SynthArgs};

/// Opens a photo or a light field; a photo with the map of `--disparity`.
pub fn subject(path: &Path, args: &SynthArgs, job: &Job) -> Result<Arc<Subject>> {
    let subject = Subject::open(path, job)?;
    Ok(Arc::new(match own_map(args)? {
        Some(map) => subject.with_own_map(map),
        None => subject,
    }))
}

/// The map that `--disparity` names.
pub fn own_map(args: &SynthArgs) -> Result<Option<GivenDepth>> {
    let map = args.disparity.as_deref().map(pfm::read_pfm).transpose()?;
    Ok(map.map(|map| GivenDepth::Disparity(Arc::new(map))))
}

/// Opens a photo or a light field, and makes of it what is needed; its depth as the edit says, where one is named.
pub fn scene(path: &Path, args: &SynthArgs, edit: &RecipeArgs, need: Need, job: &Job) -> Result<Scene> {
    let making = making_with(args, recipe(edit)?.as_ref());
    Ok(maker(args).scene(&subject(path, args, job)?, &making, need, job)?)
}

/// The edit that is named.
pub fn recipe(args: &RecipeArgs) -> Result<Option<Recipe>> {
    Ok(args.recipe.as_deref().map(Recipe::read).transpose()?)
}

/// How light fields are made, as the arguments name it and the edit says it.
pub fn making_with(args: &SynthArgs, recipe: Option<&Recipe>) -> Making {
    let making = making(args);
    recipe.map_or_else(|| making.clone(), |recipe| making.with_recipe(recipe))
}

/// How light fields are made, as the arguments name it.
pub fn making(args: &SynthArgs) -> Making {
    let source = if args.disparity.is_some() { DepthFrom::Map } else { DepthFrom::named(&args.source) };
    Making {
        long_side: args.long_side,
        occlusion: !args.lambertian,
        threads: args.threads.into(),
        source,
        scale: args.scale,
        models: model_source(args.models.as_deref()),
        shelf: Shelf::user(),
        ..Making::default()
    }
}

/// Makes scenes, with the user's cache unless the arguments say otherwise.
pub fn maker(args: &SynthArgs) -> Maker {
    Maker::new(Cache::user().filter(|_| !args.no_cache))
}

/// The folder of `--models`, or the nets in the program.
pub fn model_source(folder: Option<&Path>) -> ModelSource {
    folder.map_or(ModelSource::Embedded, |folder| ModelSource::Folder(folder.to_owned()))
}
