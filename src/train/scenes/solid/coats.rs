//! Coats and clothes: spots, stripes, brindle and checks on people and animals, whose depth they say nothing about.

use std::f32::consts::TAU;
use std::sync::Arc;

use glam::{Quat, Vec2, Vec3};

use super::mesh::{Face, Mesh};
use super::set::{Set, stand};
use super::shapes::any_way;
use super::texture::Texture;
use crate::rng::Rng;
use crate::scenes::raster::Raster;
use crate::scenes::walls::noise;

/// Side of a coat's picture.
const SIDE: usize = 64;

impl Mesh {
    /// The mesh in a coat whose picture is `metres` wide, painted on from the side that `turn` brings to the front.
    fn coated(&self, coat: Arc<Texture>, metres: f32, turn: Quat) -> Self {
        let mut corners = self.corners.clone();
        for corner in &mut corners {
            let seen = turn * corner.at / metres;
            corner.uv = Vec2::new(seen.x, seen.y);
        }
        let faces = self.faces.iter().map(|face| Face { tint: [1.0; 3], skin: 0, ..*face }).collect();
        Self { corners, faces, skins: vec![coat] }
    }
}

impl Set<'_> {
    /// Someone or some animal in a coat, its longest side as given.
    pub fn coated(&mut self, at: Vec3, longest: f32, yaw: f32) {
        let stock = self.stock;
        let Some(prop) = stock.prop(&mut self.rng, &["person", "animal"]) else { return };
        let metres = prop.size.max_element();
        let wide = metres * self.range(0.2, 0.9);
        let turn = Quat::from_rotation_arc(any_way(&mut self.rng), Vec3::Z);
        let cloth = if self.chance(0.3) { self.cloth(&["fabric"], wide).skin } else { None };
        let coat = cloth.unwrap_or_else(|| Arc::new(Texture::opaque(&hide(&mut self.rng))));
        let mesh = prop.mesh.coated(coat, wide, turn);
        self.world.add(&mesh, stand(at, yaw, longest / metres), None, true);
    }
}

/// Two colours in spots, stripes, brindle, checks or patches.
pub(super) fn hide(rng: &mut Rng) -> Raster<[u8; 3]> {
    let mut colour = || {
        let light = rng.range(15.0, 250.0);
        [1.0, rng.range(0.65, 1.0), rng.range(0.4, 1.0)].map(|share| light * share)
    };
    let (first, second) = (colour(), colour());
    let amount = pattern(rng);
    Raster::from_fn([SIDE; 2], |x, y| {
        let share = amount(x as f32 / SIDE as f32, y as f32 / SIDE as f32);
        [0, 1, 2].map(|c| (first[c] + (second[c] - first[c]) * share) as u8)
    })
}

/// How much of the second colour a place has, 0 … 1.
fn pattern(rng: &mut Rng) -> impl Fn(f32, f32) -> f32 {
    let (seed, kind) = (rng.next_u64(), rng.below(5));
    let (cells, sharp) = (rng.range(3.0, 14.0), rng.range(1.0, 8.0));
    let (least, bend) = (rng.range(0.35, 0.65), rng.range(0.0, 2.0));
    move |x, y| {
        let spots = |x: f32, y: f32| 0.65 * noise(seed, x, y) + 0.35 * noise(seed ^ 1, 2.3 * x, 2.3 * y);
        let waves = |t: f32| 0.5 + 0.5 * (TAU * t).sin();
        let value = match kind {
            0 => spots(cells * x, cells * y),
            1 => waves(cells * x + bend * spots(4.0 * x, 4.0 * y)),
            2 => spots(3.0 * cells * x, 0.4 * cells * y),
            3 => waves(cells.round() * x).max(waves(cells.round() * y)),
            _ => spots(0.4 * cells * x, 0.4 * cells * y),
        };
        (0.5 + sharp * (value - least)).clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::super::shapes::cuboid;
    use super::*;

    #[test]
    fn a_coat_covers_all_of_a_thing_and_changes_no_place() {
        let thing = cuboid(Vec3::new(0.5, 1.0, 0.2));
        let coat = Arc::new(Texture::opaque(&hide(&mut Rng::new(1, 0))));
        let coated = thing.coated(coat, 0.25, Quat::IDENTITY);
        assert!(thing.corners.iter().zip(&coated.corners).all(|(a, b)| a.at == b.at && a.normal == b.normal));
        assert!(coated.faces.iter().all(|face| face.skin == 0));
        let across = coated.corners.iter().map(|corner| corner.uv.x);
        let [least, most] = across.fold([f32::MAX, f32::MIN], |[lo, hi], u| [lo.min(u), hi.max(u)]);
        assert!((most - least - 2.0).abs() < 1e-5, "{least} {most}");
    }

    #[test]
    fn most_hides_have_a_pattern() {
        let contrast = |index| {
            let mut light: Vec<u8> = hide(&mut Rng::new(7, index)).px.iter().map(|px| px[0]).collect();
            light.sort_unstable();
            light[light.len() * 9 / 10] - light[light.len() / 10]
        };
        let seen = (0..60).filter(|&index| contrast(index) > 25).count();
        assert!(seen > 40, "{seen} of 60");
    }
}
