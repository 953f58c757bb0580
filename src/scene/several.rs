//! A subject of several photos: one is looked at, the others saw more of it.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use rayon::prelude::*;

use super::picture::{MadeBy, MadeViews, Scene};
use super::{Content, Making, Need, OnePhoto, SceneError, Subject};
use crate::burst::{self, BurstError, Solved};
use crate::errors::sentence;
use crate::field::{DisparityMap, Metadata, Photo, PhotoPixels, Provenance, Seen, Size, View};
use crate::io::{PhotoFile, several};
use crate::job::{Job, Stage};
use crate::synth::{SynthError, SynthParams, Synthesis, Synthesizer, reference_view, synthesize_bared, tract};

/// Shapes that differ by more than this part are of other cameras, or turned.
const SAME_SHAPE: f32 = 0.02;
/// The same for focal lengths.
const SAME_LENS: f32 = 0.03;

/// Photos beside the one that is looked at. They are read when they are first needed, so that the one is seen at once.
#[derive(Debug)]
pub struct Several {
    /// The other pictures of the file that is looked at.
    own: Vec<Other>,
    /// The other files.
    files: Vec<PathBuf>,
    frames: Mutex<Option<Arc<[Other]>>>,
    /// How much of the baseline the light field takes; none where the scene says it.
    share: Option<f64>,
    solved: Mutex<Option<Outcome>>,
}

/// One of them.
#[derive(Clone, Debug)]
struct Other {
    /// What it is called.
    name: String,
    /// A small copy.
    view: View,
    /// Its file, and which picture of it.
    source: (PathBuf, usize),
}

/// What they told, or why nothing.
type Outcome = Result<Arc<Solved>, String>;

/// What is asked for of several photos.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SeveralAsked {
    /// Which of the photos is looked at, from 0.
    pub reference: usize,
    /// How much of the baseline that was there lies between the reference view and the outermost ones.
    pub share: Option<f64>,
    /// Whether the photo that is looked at takes the others' mean where they agree, which has less noise.
    pub denoise: bool,
}

/// What is known of a light field of several photos, for people and for programs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeveralFound {
    /// Photos that were used, with the reference photo.
    pub used: usize,
    /// Median distance of where things are from where the cameras see them, in pixels of a picture of 1280.
    pub reprojection_px: f64,
    /// How much of the baseline lies between the reference view and the outermost ones.
    pub share: f64,
}

impl Subject {
    /// Opens photos of one subject: files, folders, pictures that hold several. The others are read when a scene is made;
    /// what cannot be used of them is told of then, and left out.
    ///
    /// # Errors
    /// The reference photo cannot be opened, or there is none of that number.
    pub fn open_several(paths: &[PathBuf], asked: SeveralAsked, job: &Job) -> Result<Self, SceneError> {
        let files = several::listed(paths)?;
        let path = files.get(asked.reference).ok_or_else(|| {
            let (number, count) = (asked.reference + 1, files.len());
            SceneError::Refused(format!(
                "there is no photo {number} — {count} were given — name another as --reference"
            ))
        })?;
        let mut own = several::photos(path, job)?.into_iter();
        let Some(first) = own.next() else { return Self::open(path, job) };
        first.warnings.iter().for_each(|warning| job.sink.warning(warning.clone()));
        let facts = (first.photo.size(), first.info.f35_mm);
        let small =
            |(n, other): (usize, PhotoFile)| small(&other, &format!("picture {}", n + 2), (path, n + 1), facts, job);
        let own = own.enumerate().map(small).collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect();
        let files = others(&files, asked.reference, job);
        let several = Several { own, files, frames: Mutex::default(), share: asked.share, solved: Mutex::default() };
        let mut subject = Self::from_opened(first.into(), path);
        if let Content::Photo(one) = &mut subject.content {
            if asked.denoise {
                one.photo = several.denoised(one, job)?;
            }
            one.several = Some(Arc::new(several));
        }
        Ok(subject)
    }
}

/// All files but one, evenly chosen where there are too many.
fn others(files: &[PathBuf], reference: usize, job: &Job) -> Vec<PathBuf> {
    let rest: Vec<PathBuf> =
        files.iter().enumerate().filter(|(i, _)| *i != reference).map(|(_, path)| path.clone()).collect();
    let most = burst::MOST - 1;
    if rest.len() <= most {
        return rest;
    }
    let (count, used) = (files.len(), most + 1);
    job.sink.warning(format!("{count} photos are more than are needed: {used} of them are used, evenly apart"));
    (0..most).map(|i| rest[i * rest.len() / most].clone()).collect()
}

/// The frames of files, for a photo of a size and a focal length.
fn read(files: &[PathBuf], facts: (Size, Option<f32>), job: &Job) -> Result<Vec<Other>, SceneError> {
    let (done, total) = (AtomicU32::new(0), files.len() as u32);
    let read = |path: &PathBuf| -> Result<Vec<Other>, SceneError> {
        job.check()?;
        let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        let found = match several::photos(path, job) {
            Ok(files) => {
                let small = |(n, file): (usize, &PhotoFile)| small(file, &name, (path, n), facts, job);
                files.iter().enumerate().map(small).collect::<Result<Vec<_>, _>>()?
            }
            Err(error) => {
                job.check()?;
                job.sink.warning(format!("{} — it is left out", sentence(&error)));
                Vec::new()
            }
        };
        job.advance(Stage::Open, done.fetch_add(1, Ordering::Relaxed) + 1, total)?;
        Ok(found.into_iter().flatten().collect())
    };
    Ok(files.par_iter().map(read).collect::<Result<Vec<_>, _>>()?.concat())
}

/// A frame as small as it is needed; none, and the person is told, where it is not of the reference photo's camera.
fn small(
    file: &PhotoFile,
    name: &str,
    source: (&Path, usize),
    (size, f35_mm): (Size, Option<f32>),
    job: &Job,
) -> Result<Option<Other>, SceneError> {
    let shape = |size: Size| size[0] as f32 / size[1] as f32;
    let differs = |a: f32, b: f32, by: f32| (a / b - 1.0).abs() > by;
    let why = match (file.info.f35_mm, f35_mm) {
        _ if differs(shape(file.photo.size()), shape(size), SAME_SHAPE) => "it has another shape",
        (Some(a), Some(b)) if differs(a, b, SAME_LENS) => "it was taken with another lens or zoom",
        _ => {
            let view = reference_view(&file.photo, burst::FRAME_LONG_SIDE, job)?;
            return Ok(Some(Other { name: name.to_owned(), view, source: (source.0.to_owned(), source.1) }));
        }
    };
    job.sink.warning(format!("{name} is left out — {why} than the first photo"));
    Ok(None)
}

impl Several {
    /// How many other photos there are.
    pub fn count(&self) -> usize {
        self.own.len() + self.files.len()
    }

    /// The other photos that can be used, read once.
    fn frames(&self, one: &OnePhoto, job: &Job) -> Result<Arc<[Other]>, SceneError> {
        let mut known = self.frames.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(frames) = &*known {
            return Ok(Arc::clone(frames));
        }
        let frames: Arc<[Other]> =
            [self.own.clone(), read(&self.files, (one.photo.size(), one.f35_mm), job)?].concat().into();
        *known = Some(Arc::clone(&frames));
        Ok(frames)
    }

    /// What the photos tell, found once; none, and the person is told, where they tell nothing.
    fn solved(&self, one: &OnePhoto, job: &Job) -> Result<Option<Arc<Solved>>, SceneError> {
        let mut known = self.solved.lock().unwrap_or_else(PoisonError::into_inner);
        if known.is_none() {
            *known = Some(self.solve(one, job)?);
        }
        match known.as_ref() {
            Some(Ok(solved)) => Ok(Some(Arc::clone(solved))),
            Some(Err(why)) => {
                job.sink.warning(why.clone());
                Ok(None)
            }
            None => Ok(None),
        }
    }

    fn solve(&self, one: &OnePhoto, job: &Job) -> Result<Outcome, SceneError> {
        let others = self.frames(one, job)?;
        if others.is_empty() {
            return Ok(Err("only one photo can be used; its other views are made".to_owned()));
        }
        let reference = reference_view(&one.photo, burst::FRAME_LONG_SIDE, job)?;
        let frames: Vec<View> = others.iter().map(|other| other.view.clone()).collect();
        let solved = match burst::solve(&reference, &frames, one.f35_mm, job) {
            Ok(solved) => solved,
            Err(BurstError::Cancelled(stopped)) => return Err(stopped.into()),
            Err(BurstError::Synth(error)) => return Err(error.into()),
            Err(error) => return Ok(Err(sentence(&error))),
        };
        let is_out = |i: usize| solved.posed.poses[i].is_none();
        let out: Vec<&str> = (0..frames.len()).filter(|i| is_out(*i)).map(|i| others[i].name.as_str()).collect();
        if !out.is_empty() {
            job.sink.warning(format!("Photos that do not fit are left out: {}", out.join(", ")));
        }
        Ok(Ok(Arc::new(solved)))
    }

    /// The photo with less noise, where the others can be brought over it; its colours are sRGB then.
    fn denoised(&self, one: &OnePhoto, job: &Job) -> Result<Arc<Photo>, SceneError> {
        let Some(solved) = self.solved(one, job)? else { return Ok(Arc::clone(&one.photo)) };
        let others = self.frames(one, job)?;
        let whole = |photo: &Photo| View::new(photo.size(), photo.srgb8().to_vec()).map_err(SynthError::from);
        let frame = |i: usize| -> Result<Option<View>, SceneError> {
            let (path, n) = &others[i].source;
            let files = several::photos(path, job)?;
            files.get(*n).map(|file| whole(&file.photo).map_err(SceneError::from)).transpose()
        };
        let view = solved.denoised(&whole(&one.photo)?, frame, job)?;
        let pixels = Arc::new(view.into_rgba());
        let metadata = Metadata { icc: None, ..one.photo.metadata().clone() };
        let photo = Photo::new(one.photo.size(), PhotoPixels::Eight(Arc::clone(&pixels)), pixels, metadata);
        let photo = photo.map_err(SynthError::from)?;
        Ok(Arc::new(match one.photo.source() {
            Some(source) => photo.with_source(source),
            None => photo,
        }))
    }

    /// What was found, where it was.
    fn known(&self) -> Option<Arc<Solved>> {
        let known = self.solved.lock().unwrap_or_else(PoisonError::into_inner);
        known.as_ref().and_then(|outcome| outcome.as_ref().ok().cloned())
    }

    /// What was found, for people and for programs.
    pub fn found(&self) -> Option<SeveralFound> {
        let solved = self.known()?;
        let (_, share) = solved.step(self.share);
        let (used, reprojection_px) = (solved.frames.len() + 1, solved.posed.reprojection_px);
        Some(SeveralFound { used, reprojection_px, share })
    }
}

/// A scene of several photos; none where they tell nothing.
pub(super) fn scene(
    subject: &Arc<Subject>,
    one: &OnePhoto,
    nets: Option<(&Synthesizer, Option<&DisparityMap>)>,
    (params, need): (&SynthParams, Need),
    how: &Making,
    job: &Job,
) -> Result<Option<Scene>, SceneError> {
    let Some(several) = &one.several else { return Ok(None) };
    let pool = tract::pool(how.threads).map_err(|error| SynthError::Threads(error.to_string()))?;
    let Some(solved) = pool.install(|| several.solved(one, job))? else { return Ok(None) };
    let guess = nets.and_then(|nets| nets.1);
    let solved = match guess {
        Some(guess) => solved.with_sides_of(guess)?,
        None => solved,
    };
    *several.solved.lock().unwrap_or_else(PoisonError::into_inner) = Some(Ok(Arc::clone(&solved)));
    let (step, _) = solved.step(several.share);
    let map = pool.install(|| -> Result<_, SceneError> {
        let reference = reference_view(&one.photo, params.long_side, job)?;
        Ok(Arc::new(solved.map(&reference, guess, step, job)?))
    })?;
    let mut made_by = MadeBy::named(&format!("{} photos", solved.frames.len() + 1));
    let params = SynthParams { disparity: Some(Arc::clone(&map)), ..params.clone() };
    if need == Need::Map {
        return Ok(Some(Scene::of_map(subject, map, made_by)?));
    }
    let made = match nets.filter(|_| how.occlusion) {
        Some((nets, _)) => {
            made_by.models = nets.models(&params);
            nets.synthesize(&one.photo, &params, job)?
        }
        None => synthesize_bared(&one.photo, &map, &params, job)?,
    };
    let views = pool.install(|| of_frames(&solved, made, step, job))?;
    Ok(Some(Scene::of_views(subject, Some(map), views, made_by)?))
}

fn of_frames(solved: &Solved, made: Synthesis, step: burst::Step, job: &Job) -> Result<MadeViews, SceneError> {
    let (field, provenance) = solved.seen((&*made.field, &*made.depths), step, job)?;
    Ok(MadeViews { field, depths: made.depths, provenance: Some(provenance) })
}

/// Views at another strength: rays that the photo does not see come from the frames there, too.
pub(super) fn stronger(one: &OnePhoto, made: Synthesis, strength: f32, job: &Job) -> Result<MadeViews, SceneError> {
    let solved = one.several.as_ref().and_then(|several| Some((several.known()?, several.share)));
    let Some((solved, share)) = solved else { return Ok(made.into()) };
    of_frames(&solved, made, solved.step(share).0.times(strength.into()), job)
}

/// Where a light field's rays come from, in one sentence.
pub fn told(provenance: &Provenance) -> String {
    let percent = |seen: Seen| 100.0 * provenance.share(seen);
    format!(
        "of all rays the reference photo saw {:.1} %, another photo {:.1} %; {:.1} % are invented",
        percent(Seen::Reference),
        percent(Seen::Frame),
        percent(Seen::Invented)
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::burst::made::{Made, Taking, fit};
    use crate::field::{ViewIndex, nearest};
    use crate::job::{Cancel, Told};
    use crate::scene::export::{self, Kind, Settings};
    use crate::scene::{Edit, Maker};
    use glam::DVec3;

    fn saved(folder: &std::path::Path, name: &str, view: &View) -> PathBuf {
        let path = folder.join(name);
        let [w, h] = view.size();
        image::save_buffer(&path, view.rgba(), w, h, image::ColorType::Rgba8).unwrap();
        path
    }

    /// Mean difference of two views inside a margin, 0 … 1.
    fn apart(a: &View, b: &View) -> f32 {
        let [w, h] = a.size();
        let inside = (12..h - 12).flat_map(|y| (12..w - 12).map(move |x| (x, y)));
        let of = |(x, y)| (0..3).map(|c| f32::from(a.pixel(x, y)[c].abs_diff(b.pixel(x, y)[c])) / 765.0).sum::<f32>();
        inside.map(of).sum::<f32>() / ((w - 24) * (h - 24)) as f32
    }

    #[test]
    fn views_are_nearer_to_the_truth_than_those_of_one_photo_and_say_who_saw_them() {
        let taking = Taking {
            seed: 2,
            size: [400, 300],
            frames: 6,
            noise: 2.0,
            hand_m: 0.03,
            moving_m: 0.0,
            ..Taking::default()
        };
        let (made, dir, told) = (Made::new(taking), tempfile::tempdir().unwrap(), Told::default());
        let job = Job { cancel: &Cancel::default(), sink: &told };
        let mut paths: Vec<PathBuf> =
            made.views.iter().enumerate().map(|(i, view)| saved(dir.path(), &format!("{i}.png"), view)).collect();
        paths.push(saved(dir.path(), "tall.png", &View::new([30, 90], vec![99; 30 * 90 * 4]).unwrap()));
        paths.push(dir.path().join("broken.jpg"));
        std::fs::write(&paths[7], b"no picture").unwrap();
        let subject = Arc::new(Subject::open_several(&paths, SeveralAsked::default(), &job).unwrap());
        assert!(told.take().is_empty(), "the others are not read yet");
        let (maker, how) = (Maker::default(), Making { long_side: 200, ..Making::default() });
        let scene = maker.scene(&subject, &how, Need::Views, &job).unwrap();
        let texts = told.take().join("\n");
        assert!(texts.contains("tall.png is left out") && texts.contains("broken.jpg — it is left out"), "{texts}");
        let found = scene.several().unwrap();
        assert!(found.used == 6 && found.reprojection_px < 0.5, "{found:?}");
        let MadeViews { field, provenance, .. } = scene.made_views().unwrap();
        let own = reference_view(subject.photo().unwrap(), 200, &job).unwrap();
        assert_eq!(**field.reference(), own, "the reference photo stays as it is");
        let rays = provenance.as_deref().unwrap();
        let [seen, frame, invented] = [Seen::Reference, Seen::Frame, Seen::Invented].map(|seen| rays.share(seen));
        assert!(seen > 0.8 && frame > invented && invented > 0.0, "{seen} {frame} {invented}");
        assert_eq!(maker.scene(&subject, &how, Need::Map, &job).unwrap().map(), scene.map());

        // In metres: inverse depth is gain · disparity + shift.
        let (map, width) = (scene.map(), f64::from(own.size()[0]));
        let truth = nearest(made.inverse_depth.pixels(), taking.size, map.size());
        let [gain, shift] = fit(map.disparity_px(), &truth).map(f64::from);
        let step = match &subject.content {
            Content::Photo(one) => one.several.as_ref().unwrap().known().unwrap().step(None).0,
            Content::Views(_) => panic!("a photo"),
        };
        let step_m = step.step / (gain * step.gain * width);
        let one = Subject::open(&paths[0], &job).unwrap();
        let one = maker.scene(&Arc::new(one), &how, Need::Views, &job).unwrap();
        let error = |views: &MadeViews| -> f32 {
            let corners = [(0, 0), (0, 7), (7, 0), (7, 7)].map(|(v, u)| {
                let centre = DVec3::new(f64::from(u) - 4.0, f64::from(v) - 4.0, 0.0) * step_m;
                apart(&made.sheared(own.size(), centre, shift), views.field.view(ViewIndex { v, u }))
            });
            corners.iter().sum()
        };
        let errors = [scene.made_views().unwrap(), one.made_views().unwrap()].map(error);
        assert!(errors[0] < 0.5 * errors[1], "{errors:?}");

        // The folder keeps who saw what.
        let folder = dir.path().join("field");
        let settings = Settings { kind: Kind::Views, ..Settings::default() };
        export::write(&scene, &Edit::default(), &settings, &folder, &job).unwrap();
        let again = Subject::open(&folder, &job).unwrap();
        let read = again.recorded().unwrap();
        assert_eq!(read.provenance.as_deref(), Some(rays));
        assert!(read.shown.view(ViewIndex { v: 0, u: 7 }) == field.view(ViewIndex { v: 0, u: 7 }), "views are views");
        let again = maker.scene(&Arc::new(again), &how, Need::Views, &job).unwrap();
        let at = ViewIndex { v: 0, u: 0 };
        assert_eq!(again.trust().unwrap().of_view(at), scene.trust().unwrap().of_view(at));
    }

    #[test]
    fn the_mean_of_the_photos_has_less_noise_and_no_ghosts() {
        let taking = Taking { seed: 3, size: [400, 300], frames: 7, noise: 8.0, hand_m: 0.015, ..Taking::default() };
        let (made, dir) = (Made::new(taking), tempfile::tempdir().unwrap());
        let job = Job { cancel: &Cancel::default(), sink: &Told::default() };
        let paths: Vec<PathBuf> =
            made.views.iter().enumerate().map(|(i, view)| saved(dir.path(), &format!("{i}.png"), view)).collect();
        let asked = SeveralAsked { denoise: true, ..SeveralAsked::default() };
        let subject = Subject::open_several(&paths, asked, &job).unwrap();
        let photo = subject.photo().unwrap();
        let mean = View::new(photo.size(), photo.srgb8().to_vec()).unwrap();
        let clean = made.sheared(taking.size, DVec3::ZERO, 0.0);
        // What moves by itself keeps its noise, and is where it was.
        let moves = made.moving(taking.size);
        let error = |view: &View, of: bool| {
            let pixels = view.pixels().iter().zip(clean.pixels()).zip(&moves).filter(|(_, moves)| **moves == of);
            let squares: Vec<f64> = pixels.map(|((a, b), _)| (f64::from(a[1]) - f64::from(b[1])).powi(2)).collect();
            (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
        };
        let own = &made.views[0];
        assert!(error(&mean, false) < 0.6 * error(own, false), "{} {}", error(&mean, false), error(own, false));
        assert!(error(&mean, true) < 1.05 * error(own, true), "{} {}", error(&mean, true), error(own, true));
    }

    #[test]
    fn a_camera_that_did_not_move_gives_one_photo_and_says_so() {
        let made = Made::new(Taking { size: [240, 180], frames: 1, ..Taking::default() });
        let (dir, told) = (tempfile::tempdir().unwrap(), Told::default());
        let job = Job { cancel: &Cancel::default(), sink: &told };
        let paths = ["a.png", "b.png"].map(|name| saved(dir.path(), name, &made.views[0]));
        let subject = Arc::new(Subject::open_several(&paths, SeveralAsked::default(), &job).unwrap());
        let how = Making { long_side: 120, ..Making::default() };
        let scene = Maker::default().scene(&subject, &how, Need::Map, &job).unwrap();
        assert!(told.take().join("\n").contains("the camera did not move; one photo is used"));
        let one = Arc::new(Subject::open(&paths[0], &job).unwrap());
        assert_eq!(scene.map(), Maker::default().scene(&one, &how, Need::Map, &job).unwrap().map());
        let wrong = SeveralAsked { reference: 2, ..SeveralAsked::default() };
        let error = Subject::open_several(&paths, wrong, &job).unwrap_err();
        assert!(error.to_string().contains("--reference"), "{error}");
    }
}
