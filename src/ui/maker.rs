//! From an open file to a light field with ray depths: the nets for a photo, plane sweep for views without depths.
//!
//! Where the nets are missing, a photo with a depth map of its own still becomes a light field: a Lambertian one.

use std::sync::Arc;
use std::time::Instant;

use super::document::{Document, Made, Survey};
use super::jobs::{Load, secs_since};
use super::state::Source;
use crate::errors::sentence;
use crate::field::{DisparityMap, LightField, Photo, RelativeDepth};
use crate::io::formats::depth_map::GivenDepth;
use crate::job::Job;
use crate::synth::{
    DepthSource, ModelSource, SynthError, SynthParams, Synthesizer, fuse, lift, reference_view, sweep,
    synthesize_from_map, upsample,
};

/// A correlation beyond this tells near from far. Of nine light fields of known sign it tells five, none of them wrongly.
const TELLS: f32 = 0.5;

/// Keeps the nets between jobs.
pub struct Maker {
    threads: usize,
    nets: Option<(ModelSource, Synthesizer)>,
}

impl Maker {
    /// Nothing is loaded before the first photo.
    pub fn new(threads: usize) -> Self {
        Self { threads, nets: None }
    }

    /// Makes the light field of a document, or adds ray depths to one that came without.
    pub fn make(&mut self, document: &Document, load: &Load, job: &Job) -> Result<Made, String> {
        let made = match (&document.photo, &document.field) {
            (Some(photo), _) => self.of_photo(photo, document, load, job),
            (None, Some(field)) => {
                let made = of_views(field, document, job)?;
                if document.depths.is_none() && document.reference.is_none() {
                    self.doubt_sign(&made, &load.models, job);
                }
                Ok(made)
            }
            (None, None) => Err("nothing to make a light field of — the file is empty — open another".to_owned()),
        }?;
        let survey = made.depths.as_deref().map(|depths| Arc::new(Survey::new(depths)));
        Ok(Made { survey, ..made })
    }

    fn of_photo(&mut self, photo: &Photo, document: &Document, load: &Load, job: &Job) -> Result<Made, String> {
        let phone = document.phone.as_ref().map(|phone| Arc::new(phone.map.clone()));
        let params = self.params(document, phone, load, job);
        if let Err(error) = self.load(&load.models) {
            let of_phone = || params.phone.as_ref().map(|phone| Arc::new(phone.disparity()));
            let known = params.disparity.clone().or_else(|| document.reference.clone()).or_else(of_phone);
            let Some(map) = known else { return Err(error) };
            job.sink.warning(format!("{error} — the picture's own depth is used"));
            return without_nets(photo, &map, document, load.long_side, job);
        }
        let Some((_, nets)) = &self.nets else { return Err("the nets are not there".to_owned()) };
        let made = nets.synthesize(photo, &params, job).map_err(|error| sentence(&error))?;
        let mut made_by: Vec<&str> = made.models.iter().map(|model| model.id.as_str()).collect();
        match &params.source {
            _ if params.disparity.is_some() => made_by.insert(0, "your map"),
            DepthSource::Phone if document.own_map.is_some() && load.source == Source::Map => {
                made_by.insert(0, "your map");
            }
            DepthSource::Phone => made_by.insert(0, "phone"),
            DepthSource::Fused => made_by.insert(0, "phone"),
            DepthSource::Model(_) | DepthSource::Network => {}
        }
        Ok(Made {
            field: made.field,
            depths: Some(made.depths),
            survey: None,
            made_by: made_by.join(" + "),
            took_secs: made.took.as_secs_f64(),
            of: Box::new(document.clone()),
        })
    }

    /// Colours cannot tell near from far (see [`Layout`](crate::io::formats::layout::Layout)); the depth net has a guess.
    fn doubt_sign(&mut self, made: &Made, models: &ModelSource, job: &Job) {
        let (Ok(()), Some(depths)) = (self.load(models), &made.depths) else { return };
        let Some((_, nets)) = &self.nets else { return };
        let params = SynthParams { threads: self.threads, ..SynthParams::default() };
        let Ok(guess) = nets.working_scale_depth(made.field.reference(), &params, job) else { return };
        let measured = depths.reference_map();
        if fuse::agreement(&guess, &measured) < -TELLS {
            job.sink.warning(
                "What looks near to the depth net lies far in these views: if it is near, turn on “Exchange near and far”"
                    .to_owned(),
            );
        }
    }

    fn load(&mut self, models: &ModelSource) -> Result<(), String> {
        if self.nets.as_ref().is_none_or(|(have, _)| have != models) {
            self.nets = None;
            let nets = Synthesizer::load(models).map_err(|error| sentence(&error))?;
            self.nets = Some((models.clone(), nets));
        }
        Ok(())
    }

    /// What the synthesis is asked for; a source that this photo or these models have not is the network.
    fn params(&self, document: &Document, phone: Option<Arc<RelativeDepth>>, load: &Load, job: &Job) -> SynthParams {
        let base = SynthParams {
            long_side: load.long_side,
            occlusion: load.occlusion,
            threads: self.threads,
            disparity: None,
            source: DepthSource::Network,
            phone,
        };
        match (&load.source, &document.own_map) {
            (Source::Phone, _) if base.phone.is_some() => SynthParams { source: DepthSource::Phone, ..base },
            (Source::Fused, _) if base.phone.is_some() => SynthParams { source: DepthSource::Fused, ..base },
            (Source::Map, Some(GivenDepth::Disparity(map))) => SynthParams { disparity: Some(Arc::clone(map)), ..base },
            (Source::Map, Some(GivenDepth::Order(map))) => {
                SynthParams { source: DepthSource::Phone, phone: Some(Arc::clone(map)), ..base }
            }
            (Source::Model(id), _) if load.models.further_models().contains(id) => {
                SynthParams { source: DepthSource::Model(id.clone()), ..base }
            }
            (Source::Model(id), _) => {
                job.sink.warning(format!("The model {id} is not in the models folder, so the network is used"));
                base
            }
            _ => base,
        }
    }
}

/// A light field from disk: its own ray depths, those of its reference view lifted, or measured from its views.
fn of_views(field: &Arc<LightField>, document: &Document, job: &Job) -> Result<Made, String> {
    let start = Instant::now();
    let made_by = document.made_by.clone();
    if let Some(depths) = document.depths.clone() {
        let of = Box::new(document.clone());
        return Ok(Made { field: Arc::clone(field), depths: Some(depths), survey: None, made_by, took_secs: 0.0, of });
    }
    let map = document.reference.as_ref().filter(|map| map.size() == field.size());
    let depths = match map {
        Some(map) => lift::lifted(map, field.grid(), job).map_err(SynthError::from),
        None => sweep::ray_depths(field, job),
    };
    let depths = Some(Arc::new(depths.map_err(|error| sentence(&error))?));
    let of = Box::new(document.clone());
    Ok(Made { field: Arc::clone(field), depths, survey: None, made_by, took_secs: secs_since(start), of })
}

/// Lambertian views (paper, §3.2) of a photo whose depth is known.
fn without_nets(
    photo: &Photo,
    map: &DisparityMap,
    document: &Document,
    long_side: u32,
    job: &Job,
) -> Result<Made, String> {
    let params = SynthParams { long_side, ..SynthParams::default() };
    let reference = reference_view(photo, long_side, job).map_err(|error| sentence(&error))?;
    let map = upsample::to_guide(map, &reference, job).map_err(|error| sentence(&error))?;
    let made = synthesize_from_map(photo, &map, &params, job).map_err(|error| sentence(&error))?;
    Ok(Made {
        field: made.field,
        depths: Some(made.depths),
        survey: None,
        made_by: "the picture's own depth".to_owned(),
        took_secs: made.took.as_secs_f64(),
        of: Box::new(document.clone()),
    })
}
