//! A subject with its disparity, and the pictures of it.

use std::sync::{Arc, OnceLock};
use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::{Content, Edit, Focus, SceneError, SeveralFound, Subject, focus, sharp};
use crate::field::{
    DisparityMap, FNumber, Lens, LightField, Photo, Picture, Pixels, Provenance, RayDepths, Strength, ViewPoint,
    fit_long_side,
};
use crate::io;
use crate::io::save::Origin;
use crate::job::Job;
use crate::render::cpu;
use crate::render::lens::{self, Rgbd, Space};
use crate::repair::Repairs;
use crate::splats::Processor;
use crate::synth::range::Metric;
use crate::synth::{ModelTag, Synthesis};

/// Copies of a thing that are so many pixels apart are seen as one that is blurred.
const COPIES_PX: f32 = 1.0;

/// How large the picture becomes; never larger than the photo.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum OutputSize {
    /// As the photo.
    #[default]
    Photo,
    /// At most so many pixels on the longer side.
    LongSide(u32),
    /// As large as fits into this width and height.
    Within([u32; 2]),
    /// As the views: their sum, as the paper refocuses (§1).
    LightField,
}

impl OutputSize {
    /// The picture's size for a photo's; that of the views is the photo's here.
    pub fn of(self, photo: [u32; 2]) -> [u32; 2] {
        match self {
            Self::Photo | Self::LightField => photo,
            Self::LongSide(side) => fit_long_side(photo, side.max(1)),
            Self::Within(wanted) => within(photo, wanted),
        }
    }
}

/// The largest size of a photo's shape in a width and height; what misses them by a pixel's rounding is taken as asked.
fn within(photo: [u32; 2], wanted: [u32; 2]) -> [u32; 2] {
    let wanted = [0, 1].map(|axis| wanted[axis].clamp(1, photo[axis]));
    let share = |axis: usize| f64::from(wanted[axis]) / f64::from(photo[axis]);
    let scale = share(0).min(share(1));
    let fits = photo.map(|side| ((f64::from(side) * scale).round() as u32).max(1));
    if fits.iter().zip(wanted).all(|(fits, wanted)| fits.abs_diff(wanted) <= 1) { wanted } else { fits }
}

/// A subject with its disparity: all that pictures are made of.
#[derive(Clone)]
pub struct Scene {
    subject: Arc<Subject>,
    map: Arc<DisparityMap>,
    subject_at: OnceLock<[f32; 2]>,
    views: Option<MadeViews>,
    /// The scene before its depth was mended, where it was, and what was asked to be done to it.
    unmended: Option<Arc<Self>>,
    repairs: Repairs,
    strength: Strength,
    /// Metres of its depth at strength 1, where the source has them.
    metric: Option<Metric>,
    /// Disparities of the far and the near end at strength 1, as shares of the width.
    ends: OnceLock<[f32; 2]>,
    /// The scene at strength 1, where this is another.
    as_made: Option<Arc<Self>>,
    made_by: MadeBy,
    took: Duration,
}

/// Views and the disparity of every ray, of one size.
#[derive(Clone, Debug)]
pub struct MadeViews {
    /// The views as they are shown.
    pub field: Arc<LightField>,
    /// The disparity of every ray.
    pub depths: Arc<RayDepths>,
    /// Where each ray's colour comes from, where several photos saw the scene.
    pub provenance: Option<Arc<Provenance>>,
}

impl From<Synthesis> for MadeViews {
    fn from(made: Synthesis) -> Self {
        Self { field: made.field, depths: made.depths, provenance: None }
    }
}

/// Who made a scene.
#[derive(Clone, Debug, Default)]
pub(super) struct MadeBy {
    /// Sources that are no models.
    pub(super) names: Vec<String>,
    /// The models that took part.
    pub(super) models: Vec<ModelTag>,
}

impl MadeBy {
    pub(super) fn named(name: &str) -> Self {
        Self { names: vec![name.to_owned()], models: Vec::new() }
    }
}

impl Scene {
    /// Of one map alone.
    pub(super) fn of_map(subject: &Arc<Subject>, map: Arc<DisparityMap>, made_by: MadeBy) -> Result<Self, SceneError> {
        Rgbd::check(subject.size(), &map)?;
        let (subject, subject_at) = (Arc::clone(subject), OnceLock::new());
        let (views, unmended, repairs, took) = (None, None, Repairs::default(), Duration::ZERO);
        let (strength, as_made, metric, ends) = (Strength::AS_MADE, None, None, OnceLock::new());
        Ok(Self { subject, map, subject_at, views, unmended, repairs, strength, metric, ends, as_made, made_by, took })
    }

    /// Of views; `given` is the map that they were made from, where that is known better than at their size.
    pub(super) fn of_views(
        subject: &Arc<Subject>,
        given: Option<Arc<DisparityMap>>,
        views: MadeViews,
        made_by: MadeBy,
    ) -> Result<Self, SceneError> {
        let map = given.unwrap_or_else(|| Arc::new(views.depths.reference_map()));
        Ok(Self { views: Some(views), ..Self::of_map(subject, map, made_by)? })
    }

    pub(super) fn timed(self, took: Duration) -> Self {
        Self { took, ..self }
    }

    /// The same with another map, and views of it where there were views. It stays about what it was about: the focus must
    /// not leap while something else is mended.
    pub(super) fn with_mended(&self, map: Arc<DisparityMap>, views: Option<MadeViews>) -> Result<Self, SceneError> {
        Rgbd::check(self.subject.size(), &map)?;
        let unmended = Some(Arc::new(self.unmended().clone()));
        let (subject_at, ends) = (OnceLock::from(self.subject_at()), OnceLock::new());
        Ok(Self { map, subject_at, ends, views, unmended, ..self.clone() })
    }

    /// The same with what was asked to be done to its depth.
    pub(super) fn with_repairs(self, repairs: &Repairs) -> Self {
        Self { repairs: repairs.clone(), ..self }
    }

    /// What was asked to be done to its depth.
    pub fn repairs(&self) -> &Repairs {
        &self.repairs
    }

    /// The same scene before its depth was mended.
    pub fn unmended(&self) -> &Self {
        self.unmended.as_deref().unwrap_or(self)
    }

    /// The same scene with its views in one block of memory, for those who look at the memory itself.
    #[must_use]
    pub fn in_one_block(self) -> Self {
        let views = self.views.map(|made| MadeViews { field: made.field.in_one_block(), ..made });
        Self { views, ..self }
    }

    pub(super) fn in_metres(self, metric: Option<Metric>) -> Self {
        Self { metric, ..self }
    }

    /// Metres of its depth at strength 1, where the source has them.
    pub(super) fn metric(&self) -> Option<Metric> {
        self.metric
    }

    /// Disparities between which almost all of the scene lies at strength 1, as shares of the width: far and near.
    pub(super) fn ends(&self) -> [f32; 2] {
        let made = self.as_made();
        *made.ends.get_or_init(|| focus::ends(&made.map).map(|px| px / made.map.size()[0] as f32))
    }

    /// The same with its map at another strength, and no views yet; what it is about is seen at strength 1.
    pub(super) fn with_map_at(&self, strength: Strength) -> Self {
        let (map, subject_at) = (Arc::new(self.map.at_strength(strength)), OnceLock::from(self.subject_at()));
        let as_made = Some(Arc::new(self.clone()));
        Self { map, subject_at, views: None, strength, as_made, ..self.clone() }
    }

    pub(super) fn with_views(self, views: MadeViews) -> Self {
        Self { views: Some(views), ..self }
    }

    /// How deep it is, against how it was made.
    pub fn strength(&self) -> Strength {
        self.strength
    }

    /// The same scene at strength 1.
    pub fn as_made(&self) -> &Self {
        self.as_made.as_deref().unwrap_or(self)
    }

    /// What it is a scene of.
    pub fn subject(&self) -> &Arc<Subject> {
        &self.subject
    }

    /// The disparity of the reference view, as exact as it is known.
    pub fn map(&self) -> &Arc<DisparityMap> {
        &self.map
    }

    /// The views; none where only a map was asked for.
    pub fn views(&self) -> Option<&MadeViews> {
        self.views.as_ref()
    }

    /// The models that made it.
    pub fn models(&self) -> &[ModelTag] {
        &self.made_by.models
    }

    /// What is known of the photos that it is made of; none where it is of one.
    pub fn several(&self) -> Option<SeveralFound> {
        match &self.subject.content {
            Content::Photo(one) => one.several.as_ref()?.found(),
            Content::Views(_) => None,
        }
    }

    /// Who made it, for people.
    pub fn made_by(&self) -> String {
        let models = self.made_by.models.iter().map(|model| &model.id);
        self.made_by.names.iter().chain(models).map(String::as_str).collect::<Vec<_>>().join(" + ")
    }

    /// How long it took to make.
    pub fn took(&self) -> Duration {
        self.took
    }

    /// The lens of an edit, in pixels of the map's width.
    pub fn lens(&self, edit: &Edit) -> Lens {
        match edit.focus {
            Focus::Subject => {
                Edit { focus: Focus::At(self.subject_at()), ..edit.clone() }.lens(&self.map, self.strength)
            }
            _ => edit.lens(&self.map, self.strength),
        }
    }

    /// The widest aperture at which the places of an edit stay sharp in a picture of a width; none where it has not two.
    pub fn widest(&self, edit: &Edit, picture_width: u32) -> Option<FNumber> {
        let Focus::Through(places) = edit.focus else { return None };
        let lens = self.lens(edit);
        (places.all().len() > 1).then(|| sharp::widest(&self.map, &lens, &places, picture_width, self.strength.0))
    }

    /// Whether a plane goes through the places of an edit; none where it has not two.
    pub fn goes_through(&self, edit: &Edit) -> Option<bool> {
        let Focus::Through(places) = edit.focus else { return None };
        (places.all().len() > 1).then(|| sharp::solve(&self.map, &places, self.strength.0).is_plane())
    }

    /// Where the subject most likely is, x and y from 0 to 1.
    pub fn subject_at(&self) -> [f32; 2] {
        *self.subject_at.get_or_init(|| focus::subject(&self.map, &self.subject.salience()))
    }

    /// The lens of an edit, in pixels of a width.
    pub fn lens_at(&self, edit: &Edit, width: u32) -> Lens {
        self.lens(edit).scaled(width as f32 / self.map.size()[0] as f32)
    }

    /// The photo, or the reference view, with its disparity: what the lens renderer works on. For a recorded light
    /// field it knows what the other views have seen behind edges.
    pub fn rgbd(&self) -> Result<Rgbd, SceneError> {
        let map = DisparityMap::clone(&self.map);
        let Some(photo) = self.subject.photo() else { return self.rgbd_of_views(map) };
        Ok(Rgbd::new(Arc::clone(photo), map)?)
    }

    fn rgbd_of_views(&self, map: DisparityMap) -> Result<Rgbd, SceneError> {
        let views = self.made_views()?;
        let reference = views.field.reference();
        let photo = Photo::from_srgb8(reference.size(), reference.rgba().to_vec())?;
        Ok(Rgbd::new(Arc::new(photo), map)?.with_behind(lens::revealed(&views.field, &views.depths)))
    }

    /// The views, or why there are none.
    pub fn made_views(&self) -> Result<&MadeViews, SceneError> {
        self.views.as_ref().ok_or(SceneError::NoViews)
    }

    /// Width and height of a picture of it.
    pub fn picture_size(&self, size: OutputSize) -> [u32; 2] {
        match (size, &self.views) {
            (OutputSize::LightField, Some(views)) => views.field.size(),
            _ => size.of(self.subject.size()),
        }
    }

    /// Whether a picture is a sum of views: asked for so, or of a recorded light field at its own size, as long as its
    /// views reach across the lens and it has no faults. All else is the lens renderer's.
    pub fn sums_views(&self, edit: &Edit, size: OutputSize) -> bool {
        let Some(views) = &self.views else { return false };
        let is_asked_for = size == OutputSize::LightField;
        // Views turn around disparity 0.
        let is_turned = edit.pivot != 0.0 && edit.viewpoint != ViewPoint::default() && !is_asked_for;
        let is_own_size = self.subject.photo().is_none() && self.picture_size(size) == views.field.size();
        (is_asked_for || is_own_size) && !is_turned && views.field.grid().spans(edit.f_number) && edit.glass.is_plain()
    }

    /// Whether every `nth` view of each row, added up, shows an edit as the lens does, only coarser: the views reach across the
    /// lens, and from one to the next nothing moves by more than a pixel. Else copies are seen beside each other.
    pub fn views_draft(&self, edit: &Edit, nth: u32) -> bool {
        let Some(views) = &self.views else { return false };
        let width = views.field.size()[0];
        let ends_px = self.ends().map(|share| share * self.strength.0 * width as f32);
        let step_px = self.lens_at(edit, width).widest_defocus_px(ends_px) * nth as f32;
        views.field.grid().spans(edit.f_number) && step_px <= COPIES_PX
    }

    /// What must be made of a subject for a picture of this size.
    pub fn need(size: OutputSize) -> super::Need {
        if size == OutputSize::LightField { super::Need::Views } else { super::Need::Map }
    }

    /// What the numbers of [`Scene::picture`] mean, and what is known about the photo.
    pub fn origin(&self, size: OutputSize) -> Origin {
        match self.subject.photo() {
            Some(photo) if size == OutputSize::LightField => Origin::in_srgb(photo),
            Some(photo) => Origin::in_own_space(photo),
            None => Origin { source: self.subject.path.clone(), ..Origin::default() },
        }
    }

    /// The picture as it stands in a file, of 8 or 16 bits a channel. A photo keeps its own colours. One that was opened reduced
    /// is read again, where the picture is larger.
    pub fn picture(&self, edit: &Edit, size: OutputSize, bits: u8, job: &Job) -> Result<Pixels, SceneError> {
        if let Some(photo) = self.kept_too_small(size) {
            let subject = Subject::clone(&self.subject).with_photo(io::open_whole(photo, job)?);
            return Self { subject: Arc::new(subject), ..self.clone() }.picture(edit, size, bits, job);
        }
        if self.sums_views(edit, size) {
            let sum = self.sum_of_views(edit)?;
            return Ok(Pixels::from_linear(sum.size, &sum.rgb_linear, bits, &self.origin(size).transfer));
        }
        if let Some(picture) = self.through_true_lens(edit, size, &Processor, job)? {
            return Ok(Pixels::from_linear(picture.size, &picture.rgb_linear, bits, &self.origin(size).transfer));
        }
        let space = if size == OutputSize::LightField { Space::Srgb } else { Space::Own };
        let (rgbd, size) = self.seen(edit, size, space, job)?;
        Ok(lens::render_pixels(&rgbd, &self.lens(edit), size, bits, job)?)
    }

    /// The photo, where less of it was kept than a picture needs, and there is a file that has the rest.
    fn kept_too_small(&self, size: OutputSize) -> Option<&Photo> {
        let photo = self.subject.photo().filter(|photo| photo.source().is_some())?;
        (size != OutputSize::LightField && size.of(photo.whole_size())[0] > photo.size()[0]).then_some(photo)
    }

    /// The picture in linear sRGB light, for screens and the clipboard.
    pub fn shown(&self, edit: &Edit, size: OutputSize, job: &Job) -> Result<Picture, SceneError> {
        if self.sums_views(edit, size) {
            return self.sum_of_views(edit);
        }
        if let Some(picture) = self.through_true_lens(edit, size, &Processor, job)? {
            return Ok(picture);
        }
        let (rgbd, size) = self.seen(edit, size, Space::Srgb, job)?;
        Ok(lens::render(&rgbd, &self.lens(edit), size, job)?)
    }

    fn seen(&self, edit: &Edit, size: OutputSize, space: Space, job: &Job) -> Result<(Rgbd, [u32; 2]), SceneError> {
        let size = self.picture_size(size);
        let pivot_px = edit.pivot_px(self.map.size()[0], self.strength);
        Ok((self.rgbd()?.in_space(space).seen_from(edit.viewpoint, pivot_px, size, job)?, size))
    }

    /// Shift and add (paper, §1); closed down, the view itself.
    fn sum_of_views(&self, edit: &Edit) -> Result<Picture, SceneError> {
        let MadeViews { field, depths, .. } = self.made_views()?;
        if edit.f_number.added_views() == 0.0 {
            return Ok(cpu::view_with_depths(field, Some(depths), edit.viewpoint));
        }
        let lens = self.lens_at(edit, field.size()[0]);
        Ok(cpu::refocus_with_depths(field, Some(depths), &lens, edit.viewpoint))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_keep_the_shape_and_never_grow() {
        assert_eq!(OutputSize::LongSide(2048).of([4000, 3000]), [2048, 1536]);
        assert_eq!(OutputSize::Within([1000, 1000]).of([4000, 3000]), [1000, 750]);
        assert_eq!(
            OutputSize::Within([1000, 751]).of([4000, 3000]),
            [1000, 751],
            "a pixel's rounding is no other shape"
        );
        assert_eq!(OutputSize::Within([9000, 9000]).of([4000, 3000]), [4000, 3000]);
    }

    #[test]
    fn a_photo_that_was_opened_reduced_is_exported_whole() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("large.png");
        image::RgbImage::from_fn(64, 48, |x, y| image::Rgb([(4 * x) as u8, (5 * y) as u8, 90])).save(&path).unwrap();
        let map = Arc::new(DisparityMap::new([16, 12], (0..16 * 12).map(|i| (i % 16) as f32 / 8.0).collect()).unwrap());
        let scene_of = |photo: Photo| {
            let subject = Arc::new(Subject::from_photo(Arc::new(photo.with_source(&path)), "large.png"));
            Scene::of_map(&subject, Arc::clone(&map), MadeBy::default()).unwrap()
        };
        let small = || Photo::from_srgb8([32, 24], vec![128; 32 * 24 * 4]).unwrap().reduced_from([64, 48]);
        let job = Job { cancel: &crate::job::Cancel::default(), sink: &() };
        let whole = Photo::from_srgb8([64, 48], image::open(&path).unwrap().into_rgba8().into_raw()).unwrap();
        let picture = |photo, size| scene_of(photo).picture(&Edit::default(), size, 8, &job);
        assert_eq!(picture(small(), OutputSize::Photo).unwrap(), picture(whole.clone(), OutputSize::Photo).unwrap());
        let forty = picture(small(), OutputSize::LongSide(40)).unwrap();
        assert_eq!(forty, picture(whole, OutputSize::LongSide(40)).unwrap());
        // What was kept is enough, and no file is asked for.
        std::fs::remove_file(&path).unwrap();
        assert_eq!(picture(small(), OutputSize::LongSide(32)).unwrap().size, [32, 24]);
        assert!(matches!(picture(small(), OutputSize::Photo), Err(SceneError::Open(_))));
        image::RgbImage::new(60, 48).save(&path).unwrap();
        let changed = picture(small(), OutputSize::Photo).unwrap_err().to_string();
        assert!(changed.contains("has changed since it was opened"), "{changed}");
    }
}
