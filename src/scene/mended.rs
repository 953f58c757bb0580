//! A scene whose depth was mended by hand: the one place where repairs are done, whatever the depth came from.
//!
//! Repairs change the map of the reference view, which the lens and all exports of a map read. Other views follow without
//! a net ([`carry`]). The views of a recorded light field stay as they were seen: only their rays' depths follow.

use std::sync::Arc;

use super::picture::{MadeViews, Scene};
use super::{SceneError, Subject};
use crate::field::{DisparityMap, View};
use crate::job::Job;
use crate::repair::{self, Guide, Mender, PhotoSign, Repairs};
use crate::synth::carry::{self, Colours};
use crate::synth::reference_view;

/// Said where the repairs are another photo's.
pub const OTHER_PHOTO: &str = "the repairs of this edit are of another photo, so they are left out — the rest of it is applied, and its file keeps them";

impl Subject {
    /// What the photo looks like from afar; of a light field its reference view.
    pub fn sign(&self) -> PhotoSign {
        match (self.photo(), self.recorded()) {
            (Some(photo), _) => PhotoSign::of(photo),
            (None, Some(recorded)) => {
                let view = recorded.shown.reference();
                PhotoSign::of_pixels(view.size(), view.rgba())
            }
            (None, None) => PhotoSign::of_pixels([1, 1], &[0; 4]),
        }
    }

    /// The photo's colours at about the size of a map.
    fn colours(&self, long_side: u32, job: &Job) -> Result<Arc<View>, SceneError> {
        match (self.photo(), self.recorded()) {
            (None, Some(recorded)) => Ok(Arc::clone(recorded.shown.reference())),
            (Some(photo), _) => Ok(Arc::new(reference_view(photo, long_side, job)?)),
            (None, None) => Ok(Arc::new(View::new([1, 1], vec![0; 4])?)),
        }
    }
}

impl Scene {
    /// The scene with repairs done to its depth as it was made; those of another photo are left out. The sink hears of
    /// what could not be done.
    ///
    /// # Errors
    /// [`SceneError`]: stopped.
    pub fn mended(&self, repairs: &Repairs, job: &Job) -> Result<Self, SceneError> {
        let first = self.as_made().unmended();
        if repairs.is_empty() {
            return Ok(first.clone());
        }
        if !repairs.are_of(&self.subject().sign()) {
            job.sink.warning(OTHER_PHOTO.to_owned());
            return Ok(first.clone().with_repairs(repairs));
        }
        repairs.left_out().into_iter().for_each(|text| job.sink.warning(text));
        let guide = first.guide(job)?;
        let usable: Vec<_> = repairs.usable().collect();
        let map = Arc::new(repair::mended(first.map(), guide, &usable, job)??);
        let views = first.views().map(|views| first.carried(views, &map, job)).transpose()?;
        Ok(first.with_mended(map, views)?.with_repairs(repairs))
    }

    /// What repairs are made with: the map as it is, and the photo's colours.
    ///
    /// # Errors
    /// Stopped.
    pub fn mender(&self, job: &Job) -> Result<Mender, SceneError> {
        Ok(Mender::new(self.map(), self.guide(job)?))
    }

    fn guide(&self, job: &Job) -> Result<Guide, SceneError> {
        let size = self.map().size();
        let colours = self.subject().colours(size[0].max(size[1]), job)?;
        Ok(Guide::new(&colours, size))
    }

    /// Views for another map than this scene's.
    fn carried(&self, views: &MadeViews, map: &DisparityMap, job: &Job) -> Result<MadeViews, SceneError> {
        let size = views.field.size();
        let colours = if self.subject().photo().is_some() { Colours::Photo } else { Colours::Recorded };
        let maps = [&self.map().resized(size)?, &map.resized(size)?];
        let (field, depths) = carry::carried((&views.field, &views.depths), maps, colours, job)?;
        Ok(MadeViews { field, depths, provenance: views.provenance.clone() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{Strength, ViewIndex};
    use crate::io::formats::depth_map::GivenDepth;
    use crate::job::{Cancel, Told};
    use crate::repair::{Operation, Region, Repair};
    use crate::scene::{Content, DepthFrom, Edit, Focus, Maker, Making, Need, OutputSize, Recipe, Recorded};

    /// The sample with its true map.
    fn subject() -> Arc<Subject> {
        let sample = Subject::sample().unwrap();
        let Content::Photo(one) = &sample.content else { panic!("the sample is a photo") };
        let truth = GivenDepth::Disparity(Arc::clone(one.truth.as_ref().unwrap()));
        Arc::new(sample.with_own_map(truth))
    }

    fn making(repairs: Repairs) -> Making {
        Making { long_side: 96, occlusion: false, source: DepthFrom::Map, repairs, ..Making::default() }
    }

    fn scene(subject: &Arc<Subject>, repairs: &Repairs, need: Need) -> (Scene, Vec<String>) {
        let told = Told::default();
        let job = Job { cancel: &Cancel::default(), sink: &told };
        let scene = Maker::default().scene(subject, &making(repairs.clone()), need, &job).unwrap();
        (scene, told.take())
    }

    /// The flower's head goes far back.
    fn repairs(subject: &Subject) -> Repairs {
        let of = Region::Click { at: [0.43, 0.42], size: 0.15 };
        let repair = Repair::Region { of, what: Operation::Farther(3e-3) };
        Repairs::default().with(repair, Some(&subject.sign())).unwrap()
    }

    #[test]
    fn map_views_and_pictures_follow_and_nothing_done_is_what_was_made() {
        let subject = subject();
        let list = repairs(&subject);
        let (plain, _) = scene(&subject, &Repairs::default(), Need::Views);
        let (mended, told) = scene(&subject, &list, Need::Views);
        assert!(told.is_empty(), "{told:?}");
        let at =
            |scene: &Scene| crate::scene::focus::disparity_at(scene.map(), [0.43, 0.42]) / scene.map().size()[0] as f32;
        assert!((at(&plain) - at(&mended) - 3e-3).abs() < 2e-4, "{} and {}", at(&plain), at(&mended));
        let rays = |scene: &Scene| scene.made_views().unwrap().depths.map(ViewIndex { v: 1, u: 6 });
        assert!(rays(&plain) != rays(&mended));
        // One map alone is mended as that of the views is.
        assert_eq!(scene(&subject, &list, Need::Map).0.map(), mended.map());
        let edit = Edit { focus: Focus::Disparity(0.0), ..Edit::default() };
        let job = Job { cancel: &Cancel::default(), sink: &() };
        let picture = |scene: &Scene| scene.shown(&edit, OutputSize::LongSide(120), &job).unwrap();
        assert!(picture(&plain).rgb_linear != picture(&mended).rgb_linear);
        let again = mended.mended(&Repairs::default(), &job).unwrap();
        assert!(Arc::ptr_eq(again.map(), mended.unmended().map()));
        assert_eq!(**again.map(), **plain.map());
        assert_eq!(again.made_views().unwrap().field, plain.made_views().unwrap().field);
        // Undone one by one: the list is done to what was made, not to what was mended.
        let twice = list.with(list.usable().next().unwrap().clone(), None).unwrap();
        let back = mended.mended(&twice, &job).unwrap().mended(&twice.without(1), &job).unwrap();
        assert_eq!(back.map(), mended.map());
        assert_eq!(back.made_views().unwrap().field, mended.made_views().unwrap().field);
    }

    #[test]
    fn the_focus_stays_where_it_was_while_something_else_is_mended() {
        let subject = subject();
        let (plain, _) = scene(&subject, &Repairs::default(), Need::Map);
        // What the scene is about goes behind all else: it is still what the scene is about.
        let [x, y] = plain.subject_at();
        let outline = [[x - 0.2, y - 0.2], [x + 0.2, y - 0.2], [x + 0.2, y + 0.2], [x - 0.2, y + 0.2]].to_vec();
        let far = Repair::Region { of: Region::Lasso { outline, snap: 0.0 }, what: Operation::Farther(1e-2) };
        let list = Repairs::default().with(far, Some(&subject.sign())).unwrap();
        let (mended, _) = scene(&subject, &list, Need::Map);
        let found = crate::scene::focus::subject(mended.map(), &mended.subject().salience());
        assert!(found != [x, y], "looked for anew, it would be another thing");
        assert_eq!(mended.subject_at(), [x, y]);
    }

    #[test]
    fn at_another_strength_a_repair_moves_the_same_thing_as_much_more() {
        let (subject, strong) = (subject(), Strength(2.0));
        let list = repairs(&subject);
        let job = Job { cancel: &Cancel::default(), sink: &() };
        let (mended, _) = scene(&subject, &list, Need::Views);
        let made = |repairs: &Repairs| {
            let how = Making { strength: Some(strong), ..making(repairs.clone()) };
            Maker::default().scene(&subject, &how, Need::Views, &job).unwrap()
        };
        let (deep, plain) = (made(&list), made(&Repairs::default()));
        let is_double = |one: &[f32], two: &[f32]| one.iter().zip(two).all(|(one, two)| (two - 2.0 * one).abs() < 1e-4);
        assert!(is_double(mended.map().disparity_px(), deep.map().disparity_px()));
        let views = [&mended, &deep, &plain].map(|scene| scene.made_views().unwrap());
        assert!(is_double(views[0].depths.reference(), views[1].depths.reference()));
        assert_eq!(views[0].field.reference(), views[1].field.reference());
        let view = |at: usize, u| views[at].field.view(ViewIndex { v: 4, u }).rgba();
        let apart = |a: &[u8], b: &[u8]| a.iter().zip(b).map(|(a, b)| u32::from(a.abs_diff(*b))).sum::<u32>();
        // One step at twice the strength is two steps at once; and other views follow the repair.
        assert!(apart(view(1, 5), view(0, 6)) * 2 < apart(view(1, 5), view(0, 5)));
        assert!(apart(view(1, 5), view(0, 6)) < apart(view(2, 5), view(0, 6)));
        // What was mended at a strength is what was mended without.
        let back = deep.at_strength(Strength::AS_MADE, &making(list.clone()), Need::Views, &job).unwrap();
        assert_eq!(back.map(), mended.map());
        let again = deep.mended(&list, &job).unwrap().at_strength(strong, &making(list), Need::Map, &job).unwrap();
        assert_eq!(again.map(), deep.map());
    }

    #[test]
    fn a_recipe_takes_its_repairs_along_but_not_to_another_photo() {
        let subject = subject();
        let list = repairs(&subject);
        let recipe = Recipe::from_json(&Recipe::default().with_repairs(list.clone()).to_json()).unwrap();
        assert_eq!(recipe.repairs, list);
        assert_eq!(making(Repairs::default()).with_recipe(&recipe).repairs, list);
        let size = [120, 80];
        let other = crate::field::Photo::from_srgb8(size, vec![90; 120 * 80 * 4]).unwrap();
        let other = Subject::from_photo(Arc::new(other), "other");
        let flat = GivenDepth::Disparity(Arc::new(DisparityMap::constant(size, 0.5)));
        let (left, told) = scene(&Arc::new(other.with_own_map(flat)), &list, Need::Map);
        assert_eq!(left.map().range_px(), [0.5, 0.5]);
        assert!(told.len() == 1 && told[0].contains("another photo"), "{told:?}");
        let gone: serde_json::Value = serde_json::from_str(&recipe.with_repairs(Repairs::default()).to_json()).unwrap();
        assert!(gone.get("repairs").is_none());
    }

    #[test]
    fn of_a_recorded_light_field_rays_follow_and_views_stay() {
        let (photo, _) = scene(&subject(), &Repairs::default(), Need::Views);
        let MadeViews { field, depths, .. } = photo.made_views().unwrap().clone();
        let (shown, depths) = (Arc::clone(&field), Some(Arc::clone(&depths)));
        let content = Content::Views(Recorded {
            shown,
            stored: None,
            depths,
            reference: None,
            provenance: None,
            layout: Default::default(),
        });
        let recorded = Arc::new(Subject { name: String::new(), path: None, file: None, info: None, content });
        let (mended, told) = scene(&recorded, &repairs(&recorded), Need::Views);
        assert!(told.is_empty(), "{told:?}");
        let views = mended.made_views().unwrap();
        assert_eq!(*views.field, *field);
        assert!(views.depths.reference() != photo.made_views().unwrap().depths.reference());
        assert_eq!(views.depths.reference_map(), **mended.map());
    }
}
