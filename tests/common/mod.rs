//! Synthetic light fields whose truth is known, the tolerances, and a device for tests.
#![allow(dead_code, reason = "each test file uses its own part")]
#![allow(clippy::unwrap_used, reason = "in a test a panic is the failure")]

use std::sync::Arc;

use plenoscope::field::{LightField, RayDepths, View, ViewGrid};

/// How far two numbers of the same maths may be apart; nothing else is used.
#[derive(Clone, Copy, Debug)]
pub enum Approx {
    /// 1e-5 absolute and 1e-4 relative: the same maths in f32.
    Close,
    /// 2e-3: fast maths on a device.
    Fast,
}

impl Approx {
    /// Fails with the place of the worst difference.
    pub fn check(self, what: &str, got: &[f32], want: &[f32]) {
        assert_eq!(got.len(), want.len(), "{what}: lengths");
        let over = |g: f32, w: f32| match self {
            Self::Close => (g - w).abs() - 1e-4 * w.abs() - 1e-5,
            Self::Fast => (g - w).abs() - 2e-3,
        };
        for (i, (&g, &w)) in got.iter().zip(want).enumerate() {
            assert!(over(g, w) <= 0.0, "{what}: value {i} is {g}, not {w}");
        }
    }
}

/// A smooth texture that is different in x and y, sRGB.
pub fn texture(x: f32, y: f32) -> [u8; 4] {
    let wave = |a: f32, b: f32, c: f32| (127.5 + 90.0 * (x * a + y * b + c).sin()) as u8;
    [wave(0.21, 0.05, 0.0), wave(0.07, 0.33, 1.0), wave(0.13, -0.11, 2.0), 255]
}

/// A plane of one disparity: `view(v, u)[y, x] = texture(x + du·d, y + dv·d)`.
pub fn plane(grid: ViewGrid, size: [u32; 2], disparity_px: f32) -> (LightField, Arc<RayDepths>) {
    scene(grid, size, |x, y, du, dv| (texture(x + du * disparity_px, y + dv * disparity_px), disparity_px))
}

/// A near square of texture before a far plane.
pub fn two_planes(grid: ViewGrid, size: [u32; 2]) -> (LightField, Arc<RayDepths>) {
    let (near, far) = (0.9, -0.4);
    scene(grid, size, move |x, y, du, dv| {
        let (nx, ny) = (x + du * near, y + dv * near);
        let inside = |p: f32, n: u32| p > n as f32 * 0.3 && p < n as f32 * 0.7;
        if inside(nx, size[0]) && inside(ny, size[1]) {
            (texture(nx * 1.7 + 40.0, ny * 1.3), near)
        } else {
            (texture(x + du * far, y + dv * far), far)
        }
    })
}

/// A light field from the colour and disparity of each ray `(x, y, du, dv)`.
pub fn scene(
    grid: ViewGrid,
    size: [u32; 2],
    ray: impl Fn(f32, f32, f32, f32) -> ([u8; 4], f32),
) -> (LightField, Arc<RayDepths>) {
    let mut views = Vec::new();
    let mut depths = Vec::new();
    for at in grid.views() {
        let step = grid.offset(at);
        let mut rgba = Vec::new();
        for y in 0..size[1] {
            for x in 0..size[0] {
                let (color, disparity) = ray(x as f32, y as f32, step.du, step.dv);
                rgba.extend(color);
                depths.push(disparity);
            }
        }
        views.push(Arc::new(View::new(size, rgba).unwrap()));
    }
    (LightField::new(grid, views).unwrap(), Arc::new(RayDepths::new(grid, size, depths).unwrap()))
}
