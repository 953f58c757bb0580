//! What a light field's other views see behind the edges of the reference view.

use super::behind::Revealed;
use crate::field::color::linear_from_srgb8;
use crate::field::{LightField, RayDepths};

/// Farther than the reference view's surface by this much, in pixels per view step.
const BEHIND_PX: f32 = 0.08;

/// Brings every ray that the reference view cannot see to where it would be in it. For views that a camera saw: those that
/// nets made know no more than the photo, and the near side's colours go on in them. Of several the farthest surface's
/// are averaged, as that is what remains when all before it is taken away.
pub fn revealed(field: &LightField, depths: &RayDepths) -> Revealed {
    let size = field.size();
    let [width, height] = size.map(|s| s as i32);
    let reference = depths.reference();
    let mut revealed = Revealed::filled(size, [0.0; 5]);
    let cells = revealed.pixels_mut();
    for at in field.grid().views() {
        let step = field.grid().offset(at);
        let (view, depth) = (field.view(at), depths.view(at));
        for y in 0..height {
            for x in 0..width {
                let here = (y * width + x) as usize;
                let d = depth[here];
                // L(x, u) = L(x + u·D, 0): the same point in the reference view.
                let [tx, ty] = [x as f32 + step.du * d, y as f32 + step.dv * d].map(|v| v.round() as i32);
                if tx < 0 || ty < 0 || tx >= width || ty >= height {
                    continue;
                }
                let there = (ty * width + tx) as usize;
                let known = if cells[there][4] > 0.0 { cells[there][3] / cells[there][4] } else { f32::MAX };
                if d > reference[there] - BEHIND_PX || d > known + BEHIND_PX {
                    continue;
                }
                if d < known - BEHIND_PX {
                    cells[there] = [0.0; 5];
                }
                let [r, g, b, _] = view.pixel(x as u32, y as u32).map(linear_from_srgb8);
                cells[there].iter_mut().zip([r, g, b, d, 1.0]).for_each(|(s, v)| *s += v);
            }
        }
    }
    for cell in cells {
        let weight = cell[4].max(1.0);
        cell.iter_mut().for_each(|v| *v /= weight);
    }
    revealed
}
