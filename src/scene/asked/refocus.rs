//! A refocused picture, as it was asked for: a recipe, what goes before it, and how the picture is kept.

use std::sync::Arc;

use super::{How, LensAsked, Usage};
use crate::field::{ViewOffset, ViewPoint};
use crate::io::save::Keep;
use crate::job::Job;
use crate::scene::export::{Kind, Settings};
use crate::scene::recipe::PictureSettings;
use crate::scene::{Edit, Embed, Maker, OutputSize, Scene, SceneError, Subject};

/// What is asked for; none leaves it to the recipe, and without one to the photo.
#[derive(Clone, Debug, Default)]
pub struct Refocus {
    /// The lens.
    pub lens: LensAsked,
    /// Where the lens stands, in steps from the reference view.
    pub at: Option<ViewOffset>,
    /// How large the picture becomes.
    pub size: Option<OutputSize>,
    /// Quality of a JPEG, 1 … 100.
    pub quality: Option<u8>,
    /// Bits of a channel, 8 or 16.
    pub bits: Option<u8>,
    /// What of the edit goes into the picture.
    pub embed: Option<Embed>,
    /// Leaves EXIF and XMP out.
    pub strip_metadata: bool,
    /// Whether the photo's own file may be written over.
    pub replaces_source: bool,
}

/// The scene, and what is to be done with it.
pub struct Asked {
    /// Of which as much is made as the picture needs.
    pub scene: Scene,
    /// The edit.
    pub edit: Edit,
    /// How the picture is kept.
    pub settings: Settings,
}

impl Refocus {
    /// Makes what the picture of a subject needs.
    ///
    /// # Errors
    /// [`SceneError`]; [`SceneError::Usage`] for what this photo cannot become.
    pub fn of(&self, subject: &Arc<Subject>, how: &How, maker: &Maker, job: &Job) -> Result<Asked, SceneError> {
        let settings = self.settings(how, subject, job)?;
        let scene = how.scene_of_picture(subject, maker, Kind::Picture.need(settings.size()), job)?;
        self.of_scene(scene, how, settings)
    }

    /// The same of a scene that is made already.
    ///
    /// # Errors
    /// [`SceneError`], as above.
    pub fn of_made(&self, scene: &Scene, how: &How, job: &Job) -> Result<Asked, SceneError> {
        let settings = self.settings(how, scene.subject(), job)?;
        self.of_scene(how.made(scene, job)?, how, settings)
    }

    fn of_scene(&self, scene: Scene, how: &How, settings: Settings) -> Result<Asked, SceneError> {
        let edit = how.edit(&self.lens, &scene)?;
        let viewpoint = self.at.map_or(edit.viewpoint, ViewPoint);
        Ok(Asked { scene, edit: Edit { viewpoint, ..edit }, settings })
    }

    /// How the picture is kept: as the recipe says, else with the photo's own bits.
    fn settings(&self, how: &How, subject: &Subject, job: &Job) -> Result<Settings, Usage> {
        let bits = subject.photo().map_or(8, |photo| photo.pixels().bits());
        let plain = || PictureSettings { bits, ..PictureSettings::default() };
        let mut picture = how.recipe().map_or_else(plain, |recipe| recipe.export.clone());
        picture.bits = self.bits.unwrap_or(picture.bits);
        picture.quality = self.quality.unwrap_or(picture.quality);
        picture.embed = self.embed.unwrap_or(picture.embed);
        if self.strip_metadata {
            picture.keep = Keep::Nothing;
        }
        if let Some(size) = self.size {
            picture.size = size;
            told(size, subject.whole_size(), job)?;
        }
        let (recipe, replaces_source) = (how.edited(), self.replaces_source);
        Ok(Settings { picture, recipe, replaces_source, ..Settings::default() })
    }
}

/// Nothing is enlarged, and a photo keeps its shape: the person is told where that changes what was asked for.
fn told(size: OutputSize, photo: [u32; 2], job: &Job) -> Result<(), Usage> {
    let OutputSize::Within(wanted) = size else { return Ok(()) };
    if wanted[0] > photo[0] || wanted[1] > photo[1] {
        let [width, height] = photo;
        return Err(Usage(format!(
            "the picture would be larger than the photo — nothing is enlarged — at most {width}x{height}"
        )));
    }
    let [width, height] = size.of(photo);
    if [width, height] != wanted {
        job.sink.warning(format!("the photo's shape is kept: the picture has {width}x{height} pixels"));
    }
    Ok(())
}
