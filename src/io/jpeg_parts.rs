//! The marker segments of a JPEG, and where the picture ends: what phones hide in and behind it.

/// A marker segment before the picture's data: the marker's second byte and its content.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Segment<'a> {
    pub(crate) marker: u8,
    pub(crate) data: &'a [u8],
}

/// A JPEG, taken apart.
#[derive(Debug)]
pub(crate) struct JpegParts<'a> {
    pub(crate) segments: Vec<Segment<'a>>,
    /// Bytes of entropy-coded data that follow the first start of a scan.
    first_scan_bytes: usize,
    /// Just behind the end-of-image marker; none if the file is cut off before it.
    pub(crate) end: Option<usize>,
}

const START_OF_IMAGE: u8 = 0xd8;
const END_OF_IMAGE: u8 = 0xd9;
const APP1: u8 = 0xe1;
const PROGRESSIVE_FRAME: u8 = 0xc2;
const START_OF_SCAN: u8 = 0xda;
const EXIF: &[u8] = b"Exif\0\0";
const XMP: &[u8] = b"http://ns.adobe.com/xap/1.0/\0";
const EXTENDED_XMP: &[u8] = b"http://ns.adobe.com/xmp/extension/\0";

/// Takes a JPEG apart; stops, without `end`, where it is cut off.
pub(crate) fn parse(jpeg: &[u8]) -> JpegParts<'_> {
    let mut parts = JpegParts { segments: Vec::new(), first_scan_bytes: 0, end: None };
    let (mut at, mut first_scan) = (0, None);
    while let Some(marker) = next_marker(jpeg, &mut at) {
        if let Some(start) = first_scan.filter(|_| parts.first_scan_bytes == 0 && !matches!(marker, 0xd0..=0xd7)) {
            parts.first_scan_bytes = at - 2 - start;
        }
        match marker {
            START_OF_IMAGE | 0x01 | 0xd0..=0xd7 => continue,
            END_OF_IMAGE => {
                parts.end = Some(at);
                break;
            }
            _ => {}
        }
        let Some(length) = jpeg.get(at..at + 2).map(|b| usize::from(u16::from_be_bytes([b[0], b[1]]))) else { break };
        let Some(data) = length.checked_sub(2).and_then(|len| jpeg.get(at + 2..at + 2 + len)) else { break };
        parts.segments.push(Segment { marker, data });
        at += length;
        if marker == START_OF_SCAN {
            first_scan.get_or_insert(at);
        }
    }
    parts
}

/// Finds the next marker from `at` on, skipping entropy-coded data, and moves `at` behind it.
fn next_marker(jpeg: &[u8], at: &mut usize) -> Option<u8> {
    loop {
        let skip = jpeg.get(*at..)?.iter().position(|&byte| byte == 0xff)?;
        *at += skip + 1;
        match jpeg.get(*at)? {
            0x00 => *at += 1,
            0xff => {}
            &marker => {
                *at += 1;
                return Some(marker);
            }
        }
    }
}

/// The components of a scan, and the coefficients (one bit each) whose last bit it brings.
fn last_bits(scan: &Segment) -> Option<(Vec<u8>, u64)> {
    let count = usize::from(*scan.data.first()?);
    let components = scan.data.get(1..1 + 2 * count)?.chunks_exact(2).map(|component| component[0]).collect();
    let &[first, last, bits] = scan.data.get(1 + 2 * count..)?.first_chunk()?;
    let brings = |at: u8| if first <= at && at <= last && bits & 15 == 0 { 1 << at } else { 0 };
    Some((components, (0..64).map(brings).fold(0, |all, one: u64| all | one)))
}

/// The header of a frame: size in pixels, and each component's name and sampling factors (ITU-T T.81, B.2.2).
struct Frame {
    size: [u64; 2],
    components: Vec<(u8, [u64; 2])>,
}

impl Frame {
    fn read(segment: &Segment) -> Option<Self> {
        let number = |at: usize| Some(u64::from(u16::from_be_bytes(*segment.data.get(at..)?.first_chunk()?)));
        let factors = |component: &[u8]| (component[0], [component[1] >> 4, component[1] & 15].map(u64::from));
        let components = segment.data.get(6..)?.chunks_exact(3).map(factors).collect();
        Some(Self { size: [number(3)?, number(1)?], components })
    }

    /// Blocks of a component of these factors in a scan of its own; of factors 1, the units of a common scan (T.81, A.2).
    fn blocks(&self, [across, down]: [u64; 2]) -> u64 {
        let most = |axis: usize| self.components.iter().map(|(_, by)| by[axis]).max().unwrap_or(1).max(1);
        (self.size[0] * across).div_ceil(8 * most(0)) * (self.size[1] * down).div_ceil(8 * most(1))
    }
}

impl<'a> JpegParts<'a> {
    fn with_head(&self, marker: u8, head: &'static [u8]) -> impl Iterator<Item = &'a [u8]> + use<'a, '_> {
        self.segments.iter().filter(move |s| s.marker == marker).filter_map(move |s| s.data.strip_prefix(head))
    }

    /// Whether the picture comes in passes, each of which makes the last one finer.
    pub(crate) fn is_progressive(&self) -> bool {
        self.segments.iter().any(|segment| segment.marker == PROGRESSIVE_FRAME)
    }

    fn progressive_frame(&self) -> Option<Frame> {
        Frame::read(self.segments.iter().find(|segment| segment.marker == PROGRESSIVE_FRAME)?)
    }

    /// Numbers that are held until the last pass of a progressive picture is read.
    pub(crate) fn held_numbers(&self) -> Option<u64> {
        let frame = self.progressive_frame()?;
        Some(64 * frame.blocks([1, 1]) * frame.components.iter().map(|(_, [across, down])| across * down).sum::<u64>())
    }

    /// Whether the passes of a progressive picture are all there: for each component the last bit of its means and of all
    /// its other coefficients (ITU-T T.81, G.1.1).
    pub(crate) fn has_all_passes(&self) -> bool {
        let Some(frame) = self.progressive_frame() else { return false };
        let scans = self.segments.iter().filter(|segment| segment.marker == START_OF_SCAN).filter_map(last_bits);
        let mut done: Vec<(u8, u64)> = frame.components.iter().map(|&(component, _)| (component, 0)).collect();
        for (of, coefficients) in scans {
            for (component, done) in &mut done {
                *done |= if of.contains(component) { coefficients } else { 0 };
            }
        }
        let is_full = !done.is_empty() && done.iter().all(|(_, done)| *done == u64::MAX);
        // The first pass has a code of at least one bit for each block.
        is_full && self.first_pass_blocks(&frame).is_none_or(|blocks| blocks <= 8 * self.first_scan_bytes as u64)
    }

    /// Blocks of 8×8 numbers in the first scan, by the size in the header.
    fn first_pass_blocks(&self, frame: &Frame) -> Option<u64> {
        let (of, _) = last_bits(self.segments.iter().find(|segment| segment.marker == START_OF_SCAN)?)?;
        let scanned = || frame.components.iter().filter(|(name, _)| of.contains(name)).map(|&(_, by)| by);
        Some(match (scanned().next(), scanned().count()) {
            (Some(by), 1) => frame.blocks(by),
            _ => frame.blocks([1, 1]) * scanned().map(|[across, down]| across * down).sum::<u64>(),
        })
    }

    /// The EXIF block, a TIFF structure.
    pub(crate) fn exif(&self) -> Option<&'a [u8]> {
        self.with_head(APP1, EXIF).next()
    }

    /// The main XMP packet.
    pub(crate) fn xmp(&self) -> Option<&'a [u8]> {
        self.with_head(APP1, XMP).next()
    }

    /// The extended XMP packet with a GUID, put together from its chunks (XMP specification, part 3, 1.1.3.1).
    pub(crate) fn extended_xmp(&self, guid: &str) -> Result<Vec<u8>, String> {
        let mut whole: Vec<u8> = Vec::new();
        let mut filled = 0usize;
        for chunk in self.with_head(APP1, EXTENDED_XMP) {
            let Some((head, data)) = chunk.split_at_checked(40) else { return Err("an XMP chunk is too short".into()) };
            if !head[..32].eq_ignore_ascii_case(guid.as_bytes()) {
                continue;
            }
            let number = |at: usize| u32::from_be_bytes([head[at], head[at + 1], head[at + 2], head[at + 3]]) as usize;
            let (total, offset) = (number(32), number(36));
            if whole.is_empty() {
                // The chunks must be in this file, so their sum bounds what is allocated.
                if total > self.segments.len().saturating_mul(65_536) {
                    return Err(format!("extended XMP says {total} bytes, more than the file holds"));
                }
                whole = vec![0; total];
            }
            let place = offset.checked_add(data.len()).and_then(|end| whole.get_mut(offset..end));
            place.ok_or("an XMP chunk lies outside its packet")?.copy_from_slice(data);
            filled += data.len();
        }
        if filled == 0 || filled < whole.len() {
            Err("parts of the extended XMP are missing".into())
        } else {
            Ok(whole)
        }
    }
}
