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
/// More bytes than this are no prop; they are not even read.
const MOST_BYTES: u64 = 64 << 20;

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
                Ok((prop, note)) => {
                    stock.props.entry(entry.kind).or_default().push(prop);
                    stock.notes.extend(note.map(|note| note.to_string()));
                }
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
        if !path.exists() {
            return Vec::new();
        }
        let text = std::fs::read_to_string(&path).unwrap_or_else(|why| {
            self.notes.push(left_out("manifest", &path, why).to_string());
            String::new()
        });
        let mut entries = Vec::new();
        for line in text.lines().filter(|line| !line.trim().is_empty()) {
            match serde_json::from_str::<Entry>(line) {
                Ok(entry) if side(&entry.id) == split => entries.push(entry),
                Ok(_) => {}
                Err(why) => self.notes.push(left_out("line of the manifest", &path, why).to_string()),
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

/// A mesh of the folder, and a sentence where it must be painted because its picture cannot be read.
fn read_prop(folder: &Path, entry: &Entry) -> Result<(Prop, Option<SceneError>), SceneError> {
    let path = folder.join(format!("{}.glb", entry.id));
    let length = std::fs::metadata(&path).map_err(|why| left_out("mesh", &path, why))?.len();
    if length > MOST_BYTES {
        return Err(left_out("mesh", &path, format!("it has {} MB", length >> 20)));
    }
    let bytes = std::fs::read(&path).map_err(|why| left_out("mesh", &path, why))?;
    let (mut mesh, lost) = glb::read(&bytes).map_err(|why| left_out("mesh", &path, why))?;
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
    if size.max_element() * metres > glb::FARTHEST_M {
        return Err(left_out("mesh", &path, "its extent is kilometres"));
    }
    let blank = lost || entry.tags.iter().any(|tag| tag == "untextured");
    let note = lost
        .then(|| SceneError::read("picture of the mesh", &path, "it is none", "a PNG or JPEG in it; it is painted"));
    Ok((Prop { mesh, size: size * metres, blank }, note))
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
    fn triangle(corners: [[f32; 3]; 3]) -> Vec<u8> {
        let json = r#"{"asset":{"version":"2.0"},"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
            "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],
            "bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36}]}"#;
        file(json, corners.as_flattened())
    }

    /// The same with a picture of zeros, which is none, and these places on it.
    fn textured(corners: [[f32; 3]; 3], places: [f32; 6]) -> Vec<u8> {
        let json = r#"{"asset":{"version":"2.0"},"meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1},
            "material":0}]}],"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},
            {"bufferView":0,"byteOffset":36,"componentType":5126,"count":3,"type":"VEC2"}],
            "bufferViews":[{"buffer":0,"byteLength":60},{"buffer":0,"byteOffset":60,"byteLength":16}],
            "images":[{"bufferView":1}],"textures":[{"source":0}],
            "materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}],"buffers":[{"byteLength":76}]}"#;
        file(json, &[corners.as_flattened(), &places, &[0.0; 4]].concat())
    }

    fn file(json: &str, numbers: &[f32]) -> Vec<u8> {
        let wide = json.len().div_ceil(4) * 4;
        let json = format!("{json:<wide$}");
        let data: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
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
        let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
        let whole = triangle(corners);
        std::fs::write(folder.join("skin.glb"), textured(corners, [0.0, f32::NAN, 1.0, 0.0, 0.0, 1.0])).unwrap();
        std::fs::write(folder.join("bare.glb"), textured(corners, [0.0, 0.0, 1.0, 0.0, 0.0, 1.0])).unwrap();
        std::fs::write(folder.join("good.glb"), &whole).unwrap();
        std::fs::write(folder.join("nan.glb"), triangle([[0.0; 3], [f32::NAN; 3], [1.0; 3]])).unwrap();
        std::fs::write(folder.join("cut.glb"), &whole[..60]).unwrap();
        std::fs::write(folder.join("text.glb"), "hello").unwrap();
        let many = String::from_utf8_lossy(&whole).replace("\"count\":3,", "\"count\":30000000,");
        std::fs::write(folder.join("many.glb"), many.as_bytes()).unwrap();
        std::fs::write(folder.join("giant.glb"), &whole).unwrap();
        let heavy = std::fs::File::create(folder.join("heavy.glb")).unwrap();
        heavy.set_len(MOST_BYTES + 1).unwrap();
        let names = ["good", "nan", "cut", "text", "many", "missing", "heavy", "skin", "bare"];
        let lines: String = names.iter().map(|id| format!("{{\"id\":\"{id}\",\"kind\":\"toy\"}}\n")).collect();
        let giant = "{\"id\":\"giant\",\"kind\":\"toy\",\"extent\":[1e9,1,1]}\n";
        std::fs::write(folder.join("manifest.jsonl"), lines + giant + "{broken\n").unwrap();
        let both = [Split::Train, Split::Val].map(|split| Stock::load(data.path(), split));
        // The one whose picture is none is there, to be painted.
        assert_eq!(both.iter().map(|stock| stock.counts()[0]).sum::<usize>(), 2);
        for name in names[1..].iter().chain(["giant"].iter()) {
            let notes: Vec<&String> =
                both.iter().flat_map(|s| &s.notes).filter(|n| n.contains(&format!("{name}.glb"))).collect();
            assert_eq!(notes.len(), 1, "{name}: {notes:?}");
        }
        assert!(both[0].notes.iter().any(|note| note.contains("manifest")));
        let props = || both.iter().flat_map(|stock| stock.props.values().flatten());
        assert!(props().all(|prop| prop.size == glam::Vec3::new(1.0, 2.0, 0.0)));
        assert_eq!(props().filter(|prop| prop.blank).count(), 1);
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
