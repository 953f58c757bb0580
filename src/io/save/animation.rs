//! Short animations: GIF, APNG, WebP and films, frame by frame, so that one frame is held at a time.

use std::io::BufWriter;
use std::path::Path;

use super::{SaveError, atomic, video, webp_animation};
use crate::field::Picture;

/// How an animation is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AnimationOptions {
    /// Frames a second, 1 … 50.
    pub frames_per_second: u16,
    /// Frames in all; never 0.
    pub frames: u32,
}

/// Writes pictures in linear sRGB as an endless animation: `.gif`, `.webp` (without loss), `.png` and `.apng`, or
/// as a film that ends: `.mp4` and `.webm`.
/// What goes wrong in making a frame is handed on.
pub fn animation<E: From<SaveError>>(
    path: &Path,
    frames: impl Iterator<Item = Result<Picture, E>>,
    options: &AnimationOptions,
) -> Result<(), E> {
    if video::is_video(path) {
        return video::video(path, frames, options.frames_per_second);
    }
    let ending = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    let write = match ending.as_str() {
        "gif" => gif,
        "png" | "apng" => apng,
        "webp" => webp,
        _ => return Err(SaveError::Animation(path.to_owned()).into()),
    };
    let mut broken = None;
    let mut good = frames.map_while(|frame| frame.map_err(|error| broken = Some(error)).ok()).peekable();
    let size = good.peek().map(|first| first.size);
    let written = match size {
        None => Err(SaveError::Cancelled),
        Some(size) => atomic(path, |file| {
            write(&mut BufWriter::new(file), size, &mut good, options)?;
            // A file with fewer frames than it says would be broken.
            if good.next().is_some() { Err(odd("there are more frames than were announced")) } else { Ok(()) }
        }),
    };
    match broken {
        Some(error) => Err(error),
        None => Ok(written?),
    }
}

type Frames<'a> = dyn Iterator<Item = Picture> + 'a;
type Out<'a> = BufWriter<&'a mut std::fs::File>;

fn odd(why: impl ToString) -> SaveError {
    SaveError::Encode { why: why.to_string(), path: Path::new("").to_owned() }
}

fn gif(out: &mut Out, size: [u32; 2], frames: &mut Frames, options: &AnimationOptions) -> Result<(), SaveError> {
    let error = |e: gif::EncodingError| match e {
        gif::EncodingError::Io(e) => SaveError::from_io(&e, Path::new("")),
        other => odd(other),
    };
    if size.into_iter().any(|side| side > u32::from(u16::MAX)) {
        return Err(odd("a GIF is at most 65535 pixels wide and high; choose a smaller size"));
    }
    let [width, height] = size.map(|s| s as u16);
    let mut encoder = gif::Encoder::new(out, width, height, &[]).map_err(error)?;
    encoder.set_repeat(gif::Repeat::Infinite).map_err(error)?;
    for _ in 0..options.frames {
        let picture = frames.next().ok_or(SaveError::Cancelled)?;
        let mut frame = gif::Frame::from_rgba_speed(width, height, &mut picture.to_srgb8(), 10);
        frame.delay = 100 / options.frames_per_second.clamp(1, 50);
        encoder.write_frame(&frame).map_err(error)?;
    }
    Ok(())
}

fn apng(out: &mut Out, size: [u32; 2], frames: &mut Frames, options: &AnimationOptions) -> Result<(), SaveError> {
    let error = |e: png::EncodingError| match e {
        png::EncodingError::IoError(e) => SaveError::from_io(&e, Path::new("")),
        other => odd(other),
    };
    let mut encoder = png::Encoder::new(out, size[0], size[1]);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Fast);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    encoder.set_animated(options.frames, 0).map_err(error)?;
    encoder.set_frame_delay(1, options.frames_per_second.clamp(1, 50)).map_err(error)?;
    let mut writer = encoder.write_header().map_err(error)?;
    for _ in 0..options.frames {
        let picture = frames.next().ok_or(SaveError::Cancelled)?;
        let rgb: Vec<u8> = picture.to_srgb8().chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect();
        writer.write_image_data(&rgb).map_err(error)?;
    }
    writer.finish().map_err(error)
}

fn webp(out: &mut Out, size: [u32; 2], frames: &mut Frames, options: &AnimationOptions) -> Result<(), SaveError> {
    let frame_ms = 1000 / u32::from(options.frames_per_second.clamp(1, 50));
    let all = (0..options.frames).map(|_| frames.next().ok_or(SaveError::Cancelled));
    webp_animation::write(out, size, all, frame_ms)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(light: f32) -> Result<Picture, SaveError> {
        Ok(Picture { size: [6, 4], rgb_linear: vec![light; 72] })
    }

    const OPTIONS: AnimationOptions = AnimationOptions { frames_per_second: 20, frames: 3 };

    #[test]
    fn all_frames_are_in_the_file() {
        let dir = tempfile::tempdir().unwrap();
        for name in ["a.gif", "a.apng", "a.png", "a.webp"] {
            let path = dir.path().join(name);
            animation(&path, [0.1, 0.5, 0.9].into_iter().map(frame), &OPTIONS).unwrap();
            let file = std::fs::File::open(&path).unwrap();
            if name == "a.gif" {
                let mut decoder = gif::DecodeOptions::new().read_info(file).unwrap();
                let mut count = 0;
                while decoder.read_next_frame().unwrap().is_some() {
                    count += 1;
                }
                assert_eq!(count, 3);
            } else if name == "a.webp" {
                let mut decoder = image_webp::WebPDecoder::new(std::io::BufReader::new(file)).unwrap();
                assert!(decoder.is_animated());
                assert_eq!((decoder.dimensions(), decoder.num_frames()), ((6, 4), 3));
                let mut pixels = vec![0; decoder.output_buffer_size().unwrap()];
                for light in [0.1, 0.5, 0.9] {
                    assert_eq!(decoder.read_frame(&mut pixels).unwrap(), 50);
                    assert!(pixels.iter().all(|&v| v == crate::field::color::srgb8_from_linear(light)));
                }
            } else {
                let reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().unwrap();
                assert_eq!(reader.info().animation_control().unwrap().num_frames, 3);
            }
        }
    }

    #[test]
    fn a_frame_that_fails_leaves_no_file_and_its_error_is_told() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.gif");
        let frames = [frame(0.1), Err(SaveError::DiskFull("x".into())), frame(0.2)];
        assert!(matches!(animation(&path, frames.into_iter(), &OPTIONS), Err(SaveError::DiskFull(_))));
        assert!(!path.exists());
        let other = animation(&dir.path().join("a.mov"), std::iter::once(frame(0.1)), &OPTIONS);
        assert!(matches!(other, Err(SaveError::Animation(_))));
    }
}
