//! The eight EXIF orientations.

use rayon::prelude::*;

/// Tiles of this side keep both rows and columns in cache when a picture is turned.
const TILE: usize = 32;

/// Turns a picture upright: its new size and pixels. Orientation 1 costs nothing.
pub(crate) fn orient<T: Copy + Default + Send + Sync>(
    pixels: Vec<T>,
    size: [u32; 2],
    orientation: u8,
) -> ([u32; 2], Vec<T>) {
    if orientation <= 1 || orientation > 8 {
        return (size, pixels);
    }
    let upright = if orientation >= 5 { [size[1], size[0]] } else { size };
    let (width, source_width) = (upright[0] as usize, size[0] as usize);
    let mut out = vec![T::default(); pixels.len()];
    out.par_chunks_mut(width * TILE).enumerate().for_each(|(band, rows)| {
        for left in (0..width).step_by(TILE) {
            for (row, line) in rows.chunks_mut(width).enumerate() {
                let y = band * TILE + row;
                for (x, px) in line.iter_mut().enumerate().skip(left).take(TILE) {
                    let [sx, sy] = source_from_upright(x, y, size, orientation);
                    *px = pixels[sy * source_width + sx];
                }
            }
        }
    });
    (upright, out)
}

/// The stored pixel that an upright pixel comes from (EXIF 2.32, tag 0x0112).
fn source_from_upright(x: usize, y: usize, stored: [u32; 2], orientation: u8) -> [usize; 2] {
    let (right, bottom) = (stored[0] as usize - 1, stored[1] as usize - 1);
    match orientation {
        2 => [right - x, y],
        3 => [right - x, bottom - y],
        4 => [x, bottom - y],
        5 => [y, x],
        6 => [y, bottom - x],
        7 => [right - y, bottom - x],
        8 => [right - y, x],
        _ => [x, y],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What tag 0x0112 says: where row 0 and column 0 of the stored picture are seen.
    #[test]
    fn stored_corner_lands_where_exif_says() {
        // Stored 3×2: a at (0, 0), b at the end of row 0, c at the end of column 0.
        let stored = vec!['a', '.', 'b', 'c', '.', '.'];
        let seen = |orientation| {
            let (size, px) = orient(stored.clone(), [3, 2], orientation);
            (size, px.chunks(size[0] as usize).map(|row| row.iter().collect::<String>()).collect::<Vec<_>>().join("/"))
        };
        assert_eq!(seen(1), ([3, 2], "a.b/c..".to_owned()));
        assert_eq!(seen(2), ([3, 2], "b.a/..c".to_owned()));
        assert_eq!(seen(3), ([3, 2], "..c/b.a".to_owned()));
        assert_eq!(seen(4), ([3, 2], "c../a.b".to_owned()));
        assert_eq!(seen(5), ([2, 3], "ac/../b.".to_owned()));
        assert_eq!(seen(6), ([2, 3], "ca/../.b".to_owned()));
        assert_eq!(seen(7), ([2, 3], ".b/../ca".to_owned()));
        assert_eq!(seen(8), ([2, 3], "b./../ac".to_owned()));
    }
}
