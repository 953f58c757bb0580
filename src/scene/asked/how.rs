//! From a file to what is known of its depth, as it was asked for.

use std::path::Path;
use std::sync::Arc;

use super::{LensAsked, Usage};
use crate::io::formats::depth_map::GivenDepth;
use crate::job::Job;
use crate::scene::{DepthFrom, Edit, Maker, Making, Need, Recipe, Restored, Scene, SceneError, Subject};

/// How light fields are made of photos: what holds for all of them, a map of one's own, and an edit that is given.
#[derive(Clone, Debug, Default)]
pub struct How {
    making: Making,
    own_map: Option<GivenDepth>,
    recipe: Option<Recipe>,
    /// The photo that the edit came out of a picture with.
    restored: Option<Subject>,
}

impl How {
    /// As `making` says; a map goes before every other source of depth, and what is asked for before the recipe.
    pub fn new(making: Making, own_map: Option<GivenDepth>, recipe: Option<Recipe>) -> Self {
        let source = if own_map.is_some() { DepthFrom::Map } else { making.source };
        let making = Making { source, ..making };
        let making = recipe.as_ref().map_or_else(|| making.clone(), |recipe| making.with_recipe(recipe));
        Self { making, own_map, recipe, restored: None }
    }

    /// The same with the edit that a picture carries, and the photo that the picture was made of.
    #[must_use]
    pub fn restored(self, Restored { subject, recipe }: Restored) -> Self {
        Self { restored: Some(subject), ..Self::new(self.making, self.own_map, Some(recipe)) }
    }

    /// How scenes are made.
    pub fn making(&self) -> &Making {
        &self.making
    }

    /// The map of one's own.
    pub fn own_map(&self) -> Option<&GivenDepth> {
        self.own_map.as_ref()
    }

    /// The edit that is given.
    pub fn recipe(&self) -> Option<&Recipe> {
        self.recipe.as_ref()
    }

    /// Opens a photo or a light field; a photo with the map. Of a picture with an edit in use, the photo that it was made of.
    pub fn open(&self, path: &Path, job: &Job) -> Result<Arc<Subject>, SceneError> {
        Ok(self.subject(match &self.restored {
            Some(subject) => subject.clone(),
            None => Subject::open(path, job)?,
        }))
    }

    /// What is open already, with the map.
    pub fn subject(&self, subject: Subject) -> Arc<Subject> {
        Arc::new(match &self.own_map {
            Some(map) => subject.with_own_map(map.clone()),
            None => subject,
        })
    }

    /// The edit that is given, and where the depth comes from: what goes into a picture.
    pub fn edited(&self) -> Recipe {
        self.recipe.clone().unwrap_or_default().of_depth(self.making.source.clone())
    }

    /// What is needed of a subject.
    pub fn scene(&self, subject: &Arc<Subject>, maker: &Maker, need: Need, job: &Job) -> Result<Scene, SceneError> {
        maker.scene(subject, &self.making, need, job)
    }

    /// The scene of one picture: a map that is given spares all nets.
    pub fn scene_of_picture(
        &self,
        subject: &Arc<Subject>,
        maker: &Maker,
        need: Need,
        job: &Job,
    ) -> Result<Scene, SceneError> {
        let occlusion = self.making.occlusion && self.own_map.is_none();
        maker.scene(subject, &Making { occlusion, ..self.making.clone() }, need, job)
    }

    /// A scene that is made already, with the repairs of the recipe where there is one.
    pub fn made(&self, scene: &Scene, job: &Job) -> Result<Scene, SceneError> {
        match &self.recipe {
            Some(recipe) => scene.mended(&recipe.repairs, job),
            None => Ok(scene.clone()),
        }
    }

    /// What is asked for of the lens, over the recipe's edit or the plain one.
    ///
    /// # Errors
    /// A focus outside the picture.
    pub fn edit(&self, lens: &LensAsked, scene: &Scene) -> Result<Edit, Usage> {
        let width = scene.map().size()[0];
        lens.edit(self.recipe.as_ref().map_or_else(LensAsked::plain, |recipe| recipe.edit(width)), scene)
    }
}
