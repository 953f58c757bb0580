//! A net is tried on a picture whose depth is known: which colours it wants, and which way its numbers run.

use std::path::Path;
use std::time::Instant;

use super::draft::Draft;
use super::error::AdoptError;
use super::family::{Colours, Family};
use super::reading::Reading;
use super::rehearsal;
use crate::field::{DisparityMap, Filter, RelativeDepth, View, correlation, resample, spearman};
use crate::job::{Job, Stage};
use crate::synth::library::checksum;
use crate::synth::relative::{map_of, relative_input};
use crate::synth::tract::{EngineError, Output, Runnable, Signs};
use crate::synth::{ColourOrder, Manifest, RelativeOutput, Signed};

/// Least rank correlation with the known depth at which a net is taken for a depth net.
const LEAST: f32 = 0.6;
/// A family's own colours need not be compared with others from here on.
const PLAIN: f32 = 0.7;
/// By how much a reading of the numbers must fit better than the plainer one.
const BETTER: f32 = 0.03;
/// A picture whose depth is known.
#[derive(Clone, Copy, Debug)]
pub struct Known<'a> {
    /// The picture.
    pub view: &'a View,
    /// Its disparity; only the order and the relief count.
    pub disparity: &'a DisparityMap,
}

/// A net that was tried.
#[derive(Clone, Debug)]
pub struct Adopted {
    /// What is known of it now.
    pub manifest: Manifest,
    /// Its family, where its signs tell one.
    pub family: Option<&'static str>,
    /// What a person must know before using its pictures.
    pub warning: Option<&'static str>,
    /// Rank correlation of its answer with the known depth.
    pub correlation: f32,
    /// Seconds that one answer takes.
    pub seconds: f32,
    /// Bytes of all its files.
    pub bytes: u64,
    /// What it says of the known picture.
    pub depth: RelativeDepth,
}

impl Adopted {
    /// What a person reads of it: family, size, time, whose it is.
    pub fn summary(&self) -> String {
        let licence = match (self.manifest.licence.as_str(), self.warning) {
            ("", _) => "licence not known: look where you got it".to_owned(),
            (licence, None) => licence.to_owned(),
            (licence, Some(warning)) => format!("{licence} — {warning}"),
        };
        let what = self.family.unwrap_or("a depth net of no known family");
        let (id, megabytes) = (&self.manifest.id, self.bytes as f64 / 1e6);
        format!("{id}: {what}, {megabytes:.0} MB, {:.1} s a photo, {licence}", self.seconds)
    }
}

/// Tells what a net is and tries it. Nothing is written.
///
/// With `any` a net that does not find the known depth is taken all the same.
///
/// # Errors
/// [`AdoptError`].
pub fn adopt(path: &Path, known: Known, any: bool, job: &Job) -> Result<Adopted, AdoptError> {
    let photo = known.view.size();
    rehearsal::check(path, photo, job.cancel)?;
    let Reading { signs, family, draft, mut manifest, size, net } = Reading::of(path, photo, job.cancel)?;
    let bytes = sealed(path, &signs, &mut manifest)?;
    let trial = Trial { net, manifest: &manifest, picture: Signed::resized(known.view, size, Filter::Lanczos3), known };
    let best = trial.best(&draft, family, job).map_err(AdoptError::engine(path))?;
    best.check(any)?;
    let Answer { rules, correlation, seconds, depth, .. } = best;
    manifest.relative = rules;
    let (name, warning) = (family.map(|family| family.name), family.and_then(|family| family.warning));
    Ok(Adopted { manifest, family: name, warning, correlation, seconds, bytes, depth })
}

/// Writes the checksums of all files of a net into its manifest; answers their bytes.
fn sealed(path: &Path, signs: &Signs, manifest: &mut Manifest) -> Result<u64, AdoptError> {
    let checksum = |path: &Path| checksum(path).map_err(AdoptError::read(path));
    manifest.sha256 = checksum(path)?;
    let mut bytes = std::fs::metadata(path).map_err(AdoptError::read(path))?.len();
    for name in &signs.files {
        let file = path.with_file_name(name);
        bytes += std::fs::metadata(&file).map_err(AdoptError::read(&file))?.len();
        manifest.data_files.insert(name.clone(), checksum(&file)?);
    }
    Ok(bytes)
}

/// A net ready for the known picture.
struct Trial<'a> {
    net: Runnable,
    manifest: &'a Manifest,
    picture: Signed,
    known: Known<'a>,
}

/// What came of one reading of the picture.
struct Answer {
    rules: crate::synth::RelativeRules,
    correlation: f32,
    seconds: f32,
    depth: RelativeDepth,
    /// Why it cannot be a depth map, where it cannot.
    fault: Option<&'static str>,
}

impl Answer {
    fn check(&self, any: bool) -> Result<(), AdoptError> {
        let refuse = |why: String| Err(AdoptError::NotDepth { why });
        match self.fault {
            Some(why) => refuse(why.to_owned()),
            None if any || self.correlation >= LEAST => Ok(()),
            None => refuse(format!(
                "depth whose order has a correlation of {:.2} with the truth, and a depth net has {LEAST} or more",
                self.correlation
            )),
        }
    }
}

impl Trial<'_> {
    /// The best of all readings; a family's own is enough where it is plainly right.
    fn best(&self, draft: &Draft, family: Option<&Family>, job: &Job) -> Result<Answer, EngineError> {
        let mut best: Option<Answer> = None;
        for (i, (colours, order)) in draft.colours.iter().enumerate() {
            let told = job.advance(Stage::Depth, i as u32, draft.colours.len() as u32);
            told.map_err(|_cancelled| EngineError::Cancelled)?;
            let answer = self.answer(*colours, *order, family, job)?;
            let is_plain = family.is_some() && i == 0 && answer.correlation >= PLAIN;
            if best.as_ref().is_none_or(|best| answer.correlation > best.correlation + BETTER) {
                best = Some(answer);
            }
            if is_plain {
                break;
            }
        }
        best.ok_or(EngineError::Cancelled)
    }

    fn answer(
        &self,
        colours: Colours,
        order: ColourOrder,
        family: Option<&Family>,
        job: &Job,
    ) -> Result<Answer, EngineError> {
        let mut manifest = self.manifest.clone();
        let rules = &mut manifest.relative;
        (rules.mean, rules.std, rules.value_scale, rules.order) = (colours.mean, colours.std, colours.white, order);
        let input = relative_input(&manifest, &self.picture);
        let started = Instant::now();
        let output = self.net.run(&input, job.cancel)?;
        let seconds = started.elapsed().as_secs_f32();
        let (size, values, fault) = self.values(&output, manifest.relative.output);
        let truth = self.known.disparity;
        let truth = resample::<1>(truth.disparity_px(), truth.size(), size, Filter::Linear);
        let (correlation, output) = sense(&values, &truth, family.map(|family| family.output));
        manifest.relative.output = output;
        let nearness = output.nearness_of(&values);
        let depth =
            RelativeDepth::new(size, nearness).map_err(|error| EngineError::Run { detail: error.to_string() })?;
        Ok(Answer { rules: manifest.relative, correlation, seconds, depth, fault })
    }

    /// The map in an answer; zeros, and why, where there is none.
    fn values(&self, output: &Output, kind: RelativeOutput) -> ([u32; 2], Vec<f32>, Option<&'static str>) {
        let none = |why| ([1, 1], vec![0.0], Some(why));
        let Some(([w, h], values)) = map_of(output, kind) else { return none("no map") };
        if !values.iter().all(|value| value.is_finite()) {
            return none("values that are no numbers");
        }
        let [least, most] = values.iter().fold([f32::MAX, f32::MIN], |[lo, hi], v| [lo.min(*v), hi.max(*v)]);
        if most - least <= 1e-6 * most.abs().max(least.abs()) {
            return none("one depth everywhere");
        }
        ([w as u32, h as u32], values, None)
    }
}

/// How well an answer orders the known depth, and what its numbers are: what the family's authors say where the order
/// agrees with that, else the reading that fits the relief best, the plainer one where there is little between them.
fn sense(values: &[f32], truth: &[f32], expected: Option<RelativeOutput>) -> (f32, RelativeOutput) {
    use RelativeOutput::{Distance, Farness, LogNearness, Nearness};
    let rank = spearman(values, truth);
    let is_near = rank >= 0.0;
    if let Some(output) = expected.filter(|output| output.grows_nearer() == is_near) {
        return (rank.abs(), output);
    }
    let [plain, other] = if is_near { [Nearness, LogNearness] } else { [Distance, Farness] };
    let fit = |output: RelativeOutput| correlation(output.nearness_of(values).into_iter().zip(truth.iter().copied()));
    let is_distance = values.iter().all(|value| *value > 0.0);
    let output = match other {
        Farness if !is_distance => Farness,
        other if fit(other) > fit(plain) + BETTER => other,
        _ => plain,
    };
    (rank.abs(), output)
}
