//! What is open, and how much of its light field is known.

use std::sync::Arc;

use egui::Vec2;

use super::document::Document;
use super::rays::Rays;
use crate::field::{
    DisparityMap, FNumber, Lens, LightField, Photo, Strength, ViewGrid, ViewIndex, ViewOffset, ViewPoint,
};
use crate::scene::trust::Invented;
use crate::scene::{Edit, Focus, Making, Scene, SceneError, Subject};

/// What is open.
#[derive(Default)]
pub enum Open {
    /// Nothing yet.
    #[default]
    Nothing,
    /// A photo, whose light field is being made or is there.
    Photo(Box<OpenPhoto>),
    /// A recorded light field, whose ray depths are being measured or are there.
    LightField(Box<OpenField>),
}

/// A photo.
pub struct OpenPhoto {
    document: Document,
    photo: Arc<Photo>,
    known: Known,
}

/// A recorded light field.
pub struct OpenField {
    document: Document,
    views: Arc<LightField>,
    known: Known,
}

/// What is known of the scene so far.
enum Known {
    /// Neither depth nor other views.
    Nothing,
    /// The ray depths; of a photo views may have come to the device.
    Rays(Rays),
    /// All of it.
    Whole(Box<Made>),
}

/// A finished scene.
#[derive(Clone)]
pub struct Made {
    /// The scene, with all views.
    pub scene: Scene,
    /// Its ray depths, and what they say.
    pub rays: Rays,
    /// How much of each view was invented.
    pub invented: Invented,
}

impl Made {
    /// A scene with all views. Takes some milliseconds, so it is not for the window's thread.
    ///
    /// # Errors
    /// It has no views.
    pub fn of(scene: Scene) -> Result<Self, SceneError> {
        let rays = Rays::about(Arc::clone(&scene.made_views()?.depths), scene.subject_at());
        let invented = scene.trust()?.invented();
        Ok(Self { scene, rays, invented })
    }

    /// Memory that views and ray depths take.
    pub fn bytes(&self) -> usize {
        let rays = size_of_val(self.rays.depths.disparity_px());
        let views = self.scene.views().map_or(&[][..], |views| views.field.views());
        rays + views.iter().map(|view| view.rgba().len()).sum::<usize>()
    }
}

impl Open {
    /// A file that was read; the ray depths that lie in it are taken next.
    pub fn new(document: Document) -> Self {
        let (subject, known) = (Arc::clone(&document.subject), Known::Nothing);
        match (subject.photo().cloned(), subject.recorded()) {
            (Some(photo), _) => Self::Photo(Box::new(OpenPhoto { document, photo, known })),
            (None, Some(recorded)) => {
                Self::LightField(Box::new(OpenField { document, views: Arc::clone(&recorded.shown), known }))
            }
            (None, None) => Self::Nothing,
        }
    }

    /// Ray depths are there before the views.
    pub fn take_rays(&mut self, rays: Rays) {
        match self {
            Self::Nothing => {}
            Self::Photo(open) => open.known = Known::Rays(rays),
            Self::LightField(open) => open.known = Known::Rays(rays),
        }
    }

    /// The light field is complete.
    pub fn take_made(&mut self, made: Made) {
        match self {
            Self::Nothing => {}
            Self::Photo(open) => open.known = Known::Whole(Box::new(made)),
            Self::LightField(open) => {
                open.document.subject = Arc::clone(made.scene.subject());
                if let Some(views) = made.scene.views() {
                    open.views = Arc::clone(&views.field);
                }
                open.known = Known::Whole(Box::new(made));
            }
        }
    }

    /// What was read.
    pub fn document(&self) -> Option<&Document> {
        match self {
            Self::Nothing => None,
            Self::Photo(open) => Some(&open.document),
            Self::LightField(open) => Some(&open.document),
        }
    }

    /// As [`Open::document`], to give it a map or what lies beside it.
    pub fn document_mut(&mut self) -> Option<&mut Document> {
        match self {
            Self::Nothing => None,
            Self::Photo(open) => Some(&mut open.document),
            Self::LightField(open) => Some(&mut open.document),
        }
    }

    /// The photo or light field itself.
    pub fn subject(&self) -> Option<&Arc<Subject>> {
        self.document().map(|document| &document.subject)
    }

    /// The photo.
    pub fn photo(&self) -> Option<&Arc<Photo>> {
        if let Self::Photo(open) = self { Some(&open.photo) } else { None }
    }

    fn known(&self) -> &Known {
        match self {
            Self::Nothing => &Known::Nothing,
            Self::Photo(open) => &open.known,
            Self::LightField(open) => &open.known,
        }
    }

    /// The scene, once it is complete: what pictures are made of.
    pub fn scene(&self) -> Option<&Scene> {
        if let Known::Whole(made) = self.known() { Some(&made.scene) } else { None }
    }

    /// How much of each view was invented, once all is known.
    pub fn invented(&self) -> Option<&Invented> {
        if let Known::Whole(made) = self.known() { Some(&made.invented) } else { None }
    }

    /// Its ray depths.
    pub fn rays(&self) -> Option<&Rays> {
        match self.known() {
            Known::Nothing => None,
            Known::Rays(rays) => Some(rays),
            Known::Whole(made) => Some(&made.rays),
        }
    }

    /// The views, once all are there.
    pub fn field(&self) -> Option<&Arc<LightField>> {
        match self {
            Self::LightField(open) => Some(&open.views),
            _ => Some(&self.scene()?.views()?.field),
        }
    }

    /// Width and height of the picture that is looked at.
    pub fn size(&self) -> Option<[u32; 2]> {
        self.subject().map(|subject| subject.size())
    }

    /// As [`Open::size`], for what is laid out on the screen.
    pub fn picture_size(&self) -> Option<Vec2> {
        self.size().map(|[w, h]| Vec2::new(w as f32, h as f32))
    }

    /// The grid of views, once there is one.
    pub fn grid(&self) -> Option<ViewGrid> {
        let of_field = self.field().map(|field| field.grid());
        of_field.or_else(|| self.rays().map(|rays| rays.depths.grid()))
    }

    /// The view that is nearest to the eye.
    pub fn nearest_view(&self, eye: ViewPoint) -> Option<ViewIndex> {
        self.grid().map(|grid| grid.nearest(eye.0))
    }

    /// The disparity that is seen at a place of a view, x and y from 0 to 1, in pixels per view step.
    pub fn disparity_at(&self, view: Option<ViewIndex>, place: Vec2) -> Option<f32> {
        Some(self.rays()?.disparity_at(view?, [place.x, place.y]))
    }

    /// Width of the views, in whose pixels people read disparities.
    fn width(&self) -> u32 {
        self.rays().map_or(Making::LONG_SIDE, |rays| rays.depths.size()[0])
    }

    /// The lens of an edit, in pixels of the views' width. Without depth, what is to be in focus lies at 0.
    pub fn lens(&self, edit: &Edit) -> Lens {
        match (self.scene(), self.rays()) {
            (Some(scene), _) => scene.lens_at(edit, self.width()),
            (None, Some(rays)) => rays.lens(edit),
            (None, None) => {
                edit.lens(&DisparityMap::constant([1, 1], 0.0), Strength::AS_MADE).scaled(self.width() as f32)
            }
        }
    }

    /// The strength of what is shown, which is another than the edit's until that is made.
    pub fn strength(&self) -> Strength {
        self.scene().map_or(Strength::AS_MADE, Scene::strength)
    }

    /// The strength that an edit asks for of what is open, where that is not there yet.
    pub fn wanted_strength(&self, edit: &Edit) -> Option<Strength> {
        let scene = self.scene()?;
        Some(scene.subject().strength(edit.strength)).filter(|wanted| *wanted != scene.strength())
    }

    /// The edit as the views that are there can draft it: at another strength a lens is as much wider, and an eye as much
    /// farther out.
    pub fn drafted(&self, edit: &Edit) -> Edit {
        let Some(wanted) = self.wanted_strength(edit) else { return edit.clone() };
        let ratio = wanted.0 / self.strength().0;
        let at = edit.viewpoint.0;
        let viewpoint = ViewPoint(ViewOffset { dv: at.dv * ratio, du: at.du * ratio });
        Edit { f_number: FNumber::adding(edit.f_number.added_views() * ratio), viewpoint, ..edit.clone() }
    }

    /// Puts a lens that was turned by hand into the edit it came of. What is in focus stays, unless that was turned.
    pub fn turn(&self, edit: &mut Edit, before: &Lens, after: &Lens) {
        if before == after {
            return;
        }
        let (focus, tilt, keep_sharp) = (edit.focus, edit.tilt, edit.keep_sharp);
        *edit = std::mem::take(edit).with_lens(after, self.width(), self.strength());
        if before.keep_sharp_px == after.keep_sharp_px {
            edit.keep_sharp = keep_sharp;
        }
        // What is solved for places has no tilt of its own.
        let is_solved = matches!(focus, Focus::Through(places) if places.all().len() > 1);
        let is_as_it_was = before.focus.disparity_px == after.focus.disparity_px;
        if is_as_it_was && (!is_solved || before.focus.tilt_px == after.focus.tilt_px) {
            edit.focus = focus;
        }
        if before.focus.tilt_px == after.focus.tilt_px && edit.focus == focus {
            edit.tilt = tilt;
        }
    }
}
