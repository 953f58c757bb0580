//! Synthesis by way of the cache.

use std::sync::Arc;
use std::time::Instant;

use rayon::prelude::*;

use super::cache::{Cache, CacheKey, Entry};
use super::picture::{Signed, reference_view};
use super::pipeline::{Made, Synthesizer};
use super::range::Metric;
use super::{DepthSource, SynthError, SynthParams, Synthesis, lambertian, lift, tract};
use crate::field::{DisparityMap, LightField, Photo, View, ViewIndex, fit_long_side};
use crate::job::Job;

impl Synthesizer {
    /// [`synthesize`](Self::synthesize), but from the cache where the light field lies there; else it is put there.
    ///
    /// # Errors
    /// As `synthesize`. A cache that cannot be written is only a warning.
    pub fn synthesize_cached(
        &self,
        photo: &Photo,
        params: &SynthParams,
        cache: Option<&Cache>,
        job: &Job,
    ) -> Result<Synthesis, SynthError> {
        let Some(cache) = cache else { return self.synthesize(photo, params, job) };
        let started = Instant::now();
        let key = CacheKey::new(photo, params, &self.manifests(params));
        let pool = tract::pool(params.threads).map_err(|error| SynthError::Threads(error.to_string()))?;
        if let Some(entry) = cache.read(&key)
            && let Some((field, depths)) = pool.install(|| self.restored(photo, params, &entry, job))?
        {
            let (metric, models) = (entry.metric, self.models(params));
            return Ok(Synthesis { field, depths, metric, models, took: started.elapsed() });
        }
        let made = self.synthesize(photo, params, job)?;
        if let Some(entry) = pool.install(|| self.entry(&made)) {
            keep(cache, &key, &entry, job);
        }
        Ok(made)
    }

    /// The disparity of the reference view alone, at the size of the views: the map that [`synthesize`](Self::synthesize)
    /// would make its light field of, without the 63 other views, and metres where its source has them. It is taken from the
    /// cache, or put there.
    ///
    /// # Errors
    /// As `synthesize`.
    pub fn depth_map(
        &self,
        photo: &Photo,
        params: &SynthParams,
        cache: Option<&Cache>,
        job: &Job,
    ) -> Result<(DisparityMap, Option<Metric>), SynthError> {
        // What a phone measured is brought to the views' size sooner than a large photo is known again.
        let cache = cache.filter(|_| params.source != DepthSource::Phone || params.phone.is_none());
        let key = cache.map(|cache| (cache, CacheKey::new(photo, params, &self.manifests(params))));
        let known = key.as_ref().and_then(|(cache, key)| cache.read_map(key));
        let size = fit_long_side(photo.size(), params.long_side.max(1));
        if let Some(known) = known.filter(|(map, _)| map.size() == size) {
            return Ok(known);
        }
        let pool = tract::pool(params.threads).map_err(|error| SynthError::Threads(error.to_string()))?;
        let (map, metric) = pool.install(|| self.reference_map_of(photo, params, job))?;
        if let Some((cache, key)) = key {
            keep(cache, &key, &Entry::of_map(map.clone(), metric), job);
        }
        Ok((map, metric))
    }

    /// What a cache keeps of a light field; none where its depths are more than their reference map.
    fn entry(&self, made: &Synthesis) -> Option<Entry> {
        let (grid, depths) = (self.grid(), &made.depths);
        let map = depths.reference_map();
        if lift::ray_depths(&map, grid) != **depths {
            return None;
        }
        let photo = Signed::from_view(made.field.reference());
        let views = (0..grid.count()).into_par_iter().map(|layer| {
            let at = grid.view_from_layer(layer);
            let plain = lambertian::render_view(&photo, depths.view(at), grid.offset(at)).ok()?;
            Some(difference(made.field.view(at), &plain))
        });
        let differences = views.collect::<Option<Vec<_>>>()?.concat();
        Some(Entry { map, metric: made.metric, differences, checksum: checksum(made.field.views()) })
    }

    /// A light field from a cache's entry; none where the entry does not lead to the views it was made from.
    fn restored(
        &self,
        photo: &Photo,
        params: &SynthParams,
        entry: &Entry,
        job: &Job,
    ) -> Result<Option<Made>, SynthError> {
        let reference = reference_view(photo, params.long_side, job)?;
        let (grid, bytes) = (self.grid(), reference.rgba().len() / 4 * 3);
        if entry.map.size() != reference.size() || entry.differences.len() != bytes * grid.count() {
            return Ok(None);
        }
        let depths = Arc::new(lift::lifted(&entry.map, grid, job)?);
        let signed = Signed::from_view(&reference);
        let make = |at: ViewIndex| {
            let plain = lambertian::render_view(&signed, depths.view(at), grid.offset(at))?;
            let start = grid.layer_from_view(at) * bytes;
            Ok(Arc::new(sum(plain, &entry.differences[start..start + bytes])?))
        };
        let layers = (0..grid.count()).into_par_iter();
        let views = layers.map(|layer| make(grid.view_from_layer(layer))).collect::<Result<Vec<_>, SynthError>>()?;
        if checksum(&views) != entry.checksum {
            return Ok(None);
        }
        job.sink.depths(&depths);
        grid.spiral().into_iter().for_each(|at| job.sink.view(at, &views[grid.layer_from_view(at)]));
        Ok(Some((Arc::new(LightField::new(grid, views)?), depths)))
    }
}

/// Puts an entry into the cache; that it cannot be kept is only a warning.
fn keep(cache: &Cache, key: &CacheKey, entry: &Entry, job: &Job) {
    if let Err(error) = cache.write(key, entry) {
        let place = cache.folder().display();
        job.sink.warning(format!("The light field could not be kept for next time — {error}: {place}"));
    }
}

/// Colours of a view less those of its Lambertian rendering, wrapping, `[y, x, rgb]`.
fn difference(view: &View, plain: &View) -> Vec<u8> {
    let pairs = view.rgba().chunks_exact(4).zip(plain.rgba().chunks_exact(4));
    pairs.flat_map(|(a, b)| [0, 1, 2].map(|c| a[c].wrapping_sub(b[c]))).collect()
}

/// The inverse of [`difference`].
fn sum(plain: View, difference: &[u8]) -> Result<View, SynthError> {
    let size = plain.size();
    let mut rgba = plain.into_rgba();
    for (pixel, more) in rgba.chunks_exact_mut(4).zip(difference.chunks_exact(3)) {
        (0..3).for_each(|c| pixel[c] = pixel[c].wrapping_add(more[c]));
    }
    Ok(View::new(size, rgba)?)
}

fn checksum(views: &[Arc<View>]) -> u32 {
    let mut crc = flate2::Crc::new();
    views.iter().for_each(|view| crc.update(view.rgba()));
    crc.sum()
}
