//! Width and height.

/// Width and height of a picture, in pixels.
pub type Size = [u32; 2];

/// Width and height to count with in memory.
#[inline]
pub fn sides(size: Size) -> [usize; 2] {
    [size[0] as usize, size[1] as usize]
}

/// The same back. Pictures are made by [`Size`], so nothing is cut off.
#[inline]
pub fn size_from(sides: [usize; 2]) -> Size {
    [sides[0] as u32, sides[1] as u32]
}

/// Pixels of a picture.
#[inline]
pub fn pixels(size: Size) -> usize {
    size[0] as usize * size[1] as usize
}

/// The size with the same shape whose longer side is at most `long_side`; never larger than `size`, never 0.
pub fn fit_long_side(size: Size, long_side: u32) -> Size {
    let long = size[0].max(size[1]);
    if long <= long_side {
        return size;
    }
    size.map(|side| {
        let scaled = f64::from(side) * f64::from(long_side) / f64::from(long);
        (scaled.round() as u32).max(1)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shape_is_kept_and_nothing_is_enlarged() {
        assert_eq!(fit_long_side([4032, 3024], 540), [540, 405]);
        assert_eq!(fit_long_side([300, 200], 540), [300, 200]);
        assert_eq!(fit_long_side([30_000, 1], 540), [540, 1]);
    }
}
