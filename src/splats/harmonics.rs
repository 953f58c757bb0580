//! Colour by direction: real spherical harmonics up to degree 3, in the order and with the signs of the usual files.

use glam::Vec3;

/// The highest degree that is read.
pub const MOST_DEGREE: usize = 3;
/// `√(1 / 4π)`: what the constant coefficient is multiplied by.
pub const CONSTANT: f32 = 0.282_094_8;

const FIRST: f32 = 0.488_602_5;
const SECOND: [f32; 5] = [1.092_548_4, -1.092_548_4, 0.315_391_57, -1.092_548_4, 0.546_274_2];
const THIRD: [f32; 7] =
    [-0.590_043_6, 2.890_611_4, -0.457_045_8, 0.373_176_33, -0.457_045_8, 1.445_305_7, -0.590_043_6];

/// Coefficients of a channel up to a degree.
pub const fn count(degree: usize) -> usize {
    (degree + 1) * (degree + 1)
}

/// What each coefficient counts in a direction of length 1.
pub fn basis(degree: usize, direction: Vec3) -> [f32; 16] {
    let mut values = [0.0; 16];
    values[0] = CONSTANT;
    let [x, y, z] = direction.to_array();
    if degree > 0 {
        values[1..4].copy_from_slice(&[-FIRST * y, FIRST * z, -FIRST * x]);
    }
    let [xx, yy, zz] = [x * x, y * y, z * z];
    if degree > 1 {
        let terms = [x * y, y * z, 2.0 * zz - xx - yy, x * z, xx - yy];
        (0..5).for_each(|i| values[4 + i] = SECOND[i] * terms[i]);
    }
    if degree > 2 {
        let terms = [
            y * (3.0 * xx - yy),
            x * y * z,
            y * (4.0 * zz - xx - yy),
            z * (2.0 * zz - 3.0 * xx - 3.0 * yy),
            x * (4.0 * zz - xx - yy),
            z * (xx - yy),
            x * (xx - 3.0 * yy),
        ];
        (0..7).for_each(|i| values[9 + i] = THIRD[i] * terms[i]);
    }
    values
}

/// The colour that is seen in a direction (from the eye to the Gaussian, of length 1), 0 … 1 and above.
pub fn color(degree: usize, coefficients: &[[f32; 3]], direction: Vec3) -> [f32; 3] {
    let weights = basis(degree, direction);
    let mut sum = [0.5; 3];
    for (weight, coefficient) in weights.iter().zip(coefficients) {
        (0..3).for_each(|c| sum[c] += weight * coefficient[c]);
    }
    sum.map(|value| value.max(0.0))
}

/// The constant coefficients of a colour that is the same in all directions.
pub fn constant(color: [f32; 3]) -> [f32; 3] {
    color.map(|value| (value - 0.5) / CONSTANT)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Directions spread evenly over the sphere (Fibonacci).
    fn directions(count: usize) -> impl Iterator<Item = Vec3> {
        (0..count).map(move |i| {
            let z = 1.0 - (2.0 * i as f32 + 1.0) / count as f32;
            let turn = i as f32 * 2.399_963_2;
            let r = (1.0 - z * z).sqrt();
            Vec3::new(r * turn.cos(), r * turn.sin(), z)
        })
    }

    #[test]
    fn the_functions_are_orthonormal() {
        const COUNT: usize = 4000;
        let mut products = [[0.0f64; 16]; 16];
        for direction in directions(COUNT) {
            let values = basis(3, direction);
            for (i, row) in products.iter_mut().enumerate() {
                for (j, sum) in row.iter_mut().enumerate() {
                    *sum += f64::from(values[i] * values[j]) * 4.0 * std::f64::consts::PI / COUNT as f64;
                }
            }
        }
        for (i, row) in products.iter().enumerate() {
            for (j, product) in row.iter().enumerate() {
                let want = if i == j { 1.0 } else { 0.0 };
                assert!((product - want).abs() < 2e-3, "{i} {j}: {product}");
            }
        }
    }

    #[test]
    fn a_constant_colour_comes_back_from_everywhere() {
        let coefficients = [constant([0.2, 0.5, 0.9])];
        for direction in directions(10) {
            let seen = color(0, &coefficients, direction);
            assert!(seen.iter().zip([0.2, 0.5, 0.9]).all(|(a, b)| (a - b).abs() < 1e-6));
        }
    }
}
