//! Changes to an EXIF block in place, so that maker notes and other offsets stay valid.
//!
//! The block is a TIFF structure (EXIF 2.32, §4.5): orientation becomes 1, the size that of the picture, the old
//! thumbnail goes and a new one comes, the position (GPS) goes where that is asked for.

use std::ops::Range;

const ORIENTATION: u16 = 0x0112;
const EXIF_IFD: u16 = 0x8769;
const GPS_IFD: u16 = 0x8825;
const PIXEL_X: u16 = 0xA002;
const PIXEL_Y: u16 = 0xA003;
const COMPRESSION: u16 = 0x0103;
const THUMBNAIL_AT: u16 = 0x0201;
const THUMBNAIL_LEN: u16 = 0x0202;
const SHORT: u16 = 3;
const LONG: u16 = 4;

/// What is to be changed.
pub struct Edit<'a> {
    /// Width and height of the picture that the block will describe.
    pub size: [u32; 2],
    /// Whether the position is taken out.
    pub strip_gps: bool,
    /// A new thumbnail, a JPEG; none leaves the block without one.
    pub thumbnail: Option<&'a [u8]>,
}

/// The block after the edit; none if it cannot be read, as then nothing in it can be trusted.
pub fn edited(exif: &[u8], edit: &Edit) -> Option<Vec<u8>> {
    let mut block = Block::parse(exif)?;
    let first = block.u32(4)? as usize;
    block.drop_thumbnail(first);
    block.set_orientation(first);
    if let Some(entry) = block.find(first, EXIF_IFD) {
        let ifd = block.u32(entry + 8)? as usize;
        block.set_long(ifd, PIXEL_X, edit.size[0]);
        block.set_long(ifd, PIXEL_Y, edit.size[1]);
    }
    if edit.strip_gps {
        block.remove_gps(first);
    }
    if let Some(jpeg) = edit.thumbnail {
        block.add_thumbnail(first, jpeg);
    }
    Some(block.bytes)
}

/// One entry of a directory, its value's bytes in native order of the machine.
pub struct Field {
    /// Tag number.
    pub tag: u16,
    /// TIFF type, 1 … 12.
    pub kind: u16,
    /// The values, in this machine's byte order.
    pub data: Vec<u8>,
}

/// Directories of a block that TIFF files keep too: the first one's texts and the EXIF one, without what holds offsets.
pub fn fields(exif: &[u8]) -> Option<[Vec<Field>; 3]> {
    const TEXTS: [u16; 7] = [0x010E, 0x010F, 0x0110, 0x0131, 0x0132, 0x013B, 0x8298];
    const MAKER_NOTE: u16 = 0x927C;
    const INTEROP: u16 = 0xA005;
    let block = Block::parse(exif)?;
    let first = block.u32(4)? as usize;
    let sub = |tag| block.find(first, tag).and_then(|e| block.u32(e + 8)).map(|ifd| block.fields(ifd as usize));
    let texts = block.fields(first).into_iter().filter(|f| TEXTS.contains(&f.tag)).collect();
    let mut own = sub(EXIF_IFD).unwrap_or_default();
    own.retain(|f| f.tag != MAKER_NOTE && f.tag != INTEROP);
    Some([texts, own, sub(GPS_IFD).unwrap_or_default()])
}

struct Block {
    bytes: Vec<u8>,
    little: bool,
}

impl Block {
    fn parse(exif: &[u8]) -> Option<Self> {
        let exif = exif.strip_prefix(b"Exif\0\0").unwrap_or(exif);
        let little = match exif.get(..4)? {
            b"II*\0" => true,
            b"MM\0*" => false,
            _ => return None,
        };
        let block = Self { bytes: exif.to_vec(), little };
        let first = block.u32(4)? as usize;
        block.entries(first).is_some().then_some(block)
    }

    fn u16(&self, at: usize) -> Option<u16> {
        let b: [u8; 2] = self.bytes.get(at..at.checked_add(2)?)?.try_into().ok()?;
        Some(if self.little { u16::from_le_bytes(b) } else { u16::from_be_bytes(b) })
    }

    fn u32(&self, at: usize) -> Option<u32> {
        let b: [u8; 4] = self.bytes.get(at..at.checked_add(4)?)?.try_into().ok()?;
        Some(if self.little { u32::from_le_bytes(b) } else { u32::from_be_bytes(b) })
    }

    fn put16(&mut self, at: usize, value: u16) {
        let b = if self.little { value.to_le_bytes() } else { value.to_be_bytes() };
        if let Some(place) = self.bytes.get_mut(at..at + 2) {
            place.copy_from_slice(&b);
        }
    }

    fn put32(&mut self, at: usize, value: u32) {
        let b = if self.little { value.to_le_bytes() } else { value.to_be_bytes() };
        if let Some(place) = self.bytes.get_mut(at..at + 4) {
            place.copy_from_slice(&b);
        }
    }

    /// Places of a directory's entries; none if it reaches out of the block.
    fn entries(&self, ifd: usize) -> Option<impl Iterator<Item = usize> + use<>> {
        let count = usize::from(self.u16(ifd)?);
        (ifd + 2 + count * 12 + 4 <= self.bytes.len()).then(|| (0..count).map(move |i| ifd + 2 + i * 12))
    }

    fn find(&self, ifd: usize, tag: u16) -> Option<usize> {
        self.entries(ifd)?.find(|&at| self.u16(at) == Some(tag))
    }

    fn next_place(&self, ifd: usize) -> Option<usize> {
        Some(ifd + 2 + usize::from(self.u16(ifd)?) * 12)
    }

    /// Where an entry's values stand: in the entry, or elsewhere when they are longer than 4 bytes.
    fn value_range(&self, entry: usize) -> Option<Range<usize>> {
        const SIZES: [usize; 13] = [0, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8];
        let size = *SIZES.get(usize::from(self.u16(entry + 2)?))?;
        let len = size.checked_mul(self.u32(entry + 4)? as usize)?;
        let at = if len <= 4 { entry + 8 } else { self.u32(entry + 8)? as usize };
        (at.checked_add(len)? <= self.bytes.len()).then(|| at..at + len)
    }

    fn fields(&self, ifd: usize) -> Vec<Field> {
        let entries = self.entries(ifd).into_iter().flatten();
        let field = |at| {
            let kind = self.u16(at + 2)?;
            let mut data = self.bytes[self.value_range(at)?].to_vec();
            if self.little != cfg!(target_endian = "little") {
                let width = match kind {
                    3 | 8 => 2,
                    4 | 5 | 9 | 10 | 11 => 4,
                    12 => 8,
                    _ => 1,
                };
                data.chunks_exact_mut(width).for_each(<[u8]>::reverse);
            }
            Some(Field { tag: self.u16(at)?, kind, data })
        };
        entries.filter_map(field).collect()
    }

    fn set_orientation(&mut self, ifd: usize) {
        if let Some(at) = self.find(ifd, ORIENTATION) {
            self.put16(at + 2, SHORT);
            self.put32(at + 4, 1);
            self.put32(at + 8, 0);
            self.put16(at + 8, 1);
        }
    }

    fn set_long(&mut self, ifd: usize, tag: u16, value: u32) {
        if let Some(at) = self.find(ifd, tag) {
            self.put16(at + 2, LONG);
            self.put32(at + 4, 1);
            self.put32(at + 8, value);
        }
    }

    /// Blackens a directory and all that its entries point to.
    fn erase_ifd(&mut self, ifd: usize) {
        let Some(entries) = self.entries(ifd) else { return };
        let ranges: Vec<_> = entries.filter_map(|at| self.value_range(at)).collect();
        ranges.into_iter().for_each(|range| self.bytes[range].fill(0));
        if let Some(end) = self.next_place(ifd) {
            self.bytes[ifd..end + 4].fill(0);
        }
    }

    fn remove_gps(&mut self, ifd: usize) {
        let Some(at) = self.find(ifd, GPS_IFD) else { return };
        if let Some(gps) = self.u32(at + 8) {
            self.erase_ifd(gps as usize);
        }
        let (Some(count), Some(end)) = (self.u16(ifd), self.next_place(ifd)) else { return };
        self.bytes.copy_within(at + 12..end + 4, at);
        self.bytes[end + 4 - 12..end + 4].fill(0);
        self.put16(ifd, count - 1);
    }

    fn drop_thumbnail(&mut self, ifd: usize) {
        let Some(next) = self.next_place(ifd) else { return };
        let Some(second) = self.u32(next).filter(|&at| at != 0) else { return };
        let second = second as usize;
        let long = |tag| self.find(second, tag).and_then(|e| self.u32(e + 8)).map(|v| v as usize);
        if let (Some(at), Some(len)) = (long(THUMBNAIL_AT), long(THUMBNAIL_LEN))
            && let Some(end) = at.checked_add(len).filter(|&end| end <= self.bytes.len() && at > 8)
        {
            self.bytes[at..end].fill(0);
            if end == self.bytes.len() && at > second {
                self.bytes.truncate(at);
            }
        }
        self.erase_ifd(second);
        self.put32(next, 0);
    }

    fn add_thumbnail(&mut self, ifd: usize, jpeg: &[u8]) {
        let Some(next) = self.next_place(ifd) else { return };
        if !self.bytes.len().is_multiple_of(2) {
            self.bytes.push(0);
        }
        let at = self.bytes.len();
        let image = at + 2 + 3 * 12 + 4;
        self.bytes.resize(image, 0);
        self.put16(at, 3);
        let entries = [(COMPRESSION, 6), (THUMBNAIL_AT, image as u32), (THUMBNAIL_LEN, jpeg.len() as u32)];
        for (i, (tag, value)) in entries.into_iter().enumerate() {
            let entry = at + 2 + i * 12;
            let short = tag == COMPRESSION;
            self.put16(entry, tag);
            self.put16(entry + 2, if short { SHORT } else { LONG });
            self.put32(entry + 4, 1);
            if short { self.put16(entry + 8, value as u16) } else { self.put32(entry + 8, value) }
        }
        self.bytes.extend_from_slice(jpeg);
        self.put32(next, at as u32);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A block with orientation 6, a position, a size and a thumbnail of eight bytes, in either byte order.
    fn sample(little: bool) -> Vec<u8> {
        let mut block = Block { bytes: vec![0; 240], little };
        block.bytes[..4].copy_from_slice(if little { b"II*\0" } else { b"MM\0*" });
        block.put32(4, 8);
        let mut put = |at: usize, tag: u16, kind: u16, count: u32, value: u32| {
            block.put16(at, tag);
            block.put16(at + 2, kind);
            block.put32(at + 4, count);
            if kind == SHORT { block.put16(at + 8, value as u16) } else { block.put32(at + 8, value) }
        };
        put(10, ORIENTATION, SHORT, 1, 6);
        put(22, EXIF_IFD, LONG, 1, 60);
        put(34, GPS_IFD, LONG, 1, 100);
        put(62, PIXEL_X, LONG, 1, 4000);
        put(102, 2, 5, 3, 130);
        put(182, THUMBNAIL_AT, LONG, 1, 232);
        put(194, THUMBNAIL_LEN, LONG, 1, 8);
        for (ifd, count) in [(8, 3), (60, 1), (100, 1), (180, 2)] {
            block.put16(ifd, count);
        }
        block.put32(46, 180);
        block.bytes[130..154].fill(0x77);
        block.bytes[232..].copy_from_slice(b"THUMBJPG");
        block.bytes
    }

    fn read(bytes: &[u8], tag: exif::Tag) -> Option<u32> {
        let exif = exif::Reader::new().read_raw(bytes.to_vec()).unwrap();
        exif.get_field(tag, exif::In::PRIMARY).and_then(|f| f.value.get_uint(0))
    }

    #[test]
    fn orientation_size_position_and_thumbnail_are_edited_in_both_byte_orders() {
        for little in [true, false] {
            let edit = Edit { size: [800, 600], strip_gps: true, thumbnail: Some(b"NEWJPEG") };
            let out = edited(&sample(little), &edit).unwrap();
            assert_eq!(read(&out, exif::Tag::Orientation), Some(1));
            assert_eq!(read(&out, exif::Tag::PixelXDimension), Some(800));
            let has = |bytes: &[u8]| out.windows(bytes.len()).any(|w| w == bytes);
            assert!(!has(b"THUMBJPG") && !has(&[0x77; 4]) && has(b"NEWJPEG"));
            let parsed = exif::Reader::new().read_raw(out.clone()).unwrap();
            assert!(parsed.get_field(exif::Tag::GPSLatitude, exif::In::PRIMARY).is_none());
            assert_eq!(parsed.fields().filter(|f| f.ifd_num == exif::In::THUMBNAIL).count(), 3);
        }
    }

    #[test]
    fn the_position_stays_where_it_is_not_asked_to_go() {
        let edit = Edit { size: [8, 6], strip_gps: false, thumbnail: None };
        let out = edited(&sample(true), &edit).unwrap();
        let parsed = exif::Reader::new().read_raw(out).unwrap();
        assert!(parsed.get_field(exif::Tag::GPSLatitude, exif::In::PRIMARY).is_some());
    }

    #[test]
    fn broken_blocks_are_refused_or_survived_at_every_length() {
        let edit = Edit { size: [8, 6], strip_gps: true, thumbnail: Some(b"T") };
        let whole = sample(true);
        for len in 0..whole.len() {
            let _ = edited(&whole[..len], &edit);
        }
        for at in 0..whole.len() {
            let mut bad = whole.clone();
            bad[at] = 0xff;
            let _ = edited(&bad, &edit);
            let _ = fields(&bad);
        }
        assert!(edited(b"garbage", &edit).is_none());
    }
}
