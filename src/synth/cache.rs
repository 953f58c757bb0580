//! Synthesized light fields on disk, so that a photo seen before opens at once.
//!
//! An entry holds what cannot be computed quickly: the reference map, and the difference of each view from its
//! Lambertian rendering (mostly zeros). Depths and Lambertian views are made anew; a checksum over the views
//! guards against a program that makes them otherwise.

use std::fs::{self, File};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use directories::ProjectDirs;
use flate2::Compression;
use flate2::read::ZlibDecoder;
use flate2::write::ZlibEncoder;
use sha2::{Digest, Sha256};

use super::library::hex;
use super::range::Metric;
use super::{Manifest, SynthParams};
use crate::aside::NewFile;
use crate::field::{DisparityMap, Photo, PhotoPixels, pixels};

/// First bytes of an entry; the number grows with its layout and with how maps are made.
const MAGIC: &[u8; 8] = b"PLENO\0\0\x0e";
/// Bytes that the folder may hold.
const CAP_BYTES: u64 = 2 << 30;

/// A folder of synthesized light fields.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Cache {
    folder: PathBuf,
    cap_bytes: u64,
}

/// What a light field is known by: photo, models and parameters.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CacheKey(String);

/// What is kept of a light field; of one map alone neither differences nor a checksum.
#[derive(Debug, PartialEq)]
pub(super) struct Entry {
    /// The reference map at the size of the views.
    pub(super) map: DisparityMap,
    /// Metres, where its source has them.
    pub(super) metric: Option<Metric>,
    /// View less Lambertian view, wrapping, `[v, u, y, x, rgb]`.
    pub(super) differences: Vec<u8>,
    /// Checksum of the views.
    pub(super) checksum: u32,
}

impl Cache {
    /// The user's own cache folder, up to 2 GiB; none where the system has no such place.
    pub fn user() -> Option<Self> {
        ProjectDirs::from("", "", "plenoscope").map(|dirs| Self::new(&dirs.cache_dir().join("light-fields"), CAP_BYTES))
    }

    /// A folder of one's own, with a limit in bytes.
    pub fn new(folder: &Path, cap_bytes: u64) -> Self {
        Self { folder: folder.to_owned(), cap_bytes }
    }

    /// Where the entries lie.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Bytes that the entries take.
    pub fn size_bytes(&self) -> u64 {
        self.entries().iter().map(|(_, _, bytes)| bytes).sum()
    }

    /// Deletes every entry.
    ///
    /// # Errors
    /// The system's, of the first entry that could not be deleted.
    pub fn clear(&self) -> io::Result<()> {
        self.entries().iter().try_for_each(|(path, ..)| fs::remove_file(path))
    }

    /// Reads an entry and marks it as used; none where it is missing or damaged.
    pub(super) fn read(&self, key: &CacheKey) -> Option<Entry> {
        let path = self.path(key);
        let entry = Entry::parse(&mut File::open(&path).ok()?).ok()?;
        if let Ok(file) = File::options().append(true).open(&path) {
            // Only the order of deletion hangs on it.
            let _ = file.set_modified(SystemTime::now());
        }
        Some(entry)
    }

    /// The reference map of an entry, whether or not its views are there; none where it is missing or damaged.
    pub(super) fn read_map(&self, key: &CacheKey) -> Option<(DisparityMap, Option<Metric>)> {
        Entry::parse_head(&mut File::open(self.path(key)).ok()?).ok().map(|(entry, ..)| (entry.map, entry.metric))
    }

    /// Writes an entry aside, renames it, and deletes the longest unused ones beyond the limit.
    pub(super) fn write(&self, key: &CacheKey, entry: &Entry) -> io::Result<()> {
        fs::create_dir_all(&self.folder)?;
        let mut new = NewFile::new(&self.path(key))?;
        entry.write(new.file())?;
        new.put()?;
        self.trim()
    }

    fn trim(&self) -> io::Result<()> {
        let mut entries = self.entries();
        entries.sort_by_key(|(_, used, _)| *used);
        let mut total: u64 = entries.iter().map(|(_, _, bytes)| bytes).sum();
        for (path, _, bytes) in entries {
            if total <= self.cap_bytes {
                break;
            }
            match fs::remove_file(path) {
                // Another program was faster.
                Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
                _ => total -= bytes,
            }
        }
        Ok(())
    }

    fn entries(&self) -> Vec<(PathBuf, SystemTime, u64)> {
        let files = fs::read_dir(&self.folder).into_iter().flatten().flatten().map(|entry| entry.path());
        let entries = files.filter(|path| path.extension().is_some_and(|extension| extension == "pleno"));
        let facts = entries.filter_map(|path| fs::metadata(&path).ok().map(|facts| (path, facts)));
        facts.filter_map(|(path, facts)| Some((path, facts.modified().ok()?, facts.len()))).collect()
    }

    fn path(&self, key: &CacheKey) -> PathBuf {
        self.folder.join(format!("{}.pleno", key.0))
    }
}

impl CacheKey {
    /// The key of a photo's light field.
    pub(super) fn new(photo: &Photo, params: &SynthParams, models: &[Manifest]) -> Self {
        let mut hash = Sha256::new();
        hash.update(env!("CARGO_PKG_VERSION"));
        hash.update(format!("{:?} {} {} {:?}", photo.size(), params.long_side, params.occlusion, params.source));
        hash.update(format!("{:?} {:?}", params.camera, params.scale));
        // All that a manifest says counts: who tries another working scale must not be shown the old one's light field.
        models.iter().for_each(|manifest| hash.update(format!("{manifest:?}")));
        match photo.pixels() {
            PhotoPixels::Eight(px) => hash.update(&**px),
            PhotoPixels::Sixteen(px) => px.iter().for_each(|value| hash.update(value.to_le_bytes())),
        }
        hash.update(photo.metadata().icc.as_deref().unwrap_or_default());
        let disparity = params.disparity.as_deref().map(|map| (map.size(), map.disparity_px()));
        let phone = params.phone.as_deref().map(|phone| (phone.nearness.size(), phone.nearness.nearness()));
        // An order and the same numbers in metres are two scenes.
        hash.update(format!("{:?}", params.phone.as_deref().map(|phone| (phone.geometry, &phone.sky))));
        for map in [disparity, phone] {
            hash.update([u8::from(map.is_some())]);
            if let Some((size, values)) = map {
                hash.update(format!("{size:?}"));
                values.iter().for_each(|value| hash.update(value.to_le_bytes()));
            }
        }
        Self(hex(&hash.finalize()[..16]))
    }
}

impl Entry {
    /// Of one map alone.
    pub(super) fn of_map(map: DisparityMap, metric: Option<Metric>) -> Self {
        Self { map, metric, differences: Vec::new(), checksum: 0 }
    }

    fn write(&self, to: &mut impl Write) -> io::Result<()> {
        to.write_all(MAGIC)?;
        for number in [self.map.size()[0], self.map.size()[1], self.checksum, self.differences.len() as u32] {
            to.write_all(&number.to_le_bytes())?;
        }
        // No metres are no numbers.
        let metric = self.metric.map_or([f32::NAN; 3], |m| [m.gain, m.nearness, m.f35_mm]);
        metric.iter().try_for_each(|number| to.write_all(&number.to_le_bytes()))?;
        let mut packed = ZlibEncoder::new(to, Compression::fast());
        let disparity: Vec<u8> = self.map.disparity_px().iter().flat_map(|d| d.to_le_bytes()).collect();
        packed.write_all(&disparity)?;
        packed.write_all(&self.differences)?;
        packed.finish().map(|_| ())
    }

    fn parse(from: &mut impl Read) -> io::Result<Self> {
        let (entry, bytes, mut packed) = Self::parse_head(from)?;
        let mut differences = Vec::new();
        packed.by_ref().take(bytes + 1).read_to_end(&mut differences)?;
        if differences.len() as u64 != bytes {
            return Err(io::ErrorKind::InvalidData.into());
        }
        Ok(Self { differences, ..entry })
    }

    /// All but the differences, the length of those, and the way on to them.
    fn parse_head<R: Read>(from: &mut R) -> io::Result<(Self, u64, ZlibDecoder<&mut R>)> {
        let damaged = || io::Error::from(io::ErrorKind::InvalidData);
        let mut head = [0; 36];
        from.read_exact(&mut head)?;
        let number = |i: usize| u32::from_le_bytes([head[i], head[i + 1], head[i + 2], head[i + 3]]);
        let (size, checksum, bytes) = ([number(8), number(12)], number(16), number(20));
        let pixels = pixels(size);
        if &head[..8] != MAGIC || !(1..=1 << 26).contains(&pixels) {
            return Err(damaged());
        }
        let [gain, nearness, f35_mm] = [24, 28, 32].map(|i| f32::from_bits(number(i)));
        let is_metric = [gain, nearness, f35_mm].iter().all(|number| number.is_finite());
        let mut packed = ZlibDecoder::new(from);
        let mut content = Vec::new();
        packed.by_ref().take(pixels as u64 * 4).read_to_end(&mut content)?;
        let disparity_px = content.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
        let map = DisparityMap::new(size, disparity_px).map_err(|_wrong_length| damaged())?;
        let metric = is_metric.then_some(Metric { gain, nearness, f35_mm });
        Ok((Self { map, metric, differences: Vec::new(), checksum }, bytes.into(), packed))
    }
}

#[cfg(test)]
mod tests {
    use std::thread::sleep;
    use std::time::Duration;

    use super::*;

    fn entry(seed: u8, bytes: usize) -> Entry {
        // Bytes that hardly compress, so that sizes are as meant.
        let mut state = u32::from(seed) + 1;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8
        };
        Entry {
            map: DisparityMap::constant([3, 2], 0.5),
            metric: Some(Metric { gain: 0.5, nearness: -0.25, f35_mm: 26.0 }),
            differences: (0..bytes).map(|_| next()).collect(),
            checksum: 7,
        }
    }

    fn key(name: &str) -> CacheKey {
        CacheKey(name.to_owned())
    }

    #[test]
    fn an_entry_comes_back_and_a_damaged_one_is_as_good_as_none() {
        let folder = tempfile::tempdir().unwrap();
        let cache = Cache::new(folder.path(), 1 << 20);
        cache.write(&key("a"), &entry(1, 1000)).unwrap();
        assert_eq!(cache.read(&key("a")), Some(entry(1, 1000)));
        assert_eq!(cache.read(&key("b")), None);
        assert_eq!(cache.read_map(&key("a")), Some((entry(1, 0).map, entry(1, 0).metric)));
        let of_map = Entry::of_map(DisparityMap::constant([3, 2], 0.5), None);
        cache.write(&key("map"), &of_map).unwrap();
        let read = (cache.read_map(&key("map")), cache.read(&key("map")));
        assert_eq!(read, (Some((of_map.map.clone(), None)), Some(of_map)));
        let path = cache.path(&key("a"));
        let whole = fs::read(&path).unwrap();
        for cut in [0, 7, 20, 30, whole.len() - 1] {
            fs::write(&path, &whole[..cut]).unwrap();
            assert_eq!(cache.read(&key("a")), None, "cut at {cut}");
        }
    }

    #[test]
    fn the_longest_unused_entry_goes_first_and_clear_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let cache = Cache::new(folder.path(), 9000);
        for name in ["a", "b", "a", "c"] {
            match cache.read(&key(name)) {
                Some(_) => (),
                None => cache.write(&key(name), &entry(2, 4000)).unwrap(),
            }
            sleep(Duration::from_millis(20));
        }
        assert!(cache.read(&key("a")).is_some() && cache.read(&key("c")).is_some());
        assert!(cache.read(&key("b")).is_none(), "b was unused for longest");
        cache.clear().unwrap();
        assert_eq!(cache.size_bytes(), 0);
    }
}
