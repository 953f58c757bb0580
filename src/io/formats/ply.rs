//! PLY: the reference view as a cloud of coloured points, binary little-endian.

use std::io::Write;
use std::path::Path;

use super::out::{self, FieldToWrite};
use crate::io::save::SaveError;

/// Focal length over the longer side, where the photo does not say it: a phone's main camera.
const FOCAL: f32 = 0.75;

/// Writes one point for each pixel: x right, y down, z away from the camera, in units of the nearest point's distance.
/// Disparity knows no distance of its own: the farthest point is put four times as far as the nearest.
///
/// # Errors
/// [`SaveError`]; then nothing has been written.
pub fn write(path: &Path, source: &FieldToWrite) -> Result<(), SaveError> {
    let depths = source.need_depths(path)?;
    let map = depths.reference();
    let [far, near] = map.iter().fold([f32::INFINITY, f32::NEG_INFINITY], |[lo, hi], &d| [lo.min(d), hi.max(d)]);
    let view = source.field.reference();
    let [w, h] = depths.size();
    let focal = FOCAL * w.max(h) as f32;
    let share = |d: f32| if near > far { (d - far) / (near - far) } else { 1.0 };
    out::single(path, |out| {
        write!(
            out,
            "ply\nformat binary_little_endian 1.0\ncomment made by Plenoscope\nelement vertex {}\n",
            map.len()
        )?;
        write!(out, "property float x\nproperty float y\nproperty float z\n")?;
        write!(out, "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n")?;
        for (n, &d) in map.iter().enumerate() {
            let (x, y) = (n as u32 % w, n as u32 / w);
            let z = 1.0 / (0.25 + 0.75 * share(d));
            let at = [(x as f32 - (w - 1) as f32 / 2.0) * z / focal, (y as f32 - (h - 1) as f32 / 2.0) * z / focal, z];
            at.iter().try_for_each(|value| out.write_all(&value.to_le_bytes()))?;
            let [vw, vh] = view.size();
            out.write_all(&view.pixel(x * vw / w, y * vh / h)[..3])?;
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::field::{LightField, RayDepths, View, ViewGrid};

    #[test]
    fn near_points_have_the_smaller_z() {
        let view = Arc::new(View::new([2, 1], vec![255, 0, 0, 255, 0, 0, 255, 255]).unwrap());
        let field = LightField::new(ViewGrid::new(1, 1).unwrap(), vec![view]).unwrap();
        let depths = RayDepths::new(field.grid(), [2, 1], vec![1.0, -1.0]).unwrap();
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("cloud.ply");
        write(&path, &FieldToWrite { depths: Some(&depths), ..FieldToWrite::new(&field) }).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let points = &bytes[bytes.windows(11).position(|w| w == b"end_header\n").unwrap() + 11..];
        let z = |n: usize| f32::from_le_bytes(points[n * 15 + 8..n * 15 + 12].try_into().unwrap());
        assert_eq!((points.len(), z(0), z(1)), (30, 1.0, 4.0));
        assert_eq!(points[12..15], [255, 0, 0]);
        assert!(write(&path, &FieldToWrite::new(&field)).is_err());
    }
}
