//! What pictures are made of: a photo, or a light field that was recorded.

use std::borrow::Cow;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::{Salience, SceneError, Several};
use crate::field::{DisparityMap, LightField, Photo, Provenance, RayDepths, Strength, View};
use crate::io::formats::depth_map::GivenDepth;
use crate::io::formats::layout::Layout;
use crate::io::{self, EmbeddedDepth, FileInfo, LightFieldFile, Opened, PhotoFile};
use crate::job::Job;
use crate::splats::Pictured;
use crate::synth::corners::{self, CornerNets};
use crate::synth::reference_view;

/// The most pixels of a view of which 64 are made.
const LARGEST_CORNER: u64 = 6 << 20;

/// An open file, or a picture that never was one.
#[derive(Clone, Debug)]
pub struct Subject {
    /// Its name, for people and for the names of exports.
    pub name: String,
    /// Where it lies; none for a pasted picture and the sample.
    pub path: Option<PathBuf>,
    /// Its file, where that lay in another one.
    pub file: Option<Arc<[u8]>>,
    /// What the file is; none for what was no file.
    pub info: Option<FileInfo>,
    /// What is in it.
    pub content: Content,
}

/// A photo or a grid of views.
#[derive(Clone, Debug)]
pub enum Content {
    /// One picture: its other views are made.
    Photo(OnePhoto),
    /// Views that a camera or a renderer made.
    Views(Recorded),
}

/// A photo and what is known of its depth.
#[derive(Clone, Debug)]
pub struct OnePhoto {
    /// The photo.
    pub photo: Arc<Photo>,
    /// Focal length as on 35-mm film in millimetres, where the file says it.
    pub f35_mm: Option<f32>,
    /// Depth that the phone measured.
    pub phone: Option<Arc<EmbeddedDepth>>,
    /// A map of one's own.
    pub own_map: Option<GivenDepth>,
    /// The scene of Gaussian splats that it is a picture of.
    pub splats: Option<Arc<Pictured>>,
    /// The true disparity, where the program drew the photo itself.
    pub truth: Option<Arc<DisparityMap>>,
    /// Other photos of the same subject.
    pub several: Option<Arc<Several>>,
}

/// A light field as it was recorded.
#[derive(Clone, Debug)]
pub struct Recorded {
    /// The views as they are shown.
    pub shown: Arc<LightField>,
    /// The views as they lie in their files, where they are shown brighter: what is written as a light field.
    pub stored: Option<Arc<LightField>>,
    /// The disparity of every ray, where the file has it.
    pub depths: Option<Arc<RayDepths>>,
    /// The disparity of the reference view alone, where the file has only that.
    pub reference: Option<Arc<DisparityMap>>,
    /// Where each ray's colour comes from, where the file says it.
    pub provenance: Option<Arc<Provenance>>,
    /// How the stored views were laid out to fit the conventions.
    pub layout: Layout,
}

impl Subject {
    /// Opens a file or folder, and passes its warnings on.
    pub fn open(path: &Path, job: &Job) -> Result<Self, SceneError> {
        let opened = io::open(path, job)?;
        log::info!("opened {}", path.display());
        opened.info().warnings.iter().for_each(|warning| job.sink.warning(warning.clone()));
        Self::whole(opened, path, job)
    }

    /// What was read from a path; where only the views at the corners are there, with those between.
    ///
    /// # Errors
    /// Corners that are too large; cancelled.
    pub fn whole(opened: Opened, path: &Path, job: &Job) -> Result<Self, SceneError> {
        let corners = matches!(&opened, Opened::LightField(file) if file.corners);
        let mut subject = Self::from_opened(opened, path);
        if let Content::Views(recorded) = &mut subject.content
            && corners
        {
            let [width, height] = recorded.shown.size();
            if u64::from(width) * u64::from(height) > LARGEST_CORNER {
                return Err(SceneError::Refused(format!(
                    "64 views of {width}×{height} pixels do not fit into memory — give the four to `plenoscope synth \
                     --corners`, which makes smaller ones: {}",
                    path.display()
                )));
            }
            *recorded = Recorded::between(recorded.shown.views(), None, job)?;
        }
        Ok(subject)
    }

    /// What was read from a path.
    pub fn from_opened(opened: Opened, path: &Path) -> Self {
        let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        let info = Some(opened.info().clone());
        let content = match opened {
            Opened::Photo(file) => Content::Photo(OnePhoto::from(*file)),
            Opened::LightField(file) => Content::Views(Recorded::from(*file)),
        };
        Self { name, path: Some(path.to_owned()), file: None, info, content }
    }

    /// A photo that is no file.
    pub fn from_photo(photo: Arc<Photo>, name: &str) -> Self {
        let content = Content::Photo(OnePhoto {
            photo,
            f35_mm: None,
            phone: None,
            own_map: None,
            splats: None,
            truth: None,
            several: None,
        });
        Self { name: name.to_owned(), path: None, file: None, info: None, content }
    }

    /// The light field between four photos that were taken from the corners of a square: upper left, upper right, lower
    /// left, lower right. Its views are `long_side` long at most. Nets make those between, where they are given, else what a
    /// sweep over the four finds.
    ///
    /// # Errors
    /// What is no photo; photos of several sizes; cancelled; what the nets say.
    pub fn between(
        photos: [&Path; 4],
        long_side: u32,
        nets: Option<&CornerNets>,
        job: &Job,
    ) -> Result<Self, SceneError> {
        let mut views: Vec<Arc<View>> = Vec::with_capacity(4);
        for path in photos {
            let subject = Self::open(path, job)?;
            let refused = |why: &str| SceneError::Refused(format!("{why}: {}", path.display()));
            let photo = subject
                .photo()
                .ok_or_else(|| refused("this is a light field — each corner is one photo — name four photos"))?;
            let view = reference_view(photo, long_side, job)?;
            if views.first().is_some_and(|first| first.size() != view.size()) {
                return Err(refused("this photo has another size than the first — corners need the same — crop it"));
            }
            views.push(Arc::new(view));
        }
        let recorded = Recorded::between(&views, nets, job)?;
        let name = photos[0].file_name().unwrap_or(photos[0].as_os_str()).to_string_lossy().into_owned();
        let path = Some(photos[0].to_owned());
        Ok(Self { name, path, file: None, info: None, content: Content::Views(recorded) })
    }

    /// The built-in sample, whose true disparity is known.
    pub fn sample() -> Result<Self, SceneError> {
        let sample = io::sample::sample()?;
        let mut subject = Self::from_photo(sample.photo, "Sample");
        if let Content::Photo(one) = &mut subject.content {
            one.truth = Some(Arc::new(sample.disparity));
        }
        Ok(subject)
    }

    /// The photo; none for a recorded light field.
    pub fn photo(&self) -> Option<&Arc<Photo>> {
        match &self.content {
            Content::Photo(one) => Some(&one.photo),
            Content::Views(_) => None,
        }
    }

    /// The same of another copy of its photo; a recorded light field stays as it is.
    #[must_use]
    pub(super) fn with_photo(mut self, photo: Arc<Photo>) -> Self {
        if let Content::Photo(one) = &mut self.content {
            one.photo = photo;
        }
        self
    }

    /// The views; none for a photo, whose views are made.
    pub fn recorded(&self) -> Option<&Recorded> {
        match &self.content {
            Content::Photo(_) => None,
            Content::Views(recorded) => Some(recorded),
        }
    }

    /// How much each part of the photo, or of the reference view, stands out by its colours. Takes some milliseconds.
    pub fn salience(&self) -> Salience {
        match &self.content {
            Content::Photo(one) => Salience::of(one.photo.size(), |y| one.photo.srgb8_row(y)),
            Content::Views(recorded) => {
                let view = recorded.shown.reference();
                let wide = view.size()[0] as usize * 4;
                Salience::of(view.size(), |y| Cow::Borrowed(&view.rgba()[y * wide..(y + 1) * wide]))
            }
        }
    }

    /// The scene of Gaussian splats, where it is one.
    pub fn splats(&self) -> Option<&Arc<Pictured>> {
        match &self.content {
            Content::Photo(one) => one.splats.as_ref(),
            Content::Views(_) => None,
        }
    }

    /// Focal length as on 35-mm film in millimetres, where the file says it.
    pub fn f35_mm(&self) -> Option<f32> {
        match &self.content {
            Content::Photo(one) => one.f35_mm,
            Content::Views(_) => None,
        }
    }

    /// Width and height of the picture that is looked at.
    pub fn size(&self) -> [u32; 2] {
        match &self.content {
            Content::Photo(one) => one.photo.size(),
            Content::Views(recorded) => recorded.shown.size(),
        }
    }

    /// Width and height of the largest picture that is made of it: more than [`Subject::size`] where the photo was too large to
    /// be kept whole.
    pub fn whole_size(&self) -> [u32; 2] {
        self.photo().map_or_else(|| self.size(), |photo| photo.whole_size())
    }

    /// The same with its views, where it has some, in one block of memory.
    #[must_use]
    pub fn in_one_block(mut self) -> Self {
        if let Content::Views(recorded) = &mut self.content {
            recorded.shown = Arc::clone(&recorded.shown).in_one_block();
        }
        self
    }

    /// The strength that it can have of the one that is wanted: views that were recorded end where they do.
    pub fn strength(&self, wanted: Strength) -> Strength {
        let wanted = wanted.clamped();
        if self.recorded().is_some() { Strength(wanted.0.min(Strength::AS_MADE.0)) } else { wanted }
    }

    /// A photo with a map of one's own; a recorded light field stays as it is.
    #[must_use]
    pub fn with_own_map(mut self, own: GivenDepth) -> Self {
        if let Content::Photo(one) = &mut self.content {
            one.own_map = Some(own);
        }
        self
    }
}

impl From<PhotoFile> for OnePhoto {
    fn from(file: PhotoFile) -> Self {
        let (f35_mm, phone) = (file.info.f35_mm, file.depth.map(Arc::new));
        Self { photo: file.photo, f35_mm, phone, own_map: None, splats: file.splats, truth: None, several: None }
    }
}

impl From<LightFieldFile> for Recorded {
    fn from(file: LightFieldFile) -> Self {
        let shown = file.display_gamma.map(|gamma| Arc::new(brighter(&file.field, gamma)));
        Self {
            stored: shown.is_some().then(|| Arc::clone(&file.field)),
            shown: shown.unwrap_or(file.field),
            depths: file.depths,
            reference: file.reference_disparity.map(Arc::new),
            provenance: file.provenance,
            layout: file.layout,
        }
    }
}

impl Recorded {
    fn between(corners: &[Arc<View>], nets: Option<&CornerNets>, job: &Job) -> Result<Self, SceneError> {
        let (field, depths) = nets.map_or_else(|| corners::between(corners, job), |nets| nets.between(corners, job))?;
        let (shown, depths) = (Arc::new(field), Some(Arc::new(depths)));
        let layout = Layout::default();
        Ok(Self { shown, depths, stored: None, reference: None, provenance: None, layout })
    }

    /// The views as they lie in their files.
    pub fn as_stored(&self) -> &Arc<LightField> {
        self.stored.as_ref().unwrap_or(&self.shown)
    }

    /// The same views in another layout, without disparities: they are to be measured anew.
    #[must_use]
    pub fn laid_out(&self, layout: Layout) -> Self {
        let turn = |field: &Arc<LightField>| Arc::new(layout.apply(&self.layout.undo(field)));
        let (shown, stored) = (turn(&self.shown), self.stored.as_ref().map(turn));
        Self { shown, stored, layout, depths: None, reference: None, provenance: None }
    }
}

/// A dark light field as it should be shown: `shown = stored ^ γ`.
fn brighter(field: &LightField, gamma: f32) -> LightField {
    let table: Vec<u8> = (0..=255u8).map(|v| ((f32::from(v) / 255.0).powf(gamma) * 255.0).round() as u8).collect();
    let shown = |view: &Arc<View>| {
        let rgba = view.rgba().chunks_exact(4);
        let rgba =
            rgba.flat_map(|p| [table[p[0] as usize], table[p[1] as usize], table[p[2] as usize], p[3]]).collect();
        View::new(view.size(), rgba).map_or_else(|_same_size| Arc::clone(view), Arc::new)
    };
    LightField::new(field.grid(), field.views().iter().map(shown).collect()).unwrap_or_else(|_same_views| field.clone())
}
