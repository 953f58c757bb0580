//! Films whose pictures are JPEGs of their own: motion-JPEG in AVI (RIFF; Microsoft 1992, OpenDML 1996).
//!
//! A film is a list of chunks: four letters, a length, that many bytes, and one more where the length is odd. `RIFF` and `LIST`
//! hold chunks themselves. Pictures are the chunks `..dc` and `..db` of the first stream that has JPEGs.

use super::file_type::FileType;
use super::raster;
use super::{PhotoFile, Problem};

const NAME: &str = "AVI";
/// What people read.
const FORMAT: &str = "motion-JPEG film (AVI)";
/// What a chunk's head takes, and the letters behind it where it holds others.
const HEAD: usize = 8;
const LETTERS: usize = 4;
/// Lists within lists that are followed.
const DEEPEST: usize = 8;

/// How such a file is told; as a photo it is its first picture.
pub(crate) const TYPE: FileType =
    FileType { name: NAME, suffixes: &["avi"], begins, photo: Some(|bytes, _job| first(bytes)), ..FileType::UNKNOWN };

fn begins(bytes: &[u8]) -> bool {
    bytes.starts_with(b"RIFF") && bytes.get(HEAD..HEAD + LETTERS) == Some(b"AVI ")
}

fn first(bytes: &[u8]) -> Result<PhotoFile, Problem> {
    let found = Found::of(bytes);
    let Some(first) = found.pictures.first() else {
        return Err(Problem::Unsupported {
            format: NAME,
            reason: "its pictures are no JPEGs".to_owned(),
            advice: "save it as motion-JPEG, or its frames as pictures",
        });
    };
    let mut file = photo(first)?;
    file.info.notes.push(("pictures".to_owned(), found.pictures.len().to_string()));
    if found.is_cut {
        file.warn("the film is cut off — what lies before its end is used".to_owned());
    }
    Ok(file)
}

/// One picture of a film as a photo.
///
/// # Errors
/// It is damaged.
pub(crate) fn photo(jpeg: &[u8]) -> Result<PhotoFile, Problem> {
    PhotoFile::from_raster(raster::decode(jpeg)?, FORMAT)
}

/// The JPEGs of a film, in order; none of other files. What a damaged end holds is missing.
pub(crate) fn pictures(bytes: &[u8]) -> Vec<&[u8]> {
    Found::of(bytes).pictures
}

#[derive(Default)]
struct Found<'a> {
    /// The stream's two digits.
    stream: Option<[u8; 2]>,
    pictures: Vec<&'a [u8]>,
    /// Whether a chunk is longer than what is left of the file.
    is_cut: bool,
}

impl<'a> Found<'a> {
    fn of(bytes: &'a [u8]) -> Self {
        let mut found = Self::default();
        if begins(bytes) {
            found.walk(bytes, 0);
        }
        found
    }

    fn walk(&mut self, mut bytes: &'a [u8], depth: usize) {
        while let Some((head, rest)) = bytes.split_at_checked(HEAD) {
            let length = u32::from_le_bytes([head[4], head[5], head[6], head[7]]) as usize;
            // A film that was cut off still has what lies before.
            self.is_cut |= length > rest.len();
            let data = &rest[..length.min(rest.len())];
            match &head[..LETTERS] {
                b"RIFF" | b"LIST" if depth < DEEPEST => self.walk(data.get(LETTERS..).unwrap_or_default(), depth + 1),
                [a, b, b'd', b'c' | b'b'] => self.add([*a, *b], data),
                _ => {}
            }
            bytes = rest.get(length.saturating_add(length % 2)..).unwrap_or_default();
        }
    }

    fn add(&mut self, stream: [u8; 2], data: &'a [u8]) {
        let is_jpeg = data.starts_with(&[0xff, 0xd8]);
        if is_jpeg && *self.stream.get_or_insert(stream) == stream {
            self.pictures.push(data);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::several;
    use crate::job::{Cancel, Job};

    fn chunk(name: &[u8], data: &[u8]) -> Vec<u8> {
        let mut bytes = [name, &(data.len() as u32).to_le_bytes(), data].concat();
        bytes.resize(bytes.len() + data.len() % 2, 0);
        bytes
    }

    fn jpeg(light: u8) -> Vec<u8> {
        let mut bytes = Vec::new();
        let encoder = jpeg_encoder::Encoder::new(&mut bytes, 90);
        encoder.encode(&[light; 24 * 16], 24, 16, jpeg_encoder::ColorType::Luma).unwrap();
        bytes
    }

    fn film(pictures: &[Vec<u8>]) -> Vec<u8> {
        let sound = chunk(b"01wb", &[7; 33]);
        let all: Vec<u8> = pictures.iter().flat_map(|data| [chunk(b"00dc", data), sound.clone()].concat()).collect();
        let records = chunk(b"LIST", &[b"rec ", &all[..]].concat());
        let header = chunk(b"LIST", &[b"hdrl", &chunk(b"avih", &[0; 56])[..]].concat());
        let movie = chunk(b"LIST", &[b"movi", &records[..]].concat());
        chunk(b"RIFF", &[b"AVI ", &header[..], &movie, &chunk(b"idx1", &[0; 16])].concat())
    }

    #[test]
    fn every_picture_of_a_film_is_a_photo_also_where_its_end_is_missing() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.avi");
        // A picture that was dropped has no bytes.
        let bytes = film(&[jpeg(40), Vec::new(), jpeg(120), jpeg(200)]);
        let job = Job { cancel: &Cancel::default(), sink: &() };
        let lights = |bytes: &[u8]| -> Vec<u8> {
            std::fs::write(&path, bytes).unwrap();
            let photos = several::photos(&path, &job).unwrap();
            photos.iter().map(|file| file.photo.srgb8()[0].div_ceil(10) * 10).collect()
        };
        assert_eq!(lights(&bytes), [40, 120, 200]);
        let third = bytes.windows(4).rposition(|four| four == b"00dc").unwrap();
        assert_eq!(lights(&bytes[..third]), [40, 120]);
        let other = film(&[b"H264".to_vec()]);
        assert!(matches!(first(&other), Err(Problem::Unsupported { .. })));
    }
}
