//! A picture as the opening of a lens, from a file.

use std::path::Path;

use super::open::read_file;
use super::raster;
use super::{OpenError, Problem};
use crate::field::Opening;

/// The most pixels of a side; what is kept of it has a few dozen.
const MOST_SIDE: u32 = 4096;

/// Reads a picture as the opening of a lens: white is open, black is closed, and what is transparent is closed too.
///
/// # Errors
/// [`OpenError`], if it is no picture, too large, or black everywhere.
pub fn read(path: &Path) -> Result<Opening, OpenError> {
    read_file(path).and_then(|bytes| parse(&bytes)).map_err(OpenError::at(Some(path)))
}

fn parse(bytes: &[u8]) -> Result<Opening, Problem> {
    let [width, height] = raster::header_size(bytes)?;
    if width.max(height) > MOST_SIDE {
        return Err(Problem::Opening(format!("it has {width}×{height} pixels, where {MOST_SIDE} a side are the most")));
    }
    let (size, pixels) = raster::decode_rgba8(bytes)?;
    // As stored, and not as light: who paints grey means half.
    let light = |[r, g, b, a]: [u8; 4]| {
        (0.2126 * f32::from(r) + 0.7152 * f32::from(g) + 0.0722 * f32::from(b)) * f32::from(a) / (255.0 * 255.0)
    };
    let light: Vec<f32> = pixels.into_iter().map(light).collect();
    Opening::of_picture(size, &light).ok_or_else(|| Problem::Opening("it is black everywhere".to_owned()))
}

#[cfg(test)]
mod tests {
    use image::{DynamicImage, ImageFormat, Rgba, RgbaImage};

    use super::*;

    fn read_back(picture: RgbaImage) -> Result<Opening, String> {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("opening.png");
        DynamicImage::from(picture).save_with_format(&path, ImageFormat::Png).unwrap();
        read(&path).map_err(|error| error.to_string())
    }

    #[test]
    fn white_is_open_and_black_and_transparent_are_closed() {
        let is_open = |x: u32, y: u32| (10..50).contains(&x) && (10..50).contains(&y);
        let of = |closed: Rgba<u8>| {
            let picture = RgbaImage::from_fn(60, 70, |x, y| if is_open(x, y) { Rgba([255; 4]) } else { closed });
            read_back(picture).unwrap()
        };
        let opening = of(Rgba([0, 0, 0, 255]));
        assert_eq!(opening, of(Rgba([255, 255, 255, 0])));
        assert!(opening.at([0.5, -0.5]) == 1.0 && opening.at([0.0, 0.9]) == 0.0);
    }

    #[test]
    fn what_cannot_be_one_is_one_sentence() {
        let black = read_back(RgbaImage::from_pixel(30, 20, Rgba([0, 0, 0, 255]))).unwrap_err();
        let wide = read_back(RgbaImage::from_pixel(20_000, 2, Rgba([255; 4]))).unwrap_err();
        let dir = tempfile::tempdir().unwrap();
        let text = dir.path().join("text.png");
        std::fs::write(&text, "not a picture").unwrap();
        let none = read(&text).unwrap_err().to_string();
        for (said, why) in [(black, "black everywhere"), (wide, "20000×2"), (none, "no picture")] {
            assert!(said.contains(why) && said.matches(" — ").count() == 2 && !said.contains('\n'), "{why}: {said}");
        }
    }
}
