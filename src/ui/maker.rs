//! From an open file to a light field with ray depths: the nets for a photo, plane sweep for views without depths.
//!
//! Where the nets are missing, a photo with a depth map of its own still becomes a light field: a Lambertian one.

use std::sync::Arc;
use std::time::Instant;

use super::document::{Document, Made};
use super::jobs::{Load, secs_since, sentence};
use super::state::Source;
use crate::field::{DisparityMap, LightField, Photo, ViewGrid};
use crate::job::{Job, Stage};
use crate::synth::{
    DepthSource, ModelSource, Signed, SynthParams, Synthesizer, lambertian, lift, reference_view, sweep, upsample,
};

/// Disparities that a phone's depth is spread over, in pixels per view step of its own width: the ratios of a flower
/// before its garden.
const PHONE_RANGE_PER_WIDTH: [f32; 2] = [-0.8 / 540.0, 1.0 / 540.0];

/// Keeps the nets between jobs.
pub struct Maker {
    models: ModelSource,
    threads: usize,
    nets: Option<Synthesizer>,
}

impl Maker {
    /// Nothing is loaded before the first photo.
    pub fn new(models: ModelSource, threads: usize) -> Self {
        Self { models, threads, nets: None }
    }

    /// Makes the light field of a document, or adds ray depths to one that came without.
    pub fn make(&mut self, document: &Document, load: &Load, job: &Job) -> Result<Made, String> {
        match (&document.photo, &document.field) {
            (Some(photo), _) => self.of_photo(photo, document, load, job),
            (None, Some(field)) => of_views(field, document, job),
            (None, None) => Err("nothing to make a light field of — the file is empty — open another".to_owned()),
        }
    }

    fn of_photo(&mut self, photo: &Photo, document: &Document, load: &Load, job: &Job) -> Result<Made, String> {
        let phone = document.phone.as_ref().map(|phone| {
            let width = phone.size[0] as f32;
            Arc::new(phone.disparity(PHONE_RANGE_PER_WIDTH.map(|per_width| per_width * width)))
        });
        if self.nets.is_none() {
            match Synthesizer::load(&self.models) {
                Ok(nets) => self.nets = Some(nets),
                Err(error) => {
                    let Some(map) = document.reference.clone().or(phone) else { return Err(sentence(&error)) };
                    job.sink.warning(format!("{} — the picture's own depth is used", sentence(&error)));
                    return without_nets(photo, &map, load.long_side, job);
                }
            }
        }
        let source = match (load.source, &phone) {
            (Source::Phone, Some(_)) => DepthSource::Phone,
            (Source::Fused, Some(_)) => DepthSource::Fused,
            _ => DepthSource::Network,
        };
        let params = SynthParams {
            long_side: load.long_side,
            occlusion: load.occlusion,
            threads: self.threads,
            disparity: None,
            source,
            phone,
        };
        let Some(nets) = &self.nets else { return Err("the nets are not there".to_owned()) };
        let made = nets.synthesize(photo, &params, job).map_err(|error| sentence(&error))?;
        let made_by = made.models.iter().map(|model| model.id.as_str()).collect::<Vec<_>>().join(" + ");
        Ok(Made { field: made.field, depths: Some(made.depths), made_by, took_secs: made.took.as_secs_f64() })
    }
}

/// A light field from disk: its own ray depths, those of its reference view lifted, or measured from its views.
fn of_views(field: &Arc<LightField>, document: &Document, job: &Job) -> Result<Made, String> {
    let start = Instant::now();
    let made_by = document.made_by.clone();
    if let Some(depths) = document.depths.clone() {
        return Ok(Made { field: Arc::clone(field), depths: Some(depths), made_by, took_secs: 0.0 });
    }
    let map = document.reference.as_ref().filter(|map| map.size == field.size());
    let depths = match map {
        Some(map) => lift::lifted(map, field.grid(), job),
        None => sweep::ray_depths(field, job),
    };
    let depths = Some(Arc::new(depths.map_err(|error| sentence(&error))?));
    Ok(Made { field: Arc::clone(field), depths, made_by, took_secs: secs_since(start) })
}

/// Lambertian views (paper, §3.2) of a photo whose depth is known.
fn without_nets(photo: &Photo, map: &DisparityMap, long_side: u32, job: &Job) -> Result<Made, String> {
    let start = Instant::now();
    let told = |error: &dyn std::error::Error| sentence(error);
    let grid = ViewGrid::PAPER;
    let reference = Arc::new(reference_view(photo, long_side).map_err(|error| told(&error))?);
    let map = upsample::to_guide(map, &reference);
    let depths = Arc::new(lift::lifted(&map, grid, job).map_err(|error| told(&error))?);
    job.sink.depths(&depths);
    let signed = Signed::from_view(&reference);
    let mut views = vec![Arc::clone(&reference); grid.count()];
    for (done, at) in (1..).zip(grid.spiral()) {
        let view = lambertian::render_view(&signed, depths.view(at), grid.offset(at)).map_err(|error| told(&error))?;
        let view = if at == grid.reference() { Arc::clone(&reference) } else { Arc::new(view) };
        job.sink.view(at, &view);
        views[grid.layer_from_view(at)] = view;
        job.advance(Stage::Warp, done, grid.count() as u32).map_err(|error| told(&error))?;
    }
    let field = Arc::new(LightField::new(grid, views).map_err(|error| told(&error))?);
    Ok(Made {
        field,
        depths: Some(depths),
        made_by: "the picture's own depth".to_owned(),
        took_secs: secs_since(start),
    })
}
