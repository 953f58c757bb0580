//! The order of the stages: photo → ray depths → Lambertian views → corrected views, streamed as they come.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use rayon::prelude::*;

use super::adopt::Shelf;
use super::depth::{DepthNet, NetDepths};
use super::far_side::FarSide;
use super::occlusion::OcclusionNet;
use super::picture::{Signed, reference_view};
use super::range::{Estimate, Geometry, Metric};
use super::relative::RelativeNet;
use super::{
    DepthSource, Manifest, ModelError, ModelSource, ModelTag, RayDepthsFrom, RelativeOutput, Scale, SynthError,
    SynthParams, Synthesis, Task,
};
use super::{fuse, lambertian, lift, memory, tract, upsample};
use crate::field::{
    DisparityMap, Filter, LightField, Photo, RayDepths, Size, View, ViewGrid, ViewIndex, disparity_scale,
    fit_long_side, nearest, pixels, resample,
};
use crate::job::{Job, Stage};

/// Long side above which the occlusion net's residual is computed small and enlarged.
const OCCLUSION_LONG_SIDE: u32 = 540;

/// Views and the disparity of every ray.
pub(super) type Made = (Arc<LightField>, Arc<RayDepths>);

/// Makes light fields from photos. Keeps its nets warm between photos of one size.
pub struct Synthesizer {
    /// Where further models are looked for, in this order.
    sources: Vec<ModelSource>,
    depth: DepthNet,
    occlusion: Option<OcclusionNet>,
    /// The further model that was asked for last, by its name.
    further: Mutex<Option<(String, Arc<Further>)>>,
}

/// What is known of the reference view.
struct Reference {
    /// Its disparity.
    map: DisparityMap,
    /// The net's maps of all views, where its manifest wants those.
    net: Option<NetDepths>,
    /// Metres, where the source has them.
    metric: Option<Metric>,
}

/// A depth net that is asked for by its name.
enum Further {
    /// One of ours, with a map for every view.
    Ray(DepthNet),
    /// Anybody's.
    Relative(RelativeNet),
}

impl Further {
    fn manifest(&self) -> &Manifest {
        match self {
            Self::Ray(net) => net.net().manifest(),
            Self::Relative(net) => net.net().manifest(),
        }
    }
}

impl Synthesizer {
    /// Loads and checks the pair of nets that a source names; a folder of relative-depth models alone leaves the
    /// program's own pair in use.
    pub fn load(source: &ModelSource) -> Result<Self, ModelError> {
        let pair = source.for_pair();
        let index = pair.index()?;
        let depth = DepthNet::load(pair.model(&index.depth, Task::RayDepth)?)?;
        let occlusion = match &index.occlusion {
            Some(id) => Some(OcclusionNet::load(pair.model(id, Task::Occlusion)?, depth.grid())?),
            None => None,
        };
        Ok(Self { sources: vec![source.clone()], depth, occlusion, further: Mutex::default() })
    }

    /// With the nets that a person added beside those of the source.
    #[must_use]
    pub fn with_shelf(mut self, shelf: Option<&Shelf>) -> Self {
        self.sources.extend(shelf.map(Shelf::source));
        self
    }

    /// Rows and columns of the views that it makes.
    pub fn grid(&self) -> ViewGrid {
        self.depth.grid()
    }

    /// Name and checksum of the models that take part in a synthesis with these parameters.
    pub fn models(&self, params: &SynthParams) -> Vec<ModelTag> {
        self.manifests(params).iter().map(Manifest::tag).collect()
    }

    /// Manifests of the models that take part in a synthesis with these parameters.
    pub(super) fn manifests(&self, params: &SynthParams) -> Vec<Manifest> {
        let own = || self.depth.net().manifest().clone();
        let depth = match &params.source {
            _ if params.disparity.is_some() => None,
            DepthSource::Network | DepthSource::Fused => Some(own()),
            // One that cannot be read is told of when it is to run.
            DepthSource::Model(id) => self.further(id).ok().map(|net| net.manifest().clone()),
            DepthSource::Phone => params.phone.is_none().then(own),
        };
        let occlusion = self.occlusion.as_ref().filter(|_| params.occlusion).map(|net| net.net().manifest().clone());
        depth.into_iter().chain(occlusion).collect()
    }

    /// The depth net's own map of the reference view, at its working scale and in pixels of that width.
    pub fn working_scale_depth(
        &self,
        reference: &View,
        params: &SynthParams,
        job: &Job,
    ) -> Result<DisparityMap, SynthError> {
        self.depth.reference(reference, params.threads, job)
    }

    /// Makes a light field. The sink hears of ray depths, then of Lambertian views from the middle outward, then of
    /// corrected ones.
    pub fn synthesize(&self, photo: &Photo, params: &SynthParams, job: &Job) -> Result<Synthesis, SynthError> {
        let started = Instant::now();
        let size = fit_long_side(photo.size(), params.long_side.max(1));
        memory::check(size, self.grid())?;
        let pool = tract::pool(params.threads).map_err(|error| SynthError::Threads(error.to_string()))?;
        let ((field, depths), metric) = pool.install(|| self.stages(photo, params, job))?;
        Ok(Synthesis { field, depths, metric, models: self.models(params), took: started.elapsed() })
    }

    /// Makes the disparity of the reference view alone, at the size of the views: what one picture needs.
    pub(super) fn reference_map_of(
        &self,
        photo: &Photo,
        params: &SynthParams,
        job: &Job,
    ) -> Result<(DisparityMap, Option<Metric>), SynthError> {
        job.advance(Stage::Depth, 0, 3)?;
        let reference = reference_view(photo, params.long_side, job)?;
        let known = self.reference_map(photo, &reference, params, job)?;
        job.advance(Stage::Depth, 3, 3)?;
        Ok((known.map, known.metric))
    }

    fn stages(&self, photo: &Photo, params: &SynthParams, job: &Job) -> Result<(Made, Option<Metric>), SynthError> {
        job.advance(Stage::Depth, 0, 3)?;
        let reference = Arc::new(reference_view(photo, params.long_side, job)?);
        job.sink.view(self.grid().reference(), &reference);
        let known = self.reference_map(photo, &reference, params, job)?;
        let metric = known.metric;
        let depths = Arc::new(self.ray_depths(known, job)?);
        job.advance(Stage::Depth, 3, 3)?;
        job.sink.depths(&depths);
        let signed = Signed::from_view(&reference);
        let mut views = lambertian_views(&reference, &signed, &depths, job)?;
        if let Some(net) = self.occlusion.as_ref().filter(|_| params.occlusion) {
            correct(net, &reference, &signed, &depths, params.threads, job, &mut views)?;
        }
        Ok(((Arc::new(LightField::new(self.grid(), views)?), depths), metric))
    }

    /// The disparity of every ray.
    fn ray_depths(&self, known: Reference, job: &Job) -> Result<RayDepths, SynthError> {
        match known {
            Reference { map, net: Some(net), .. } => all_maps(&net, map),
            Reference { map, net: None, .. } => Ok(lift::lifted(&map, self.grid(), job)?),
        }
    }

    /// What is known of the reference view on the scale that is asked for; the net's maps of all views where its manifest
    /// wants those and they are on that scale.
    fn reference_map(
        &self,
        photo: &Photo,
        reference: &View,
        params: &SynthParams,
        job: &Job,
    ) -> Result<Reference, SynthError> {
        let made = self.source_map(photo, reference, params, job)?;
        if params.scale == Scale::Deep || self.has_a_scale(params)? {
            return Ok(made);
        }
        Ok(Reference { map: params.scale.of(made.map)?, net: None, metric: None })
    }

    /// Whether the source of depth says how far it reaches: a map of the person's own, or metres.
    fn has_a_scale(&self, params: &SynthParams) -> Result<bool, ModelError> {
        let in_metres = |phone: &Estimate| matches!(phone.geometry, Geometry::Metric { .. });
        Ok(match &params.source {
            _ if params.disparity.is_some() => true,
            DepthSource::Phone => params.phone.as_deref().is_some_and(in_metres),
            DepthSource::Model(id) => match &*self.further(id)? {
                Further::Ray(_) => false,
                Further::Relative(net) => net.net().manifest().relative.output == RelativeOutput::Metres,
            },
            DepthSource::Network | DepthSource::Fused => false,
        })
    }

    /// What is known of the reference view as its source has it.
    fn source_map(
        &self,
        photo: &Photo,
        reference: &View,
        params: &SynthParams,
        job: &Job,
    ) -> Result<Reference, SynthError> {
        if let Some(map) = &params.disparity {
            return Ok(Reference { map: map.resized(reference.size())?, net: None, metric: None });
        }
        let threads = params.threads;
        let measured = |phone: &Estimate| phone.disparity(&params.camera, None);
        let (map, metric) = match (&params.source, &params.phone) {
            (DepthSource::Model(id), _) => match &*self.further(id)? {
                Further::Ray(net) => return refined(net, reference, threads, job),
                Further::Relative(net) => net.estimate(photo, reference, params, job)?,
            },
            (DepthSource::Phone, Some(phone)) => {
                let map = upsample::to_guide(&measured(phone)?, reference, job)?;
                (map, phone.metric_scale(&params.camera, None))
            }
            (DepthSource::Fused, Some(phone)) => {
                let net = self.depth.reference(reference, threads, job)?;
                (fuse::fuse(&net, &measured(phone)?, reference, job)?, None)
            }
            (source, _) => {
                if *source != DepthSource::Network {
                    job.sink.warning("This photo has no depth of its own, so the network's is used".to_owned());
                }
                return refined(&self.depth, reference, threads, job);
            }
        };
        Ok(Reference { map, net: None, metric })
    }

    /// A further model by its name, kept for the next photo.
    fn further(&self, id: &str) -> Result<Arc<Further>, ModelError> {
        let mut kept = self.further.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, net)) = kept.as_ref().filter(|(name, _)| name == id) {
            return Ok(Arc::clone(net));
        }
        let file = self.sources.iter().find_map(|source| source.further_model(id));
        let file = file.unwrap_or_else(|| Err(self.no_source(id)))?;
        let net = match file.manifest.task {
            Task::RayDepth => {
                file.check_grid(self.grid())?;
                Further::Ray(DepthNet::load(file)?)
            }
            _ => Further::Relative(RelativeNet::new(file)),
        };
        let net = Arc::new(net);
        *kept = Some((id.to_owned(), Arc::clone(&net)));
        Ok(net)
    }
}

impl Synthesizer {
    /// Whether a further model can be used.
    ///
    /// # Errors
    /// There is none of that name, or what is wrong with it.
    pub fn check(&self, id: &str) -> Result<(), ModelError> {
        self.further(id).map(|_| ())
    }

    /// The name that a further model has here, by its checksum: its own where that is free to choose; none where it is
    /// not here.
    pub fn name_of(&self, wanted: &ModelTag) -> Option<String> {
        let tags = self.sources.iter().flat_map(ModelSource::further_tags);
        let same: Vec<ModelTag> = tags.filter(|tag| tag.sha256 == wanted.sha256).collect();
        same.iter().find(|tag| tag.id == wanted.id).or(same.first()).map(|tag| tag.id.clone())
    }

    fn no_source(&self, id: &str) -> ModelError {
        let further = self.sources.iter().flat_map(ModelSource::further_models);
        let known: Vec<_> = ["network", "phone", "fused"].map(str::to_owned).into_iter().chain(further).collect();
        ModelError::NoSource { name: id.to_owned(), known: known.join(", ") }
    }
}

/// A ray-depth net's map of the reference view, its edges brought to the photo's.
fn refined(depth: &DepthNet, reference: &View, threads: usize, job: &Job) -> Result<Reference, SynthError> {
    let (map, net) = match depth.net().manifest().ray_depths {
        RayDepthsFrom::Lift => (depth.reference(reference, threads, job)?, None),
        RayDepthsFrom::Net => {
            let net = depth.estimate(reference, threads, job)?;
            (net.reference()?, Some(net))
        }
    };
    job.advance(Stage::Depth, 1, 3)?;
    let knows_edges = depth.sees_all_of(reference.size());
    let map = if knows_edges { upsample::to_guide } else { upsample::net_to_guide }(&map, reference, job)?;
    job.advance(Stage::Depth, 2, 3)?;
    Ok(Reference { map, net, metric: None })
}

/// Makes a light field of a photo whose ray depth is known: Lambertian views on the paper's grid, without any net.
///
/// # Errors
/// [`SynthError`]; never [`SynthError::Model`].
pub fn synthesize_from_map(
    photo: &Photo,
    map: &DisparityMap,
    params: &SynthParams,
    job: &Job,
) -> Result<Synthesis, SynthError> {
    of_map(photo, map, params, job, lambertian_views)
}

/// As [`synthesize_from_map`]; where rays end behind what the photo sees, the far side goes on.
///
/// # Errors
/// As [`synthesize_from_map`].
pub fn synthesize_bared(
    photo: &Photo,
    map: &DisparityMap,
    params: &SynthParams,
    job: &Job,
) -> Result<Synthesis, SynthError> {
    of_map(photo, map, params, job, bared_views)
}

/// Makes all views of a reference view, its colours, and the disparity of every ray.
type Render = fn(&Arc<View>, &Signed, &RayDepths, &Job) -> Result<Vec<Arc<View>>, SynthError>;

fn of_map(
    photo: &Photo,
    map: &DisparityMap,
    params: &SynthParams,
    job: &Job,
    render: Render,
) -> Result<Synthesis, SynthError> {
    let started = Instant::now();
    memory::check(fit_long_side(photo.size(), params.long_side.max(1)), ViewGrid::PAPER)?;
    let pool = tract::pool(params.threads).map_err(|error| SynthError::Threads(error.to_string()))?;
    let (field, depths) = pool.install(|| -> Result<_, SynthError> {
        job.advance(Stage::Depth, 0, 1)?;
        let reference = Arc::new(reference_view(photo, params.long_side, job)?);
        let depths = Arc::new(lift::lifted(&map.resized(reference.size())?, ViewGrid::PAPER, job)?);
        job.sink.depths(&depths);
        let views = render(&reference, &Signed::from_view(&reference), &depths, job)?;
        Ok((Arc::new(LightField::new(ViewGrid::PAPER, views)?), depths))
    })?;
    Ok(Synthesis { field, depths, metric: None, models: Vec::new(), took: started.elapsed() })
}

/// The net's own maps at the size of the views; the reference view's is the refined one.
fn all_maps(net: &NetDepths, refined: DisparityMap) -> Result<RayDepths, SynthError> {
    let ratio = disparity_scale(net.size, refined.size());
    let own = net.grid.layer_from_view(net.grid.reference());
    let layer = |layer: usize| match layer == own {
        true => refined.disparity_px().to_vec(),
        false => {
            let map = resample::<1>(net.layer(layer), net.size, refined.size(), Filter::Linear);
            map.into_iter().map(|d| d * ratio).collect()
        }
    };
    let maps: Vec<f32> = (0..net.grid.count()).into_par_iter().flat_map_iter(layer).collect();
    Ok(RayDepths::new(net.grid, refined.size(), maps)?)
}

/// All Lambertian views in `[v, u]` order; the sink hears of them from the middle outward.
fn lambertian_views(
    reference: &Arc<View>,
    photo: &Signed,
    depths: &RayDepths,
    job: &Job,
) -> Result<Vec<Arc<View>>, SynthError> {
    let grid = depths.grid();
    spiral(grid, Some(Stage::Warp), job, |at| match at == grid.reference() {
        true => Ok(Arc::clone(reference)),
        false => Ok(Arc::new(lambertian::render_view(photo, depths.view(at), grid.offset(at))?)),
    })
}

/// The same, with the far side's colours where rays end behind what the photo sees.
fn bared_views(
    reference: &Arc<View>,
    photo: &Signed,
    depths: &RayDepths,
    job: &Job,
) -> Result<Vec<Arc<View>>, SynthError> {
    let (grid, far) = (depths.grid(), FarSide::new(photo, depths));
    spiral(grid, Some(Stage::Warp), job, |at| match at == grid.reference() {
        true => Ok(Arc::clone(reference)),
        false => Ok(Arc::new(far.view(photo, depths.view(at), grid.offset(at))?)),
    })
}

/// Replaces each view but the reference by its corrected one.
fn correct(
    net: &OcclusionNet,
    reference: &Arc<View>,
    photo: &Signed,
    depths: &RayDepths,
    threads: usize,
    job: &Job,
    views: &mut Vec<Arc<View>>,
) -> Result<(), SynthError> {
    let grid = depths.grid();
    let small = fit_long_side(reference.size(), OCCLUSION_LONG_SIDE);
    let residuals = if small == reference.size() {
        net.residuals(photo, depths, threads, job)?
    } else {
        let (photo, depths) = shrunk(reference, depths, small)?;
        net.residuals(&photo, &depths, threads, job)?
    };
    let far = FarSide::new(photo, depths);
    *views = spiral(grid, None, job, |at| match at == grid.reference() {
        true => Ok(Arc::clone(reference)),
        false => Ok(Arc::new(residuals.correct(photo, &far, depths, grid.layer_from_view(at))?)),
    })?;
    Ok(())
}

/// Photo and ray depths at the size at which the occlusion net works.
fn shrunk(reference: &View, depths: &RayDepths, size: Size) -> Result<(Signed, RayDepths), SynthError> {
    let from = depths.size();
    let ratio = disparity_scale(from, size);
    let maps: Vec<f32> = depths
        .disparity_px()
        .par_chunks_exact(pixels(from))
        .flat_map_iter(|map| nearest(map, from, size).into_iter().map(|d| d * ratio))
        .collect();
    Ok((Signed::resized(reference, size, Filter::Lanczos3), RayDepths::new(depths.grid(), size, maps)?))
}

/// Makes all views in parallel, a few at a time from the middle outward, and tells the sink of each.
fn spiral(
    grid: ViewGrid,
    stage: Option<Stage>,
    job: &Job,
    make: impl Fn(ViewIndex) -> Result<Arc<View>, SynthError> + Sync,
) -> Result<Vec<Arc<View>>, SynthError> {
    let order = grid.spiral();
    let mut views: Vec<Option<Arc<View>>> = vec![None; grid.count()];
    let at_once = rayon::current_num_threads().max(1);
    for (round, group) in order.chunks(at_once).enumerate() {
        let made: Result<Vec<_>, _> = group.par_iter().map(|at| make(*at)).collect();
        for (at, view) in group.iter().zip(made?) {
            job.sink.view(*at, &view);
            views[grid.layer_from_view(*at)] = Some(view);
        }
        match stage {
            Some(stage) => job.advance(stage, (round * at_once + group.len()) as u32, grid.count() as u32)?,
            None => job.check()?,
        }
    }
    Ok(views.into_iter().flatten().collect())
}
