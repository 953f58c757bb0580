//! Light as an encoder wants it: Y′CbCr of BT.709, 16 … 235, colour at half the size.

use rayon::prelude::*;

use crate::field::Picture;

/// One plane, `[y, x]`.
pub(super) struct Plane {
    pub(super) width: usize,
    pub(super) values: Vec<u8>,
}

/// Weights of red, green and blue in luma (BT.709).
const LUMA: [f32; 3] = [0.2126, 0.7152, 0.0722];

/// The planes of a picture, cut to an even size.
pub(super) fn planes(picture: &Picture, [width, height]: [u32; 2]) -> [Plane; 3] {
    let [width, height] = [width as usize, height as usize];
    let rgba = picture.to_srgb8();
    let stride = picture.size[0] as usize * 4;
    let encoded = |x: usize, y: usize| -> [f32; 3] { std::array::from_fn(|c| f32::from(rgba[y * stride + x * 4 + c])) };
    let luma = |rgb: [f32; 3]| (0..3).map(|c| LUMA[c] * rgb[c]).sum::<f32>() / 255.0;
    let mut y_values = vec![0; width * height];
    y_values.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
        row.iter_mut().enumerate().for_each(|(x, v)| *v = (16.5 + 219.0 * luma(encoded(x, y))) as u8);
    });
    let colors: Vec<[u8; 2]> = (0..width / 2 * (height / 2))
        .into_par_iter()
        .with_min_len(width)
        .map(|i| {
            let [x, y] = [i % (width / 2) * 2, i / (width / 2) * 2];
            let four = [encoded(x, y), encoded(x + 1, y), encoded(x, y + 1), encoded(x + 1, y + 1)];
            let mean: [f32; 3] = std::array::from_fn(|c| four.iter().map(|rgb| rgb[c]).sum::<f32>() / 4.0);
            let apart = |c: usize| (mean[c] / 255.0 - luma(mean)) / (2.0 * (1.0 - LUMA[c]));
            [2, 0].map(|c| (128.5 + 224.0 * apart(c)) as u8)
        })
        .collect();
    let plane = |of: usize| Plane { width: width / 2, values: colors.iter().map(|pair| pair[of]).collect() };
    [Plane { width, values: y_values }, plane(0), plane(1)]
}
