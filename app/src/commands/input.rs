//! What a command works on: a light field, made on the way where a photo comes in.

use std::path::Path;
use std::sync::Arc;

use anyhow::Result;
use plenoscope::field::{DisparityMap, LightField, Photo, RayDepths};
use plenoscope::io::formats::pfm;
use plenoscope::io::{self, EmbeddedDepth, LightFieldFile, Opened, PhotoFile};
use plenoscope::job::Job;
use plenoscope::synth::cache::Cache;
use plenoscope::synth::{
    DepthSource, ModelSource, ModelTag, SynthParams, Synthesis, Synthesizer, lift, sweep, synthesize_from_map,
};

use crate::cli::SynthArgs;

/// A light field and what it was made from.
pub struct Scene {
    pub field: Arc<LightField>,
    pub depths: Option<Arc<RayDepths>>,
    pub photo: Option<Arc<Photo>>,
    pub models: Vec<ModelTag>,
}

impl Scene {
    /// A light field as it was in its files.
    pub fn from_file(file: LightFieldFile) -> Self {
        let lifted = || {
            let map = file.reference_disparity.as_ref().filter(|map| map.size() == file.field.size())?;
            Some(Arc::new(lift::ray_depths(map, file.field.grid())))
        };
        let depths = file.depths.clone().or_else(lifted);
        Self { field: file.field, depths, photo: None, models: Vec::new() }
    }

    fn made(made: Synthesis, file: &PhotoFile) -> Self {
        let photo = Some(Arc::clone(&file.photo));
        Self { field: made.field, depths: Some(made.depths), photo, models: made.models }
    }

    /// The ray depths; a light field that came without gets them by plane sweep over its views.
    pub fn depths(&self, job: &Job) -> Result<Arc<RayDepths>> {
        match &self.depths {
            Some(depths) => Ok(Arc::clone(depths)),
            None => Ok(Arc::new(sweep::ray_depths(&self.field, job)?)),
        }
    }
}

/// Opens a file and passes its warnings on.
pub fn open(path: &Path, job: &Job) -> Result<Opened> {
    let opened = io::open(path, job)?;
    log::info!("opened {}", path.display());
    for warning in &opened.info().warnings {
        job.sink.warning(warning.clone());
    }
    Ok(opened)
}

/// Opens a photo or a light field, and makes a light field of a photo.
pub fn scene(path: &Path, args: &SynthArgs, job: &Job) -> Result<Scene> {
    match open(path, job)? {
        Opened::Photo(file) => from_photo(&file, args, job),
        Opened::LightField(file) => Ok(Scene::from_file(*file)),
    }
}

/// Makes a light field of a photo; without nets where neither ray depth nor occlusions need one.
pub fn from_photo(file: &PhotoFile, args: &SynthArgs, job: &Job) -> Result<Scene> {
    if let Some(map) = disparity(args)?.filter(|_| args.lambertian) {
        let made = synthesize_from_map(&file.photo, &map, &params(args, None)?, job)?;
        return Ok(Scene::made(made, file));
    }
    with_nets(&Synthesizer::load(&model_source(args))?, file, args, job)
}

/// Makes a light field of a photo with nets that are loaded already, or takes that of last time.
pub fn with_nets(nets: &Synthesizer, file: &PhotoFile, args: &SynthArgs, job: &Job) -> Result<Scene> {
    let params = params(args, file.depth.as_ref())?;
    let made = match Cache::user().filter(|_| !args.no_cache) {
        Some(cache) => nets.synthesize_cached(&file.photo, &params, &cache, job)?,
        None => nets.synthesize(&file.photo, &params, job)?,
    };
    log::info!("light field of {:?} in {:.2} s", made.field.size(), made.took.as_secs_f32());
    Ok(Scene::made(made, file))
}

/// The parameters that the arguments name.
fn params(args: &SynthArgs, phone: Option<&EmbeddedDepth>) -> Result<SynthParams> {
    Ok(SynthParams {
        long_side: args.long_side,
        occlusion: !args.lambertian,
        threads: args.threads.into(),
        disparity: disparity(args)?.map(Arc::new),
        source: match args.source.as_str() {
            "network" => DepthSource::Network,
            "phone" => DepthSource::Phone,
            "fused" => DepthSource::Fused,
            model => DepthSource::Model(model.to_owned()),
        },
        phone: phone.map(|depth| Arc::new(depth.map.clone())),
    })
}

/// The map that `--disparity` names.
pub fn disparity(args: &SynthArgs) -> Result<Option<DisparityMap>> {
    Ok(args.disparity.as_deref().map(pfm::read_pfm).transpose()?)
}

/// The folder of `--models`, or the nets in the program.
pub fn model_source(args: &SynthArgs) -> ModelSource {
    args.models.clone().map_or(ModelSource::Embedded, ModelSource::Folder)
}
