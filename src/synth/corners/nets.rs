//! The two nets of views between corners: ray depth from how far the corners agree, then the colours of their blend corrected.

use std::sync::Arc;

use super::given_at;
use super::one::{Between, RESIDUAL_GAIN};
use crate::field::{LightField, RayDepths, View, ViewGrid, sides};
use crate::job::{Job, Stage};
use crate::synth::library::ModelBytes;
use crate::synth::net::Net;
use crate::synth::{ModelError, ModelFile, ModelSource, SynthError, Task};

/// The colour net's file, beside that of the disparity net.
pub const COLOUR_FILE: &str = "colour.onnx";

/// Nets of a manifest with `task = "corners"`.
pub struct CornerNets {
    disparity: Net,
    colour: Net,
    threads: usize,
}

impl CornerNets {
    /// The nets of a name, from the first source that has them.
    ///
    /// # Errors
    /// None of this name; a file that is not what its manifest says; nets of another shape.
    pub fn named(name: &str, sources: &[ModelSource], threads: usize) -> Result<Self, ModelError> {
        let known = |source: &ModelSource| source.corner_models();
        match sources.iter().find(|source| known(source).iter().any(|id| id == name)) {
            Some(source) => Self::load(source.model(name, Task::Corners)?, threads),
            None => {
                let known = sources.iter().flat_map(known).collect();
                Err(ModelError::NoCornerNets { name: name.to_owned(), known })
            }
        }
    }

    fn load(file: ModelFile, threads: usize) -> Result<Self, ModelError> {
        file.check_grid(ViewGrid::PAPER)?;
        let colour = Self::colour(&file)?;
        let (agreement, given) = (Between::AGREEMENT_CHANNELS, Between::COLOUR_CHANNELS);
        let disparity = Net::load(file, |h, w| vec![1, agreement, h, w], |h, w| vec![1, 1, h, w])?;
        let colour = Net::load(colour, |h, w| vec![1, given, h, w], |h, w| vec![1, 3, h, w])?;
        Ok(Self { disparity, colour, threads })
    }

    /// The second net, whose checksum was looked at with the first.
    fn colour(file: &ModelFile) -> Result<ModelFile, ModelError> {
        let mut manifest = file.manifest.clone();
        let sum = manifest.data_files.remove(COLOUR_FILE);
        let (Some(sha256), Some(folder)) = (sum, &file.folder) else {
            let why = format!("data_files does not name {COLOUR_FILE}");
            return Err(ModelError::Manifest { place: file.place.clone(), why });
        };
        let path = folder.join(COLOUR_FILE);
        (manifest.file, manifest.sha256) = (COLOUR_FILE.to_owned(), sha256);
        let place = path.display().to_string();
        Ok(ModelFile { manifest, onnx: ModelBytes::File(path), bytes: file.bytes, folder: None, place })
    }

    /// The paper's grid of views, its corners given as [`between`](super::between) is.
    ///
    /// # Errors
    /// Cancelled; views of several sizes, or not four; what the nets say.
    pub fn between(&self, corners: &[Arc<View>], job: &Job) -> Result<(LightField, RayDepths), SynthError> {
        let grid = ViewGrid::PAPER;
        let given = LightField::new(ViewGrid::new(2, 2)?, corners.to_vec())?;
        let planes: Vec<Vec<f32>> = corners.iter().map(|view| planes(view)).collect();
        let (mut views, mut depths) = (Vec::new(), Vec::new());
        for layer in 0..grid.count() {
            job.advance(Stage::Warp, layer as u32, grid.count() as u32)?;
            let size = sides(given.size());
            let one = Between { corners: std::array::from_fn(|c| &planes[c][..]), layer, size };
            let depth = self.depth(&one, job)?;
            views.push(match given_at(grid, grid.view_from_layer(layer)) {
                Some(corner) => Arc::clone(&corners[corner]),
                None => Arc::new(View::new(given.size(), self.colours(&one, &depth, job)?)?),
            });
            depths.extend(depth);
        }
        job.advance(Stage::Warp, grid.count() as u32, grid.count() as u32)?;
        Ok((LightField::new(grid, views)?, RayDepths::new(grid, given.size(), depths)?))
    }

    /// Ray depths `[h, w]` of a view.
    fn depth(&self, view: &Between<'_>, job: &Job) -> Result<Vec<f32>, SynthError> {
        let [w, h] = view.size;
        let shape = [1, Between::AGREEMENT_CHANNELS, h, w];
        let depth = self.disparity.run(&shape, &view.features(), self.threads, job.cancel)?;
        Ok(depth.to_vec())
    }

    /// Its colours, RGBA.
    fn colours(&self, view: &Between<'_>, depth: &[f32], job: &Job) -> Result<Vec<u8>, SynthError> {
        let ([w, h], p) = (view.size, depth.len());
        let warped = view.warped(depth);
        let input = view.colour_input(&warped, depth);
        let residual = self.colour.run(&[1, Between::COLOUR_CHANNELS, h, w], &input, self.threads, job.cancel)?;
        let blend = view.blended(&warped);
        let byte = |i: usize| ((blend[i] + RESIDUAL_GAIN * residual[i]).clamp(0.0, 1.0) * 255.0).round() as u8;
        Ok((0..p).flat_map(|i| [byte(i), byte(p + i), byte(2 * p + i), 255]).collect())
    }
}

/// Colours `[3, h, w]` in 0 … 1.
fn planes(view: &View) -> Vec<f32> {
    let channel = |c: usize| view.rgba().chunks_exact(4).map(move |pixel| f32::from(pixel[c]) / 255.0);
    (0..3).flat_map(channel).collect()
}
