//! What the generic code asks of a vector register, and the functions built on it.
//!
//! Everything here is inlined into an entry point that has the instructions switched on ([`entry_points`]).

/// A register of `f32`. Each operation is lane by lane.
///
/// # Safety
/// Of all functions: the processor has the instructions of the type, pointers are good for what is read or written.
pub(super) trait Vector: Copy {
    /// Values in the register.
    const LANES: usize;
    unsafe fn splat(value: f32) -> Self;
    unsafe fn load(from: *const f32) -> Self;
    /// The first `n` < `LANES` values; the others are 0.
    unsafe fn load_first(from: *const f32, n: usize) -> Self;
    unsafe fn store(self, to: *mut f32);
    /// Writes the first `n` < `LANES` values.
    unsafe fn store_first(self, to: *mut f32, n: usize);
    unsafe fn add(self, other: Self) -> Self;
    unsafe fn sub(self, other: Self) -> Self;
    unsafe fn mul(self, other: Self) -> Self;
    unsafe fn div(self, other: Self) -> Self;
    unsafe fn min(self, other: Self) -> Self;
    unsafe fn max(self, other: Self) -> Self;
    /// `self · factor + summand`.
    unsafe fn mul_add(self, factor: Self, summand: Self) -> Self;
    /// The nearest whole number.
    unsafe fn round(self) -> Self;
    /// `self · 2^exponent`, the exponent whole, −126 … 0.
    unsafe fn scale(self, exponent: Self) -> Self;
    /// `positive` where `self` > 0, else `other` (also where `self` is NaN).
    unsafe fn if_positive(self, positive: Self, other: Self) -> Self;
    /// The sum of all values.
    unsafe fn sum(self) -> f32;
    /// Transposes 16×16 values, rows being `from_step` and `to_step` values apart.
    #[inline(always)]
    unsafe fn transpose_16(from: *const f32, from_step: usize, to: *mut f32, to_step: usize) {
        for i in 0..16 {
            for j in 0..16 {
                // SAFETY: the caller's word.
                unsafe { *to.add(j * to_step + i) = *from.add(i * from_step + j) };
            }
        }
    }
}

/// `exp(x)` for x ≤ 0, relative error below 2e-7 (Cephes `expf`: range reduction by ln 2, polynomial of degree 7).
#[inline(always)]
pub(super) unsafe fn exp_of_negative<V: Vector>(x: V) -> V {
    // SAFETY: see the trait; no memory is touched.
    unsafe {
        let x = V::splat(-87.0).max(x);
        let k = x.mul(V::splat(std::f32::consts::LOG2_E)).round();
        let r = k.mul_add(V::splat(-0.693_359_4), x);
        let r = k.mul_add(V::splat(2.121_944_4e-4), r);
        let mut p = V::splat(1.987_569_1e-4);
        for coefficient in [1.398_2e-3, 8.333_452e-3, 4.166_579_6e-2, 1.666_666_5e-1, 0.5] {
            p = p.mul_add(r, V::splat(coefficient));
        }
        r.mul(r).mul_add(p, r).add(V::splat(1.0)).scale(k)
    }
}

/// `x` where positive, else `exp(x) − 1`. NaN stays NaN.
#[inline(always)]
pub(super) unsafe fn elu<V: Vector>(x: V) -> V {
    // SAFETY: see the trait; no memory is touched.
    unsafe {
        let negative = exp_of_negative(V::splat(0.0).min(x)).sub(V::splat(1.0));
        x.if_positive(x, negative)
    }
}

/// The derivative of [`elu`].
#[inline(always)]
pub(super) unsafe fn elu_slope<V: Vector>(x: V) -> V {
    // SAFETY: see the trait; no memory is touched.
    unsafe { x.if_positive(V::splat(1.0), exp_of_negative(V::splat(0.0).min(x))) }
}

/// `tanh(x)`, error below 4e-7 (the rational function of Eigen's `ptanh`, odd of degree 13 over 6).
#[inline(always)]
pub(super) unsafe fn tanh<V: Vector>(x: V) -> V {
    const ODD: [f32; 6] = [2.000_188e-13, -8.604_672e-11, 5.122_297e-8, 1.485_722_3e-5, 6.372_619_4e-4, 4.893_524_6e-3];
    const EVEN: [f32; 3] = [1.185_347_1e-4, 2.268_434_6e-3, 4.893_525e-3];
    // SAFETY: see the trait; no memory is touched.
    unsafe {
        let limit = V::splat(7.905_31);
        let x = limit.min(V::splat(-7.905_31).max(x));
        let square = x.mul(x);
        let mut odd = V::splat(-2.760_768_5e-16);
        for coefficient in ODD {
            odd = odd.mul_add(square, V::splat(coefficient));
        }
        let mut even = V::splat(1.198_258_4e-6);
        for coefficient in EVEN {
            even = even.mul_add(square, V::splat(coefficient));
        }
        x.mul(odd).div(even)
    }
}

/// GELU, `x · Φ(x)`, error below 2e-7 of `x` (Abramowitz and Stegun 7.1.26 for the tail of the normal distribution).
#[inline(always)]
pub(super) unsafe fn gelu<V: Vector>(x: V) -> V {
    const TAIL: [f32; 4] = [-1.453_152_1, 1.421_413_8, -0.284_496_72, 0.254_829_6];
    // SAFETY: see the trait; no memory is touched.
    unsafe {
        // Below, the result is 0 to all digits; and −∞ · 0 would not be.
        let x = V::splat(-50.0).max(x);
        let z = x.mul(V::splat(std::f32::consts::FRAC_1_SQRT_2));
        let minus_z = V::splat(0.0).sub(z);
        let t = V::splat(1.0).div(z.max(minus_z).mul_add(V::splat(0.327_591_1), V::splat(1.0)));
        let mut polynomial = V::splat(1.061_405_4);
        for coefficient in TAIL {
            polynomial = polynomial.mul_add(t, V::splat(coefficient));
        }
        let tail = exp_of_negative(z.mul(minus_z)).mul(polynomial.mul(t)).mul(V::splat(0.5));
        let product = x.mul(tail);
        x.if_positive(x.sub(product), product)
    }
}

/// The functions that the rest of the kernel calls, compiled for one set of instructions.
macro_rules! entry_points {
    ($vector:ty $(, $features:literal)?) => {
        use $crate::kernel::winograd::batch::{pixels, products, tiles, weights};
        use $crate::kernel::winograd::{plane_tile, volume_tile};
        use $crate::kernel::{ending, halves, norm, peak, product, resize, split, tile, token, weight_tile};

        $(#[target_feature(enable = $features)])?
        pub(in crate::kernel) unsafe fn convolve_tile(tile: &tile::Tile) {
            // SAFETY: the caller's word.
            unsafe { tile::run::<$vector>(tile) }
        }

        $(#[target_feature(enable = $features)])?
        pub(in crate::kernel) unsafe fn product(block: &product::tile::Block) {
            // SAFETY: the caller's word.
            unsafe { product::tile::run::<$vector>(block) }
        }

        $(#[target_feature(enable = $features)])?
        pub(in crate::kernel) unsafe fn soft_scores(scores: &product::attention::Scores) {
            // SAFETY: the caller's word.
            unsafe { product::soft::run::<$vector>(scores) }
        }

        $(#[target_feature(enable = $features)])?
        pub(in crate::kernel) unsafe fn resize_across(across: &resize::Across) {
            // SAFETY: the caller's word.
            unsafe { resize::across(across) }
        }

        $(#[target_feature(enable = $features)])?
        pub(in crate::kernel) unsafe fn resize_down(down: &resize::Down) {
            // SAFETY: the caller's word.
            unsafe { resize::down::<$vector>(down) }
        }

        $(#[target_feature(enable = $features)])?
        pub(in crate::kernel) unsafe fn layer_norm_row(row: &token::Row) {
            // SAFETY: the caller's word.
            unsafe { token::normalise::<$vector>(row) }
        }

        $(#[target_feature(enable = $features)])?
        pub(in crate::kernel) unsafe fn depthwise_plane(plane: &product::depthwise::Plane) {
            // SAFETY: the caller's word.
            unsafe { product::depthwise::run::<$vector>(plane) }
        }

        $(#[target_feature(enable = $features)])?
        pub(in crate::kernel) unsafe fn split_pairs(from: &[f32], to: &mut [f32]) {
            product::depthwise::split_pairs(from, to);
        }

        $(#[target_feature(enable = $features)])?
        pub(in crate::kernel) unsafe fn split_row(row: &mut split::Row) {
            split::split(row);
        }

        $(#[target_feature(enable = $features)])?
        pub(in crate::kernel) unsafe fn finish_split(finish: &split::Finish) {
            // SAFETY: the caller's word.
            unsafe { split::finish::<$vector>(finish) }
        }

        $(#[target_feature(enable = $features)])?
        pub(in crate::kernel) unsafe fn pair_rows(rows: [&[f32]; 2], to: &mut [u32]) {
            halves::planes::pair(rows, to);
        }

        $(#[target_feature(enable = $features)])?
        pub(in crate::kernel) unsafe fn pair_pixels(row: &[f32], to: &mut [u32]) {
            halves::planes::pair_pixels(row, to);
        }

        $(#[target_feature(enable = $features)])?
        pub(in crate::kernel) unsafe fn halve_row(row: &[f32], to: &mut [u16]) {
            halves::planes::halve(row, to);
        }

        $(#[target_feature(enable = $features)])?
        pub(in crate::kernel) unsafe fn winograd_plane(tiles: &plane_tile::Tiles, scratch: *mut f32) {
            // SAFETY: the caller's word.
            unsafe { plane_tile::run::<$vector>(tiles, scratch) }
        }

        $(#[target_feature(enable = $features)])?
        pub(in crate::kernel) unsafe fn winograd_enter(tiles: &plane_tile::Tiles, to: plane_tile::Transformed) {
            // SAFETY: the caller's word.
            unsafe { plane_tile::enter::<$vector>(tiles, to) }
        }

        $(#[target_feature(enable = $features)])?
        pub(in crate::kernel) unsafe fn winograd_component(component: &plane_tile::Component) {
            // SAFETY: the caller's word.
            unsafe { plane_tile::component::<$vector>(component) }
        }

        $(#[target_feature(enable = $features)])?
        pub(in crate::kernel) unsafe fn winograd_leave(tiles: &plane_tile::Tiles, from: plane_tile::Transformed) {
            // SAFETY: the caller's word.
            unsafe { plane_tile::leave::<$vector>(tiles, from) }
        }

        $(#[target_feature(enable = $features)])?
        pub(in crate::kernel) unsafe fn winograd_volume(tile: &volume_tile::VolumeTile) {
            // SAFETY: the caller's word.
            unsafe { volume_tile::run::<$vector>(tile) }
        }

        $(#[target_feature(enable = $features)])?
        pub(in crate::kernel) unsafe fn winograd_views(input: &volume_tile::VolumeInput) {
            // SAFETY: the caller's word.
            unsafe { volume_tile::transform::<$vector>(input) }
        }

        $(#[target_feature(enable = $features)])?
        pub(in crate::kernel) unsafe fn transpose(from: *const f32, steps: [usize; 2], to: *mut f32, blocks: [usize; 2]) {
            // SAFETY: the caller's word.
            unsafe { pixels::transpose::<$vector>(from, steps, to, blocks) }
        }

        $(#[target_feature(enable = $features)])?
        pub(in crate::kernel) unsafe fn winograd_channels(channels: &tiles::Channels) {
            // SAFETY: the caller's word.
            unsafe { tiles::run::<$vector>(channels) }
        }

        $(#[target_feature(enable = $features)])?
        pub(in crate::kernel) unsafe fn winograd_products(products: &products::Products) {
            // SAFETY: the caller's word.
            unsafe { products::forward::<$vector>(products) }
        }

        $(#[target_feature(enable = $features)])?
        pub(in crate::kernel) unsafe fn winograd_weight_gradient(products: &products::Products) {
            // SAFETY: the caller's word.
            unsafe { products::weight_gradient::<$vector>(products) }
        }

        $(#[target_feature(enable = $features)])?
        pub(in crate::kernel) unsafe fn winograd_weights(weights: &weights::GroupWeights) {
            // SAFETY: the caller's word.
            unsafe { weights::transform::<$vector>(weights) }
        }

        $(#[target_feature(enable = $features)])?
        pub(in crate::kernel) unsafe fn winograd_weights_gradient(weights: &weights::GroupWeights) {
            // SAFETY: the caller's word.
            unsafe { weights::transform_gradient::<$vector>(weights) }
        }

        $(#[target_feature(enable = $features)])?
        pub(in crate::kernel) unsafe fn weight_gradient_tile(tile: &weight_tile::WeightTile, sums: *mut f32) {
            // SAFETY: the caller's word.
            unsafe { weight_tile::run::<$vector>(tile, sums) }
        }

        $(#[target_feature(enable = $features)])?
        pub(in crate::kernel) unsafe fn sum_and_squares(values: &[f32]) -> [f64; 2] {
            // SAFETY: the caller's word.
            unsafe { norm::rows::sum_and_squares::<$vector>(values) }
        }

        $(#[target_feature(enable = $features)])?
        pub(in crate::kernel) unsafe fn dot_row(a: &[f32], b: &[f32]) -> f32 {
            // SAFETY: the caller's word.
            unsafe { norm::rows::dot::<$vector>(a, b) }
        }

        $(#[target_feature(enable = $features)])?
        pub(in crate::kernel) unsafe fn multiply_add_chains(rounds: usize) -> f32 {
            // SAFETY: the caller's word.
            unsafe { peak::chains::<$vector>(rounds) }
        }

        $(#[target_feature(enable = $features)])?
        pub(in crate::kernel) unsafe fn activate(values: &mut [f32], activation: tile::Activation) {
            // SAFETY: the caller's word.
            unsafe { norm::rows::activate::<$vector>(values, activation) }
        }

        $(#[target_feature(enable = $features)])?
        pub(in crate::kernel) unsafe fn end_row(values: &mut [f32], summand: &[f32], limits: ending::Limits) {
            // SAFETY: the caller's word.
            unsafe { norm::rows::end_row::<$vector>(values, summand, limits) }
        }

        $(#[target_feature(enable = $features)])?
        pub(in crate::kernel) unsafe fn elu_row(z: &[f32], y: *mut f32, scale: f32, shift: f32) {
            // SAFETY: the caller's word.
            unsafe { norm::rows::elu_row::<$vector>(z, y, scale, shift) }
        }

        $(#[target_feature(enable = $features)])?
        pub(in crate::kernel) unsafe fn elu_gradient_sums(z: &[f32], gy: &[f32], scale: f32, shift: f32) -> [f64; 2] {
            // SAFETY: the caller's word.
            unsafe { norm::rows::elu_gradient_sums::<$vector>(z, gy, scale, shift) }
        }

        $(#[target_feature(enable = $features)])?
        pub(in crate::kernel) unsafe fn elu_gradient_row(
            z: &[f32],
            gy: &[f32],
            gz: &mut [f32],
            channel: norm::Channel,
        ) {
            // SAFETY: the caller's word.
            unsafe { norm::rows::elu_gradient_row::<$vector>(z, gy, gz, channel) }
        }
    };
}
pub(super) use entry_points;
