//! Films: AV1 by rav1e, which is Rust throughout, in MP4 or WebM by the writers here. 4:2:0, 8 bits, BT.709.
//!
//! Packets are kept until the last frame is there, since both boxes begin with a table of them; they are some hundredths of
//! the frames they came from.

mod mp4;
mod webm;
mod yuv;

use std::io::Write;
use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, sync_channel};

use rav1e::config::SpeedSettings;
use rav1e::prelude::*;

use super::{SaveError, atomic};
use crate::field::Picture;

/// Least width and height that the encoder takes.
const LEAST_PX: u32 = 16;
/// Where the encoder's quality stands, 0 (best) … 255.
const QUANTIZER: usize = 80;
/// The fastest of rav1e's speeds.
const SPEED: u8 = 10;
/// Frames between two that can be jumped to.
const KEY_EVERY: u64 = 60;

/// A film on its way into a file.
struct Film {
    size: [u32; 2],
    frames_per_second: u32,
    /// The `av1C` record: profile, level, and the sequence header.
    codec: Vec<u8>,
    frames: Vec<Packed>,
}

/// One frame, packed.
struct Packed {
    data: Vec<u8>,
    is_key: bool,
}

impl Film {
    /// How long it takes, in milliseconds.
    fn duration_ms(&self) -> f64 {
        self.frames.len() as f64 * 1000.0 / f64::from(self.frames_per_second)
    }
}

/// Whether a name says that it is a film.
pub(super) fn is_video(path: &Path) -> bool {
    writer(path).is_some()
}

type Writer = fn(&mut dyn Write, &Film) -> std::io::Result<()>;

fn writer(path: &Path) -> Option<Writer> {
    match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
        "mp4" => Some(mp4::write),
        "webm" => Some(webm::write),
        _ => None,
    }
}

/// Writes pictures in linear sRGB as a film: `.mp4` or `.webm`. An odd row or column at the right or lower edge is left
/// out. What goes wrong in making a frame is handed on, and then there is no file.
///
/// # Errors
/// A frame's own, and [`SaveError`].
pub(super) fn video<E: From<SaveError>>(
    path: &Path,
    frames: impl Iterator<Item = Result<Picture, E>>,
    frames_per_second: u16,
) -> Result<(), E> {
    let write = writer(path).ok_or_else(|| SaveError::Animation(path.to_owned()))?;
    let rate = u32::from(frames_per_second.max(1));
    let film = coded(frames, rate, path)?;
    Ok(atomic(path, |file| {
        let mut out = std::io::BufWriter::with_capacity(1 << 18, file);
        write(&mut out, &film).and_then(|()| out.flush()).map_err(|error| SaveError::from_io(&error, path))
    })?)
}

/// Makes frames here and packs them on a thread of its own, so that neither waits for the other's slowest row.
fn coded<E: From<SaveError>>(
    frames: impl Iterator<Item = Result<Picture, E>>,
    rate: u32,
    path: &Path,
) -> Result<Film, E> {
    let (give, take) = sync_channel(1);
    std::thread::scope(move |scope| {
        let name = std::thread::Builder::new().name("film".to_owned());
        let coder =
            name.spawn_scoped(scope, move || packed(&take, rate)).map_err(|error| odd(path, error.to_string()))?;
        for frame in frames {
            // Where the coder has ended already, it says why.
            if give.send(Some(frame?)).is_err() {
                break;
            }
        }
        let _ = give.send(None);
        let film = coder.join().unwrap_or_else(|_| Err("the encoder failed".to_owned()));
        Ok(film.map_err(|why| odd(path, why))?.ok_or(SaveError::Cancelled)?)
    })
}

/// Packs what comes until it is said to be the end. None where there was no frame, or no end: then nobody wants the film.
fn packed(frames: &Receiver<Option<Picture>>, rate: u32) -> Result<Option<Film>, String> {
    let mut coder: Option<Coder> = None;
    while let Ok(frame) = frames.recv() {
        let Some(frame) = frame else { return coder.map(Coder::finish).transpose() };
        let coder = match &mut coder {
            Some(coder) => coder,
            none => none.insert(Coder::new(frame.size, rate)?),
        };
        coder.push(&frame)?;
    }
    Ok(None)
}

fn odd(path: &Path, why: String) -> SaveError {
    SaveError::Encode { why, path: path.to_owned() }
}

/// The encoder, and what came out of it.
struct Coder {
    context: Context<u8>,
    given: [u32; 2],
    film: Film,
}

impl Coder {
    fn new(given: [u32; 2], rate: u32) -> Result<Self, String> {
        let size = given.map(|side| side & !1);
        if size.into_iter().any(|side| side < LEAST_PX) {
            return Err(format!("a film is at least {LEAST_PX} pixels wide and high; choose a larger size"));
        }
        let mut encoder = EncoderConfig {
            width: size[0] as usize,
            height: size[1] as usize,
            time_base: Rational::new(1, u64::from(rate)),
            chroma_sampling: ChromaSampling::Cs420,
            pixel_range: PixelRange::Limited,
            color_description: Some(ColorDescription {
                color_primaries: ColorPrimaries::BT709,
                transfer_characteristics: TransferCharacteristics::SRGB,
                matrix_coefficients: MatrixCoefficients::BT709,
            }),
            quantizer: QUANTIZER,
            speed_settings: speed(),
            // What eyes forgive takes longer to find out than to encode.
            tune: Tune::Psnr,
            // Frames that wait for later ones take twice the time, and make the film 8 % smaller.
            low_latency: true,
            tiles: rayon::current_num_threads().next_power_of_two().min(16),
            ..EncoderConfig::default()
        };
        encoder.set_key_frame_interval(1, KEY_EVERY);
        let config = Config::new().with_encoder_config(encoder).with_threads(rayon::current_num_threads());
        let context: Context<u8> = config.new_context().map_err(|error| error.to_string())?;
        let codec = context.container_sequence_header();
        Ok(Self { context, given, film: Film { size, frames_per_second: rate, codec, frames: Vec::new() } })
    }

    fn push(&mut self, picture: &Picture) -> Result<(), String> {
        if picture.size != self.given {
            return Err("the frames are of several sizes".to_owned());
        }
        let mut frame = self.context.new_frame();
        for (plane, samples) in frame.planes.iter_mut().zip(yuv::planes(picture, self.film.size)) {
            let stride = samples.width;
            plane.copy_from_raw_u8(&samples.values, stride, 1);
        }
        self.context.send_frame(Arc::new(frame)).map_err(|error| error.to_string())?;
        self.take()
    }

    /// Takes what is packed; all of it after a flush.
    fn take(&mut self) -> Result<(), String> {
        loop {
            match self.context.receive_packet() {
                Ok(packet) => {
                    let is_key = packet.frame_type == FrameType::KEY;
                    let data = without_delimiter(packet.data);
                    if self.film.frames.is_empty() {
                        self.film.codec.extend(sequence_header(&data).ok_or("the encoder gave no sequence header")?);
                    }
                    self.film.frames.push(Packed { data, is_key });
                }
                Err(EncoderStatus::Encoded) => {}
                Err(EncoderStatus::NeedMoreData | EncoderStatus::LimitReached) => return Ok(()),
                Err(error) => return Err(error.to_string()),
            }
        }
    }

    fn finish(mut self) -> Result<Film, String> {
        self.context.flush();
        self.take()?;
        Ok(self.film)
    }
}

/// The fastest preset without the filter that directs: it takes a fifth of the time, and 0.1 dB is all it gives.
fn speed() -> SpeedSettings {
    let mut speed = SpeedSettings::from_preset(SPEED);
    speed.cdef = false;
    speed
}

/// A packet without the delimiter that boxes have no use for (AV1 in ISOBMFF, §2.4).
fn without_delimiter(data: Vec<u8>) -> Vec<u8> {
    match data.strip_prefix(&[0x12, 0x00]) {
        Some(rest) => rest.to_vec(),
        None => data,
    }
}

/// The sequence header at the front of the first packet: its head, its length in seven bits a byte, and so many bytes.
fn sequence_header(data: &[u8]) -> Option<&[u8]> {
    const HEAD: u8 = 1 << 3 | 1 << 1;
    let (head, rest) = data.split_first()?;
    let digits = rest.iter().position(|byte| byte & 0x80 == 0)? + 1;
    let len = rest[..digits].iter().rev().fold(0usize, |len, byte| len << 7 | usize::from(byte & 0x7f));
    (*head == HEAD && digits < 5).then(|| data.get(..1 + digits + len)).flatten()
}

#[cfg(test)]
mod tests;
