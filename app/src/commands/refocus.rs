//! `refocus`: the picture that another lens would have taken.

use std::sync::Arc;

use anyhow::{Result, bail};
use plenoscope::field::{FNumber, FocalPlane, Lens, Photo, View, ViewOffset, ViewPoint, fit_long_side};
use plenoscope::io::save::{self, Keep, Origin, PictureOptions};
use plenoscope::io::{Opened, PhotoFile};
use plenoscope::job::{Job, Stage};
use plenoscope::recipe::Recipe;
use plenoscope::render::lens::Space;
use plenoscope::render::{cpu, lens};

use super::input::{self, Scene};
use super::output::Target;
use super::{Usage, lens_args};
use crate::cli::{Refocus, SynthArgs};
use crate::values::{Pair, PictureSize, Size};

/// Renders the picture and writes it.
pub fn run(args: &Refocus, job: &Job) -> Result<()> {
    let target = Target { file: &args.output, input: &args.input, force: args.force };
    target.check()?;
    save::check(&args.output, &PictureOptions::default())?;
    let recipe = args.recipe.as_deref().map(Recipe::read).transpose()?;
    let edit = Edit { args, recipe };
    match input::open(&args.input, job)? {
        Opened::Photo(file) if args.size == Some(PictureSize::LightField) => {
            // A map that is given spares the nets here, all of them.
            let lambertian = args.synth.lambertian || args.synth.disparity.is_some();
            let scene = input::from_photo(&file, &SynthArgs { lambertian, ..args.synth.clone() }, job)?;
            edit.of_views(&scene, job)
        }
        Opened::Photo(file) => edit.of_photo(photo_scene(&args.synth, &file, job)?, job),
        Opened::LightField(file) => {
            let scene = Scene::from_file(*file);
            match args.size {
                None | Some(PictureSize::LightField) => edit.of_views(&scene, job),
                Some(_) => edit.of_photo(view_scene(&scene, job)?, job),
            }
        }
    }
}

/// A photo with the ray depth of its light field, or with the map that was given: then no net runs.
pub fn photo_scene(args: &SynthArgs, file: &PhotoFile, job: &Job) -> Result<lens::Scene> {
    if let Some(map) = input::disparity(args)? {
        return Ok(lens::Scene::new(Arc::clone(&file.photo), map)?);
    }
    let scene = input::from_photo(file, args, job)?;
    lens_scene(Arc::clone(&file.photo), &scene, job)
}

/// A light field's reference view as the photo, with what the other views see behind its edges.
pub fn view_scene(scene: &Scene, job: &Job) -> Result<lens::Scene> {
    let view: &View = scene.field.reference();
    let photo = Photo::from_srgb8(view.size(), view.rgba().to_vec())?;
    let lens_scene = lens_scene(Arc::new(photo), scene, job)?;
    let depths = scene.depths(job)?;
    Ok(lens_scene.with_behind(lens::revealed(&scene.field, &depths)))
}

/// A photo with the ray depth of its light field.
pub fn lens_scene(photo: Arc<Photo>, scene: &Scene, job: &Job) -> Result<lens::Scene> {
    let depths = scene.depths(job)?;
    Ok(lens::Scene::new(photo, depths.reference_map())?)
}

/// What was asked for: a recipe, and arguments that go before it.
struct Edit<'a> {
    args: &'a Refocus,
    recipe: Option<Recipe>,
}

impl Edit<'_> {
    /// At the photo's size or smaller, with the lens renderer.
    fn of_photo(&self, scene: lens::Scene, job: &Job) -> Result<()> {
        let photo = scene.photo();
        let base = self.recipe.as_ref().map_or_else(Lens::default, |recipe| recipe.lens_for(&scene));
        let lens = lens_args::lens(&self.args.lens, base, photo.size(), scene.disparity())?;
        let size = match (self.args.size, &self.recipe) {
            (Some(PictureSize::Custom(size)), _) => inside(photo.size(), size, job)?,
            (None, Some(recipe)) => recipe.export.size.of(photo.size()),
            _ => photo.size(),
        };
        let options = self.options(Origin::in_own_space(photo), photo.pixels().bits());
        let scene = scene.seen_from(self.viewpoint(), size, job)?;
        let pixels = lens::render_pixels(&scene, &lens, size, options.bits, job)?;
        job.advance(Stage::Save, 0, 1)?;
        Ok(save::pixels(&self.args.output, &pixels, &options)?)
    }

    /// At the light field's size, as the paper does it: shift the views and add. A lens that is wider than all views
    /// together is the lens renderer's.
    fn of_views(&self, scene: &Scene, job: &Job) -> Result<()> {
        let depths = scene.depths(job)?;
        let own = depths.reference_map();
        let photo_size = scene.photo.as_ref().map_or(scene.field.size(), |photo| photo.size());
        let recipe = self.recipe.clone().unwrap_or_default();
        let mut base = recipe.lens;
        if let Some([x, y]) = recipe.focus_at {
            let at = Pair(x * photo_size[0] as f32 - 0.5, y * photo_size[1] as f32 - 0.5);
            base.focus.disparity_px = lens_args::focus_at(at, photo_size, &own, base.focus)?;
        }
        let lens = match input::disparity(&self.args.synth)? {
            // What was typed is in the units of the given map.
            Some(map) => {
                let ratio = map.scale_to(own.size());
                let typed = lens_args::lens(&self.args.lens, scaled(base, 1.0 / ratio), photo_size, &map)?;
                scaled(typed, ratio)
            }
            None => lens_args::lens(&self.args.lens, base, photo_size, &own)?,
        };
        let picture = if lens.f_number < FNumber::PAPER_WIDEST {
            let size = scene.field.size();
            let wide = view_scene(scene, job)?.in_space(Space::Srgb).seen_from(self.viewpoint(), size, job)?;
            lens::render(&wide, &lens, size, job)?
        } else {
            cpu::refocus_with_depths(&scene.field, Some(&depths), &lens, self.viewpoint())
        };
        job.advance(Stage::Save, 0, 1)?;
        let origin = scene.photo.as_deref().map(Origin::in_srgb).unwrap_or_default();
        Ok(save::picture(&self.args.output, &picture, &self.options(origin, 8))?)
    }

    /// Where the lens stands.
    fn viewpoint(&self) -> ViewPoint {
        let of_recipe = self.recipe.as_ref().map_or_else(ViewPoint::default, |recipe| recipe.viewpoint);
        self.args.at.map_or(of_recipe, |Pair(du, dv)| ViewPoint(ViewOffset { dv, du }))
    }

    /// How the picture is written; `bits` are those of the photo.
    fn options(&self, mut origin: Origin, bits: u8) -> PictureOptions {
        let export = self.recipe.as_ref().map(|recipe| &recipe.export);
        let format = save::Format::of(&self.args.output);
        let wanted = self.args.bits.or(export.map(|export| export.bits)).unwrap_or(bits);
        origin.source = Some(self.args.input.clone());
        PictureOptions {
            format: None,
            bits: if format.is_some_and(save::Format::has_16_bits) { wanted } else { 8 },
            quality: self
                .args
                .quality
                .or(export.map(|export| export.quality))
                .unwrap_or(PictureOptions::default().quality),
            keep: if self.args.strip_metadata { Keep::Nothing } else { export.map_or(Keep::All, |export| export.keep) },
            origin,
            replace_source: self.args.force,
        }
    }
}

/// The same lens in pixels of another width.
fn scaled(lens: Lens, ratio: f32) -> Lens {
    let focus = FocalPlane {
        disparity_px: lens.focus.disparity_px * ratio,
        tilt_px: lens.focus.tilt_px.map(|tilt| tilt * ratio),
    };
    Lens { focus, keep_sharp_px: lens.keep_sharp_px.map(|end| end * ratio), ..lens }
}

/// The largest size of the photo's shape in what was asked for.
fn inside(photo: [u32; 2], Size(wanted): Size, job: &Job) -> Result<[u32; 2]> {
    if wanted[0] > photo[0] || wanted[1] > photo[1] {
        let [width, height] = photo;
        bail!(Usage(format!(
            "the picture would be larger than the photo — nothing is enlarged — at most {width}x{height}"
        )));
    }
    let scale = (f64::from(wanted[0]) / f64::from(photo[0])).min(f64::from(wanted[1]) / f64::from(photo[1]));
    let long_side = (f64::from(photo[0].max(photo[1])) * scale).round() as u32;
    let fitting = fit_long_side(photo, long_side.max(1));
    if fitting.iter().zip(wanted).all(|(fits, wanted)| fits.abs_diff(wanted) <= 1) {
        return Ok(wanted);
    }
    job.sink.warning(format!("the photo's shape is kept: the picture has {}x{} pixels", fitting[0], fitting[1]));
    Ok(fitting)
}
