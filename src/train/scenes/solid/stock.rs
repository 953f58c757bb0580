//! What scenes are furnished with: meshes and textures of a data folder, by kind.
//!
//! About one in six of both is kept for validation, chosen by a hash of its name that is the same for names that differ
//! in their last letters: what a net is judged on is made of families of shapes and surfaces that it never saw.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use rayon::prelude::*;
use serde::Deserialize;

use super::glb;
use super::mesh::Mesh;
use super::texture::Texture;
use crate::rng::Rng;
use crate::scenes::library::{read_rgb, to_u8};
use crate::scenes::{SceneError, Split};

/// Long side of a texture in memory.
const TEXTURE_PX: usize = 128;

/// A mesh with its size.
pub struct Prop {
    /// The mesh.
    pub mesh: Mesh,
    /// Width, height and depth in metres.
    pub size: glam::Vec3,
    /// Whether it is a shape to be painted.
    pub blank: bool,
}

/// A texture, and whether it repeats.
pub struct Cloth {
    /// The picture.
    pub texture: Arc<Texture>,
    /// Whether it can lie side by side with itself.
    pub tileable: bool,
}

/// Meshes and textures by kind.
#[derive(Default)]
pub struct Stock {
    props: BTreeMap<String, Vec<Prop>>,
    cloths: BTreeMap<String, Vec<Cloth>>,
    /// A sentence for everything that was left out.
    pub notes: Vec<String>,
}

#[derive(Deserialize)]
struct Entry {
    id: String,
    kind: String,
    #[serde(default)]
    tags: Vec<String>,
    #[serde(default)]
    tileable: bool,
    #[serde(default)]
    extent: Option<[f32; 3]>,
}

/// Which side of the split a name is on.
pub fn side(id: &str) -> Split {
    // FNV-1a: the same on every machine and in every version. The last letters do not reach the bits that are asked.
    let hash = id.bytes().fold(0xcbf2_9ce4_8422_2325u64, |h, b| (h ^ u64::from(b)).wrapping_mul(0x0000_0100_0000_01b3));
    if (hash >> 32) % 8 == 0 { Split::Val } else { Split::Train }
}

impl Stock {
    /// Reads `meshes/` and `textures/` of a data folder. What cannot be used is told in [`Self::notes`]; without any of
    /// it, scenes are of shapes made by rule.
    pub fn load(data: &Path, split: Split) -> Self {
        let mut stock = Self::default();
        let meshes = stock.entries(&data.join("meshes"), split);
        let read: Vec<_> = meshes.par_iter().map(|entry| read_prop(&data.join("meshes"), entry)).collect();
        for (entry, prop) in meshes.into_iter().zip(read) {
            match prop {
                Ok(prop) => stock.props.entry(entry.kind).or_default().push(prop),
                Err(note) => stock.notes.push(note.to_string()),
            }
        }
        let textures = stock.entries(&data.join("textures"), split);
        let read: Vec<_> = textures.par_iter().map(|entry| read_cloth(&data.join("textures"), entry)).collect();
        for (entry, cloth) in textures.into_iter().zip(read) {
            match cloth {
                Ok(cloth) => stock.cloths.entry(entry.kind).or_default().push(cloth),
                Err(note) => stock.notes.push(note.to_string()),
            }
        }
        stock
    }

    fn entries(&mut self, folder: &Path, split: Split) -> Vec<Entry> {
        let path = folder.join("manifest.jsonl");
        let Ok(text) = std::fs::read_to_string(&path) else { return Vec::new() };
        let mut entries = Vec::new();
        for line in text.lines().filter(|line| !line.trim().is_empty()) {
            match serde_json::from_str::<Entry>(line) {
                Ok(entry) if side(&entry.id) == split => entries.push(entry),
                Ok(_) => {}
                Err(why) => self.notes.push(left_out("a line of the manifest", &path, why).to_string()),
            }
        }
        entries
    }

    /// A prop of one of these kinds, each kind as likely as the other; none where there are none.
    pub fn prop(&self, rng: &mut Rng, kinds: &[&str]) -> Option<&Prop> {
        pick(rng, &self.props, kinds)
    }

    /// A texture of one of these kinds.
    pub fn cloth(&self, rng: &mut Rng, kinds: &[&str]) -> Option<&Cloth> {
        pick(rng, &self.cloths, kinds)
    }

    /// Meshes and textures.
    pub fn counts(&self) -> [usize; 2] {
        [self.props.values().map(Vec::len).sum(), self.cloths.values().map(Vec::len).sum()]
    }
}

fn pick<'a, T>(rng: &mut Rng, all: &'a BTreeMap<String, Vec<T>>, kinds: &[&str]) -> Option<&'a T> {
    let there: Vec<&Vec<T>> = kinds.iter().filter_map(|kind| all.get(*kind)).collect();
    let list = there.get(rng.below(there.len()))?;
    list.get(rng.below(list.len()))
}

fn left_out(what: &'static str, path: &Path, why: impl ToString) -> SceneError {
    SceneError::read(what, path, why, "a usable one; it is left out")
}

fn read_prop(folder: &Path, entry: &Entry) -> Result<Prop, SceneError> {
    let path = folder.join(format!("{}.glb", entry.id));
    let bytes = std::fs::read(&path).map_err(|why| left_out("mesh", &path, why))?;
    let mut mesh = glb::read(&bytes).map_err(|why| left_out("mesh", &path, why))?;
    let (lo, hi) = mesh.bounds();
    let size = hi - lo;
    if size.max_element() <= 1e-4 {
        return Err(left_out("mesh", &path, "it has no size"));
    }
    // On the ground, about the origin, in metres: as the manifest says where the file has another unit.
    let metres = entry.extent.map_or(1.0, |extent| extent.into_iter().fold(0.0, f32::max) / size.max_element());
    let metres = if metres.is_finite() && metres > 0.0 { metres } else { 1.0 };
    let foot = glam::Vec3::new((lo.x + hi.x) / 2.0, lo.y, (lo.z + hi.z) / 2.0);
    mesh.corners.iter_mut().for_each(|corner| corner.at = (corner.at - foot) * metres);
    let blank = entry.tags.iter().any(|tag| tag == "untextured");
    Ok(Prop { mesh, size: size * metres, blank })
}

fn read_cloth(folder: &Path, entry: &Entry) -> Result<Cloth, SceneError> {
    let path = folder.join(format!("{}.jpg", entry.id));
    let picture = read_rgb("texture", &path)?;
    let size = plenoscope::field::fit_long_side(picture.size.map(|side| side as u32), TEXTURE_PX as u32);
    let small = to_u8(&picture.resized(size.map(|side| side as usize)));
    Ok(Cloth { texture: Arc::new(Texture::opaque(&small)), tileable: entry.tileable })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A binary glTF of one triangle with these corners.
    pub(crate) fn triangle(corners: [[f32; 3]; 3]) -> Vec<u8> {
        let json = r#"{"asset":{"version":"2.0"},"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
            "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],
            "bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36}]}"#;
        let wide = json.len().div_ceil(4) * 4;
        let json = format!("{json:<wide$}");
        let data: Vec<u8> = corners.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
        let word = |n: usize| (n as u32).to_le_bytes();
        let mut file = b"glTF".to_vec();
        file.extend([word(2), word(28 + json.len() + data.len()), word(json.len()), *b"JSON"].concat());
        file.extend(json.as_bytes());
        file.extend([word(data.len()), *b"BIN\0"].concat());
        file.extend(data);
        file
    }

    #[test]
    fn bad_meshes_are_told_by_name_and_the_rest_is_there() {
        let data = tempfile::tempdir().unwrap();
        let folder = data.path().join("meshes");
        std::fs::create_dir_all(&folder).unwrap();
        let whole = triangle([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]]);
        std::fs::write(folder.join("good.glb"), &whole).unwrap();
        std::fs::write(folder.join("nan.glb"), triangle([[0.0; 3], [f32::NAN; 3], [1.0; 3]])).unwrap();
        std::fs::write(folder.join("cut.glb"), &whole[..60]).unwrap();
        std::fs::write(folder.join("text.glb"), "hello").unwrap();
        let many = String::from_utf8_lossy(&whole).replace("\"count\":3,", "\"count\":30000000,");
        std::fs::write(folder.join("many.glb"), many.as_bytes()).unwrap();
        let names = ["good", "nan", "cut", "text", "many", "missing"];
        let lines: String = names.iter().map(|id| format!("{{\"id\":\"{id}\",\"kind\":\"toy\"}}\n")).collect();
        std::fs::write(folder.join("manifest.jsonl"), lines + "{broken\n").unwrap();
        let both = [Split::Train, Split::Val].map(|split| Stock::load(data.path(), split));
        assert_eq!(both.iter().map(|stock| stock.counts()[0]).sum::<usize>(), 1);
        for name in &names[1..] {
            let notes: Vec<&String> =
                both.iter().flat_map(|s| &s.notes).filter(|n| n.contains(&format!("{name}.glb"))).collect();
            assert_eq!(notes.len(), 1, "{name}: {notes:?}");
        }
        assert!(both[0].notes.iter().any(|note| note.contains("manifest")));
        let good = both.iter().flat_map(|stock| stock.props.values().flatten()).next().unwrap();
        assert_eq!(good.size, glam::Vec3::new(1.0, 2.0, 0.0));
    }

    #[test]
    fn families_are_on_one_side_and_some_are_kept() {
        let name = |i: u32| format!("{:08x}_chair", i.wrapping_mul(2_654_435_761));
        let kept: Vec<u32> = (0..4000).filter(|&i| side(&name(i)) == Split::Val).collect();
        assert!((300..800).contains(&kept.len()), "{}", kept.len());
        assert!(
            kept.iter().all(|&i| (0..9).all(|k| side(&format!("{}_{k}", name(i))) == side(&format!("{}_9", name(i)))))
        );
    }
}
