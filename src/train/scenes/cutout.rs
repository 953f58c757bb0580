//! A photo taken apart: the subject without its surround, the surround without the subject.

use super::library::{Picture, byte_from_nearness, nearness_from_byte, to_u8};
use super::raster::{Raster, distance_inside, push_pull};

/// Least nearness by which a subject stands before what is just behind it.
const STEP: f32 = 0.2;

/// The two layers of a masked photo, all of the photo's size.
pub struct Cutout {
    /// The photo with the subject filled in.
    pub behind: Raster<[u8; 3]>,
    /// Nearness of the subject and of what is behind it, where the photo has a map.
    pub nearness: Option<[Raster<u8>; 2]>,
    /// Left, top, right, bottom of the coverage.
    pub bounds: [usize; 4],
    /// The subject at the photo's size, at half and at a quarter of it, for cut-outs that are shown small.
    looks: [Look; 3],
}

/// The subject at one size.
pub struct Look {
    /// Its colours, carried on beyond its edge.
    pub front: Raster<[u8; 3]>,
    /// Coverage, 0 … 255.
    pub alpha: Raster<u8>,
    /// How far inside a pixel lies: √(distance to the edge / the largest), 0 … 255.
    pub dome: Raster<u8>,
}

impl Cutout {
    /// Takes a picture apart along its mask.
    pub fn new(picture: &Picture, mask: &Raster<u8>) -> Self {
        let rgb = picture.rgb.map(|texel| texel.map(f32::from));
        let outside = outside_weight(mask);
        let inside: Vec<f32> = mask.px.iter().map(|&m| f32::from(u8::from(m > 230))).collect();
        let behind = to_u8(&behind(&rgb, &outside));
        let front = to_u8(&push_pull(&rgb, &inside));
        let solid: Vec<bool> = mask.px.iter().map(|&m| m > 127).collect();
        let distance = distance_inside(&solid, mask.size);
        let deepest = distance.iter().fold(1.0f32, |a, &b| a.max(b));
        let dome = distance.iter().map(|d| ((d / deepest).sqrt() * 255.0 + 0.5) as u8).collect();
        let nearness = picture.nearness.as_ref().map(|map| split_nearness(map, &outside, &distance));
        let dome = Raster { size: mask.size, px: dome };
        let whole = Look { front, alpha: mask.clone(), dome };
        let looks = [whole.shrunk(1), whole.shrunk(2), whole.shrunk(4)];
        Self { behind, nearness, bounds: bounds(mask), looks }
    }

    /// The subject at the photo's size.
    pub fn subject(&self) -> &Look {
        &self.looks[0]
    }

    /// The subject for where a canvas pixel is `step` of the photo's, and by what it is smaller than the photo.
    pub fn look(&self, step: f32) -> (&Look, f32) {
        match step {
            s if s < 1.5 => (&self.looks[0], 1.0),
            s if s < 3.0 => (&self.looks[1], 2.0),
            _ => (&self.looks[2], 4.0),
        }
    }
}

impl Look {
    fn shrunk(&self, times: usize) -> Self {
        let gray = |raster: &Raster<u8>| shrunk(&raster.map(|&value| [value]), times).map(|texel| texel[0]);
        Self { front: shrunk(&self.front, times), alpha: gray(&self.alpha), dome: gray(&self.dome) }
    }
}

fn shrunk<const N: usize>(raster: &Raster<[u8; N]>, times: usize) -> Raster<[u8; N]> {
    to_u8(&raster.map(|texel| texel.map(f32::from)).resized(raster.size.map(|side| side.div_ceil(times))))
}

/// 1 well outside the mask, 0 inside it and within two pixels of it.
fn outside_weight(mask: &Raster<u8>) -> Vec<f32> {
    let clear: Vec<bool> = mask.px.iter().map(|&m| m < 6).collect();
    distance_inside(&clear, mask.size).iter().map(|&d| f32::from(u8::from(d > 2.0))).collect()
}

/// The photo without its subject: a smooth fill, and on it the fine texture of another place of the photo.
fn behind(rgb: &Raster<[f32; 3]>, outside: &[f32]) -> Raster<[f32; 3]> {
    let [w, h] = rgb.size;
    let fill = push_pull(rgb, outside);
    let mut smooth = fill.clone();
    smooth.blur(3.0);
    Raster::from_fn(rgb.size, |x, y| {
        let here = y * w + x;
        if outside[here] > 0.5 {
            return rgb.px[here];
        }
        let there = ((y + h / 2) % h) * w + (x + w / 2) % w;
        std::array::from_fn(|c| fill.px[here][c] + outside[there] * (fill.px[there][c] - smooth.px[there][c]))
    })
}

/// The map of the subject alone and of what is behind it; the subject is nearer than what it hides and borders on.
fn split_nearness(map: &Raster<u8>, outside: &[f32], distance: &[f32]) -> [Raster<u8>; 2] {
    let nearness = map.map(|&byte| [nearness_from_byte(f32::from(byte))]);
    // Nearness maps are soft at edges: what is next to the edge belongs to neither side.
    let core: Vec<f32> = distance.iter().map(|&d| f32::from(u8::from(d > 2.5))).collect();
    let core = if core.iter().sum::<f32>() < 8.0 { distance.iter().map(|&d| d.min(1.0)).collect() } else { core };
    let back = push_pull(&nearness, outside);
    let front = push_pull(&nearness, &core);
    let edge = |d: f32| (0.5..4.0).contains(&d);
    let steps = distance.iter().enumerate().filter(|(_, d)| edge(**d)).map(|(i, _)| front.px[i][0] - back.px[i][0]);
    let (sum, count) = steps.fold((0.0, 0.0f32), |(sum, count), step| (sum + step, count + 1.0));
    let lift = (STEP - sum / count.max(1.0)).max(0.0);
    let front = Raster::from_fn(map.size, |x, y| {
        byte_from_nearness((front.at(x, y)[0] + lift).max(back.at(x, y)[0] + 0.3 * STEP))
    });
    [front, back.map(|texel| byte_from_nearness(texel[0]))]
}

fn bounds(mask: &Raster<u8>) -> [usize; 4] {
    let [w, h] = mask.size;
    let hit = mask.px.iter().enumerate().filter(|(_, m)| **m > 5).map(|(i, _)| [i % w, i / w]);
    hit.fold([w, h, 0, 0], |[l, t, r, b], [x, y]| [l.min(x), t.min(y), r.max(x + 1), b.max(y + 1)])
}
