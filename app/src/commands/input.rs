//! What a command works on: a scene, of which as much is made as the command needs.

use std::path::Path;
use std::sync::Arc;

use anyhow::Result;
use plenoscope::io::formats::depth_map::GivenDepth;
use plenoscope::io::formats::pfm;
use plenoscope::job::Job;
use plenoscope::scene::asked::How;
use plenoscope::scene::recipe::Presets;
use plenoscope::scene::{DepthFrom, Maker, Making, Need, Recipe, Restored, Scene};
use plenoscope::synth::ModelSource;
use plenoscope::synth::adopt::Shelf;
use plenoscope::synth::cache::Cache;
use plenoscope::synth::corners::CornerNets;

use crate::cli::{RecipeArgs, SynthArgs};

/// Opens a photo or a light field, and makes of it what is needed; its depth as the edit says, where one is named.
pub fn scene(path: &Path, args: &SynthArgs, edit: &RecipeArgs, need: Need, job: &Job) -> Result<Scene> {
    let how = how_of(path, args, edit.recipe.as_deref(), job)?;
    Ok(how.scene(&how.open(path, job)?, &maker(args), need, job)?)
}

/// What `--recipe` says for the edit that a picture carries.
const EMBEDDED: &str = "embedded";

/// As [`how`], for a picture that may carry its edit itself.
pub fn how_of(picture: &Path, args: &SynthArgs, recipe: Option<&Path>, job: &Job) -> Result<How> {
    match recipe {
        Some(recipe) if recipe == Path::new(EMBEDDED) => Ok(how(args, None)?.restored(Restored::open(picture, job)?)),
        recipe => how(args, recipe),
    }
}

/// How light fields are made, as the arguments name it, with the map of `--disparity` and the edit of `--recipe`.
pub fn how(args: &SynthArgs, recipe: Option<&Path>) -> Result<How> {
    let recipe = recipe.map(|path| Recipe::named(path, Presets::user().as_ref())).transpose()?;
    let own_map = args.disparity.as_deref().map(pfm::read_pfm).transpose()?;
    let making = Making {
        long_side: args.long_side,
        occlusion: !args.lambertian,
        threads: args.threads.into(),
        source: DepthFrom::named(&args.source),
        scale: args.depth_scale,
        models: model_source(args.models.as_deref()),
        shelf: Shelf::user(),
        strength: args.strength,
        ..Making::default()
    };
    Ok(How::new(making, own_map.map(|map| GivenDepth::Disparity(Arc::new(map))), recipe))
}

/// The nets between four corners that `--source` names: of the folder of `--models`, or among one's own.
pub fn corner_nets(args: &SynthArgs) -> Result<Option<CornerNets>> {
    if DepthFrom::named(&args.source) == DepthFrom::Auto {
        return Ok(None);
    }
    let sources: Vec<ModelSource> =
        [model_source(args.models.as_deref())].into_iter().chain(Shelf::user().map(|shelf| shelf.source())).collect();
    Ok(Some(CornerNets::named(&args.source, &sources, args.threads.into())?))
}

/// Makes scenes, with the user's cache unless the arguments say otherwise.
pub fn maker(args: &SynthArgs) -> Maker {
    Maker::new(Cache::user().filter(|_| !args.no_cache))
}

/// The folder of `--models`, or the nets in the program.
pub fn model_source(folder: Option<&Path>) -> ModelSource {
    folder.map_or(ModelSource::Embedded, |folder| ModelSource::Folder(folder.to_owned()))
}
