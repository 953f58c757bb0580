//! Meshes from `.glb` files (glTF 2.0 binary): triangles with colours of corners or a picture, as one mesh.
//!
//! Node transforms, animation and all of the material but its base colour are left out: the meshes that the data
//! engine is given are baked. Everything read is checked, so that a broken file is told in a sentence.

use std::sync::Arc;

use glam::{Vec2, Vec3};
use serde::Deserialize;

use super::mesh::{BARE, Face, Mesh};
use super::texture::Texture;
use crate::scenes::raster::Raster;

/// More triangles than this are no prop for a small picture.
pub const MOST_TRIANGLES: usize = 100_000;
/// No corner lies further from the origin, metres.
pub const FARTHEST_M: f32 = 1e4;
/// Long side of a mesh's picture in memory.
const SKIN_PX: usize = 128;

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
#[derive(Default)]
struct Root {
    meshes: Vec<Group>,
    accessors: Vec<Accessor>,
    buffer_views: Vec<BufferView>,
    materials: Vec<Material>,
    textures: Vec<Image>,
    images: Vec<Stored>,
}

#[derive(Deserialize)]
struct Group {
    primitives: Vec<Primitive>,
}

#[derive(Deserialize)]
struct Primitive {
    attributes: std::collections::BTreeMap<String, usize>,
    indices: Option<usize>,
    material: Option<usize>,
    #[serde(default = "triangles")]
    mode: u32,
}

fn triangles() -> u32 {
    4
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Accessor {
    buffer_view: Option<usize>,
    #[serde(default)]
    byte_offset: usize,
    component_type: u32,
    count: usize,
    #[serde(rename = "type")]
    kind: String,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct BufferView {
    #[serde(default)]
    byte_offset: usize,
    byte_length: usize,
    byte_stride: Option<usize>,
}

#[derive(Deserialize, Default)]
#[serde(rename_all = "camelCase", default)]
struct Material {
    pbr_metallic_roughness: Base,
}

#[derive(Deserialize, Default)]
#[serde(rename_all = "camelCase", default)]
struct Base {
    base_color_factor: Option<[f32; 4]>,
    base_color_texture: Option<Reference>,
}

#[derive(Deserialize)]
struct Reference {
    index: usize,
}

#[derive(Deserialize)]
struct Image {
    source: Option<usize>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Stored {
    buffer_view: Option<usize>,
}

struct File<'a> {
    root: Root,
    data: &'a [u8],
}

/// Reads a mesh, and tells whether a picture that it names cannot be read: such a thing is to be painted. The reason in a
/// few words where it cannot be used.
///
/// # Errors
/// No binary glTF 2.0; numbers that point outside the file; corners that are no numbers; too many triangles; none.
pub fn read(bytes: &[u8]) -> Result<(Mesh, bool), String> {
    let word = |at: usize| Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?) as usize);
    if bytes.get(..4) != Some(b"glTF") || word(4) != Some(2) {
        return Err("it is no binary glTF 2.0".into());
    }
    let length = word(12).ok_or("it ends early")?;
    let json = bytes.get(20..20usize.saturating_add(length)).ok_or("it ends early")?;
    let root: Root = serde_json::from_slice(json).map_err(|e| format!("its description is broken: {e}"))?;
    let file = File { root, data: bytes.get(28 + length..).unwrap_or(&[]) };
    file.mesh()
}

impl File<'_> {
    fn mesh(&self) -> Result<(Mesh, bool), String> {
        let (mut corners, mut faces) = (Vec::new(), Vec::new());
        let skins = self.root.materials.iter().map(|material| self.skin(material)).collect::<Vec<_>>();
        for primitive in self.root.meshes.iter().flat_map(|group| &group.primitives).filter(|p| p.mode == 4) {
            self.primitive(primitive, &skins, &mut corners, &mut faces)?;
        }
        if faces.is_empty() {
            return Err("it holds no triangles".into());
        }
        let mut kept = Vec::new();
        for face in &mut faces {
            if face.skin != BARE {
                let skin = skins[face.skin as usize].as_ref();
                let known = kept.iter().position(|own| skin.is_some_and(|skin| Arc::ptr_eq(own, skin)));
                face.skin = known.unwrap_or_else(|| {
                    kept.extend(skin.cloned());
                    kept.len() - 1
                }) as u32;
            }
        }
        let named = |material: &Material| material.pbr_metallic_roughness.base_color_texture.is_some();
        let lost = self.root.materials.iter().zip(&skins).any(|(material, skin)| named(material) && skin.is_none());
        Ok((Mesh::new(corners, faces, kept), lost))
    }

    fn primitive(
        &self,
        primitive: &Primitive,
        skins: &[Option<Arc<Texture>>],
        corners: &mut Vec<(Vec3, Vec2)>,
        faces: &mut Vec<Face>,
    ) -> Result<(), String> {
        let first = corners.len() as u32;
        let attribute = |name: &str| primitive.attributes.get(name).copied();
        let places = self.numbers(attribute("POSITION").ok_or("its corners have no places")?, 3)?;
        if places.iter().any(|x| x.abs() > FARTHEST_M) {
            return Err("corners of it are kilometres away".into());
        }
        let count = places.len() / 3;
        let indices = match primitive.indices {
            Some(accessor) => self.numbers(accessor, 1)?.into_iter().map(|i| i as u32).collect(),
            None => (0..count as u32).collect::<Vec<_>>(),
        };
        if faces.len() + indices.len() / 3 > MOST_TRIANGLES {
            return Err(format!("it has more than {MOST_TRIANGLES} triangles"));
        }
        if indices.iter().any(|&i| i as usize >= count) {
            return Err("a triangle of it names a corner that is not there".into());
        }
        let uv = attribute("TEXCOORD_0").map(|a| self.numbers(a, 2)).transpose()?.filter(|uv| uv.len() == 2 * count);
        let skin = primitive.material.filter(|&m| uv.is_some() && skins.get(m).is_some_and(Option::is_some));
        let colours = match attribute("COLOR_0") {
            Some(accessor) => Some((self.numbers(accessor, 0)?, self.channels(accessor)?)),
            None => None,
        };
        let factor = primitive.material.and_then(|m| self.root.materials.get(m)).and_then(Material::colour);
        let factor = factor.unwrap_or([if skin.is_some() || colours.is_some() { 1.0 } else { 0.6 }; 3]);
        corners.extend((0..count).map(|i| {
            let at = Vec3::from_slice(&places[3 * i..]);
            // Without a place on a picture, the thing is wrapped: metres along it and up.
            let wrapped = Vec2::new(at.x + at.z, -at.y);
            (at, uv.as_ref().filter(|_| skin.is_some()).map_or(wrapped, |uv| Vec2::from_slice(&uv[2 * i..])))
        }));
        let shade = |i: u32| match &colours {
            Some((values, n)) => [0, 1, 2].map(|c| values.get(i as usize * n + c).copied().unwrap_or(1.0)),
            None => [1.0; 3],
        };
        faces.extend(indices.chunks_exact(3).map(|t| {
            let shades = [shade(t[0]), shade(t[1]), shade(t[2])];
            let tint = [0, 1, 2].map(|c| (factor[c] * shades.iter().map(|s| s[c]).sum::<f32>() / 3.0).clamp(0.0, 1.0));
            let skin = skin.map_or(BARE, |skin| skin as u32);
            Face { corners: [t[0] + first, t[1] + first, t[2] + first], tint, skin }
        }));
        Ok(())
    }

    fn channels(&self, accessor: usize) -> Result<usize, String> {
        let accessor = self.root.accessors.get(accessor).ok_or("a table of it is missing")?;
        Ok(match accessor.kind.as_str() {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            other => return Err(format!("a table of it is of the kind {other}")),
        })
    }

    /// A table of numbers, of `wanted` numbers each unless that is 0; bytes of colours become 0 … 1.
    fn numbers(&self, index: usize, wanted: usize) -> Result<Vec<f32>, String> {
        let channels = self.channels(index)?;
        let accessor = &self.root.accessors[index];
        if wanted != 0 && channels != wanted {
            return Err(format!("a table of it has {channels} numbers an entry, not {wanted}"));
        }
        if accessor.count > 4 * MOST_TRIANGLES {
            return Err(format!("it has more than {MOST_TRIANGLES} triangles"));
        }
        let view = accessor.buffer_view.and_then(|v| self.root.buffer_views.get(v)).ok_or("a table of it is empty")?;
        let bytes = match accessor.component_type {
            5121 => 1,
            5123 => 2,
            5125 | 5126 => 4,
            other => return Err(format!("a table of it is of the type {other}")),
        };
        let stride = view.byte_stride.filter(|&stride| stride > 0).unwrap_or(bytes * channels);
        let start = view.byte_offset.saturating_add(accessor.byte_offset);
        let mut numbers = Vec::with_capacity(accessor.count * channels);
        for entry in 0..accessor.count {
            for channel in 0..channels {
                let at = start.saturating_add(entry.saturating_mul(stride) + channel * bytes);
                let raw = self.data.get(at..at.saturating_add(bytes)).ok_or("a table of it leaves the file")?;
                numbers.push(match (accessor.component_type, raw) {
                    (5121, &[a]) if wanted == 0 => f32::from(a) / 255.0,
                    (5121, &[a]) => f32::from(a),
                    (5123, &[a, b]) if wanted == 0 => f32::from(u16::from_le_bytes([a, b])) / 65535.0,
                    (5123, &[a, b]) => f32::from(u16::from_le_bytes([a, b])),
                    (5125, &[a, b, c, d]) => u32::from_le_bytes([a, b, c, d]) as f32,
                    (_, &[a, b, c, d]) => f32::from_le_bytes([a, b, c, d]),
                    _ => 0.0,
                });
            }
        }
        if numbers.iter().any(|x| !x.is_finite()) {
            return Err("a table of it holds what is no number".into());
        }
        Ok(numbers)
    }

    /// The picture of a material; none where it has none or it cannot be read.
    fn skin(&self, material: &Material) -> Option<Arc<Texture>> {
        let texture = self.root.textures.get(material.pbr_metallic_roughness.base_color_texture.as_ref()?.index)?;
        let view = self.root.buffer_views.get(self.root.images.get(texture.source?)?.buffer_view?)?;
        let bytes = self.data.get(view.byte_offset..view.byte_offset.checked_add(view.byte_length)?)?;
        let picture = image::load_from_memory(bytes).ok()?;
        let picture = picture.thumbnail(SKIN_PX as u32, SKIN_PX as u32).into_rgba8();
        let size = [picture.width() as usize, picture.height() as usize];
        let px = picture.pixels().map(|p| p.0).collect();
        Some(Arc::new(Texture::new(Raster { size, px })))
    }
}

impl Material {
    fn colour(&self) -> Option<[f32; 3]> {
        self.pbr_metallic_roughness.base_color_factor.map(|[r, g, b, _]| [r, g, b])
    }
}
