//! How light fields are made of photos, as keyword arguments name it; and the makers, whose nets stay warm between calls.

use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

use plenoscope::field::DisparityMap;
use plenoscope::io::formats::depth_map::GivenDepth;
use plenoscope::io::formats::pfm;
use plenoscope::scene::asked::{How, LONG_SIDES, THREADS, Usage, within};
use plenoscope::scene::{DepthFrom, Maker, Making};
use plenoscope::synth::adopt::Shelf;
use plenoscope::synth::cache::Cache;
use plenoscope::synth::{ModelSource, Scale};
use pyo3::prelude::*;

use crate::errors::{raised, wrong_type};
use crate::options::Options;
use crate::{arrays, recipe};

/// Makers with the user's cache and without.
static MAKERS: [OnceLock<Maker>; 2] = [const { OnceLock::new() }; 2];

/// What makes scenes.
pub fn maker(options: &Options) -> PyResult<&'static Maker> {
    let is_cached = options.get("cache", "True or False")?.unwrap_or(true);
    let cache = || if is_cached { Cache::user() } else { None };
    Ok(MAKERS[usize::from(is_cached)].get_or_init(|| Maker::new(cache())))
}

/// What holds for photos where nobody says anything else.
pub fn usual() -> Making {
    Making { shelf: Shelf::user(), ..Making::default() }
}

/// How light fields are made.
pub fn how(py: Python<'_>, options: &Options) -> PyResult<How> {
    let usual = usual();
    let whole = "a whole number";
    let source = options.get::<String>("source", "a name")?;
    let own_map = options.any("disparity")?.map(|map| own_map(py, &map)).transpose()?;
    if source.is_some() && own_map.is_some() {
        let text = "disparity cannot be used with source — leave one of them out";
        return Err(raised(py, Usage(text.to_owned())));
    }
    let models =
        options.get::<PathBuf>("models", "a folder")?.map_or_else(|| usual.models.clone(), ModelSource::Folder);
    let making = Making {
        long_side: options.checked("long_side", whole, |n| within(n, &LONG_SIDES))?.unwrap_or(usual.long_side),
        occlusion: !options.is_on("lambertian")?,
        threads: options.checked("threads", whole, |n| within(n, &THREADS))?.unwrap_or_default().into(),
        source: source.map_or(DepthFrom::Auto, |name| DepthFrom::named(&name)),
        scale: options.checked("depth_scale", "a name", scale)?.unwrap_or(usual.scale),
        models,
        ..usual
    };
    Ok(How::new(making, own_map, recipe::asked(py, options)?))
}

fn scale(name: String) -> Result<Scale, Usage> {
    name.parse::<Scale>().map_err(|none| Usage(none.to_string()))
}

/// A map of one's own: a PFM file, or an array `[y, x]` of pixels per view step at its own width.
fn own_map(py: Python<'_>, map: &Bound<'_, PyAny>) -> PyResult<GivenDepth> {
    let map = if arrays::is_array(map)? {
        let given = arrays::given(map, "float32")?;
        let &[height, width] = given.shape.as_slice() else {
            return Err(wrong_type("disparity", "a file or an array [y, x]", map));
        };
        DisparityMap::new([width as u32, height as u32], given.floats()).map_err(|error| raised(py, error))?
    } else {
        let path: PathBuf =
            map.extract().map_err(|_no_path| wrong_type("disparity", "a file or an array [y, x]", map))?;
        pfm::read_pfm(&path).map_err(|error| raised(py, error))?
    };
    Ok(GivenDepth::Disparity(Arc::new(map)))
}
