//! From a subject to its disparity and views: nets that stay warm, the cache, plane sweep, and what is done without nets.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use super::picture::{MadeBy, MadeViews, Scene};
use super::{Content, DepthFrom, OnePhoto, Recipe, Recorded, SceneError, Subject, several};
use crate::errors::sentence;
use crate::field::{DisparityMap, RelativeDepth, Strength, ViewBlock, fit_long_side};
use crate::io::formats::depth_map::GivenDepth;
use crate::io::{EmbeddedDepth, exif};
use crate::job::Job;
use crate::repair::Repairs;
use crate::synth::adopt::Shelf;
use crate::synth::cache::Cache;
use crate::synth::range::{Camera, Estimate};
use crate::synth::{
    DepthSource, ModelSource, ModelTag, Scale, SynthError, SynthParams, Synthesizer, fuse, lift, reference_view, sweep,
    synthesize_from_map, upsample,
};

/// A correlation beyond this tells near from far. Of nine light fields of known sign it tells five, none of them wrongly.
const TELLS: f32 = 0.5;

/// How light fields are made.
#[derive(Clone, Debug, PartialEq)]
pub struct Making {
    /// Long side of a view, in pixels; a smaller photo is not enlarged.
    pub long_side: u32,
    /// Whether the occlusion net corrects the Lambertian views.
    pub occlusion: bool,
    /// Threads that compute; 0 is one for each core.
    pub threads: usize,
    /// Where ray depths come from.
    pub source: DepthFrom,
    /// How far they reach, where they only order.
    pub scale: Scale,
    /// Where the nets come from.
    pub models: ModelSource,
    /// The nets that the person added.
    pub shelf: Option<Shelf>,
    /// What was mended of its depth.
    pub repairs: Repairs,
    /// How deep the scene is made, where that is asked for apart from a recipe.
    pub strength: Option<Strength>,
}

impl Making {
    /// Long side of a view where nobody asks for another, in pixels.
    pub const LONG_SIDE: u32 = 540;

    /// Width and height of the views of a subject.
    pub fn view_size(&self, subject: &Subject) -> [u32; 2] {
        match &subject.content {
            Content::Photo(one) => fit_long_side(one.photo.size(), self.long_side.max(1)),
            Content::Views(recorded) => recorded.shown.size(),
        }
    }

    /// The same with the strength and the source of depth that a recipe names, where no others were asked for, and with its
    /// repairs.
    #[must_use]
    pub fn with_recipe(&self, recipe: &Recipe) -> Self {
        let strength = self.strength.or(Some(recipe.strength()));
        let source = match (&self.source, &recipe.depth) {
            (DepthFrom::Auto, Some(source)) => source.clone(),
            (source, _) => source.clone(),
        };
        Self { source, strength, repairs: recipe.repairs.clone(), ..self.clone() }
    }

    /// The source that [`DepthFrom::Auto`] is for a photo: measured depth before a chosen net before our own.
    fn best_source(&self, one: &OnePhoto) -> DepthFrom {
        one.best_source(self.shelf.as_ref().and_then(Shelf::preferred).map(DepthFrom::Model))
    }
}

impl Default for Making {
    fn default() -> Self {
        Self {
            long_side: Self::LONG_SIDE,
            occlusion: true,
            threads: 0,
            source: DepthFrom::default(),
            scale: Scale::default(),
            models: ModelSource::default(),
            shelf: None,
            repairs: Repairs::default(),
            strength: None,
        }
    }
}

/// What is asked for: one map is made much sooner than 64 views.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Need {
    /// The disparity of the reference view: what the lens renderer needs.
    Map,
    /// All views and the disparity of every ray.
    Views,
    /// These views of the paper's grid: what is dear to make view by view makes no others, and blank views are in their place.
    Some(ViewBlock),
}

impl Need {
    /// Whether these views are needed.
    pub(super) fn block(self) -> Option<ViewBlock> {
        match self {
            Self::Some(block) => Some(block),
            Self::Map | Self::Views => None,
        }
    }
}

/// Makes scenes of subjects, and keeps its nets between them.
#[derive(Default)]
pub struct Maker {
    cache: Option<Cache>,
    nets: Mutex<Option<(Sources, Arc<Synthesizer>)>>,
}

/// Where nets come from: the program or a folder, and the person's shelf.
type Sources = (ModelSource, Option<Shelf>);

impl Maker {
    /// With a cache of light fields, or without. Nothing is loaded before the first photo.
    pub fn new(cache: Option<Cache>) -> Self {
        Self { cache, nets: Mutex::default() }
    }

    /// Makes what is needed of a subject. The sink hears of ray depths and views as they come.
    ///
    /// # Errors
    /// [`SceneError`]. A photo with a depth of its own becomes a scene even where the nets cannot be loaded.
    pub fn scene(&self, subject: &Arc<Subject>, how: &Making, need: Need, job: &Job) -> Result<Scene, SceneError> {
        let started = Instant::now();
        let wanted = how.strength.unwrap_or_default();
        let strength = subject.strength(wanted);
        if strength < wanted.clamped() {
            job.sink.warning(RECORDED.to_owned());
        }
        // Views of another strength are made of the map.
        let first = if strength == Strength::AS_MADE { need } else { Need::Map };
        let scene = match &subject.content {
            Content::Photo(one) => self.of_photo(subject, one, how, first, job)?,
            Content::Views(recorded) => self.of_views(subject, recorded, how, job)?,
        };
        // After the cache: whatever was kept, or comes from elsewhere, is mended alike.
        let scene = scene.mended(&how.repairs, job)?;
        let scene = scene.at_strength(strength, how, need, job)?;
        let took = started.elapsed();
        log::info!("{}: {:?} in {:.3} s", subject.name, need, took.as_secs_f32());
        Ok(scene.timed(took))
    }

    fn of_photo(
        &self,
        subject: &Arc<Subject>,
        one: &OnePhoto,
        how: &Making,
        need: Need,
        job: &Job,
    ) -> Result<Scene, SceneError> {
        if let Some(splats) = &one.splats {
            return super::splats::scene(subject, splats, how, need, job);
        }
        if let Some(scene) = self.of_several(subject, one, how, need, job)? {
            return Ok(scene);
        }
        let how = &Making { source: self.source_of(one, how, job), ..how.clone() };
        let params = params(one, how, job);
        let given = params.disparity.clone();
        if let Some(map) = given.as_ref().filter(|_| need == Need::Map) {
            return Scene::of_map(subject, Arc::clone(map), MadeBy::named(OWN_MAP));
        }
        if let Some(map) = given.as_ref().filter(|_| !how.occlusion) {
            let made = synthesize_from_map(&one.photo, map, &params, job)?;
            return Scene::of_views(subject, given, made.into(), MadeBy::named(OWN_MAP));
        }
        let nets = match self.nets(how) {
            Ok(nets) => nets,
            Err(error) => return without_nets(subject, one, &params, need, error, job),
        };
        let made_by = MadeBy { names: first_names(how, &params), models: nets.models(&params) };
        if need == Need::Map {
            let (map, metric) = nets.depth_map(&one.photo, &params, self.cache.as_ref(), job)?;
            return Ok(Scene::of_map(subject, Arc::new(map), made_by)?.in_metres(metric));
        }
        let made = nets.synthesize_cached(&one.photo, &params, self.cache.as_ref(), job)?;
        let metric = made.metric;
        Ok(Scene::of_views(subject, given, made.into(), made_by)?.in_metres(metric))
    }

    /// Several photos: what they tell, with the depth net's map fitted in; none where nothing is to be told, or another
    /// source is asked for.
    fn of_several(
        &self,
        subject: &Arc<Subject>,
        one: &OnePhoto,
        how: &Making,
        need: Need,
        job: &Job,
    ) -> Result<Option<Scene>, SceneError> {
        if one.several.is_none() || how.source != DepthFrom::Auto {
            return Ok(None);
        }
        let params = params(one, &Making { source: DepthFrom::Network, ..how.clone() }, job);
        let nets = self.nets(how).ok();
        let guess =
            nets.as_ref().map(|nets| nets.depth_map(&one.photo, &params, self.cache.as_ref(), job)).transpose()?;
        let guess = guess.as_ref().map(|(map, _)| map);
        let nets = nets.as_deref().map(|nets| (nets, guess));
        several::scene(subject, one, nets, (&params, need), how, job)
    }

    /// What a photo's depth is made from. A net that was not asked for by name and cannot be used is told of, and the
    /// next best takes its place.
    pub(super) fn source_of(&self, one: &OnePhoto, how: &Making, job: &Job) -> DepthFrom {
        let best = || how.best_source(one);
        let source = match &how.source {
            DepthFrom::Auto => best(),
            DepthFrom::Net(tag) => match self.name_of(tag, how) {
                Ok(name) => return DepthFrom::Model(name),
                Err(why) => {
                    job.sink.warning(format!("{why} — the automatic choice is used"));
                    best()
                }
            },
            source => return source.clone(),
        };
        let DepthFrom::Model(name) = &source else { return source };
        match self.nets(how).map(|nets| nets.check(name)) {
            Ok(Err(error)) => {
                job.sink.warning(format!("{error} — the program's own net is used"));
                DepthFrom::Network
            }
            _ => source,
        }
    }

    /// The name that a net has here now, by its checksum; else why it cannot be used. Without any nets that is told later.
    fn name_of(&self, tag: &ModelTag, how: &Making) -> Result<String, String> {
        let Ok(nets) = self.nets(how) else { return Ok(tag.id.clone()) };
        let missing = || format!("the net {:?} of this edit is not here: add its file again to use it", tag.id);
        let name = nets.name_of(tag).ok_or_else(missing)?;
        nets.check(&name).map_err(|error| sentence(&error))?;
        Ok(name)
    }

    /// A recorded light field: its own ray depths, those of its reference view lifted, or measured from its views.
    fn of_views(
        &self,
        subject: &Arc<Subject>,
        recorded: &Recorded,
        how: &Making,
        job: &Job,
    ) -> Result<Scene, SceneError> {
        let field = Arc::clone(&recorded.shown);
        let reference = recorded.reference.as_ref().filter(|map| map.size() == field.size());
        let depths = match (&recorded.depths, reference) {
            (Some(depths), _) => Arc::clone(depths),
            (None, Some(map)) => Arc::new(lift::lifted(map, field.grid(), job)?),
            (None, None) => {
                let depths = Arc::new(sweep::ray_depths(&field, job)?);
                self.doubt_sign(recorded, &depths.reference_map(), how, job);
                depths
            }
        };
        let provenance = recorded.provenance.clone();
        Scene::of_views(subject, None, MadeViews { field, depths, provenance }, MadeBy::named("from disk"))
    }

    /// Colours cannot tell near from far (see [`Layout`](crate::io::formats::layout::Layout)); the depth net has a guess.
    fn doubt_sign(&self, recorded: &Recorded, measured: &DisparityMap, how: &Making, job: &Job) {
        let Ok(nets) = self.nets(how) else { return };
        let params = SynthParams { threads: how.threads, ..SynthParams::default() };
        let Ok(guess) = nets.working_scale_depth(recorded.shown.reference(), &params, job) else { return };
        if fuse::agreement(&guess, measured) < -TELLS {
            job.sink.warning(
                "What looks near to the depth net lies far in these views: if it is near, turn on “Exchange near and far”"
                    .to_owned(),
            );
        }
    }

    /// The nets of a source, loaded once.
    fn nets(&self, how: &Making) -> Result<Arc<Synthesizer>, SceneError> {
        let mut kept = self.nets.lock().unwrap_or_else(PoisonError::into_inner);
        let wanted = (how.models.clone(), how.shelf.clone());
        if let Some((_, nets)) = kept.as_ref().filter(|(have, _)| *have == wanted) {
            return Ok(Arc::clone(nets));
        }
        let nets = Arc::new(Synthesizer::load(&how.models)?.with_shelf(how.shelf.as_ref()));
        *kept = Some((wanted, Arc::clone(&nets)));
        Ok(nets)
    }

    /// Forgets the nets, for when one of them was added, replaced or removed.
    pub fn forget_nets(&self) {
        *self.nets.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }

    /// Where the cache's entries lie, if there is a cache.
    pub fn cache_folder(&self) -> Option<PathBuf> {
        self.cache.as_ref().map(|cache| cache.folder().to_owned())
    }
}

/// Said where more is asked for than was recorded.
const RECORDED: &str = "A recorded light field reaches as far as its views do: its strength is 1 at most";

/// What people read where a map of their own made the picture, and where the phone's did.
const OWN_MAP: &str = "your map";
const PHONE: &str = "phone";

/// What stands before the models' names.
fn first_names(how: &Making, params: &SynthParams) -> Vec<String> {
    let name = match params.source {
        _ if params.disparity.is_some() => OWN_MAP,
        DepthSource::Phone if how.source == DepthFrom::Map => OWN_MAP,
        DepthSource::Phone | DepthSource::Fused => PHONE,
        DepthSource::Model(_) | DepthSource::Network => return Vec::new(),
    };
    vec![name.to_owned()]
}

/// What the synthesis is asked for; a source that this photo has not is the network, and the person is told.
fn params(one: &OnePhoto, how: &Making, job: &Job) -> SynthParams {
    let base = SynthParams {
        long_side: how.long_side,
        occlusion: how.occlusion,
        threads: how.threads,
        disparity: None,
        source: DepthSource::Network,
        phone: one.phone.as_ref().map(|depth| Arc::new(measured(depth))),
        camera: camera(one),
        scale: how.scale,
    };
    let missing = |what: &str| job.sink.warning(format!("{what}, so the network's depth is used"));
    match (&how.source, &one.own_map) {
        (DepthFrom::Phone | DepthFrom::Fused, _) if base.phone.is_none() => {
            missing("This photo has no depth of its own")
        }
        (DepthFrom::Phone, _) => return SynthParams { source: DepthSource::Phone, ..base },
        (DepthFrom::Fused, _) => return SynthParams { source: DepthSource::Fused, ..base },
        (DepthFrom::Map, None) => missing("There is no map for this photo"),
        (DepthFrom::Map, Some(GivenDepth::Disparity(map))) => {
            return SynthParams { disparity: Some(Arc::clone(map)), ..base };
        }
        (DepthFrom::Map, Some(GivenDepth::Order(map))) => {
            let phone = Some(Arc::new(Estimate::relative(RelativeDepth::clone(map))));
            return SynthParams { source: DepthSource::Phone, phone, ..base };
        }
        (DepthFrom::Model(id), _) => return SynthParams { source: DepthSource::Model(id.clone()), ..base },
        // A net was brought to its name before.
        (DepthFrom::Auto | DepthFrom::Network | DepthFrom::Net(_), _) => {}
    }
    base
}

/// What the phone measured: metres where its file says so, else an order.
fn measured(depth: &EmbeddedDepth) -> Estimate {
    let nearness = depth.map.clone();
    if depth.metric { Estimate::metric(nearness, None) } else { Estimate::relative(nearness) }
}

/// What the photo's file says of the camera.
fn camera(one: &OnePhoto) -> Camera {
    let exif = one.photo.metadata().exif.as_deref();
    Camera { f35_mm: one.f35_mm, focus_m: exif.and_then(exif::subject_distance_m) }
}

/// Lambertian views (paper, §3.2) of a photo whose depth is known; else the error that the nets gave.
fn without_nets(
    subject: &Arc<Subject>,
    one: &OnePhoto,
    params: &SynthParams,
    need: Need,
    error: SceneError,
    job: &Job,
) -> Result<Scene, SceneError> {
    let guided = |map: &DisparityMap| -> Result<DisparityMap, SceneError> {
        let reference = reference_view(&one.photo, params.long_side, job)?;
        Ok(upsample::to_guide(map, &reference, job)?)
    };
    let map = match (&params.disparity, &one.truth, &params.phone) {
        (Some(map), ..) => Arc::clone(map),
        (None, Some(truth), _) => Arc::new(guided(truth)?),
        (None, None, Some(phone)) => {
            Arc::new(guided(&phone.disparity(&params.camera, None).map_err(SynthError::from)?)?)
        }
        (None, None, None) => return Err(error),
    };
    job.sink.warning(format!("{} — the picture's own depth is used", sentence(&error)));
    let made_by = MadeBy::named("the picture's own depth");
    let is_measured = params.disparity.is_none() && one.truth.is_none();
    let metric = params.phone.as_ref().filter(|_| is_measured).and_then(|p| p.metric_scale(&params.camera, None));
    let scene = match need {
        Need::Map => Scene::of_map(subject, map, made_by),
        Need::Views | Need::Some(_) => {
            let made = synthesize_from_map(&one.photo, &map, params, job)?;
            Scene::of_views(subject, Some(map), made.into(), made_by)
        }
    };
    Ok(scene?.in_metres(metric))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::Photo;
    use crate::io::DepthKind;
    use crate::job::Cancel;

    /// Disparities at 1 m and at 2 m of a photo whose phone measured both.
    fn disparities(metric: bool, f35_mm: Option<f32>) -> [f32; 2] {
        let size = [96, 64];
        let photo = Arc::new(Photo::from_srgb8(size, vec![128; 96 * 64 * 4]).unwrap());
        let map =
            RelativeDepth::new(size, (0..96 * 64).map(|i| if i % 96 < 48 { 1.0 } else { 0.5 }).collect()).unwrap();
        let phone = Some(Arc::new(EmbeddedDepth { kind: DepthKind::DynamicDepth, map, metric }));
        let content =
            Content::Photo(OnePhoto { photo, f35_mm, phone, own_map: None, splats: None, truth: None, several: None });
        let subject = Arc::new(Subject { name: "phone".to_owned(), path: None, file: None, info: None, content });
        let job = Job { cancel: &Cancel::default(), sink: &() };
        let scene = Maker::default().scene(&subject, &Making::default(), Need::Map, &job).unwrap();
        [scene.map().at(8, 32), scene.map().at(88, 32)]
    }

    #[test]
    fn metres_of_a_phone_become_what_its_own_lens_would_see() {
        // 96 px wide: a focal length of 96 · 52 / 36 px, and a step of 52 / 28 mm.
        let wanted = 96.0 * 52.0 / 36.0 * (0.052 / 28.0) * (1.0 - 0.5);
        let [near, far] = disparities(true, Some(52.0));
        assert!((near - far - wanted).abs() < 0.01 * wanted, "{near} and {far} differ by {wanted}");
        let [near, far] = disparities(true, None);
        let wide = wanted * (28.0f32 / 52.0).powi(2);
        assert!((near - far - wide).abs() < 0.01 * wide, "a usual lens where the file says none");
        let [far_px, near_px] = RelativeDepth::usual_range_px(96);
        let [near, far] = disparities(false, Some(52.0));
        assert!((near - near_px).abs() < 0.01 && (far - far_px).abs() < 0.01, "an order has the usual range");
    }
}
