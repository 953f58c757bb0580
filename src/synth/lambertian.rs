//! Lambertian rendering (paper, §3.2): `L_r(x, u) = L(x + u·D(x, u), 0)`, every surface the same from all sides.

use glam::Vec4;

use super::picture::Signed;
use crate::field::color::u8_from_signed;
use crate::field::{FieldError, View, ViewOffset};

/// One row of one view, as the nets see it: −1 … 1, (r, g, b, 0) a pixel.
///
/// `disparity_px` is that row of the view's own ray depths, from the pixel `first` on. `put(i, colour)` takes the
/// pixels in order.
pub fn render_row(
    photo: &Signed,
    disparity_px: &[f32],
    first: [usize; 2],
    from: ViewOffset,
    mut put: impl FnMut(usize, Vec4),
) {
    for (i, d) in disparity_px.iter().enumerate() {
        put(i, photo.tap((first[0] + i) as f32 + from.du * d, first[1] as f32 + from.dv * d));
    }
}

/// The occlusion net's input for such a row: red, green, blue and disparity, each `step` values after the other.
pub fn fill_row(
    photo: &Signed,
    disparity_px: &[f32],
    first: [usize; 2],
    from: ViewOffset,
    rows: &mut [f32],
    step: usize,
) {
    let (red, rest) = rows.split_at_mut(step);
    let (green, rest) = rest.split_at_mut(step);
    let (blue, disparity) = rest.split_at_mut(step);
    disparity[..disparity_px.len()].copy_from_slice(disparity_px);
    render_row(photo, disparity_px, first, from, |i, colour| {
        (red[i], green[i], blue[i]) = (colour.x, colour.y, colour.z);
    });
}

/// One whole view from its ray depths.
///
/// # Shapes
/// - `disparity_px`: `[y, x]` of the photo's size
pub fn render_view(photo: &Signed, disparity_px: &[f32], from: ViewOffset) -> Result<View, FieldError> {
    let [w, h] = photo.sides();
    let mut rgba = vec![255; w * h * 4];
    for (y, (row, depths)) in rgba.chunks_exact_mut(w * 4).zip(disparity_px.chunks_exact(w)).enumerate() {
        render_row(photo, depths, [0, y], from, |x, colour| row[x * 4..x * 4 + 3].copy_from_slice(&encode(colour)));
    }
    View::new(photo.size(), rgba)
}

/// 8-bit colour of a net's colour.
pub(super) fn encode(colour: Vec4) -> [u8; 3] {
    [u8_from_signed(colour.x), u8_from_signed(colour.y), u8_from_signed(colour.z)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp(size: [u32; 2]) -> View {
        let pixel = |i: u32| [(i % size[0] * 5) as u8, (i / size[0] * 7) as u8, 40, 255];
        View::new(size, (0..size[0] * size[1]).flat_map(pixel).collect()).unwrap()
    }

    #[test]
    fn the_sign_and_the_axes_are_those_of_the_convention() {
        let photo = ramp([40, 30]);
        let signed = Signed::from_view(&photo);
        let view = render_view(&signed, &[1.5; 1200], ViewOffset { dv: -2.0, du: 4.0 }).unwrap();
        // view[y, x] = photo[y − 2·1.5, x + 4·1.5]
        assert_eq!(view.pixel(10, 20), photo.pixel(16, 17));
    }

    #[test]
    fn the_reference_view_is_untouched() {
        let photo = ramp([40, 30]);
        let view = render_view(&Signed::from_view(&photo), &[3.3; 1200], ViewOffset::default()).unwrap();
        assert_eq!(view, photo);
    }
}
