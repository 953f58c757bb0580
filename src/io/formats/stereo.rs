//! Two eyes in one picture: side by side, and red-cyan anaglyphs (Dubois 2001).

use std::path::Path;

use png::{BitDepth, ColorType};

use super::out;
use crate::field::Picture;
use crate::field::color::srgb8_from_linear;
use crate::field::{ViewOffset, ViewPoint};
use crate::io::save::SaveError;

/// Both eyes' viewpoints, `apart` view steps from each other, around the reference view.
pub fn eyes(apart: f32) -> [ViewPoint; 2] {
    [-0.5, 0.5].map(|side| ViewPoint(ViewOffset { dv: 0.0, du: side * apart }))
}

/// Eric Dubois' least-squares matrices for red-cyan glasses, in linear light; rows are red, green and blue out.
const LEFT: [[f32; 3]; 3] = [[0.437, 0.449, 0.164], [-0.062, -0.062, -0.024], [-0.048, -0.050, -0.017]];
const RIGHT: [[f32; 3]; 3] = [[-0.011, -0.032, -0.007], [0.377, 0.761, 0.009], [-0.026, -0.093, 1.234]];

/// The anaglyph of two pictures of one size.
pub fn anaglyph(left: &Picture, right: &Picture) -> Picture {
    let pair = left.rgb_linear.chunks_exact(3).zip(right.rgb_linear.chunks_exact(3));
    let mix = |(l, r): (&[f32], &[f32])| -> [f32; 3] {
        std::array::from_fn(|c| (0..3).map(|k| LEFT[c][k] * l[k] + RIGHT[c][k] * r[k]).sum::<f32>().clamp(0.0, 1.0))
    };
    Picture { rgb_linear: pair.flat_map(mix).collect(), ..left.clone() }
}

/// Writes two pictures beside each other at full width, left eye left. Players know it by `_3D_SBS` in the name.
///
/// # Errors
/// [`SaveError`]; then nothing has been written.
pub fn write_side_by_side(path: &Path, left: &Picture, right: &Picture) -> Result<(), SaveError> {
    let [width, height] = left.size;
    let stored =
        [left, right].map(|picture| picture.rgb_linear.iter().map(|&l| srgb8_from_linear(l)).collect::<Vec<u8>>());
    let bytes = width as usize * 3;
    let rows =
        (0..height as usize).map(|y| stored.iter().flat_map(|rgb| rgb[y * bytes..(y + 1) * bytes].to_vec()).collect());
    out::single(path, |out| out::png(out, [width * 2, height], (ColorType::Rgb, BitDepth::Eight), &[], rows))
}

/// Writes an anaglyph as PNG: chroma subsampling would make ghosts.
///
/// # Errors
/// [`SaveError`]; then nothing has been written.
pub fn write_anaglyph(path: &Path, left: &Picture, right: &Picture) -> Result<(), SaveError> {
    let picture = anaglyph(left, right);
    let rgb: Vec<u8> = picture.rgb_linear.iter().map(|&light| srgb8_from_linear(light)).collect();
    let rows = rgb.chunks_exact(picture.size[0] as usize * 3).map(<[u8]>::to_vec);
    out::single(path, |out| out::png(out, picture.size, (ColorType::Rgb, BitDepth::Eight), &[], rows))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain(rgb: [f32; 3]) -> Picture {
        Picture { size: [2, 1], rgb_linear: [rgb, rgb].concat() }
    }

    #[test]
    fn each_eye_gets_its_own_picture() {
        let (white, black) = (plain([1.0; 3]), plain([0.0; 3]));
        let left_only = anaglyph(&white, &black).rgb_linear;
        let right_only = anaglyph(&black, &white).rgb_linear;
        assert!(left_only[0] > 0.99 && left_only[1] == 0.0 && left_only[2] == 0.0, "{left_only:?}");
        assert!(right_only[0] == 0.0 && right_only[1] > 0.99 && right_only[2] > 0.99, "{right_only:?}");
        let both = anaglyph(&white, &white).rgb_linear;
        assert!(both.iter().all(|light| *light > 0.97), "white stays white: {both:?}");
    }

    #[test]
    fn the_left_eye_stands_on_the_left() {
        let [left, right] = eyes(2.0);
        assert!(left.0.du == -1.0 && right.0.du == 1.0);
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("x_3D_SBS.png");
        write_side_by_side(&path, &plain([1.0, 0.0, 0.0]), &plain([0.0, 0.0, 1.0])).unwrap();
        let picture = image::open(&path).unwrap().into_rgb8();
        assert_eq!(
            (picture.dimensions(), picture.get_pixel(0, 0).0, picture.get_pixel(3, 0).0),
            ((4, 1), [255, 0, 0], [0, 0, 255])
        );
    }
}
